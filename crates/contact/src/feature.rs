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
