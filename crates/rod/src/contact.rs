//! Contact of the rod with obstacles and with itself.
//!
//! ```text
//! U_c(x) = Σ_m w_m U(g_m),      g_m = d(p_m) − r_m
//! ```
//!
//! Balls of radius r_m touch at points p_m that divide each segment into equal parts, w_m is the length of rod that
//! belongs to one, and U the potential of a [`Law`] per metre of rod. d is the distance from an obstacle, or from each
//! strand of the rod that passes by, less its radius. Each side of a pair counts half, so all forces between strands
//! are equal and opposite.
//!
//! A pair couples nodes that are far apart, outside the band of the Newton matrix. With the stiffness k along the
//! normal n the matrix takes 2 k n nᵀ for each side alone, which is at least the true coupling:
//!
//! ```text
//! [ 2 0 ]   [  1 −1 ]   [ 1 1 ]
//! [ 0 2 ] − [ −1  1 ] = [ 1 1 ] ≥ 0,
//! ```
//!
//! so the update descends, and the iteration converges to the true minimum, each time by 2 k/(2 k + m/Δt²) or better.

use std::f64::consts::FRAC_PI_2;

use ::contact::{
    Cells, ContactError, Encounter, HELD, Law, MOST_PARTNERS, Meeting, Obstacle, Obstacles, Push, keep_one_of_each_bend,
};
use structure::{Matrix, Vector, check_law, finite, positive};

use crate::{Error, RodError};

/// Distance up to which an equilibrium seeks strands, over that at which they touch.
const STATIC_SEARCH: f64 = 3.0;

/// What a rod touches, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact<const D: usize> {
    /// Forces per metre of rod.
    pub law: Law,
    /// Half the thickness at the nodes, m: `[n + 1]`.
    pub radius: Vec<f64>,
    /// Whether the rod touches itself.
    pub with_itself: bool,
    /// What else it touches.
    pub obstacles: Vec<Obstacle<D>>,
}

impl<const D: usize> Contact<D> {
    /// Refuse numbers outside their ranges.
    pub(crate) fn check(&self, nodes: usize) -> Result<(), Error> {
        check_law(&self.law)?;
        Error::check_length("contact.radius", self.radius.len(), nodes)?;
        self.radius.iter().enumerate().try_for_each(|(k, r)| positive(format!("contact.radius[{k}]"), *r))?;
        self.obstacles.iter().try_for_each(|own| finite("contact.obstacles", own.pose.origin.as_slice()))
    }
}

/// A point of the rod: its segment, and the share of the way along it.
#[derive(Clone, Copy)]
struct Spot {
    segment: usize,
    share: f64,
}

/// Closest point of another strand.
#[derive(Clone, Copy)]
struct Strand<const D: usize> {
    spot: Spot,
    /// Vector from there, m.
    from: Vector<D>,
    distance: f64,
}

/// Contact of a rod during a stage.
pub(crate) struct Contacts<const D: usize> {
    own: Contact<D>,
    /// Length of a segment at rest, m.
    segment_length: f64,
    /// Distance of centre lines at which the thickest parts touch, m.
    touching: f64,
    /// Length of rod between points that touch, m: half a circle of that diameter.
    apart: f64,
    /// Points of contact in a segment.
    parts: usize,
    /// First point of contact that touches each obstacle.
    begins: Vec<usize>,
    pub(crate) obstacles: Obstacles<D>,
    /// Length of the stage, s; `None` in an equilibrium.
    dt: Option<f64>,
    /// Largest motion of a node in the stage that the search allows for, m.
    allowed: f64,
    cells: Cells<D>,
    /// Segments of strands that each point may touch, one a strand; those of point m end at `ends[m]`.
    partners: Vec<u32>,
    ends: Vec<usize>,
}

impl<const D: usize> Contacts<D> {
    /// Return the contact of the rod with this shape at rest, m: `[n + 1]`, whose root is held or not.
    pub(crate) fn new(own: Contact<D>, rest: &[Vector<D>], segment_length: f64, is_held: bool) -> Self {
        let range = own.law.range;
        let thinnest = own.radius.iter().copied().fold(f64::INFINITY, f64::min);
        let touching = 2.0 * own.radius.iter().copied().fold(0.0, f64::max) + own.law.reach();
        let parts = (segment_length / (thinnest + range)).ceil() as usize;
        let segments = rest.len() - 1;
        let behind = |obstacle: &Obstacle<D>| {
            let touches = obstacle.nearest(rest[0]).distance < own.radius[0] + range;
            let length = if touches && is_held { HELD * (own.radius[0] + range) } else { 0.0 };
            (length / segment_length * parts as f64).ceil() as usize
        };
        let points = segments * parts + 1;
        let searched = if own.with_itself { points } else { 0 };
        Self {
            begins: own.obstacles.iter().map(behind).collect(),
            obstacles: Obstacles::new(own.obstacles.clone()),
            dt: None,
            allowed: f64::INFINITY,
            cells: Cells::new(if own.with_itself { segments } else { 0 }),
            partners: Vec::with_capacity(MOST_PARTNERS * searched),
            ends: vec![0; searched],
            touching,
            apart: FRAC_PI_2 * touching,
            own,
            segment_length,
            parts,
        }
    }

    /// Begin a stage of `dt` (s) between these fractions of the step, from `origin` (m) to the first guess `guess`.
    pub(crate) fn begin(
        &mut self,
        origin: &[Vector<D>],
        guess: &[Vector<D>],
        dt: f64,
        between: [f64; 2],
    ) -> Result<(), Error> {
        self.dt = Some(dt);
        self.obstacles.begin(between);
        let predicted = origin.iter().zip(guess).map(|(x, guess)| (guess - x).norm()).fold(0.0, f64::max);
        self.allowed = predicted + 0.5 * self.own.law.range;
        self.search(origin, 2.0 * self.allowed)
    }

    /// Return whether the rod of this shape (m) and velocity (m/s) may touch anything in `dt`, s.
    pub(crate) fn may_touch(&mut self, x: &[Vector<D>], velocity: &[Vector<D>], dt: f64) -> Result<bool, Error> {
        let closer = 2.0 * dt * velocity.iter().map(Vector::norm).fold(0.0, f64::max);
        self.begin_static(x)?;
        self.search(x, closer)?;
        let (reach, mut may) = (self.own.law.reach() + closer, !self.obstacles.are_still());
        self.visit(x, x, reach, |met| may |= met.met.gaps[1] < reach);
        Ok(may)
    }

    /// Begin an equilibrium from the shape `origin`, m.
    pub(crate) fn begin_static(&mut self, origin: &[Vector<D>]) -> Result<(), Error> {
        self.dt = None;
        self.obstacles.begin_static();
        self.allowed = f64::INFINITY;
        self.search(origin, (STATIC_SEARCH - 1.0) * self.touching)
    }

    /// Find the strands that each point may touch if they come closer by `closer`, m.
    fn search(&mut self, x: &[Vector<D>], closer: f64) -> Result<(), Error> {
        if !self.own.with_itself {
            return Ok(());
        }
        let longest = x.windows(2).map(|ends| (ends[1] - ends[0]).norm()).fold(0.0, f64::max);
        let near = self.touching + closer;
        self.cells.sort(near + 0.5 * longest, x.windows(2).map(|ends| ((ends[0] + ends[1]) * 0.5).into()));
        self.partners.clear();
        for m in 0..self.ends.len() {
            let (spot, ..) = self.point(m);
            let (p, begin, last) = (at(x, spot), self.partners.len(), x.len() - 2);
            let Self { cells, partners, segment_length: l0, apart, .. } = self;
            let mut found = 0;
            cells.visit(p.into(), |j| {
                let own = strand(x, p, j).distance;
                let beside =
                    |j: usize| if is_apart(spot, j, *l0, *apart) { strand(x, p, j).distance } else { f64::INFINITY };
                let is_closest = (j == 0 || own <= beside(j - 1)) && (j == last || own < beside(j + 1));
                if own < near && is_apart(spot, j, *l0, *apart) && is_closest {
                    found += 1;
                    if found <= MOST_PARTNERS {
                        partners.push(j as u32);
                    }
                }
            });
            if found > MOST_PARTNERS {
                return Err(
                    RodError::from(ContactError::Crowded { node: spot.segment, found, most: MOST_PARTNERS }).into()
                );
            }
            let distance = |j: u32| strand(x, p, j as usize).distance;
            let are_apart = |i: u32, j: u32| f64::from(i.abs_diff(j)) * *l0 > *apart;
            keep_one_of_each_bend(partners, begin, distance, are_apart);
            self.ends[m] = self.partners.len();
        }
        Ok(())
    }

    /// Return a point of contact, the length of rod that belongs to it, m, and the radius there, m.
    fn point(&self, m: usize) -> (Spot, f64, f64) {
        let Self { parts, ref own, segment_length, .. } = *self;
        let last = (own.radius.len() - 1) * parts;
        let segment = (m / parts).min(own.radius.len() - 2);
        let spot = Spot { segment, share: (m - segment * parts) as f64 / parts as f64 };
        let length = segment_length / parts as f64;
        (spot, if m == 0 || m == last { 0.5 * length } else { length }, self.radius_at(spot))
    }

    fn radius_at(&self, Spot { segment, share }: Spot) -> f64 {
        let radius = &self.own.radius;
        radius[segment] + share * (radius[segment + 1] - radius[segment])
    }

    /// Return the closest point to `p`, which belongs to `spot`, of the strand near segment `j`.
    fn walk(&self, x: &[Vector<D>], p: Vector<D>, spot: Spot, j: usize) -> Strand<D> {
        let mut best = strand(x, p, j);
        loop {
            let j = best.spot.segment;
            let beside = [j.checked_sub(1), (j + 2 < x.len()).then_some(j + 1)].into_iter().flatten();
            let beside = beside.filter(|&j| is_apart(spot, j, self.segment_length, self.apart));
            let beside = beside.map(|j| strand(x, p, j));
            match beside.min_by(|a, b| a.distance.total_cmp(&b.distance)) {
                Some(next) if next.distance < best.distance => best = next,
                _ => return best,
            }
        }
    }

    /// Visit each point of contact and what it may touch in the shape `x`, from the shape `origin`, m.
    ///
    /// Obstacles that stay farther than `reach` (m) are left out.
    fn visit(&self, x: &[Vector<D>], origin: &[Vector<D>], reach: f64, mut visit: impl FnMut(Meeting<Spot, D>)) {
        for m in 0..(x.len() - 1) * self.parts + 1 {
            let (spot, length, radius) = self.point(m);
            let (p, p_before) = (at(x, spot), at(origin, spot));
            for (i, _) in self.begins.iter().enumerate().filter(|(_, begin)| m >= **begin) {
                if let Some(met) = self.obstacles.meet(i, [p_before, p], radius, reach) {
                    visit(Meeting { spot, size: length, partners: None, met });
                }
            }
            let begin = if m == 0 { 0 } else { self.ends.get(m - 1).copied().unwrap_or(0) };
            for &j in &self.partners[begin..self.ends.get(m).copied().unwrap_or(begin)] {
                let (before, now) = (self.walk(origin, p_before, spot, j as usize), self.walk(x, p, spot, j as usize));
                visit(Meeting {
                    spot,
                    size: 0.5 * length,
                    partners: Some([before.spot, now.spot]),
                    met: Encounter {
                        distances: [before.distance, now.distance],
                        gaps: [before, now].map(|own| own.distance - radius - self.radius_at(own.spot)),
                        normals: [before, now].map(|own| own.from / own.distance.max(f64::MIN_POSITIVE)),
                        curvature: Matrix::zeros(),
                        slip: p - at(x, before.spot) - before.from,
                    },
                });
            }
        }
    }

    /// Pass the parts of the potential in the shape `x` of a stage from `origin`, m, to `emit`: spot, push and partner.
    fn pushes(&self, x: &[Vector<D>], origin: &[Vector<D>], mut emit: impl FnMut(Spot, Push<D>, Option<Spot>)) {
        let law = &self.own.law;
        self.visit(x, origin, law.reach(), |meeting| {
            meeting.pushes(law, self.dt).for_each(|(push, partner)| emit(meeting.spot, push, partner));
        });
    }

    /// Return the potential of the shape `x` in a stage from `origin`, m, in J.
    pub(crate) fn potential(&self, x: &[Vector<D>], origin: &[Vector<D>]) -> f64 {
        let mut sum = 0.0;
        self.pushes(x, origin, |_, push, _| sum += push.potential);
        sum
    }

    /// Return the energy of the penalty in the shape `x`, J.
    pub(crate) fn energy(&self, x: &[Vector<D>]) -> f64 {
        let mut sum = 0.0;
        self.visit(x, x, self.own.law.reach(), |meeting| {
            sum += meeting.size * self.own.law.penalty(meeting.met.gaps[1]).potential
        });
        sum
    }

    /// Write the forces on the nodes in the shape `x` of a stage from `origin`, N: `[n + 1]`.
    pub(crate) fn find_forces(&self, x: &[Vector<D>], origin: &[Vector<D>], forces: &mut [Vector<D>]) {
        forces.fill(Vector::zeros());
        self.pushes(x, origin, |spot, Push { force, .. }, partner| {
            let parts = [(Some(spot), force), (partner, -force)];
            for (Spot { segment, share }, force) in parts.into_iter().filter_map(|(spot, force)| Some((spot?, force))) {
                forces[segment] += force * (1.0 - share);
                forces[segment + 1] += force * share;
            }
        });
    }

    /// Pass second derivatives of the potential, or more, to `emit`: by the node k twice, by k and k + 1, and by k + 1
    /// twice, N/m.
    pub(crate) fn hessian(&self, x: &[Vector<D>], origin: &[Vector<D>], mut emit: impl FnMut(usize, [Matrix<D>; 3])) {
        self.pushes(x, origin, |spot, Push { hessian, .. }, partner| {
            let both = if partner.is_some() { 2.0 } else { 1.0 };
            for Spot { segment, share } in [Some(spot), partner].into_iter().flatten() {
                let (first, second) = (1.0 - share, share);
                emit(segment, [first * first, first * second, second * second].map(|part| hessian * (both * part)));
            }
        });
    }

    /// Refuse a stage from `origin` to `x`, m, in which the rod may have passed through something.
    pub(crate) fn check(&self, x: &[Vector<D>], origin: &[Vector<D>]) -> Result<(), RodError> {
        let mut result = Ok(());
        if self.own.with_itself {
            let moved = x.iter().zip(origin).map(|(x, before)| (x - before).norm()).fold(0.0, f64::max);
            if moved > self.allowed {
                return Err(ContactError::Hasty { moved, allowed: self.allowed }.into());
            }
        }
        self.visit(x, origin, f64::INFINITY, |Meeting { spot: Spot { segment: node, .. }, met, .. }| {
            if met.passes_through() && self.dt.is_some() {
                result = Err(ContactError::Through { node }.into());
            }
        });
        result
    }

    /// Refuse a shape `x`, m, in which something lies too deep in the rod.
    pub(crate) fn check_depth(&mut self, x: &[Vector<D>]) -> Result<(), Error> {
        self.begin_static(x)?;
        let (mut result, allowed) = (Ok(()), self.own.law.depth);
        self.visit(
            x,
            x,
            0.0,
            |Meeting { spot: Spot { segment: node, .. }, met: Encounter { gaps: [gap, _], .. }, .. }| {
                if -gap >= allowed {
                    result = Err(RodError::from(ContactError::Deep { node, depth: -gap, allowed }).into());
                }
            },
        );
        result
    }
}

/// Return the place of a spot in the shape `x`, m.
fn at<const D: usize>(x: &[Vector<D>], Spot { segment, share }: Spot) -> Vector<D> {
    x[segment] + (x[segment + 1] - x[segment]) * share
}

/// Return the closest point to `p` of segment `j`.
fn strand<const D: usize>(x: &[Vector<D>], p: Vector<D>, j: usize) -> Strand<D> {
    let (edge, offset) = (x[j + 1] - x[j], p - x[j]);
    let share = (offset.dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
    let from = offset - edge * share;
    Strand { spot: Spot { segment: j, share }, from, distance: from.norm() }
}

/// Return whether more than `apart` (m) of the rod, of segments of this length, lies between a spot and segment `j`.
fn is_apart(spot: Spot, j: usize, segment_length: f64, apart: f64) -> bool {
    let (own, j) = (spot.segment as f64 + spot.share, j as f64);
    (j - own).max(own - j - 1.0) * segment_length > apart
}
