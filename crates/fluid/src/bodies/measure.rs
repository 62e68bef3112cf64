//! The contract of bodies: what a body is at a place.

use crate::space::{Space, Spin, Vector};

/// A body that can be measured.
///
/// Everything that its drag on the fluid depends on follows from `measure`: the drag profile from the distance, the
/// wall target from the surfaces, and the velocity to which the fluid is drawn. `N` is the number of surfaces that may
/// be near a point.
pub trait Measured<const D: usize, const N: usize>
where
    [f64; D]: Space<D>,
{
    /// A point near the body, with what is known of its place in the body.
    type Place;

    /// Measure the body at a place.
    fn measure(&self, place: &Self::Place) -> Measure<D, N>;
}

/// A body at a point.
#[derive(Clone, Copy, Debug)]
pub struct Measure<const D: usize, const N: usize>
where
    [f64; D]: Space<D>,
{
    /// Surfaces of the body.
    pub surfaces: [Surface<D>; N],
    /// Velocity of the body at the point, m/s.
    pub velocity: Vector<D>,
    /// The same at the beginning of the step, m/s.
    pub velocity_before: Vector<D>,
    /// Angular velocity of a body whose velocity along a surface grows with the distance from it, 1/s.
    pub spin: Option<Spin<D>>,
}

/// A surface, measured from a point.
#[derive(Clone, Copy, Debug)]
pub struct Surface<const D: usize> {
    /// Signed distance, m, positive in the fluid.
    pub distance: f64,
    /// Nearest point of the surface, m.
    pub foot: Vector<D>,
    /// Unit normal into the fluid.
    pub normal: Vector<D>,
}

impl<const D: usize, const N: usize> Measure<D, N>
where
    [f64; D]: Space<D>,
{
    /// Return the signed distance from the body, m, positive in the fluid.
    #[inline(always)]
    pub fn distance(&self) -> f64 {
        self.surfaces.iter().map(|surface| surface.distance).fold(f64::NEG_INFINITY, f64::max)
    }
}
