//! Single stations: position, effect of load and impedance, and reaction at the root.

use nervure_rod::{BaseMotion, Parameters, Rod, Scheme};

use crate::common::unit_rod;

const SEGMENTS: usize = 8;
const NODES: usize = SEGMENTS + 1;

/// Return irregular numbers between −1 and 1.
fn numbers(seed: f64) -> Vec<f64> {
    (0..2 * NODES).map(|i| (seed + 7.3 * i as f64).sin()).collect()
}

fn rod() -> Rod<2> {
    Rod::new(unit_rod(SEGMENTS, 100.0, Scheme::Bdf2)).unwrap()
}

#[test]
fn stations_lie_along_the_direction_of_the_root() {
    let parameters = unit_rod::<2>(SEGMENTS, 100.0, Scheme::Bdf2);
    let rod = Rod::new(Parameters { attachment: [3.0, -2.0], direction: [6.0, 8.0], ..parameters }).unwrap();
    for k in 0..NODES {
        let s = k as f64 / SEGMENTS as f64;
        let [x, y] = [0, 1].map(|d| rod.positions(d)[k]);
        assert!((x - (3.0 + 0.6 * s)).abs() < 1e-15 && (y - (-2.0 + 0.8 * s)).abs() < 1e-15, "{k}: ({x}, {y})");
    }
}

/// A load with impedance has the effect of the force f − D (v − v_before), with v at the end of the step.
#[test]
fn impedance_of_each_station_is_a_force_against_its_own_change_of_velocity() {
    let impedance: Vec<_> = numbers(0.4)[..NODES].iter().map(|d| 2.0 * d.abs()).collect();
    let mut with = rod();
    with.loads.force = numbers(0.1);
    with.loads.impedance = vec![0.0; NODES];
    (0..3).for_each(|_| with.step(0.02).unwrap());
    let mut without = rod();
    without.restore(with.state()).unwrap();
    let before: Vec<_> = (0..2).flat_map(|d| with.velocities(d).to_vec()).collect();

    with.loads.impedance.clone_from(&impedance);
    with.step(0.02).unwrap();
    without.loads.force = (0..2 * NODES)
        .map(|i| {
            let v = with.velocities(i / NODES)[i % NODES];
            with.loads.force[i] - impedance[i % NODES] * (v - before[i])
        })
        .collect();
    without.step(0.02).unwrap();
    for d in 0..2 {
        for k in 0..NODES {
            let [found, expected] = [&with, &without].map(|rod| rod.velocities(d)[k]);
            assert!((found - expected).abs() < 1e-9, "component {d} of station {k}: {found} against {expected}");
        }
    }
    let sum = |rod: &Rod<2>| rod.state().exchange.force;
    let difference = (sum(&with) - sum(&without)).norm();
    assert!(difference < 1e-9, "loads taken: {} against {}", sum(&with), sum(&without));
}

/// In equilibrium the reaction balances the loads of all stations: F = −Σ f_k and M = −Σ (x_k − x_0) × f_k.
#[test]
fn moment_at_the_root_is_that_of_each_stations_load() {
    for loaded in 1..NODES {
        for d in 0..2 {
            let mut rod = rod();
            let &Parameters { attachment: position, direction, .. } = rod.parameters();
            rod.base_motion = Some(BaseMotion { position, velocity: [0.0; 2], direction, direction_rate: [0.0; 2] });
            rod.loads.force = vec![0.0; 2 * NODES];
            rod.loads.force[d * NODES + loaded] = 0.5;
            rod.solve_static().unwrap();
            rod.step(1e-3).unwrap();
            let [x, y] = [0, 1].map(|d| rod.positions(d)[loaded] - rod.positions(d)[0]);
            let expected = -0.5 * if d == 0 { -y } else { x };
            let drive = rod.state().drive;
            assert!(
                (drive.moment[2] - expected).abs() < 1e-9,
                "station {loaded}, {d}: {} N m against {expected}",
                drive.moment[2]
            );
            assert!((drive.force[d] + 0.5).abs() < 1e-9 && drive.force[1 - d].abs() < 1e-9, "{}", drive.force);
        }
    }
}
