//! Steps in time: invariants, order, motion of the base, and the contract of a step.

use nervure_wing::{Membrane, Mesh, Parameters, RigidMotion, Root, Scheme, Support, Wing, rectangle};

fn free_wing(scheme: Scheme) -> Wing {
    let mesh = rectangle(0.2, 0.1, 4);
    let mut wing = Parameters { scheme, ..Parameters::new(mesh, Membrane::plate(1e8, 0.3, 1e-3, 1000.0)) }
        .build()
        .expect("a wing");
    let velocities: Vec<_> = wing
        .parameters()
        .mesh
        .nodes
        .iter()
        .map(|[x, y, _]| [0.3 - 0.5 * y, 0.5 * x, 4.0 * (30.0 * x).cos() * y + 20.0 * (x - 0.1) * (x - 0.1)])
        .collect();
    wing.set_velocities(&velocities).expect("velocities");
    wing
}

#[test]
fn a_free_wing_keeps_its_momentum_in_each_scheme() {
    for scheme in [Scheme::TrBdf2, Scheme::Bdf2, Scheme::Trapezoid, Scheme::GeneralisedAlpha { rho_inf: 0.8 }] {
        let mut wing = free_wing(scheme);
        let [before, turning] = wing.momentum();
        (0..50).for_each(|_| wing.step(1e-4).expect("a step"));
        let [after, turned] = wing.momentum();
        let scale = before.iter().map(|p| p * p).sum::<f64>().sqrt();
        let change = before.iter().zip(after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale;
        let scale = turning.iter().map(|p| p * p).sum::<f64>().sqrt();
        let turn = turning.iter().zip(turned).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale;
        println!("{scheme:?}: momentum {change:.1e}, angular momentum {turn:.1e}");
        assert!(change < 1e-10 && turn < 2e-3);
    }
}

#[test]
fn damping_takes_energy_but_no_momentum() {
    let mesh = rectangle(0.2, 0.1, 4);
    let membrane = Membrane::plate(1e8, 0.3, 1e-3, 1000.0);
    let mut wing = Parameters { relaxation_time: 1e-3, ..Parameters::new(mesh, membrane) }.build().expect("a wing");
    let bend: Vec<_> = wing.parameters().mesh.nodes.iter().map(|[x, _, _]| [0.0, 0.02, (30.0 * x).cos()]).collect();
    wing.set_velocities(&bend).expect("velocities");
    let [before, _] = wing.momentum();
    let (mut energy, mut lost, dt) = (wing.energy().expect("an energy").total(), 0.0, 2e-4);
    let first = energy;
    let mut power = wing.damping_power().expect("a power");
    for _ in 0..200 {
        wing.step(dt).expect("a step");
        let now = wing.energy().expect("an energy").total();
        let next = wing.damping_power().expect("a power");
        assert!(now <= energy * (1.0 + 1e-9) && next >= 0.0);
        lost += 0.5 * dt * (power + next);
        (energy, power) = (now, next);
    }
    let [after, _] = wing.momentum();
    println!("{first} {energy} {lost}");
    assert!(before.iter().zip(after).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(lost > 0.05 * first && ((first - energy) / lost - 1.0).abs() < 0.05);
}

#[test]
fn steps_are_of_second_order() {
    for scheme in [Scheme::TrBdf2, Scheme::Bdf2, Scheme::GeneralisedAlpha { rho_inf: 0.5 }] {
        let end = |steps: usize| {
            let mut wing = free_wing(scheme);
            (0..steps).for_each(|_| wing.step(2e-3 / steps as f64).expect("a step"));
            let k = wing.nodes() - 1;
            [0, 1, 2].map(|d| wing.positions(d)[k])
        };
        let shapes = [160, 320, 640].map(end);
        let off = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let ratio = off(shapes[0], shapes[1]) / off(shapes[1], shapes[2]);
        println!("{scheme:?}: {ratio}");
        assert!((3.2..5.5).contains(&ratio), "{scheme:?}: {ratio}");
    }
}

/// Return the pose of a base that turns about z by `angle` at the rate `omega`.
fn turned(angle: f64, omega: f64) -> RigidMotion {
    let (sin, cos) = angle.sin_cos();
    RigidMotion {
        rotation: [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]],
        angular_velocity: [0.0, 0.0, omega],
        ..RigidMotion::rest()
    }
}

#[test]
fn a_base_at_constant_rate_turns_a_stiff_wing_without_power_and_balances_its_centrifugal_force() {
    let mesh = rectangle(0.2, 0.1, 4);
    let root = Root { nodes: mesh.chain("root").expect("a root").to_vec(), ..Root::default() };
    let membrane = Membrane::plate(1e9, 0.3, 2e-3, 1000.0);
    let parameters = Parameters { root, relaxation_time: 1e-4, ..Parameters::new(mesh, membrane) };
    let mut wing = parameters.build().expect("a wing");
    let (omega, dt) = (5.0, 2e-3);
    wing.place(turned(0.0, omega)).expect("a pose");
    for step in 1..=200 {
        wing.base_motion = Some(turned(omega * dt * f64::from(step), omega));
        wing.step(dt).expect("a step");
    }
    let drive = wing.state().drive;
    let mass: f64 = wing.masses().iter().sum();
    let pull = drive.force.norm() / (mass * omega * omega * 0.1);
    println!("{pull} {} {}", drive.power, drive.work);
    assert!((pull - 1.0).abs() < 1e-2);
    assert!(drive.power.abs() < 1e-3 * mass * omega.powi(3) * 0.01);
}

#[test]
fn the_work_of_the_drive_is_the_energy_of_a_flapping_wing() {
    let mesh = rectangle(0.2, 0.1, 4);
    let root = Root { nodes: mesh.chain("root").expect("a root").to_vec(), ..Root::default() };
    let membrane = Membrane::plate(1e8, 0.3, 1e-3, 1000.0);
    let parameters = Parameters { root, ..Parameters::new(mesh, membrane) };
    let mut wing = parameters.build().expect("a wing");
    let dt = 1e-3;
    // About y, so the wing bends.
    let pose = |t: f64| {
        let (angle, omega) = (0.3 * (1.0 - (20.0 * t).cos()), 6.0 * (20.0 * t).sin());
        let (sin, cos) = angle.sin_cos();
        let rotation = [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]];
        RigidMotion { rotation, angular_velocity: [0.0, omega, 0.0], ..RigidMotion::rest() }
    };
    wing.place(pose(0.0)).expect("a pose");
    let (mut largest, mut work, mut power) = (0.0_f64, 0.0, 0.0);
    for step in 1..=300 {
        wing.base_motion = Some(pose(dt * f64::from(step)));
        wing.step(dt).expect("a step");
        let energy = wing.energy().expect("an energy").total();
        largest = largest.max(energy);
        // The trapezoid of the power; the unit's work is a sum of first order.
        let now = wing.state().drive.power;
        work += 0.5 * dt * (power + now);
        power = now;
        assert!((energy - work).abs() < 0.03 * largest.max(1e-4), "step {step}: {energy} and {work}");
    }
    assert!(largest > 1e-4);
}

#[test]
fn a_torsion_spring_turns_by_moment_over_stiffness() {
    let mesh = rectangle(0.2, 0.1, 4);
    let stiffness = 1e-2;
    let root = Root {
        nodes: mesh.chain("root").expect("a root").to_vec(),
        support: Support::TorsionSpring { stiffness },
        ..Root::default()
    };
    let membrane = Membrane::plate(1e13, 0.3, 2e-3, 1000.0);
    let mut wing = Parameters { root, ..Parameters::new(mesh, membrane) }.build().expect("a wing");
    let (nodes, force) = (wing.nodes(), 1e-4);
    wing.loads.force = vec![0.0; 3 * nodes];
    let tip = wing.parameters().mesh.chain("tip").expect("a tip").to_vec();
    tip.iter().for_each(|&k| wing.loads.force[2 * nodes + k] = force / tip.len() as f64);
    wing.solve_static().expect("an equilibrium");
    let angle = wing.positions(2)[tip[2]].atan2(wing.positions(0)[tip[2]]);
    let expected = force * 0.2 * angle.cos() / stiffness;
    assert!((angle / expected - 1.0).abs() < 1e-4, "{angle} and {expected}");
}

#[test]
fn a_step_allocates_nothing_and_repeats_its_bits_from_a_state() {
    let mesh = rectangle(0.2, 0.1, 6);
    let root = Root { nodes: mesh.chain("root").expect("a root").to_vec(), ..Root::default() };
    let membrane = Membrane::plate(1e8, 0.3, 1e-3, 1000.0);
    let parameters = Parameters { root, gravity: [0.0, 0.0, -9.81], ..Parameters::new(mesh, membrane) };
    let mut wing = parameters.build().expect("a wing");
    (0..3).for_each(|_| wing.step(1e-3).expect("a step"));
    let state = wing.state().clone();
    let counted = allocation_counter::measure(|| (0..3).for_each(|_| wing.step(1e-3).expect("a step")));
    assert_eq!(counted.count_total, 0);
    let ahead = wing.state().clone();
    wing.step(1e-2).expect("a step");
    wing.restore(&state).expect("a state");
    (0..3).for_each(|_| wing.step(1e-3).expect("a step"));
    assert_eq!(*wing.state(), ahead);
}

#[test]
fn a_stiff_wing_takes_long_steps() {
    // The step is 10⁵ times the shortest period of the membrane.
    let mesh = rectangle(0.2, 0.1, 6);
    let root = Root { nodes: mesh.chain("root").expect("a root").to_vec(), ..Root::default() };
    let membrane = Membrane::plate(1e8, 0.3, 1e-3, 1000.0);
    let parameters = Parameters { root, gravity: [0.0, 0.0, -9.81], ..Parameters::new(mesh, membrane) };
    let mut wing = parameters.build().expect("a wing");
    for _ in 0..50 {
        wing.step(5e-3).expect("a step");
    }
    assert!(wing.energy().expect("an energy").total() < 1e-6);
}

#[test]
fn a_hinge_that_turns_far_takes_sub_steps() {
    // A triangle of height 1 turns about a held edge by 2.4 rad in one step: otherwise a stage turns it back.
    let nodes = vec![[0.0, -0.5, 0.0], [0.0, 0.5, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let mesh = Mesh { nodes, triangles: vec![[0, 2, 1], [0, 1, 3]], chains: Vec::new() };
    let membrane =
        Membrane { stretching_stiffness: 1e3, bending_stiffness: 1e-6, ..Membrane::plate(1e3, 0.3, 1.0, 0.3) };
    let root = Root { nodes: vec![0, 1, 3], ..Root::default() };
    let mut wing = Parameters { root, ..Parameters::new(mesh, membrane) }.build().expect("a wing");
    let mut velocities = [[0.0; 3]; 4];
    velocities[2] = [0.0, 0.0, 1.0];
    wing.set_velocities(&velocities).expect("velocities");
    wing.step(2.4).expect("a step");
    let angle = wing.positions(2)[2].atan2(wing.positions(0)[2]);
    println!("{angle} in {} sub-steps", wing.statistics().substeps);
    assert!(wing.statistics().substeps >= 2 && (angle / 2.4 - 1.0).abs() < 0.2);
}

/// At long steps a limp film has several solutions, of which some have more energy: without the halving of sub-steps
/// that gain it, this one ends at 2.3 times the depth of its fall.
#[test]
fn a_limp_film_that_falls_gains_no_energy_at_long_steps() {
    let mesh = rectangle(0.1, 0.1, 10);
    let root = Root { nodes: mesh.chain("root").expect("a root").to_vec(), ..Root::default() };
    let membrane = Membrane {
        areal_density: 0.05,
        stretching_stiffness: 5e3,
        bending_stiffness: 1e-8,
        poisson_ratio: 0.3,
        tension: 0.0,
    };
    let parameters = Parameters { root, gravity: [0.0, 0.0, -9.81], ..Parameters::new(mesh, membrane) };
    // A load or an impedance too small to add energy of this size.
    for (force, impedance) in [(0.0, 0.0), (1e-9, 0.0), (0.0, 1e-9)] {
        let mut wing = parameters.clone().build().expect("a wing");
        let nodes = wing.nodes();
        (wing.loads.force, wing.loads.impedance) = (vec![force; 3 * nodes], vec![impedance; nodes]);
        let (mut highest, mut deepest) = (0.0_f64, 0.0_f64);
        for _ in 0..23 {
            wing.step(5e-3).expect("a step");
            let energy = wing.energy().expect("an energy");
            highest = highest.max(energy.total());
            deepest = deepest.max(-energy.gravity);
        }
        println!("{force} N, {impedance} kg/s: gained {highest} J of {deepest} J");
        assert!(deepest > 1e-4 && highest < 0.03 * deepest, "{force} N, {impedance} kg/s: {highest} of {deepest} J");
    }
}

#[test]
fn the_trapezoid_keeps_the_energy_of_a_free_wing_over_a_hundred_periods() {
    let mesh = rectangle(0.2, 0.1, 3);
    let membrane = Membrane::plate(1e8, 0.3, 1e-3, 1000.0);
    // First bending frequency of a free strip. The amplitude is a hundredth of the thickness: the trapezoid keeps the
    // energy of linear oscillations, and its error grows with the amplitude.
    let period = std::f64::consts::TAU / (22.37 / 0.04 * (membrane.bending_stiffness / membrane.areal_density).sqrt());
    for (scheme, allowed) in [(Scheme::Trapezoid, 1e-6), (Scheme::TrBdf2, 0.1)] {
        let mut wing = Parameters { scheme, ..Parameters::new(mesh.clone(), membrane) }.build().expect("a wing");
        let bend: Vec<_> = mesh.nodes.iter().map(|[x, _, _]| [0.0, 0.0, 5e-4 * (31.0 * x).cos()]).collect();
        wing.set_velocities(&bend).expect("velocities");
        let first = wing.energy().expect("an energy").total();
        let mut worst = 0.0_f64;
        for _ in 0..4000 {
            wing.step(period / 40.0).expect("a step");
            worst = worst.max((wing.energy().expect("an energy").total() / first - 1.0).abs());
        }
        println!("{scheme:?}: {worst:.1e}");
        assert!(worst < allowed, "{scheme:?}: {worst}");
    }
}

/// A strip in the shape (1 + b cos θ)(cos θ, sin θ), which crosses itself where b > 1.
fn bent(b: f64) -> usize {
    let mesh = rectangle(1.0, 0.1, 40);
    let mut wing = Parameters::new(mesh, Membrane::plate(1e6, 0.3, 1e-3, 1000.0)).build().expect("a wing");
    let mut state = wing.state().clone();
    for x in &mut state.positions {
        let theta = 0.2 + 5.8 * x[0];
        let r = 1.0 + b * theta.cos();
        (x[0], x[2]) = (r * theta.cos(), r * theta.sin());
    }
    wing.restore(&state).expect("a state");
    wing.crossings()
}

#[test]
fn a_wing_that_crosses_itself_is_seen() {
    let (open, closed) = (bent(0.5), bent(2.0));
    println!("{open} and {closed} pairs");
    assert!(open == 0 && (4..100).contains(&closed));
}

#[test]
fn a_wing_lighter_than_the_fluid_that_moves_with_it_follows_impedance_and_feels_its_whole_weight() {
    let membrane = Membrane::plate(1e6, 0.3, 1e-3, 1000.0);
    let gravity = [0.0, 0.0, -9.81];
    let parameters =
        Parameters { gravity, displaced_density: 2.0, ..Parameters::new(rectangle(0.2, 0.1, 4), membrane) };
    let mut wing = parameters.build().expect("a wing");
    let rate = 500.0; // 1/s
    wing.loads.impedance = wing.masses().iter().map(|mass| rate * mass).collect();
    for step in 1..4 {
        wing.step(1e-3).expect("a step");
        let (low, high) = wing.velocities(2).iter().fold((0.0_f64, -9.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
        let expected = -9.81 / rate * f64::from(step);
        println!("{low} to {high}, {expected} without mass");
        assert!((low / expected - 1.0).abs() < 0.01 && (high / expected - 1.0).abs() < 0.01);
    }
}

#[test]
fn a_held_node_has_the_acceleration_of_its_base() {
    let mesh = rectangle(0.2, 0.1, 4);
    let root = Root { nodes: mesh.chain("root").expect("a root").to_vec(), ..Root::default() };
    let mut wing =
        Parameters { root, ..Parameters::new(mesh, Membrane::plate(1e8, 0.3, 1e-3, 1000.0)) }.build().expect("a wing");
    // φ = sin 20 t about y, so that its second derivative is −400 sin 20 t.
    let (dt, pose) = (1e-3, |t: f64| turned((20.0 * t).sin(), 20.0 * (20.0 * t).cos()));
    wing.place(pose(0.0)).expect("a place");
    for step in 1..=40 {
        let t = dt * f64::from(step);
        wing.base_motion = Some(pose(t));
        wing.step(dt).expect("a step");
        let (phi, omega, alpha) = ((20.0 * t).sin(), 20.0 * (20.0 * t).cos(), -400.0 * (20.0 * t).sin());
        for &k in &wing.parameters().root.nodes {
            let [x, y, z] = wing.parameters().mesh.nodes[k];
            let state = wing.state();
            let (omegas, arm) = (state.own.base.angular_velocity, turned(phi, omega).rotation);
            let r: [f64; 3] = std::array::from_fn(|i| arm[i][0] * x + arm[i][1] * y + arm[i][2] * z);
            let axis: [f64; 3] = std::array::from_fn(|i| omegas[i] / omega);
            let cross = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
                std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
            };
            let (around, inward) = (cross(axis, r), cross(axis, cross(axis, r)));
            for i in 0..3 {
                let exact = alpha * around[i] + omega * omega * inward[i];
                let found = state.accelerations[k][i];
                assert!((found - exact).abs() < 0.05, "{found} is not {exact} at {t} s");
            }
        }
    }
}

/// At rest the energies of a loaded or taut wing change by rounding alone, which is no gain.
#[test]
fn a_wing_that_has_come_to_rest_stays_there() {
    let mesh = rectangle(1.0, 0.2, 10);
    let edge: Vec<_> = (0..mesh.nodes.len())
        .filter(|&k| {
            let [x, y, _] = mesh.nodes[k];
            [x, x - 1.0, y - 0.1, y + 0.1].iter().any(|gap| gap.abs() < 1e-9)
        })
        .collect();
    let root = mesh.chain("root").expect("a root").to_vec();
    let membrane = |stiffness, tension| Membrane {
        areal_density: 1.0,
        stretching_stiffness: stiffness,
        bending_stiffness: 1e-3,
        poisson_ratio: 0.0,
        tension,
    };
    for (name, held, membrane, gravity) in [
        ("hangs", &root, membrane(1e3, 0.0), [9.81, 0.0, 0.0]),
        ("hangs, stiff", &root, membrane(1e7, 0.0), [9.81, 0.0, 0.0]),
        ("taut", &edge, membrane(1e3, 50.0), [0.0, 0.0, 1e-3]),
    ] {
        for place in [0.0, 100.0] {
            let mut mesh = mesh.clone();
            mesh.nodes.iter_mut().for_each(|x| x[1] += place);
            let root = Root { nodes: held.clone(), ..Root::default() };
            let parameters = Parameters { root, gravity, relaxation_time: 0.02, ..Parameters::new(mesh, membrane) };
            let mut wing = parameters.build().expect("a wing");
            let ended = (0..400).find_map(|step| wing.step(0.02).err().map(|error| format!("step {step}: {error}")));
            assert_eq!(ended, None, "{name} at {place} m");
        }
    }
}

/// Before the loads tell of the fluid that moves with it, a light wing starts as with the mass of this fluid.
#[test]
fn a_light_wing_is_not_thrown_by_its_weight_in_the_first_step() {
    let membrane = Membrane { areal_density: 0.01, ..Membrane::plate(1e6, 0.3, 1e-3, 1000.0) };
    for (displaced_density, expected) in [(0.1, 0.1), (5e-3, 2.0), (1e-3, 1.0 / 0.9), (0.0, 1.0)] {
        let parameters = Parameters {
            displaced_density,
            gravity: [0.0, 0.0, -10.0],
            scheme: Scheme::Bdf2,
            ..Parameters::new(rectangle(0.2, 0.1, 4), membrane)
        };
        let mut wing = parameters.build().expect("a wing");
        wing.step(1e-3).expect("a step");
        for velocity in wing.velocities(2) {
            assert!((velocity / (-10.0 * 1e-3 * expected) - 1.0).abs() < 0.2, "{displaced_density}: {velocity} m/s");
        }
    }
}
