//! Forces of several bodies, probes, forcing, and Heun's scheme with all of them.

use std::f64::consts::{PI, TAU};

use nervure_fluid::Fluid;
use scene::{Mask, Scene, TimeScheme};

use crate::common::{fluid_of, run, scene};

const SCHEMES: [TimeScheme; 2] = [TimeScheme::Sbdf2, TimeScheme::Rk2];

/// The scene with another scheme and a mask that Heun's method can step over.
fn with(mut scene: Scene, scheme: TimeScheme) -> Scene {
    let fluid = scene.fluid.as_mut().expect("it has one");
    fluid.time_stepping.scheme = scheme;
    fluid.mask = Mask::Cosine { c_eta: 2e-3, half_width: 1.0, displacement_corrected: true };
    scene
}

/// A still cylinder, one that swings, and a beam, in a still open box.
fn three_bodies() -> Scene {
    scene(
        r#""kinematic_viscosity": 1e-3, "box": { "x": [-0.6, 0.6], "y": [-0.3, 0.3], "cells": [72, 36] },
        "initial_velocity": [0.5, 0.1],
        "cylinders": [{ "center": [-0.3, -0.05], "radius": 0.08 },
            { "center": [0.0, 0.12], "radius": 0.07, "motion":
                { "y": { "sine": { "amplitude": 0.02, "frequency": 2.0 } } } }]"#,
        r#", "beam": { "root": { "at": { "position": [0.1, -0.1], "direction": [1, 0] } },
            "length": 0.3, "thickness": 0.05, "segments": 8 }"#,
    )
}

/// What the fluid loses of its momentum in a step of backward differences is the drag on the bodies, to rounding.
#[test]
fn the_bodies_get_the_momentum_that_the_fluid_loses() {
    let mut fluid = fluid_of(&three_bodies());
    let h = 2e-3;
    let momentum = |fluid: &Fluid| {
        [0, 1].map(|axis| 1000.0 * fluid.grid().cell_volume() * fluid.velocity(axis).iter().sum::<f64>())
    };
    run(&mut fluid, 3, h);
    let mut before = [momentum(&fluid); 2];
    for _ in 0..20 {
        run(&mut fluid, 1, h);
        let now = momentum(&fluid);
        // The unsteady term of the swinging cylinder belongs to the fluid that it displaces.
        let omega = TAU * 2.0;
        let speed = |t: f64| 0.02 * omega * (omega * t).cos();
        let unsteady = 1000.0 * PI * 0.07_f64.powi(2) * (speed(fluid.time()) - speed(fluid.time() - h)) / h;
        if before[0] != before[1] {
            for axis in 0..2 {
                let lost = -(1.5 * now[axis] - 2.0 * before[0][axis] + 0.5 * before[1][axis]) / h;
                let drag = fluid.force()[axis] - if axis == 1 { unsteady } else { 0.0 };
                assert!((drag / lost - 1.0).abs() < 1e-9, "axis {axis}: drag {drag} N/m, momentum lost {lost}");
            }
        }
        before = [now, before[0]];
    }
    let parts = [fluid.force_on_body(0), fluid.force_on_body(1), fluid.force_on_flexible(0)];
    for axis in 0..2 {
        let sum: f64 = parts.iter().map(|part| part.force[axis]).sum();
        assert!((sum - fluid.force()[axis]).abs() <= 1e-12 * sum.abs(), "{parts:?}");
        assert!(parts.iter().all(|part| part.force[axis].abs() > 1e-3 * sum.abs()), "{parts:?}");
    }
}

/// A beam that starts to move across itself carries its added mass evenly: the moment about the root is half its length
/// times the lift; two mirrored cylinders feel mirrored moments.
#[test]
fn moments_are_those_of_symmetry() {
    for scheme in SCHEMES {
        let beam = scene(
            r#""kinematic_viscosity": 1e-3, "box": { "x": [-0.5, 0.5], "y": [-0.25, 0.25], "cells": [80, 40] }"#,
            r#", "beam": { "root": { "at": { "position": [-0.15, 0.0], "direction": [1, 0] } },
                "length": 0.3, "thickness": 0.05, "segments": 9 }"#,
        );
        let mut fluid = fluid_of(&with(beam, scheme));
        for step in 1..=20 {
            let stations = &mut fluid.stations_mut()[0];
            let t = 1e-3 * f64::from(step);
            stations.velocity[1].fill(2.0 * t);
            stations.position[1].fill(t * t);
            run(&mut fluid, 1, 1e-3);
        }
        let beam = fluid.force_on_flexible(0);
        assert!(beam.force[1] < -20.0, "{scheme:?}: {beam:?}");
        assert!((beam.moment / beam.force[1] / 0.15 - 1.0).abs() < 1e-9, "{scheme:?}: {beam:?}");
        let load: f64 = fluid.loads()[0].force[1].iter().sum();
        let unsteady = -1000.0 * 0.3 * 0.05 * 2.0;
        assert!((load / (beam.force[1] + unsteady) - 1.0).abs() < 0.15, "{scheme:?}: load {load} N/m, {beam:?}");

        let pair = scene(
            r#""kinematic_viscosity": 2e-3, "box": { "x": [-0.5, 0.5], "y": [-0.25, 0.25], "cells": [80, 40] },
            "initial_velocity": [1.0, 0.0],
            "cylinders": [{ "center": [0.0, 0.1], "radius": 0.06 }, { "center": [0.0, -0.1], "radius": 0.06 }]"#,
            "",
        );
        let mut fluid = fluid_of(&with(pair, scheme));
        run(&mut fluid, 60, 2e-3);
        let [upper, lower] = [0, 1].map(|k| fluid.force_on_body(k));
        assert!(upper.moment.abs() > 1e-4 * upper.force[0], "{upper:?}");
        for (a, b) in
            [(upper.moment, -lower.moment), (upper.force[0], lower.force[0]), (upper.force[1], -lower.force[1])]
        {
            assert!((a - b).abs() < 1e-9 * upper.force[0], "{scheme:?}: {upper:?} against {lower:?}");
        }
    }
}

/// Velocity and pressure of the Taylor–Green vortex at a point between the grid's, with fourth order in the cell size.
#[test]
fn probes_read_the_taylor_green_vortex() {
    // A third of a cell from the nearest column and row of either grid.
    let at: [f64; 2] = [TAU / 16.0 * (5.0 + 1.0 / 3.0), TAU / 16.0 * (2.0 + 1.0 / 3.0)];
    let (exact_u, exact_v) = (at[0].sin() * at[1].cos(), -at[0].cos() * at[1].sin());
    // The mean of Pi is 0, and that of u²/2 is 1/4.
    let exact_p = 1000.0 * (0.25 * ((2.0 * at[0]).cos() + (2.0 * at[1]).cos()) - 0.25);
    for scheme in SCHEMES {
        let errors = [16, 32].map(|n| {
            let text = format!(
                r#""kinematic_viscosity": 1e-9, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [{n}, {n}] }},
                "probes": [{{ "name": "other", "position": [0, 0] }}, {{ "name": "a", "position": {at:?} }}]"#
            );
            let mut scene = scene(&text, "");
            scene.fluid.as_mut().expect("it has one").time_stepping.scheme = scheme;
            let mut fluid = fluid_of(&scene);
            fluid.set_velocity(|[x, y]| [x.sin() * y.cos(), -x.cos() * y.sin()]);
            run(&mut fluid, 2, 1e-3);
            let [u, v] = fluid.probe_velocity(1);
            let centre = fluid.probe_pressure(0);
            assert!((centre / 250.0 - 1.0).abs() < 1e-6, "{scheme:?}: {centre} Pa at the grid point (0, 0)");
            [u - exact_u, v - exact_v, (fluid.probe_pressure(1) - exact_p) / 1000.0].map(f64::abs)
        });
        for (coarse, fine) in errors[0].into_iter().zip(errors[1]) {
            assert!(fine < 4e-4 && coarse < 24.0 * fine && coarse > 8.0 * fine, "{scheme:?}: {errors:?}");
        }
    }
}

/// The mean flow is held exactly, whatever stands in its way.
#[test]
fn the_mean_flow_is_held() {
    let text = r#""kinematic_viscosity": 0.02, "box": { "x": [-0.4, 0.4], "y": [-0.1, 0.5], "cells": [16, 96] },
        "channel": { "y": [0.0, 0.41] },
        "mean_flow": { "x": { "cosine_ramp": { "value": 0.7, "duration": 0.1 } } }"#;
    // The same turned: along y.
    let turned = r#""kinematic_viscosity": 0.02, "box": { "x": [-0.4, 0.4], "y": [-0.1, 0.5], "cells": [24, 16] },
        "cylinders": [{ "center": [0.0, 0.2], "radius": 0.1 }],
        "mean_flow": { "y": { "cosine_ramp": { "value": 0.7, "duration": 0.1 } } }"#;
    for (scheme, text, axis) in SCHEMES.into_iter().flat_map(|scheme| [(scheme, text, 0), (scheme, turned, 1)]) {
        let mut fluid = fluid_of(&with(scene(text, ""), scheme));
        let law = |t: f64| 0.7 * 0.5 * (1.0 - (PI * (t / 0.1).min(1.0)).cos());
        for _ in 0..40 {
            run(&mut fluid, 5, 1e-3);
            let mean = |axis| fluid.velocity(axis).iter().sum::<f64>() / fluid.grid().len() as f64;
            let (along, t) = (mean(axis), fluid.time());
            assert!((along - law(t)).abs() < 1e-12, "{scheme:?}, axis {axis}: mean {along} m/s at {t} s");
            assert!(axis == 0 || mean(0).abs() < 1e-12, "{scheme:?}: mean {} m/s across", mean(0));
        }
    }
}

/// A wave across a stream of velocity U loses the factor exp(−∫ a dx / U) = exp(−L/(2 c_eta U)) on its way through.
#[test]
fn a_sponge_damps_what_passes_through_it() {
    let text = r#""kinematic_viscosity": 1e-9, "box": { "x": [0, 2], "y": [0, 0.5], "cells": [128, 8] },
        "initial_velocity": [1.0, 0.0],
        "sponge": { "x": [1.2, 1.8], "mean_velocity": { "constant": 1.0 }, "c_eta": 0.2 }"#;
    for scheme in SCHEMES {
        let mut fluid = fluid_of(&with(scene(text, ""), scheme));
        let wave = |x: f64| 0.1 * (TAU * x).sin();
        fluid.set_velocity(|[x, _]| [1.0, wave(x)]);
        run(&mut fluid, 4000, 5e-4);
        let factor = (-0.6_f64 / (2.0 * 0.2)).exp();
        let grid = *fluid.grid();
        for (c, v) in fluid.velocity(1).iter().enumerate() {
            let expected = factor * wave(grid.coordinate(0, c / grid.cells[1]));
            assert!(
                (v - expected).abs() < 1e-5,
                "{scheme:?}: v = {v} at x = {}, not {expected}",
                grid.coordinate(0, c / grid.cells[1])
            );
        }
        let worst = fluid.velocity(0).iter().map(|u| (u - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-9, "{scheme:?}: the stream changed by {worst} m/s");
    }
}

/// A moving cylinder and a moving beam give the same forces wherever the box is cut.
#[test]
fn bodies_leave_through_one_end_and_come_in_at_the_other() {
    for scheme in SCHEMES {
        let history = |shift: f64| {
            let (x, y) = (0.35 + shift, 0.1 + shift);
            let text = format!(
                r#""kinematic_viscosity": 1e-3, "box": {{ "x": [0, 1], "y": [0, 0.5], "cells": [64, 32] }},
                "cylinders": [{{ "center": [{x}, 0.12], "radius": 0.06, "motion": {{ "x": {{ "table":
                    {{ "times": [0, 0.1, 0.4], "values": [0, 0.02, 0.3] }} }} }} }}]"#
            );
            let rest = format!(
                r#", "beam": {{ "root": {{ "at": {{ "position": [{y}, 0.375], "direction": [1, 0] }} }},
                "length": 0.3, "thickness": 0.0625, "segments": 6 }}"#
            );
            let mut fluid = fluid_of(&with(scene(&text, &rest), scheme));
            let rest = fluid.stations()[0].clone();
            let mut history = Vec::new();
            for step in 1..=100 {
                let t = 2e-3 * f64::from(step);
                let stations = &mut fluid.stations_mut()[0];
                for k in 0..rest.len() {
                    stations.position[0][k] = rest.position[0][k] + 4.0 * t * t;
                    stations.velocity[0][k] = 8.0 * t;
                }
                run(&mut fluid, 1, 2e-3);
                let (cylinder, beam) = (fluid.force_on_body(0), fluid.force_on_flexible(0));
                history.extend([cylinder.force.into(), [cylinder.moment, beam.moment], beam.force.into()].concat());
            }
            history
        };
        let (inside, across) = (history(0.0), history(0.5));
        let scale = inside.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        assert!(scale > 1.0, "the largest force is {scale} N/m");
        for (step, (a, b)) in inside.iter().zip(&across).enumerate() {
            assert!((a - b).abs() < 1e-7 * scale, "{scheme:?}, value {step}: {a} against {b}, largest {scale}");
        }
    }
}

/// Bodies that touch or overlap the walls and each other, still and moving, make no trouble, and a body that has passed
/// leaves nothing behind.
#[test]
fn bodies_may_touch() {
    for scheme in SCHEMES {
        let text = r#""kinematic_viscosity": 1e-3, "box": { "x": [-0.4, 1.2], "y": [-0.1, 0.5], "cells": [96, 36] },
            "channel": { "y": [0.0, 0.4] },
            "inflow": { "x": [-0.4, -0.1], "profile": "parabolic", "c_eta": 2e-3,
                        "mean_velocity": { "constant": 1.0 } },
            "initial_velocity": [0.8, 0.0],
            "cylinders": [
                { "center": [0.1, 0.03], "radius": 0.05 }, { "center": [0.21, 0.05], "radius": 0.06 },
                { "center": [0.3, 0.25], "radius": 0.05 }, { "center": [0.3, 0.145], "radius": 0.05 },
                { "center": [0.8, 0.35], "radius": 0.05, "motion":
                    { "y": { "table": { "times": [0, 0.2], "values": [0, 0.6] } } } }]"#;
        let beam = r#", "beam": { "root": { "on_cylinder": { "cylinder": 2 } }, "length": 0.3, "thickness": 0.05,
            "segments": 10 }"#;
        let mut scene = with(scene(text, beam), scheme);
        scene.fluid.as_mut().expect("it has one").time_stepping.max_cfl = 0.4;
        let mut fluid = fluid_of(&scene);
        run(&mut fluid, 150, 2e-3);
        let divergence = fluid.divergence();
        assert!(divergence < 1e-12, "{scheme:?}: divergence {divergence}");
        let forces: Vec<_> = (0..5).map(|k| fluid.force_on_body(k)).collect();
        assert!(forces.iter().all(|f| f.force[0].is_finite() && f.force[0].abs() > 1.0), "{forces:?}");
        // The mover has gone through the wall, the box's end and back to where it was: one box height on.
        let energy = fluid.kinetic_energy();
        assert!((20.0..2000.0).contains(&energy), "{scheme:?}: {energy} J/m");
    }
}

/// Heun's drag is explicit: the unit divides its steps at C_eta, and refuses what would never end.
#[test]
fn the_explicit_drag_limits_the_step() {
    let mut scene = with(three_bodies(), TimeScheme::Rk2);
    let c_eta = |scene: &mut Scene, value: f64| {
        scene.fluid.as_mut().expect("it has one").mask = Mask::Sharp { c_eta: value, displacement_corrected: false };
    };
    c_eta(&mut scene, 1e-3);
    let mut fluid = fluid_of(&scene);
    run(&mut fluid, 20, 1e-2);
    let cfl_per_step = fluid.cfl();
    let speed = (0..2).map(|axis| fluid.velocity(axis).iter().fold(0.0_f64, |m, u| m.max(u.abs()))).sum::<f64>();
    assert!(speed < 3.0 && cfl_per_step <= 1e-3 * speed * 60.0 * 1.01, "{speed} m/s, CFL {cfl_per_step}");
    c_eta(&mut scene, 1e-8);
    let error = fluid_of(&scene).advance(0.0, 1e-2).expect_err("a million steps").to_string();
    assert!(error.contains("C_eta = 1.000e-8 s") && error.contains("communication step of 1.000e-2 s"), "{error}");
}

/// Heun's method converges to the same flow around bodies as backward differences.
#[test]
fn both_schemes_agree_on_forces() {
    let forces = SCHEMES.map(|scheme| {
        let mut fluid = fluid_of(&with(three_bodies(), scheme));
        run(&mut fluid, 400, 2.5e-4);
        let cylinders = [0, 1].map(|k| fluid.force_on_body(k));
        [cylinders[0], cylinders[1], fluid.force_on_flexible(0)]
    });
    let scale = forces[0][0].force[0].abs();
    for (a, b) in forces[0].iter().zip(&forces[1]) {
        for (a, b) in [(a.force[0], b.force[0]), (a.force[1], b.force[1]), (a.moment / 0.1, b.moment / 0.1)] {
            assert!((a - b).abs() < 0.01 * scale, "{forces:?}");
        }
    }
}

/// A fluid with rigid bodies, at rest in an open box of 1 m.
fn with_bodies(bodies: &str, rest: &str, cells: usize) -> Scene {
    let mut scene = scene(
        &format!(
            r#""kinematic_viscosity": 2e-3, "box": {{ "x": [-0.5, 0.5], "y": [-0.5, 0.5],
                "cells": [{cells}, {cells}] }},
            "bodies": [{bodies}] {rest}"#
        ),
        "",
    );
    let fluid = scene.fluid.as_mut().expect("it has one");
    fluid.mask = Mask::LogLinear {
        c_eta: 1e-4,
        decay_length_cells: 0.25,
        core_depth: None,
        wall_correction: scene::WallCorrection::Curvature,
    };
    fluid.density = 1.0;
    scene
}

/// A still and a swinging circle are cylinders, to the bit.
#[test]
fn a_circle_is_a_cylinder() {
    let stream = r#", "initial_velocity": [0.5, 0.1]"#;
    let swing = r#""motion": { "y": { "sine": { "amplitude": 0.02, "frequency": 2.0 } } }"#;
    let bodies = format!(
        r#"{{ "shape": {{ "circle": {{ "radius": 0.1 }} }}, "position": [-0.2, 0.05] }},
        {{ "shape": {{ "circle": {{ "radius": 0.07 }} }}, "position": [0.2, -0.1], {swing} }}"#
    );
    let cylinders = format!(
        r#"{stream}, "cylinders": [{{ "center": [-0.2, 0.05], "radius": 0.1 }},
        {{ "center": [0.2, -0.1], "radius": 0.07, {swing} }}]"#
    );
    let [mut one, mut other] =
        [with_bodies(&bodies, stream, 48), with_bodies("", &cylinders, 48)].map(|scene| fluid_of(&scene));
    for fluid in [&mut one, &mut other] {
        run(fluid, 20, 2e-3);
    }
    assert!(one.state() == other.state(), "{:?}, {:?}", one.force(), other.force());
    assert_eq!([0, 1].map(|k| one.force_on_body(k)), [0, 1].map(|k| other.force_on_body(k)));
}

/// The same body told in other ways: a rectangle as a polygon with its corners elsewhere in its axes, and axes that are
/// turned by what its angle is less.
#[test]
fn equal_bodies_feel_equal_forces() {
    let motion = r#""motion": { "x": { "sine": { "amplitude": 0.05, "frequency": 1.0 } },
        "angle": { "sine": { "amplitude": 0.5, "frequency": 1.0, "phase": 0.3 } } }"#;
    let rectangle = format!(
        r#"{{ "shape": {{ "rectangle": {{ "length": 0.3, "thickness": 0.1 }} }}, "position": [0.0, 0.0],
        "pivot": [0.1, 0.0], "angle": 0.4, {motion} }}"#
    );
    // The axes of the polygon are those of the rectangle turned by a right angle, about a point aside.
    let polygon = format!(
        r#"{{ "shape": {{ "polygon": {{ "corners": [[3.05, 1.15], [2.95, 1.15], [2.95, 0.85], [3.05, 0.85]] }} }},
        "position": [0.0, 0.0], "pivot": [3.0, 0.9], "angle": {}, {motion} }}"#,
        0.4 + 0.5 * PI
    );
    let [one, other] = [rectangle, polygon].map(|body| {
        let mut fluid = fluid_of(&with_bodies(&body, "", 64));
        run(&mut fluid, 40, 2e-3);
        fluid.force_on_body(0)
    });
    for (a, b) in [(one.force[0], other.force[0]), (one.force[1], other.force[1]), (one.moment, other.moment)] {
        assert!((a - b).abs() < 1e-7 * one.force[0].hypot(one.force[1]), "{one:?} against {other:?}");
    }
}

/// What the fluid loses of its momentum is the drag on a body that turns about a point aside, and its reported force
/// has the rate of the momentum of the fluid that it displaces besides.
#[test]
fn a_turning_body_gets_the_momentum_that_the_fluid_loses() {
    let (arm, omega, h) = (0.1, TAU * 0.5, 1e-3);
    let body = r#"{ "shape": { "ellipse": { "length": 0.3, "thickness": 0.1 } }, "position": [0.05, 0.0],
        "pivot": [-0.1, 0.0], "motion": { "angle": { "sine": { "amplitude": 0.6, "frequency": 0.5 } } } }"#;
    let mut fluid = fluid_of(&with_bodies(body, "", 64));
    let momentum =
        |fluid: &Fluid| [0, 1].map(|axis| fluid.grid().cell_volume() * fluid.velocity(axis).iter().sum::<f64>());
    let displaced = |t: f64| {
        let (angle, rate) = (0.6 * (omega * t).sin(), 0.6 * omega * (omega * t).cos());
        let mass = PI * 0.15 * 0.05;
        [-mass * arm * rate * angle.sin(), mass * arm * rate * angle.cos()]
    };
    run(&mut fluid, 2, h);
    let mut before = momentum(&fluid);
    run(&mut fluid, 1, h);
    let mut earlier = [momentum(&fluid), before];
    for _ in 0..20 {
        run(&mut fluid, 1, h);
        let now = momentum(&fluid);
        before = earlier[0];
        let t = fluid.time();
        for axis in 0..2 {
            let lost = -(1.5 * now[axis] - 2.0 * before[axis] + 0.5 * earlier[1][axis]) / h;
            let unsteady = (displaced(t)[axis] - displaced(t - h)[axis]) / h;
            let found = fluid.force_on_body(0).force[axis];
            let scale = fluid.force()[1].abs();
            assert!((found - lost - unsteady).abs() < 1e-9 * scale, "axis {axis}: {found} against {lost} + {unsteady}");
        }
        earlier = [now, before];
    }
    let (force, pose) = (fluid.force_on_body(0), fluid.pose(0));
    let power = force.moment * pose.omega;
    assert!((fluid.power_on_body(0) / power - 1.0).abs() < 1e-12, "{} against {power}", fluid.power_on_body(0));
}

/// A circle that begins to turn at a steady rate: the Laplace transform of the torque in open fluid is
/// `−2 pi rho nu R² omega (2 + z K_0(z)/K_1(z))/p` with `z² = p R²/nu`. For large z the bracket is
/// `z + 3/2 + 3/(8 z) − 3/(8 z²) + 63/(128 z³)`, term by term a series in √T, T = nu t/R².
#[test]
fn a_circle_that_turns_feels_the_exact_torque() {
    let (radius, nu, omega) = (0.15_f64, 2e-3, 1.0);
    let turning = format!(
        r#"{{ "shape": {{ "circle": {{ "radius": {radius} }} }}, "position": [0.003, 0.002], "motion":
        {{ "angle": {{ "table": {{ "times": [-1, 0, 9, 10], "values": [-1, 0, 9, 10] }} }} }} }}"#
    );
    let mut fluid = fluid_of(&with_bodies(&turning, "", 96));
    let h = 5e-3;
    let mut worst: f64 = 0.0;
    run(&mut fluid, 100, h);
    for _ in 0..100 {
        run(&mut fluid, 1, h);
        let t = nu * fluid.time() / (radius * radius);
        let root = (t / PI).sqrt();
        let shape = root / t + 1.5 + 0.75 * root - 0.375 * t + 0.65625 * t * root;
        let exact = -2.0 * PI * nu * radius * radius * omega * shape;
        worst = worst.max((fluid.force_on_body(0).moment / exact - 1.0).abs());
    }
    println!("torque off by {worst:.5}");
    assert!(worst < 0.01, "torque off by {worst}");
}
