//! Rotations of the nodes since a factorisation.
//!
//! Newton's matrix K of a shape that has turned is R K Rᵀ, and its factors are those of K. A wing that bends turns
//! each node by a rotation of its own. With it old factors stay good: otherwise the stiff plane of each triangle is
//! tilted. The frame of a node is the mean deformation gradient of its triangles, made orthonormal.

use nalgebra::Matrix3;

use crate::face::Face;
use crate::geometry::Vector;

pub(crate) struct Frames {
    /// Inverse of two edges and the normal of each triangle at rest: `[triangles]`.
    rest: Vec<Matrix3<f64>>,
    /// Frames in the shape of the factors, and in the last shape: `[nodes]`.
    before: Vec<Matrix3<f64>>,
    now: Vec<Matrix3<f64>>,
}

impl Frames {
    pub(crate) fn new(rest: &[Vector], faces: &[Face]) -> Self {
        let inverse = |face: &Face| triad(face, rest).try_inverse().unwrap_or_else(Matrix3::identity);
        let still = vec![Matrix3::identity(); rest.len()];
        Self { rest: faces.iter().map(inverse).collect(), before: still.clone(), now: still }
    }

    /// Take the shape `x` for the shape of the factors.
    pub(crate) fn set(&mut self, faces: &[Face], x: &[Vector]) {
        self.find(faces, x);
        self.before.copy_from_slice(&self.now);
    }

    /// Write the rotation of each node from the shape of the factors to `x` to `rotations`: `[nodes]`.
    pub(crate) fn turn(&mut self, faces: &[Face], x: &[Vector], rotations: &mut [Matrix3<f64>]) {
        self.find(faces, x);
        for ((rotation, now), before) in rotations.iter_mut().zip(&self.now).zip(&self.before) {
            *rotation = now * before.transpose();
        }
    }

    fn find(&mut self, faces: &[Face], x: &[Vector]) {
        self.now.fill(Matrix3::zeros());
        for (face, rest) in faces.iter().zip(&self.rest) {
            let gradient = triad(face, x) * rest;
            face.nodes.iter().for_each(|&k| self.now[k] += gradient);
        }
        for frame in &mut self.now {
            let first = frame.column(0).normalize();
            let second = (frame.column(1) - first * first.dot(&frame.column(1))).normalize();
            *frame = Matrix3::from_columns(&[first, second, first.cross(&second)]);
            // A node of veins alone has no triangle.
            if frame.iter().any(|c| !c.is_finite()) {
                *frame = Matrix3::identity();
            }
        }
    }
}

/// Return two edges and the unit normal of a triangle in the shape `x`, in columns.
fn triad(face: &Face, x: &[Vector]) -> Matrix3<f64> {
    let [a, b, c] = face.nodes.map(|k| x[k]);
    let (u, v) = (b - a, c - a);
    Matrix3::from_columns(&[u, v, u.cross(&v).normalize()])
}
