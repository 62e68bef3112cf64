//! Cholesky factors by supernodes: blocks of columns that have the same rows below their triangle.
//!
//! Each block is factorised and then subtracts its products from the blocks of its rows:
//!
//! ```text
//! L_11 L_11ᵀ = A_11,     L_21 = A_21 L_11⁻ᵀ,     A_22 −= L_21 L_21ᵀ.
//! ```
//!
//! The blocks of a wing are small. A general matrix product would cost more in its calls than in its sums, and each
//! entry of a product has one known place in a later block. All processors sum in the same order; those that fuse a
//! product with its sum round once less.

use std::array::from_fn;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use pulp::{Arch, Simd, WithSimd};

/// Columns of a product at once; the registers of AVX2 hold them with [`TALL`] vectors.
const WIDE: usize = 4;
/// Vectors of a product at once.
const TALL: usize = 2;
/// Entries behind the factors that a vector may read.
pub(crate) const MARGIN: usize = 8 * TALL;

/// Bits of the first entries of a vector.
const MASKS: [[u64; 4]; 5] = [[0; 4], [!0, 0, 0, 0], [!0, !0, 0, 0], [!0, !0, !0, 0], [!0; 4]];

/// Column of a later supernode from which a row of a supernode subtracts.
struct Target {
    /// Place of the column.
    start: usize,
    /// Runs of this row and of those below it, in `runs`.
    runs: [usize; 2],
}

/// Rows of a supernode that follow each other in a later one.
struct Run {
    /// First of them among the rows below the supernode.
    first: usize,
    count: usize,
    /// Its place in a column of the later supernode.
    place: usize,
}

/// Places of the entries, which do not change.
#[derive(Default)]
pub(crate) struct Plan {
    supernodes: usize,
    /// First column of each supernode, and of none: `[supernodes + 1]`.
    columns: Vec<usize>,
    /// First entry of each supernode: `[supernodes + 1]`.
    entries: Vec<usize>,
    /// Targets of the rows below each supernode, one supernode after the other.
    targets: Vec<Target>,
    runs: Vec<Run>,
    /// Rows below each supernode, one supernode after the other.
    below: Vec<u32>,
    /// Place of each entry of the matrix.
    places: Vec<u32>,
    /// Columns of a product.
    product: Vec<f64>,
}

impl Plan {
    /// Return the places of the entries (row, column) of one triangle of the matrix, in the order of the factors.
    pub(crate) fn new(
        symbolic: &SymbolicSupernodalCholesky<usize>,
        matrix: impl Iterator<Item = (usize, usize)>,
    ) -> Self {
        let count = symbolic.n_supernodes();
        let mut columns = symbolic.supernode_begin()[..count].to_vec();
        columns.push(symbolic.supernode_end().last().copied().unwrap_or(0));
        let entries = symbolic.col_ptr_for_val()[..=count].to_vec();
        let mut supernode = vec![0; columns[count]];
        (0..count).for_each(|s| supernode[columns[s]..columns[s + 1]].fill(s));
        let below = |s: usize| symbolic.supernode(s).pattern();
        let width = |s: usize| columns[s + 1] - columns[s];
        let height = |s: usize| width(s) + below(s).len();
        let place_in = |s: usize, row: usize| match row < columns[s + 1] {
            true => row - columns[s],
            false => width(s) + below(s).partition_point(|&other| other < row),
        };
        let (mut targets, mut runs, mut last) = (Vec::new(), Vec::<Run>::new(), None);
        for s in 0..count {
            let mut run = 0;
            for (j, &row) in below(s).iter().enumerate() {
                let later = supernode[row];
                if last != Some((s, later)) {
                    run = runs.len();
                    for (first, &row) in below(s).iter().enumerate().skip(j) {
                        let place = place_in(later, row);
                        match runs[run..].last_mut() {
                            Some(run) if place == run.place + run.count => run.count += 1,
                            _ => runs.push(Run { first, count: 1, place }),
                        }
                    }
                    last = Some((s, later));
                }
                run += usize::from(j >= runs[run].first + runs[run].count);
                let start = entries[later] + (row - columns[later]) * height(later);
                targets.push(Target { start, runs: [run, runs.len()] });
            }
        }
        let patterns = (0..count).flat_map(|s| below(s).iter().map(|&row| row as u32)).collect();
        let places = matrix.map(|(i, j)| {
            let (row, column) = (i.max(j), i.min(j));
            let s = supernode[column];
            (entries[s] + (column - columns[s]) * height(s) + place_in(s, row)) as u32
        });
        let places = places.collect();
        let tallest = (0..count).map(height).max().unwrap_or(0);
        let product = vec![0.0; WIDE * (tallest + MARGIN) + MARGIN];
        Self { supernodes: count, columns, entries, targets, runs, below: patterns, places, product }
    }

    /// Write the factors of the matrix of `values`; `false` means that it is not positive definite.
    pub(crate) fn factorise(&mut self, values: &[f64], factors: &mut [f64]) -> bool {
        self.spread(values, factors);
        Arch::new().dispatch(Factorise { plan: self, factors })
    }

    /// The same as on a processor without vectors.
    #[cfg(test)]
    pub(crate) fn factorise_without_vectors(&mut self, values: &[f64], factors: &mut [f64]) -> bool {
        self.spread(values, factors);
        Factorise { plan: self, factors }.with_simd(pulp::Scalar)
    }

    /// Write the values to their places.
    fn spread(&self, values: &[f64], factors: &mut [f64]) {
        factors.fill(0.0);
        self.places.iter().zip(values).for_each(|(&place, value)| factors[place as usize] = *value);
    }

    /// Replace `y` by the solution of L Lᵀ y, in the order of the factors; `below` is scratch of the same size.
    pub(crate) fn solve(&self, factors: &[f64], y: &mut [f64], below: &mut [f64]) {
        Arch::new().dispatch(Solve { plan: self, factors, y, below });
    }
}

struct Factorise<'a> {
    plan: &'a mut Plan,
    factors: &'a mut [f64],
}

impl WithSimd for Factorise<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { plan: Plan { supernodes, columns, entries, targets, runs, product, .. }, factors } = self;
        let mut targets = targets.as_slice();
        for s in 0..*supernodes {
            let width = columns[s + 1] - columns[s];
            let height = (entries[s + 1] - entries[s]) / width;
            let block = &mut factors[entries[s]..];
            for left in (0..width).step_by(WIDE) {
                let wide = WIDE.min(width - left);
                if left > 0 {
                    let stride = multiply(simd, block, height, left, left, product);
                    let columns = block[left * height..].chunks_exact_mut(height).zip(product.chunks_exact(stride));
                    for (column, sums) in columns.take(wide) {
                        column[left..].iter_mut().zip(sums).for_each(|(a, sum)| *a -= sum);
                    }
                }
                if !factorise_columns(&mut block[left * height..(left + wide) * height], height, left) {
                    return false;
                }
            }
            let (own, others) = targets.split_at(height - width);
            targets = others;
            for (i, own) in own.chunks(WIDE).enumerate() {
                let first = width + WIDE * i;
                let stride = multiply(simd, &factors[entries[s]..], height, width, first, product);
                let mut begin = 0;
                for own in own.chunk_by(|a, b| a.runs[1] == b.runs[1]) {
                    for &Run { first, count, place } in &runs[own[0].runs[0]..own[0].runs[1]] {
                        let skipped = (WIDE * i + begin).saturating_sub(first);
                        let row = first + skipped - WIDE * i;
                        for (j, target) in own.iter().enumerate() {
                            let sums = &product[(begin + j) * stride + row..];
                            subtract(&mut factors[target.start + place + skipped..], sums, count - skipped);
                        }
                    }
                    begin += own.len();
                }
            }
        }
        true
    }
}

struct Solve<'a> {
    plan: &'a Plan,
    factors: &'a [f64],
    y: &'a mut [f64],
    below: &'a mut [f64],
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { plan: Plan { supernodes, columns, entries, below: patterns, .. }, factors, y, below } = self;
        let block = |s: usize| (columns[s], columns[s + 1] - columns[s], &factors[entries[s]..entries[s + 1]]);
        let all = patterns.as_slice();
        let mut patterns = all;
        for s in 0..*supernodes {
            let (start, count, values) = block(s);
            let height = values.len() / count;
            let (rows, others) = patterns.split_at(height - count);
            patterns = others;
            let own = &mut y[start..start + count];
            for (j, column) in values.chunks_exact(height).enumerate() {
                let y_j = own[j] * column[j];
                own[j] = y_j;
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
            rows.iter().zip(&*below).for_each(|(&row, sum)| y[row as usize] -= sum);
        }
        patterns = all;
        for s in (0..*supernodes).rev() {
            let (start, count, values) = block(s);
            let height = values.len() / count;
            let (others, rows) = patterns.split_at(patterns.len() + count - height);
            patterns = others;
            let below = &mut below[..rows.len()];
            below.iter_mut().zip(rows).for_each(|(below, &row)| *below = y[row as usize]);
            let own = &mut y[start..start + count];
            for (j, column) in values.chunks_exact(height).enumerate().rev() {
                let sum = dot(&column[count..], below) + dot(&column[j + 1..count], &own[j + 1..]);
                own[j] = (own[j] - sum) * column[j];
            }
        }
    }
}

/// Factorise columns `first` … of a block, whose earlier columns are subtracted; `false` where they have no root. The
/// diagonal then holds the inverse of that of L.
#[inline(always)]
fn factorise_columns(columns: &mut [f64], height: usize, first: usize) -> bool {
    for j in 0..columns.len() / height {
        let (before, column) = columns.split_at_mut(j * height);
        let column = &mut column[first + j..height];
        for earlier in before.chunks_exact(height) {
            let earlier = &earlier[first + j..];
            let factor = earlier[0];
            column.iter_mut().zip(earlier).for_each(|(a, l)| *a -= l * factor);
        }
        if !(column[0] > 0.0 && column[0].is_finite()) {
            return false;
        }
        let over = 1.0 / column[0].sqrt();
        column[1..].iter_mut().for_each(|a| *a *= over);
        column[0] = over;
    }
    true
}

/// Write Σ l_ik l_jk over the first `depth` columns k of a block, for [`WIDE`] rows j from `first` on and all rows i
/// from there on. Return the distance of the columns of the product.
///
/// Rows j and vectors reach into what follows a column; these sums are not used.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn multiply<S: Simd>(simd: S, block: &[f64], height: usize, depth: usize, first: usize, product: &mut [f64]) -> usize {
    let vectors = (height - first).div_ceil(S::F64_LANES);
    let stride = vectors * S::F64_LANES;
    let from = &block[first..];
    let mut done = 0;
    while done + TALL <= vectors {
        multiply_tile::<S, TALL>(simd, from, height, depth, done, stride, product);
        done += TALL;
    }
    if vectors > done {
        multiply_tile::<S, 1>(simd, from, height, depth, done, stride, product);
    }
    stride
}

/// Write `N` vectors of each column of a product, from vector `done` on.
#[inline(always)]
fn multiply_tile<S: Simd, const N: usize>(
    simd: S,
    from: &[f64],
    height: usize,
    depth: usize,
    done: usize,
    stride: usize,
    product: &mut [f64],
) {
    let row = done * S::F64_LANES;
    let mut sums = [[simd.splat_f64s(0.0); N]; WIDE];
    for column in 0..depth {
        let column = &from[column * height..][..WIDE.max(row + N * S::F64_LANES)];
        let (vectors, _) = S::as_simd_f64s(&column[row..][..N * S::F64_LANES]);
        for j in 0..WIDE {
            let factor = simd.splat_f64s(column[j]);
            for i in 0..N {
                sums[j][i] = simd.mul_add_e_f64s(vectors[i], factor, sums[j][i]);
            }
        }
    }
    for (product, sums) in product.chunks_exact_mut(stride).zip(&sums) {
        let (vectors, _) = S::as_mut_simd_f64s(&mut product[row..row + N * S::F64_LANES]);
        vectors.copy_from_slice(sums);
    }
}

/// Subtract the first `count` numbers of `b` from those of `a`; both go on behind them.
#[inline(always)]
fn subtract(a: &mut [f64], b: &[f64], count: usize) {
    let chunks = count.div_ceil(4);
    let (a, _) = a[..4 * chunks].as_chunks_mut::<4>();
    let (b, _) = b[..4 * chunks].as_chunks::<4>();
    for (k, (a, b)) in a.iter_mut().zip(b).enumerate() {
        let mask = &MASKS[(count - 4 * k).min(4)];
        // Of copies a compiler knows that they do not overlap.
        let (own, other) = (*a, *b);
        *a = from_fn(|l| own[l] - f64::from_bits(other[l].to_bits() & mask[l]));
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
