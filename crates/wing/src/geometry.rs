//! Vectors, and flaws of a mesh as errors.

use mesh::{Flaw, Mesh};
use nalgebra::Vector3;

use crate::Error;

/// A point, a velocity or a force.
pub(crate) type Vector = Vector3<f64>;

/// Positions of a mesh as vectors.
pub(crate) trait Geometry {
    /// Return the position of node `k` at rest.
    fn node(&self, k: usize) -> Vector;
}

impl Geometry for Mesh {
    fn node(&self, k: usize) -> Vector {
        Vector::from(self.nodes[k])
    }
}

/// Return the error of a mesh with this flaw.
pub(crate) fn refused(Flaw { key, value, allowed }: Flaw) -> Error {
    Error::value(format!("mesh.{key}"), &value[..], allowed)
}
