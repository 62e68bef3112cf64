//! Symmetric banded matrices and their LDLᵀ factors without pivoting, L unit lower triangular and D diagonal.
//!
//! A factorisation is O(order · half-bandwidth²) work. By Sylvester's law of inertia the number of negative entries of
//! D equals the number of negative eigenvalues.

/// Lower triangle of a symmetric banded matrix, or its factors after [`Banded::factorise`].
#[derive(Clone)]
pub struct Banded {
    order: usize,
    half_bandwidth: usize,
    /// Columns from their diagonal down: `[order][half_bandwidth + 1]`, 0 below the last row. The factors are L with
    /// 1/D on its diagonal.
    columns: Vec<f64>,
}

/// A pivot is zero or not finite.
#[derive(Debug)]
pub struct Singular;

impl Banded {
    /// Return the zero matrix.
    pub fn zeros(order: usize, half_bandwidth: usize) -> Self {
        Self { order, half_bandwidth, columns: vec![0.0; order * (half_bandwidth + 1)] }
    }

    /// Return the number of rows.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Return the number of diagonals below the main diagonal.
    pub fn half_bandwidth(&self) -> usize {
        self.half_bandwidth
    }

    /// Return a column from its diagonal down: `[half_bandwidth + 1]`; entries below the last row are 0.
    pub fn column(&self, column: usize) -> &[f64] {
        let stride = self.half_bandwidth + 1;
        &self.columns[column * stride..][..stride]
    }

    /// Return a column from its diagonal down, for writing.
    #[inline]
    pub fn column_mut(&mut self, column: usize) -> &mut [f64] {
        let stride = self.half_bandwidth + 1;
        &mut self.columns[column * stride..][..stride]
    }

    /// Replace the matrix by its factors and return the number of negative pivots.
    pub fn factorise(&mut self) -> Result<usize, Singular> {
        // Constant widths for a rod in the plane, in the plane with shear, and in space.
        match self.half_bandwidth {
            5 => factorise::<6>(&mut self.columns),
            7 => factorise::<8>(&mut self.columns),
            8 => factorise::<9>(&mut self.columns),
            _ => self.factorise_any_width(),
        }
    }

    fn factorise_any_width(&mut self) -> Result<usize, Singular> {
        let stride = self.half_bandwidth + 1;
        let mut negative_pivots = 0;
        for j in 0..self.order {
            let (column, later) = self.columns[j * stride..].split_at_mut(stride);
            let inverse = inverse_pivot(column[0], &mut negative_pivots)?;
            for (k, updated) in (1..stride).zip(later.chunks_exact_mut(stride)) {
                let factor = column[k] * inverse;
                for (entry, below) in updated.iter_mut().zip(&column[k..]) {
                    *entry -= factor * below;
                }
            }
            column[0] = inverse;
            column[1..].iter_mut().for_each(|entry| *entry *= inverse);
        }
        Ok(negative_pivots)
    }

    /// Replace `b` by the solution of the factorised matrix.
    pub fn solve(&self, b: &mut [f64]) {
        match self.half_bandwidth {
            5 => solve::<6>(&self.columns, b),
            7 => solve::<8>(&self.columns, b),
            8 => solve::<9>(&self.columns, b),
            _ => self.solve_any_width(b),
        }
    }

    fn solve_any_width(&self, b: &mut [f64]) {
        let stride = self.half_bandwidth + 1;
        for (j, column) in self.columns.chunks_exact(stride).enumerate() {
            let b_j = b[j];
            for (entry, factor) in b[j + 1..].iter_mut().zip(&column[1..]) {
                *entry -= factor * b_j;
            }
        }
        for (j, column) in self.columns.chunks_exact(stride).enumerate().rev() {
            let coupled: f64 = column[1..].iter().zip(&b[j + 1..]).map(|(factor, entry)| factor * entry).sum();
            b[j] = b[j] * column[0] - coupled;
        }
    }
}

fn inverse_pivot(pivot: f64, negative_pivots: &mut usize) -> Result<f64, Singular> {
    if pivot == 0.0 || !pivot.is_finite() {
        return Err(Singular);
    }
    *negative_pivots += usize::from(pivot < 0.0);
    Ok(1.0 / pivot)
}

/// [`Banded::factorise`] for columns of `S` entries.
fn factorise<const S: usize>(columns: &mut [f64]) -> Result<usize, Singular> {
    let (columns, _) = columns.as_chunks_mut::<S>();
    let mut negative_pivots = 0;
    let mut rest = columns;
    while let Some((column, later)) = rest.split_first_mut() {
        let inverse = inverse_pivot(column[0], &mut negative_pivots)?;
        let factors = column.map(|entry| entry * inverse);
        if later.len() >= S - 1 {
            for k in 1..S {
                for i in k..S {
                    later[k - 1][i - k] -= factors[k] * column[i];
                }
            }
        } else {
            for (k, updated) in later.iter_mut().enumerate() {
                for i in k + 1..S {
                    updated[i - k - 1] -= factors[k + 1] * column[i];
                }
            }
        }
        *column = factors;
        column[0] = inverse;
        rest = later;
    }
    Ok(negative_pivots)
}

/// [`Banded::solve`] for columns of `S` entries.
fn solve<const S: usize>(columns: &[f64], b: &mut [f64]) {
    let (columns, _) = columns.as_chunks::<S>();
    // The entries from j on, in registers; 0 beyond the last.
    let mut window = [0.0; S];
    let known = window.len().min(b.len());
    window[..known].copy_from_slice(&b[..known]);
    for (j, column) in columns.iter().enumerate() {
        let b_j = window[0];
        b[j] = b_j;
        for i in 1..S {
            window[i - 1] = window[i] - column[i] * b_j;
        }
        window[S - 1] = b.get(j + S).copied().unwrap_or(0.0);
    }
    // The solution from j + 1 on. The sums leave the newest entry for last, because only it has to wait.
    let mut window = [0.0; S];
    for (j, column) in columns.iter().enumerate().rev() {
        let mut sums = [0.0; 2];
        for i in (2..S).rev() {
            sums[i % 2] += column[i] * window[i - 1];
        }
        let x_j = b[j] * column[0] - (sums[0] + sums[1]) - column[1] * window[0];
        b[j] = x_j;
        for i in (1..S).rev() {
            window[i] = window[i - 1];
        }
        window[0] = x_j;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    const ORDER: usize = 60;
    /// Widths of a rod in the plane, in the plane with shear and in space, and another width.
    const HALF_BANDWIDTHS: [usize; 4] = [5, 7, 8, 4];

    /// A banded matrix with off-diagonal entries in ±1, as `Banded` and dense.
    fn banded_and_dense(half_bandwidth: usize, diagonal: impl Fn(usize) -> f64) -> (Banded, DMatrix<f64>) {
        let mut banded = Banded::zeros(ORDER, half_bandwidth);
        let mut dense = DMatrix::zeros(ORDER, ORDER);
        for j in 0..ORDER {
            for i in j..ORDER.min(j + half_bandwidth + 1) {
                let value = if i == j { diagonal(i) } else { (1.0 + (7 * i + 13 * j) as f64).sin() };
                banded.column_mut(j)[i - j] = value;
                dense[(i, j)] = value;
                dense[(j, i)] = value;
            }
        }
        (banded, dense)
    }

    #[test]
    fn solution_agrees_with_a_dense_solver() {
        for (half_bandwidth, sign) in HALF_BANDWIDTHS.into_iter().flat_map(|w| [(w, 1.0), (w, -1.0)]) {
            let (mut banded, dense) = banded_and_dense(half_bandwidth, |i| if i % 3 == 0 { sign * 20.0 } else { 20.0 });
            let b = DVector::from_fn(ORDER, |i, _| (i as f64).cos());
            let expected = dense.lu().solve(&b).unwrap();
            let mut x = b.as_slice().to_vec();
            banded.factorise().unwrap();
            banded.solve(&mut x);
            for (i, (x, expected)) in x.iter().zip(&expected).enumerate() {
                assert!((x - expected).abs() < 1e-12, "{half_bandwidth}, {sign}, row {i}: {x} against {expected}");
            }
        }
    }

    #[test]
    fn negative_pivots_are_the_negative_eigenvalues() {
        for (half_bandwidth, shift) in
            HALF_BANDWIDTHS.into_iter().flat_map(|w| [20.0, 5.0, 0.1, -5.0, -20.0].map(|shift| (w, shift)))
        {
            let (mut banded, dense) = banded_and_dense(half_bandwidth, |i| shift + (i as f64).sin());
            let eigenvalues = dense.symmetric_eigenvalues();
            let expected = eigenvalues.iter().filter(|&&value| value < 0.0).count();
            let found = banded.factorise().unwrap();
            assert_eq!(found, expected, "half-bandwidth {half_bandwidth}, shift {shift}");
        }
    }

    #[test]
    fn a_zero_or_meaningless_pivot_is_refused() {
        for (half_bandwidth, pivot) in
            HALF_BANDWIDTHS.into_iter().flat_map(|w| [0.0, f64::NAN, f64::INFINITY].map(|pivot| (w, pivot)))
        {
            let (mut banded, _) = banded_and_dense(half_bandwidth, |i| if i == 0 { pivot } else { 20.0 });
            assert!(banded.factorise().is_err(), "half-bandwidth {half_bandwidth}, pivot {pivot} was accepted");
        }
    }
}
