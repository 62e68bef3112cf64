//! Bodies that the fluid or the master moves.

use std::f64::consts::{PI, TAU};

use nervure_fluid::{Error, Fluid, Pose};
use rustfft::num_complex::Complex64;
use scene::{Precision, Scene};

use crate::common::{fluid_of, run};

/// A body in a box of 8 m of fluid, at rest but for `flow`.
fn scene(body: &str, flow: &str, nu: f64, cells: usize) -> Scene {
    let text = format!(
        r#"{{ "name": "carried", "time": {{ "end": 1.0, "communication_step": 0.02 }}, "fluid": {{
            "density": 1.0, "kinematic_viscosity": {nu}, {flow}
            "box": {{ "x": [-4.0, 4.0], "y": [-4.0, 4.0], "cells": [{cells}, {cells}] }},
            "bodies": [{body}], "mask": {{ "log_linear": {{ "c_eta": 1e-4 }} }},
            "time_stepping": {{ "max_step": 0.1, "max_cfl": 0.4 }} }} }}"#
    );
    Scene::from_json(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// An ellipse that moves in all three directions about a pivot aside, in a stream and in gravity.
fn ellipse(scene_of: impl FnOnce(&mut Scene)) -> Fluid {
    let body = r#"{ "shape": { "ellipse": { "length": 1.2, "thickness": 0.8 } }, "position": [0.02, 0.01],
        "pivot": [-0.2, 0.05], "angle": 0.3, "mount": { "mass": 1.5, "inertia": 0.4, "gravity": [0.2, -0.4],
        "x": { "stiffness": 3.0, "damping": 0.1 }, "y": { "stiffness": 2.0, "damping": 0.2, "rest": 0.05 },
        "angle": { "stiffness": 0.5, "damping": 0.05, "rest": -0.2 } } }"#;
    let mut scene = scene(body, r#""initial_velocity": [0.6, 0.1],"#, 5e-3, 96);
    scene_of(&mut scene);
    fluid_of(&scene)
}

/// Period and damping of a circle on a spring in still fluid are those of Stokes (1851): at the complex rate s the fluid
/// adds `k m_d` to the mass, `k = 1 + 4 K_1(z)/(z K_0(z))` with `z² = R² s/nu`, which is 1 + 4/z + 2/z² for large z.
/// Between its images the added mass of potential flow is larger by `(1 + q)/(1 − q)`, q being the share of the box that
/// the circle fills. The lightest weighs a tenth of the fluid that it displaces.
#[test]
fn a_circle_on_a_spring_has_period_and_damping_of_stokes() {
    let (displaced, nu, h) = (PI / 4.0, 0.01, 0.02);
    let potential = (64.0 + displaced) / (64.0 - displaced);
    for ratio in [2.0, 0.5, 0.1] {
        let mass = ratio * displaced;
        let stiffness = (TAU / 4.0_f64).powi(2) * (mass + displaced);
        let mut rate = Complex64::new(0.0, TAU / 4.0);
        for _ in 0..100 {
            let z = (0.25 * rate / nu).sqrt();
            rate = Complex64::i() * (stiffness / (mass + displaced * (potential + 4.0 / z + 2.0 / (z * z)))).sqrt();
        }
        let (period, expected) = (TAU / rate.im, -rate.re / rate.im);
        let body = format!(
            r#"{{ "shape": {{ "circle": {{ "radius": 0.5 }} }}, "position": [0.02, 0.01],
            "mount": {{ "mass": {mass}, "y": {{ "stiffness": {stiffness}, "rest": -0.05 }} }} }}"#
        );
        let mut fluid = fluid_of(&scene(&body, r#""mean_flow": {},"#, nu, 128));
        let (mut crossings, mut extremes, mut last) = (Vec::new(), Vec::new(), (0.05, 0.0));
        while crossings.len() < 5 {
            run(&mut fluid, 1, h);
            let pose = fluid.pose(0);
            let now = (pose.position[1] + 0.04, pose.velocity[1]);
            if last.0 * now.0 < 0.0 {
                crossings.push(fluid.time() - h * now.0 / (now.0 - last.0));
            }
            if last.1 * now.1 < 0.0 {
                extremes.push(now.0.abs());
            }
            last = now;
        }
        let found = (crossings[4] - crossings[0]) / 2.0;
        let damping = (extremes[0] / extremes[3]).ln() / (3.0 * PI);
        println!("mass ratio {ratio}: period {found:.4} by {period:.4}, damping {damping:.4} by {expected:.4}");
        assert!(extremes.len() == 4 || extremes.len() == 5, "mass ratio {ratio}: it shakes: {extremes:?}");
        assert!((found / period - 1.0).abs() < 0.02, "mass ratio {ratio}: period {found} by {period}");
        assert!((damping / expected - 1.0).abs() < 0.15, "mass ratio {ratio}: damping {damping} by {expected}");
        let pose = fluid.pose(0);
        assert_eq!((pose.position[0], pose.angle, pose.velocity[0], pose.omega), (0.02, 0.0, 0.0, 0.0));
    }
}

/// The reported force and moment are those under which the body moves, with its weight less that of the fluid that it
/// displaces, at the centroid; and the force is what the fluid loses of its momentum with the rate of the momentum of the
/// fluid that the body displaces.
#[test]
fn body_and_fluid_exchange_their_momentum() {
    let h = 0.02;
    let mut fluid = ellipse(|_| ());
    let momentum =
        |fluid: &Fluid| [0, 1].map(|axis| fluid.grid().cell_volume() * fluid.velocity(axis).iter().sum::<f64>());
    let rates = |pose: &Pose| [pose.velocity[0], pose.velocity[1], pose.omega];
    let (mut known, mut angle) = (Vec::new(), 0.0);
    for _ in 0..25 {
        known.push((momentum(&fluid), rates(&fluid.pose(0))));
        angle = fluid.pose(0).angle;
        run(&mut fluid, 1, h);
    }
    let [.., (lost_before, v_before), (lost, v)] = known.as_slice() else { unreachable!() };
    let change = |now: f64, before: f64, earlier: f64| (1.5 * now - 2.0 * before + 0.5 * earlier) / h;
    let (pose, force) = (fluid.pose(0), fluid.force_on_body(0));
    let now = rates(&pose);
    let acceleration = [0, 1, 2].map(|i| change(now[i], v[i], v_before[i]));
    let displaced = [pose.position[0] - 0.02, pose.position[1] - 0.01, pose.angle - 0.3];
    let on_springs = [3.0 * displaced[0], 2.0 * (displaced[1] - 0.05), 0.5 * (displaced[2] + 0.2)];
    let scale = force.force[0].hypot(force.force[1]);
    // The centroid of the displaced fluid.
    let arm_at = |angle: f64| [0.2 * angle.cos() + 0.05 * angle.sin(), 0.2 * angle.sin() - 0.05 * angle.cos()];
    let mass = PI * 0.6 * 0.4;
    // The moment is that where the body was expected.
    let there = arm_at(angle + h * (1.5 * v[2] - 0.5 * v_before[2]));
    let weight = [(1.5 - mass) * 0.2, (1.5 - mass) * -0.4, mass * (0.4 * there[0] + 0.2 * there[1])];
    for i in 0..3 {
        let expected = [1.5, 1.5, 0.4][i] * acceleration[i] + [0.1, 0.2, 0.05][i] * now[i] + on_springs[i];
        let found = [force.force[0], force.force[1], force.moment][i] + weight[i];
        assert!((found - expected).abs() < 1e-9 * scale, "direction {i}: {found} against {expected}");
    }
    // The centripetal force has the velocity that was expected.
    let arm = arm_at(pose.angle);
    let omega = 2.0 * v[2] - v_before[2];
    let swing = [-acceleration[2] * arm[1], acceleration[2] * arm[0]];
    for axis in 0..2 {
        let lost = -change(momentum(&fluid)[axis], lost[axis], lost_before[axis]);
        let unsteady = mass * (acceleration[axis] + swing[axis] - omega * omega * arm[axis]);
        let found = force.force[axis];
        // The centroid was where the body was expected, which is off by the third power of the step.
        assert!((found - lost - unsteady).abs() < 1e-5 * scale, "axis {axis}: {found} against {lost} + {unsteady}");
    }
}

/// With half the step the error of the place falls to a quarter where the fluid weighs nothing, by the exact oscillation.
/// In a fluid the order is some 1.5.
#[test]
fn a_body_on_springs_converges_in_time() {
    let end = |mass: f64, h: f64| {
        let stiffness = mass * 4.0;
        let body = format!(
            r#"{{ "shape": {{ "circle": {{ "radius": 0.5 }} }}, "position": [0.02, 0.01], "mount": {{
            "mass": {mass}, "x": {{ "stiffness": {stiffness}, "rest": -1e-3 }} }} }}"#
        );
        let mut fluid = fluid_of(&scene(&body, "", 0.02, 48));
        run(&mut fluid, (1.6 / h).round() as usize, h);
        fluid.pose(0).position[0] - 0.02 + 1e-3
    };
    let steps = [0.02, 0.01, 0.005];
    let [coarse, middle, fine] = steps.map(|h| end(1.5, h));
    let order = ((coarse - middle) / (middle - fine)).abs().log2();
    println!("order {order:.2}: {coarse}, {middle}, {fine}");
    // The start by a jump of the spring force leaves a layer that grows like √t.
    assert!(order > 1.4, "order {order}: {coarse}, {middle}, {fine}");
    let errors = steps.map(|h| (end(1e6, h) - 1e-3 * 3.2_f64.cos()).abs());
    println!("{errors:?}");
    assert!(errors[0] < 1e-5 && errors[0] > 3.5 * errors[1] && errors[1] > 3.5 * errors[2], "{errors:?}");
}

/// A state has all that the next step depends on, in both precisions; helpers change no bit.
#[test]
fn a_restored_body_continues_bit_by_bit() {
    for (precision, threads) in [(Precision::Double, 1), (Precision::Single, 2)] {
        let make = |threads| {
            ellipse(|scene| {
                let fluid = scene.fluid.as_mut().expect("it has one");
                (fluid.precision, fluid.threads) = (precision, threads);
            })
        };
        let mut fluid = make(1);
        run(&mut fluid, 7, 0.02);
        let mut other = make(threads);
        other.restore(&fluid.state()).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((fluid.pose(0), fluid.power_on_body(0)), (other.pose(0), other.power_on_body(0)));
        for fluid in [&mut fluid, &mut other] {
            run(fluid, 5, 0.02);
            // Several steps of the fluid in a communication step.
            run(fluid, 2, 0.15);
        }
        assert!(fluid.state() == other.state(), "{precision:?}: the states differ");
        assert_eq!((fluid.pose(0), fluid.force_on_body(0)), (other.pose(0), other.force_on_body(0)));
    }
}

/// Displacement and angle over time.
fn swing(t: f64) -> Pose {
    let (sin, cos) = (TAU * 0.5 * t).sin_cos();
    let sine = |amplitude: f64| [amplitude * sin, amplitude * TAU * 0.5 * cos];
    let ([x, u], [y, v], [angle, omega]) = (sine(0.2), sine(-0.1), sine(0.4));
    Pose { position: [x, y].into(), angle, velocity: [u, v].into(), omega }
}

/// The same motion by laws of time.
const SWING: &str = r#"{ "x": { "sine": { "amplitude": 0.2, "frequency": 0.5 } },
    "y": { "sine": { "amplitude": -0.1, "frequency": 0.5 } }, "angle": { "sine": { "amplitude": 0.4, "frequency": 0.5 } } }"#;

/// A body that the master moves as laws would feels the same where the fluid makes one step, and nearly so where it makes
/// several and the motion is interpolated.
#[test]
fn the_master_moves_a_body_as_laws_do() {
    let [law, master] = [SWING, r#""master""#].map(|motion| {
        let body = format!(
            r#"{{ "shape": {{ "rectangle": {{ "length": 1.0, "thickness": 0.4 }} }}, "position": [0.1, 0.0],
            "pivot": [0.3, 0.0], "motion": {motion} }}"#
        );
        scene(&body, "", 0.01, 64)
    });
    for (h, tolerance) in [(0.02, 1e-12), (0.2, 0.02)] {
        let (mut law, mut driven) = (fluid_of(&law), fluid_of(&master));
        *driven.displacement_mut(0) = swing(0.0);
        for _ in 0..(0.8 / h) as usize {
            let t = driven.time();
            *driven.displacement_mut(0) = swing(t + h);
            run(&mut driven, 1, h);
            run(&mut law, 1, h);
        }
        let (expected, found) = (law.force_on_body(0), driven.force_on_body(0));
        let scale = expected.force[0].hypot(expected.force[1]);
        let off = (expected.force[0] - found.force[0]).hypot(expected.force[1] - found.force[1]);
        println!("h = {h}: off by {:.1e} of {scale}", off / scale);
        assert!(off <= tolerance * scale, "h = {h}: {found:?} against {expected:?}");
        assert!((law.pose(0).position[0] - driven.pose(0).position[0]).abs() < 1e-14);
        let saved = driven.state();
        let mut other = fluid_of(&master);
        other.restore(&saved).unwrap_or_else(|e| panic!("{e}"));
        for fluid in [&mut driven, &mut other] {
            *fluid.displacement_mut(0) = swing(0.8 + h);
            run(fluid, 1, h);
        }
        assert!(driven.state() == other.state(), "the states differ");
        let before = driven.state();
        driven.displacement_mut(0).angle = f64::NAN;
        let refused = driven.advance(driven.time(), h);
        assert!(matches!(&refused, Err(Error::Displacement { body, .. }) if body == "body 1"), "{refused:?}");
        assert!(before == driven.state());
    }
}

/// Return a law through values at multiples of `h` (s), with these slopes at both ends.
fn table(values: &[f64], h: f64, slopes: [f64; 2]) -> String {
    let times: Vec<_> = (0..values.len()).map(|k| k as f64 * h).collect();
    format!(r#"{{ "table": {{ "times": {times:?}, "values": {values:?}, "end_slopes": {slopes:?} }} }}"#)
}

/// A body that laws lead along its own way through the fluid moves on from its release as if it had always been free:
/// velocities and accelerations stay, also of one as light as a tenth of the fluid and of a plate without thickness.
/// Until then its forces are those of a body that laws move, to the bit.
#[test]
fn a_released_body_moves_on_as_if_it_had_always_been_free() {
    let (h, steps) = (0.02, 20);
    let circle = r#""shape": { "circle": { "radius": 0.5 } }"#;
    let ellipse = r#""shape": { "ellipse": { "length": 1.2, "thickness": 0.8 } }, "pivot": [-0.2, 0.05], "angle": 0.3"#;
    let plate = r#""shape": { "plate": { "length": 1.0 } }, "pivot": [0.1, 0.0]"#;
    let bodies = [
        (circle, 0.08, "light", 0.5),
        (circle, 3.0, "heavy", 0.01),
        (ellipse, 1.5, "oblong", 0.01),
        (plate, 0.3, "plate", 0.1),
    ];
    for (shape, mass, name, most) in bodies {
        let mount = |release: &str| {
            format!(
                r#""mount": {{ "mass": {mass}, "inertia": 0.4, "x": {{}}, "y": {{ "stiffness": 2.0 }}, "angle": {{}},
                "gravity": [0.3, -0.6] {release} }}"#
            )
        };
        let made = |motion: &str| {
            let body = format!(r#"{{ {shape}, "position": [0.02, 0.01], {motion} }}"#);
            fluid_of(&scene(&body, r#""mean_flow": {},"#, 0.02, 64))
        };
        let numbers = |fluid: &Fluid| {
            let Pose { position, angle, velocity, omega } = fluid.pose(0);
            ([position[0] - 0.02, position[1] - 0.01, angle], [velocity[0], velocity[1], omega])
        };
        let mut free = made(&mount(""));
        let mut way = vec![numbers(&free)];
        for _ in 0..2 * steps {
            run(&mut free, 1, h);
            way.push(numbers(&free));
        }
        let rest = way[0].0;
        let law = |i: usize| {
            let values: Vec<_> = way[..=steps].iter().map(|(places, _)| places[i] - rest[i]).collect();
            table(&values, h, [0.0, way[steps].1[i]])
        };
        let motion = format!(r#""motion": {{ "x": {}, "y": {}, "angle": {} }}"#, law(0), law(1), law(2));
        let mut led = made(&motion);
        let mut released = made(&format!("{motion}, {}", mount(&format!(r#", "release": {}"#, h * steps as f64))));
        // The last time may be after the end of the tables through rounding.
        for _ in 1..steps {
            run(&mut led, 1, h);
            run(&mut released, 1, h);
            assert_eq!((led.pose(0), led.force_on_body(0)), (released.pose(0), released.force_on_body(0)), "{name}");
        }
        run(&mut released, 1, h);
        let step = |i: usize| (way[2 * steps].1[i] - way[steps].1[i]).abs() / steps as f64;
        let (gained, mut worst) = ((0..3).map(step).fold(0.0, f64::max), 0.0);
        for (_, expected) in &way[steps + 1..] {
            run(&mut released, 1, h);
            let now = numbers(&released).1;
            worst = (0..3).map(|i| (now[i] - expected[i]).abs() / gained).fold(worst, f64::max);
        }
        println!("{name}: velocities differ by {worst:.1e} of what they gain in a step");
        assert!(worst < most, "{name}: velocities differ by {worst} of what they gain in a step");
    }
}

/// In a fluid that weighs nothing the differences follow a fall and a turn at constant rates to rounding, so that a body
/// released from such laws keeps to them: it has the place and the velocity of the last two steps. A state before the
/// release has all of it, and communication steps of several steps go over it.
#[test]
fn a_body_released_from_a_fall_goes_on_falling() {
    let (release, h) = (0.3, 0.02);
    let fall = r#"{ "table": { "times": [0, 0.15, 0.3], "values": [0, -0.0225, -0.09], "end_slopes": [0, -0.6] } }"#;
    let turn = r#"{ "table": { "times": [0, 0.3], "values": [0, 0.3], "end_slopes": [1, 1] } }"#;
    let body = format!(
        r#"{{ "shape": {{ "ellipse": {{ "length": 1.2, "thickness": 0.8 }} }}, "position": [0.02, 0.01], "motion": {{
        "y": {fall}, "angle": {turn} }}, "mount": {{ "mass": 1e8, "inertia": 1e8, "gravity": [0.0, -2.0], "y": {{}},
        "angle": {{}}, "release": {release} }} }}"#
    );
    let scene = scene(&body, "", 0.02, 48);
    let mut fluid = fluid_of(&scene);
    run(&mut fluid, 14, h);
    let mut other = fluid_of(&scene);
    other.restore(&fluid.state()).unwrap_or_else(|e| panic!("{e}"));
    for fluid in [&mut fluid, &mut other] {
        run(fluid, 10, h);
        run(fluid, 2, 0.15);
    }
    assert!(fluid.state() == other.state(), "the states differ");
    for (steps, mut fluid) in [(0, fluid), (5, fluid_of(&scene))] {
        run(&mut fluid, steps, 0.156);
        let (t, Pose { position, angle, velocity, omega }) = (fluid.time(), fluid.pose(0));
        let off = [position[1] - 0.01 + t * t, velocity[1] + 2.0 * t, angle - t, omega - 1.0];
        println!("off by {off:?} at {t} s");
        assert!(off.iter().all(|off| off.abs() < 1e-7), "off by {off:?} at {t} s");
    }
}
