//! Edges and faces of solids, which touch another solid by the point that is closest to it.
//!
//! A feature has the points x(ξ) = m + Σ ξ_i a_i with ξ_1² + ξ_2² ≤ 1 and ξ_3² ≤ 1: a line, a disk or a cylinder. Its gap
//! to a convex solid with the distance d is
//!
//! ```text
//! g = min [d(x(ξ)) + r b(ξ)],      b = 2 − (1 − ξ_1² − ξ_2²)^(1/2) − (1 − ξ_3²)^(1/2)
//! ```
//!
//! with a length r far below the range of the contact. The convex b is 0 in the middle and at most 2, and makes the closest
//! point unique: that of an edge along a face is in its middle, and moves to an end as the edge tilts by r over its length.
//! So g has a derivative everywhere, that at a fixed ξ, however the solids lie, and meetings neither come nor go in steps.
//! With u = ξ/(1 − ξ²)^(1/2), of the disk and of the line, the condition is a_i·∇d + r u_i = 0.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use crate::obstacle::{Nearest, Obstacle, Pose};

/// Length r over the radius by which edges are rounded.
pub const SOFT: f64 = 0.1;

/// Largest b.
pub const MOST_RISE: f64 = 2.0;

/// Most trials for each of the three shares; most take about eight.
const TRIALS: usize = 60;

/// Residual at which a share is found, relative to the size of the feature.
const TOLERANCE: f64 = 1e-14;

/// A point, line, disk or cylinder of a solid in its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature<const D: usize> {
    /// Its middle m, m.
    pub middle: SVector<f64, D>,
    /// Ways a_i from there to its ends, m: two radii of a disk, and half a line.
    pub ways: [SVector<f64, D>; 3],
}

/// The point of a feature that is closest to a solid.
#[derive(Clone, Copy, Debug)]
pub struct Closest<const D: usize> {
    /// The point, m.
    pub point: SVector<f64, D>,
    /// The gap g, m.
    pub gap: f64,
    /// Unit normal from the solid.
    pub normal: SVector<f64, D>,
    /// Ways w, m^(1/2), with which g has −Σ (n·(δω × w))² as its second differential by a turn δω, as the point slides.
    pub slides: [SVector<f64, D>; 3],
}

impl<const D: usize> Feature<D> {
    /// Return a point.
    pub fn point(middle: SVector<f64, D>) -> Self {
        Self { middle, ways: [SVector::zeros(); 3] }
    }

    /// Return the greatest distance of its points from its middle, m.
    pub fn size(&self) -> f64 {
        let [one, two, line] = self.ways.map(|way| way.norm());
        one.max(two).hypot(line)
    }

    /// Return the point that is closest to a solid, both at their poses, with the length r, m.
    pub fn closest(&self, solid: &Obstacle<D>, [own, other]: [&Pose<D>; 2], soft: f64) -> Closest<D> {
        let ways = self.ways.each_ref().map(|way| own.along(*way));
        // In the axes of the solid.
        let middle = other.own(own.place(self.middle));
        let across = SMatrix::from_columns(&ways.map(|way| other.across(way)));
        let search = Search { solid, middle, across, soft, size: self.size() };
        let Found { angles, nearest } = search.closest([0.0; 3], 0);
        let (xi, u) = (shares(angles), slopes(angles));
        let second = across.transpose() * nearest.curvature * across + second_derivative(u) * soft;
        let factor = second.cholesky().and_then(|factor| factor.l().try_inverse()).unwrap_or_else(Matrix3::zeros);
        let sum = |shares: [f64; 3]| -> SVector<f64, D> { ways.iter().zip(shares).map(|(way, own)| way * own).sum() };
        Closest {
            point: own.place(self.middle) + sum(xi.into()),
            gap: nearest.distance + soft * rise(u),
            normal: other.along(nearest.normal),
            slides: std::array::from_fn(|i| sum(std::array::from_fn(|j| factor[(i, j)]))),
        }
    }
}

/// Search for the closest point, in the axes of the solid.
struct Search<'a, const D: usize> {
    solid: &'a Obstacle<D>,
    middle: SVector<f64, D>,
    /// Ways a_i as columns, m.
    across: SMatrix<f64, D, 3>,
    soft: f64,
    size: f64,
}

/// A point of a feature by its angles: ξ = (sin t_1, cos t_1 sin t_2, sin t_3).
struct Found<const D: usize> {
    angles: [f64; 3],
    nearest: Nearest<D>,
}

impl<const D: usize> Search<'_, D> {
    /// Return the closest point whose first `fixed` angles are these. Minimized over some shares, a convex function stays
    /// convex in the others, so the residual of each has one zero.
    fn closest(&self, angles: [f64; 3], fixed: usize) -> Found<D> {
        if fixed == 3 {
            return Found { angles, nearest: self.solid.nearest_own(self.middle + self.across * shares(angles)) };
        }
        let way = self.across.column(fixed);
        let with = |angle: f64| {
            let found = self.closest(std::array::from_fn(|i| if i == fixed { angle } else { angles[i] }), fixed + 1);
            let pull = way.dot(&found.nearest.normal);
            // a·∇d + r u, times the cosine: bounded, and 0 at the same place.
            (angle.cos() * (pull + self.soft * slopes(found.angles)[fixed]), found)
        };
        let (mut value, mut found) = with(0.0);
        if way.norm_squared() == 0.0 {
            return found;
        }
        // A bracket, with the values there, of which that of an end that stays is halved (Dowell & Jarratt 1971).
        let mut ends = [(-FRAC_PI_2, -self.soft), (FRAC_PI_2, self.soft)];
        // Where a flat face has it.
        let mut next = -way.dot(&found.nearest.normal).atan2(self.soft);
        let mut last = None;
        for trial in 0..TRIALS {
            if value.abs() <= TOLERANCE * self.size {
                break;
            }
            let side = usize::from(value > 0.0);
            ends[side] = (found.angles[fixed], value);
            if last == Some(side) {
                ends[1 - side].1 *= 0.5;
            }
            last = Some(side);
            let [(low, below), (high, above)] = ends;
            if trial > 0 || !(low < next && next < high) {
                next = if trial % 4 == 3 { 0.5 * (low + high) } else { (low * above - high * below) / (above - below) };
            }
            if !(low < next && next < high) {
                break;
            }
            (value, found) = with(next);
        }
        found
    }
}

/// Return ξ.
fn shares([one, two, line]: [f64; 3]) -> Vector3<f64> {
    Vector3::new(one.sin(), one.cos() * two.sin(), line.sin())
}

/// Return u.
fn slopes([one, two, line]: [f64; 3]) -> Vector3<f64> {
    Vector3::new(one.tan() / two.cos(), two.tan(), line.tan())
}

/// Return (1 + u²)^(1/2) of the disk and of the line.
fn roots(u: Vector3<f64>) -> [f64; 2] {
    [(1.0 + u[0] * u[0] + u[1] * u[1]).sqrt(), (1.0 + u[2] * u[2]).sqrt()]
}

/// Return b.
fn rise(u: Vector3<f64>) -> f64 {
    roots(u).map(|root| 1.0 - 1.0 / root).iter().sum()
}

/// Return the second derivative of b, du/dξ.
fn second_derivative(u: Vector3<f64>) -> Matrix3<f64> {
    let [disk, line] = roots(u);
    let mut slope = Matrix3::from_diagonal(&Vector3::new(disk, disk, line.powi(3)));
    for i in 0..2 {
        for j in 0..2 {
            slope[(i, j)] += u[i] * u[j] * disk;
        }
    }
    slope
}

#[cfg(test)]
mod tests {
    use geometry::space::Solid;
    use nalgebra::Rotation3;

    use super::*;

    type V = Vector3<f64>;

    fn turned(pose: &Pose<3>, [way, turn]: [V; 2]) -> Pose<3> {
        let by = Rotation3::from_scaled_axis(turn);
        Pose { axes: pose.axes.map(|axis| by * axis), origin: pose.origin + way }
    }

    /// The gap is a minimum, and changes as the point at fixed ξ does.
    #[test]
    fn gaps_are_least_and_have_the_derivatives_of_their_points() {
        let (round, soft) = (0.03, 3e-3);
        let line = [V::zeros(), V::zeros(), V::x() * 0.4];
        let disk = [V::x() * 0.3, V::y() * 0.3, V::zeros()];
        let whole = [V::x() * 0.2, V::y() * 0.2, V::z() * 0.3];
        let solids = [
            Solid::Cuboid([0.3, 0.2, 0.1]),
            Solid::Cylinder { axis: 1, radius: 0.2, half_length: 0.3 },
            Solid::Capsule { axis: 0, radius: 0.1, half_length: 0.3 },
        ];
        let mut seen = 0;
        for k in 0..600 {
            let part = |d: u32| 2.0 * (f64::from(k * (d + 1) + 1) * 0.618_033_988_749_895).fract() - 1.0;
            let solid = solids[k as usize % 3];
            let solid = Obstacle::of_solid(&solid, Pose::at([0.0; 3])).expect("no ellipsoid").rounded(round);
            let feature = Feature { middle: V::new(0.1, 0.0, -0.1), ways: [line, disk, whole][k as usize / 3 % 3] };
            let place = V::new(part(0), part(1), part(2)) * 0.5;
            let pose = turned(&Pose::at([0.0; 3]), [place, V::new(part(3), part(4), part(5)) * 2.0]);
            let gap = |change: [V; 2]| feature.closest(&solid, [&turned(&pose, change), &solid.pose], soft);
            let found = gap([V::zeros(); 2]);
            if found.gap < -0.8 * round {
                continue; // no force reaches it
            }
            seen += 1;
            for trial in 0..20 {
                let share =
                    |d: u32| 2.0 * (f64::from(k * 20 + trial + 1) * [0.414, 0.732, 0.236][d as usize]).fract() - 1.0;
                let angles = [0, 1, 2].map(|d| share(d) * FRAC_PI_2);
                let own = pose.place(feature.middle + SMatrix::from_columns(&feature.ways) * shares(angles));
                let other = solid.nearest(own).distance + soft * rise(slopes(angles));
                assert!(other > found.gap - 1e-12, "{k}: {other} at {angles:?} below {}", found.gap);
            }
            let step = 1e-6;
            for d in 0..6 {
                let unit = [0, 3].map(|first| V::from_fn(|i, _| f64::from(u8::from(first + i == d))));
                let [low, high] = [-step, step].map(|by| gap(unit.map(|own| own * by)));
                let slope = (high.gap - low.gap) / (2.0 * step);
                let arm = found.point - pose.origin;
                let expected = found.normal.dot(&(unit[0] + unit[1].cross(&arm)));
                assert!((slope - expected).abs() < 1e-5, "{k}, {d}: {slope}, not {expected}");
            }
        }
        assert!(seen > 300, "{seen} cases");
    }

    /// An edge along a face meets it in its middle, and tilted at an end; the way there is the second derivative.
    #[test]
    fn a_tilted_edge_slides_to_its_end() {
        let (soft, half) = (1e-3, 0.3);
        let wall = Obstacle::plane([0.0; 3], [0.0, 0.0, 1.0]);
        let feature = Feature { middle: V::zeros(), ways: [V::zeros(), V::zeros(), V::x() * half] };
        let at = |tilt: f64| {
            let pose = turned(&Pose::at([0.0, 0.0, 0.1]), [V::zeros(), V::y() * tilt]);
            feature.closest(&wall, [&pose, &wall.pose], soft)
        };
        let flat = at(0.0);
        assert!((flat.point - V::z() * 0.1).norm() < 1e-15 && (flat.gap - 0.1).abs() < 1e-15, "{flat:?}");
        assert!((at(0.1).point.x / half - 1.0).abs() < 6e-3, "{:?}", at(0.1));
        let step = 1e-5;
        let second = (at(step).gap + at(-step).gap - 2.0 * flat.gap) / (step * step);
        let slides: f64 = flat.slides.iter().map(|way| V::z().dot(&V::y().cross(way)).powi(2)).sum();
        assert!((second / -slides - 1.0).abs() < 1e-4, "{second}, not {}", -slides);
    }
}
