//! Wings thrown between obstacles, for a test and a study.

use std::f64::consts::PI;

use nervure_wing::{Contact, Error, Law, Membrane, Obstacle, Parameters, Scheme, Wing, WingError, rectangle};

pub const AREAL: f64 = 1.0;
pub const RANGE: f64 = 0.02;
pub const STEP: f64 = 1e-3;

/// A contact that lasts ten steps, with `obstacles`.
pub fn contact(obstacles: Vec<Obstacle<3>>) -> Contact {
    let stiffness = AREAL * (PI / (10.0 * STEP)).powi(2);
    let law = Law { range: RANGE, stiffness, depth: 0.5 * RANGE, damping: 0.0, friction: 0.0, film: None };
    Contact { law, with_itself: false, obstacles }
}

/// A free wing of 1 kg/m² with a contact.
pub fn parameters(contact: Contact, height: f64) -> Parameters {
    let mut mesh = rectangle(0.2, 0.1, 4);
    mesh.nodes.iter_mut().for_each(|node| node[2] = height);
    let contact = Some(contact);
    Parameters { contact, ..Parameters::new(mesh, Membrane::plate(1e8, 0.3, 1e-3, 1e3 * AREAL)) }
}

/// Return a wing like another one, with two halves of so many triangles and a soft strip between them.
pub fn book(mut own: Parameters, along: usize) -> Parameters {
    let height = own.mesh.nodes[0][2];
    own.mesh = rectangle(0.2, 0.1, along);
    own.mesh.nodes.iter_mut().for_each(|node| node[2] = height);
    let middle = |[i, j, k]: &[usize; 3]| [i, j, k].map(|n| own.mesh.nodes[*n][0]).iter().sum::<f64>() / 3.0;
    own.regions =
        own.mesh.triangles.iter().map(|t| usize::from((middle(t) - 0.1).abs() < 0.2 / along as f64)).collect();
    let stiff = own.membranes[0];
    own.membranes.push(Membrane { bending_stiffness: 1e-3 * stiff.bending_stiffness, ..stiff });
    own
}

pub fn floor() -> Obstacle<3> {
    Obstacle::plane([0.0; 3], [0.0, 0.0, 1.0])
}

pub fn energy(wing: &mut Wing) -> f64 {
    wing.energy().expect("an energy").total()
}

/// Numbers between 0 and 1, the same in each run.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Throw a wing between solids and walls for 300 steps, or until it folds by 160°. Return the number of steps in contact,
/// the largest gain of energy over what it falls by, and the largest depth of a node in an obstacle, over half the range.
///
/// # Errors
/// A step that fails, or after which the wing passes through itself.
pub fn throw(seed: u64) -> Result<[f64; 3], String> {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1);
    (0..8).for_each(|_| _ = random.between(0.0, 1.0));
    let mut obstacles = vec![floor(), Obstacle::plane([0.0, 0.0, 0.4], [0.0, 0.2, -1.0])];
    for _ in 0..2 {
        let middle = [random.between(0.0, 0.2), random.between(0.0, 0.1), random.between(0.0, 0.1)];
        let half = [0, 1, 2].map(|_| (random.between(-0.04, 0.04)).max(0.0));
        obstacles.push(Obstacle::block(middle, half, random.between(0.01, 0.03)));
    }
    let mut touch = Contact { with_itself: true, ..contact(obstacles.clone()) };
    touch.law.damping = random.between(-100.0, 100.0).max(0.0);
    touch.law.friction = random.between(-1.0, 1.0).max(0.0);
    let mut own = parameters(touch, 0.22);
    let closes = !seed.is_multiple_of(2);
    if closes {
        own = book(own, 6);
    }
    own.gravity = [0.0, 0.0, -9.81];
    own.relaxation_time = 1e-3;
    own.scheme = if random.between(0.0, 1.0) < 0.5 { Scheme::TrBdf2 } else { Scheme::Bdf2 };
    let mut wing = own.build().expect("a wing");
    let spin = [0, 1, 2].map(|_| random.between(-5.0, 5.0));
    let speed = random.between(0.0, 2.0);
    let closing = if closes { random.between(10.0, 20.0) } else { 0.0 };
    let nodes = wing.parameters().mesh.nodes.clone();
    let turning = nodes.iter().map(|[x, y, _]| {
        let arm = [x - 0.1, y - 0.05];
        let up = spin[0] * arm[1] - spin[1] * arm[0] - speed + closing * arm[0].abs();
        [-spin[2] * arm[1], spin[2] * arm[0], up]
    });
    wing.set_velocities(&turning.collect::<Vec<_>>()).expect("velocities");
    let (start, scale) = (energy(&mut wing), wing.energy().expect("an energy").kinetic + AREAL * 0.02 * 9.81 * 0.2);
    let (mut touched, mut gain, mut depth) = (0.0, 0.0_f64, 0.0_f64);
    for step in 0..300 {
        match wing.step(STEP) {
            // So far the model goes.
            Err(Error::Structure(WingError::Fold { .. })) => break,
            done => done.map_err(|error| format!("case {seed}, step {step}: {error}"))?,
        }
        gain = gain.max((energy(&mut wing) - start) / scale);
        touched += f64::from(u8::from(wing.energy().expect("an energy").contact > 0.0));
        let crossings = wing.crossings();
        if crossings > 0 {
            return Err(format!("case {seed}, step {step}: {crossings} pairs of triangles cross"));
        }
        for n in 0..wing.nodes() {
            let place = [0, 1, 2].map(|d| wing.positions(d)[n]).into();
            depth = obstacles.iter().map(|own| -own.nearest(place).distance / (0.5 * RANGE)).fold(depth, f64::max);
        }
    }
    Ok([touched, gain, depth])
}
