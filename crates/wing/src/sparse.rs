//! Sparse symmetric matrices and their Cholesky factors, with an order of approximate minimum degree.
//!
//! Order, pattern and supernodes of the factor are found once, by faer.

use faer::Side;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{CholeskySymbolicParams, SymbolicCholeskyRaw, factorize_symbolic_cholesky};

use crate::supernodes::{MARGIN, Plan};
use crate::{Error, WingError};

/// Lower triangle of a sparse symmetric matrix with its factors.
pub(crate) struct Symmetric {
    /// First entry of each column: `[order + 1]`.
    columns: Vec<usize>,
    /// Row of each entry, ascending in a column.
    rows: Vec<usize>,
    /// Entries.
    pub(crate) values: Vec<f64>,
    /// Row of the matrix of each row of the factor.
    order: Vec<usize>,
    plan: Plan,
    factors: Vec<f64>,
    /// Right-hand side in that order, and the part below a supernode: `[2, order]`.
    work: Vec<f64>,
}

impl Symmetric {
    /// Return the zero matrix of `order` with a pattern of `places` (column, row), row ≥ column, in any order.
    pub(crate) fn new(order: usize, mut places: Vec<(u32, u32)>) -> Result<Self, Error> {
        places.sort_unstable();
        places.dedup();
        let mut columns = vec![0; order + 1];
        places.iter().for_each(|&(column, _)| columns[column as usize + 1] += 1);
        for column in 0..order {
            columns[column + 1] += columns[column];
        }
        let rows: Vec<_> = places.iter().map(|&(_, row)| row as usize).collect();
        let pattern = SymbolicSparseColMatRef::new_checked(order, order, &columns, None, &rows);
        // Below zero: supernodes also for a small or a diagonal matrix, which faer would leave without any.
        let supernodal_flop_ratio_threshold = SupernodalThreshold(-1.0);
        let forced = CholeskySymbolicParams { supernodal_flop_ratio_threshold, ..Default::default() };
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, Default::default(), forced)
            .map_err(|_| WingError::Singular)?;
        let (order_of_factor, plan) = match (symbolic.raw(), symbolic.perm()) {
            (SymbolicCholeskyRaw::Supernodal(supernodes), Some(ordering)) => {
                let (old, new) = ordering.arrays();
                let places = places.iter().map(|&(i, j)| (new[i as usize], new[j as usize]));
                (old.to_vec(), Plan::new(supernodes, places))
            }
            _ if order == 0 => (Vec::new(), Plan::default()),
            _ => return Err(WingError::Singular.into()),
        };
        Ok(Self {
            values: vec![0.0; rows.len()],
            columns,
            rows,
            order: order_of_factor,
            factors: vec![0.0; symbolic.len_val() + MARGIN],
            plan,
            work: vec![0.0; 2 * order],
        })
    }

    /// Return the number of rows.
    pub(crate) fn order(&self) -> usize {
        self.columns.len() - 1
    }

    /// Return the number of entries of L.
    pub(crate) fn fill(&self) -> usize {
        self.factors.len() - MARGIN
    }

    /// Return the place of an entry of the pattern in `values`.
    pub(crate) fn place(&self, i: usize, j: usize) -> usize {
        let (column, row) = (i.min(j), i.max(j));
        let start = self.columns[column];
        match self.rows[start..self.columns[column + 1]].binary_search(&row) {
            Ok(place) => start + place,
            Err(_) => unreachable!("the pattern holds every entry of the elements"),
        }
    }

    /// Add `value` to the diagonal entry `i`; the diagonal belongs to the pattern.
    pub(crate) fn add_to_diagonal(&mut self, i: usize, value: f64) {
        self.values[self.columns[i]] += value;
    }

    /// Return the diagonal entry `i`.
    pub(crate) fn diagonal(&self, i: usize) -> f64 {
        self.values[self.columns[i]]
    }

    /// Factorise the matrix; `false` means that it is not positive definite.
    pub(crate) fn factorise(&mut self) -> bool {
        self.plan.factorise(&self.values, &mut self.factors)
    }

    /// Replace `b` by the solution of the factorised matrix.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let Self { order, plan, factors, work, .. } = self;
        let (y, below) = work.split_at_mut(order.len());
        y.iter_mut().zip(&*order).for_each(|(y, &i)| *y = b[i]);
        plan.solve(factors, y, below);
        y.iter().zip(&*order).for_each(|(y, &i)| b[i] = *y);
    }
}

#[cfg(test)]
#[path = "sparse/tests.rs"]
mod tests;
