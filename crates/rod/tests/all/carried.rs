//! What a rod announces to a body that carries it.

use nervure_rod::{BaseMotion, Parameters, Rod, RootSupport, Scheme, Section};

use crate::common::unit_rod;

const DT: f64 = 1e-2;

/// The root turns about z; `change` of its velocities at the end of the step moves it by two thirds of a step.
fn root(t: f64, change: &[f64; 6]) -> BaseMotion<3> {
    let (angle, omega) = (0.3 * t * t, 0.6 * t);
    let (sin, cos) = angle.sin_cos();
    let moved = |i: usize| change[i] * (DT / 1.5);
    // The turn by the small change, about z after the others.
    let turned = |[x, y, z]: [f64; 3], by: [f64; 3]| {
        [x + by[1] * z - by[2] * y, y + by[2] * x - by[0] * z, z + by[0] * y - by[1] * x]
    };
    let direction = turned([cos, sin, 0.0], [moved(3), moved(4), moved(5)]);
    let spin = [change[3], change[4], omega + change[5]];
    BaseMotion {
        position: [0, 1, 2].map(moved),
        velocity: [change[0], change[1], change[2]],
        direction,
        direction_rate: [
            spin[1] * direction[2] - spin[2] * direction[1],
            spin[2] * direction[0] - spin[0] * direction[2],
            spin[0] * direction[1] - spin[1] * direction[0],
        ],
    }
}

fn turning(parameters: Parameters<3>) -> Rod<3> {
    let mut rod = Rod::new(parameters).unwrap();
    rod.carry();
    rod.place(root(0.0, &[0.0; 6])).unwrap();
    let nodes = rod.positions(0).len();
    (rod.loads.force, rod.loads.impedance) = (vec![1e-2; 3 * nodes], vec![0.3; nodes]);
    for step in 1..=20 {
        rod.base_motion = Some(root(f64::from(step) * DT, &[0.0; 6]));
        rod.step(DT).unwrap();
    }
    rod
}

#[test]
fn the_announced_reaction_is_that_of_the_step_and_falls_with_the_impedance() {
    let plain = unit_rod::<3>(8, 1e4, Scheme::Bdf2);
    for parameters in [plain.clone(), Parameters { support: RootSupport::Pinned, damping: 0.2, ..plain }] {
        let mut rod = turning(parameters);
        let (state, t) = (rod.state().clone(), 21.0 * DT);
        rod.base_motion = Some(root(t, &[0.0; 6]));
        let announced = rod.root_response(DT).unwrap();
        assert_eq!(*rod.state(), state, "the rod has moved");
        let mut react = |change: &[f64; 6]| -> [f64; 6] {
            rod.restore(&state).unwrap();
            rod.base_motion = Some(root(t, change));
            rod.step(DT).unwrap();
            let drive = rod.state().drive;
            std::array::from_fn(|i| if i < 3 { -drive.force[i] } else { -drive.moment[i - 3] })
        };
        assert_eq!(react(&[0.0; 6]), announced.reaction);
        for j in 0..6 {
            let [ahead, behind] =
                [1e-4, -1e-4].map(|size| react(&std::array::from_fn(|i| if i == j { size } else { 0.0 })));
            for i in 0..6 {
                let found = (behind[i] - ahead[i]) / 2e-4;
                let expected = announced.impedance[i][j];
                assert!((found - expected).abs() < 0.1, "{i}, {j}: {found} against {expected}");
            }
        }
    }
}

#[test]
fn the_impedance_of_a_stiff_rod_is_its_rigid_inertia() {
    let stiff = Section { bending_stiffness: 1e8, ..unit_rod::<3>(8, 1e10, Scheme::Bdf2).section };
    let mut rod = turning(Parameters { section: stiff, ..unit_rod::<3>(8, 1e10, Scheme::Bdf2) });
    rod.base_motion = Some(root(21.0 * DT, &[0.0; 6]));
    let impedance = rod.root_response(DT).unwrap().impedance;
    let (masses, mut expected) = (rod.masses(), [0.0; 2]);
    for (k, mass) in masses.iter().enumerate() {
        let (rate, s) = (1.5 / DT * mass + 0.3, k as f64 / 8.0);
        expected = [expected[0] + rate, expected[1] + rate * s * s];
    }
    for (found, expected) in [impedance[2][2], impedance[5][5]].into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} against {expected}");
    }
}
