//! Outlines of rigid bodies in axes of their own: the nearest point of the surface, size, mass and moment of inertia.

use std::f64::consts::{PI, SQRT_2};

use scene::Ends;

/// Iterations of Newton's method for the nearest point of an ellipse. It goes up to the root from one side and needs
/// four to ten; more are needed only next to the middle of the long axis's focal points, where the drag is at its largest.
const NEWTON_STEPS: usize = 40;

/// How near to an axis of an ellipse a point is taken to be off it, by that semi-axis: on it the equation has a pole.
const OFF_AXIS: f64 = 1e-12;

/// Points along each side of the bounding rectangle among which the search for the thickest place begins, and how often
/// it halves its stride.
const SEARCH: usize = 48;
const HALVINGS: usize = 30;

/// An outline.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Circle of a radius, m.
    Circle(f64),
    /// Ellipse of semi-axes, m.
    Ellipse([f64; 2]),
    /// Rectangle of half its size, m.
    Rectangle([f64; 2]),
    /// Rectangle whose ends are half circles: half the length of its straight sides, and half its thickness, m.
    Capsule([f64; 2]),
    /// Polygon whose corners, m, go round to the left.
    Polygon(Vec<[f64; 2]>),
}

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Signed distance to it, m, positive in the fluid. Outside of corners it is that to the lines of the sides, so that
    /// lines of equal distance keep the corner.
    pub distance: f64,
    /// That point, or the one on the line of the side, m.
    pub surface: [f64; 2],
    /// Unit normal into the fluid.
    pub normal: [f64; 2],
}

/// Area (m²), centroid (m) and polar second moment of area about the centroid (m⁴).
#[derive(Clone, Copy, Debug)]
pub struct Section {
    pub area: f64,
    pub centroid: [f64; 2],
    pub polar: f64,
}

impl Shape {
    /// The outline of a scene's body.
    pub fn new(shape: &scene::Shape) -> Self {
        match shape {
            scene::Shape::Circle { radius } => Self::Circle(*radius),
            scene::Shape::Ellipse { length, thickness } => Self::Ellipse([0.5 * length, 0.5 * thickness]),
            scene::Shape::Rectangle { length, thickness, ends } => match ends {
                Ends::Square => Self::Rectangle([0.5 * length, 0.5 * thickness]),
                Ends::Round => Self::Capsule([0.5 * (length - thickness), 0.5 * thickness]),
            },
            scene::Shape::Polygon { corners } => {
                let mut corners = corners.clone();
                if signed_area(&corners) < 0.0 {
                    corners.reverse();
                }
                Self::Polygon(corners)
            }
        }
    }

    /// Diameter of the largest circle inside, m.
    pub fn thickness(&self) -> f64 {
        match self {
            Self::Circle(radius) => 2.0 * radius,
            Self::Ellipse([a, b]) | Self::Rectangle([a, b]) => 2.0 * a.min(*b),
            Self::Capsule([_, radius]) => 2.0 * radius,
            Self::Polygon(corners) => 2.0 * depth_of_polygon(corners),
        }
    }

    /// How far it goes from its origin in the direction of a unit vector, m.
    pub fn extent(&self, direction: [f64; 2]) -> f64 {
        let [x, y] = direction;
        match self {
            Self::Circle(radius) => *radius,
            Self::Ellipse([a, b]) => (a * x).hypot(b * y),
            Self::Rectangle([a, b]) => a * x.abs() + b * y.abs(),
            Self::Capsule([a, radius]) => a * x.abs() + radius,
            Self::Polygon(corners) => corners.iter().map(|c| c[0] * x + c[1] * y).fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Its area and how that is distributed.
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
            Self::Polygon(corners) => section_of_polygon(corners),
        }
    }

    /// The nearest point of the surface.
    pub fn nearest(&self, point: [f64; 2]) -> Nearest {
        match self {
            Self::Circle(radius) => nearest_of_circle(point, [0.0; 2], *radius),
            Self::Ellipse(semi_axes) => nearest_of_ellipse(point, *semi_axes),
            Self::Rectangle([a, b]) => {
                let [x, y] = [point[0].abs() - a, point[1].abs() - b];
                let (distance, normal) =
                    if x > y { (x, [1_f64.copysign(point[0]), 0.0]) } else { (y, [0.0, 1_f64.copysign(point[1])]) };
                Nearest { distance, surface: [0, 1].map(|axis| point[axis] - distance * normal[axis]), normal }
            }
            Self::Capsule([a, radius]) => nearest_of_circle(point, [point[0].clamp(-a, *a), 0.0], *radius),
            Self::Polygon(corners) => nearest_of_polygon(point, corners),
        }
    }
}

fn nearest_of_circle(point: [f64; 2], center: [f64; 2], radius: f64) -> Nearest {
    let offset = [point[0] - center[0], point[1] - center[1]];
    let from_center = offset[0].hypot(offset[1]);
    let normal = offset.map(|component| component / from_center.max(f64::MIN_POSITIVE));
    let surface = [center[0] + radius * normal[0], center[1] + radius * normal[1]];
    Nearest { distance: from_center - radius, surface, normal }
}

/// The point (x, y) = (a² p/(t + a²), b² q/(t + b²)) of the ellipse is the nearest to (p, q) where t is the largest root of
/// `F(t) = (a p/(t + a²))² + (b q/(t + b²))² − 1`, which is convex and falls there.
fn nearest_of_ellipse(point: [f64; 2], [a, b]: [f64; 2]) -> Nearest {
    let (p, q) = (point[0].abs().max(OFF_AXIS * a), point[1].abs().max(OFF_AXIS * b));
    // F is not negative here: Newton's method goes up to the root.
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

/// Twice the area, positive where the corners go round to the left.
fn signed_area(corners: &[[f64; 2]]) -> f64 {
    sides(corners).map(|([x0, y0], [x1, y1])| x0 * y1 - x1 * y0).sum()
}

/// The sides, each from a corner to the next.
fn sides(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]))
}

fn section_of_polygon(corners: &[[f64; 2]]) -> Section {
    // Green's theorem about the first corner, so that a place far from the origin costs no digits.
    let [x0, y0] = corners[0];
    let (mut area, mut first, mut second) = (0.0, [0.0; 2], 0.0);
    for (a, b) in sides(corners) {
        let [a, b] = [a, b].map(|[x, y]| [x - x0, y - y0]);
        let cross = a[0] * b[1] - a[1] * b[0];
        area += 0.5 * cross;
        (0..2).for_each(|axis| first[axis] += cross / 6.0 * (a[axis] + b[axis]));
        second += (0..2).map(|i| cross / 12.0 * (a[i] * a[i] + a[i] * b[i] + b[i] * b[i])).sum::<f64>();
    }
    let [cx, cy] = first.map(|moment| moment / area);
    Section { area, centroid: [x0 + cx, y0 + cy], polar: second - area * (cx * cx + cy * cy) }
}

/// A side's inner points have fluid on one side of them. A corner that points outwards is near to points in the fluid alone,
/// one that points inwards to points in the body alone.
fn nearest_of_polygon(point: [f64; 2], corners: &[[f64; 2]]) -> Nearest {
    let (mut least, mut nearest, mut corner) = (f64::INFINITY, 0, None);
    for (i, (a, b)) in sides(corners).enumerate() {
        let (along, offset) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
        let fraction = (offset[0] * along[0] + offset[1] * along[1]) / (along[0] * along[0] + along[1] * along[1]);
        let at = fraction.clamp(0.0, 1.0);
        let distance = (offset[0] - at * along[0]).hypot(offset[1] - at * along[1]);
        if distance < least {
            // The corner at the begin of a side has its number.
            corner = if fraction <= 0.0 {
                Some(i)
            } else if fraction >= 1.0 {
                Some((i + 1) % corners.len())
            } else {
                None
            };
            (least, nearest) = (distance, i);
        }
    }
    // Distance to the line of a side, and its normal.
    let line = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
        ((point[0] - a[0]) * normal[0] + (point[1] - a[1]) * normal[1], normal)
    };
    let Some(corner) = corner else {
        let (distance, normal) = line(nearest);
        return Nearest { distance, surface: [0, 1].map(|axis| point[axis] - distance * normal[axis]), normal };
    };
    let before = (corner + corners.len() - 1) % corners.len();
    let (one, other) = (line(before), line(corner));
    let points_outwards = one.1[0] * other.1[1] - one.1[1] * other.1[0] >= 0.0;
    if points_outwards {
        let (distance, normal) = if one.0 > other.0 { one } else { other };
        // A corner sharper than a right angle is cut, lest the lines of equal distance go far beyond it.
        let distance = distance.max(least / SQRT_2);
        Nearest { distance, surface: [0, 1].map(|axis| point[axis] - distance * normal[axis]), normal }
    } else {
        let surface = corners[corner];
        let normal = [0, 1].map(|axis| (surface[axis] - point[axis]) / least.max(f64::MIN_POSITIVE));
        Nearest { distance: -least, surface, normal }
    }
}

/// Radius of the largest circle in a polygon, m: a pattern search from the deepest of a grid of points.
fn depth_of_polygon(corners: &[[f64; 2]]) -> f64 {
    let range = |axis: usize| {
        let values = corners.iter().map(|corner| corner[axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        [low, high - low]
    };
    let ([x0, width], [y0, height]) = (range(0), range(1));
    let depth = |point: [f64; 2]| -nearest_of_polygon(point, corners).distance;
    let (mut best, mut deepest) = (corners[0], 0.0);
    let mut take = |point: [f64; 2], best: &mut [f64; 2]| {
        let there = depth(point);
        if there > deepest {
            (*best, deepest) = (point, there);
        }
    };
    for i in 0..SEARCH * SEARCH {
        let share = |k: usize| (k as f64 + 0.5) / SEARCH as f64;
        take([x0 + width * share(i / SEARCH), y0 + height * share(i % SEARCH)], &mut best);
    }
    let mut stride = [width, height].map(|size| 0.5 * size / SEARCH as f64);
    for _ in 0..HALVINGS {
        for (sx, sy) in
            [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
        {
            take([best[0] + sx * stride[0], best[1] + sy * stride[1]], &mut best);
        }
        stride = stride.map(|s| 0.5 * s);
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: [f64; 2], expected: [f64; 2]) -> bool {
        (0..2).all(|axis| (found[axis] - expected[axis]).abs() < 1e-9)
    }

    fn polygon(corners: &[[f64; 2]]) -> Shape {
        Shape::new(&scene::Shape::Polygon { corners: corners.to_vec() })
    }

    /// From a point of the surface along its normal, inwards up to the centre of curvature and outwards, that point is
    /// the nearest.
    #[test]
    fn the_nearest_point_of_an_ellipse_lies_along_its_normal() {
        for [a, b] in [[0.5, 0.06], [0.3, 0.3], [0.1, 0.4]] {
            let ellipse = Shape::Ellipse([a, b]);
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
        let rectangle = Shape::Rectangle([0.3, 0.1]);
        let corners = [[0.3, 0.1], [-0.3, 0.1], [-0.3, -0.1], [0.3, -0.1]];
        let (circle, ellipse, capsule) = (Shape::Circle(0.2), Shape::Ellipse([0.2, 0.2]), Shape::Capsule([0.0, 0.2]));
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
            (Shape::Circle(0.3), around([0.3, 0.3])),
            (Shape::Ellipse([0.5, 0.06]), around([0.5, 0.06])),
            (Shape::Rectangle([0.3, 0.1]), polygon(&[[2.7, -1.9], [3.3, -1.9], [3.3, -2.1], [2.7, -2.1]])),
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
            if Shape::Capsule(capsule).nearest(point).distance < 0.0 {
                sums = [sums[0] + 1.0, sums[1] + point[0].powi(2) + point[1].powi(2)];
            }
        }
        let per_point = 4.0 * 0.4 * 0.1 / (n * n) as f64;
        let Section { area, polar, .. } = Shape::Capsule(capsule).section();
        assert!((area / (sums[0] * per_point) - 1.0).abs() < 1e-3, "{area} against {}", sums[0] * per_point);
        assert!((polar / (sums[1] * per_point) - 1.0).abs() < 1e-3, "{polar} against {}", sums[1] * per_point);
    }
}
