//! Bending of the membrane: constant moments in each triangle, hinges at the edges.
//!
//! The normals of two triangles turn at their edge e by the angle θ_e. The moment M_e across the edge, per length, is
//! the same on both sides. Three such moments make the moment tensor of a triangle, and its compliance turns each edge
//! by (C_T M)_e out of the normal:
//!
//! ```text
//! C M = θ − θ_rest,     C = Σ_T C_T,     C_T⁻¹ = D A (l_i l_j/A²) [(1 − ν) (n_i · n_j)² + ν],
//! U = ½ (θ − θ_rest) · C⁻¹ (θ − θ_rest).
//! ```
//!
//! With small angles this is the lowest-order method of Hellan, Herrmann and Johnson for the plate of Kirchhoff, which
//! converges on any regular mesh and has free edges as natural conditions, M_e = 0 (Comodi 1989, Math. Comp. 52, 17).
//! Splitting θ_e into halves, as rotation-free elements do, saves the moments, but is not consistent: the second
//! frequency of a cantilever plate is then 48 % off on a mesh with alternating diagonals.
//!
//! A held edge has one triangle and turns from the normal of the support; a torsion spring there adds its compliance.
//! On a vein with torsion each triangle has an edge of its own, which turns from the director of the vein.
//! C⁻¹ is full, so Newton's matrix has the turn of each edge as an unknown beside the nodes (`system`).

use nalgebra::Matrix3;

use crate::face::{EdgeFrame, Face, FaceShape};
use crate::geometry::Vector;
use crate::twist::Twists;

/// Limit of cos θ: an edge that turns further counts as folded.
const FOLD: f64 = -0.95;

/// Edge with a moment.
pub(crate) struct Hinge {
    /// Ends in the direction of the first triangle.
    pub(crate) nodes: [usize; 2],
    /// Triangle and corner opposite to the edge.
    pub(crate) first: (usize, usize),
    pub(crate) second: Side,
    /// Angle at rest, rad.
    pub(crate) rest: f64,
}

/// Second side of an edge.
pub(crate) enum Side {
    Face(usize, usize),
    /// Support with this normal at rest.
    Support(Vector),
    /// Director of a segment of a vein, which runs along (1) or against (−1) the edge.
    Vein(usize, f64),
}

impl Hinge {
    /// Return θ in a shape, rad, with the `support` turned; `None` at a fold.
    pub(crate) fn turn(&self, shapes: &[FaceShape], support: &Matrix3<f64>, twists: &Twists) -> Option<f64> {
        let FaceShape { normal: first, edges, over, .. } = &shapes[self.first.0];
        let other = match self.second {
            Side::Face(t, _) => shapes[t].normal,
            Side::Support(normal) => support * normal,
            Side::Vein(strand, _) => *twists.director(strand),
        };
        let i = self.first.1;
        let (sin, cos) = (other.cross(first).dot(&edges[i]) * over[i], other.dot(first));
        (cos > FOLD).then(|| sin.atan2(cos))
    }

    /// Return the vector from begin to end of the edge, m.
    pub(crate) fn edge(&self, x: &[Vector]) -> Vector {
        x[self.nodes[1]] - x[self.nodes[0]]
    }
}

/// Add Σ M_i ∂²θ_i/∂x∂x of the edges i of one triangle to its blocks (j, k) of [`crate::face::PAIRS`].
///
/// The part of one triangle is not symmetric, and the difference cancels with the triangle beyond the edge. So each
/// contributes its symmetric part.
#[inline(always)]
pub(crate) fn add_hessian(blocks: &mut [Matrix3<f64>; 6], shape: &FaceShape, moments: [f64; 3]) {
    let n = shape.normal;
    // Row of the corners j and k: the part along n of ∂²θ.
    let mut rows = [[Vector::zeros(); 3]; 3];
    for (i, moment) in moments.into_iter().enumerate().filter(|(_, moment)| *moment != 0.0) {
        let EdgeFrame { along, across, by_along, by_across } = shape.edge(i);
        let (along, across) = (along * moment, across * moment);
        for (j, row) in rows.iter_mut().enumerate() {
            for (k, row) in row.iter_mut().enumerate() {
                let both = by_across[j] * by_across[k] + 0.5 * by_along[j] * by_along[k];
                *row += across * both + along * (by_across[k] * by_along[j]);
            }
        }
    }
    for (block, (j, k)) in blocks.iter_mut().zip(crate::face::PAIRS) {
        let (row, column) = (rows[j][k], rows[k][j]);
        *block -= Matrix3::from_fn(|r, c| n[r] * row[c] + column[r] * n[c]);
    }
}

/// Return Σ π_ij Q_il π_lk and Σ Q_il π_lk, with the turns π of the edges i and l of a triangle by its corners j
/// and k.
#[inline(always)]
pub(crate) fn stiffness(shape: &FaceShape, bending: &Matrix3<f64>) -> (Matrix3<f64>, Matrix3<f64>) {
    let moments = bending * shape.by_across;
    (shape.by_across.transpose() * moments, moments)
}

/// Return C_T of a triangle of bending stiffness D, rad/(N m).
pub(crate) fn compliance(face: &Face, corners: [Vector; 3], bending_stiffness: f64, nu: f64) -> Option<Matrix3<f64>> {
    let edges: [Vector; 3] = std::array::from_fn(|i| corners[(i + 2) % 3] - corners[(i + 1) % 3]);
    Matrix3::from_fn(|i, j| {
        let lengths = edges[i].norm() * edges[j].norm();
        let cosine = edges[i].dot(&edges[j]) / lengths;
        bending_stiffness * lengths / face.area * ((1.0 - nu) * cosine * cosine + nu)
    })
    .try_inverse()
}
