//! Vectors of any dimension.

/// Return the scalar product.
pub fn dot<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Return the length.
pub fn norm<const D: usize>(a: [f64; D]) -> f64 {
    dot(a, a).sqrt()
}

/// Return the unit vector along `a`.
pub fn unit<const D: usize>(a: [f64; D]) -> [f64; D] {
    a.map(|part| part / norm(a))
}

/// Return `a - b`.
pub fn minus<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| a[d] - b[d])
}

/// Return `a + share (b - a)`.
pub fn between<const D: usize>(a: [f64; D], b: [f64; D], share: f64) -> [f64; D] {
    std::array::from_fn(|d| a[d] + share * (b[d] - a[d]))
}

/// Return the vector product.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Return `v` turned by `angle` (rad) about the unit vector `axis` by the right-hand rule (Rodrigues).
pub fn turned(v: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let ((sin, cos), along, across) = (angle.sin_cos(), dot(axis, v), cross(axis, v));
    std::array::from_fn(|d| cos * v[d] + sin * across[d] + (1.0 - cos) * along * axis[d])
}
