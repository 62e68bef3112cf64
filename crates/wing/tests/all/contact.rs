//! Contact of the membrane with obstacles, and with itself.

use nervure_wing::{Contact, Membrane, Obstacle, Parameters, Pose, Root};

use crate::thrown::{AREAL, RANGE, STEP, book, contact, energy, floor, parameters, throw};

/// The penalty k (h − g)²/(2 h) balances the weight of each part.
#[test]
fn a_flat_wing_rests_on_the_floor_at_the_exact_gap() {
    let mut touch = contact(vec![floor()]);
    touch.law.damping = 2.0 * (touch.law.stiffness * AREAL).sqrt();
    let exact = RANGE - (2.0 * AREAL * 9.81 * RANGE / touch.law.stiffness).sqrt();
    let mut wing = Parameters { gravity: [0.0, 0.0, -9.81], ..parameters(touch, 0.02) }.build().expect("a wing");
    (0..1500).for_each(|_| wing.step(STEP).expect("a step"));
    let counted = allocation_counter::measure(|| wing.step(STEP).expect("a step"));
    assert_eq!(counted.count_total, 0, "allocations in a step");
    let off = wing.positions(2).iter().map(|z| (z - exact).abs()).fold(0.0, f64::max);
    assert!(off < 1e-3 * exact, "{off} m from {exact} m");
    let carried: f64 = wing.contact_forces().iter().map(|force| force.z).sum();
    assert!((carried / (AREAL * 0.02 * 9.81) - 1.0).abs() < 1e-3, "the floor carries {carried} N");
}

/// A wing that flies flat bounces back as one mass; its corners and its middle feel the same force per mass.
#[test]
fn a_flat_wing_bounces_with_its_speed() {
    let mut wing = parameters(contact(vec![floor()]), 0.05).build().expect("a wing");
    wing.set_velocities(&vec![[0.0, 0.0, -1.0]; wing.nodes()]).expect("velocities");
    let mut least = f64::INFINITY;
    for _ in 0..120 {
        wing.step(STEP).expect("a step");
        least = wing.positions(2).iter().copied().fold(least, f64::min);
    }
    let [momentum, _] = wing.momentum();
    let speed = momentum[2] / (AREAL * 0.02);
    assert!(speed > 0.95 && speed < 1.0 + 1e-9 && least > -0.5 * RANGE, "{speed} m/s, at least {least} m high");
}

/// A cantilever whose middle a ball lifts: the ball carries what the root does not.
#[test]
fn a_ball_that_a_law_moves_lifts_a_held_wing() {
    let ball = |z: f64| Pose::at([0.1, 0.05, z]);
    let mut touch = contact(vec![Obstacle::block([0.1, 0.05, -0.08], [0.0; 3], 0.05)]);
    touch.law.damping = 50.0;
    let mut held = parameters(touch, 0.0);
    let nodes = held.mesh.chain("root").expect("a root").to_vec();
    held.root = Root { nodes, ..Root::default() };
    held.membranes = vec![Membrane::plate(1e9, 0.3, 1e-3, 1e3 * AREAL)];
    held.relaxation_time = 0.03;
    let mut wing = held.build().expect("a wing");
    let place = |k: usize| -0.08 + 2e-4 * (k as f64).min(250.0);
    for k in 0..800 {
        wing.move_obstacle(0, [ball(place(k)), ball(place(k + 1))]);
        wing.step(STEP).expect("a step");
        let least = (0..wing.nodes())
            .map(|n| {
                let d = [wing.positions(0)[n] - 0.1, wing.positions(1)[n] - 0.05, wing.positions(2)[n] - place(k + 1)];
                d.iter().map(|d| d * d).sum::<f64>().sqrt()
            })
            .fold(f64::INFINITY, f64::min);
        assert!(least > 0.05 - 0.5 * RANGE, "a node is {least} m from the middle of a ball of 0.05 m");
    }
    let tip = wing.positions(2).iter().copied().fold(0.0, f64::max);
    let carried: f64 = wing.contact_forces().iter().map(|force| force.z).sum();
    let root = wing.state().drive.force[2];
    assert!(tip > 0.03, "the tip is lifted by {tip} m");
    assert!((root + carried).abs() < 0.02 * carried, "the ball pushes with {carried} N, the root holds {root} N");
}

/// A free wing whose halves close like a book: they open again, nothing crosses, and the momentum stays.
#[test]
fn halves_of_a_wing_that_close_bounce_without_a_net_force() {
    let closing = |with_itself: bool| {
        let own = book(parameters(Contact { with_itself, ..contact(vec![]) }, 0.0), 8);
        let mut wing = own.build().expect("a wing");
        let turning: Vec<_> = wing.positions(0).iter().map(|x| [0.0, 0.0, 20.0 * (x - 0.1).abs()]).collect();
        wing.set_velocities(&turning).expect("velocities");
        wing
    };
    let mut wing = closing(true);
    let (start, [momentum, _]) = (energy(&mut wing), wing.momentum());
    let (mut touched, mut net) = (0.0_f64, 0.0_f64);
    for step in 0..160 {
        wing.step(STEP).unwrap_or_else(|error| panic!("step {step}: {error}"));
        let each: f64 = wing.contact_forces().iter().map(|force| force.norm()).sum();
        let all = wing.contact_forces().iter().sum::<nalgebra::Vector3<f64>>().norm();
        (touched, net) = (touched.max(each), net.max(all));
        assert_eq!(wing.crossings(), 0, "step {step}");
        let now = energy(&mut wing);
        assert!(now <= 1.001 * start, "step {step}: {now} J after {start} J");
    }
    assert!(touched > 0.1 && net < 1e-12 * touched, "net force {net} N of {touched} N");
    let drift = (0..3).map(|d| (wing.momentum()[0][d] - momentum[d]).abs()).fold(0.0, f64::max);
    assert!(drift < 1e-9, "the momentum drifts by {drift} kg m/s");
    let mut without = closing(false);
    let crosses = (0..160).any(|_| without.step(STEP).is_err() || without.crossings() > 0);
    assert!(crosses, "without contact it passes through itself");
}

#[test]
fn a_wing_thrown_between_obstacles_gains_no_energy_and_stays_outside() {
    for seed in 0..6 {
        let [touched, gain, depth] = throw(seed).unwrap();
        assert!(touched > 10.0 && gain < 0.01 && depth < 1.0, "{touched} steps, {gain} of the energy, {depth} deep");
    }
}

#[test]
fn a_wing_that_starts_in_an_obstacle_is_refused_in_words() {
    let mut wing = parameters(contact(vec![floor()]), -0.02).build().expect("a wing");
    let error = wing.step(STEP).unwrap_err().to_string();
    assert!(error.contains("what it touches overlaps it by 2.000e-2 m"), "{error}");
    let mut touch = contact(vec![Obstacle::block([0.0; 3], [0.0; 3], 0.1)]);
    touch.law.range = 1e-4;
    let error = parameters(touch, 0.3).build().err().expect("too many points").to_string();
    assert!(error.contains("contact.range"), "{error}");
}
