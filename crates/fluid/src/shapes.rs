//! Shapes of rigid bodies: what the drag on the fluid and the displaced fluid need of them, in the axes of the body.

use std::fmt::Debug;

use contact::{Obstacle, Pose};
use geometry::plane::Outline;
use geometry::space::Solid;
use geometry::{Nearest, Region, Section};

use crate::space::{Kinematics, Space, Vector};

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
    pub inertia: <[f64; D] as Kinematics<D>>::Inertia,
}

/// What lies between the nodes of a shape without thickness.
#[derive(Clone, Debug)]
pub enum Between {
    /// A line through all of them.
    Line,
    /// Triangles, each of three nodes.
    Triangles(Vec<[usize; 3]>),
}

/// A shape of a rigid body, about the origin of its axes: the closed ones of `nervure-geometry`, a [`Polyline`] or a
/// [`Triangulation`].
pub trait Shape<const D: usize>: Debug + Send + Sync
where
    [f64; D]: Space<D>,
{
    /// Return the closed shape; none of a shape without thickness.
    fn region(&self) -> Option<&dyn Region<D>> {
        None
    }

    /// Return the radius of a circle or a sphere.
    fn radius(&self) -> Option<f64> {
        None
    }

    /// Return the solid that it is in contact; none of a shape that cannot touch.
    fn obstacle(&self) -> Option<Obstacle<D>> {
        None
    }

    /// Return whether its drag fills the box around it, beyond its reach.
    fn fills_box(&self) -> bool {
        false
    }

    /// Return the volume and its moments in a domain of a size (m), which a shape without ends fills.
    fn moments(&self, size: &[f64; D]) -> Moments<D>;

    /// Return the nodes of a shape without thickness, m, and what lies between them; none of a closed shape.
    fn thin(&self) -> Option<(Vec<[f64; D]>, Between)> {
        None
    }

    /// Return the moments of a layer of a thickness (m) along a shape without thickness; none if they are to be those of
    /// its markers.
    fn layer(&self, _thickness: f64) -> Option<Moments<D>> {
        None
    }
}

/// An open line of no thickness through at least two points in the plane, m, which markers represent.
#[derive(Clone, Debug)]
pub struct Polyline(pub Vec<[f64; 2]>);

/// Nodes in space, m, and triangles of no thickness between them, which markers represent.
#[derive(Clone, Debug)]
pub struct Triangulation(pub Vec<[f64; 3]>, pub Vec<[usize; 3]>);

impl<const D: usize> Moments<D>
where
    [f64; D]: Space<D>,
{
    /// Return mass and moments of inertia about a `pivot` for a density (kg/m³).
    pub fn about(&self, pivot: [f64; D], density: f64) -> (f64, <[f64; D] as Kinematics<D>>::Inertia) {
        let arm = self.centroid - Vector::from(pivot);
        (density * self.volume, <[f64; D]>::shifted(self.inertia, self.volume, &arm) * density)
    }

    /// No volume.
    fn none() -> Self {
        Self { volume: 0.0, centroid: Vector::zeros(), inertia: <[f64; D]>::inertia([0.0; 3]) }
    }
}

impl Shape<2> for Outline {
    fn region(&self) -> Option<&dyn Region<2>> {
        Some(self)
    }

    fn radius(&self) -> Option<f64> {
        if let Self::Circle(radius) = self { Some(*radius) } else { None }
    }

    fn obstacle(&self) -> Option<Obstacle<2>> {
        Obstacle::of_outline(self, Pose::at([0.0; 2]))
    }

    fn fills_box(&self) -> bool {
        matches!(self, Self::Circle(_))
    }

    fn moments(&self, _: &[f64; 2]) -> Moments<2> {
        let Section { area: volume, centroid, polar: inertia } = self.section();
        Moments { volume, centroid: centroid.into(), inertia }
    }
}

impl Shape<3> for Solid {
    fn region(&self) -> Option<&dyn Region<3>> {
        Some(self)
    }

    fn radius(&self) -> Option<f64> {
        if let Self::Sphere(radius) = self { Some(*radius) } else { None }
    }

    fn obstacle(&self) -> Option<Obstacle<3>> {
        Obstacle::of_solid(self, Pose::at([0.0; 3]))
    }

    fn moments(&self, size: &[f64; 3]) -> Moments<3> {
        let (volume, about) = self.inertia(*size);
        Moments { volume, centroid: Vector::zeros(), inertia: <[f64; 3]>::inertia(about) }
    }
}

impl Shape<2> for Polyline {
    fn moments(&self, _: &[f64; 2]) -> Moments<2> {
        Moments::none()
    }

    fn thin(&self) -> Option<(Vec<[f64; 2]>, Between)> {
        Some((self.0.clone(), Between::Line))
    }

    fn layer(&self, thickness: f64) -> Option<Moments<2>> {
        let sides = || {
            self.0.windows(2).map(|side| {
                let middle = [0, 1].map(|axis| 0.5 * (side[0][axis] + side[1][axis]));
                (middle, (side[1][0] - side[0][0]).hypot(side[1][1] - side[0][1]))
            })
        };
        let length: f64 = sides().map(|(_, length)| length).sum();
        let centroid = [0, 1].map(|axis| sides().map(|(middle, part)| middle[axis] * part).sum::<f64>() / length);
        let polar = |(middle, part): ([f64; 2], f64)| {
            let arm = [0, 1].map(|axis| middle[axis] - centroid[axis]);
            part * (arm[0] * arm[0] + arm[1] * arm[1] + part * part / 12.0)
        };
        let inertia = thickness * sides().map(polar).sum::<f64>();
        Some(Moments { volume: thickness * length, centroid: centroid.into(), inertia })
    }
}

impl Shape<3> for Triangulation {
    fn moments(&self, _: &[f64; 3]) -> Moments<3> {
        Moments::none()
    }

    fn thin(&self) -> Option<(Vec<[f64; 3]>, Between)> {
        Some((self.0.clone(), Between::Triangles(self.1.clone())))
    }
}

/// Return signed distance (m, positive outside), nearest point (m) and outward normal of a closed shape.
#[inline(always)]
pub fn nearest<const D: usize>(region: &dyn Region<D>, point: Vector<D>) -> (f64, Vector<D>, Vector<D>) {
    let Nearest { distance, surface, normal } = region.nearest(point.into());
    (distance, surface.into(), normal.into())
}
