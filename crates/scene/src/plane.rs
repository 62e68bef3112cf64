//! Points, sides and polygons of the plane.

/// A point, m.
pub(crate) type Point = [f64; 2];

/// Samples along each side of the frame around a polygon, by which its area is measured.
const SAMPLES: usize = 24;

/// Return twice the area of a triangle, positive if its corners go round counter-clockwise.
pub(crate) fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether `c` lies on the side from `a` to `b`.
pub(crate) fn within(a: Point, b: Point, c: Point) -> bool {
    turn(a, b, c) == 0.0
        && [0, 1].iter().all(|&axis| a[axis].min(b[axis]) <= c[axis] && c[axis] <= a[axis].max(b[axis]))
}

/// Whether each of two sides has its ends on both sides of the other.
pub(crate) fn cross(a: Point, b: Point, c: Point, d: Point) -> bool {
    let apart = |a, b, c, d| turn(a, b, c) * turn(a, b, d) < 0.0;
    apart(a, b, c, d) && apart(c, d, a, b)
}

/// Whether two sides have a point in common.
pub(crate) fn meet(a: Point, b: Point, c: Point, d: Point) -> bool {
    cross(a, b, c, d) || within(a, b, c) || within(a, b, d) || within(c, d, a) || within(c, d, b)
}

/// Return the distance of `p` from the side from `a` to `b`.
pub(crate) fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (along, from) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    f64::hypot(from[0] - share * along[0], from[1] - share * along[1])
}

/// Return the sides of a line through `points`.
pub(crate) fn sides(points: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    points.windows(2).map(|pair| (pair[0], pair[1]))
}

/// The outline of a body, with the frame around it.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    /// Corners in order, the first one again at the end.
    points: Vec<Point>,
    /// Least and largest x, least and largest y.
    pub frame: [[f64; 2]; 2],
}

impl Outline {
    /// Make the outline through `corners`.
    pub fn new(corners: impl IntoIterator<Item = Point>) -> Self {
        let mut points: Vec<_> = corners.into_iter().collect();
        points.extend(points.first().copied());
        let mut frame = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for point in &points {
            for (range, at) in frame.iter_mut().zip(point) {
                *range = [range[0].min(*at), range[1].max(*at)];
            }
        }
        Self { points, frame }
    }

    /// Return the corners.
    pub fn corners(&self) -> &[Point] {
        &self.points[1..]
    }

    /// Return the middle of the frame.
    pub fn middle(&self) -> Point {
        self.frame.map(|[low, high]| (low + high) / 2.0)
    }

    /// Whether the frames of two outlines have a point in common.
    fn is_near(&self, other: &Self) -> bool {
        self.frame.iter().zip(&other.frame).all(|(a, b)| a[0] <= b[1] && b[0] <= a[1])
    }

    /// Whether `p` lies inside.
    pub fn contains(&self, p: Point) -> bool {
        let framed = self.frame.iter().zip(p).all(|([low, high], at)| (*low..=*high).contains(&at));
        let crossed =
            |&(a, b): &(Point, Point)| (a[1] > p[1]) != (b[1] > p[1]) && (turn(a, b, p) > 0.0) == (b[1] > a[1]);
        framed && sides(&self.points).filter(crossed).count() % 2 == 1
    }

    /// Return the distance of `p` from the outline, 0 outside.
    pub fn depth(&self, p: Point) -> f64 {
        if !self.contains(p) {
            return 0.0;
        }
        sides(&self.points).map(|(a, b)| distance(p, a, b)).fold(f64::INFINITY, f64::min)
    }

    /// Whether two outlines overlap by more than `depth` at a corner, or cross.
    pub fn overlaps(&self, other: &Self, depth: f64) -> bool {
        let enters = |a: &Self, b: &Self| a.corners().iter().any(|&corner| b.depth(corner) > depth);
        let through = || {
            // Outlines that cross without a corner inside: two bars.
            let crossings =
                sides(&self.points).flat_map(|(a, b)| sides(&other.points).filter(move |&(c, d)| cross(a, b, c, d)));
            crossings.take(4).count() == 4
        };
        self.is_near(other) && (enters(self, other) || enters(other, self) || through())
    }

    /// Whether `p` lies inside or on the outline, as all of a line does.
    fn holds(&self, p: Point) -> bool {
        let size = self.frame.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
        self.contains(p) || sides(&self.points).any(|(a, b)| distance(p, a, b) <= 1e-6 * size)
    }

    /// Return the share of the area whose points have `property`.
    pub fn share(&self, property: impl Fn(Point) -> bool) -> f64 {
        let at = |[low, high]: [f64; 2], i: usize| low + (high - low) * (i as f64 + 0.5) / SAMPLES as f64;
        let grid = (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j)));
        let inside = grid.map(|(i, j)| [at(self.frame[0], i), at(self.frame[1], j)]).filter(|&p| self.contains(p));
        let (mut all, mut some) = (0, 0);
        for p in inside {
            all += 1;
            some += usize::from(property(p));
        }
        if all > 0 {
            return some as f64 / f64::from(all);
        }
        // A line has no inside: its share is that of its length.
        let (mut length, mut with) = (0.0, 0.0);
        for (a, b) in sides(&self.points) {
            let part = f64::hypot(b[0] - a[0], b[1] - a[1]) / SAMPLES as f64;
            for i in 0..SAMPLES {
                let p = [0, 1].map(|axis| at([a[axis], b[axis]], i));
                length += part;
                with += if property(p) { part } else { 0.0 };
            }
        }
        if length > 0.0 { with / length } else { f64::from(u8::from(property(self.middle()))) }
    }

    /// Return the larger of both shares of the areas of two outlines that lie inside each other.
    pub fn shared(&self, other: &Self) -> f64 {
        if self.is_near(other) { f64::max(self.share(|p| other.holds(p)), other.share(|p| self.holds(p))) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_knows_its_inside_its_depth_and_its_overlaps() {
        let bar = |x: f64, y: f64| Outline::new([[-x, -y], [x, -y], [x, y], [-x, y]]);
        let (long, high) = (bar(2.0, 0.25), bar(0.25, 2.0));
        assert!(long.contains([1.9, 0.2]) && !long.contains([1.9, 0.3]) && !long.contains([-2.1, 0.0]));
        assert!((long.depth([1.9, 0.0]) - 0.1).abs() < 1e-15 && long.depth([3.0, 0.0]) == 0.0);
        assert!(long.overlaps(&high, 0.1), "no corner lies inside the other bar");
        assert!((long.shared(&high) - 0.125).abs() < 0.05, "{}", long.shared(&high));
        let end = |y: f64| {
            long.overlaps(&Outline::new(long.corners().iter().map(|corner| [corner[0] + 3.8, corner[1] + y])), 0.05)
        };
        assert!(end(0.1) && !end(0.46));
        assert!((long.shared(&bar(0.1, 0.1)) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_distance_from_a_side_is_that_of_its_nearest_point() {
        let side = |p| distance(p, [0.0, 0.0], [2.0, 0.0]);
        assert_eq!([side([1.0, -3.0]), side([-3.0, 4.0]), side([2.5, 0.0])], [3.0, 5.0, 0.5]);
    }
}
