//! Single precision: as exact as seven digits allow, without drift, and told apart from double precision.

use std::f64::consts::TAU;

use nervure_fluid::{Error, Fluid, State};
use scene::{Precision, Scene, TimeScheme};

use crate::common::{fluid_of, run, scene};

/// A closed channel with a cylinder and a beam behind it.
const CYLINDER_AND_BEAM: &str = r#"
    "kinematic_viscosity": 1e-3,
    "box": { "x": [-0.4, 1.2], "y": [-0.1, 0.5], "cells": [96, 36] },
    "channel": { "y": [0.0, 0.41] },
    "inflow": { "x": [-0.4, 0.0], "profile": "parabolic", "c_eta": 1e-3,
                "mean_velocity": { "cosine_ramp": { "value": 1.0, "duration": 0.1 } } },
    "cylinders": [{ "center": [0.2, 0.2], "radius": 0.05 }]"#;
const BEAM: &str =
    r#", "beam": { "root": { "on_cylinder": { "cylinder": 0 } }, "length": 0.35, "thickness": 0.06, "segments": 8 }"#;

fn fluid(mut scene: Scene, precision: Precision) -> Fluid {
    scene.fluid.as_mut().expect("it has one").precision = precision;
    fluid_of(&scene)
}

fn both(scene: &Scene) -> [Fluid; 2] {
    [Precision::Double, Precision::Single].map(|precision| fluid(scene.clone(), precision))
}

/// The Taylor–Green vortex in both schemes over a thousand steps. On these lengths the rounded roots of unity take
/// 1.4e-7 of it in a step, unless the projection puts that back.
#[test]
fn the_taylor_green_vortex_decays_as_it_should() {
    let vortex = |x: f64, y: f64| [x.sin() * y.cos(), -x.cos() * y.sin()];
    for scheme in [TimeScheme::Sbdf2, TimeScheme::Rk2] {
        let text =
            format!(r#""kinematic_viscosity": 0.05, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [32, 24] }}"#);
        let mut scene = scene(&text, "");
        scene.fluid.as_mut().expect("it has one").time_stepping.scheme = scheme;
        let mut fluid = fluid(scene, Precision::Single);
        fluid.set_velocity(|[x, y]| vortex(x, y));
        run(&mut fluid, 1000, 2e-3);
        let decay = (-2.0 * 0.05 * fluid.time()).exp();
        let (grid, mut squares) = (*fluid.grid(), 0.0);
        for axis in 0..2 {
            for (c, value) in fluid.velocity(axis).iter().enumerate() {
                let exact =
                    decay * vortex(grid.coordinate(0, c / grid.cells[1]), grid.coordinate(1, c % grid.cells[1]))[axis];
                squares += (value - exact).powi(2);
            }
        }
        // The vortex itself has the squares of ½ in the mean.
        let error = (2.0 * squares / grid.len() as f64).sqrt() / decay;
        assert!(error < 3e-5, "{scheme:?}: relative error {error}");
        let divergence = fluid.divergence();
        assert!(divergence < 3e-6, "{scheme:?}: divergence {divergence}");
    }
}

/// What is lost or won in a step, however little, would be seen after so many: the mean flow, and a wave without
/// viscosity. That falls by 4e-9 in a step, which is what the rounded roots of unity of the transforms make; a rounded
/// factor between them would make up to 6e-8.
#[test]
fn nothing_drifts_in_thirty_thousand_steps() {
    for scheme in [TimeScheme::Sbdf2, TimeScheme::Rk2] {
        let text = r#""kinematic_viscosity": 1e-12, "box": { "x": [0, 1.0], "y": [0, 0.7], "cells": [26, 22] },
            "initial_velocity": [0.3, -0.1]"#;
        let mut scene = scene(text, "");
        scene.fluid.as_mut().expect("it has one").time_stepping.scheme = scheme;
        let mut fluid = fluid(scene, Precision::Single);
        fluid.set_velocity(|[_, y]| [0.3 + 0.1 * (TAU * y / 0.7).sin(), 0.0]);
        run(&mut fluid, 30_000, 1e-3);
        let grid = *fluid.grid();
        let mean = fluid.velocity(0).iter().sum::<f64>() / grid.len() as f64;
        let sine = |c: usize| (TAU * grid.coordinate(1, c % grid.cells[1]) / 0.7).sin();
        let wave =
            fluid.velocity(0).iter().enumerate().map(|(c, u)| 2.0 * u * sine(c)).sum::<f64>() / grid.len() as f64;
        assert!((mean / 0.3 - 1.0).abs() < 1e-5, "{scheme:?}: mean flow of {mean} m/s, not 0.3");
        assert!((wave / 0.1 - 1.0).abs() < 3e-4, "{scheme:?}: wave of {wave} m/s, not 0.1");
    }
}

#[test]
fn forces_loads_and_pressures_are_those_of_double_precision() {
    let [mut double, mut single] = both(&scene(CYLINDER_AND_BEAM, BEAM));
    for fluid in [&mut double, &mut single] {
        run(fluid, 100, 2e-3);
    }
    let near = |what: &str, found: &[f64], expected: &[f64], tolerance: f64| {
        let largest = expected.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let far = found.iter().zip(expected).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(far < tolerance * largest, "{what}: off by {far} beside {largest}");
        assert!(far > 0.0, "{what}: the precisions cannot be told apart");
    };
    for axis in 0..2 {
        near("velocity", &single.velocity(axis), &double.velocity(axis), 2e-5);
    }
    near("vorticity", &single.vorticity(0), &double.vorticity(0), 5e-5);
    near("pressure", &single.pressure(), &double.pressure(), 1e-4);
    near("force", &single.force(), &double.force(), 1e-4);
    let [found, expected] = [&single, &double].map(|fluid| &fluid.loads()[0]);
    near("load", &found.force.concat(), &expected.force.concat(), 1e-4);
    let jump = |fluid: &mut Fluid| fluid.pressure_jump()[0].clone();
    near("pressure jump", &jump(&mut single), &jump(&mut double), 1e-3);
    let [found, expected] = [&single, &double].map(|fluid| [fluid.kinetic_energy(), fluid.flow_rate()]);
    near("energy and flow rate", &found, &expected, 1e-6);
    let divergence = single.divergence();
    assert!(divergence < 1e-5, "divergence {divergence}");
}

#[test]
fn a_state_goes_back_to_the_same_bits_and_only_to_its_own_precision() {
    let mut fluids = both(&scene(CYLINDER_AND_BEAM, BEAM));
    let states = fluids.each_mut().map(|fluid| {
        run(fluid, 20, 2e-3);
        let state = fluid.state();
        run(fluid, 5, 2e-3);
        let later = fluid.state();
        fluid.restore(&state).unwrap_or_else(|e| panic!("{e}"));
        run(fluid, 5, 2e-3);
        assert!(fluid.state() == later, "another way after going back");
        state
    });
    let [double, single] = &mut fluids;
    for (fluid, state, named) in [
        (double, &states[1], ["the state is in single", "for double"]),
        (single, &states[0], ["is in double", "for single"]),
    ] {
        let before: State = fluid.state();
        let error = fluid.restore(state).expect_err("it is of the other precision");
        assert!(matches!(error, Error::Precision { .. }), "{error:?}");
        assert!(named.iter().all(|part| error.to_string().contains(part)), "{error}");
        assert!(fluid.state() == before, "a state that was refused changed something");
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let mut scene = scene(CYLINDER_AND_BEAM, BEAM);
    let states = [1, 2, 3].map(|threads| {
        let part = scene.fluid.as_mut().expect("it has one");
        // Large enough for three threads.
        (part.r#box.cells, part.threads) = (vec![1201, 201], threads);
        let mut fluid = fluid(scene.clone(), Precision::Single);
        run(&mut fluid, 8, 2e-4);
        fluid.state()
    });
    assert!(states[0] == states[1] && states[0] == states[2]);
}

#[test]
fn what_diverges_in_single_precision_says_so() {
    let mut scene = scene(CYLINDER_AND_BEAM, "");
    let fluid_part = scene.fluid.as_mut().expect("it has one");
    // A scene may not have this.
    (fluid_part.time_stepping.max_cfl, fluid_part.kinematic_viscosity) = (1e9, 1e-7);
    scene.time.communication_step = 0.1;
    let mut fluid = fluid(scene, Precision::Single);
    let error = (0..1000).find_map(|step| fluid.advance(0.1 * f64::from(step), 0.1).err()).expect("it diverges");
    assert!(matches!(error, Error::Diverged { .. }), "{error}");
    assert!(fluid.velocity(0).iter().all(|u| u.is_finite()));
}

#[test]
fn the_single_fluid_is_half_as_large() {
    let scene = scene(CYLINDER_AND_BEAM, BEAM);
    let [double, single] = both(&scene).map(|fluid| fluid.state_bytes());
    assert!((single as f64) < 0.55 * double as f64, "{single} of {double} bytes");
}
