//! Thin beams: added mass, balance of momentum and power, states, and threads.

mod common;

use std::f64::consts::PI;

use common::{fluid_of, run, scene};
use nervure_fluid::{Fluid, Stations};

/// A line along y of length 1 in the middle of a box of the size `size`, with `points` points a length.
fn line(size: f64, points: usize, more: &str) -> Fluid {
    let (half, cells) = (0.5 * size, (size * points as f64) as usize);
    let text = format!(
        r#""kinematic_viscosity": 1e-9, "box": {{ "x": [-{half}, {half}], "y": [-{half}, {half}],
        "cells": [{cells}, {cells}] }} {more}"#
    );
    let beam = r#", "beam": { "root": { "at": { "position": [0.01, -0.5], "direction": [0, 1] } }, "length": 1,
        "thickness": 0.01, "segments": 40, "surface": "line" }"#;
    fluid_of(&scene(&text, beam))
}

/// Let the stations move for a step of `h` seconds with a velocity, given at a place from 0 to 1.
fn step(fluid: &mut Fluid, h: f64, velocity: impl Fn(f64) -> [f64; 2]) {
    let stations = &mut fluid.stations_mut()[0];
    let last = (stations.len() - 1) as f64;
    for k in 0..stations.len() {
        for (axis, velocity) in velocity(k as f64 / last).into_iter().enumerate() {
            stations.position[axis][k] += h * velocity;
            stations.velocity[axis][k] = velocity;
        }
    }
    run(fluid, 1, h);
}

/// Added mass over the density of a line of length 1 across still fluid, m²: the impulse of its start.
fn added_mass(size: f64, points: usize) -> f64 {
    let mut fluid = line(size, points, r#", "mean_flow": { "x": { "constant": 0 } }"#);
    let (h, speed, mut impulse) = (2e-3, 1e-3, 0.0);
    // The split step needs some steps until the pressure has grown.
    for _ in 0..60 {
        step(&mut fluid, h, |_| [speed, 0.0]);
        impulse -= h * fluid.force_on_beam(0).force[0];
    }
    impulse / (1000.0 * speed)
}

/// A plate of no thickness has the added mass π/4 rho c²; one of thickness t has 1 + t (0.237 + 0.505 ln(1/t)) times as
/// much (a fit to the rectangles of DNV-RP-C205). The neighbours in the lattice count with the square of its size.
#[test]
fn a_line_has_the_added_mass_of_a_plate() {
    for points in [16, 32] {
        let [near, far] = [6.0, 12.0].map(|size| added_mass(size, points));
        let found = far + (far - near) / 3.0;
        let thickness = scene::LINE_THICKNESS_CELLS / points as f64;
        let expected = 0.25 * PI * (1.0 + thickness * (0.237 + 0.505 * (1.0 / thickness).ln()));
        assert!((found / expected - 1.0).abs() < 0.03, "{points} points a length: {found} against {expected}");
    }
}

/// Power and force that the stations exchange are those of the markers; the pressure jump along the beam adds up to the
/// force on it.
#[test]
fn loads_and_pressure_jump_add_up_to_the_force() {
    let mut fluid = line(4.0, 24, "");
    for k in 0..20 {
        let turn = 0.02 * f64::from(k);
        step(&mut fluid, 1e-3, |s| [turn + 0.3 * s, 0.1]);
    }
    let announced = fluid.loads()[0].clone();
    let sum: f64 = announced.force[0].iter().sum();
    assert!(announced.impedance.iter().all(|z| *z > 0.0), "{:?}", announced.impedance);
    let velocity = fluid.stations()[0].velocity.clone();
    let target = |s: f64| {
        let k = (s * 40.0).round() as usize;
        [velocity[0][k], velocity[1][k]]
    };
    step(&mut fluid, 1e-3, target);
    let exchanged = fluid.exchange()[0];
    // The stations kept their velocities, so the loads came true but for the change of the flow beside them.
    assert!((exchanged.force[0] / sum - 1.0).abs() < 2e-2, "{} against {sum}", exchanged.force[0]);
    let force = fluid.force_on_beam(0).force[0];
    let jump = fluid.pressure_jump()[0].clone();
    let along: f64 = (0..40).map(|k| 0.5 * (jump[k] + jump[k + 1]) / 40.0).sum();
    // The left-hand normal of a beam along y is −x.
    assert!((along / force - 1.0).abs() < 3e-2, "jump {along} against force {force}");
}

/// Lines of two beams, on two threads and from a saved state, have the same bits as alone.
#[test]
fn threads_and_states_change_no_bit() {
    let start = |threads: &str| {
        let mut fluid = line(4.0, 24, &format!(r#", "threads": {threads}, "initial_velocity": [0.5, 0.2]"#));
        (0..5).for_each(|_| step(&mut fluid, 1e-3, |s| [0.1 * s, 0.0]));
        fluid
    };
    let (mut one, mut two) = (start("1"), start("2"));
    let state = one.state();
    let mut results = Vec::new();
    for fluid in [&mut one, &mut two] {
        (0..5).for_each(|_| step(fluid, 1e-3, |s| [0.3 * s, 0.1]));
        results.push((fluid.loads()[0].clone(), fluid.vorticity().into_owned(), fluid.pressure_jump()[0].clone()));
    }
    assert!(results[0] == results[1], "threads");
    let stations: Stations = {
        one.restore(&state).unwrap();
        one.stations()[0].clone()
    };
    assert_eq!(stations.len(), 41);
    (0..5).for_each(|_| step(&mut one, 1e-3, |s| [0.3 * s, 0.1]));
    assert!((one.loads()[0].clone(), one.vorticity().into_owned()) == (results[0].0.clone(), results[0].1.clone()));
}

/// The legs of a hairpin, half a cell apart, share grid points: their system has a solution too.
#[test]
fn a_hairpin_has_finite_loads() {
    let mut fluid = line(4.0, 24, r#", "initial_velocity": [1, 0]"#);
    let stations = &mut fluid.stations_mut()[0];
    for k in 0..41 {
        stations.position[0][k] = 0.01 + 0.01 * (k as f64 - 19.0).clamp(0.0, 2.0);
        stations.position[1][k] = -0.5 + 0.025 * (20.0 - (k as f64 - 20.0).abs()).min(19.0);
    }
    run(&mut fluid, 3, 1e-3);
    let loads = &fluid.loads()[0].force;
    assert!(loads.iter().flatten().all(|force| force.abs() < 1e4), "{loads:?}");
}
