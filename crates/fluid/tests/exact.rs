//! Exact solutions and invariants.

use std::f64::consts::{PI, TAU};

use fluid::Fluid;
use fluid::fft::Fft2;
use scene::{Mask, Scene};

/// A scene from the parts of its fluid and what else it has.
fn scene(fluid: &str, rest: &str) -> Scene {
    let text = format!(
        r#"{{ "name": "test", "time": {{ "end": 1.0, "communication_step": 0.01 }}, "fluid": {{
            "density": 1000.0, "time_stepping": {{ "max_step": 1.0, "max_cfl": 1.0 }},
            "mask": {{ "cosine": {{ "c_eta": 1e-4, "half_width": 1.0 }} }}, {fluid} }} {rest} }}"#
    );
    Scene::from_json(&text).unwrap_or_else(|e| panic!("{e}"))
}

const CYLINDER_IN_CHANNEL: &str = r#"
    "kinematic_viscosity": 1e-3,
    "box": { "x": [-0.4, 1.2], "y": [-0.1, 0.5], "cells": [96, 36] },
    "channel": { "y": [0.0, 0.41] },
    "inflow": { "x": [-0.4, 0.0], "profile": "parabolic", "c_eta": 1e-3,
                "mean_velocity": { "cosine_ramp": { "value": 1.0, "duration": 0.1 } } },
    "cylinders": [{ "center": [0.2, 0.2], "radius": 0.05 }]"#;

const FREE_BEAM: &str = r#", "beam": { "root": { "at": { "position": [0.4, 0.2], "direction": [1, 0] } },
    "length": 0.35, "thickness": 0.05, "segments": 12 }"#;

const BEAM: &str = r#", "beam": { "root": { "on_cylinder": { "cylinder": 0 } }, "length": 0.35, "thickness": 0.05,
    "segments": 12 }"#;

fn run(fluid: &mut Fluid, steps: usize, h: f64) {
    for step in 0..steps {
        let t = fluid.time();
        fluid.advance(t, h).unwrap_or_else(|e| panic!("step {step}: {e}"));
    }
}

/// Largest error of the Taylor–Green vortex on 16 x 24 points at t = 1 s with `steps` steps.
fn taylor_green_error(steps: usize) -> f64 {
    let nu = 0.05;
    let vortex = |x: f64, y: f64| [x.sin() * y.cos(), -x.cos() * y.sin()];
    let text =
        format!(r#""kinematic_viscosity": {nu}, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [16, 24] }}"#);
    let mut fluid = Fluid::new(&scene(&text, "")).unwrap_or_else(|e| panic!("{e}"));
    fluid.set_velocity(vortex);
    run(&mut fluid, steps, 1.0 / steps as f64);
    let decay = (-2.0 * nu * fluid.time()).exp();
    let grid = *fluid.grid();
    let mut largest = 0.0_f64;
    for axis in 0..2 {
        for (c, value) in fluid.velocity(axis).iter().enumerate() {
            let exact = decay * vortex(grid.x(c / grid.ny), grid.y(c % grid.ny))[axis];
            largest = largest.max((value - exact).abs());
        }
    }
    largest
}

#[test]
fn the_taylor_green_vortex_decays_with_second_order_in_time() {
    let [coarse, fine] = [80, 160].map(taylor_green_error);
    let order = (coarse / fine).log2();
    assert!(fine < 3e-7, "error {fine} with 160 steps");
    assert!((order - 2.0).abs() < 0.1, "order {order}: errors {coarse} and {fine}");
}

#[test]
fn a_scene_without_bodies_has_no_force_and_no_beam() {
    let text = r#""kinematic_viscosity": 1e-3, "box": { "x": [0, 1], "y": [0, 1], "cells": [8, 8] },
        "initial_velocity": [0.3, -0.2]"#;
    let mut fluid = Fluid::new(&scene(text, "")).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 3, 0.01);
    assert_eq!(fluid.force(), [0.0; 2]);
    assert!(fluid.loads().is_none() && fluid.stations().is_none() && fluid.pressure_jump().is_none());
    for (axis, expected) in [0.3, -0.2].into_iter().enumerate() {
        let worst = fluid.velocity(axis).iter().map(|u| (u - expected).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-15, "a uniform flow changed by {worst} m/s");
    }
}

#[test]
fn the_velocity_is_divergence_free_around_bodies() {
    let mut fluid = Fluid::new(&scene(CYLINDER_IN_CHANNEL, BEAM)).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 60, 2e-3);
    let grid = *fluid.grid();
    let fft = Fft2::new(grid.nx, grid.ny, grid.ny / 2 + 1);
    let (mut spectra, mut scratch) = ([fft.spectrum(), fft.spectrum()], fft.scratch());
    for (axis, spectrum) in spectra.iter_mut().enumerate() {
        fft.forward(fluid.velocity(axis), spectrum, &mut scratch);
    }
    let (mut divergence, mut gradient) = (0.0_f64, 0.0_f64);
    for j in 0..=grid.ny / 2 {
        for i in 0..grid.nx {
            let signed = if 2 * i > grid.nx { i as f64 - grid.nx as f64 } else { i as f64 };
            let (kx, ky) = (TAU / grid.length * signed, TAU / grid.height * j as f64);
            let [u, v] = [0, 1].map(|axis| fft.mode(&spectra[axis], i, j));
            divergence = divergence.max((u * kx + v * ky).norm());
            gradient = gradient.max((u * ky).norm());
        }
    }
    assert!(divergence < 1e-13 * gradient, "divergence {divergence} beside gradients of {gradient}");
}

#[test]
fn the_inflow_zone_sets_the_flow_rate() {
    let mut fluid = Fluid::new(&scene(CYLINDER_IN_CHANNEL, "")).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 200, 2e-3);
    let (rate, nominal) = (fluid.diagnostics().flow_rate, 0.41);
    assert!((rate / nominal - 1.0).abs() < 5e-3, "{rate} m²/s against {nominal}");
}

/// The pressure gradient of plane Poiseuille flow, from a channel with its own drive: dp/dx = −12 rho nu U / H².
#[test]
fn poiseuille_flow_has_its_pressure_drop() {
    let text = r#""kinematic_viscosity": 0.02, "box": { "x": [-0.4, 1.6], "y": [-0.1, 0.5], "cells": [64, 96] },
        "channel": { "y": [0.0, 0.41] },
        "inflow": { "x": [-0.4, 0.0], "profile": "parabolic", "mean_velocity": { "steady": 1.0 }, "c_eta": 1e-3 }"#;
    let mut fluid = Fluid::new(&scene(text, "")).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 1500, 1e-3);
    let (grid, pressure) = (*fluid.grid(), fluid.pressure());
    let at = |x: f64| -> f64 { grid.interpolation([x, 0.205]).iter().map(|&(c, w)| w * pressure[c]).sum() };
    let (drop, exact) = ((at(1.0) - at(0.5)) / 0.5, -12.0 * 1000.0 * 0.02 / 0.41_f64.powi(2));
    assert!((drop / exact - 1.0).abs() < 0.01, "dp/dx = {drop} Pa/m against {exact}");
}

/// Stokes (1851): a cylinder of radius a that oscillates in a still fluid carries the displaced mass times
/// 1 + 2 delta/a, delta = √(2 nu/omega), as added mass; in a lattice of cylinders with the share phi of the area,
/// potential flow raises the 1 to (1 + phi)/(1 − phi).
#[test]
fn an_oscillating_cylinder_feels_its_added_mass() {
    let (radius, amplitude, frequency, nu) = (0.1, 0.002, 5.0, 1e-3);
    let text = format!(
        r#""kinematic_viscosity": {nu}, "box": {{ "x": [-1, 1], "y": [-1, 1], "cells": [256, 256] }},
        "cylinders": [{{ "center": [0.0, 0.0], "radius": {radius}, "motion":
            {{ "x": {{ "sine": {{ "amplitude": {amplitude}, "frequency": {frequency} }} }} }} }}]"#
    );
    let mut fluid = Fluid::new(&scene(&text, "")).unwrap_or_else(|e| panic!("{e}"));
    let (h, omega, per_period) = (1e-3, TAU * frequency, 200);
    run(&mut fluid, 2 * per_period, h);
    // The part of the force in phase with the displacement: F = −m_a x'' = m_a omega² x.
    let mut in_phase = 0.0;
    for _ in 0..per_period {
        run(&mut fluid, 1, h);
        in_phase += 2.0 / per_period as f64 * fluid.force()[0] * (omega * (fluid.time() - 0.5 * h)).sin();
    }
    let coefficient = in_phase / (amplitude * omega * omega) / (1000.0 * PI * radius * radius);
    let (layer, phi) = ((2.0 * nu / omega).sqrt() / radius, PI * radius * radius / 4.0);
    let expected = (1.0 + phi) / (1.0 - phi) + 2.0 * layer;
    assert!(
        (coefficient / expected - 1.0).abs() < 0.03,
        "added mass {coefficient} against {expected} displaced masses"
    );
}

#[test]
fn a_restored_state_continues_bit_by_bit() {
    let scene = scene(CYLINDER_IN_CHANNEL, BEAM);
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    let shake = |fluid: &mut Fluid, step: usize| {
        let phase = step as f64;
        let stations = fluid.stations_mut().expect("the scene has a beam");
        for k in 1..stations.len() {
            stations.velocity[1][k] = 0.01 * k as f64 * phase.sin();
            stations.position[1][k] += 2e-3 * stations.velocity[1][k];
        }
    };
    for step in 0..10 {
        shake(&mut fluid, step);
        run(&mut fluid, 1, 2e-3);
    }
    let saved = fluid.state().clone();
    let mut other = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    other.restore(&saved);
    for fluid in [&mut fluid, &mut other] {
        for step in 10..20 {
            shake(fluid, step);
            run(fluid, 1, if step < 15 { 2e-3 } else { 1e-3 });
        }
    }
    assert!(fluid.state() == other.state(), "the states differ after ten steps");
    assert_eq!(fluid.pressure_jump(), other.pressure_jump());
}

/// The load that is announced is the one that the fluid then exerts, less the impedance times the change of velocity.
#[test]
fn announced_loads_are_exerted() {
    let masks = [
        Mask::Sharp { c_eta: 1e-4 },
        Mask::Cosine { c_eta: 1e-4, half_width: 1.0 },
        Mask::LogLinear { c_eta: 1e-5, e_fold: 0.2, reflect: true },
    ];
    for mask in masks {
        let mut scene = scene(CYLINDER_IN_CHANNEL, FREE_BEAM);
        let parts = (scene.fluid.as_mut(), scene.beam.as_mut());
        let (fluid, beam) = (parts.0.expect("it has one"), parts.1.expect("it has one"));
        (fluid.mask, beam.thickness) = (mask, 0.08);
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        run(&mut fluid, 50, 2e-3);
        let sum = |values: &[f64]| values.iter().sum::<f64>();
        let impedance = sum(&fluid.loads().expect("the scene has a beam").impedance);
        let mut still = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        still.restore(&fluid.state().clone());
        run(&mut still, 1, 2e-3);
        let changes = [3e-3, -2e-3];
        let stations = fluid.stations_mut().expect("the scene has a beam");
        (0..2).for_each(|axis| stations.velocity[axis].fill(changes[axis]));
        run(&mut fluid, 1, 2e-3);
        let displaced = 1000.0 * 0.08 * 0.35;
        for (axis, change) in changes.into_iter().enumerate() {
            // The unsteady term of the reported force is the displaced mass times the change of velocity.
            let exerted = fluid.force()[axis] - still.force()[axis] - displaced * change / 2e-3;
            let announced = -impedance * change;
            assert!(
                (exerted / announced - 1.0).abs() < 1e-9,
                "{mask:?}, axis {axis}: {exerted} N/m against {announced}"
            );
        }
    }
}

#[test]
fn a_step_allocates_nothing() {
    let mut fluid = Fluid::new(&scene(CYLINDER_IN_CHANNEL, BEAM)).unwrap_or_else(|e| panic!("{e}"));
    let swing = |fluid: &mut Fluid, step: usize| {
        let stations = fluid.stations_mut().expect("the scene has a beam");
        for k in 1..stations.len() {
            stations.position[1][k] = 0.2 + 0.002 * k as f64 * (0.3 * step as f64).sin();
        }
        run(fluid, 1, 2e-3);
    };
    // One swing lets every list grow to what it needs.
    (0..21).for_each(|step| swing(&mut fluid, step));
    let counted = allocation_counter::measure(|| (21..42).for_each(|step| swing(&mut fluid, step)));
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

#[test]
fn a_fluid_takes_less_than_25_fields() {
    let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
    scene.fluid.as_mut().expect("it has one").domain.cells = [320, 120];
    let counted = allocation_counter::measure(|| {
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        run(&mut fluid, 2, 1e-3);
        fluid.pressure_jump();
    });
    let fields = counted.bytes_max as f64 / (8.0 * 320.0 * 120.0);
    println!("{fields:.1} arrays of the grid's size at most");
    assert!(fields < 25.0, "{fields} arrays of the grid's size");
}

#[test]
fn threads_change_no_bit() {
    let [one, two, many] = [1, 2, 5].map(|threads| {
        let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
        let fluid = scene.fluid.as_mut().expect("it has one");
        // Blocks of columns that overlap, rows that do not come out even.
        (fluid.domain.cells, fluid.threads) = ([99, 39], threads);
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        run(&mut fluid, 20, 2e-3);
        fluid
    });
    assert!(one.state() == two.state(), "two threads give other bits than one");
    assert!(one.state() == many.state(), "five threads give other bits than one");
}

#[test]
fn bad_steps_and_stations_are_refused_and_change_nothing() {
    let mut fluid = Fluid::new(&scene(CYLINDER_IN_CHANNEL, BEAM)).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 2, 2e-3);
    let before = fluid.state().clone();
    for h in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let error = fluid.advance(4e-3, h).expect_err("such a step is no step").to_string();
        assert!(error.contains("above 0"), "{error}");
    }
    fluid.stations_mut().expect("the scene has a beam").position[1][3] = f64::NAN;
    let error = fluid.advance(4e-3, 1e-3).expect_err("NaN is nowhere").to_string();
    assert!(error.contains("station 4"), "{error}");
    assert!(fluid.state() == &before, "a refused step changed the state");
}

#[test]
fn divergence_is_an_error_with_the_time() {
    let text =
        r#""kinematic_viscosity": 1e-6, "box": { "x": [0, 1], "y": [0, 1], "cells": [16, 16] }, "filter": "none""#;
    let mut scene = scene(text, "");
    scene.fluid.as_mut().expect("it has one").time_stepping.max_cfl = 1e9;
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    fluid.set_velocity(|x, y| [10.0 * (TAU * y).sin() + (3.0 * TAU * x).cos(), 7.0 * (2.0 * TAU * x).cos()]);
    let error = (0..10_000).find_map(|step| fluid.advance(0.5 * step as f64, 0.5).err());
    let error = error.expect("CFL numbers of a hundred cannot be stable").to_string();
    assert!(error.contains("diverged at t ="), "{error}");
}
