//! The fields of the flow at one time.

use line_fft::Real;
use serde::{Deserialize, Serialize};

use crate::field::Field;

/// Velocity and vorticity at one time, `[nx, ny]` each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Flow<R: Real> {
    /// Velocity, m/s, per component.
    pub velocity: [Field<R>; 2],
    /// Vorticity, 1/s.
    pub vorticity: Field<R>,
}

impl<R: Real> Flow<R> {
    /// A uniform flow (m/s) at `n` points.
    pub fn uniform(velocity: [f64; 2], n: usize) -> Self {
        Self { velocity: velocity.map(|u| Field::uniform(R::rounded(u), n)), vorticity: Field::uniform(R::zero(), n) }
    }

    /// Copy `other`, which has the same size; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.velocity.iter_mut().zip(&other.velocity).for_each(|(own, other)| own.copy_from_slice(other));
        self.vorticity.copy_from_slice(&other.vorticity);
    }

    /// Return whether `other` has the same size.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let lengths = |flow: &Self| (flow.velocity.each_ref().map(|u| u.len()), flow.vorticity.len());
        lengths(self) == lengths(other)
    }

    /// Return the velocity at a grid point, m/s.
    #[inline(always)]
    pub fn velocity_at(&self, point: usize) -> [f64; 2] {
        self.velocity.each_ref().map(|u| u[point].to_f64())
    }
}
