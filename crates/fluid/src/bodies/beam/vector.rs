//! Vectors in the plane of x and y.

use crate::space::Vector;

/// Return the left-hand normal.
pub fn normal([x, y]: [f64; 2]) -> [f64; 2] {
    [-y, x]
}

/// Return the direction.
pub fn unit(vector: [f64; 2]) -> [f64; 2] {
    direction(vector).0
}

/// Return the direction and the length.
pub fn direction([x, y]: [f64; 2]) -> ([f64; 2], f64) {
    let length = x.hypot(y);
    ([x / length, y / length], length)
}

/// Return the scalar product.
pub fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Return the vector product.
pub fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Return the difference of two entries of a field in the plane of x and y.
pub fn difference<const D: usize>(field: &[Vec<f64>; D], [from, to]: [usize; 2]) -> [f64; 2] {
    in_plane(field).map(|f| f[to] - f[from])
}

/// Return the components along x and y.
pub fn in_plane<const D: usize>(field: &[Vec<f64>; D]) -> [&[f64]; 2] {
    [0, 1].map(|axis| &field[axis][..])
}

/// Return the vector with components along x and y.
pub fn lifted<const D: usize>(vector: [f64; 2]) -> Vector<D> {
    Vector::from_fn(|axis, _| vector.get(axis).copied().unwrap_or(0.0))
}

/// Return the point at the fraction `t` from `a` to `b`.
pub fn between(a: [f64; 2], b: [f64; 2], t: f64) -> [f64; 2] {
    [0, 1].map(|axis| (1.0 - t) * a[axis] + t * b[axis])
}

/// Return the unit tangent at station `k`: the bisector of the segments beside it, of which `along` gives the
/// directions, from 0 to `last`.
pub fn bisector(k: usize, last: usize, along: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let [behind, ahead] = [k.saturating_sub(1), k.min(last)].map(along);
    unit([behind[0] + ahead[0], behind[1] + ahead[1]])
}
