//! The fields of the flow at one time.

use line_fft::Real;
use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use crate::field::Field;
use crate::space::Space;

/// Velocity and vorticity at one time, `[nx, ny]` or `[nx, ny, nz]` each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Flow<R: Real, const D: usize> {
    /// Velocity, m/s, per component.
    #[serde(with = "BigArray")]
    pub velocity: [Field<R>; D],
    /// Vorticity, 1/s: one component in the plane, three in space.
    pub vorticity: Vec<Field<R>>,
}

impl<R: Real, const D: usize> Flow<R, D>
where
    [f64; D]: Space<D>,
{
    /// A uniform flow (m/s) at `n` points.
    pub fn uniform(velocity: [f64; D], n: usize) -> Self {
        let vorticity = (0..<[f64; D]>::VORTICITY).map(|_| Field::uniform(R::zero(), n));
        Self { velocity: velocity.map(|u| Field::uniform(R::rounded(u), n)), vorticity: vorticity.collect() }
    }
}

impl<R: Real, const D: usize> Flow<R, D> {
    /// Return the fields: velocity, then vorticity.
    pub fn fields(&self) -> impl Iterator<Item = &Field<R>> {
        self.velocity.iter().chain(&self.vorticity)
    }

    /// Return the fields, to be changed.
    pub fn fields_mut(&mut self) -> impl Iterator<Item = &mut Field<R>> {
        self.velocity.iter_mut().chain(&mut self.vorticity)
    }

    /// Copy `other`, which has the same size; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.fields_mut().zip(other.fields()).for_each(|(own, other)| own.copy_from_slice(other));
    }

    /// Return whether `other` has the same size.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        self.vorticity.len() == other.vorticity.len()
            && self.fields().zip(other.fields()).all(|(own, other)| own.len() == other.len())
    }

    /// Return the velocity interpolated by grid points and weights, m/s.
    pub fn velocity_by(&self, weights: &[(usize, f64)]) -> [f64; D] {
        let component = |u: &[R]| weights.iter().map(|&(point, weight)| weight * u[point].to_f64()).sum();
        self.velocity.each_ref().map(|u| component(u))
    }

    /// Return the velocity at a grid point, m/s.
    #[inline(always)]
    pub fn velocity_at(&self, point: usize) -> [f64; D] {
        self.velocity.each_ref().map(|u| u[point].to_f64())
    }
}
