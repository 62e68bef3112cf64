//! Vectors, sides and triangles in space.

/// A point or a vector, m.
pub(crate) type Vector = [f64; 3];

/// Part of a side or a triangle to which a point is on its edge.
pub(crate) const ROUNDING: f64 = 1e-9;

pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn minus(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|d| a[d] - b[d])
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Return `a + share (b - a)`.
pub(crate) fn between(a: Vector, b: Vector, share: f64) -> Vector {
    [0, 1, 2].map(|d| a[d] + share * (b[d] - a[d]))
}

/// Return least and largest place of points along each axis.
pub(crate) fn frame<'a>(points: impl Iterator<Item = &'a Vector>) -> [[f64; 2]; 3] {
    points.fold([[f64::INFINITY, f64::NEG_INFINITY]; 3], |frame, p| {
        [0, 1, 2].map(|d| [frame[d][0].min(p[d]), frame[d][1].max(p[d])])
    })
}

/// Whether two frames are at most `gap` apart along each axis.
pub(crate) fn are_near(a: &[[f64; 2]; 3], b: &[[f64; 2]; 3], gap: f64) -> bool {
    a.iter().zip(b).all(|(a, b)| a[0] <= b[1] + gap && b[0] <= a[1] + gap)
}

/// Return the distance of the side from `p` to `q` from that from `r` to `s` (Ericson, Real-Time Collision Detection,
/// section 5.1.9).
pub(crate) fn distance([p, q]: [Vector; 2], [r, s]: [Vector; 2]) -> f64 {
    let (one, other, from) = (minus(q, p), minus(s, r), minus(p, r));
    let (square, other_square) = (dot(one, one) + f64::MIN_POSITIVE, dot(other, other) + f64::MIN_POSITIVE);
    let (mixed, at_one, at_other) = (dot(one, other), dot(one, from), dot(other, from));
    let parallel = (square * other_square - mixed * mixed).max(f64::MIN_POSITIVE);
    let share = ((mixed * at_other - at_one * other_square) / parallel).clamp(0.0, 1.0);
    let other_share = ((mixed * share + at_other) / other_square).clamp(0.0, 1.0);
    let share = ((mixed * other_share - at_one) / square).clamp(0.0, 1.0);
    let apart = minus(between(p, q, share), between(r, s, other_share));
    dot(apart, apart).sqrt()
}

/// Return the part of the side from `p` to `q` after which it passes through a triangle, 0 and 1 to rounding (Möller &
/// Trumbore 1997).
pub(crate) fn piercing([p, q]: [Vector; 2], [a, b, c]: [Vector; 3]) -> Option<f64> {
    let (along, one, other, from) = (minus(q, p), minus(b, a), minus(c, a), minus(p, a));
    let (across, around) = (cross(along, other), cross(from, one));
    let volume = dot(one, across);
    let [first, second, share] = [dot(from, across), dot(along, around), dot(other, around)].map(|part| part / volume);
    // Without a volume the side is parallel, and the parts are no numbers.
    let inside = first >= -ROUNDING && second >= -ROUNDING && first + second <= 1.0 + ROUNDING;
    (inside && (-ROUNDING..=1.0 + ROUNDING).contains(&share)).then_some(share)
}

/// Return the distance of a point from the plane of a triangle where its foot lies inside; infinite elsewhere.
pub(crate) fn height(p: Vector, [a, b, c]: [Vector; 3]) -> f64 {
    let (one, other, from) = (minus(b, a), minus(c, a), minus(p, a));
    let normal = cross(one, other);
    let square = dot(normal, normal);
    let (first, second) = (dot(cross(from, other), normal) / square, dot(cross(one, from), normal) / square);
    let inside = first >= -ROUNDING && second >= -ROUNDING && first + second <= 1.0 + ROUNDING;
    if inside { dot(from, normal).abs() / square.sqrt() } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_have_the_distance_of_their_nearest_points() {
        let side = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let found = [
            distance(side, [[1.0, -1.0, 0.5], [1.0, 1.0, 0.5]]), // across it
            distance(side, [[-1.0, 3.0, 4.0], [3.0, 3.0, 4.0]]), // along it
            distance(side, [[5.0, 0.0, 4.0], [6.0, 9.0, 4.0]]),  // from end to end
            distance(side, [[1.0, 1.0, 0.0], [1.0, 5.0, 0.0]]),  // an end above the middle
        ];
        assert_eq!(found, [0.5, 5.0, 5.0, 1.0]);
    }

    #[test]
    fn a_side_pierces_a_triangle() {
        let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let through = |x: f64, low: f64| piercing([[x, x, low], [x, x, 1.0]], triangle);
        assert_eq!([through(0.3, -1.0), through(0.5, 0.0), through(0.6, -1.0)], [Some(0.5), Some(0.0), None]);
        assert_eq!([through(0.3, 0.5), piercing([[-1.0, 0.2, 0.0], [1.0, 0.2, 0.0]], triangle)], [None; 2]);
        assert_eq!([height([0.2, 0.2, -3.0], triangle), height([0.8, 0.8, 1.0], triangle)], [3.0, f64::INFINITY]);
    }
}
