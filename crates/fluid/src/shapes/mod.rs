//! Shapes of rigid bodies: nearest point of the surface, thickness, volume and its moments, in the axes of the body.

mod outline;
mod polygon;
mod solid;

use std::fmt::Debug;

pub use outline::Outline;
pub use solid::Solid;

use crate::space::{Space, Vector};

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<const D: usize> {
    /// Signed distance, m, positive outside. Outside corners of a polygon it is the distance to the lines of the sides,
    /// so that distance contours are mitred.
    pub distance: f64,
    /// That point, or the point on the line of the side, m.
    pub surface: Vector<D>,
    /// Unit normal outwards.
    pub normal: Vector<D>,
}

/// Volume and its moments, in the plane of an area.
#[derive(Clone, Copy, Debug)]
pub struct Moments<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Volume, m³, or area, m².
    pub volume: f64,
    /// Centroid, m.
    pub centroid: Vector<D>,
    /// Moments of inertia about the centroid for a density of 1, m⁵, or m⁴ in the plane.
    pub inertia: <[f64; D] as Space<D>>::Inertia,
}

/// What lies between the nodes of a shape without thickness.
#[derive(Clone, Debug)]
pub enum Between {
    /// A line through all of them.
    Line,
    /// Triangles, each of three nodes.
    Triangles(Vec<[usize; 3]>),
}

/// A shape of a rigid body, about the origin of its axes.
pub trait Shape<const D: usize>: Debug + Send + Sync
where
    [f64; D]: Space<D>,
{
    /// Return whether it is a circle or a sphere.
    fn is_round(&self) -> bool;

    /// Return the radius of a shape around which the pressure is known to be extrapolated well; none of others.
    fn radius(&self) -> Option<f64> {
        None
    }

    /// Return whether its drag fills the box around it, beyond its reach.
    fn fills_box(&self) -> bool {
        false
    }

    /// Return the diameter of the largest ball inside, m.
    fn thickness(&self) -> f64;

    /// Return the extent from the origin in the direction of a unit vector, m.
    fn extent(&self, direction: &Vector<D>) -> f64;

    /// Return the volume and its moments in a domain of a size (m), which a shape without ends fills.
    fn moments(&self, size: &[f64; D]) -> Moments<D>;

    /// Return the nearest point of the surface of a solid.
    fn nearest(&self, point: Vector<D>) -> Nearest<D>;

    /// Return the nodes of a shape without thickness, m, and what lies between them; none of a solid.
    fn thin(&self) -> Option<(Vec<[f64; D]>, Between)> {
        None
    }

    /// Return the moments of a layer of a thickness (m) along a shape without thickness; none if they are to be those of
    /// its markers.
    fn layer(&self, _thickness: f64) -> Option<Moments<D>> {
        None
    }
}

impl<const D: usize> Moments<D>
where
    [f64; D]: Space<D>,
{
    /// Return mass and moments of inertia about a `pivot` for a density (kg/m³).
    pub fn about(&self, pivot: [f64; D], density: f64) -> (f64, <[f64; D] as Space<D>>::Inertia) {
        let arm = self.centroid - Vector::from(pivot);
        (density * self.volume, <[f64; D]>::shifted(self.inertia, self.volume, &arm) * density)
    }
}
