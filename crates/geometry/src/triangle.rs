//! Triangles in space.

use crate::segment;
use crate::vector::{cross, dot, minus};

/// Part of a side or a triangle to which a point is on its edge.
pub(crate) const ROUNDING: f64 = 1e-9;

/// Return the edges of a triangle.
pub(crate) fn edges([a, b, c]: [[f64; 3]; 3]) -> [[[f64; 3]; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Return the part of the segment from `p` to `q` after which it passes through a triangle, 0 and 1 to rounding (Möller
/// & Trumbore 1997).
pub(crate) fn piercing([p, q]: [[f64; 3]; 2], [a, b, c]: [[f64; 3]; 3]) -> Option<f64> {
    let (along, one, other, from) = (minus(q, p), minus(b, a), minus(c, a), minus(p, a));
    let (across, around) = (cross(along, other), cross(from, one));
    let volume = dot(one, across);
    let [first, second, share] = [dot(from, across), dot(along, around), dot(other, around)].map(|part| part / volume);
    // Without a volume the segment is parallel, and the parts are no numbers.
    let inside = first >= -ROUNDING && second >= -ROUNDING && first + second <= 1.0 + ROUNDING;
    (inside && (-ROUNDING..=1.0 + ROUNDING).contains(&share)).then_some(share)
}

/// Return the distance of a point from the plane of a triangle where its foot lies inside; infinite elsewhere.
pub(crate) fn height(p: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> f64 {
    let (one, other, from) = (minus(b, a), minus(c, a), minus(p, a));
    let normal = cross(one, other);
    let square = dot(normal, normal);
    let (first, second) = (dot(cross(from, other), normal) / square, dot(cross(one, from), normal) / square);
    let inside = first >= -ROUNDING && second >= -ROUNDING && first + second <= 1.0 + ROUNDING;
    if inside { dot(from, normal).abs() / square.sqrt() } else { f64::INFINITY }
}

/// Return whether a segment passes through a triangle or comes closer to it than `gap`, m.
pub(crate) fn reaches(segment: [[f64; 3]; 2], triangle: [[f64; 3]; 3], gap: f64) -> bool {
    piercing(segment, triangle).is_some()
        || segment.iter().any(|p| height(*p, triangle) < gap)
        || edges(triangle).iter().any(|edge| segment::distance(segment, *edge) < gap)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_pierces_a_triangle() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let through = |x: f64, low: f64| piercing([[x, x, low], [x, x, 1.0]], triangle);
        assert_eq!([through(0.3, -1.0), through(0.5, 0.0), through(0.6, -1.0)], [Some(0.5), Some(0.0), None]);
        assert_eq!([through(0.3, 0.5), piercing([[-1.0, 0.2, 0.0], [1.0, 0.2, 0.0]], triangle)], [None; 2]);
        assert_eq!([height([0.2, 0.2, -3.0], triangle), height([0.8, 0.8, 1.0], triangle)], [3.0, f64::INFINITY]);
    }
}
