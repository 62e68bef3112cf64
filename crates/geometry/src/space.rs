//! Solids in their own axes: nearest point of the surface, thickness, volume and moments of inertia.

use std::f64::consts::PI;

use crate::region::{Nearest, Region};
use crate::vector::{dot, norm};

/// Iterations of Newton's method for the nearest point of an ellipsoid; more than ten only near its middle.
const NEWTON_STEPS: usize = 40;

/// Least distance from a plane of symmetry of an ellipsoid, over that semi-axis: on the plane the equation has a pole.
const OFF_PLANE: f64 = 1e-12;

/// A solid; the origin of its axes is its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// Sphere of this radius, m.
    Sphere(f64),
    /// Ellipsoid with these semi-axes, m.
    Ellipsoid([f64; 3]),
    /// Cuboid with these halves of its lengths, m.
    Cuboid([f64; 3]),
    /// Circular cylinder.
    Cylinder {
        /// Own axis along which it lies.
        axis: usize,
        /// Radius, m.
        radius: f64,
        /// Half its length, m; infinite without ends.
        half_length: f64,
    },
    /// Circular cylinder with half spheres at its ends.
    Capsule {
        /// Own axis along which it lies.
        axis: usize,
        /// Radius, m.
        radius: f64,
        /// Half the length of the cylinder, m.
        half_length: f64,
    },
}

impl Solid {
    /// Return half the lengths along its own axes, m.
    pub fn half_lengths(&self) -> [f64; 3] {
        match *self {
            Self::Sphere(radius) => [radius; 3],
            Self::Ellipsoid(half) | Self::Cuboid(half) => half,
            Self::Cylinder { axis, radius, half_length } => {
                let mut half = [radius; 3];
                half[axis] = half_length;
                half
            }
            Self::Capsule { axis, radius, half_length } => {
                let mut half = [radius; 3];
                half[axis] += half_length;
                half
            }
        }
    }

    /// Return the volume (m³) and the moments of inertia about the own axes for a density of 1 (m⁵). A cylinder without
    /// ends has the `length` of the domain, m.
    pub fn inertia(&self, length: [f64; 3]) -> (f64, [f64; 3]) {
        // Mean squares along the axes.
        let (volume, square) = match *self {
            Self::Sphere(radius) => (4.0 / 3.0 * PI * radius.powi(3), [radius * radius / 5.0; 3]),
            Self::Ellipsoid([a, b, c]) => (4.0 / 3.0 * PI * a * b * c, [a * a / 5.0, b * b / 5.0, c * c / 5.0]),
            Self::Cuboid([a, b, c]) => (8.0 * a * b * c, [a * a / 3.0, b * b / 3.0, c * c / 3.0]),
            Self::Cylinder { axis, radius, half_length } => {
                let half = half_length.min(0.5 * length[axis]);
                let mut square = [0.25 * radius * radius; 3];
                square[axis] = half * half / 3.0;
                (2.0 * half * PI * radius * radius, square)
            }
            Self::Capsule { axis, radius, half_length } => {
                let [cylinder, ends] = [2.0 * half_length, 4.0 / 3.0 * radius].map(|h| h * PI * radius * radius);
                let volume = cylinder + ends;
                let mut square = [(0.25 * cylinder + 0.2 * ends) * radius * radius / volume; 3];
                let along = half_length * (half_length + 0.75 * radius) + radius * radius / 5.0;
                square[axis] = (cylinder * half_length * half_length / 3.0 + ends * along) / volume;
                (volume, square)
            }
        };
        let sum: f64 = square.iter().sum();
        (volume, square.map(|own| volume * (sum - own)))
    }
}

impl Region<3> for Solid {
    fn nearest(&self, point: [f64; 3]) -> Nearest<3> {
        let (distance, normal) = match *self {
            Self::Sphere(radius) => {
                let from_center = norm(point);
                (from_center - radius, point.map(|at| at / from_center.max(f64::MIN_POSITIVE)))
            }
            Self::Ellipsoid(semi_axes) => nearest_of_ellipsoid(point, semi_axes),
            Self::Cuboid(half) => {
                let beyond = |face: usize| point[face].abs() - half[face];
                let face = (1..3).fold(0, |most, face| if beyond(face) > beyond(most) { face } else { most });
                (beyond(face), unit(face, point[face]))
            }
            Self::Cylinder { axis, radius, half_length } => {
                let mut across = point;
                across[axis] = 0.0;
                let from_axis = norm(across);
                let [side, end] = [from_axis - radius, point[axis].abs() - half_length];
                if side > end {
                    (side, across.map(|at| at / from_axis.max(f64::MIN_POSITIVE)))
                } else {
                    (end, unit(axis, point[axis]))
                }
            }
            Self::Capsule { axis, radius, half_length } => {
                let mut from_core = point;
                from_core[axis] -= point[axis].clamp(-half_length, half_length);
                let distance = norm(from_core);
                (distance - radius, from_core.map(|at| at / distance.max(f64::MIN_POSITIVE)))
            }
        };
        Nearest { distance, surface: std::array::from_fn(|d| point[d] - distance * normal[d]), normal }
    }

    fn extent(&self, direction: [f64; 3]) -> f64 {
        match *self {
            Self::Sphere(radius) => radius,
            Self::Ellipsoid(a) => norm([0, 1, 2].map(|d| a[d] * direction[d])),
            Self::Cuboid(half) => dot(half, direction.map(f64::abs)),
            Self::Cylinder { axis, radius, half_length } => {
                let along = direction[axis].abs();
                let ends = if along == 0.0 { 0.0 } else { half_length * along };
                radius * (1.0 - along * along).max(0.0).sqrt() + ends
            }
            Self::Capsule { axis, radius, half_length } => radius + half_length * direction[axis].abs(),
        }
    }

    fn thickness(&self) -> f64 {
        2.0 * self.half_lengths().into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Return the corners of the cuboid around the solid.
    fn corners(&self) -> Vec<[f64; 3]> {
        let half = self.half_lengths();
        (0..8).map(|k| std::array::from_fn(|d| if k >> d & 1 == 0 { half[d] } else { -half[d] })).collect()
    }
}

/// Return the unit vector along an axis with the sign of `at`.
fn unit(axis: usize, at: f64) -> [f64; 3] {
    std::array::from_fn(|d| if d == axis { 1_f64.copysign(at) } else { 0.0 })
}

/// Return the distance and the normal at the point `x_i = a_i² p_i/(t + a_i²)` of the ellipsoid nearest to p. t is the
/// largest root of `F(t) = Σ (a_i p_i/(t + a_i²))² − 1`, which is convex and decreases there.
fn nearest_of_ellipsoid(point: [f64; 3], a: [f64; 3]) -> (f64, [f64; 3]) {
    let p = [0, 1, 2].map(|d| point[d].abs().max(OFF_PLANE * a[d]));
    let squares = a.map(|own| own * own);
    let largest = |v: [f64; 3]| v.into_iter().fold(f64::NEG_INFINITY, f64::max);
    // F is not negative here, so Newton's method increases t up to the root.
    let mut t = largest([0, 1, 2].map(|d| a[d] * p[d] - squares[d]));
    for _ in 0..NEWTON_STEPS {
        let x = [0, 1, 2].map(|d| a[d] * p[d] / (squares[d] + t));
        let slope = -2.0 * (0..3).map(|d| x[d] * x[d] / (squares[d] + t)).sum::<f64>();
        let step = -(dot(x, x) - 1.0) / slope;
        t += step;
        if step <= 1e-15 * largest(squares) {
            break;
        }
    }
    let surface = [0, 1, 2].map(|d| squares[d] * p[d] / (squares[d] + t));
    let gradient = [0, 1, 2].map(|d| surface[d] / squares[d]);
    let normal = gradient.map(|own| own / norm(gradient));
    (dot([0, 1, 2].map(|d| p[d] - surface[d]), normal), [0, 1, 2].map(|d| normal[d].copysign(point[d])))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From a point of the surface along its normal, outwards and a little inwards, that point is the nearest.
    #[test]
    fn the_nearest_point_of_a_solid_lies_along_its_normal() {
        let a = [0.5, 0.3, 0.06];
        for k in 0..64 {
            let (polar, around) = (0.05 + 0.045 * f64::from(k), 2.4 * f64::from(k));
            let unit = [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()];
            let surface: [f64; 3] = std::array::from_fn(|d| a[d] * unit[d]);
            let gradient: [f64; 3] = std::array::from_fn(|d| unit[d] / a[d]);
            let normal = gradient.map(|own| own / norm(gradient));
            for distance in [-1e-3, 0.0, 0.02, 3.0] {
                let point = std::array::from_fn(|d| surface[d] + distance * normal[d]);
                let found = Solid::Ellipsoid(a).nearest(point);
                let off = norm([0, 1, 2].map(|d| found.normal[d] - normal[d]));
                assert!((found.distance - distance).abs() < 1e-9 && off < 1e-6, "{k}, {distance}: {found:?}");
            }
        }
        let (cuboid, ball) = (Solid::Cuboid([0.5, 0.3, 0.1]), Solid::Sphere(0.3));
        let cylinder = Solid::Cylinder { axis: 1, radius: 0.3, half_length: 0.5 };
        let found = [cuboid.nearest([0.1, -0.2, 0.05]), cuboid.nearest([0.7, 0.0, 0.1]), ball.nearest([0.3, 0.4, 0.0])];
        let capsule = Solid::Capsule { axis: 0, radius: 0.2, half_length: 0.5 };
        let more = [
            cylinder.nearest([0.0, 0.45, 0.1]),
            cylinder.nearest([0.3, 0.2, -0.4]),
            capsule.nearest([-0.8, 0.4, 0.0]),
            capsule.nearest([0.3, 0.0, -0.1]),
        ];
        let distances = found.iter().chain(&more).map(|own| own.distance);
        let expected = [-0.05, 0.2, 0.2, -0.05, 0.2, 0.3, -0.1];
        for (i, (own, wanted)) in distances.zip(expected).enumerate() {
            assert!((own - wanted).abs() < 1e-15, "{i}: {own}, not {wanted}");
        }
        assert_eq!([found[0].normal, found[1].normal], [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn a_solid_weighs_what_its_points_do() {
        let (n, length) = (60, [2.0; 3]);
        let solids = [
            Solid::Sphere(0.4),
            Solid::Ellipsoid([0.5, 0.3, 0.2]),
            Solid::Cuboid([0.5, 0.3, 0.2]),
            Solid::Cylinder { axis: 2, radius: 0.4, half_length: f64::INFINITY },
            Solid::Capsule { axis: 1, radius: 0.4, half_length: 0.5 },
        ];
        for solid in solids {
            let (mut volume, mut moments) = (0.0, [0.0; 3]);
            for p in crate::bounds::grid([[-1.0, 1.0]; 3], n).filter(|p| solid.nearest(*p).distance < 0.0) {
                let cell = (2.0 / n as f64).powi(3);
                volume += cell;
                (0..3).for_each(|d| moments[d] += cell * (dot(p, p) - p[d] * p[d]));
            }
            let (own, about) = solid.inertia(length);
            assert!((own / volume - 1.0).abs() < 0.02, "{solid:?}: {own}, not {volume}");
            for d in 0..3 {
                assert!((about[d] / moments[d] - 1.0).abs() < 0.04, "{solid:?}: {about:?}, not {moments:?}");
            }
        }
    }
}
