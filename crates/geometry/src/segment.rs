//! Segments between two points.

use crate::vector::{between, dot, minus, norm};

/// Return the distance of the segment from `p` to `q` from that from `r` to `s` (Ericson, Real-Time Collision
/// Detection, section 5.1.9).
pub fn distance<const D: usize>([p, q]: [[f64; D]; 2], [r, s]: [[f64; D]; 2]) -> f64 {
    let (one, other, from) = (minus(q, p), minus(s, r), minus(p, r));
    let (square, other_square) = (dot(one, one) + f64::MIN_POSITIVE, dot(other, other) + f64::MIN_POSITIVE);
    let (mixed, at_one, at_other) = (dot(one, other), dot(one, from), dot(other, from));
    let parallel = (square * other_square - mixed * mixed).max(f64::MIN_POSITIVE);
    let share = ((mixed * at_other - at_one * other_square) / parallel).clamp(0.0, 1.0);
    let other_share = ((mixed * share + at_other) / other_square).clamp(0.0, 1.0);
    let share = ((mixed * other_share - at_one) / square).clamp(0.0, 1.0);
    norm(minus(between(p, q, share), between(r, s, other_share)))
}

/// Return the sides of a line through `points`.
pub fn sides<const D: usize>(points: &[[f64; D]]) -> impl Iterator<Item = [[f64; D]; 2]> + Clone + '_ {
    points.windows(2).map(|pair| [pair[0], pair[1]])
}

/// Return twice the area of a triangle, positive if its corners go round counter-clockwise.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Return whether `c` lies on the segment from `a` to `b`.
pub fn lies_on(c: [f64; 2], [a, b]: [[f64; 2]; 2]) -> bool {
    turn(a, b, c) == 0.0 && (0..2).all(|d| a[d].min(b[d]) <= c[d] && c[d] <= a[d].max(b[d]))
}

/// Return whether each of two segments has its ends on both sides of the other.
pub fn crosses([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let apart = |a, b, c, d| turn(a, b, c) * turn(a, b, d) < 0.0;
    apart(a, b, c, d) && apart(c, d, a, b)
}

/// Return whether two segments have a point in common.
pub fn meets(one: [[f64; 2]; 2], other: [[f64; 2]; 2]) -> bool {
    crosses(one, other) || other.iter().any(|p| lies_on(*p, one)) || one.iter().any(|p| lies_on(*p, other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_have_the_distance_of_their_nearest_points() {
        let segment = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let found = [
            distance(segment, [[1.0, -1.0, 0.5], [1.0, 1.0, 0.5]]), // across it
            distance(segment, [[-1.0, 3.0, 4.0], [3.0, 3.0, 4.0]]), // along it
            distance(segment, [[5.0, 0.0, 4.0], [6.0, 9.0, 4.0]]),  // from end to end
            distance(segment, [[1.0, 1.0, 0.0], [1.0, 5.0, 0.0]]),  // an end above the middle
        ];
        assert_eq!(found, [0.5, 5.0, 5.0, 1.0]);
        let from = |p: [f64; 2]| distance([[0.0, 0.0], [2.0, 0.0]], [p, p]);
        assert_eq!([from([1.0, -3.0]), from([-3.0, 4.0]), from([2.5, 0.0])], [3.0, 5.0, 0.5]);
    }

    #[test]
    fn segments_that_touch_meet_and_do_not_cross() {
        let segment = [[0.0, 0.0], [2.0, 0.0]];
        let (across, on, beside) = ([[1.0, -1.0], [1.0, 1.0]], [[1.0, 0.0], [1.0, 1.0]], [[3.0, -1.0], [3.0, 1.0]]);
        assert_eq!([across, on, beside].map(|other| crosses(segment, other)), [true, false, false]);
        assert_eq!([across, on, beside].map(|other| meets(segment, other)), [true, true, false]);
    }
}
