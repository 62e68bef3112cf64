//! Symmetric banded matrices and their LDLᵀ factors, L unit lower triangular and D diagonal, without pivoting.
//!
//! O(order · half-bandwidth²) work. By Sylvester's law of inertia the negative entries of D are as many as the
//! matrix has negative eigenvalues.

/// Lower triangle of a symmetric banded matrix, or its LDLᵀ factors after [`Banded::factorise`].
pub(crate) struct Banded {
    order: usize,
    half_bandwidth: usize,
    /// Column after column, each from its diagonal down: `[order][half_bandwidth + 1]`.
    columns: Vec<f64>,
}

/// A pivot was zero or not a number.
#[derive(Debug)]
pub(crate) struct Singular;

impl Banded {
    /// The zero matrix.
    pub(crate) fn zeros(order: usize, half_bandwidth: usize) -> Self {
        Self { order, half_bandwidth, columns: vec![0.0; order * (half_bandwidth + 1)] }
    }

    /// Set every entry to zero.
    pub(crate) fn clear(&mut self) {
        self.columns.fill(0.0);
    }

    /// Add to an entry of the lower triangle.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        debug_assert!(row >= column && row - column <= self.half_bandwidth && row < self.order);
        self.columns[column * (self.half_bandwidth + 1) + row - column] += value;
    }

    /// Add `value` to each diagonal entry.
    pub(crate) fn shift(&mut self, value: f64) {
        self.columns.iter_mut().step_by(self.half_bandwidth + 1).for_each(|diagonal| *diagonal += value);
    }

    /// Largest entry of the diagonal.
    pub(crate) fn largest_diagonal(&self) -> f64 {
        self.columns.iter().step_by(self.half_bandwidth + 1).fold(0.0, |largest, d| d.abs().max(largest))
    }

    /// Replace the matrix by its factors; returns the number of negative pivots.
    pub(crate) fn factorise(&mut self) -> Result<usize, Singular> {
        let stride = self.half_bandwidth + 1;
        let mut negative_pivots = 0;
        for j in 0..self.order {
            let (column, later) = self.columns[j * stride..].split_at_mut(stride);
            let pivot = column[0];
            if pivot == 0.0 || !pivot.is_finite() {
                return Err(Singular);
            }
            negative_pivots += usize::from(pivot < 0.0);
            for (k, updated) in (1..stride).zip(later.chunks_exact_mut(stride)) {
                let factor = column[k] / pivot;
                for (entry, below) in updated.iter_mut().zip(&column[k..]) {
                    *entry -= factor * below;
                }
            }
            column[1..].iter_mut().for_each(|entry| *entry /= pivot);
        }
        Ok(negative_pivots)
    }

    /// Replace `b` by the solution of the factorised matrix.
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let stride = self.half_bandwidth + 1;
        for (j, column) in self.columns.chunks_exact(stride).enumerate() {
            let b_j = b[j];
            for (entry, factor) in b[j + 1..].iter_mut().zip(&column[1..]) {
                *entry -= factor * b_j;
            }
        }
        for (j, column) in self.columns.chunks_exact(stride).enumerate().rev() {
            let coupled: f64 = column[1..].iter().zip(&b[j + 1..]).map(|(factor, entry)| factor * entry).sum();
            b[j] = b[j] / column[0] - coupled;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    const ORDER: usize = 60;
    const HALF_BANDWIDTH: usize = 8;

    /// A banded matrix with off-diagonal entries in ±1, as `Banded` and dense.
    fn banded_and_dense(diagonal: impl Fn(usize) -> f64) -> (Banded, DMatrix<f64>) {
        let mut banded = Banded::zeros(ORDER, HALF_BANDWIDTH);
        let mut dense = DMatrix::zeros(ORDER, ORDER);
        for j in 0..ORDER {
            for i in j..ORDER.min(j + HALF_BANDWIDTH + 1) {
                let value = if i == j { diagonal(i) } else { (1.0 + (7 * i + 13 * j) as f64).sin() };
                banded.add(i, j, value);
                dense[(i, j)] = value;
                dense[(j, i)] = value;
            }
        }
        (banded, dense)
    }

    #[test]
    fn solution_agrees_with_a_dense_solver() {
        for sign in [1.0, -1.0] {
            let (mut banded, dense) = banded_and_dense(|i| if i % 3 == 0 { sign * 20.0 } else { 20.0 });
            let b = DVector::from_fn(ORDER, |i, _| (i as f64).cos());
            let expected = dense.lu().solve(&b).unwrap();
            let mut x = b.as_slice().to_vec();
            banded.factorise().unwrap();
            banded.solve(&mut x);
            for (i, (x, expected)) in x.iter().zip(&expected).enumerate() {
                assert!((x - expected).abs() < 1e-12, "sign {sign}, row {i}: {x} against {expected}");
            }
        }
    }

    #[test]
    fn negative_pivots_are_the_negative_eigenvalues() {
        for shift in [20.0, 5.0, 0.1, -5.0, -20.0] {
            let (mut banded, dense) = banded_and_dense(|i| shift + (i as f64).sin());
            let eigenvalues = dense.symmetric_eigenvalues();
            let expected = eigenvalues.iter().filter(|&&value| value < 0.0).count();
            let found = banded.factorise().unwrap();
            assert_eq!(found, expected, "shift {shift}");
        }
    }

    #[test]
    fn a_zero_or_meaningless_pivot_is_refused() {
        for pivot in [0.0, f64::NAN, f64::INFINITY] {
            let (mut banded, _) = banded_and_dense(|i| if i == 0 { pivot } else { 20.0 });
            assert!(banded.factorise().is_err(), "pivot {pivot} was accepted");
        }
    }
}
