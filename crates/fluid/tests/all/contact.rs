//! Contact of bodies on a mount.

use std::f64::consts::PI;

use nervure_fluid::{BodyLaw, Contact, Extent, Flexible, Fluid, Parameters, Skin, Solvable};
use scene::Scene;

/// A scene of bodies in a closed box of fluid with cells of 0.1 m.
fn scene(bodies: &[String], contact: &str, extra: &str) -> Result<Scene, String> {
    let is_space = bodies.iter().any(|own| own.contains("sphere") || own.contains("cuboid"));
    let z = |on: &'static str| if is_space { on } else { "" };
    let text = format!(
        r#"{{ "name": "contact", "time": {{ "end": 1.0, "communication_step": 0.02 }}, {contact} "fluid": {{
            "density": 1.0, "kinematic_viscosity": 0.02,
            "box": {{ "x": [-0.2, 2.2], "y": [-0.2, 3.0] {}, "cells": [24, 32 {}] }},
            "channel": {{ "x": [0, 2], "y": [0, 2.8] }}, "bodies": [{}], {extra}
            "mask": {{ "log_linear": {{ "c_eta": 1e-4 }} }},
            "time_stepping": {{ "max_step": 0.02, "max_cfl": 0.4 }} }} }}"#,
        z(r#", "z": [-0.8, 0.8]"#),
        z(", 16"),
        bodies.join(", ")
    );
    Scene::from_json(&text).map_err(|error| error.to_string())
}

fn body(shape: &str, position: &str, mass: f64) -> String {
    let (gravity, about) = if shape.contains("circle") || shape.contains("rectangle") {
        ("0, -1", r#""angle": {}"#)
    } else {
        ("0, -1, 0", r#""z": {}, "angle_x": {}, "angle_y": {}, "angle_z": {}"#)
    };
    let inertia = 0.1 * mass;
    format!(
        r#"{{ "shape": {{ {shape} }}, "position": [{position}], "mount": {{ "mass": {mass}, "inertia": {inertia},
        "gravity": [{gravity}], "x": {{}}, "y": {{}}, {about} }} }}"#
    )
}

const CIRCLE: &str = r#""circle": { "radius": 0.4 }"#;
const BLOCK: &str = r#""rectangle": { "length": 1.2, "thickness": 0.4 }"#;

fn fluid_of<const D: usize>(scene: Result<Scene, String>) -> Fluid<D>
where
    [f64; D]: Solvable<D>,
    Parameters<D>: for<'a> TryFrom<&'a Scene, Error = nervure_fluid::Error>,
{
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    let parameters = Parameters::<D>::try_from(&scene).unwrap_or_else(|e| panic!("{e}"));
    Fluid::new(&parameters).unwrap_or_else(|e| panic!("{e}"))
}

fn run<const D: usize>(fluid: &mut Fluid<D>, steps: usize, mut see: impl FnMut(&Fluid<D>))
where
    [f64; D]: Solvable<D>,
{
    for _ in 0..steps {
        let t = fluid.time();
        fluid.advance(t, 0.02).unwrap_or_else(|e| panic!("{e}"));
        see(fluid);
    }
}

/// The penalty k (h − g)²/(2 h), of which a contact takes ten steps, balances the weight less that of the fluid.
#[test]
fn a_body_that_falls_comes_to_rest_on_the_floor() {
    let (mass, displaced) = (2.0 * 0.16 * PI, 0.16 * PI);
    let mut fluid = fluid_of::<2>(scene(&[body(CIRCLE, "1, 0.7", mass)], r#""contact": { "damping": 1 },"#, ""));
    run(&mut fluid, 600, |_| ());
    let (gap, stiffness) = (fluid.pose(0).position[1] - 0.4, mass * (PI / 0.2).powi(2));
    let exact = 0.2 - (2.0 * 0.2 * (mass - displaced) / stiffness).sqrt();
    assert!((gap - exact).abs() < 2e-3 && fluid.pose(0).velocity.norm() < 1e-2, "a gap of {gap} against {exact} m");
}

#[test]
fn bodies_lie_on_each_other_and_on_an_obstacle() {
    let bodies = [body(BLOCK, "1, 0.6", 1.0), body(CIRCLE, "1.02, 1.5", 1.0)];
    let contact = r#""contact": { "friction": 0.5, "damping": 2, "obstacles": [{ "shape": { "circle": { "radius": 0.2 } },
        "position": [1, -0.1] }] },"#;
    let mut fluid = fluid_of::<2>(scene(&bodies, contact, ""));
    let mut least = f64::INFINITY;
    run(&mut fluid, 300, |fluid| {
        let [low, high] = [0, 1].map(|k| fluid.pose(k).position[1]);
        least = least.min(low - 0.2 - 0.1).min(high - low - 0.4 - 0.2);
    });
    assert!(least > 0.0, "a gap of {least} m");
}

#[test]
fn a_sphere_in_space_stays_above_the_floor_and_a_law_driven_ram() {
    let sphere = body(r#""sphere": { "radius": 0.4 }"#, "1, 0.8, 0.1", 0.6);
    let ram = r#"{ "shape": { "cuboid": { "lengths": [0.4, 0.8, 0.8] } }, "position": [0.2, 0.6, 0],
        "motion": { "x": { "cosine_ramp": { "value": 0.4, "duration": 1.0 } } } }"#;
    let mut fluid = fluid_of::<3>(scene(&[sphere, ram.into()], r#""contact": {},"#, ""));
    let mut least = f64::INFINITY;
    run(&mut fluid, 60, |fluid| {
        let place = fluid.pose(0).position;
        least = least.min(place[1] - 0.4).min(place[0] - 0.4 - (fluid.pose(1).position[0] + 0.2));
    });
    assert!(least > 0.0 && fluid.pose(0).position[0] > 1.1, "a gap of {least} m at {}", fluid.pose(0).position);
}

#[test]
fn a_step_that_would_press_bodies_into_each_other_is_refused_by_name() {
    let bodies = [body(CIRCLE, "1, 1", 1.0), body(CIRCLE, "1.1, 1.3", 1.0)];
    let mut fluid = fluid_of::<2>(scene(&bodies, r#""contact": {},"#, ""));
    let error = fluid.advance(0.0, 0.02).unwrap_err().to_string();
    assert!(error.contains("body 1 and body 2 are deeper in each other"), "{error}");
}

#[test]
fn shapes_that_cannot_touch_are_refused_in_words() {
    let at = |shape: &str, x: &str| body(shape, &format!("{x}, 1, 0"), 1.0);
    let cuboid = r#""cuboid": { "lengths": [0.4, 0.4, 0.4] }"#;
    let ellipse = body(r#""ellipse": { "length": 0.4, "thickness": 0.3 }"#, "1, 1", 1.0).replace(", 0]", "]");
    for (bodies, sentence) in [
        (vec![at(cuboid, "0.5"), at(cuboid, "1.5")], "contact is not known with the cuboid of `fluid.bodies[1]`"),
        (
            vec![at(r#""circular_cylinder": { "axis": "x", "radius": 0.2, "length": 0.5 }"#, "1"), at(cuboid, "1.5")],
            "contact of a `circular_cylinder` with a wall",
        ),
        (vec![ellipse], "what touches is a circle, rectangle"),
    ] {
        let refused = scene(&bodies, r#""contact": {},"#, "").expect_err("it is refused");
        assert!(refused.contains(sentence), "{refused}");
    }
}

const STEP: f64 = 5e-3;
const MASS: f64 = 2.0;

/// Two lines of a light and a heavy rod at these heights (m), with contact of a stiffness if it is given.
fn two_lines(heights: [f64; 2], contact: Option<f64>, ratio: f64, communication_step: f64) -> Parameters {
    let mut parameters = Parameters::new([[-1.0, 1.0], [-1.5, 1.5]], [20, 30], 1e-2, 1e-3, communication_step);
    let line = |y: f64| Flexible {
        name: "a line".into(),
        nodes: (0..9).map(|k| [0.1 * f64::from(k) - 0.4, y]).collect(),
        extent: Extent::Line { free: [true; 2] },
        pivot: None,
    };
    let skin = |mass: f64| Skin { radius: vec![0.02; 9], largest_stiffness: mass * (PI / (10.0 * STEP)).powi(2) };
    parameters.flexible = heights.map(line).into();
    parameters.contact = contact.map(|stiffness| Contact {
        law: BodyLaw { range: 0.2, stiffness, damping: 0.0, friction: 0.0, film: None, dt: STEP },
        obstacles: vec![],
        walls: [None; 2],
        rod_stiffness: stiffness,
        skins: [MASS, ratio * MASS].map(|mass| Some(skin(mass))).into(),
    });
    parameters
}

/// Let each of two lines move along y as a whole under the loads that the fluid announces, like a rod of another maker:
/// return the least distance, and the energy at the end by that at the start.
fn lines_that_meet(contact: Option<f64>, ratio: f64) -> [f64; 2] {
    let (h, mass) = (STEP, MASS);
    let parameters = two_lines([0.3, -0.3], contact, ratio, h);
    let mut fluid = Fluid::new(&parameters).unwrap_or_else(|e| panic!("{e}"));
    let mut given = [0.0; 2];
    let (mut y, mut v, masses, mut least) = ([0.3, -0.3], [-1.0, 0.0], [0.8 * mass, 0.8 * ratio * mass], f64::INFINITY);
    for _ in 0..300 {
        for k in 0..2 {
            let loads = &fluid.loads()[k];
            let [force, rate] = [&loads.force[1], &loads.impedance].map(|of| of.iter().sum::<f64>());
            let change = force / (masses[k] / h + rate);
            v[k] += change;
            y[k] += h * v[k];
            given[k] += h * (force - rate * change) * v[k];
            let to = &mut fluid.stations_mut()[k];
            to.position[1].fill(y[k]);
            to.velocity[1].fill(v[k]);
        }
        let t = fluid.time();
        fluid.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
        least = least.min(y[0] - y[1]);
    }
    for (given, exchange) in given.iter().zip(fluid.exchange()) {
        let off = (given - exchange.work).abs();
        assert!(off < 0.02 * masses[0], "a work of {given} J, but {} J from the fluid", exchange.work);
    }
    let energy = |v: [f64; 2]| (masses[0] * v[0] * v[0] + masses[1] * v[1] * v[1]) / masses[0];
    [least, energy(v)]
}

/// Its impedance grows with this step.
#[test]
fn the_contact_of_lines_is_that_of_a_coming_step_as_long_as_the_last() {
    let [one, other] = [STEP, 2.0 * STEP].map(|communication_step| {
        let mut fluid = Fluid::new(&two_lines([0.08, -0.08], Some(1e3), 1.0, communication_step)).expect("it is right");
        fluid.advance(0.0, STEP).unwrap_or_else(|e| panic!("{e}"));
        fluid.loads()[0].impedance.iter().sum::<f64>()
    });
    let mut free = Fluid::new(&two_lines([0.08, -0.08], None, 1.0, STEP)).expect("it is right");
    free.advance(0.0, STEP).unwrap_or_else(|e| panic!("{e}"));
    let without: f64 = free.loads()[0].impedance.iter().sum();
    assert!((one - other).abs() < 1e-9 * one && one > 1.01 * without, "{one}, {other}, {without} kg/s without contact");
}

#[test]
fn the_fluid_keeps_lines_of_two_units_apart() {
    for ratio in [0.1, 1.0, 10.0] {
        for stiffness in [1e3, f64::INFINITY] {
            let [least, energy] = lines_that_meet(Some(stiffness), ratio);
            assert!(least > 0.12 && energy < 1.0, "a distance of {least} m, {energy} of the energy at the start");
        }
        let [least, _] = lines_that_meet(None, ratio);
        assert!(least < 0.1, "without contact they stay {least} m apart");
    }
}
