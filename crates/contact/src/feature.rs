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
//! With u = ξ/(1 − ξ²)^(1/2), of the disk and of the line, the condition is aᵢ·∇d + r uᵢ = 0.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use crate::obstacle::{Nearest, Obstacle, Pose};

/// Length r over the range of the contact.
pub const SOFT: f64 = 0.05;

/// Most iterations; most features take one to five.
const ITERATIONS: usize = 40;

/// Most halvings in an iteration.
const HALVINGS: usize = 40;

/// Residual at which the closest point is found, relative to the size of the feature.
const TOLERANCE: f64 = 1e-13;

/// Part of the slope along a direction that may be left.
const LEFT: f64 = 0.2;

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
        // In the axes of the solid.
        let middle = other.own(own.place(self.middle));
        let turn = |way: &SVector<f64, D>| own.along(*way);
        let (ways, size) = (self.ways.each_ref().map(turn), self.size());
        let across = SMatrix::<f64, D, 3>::from_columns(&ways.map(|way| other.across(way)));
        let at = |xi: Vector3<f64>| solid.nearest_own(middle + across * xi);
        let gradient = |found: &Nearest<D>| across.transpose() * found.normal;
        let hessian = |u: Vector3<f64>, found: &Nearest<D>| {
            (across.transpose() * found.curvature * across + second_derivative(u) * soft).cholesky()
        };
        let mut u = Vector3::zeros();
        let mut found = at(u);
        for _ in 0..if size > 0.0 { ITERATIONS } else { 0 } {
            let (xi, residual) = (inner(u), gradient(&found) + soft * u);
            if residual.amax() <= TOLERANCE * size {
                break;
            }
            let newton = hessian(u, &found).map(|factor| u - second_derivative(u) * factor.solve(&residual));
            // Else where a flat face has it, which always descends.
            let descends = |next: &Vector3<f64>| residual.dot(&(inner(*next) - xi)) < 0.0;
            u = newton.filter(descends).unwrap_or_else(|| u - residual / soft);
            found = at(inner(u));
            let way = inner(u) - xi;
            let along = |u: Vector3<f64>, found: &Nearest<D>| (gradient(found) + soft * u).dot(&way);
            let (left, [mut low, mut high]) = (LEFT * residual.dot(&way).abs(), [0.0, 1.0]);
            let mut now = along(u, &found);
            for _ in 0..if now > left { HALVINGS } else { 0 } {
                let share = 0.5 * (low + high);
                u = outer(xi + way * share);
                found = at(inner(u));
                now = along(u, &found);
                if now.abs() <= left {
                    break;
                }
                *(if now > 0.0 { &mut high } else { &mut low }) = share;
            }
        }
        let shares = hessian(u, &found).and_then(|factor| factor.l().try_inverse()).filter(|_| size > 0.0);
        let shares = shares.unwrap_or_else(Matrix3::zeros);
        let sum = |shares: [f64; 3]| -> SVector<f64, D> { ways.iter().zip(shares).map(|(way, own)| way * own).sum() };
        Closest {
            point: own.place(self.middle) + sum(inner(u).into()),
            gap: found.distance + soft * rise(u),
            normal: other.along(found.normal),
            slides: std::array::from_fn(|i| sum(std::array::from_fn(|j| shares[(i, j)]))),
        }
    }
}

/// Return (1 + u²)^(1/2) of the disk and of the line.
fn roots(u: Vector3<f64>) -> [f64; 2] {
    [(1.0 + u[0] * u[0] + u[1] * u[1]).sqrt(), (1.0 + u[2] * u[2]).sqrt()]
}

/// Return ξ.
fn inner(u: Vector3<f64>) -> Vector3<f64> {
    let [disk, line] = roots(u);
    Vector3::new(u[0] / disk, u[1] / disk, u[2] / line)
}

/// Return u.
fn outer(xi: Vector3<f64>) -> Vector3<f64> {
    let of = |square: f64| (1.0 - square).max(f64::EPSILON).sqrt();
    let [disk, line] = [of(xi[0] * xi[0] + xi[1] * xi[1]), of(xi[2] * xi[2])];
    Vector3::new(xi[0] / disk, xi[1] / disk, xi[2] / line)
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
