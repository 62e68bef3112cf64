//! Contact of the membrane with obstacles.

use std::f64::consts::PI;

use nervure_wing::{Contact, Law, Membrane, Obstacle, Parameters, Pose, Root, Scheme, Wing, rectangle};

const AREAL: f64 = 1.0;
const RANGE: f64 = 0.02;
const STEP: f64 = 1e-3;

/// A contact that lasts ten steps, with `obstacles`.
fn contact(obstacles: Vec<Obstacle<3>>) -> Contact {
    let stiffness = AREAL * (PI / (10.0 * STEP)).powi(2);
    let law = Law { range: RANGE, stiffness, depth: 0.5 * RANGE, damping: 0.0, friction: 0.0, film: None };
    Contact { law, obstacles }
}

/// A free wing of 1 kg/m² with a contact.
fn parameters(contact: Contact, height: f64) -> Parameters {
    let mut mesh = rectangle(0.2, 0.1, 4);
    mesh.nodes.iter_mut().for_each(|node| node[2] = height);
    let contact = Some(contact);
    Parameters { contact, ..Parameters::new(mesh, Membrane::plate(1e8, 0.3, 1e-3, 1e3 * AREAL)) }
}

fn floor() -> Obstacle<3> {
    Obstacle::plane([0.0; 3], [0.0, 0.0, 1.0])
}

fn energy(wing: &mut Wing) -> f64 {
    wing.energy().expect("an energy").total()
}

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

/// Numbers between 0 and 1, the same in each run.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Throw a wing between solids and walls, where a step refuses what is deeper than half the range; return the number of
/// steps in contact.
fn thrown(seed: u64) -> usize {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1);
    (0..8).for_each(|_| _ = random.between(0.0, 1.0));
    let mut obstacles = vec![floor(), Obstacle::plane([0.0, 0.0, 0.4], [0.0, 0.2, -1.0])];
    for _ in 0..2 {
        let middle = [random.between(0.0, 0.2), random.between(0.0, 0.1), random.between(0.0, 0.1)];
        let half = [0, 1, 2].map(|_| (random.between(-0.04, 0.04)).max(0.0));
        obstacles.push(Obstacle::block(middle, half, random.between(0.01, 0.03)));
    }
    let mut touch = contact(obstacles);
    touch.law.damping = random.between(-100.0, 100.0).max(0.0);
    touch.law.friction = random.between(-1.0, 1.0).max(0.0);
    let mut own = parameters(touch, 0.22);
    own.gravity = [0.0, 0.0, -9.81];
    own.relaxation_time = 1e-3;
    own.scheme = if random.between(0.0, 1.0) < 0.5 { Scheme::TrBdf2 } else { Scheme::Bdf2 };
    let mut wing = own.build().expect("a wing");
    let spin = [0, 1, 2].map(|_| random.between(-5.0, 5.0));
    let speed = random.between(0.0, 2.0);
    let nodes = wing.parameters().mesh.nodes.clone();
    let turning = nodes.iter().map(|[x, y, _]| {
        let arm = [x - 0.1, y - 0.05];
        [-spin[2] * arm[1], spin[2] * arm[0], spin[0] * arm[1] - spin[1] * arm[0] - speed]
    });
    wing.set_velocities(&turning.collect::<Vec<_>>()).expect("velocities");
    let (start, scale) = (energy(&mut wing), wing.energy().expect("an energy").kinetic + AREAL * 0.02 * 9.81 * 0.2);
    let mut touched = 0;
    for step in 0..300 {
        wing.step(STEP).unwrap_or_else(|error| panic!("case {seed}, step {step}: {error}"));
        let now = energy(&mut wing);
        assert!(now <= start + 0.01 * scale, "case {seed}, step {step}: {now} J after {start} J of {scale} J");
        touched += usize::from(wing.energy().expect("an energy").contact > 0.0);
    }
    touched
}

#[test]
fn a_wing_thrown_between_obstacles_gains_no_energy_and_stays_outside() {
    let touched: usize = (0..4).map(thrown).sum();
    assert!(touched > 200, "{touched} steps in contact");
}

#[test]
#[ignore = "a study of some minutes"]
fn hundreds_of_wings_thrown_between_obstacles_gain_no_energy_and_stay_outside() {
    (4..304).for_each(|seed| _ = thrown(seed));
}

#[test]
fn a_wing_that_starts_in_an_obstacle_is_refused_in_words() {
    let mut wing = parameters(contact(vec![floor()]), -0.02).build().expect("a wing");
    let error = wing.step(STEP).unwrap_err().to_string();
    assert!(error.contains("what the wing touches lies 2.000e-2 m beyond it"), "{error}");
    let mut touch = contact(vec![Obstacle::block([0.0; 3], [0.0; 3], 0.1)]);
    touch.law.range = 1e-4;
    let error = parameters(touch, 0.3).build().err().expect("too many points").to_string();
    assert!(error.contains("contact.range"), "{error}");
}
