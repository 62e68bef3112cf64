//! Rigid bodies without a fluid, in two-step backward differences.

use std::array::from_fn;
use std::f64::consts::PI;

use method::Support;
use nalgebra::SVector;
use nervure_contact::{BodyContacts, BodyFilm, BodyLaw, Obstacle, Part, PartMotion, Pose};
use rigid::{Carried, Drag, Freedoms, Kinematics, Mass, MountedStep, SpringMotion, join};

/// A free body: its shape, mass, kg, and moment of inertia, kg m², place, m, and velocities.
struct Free<const D: usize> {
    solid: Obstacle<D>,
    mass: f64,
    inertia: f64,
    place: [f64; D],
    rates: Freedoms,
}

/// Bodies on their way.
struct World<const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    contacts: BodyContacts<D>,
    bodies: Vec<(Free<D>, Carried<D>)>,
    gravity: SVector<f64, D>,
    dt: f64,
    last: f64,
}

const LAW: BodyLaw =
    BodyLaw { range: 0.05, stiffness: f64::INFINITY, damping: 0.0, friction: 0.0, film: None, dt: 1e-3 };

const SUPPORT: Option<Support> = Some(Support { stiffness: 0.0, damping: 0.0, rest: 0.0 });

fn pose<const D: usize>(body: &Free<D>, at: &rigid::Pose<D>) -> Pose<D>
where
    [f64; D]: Kinematics<D>,
{
    let by = <[f64; D]>::orientation(&Default::default(), at.angle);
    let unit = |d: usize| SVector::from_fn(|e, _| f64::from(u8::from(d == e)));
    Pose { axes: from_fn(|d| <[f64; D]>::turn(&by, unit(d))), origin: SVector::from(body.place) + at.position }
}

impl<const D: usize> World<D>
where
    [f64; D]: Kinematics<D>,
{
    fn new(bodies: Vec<Free<D>>, obstacles: Vec<Obstacle<D>>, law: &BodyLaw) -> Self {
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
            (body, Carried { now, before: now, acceleration: [0.0; 6] })
        };
        let bodies = bodies.into_iter().map(begun).collect();
        Self { contacts, bodies, gravity: SVector::zeros(), dt: law.dt, last: 0.0 }
    }

    fn step(&mut self) -> Result<(), [usize; 2]> {
        let h = self.dt;
        let c = if self.last == 0.0 { [1.0 / h, 1.0 / h, 0.0] } else { [1.5 / h, 2.0 / h, -0.5 / h] };
        let none = Mass { mass: 0.0, inertia: [[0.0; 3]; 3], arm: SVector::zeros() };
        let mut found = Vec::new();
        for (k, (body, carried)) in self.bodies.iter().enumerate() {
            let inertia = from_fn(|i| from_fn(|j| if i == j { body.inertia } else { 0.0 }));
            let weight = join::<D>(&(self.gravity * body.mass), Default::default());
            let step = MountedStep {
                supports: &[SUPPORT; 6],
                carried,
                c,
                mass: body.mass,
                inertia,
                fluid: none,
                weight,
                predicted: carried.predicted(h, self.last).rates(),
            };
            let motion = step.solve(&Drag::default());
            let poses = [pose(body, &carried.now), pose(body, &motion.displacement)];
            let (rates, matrix) = (motion.displacement.rates(), motion.matrix);
            *self.contacts.motion_mut(k) = PartMotion { poses, rates, matrix, free: [true; 6] };
            found.push(motion);
        }
        if let Some(changes) = self.contacts.solve(c[0], h)? {
            found.iter_mut().zip(changes).for_each(|(motion, change)| motion.add(change, c[0], &none));
        }
        for ((_, carried), SpringMotion { displacement, acceleration, .. }) in self.bodies.iter_mut().zip(found) {
            *carried = Carried { now: displacement, before: carried.now, acceleration };
        }
        self.last = h;
        Ok(())
    }

    /// Return the kinetic energy, J.
    fn energy(&self) -> f64 {
        let kinetic = |(body, carried): &(Free<D>, Carried<D>)| {
            let rates = carried.now.rates();
            let square = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
            0.5 * (body.mass * square(&rates[..D]) + body.inertia * square(&rates[D..]))
        };
        self.bodies.iter().map(kinetic).sum()
    }
}

fn ball<const D: usize>(radius: f64, place: [f64; D], velocity: f64) -> Free<D> {
    let rates = from_fn(|i| if i == D - 1 { velocity } else { 0.0 });
    Free { solid: Obstacle::block([0.0; D], [0.0; D], radius), mass: 2.0, inertia: 0.01, place, rates }
}

fn floor<const D: usize>() -> Obstacle<D> {
    Obstacle::plane([0.0; D], from_fn(|d| if d == D - 1 { 1.0 } else { 0.0 }))
}

/// Return the speed after a fall of a ball of 2 kg at 1 m/s on a floor.
fn rebound<const D: usize>(law: &BodyLaw) -> f64
where
    [f64; D]: Kinematics<D>,
{
    let mut place = [0.0; D];
    // So thick that what keeps it from half its thickness adds nothing.
    place[D - 1] = 10.0 + 3.0 * law.range.max(law.film.map_or(0.0, |film| film.range));
    let mut world = World::new(vec![ball(10.0, place, -1.0)], vec![floor()], law);
    for _ in 0..100_000 {
        world.step().unwrap();
        let now = &world.bodies[0].1.now;
        if now.velocity[D - 1] > 0.0 && now.position[D - 1] > 0.0 {
            return now.velocity[D - 1];
        }
    }
    0.0
}

#[test]
fn a_ball_on_spring_and_damper_loses_the_exact_share_of_its_speed() {
    for zeta in [0.0, 0.05, 0.3] {
        let stiffness = 2e4_f64;
        let damping = 2.0 * zeta * (2.0 * stiffness).sqrt();
        let dt = PI * (2.0 / stiffness).sqrt() / 1000.0;
        let law = BodyLaw { range: 1e-5, stiffness, damping, dt, ..LAW };
        let exact = (-PI * zeta / (1.0_f64 - zeta * zeta).sqrt()).exp();
        let found = [rebound::<2>(&law), rebound::<3>(&law)];
        for found in found {
            assert!((found - exact).abs() < 1e-3, "damping ratio {zeta}: {found} against {exact}");
        }
    }
}

#[test]
fn a_contact_of_ten_steps_keeps_the_speed_within_some_per_cent() {
    for k in 0..50 {
        let found = rebound::<2>(&BodyLaw { range: 0.01 + 2e-5 * f64::from(k), ..LAW });
        assert!(found <= 1.0 + 1e-9 && found > 0.95, "{k}: {found}");
    }
}

/// e = 1 − 2 (ln(h_0/h_min) + 1)/St with p = 1, and by the same impulse ∫ dh/h^(3/2) in the plane.
#[test]
fn a_ball_keeps_the_exact_speed_through_a_film() {
    let (range, least, radius) = (0.1_f64, 1e-3_f64, 10.0_f64);
    for (loss, steps) in [0.1, 0.3, 0.6].into_iter().flat_map(|loss| [2.0, 20.0].map(|steps| (loss, steps))) {
        let viscosity = |impulse: f64| 0.5 * loss * 2.0 / impulse;
        let space = 6.0 * PI * radius * radius * ((range / least).ln() + 1.0);
        let plane = 3.0
            * 2.0_f64.sqrt()
            * PI
            * radius.powf(1.5)
            * (2.0 / least.sqrt() - 2.0 / range.sqrt() + 1.0 / least.sqrt());
        let law = |impulse: f64| {
            let film = Some(BodyFilm { viscosity: viscosity(impulse), range, least });
            BodyLaw { range: 1e-8, stiffness: 1e12, film, dt: range / steps, ..LAW }
        };
        let found = [rebound::<2>(&law(plane)), rebound::<3>(&law(space))];
        for found in found {
            assert!((found - 1.0 + loss).abs() < 0.015, "{found} in {steps} steps against {}", 1.0 - loss);
        }
    }
}

/// A number from 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Let bodies fly in a closed box, where a step refuses what is deeper than half a thickness; return the
/// largest energy over that at the start.
fn fly<const D: usize>(random: &mut Random, law: &BodyLaw) -> f64
where
    [f64; D]: Kinematics<D>,
{
    let mut bodies = Vec::<Free<D>>::new();
    for k in 0..4 {
        let radius = random.between(0.15, 0.3);
        let long = random.between(0.1, 0.4);
        let half = match random.between(0.0, 3.0) as usize {
            0 => [0.0; D],
            1 => from_fn(|d| if d == 0 { long } else { 0.0 }),
            _ if D == 2 => from_fn(|d| if d == 0 { long } else { 0.2 }),
            _ => [0.0; D],
        };
        let radius = if half[1] > 0.0 { 0.0 } else { radius };
        let mass = 10.0_f64.powf(random.between(-0.5, 0.5));
        let size = half.iter().map(|half| half * half).sum::<f64>() + radius * radius;
        let place = from_fn(|d| (if k >> d & 1 == 0 { -0.8 } else { 0.8 }) + random.between(-0.05, 0.05));
        let rates = from_fn(|i| if i < <[f64; D]>::FREEDOMS { random.between(-1.0, 1.0) } else { 0.0 });
        bodies.push(Free {
            solid: Obstacle::block([0.0; D], half, radius),
            mass,
            inertia: 0.4 * mass * size,
            place,
            rates,
        });
    }
    let walls = (0..2 * D).map(|k| {
        let (axis, side) = (k / 2, if k % 2 == 0 { 1.0 } else { -1.0 });
        let along = |size: f64| from_fn(|d| if d == axis { size } else { 0.0 });
        Obstacle::plane(along(-1.6 * side), along(side))
    });
    let pillar = Obstacle::block([0.0; D], [0.0; D], 0.15);
    let mut world = World::new(bodies, walls.chain([pillar]).collect(), law);
    let (start, mut most) = (world.energy(), 0.0_f64);
    for _ in 0..200 {
        world.step().unwrap_or_else(|[i, j]| panic!("{i} is in {j}"));
        most = most.max(world.energy());
    }
    most / start
}

#[test]
fn hundreds_of_random_bodies_stay_apart_and_gain_no_energy() {
    let mut random = Random(88_172_645_463_325_252);
    for case in 0..120 {
        let law = BodyLaw {
            range: random.between(0.03, 0.1),
            stiffness: 10.0_f64.powf(random.between(2.0, 9.0)),
            damping: if case % 3 == 0 { random.between(0.0, 50.0) } else { 0.0 },
            friction: if case % 2 == 0 { random.between(0.0, 1.0) } else { 0.0 },
            dt: 2e-3,
            ..LAW
        };
        for found in [fly::<2>(&mut random, &law), fly::<3>(&mut random, &law)] {
            assert!(found < 1.0 + 1e-12, "case {case}: the energy grows to {found} of that at the start; {law:?}");
        }
    }
}

/// A ball hands its speed to one of the same mass beyond the edge of a periodic box.
#[test]
fn balls_touch_across_the_edge_of_a_periodic_box() {
    let law = BodyLaw { range: 0.02, ..LAW };
    let world = World::<2>::new(vec![ball(0.05, [0.0, 0.9], 1.0), ball(0.05, [0.0, -0.9], 0.0)], vec![], &law);
    let mut world = World { contacts: world.contacts.with_periods([f64::INFINITY, 2.0]), ..world };
    (0..300).for_each(|_| world.step().expect("they stay apart"));
    let [first, second] = [0, 1].map(|k| world.bodies[k].1.now.velocity[1]);
    assert!(first.abs() < 0.05 && (second - 1.0).abs() < 0.05, "{first} and {second} m/s");
}
