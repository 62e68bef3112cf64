//! Several beams in one fluid: each has its own cells, loads and force, and together they take what the fluid loses.

use nervure_fluid::Fluid;
use scene::{NamedRod, Scene};

use crate::common::{fluid_of, run, scene};

/// Beams of other lengths one above the other in a stream, as the parts of `rods`.
fn beams(order: [usize; 2]) -> Scene {
    let beam = |name: &str, y: f64, length: f64, segments: usize| {
        format!(
            r#"{{ "name": "{name}", "beam": {{ "root": {{ "at": {{ "position": [-0.2, {y}], "direction": [1, 0.1] }} }},
                "length": {length}, "thickness": 0.06, "segments": {segments} }},
            "rod": {{ "material": {{ "section": {{ "line_density": 200, "bending_stiffness": 1,
                "axial_stiffness": 1e4 }} }} }} }}"#
        )
    };
    let both = [beam("upper", 0.12, 0.3, 8), beam("lower", -0.1, 0.4, 6)];
    scene(
        r#""kinematic_viscosity": 1e-3, "box": { "x": [-0.6, 0.6], "y": [-0.3, 0.3], "cells": [72, 36] },
        "initial_velocity": [0.5, 0.1]"#,
        &format!(r#", "rods": [{}, {}]"#, both[order[0]], both[order[1]]),
    )
}

/// The beams after some steps in which beam `lifted` goes up at 0.1 m/s.
fn advanced(order: [usize; 2], lifted: Option<usize>) -> Fluid {
    let (mut fluid, h) = (fluid_of(&beams(order)), 2e-3);
    for _ in 0..20 {
        if let Some(k) = lifted {
            let stations = &mut fluid.stations_mut()[k];
            stations.velocity[1].fill(0.1);
            stations.position[1].iter_mut().for_each(|y| *y += 0.1 * h);
        }
        run(&mut fluid, 1, h);
    }
    fluid
}

/// What the fluid loses of its momentum in a step of backward differences is the drag on both beams, to rounding.
#[test]
fn both_beams_get_the_momentum_that_the_fluid_loses() {
    let (mut fluid, h) = (fluid_of(&beams([0, 1])), 2e-3);
    let momentum = |fluid: &Fluid| {
        [0, 1].map(|axis| 1000.0 * fluid.grid().cell_volume() * fluid.velocity(axis).iter().sum::<f64>())
    };
    run(&mut fluid, 5, h);
    let first = momentum(&fluid);
    run(&mut fluid, 1, h);
    let second = momentum(&fluid);
    run(&mut fluid, 1, h);
    let third = momentum(&fluid);
    for axis in 0..2 {
        let lost = -(1.5 * third[axis] - 2.0 * second[axis] + 0.5 * first[axis]) / h;
        let parts = [0, 1].map(|beam| fluid.force_on_flexible(beam).force[axis]);
        let sum = parts[0] + parts[1];
        assert!((sum / lost - 1.0).abs() < 1e-9, "axis {axis}: drag {parts:?} N/m, momentum lost {lost}");
        assert!(parts.iter().all(|part| part / sum > 0.1), "axis {axis}: {parts:?}");
        assert_eq!(fluid.force()[axis], sum);
    }
}

/// The order in which a scene lists them is that of the numbers, and nothing else.
#[test]
fn beams_keep_what_is_theirs_in_another_order() {
    let (one, other) = (advanced([0, 1], Some(0)), advanced([1, 0], Some(1)));
    for (k, j) in [(0, 1), (1, 0)] {
        let close = |what: &str, a: f64, b: f64| {
            assert!((a - b).abs() <= 1e-9 * a.abs().max(1e-3), "{what} of beam {k}: {a} against {b}");
        };
        let (a, b) = (one.exchange()[k], other.exchange()[j]);
        close("power", a.power, b.power);
        close("work", a.work, b.work);
        let sum = |fluid: &Fluid, k: usize| fluid.loads()[k].force[1].iter().sum::<f64>();
        close("load", sum(&one, k), sum(&other, j));
        assert_eq!(one.loads()[k].impedance.len(), one.stations()[k].len());
        close("moment", one.force_on_flexible(k).moment, other.force_on_flexible(j).moment);
    }
    assert!(one.exchange()[0].work != 0.0, "the lifted beam does work");
    assert_eq!(one.exchange()[1].work, 0.0, "the still one does none");
}

/// Each beam has a pressure jump of its own, the same in another order.
#[test]
fn pressure_jump_is_that_of_each_beam() {
    let mut fluid = advanced([0, 1], Some(0));
    let lengths: Vec<_> = fluid.pressure_jump().iter().map(Vec::len).collect();
    assert_eq!(lengths, [9, 7]);
    let mut turned = advanced([1, 0], Some(1));
    let (jumps, others) = (fluid.pressure_jump().to_vec(), turned.pressure_jump().to_vec());
    for (jump, other) in jumps.iter().zip(others.iter().rev()) {
        let largest = jump.iter().fold(0.0_f64, |most, p| most.max(p.abs()));
        let apart = jump.iter().zip(other).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(largest > 1.0 && apart < 1e-9 * largest, "{apart} of {largest} Pa");
    }
}

/// A state holds all beams, and fits no fluid with fewer.
#[test]
fn state_holds_all_beams() {
    let mut fluid = advanced([0, 1], Some(1));
    let state = fluid.state();
    let then = fluid.loads().to_vec();
    run(&mut fluid, 3, 2e-3);
    fluid.restore(&state).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(fluid.loads(), then);
    assert_eq!(fluid.state(), state);

    let mut fewer = beams([0, 1]);
    let NamedRod { beam, rod, .. } = fewer.rods.remove(0);
    fewer.rods.clear();
    (fewer.beam, fewer.rod) = (Some(beam), Some(rod));
    let refused = fluid_of(&fewer).restore(&state).unwrap_err().to_string();
    assert!(refused.contains("the list of bodies of the state"), "{refused}");
    let refused = fluid_of(&beams([1, 0])).restore(&state).unwrap_err().to_string();
    assert!(refused.contains("the list of stations of the state"), "{refused}");
}

/// A wrong station is said with its beam.
#[test]
fn a_wrong_station_names_its_beam() {
    let mut fluid = fluid_of(&beams([0, 1]));
    fluid.stations_mut()[1].position[0][3] = f64::NAN;
    let refused = fluid.advance(0.0, 2e-3).unwrap_err().to_string();
    assert!(refused.contains("station 4 of beam 2 is at (NaN"), "{refused}");
}
