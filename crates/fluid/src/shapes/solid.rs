//! Shapes in space.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use super::{Between, Moments, Nearest, Shape};

/// Iterations of Newton's method for the nearest point of an ellipsoid; more than ten only near its middle.
const NEWTON_STEPS: usize = 40;

/// Least distance from a plane of symmetry of an ellipsoid, over that semi-axis: on the plane the equation has a pole.
const OFF_PLANE: f64 = 1e-12;

/// Shape of a body in space, about the origin of its axes.
#[derive(Clone, Debug)]
pub enum Solid {
    /// Sphere of a radius, m.
    Sphere(f64),
    /// Ellipsoid of semi-axes, m.
    Ellipsoid([f64; 3]),
    /// Circular cylinder.
    Cylinder {
        /// Axis of the body along which it lies: 0, 1 or 2.
        axis: usize,
        /// Radius, m.
        radius: f64,
        /// Half the length, m; infinite for a cylinder through the whole domain.
        half_length: f64,
    },
    /// Cuboid of half its lengths, m; a plate is a thin one.
    Cuboid([f64; 3]),
    /// Nodes, m, and triangles of no thickness, which markers represent.
    Surface(Vec<[f64; 3]>, Vec<[usize; 3]>),
}

impl From<Solid> for Arc<dyn Shape<3>> {
    fn from(solid: Solid) -> Self {
        Arc::new(solid)
    }
}

impl Shape<3> for Solid {
    fn is_round(&self) -> bool {
        matches!(self, Self::Sphere(_))
    }

    fn thickness(&self) -> f64 {
        match self {
            Self::Sphere(radius) => 2.0 * radius,
            Self::Ellipsoid(semi_axes) | Self::Cuboid(semi_axes) => {
                2.0 * semi_axes.iter().copied().fold(f64::INFINITY, f64::min)
            }
            Self::Cylinder { radius, half_length, .. } => 2.0 * radius.min(*half_length),
            Self::Surface(..) => 0.0,
        }
    }

    fn extent(&self, direction: &Vector3<f64>) -> f64 {
        match *self {
            Self::Sphere(radius) => radius,
            Self::Ellipsoid(semi_axes) => direction.component_mul(&Vector3::from(semi_axes)).norm(),
            Self::Cuboid(half) => direction.abs().dot(&Vector3::from(half)),
            Self::Cylinder { axis, radius, half_length } => {
                let along = direction[axis].abs();
                let ends = if along == 0.0 { 0.0 } else { half_length * along };
                radius * (1.0 - along * along).max(0.0).sqrt() + ends
            }
            Self::Surface(..) => 0.0,
        }
    }

    fn moments(&self, size: &[f64; 3]) -> Moments<3> {
        // Mean squares along the axes.
        let (volume, square) = match *self {
            Self::Sphere(radius) => (4.0 / 3.0 * PI * radius.powi(3), Vector3::repeat(radius * radius / 5.0)),
            Self::Ellipsoid([a, b, c]) => (4.0 / 3.0 * PI * a * b * c, Vector3::new(a * a, b * b, c * c) / 5.0),
            Self::Cuboid([a, b, c]) => (8.0 * a * b * c, Vector3::new(a * a, b * b, c * c) / 3.0),
            Self::Cylinder { axis, radius, half_length } => {
                let half = half_length.min(0.5 * size[axis]);
                let mut square = Vector3::repeat(0.25 * radius * radius);
                square[axis] = half * half / 3.0;
                (2.0 * half * PI * radius * radius, square)
            }
            Self::Surface(..) => (0.0, Vector3::zeros()),
        };
        let inertia = Matrix3::from_diagonal(&(volume * (Vector3::repeat(square.sum()) - square)));
        Moments { volume, centroid: Vector3::zeros(), inertia }
    }

    fn nearest(&self, point: Vector3<f64>) -> Nearest<3> {
        let (distance, normal) = self.distance_and_normal(point);
        Nearest { distance, surface: point - distance * normal, normal }
    }

    fn thin(&self) -> Option<(Vec<[f64; 3]>, Between)> {
        let Self::Surface(nodes, triangles) = self else { return None };
        Some((nodes.clone(), Between::Triangles(triangles.clone())))
    }
}

impl Solid {
    /// Return the signed distance (m, positive outside) and the unit normal of the nearest point of the surface.
    fn distance_and_normal(&self, point: Vector3<f64>) -> (f64, Vector3<f64>) {
        match *self {
            Self::Sphere(radius) => {
                let from_center = point.norm();
                (from_center - radius, point / from_center.max(f64::MIN_POSITIVE))
            }
            Self::Ellipsoid(semi_axes) => nearest_of_ellipsoid(point, semi_axes.into()),
            Self::Cuboid(half) => {
                let beyond = point.abs() - Vector3::from(half);
                let face = beyond.imax();
                (beyond[face], Vector3::ith(face, 1_f64.copysign(point[face])))
            }
            Self::Cylinder { axis, radius, half_length } => {
                let mut across = point;
                across[axis] = 0.0;
                let from_axis = across.norm();
                let [side, end] = [from_axis - radius, point[axis].abs() - half_length];
                if side > end {
                    (side, across / from_axis.max(f64::MIN_POSITIVE))
                } else {
                    (end, Vector3::ith(axis, 1_f64.copysign(point[axis])))
                }
            }
            Self::Surface(..) => (f64::INFINITY, Vector3::zeros()),
        }
    }
}

/// Return the distance and the normal at the point `x_i = a_i² p_i/(t + a_i²)` of the ellipsoid nearest to p. t is the
/// largest root of `F(t) = Σ (a_i p_i/(t + a_i²))² − 1`, which is convex and decreases there.
fn nearest_of_ellipsoid(point: Vector3<f64>, a: Vector3<f64>) -> (f64, Vector3<f64>) {
    let p = point.abs().sup(&(OFF_PLANE * a));
    let squares = a.component_mul(&a);
    // F is not negative here, so Newton's method increases t up to the root.
    let mut t = (a.component_mul(&p) - squares).max();
    for _ in 0..NEWTON_STEPS {
        let x = a.component_mul(&p).component_div(&squares.add_scalar(t));
        let slope = -2.0 * x.component_mul(&x).component_div(&squares.add_scalar(t)).sum();
        let step = -(x.norm_squared() - 1.0) / slope;
        t += step;
        if step <= 1e-15 * squares.max() {
            break;
        }
    }
    let surface = squares.component_mul(&p).component_div(&squares.add_scalar(t));
    let normal = surface.component_div(&squares).normalize();
    ((p - surface).dot(&normal), normal.zip_map(&point, f64::copysign))
}
