//! What a wing announces to a body that carries it.

use nalgebra::{Rotation3, Vector3};
use nervure_wing::{Membrane, Parameters, RigidMotion, Root, Scheme, Vein, Wing, rectangle};

type Vector = Vector3<f64>;

const DT: f64 = 1e-3;

/// A wing with a vein, with or without torsion, on a clamped root whose base turns about a point aside; a body carries it.
fn carried(youngs_modulus: f64, torsion: f64) -> Wing {
    let mesh = rectangle(0.2, 0.1, 4);
    let root = mesh.chain("root").expect("a root").to_vec();
    let along: Vec<_> = (0..mesh.nodes.len()).filter(|&k| mesh.nodes[k][1] == mesh.nodes[root[1]][1]).collect();
    let mut wing = Parameters {
        veins: vec![Vein {
            torsional_stiffness: torsion * 1e-11 * youngs_modulus,
            ..Vein::new("vein", &along, 0.02, 1e-11 * youngs_modulus, 1e-5 * youngs_modulus)
        }],
        root: Root { nodes: root, origin: [0.03, -0.02, 0.01], ..Root::default() },
        gravity: [0.0, 1.0, -9.0],
        relaxation_time: 1e-4,
        scheme: Scheme::Bdf2,
        ..Parameters::new(mesh, Membrane::plate(youngs_modulus, 0.3, 1e-3, 1000.0))
    }
    .build()
    .expect("a wing");
    wing.carry();
    let nodes = wing.nodes();
    wing.loads.force = vec![1e-4; 3 * nodes];
    wing.loads.impedance = vec![2e-3; nodes];
    wing
}

/// The base flaps gently; `change` of its velocities at the end of the step moves it by two thirds of a step.
fn pose(t: f64, change: &[f64; 6]) -> RigidMotion {
    let [linear, angular] = [0, 3].map(|i| Vector::new(change[i], change[i + 1], change[i + 2]));
    let about = Vector::new(0.3, 0.9, 0.2).normalize();
    let (sin, cos) = (20.0 * t).sin_cos();
    let rotation = Rotation3::new(angular * (DT / 1.5)) * Rotation3::new(about * 0.1 * (1.0 - cos));
    RigidMotion {
        displacement: (Vector::new(0.005 * (1.0 - cos), 0.0, 0.0) + linear * (DT / 1.5)).into(),
        velocity: (Vector::new(0.1 * sin, 0.0, 0.0) + linear).into(),
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
        angular_velocity: (about * 2.0 * sin + angular).into(),
    }
}

/// Return the wing after some steps, with the time.
fn flapping(youngs_modulus: f64, torsion: f64) -> (Wing, f64) {
    let mut wing = carried(youngs_modulus, torsion);
    wing.place(pose(0.0, &[0.0; 6])).expect("a pose");
    for step in 1..=30 {
        wing.base_motion = Some(pose(f64::from(step) * DT, &[0.0; 6]));
        wing.step(DT).expect("a step");
    }
    (wing, 31.0 * DT)
}

#[test]
fn the_announced_reaction_is_that_of_the_step_and_falls_with_the_impedance() {
    let (mut wing, t) = flapping(1e7, 0.0);
    let state = wing.state().clone();
    wing.base_motion = Some(pose(t, &[0.0; 6]));
    let announced = wing.root_response(DT).expect("a response");
    assert_eq!(*wing.state(), state, "the wing has moved");
    let mut react = |change: &[f64; 6]| -> [f64; 6] {
        wing.restore(&state).expect("a state");
        wing.base_motion = Some(pose(t, change));
        wing.step(DT).expect("a step");
        let drive = wing.state().drive;
        std::array::from_fn(|i| if i < 3 { -drive.force[i] } else { -drive.moment[i - 3] })
    };
    assert_eq!(react(&[0.0; 6]), announced.reaction);
    for j in 0..6 {
        let size = if j < 3 { 1e-4 } else { 1e-3 };
        let [ahead, behind] =
            [size, -size].map(|size| react(&std::array::from_fn(|i| if i == j { size } else { 0.0 })));
        let scale = announced.impedance[j][j].sqrt();
        for i in 0..6 {
            let found = (behind[i] - ahead[i]) / (2.0 * size);
            let (expected, scale) = (announced.impedance[i][j], scale * announced.impedance[i][i].sqrt());
            assert!((found - expected).abs() < 2e-3 * scale, "{i}, {j}: {found} against {expected}, scale {scale}");
        }
    }
}

#[test]
fn the_impedance_of_a_stiff_wing_is_its_rigid_inertia_and_that_of_a_soft_one_is_less() {
    let ([mut stiff, mut soft], t) = ([flapping(1e15, 0.0).0, flapping(1e5, 0.0).0], 31.0 * DT);
    let [stiff, soft] = [&mut stiff, &mut soft].map(|wing| {
        wing.base_motion = Some(pose(t, &[0.0; 6]));
        let rigid = 1.5 / DT * wing.masses().iter().sum::<f64>() + 2e-3 * wing.nodes() as f64;
        (wing.root_response(DT).expect("a response").impedance, rigid)
    });
    let (impedance, rigid) = (stiff.0[2][2], stiff.1);
    assert!((impedance / rigid - 1.0).abs() < 5e-3, "{impedance} kg/s against {rigid}");
    assert!(soft.0[2][2] < 0.7 * rigid, "{} kg/s against {rigid}", soft.0[2][2]);
    for i in 0..6 {
        for j in 0..6 {
            let (one, other) = (stiff.0[i][j], stiff.0[j][i]);
            let scale = (stiff.0[i][i] * stiff.0[j][j]).sqrt();
            assert!((one - other).abs() < 1e-9 * scale, "{i}, {j}: {one} is not {other}");
        }
    }
}

/// The change of the root is that of a body that accelerates by 1 g more than at the reference, and turns faster; a
/// change a hundred times as large costs more.
#[test]
fn a_step_after_its_trial_takes_no_factorisation_and_ends_at_the_same_place() {
    for (torsion, scale) in [(0.0, 1.0), (0.8, 1.0), (0.0, 100.0), (0.8, 100.0)] {
        let (mut wing, t) = flapping(1e7, torsion);
        let state = wing.state().clone();
        let change = [1e-2, -5e-3, 1e-2, 0.05, -0.02, 0.05].map(|part| part * scale);
        let mut step = |is_tried: bool| {
            wing.restore(&state).expect("a state");
            if is_tried {
                wing.base_motion = Some(pose(t, &[0.0; 6]));
                wing.root_response(DT).expect("a response");
            }
            wing.base_motion = Some(pose(t, &change));
            let counted = allocation_counter::measure(|| wing.step(DT).expect("a step"));
            assert_eq!(counted.count_total, 0, "allocations in a step");
            (wing.state().clone(), wing.statistics())
        };
        let [(alone, effort), (tried, less)] = [false, true].map(&mut step);
        let is_cheap = less.factorisations == 0 && less.iterations <= effort.iterations;
        assert!(is_cheap || scale > 1.0, "{less:?} after {effort:?}");
        assert!(effort.factorisations > 0, "{effort:?}");
        let moved = |of: &[Vector], to: &[Vector]| of.iter().zip(to).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
        let whole = moved(&state.positions, &alone.positions);
        let off = moved(&tried.positions, &alone.positions);
        println!("torsion {torsion}: {off:e} m of {whole:e}, {effort:?}, {less:?}");
        let allowed = if scale > 1.0 { 1e-8 } else { 1e-9 };
        assert!(off < allowed * whole, "torsion {torsion}: off by {off:e} m of {whole:e}");
        let [one, other] = [&tried, &alone].map(|state| state.drive.force);
        assert!((one - other).norm() < 1e-8 * other.norm(), "{one} is not {other}");
    }
}

/// A step without a trial of its own repeats the bits of the state.
#[test]
fn a_trial_serves_only_the_next_step_under_its_loads() {
    let (mut wing, t) = flapping(1e7, 0.8);
    let state = wing.state().clone();
    let loads = wing.loads.clone();
    let mut step = |between: &dyn Fn(&mut Wing)| {
        wing.restore(&state).expect("a state");
        (wing.loads, wing.base_motion) = (loads.clone(), Some(pose(t, &[1e-2; 6])));
        between(&mut wing);
        wing.base_motion = Some(pose(t, &[0.0; 6]));
        wing.step(DT).expect("a step");
        wing.state().clone()
    };
    let tried = |wing: &mut Wing| assert!(wing.root_response(DT).is_ok());
    let heavier = |wing: &mut Wing| wing.loads.force.fill(2e-4);
    let alone = step(&|_| ());
    assert_eq!(alone, step(&|wing| (tried(wing), wing.forget_trial()).1), "forgotten");
    assert_eq!(alone, step(&|wing| (tried(wing), wing.restore(&state).expect("a state")).1), "restored");
    let other = step(&|wing| (tried(wing), heavier(wing)).1);
    assert_eq!(step(&heavier), other, "of other loads");
    let again = step(&|wing| {
        tried(wing);
        wing.base_motion = Some(pose(t, &[2e-2; 6]));
        tried(wing);
    });
    let once = step(&|wing| {
        wing.base_motion = Some(pose(t, &[2e-2; 6]));
        tried(wing);
    });
    assert_eq!(once, again, "the second of two");
    wing.base_motion = Some(pose(t, &[0.0; 6]));
    tried(&mut wing);
    let factors = [(), ()].map(|()| {
        wing.step(DT).expect("a step");
        wing.statistics().factorisations
    });
    assert!(factors[0] == 0 && factors[1] > 0, "{factors:?} factorisations");
}
