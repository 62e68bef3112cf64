//! Contact of bodies on a mount.

use std::f64::consts::PI;

use nervure_fluid::{
    Body, BodyLaw, Contact, Extent, Flexible, Fluid, Motion, Mount, Outline, Parameters, Pose, Skin, Solvable, Support,
};
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

/// Until its release nothing slows the body that pushes the other one; then the other one does.
#[test]
fn a_body_pushes_another_one_by_its_law_until_it_is_released() {
    let law = r#""motion": { "x": { "table": { "times": [0, 1], "values": [0, 0.5], "end_slopes": [0.5, 0.5] } } }"#;
    let circle = r#""circle": { "radius": 0.2 }"#;
    let led = body(circle, "0.5, 1", 0.25).replace(r#""mount": {"#, &format!(r#"{law}, "mount": {{ "release": 0.3, "#));
    let other = body(circle, "1.1, 1", 0.5).replace("0, -1", "0, 0");
    let mut fluid = fluid_of::<2>(scene(&[led, other], r#""contact": {},"#, ""));
    run(&mut fluid, 15, |fluid| {
        let (t, pose) = (fluid.time(), fluid.pose(0));
        assert!((pose.position[0] - 0.5 - 0.5 * t).abs() < 1e-9 && pose.position[1] == 1.0, "{pose:?} at {t}");
    });
    let [pushed, gap] = [fluid.pose(1).velocity[0], fluid.pose(1).position[0] - fluid.pose(0).position[0] - 0.4];
    assert!(pushed > 0.3 && gap > 0.0, "it pushes by {pushed} m/s at a gap of {gap} m");
    run(&mut fluid, 10, |_| ());
    let Pose { position, velocity, .. } = fluid.pose(0);
    assert!(velocity[0] < 0.45 && position[1] < 0.998, "it is free: {position} with {velocity}");
}

/// The fine box repeats what is in it after its own length; contact must not.
#[test]
fn contact_in_a_fine_box_knows_walls_and_obstacles_where_they_are() {
    let fine = r#""fine_box": { "x": [0.2, 1.8], "y": [0.6, 2.2] },"#;
    let obstacle = r#"{ "shape": { "circle": { "radius": 0.2 } }, "position": [1, 0.2] }"#;
    let contact = format!(r#""contact": {{ "obstacles": [{obstacle}] }},"#);
    let [free, known] = ["", &contact].map(|contact| {
        let small = body(r#""circle": { "radius": 0.1 }"#, "1, 1.4", 0.1);
        let mut fluid = fluid_of::<2>(scene(&[small], contact, fine));
        run(&mut fluid, 5, |_| ());
        fluid.pose(0).position
    });
    assert!(free == known && free[1] < 1.4, "{free} without contact, {known} with one that is far");
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
    let endless = r#""circular_cylinder": { "axis": "x", "radius": 0.2 }"#;
    let ellipse = body(r#""ellipse": { "length": 0.4, "thickness": 0.3 }"#, "1, 1", 1.0).replace(", 0]", "]");
    for (bodies, sentence) in [
        (vec![at(endless, "1"), at(cuboid, "1.5")], "contact of a `circular_cylinder` without ends with a wall"),
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
    let skin = |mass: f64| Skin { radius: vec![0.02; 9], largest_stiffness: mass * (PI / (10.0 * STEP)).powi(2), mass };
    parameters.flexible = heights.map(line).into();
    parameters.contact = contact.map(|stiffness| Contact {
        law: BodyLaw { range: 0.2, stiffness, damping: 0.0, friction: 0.0, film: None, dt: STEP },
        obstacles: vec![],
        walls: [None; 2],
        periods: [2.0, 3.0],
        flexible_stiffness: stiffness,
        skins: [MASS, ratio * MASS].map(|mass| Some(skin(mass))).into(),
        carrier: None,
    });
    parameters
}

/// Let each flexible body of these masses move along the last axis as a whole from its height with its speed under the loads
/// that the fluid announces and `outer` ones, of its number, height and speed, as one of another maker, for 300 steps; `see` sees the heights after each. Return the kinetic
/// energy at the end by that at the start.
fn move_whole<const D: usize, const N: usize>(
    parameters: &Parameters<D>,
    masses: [f64; N],
    outer: impl Fn(usize, f64, f64) -> f64,
    [mut y, mut v]: [[f64; N]; 2],
    mut see: impl FnMut(&Fluid<D>, [f64; N]),
) -> f64
where
    [f64; D]: Solvable<D>,
{
    let (h, axis, mut given) = (STEP, D - 1, [0.0; N]);
    let energy = |v: [f64; N]| masses.iter().zip(v).map(|(mass, v)| mass * v * v).sum::<f64>();
    let mut fluid = Fluid::new(parameters).unwrap_or_else(|e| panic!("{e}"));
    let start = energy(v);
    for _ in 0..300 {
        for k in 0..N {
            let loads = &fluid.loads()[k];
            let [force, rate] = [&loads.force[axis], &loads.impedance].map(|of| of.iter().sum::<f64>());
            let change = (force + outer(k, y[k], v[k])) / (masses[k] / h + rate);
            v[k] += change;
            y[k] += h * v[k];
            given[k] += h * (force - rate * change) * v[k];
            let to = &mut fluid.stations_mut()[k];
            to.position[axis].fill(y[k]);
            to.velocity[axis].fill(v[k]);
        }
        let t = fluid.time();
        fluid.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
        see(&fluid, y);
    }
    // Bodies in one another feel another load than that announced.
    for (given, exchange) in given.iter().zip(fluid.exchange()).filter(|_| parameters.contact.is_some()) {
        let off = (given - exchange.work).abs();
        assert!(off < 0.02 * start || start == 0.0, "a work of {given} J, but {} J from the fluid", exchange.work);
    }
    energy(v) / start.max(f64::MIN_POSITIVE)
}

/// Return the least distance of two lines, and the energy at the end by that at the start.
fn lines_that_meet(contact: Option<f64>, ratio: f64) -> [f64; 2] {
    let (masses, mut least) = ([0.8 * MASS, 0.8 * ratio * MASS], f64::INFINITY);
    let parameters = two_lines([0.3, -0.3], contact, ratio, STEP);
    let start = [[0.3, -0.3], [-1.0, 0.0]];
    let energy = move_whole(&parameters, masses, |_, _, _| 0.0, start, |_, y| least = least.min(y[0] - y[1]));
    [least, energy]
}

/// Two rods cross, supported so that the middle of each yields by u under K u; a load P on the upper one, which touches the
/// lower one from the start, is carried by both: P/2 each, less what the contact yields.
#[test]
fn two_rods_that_cross_carry_a_load_by_halves() {
    let line = |z: f64, along: usize| {
        let node = |k: i32| {
            std::array::from_fn(|d| {
                if d == 2 {
                    z
                } else if d == along {
                    0.1 * f64::from(k) - 0.4
                } else {
                    0.02
                }
            })
        };
        Flexible {
            name: "a line".into(),
            nodes: (0..9).map(node).collect(),
            extent: Extent::Line { free: [true; 2] },
            pivot: None,
        }
    };
    let (range, radius, load, spring) = (0.05, 0.05, 4.0, 20.0);
    let mut parameters = Parameters::<3>::new([[-0.8, 0.8]; 3], [16; 3], 1e-2, 1e-3, STEP);
    let height = 0.5 * (range + 2.0 * radius);
    parameters.flexible = vec![line(height, 0), line(-height, 1)];
    let largest_stiffness = MASS * (PI / (10.0 * STEP)).powi(2);
    let skin = || Some(Skin { radius: vec![radius; 9], largest_stiffness, mass: MASS });
    parameters.contact = Some(Contact {
        law: BodyLaw { range, stiffness: f64::INFINITY, damping: 0.0, friction: 0.0, film: None, dt: STEP },
        obstacles: vec![],
        walls: [None; 3],
        periods: [1.6; 3],
        flexible_stiffness: f64::INFINITY,
        skins: vec![skin(), skin()],
        carrier: None,
    });
    let start = [height, -height];
    let outer = |k: usize, z: f64, v: f64| [-load, 0.0][k] - spring * (z - start[k]) - 3.0 * v;
    let mut end = start;
    move_whole(&parameters, [0.1; 2], outer, [start, [0.0; 2]], |_, z| end = z);
    let [upper, lower] = [0, 1].map(|k| spring * (start[k] - end[k]));
    let yields = spring * (2.0 * height - end[0] + end[1]);
    println!("the rods carry {upper} and {lower} N, and the contact yields by {yields} N");
    assert!((upper + lower - load).abs() < 1e-2 * load, "{upper} and {lower} N of {load} N");
    assert!((lower / (0.5 * (load - yields)) - 1.0).abs() < 0.01 && lower > 0.4 * load, "{lower} N of {load} N");
}

/// A square of a side of 0.6 m as 72 triangles at a height, m.
fn plate(z: f64) -> Flexible<3> {
    let node = |k: usize| [0.1 * (k % 7) as f64 - 0.3, 0.1 * (k / 7) as f64 - 0.3, z];
    let cells = (0..36).map(|k| k / 6 * 7 + k % 6);
    let triangles = cells.flat_map(|k| [[k, k + 1, k + 8], [k, k + 8, k + 7]]).collect();
    let extent = Extent::Surface(triangles);
    Flexible { name: "a plate".into(), nodes: (0..49).map(node).collect(), extent, pivot: None }
}

/// Two plates in space, and a plate and a line across it.
#[test]
fn the_fluid_keeps_wings_of_two_units_and_a_rod_apart() {
    let line = Flexible {
        name: "a line".into(),
        nodes: (0..9).map(|k| [0.02, 0.1 * f64::from(k) - 0.4, -0.3]).collect(),
        extent: Extent::Line { free: [true; 2] },
        pivot: None,
    };
    for (second, length, has_contact) in [(plate(-0.3), 0.36, true), (line, 0.8, true), (plate(-0.3), 0.36, false)] {
        let domain = [[-0.8, 0.8], [-0.8, 0.8], [-1.6, 1.6]];
        let mut parameters = Parameters::<3>::new(domain, [16, 16, 32], 1e-2, 1e-3, STEP);
        parameters.max_cfl = 0.8;
        let range = 0.2;
        let largest_stiffness = MASS * (PI / (10.0 * STEP)).powi(2);
        let radius = |body: &Flexible<3>| match body.extent {
            Extent::Surface(_) => Skin::of_surface(range),
            _ => 0.02,
        };
        parameters.flexible = vec![plate(0.3), second];
        let skins = parameters
            .flexible
            .iter()
            .map(|body| Some(Skin { radius: vec![radius(body); body.nodes.len()], largest_stiffness, mass: MASS }));
        let skins = skins.collect();
        parameters.contact = has_contact.then_some(Contact {
            law: BodyLaw { range, stiffness: f64::INFINITY, damping: 0.0, friction: 0.0, film: None, dt: STEP },
            obstacles: vec![],
            walls: [None; 3],
            periods: [1.6, 1.6, 3.2],
            flexible_stiffness: f64::INFINITY,
            skins,
            carrier: None,
        });
        let (masses, mut least) = ([0.36 * MASS, length * MASS], f64::INFINITY);
        let start = [[0.3, -0.3], [-1.0, 0.0]];
        let energy = move_whole(&parameters, masses, |_, _, _| 0.0, start, |_, z| least = least.min(z[0] - z[1]));
        println!("a distance of {least} m, {energy} of the energy at the start");
        assert!((least > 0.03) == has_contact, "a distance of {least} m");
        assert!(energy < 1.0, "{energy} of the energy at the start");
    }
}

/// A circle and a line of different masses: the line hits the circle on its mount, or falls through it without contact.
#[test]
fn the_fluid_keeps_a_rod_and_a_body_on_a_mount_apart() {
    for (ratio, has_contact) in [(0.2, true), (1.0, true), (20.0, true), (1.0, false)] {
        let mut parameters = two_lines([0.5, -1.2], Some(f64::INFINITY), 1.0, STEP);
        let mass = ratio * 0.8 * MASS;
        let free = Some(Support { stiffness: 0.0, damping: 0.0, rest: 0.0 });
        let mount =
            Mount { mass, inertia: 0.05 * mass, supports: [free, free, free, None, None, None], gravity: [0.0; 2] };
        parameters.bodies = vec![Body {
            motion: Some(Motion::Mount(mount)),
            ..Body::still("a body", Outline::Circle(0.25), [0.03, 0.0])
        }];
        if !has_contact {
            parameters.contact = None;
        }
        let (masses, mut least, mut speed, mut pushed) = ([0.8 * MASS; 2], f64::INFINITY, 0.0, 0.0_f64);
        let start = [[0.5, -1.2], [-1.0, 0.0]];
        let energy = move_whole(
            &parameters,
            masses,
            |_, _, _| 0.0,
            start,
            |fluid, y| {
                let pose = fluid.pose(0);
                least = least.min(y[0] - 0.02 - pose.position[1] - 0.25);
                speed = pose.velocity[1];
                pushed = pushed.min(speed);
            },
        );
        let all = energy + ratio * speed * speed;
        println!("mass ratio {ratio}: a gap of {least} m, speed {pushed} m/s, {all} of the energy at the start");
        assert!((least > -0.01) == has_contact, "mass ratio {ratio}: a gap of {least} m");
        assert!(all < 1.0 && (pushed < -0.05 || !has_contact), "{all} of the energy at the start, {pushed} m/s");
    }
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

/// The upper line moves along the lower one: friction is μ N against the slip on both, and announces no rate.
#[test]
fn lines_that_slide_rub_with_the_friction_of_their_law() {
    let (friction, gap, stiffness) = (0.3, 0.12, 1e3);
    let [(upper, lower, rate), (upper_alone, lower_alone, rate_alone)] = [friction, 0.0].map(|friction| {
        let mut parameters = two_lines([0.08, -0.08], Some(stiffness), 1.0, STEP);
        parameters.contact.as_mut().expect("it has contact").law.friction = friction;
        let mut fluid = Fluid::new(&parameters).unwrap_or_else(|e| panic!("{e}"));
        let upper = &mut fluid.stations_mut()[0];
        upper.velocity[0].fill(1.0);
        upper.position[0].iter_mut().for_each(|x| *x += STEP);
        fluid.advance(0.0, STEP).unwrap_or_else(|e| panic!("{e}"));
        let [one, other] = [0, 1].map(|k| fluid.loads()[k].force[0].iter().sum::<f64>());
        (one, other, fluid.loads()[0].impedance.clone())
    });
    let [on_upper, on_lower] = [upper - upper_alone, lower - lower_alone];
    let normal = 0.8 * stiffness * (0.2 - gap) * (0.2 - gap) / (2.0 * 0.2);
    assert!((on_upper / (-friction * normal) - 1.0).abs() < 0.05, "{on_upper} N on the upper line of {normal} N");
    assert!((on_upper + on_lower).abs() < 1e-9 * normal && rate == rate_alone, "{on_upper} and {on_lower} N");
}
