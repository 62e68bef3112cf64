//! The beam's stations: their axes, their path, and the loads and impedance that are announced to each of them.

use std::f64::consts::PI;

use nervure_fluid::{Fluid, Loads, State, Stations};
use scene::{Mask, Scene, TimeScheme, WallCorrection};

use crate::common::{fluid_of, run, scene};

const MASKS: [Mask; 2] = [
    Mask::Cosine { c_eta: 1e-4, half_width: 1.0, displacement_corrected: true },
    Mask::LogLinear {
        c_eta: 1e-5,
        decay_length_cells: 0.25,
        core_depth: None,
        wall_correction: WallCorrection::Curvature,
    },
];

/// A beam across a stream, along x, or with `transposed` the same with x and y exchanged.
fn beam_in_a_stream(mask: Mask, transposed: bool) -> Scene {
    let order = |[x, y]: [&str; 2]| if transposed { format!("{y}, {x}") } else { format!("{x}, {y}") };
    let [cells, stream] = [order(["72", "36"]), order(["0.4", "0.7"])];
    let [root, direction] = [order(["0.4", "0.27"]), order(["1", "0"])];
    let (x, y) = if transposed { ("0.6", "1.2") } else { ("1.2", "0.6") };
    let text = format!(
        r#""kinematic_viscosity": 1e-3, "box": {{ "x": [0, {x}], "y": [0, {y}], "cells": [{cells}] }},
        "initial_velocity": [{stream}]"#
    );
    let rest = format!(
        r#", "beam": {{ "root": {{ "at": {{ "position": [{root}], "direction": [{direction}] }} }},
        "length": 0.3, "thickness": 0.06, "segments": 6 }}"#
    );
    let mut scene = scene(&text, &rest);
    scene.fluid.as_mut().expect("it has one").mask = mask;
    scene
}

fn stations(fluid: &mut Fluid) -> &mut Stations {
    &mut fluid.stations_mut()[0]
}

/// Largest difference between two lists over the largest number in the second.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let scale = b.iter().fold(f64::MIN_POSITIVE, |most, b| most.max(b.abs()));
    a.iter().zip(b).fold(0.0, |most, (a, b)| most.max((a - b).abs() / scale))
}

#[test]
fn stations_have_x_and_y_of_the_box() {
    let rest = fluid_of(&beam_in_a_stream(MASKS[0], false)).stations()[0].clone();
    for k in 0..=6 {
        let (x, y) = (rest.position[0][k], rest.position[1][k]);
        assert!((x - 0.4 - 0.05 * k as f64).abs() < 1e-12 && (y - 0.27).abs() < 1e-12, "station {k} at ({x}, {y}) m");
    }
    // Exchange x and y of everything: the loads exchange theirs, and the moment turns round.
    let [plain, transposed] = [false, true].map(|transposed| {
        let mut fluid = fluid_of(&beam_in_a_stream(MASKS[1], transposed));
        let [along, across] = if transposed { [1, 0] } else { [0, 1] };
        for step in 1..=20 {
            let (t, stations) = (2e-3 * f64::from(step), stations(&mut fluid));
            for k in 0..=6 {
                let s = k as f64 / 6.0;
                stations.position[across][k] = 0.27 + s * s * t * t;
                stations.velocity[across][k] = 2.0 * s * s * t;
                stations.velocity[along][k] = 0.05 * s * t;
            }
            run(&mut fluid, 1, 2e-3);
        }
        let Loads { force, impedance } = fluid.loads()[0].clone();
        let body = fluid.force_on_flexible(0);
        let moment = if transposed { -body.moment } else { body.moment };
        [force[along].clone(), force[across].clone(), impedance, vec![body.force[along], body.force[across], moment]]
    });
    for (plain, transposed) in plain.iter().zip(&transposed) {
        assert!(difference(transposed, plain) < 1e-9, "{plain:?} against {transposed:?}");
    }
}

/// The steps within a communication step see the beam on a cubic path with linear velocity.
#[test]
fn the_stations_go_their_way_within_a_communication_step() {
    let (h, parts) = (8e-3, 4);
    // Position and velocity of station k after the share s of the step.
    let at = |k: usize, s: f64| {
        let (t, a, b) = (s * h, [3.0, 12.0].map(|a| a * k as f64 / 6.0), [-100.0, 400.0].map(|b| b * k as f64 / 6.0));
        [0, 1].map(|i| (a[i] * t * t + b[i] * t * t * t, s * (2.0 * a[i] * h + 3.0 * b[i] * h * h)))
    };
    for scheme in [TimeScheme::Sbdf2, TimeScheme::Rk2] {
        let run_in = |communication_steps: usize| {
            let mut scene =
                beam_in_a_stream(Mask::Cosine { c_eta: 4e-3, half_width: 1.0, displacement_corrected: true }, false);
            let time_stepping = &mut scene.fluid.as_mut().expect("it has one").time_stepping;
            (time_stepping.scheme, time_stepping.max_step) = (scheme, h / parts as f64);
            let mut fluid = fluid_of(&scene);
            let rest = stations(&mut fluid).clone();
            for step in 1..=communication_steps {
                let stations = stations(&mut fluid);
                for k in 0..=6 {
                    for (axis, (way, velocity)) in
                        at(k, step as f64 / communication_steps as f64).into_iter().enumerate()
                    {
                        stations.position[axis][k] = rest.position[axis][k] + way;
                        stations.velocity[axis][k] = velocity;
                    }
                }
                run(&mut fluid, 1, h / communication_steps as f64);
            }
            fluid
        };
        let (whole, divided) = (run_in(1), run_in(parts));
        for (found, expected) in [
            (&*whole.velocity(0), &*divided.velocity(0)),
            (&whole.velocity(1), &divided.velocity(1)),
            (&whole.force(), &divided.force()),
        ] {
            let far = difference(found, expected);
            assert!(far < 1e-9, "{scheme:?}: one communication step differs from {parts} by {far}");
        }
    }
}

/// Power of the drag in the next step from `state` if the stations have the velocities of `shape`, W/m.
fn power(fluid: &mut Fluid, state: &State, shape: &dyn Fn(usize) -> [f64; 2]) -> f64 {
    fluid.restore(state).unwrap_or_else(|e| panic!("{e}"));
    let stations = stations(fluid);
    for k in 0..stations.len() {
        let [vx, vy] = shape(k);
        (stations.velocity[0][k], stations.velocity[1][k]) = (vx, vy);
    }
    run(fluid, 1, 2e-3);
    fluid.exchange()[0].power
}

/// The power of the drag on the cells is that of the announced loads in every motion of the stations, one by one, less
/// the impedance of each times its velocity where all move together; and their moment is that of the drag.
#[test]
fn each_station_is_announced_its_own_load_impedance_and_moment() {
    for mask in MASKS {
        let mut fluid = fluid_of(&beam_in_a_stream(mask, false));
        run(&mut fluid, 10, 2e-3);
        let (state, n, speed) = (fluid.state(), 7, 0.01);
        let Loads { force, impedance } = fluid.loads()[0].clone();
        // Linear in the velocity and quadratic, of the power.
        let mut parts = |shape: &dyn Fn(usize) -> [f64; 2]| {
            let [there, back] = [speed, -speed].map(|v| power(&mut fluid, &state, &|k| shape(k).map(|part| v * part)));
            ((there - back) / (2.0 * speed), -(there + back) / (2.0 * speed * speed))
        };
        let (_, together) = parts(&|_| [0.0, 1.0]);
        let mut found = [vec![], vec![], vec![]];
        for station in 0..n {
            let hat = |k: usize| f64::from(k == station);
            found[0].push(parts(&|k| [hat(k), 0.0]).0);
            let (linear, alone) = parts(&|k| [0.0, hat(k)]);
            let (_, both) = parts(&|k| [0.0, 1.0 + hat(k)]);
            found[1].push(linear);
            found[2].push(0.5 * (both - alone - together));
        }
        for (found, announced) in found.iter().zip([&force[0], &force[1], &impedance]) {
            assert!(difference(announced, found) < 1e-7, "{mask:?}: announced {announced:?}, exerted {found:?}");
        }
        fluid.restore(&state).unwrap_or_else(|e| panic!("{e}"));
        let position = stations(&mut fluid).position.clone();
        run(&mut fluid, 1, 2e-3);
        let arm = |axis: usize, k: usize| position[axis][k] - position[axis][0];
        let announced: f64 = (0..n).map(|k| arm(0, k) * force[1][k] - arm(1, k) * force[0][k]).sum();
        let exerted = fluid.force_on_flexible(0).moment;
        // The tail of the mask beyond the tip has a longer arm than the section that takes its load; with a wall target
        // it drags more, as the flow goes through the surface there (found 5.7e-6, and 2.2e-6 with a core).
        assert!((exerted / announced - 1.0).abs() < 1e-5, "{mask:?}: announced {announced} N m/m, exerted {exerted}");
    }
}

/// Heun's drag at the end of a step has felt half of the step: `rho a (1 − dt a/2)` where the fluid follows the body
/// freely. The pressure holds most of it back, so that the load falls by no less than announced.
#[test]
fn the_impedance_of_rk2_is_that_of_its_drag() {
    let h = 1e-3;
    let mut scene = beam_in_a_stream(Mask::Sharp { c_eta: 2.0 * h, displacement_corrected: false }, false);
    scene.fluid.as_mut().expect("it has one").time_stepping.scheme = TimeScheme::Rk2;
    let mut fluid = fluid_of(&scene);
    run(&mut fluid, 10, h);
    let state = fluid.state();
    let announced: f64 = fluid.loads()[0].impedance.iter().sum();
    let [still, moved] = [0.0, 0.01].map(|speed| {
        fluid.restore(&state).unwrap_or_else(|e| panic!("{e}"));
        stations(&mut fluid).velocity[1].fill(speed);
        run(&mut fluid, 1, h);
        fluid.exchange()[0].force[1]
    });
    let exerted = -(moved - still) / 0.01;
    // dt a is 1/2: free to follow, the fluid would leave three quarters of the drag.
    assert!((0.75..1.0).contains(&(announced / exerted)), "announced {announced} kg/(m s), exerted {exerted}");
}

/// The loads are continuous in the stations: an eighth of a move changes them by an eighth. A cell that changed its
/// velocity where the normal of a station passes over it would make an iteration between fluid and rod stall.
#[test]
fn loads_are_continuous_in_the_stations() {
    let mask = Mask::LogLinear {
        c_eta: 4e-3,
        decay_length_cells: 0.3,
        core_depth: None,
        wall_correction: scene::WallCorrection::None,
    };
    let mut fluid = fluid_of(&beam_in_a_stream(mask, false));
    run(&mut fluid, 10, 2e-3);
    let (state, rest) = (fluid.state(), stations(&mut fluid).clone());
    let mut loads = |moved: f64| {
        fluid.restore(&state).unwrap_or_else(|e| panic!("{e}"));
        let stations = stations(&mut fluid);
        let lengths = stations.position[0].clone();
        for k in 0..stations.len() {
            let s = lengths[k] - lengths[0];
            stations.position[0][k] = rest.position[0][k] + moved;
            stations.position[1][k] = rest.position[1][k] + 3.0 * s * s;
            stations.velocity[1][k] = 0.5 * (9.0 * s).sin();
        }
        run(&mut fluid, 1, 2e-3);
        fluid.loads()[0].force[1].clone()
    };
    let mut largest_change = |steps: usize, length: f64| {
        let all: Vec<_> = (0..=steps).map(|i| loads(length * i as f64)).collect();
        let changes =
            all.windows(2).map(|two| two[0].iter().zip(&two[1]).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())));
        changes.fold(0.0, f64::max)
    };
    let (coarse, fine) = (largest_change(100, 1.6e-4), largest_change(800, 2e-5));
    assert!(fine < 0.2 * coarse, "a move changes the loads by {coarse} N/m, an eighth of it by {fine}");
}

/// A stream that speeds up as a whole, and a beam that goes with it, have p = rho a (x_out − x), whatever stands in it.
#[test]
fn pressure_around_the_beam_is_measured_from_the_outlet() {
    let (acceleration, h) = (2.0, 1e-3);
    let fluid = r#""kinematic_viscosity": 1e-3, "box": { "x": [-0.6, 0.6], "y": [-0.2, 0.2], "cells": [144, 48] },
        "inflow": { "x": [-0.5, -0.3], "profile": "uniform", "c_eta": 1e-4,
            "mean_velocity": { "table": { "times": [-1, 0, 1, 2], "values": [-2, 0, 2, 4] } } }"#;
    let rest = r#", "beam": { "root": { "at": { "position": [-0.1, 0.02], "direction": [1, 0] } },
        "length": 0.3, "thickness": 0.04, "segments": 6 },
        "rod": { "material": { "plane_strain": { "density": 2000.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3 } } },
        "coupling": { "load": "momentum", "axial_pressure_strain": true }"#;
    for mask in MASKS {
        let mut scene = scene(fluid, rest);
        scene.fluid.as_mut().expect("it has one").mask = mask;
        let mut fluid = fluid_of(&scene);
        let rest = stations(&mut fluid).position[0].clone();
        for step in 1..=100 {
            let t = h * f64::from(step);
            let stations = stations(&mut fluid);
            for (x, rest) in stations.position[0].iter_mut().zip(&rest) {
                *x = rest + 0.5 * acceleration * t * t;
            }
            stations.velocity[0].fill(acceleration * t);
            run(&mut fluid, 1, h);
        }
        let x = stations(&mut fluid).position[0].clone();
        // The inflow's zone ends the box for the flow at −0.5 m, that is at 0.7 m.
        let expected: Vec<_> = x.iter().map(|x| 1000.0 * acceleration * (0.7 - x)).collect();
        let found = fluid.pressure_around()[0].clone();
        let far = difference(&found, &expected);
        assert!(far < 5e-3, "{mask:?}: {far}, {found:?} against {expected:?}");
        // It is that of the present time, and a state that is put back has its own.
        let state = fluid.state();
        run(&mut fluid, 1, h);
        assert_ne!(fluid.pressure_around()[0], found);
        fluid.restore(&state).expect("it is its own");
        assert_eq!(fluid.pressure_around()[0], found);
    }
}

#[test]
fn a_beam_that_is_folded_back_is_refused_at_the_station() {
    for (angle, folded) in [(PI, true), (0.95 * PI, true), (-0.95 * PI, true), (0.9 * PI, false), (-0.5 * PI, false)] {
        for from in [2, 3, 6] {
            let mut fluid = fluid_of(&beam_in_a_stream(MASKS[1], false));
            let (sin, cos) = angle.sin_cos();
            let Stations { position: [x, y], .. } = stations(&mut fluid);
            for k in from..x.len() {
                let s = 0.05 * (k - from + 1) as f64;
                (x[k], y[k]) = (x[from - 1] + s * cos, y[from - 1] + s * sin);
            }
            let said = fluid.advance(0.0, 0.01).map_err(|error| error.to_string());
            let station = format!("the beam is folded back on itself at station {from}, ");
            assert_eq!(said.is_err(), folded, "{angle} at {from}: {said:?}");
            assert!(said.is_ok() || said.unwrap_err().starts_with(&station));
        }
    }
}
