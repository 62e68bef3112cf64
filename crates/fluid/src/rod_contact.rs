//! Contact of lines that are set from outside, rods of units of their own, with each other.
//!
//! The fluid sees both, and adds their contact to the loads that it announces. With the gap expected after the step,
//! `g + Δt g'`, the force is `f(g + Δt g')` along the normal, and each side falls with its own velocity by `2 k Δt`. With
//! `k Δt`, the true rate of the pair, each side would take the other one for still, and both would answer in full: the pair
//! grows by up to 2.9 times a step. With twice the rate it is stable at every stiffness and ratio of masses.

use contact::{Before, Law};

use crate::force::Exchange;
use crate::parameters::{Flexible, Parameters, Skin};
use crate::space::{Space, Vector};
use crate::stations::{Loads, Stations};

/// Rate at which each force falls with the velocity of its side, over that of the pair.
const RATE: f64 = 2.0;

/// Contact of lines.
pub struct RodContact<const D: usize> {
    lines: Vec<Line>,
    /// Numbers of two lines, with their force per metre.
    pairs: Vec<([usize; 2], Law)>,
    /// Its part of the announced loads of each flexible body.
    loads: Vec<Loads<D>>,
}

/// A line.
struct Line {
    /// Number among the flexible bodies.
    number: usize,
    /// Half the thickness at the stations, m.
    radius: Vec<f64>,
    /// Points in a segment that touch.
    parts: usize,
}

/// A point of a line: its segment, and the share of the way along it.
#[derive(Clone, Copy)]
struct Spot {
    segment: usize,
    share: f64,
}

impl<const D: usize> RodContact<D>
where
    [f64; D]: Space<D>,
{
    /// Return the contact of the lines that have a skin; none of fewer than two.
    pub fn new(parameters: &Parameters<D>) -> Option<Self> {
        let own = parameters.contact.as_ref()?;
        let skins: Vec<_> = own.skins.iter().enumerate().filter_map(|(k, skin)| Some((k, skin.as_ref()?))).collect();
        let mut pairs = Vec::new();
        for (j, (_, two)) in skins.iter().enumerate() {
            for (i, (_, one)) in skins[..j].iter().enumerate() {
                let [k, l] = [one, two].map(|skin| skin.largest_stiffness);
                let stiffness = own.rod_stiffness.min(k * l / (k + l));
                let (range, damping) = (own.law.range, own.law.damping);
                let law = Law { range, stiffness, depth: f64::INFINITY, damping, friction: 0.0, film: None };
                pairs.push(([i, j], law));
            }
        }
        let line = |(number, skin): (usize, &Skin)| Line {
            number,
            parts: parts_in_segment(&parameters.flexible[number], skin, own.law.range),
            radius: skin.radius.clone(),
        };
        let lines = skins.into_iter().map(line).collect();
        let loads = parameters.flexible.iter().map(|body| Loads::none(body.nodes.len())).collect();
        (!pairs.is_empty()).then_some(Self { lines, pairs, loads })
    }

    /// Find the contact at these stations for a coming step of `dt` seconds.
    pub fn find(&mut self, stations: &[Stations<D>], dt: f64) {
        self.clear();
        let Self { lines, pairs, loads } = self;
        for ([i, j], law) in pairs {
            for [of, on] in [[*i, *j], [*j, *i]] {
                let [of, on] = [of, on].map(|k| (&lines[k], &stations[lines[k].number]));
                add_side(of, on, law, dt, loads);
            }
        }
    }

    /// Become the contact that another fluid has found, if it has any.
    pub fn copy_from(&mut self, other: Option<&Self>) {
        self.clear();
        let loads = other.iter().flat_map(|other| &other.loads);
        self.loads.iter_mut().zip(loads).for_each(|(own, other)| own.copy_from(other));
    }

    /// Forget it.
    pub fn clear(&mut self) {
        for own in &mut self.loads {
            own.force.iter_mut().chain([&mut own.impedance]).for_each(|list| list.fill(0.0));
        }
    }

    /// Add it to the loads of the coming step.
    pub fn add(&self, loads: &mut [Loads<D>]) {
        for (to, own) in loads.iter_mut().zip(&self.loads) {
            let pairs = to.force.iter_mut().chain([&mut to.impedance]).zip(own.force.iter().chain([&own.impedance]));
            pairs.for_each(|(to, own)| to.iter_mut().zip(own).for_each(|(to, own)| *to += own));
        }
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

/// Add half of the contact of the points of one line with another line in a step of `dt` seconds.
fn add_side<const D: usize>(
    (of, own): (&Line, &Stations<D>),
    (on, other): (&Line, &Stations<D>),
    law: &Law,
    dt: f64,
    loads: &mut [Loads<D>],
) {
    let segments = own.len() - 1;
    for m in 0..=segments * of.parts {
        let segment = (m / of.parts).min(segments - 1);
        let spot = Spot { segment, share: (m - segment * of.parts) as f64 / of.parts as f64 };
        let point = spot.on(&own.position);
        let Some((touched, from)) = closest(point, &other.position) else { continue };
        let normal = from / from.norm().max(f64::MIN_POSITIVE);
        let gap = from.norm() - spot.along(&of.radius) - touched.along(&on.radius);
        let closing = (spot.on(&own.velocity) - touched.on(&other.velocity)).dot(&normal);
        let found = law.response(gap + dt * closing, Some(Before { gap, dt }));
        if found.force == 0.0 && found.stiffness == 0.0 {
            continue;
        }
        let part = (node(own, segment + 1) - node(own, segment)).norm() / of.parts as f64;
        let length = if m == 0 || m == segments * of.parts { 0.25 * part } else { 0.5 * part };
        let (force, rate) = (normal * (length * found.force), RATE * length * dt * found.stiffness);
        spot.give(force, rate, &mut loads[of.number]);
        touched.give(-force, rate, &mut loads[on.number]);
    }
}

impl Spot {
    fn along(self, of: &[f64]) -> f64 {
        of[self.segment] + self.share * (of[self.segment + 1] - of[self.segment])
    }

    fn on<const D: usize>(self, of: &[Vec<f64>; D]) -> Vector<D> {
        Vector::from_fn(|axis, _| self.along(&of[axis]))
    }

    fn give<const D: usize>(self, force: Vector<D>, rate: f64, loads: &mut Loads<D>) {
        for (k, share) in [(self.segment, 1.0 - self.share), (self.segment + 1, self.share)] {
            (0..D).for_each(|axis| loads.force[axis][k] += share * force[axis]);
            loads.impedance[k] += share * rate;
        }
    }
}

/// Return how many points of a segment touch: so many that nothing passes between two.
fn parts_in_segment<const D: usize>(body: &Flexible<D>, skin: &Skin, range: f64) -> usize {
    let segment = |ends: &[[f64; D]]| (Vector::from(ends[1]) - Vector::from(ends[0])).norm();
    let longest = body.nodes.windows(2).map(segment).fold(0.0, f64::max);
    let thinnest = skin.radius.iter().copied().fold(f64::INFINITY, f64::min);
    (longest / (thinnest + range)).ceil().max(1.0) as usize
}

fn node<const D: usize>(stations: &Stations<D>, k: usize) -> Vector<D> {
    Vector::from_fn(|axis, _| stations.position[axis][k])
}

/// Return the closest spot of a line to a point (m), and the vector from there.
fn closest<const D: usize>(point: Vector<D>, line: &[Vec<f64>; D]) -> Option<(Spot, Vector<D>)> {
    let spots = (0..line[0].len() - 1).map(|segment| {
        let [from, to] = [0.0, 1.0].map(|share| Spot { segment, share }.on(line));
        let (edge, offset) = (to - from, point - from);
        let share = (offset.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        (Spot { segment, share }, offset - edge * share)
    });
    spots.min_by(|(_, a), (_, b)| a.norm_squared().total_cmp(&b.norm_squared()))
}
