//! Sparse symmetric matrices and their Cholesky factors by faer, with an order of approximate minimum degree.
//!
//! Order and pattern of the factor are found once.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use crate::Error;

/// Lower triangle of a sparse symmetric matrix with its factors.
pub(crate) struct Symmetric {
    /// First entry of each column: `[order + 1]`.
    columns: Vec<usize>,
    /// Row of each entry, ascending in a column.
    rows: Vec<usize>,
    /// Entries.
    pub(crate) values: Vec<f64>,
    symbolic: SymbolicCholesky<usize>,
    factors: Vec<f64>,
    memory: MemBuffer,
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
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, Default::default(), Default::default())
            .map_err(|_| Error::Singular)?;
        let memory = MemBuffer::new(StackReq::any_of(&[
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
        ]));
        let factors = vec![0.0; symbolic.len_val()];
        Ok(Self { values: vec![0.0; rows.len()], columns, rows, symbolic, factors, memory })
    }

    /// Return the number of rows.
    pub(crate) fn order(&self) -> usize {
        self.columns.len() - 1
    }

    /// Return the number of entries of L.
    pub(crate) fn fill(&self) -> usize {
        self.factors.len()
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
        let Self { columns, rows, values, symbolic, factors, memory } = self;
        let order = columns.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(order, order, columns, None, rows);
        let matrix = SparseColMatRef::new(pattern, values);
        let (plain, stack) = (LltRegularization::default(), MemStack::new(memory));
        let factorised =
            symbolic.factorize_numeric_llt(factors, matrix, Side::Lower, plain, Par::Seq, stack, Default::default());
        factorised.is_ok()
    }

    /// Replace `b` by the solution of the factorised matrix.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let order = self.order();
        let stack = MemStack::new(&mut self.memory);
        LltRef::new(&self.symbolic, &self.factors).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(b, order, 1),
            Par::Seq,
            stack,
        );
    }
}
