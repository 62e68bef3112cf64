//! Rigid bodies that fly without a fluid, in two-step backward differences, for tests and a study.

use std::array::from_fn;

use method::Support;
use nalgebra::SVector;
use nervure_contact::{BodyContacts, BodyLaw, Obstacle, Part, PartMotion, Pose};
use rigid::{DisplacementHistory, Drag, Freedoms, Kinematics, Mass, MountedStep, SpringDynamics, SpringMotion, join};

/// A free body: its shape, mass, kg, and moment of inertia, kg m², place, m, and velocities.
pub struct Free<const D: usize> {
    pub solid: Obstacle<D>,
    pub mass: f64,
    pub inertia: f64,
    pub place: [f64; D],
    pub rates: Freedoms,
}

/// Bodies on their way.
pub struct World<const D: usize>
where
    [f64; D]: SpringDynamics<D>,
{
    pub contacts: BodyContacts<D>,
    pub bodies: Vec<(Free<D>, DisplacementHistory<D>)>,
    pub gravity: SVector<f64, D>,
    dt: f64,
    last: f64,
}

pub const LAW: BodyLaw =
    BodyLaw { range: 0.05, stiffness: f64::INFINITY, damping: 0.0, friction: 0.0, film: None, dt: 1e-3 };

const SUPPORT: Option<Support> = Some(Support { stiffness: 0.0, damping: 0.0, rest: 0.0 });

fn pose<const D: usize>(body: &Free<D>, at: &rigid::Pose<D>) -> Pose<D>
where
    [f64; D]: SpringDynamics<D>,
{
    let by = <[f64; D]>::orientation(&Default::default(), at.angle);
    let unit = |d: usize| SVector::from_fn(|e, _| f64::from(u8::from(d == e)));
    Pose { axes: from_fn(|d| <[f64; D]>::turn(&by, unit(d))), origin: SVector::from(body.place) + at.position }
}

impl<const D: usize> World<D>
where
    [f64; D]: SpringDynamics<D>,
{
    pub fn new(bodies: Vec<Free<D>>, obstacles: Vec<Obstacle<D>>, law: &BodyLaw) -> Self {
        let moving = bodies.iter().map(|body| {
            let motion = PartMotion { free: [true; 6], ..PartMotion::still(Pose::at(body.place)) };
            let inertia = Some([body.mass, body.inertia]);
            Part { solid: body.solid.clone(), inertia, pivot: SVector::zeros(), motion }
        });
        let still = obstacles.into_iter().map(|solid| {
            let motion = PartMotion::still(solid.pose);
            Part { solid, inertia: None, pivot: SVector::zeros(), motion }
        });
        let contacts = BodyContacts::new(moving.chain(still).collect(), law).expect("all can touch");
        let begun = |body: Free<D>| {
            let now = rigid::Pose::new(&[0.0; 6], &body.rates);
            (body, DisplacementHistory { now, before: now, acceleration: [0.0; 6] })
        };
        let bodies = bodies.into_iter().map(begun).collect();
        Self { contacts, bodies, gravity: SVector::zeros(), dt: law.dt, last: 0.0 }
    }

    pub fn step(&mut self) -> Result<(), [usize; 2]> {
        let h = self.dt;
        let c = if self.last == 0.0 { [1.0 / h, 1.0 / h, 0.0] } else { [1.5 / h, 2.0 / h, -0.5 / h] };
        let none = Mass { mass: 0.0, inertia: [[0.0; 3]; 3], arm: SVector::zeros() };
        let mut found = Vec::new();
        for (k, (body, history)) in self.bodies.iter().enumerate() {
            let inertia = from_fn(|i| from_fn(|j| if i == j { body.inertia } else { 0.0 }));
            let weight = join::<D>(&(self.gravity * body.mass), Default::default());
            let step = MountedStep {
                supports: &[SUPPORT; 6],
                history,
                c,
                mass: body.mass,
                inertia,
                fluid: none,
                weight,
                predicted: history.predicted(h, self.last).rates(),
            };
            let motion = step.solve(&Drag::default());
            let poses = [pose(body, &history.now), pose(body, &motion.displacement)];
            let (rates, matrix) = (motion.displacement.rates(), motion.matrix);
            *self.contacts.motion_mut(k) = PartMotion { poses, rates, matrix, free: [true; 6] };
            found.push(motion);
        }
        if let Some(changes) = self.contacts.solve(c[0], h)? {
            found.iter_mut().zip(changes).for_each(|(motion, change)| motion.add(change, c[0], &none));
        }
        for ((_, history), SpringMotion { displacement, acceleration, .. }) in self.bodies.iter_mut().zip(found) {
            *history = DisplacementHistory { now: displacement, before: history.now, acceleration };
        }
        self.last = h;
        Ok(())
    }

    /// Turn a body by an angle, rad.
    pub fn turn(&mut self, k: usize, angle: [f64; 3]) {
        let (_, history) = &mut self.bodies[k];
        let turned = from_fn(|i| if i < D { history.now.position[i] } else { angle[i - D] });
        history.now = rigid::Pose::new(&turned, &history.now.rates());
        history.before = history.now;
    }

    /// Return the kinetic energy, J.
    pub fn energy(&self) -> f64 {
        let kinetic = |(body, history): &(Free<D>, DisplacementHistory<D>)| {
            let rates = history.now.rates();
            let square = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
            0.5 * (body.mass * square(&rates[..D]) + body.inertia * square(&rates[D..]))
        };
        self.bodies.iter().map(kinetic).sum()
    }
}

pub fn ball<const D: usize>(radius: f64, place: [f64; D], velocity: f64) -> Free<D> {
    let rates = from_fn(|i| if i == D - 1 { velocity } else { 0.0 });
    Free { solid: Obstacle::block([0.0; D], [0.0; D], radius), mass: 2.0, inertia: 0.01, place, rates }
}

pub fn floor<const D: usize>() -> Obstacle<D> {
    Obstacle::plane([0.0; D], from_fn(|d| if d == D - 1 { 1.0 } else { 0.0 }))
}

/// A number from 0 to 1.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Let bodies fly in a closed box for 200 steps. Return the number of steps in contact, the largest gain of energy over
/// that at the start, and the largest depth over half the thickness of the thinner body.
///
/// # Errors
/// A step that fails.
pub fn fly<const D: usize>(case: u64) -> Result<[f64; 3], String>
where
    [f64; D]: SpringDynamics<D>,
{
    let shape = |random: &mut Random| {
        let radius = random.between(0.15, 0.3);
        let long = random.between(0.1, 0.4);
        let half = match random.between(0.0, 3.0) as usize {
            0 => [0.0; D],
            1 => from_fn(|d| if d == 0 { long } else { 0.0 }),
            _ if D == 2 => from_fn(|d| if d == 0 { long } else { 0.2 }),
            _ => [0.0; D],
        };
        let radius = if half[1] > 0.0 { 0.0 } else { radius };
        let size = half.iter().map(|half| half * half).sum::<f64>() + radius * radius;
        (Obstacle::block([0.0; D], half, radius), size)
    };
    throw(case, shape, Obstacle::block([0.0; D], [0.0; D], 0.15))
}

/// Let bodies of these shapes, each with the square of its size, m², fly as [`fly`] does, about a pillar.
///
/// # Errors
/// A step that fails.
pub fn throw<const D: usize>(
    case: u64,
    shape: impl Fn(&mut Random) -> (Obstacle<D>, f64),
    pillar: Obstacle<D>,
) -> Result<[f64; 3], String>
where
    [f64; D]: SpringDynamics<D>,
{
    let mut random = Random(88_172_645_463_325_252_u64.wrapping_mul(2 * case + D as u64));
    (0..8).for_each(|_| _ = random.next());
    let law = BodyLaw {
        range: random.between(0.03, 0.1),
        stiffness: 10.0_f64.powf(random.between(2.0, 9.0)),
        damping: if case.is_multiple_of(3) { random.between(0.0, 50.0) } else { 0.0 },
        friction: if case.is_multiple_of(2) { random.between(0.0, 1.0) } else { 0.0 },
        dt: 2e-3,
        ..LAW
    };
    let mut bodies = Vec::<Free<D>>::new();
    for k in 0..4 {
        let (solid, size) = shape(&mut random);
        let mass = 10.0_f64.powf(random.between(-0.5, 0.5));
        let place = from_fn(|d| (if k >> d & 1 == 0 { -0.8 } else { 0.8 }) + random.between(-0.05, 0.05));
        let rates = from_fn(|i| if i < <[f64; D]>::FREEDOMS { random.between(-1.0, 1.0) } else { 0.0 });
        bodies.push(Free { solid, mass, inertia: 0.4 * mass * size, place, rates });
    }
    let walls = (0..2 * D).map(|k| {
        let (axis, side) = (k / 2, if k % 2 == 0 { 1.0 } else { -1.0 });
        let along = |size: f64| from_fn(|d| if d == axis { size } else { 0.0 });
        Obstacle::plane(along(-1.6 * side), along(side))
    });
    let mut world = World::new(bodies, walls.chain([pillar]).collect(), &law);
    let (start, [mut touched, mut most, mut depth]) = (world.energy(), [0.0, 0.0_f64, 0.0_f64]);
    for step in 0..200 {
        world.step().map_err(|[i, j]| format!("case {case}, step {step}: {i} is in {j}"))?;
        most = most.max(world.energy());
        let touching = world.contacts.touching();
        touched += f64::from(u8::from(!touching.is_empty()));
        for (pair, gap, _) in touching {
            let half = pair.map(|part| world.contacts.parts()[part].solid.half_thickness());
            depth = depth.max(-gap / half[0].min(half[1]));
        }
    }
    Ok([touched, most / start - 1.0, depth])
}
