//! Rods thrown between obstacles, for a test and a study.

use std::f64::consts::PI;

use nervure_rod::{Contact, Law, Obstacle, Parameters, Rod, RootSupport, Scheme, Section, largest_stiffness};

pub const SECTION: Section =
    Section { line_density: 2.0, bending_stiffness: 0.5, axial_stiffness: 2e4, shear_stiffness: None };

/// Contact of half a thickness `radius` with obstacles, with the stiffness for steps of `dt`.
pub fn contact<const D: usize>(segments: usize, radius: f64, dt: f64, obstacles: Vec<Obstacle<D>>) -> Contact<D> {
    let stiffness = largest_stiffness(SECTION.line_density, dt);
    let law = Law { range: 2.0 * radius, stiffness, depth: radius, damping: 0.0, friction: 0.0, film: None };
    Contact { law, radius: vec![radius; segments + 1], with_itself: false, obstacles }
}

/// Numbers between 0 and 1, the same in each run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Throw a rod between obstacles for 300 steps. Return the number of steps in contact, the largest gain of energy over
/// what it falls by, and the largest depth of an axis in an obstacle or another strand, over half the thickness.
///
/// # Errors
/// A step that fails.
pub fn throw<const D: usize>(seed: u64) -> Result<[f64; 3], String> {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) + 1);
    (0..8).for_each(|_| _ = random.next());
    let (segments, radius, dt) = (12 + (random.next() * 12.0) as usize, random.between(5e-3, 2e-2), 1e-3);
    let mut obstacles = Vec::new();
    for k in 0..3 {
        let middle = std::array::from_fn(|d| match d {
            0 => 0.3 * f64::from(k) + random.between(0.0, 0.2),
            1 => -random.between(0.15, 0.3),
            _ => random.between(-0.05, 0.05),
        });
        let half = std::array::from_fn(|_| if random.next() < 0.5 { 0.0 } else { random.between(0.02, 0.08) });
        obstacles.push(Obstacle::block(middle, half, random.between(0.02, 0.06)));
    }
    obstacles.push(Obstacle::plane(
        std::array::from_fn(|d| if d == 1 { -0.35 } else { 0.0 }),
        std::array::from_fn(|d| f64::from(u8::from(d == 1))),
    ));
    let bending_stiffness = 10_f64.powf(random.between(-3.0, 0.0));
    let section = Section { bending_stiffness, ..SECTION };
    let mut parameters = Parameters::<D>::new(random.between(0.6, 1.2), segments, section);
    parameters.gravity[1] = -9.81;
    parameters.scheme = if random.next() < 0.5 { Scheme::TrBdf2 } else { Scheme::Bdf2 };
    parameters.support = match (random.next() * 3.0) as usize {
        0 => RootSupport::Free,
        1 => RootSupport::Pinned,
        _ => RootSupport::Clamped,
    };
    let mut touch = contact(segments, radius, dt, obstacles.clone());
    touch.law.damping = if random.next() < 0.5 { 0.0 } else { random.between(0.0, 200.0) };
    touch.law.friction = if random.next() < 0.5 { 0.0 } else { random.next() };
    touch.with_itself = true;
    parameters.contact = Some(touch);
    let mut rod = Rod::new(parameters).unwrap();
    let mut state = rod.state().clone();
    let spin = random.between(-6.0, 6.0);
    for k in 1..=segments {
        state.velocities[k][1] = -random.between(0.0, 2.0) - spin * k as f64 / segments as f64;
        state.velocities[k][D - 1] += random.between(-0.5, 0.5);
    }
    rod.restore(&state).unwrap();
    let total = |rod: &Rod<D>| {
        let energy = rod.energy().unwrap();
        energy.kinetic + energy.stretching + energy.bending + energy.contact + energy.gravity
    };
    let (start, scale) = (total(&rod), rod.energy().unwrap().kinetic + SECTION.line_density * 9.81 * 0.35);
    let (mut least, mut touched, mut gain, mut depth) = (start, 0.0, 0.0_f64, 0.0_f64);
    for step in 0..300 {
        rod.step(dt).map_err(|error| format!("case {seed}, step {step}: {error}"))?;
        let (now, touching) = (total(&rod), rod.energy().unwrap().contact);
        // BDF2 takes three steps over the impulse of a hard contact: the energy dips meanwhile.
        let limit = if touching == 0.0 { least } else { start };
        gain = gain.max((now - limit) / scale);
        if touching == 0.0 {
            least = least.min(now);
        } else {
            touched += 1.0;
        }
        depth = depth.max(deepest(&rod, &obstacles, radius) / radius);
    }
    Ok([touched, gain, depth])
}

/// Return the largest depth of a node in an obstacle, or of a segment in another strand, m.
fn deepest<const D: usize>(rod: &Rod<D>, obstacles: &[Obstacle<D>], radius: f64) -> f64 {
    let place = |k: usize| std::array::from_fn::<_, D, _>(|d| rod.positions(d)[k]).into();
    let nodes: Vec<_> = (0..rod.positions(0).len()).map(place).collect();
    let segment = rod.parameters().length / (nodes.len() - 1) as f64;
    // A root that is held beside an obstacle does not touch it over 1.5 times the distance of contact.
    let is_free = matches!(rod.parameters().support, RootSupport::Free);
    let held = if is_free { 0 } else { (1.5 * 3.0 * radius / segment).ceil() as usize + 1 };
    let in_obstacles = obstacles.iter().flat_map(|own| nodes[held..].iter().map(|x| radius - own.nearest(*x).distance));
    // Strands touch from half a circle of their distance on, which here is four radii.
    let apart = (2.0 * PI * radius / segment).ceil() as usize + 1;
    let between = |i: usize, j: usize| {
        let (edge, from) = (nodes[j + 1] - nodes[j], nodes[i] - nodes[j]);
        let share = (from.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        2.0 * radius - (from - edge * share).norm()
    };
    let pairs = (0..nodes.len()).flat_map(|i| (0..nodes.len() - 1).map(move |j| (i, j)));
    let in_strands = pairs.filter(|(i, j)| i.abs_diff(*j).min(i.abs_diff(j + 1)) > apart).map(|(i, j)| between(i, j));
    in_obstacles.chain(in_strands).fold(0.0, f64::max)
}
