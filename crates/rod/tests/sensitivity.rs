//! Derivatives of a step by its loads.

mod common;

use common::{SCHEMES, turek_hron_bar, unit_rod};
use nervure_rod::{Error, Loads, Parameters, Rod};

/// Central differences of a step from the state that `rod` is in, in the direction of `change`.
fn differences<const D: usize>(rod: &Rod<D>, change: &Loads, h: f64) -> [Vec<f64>; 2] {
    let end = |part: f64| {
        let mut other = Rod::new(rod.parameters().clone()).unwrap();
        other.root = rod.root;
        other.restore(rod.state()).unwrap();
        let sum = |base: &[f64], change: &[f64]| base.iter().zip(change).map(|(b, c)| b + part * c).collect();
        other.loads = Loads {
            force: sum(&rod.loads.force, &change.force),
            pressure_jump: sum(&rod.loads.pressure_jump, &change.pressure_jump),
            impedance: sum(&rod.loads.impedance, &change.impedance),
            ..rod.loads.clone()
        };
        other.step(h).unwrap();
        let all = |get: fn(&Rod<D>, usize) -> &[f64]| (0..D).flat_map(|d| get(&other, d).to_vec()).collect::<Vec<_>>();
        [all(Rod::positions), all(Rod::velocities)]
    };
    let step = 1e-4;
    let ([x_up, v_up], [x_down, v_down]) = (end(step), end(-step));
    let slope = |up: Vec<f64>, down: Vec<f64>| up.iter().zip(down).map(|(u, d)| (u - d) / (2.0 * step)).collect();
    [slope(x_up, x_down), slope(v_up, v_down)]
}

fn assert_agrees<const D: usize>(rod: &mut Rod<D>, change: &Loads, h: f64, name: &str) {
    let [x, v] = differences(rod, change, h);
    rod.step(h).unwrap();
    let found = rod.sensitivity(change).unwrap();
    for (what, found, expected) in [("positions", &found.positions, x), ("velocities", &found.velocities, v)] {
        let scale = expected.iter().fold(0.0_f64, |largest, e| largest.max(e.abs()));
        assert!(scale > 0.0, "{name}: {what} do not change");
        for (k, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!((found - expected).abs() < 1e-5 * scale, "{name}, {what}[{k}]: {found} against {expected}");
        }
    }
}

#[test]
fn sensitivity_is_the_derivative_of_the_step_in_the_plane() {
    let nodes = 17;
    let wave = |phase: f64, count: usize| (0..count).map(|k| (phase + k as f64).sin()).collect::<Vec<f64>>();
    for scheme in SCHEMES {
        let damping = 3.0;
        let mut rod = Rod::new(Parameters { scheme, damping, ..turek_hron_bar(1.4e6, 2.0, nodes - 1) }).unwrap();
        rod.loads = Loads {
            force: wave(0.3, 2 * nodes).iter().map(|f| 3.0 * f).collect(),
            pressure_jump: vec![200.0; nodes],
            impedance: vec![20.0; nodes],
            ..Loads::default()
        };
        (0..20).for_each(|_| rod.step(4e-3).unwrap());
        let none = Loads {
            force: vec![0.0; 2 * nodes],
            pressure_jump: vec![0.0; nodes],
            impedance: vec![0.0; nodes],
            ..Loads::default()
        };
        for (name, change) in [
            ("force", Loads { force: wave(1.0, 2 * nodes), ..none.clone() }),
            ("pressure jump", Loads { pressure_jump: wave(2.0, nodes), ..none.clone() }),
            ("impedance", Loads { impedance: wave(0.7, nodes), ..none.clone() }),
        ] {
            assert_agrees(&mut rod, &change, 5e-3, &format!("{scheme:?}, {name}"));
        }
    }
}

#[test]
fn sensitivity_is_the_derivative_of_the_step_in_space() {
    for scheme in SCHEMES {
        let mut rod = Rod::new(Parameters { gravity: [0.0, -2.0, 1.0], ..unit_rod::<3>(12, 1e3, scheme) }).unwrap();
        rod.loads.force = vec![0.0; 3 * 13];
        (0..20).for_each(|_| rod.step(2e-2).unwrap());
        let force = (0..3 * 13).map(|k| (0.5 + f64::from(k)).cos()).collect();
        assert_agrees(&mut rod, &Loads { force, ..Loads::default() }, 2e-2, &format!("{scheme:?}"));
    }
}

#[test]
fn sensitivity_needs_a_step_in_one_piece() {
    let mut rod = Rod::new(Parameters { max_step: Some(1e-3), ..turek_hron_bar(1.4e6, 2.0, 8) }).unwrap();
    let change = Loads { force: vec![1.0; 18], ..Loads::default() };
    let substeps = |result: Result<_, Error>| match result {
        Err(Error::NoSensitivity { substeps }) => substeps,
        other => panic!("{other:?}"),
    };
    assert_eq!(substeps(rod.sensitivity(&change)), 0);
    rod.step(1e-3).unwrap();
    rod.sensitivity(&change).unwrap();
    rod.step(2e-3).unwrap();
    assert_eq!(substeps(rod.sensitivity(&change)), 2);
    rod.restore(&rod.state().clone()).unwrap();
    assert_eq!(substeps(rod.sensitivity(&change)), 0);
}
