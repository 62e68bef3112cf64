//! Contact of bodies on a mount.

use std::f64::consts::PI;

use nervure_fluid::{Fluid, Parameters, Solvable};
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
