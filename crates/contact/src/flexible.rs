//! Contact of rods and wings, which units of their own move, with each other and with bodies on a mount.
//!
//! What sees both announces a load on each for the coming step. With the gap expected after the step, `g + Δt g'`, the
//! force is `f(g + Δt g')` along the normal, and each side falls with its own velocity by `2 k Δt`. With `k Δt`, the true
//! rate of the pair, each side would take the other one for still, and both would answer in full: the pair grows by up to
//! 2.9 times a step. With twice the rate it is stable at every stiffness and ratio of masses.
//!
//! Friction is `μ N` of the normal force at the present gap, against the slip. Its own rate is not announced: the
//! impedance of a station is one number for all directions, so a rate that lets a slip stick would be an inertia that
//! hinders the gap too. Instead friction is at most what stops half of the slip of the two masses in the step: neither
//! side turns the slip around, so friction only takes energy, whatever else slows them. What sticks creeps with the
//! velocity that its load gives it in some steps.

use rigid::{Drag, Force, Freedoms, Kinematics, Vector, join, split};

use crate::bodies::{BodyLaw, Pair, Part as BodyPart, PartMotion, nearest_image};
use crate::cells::Cells;
use crate::law::{Before, Law, largest_stiffness};
use crate::obstacle::{Obstacle, Pose};
use crate::stations::{Loads, Stations};
use crate::surface::{SurfacePoint, nearest_of_triangle, points_of_surface};

/// Rate at which each force falls with the velocity of its side, over that of the pair.
const RATE: f64 = 2.0;

/// Part of the depth that no force reaches to which the depth counts that is expected after the step.
const DEEPEST: f64 = 0.9;

/// Part of a slip that friction stops at most in a step, with the masses of the skins alone.
const HOLD: f64 = 0.5;

/// Most parts of a segment or an edge between points that touch.
const MOST_PARTS: f64 = 64.0;

/// Memory of a point with what finds it, rounded up, bytes.
const BYTES_PER_POINT: usize = 300;

/// Skin by which a flexible body touches others.
#[derive(Clone, Debug)]
pub struct Skin {
    /// Half the thickness at the nodes, m.
    pub radius: Vec<f64>,
    /// Stiffness per metre, N/m², or per area, N/m³, with which a contact with a wall lasts ten communication steps.
    pub largest_stiffness: f64,
    /// Least mass per metre, kg/m, or per area, kg/m², which limits friction.
    pub mass: f64,
}

impl Skin {
    /// Return the half thickness that a surface has for others, m: a quarter of the range of its contact.
    pub fn of_surface(range: f64) -> f64 {
        0.25 * range
    }
}

/// A line or a surface at rest.
#[derive(Clone, Copy, Debug)]
pub struct FlexibleBody<'a, const D: usize> {
    /// Nodes, m.
    pub nodes: &'a [[f64; D]],
    /// Triangles of a surface; absent: a line.
    pub triangles: Option<&'a [[usize; 3]]>,
    /// Its skin; absent: it touches nothing.
    pub skin: Option<&'a Skin>,
}

/// A rigid body on a mount, or one that another unit moves.
#[derive(Clone, Debug)]
pub struct MountedBody<const D: usize> {
    /// Its number.
    pub number: usize,
    /// Its shape.
    pub solid: Obstacle<D>,
    /// Mass, kg, and least moment of inertia, kg m², in the plane per metre of depth.
    pub inertia: [f64; 2],
    /// Mass of the fluid that it displaces, kg.
    pub displaced: f64,
    /// Its pivot in the axes of the shape, m.
    pub pivot: Vector<D>,
    /// How one that another unit moves touches the others; absent of one on a mount.
    pub law: Option<BodyLaw>,
    /// Numbers of the flexible bodies that it carries and does not touch.
    pub carries: Vec<usize>,
}

impl<const D: usize> MountedBody<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return a body on a mount at the middle of its shape that displaces nothing.
    pub fn new(number: usize, solid: Obstacle<D>, inertia: [f64; 2]) -> Self {
        Self { number, solid, inertia, displaced: 0.0, pivot: Vector::zeros(), law: None, carries: vec![] }
    }

    fn part(&self) -> BodyPart<D> {
        let [mass, moment] = self.inertia;
        // A light body is as slow as the fluid that it displaces.
        let inertia = Some([mass.max(self.displaced), moment]);
        BodyPart { solid: self.solid.clone(), inertia, pivot: self.pivot, motion: PartMotion::still(self.solid.pose) }
    }
}

/// Contact of flexible bodies.
pub struct FlexibleContact<const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    parts: Vec<Part>,
    /// Numbers of two parts, with the force per metre or square metre of each.
    pairs: Vec<([usize; 2], [Contacting; 2])>,
    /// Rigid bodies, and the force of each part on them; absent of parts that they carry.
    bodies: Vec<(MountedBody<D>, Vec<Option<Contacting>>)>,
    /// Those of them that touch and that no equations of the fluid know.
    body_pairs: Vec<(Pair<D>, Contacting)>,
    cells: Cells<D>,
    /// Lengths after which everything repeats along the axes, m; infinite: never.
    periods: [f64; D],
    /// Its part of the announced loads of each flexible body.
    loads: Vec<Loads<D>>,
    /// Its part of the loads on those bodies.
    pushes: Vec<MountPush<D>>,
    /// Points that touch.
    touches: Vec<Touch<D>>,
    /// Energy of the contact of parts at the present gaps, J.
    energy: f64,
    /// Who met too fast so far.
    fast: Vec<FastMeeting>,
}

/// Load of contact on a rigid body.
#[derive(Clone, Copy, Debug, Default)]
pub struct MountPush<const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    /// Force, and the rate at which it falls with a change of the velocities.
    pub load: Drag<D>,
    /// Velocities along the freedoms from which they change.
    pub velocities: Freedoms,
    /// Change of those velocities in the step, summed up over its time: m and rad.
    pub change: Freedoms,
}

/// How two sides touch.
#[derive(Clone, Copy)]
struct Contacting {
    law: Law,
    /// Mass with which they slip on each other, per metre, kg/m, or per area, kg/m²; of a body on a mount that of the part.
    mass: f64,
    /// Way of the gap in a step beyond which the range does not stop them, m.
    held: f64,
}

/// Two that may meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Party {
    /// A flexible body by its number.
    Flexible(usize),
    /// A rigid body by its number.
    Body(usize),
}

/// Two that met faster than contact surely stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastMeeting {
    /// Who, in ascending order.
    pub parties: [Party; 2],
    /// Speed at which the gap closed, m/s.
    pub speed: f64,
    /// Speed that the range stops, m/s.
    pub limit: f64,
}

impl Contacting {
    /// Return how two touch by a law, of which `largest` is the stiffness with which a contact lasts ten steps.
    ///
    /// That is π² m/(10 Δt)² of the masses m that meet. The penalty k has stored k h²/6 when it ends its range h, so it
    /// stops v = h (k/(3 m))^(1/2).
    fn new(law: Law, mass: f64, largest: f64) -> Self {
        let held = law.range * (law.stiffness / (3.0 * largest)).sqrt() * largest_stiffness(1.0, 1.0).sqrt();
        Self { law, mass, held }
    }

    /// Note two that meet too fast in a step of `dt` seconds, each pair once.
    fn note(&self, speed: f64, dt: f64, mut parties: [Party; 2], fast: &mut Vec<FastMeeting>) {
        if dt * speed > self.held {
            parties.sort();
            if fast.iter().all(|known| known.parties != parties) {
                fast.push(FastMeeting { parties, speed, limit: self.held / dt });
            }
        }
    }
}

/// Where the contact of parts is added up.
struct Found<'a, const D: usize> {
    loads: &'a mut [Loads<D>],
    touches: &'a mut Vec<Touch<D>>,
    fast: &'a mut Vec<FastMeeting>,
    energy: &'a mut f64,
}

/// A point where two touch.
#[derive(Clone, Copy)]
struct Touch<const D: usize> {
    sides: [Side<D>; 2],
    normal: Vector<D>,
    /// Rate at which the force on each side falls with its velocity, kg/s.
    rate: f64,
}

/// A side of a touch.
#[derive(Clone, Copy)]
enum Side<const D: usize> {
    /// A point of the flexible body with a number.
    Part(usize, Spot),
    /// A rigid body by its place in the list, and the arm from its pivot, m.
    Body(usize, Vector<D>),
}

/// A line or a surface.
struct Part {
    /// Number among the flexible bodies.
    number: usize,
    /// Half the thickness at the stations, m.
    radius: Vec<f64>,
    /// Triangles, of a line segments that name their end twice.
    elements: Vec<[usize; 3]>,
    /// Points that touch, with the length or area of each, m or m².
    points: Vec<SurfacePoint>,
}

/// A point of a part: stations with their shares.
#[derive(Clone, Copy)]
struct Spot {
    stations: [usize; 3],
    shares: [f64; 3],
}

impl<const D: usize> FlexibleContact<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return the contact of the flexible bodies that have a skin with each other and with rigid bodies, and of the bodies
    /// that other units move with those on a mount; none where no two may touch. The stiffness of `own` is per metre or
    /// square metre, and acts at most as that of the skins.
    pub fn new(
        flexible: &[FlexibleBody<D>],
        mounted: Vec<MountedBody<D>>,
        own: &Law,
        periods: [f64; D],
    ) -> Option<Self> {
        let skins: Vec<_> = flexible.iter().enumerate().filter_map(|(k, body)| Some((k, body.skin?))).collect();
        let parts: Vec<_> = skins.iter().map(|(k, skin)| Part::new(*k, &flexible[*k], skin)).collect();
        let is_surface = |k: usize| flexible[k].triangles.is_some();
        let law = |stiffness: f64, radii: f64, range: f64| Law {
            range,
            stiffness: stiffness.min(own.stiffness),
            depth: 0.5 * radii,
            film: None,
            ..*own
        };
        // What a skin of no thickness has as such it takes off the range.
        let range = |k: usize| if is_surface(k) { Skin::of_surface(own.range) } else { 0.0 };
        let mut pairs = Vec::new();
        for j in 0..parts.len() {
            for i in 0..j {
                let of = |[a, b]: [usize; 2]| {
                    let [(one, own_skin), (other, its)] = [skins[a], skins[b]];
                    // A line is as wide as the range.
                    let width = match [one, other].map(is_surface) {
                        [true, false] => 1.0 / own.range,
                        [false, true] => own.range,
                        _ => 1.0,
                    };
                    let [k, l] = [own_skin.largest_stiffness, its.largest_stiffness * width];
                    let [m, n] = [own_skin.mass, its.mass * width];
                    let radii = parts[a].thinnest() + parts[b].thinnest();
                    let law = law(k * l / (k + l), radii, own.range - range(one) - range(other));
                    Contacting::new(law, m * n / (m + n), k * l / (k + l))
                };
                pairs.push(([i, j], [of([i, j]), of([j, i])]));
            }
        }
        let with_parts = |body: MountedBody<D>| {
            let of = |((k, skin), part): (&(usize, &Skin), &Part)| {
                let radii = 2.0 * part.thinnest().min(body.solid.half_thickness());
                let law = law(skin.largest_stiffness, radii, own.range - range(*k));
                (!body.carries.contains(k)).then(|| Contacting::new(law, skin.mass, skin.largest_stiffness))
            };
            let contacting = skins.iter().zip(&parts).map(of).collect();
            (body, contacting)
        };
        let solids: Vec<_> = mounted.iter().map(MountedBody::part).collect();
        let mut body_pairs = Vec::new();
        for j in 0..solids.len() {
            for i in 0..j {
                let (one, two) = (&solids[i], &solids[j]);
                let Some(law) = mounted[i].law.or(mounted[j].law).filter(|_| one.solid.can_touch(&two.solid)) else {
                    continue;
                };
                let mass = 1.0 / (1.0 / one.least_mass() + 1.0 / two.least_mass());
                for pair in Pair::all([i, j], [one, two], &law) {
                    let contacting = Contacting::new(pair.law, mass, largest_stiffness(mass, law.dt));
                    body_pairs.push((pair, contacting));
                }
            }
        }
        let some = !parts.is_empty() || !body_pairs.is_empty();
        let bodies: Vec<_> = mounted.into_iter().map(with_parts).filter(|_| some).collect();
        let loads = flexible.iter().map(|body| Loads::none(body.nodes.len())).collect();
        let most = parts.iter().map(|part| part.elements.len()).max().unwrap_or(0);
        let pushes = bodies.iter().map(|_| MountPush::default()).collect();
        let points = |[i, j]: &[usize; 2]| parts[*i].points.len() + parts[*j].points.len();
        let of_parts = pairs.iter().map(|(pair, _)| points(pair)).sum::<usize>();
        let on_bodies = bodies.len() * parts.iter().map(|part| part.points.len()).sum::<usize>();
        let of_bodies = body_pairs.iter().map(|(pair, _)| pair.count()).sum::<usize>();
        let touches = Vec::with_capacity(of_parts + on_bodies + of_bodies);
        let fast = Vec::with_capacity(pairs.len() + bodies.len() * parts.len() + body_pairs.len());
        (!pairs.is_empty() || !bodies.is_empty()).then(|| Self {
            parts,
            pairs,
            bodies,
            body_pairs,
            cells: Cells::new(most),
            periods,
            loads,
            pushes,
            touches,
            energy: 0.0,
            fast,
        })
    }

    /// Return the approximate memory of the contact of these flexible bodies with each other and with so many rigid ones,
    /// bytes.
    pub fn bytes(flexible: &[FlexibleBody<D>], rigid: usize) -> usize {
        let skins = || flexible.iter().filter_map(|body| Some((body, body.skin?)));
        let others = skins().count().saturating_sub(1).saturating_add(rigid);
        let points = skins().map(|(body, skin)| Part::count(body, skin)).fold(0, usize::saturating_add);
        // A point may touch each of the others, for which there is room.
        points.saturating_mul(BYTES_PER_POINT.saturating_add(size_of::<Touch<D>>().saturating_mul(others)))
    }

    /// Find the contact at these stations for a coming step of `dt` seconds; `pose_of` returns place and motion of the rigid
    /// body with a number.
    pub fn find(
        &mut self,
        stations: &[Stations<D>],
        pose_of: impl Fn(usize) -> Option<(Pose<D>, rigid::Pose<D>)>,
        dt: f64,
    ) {
        self.clear();
        let Self { parts, pairs, bodies, body_pairs, cells, loads, pushes, periods, touches, energy, fast } = self;
        let mut found = Found { loads: &mut *loads, touches: &mut *touches, fast: &mut *fast, energy };
        for ([i, j], laws) in pairs {
            for ([of, on], law) in [[*i, *j], [*j, *i]].into_iter().zip(laws) {
                let [of, on] = [of, on].map(|k| (&parts[k], &stations[parts[k].number]));
                let shift = nearest_image(of.1.middle() - on.1.middle(), periods);
                add_side(of, on, shift, law, dt, cells, &mut found);
            }
        }
        for (k, ((body, laws), push)) in bodies.iter().zip(&mut *pushes).enumerate() {
            let Some((at, pose)) = pose_of(body.number) else { continue };
            push.velocities = pose.rates();
            for (part, contacting) in parts.iter().zip(laws).filter_map(|(part, law)| Some((part, law.as_ref()?))) {
                let own = &stations[part.number];
                let shift = nearest_image(own.middle() - pose.position, periods);
                let meet = |point: &SurfacePoint| {
                    let spot = part.spot(point);
                    let p = spot.on(&own.position) - shift;
                    let nearest = body.solid.nearest_at(&at, p);
                    let gap = nearest.distance - spot.along(&part.radius);
                    (spot, p - pose.position, nearest.normal, gap)
                };
                let mut slipping = *contacting;
                if slipping.law.friction > 0.0 {
                    let sizes = part.points.iter().filter(|point| meet(point).3 < slipping.law.range);
                    slipping.mass =
                        shared_mass(slipping.mass, sizes.map(|point| point.area).sum(), body.inertia, || {
                            part.points.iter().map(meet).map(|(_, arm, ..)| arm.norm()).fold(f64::INFINITY, f64::min)
                        });
                }
                for point in &part.points {
                    let (spot, arm, normal, gap) = meet(point);
                    let velocity = pose.velocity + <[f64; D]>::swing(pose.omega, &arm);
                    let meeting = Meeting { normal, gap, velocity: spot.on(&own.velocity) - velocity };
                    let Some((force, rate)) = meeting.answer(&slipping, dt, point.area) else { continue };
                    spot.give(force, rate, &mut loads[part.number]);
                    push.load.add(-force, Vector::repeat(rate), &arm);
                    touches.push(Touch { sides: [Side::Part(part.number, spot), Side::Body(k, arm)], normal, rate });
                    let parties = [Party::Flexible(part.number), Party::Body(body.number)];
                    contacting.note(-meeting.velocity.dot(&normal), dt, parties, fast);
                }
            }
        }
        for (pair, contacting) in body_pairs {
            let [of, on] = [pair.of, pair.on].map(|k| pose_of(bodies[k].0.number));
            let Some(((place, of), (mut image, on))) = of.zip(on) else { continue };
            let shift = nearest_image(place.origin - image.origin, periods);
            image.origin += shift;
            pair.meet(&bodies[pair.on].0.solid, [&place, &image], |point, gap, normal| {
                let arms = [point - of.position, point - shift - on.position];
                let [one, other] = [(&of, arms[0]), (&on, arms[1])]
                    .map(|(pose, arm)| pose.velocity + <[f64; D]>::swing(pose.omega, &arm));
                let meeting = Meeting { normal, gap, velocity: one - other };
                let Some((force, rate)) = meeting.answer(contacting, dt, 1.0) else { return };
                pushes[pair.of].load.add(force, Vector::repeat(rate), &arms[0]);
                pushes[pair.on].load.add(-force, Vector::repeat(rate), &arms[1]);
                let sides = [Side::Body(pair.of, arms[0]), Side::Body(pair.on, arms[1])];
                touches.push(Touch { sides, normal, rate });
                let parties = [pair.of, pair.on].map(|k| Party::Body(bodies[k].0.number));
                contacting.note(-meeting.velocity.dot(&normal), dt, parties, fast);
            });
        }
    }

    /// Add the difference of the impulses that both sides took in the step of `h` seconds between these stations to those
    /// that they are owed, N s: those of flexible bodies, and those of rigid ones about their pivots, in the order of
    /// [`Self::pushes`].
    ///
    /// `taken` returns which change of the velocity of the station (m/s) of a flexible body lowered its load, and `moved`
    /// that of a rigid body with a number, see [`MountPush::change`].
    ///
    /// Each side takes its force less the rate times the change of its own velocity. Along the normal the sum of both is
    /// owed to them in proportion to their masses, of which the change of the other one tells: what one side gets, the
    /// other one gives, and the pair moves as a whole, without energy of its own. Along the surface each side gets back its
    /// own part, which is no force of the contact.
    pub fn add_owed_impulses(
        &self,
        h: f64,
        ends: [&[Stations<D>]; 2],
        taken: impl Fn(usize, usize, Vector<D>) -> Vector<D>,
        moved: impl Fn(usize) -> Freedoms,
        (owed, of_bodies): (&mut [Loads<D>], &mut [Freedoms]),
    ) {
        for Touch { sides, normal, rate } in &self.touches {
            let change = sides.map(|side| match side {
                Side::Part(number, spot) => {
                    let at = |k: usize| {
                        let [before, now] = ends.map(|stations| node(&stations[number].velocity, k));
                        taken(number, k, now - before)
                    };
                    let parts = spot.stations.into_iter().zip(spot.shares);
                    parts.map(|(k, share)| at(k) * share).sum::<Vector<D>>() * (h * rate)
                }
                Side::Body(k, arm) => {
                    let (way, turn) = split::<D>(&moved(self.bodies[k].0.number));
                    (way + <[f64; D]>::swing(turn, &arm)) * *rate
                }
            });
            let [one, other] = change.map(|own| own.dot(normal));
            let both = one.abs() + other.abs();
            let share = if both > 0.0 { other.abs() / both } else { 0.5 };
            for ((side, change), share) in sides.iter().zip(change).zip([share, 1.0 - share]) {
                let due = change + normal * (share * (one + other) - change.dot(normal));
                match side {
                    Side::Part(number, spot) => {
                        for (k, share) in spot.stations.into_iter().zip(spot.shares) {
                            (0..D).for_each(|axis| owed[*number].force[axis][k] += share * due[axis]);
                        }
                    }
                    Side::Body(k, arm) => {
                        let impulse = join::<D>(&due, <[f64; D]>::cross(arm, &due));
                        of_bodies[*k].iter_mut().zip(impulse).for_each(|(sum, part)| *sum += part);
                    }
                }
            }
        }
    }

    /// Add impulses that the bodies are owed (N s), in the order of [`Self::add_owed_impulses`], to their loads of a
    /// coming step of `dt` seconds.
    pub fn pay(&mut self, dt: f64, owed: &[Loads<D>], of_bodies: &[Freedoms]) {
        for (load, owed) in self.loads.iter_mut().zip(owed) {
            let both = load.force.iter_mut().flatten().zip(owed.force.iter().flatten());
            both.for_each(|(force, impulse)| *force += impulse / dt);
        }
        for (push, owed) in self.pushes.iter_mut().zip(of_bodies) {
            let (force, moment) = split::<D>(&owed.map(|impulse| impulse / dt));
            push.load.force = push.load.force.plus(&Force { force, moment });
        }
    }

    /// Become the contact that another one of the same bodies has found, if there is one.
    pub fn copy_from(&mut self, other: Option<&Self>) {
        self.clear();
        let Some(other) = other else { return };
        self.loads.iter_mut().zip(&other.loads).for_each(|(own, other)| own.copy_from(other));
        self.pushes.iter_mut().zip(&other.pushes).for_each(|(own, other)| *own = *other);
        self.touches.extend_from_slice(&other.touches);
    }

    /// Forget it.
    pub fn clear(&mut self) {
        for own in &mut self.loads {
            own.force.iter_mut().chain([&mut own.impedance]).for_each(|list| list.fill(0.0));
        }
        self.pushes.fill(MountPush::default());
        self.touches.clear();
        self.energy = 0.0;
    }

    /// Add it to the loads of the coming step.
    pub fn add(&self, loads: &mut [Loads<D>]) {
        self.add_times(1.0, loads);
    }

    /// Take it off those loads.
    pub fn take_off(&self, loads: &mut [Loads<D>]) {
        self.add_times(-1.0, loads);
    }

    fn add_times(&self, sign: f64, loads: &mut [Loads<D>]) {
        for (to, own) in loads.iter_mut().zip(&self.loads) {
            let pairs = to.force.iter_mut().chain([&mut to.impedance]).zip(own.force.iter().chain([&own.impedance]));
            pairs.for_each(|(to, own)| to.iter_mut().zip(own).for_each(|(to, own)| *to += sign * own));
        }
    }

    /// Return what it does to rigid bodies in the coming step, each by its number.
    pub fn pushes(&self) -> impl Iterator<Item = (usize, &MountPush<D>)> {
        self.bodies.iter().map(|(body, _)| body.number).zip(&self.pushes)
    }

    /// Return the energy of the contact of flexible bodies with each other at the gaps of [`Self::find`], J.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Return who met faster than contact surely stops, each pair once.
    pub fn fast(&self) -> &[FastMeeting] {
        &self.fast
    }

    /// Return its loads on each flexible body.
    pub fn loads(&self) -> &[Loads<D>] {
        &self.loads
    }
}

/// How a point meets a surface.
struct Meeting<const D: usize> {
    /// Unit normal towards the point.
    normal: Vector<D>,
    /// Gap, m.
    gap: f64,
    /// Velocity of the point relative to the surface, m/s.
    velocity: Vector<D>,
}

impl<const D: usize> Meeting<D> {
    /// Return force and rate on a `size` (m, m²) of the side of the point in a step of `dt` seconds; none out of reach.
    fn answer(&self, Contacting { law, mass, .. }: &Contacting, dt: f64, size: f64) -> Option<(Vector<D>, f64)> {
        let Self { normal, gap, velocity } = self;
        let closing = velocity.dot(normal);
        let (force, rate) = answer(law, [*gap, closing], dt, size)?;
        let mut force = normal * force;
        if law.friction > 0.0 {
            let slip = velocity - normal * closing;
            let pressed = law.penalty(gap.max(-DEEPEST * law.depth)).force;
            let [_, per_slip, _] = law.friction(pressed).response(dt * slip.norm());
            force -= slip * (size * (dt * per_slip).min(HOLD * mass / dt));
        }
        Some((force, rate))
    }
}

/// Return the mass per metre (kg/m) or area (kg/m²) with which a part and a body on a mount slip on each other, where a
/// `size` (m, m²) of the part touches at a distance `arm` (m) from the pivot.
fn shared_mass(mass: f64, size: f64, [own, moment]: [f64; 2], arm: impl Fn() -> f64) -> f64 {
    if size <= 0.0 {
        return mass;
    }
    let arm = if moment.is_finite() { arm() } else { 0.0 };
    let body = 1.0 / (size * (1.0 / own + arm * arm / moment));
    mass * body / (mass + body)
}

/// Return force and rate on a side of a `size` (m, m²) in a step of `dt` seconds from this gap (m) that changes at this
/// rate, m/s; none out of reach.
///
/// The force falls in proportion to the change of the rate. Where sides approach, it falls to that at the present gap
/// while they stop, which is more than the law has between: by its slope at the expected gap, which grows without limit,
/// it would fall to nothing long before.
fn answer(law: &Law, [gap, rate]: [f64; 2], dt: f64, size: f64) -> Option<(f64, f64)> {
    let deepest = -DEEPEST * law.depth;
    let [now, expected] = [gap, gap + dt * rate].map(|gap| gap.max(deepest));
    let before = Some(Before { gap: now, dt });
    let mut found = law.response(expected, before);
    if expected < now {
        found.stiffness = (found.force - law.response(now, before).force) / (now - expected);
    }
    found.force += found.stiffness * (expected - gap - dt * rate).min(-dt * rate).max(0.0);
    let is_far = found.force == 0.0 && found.stiffness == 0.0;
    (!is_far).then_some((size * found.force, RATE * size * dt * found.stiffness))
}

/// Add half of the contact of the points of one part with the image of another part by `shift` (m) in a step of `dt`
/// seconds.
fn add_side<const D: usize>(
    (of, own): (&Part, &Stations<D>),
    (on, other): (&Part, &Stations<D>),
    shift: Vector<D>,
    contacting: &Contacting,
    dt: f64,
    cells: &mut Cells<D>,
    found: &mut Found<D>,
) {
    let speed = |of: &Stations<D>| (0..of.len()).map(|k| node(&of.velocity, k).norm()).fold(0.0, f64::max);
    let reach = contacting.law.range + of.thickest() + on.thickest() + dt * (speed(own) + speed(other));
    let [one, two] = [own, other].map(box_of);
    if (0..D).any(|d| one[0][d] - shift[d] > two[1][d] + reach || two[0][d] > one[1][d] - shift[d] + reach) {
        return;
    }
    let corners = |element: &[usize; 3]| element.map(|k| node(&other.position, k));
    let longest = |[a, b, c]: [Vector<D>; 3]| (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let longest = on.elements.iter().map(|element| longest(corners(element))).fold(0.0, f64::max);
    // No point of an element is farther from its middle than its longest edge.
    let middles = on.elements.iter().map(|element| {
        let [a, b, c] = corners(element);
        ((a + b + c) / 3.0).into()
    });
    cells.sort(reach + longest, middles);
    for point in &of.points {
        let spot = of.spot(point);
        let p = spot.on(&own.position) - shift;
        let mut best: Option<(Spot, Vector<D>)> = None;
        cells.visit(p.into(), |element| {
            let corners = corners(&on.elements[element]);
            let shares = nearest_of_triangle(p, corners);
            let from = p - (corners[0] * shares[0] + corners[1] * shares[1] + corners[2] * shares[2]);
            if best.is_none_or(|(_, known)| from.norm_squared() < known.norm_squared()) {
                best = Some((Spot { stations: on.elements[element], shares }, from));
            }
        });
        let Some((touched, from)) = best else { continue };
        let normal = from / from.norm().max(f64::MIN_POSITIVE);
        let gap = from.norm() - spot.along(&of.radius) - touched.along(&on.radius);
        let meeting = Meeting { normal, gap, velocity: spot.on(&own.velocity) - touched.on(&other.velocity) };
        let Some((force, rate)) = meeting.answer(contacting, dt, 0.5 * point.area) else { continue };
        spot.give(force, rate, &mut found.loads[of.number]);
        touched.give(-force, rate, &mut found.loads[on.number]);
        *found.energy += 0.5 * point.area * contacting.law.penalty(gap.max(-DEEPEST * contacting.law.depth)).potential;
        let sides = [Side::Part(of.number, spot), Side::Part(on.number, touched)];
        found.touches.push(Touch { sides, normal, rate });
        let parties = [of.number, on.number].map(Party::Flexible);
        contacting.note(-meeting.velocity.dot(&normal), dt, parties, found.fast);
    }
}

impl Part {
    /// Return the part that a flexible body is, so many of whose points touch that nothing passes between two.
    ///
    /// Crossing edges come closer to each other than to a point by up to half its distance from the next. Forces end half
    /// the sum of the radii before middles meet, of which each body leaves its own to the other one.
    fn new<const D: usize>(number: usize, body: &FlexibleBody<D>, skin: &Skin) -> Self {
        let (radius, parts) = (skin.radius.clone(), Self::divided(body, skin));
        if let Some(triangles) = body.triangles {
            let nodes: Vec<_> =
                body.nodes.iter().map(|node| std::array::from_fn(|d| node.get(d).copied().unwrap_or(0.0))).collect();
            let points = points_of_surface(&nodes, triangles, parts);
            return Self { number, radius, elements: triangles.to_vec(), points };
        }
        let segments = body.nodes.len().saturating_sub(1);
        let length = |k: usize| (Vector::from(body.nodes[k + 1]) - Vector::from(body.nodes[k])).norm();
        let point = |m: usize| {
            let triangle = (m / parts).min(segments - 1);
            let share = (m - triangle * parts) as f64 / parts as f64;
            let part = length(triangle) / parts as f64;
            let area = if m == 0 || m == segments * parts { 0.5 * part } else { part };
            SurfacePoint { triangle, shares: [1.0 - share, share, 0.0], area }
        };
        let points = if segments > 0 { (0..=segments * parts).map(point).collect() } else { vec![] };
        Self { number, radius, elements: (0..segments).map(|k| [k, k + 1, k + 1]).collect(), points }
    }

    /// Return into how many parts the points divide each segment or edge.
    fn divided<const D: usize>(body: &FlexibleBody<D>, skin: &Skin) -> usize {
        let spacing = 2.0 * skin.radius.iter().copied().fold(f64::INFINITY, f64::min);
        let place = |k: usize| Vector::from(body.nodes.get(k).copied().unwrap_or([f64::NAN; D]));
        let length = |[a, b]: [usize; 2]| (place(a) - place(b)).norm();
        let longest = match body.triangles {
            Some(triangles) => {
                let edges = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
                edges.map(length).fold(0.0, f64::max)
            }
            None => (1..body.nodes.len()).map(|k| length([k, k - 1])).fold(0.0, f64::max),
        };
        (longest / spacing).ceil().clamp(1.0, MOST_PARTS) as usize
    }

    /// Return about how many points it has: as many triangles and nodes as a disk has edges.
    fn count<const D: usize>(body: &FlexibleBody<D>, skin: &Skin) -> usize {
        let (nodes, parts) = (body.nodes.len(), Self::divided(body, skin));
        let triangles = body.triangles.map_or(0, <[_]>::len);
        let inner = parts.saturating_sub(2) * (parts - 1) / 2 * triangles;
        nodes + (nodes + triangles) * (parts - 1) + inner
    }

    fn spot(&self, point: &SurfacePoint) -> Spot {
        Spot { stations: self.elements[point.triangle], shares: point.shares }
    }

    fn thinnest(&self) -> f64 {
        self.radius.iter().copied().fold(f64::INFINITY, f64::min)
    }

    fn thickest(&self) -> f64 {
        self.radius.iter().copied().fold(0.0, f64::max)
    }
}

impl Spot {
    fn along(self, of: &[f64]) -> f64 {
        self.stations.iter().zip(self.shares).map(|(k, share)| share * of[*k]).sum()
    }

    fn on<const D: usize>(self, of: &[Vec<f64>; D]) -> Vector<D> {
        Vector::from_fn(|axis, _| self.along(&of[axis]))
    }

    fn give<const D: usize>(self, force: Vector<D>, rate: f64, loads: &mut Loads<D>) {
        for (k, share) in self.stations.into_iter().zip(self.shares) {
            (0..D).for_each(|axis| loads.force[axis][k] += share * force[axis]);
            loads.impedance[k] += share * rate;
        }
    }
}

fn node<const D: usize>(of: &[Vec<f64>; D], k: usize) -> Vector<D> {
    Vector::from_fn(|axis, _| of[axis][k])
}

/// Return the low and the high end of the box around the stations, m.
fn box_of<const D: usize>(of: &Stations<D>) -> [[f64; D]; 2] {
    let fold = |by: fn(f64, f64) -> f64| of.position.each_ref().map(|all| all.iter().copied().fold(all[0], by));
    [fold(f64::min), fold(f64::max)]
}
