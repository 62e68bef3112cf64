//! A point of a part that deforms, and a surface that it may touch, in a stage of a step.

use nalgebra::{SMatrix, SVector};

use crate::law::{Before, Law};
use crate::obstacle::{Obstacle, Pose};

/// A point and a surface that it may touch.
#[derive(Clone, Copy, Debug)]
pub struct Encounter<const D: usize> {
    /// Distances of the point at begin and end, m.
    pub distances: [f64; 2],
    /// The same less the radii around point and surface, m.
    pub gaps: [f64; 2],
    /// Unit normals towards the point.
    pub normals: [SVector<f64, D>; 2],
    /// Second derivative of the distance at the end, 1/m.
    pub curvature: SMatrix<f64, D, D>,
    /// Motion of the point relative to the surface, m.
    pub slip: SVector<f64, D>,
}

/// Part of the potential: a function of the place of the point relative to the surface.
#[derive(Clone, Copy, Debug)]
pub struct Push<const D: usize> {
    /// Potential, J.
    pub potential: f64,
    /// Force on the point, and against it on the surface, N.
    pub force: SVector<f64, D>,
    /// Second derivative, N/m.
    pub hessian: SMatrix<f64, D, D>,
}

impl<const D: usize> Encounter<D> {
    /// Return whether the point may have passed through the surface.
    pub fn passes_through(&self) -> bool {
        let Self { normals: [held, now], distances: [before, after], slip, .. } = self;
        held.dot(now) < 0.0 && slip.norm() > before + after
    }

    /// Return the potential of the gap by `law` for a `size` of the part (m, m²) in a stage of `dt` (s), without one in
    /// equilibrium; none beyond its reach.
    pub fn push(&self, law: &Law, size: f64, dt: Option<f64>) -> Option<Push<D>> {
        let Self { gaps: [before, gap], normals: [_, normal], curvature, .. } = self;
        if before.min(*gap) >= law.reach() {
            return None;
        }
        let own = law.response(*gap, dt.map(|dt| Before { gap: *before, dt }));
        Some(Push {
            potential: size * own.potential,
            force: normal * (size * own.force),
            hessian: (normal * normal.transpose() * own.stiffness - curvature * own.force) * size,
        })
    }

    /// Return the potential of the slip in the same stage; none without friction.
    pub fn friction(&self, law: &Law, size: f64, dt: Option<f64>) -> Option<Push<D>> {
        let Self { gaps: [before, gap], normals: [held, _], slip, .. } = self;
        let pressed = size * law.penalty(*before).force;
        if before.min(*gap) >= law.reach() || law.friction * pressed <= 0.0 || dt.is_none() {
            return None;
        }
        let slip = slip - held * held.dot(slip);
        let size = slip.norm();
        let [potential, per_slip, second] = law.friction(pressed).response(size);
        let along = slip / size.max(f64::MIN_POSITIVE);
        let across = SMatrix::identity() - held * held.transpose() - along * along.transpose();
        Some(Push {
            potential,
            force: slip * -per_slip,
            hessian: across * per_slip + along * along.transpose() * second,
        })
    }
}

/// A point of a body that deforms, and what it may touch.
#[derive(Clone, Copy, Debug)]
pub struct Meeting<S, const D: usize> {
    /// Spot of the body at which the point lies.
    pub spot: S,
    /// Part of the body that belongs to the point: m of a rod, m² of a membrane; half of it for each side of a pair.
    pub size: f64,
    /// Spots of the closest points of the body itself at the begin and the end of the stage; `None` of an obstacle.
    pub partners: Option<[S; 2]>,
    /// How they meet.
    pub met: Encounter<D>,
}

impl<S, const D: usize> Meeting<S, D> {
    /// Return the parts of the potential by `law` in a stage of `dt` (s), each with the spot that it pushes back.
    pub fn pushes(self, law: &Law, dt: Option<f64>) -> impl Iterator<Item = (Push<D>, Option<S>)> + use<S, D> {
        let [before, now] = self.partners.map_or([None, None], |both| both.map(Some));
        let parts = [(self.met.push(law, self.size, dt), now), (self.met.friction(law, self.size, dt), before)];
        parts.into_iter().filter_map(|(push, partner)| Some((push?, partner)))
    }
}

/// Keep of the elements from `begin` on, near which a point may touch its own body, the closest one of each bend, nearest
/// first: a second closest point of a bend may come and go at any distance.
pub fn keep_one_of_each_bend(
    elements: &mut Vec<u32>,
    begin: usize,
    distance: impl Fn(u32) -> f64,
    are_apart: impl Fn(u32, u32) -> bool,
) {
    elements[begin..].sort_unstable_by(|a, b| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b)));
    let mut end = begin;
    for k in begin..elements.len() {
        let own = elements[k];
        if elements[begin..end].iter().all(|&other| are_apart(other, own)) {
            elements[end] = own;
            end += 1;
        }
    }
    elements.truncate(end);
}

/// Obstacles in a step.
#[derive(Clone, Debug)]
pub struct Obstacles<const D: usize> {
    all: Vec<Obstacle<D>>,
    /// Poses of each at begin and end of the step, and of the stage.
    motion: Vec<[Pose<D>; 2]>,
    stage: Vec<[Pose<D>; 2]>,
}

impl<const D: usize> Obstacles<D> {
    /// Return these obstacles at rest.
    pub fn new(all: Vec<Obstacle<D>>) -> Self {
        let motion: Vec<_> = all.iter().map(|obstacle| [obstacle.pose; 2]).collect();
        Self { all, stage: motion.clone(), motion }
    }

    /// Return the poses of an obstacle at begin and end of the step, to be set before it; none of a number without one.
    pub fn motion_mut(&mut self, i: usize) -> Option<&mut [Pose<D>; 2]> {
        self.motion.get_mut(i)
    }

    /// Return whether none moves in the step.
    pub fn are_still(&self) -> bool {
        self.motion.iter().all(|[begin, end]| begin == end)
    }

    /// Return whether an obstacle stays farther than `reach` (m) from balls of these middles and radii (m) around all points
    /// at begin and end of the stage.
    pub fn is_beyond(&self, i: usize, balls: [(SVector<f64, D>, f64); 2], reach: f64) -> bool {
        let mut both = self.stage[i].iter().zip(balls);
        both.all(|(pose, (middle, radius))| self.all[i].nearest_at(pose, middle).distance - radius >= reach)
    }

    /// Begin a stage between these fractions of the step.
    pub fn begin(&mut self, between: [f64; 2]) {
        for (stage, [begin, end]) in self.stage.iter_mut().zip(&self.motion) {
            *stage = between.map(|share| if share == 1.0 { *end } else { begin.towards(end, share) });
        }
    }

    /// Begin an equilibrium at the end of the step.
    pub fn begin_static(&mut self) {
        self.stage.iter_mut().zip(&self.motion).for_each(|(stage, [_, end])| *stage = [*end; 2]);
    }

    /// Let them stay where they are at the end of the step.
    pub fn stay(&mut self) {
        self.motion.iter_mut().for_each(|[begin, end]| *begin = *end);
    }

    /// Return how a point (m) at begin and end of the stage, with a `radius` (m) around it, meets an obstacle; none of a
    /// still one that stays farther than `reach`, m.
    #[inline]
    pub fn meet(&self, i: usize, points: [SVector<f64, D>; 2], radius: f64, reach: f64) -> Option<Encounter<D>> {
        let ([from, to], [p_before, p]) = (&self.stage[i], points);
        let now = self.all[i].nearest_at(to, p);
        let gap = now.distance - radius;
        if from == to && gap - (p - p_before).norm() >= reach {
            return None;
        }
        let before = self.all[i].nearest_at(from, p_before);
        Some(Encounter {
            distances: [before.distance, now.distance],
            gaps: [before.distance - radius, gap],
            normals: [before.normal, now.normal],
            curvature: now.curvature,
            slip: p - to.place(from.own(p_before)),
        })
    }
}
