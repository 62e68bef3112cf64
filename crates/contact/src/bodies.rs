//! Contact of rigid bodies with each other and with obstacles, in a step of two-step backward differences.
//!
//! Without contact the bodies would have the velocities V_0, and a force F changes them by A⁻¹ F. With the coefficient
//! c_0 of the differences their places change by (V − V_0)/c_0, so V is the minimum of
//!
//! ```text
//! ½ (V − V_0)ᵀ A (V − V_0) + c_0 Σ U(g(V)) + Σ φ(Δt |s(V)|)/Δt
//! ```
//!
//! with the potentials of a [`Law`]: U of the gap g, and φ of the slip with the velocity s. Newton's method with a line
//! search finds it, whatever the stiffness.

use nalgebra::SVector;
use rigid::{Freedoms, Kinematics, split};

use crate::feature::{Feature, MOST_RISE, SOFT};
use crate::law::{Before, Film, Law, largest_stiffness};
use crate::obstacle::{Obstacle, Pose};

/// Most iterations; a contact takes about five.
const ITERATIONS: usize = 50;

/// Change of a place in an iteration below which the solution is found, relative to the range.
const TOLERANCE: f64 = 1e-11;

/// Part of the potential that may be rounding.
const ROUNDING: f64 = 1e-12;

/// Part of the expected decrease that a step of the line search must reach (Armijo 1966).
const DECREASE: f64 = 1e-4;

/// Most halvings of a step, and of the way to a place without overlap.
const HALVINGS: usize = 40;

/// How bodies touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyLaw {
    /// Gap at which the penalty begins, m.
    pub range: f64,
    /// Stiffness where surfaces meet, N/m; it acts at most as that with which a contact lasts ten steps.
    pub stiffness: f64,
    /// Damping of the gap, kg/s.
    pub damping: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Film between balls, circles in the plane, and walls; absent without.
    pub film: Option<BodyFilm>,
    /// Longest step, s.
    pub dt: f64,
}

/// Film of a viscous fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyFilm {
    /// Viscosity, Pa s.
    pub viscosity: f64,
    /// Gap at which it begins, m.
    pub range: f64,
    /// Least gap, the roughness, m.
    pub least: f64,
}

/// A body, or an obstacle.
#[derive(Clone, Debug)]
pub struct Part<const D: usize> {
    /// Shape; its own place has no meaning.
    pub solid: Obstacle<D>,
    /// Mass, kg, and least moment of inertia about the pivot, kg m², infinite where it cannot turn; absent for a part
    /// that contact does not move.
    pub inertia: Option<[f64; 2]>,
    /// Place of the pivot in the axes of the shape, m.
    pub pivot: SVector<f64, D>,
    /// Motion in the step without contact.
    pub motion: PartMotion<D>,
}

/// Motion of a part in a step.
#[derive(Clone, Copy, Debug)]
pub struct PartMotion<const D: usize> {
    /// Places at begin and end.
    pub poses: [Pose<D>; 2],
    /// Velocities at the end along the freedoms.
    pub rates: Freedoms,
    /// Rate A at which a force grows with the velocities of the body, kg/s; its row is that of the identity where the
    /// body is held.
    pub matrix: [Freedoms; 6],
    /// Freedoms along which the body moves.
    pub free: [bool; 6],
}

/// Contact of parts.
pub struct BodyContacts<const D: usize> {
    parties: Parties<D>,
    range: f64,
    /// Change of the velocities of each part by the contact, and one that is tried.
    change: Vec<Freedoms>,
    tried: Vec<Freedoms>,
    equations: Equations,
}

/// What may touch.
struct Parties<const D: usize> {
    parts: Vec<Part<D>>,
    /// Poses at the end of the step with the present change of the velocities.
    ends: Vec<Pose<D>>,
    pairs: Vec<Pair<D>>,
    /// Lengths after which everything repeats along the axes, m; infinite: never.
    periods: [f64; D],
}

/// Equations of Newton's method.
struct Equations {
    /// First row of each part; none of one that does not take part.
    rows: Vec<Option<usize>>,
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// Solution, by part.
    direction: Vec<Freedoms>,
}

/// Points of the part `of` that touch the solid of the part `on`.
pub struct Pair<const D: usize> {
    pub of: usize,
    pub on: usize,
    points: Points<D>,
    /// Radius of the points, m.
    radius: f64,
    pub law: Law,
}

/// Points of a part in its axes, m.
enum Points<const D: usize> {
    /// These.
    Fixed(Vec<SVector<f64, D>>),
    /// That of the first line, which is the closest one to the second line, of the other part; both by their ends.
    Closest([[SVector<f64, D>; 2]; 2]),
    /// Those of these features that are the closest ones to the other part, which may be rounded, with the length r, m.
    Features { features: Vec<Feature<D>>, solid: Obstacle<D>, soft: f64 },
}

/// A point of a part and the other part there.
struct Touching<const D: usize> {
    /// The point, m.
    point: SVector<f64, D>,
    /// Gap, m.
    gap: f64,
    /// Unit normal from the other part.
    normal: SVector<f64, D>,
    /// How the point slides along a feature, see [`crate::feature::Closest`].
    slides: Option<[SVector<f64, D>; 3]>,
}

/// A point and what it may touch.
struct Meeting<const D: usize> {
    /// At begin and end of the step, m.
    gaps: [f64; 2],
    /// Unit normals from the other part.
    normals: [SVector<f64, D>; 2],
    /// The point, m.
    points: [SVector<f64, D>; 2],
    /// How the point slides at the end of the step.
    slides: Option<[SVector<f64, D>; 3]>,
    /// Way from the other part to its image that the point meets, m.
    shift: SVector<f64, D>,
}

/// Part of the potential: a function of the velocity of two parts along `rows`.
struct Term {
    parts: [usize; 2],
    rows: [Freedoms; 2],
    potential: f64,
    force: f64,
    stiffness: f64,
}

impl<const D: usize> PartMotion<D> {
    /// Return the motion of a part that stays.
    pub fn still(pose: Pose<D>) -> Self {
        Self { poses: [pose; 2], rates: [0.0; 6], matrix: [[0.0; 6]; 6], free: [false; 6] }
    }
}

impl<const D: usize> BodyContacts<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Return the contact of these parts.
    ///
    /// # Errors
    /// The numbers of two parts that cannot touch, see [`Obstacle::can_touch`], of which the contact moves one.
    pub fn new(parts: Vec<Part<D>>, law: &BodyLaw) -> Result<Self, [usize; 2]> {
        let mut pairs = Vec::new();
        for (j, two) in parts.iter().enumerate() {
            for (i, one) in parts[..j].iter().enumerate().filter(|(_, one)| one.moves() || two.moves()) {
                if !one.solid.can_touch(&two.solid) {
                    return Err([i, j]);
                }
                pairs.extend(Pair::all([i, j], [one, two], law));
            }
        }
        let free = parts.iter().filter(|part| part.moves()).count() * <[f64; D]>::FREEDOMS;
        let room = || vec![[0.0; 6]; parts.len()];
        let ends = parts.iter().map(|part| part.motion.poses[1]).collect();
        let equations = Equations {
            rows: vec![None; parts.len()],
            matrix: vec![0.0; free * free],
            right: vec![0.0; free],
            direction: room(),
        };
        Ok(Self {
            range: law.range,
            change: room(),
            tried: room(),
            equations,
            parties: Parties { ends, parts, pairs, periods: [f64::INFINITY; D] },
        })
    }

    /// Let everything repeat along the axes after these lengths, m, of which some may be infinite.
    pub fn with_periods(mut self, periods: [f64; D]) -> Self {
        self.parties.periods = periods;
        self
    }

    /// Leave out the pairs of parts, by their numbers, of which something else keeps account.
    pub fn without(mut self, is_elsewhere: impl Fn([usize; 2]) -> bool) -> Self {
        self.parties.pairs.retain(|pair| !is_elsewhere([pair.of, pair.on]));
        self
    }

    /// Return the parts.
    pub fn parts(&self) -> &[Part<D>] {
        &self.parties.parts
    }

    /// Return the motion of a part, to be set before each step.
    pub fn motion_mut(&mut self, part: usize) -> &mut PartMotion<D> {
        &mut self.parties.parts[part].motion
    }

    /// Return the parts that touch at the begin of the step: their numbers, the least gap, m, and the energy of the penalty,
    /// J, which is infinite where they are too deep in each other.
    pub fn touching(&self) -> Vec<([usize; 2], f64, f64)> {
        let mut found = Vec::<([usize; 2], f64, f64)>::new();
        self.parties.visit(|pair, Meeting { gaps: [gap, _], .. }| {
            let (parts, energy) = ([pair.of.min(pair.on), pair.of.max(pair.on)], pair.law.penalty(gap).potential);
            match found.iter_mut().find(|(known, ..)| *known == parts) {
                _ if energy == 0.0 => (),
                Some((_, least, sum)) => (*least, *sum) = (least.min(gap), *sum + energy),
                None => found.push((parts, gap, energy)),
            }
        });
        found
    }

    /// Return the changes of the velocities by the contact in a step of `dt` seconds with the first coefficient `c_0` of
    /// the differences, by part; none where nothing touches.
    ///
    /// # Errors
    /// The numbers of two parts that cannot part, and are deeper in each other than half a thickness.
    pub fn solve(&mut self, c_0: f64, dt: f64) -> Result<Option<&[Freedoms]>, [usize; 2]> {
        let Self { parties, range, change, tried, equations } = self;
        change.fill([0.0; 6]);
        let mut touches = false;
        parties.place(change, c_0);
        parties.terms(change, c_0, dt, |_| touches = true);
        if !touches {
            return Ok(None);
        }
        let mut potential = parties.begin(change, c_0, dt)?;
        for _ in 0..ITERATIONS {
            let slope = equations.find_direction(parties, change, c_0, dt);
            if equations.largest_way::<D>(parties) <= TOLERANCE * *range * c_0 {
                break;
            }
            let shares = (0..HALVINGS as i32).map(|k| 0.5_f64.powi(k));
            let better = shares.into_iter().find_map(|share| {
                for ((tried, own), by) in tried.iter_mut().zip(&*change).zip(&equations.direction) {
                    *tried = std::array::from_fn(|i| own[i] + share * by[i]);
                }
                let next = parties.potential(tried, c_0, dt);
                (next <= potential - DECREASE * share * slope + ROUNDING * potential.abs()).then_some(next)
            });
            let Some(better) = better else { break }; // what is left is rounding
            potential = better;
            std::mem::swap(change, tried);
        }
        Ok(Some(change))
    }
}

impl<const D: usize> Part<D>
where
    [f64; D]: Kinematics<D>,
{
    fn moves(&self) -> bool {
        self.inertia.is_some()
    }

    /// Return the least mass with which a point answers, kg; infinite if it does not move.
    pub fn least_mass(&self) -> f64 {
        let Some([mass, inertia]) = self.inertia else { return f64::INFINITY };
        let arms = self.solid.points().into_iter().map(|point| (point - self.pivot).norm_squared());
        1.0 / (1.0 / mass + arms.fold(0.0, f64::max) / inertia)
    }

    /// Return the least mass with which anything as far from the pivot as the shape may answers, kg; infinite if it does not
    /// move.
    fn least_mass_within_reach(&self) -> f64 {
        let Some([mass, inertia]) = self.inertia else { return f64::INFINITY };
        1.0 / (1.0 / mass + (self.solid.reach() + self.pivot.norm()).powi(2) / inertia)
    }

    /// Return the pose at the end of the step, moved on along the freedoms.
    fn moved(&self, way: &Freedoms) -> Pose<D> {
        let [_, Pose { axes, .. }] = self.motion.poses;
        let (way, turn) = split::<D>(way);
        let by = <[f64; D]>::orientation(&Default::default(), turn);
        let axes = axes.map(|axis| <[f64; D]>::turn(&by, axis));
        let pivot = self.pivot_at_end() + way;
        Pose { axes, origin: SVector::zeros() }.about(pivot, self.pivot)
    }

    fn pivot_at_end(&self) -> SVector<f64, D> {
        self.motion.poses[1].place(self.pivot)
    }

    /// Return the way along the freedoms from the end of the step back to its begin; angles are small.
    fn way_back(&self) -> Freedoms {
        let [begin, end] = &self.motion.poses;
        let turns =
            end.axes.iter().zip(&begin.axes).map(|(end, begin)| <[f64; D]>::components(<[f64; D]>::cross(end, begin)));
        let turn = turns.fold([0.0; 3], |sum, own| std::array::from_fn(|i| sum[i] + 0.5 * own[i]));
        let way = rigid::join::<D>(&(begin.place(self.pivot) - end.place(self.pivot)), <[f64; D]>::spin(turn));
        std::array::from_fn(|i| if self.motion.free[i] { way[i] } else { 0.0 })
    }
}

impl<const D: usize> Parties<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Write a first guess, without contact or nearer to the places before where that is too deep, and return its
    /// potential.
    fn begin(&mut self, change: &mut [Freedoms], c_0: f64, dt: f64) -> Result<f64, [usize; 2]> {
        for k in 0..=HALVINGS as i32 {
            let share = if k == HALVINGS as i32 { 1.0 } else { 1.0 - 0.5_f64.powi(k) };
            for (own, part) in change.iter_mut().zip(&self.parts).filter(|(_, part)| part.moves()) {
                *own = part.way_back().map(|way| share * c_0 * way);
            }
            let potential = self.potential(change, c_0, dt);
            if potential < f64::INFINITY {
                return Ok(potential);
            }
        }
        let mut worst = (0.0, [0; 2]);
        self.visit(|pair, met| {
            let depth = -met.gaps[1] / pair.law.depth;
            if depth > worst.0 {
                worst = (depth, [pair.of.min(pair.on), pair.of.max(pair.on)]);
            }
        });
        Err(worst.1)
    }

    /// Put the parts to where these changes of their velocities put them.
    fn place(&mut self, change: &[Freedoms], c_0: f64) {
        for ((end, part), change) in self.ends.iter_mut().zip(&self.parts).zip(change) {
            *end = if part.moves() { part.moved(&change.map(|v| v / c_0)) } else { part.motion.poses[1] };
        }
    }

    /// Put the parts there, and return the potential.
    fn potential(&mut self, change: &[Freedoms], c_0: f64, dt: f64) -> f64 {
        self.place(change, c_0);
        let own = |(part, change): (&Part<D>, &Freedoms)| 0.5 * dot(change, &product(&part.motion.matrix, change));
        let mut sum = self.parts.iter().zip(change).filter(|(part, _)| part.moves()).map(own).sum();
        self.terms(change, c_0, dt, |term| sum += term.potential);
        sum
    }

    /// Pass all points that may touch at the begin of the step or at its end.
    fn visit(&self, mut emit: impl FnMut(&Pair<D>, Meeting<D>)) {
        for pair in &self.pairs {
            let [of, on] = [pair.of, pair.on].map(|part| &self.parts[part]);
            let mut poses = [[of, on].map(|part| part.motion.poses[0]), [pair.of, pair.on].map(|k| self.ends[k])];
            let shift = nearest_image(poses[0][0].origin - poses[0][1].origin, &self.periods);
            poses.iter_mut().for_each(|[_, image]| image.origin += shift);
            let [from, to] = poses.each_ref().map(|both| both.each_ref());
            let reach = pair.law.reach() + of.solid.reach() + on.solid.reach();
            let apart = |poses: [&Pose<D>; 2]| (poses[0].origin - poses[1].origin).norm() > reach;
            if reach < f64::INFINITY && apart(from) && apart(to) {
                continue;
            }
            for k in (0..pair.count()).filter(|k| [from, to].iter().any(|poses| pair.may_touch(*k, *poses))) {
                let [held, now] = [from, to].map(|poses| pair.touching(k, &on.solid, poses));
                let (gaps, normals) = ([held.gap, now.gap], [held.normal, now.normal]);
                emit(pair, Meeting { gaps, normals, points: [held.point, now.point], slides: now.slides, shift });
            }
        }
    }

    /// Pass the parts of the potential of contact at these changes of the velocities to `emit`.
    fn terms(&self, change: &[Freedoms], c_0: f64, dt: f64, mut emit: impl FnMut(Term)) {
        self.visit(|pair, Meeting { gaps: [before, gap], normals: [held, normal], points, slides, shift }| {
            let (law, parts) = (&pair.law, [pair.of, pair.on]);
            if before.min(gap) >= law.reach() {
                return;
            }
            // Rows of the velocity along a direction of the one part less the other at these arms.
            let rows = |along: &SVector<f64, D>, arms: [SVector<f64, D>; 2]| {
                [0, 1].map(|side| {
                    let (all, sign) = (<[f64; D]>::jacobian(1.0, arms[side].into()), [1.0, -1.0][side]);
                    let sum = |i: usize| (0..D).map(|d| along[d] * all[d][i]).sum::<f64>();
                    let free = &self.parts[parts[side]].motion.free;
                    std::array::from_fn(|i| if free[i] { sign * sum(i) } else { 0.0 })
                })
            };
            // Arms of a point about both pivots.
            let arms_at = |point: SVector<f64, D>, poses: [&Pose<D>; 2]| {
                let [of, on] = [0, 1].map(|side| point - poses[side].place(self.parts[parts[side]].pivot));
                [of, on - shift]
            };
            let own = law.response(gap, Some(Before { gap: before, dt }));
            let arms = arms_at(points[1], parts.map(|k| &self.ends[k]));
            let along = rows(&normal, arms);
            emit(Term {
                parts,
                rows: along,
                potential: c_0 * own.potential,
                force: own.force,
                stiffness: own.stiffness / c_0,
            });
            // As the bodies turn, the point slides along its feature.
            for way in slides.iter().flatten().filter(|way| way.norm_squared() > 0.0) {
                let moved = rows(&normal, arms.map(|arm| arm + way));
                let rows = [0, 1].map(|side| std::array::from_fn(|i| moved[side][i] - along[side][i]));
                emit(Term { parts, rows, potential: 0.0, force: 0.0, stiffness: own.force.max(0.0) / c_0 });
            }
            let pressed = law.penalty(before).force;
            if law.friction * pressed == 0.0 {
                return;
            }
            let surface = points[0] - held * pair.radius;
            // In the middle of the gap between two that move: neither body is the first.
            let share = match parts.map(|k| self.parts[k].moves()) {
                [true, true] => 0.5,
                [of, _] => f64::from(u8::from(!of)),
            };
            let at = surface - held * (share * before);
            let arms = arms_at(at, parts.map(|k| &self.parts[k].motion.poses[0]));
            let [of, on] = [0, 1].map(|side| {
                let k = parts[side];
                let (v, omega) = split::<D>(&std::array::from_fn(|i| self.parts[k].motion.rates[i] + change[k][i]));
                v + <[f64; D]>::swing(omega, &arms[side])
            });
            let slip = (of - on) * dt;
            let slip = slip - held * held.dot(&slip);
            let size = slip.norm();
            let [potential, per_slip, second] = law.friction(pressed).response(size);
            // Directions across the normal, the first one along the slip.
            let mut across = [held; D];
            for d in 1..D {
                let mut next = if d == 1 && size > 0.0 { slip / size } else { unit_across(&across[..d]) };
                across[..d].iter().for_each(|other| next -= other * other.dot(&next));
                across[d] = next.normalize();
            }
            for (d, along) in across.iter().enumerate().skip(1) {
                let first = d == 1;
                emit(Term {
                    parts,
                    rows: rows(along, arms),
                    potential: if first { potential / dt } else { 0.0 },
                    force: if first { -per_slip * size } else { 0.0 },
                    stiffness: dt * if first { second } else { per_slip },
                });
            }
        });
    }
}

impl Equations {
    /// Write the direction of Newton's method, and return how fast the potential falls along it.
    fn find_direction<const D: usize>(&mut self, parties: &Parties<D>, change: &[Freedoms], c_0: f64, dt: f64) -> f64
    where
        [f64; D]: Kinematics<D>,
    {
        let (freedoms, parts) = (<[f64; D]>::FREEDOMS, &parties.parts);
        let Self { rows, matrix, right, direction } = self;
        rows.iter_mut().zip(change).for_each(|(row, own)| *row = own.iter().any(|v| *v != 0.0).then_some(0));
        parties.terms(change, c_0, dt, |term| {
            term.parts.into_iter().filter(|k| parts[*k].moves()).for_each(|k| rows[k] = Some(0));
        });
        let mut size = 0;
        for row in rows.iter_mut().flatten() {
            (*row, size) = (size, size + freedoms);
        }
        let (matrix, right) = (&mut matrix[..size * size], &mut right[..size]);
        matrix.fill(0.0);
        for (k, row) in rows.iter().enumerate().filter_map(|(k, row)| Some((k, (*row)?))) {
            let own = &parts[k].motion.matrix;
            let force = product(own, &change[k]);
            for i in 0..freedoms {
                right[row + i] = -force[i];
                matrix[(row + i) * size + row..][..freedoms].copy_from_slice(&own[i][..freedoms]);
            }
        }
        parties.terms(change, c_0, dt, |Term { parts, rows: along, force, stiffness, .. }| {
            let sides = [0, 1].map(|side| Some((rows[parts[side]]?, along[side])));
            for (to, on) in sides.into_iter().flatten() {
                (0..freedoms).for_each(|i| right[to + i] += force * on[i]);
                for (from, of) in sides.into_iter().flatten() {
                    for i in 0..freedoms {
                        let row = &mut matrix[(to + i) * size + from..][..freedoms];
                        row.iter_mut().zip(of).for_each(|(entry, of)| *entry += stiffness * on[i] * of);
                    }
                }
            }
        });
        let each = |direction: &mut [Freedoms], visit: &mut dyn FnMut(&mut [f64], usize)| {
            let taking = direction.iter_mut().zip(&*rows).filter_map(|(own, row)| Some((own, (*row)?)));
            taking.for_each(|(own, row)| visit(&mut own[..freedoms], row));
        };
        direction.fill([0.0; 6]);
        each(direction, &mut |own, row| own.copy_from_slice(&right[row..][..freedoms]));
        solve(matrix, right);
        let mut slope = 0.0;
        each(direction, &mut |own, row| {
            for (own, solved) in own.iter_mut().zip(&right[row..]) {
                slope += *own * solved;
                *own = *solved;
            }
        });
        slope
    }

    /// Return the largest velocity that a point of a shape would get along the direction, m/s.
    fn largest_way<const D: usize>(&self, parties: &Parties<D>) -> f64
    where
        [f64; D]: Kinematics<D>,
    {
        let own = |(part, direction): (&Part<D>, &Freedoms)| {
            let (velocity, omega) = split::<D>(direction);
            let about = <[f64; D]>::components(omega).iter().map(|about| about * about).sum::<f64>().sqrt();
            velocity.norm() + if part.moves() { about * (part.solid.reach() + part.pivot.norm()) } else { 0.0 }
        };
        parties.parts.iter().zip(&self.direction).map(own).fold(0.0, f64::max)
    }
}

impl<const D: usize> Pair<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Pass the points that may touch at these poses of `of` and `on` to `emit`: the middle of the gap, the gap (m) and
    /// the normal from `on`.
    pub fn meet(
        &self,
        solid: &Obstacle<D>,
        poses: [&Pose<D>; 2],
        mut emit: impl FnMut(SVector<f64, D>, f64, SVector<f64, D>),
    ) {
        for k in (0..self.count()).filter(|k| self.may_touch(*k, poses)) {
            let Touching { point, gap, normal, .. } = self.touching(k, solid, poses);
            emit(point - normal * (self.radius + 0.5 * gap), gap, normal);
        }
    }

    /// Return the number of points that may touch.
    pub fn count(&self) -> usize {
        match &self.points {
            Points::Fixed(points) => points.len(),
            Points::Closest(_) => 1,
            Points::Features { features, .. } => features.len(),
        }
    }

    /// Return whether a point by its number may be within reach at these poses of `of` and `on`; of all but features it is.
    fn may_touch(&self, k: usize, poses: [&Pose<D>; 2]) -> bool {
        let Points::Features { features, solid, .. } = &self.points else { return true };
        let Feature { middle, .. } = features[k];
        solid.nearest_own(poses[1].own(poses[0].place(middle))).distance
            < self.law.reach() + self.radius + features[k].size()
    }

    /// Return a point by its number at these poses of `of` and `on`, the latter with this solid.
    fn touching(&self, k: usize, solid: &Obstacle<D>, poses: [&Pose<D>; 2]) -> Touching<D> {
        let point = match &self.points {
            Points::Fixed(points) => poses[0].place(points[k]),
            Points::Closest([own, other]) => {
                closest(own.map(|end| poses[0].place(end)), other.map(|end| poses[1].place(end)))
            }
            Points::Features { features, solid, soft } => {
                let found = features[k].closest(solid, poses, *soft);
                let gap = found.gap - self.radius;
                return Touching { point: found.point, gap, normal: found.normal, slides: Some(found.slides) };
            }
        };
        let nearest = solid.nearest_at(poses[1], point);
        Touching { point, gap: nearest.distance - self.radius, normal: nearest.normal, slides: None }
    }

    /// Return how two parts touch.
    pub fn all(numbers: [usize; 2], parts: [&Part<D>; 2], law: &BodyLaw) -> Vec<Self> {
        let [one, two] = parts.map(|part| &part.solid);
        let balls = [one, two].map(Obstacle::ball_radius);
        let lines = [one, two].map(Obstacle::line);
        let has_wall = one.is_half_space() || two.is_half_space();
        let is_cylinder = [one, two].iter().any(|solid| solid.points().is_empty() && !solid.is_half_space());
        let by_points = D == 2 || balls != [None; 2] || (has_wall && !is_cylinder) || lines.iter().all(Option::is_some);
        let masses = parts.map(|part| if by_points { part.least_mass() } else { part.least_mass_within_reach() });
        let mass = 1.0 / (1.0 / masses[0] + 1.0 / masses[1]);
        let film = law.film.and_then(|film| {
            let curvature =
                |ball: Option<f64>, other: &Obstacle<D>| ball.map(|r| 1.0 / r).or(other.is_half_space().then_some(0.0));
            let curvature = curvature(balls[0], one)? + curvature(balls[1], two)?;
            Some(Film::between::<D>(film.viscosity, 1.0 / curvature, film.range, film.least))
        });
        let law = Law {
            range: law.range,
            stiffness: law.stiffness.min(largest_stiffness(mass, law.dt)),
            depth: one.half_thickness().min(two.half_thickness()),
            damping: law.damping,
            friction: law.friction,
            film,
        };
        let pair = |[of, on]: [usize; 2], points| {
            let radius = parts[if of == numbers[0] { 0 } else { 1 }].solid.radius();
            Self { of, on, points, radius, law }
        };
        let [i, j] = numbers;
        let fixed = |of: &Obstacle<D>| Points::Fixed(of.points());
        match (balls, lines) {
            ([Some(_), _], _) => vec![pair([i, j], fixed(one))],
            ([_, Some(_)], _) => vec![pair([j, i], fixed(two))],
            (_, [Some(own), Some(other)]) if D == 3 => vec![pair([i, j], Points::Closest([own, other]))],
            _ if by_points => vec![pair([i, j], fixed(one)), pair([j, i], fixed(two))],
            _ => {
                // So round, and no deeper, that a point and what it meets have one normal.
                let round = (0.5 * law.range).min(law.depth);
                let soft = SOFT * round;
                let side = |[of, on]: [usize; 2], [own, other]: [&Obstacle<D>; 2]| {
                    let is_sharp = own.radius() == 0.0 && other.radius() == 0.0 && !other.is_half_space();
                    let solid = if is_sharp { other.rounded(round) } else { other.clone() };
                    let mut pair = pair([of, on], Points::Features { features: own.features(other), solid, soft });
                    pair.law.depth = if is_sharp { round } else { law.depth } - MOST_RISE * soft;
                    pair
                };
                vec![side([i, j], [one, two]), side([j, i], [two, one])]
            }
        }
    }
}

/// Return the way by whole periods, m, which is closest to `way` along each axis.
pub fn nearest_image<const D: usize>(way: SVector<f64, D>, periods: &[f64; D]) -> SVector<f64, D> {
    let along = |d: usize| if periods[d].is_finite() { (way[d] / periods[d]).round() * periods[d] } else { 0.0 };
    SVector::from_fn(|d, _| along(d))
}

/// Return the point of the line `one` that is closest to the line `two`, both by their ends.
fn closest<const D: usize>(one: [SVector<f64, D>; 2], two: [SVector<f64, D>; 2]) -> SVector<f64, D> {
    let (a, b, between) = (one[1] - one[0], two[1] - two[0], one[0] - two[0]);
    let (aa, bb, ab, ga, gb) = (a.dot(&a), b.dot(&b), a.dot(&b), a.dot(&between), b.dot(&between));
    // Where the lines without ends are closest, then back to the ends of one and of the other.
    let determinant = aa * bb - ab * ab;
    let free = if determinant > 1e-12 * aa * bb { (ab * gb - bb * ga) / determinant } else { 0.5 };
    let on_two = ((ab * free.clamp(0.0, 1.0) + gb) / bb).clamp(0.0, 1.0);
    one[0] + a * ((ab * on_two - ga) / aa).clamp(0.0, 1.0)
}

/// Return the unit vector of the axis that is the most across some unit vectors.
fn unit_across<const D: usize>(others: &[SVector<f64, D>]) -> SVector<f64, D> {
    let along = |axis: usize| others.iter().map(|other| other[axis] * other[axis]).sum::<f64>();
    let axis = (0..D).min_by(|i, j| along(*i).total_cmp(&along(*j))).unwrap_or(0);
    SVector::from_fn(|d, _| f64::from(u8::from(d == axis)))
}

fn dot(a: &Freedoms, b: &Freedoms) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn product(matrix: &[Freedoms; 6], vector: &Freedoms) -> Freedoms {
    std::array::from_fn(|i| dot(&matrix[i], vector))
}

/// Solve equations with a symmetric positive matrix in place, by Cholesky's factors.
fn solve(matrix: &mut [f64], right: &mut [f64]) {
    let n = right.len();
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let left = matrix[i * n + j] - sum;
            matrix[i * n + j] = match i == j {
                true => left.max(f64::EPSILON * matrix[i * n + i].abs()).max(f64::MIN_POSITIVE).sqrt(),
                false => left / matrix[j * n + j],
            };
        }
        let sum: f64 = (0..i).map(|k| matrix[i * n + k] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i * n + i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| matrix[k * n + i] * right[k]).sum();
        right[i] = (right[i] - sum) / matrix[i * n + i];
    }
}
