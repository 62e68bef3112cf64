//! Sparse symmetric matrices and their Cholesky factors, in an order of nested dissection.
//!
//! Pattern and supernodes of the factor are found once, by faer.

use faer::Side;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};

use crate::dissection::dissect;
use crate::geometry::Vector;
use crate::supernodes::{MARGIN, Plan};
use crate::{Error, WingError};

/// Lower triangle of a sparse symmetric matrix, in the order of its factors.
pub(crate) struct Symmetric {
    /// First entry of each column: `[order + 1]`.
    columns: Vec<usize>,
    /// Row of each entry, ascending in a column.
    rows: Vec<usize>,
    /// Entries.
    pub(crate) values: Vec<f64>,
    /// Row of the factors of each unknown.
    ranks: Vec<usize>,
    plan: Plan,
    factors: Vec<f64>,
    /// Right-hand side in that order, and the part below a supernode: `[2, order]`.
    work: Vec<f64>,
}

impl Symmetric {
    /// Return the zero matrix with a pattern of `places` (column, row) of either triangle, in any order, of unknowns that
    /// belong to the edges between these `ends`, m, or to nodes: `[order]`.
    pub(crate) fn new(mut places: Vec<(u32, u32)>, ends: &[[Vector; 2]]) -> Result<Self, Error> {
        let order = ends.len();
        let mut ranks = vec![0; order];
        dissect(&places, ends).into_iter().enumerate().for_each(|(rank, i)| ranks[i] = rank);
        for (i, j) in &mut places {
            let [a, b] = [*i, *j].map(|i| ranks[i as usize] as u32);
            (*i, *j) = (a.min(b), a.max(b));
        }
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
        let same: Vec<_> = (0..order).collect();
        let ordering = SymmetricOrdering::Custom(PermRef::new_checked(&same, &same, order));
        let symbolic =
            factorize_symbolic_cholesky(pattern, Side::Lower, ordering, forced).map_err(|_| WingError::Singular)?;
        let plan = match symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(supernodes) => {
                Plan::new(supernodes, places.iter().map(|&(i, j)| (i as usize, j as usize)))
            }
            _ if order == 0 => Plan::default(),
            SymbolicCholeskyRaw::Simplicial(_) => return Err(WingError::Singular.into()),
        };
        Ok(Self {
            values: vec![0.0; rows.len()],
            columns,
            rows,
            ranks,
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

    /// Return first entries of the columns, rows and values of the lower triangle.
    pub(crate) fn lower(&self) -> (&[usize], &[usize], &[f64]) {
        (&self.columns, &self.rows, &self.values)
    }

    /// Return the place of an entry of the pattern, of either triangle, in `values`.
    pub(crate) fn place(&self, i: usize, j: usize) -> usize {
        let (i, j) = (self.ranks[i], self.ranks[j]);
        let (column, row) = (i.min(j), i.max(j));
        let start = self.columns[column];
        match self.rows[start..self.columns[column + 1]].binary_search(&row) {
            Ok(place) => start + place,
            Err(_) => unreachable!("the pattern holds every entry of the elements"),
        }
    }

    /// Add `value` to the diagonal entry `i`; the diagonal belongs to the pattern.
    pub(crate) fn add_to_diagonal(&mut self, i: usize, value: f64) {
        self.values[self.columns[self.ranks[i]]] += value;
    }

    /// Return the diagonal entry `i`.
    pub(crate) fn diagonal(&self, i: usize) -> f64 {
        self.values[self.columns[self.ranks[i]]]
    }

    /// Factorise the matrix; `false` means that it is not positive definite.
    pub(crate) fn factorise(&mut self) -> bool {
        self.plan.factorise(&self.values, &mut self.factors)
    }

    /// Replace `b` by the solution of the factorised matrix.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let Self { ranks, plan, factors, work, .. } = self;
        let (y, below) = work.split_at_mut(ranks.len());
        b.iter().zip(&*ranks).for_each(|(b, &rank)| y[rank] = *b);
        plan.solve(factors, y, below);
        b.iter_mut().zip(&*ranks).for_each(|(b, &rank)| *b = y[rank]);
    }
}

#[cfg(test)]
#[path = "sparse/tests.rs"]
mod tests;
