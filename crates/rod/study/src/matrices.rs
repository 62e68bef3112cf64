//! The matrix that all solvers get: K + 4 m/dt² of the thesis' beam in space, bending in the diagonal plane, so that no
//! entry of the band vanishes.

use faer::sparse::{SparseColMat, Triplet};
use rod::{Banded, Parameters, Rod};

use crate::rods::thesis_beam;

/// Step, s.
pub const DT: f64 = 1e-3;

/// Of `n` segments.
pub fn newton_matrix(n: usize) -> Banded {
    let diagonal = Parameters { gravity: [0.0, -0.5, -0.5], ..thesis_beam::<3>(n) };
    let mut rod = Rod::new(diagonal).expect("these parameters are good");
    (0..5).for_each(|_| rod.step(DT).expect("an easy step"));
    let mut matrix = rod.stiffness().expect("a shape that steps have reached");
    let inertia = 4.0 * 0.0571 / n as f64 / (DT * DT);
    (0..matrix.order()).for_each(|j| matrix.column_mut(j)[0] += inertia);
    matrix
}

/// The lower triangle.
pub fn to_sparse(matrix: &Banded) -> SparseColMat<usize, f64> {
    let order = matrix.order();
    let entries: Vec<_> = (0..order)
        .flat_map(|j| {
            let column = matrix.column(j).iter().enumerate().filter(|(_, value)| **value != 0.0);
            column.map(move |(i, value)| Triplet::new(j + i, j, *value))
        })
        .collect();
    SparseColMat::try_new_from_triplets(order, order, &entries).expect("the entries lie in the matrix")
}
