//! Shapes in the plane.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Vector2;

use super::polygon;
use super::{Between, Moments, Nearest, Shape};

/// Iterations of Newton's method for the nearest point of an ellipse. Four to ten are needed; more only near the middle
/// of the line between the foci, where the drag has its largest value.
const NEWTON_STEPS: usize = 40;

/// Least distance from an axis of an ellipse, over that semi-axis: on the axis the equation has a pole.
const OFF_AXIS: f64 = 1e-12;

/// Distance from a face of a rectangle, over the sum of half its lengths, within which a point lies on the face.
const ON_FACE: f64 = 1e-12;

/// Shape of a body in the plane, about the origin of its axes.
#[derive(Clone, Debug)]
pub enum Outline {
    /// Circle of a radius, m.
    Circle(f64),
    /// Ellipse of semi-axes, m.
    Ellipse([f64; 2]),
    /// Rectangle of half its length and half its thickness, m.
    Rectangle([f64; 2]),
    /// Rectangle whose ends are half circles: half the length of its straight sides, and half its thickness, m.
    Capsule([f64; 2]),
    /// Polygon of at least 3 corners in either order, m. Its sides must not cross.
    Polygon(Vec<[f64; 2]>),
    /// Open line of no thickness through at least 2 points, m, which markers represent.
    Line(Vec<[f64; 2]>),
}

impl From<Outline> for Arc<dyn Shape<2>> {
    /// Bring the corners of a polygon into left-hand order.
    fn from(outline: Outline) -> Self {
        Arc::new(outline.oriented())
    }
}

impl Outline {
    fn oriented(self) -> Self {
        match self {
            Self::Polygon(mut corners) => {
                if polygon::signed_area(&corners) < 0.0 {
                    corners.reverse();
                }
                Self::Polygon(corners)
            }
            shape => shape,
        }
    }
}

impl Shape<2> for Outline {
    fn is_round(&self) -> bool {
        matches!(self, Self::Circle(_))
    }

    fn radius(&self) -> Option<f64> {
        if let Self::Circle(radius) = self { Some(*radius) } else { None }
    }

    fn fills_box(&self) -> bool {
        self.is_round()
    }

    fn thickness(&self) -> f64 {
        match self {
            Self::Circle(radius) => 2.0 * radius,
            Self::Ellipse([a, b]) | Self::Rectangle([a, b]) => 2.0 * a.min(*b),
            Self::Capsule([_, radius]) => 2.0 * radius,
            Self::Polygon(corners) => 2.0 * polygon::depth(corners),
            Self::Line(_) => 0.0,
        }
    }

    fn extent(&self, direction: &Vector2<f64>) -> f64 {
        let [x, y] = [direction[0], direction[1]];
        match self {
            Self::Circle(radius) => *radius,
            Self::Ellipse([a, b]) => (a * x).hypot(b * y),
            Self::Rectangle([a, b]) => a * x.abs() + b * y.abs(),
            Self::Capsule([a, radius]) => a * x.abs() + radius,
            Self::Polygon(corners) | Self::Line(corners) => {
                corners.iter().map(|c| c[0] * x + c[1] * y).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }

    fn moments(&self, _: &[f64; 2]) -> Moments<2> {
        let middle = |volume, inertia| Moments { volume, centroid: Vector2::zeros(), inertia };
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
            Self::Polygon(corners) => polygon::moments(corners),
            Self::Line(_) => middle(0.0, 0.0),
        }
    }

    fn nearest(&self, point: Vector2<f64>) -> Nearest<2> {
        match self {
            Self::Circle(radius) => nearest_of_circle(point, Vector2::zeros(), *radius),
            Self::Ellipse(semi_axes) => nearest_of_ellipse(point, *semi_axes),
            Self::Rectangle([a, b]) => {
                let rounding = ON_FACE * (a + b);
                // Grid points on opposite faces differ by rounding, and are on both or on none.
                let on_face = |off: f64| if off.abs() < rounding { 0.0 } else { off };
                let [x, y] = [on_face(point[0].abs() - a), on_face(point[1].abs() - b)];
                let (distance, normal) = if x > y + rounding {
                    (x, Vector2::new(1_f64.copysign(point[0]), 0.0))
                } else {
                    (y, Vector2::new(0.0, 1_f64.copysign(point[1])))
                };
                Nearest { distance, surface: point - distance * normal, normal }
            }
            Self::Capsule([a, radius]) => nearest_of_circle(point, Vector2::new(point[0].clamp(-a, *a), 0.0), *radius),
            Self::Polygon(corners) => polygon::nearest(point.into(), corners),
            // It has no inside, and so no cells.
            Self::Line(_) => Nearest { distance: f64::INFINITY, surface: point, normal: Vector2::zeros() },
        }
    }

    fn thin(&self) -> Option<(Vec<[f64; 2]>, Between)> {
        if let Self::Line(points) = self { Some((points.clone(), Between::Line)) } else { None }
    }

    fn layer(&self, thickness: f64) -> Option<Moments<2>> {
        let Self::Line(points) = self else { return None };
        let sides = || {
            points.windows(2).map(|side| {
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

fn nearest_of_circle(point: Vector2<f64>, center: Vector2<f64>, radius: f64) -> Nearest<2> {
    let offset = point - center;
    let from_center = offset[0].hypot(offset[1]);
    let normal = offset / from_center.max(f64::MIN_POSITIVE);
    let surface = center + radius * normal;
    Nearest { distance: from_center - radius, surface, normal }
}

/// Return the point (x, y) = (a² p/(t + a²), b² q/(t + b²)) of the ellipse nearest to (p, q). t is the largest root of
/// `F(t) = (a p/(t + a²))² + (b q/(t + b²))² − 1`, which is convex and decreases there.
fn nearest_of_ellipse(point: Vector2<f64>, [a, b]: [f64; 2]) -> Nearest<2> {
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
        surface: Vector2::new(x.copysign(point[0]), y.copysign(point[1])),
        normal: Vector2::from([0, 1].map(|axis| (gradient[axis] / size).copysign(point[axis]))),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::SQRT_2;

    use super::*;

    fn close(found: Vector2<f64>, expected: [f64; 2]) -> bool {
        (0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-9)
    }

    fn polygon(corners: &[[f64; 2]]) -> Outline {
        Outline::Polygon(corners.to_vec()).oriented()
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
                    let found = ellipse.nearest(point.into());
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
                let [one, other] = [rectangle.nearest(point.into()), polygon(&corners).nearest(point.into())];
                assert!((one.distance - other.distance).abs() < 1e-12, "{point:?}: {one:?}, {other:?}");
                let [one, other, third] = [&circle, &ellipse, &capsule].map(|shape| shape.nearest(point.into()));
                assert!((one.distance - other.distance).abs() < 1e-9, "{point:?}: {one:?}, {other:?}");
                assert!(
                    close(one.normal, other.normal.into()) && close(one.normal, third.normal.into()),
                    "{point:?}: {other:?}"
                );
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
            let found = l.nearest(point.into());
            assert!((found.distance - distance).abs() < 1e-12, "{point:?}: {found:?}");
            assert!(normal.is_none_or(|normal| close(found.normal, normal)), "{point:?}: {found:?}");
        }
        let needle = polygon(&[[0.0, -0.1], [5.0, 0.0], [0.0, 0.1]]);
        let found = needle.nearest([6.0, 0.0].into());
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
            let (one, other) = (shape.moments(&[0.0; 2]), polygon.moments(&[0.0; 2]));
            assert!((one.volume / other.volume - 1.0).abs() < 1e-5, "{shape:?}: {one:?}, {other:?}");
            assert!((one.inertia / other.inertia - 1.0).abs() < 1e-5, "{shape:?}: {one:?}, {other:?}");
            assert!(close(other.centroid - Vector2::new(3.0, -2.0), [0.0; 2]), "{other:?}");
            let (one, other) = (shape.thickness(), polygon.thickness());
            assert!((one / other - 1.0).abs() < 1e-4, "{shape:?}: thickness {one}, {other}");
        }
        // A capsule is a rectangle with two half circles.
        let (capsule, n) = ([0.3, 0.1], 400);
        let mut sums = [0.0; 2];
        for i in 0..n * n {
            let cell = |k: usize| (k as f64 + 0.5) / n as f64;
            let point = [0.4 * cell(i / n), 0.1 * cell(i % n)];
            if Outline::Capsule(capsule).nearest(point.into()).distance < 0.0 {
                sums = [sums[0] + 1.0, sums[1] + point[0].powi(2) + point[1].powi(2)];
            }
        }
        let per_point = 4.0 * 0.4 * 0.1 / (n * n) as f64;
        let Moments { volume: area, inertia: polar, .. } = Outline::Capsule(capsule).moments(&[0.0; 2]);
        assert!((area / (sums[0] * per_point) - 1.0).abs() < 1e-3, "{area} against {}", sums[0] * per_point);
        assert!((polar / (sums[1] * per_point) - 1.0).abs() < 1e-3, "{polar} against {}", sums[1] * per_point);
    }
}
