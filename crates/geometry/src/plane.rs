//! Outlines in the plane in their own axes: nearest point of the surface, thickness, area and its moments.

use std::f64::consts::PI;

use crate::polygon;
use crate::region::{Nearest, Region, Section};

/// Corners by which a round outline is drawn.
const CORNERS: usize = 64;

/// Iterations of Newton's method for the nearest point of an ellipse. Four to ten are needed; more only near the middle
/// of the line between the foci, where the drag has its largest value.
const NEWTON_STEPS: usize = 40;

/// Least distance from an axis of an ellipse, over that semi-axis: on the axis the equation has a pole.
const OFF_AXIS: f64 = 1e-12;

/// Distance from a face of a rectangle, over the sum of half its lengths, within which a point lies on the face.
const ON_FACE: f64 = 1e-12;

/// A closed outline; the origin of its axes is its middle, except for a polygon.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// Circle of this radius, m.
    Circle(f64),
    /// Ellipse with these semi-axes, m.
    Ellipse([f64; 2]),
    /// Rectangle with these halves of its lengths, m.
    Rectangle([f64; 2]),
    /// Half the length of the straight part along x, and the radius of the half circles at its ends, m.
    Capsule([f64; 2]),
    /// Polygon with these corners in left-hand order, m.
    Polygon(Vec<[f64; 2]>),
}

impl Outline {
    /// Return the polygon with these corners, given either way round, m.
    pub fn polygon(mut corners: Vec<[f64; 2]>) -> Self {
        if polygon::signed_area(&corners) < 0.0 {
            corners.reverse();
        }
        Self::Polygon(corners)
    }

    /// Return the area and its moments.
    pub fn section(&self) -> Section {
        let middle = |area, polar| Section { area, centroid: [0.0; 2], polar };
        match self {
            Self::Circle(radius) => middle(PI * radius.powi(2), 0.5 * PI * radius.powi(4)),
            Self::Ellipse([a, b]) => middle(PI * a * b, 0.25 * PI * a * b * (a * a + b * b)),
            Self::Rectangle([a, b]) => middle(4.0 * a * b, 4.0 / 3.0 * a * b * (a * a + b * b)),
            Self::Capsule([a, r]) => {
                // The half circles have their centroids 4 r/(3 π) from their middles.
                let (straight, caps) = (4.0 * a * r, PI * r * r);
                let off = 4.0 * r / (3.0 * PI);
                let polar = straight / 3.0 * (a * a + r * r) + caps * (0.5 * r * r - off * off + (a + off).powi(2));
                middle(straight + caps, polar)
            }
            Self::Polygon(corners) => polygon::section(corners),
        }
    }
}

impl Region<2> for Outline {
    fn thickness(&self) -> f64 {
        match self {
            Self::Circle(radius) => 2.0 * radius,
            Self::Ellipse([a, b]) | Self::Rectangle([a, b]) => 2.0 * a.min(*b),
            Self::Capsule([_, radius]) => 2.0 * radius,
            Self::Polygon(corners) => 2.0 * polygon::depth(corners),
        }
    }

    fn extent(&self, direction: [f64; 2]) -> f64 {
        let [x, y] = direction;
        match self {
            Self::Circle(radius) => *radius,
            Self::Ellipse([a, b]) => (a * x).hypot(b * y),
            Self::Rectangle([a, b]) => a * x.abs() + b * y.abs(),
            Self::Capsule([a, radius]) => a * x.abs() + radius,
            Self::Polygon(corners) => corners.iter().map(|c| c[0] * x + c[1] * y).fold(f64::NEG_INFINITY, f64::max),
        }
    }

    fn nearest(&self, point: [f64; 2]) -> Nearest<2> {
        match self {
            Self::Circle(radius) => nearest_of_circle(point, [0.0; 2], *radius),
            Self::Ellipse(semi_axes) => nearest_of_ellipse(point, *semi_axes),
            Self::Rectangle([a, b]) => {
                let rounding = ON_FACE * (a + b);
                // Grid points on opposite faces differ by rounding, and are on both or on none.
                let on_face = |off: f64| if off.abs() < rounding { 0.0 } else { off };
                let [x, y] = [on_face(point[0].abs() - a), on_face(point[1].abs() - b)];
                let (distance, normal) = if x > y + rounding {
                    (x, [1_f64.copysign(point[0]), 0.0])
                } else {
                    (y, [0.0, 1_f64.copysign(point[1])])
                };
                Nearest { distance, surface: [0, 1].map(|axis| point[axis] - distance * normal[axis]), normal }
            }
            Self::Capsule([a, radius]) => nearest_of_circle(point, [point[0].clamp(-a, *a), 0.0], *radius),
            Self::Polygon(corners) => polygon::nearest(point, corners),
        }
    }

    fn corners(&self) -> Vec<[f64; 2]> {
        let angles = |first: f64| (0..CORNERS).map(move |i| 2.0 * PI * (i as f64 + first) / CORNERS as f64);
        let ellipse = |a: f64, b: f64| angles(0.0).map(|angle| [a * angle.cos(), b * angle.sin()]).collect();
        match *self {
            Self::Circle(radius) => ellipse(radius, radius),
            Self::Ellipse([a, b]) => ellipse(a, b),
            Self::Rectangle([x, y]) => vec![[-x, -y], [x, -y], [x, y], [-x, y]],
            Self::Capsule([half, radius]) => {
                let cap = |angle: f64| [radius * angle.cos() + half.copysign(angle.cos()), radius * angle.sin()];
                angles(0.5).map(cap).collect()
            }
            Self::Polygon(ref corners) => corners.clone(),
        }
    }
}

fn nearest_of_circle(point: [f64; 2], center: [f64; 2], radius: f64) -> Nearest<2> {
    let offset = [point[0] - center[0], point[1] - center[1]];
    let from_center = offset[0].hypot(offset[1]);
    let normal = offset.map(|component| component / from_center.max(f64::MIN_POSITIVE));
    let surface = [center[0] + radius * normal[0], center[1] + radius * normal[1]];
    Nearest { distance: from_center - radius, surface, normal }
}

/// Return the point (x, y) = (a² p/(t + a²), b² q/(t + b²)) of the ellipse nearest to (p, q). t is the largest root of
/// `F(t) = (a p/(t + a²))² + (b q/(t + b²))² − 1`, which is convex and decreases there.
fn nearest_of_ellipse(point: [f64; 2], [a, b]: [f64; 2]) -> Nearest<2> {
    let (p, q) = (point[0].abs().max(OFF_AXIS * a), point[1].abs().max(OFF_AXIS * b));
    // F is not negative here, so Newton's method increases t up to the root.
    let mut t = (a * p - a * a).max(b * q - b * b);
    for _ in 0..NEWTON_STEPS {
        let (x, y) = (a * p / (t + a * a), b * q / (t + b * b));
        let (f, slope) = (x * x + y * y - 1.0, -2.0 * (x * x / (t + a * a) + y * y / (t + b * b)));
        let step = -f / slope;
        t += step;
        if step <= 1e-15 * (a * a).max(b * b) {
            break;
        }
    }
    let (x, y) = (a * a * p / (t + a * a), b * b * q / (t + b * b));
    let gradient = [x / (a * a), y / (b * b)];
    let size = gradient[0].hypot(gradient[1]);
    let distance = (p - x) * gradient[0] / size + (q - y) * gradient[1] / size;
    Nearest {
        distance,
        surface: [x.copysign(point[0]), y.copysign(point[1])],
        normal: [0, 1].map(|axis| (gradient[axis] / size).copysign(point[axis])),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::SQRT_2;

    use super::*;

    fn close(found: [f64; 2], expected: [f64; 2]) -> bool {
        (0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-9)
    }

    fn polygon(corners: &[[f64; 2]]) -> Outline {
        Outline::polygon(corners.to_vec())
    }

    /// From a point of the surface along its normal, inwards up to the centre of curvature and outwards, that point is
    /// the nearest.
    #[test]
    fn the_nearest_point_of_an_ellipse_lies_along_its_normal() {
        for [a, b] in [[0.5, 0.06], [0.3, 0.3], [0.1, 0.4]] {
            let ellipse = Outline::Ellipse([a, b]);
            for k in 0..64 {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos();
                let surface = [a * cos, b * sin];
                let slope = (a * sin).hypot(b * cos);
                let normal = [b * cos / slope, a * sin / slope];
                let curvature_radius = slope.powi(3) / (a * b);
                for distance in [-0.9 * curvature_radius.min(b), -1e-3 * b, 0.0, 0.02, 3.0] {
                    let point = [0, 1].map(|axis| surface[axis] + distance * normal[axis]);
                    let found = ellipse.nearest(point);
                    let good = (found.distance - distance).abs() < 1e-8
                        && (0..2).all(|axis| (found.surface[axis] - surface[axis]).abs() < 1e-6 * a.max(b))
                        && (0..2).all(|axis| (found.normal[axis] - normal[axis]).abs() < 1e-6);
                    // Beyond the axes another point may be the nearest.
                    let other = found.distance > distance.min(0.0) && (point[0] * cos < 0.0 || point[1] * sin < 0.0);
                    assert!(good || other, "{a} x {b}, {k}, {distance}: {found:?} for {surface:?}, {normal:?}");
                }
            }
        }
    }

    #[test]
    fn equal_outlines_have_equal_distances() {
        let rectangle = Outline::Rectangle([0.3, 0.1]);
        let corners = [[0.3, 0.1], [-0.3, 0.1], [-0.3, -0.1], [0.3, -0.1]];
        let (circle, ellipse, capsule) =
            (Outline::Circle(0.2), Outline::Ellipse([0.2, 0.2]), Outline::Capsule([0.0, 0.2]));
        for i in 0..41 {
            for j in 0..41 {
                let point = [-0.51 + 0.025 * f64::from(i), -0.52 + 0.026 * f64::from(j)];
                let [one, other] = [rectangle.nearest(point), polygon(&corners).nearest(point)];
                assert!((one.distance - other.distance).abs() < 1e-12, "{point:?}: {one:?}, {other:?}");
                let [one, other, third] = [&circle, &ellipse, &capsule].map(|shape| shape.nearest(point));
                assert!((one.distance - other.distance).abs() < 1e-9, "{point:?}: {one:?}, {other:?}");
                assert!(close(one.normal, other.normal) && close(one.normal, third.normal), "{point:?}: {other:?}");
            }
        }
    }

    /// An L of three squares, with a corner that points inwards.
    #[test]
    fn corners_of_a_polygon_are_kept_and_sharp_ones_cut() {
        let l = polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]);
        for (point, distance, normal) in [
            ([0.5, 0.5], -0.5, None),
            ([0.9, 0.9], -0.1 * SQRT_2, Some([1.0 / SQRT_2, 1.0 / SQRT_2])),
            ([1.1, 1.2], 0.1, Some([1.0, 0.0])),
            ([2.1, 1.05], 0.1, Some([1.0, 0.0])),
            ([2.1, 1.2], 0.2, Some([0.0, 1.0])),
            ([-0.3, 0.5], 0.3, Some([-1.0, 0.0])),
        ] {
            let found = l.nearest(point);
            assert!((found.distance - distance).abs() < 1e-12, "{point:?}: {found:?}");
            assert!(normal.is_none_or(|normal| close(found.normal, normal)), "{point:?}: {found:?}");
        }
        let needle = polygon(&[[0.0, -0.1], [5.0, 0.0], [0.0, 0.1]]);
        let found = needle.nearest([6.0, 0.0]);
        assert!((found.distance - 1.0 / SQRT_2).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn sections_and_thicknesses_are_those_of_the_outline() {
        let many = 2000;
        let around = |[a, b]: [f64; 2]| {
            let corner = |k: usize| {
                let (sin, cos) = (std::f64::consts::TAU * k as f64 / many as f64).sin_cos();
                [a * cos + 3.0, b * sin - 2.0]
            };
            polygon(&(0..many).rev().map(corner).collect::<Vec<_>>())
        };
        let shapes = [
            (Outline::Circle(0.3), around([0.3, 0.3])),
            (Outline::Ellipse([0.5, 0.06]), around([0.5, 0.06])),
            (Outline::Rectangle([0.3, 0.1]), polygon(&[[2.7, -1.9], [3.3, -1.9], [3.3, -2.1], [2.7, -2.1]])),
        ];
        for (shape, polygon) in shapes {
            let (one, other) = (shape.section(), polygon.section());
            assert!((one.area / other.area - 1.0).abs() < 1e-5, "{shape:?}: {one:?}, {other:?}");
            assert!((one.polar / other.polar - 1.0).abs() < 1e-5, "{shape:?}: {one:?}, {other:?}");
            assert!(close([other.centroid[0] - 3.0, other.centroid[1] + 2.0], [0.0; 2]), "{other:?}");
            let (one, other) = (shape.thickness(), polygon.thickness());
            assert!((one / other - 1.0).abs() < 1e-4, "{shape:?}: thickness {one}, {other}");
        }
        // A capsule is a rectangle with two half circles.
        let (capsule, n) = ([0.3, 0.1], 400);
        let mut sums = [0.0; 2];
        for i in 0..n * n {
            let cell = |k: usize| (k as f64 + 0.5) / n as f64;
            let point = [0.4 * cell(i / n), 0.1 * cell(i % n)];
            if Outline::Capsule(capsule).nearest(point).distance < 0.0 {
                sums = [sums[0] + 1.0, sums[1] + point[0].powi(2) + point[1].powi(2)];
            }
        }
        let per_point = 4.0 * 0.4 * 0.1 / (n * n) as f64;
        let Section { area, polar, .. } = Outline::Capsule(capsule).section();
        assert!((area / (sums[0] * per_point) - 1.0).abs() < 1e-3, "{area} against {}", sums[0] * per_point);
        assert!((polar / (sums[1] * per_point) - 1.0).abs() < 1e-3, "{polar} against {}", sums[1] * per_point);
    }
}
