//! Contact of rods and wings, which units of their own move, with each other and with the bodies on a mount.
//!
//! The fluid sees both, and adds their contact to the loads that it announces. With the gap expected after the step,
//! `g + Δt g'`, the force is `f(g + Δt g')` along the normal, and each side falls with its own velocity by `2 k Δt`. With
//! `k Δt`, the true rate of the pair, each side would take the other one for still, and both would answer in full: the pair
//! grows by up to 2.9 times a step. With twice the rate it is stable at every stiffness and ratio of masses.

use contact::{Before, Cells, Law, Obstacle, SurfacePoint, nearest_image, nearest_of_triangle, points_of_surface};

use crate::bodies::{Bodies, Carried, Push, place};
use crate::force::Exchange;
use crate::parameters::{Extent, Flexible, Parameters, Skin};
use crate::space::{Kinematics, Space, Vector};
use crate::stations::{Loads, Stations};

/// Rate at which each force falls with the velocity of its side, over that of the pair.
const RATE: f64 = 2.0;

/// Part of the depth that no force reaches to which the depth counts that is expected after the step.
const DEEPEST: f64 = 0.9;

/// Most parts of a segment or an edge between points that touch.
const MOST_PARTS: f64 = 64.0;

/// Contact of flexible bodies.
pub struct FlexibleContact<const D: usize>
where
    [f64; D]: Space<D>,
{
    parts: Vec<Part>,
    /// Numbers of two parts, with the force per metre or square metre of each.
    pairs: Vec<([usize; 2], [Law; 2])>,
    /// Bodies on a mount by their numbers among the rigid ones, and the force of each part on them.
    bodies: Vec<(usize, Obstacle<D>, Vec<Law>)>,
    cells: Cells<D>,
    /// Lengths after which everything repeats along the axes, m; infinite: never.
    periods: [f64; D],
    /// Its part of the announced loads of each flexible body.
    loads: Vec<Loads<D>>,
    /// Its part of the loads on those bodies on a mount.
    pushes: Vec<Push<D>>,
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
    [f64; D]: Space<D>,
{
    /// Return the contact of the flexible bodies that have a skin; none where no two may touch.
    pub fn new(parameters: &Parameters<D>) -> Option<Self> {
        let own = parameters.contact.as_ref()?;
        let skins: Vec<_> = own.skins.iter().enumerate().filter_map(|(k, skin)| Some((k, skin.as_ref()?))).collect();
        let parts: Vec<_> = skins.iter().map(|(k, skin)| Part::new(*k, &parameters.flexible[*k], skin)).collect();
        let is_surface = |k: usize| matches!(parameters.flexible[k].extent, Extent::Surface(_));
        let law = |stiffness: f64, radii: f64, range: f64| Law {
            range,
            stiffness: stiffness.min(own.flexible_stiffness),
            depth: 0.5 * radii,
            damping: own.law.damping,
            friction: 0.0,
            film: None,
        };
        // What a skin of no thickness has as such it takes off the range.
        let range = |k: usize| if is_surface(k) { Skin::of_surface(own.law.range) } else { 0.0 };
        let mut pairs = Vec::new();
        for j in 0..parts.len() {
            for i in 0..j {
                let of = |[a, b]: [usize; 2]| {
                    let [(one, own_skin), (other, its)] = [skins[a], skins[b]];
                    // A line is as wide as the range.
                    let width = match [one, other].map(is_surface) {
                        [true, false] => 1.0 / own.law.range,
                        [false, true] => own.law.range,
                        _ => 1.0,
                    };
                    let [k, l] = [own_skin.largest_stiffness, its.largest_stiffness * width];
                    let radii = parts[a].thinnest() + parts[b].thinnest();
                    law(k * l / (k + l), radii, own.law.range - range(one) - range(other))
                };
                pairs.push(([i, j], [of([i, j]), of([j, i])]));
            }
        }
        let on_mount = parameters.bodies.iter().enumerate().filter(|(_, body)| body.mount().is_some());
        let bodies: Vec<_> = on_mount
            .filter_map(|(number, body)| {
                let solid = body.shape.obstacle()?;
                let of = |((k, skin), part): (&(usize, &Skin), &Part)| {
                    law(
                        skin.largest_stiffness,
                        2.0 * part.thinnest().min(solid.half_thickness()),
                        own.law.range - range(*k),
                    )
                };
                let laws = skins.iter().zip(&parts).map(of).collect();
                Some((number, solid, laws))
            })
            .filter(|_| !parts.is_empty())
            .collect();
        let loads = parameters.flexible.iter().map(|body| Loads::none(body.nodes.len())).collect();
        let most = parts.iter().map(|part| part.elements.len()).max().unwrap_or(0);
        let pushes = bodies.iter().map(|_| Push::default()).collect();
        (!pairs.is_empty() || !bodies.is_empty()).then(|| Self {
            parts,
            pairs,
            bodies,
            cells: Cells::new(most),
            periods: own.periods,
            loads,
            pushes,
        })
    }

    /// Find the contact at these stations and places of the bodies for a coming step of `dt` seconds.
    pub fn find(&mut self, stations: &[Stations<D>], rigid: &Bodies<D>, carried: &[Carried<D>], dt: f64) {
        self.clear();
        let Self { parts, pairs, bodies, cells, loads, pushes, periods } = self;
        for ([i, j], laws) in pairs {
            for ([of, on], law) in [[*i, *j], [*j, *i]].into_iter().zip(laws) {
                let [of, on] = [of, on].map(|k| (&parts[k], &stations[parts[k].number]));
                let shift = nearest_image(of.1.middle() - on.1.middle(), periods);
                add_side(of, on, shift, law, dt, cells, loads);
            }
        }
        for ((number, solid, laws), push) in bodies.iter().zip(pushes) {
            let found = rigid.carried().zip(carried).find(|((k, _), _)| k == number);
            let Some(((_, rigid), carried)) = found else { continue };
            let pose = rigid.pose_of(&carried.now);
            push.velocities = pose.rates();
            let at = place(rigid.body(), &pose);
            for (part, law) in parts.iter().zip(laws) {
                let own = &stations[part.number];
                let shift = nearest_image(own.middle() - pose.position, periods);
                for point in &part.points {
                    let spot = part.spot(point);
                    let p = spot.on(&own.position) - shift;
                    let nearest = solid.nearest_at(&at, p);
                    let gap = nearest.distance - spot.along(&part.radius);
                    let arm = p - pose.position;
                    let velocity = pose.velocity + <[f64; D]>::swing(pose.omega, &arm);
                    let closing = (spot.on(&own.velocity) - velocity).dot(&nearest.normal);
                    let Some((force, rate)) = answer(law, [gap, closing], dt, point.area) else { continue };
                    let force = nearest.normal * force;
                    spot.give(force, rate, &mut loads[part.number]);
                    push.load.add(-force, Vector::repeat(rate), &arm);
                }
            }
        }
    }

    /// Become the contact that another fluid has found, if it has any.
    pub fn copy_from(&mut self, other: Option<&Self>) {
        self.clear();
        let Some(other) = other else { return };
        self.loads.iter_mut().zip(&other.loads).for_each(|(own, other)| own.copy_from(other));
        self.pushes.iter_mut().zip(&other.pushes).for_each(|(own, other)| *own = *other);
    }

    /// Forget it.
    pub fn clear(&mut self) {
        for own in &mut self.loads {
            own.force.iter_mut().chain([&mut own.impedance]).for_each(|list| list.fill(0.0));
        }
        self.pushes.fill(Push::default());
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

    /// Return what it does to bodies on a mount in the coming step, each by its number.
    pub fn pushes(&self) -> impl Iterator<Item = (usize, &Push<D>)> {
        self.bodies.iter().map(|(number, ..)| *number).zip(&self.pushes)
    }

    /// Add its power and its work in a step of `h` seconds between these stations to the exchange with each body.
    pub fn exchange(&self, h: f64, ends: [&[Stations<D>]; 2], exchange: &mut [Exchange<D>]) {
        for (((own, before), now), to) in self.loads.iter().zip(ends[0]).zip(ends[1]).zip(exchange) {
            let power = |axis: usize| {
                let parts = own.force[axis].iter().zip(&own.impedance);
                let velocities = before.velocity[axis].iter().zip(&now.velocity[axis]);
                parts.zip(velocities).map(|((force, rate), (v_0, v))| (force - rate * (v - v_0)) * v).sum::<f64>()
            };
            let power: f64 = (0..D).map(power).sum();
            (to.power, to.work) = (to.power + power, to.work + h * power);
        }
    }
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
    law: &Law,
    dt: f64,
    cells: &mut Cells<D>,
    loads: &mut [Loads<D>],
) {
    let speed = |of: &Stations<D>| (0..of.len()).map(|k| node(&of.velocity, k).norm()).fold(0.0, f64::max);
    let reach = law.range + of.thickest() + on.thickest() + dt * (speed(own) + speed(other));
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
        let closing = (spot.on(&own.velocity) - touched.on(&other.velocity)).dot(&normal);
        let Some((force, rate)) = answer(law, [gap, closing], dt, 0.5 * point.area) else { continue };
        spot.give(normal * force, rate, &mut loads[of.number]);
        touched.give(normal * -force, rate, &mut loads[on.number]);
    }
}

impl Part {
    /// Return the part that a flexible body is, so many of whose points touch that nothing passes between two.
    ///
    /// Crossing edges come closer to each other than to a point by up to half its distance from the next. Forces end half
    /// the sum of the radii before middles meet, of which each body leaves its own to the other one.
    fn new<const D: usize>(number: usize, body: &Flexible<D>, skin: &Skin) -> Self {
        let place = |k: usize| Vector::from(body.nodes[k]);
        let (radius, spacing) = (skin.radius.clone(), 2.0 * skin.radius.iter().copied().fold(f64::INFINITY, f64::min));
        let parts = |length: f64| (length / spacing).ceil().clamp(1.0, MOST_PARTS) as usize;
        if let Extent::Surface(triangles) = &body.extent {
            let edges = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
            let longest = edges.map(|[a, b]| (place(a) - place(b)).norm()).fold(0.0, f64::max);
            let nodes: Vec<_> =
                body.nodes.iter().map(|node| std::array::from_fn(|d| node.get(d).copied().unwrap_or(0.0))).collect();
            let points = points_of_surface(&nodes, triangles, parts(longest));
            return Self { number, radius, elements: triangles.clone(), points };
        }
        let segments = body.nodes.len().saturating_sub(1);
        let length = |k: usize| (place(k + 1) - place(k)).norm();
        let parts = parts((0..segments).map(length).fold(0.0, f64::max));
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
