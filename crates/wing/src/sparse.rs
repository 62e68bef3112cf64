//! Sparse symmetric matrices and their Cholesky factors, with an order of approximate minimum degree.
//!
//! Order and pattern of the factor are found once, by faer; it also factorises matrices without supernodes.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky, SymbolicCholeskyRaw, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};
use pulp::{Arch, Simd, WithSimd};

use crate::Error;
use crate::supernodes::{MARGIN, Plan};

/// Lower triangle of a sparse symmetric matrix with its factors.
pub(crate) struct Symmetric {
    /// First entry of each column: `[order + 1]`.
    columns: Vec<usize>,
    /// Row of each entry, ascending in a column.
    rows: Vec<usize>,
    /// Entries.
    pub(crate) values: Vec<f64>,
    symbolic: SymbolicCholesky<usize>,
    /// Places of the entries in supernodes; `None` for a matrix without any.
    plan: Option<Plan>,
    factors: Vec<f64>,
    memory: MemBuffer,
    /// Right-hand side in the order of the factor, and the part below a supernode: `[2, order]`.
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
        let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, Default::default(), Default::default())
            .map_err(|_| Error::Singular)?;
        let memory = MemBuffer::new(StackReq::any_of(&[
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
            symbolic.solve_in_place_scratch::<f64>(1, Par::Seq),
        ]));
        let plan = match (symbolic.raw(), symbolic.perm()) {
            (SymbolicCholeskyRaw::Supernodal(raw), Some(order)) => {
                let (_, new) = order.arrays();
                Some(Plan::new(raw, places.iter().map(|&(i, j)| (new[i as usize], new[j as usize]))))
            }
            _ => None,
        };
        let factors = vec![0.0; symbolic.len_val() + MARGIN];
        let work = vec![0.0; 2 * order];
        Ok(Self { values: vec![0.0; rows.len()], columns, rows, symbolic, plan, factors, memory, work })
    }

    /// Return the number of rows.
    pub(crate) fn order(&self) -> usize {
        self.columns.len() - 1
    }

    /// Return the number of entries of L.
    pub(crate) fn fill(&self) -> usize {
        self.symbolic.len_val()
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
        let Self { columns, rows, values, symbolic, plan, factors, memory, .. } = self;
        if let Some(plan) = plan {
            return plan.factorise(values, factors);
        }
        let order = columns.len() - 1;
        let pattern = SymbolicSparseColMatRef::new_checked(order, order, columns, None, rows);
        let matrix = SparseColMatRef::new(pattern, values);
        let (plain, stack) = (LltRegularization::default(), MemStack::new(memory));
        let factors = &mut factors[..symbolic.len_val()];
        let factorised =
            symbolic.factorize_numeric_llt(factors, matrix, Side::Lower, plain, Par::Seq, stack, Default::default());
        factorised.is_ok()
    }

    /// Replace `b` by the solution of the factorised matrix.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        let order = self.order();
        if let (SymbolicCholeskyRaw::Supernodal(raw), Some(order)) = (self.symbolic.raw(), self.symbolic.perm()) {
            let (order, _) = order.arrays();
            let (y, below) = self.work.split_at_mut(order.len());
            y.iter_mut().zip(order).for_each(|(y, &i)| *y = b[i]);
            Arch::new().dispatch(Solve { symbolic: raw, factors: &self.factors, y, below });
            y.iter().zip(order).for_each(|(y, &i)| b[i] = *y);
            return;
        }
        let stack = MemStack::new(&mut self.memory);
        LltRef::new(&self.symbolic, &self.factors[..self.symbolic.len_val()]).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(b, order, 1),
            Par::Seq,
            stack,
        );
    }
}

/// Solve by [`solve_supernodes`] with the instructions of the processor at hand.
struct Solve<'a> {
    symbolic: &'a SymbolicSupernodalCholesky<usize>,
    factors: &'a [f64],
    y: &'a mut [f64],
    below: &'a mut [f64],
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        solve_supernodes(self.symbolic, self.factors, self.y, self.below);
    }
}

/// Replace `y` by the solution of L Lᵀ y; `below` is scratch.
///
/// A supernode is a block of columns that have the same rows below their triangle. It is too small to pay for the
/// matrix products that a solve by faer calls.
#[inline(always)]
fn solve_supernodes(symbolic: &SymbolicSupernodalCholesky<usize>, factors: &[f64], y: &mut [f64], below: &mut [f64]) {
    let block = |s: usize| {
        let (start, end) = (symbolic.supernode_begin()[s], symbolic.supernode_end()[s]);
        let places = symbolic.col_ptr_for_val();
        let values = &factors[places[s]..places[s + 1]];
        (start, end - start, symbolic.supernode(s).pattern(), values)
    };
    for s in 0..symbolic.n_supernodes() {
        let (start, count, rows, values) = block(s);
        let height = values.len() / count;
        let own = &mut y[start..start + count];
        for (j, column) in values.chunks_exact(height).enumerate() {
            own[j] /= column[j];
            let y_j = own[j];
            own[j + 1..].iter_mut().zip(&column[j + 1..]).for_each(|(y, l)| *y -= l * y_j);
        }
        let below = &mut below[..rows.len()];
        below.fill(0.0);
        for (columns, own) in values.chunks(4 * height).zip(own.chunks(4)) {
            let tail = |j: usize| &columns[j * height + count..][..rows.len()];
            if let [y_0, y_1, y_2, y_3] = *own {
                let (l_0, l_1, l_2, l_3) = (tail(0), tail(1), tail(2), tail(3));
                for (i, sum) in below.iter_mut().enumerate() {
                    *sum += l_0[i] * y_0 + l_1[i] * y_1 + (l_2[i] * y_2 + l_3[i] * y_3);
                }
            } else {
                for (j, y_j) in own.iter().enumerate() {
                    below.iter_mut().zip(tail(j)).for_each(|(sum, l)| *sum += l * y_j);
                }
            }
        }
        rows.iter().zip(&*below).for_each(|(&row, sum)| y[row] -= sum);
    }
    for s in (0..symbolic.n_supernodes()).rev() {
        let (start, count, rows, values) = block(s);
        let height = values.len() / count;
        let below = &mut below[..rows.len()];
        below.iter_mut().zip(rows).for_each(|(below, &row)| *below = y[row]);
        let own = &mut y[start..start + count];
        for (j, column) in values.chunks_exact(height).enumerate().rev() {
            let sum = dot(&column[count..], below) + dot(&column[j + 1..count], &own[j + 1..]);
            own[j] = (own[j] - sum) / column[j];
        }
    }
}

/// Return Σ a b, in lanes that a processor adds at once.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_chunks.zip(b_chunks) {
        lanes.iter_mut().zip(a.iter().zip(b)).for_each(|(lane, (a, b))| *lane += a * b);
    }
    rest + lanes.iter().sum::<f64>()
}

#[cfg(test)]
#[path = "sparse/tests.rs"]
mod tests;
