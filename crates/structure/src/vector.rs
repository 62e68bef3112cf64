//! Points and matrices in `D` dimensions.

use nalgebra::{SMatrix, SVector};

/// A point, a velocity or a force.
pub type Vector<const D: usize> = SVector<f64, D>;
/// Second derivatives by two points.
pub type Matrix<const D: usize> = SMatrix<f64, D, D>;

/// Return a × b; in two dimensions only the last component differs from 0.
pub fn cross<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> [f64; 3] {
    let component = |i: usize, j: usize| if i < D && j < D { a[i] * b[j] - a[j] * b[i] } else { 0.0 };
    [component(1, 2), component(2, 0), component(0, 1)]
}
