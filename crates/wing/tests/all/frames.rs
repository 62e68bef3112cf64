//! A wing whose base moves and turns about skew axes: rigid motion, and the same wing in another frame.

use nalgebra::{Rotation3, Vector3};
use nervure_wing::{Membrane, Parameters, RigidMotion, Root, Vein, Wing, rectangle};

type Vector = Vector3<f64>;

/// A damped wing with a tapered vein, and one with torsion round a corner, on a clamped root, which turns about a point
/// aside, in gravity, with its rest shape turned by `axes` and put `away`.
fn clamped(axes: Rotation3<f64>, away: Vector) -> Wing {
    let mut mesh = rectangle(0.2, 0.1, 4);
    let root = mesh.chain("root").expect("a root").to_vec();
    let along: Vec<_> = (0..mesh.nodes.len()).filter(|&k| mesh.nodes[k][1] == mesh.nodes[root[1]][1]).collect();
    let rim: Vec<_> = [mesh.chain("right"), mesh.chain("tip")].map(|chain| chain.expect("a side").to_vec()).concat();
    let corner = rim.len() - mesh.chain("tip").map_or(0, <[usize]>::len);
    let rim = [&rim[..corner], &rim[corner + 1..]].concat();
    mesh.nodes.iter_mut().for_each(|x| *x = (axes * Vector::from(*x) + away).into());
    let diameter = (0..along.len()).map(|i| 1.0 - 0.1 * i as f64).collect();
    let origin = (axes * Vector::new(0.03, -0.02, 0.01) + away).into();
    Parameters {
        veins: vec![
            Vein { diameter, ..Vein::new("vein", &along, 0.02, 1e-3, 1e3) },
            Vein { torsional_stiffness: 2e-4, ..Vein::new("rim", &rim, 0.01, 3e-4, 1e3) },
        ],
        root: Root { nodes: root, origin, ..Root::default() },
        gravity: (axes * Vector::new(0.0, 1.0, -9.0)).into(),
        relaxation_time: 1e-3,
        ..Parameters::new(mesh, Membrane::plate(1e8, 0.3, 1e-3, 1000.0))
    }
    .build()
    .expect("a wing")
}

fn motion(rotation: Rotation3<f64>, omega: Vector, displacement: Vector, velocity: Vector) -> RigidMotion {
    RigidMotion {
        displacement: displacement.into(),
        velocity: velocity.into(),
        rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
        angular_velocity: omega.into(),
    }
}

#[test]
fn a_wing_that_is_placed_in_motion_accelerates_as_a_rigid_body_and_loses_nothing_to_damping() {
    let mut wing = clamped(Rotation3::identity(), Vector::zeros());
    let (omega, velocity) = (Vector::new(3.0, -5.0, 2.0), Vector::new(2.0, -1.0, 3.0));
    for t in [0.0, 0.3] {
        wing.place(motion(Rotation3::new(omega * t), omega, velocity * t, velocity)).expect("a pose");
        let (power, energy) = (wing.damping_power().expect("a power"), wing.energy().expect("an energy").kinetic);
        println!("{power} W by damping of {energy} J");
        assert!(power.abs() < 1e-9 * energy / 1e-3, "at {t} s damping takes {power} W of {energy} J");
        let centre = Vector::from(wing.parameters().root.origin) + velocity * t;
        for (k, x) in wing.state().positions.iter().enumerate() {
            let swing = omega.cross(&(x - centre));
            let found = [wing.state().velocities[k], wing.state().accelerations[k]];
            for (found, expected) in found.into_iter().zip([velocity + swing, omega.cross(&swing)]) {
                assert!((found - expected).norm() < 1e-12, "node {k} at {t} s: {found:?} is not {expected:?}");
            }
        }
    }
}

/// Return momentum and angular momentum, then their rates by reaction and weight, about the origin of coordinates.
fn momenta_and_rates(wing: &mut Wing) -> [[Vector; 2]; 2] {
    let momenta = wing.momentum().map(Vector::from);
    let (weight, state) = (Vector::from(wing.parameters().gravity), wing.state());
    let origin = Vector::from(wing.parameters().root.origin) + Vector::from(state.own.base.displacement);
    let mut rates = [state.drive.force, Vector::from(state.drive.moment) + origin.cross(&state.drive.force)];
    for (x, mass) in state.positions.iter().zip(wing.masses()) {
        rates[0] += weight * *mass;
        rates[1] += x.cross(&(weight * *mass));
    }
    [momenta, rates]
}

/// The base heaves and flaps about a skew axis. Reaction and weight are the rates of the momenta. The same wing, turned
/// with its weight into another place and seen from a steady motion, has the same shape and the same reaction about its
/// moving origin, which takes the power `F · speed` more.
#[test]
fn the_reaction_of_a_driven_wing_is_the_rate_of_its_momenta_in_every_frame() {
    let (axes, away) = (Rotation3::new(Vector::new(0.5, 0.9, -1.3)), Vector::new(0.7, -1.1, 0.4));
    let (speed, about, dt) = (Vector::new(-2.0, 1.5, 3.0), Vector::new(0.3, 0.9, 0.2).normalize(), 1e-3);
    let poses = |t: f64| {
        let [[angle, rate], [x, u], [z, w]] =
            [0.4, 0.01, -0.02].map(|size| [size * (20.0 * t).sin(), 20.0 * size * (20.0 * t).cos()]);
        let (rotation, omega) = (Rotation3::new(about * angle), about * rate);
        let (displacement, velocity) = (Vector::new(x, 0.0, z), Vector::new(u, 0.0, w));
        let turned = axes * rotation * axes.inverse();
        let from_afar = motion(turned, axes * omega, axes * displacement + speed * t, axes * velocity + speed);
        [motion(rotation, omega, displacement, velocity), from_afar]
    };
    let mut wings = [clamped(Rotation3::identity(), Vector::zeros()), clamped(axes, away)];
    wings.iter_mut().zip(poses(0.0)).for_each(|(wing, pose)| wing.place(pose).expect("a pose"));
    let mut history = Vec::new();
    for step in 1..=60 {
        let t = dt * f64::from(step);
        for (wing, pose) in wings.iter_mut().zip(poses(t)) {
            wing.base_motion = Some(pose);
            wing.step(dt).expect("a step");
        }
        history.push(wings.each_mut().map(momenta_and_rates));
        let [one, other] = wings.each_ref().map(Wing::state);
        for (x, y) in one.positions.iter().zip(&other.positions) {
            let seen = axes * x + away + speed * t;
            assert!((seen - y).norm() < 1e-9, "at {t} s: {y:?} is not {seen:?}");
        }
        let (force, size) = (axes * one.drive.force, one.drive.force.norm());
        let [moment, other_moment] = [one, other].map(|state| Vector::from(state.drive.moment));
        let [power, other_power] = [one.drive.power + force.dot(&speed), other.drive.power].map(Vector::repeat);
        for (what, found, expected, scale) in [
            ("force", other.drive.force, force, size),
            ("moment", other_moment, axes * moment, 0.1 * size),
            ("power", other_power, power, speed.norm() * size),
        ] {
            assert!((found - expected).norm() < 1e-7 * scale, "{what} at {t} s: {found:?} is not {expected:?}");
        }
    }
    // Without the first steps, whose jump in the load of the start the trapezoid does not follow.
    let (first, last) = (history[5], history[history.len() - 1]);
    for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let change = last[i][0][k] - first[i][0][k];
        let steps = history[5..].windows(2).map(|ends| (ends[0][i][1][k] + ends[1][i][1][k]) * 0.5 * dt);
        let impulse: Vector = steps.sum();
        println!("wing {i}: {:.1e} of the change of momentum {k}", (impulse - change).norm() / change.norm());
        assert!((impulse - change).norm() < 1e-3 * change.norm(), "wing {i}, {k}: {impulse:?} is not {change:?}");
    }
}
