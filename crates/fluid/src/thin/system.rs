//! The small system of the forces on the markers, and its solution by conjugate gradients.
//!
//! The preconditioner is an incomplete factor `L D Lᵀ` with the pattern of the matrix (Meijerink and van der Vorst
//! 1977, doi:10.1090/S0025-5718-1977-0438681-4). Along a straight line every two markers that share points with a third
//! one before them share points themselves, so the factor is the whole one, and nothing is iterated.

use std::array::from_fn;

use nalgebra::SMatrix;

use super::markers::{Markers, inverse};
use crate::grid::Grid;
use crate::kernel::Kernel;
use crate::space::Vector;

/// Residual over the right-hand side at which a solution is taken.
const TOLERANCE: f64 = 1e-12;

/// Most iterations. Some five are needed where bodies keep apart, the square root of c_0 C_eta more where they lie on
/// each other.
const MOST_ITERATIONS: usize = 2000;

/// Least pivot of the factor over its diagonal; a smaller one becomes the diagonal. Markers that keep apart have pivots
/// above a quarter.
const LEAST_PIVOT: f64 = 0.01;

/// The matrix with its neighbours, and room for its solution.
pub struct System<const D: usize> {
    matrix: Matrix<D>,
    /// Blocks of grid points along each axis, and the block of each marker.
    counts: [usize; D],
    blocks: Vec<[usize; D]>,
    /// First marker in each block, and the next one in the same block after each marker; the number of markers if there
    /// is none.
    heads: Vec<usize>,
    next: Vec<usize>,
    near: Vec<usize>,
    residual: Vec<Vector<D>>,
    scaled: Vec<Vector<D>>,
    direction: Vec<Vector<D>>,
    image: Vec<Vector<D>>,
}

/// A part of the matrix for two markers, or for one: rows and columns are axes.
type Block<const D: usize> = SMatrix<f64, D, D>;

/// The matrix `A + E C⁻¹ Eᵗ/V` in rows of blocks, with the inverse drag A of each marker, and its factor.
struct Matrix<const D: usize> {
    diagonal: Vec<Block<D>>,
    /// Beginning of each row in `columns` and `entries`, which hold the part above the diagonal. An entry is the same for
    /// all axes.
    starts: Vec<usize>,
    columns: Vec<usize>,
    entries: Vec<f64>,
    /// The inverse of `D` of the incomplete factor, and `Lᵀ` above its diagonal in the places of `entries`.
    pivots: Vec<Block<D>>,
    factors: Vec<Block<D>>,
    /// Whether that factor is the whole one.
    exact: bool,
}

impl<const D: usize> Matrix<D> {
    /// Write the factor.
    fn factorize(&mut self) {
        let Self { diagonal, starts, columns, entries, pivots, factors, exact } = self;
        pivots.clone_from(diagonal);
        factors.clear();
        factors.reserve(entries.capacity());
        factors.extend(entries.iter().map(|entry| Block::from_diagonal_element(*entry)));
        *exact = true;
        for j in 0..pivots.len() {
            let (own, mut pivot) = (inverse(diagonal[j]), inverse(pivots[j]));
            if (0..D).any(|axis| LEAST_PIVOT * pivot[(axis, axis)] > own[(axis, axis)] || pivot[(axis, axis)] < 0.0) {
                pivot = own;
                *exact = false;
            }
            pivots[j] = pivot;
            let row = starts[j]..starts[j + 1];
            for first in row.clone() {
                let (k, share) = (columns[first], factors[first].tr_mul(&pivot));
                pivots[k] -= share * factors[first];
                let mut place = starts[k];
                for second in first + 1..row.end {
                    while place < starts[k + 1] && columns[place] < columns[second] {
                        place += 1;
                    }
                    if place < starts[k + 1] && columns[place] == columns[second] {
                        factors[place] = factors[place] - share * factors[second];
                    } else {
                        *exact = false;
                    }
                }
            }
            factors[row].iter_mut().for_each(|factor| *factor = pivot * *factor);
        }
    }

    /// Divide `values` by the factor.
    fn divide(&self, values: &mut [Vector<D>]) {
        let Self { starts, columns, pivots, factors, .. } = self;
        for j in 0..values.len() {
            let row = starts[j]..starts[j + 1];
            for (k, factor) in columns[row.clone()].iter().zip(&factors[row]) {
                let change = factor.tr_mul(&values[j]);
                values[*k] -= change;
            }
        }
        for j in (0..values.len()).rev() {
            let row = starts[j]..starts[j + 1];
            let later = columns[row.clone()].iter().zip(&factors[row]).map(|(k, factor)| factor * values[*k]);
            values[j] = later.fold(pivots[j] * values[j], |own, later| own - later);
        }
    }

    /// Write the matrix times `values` to `image`.
    fn multiply(&self, values: &[Vector<D>], image: &mut [Vector<D>]) {
        let Self { diagonal, starts, columns, entries, .. } = self;
        image.iter_mut().zip(diagonal).zip(values).for_each(|((q, d), p)| *q = d * p);
        for j in 0..values.len() {
            let row = starts[j]..starts[j + 1];
            for (k, entry) in columns[row.clone()].iter().zip(&entries[row]) {
                image[j] += values[*k] * *entry;
                image[*k] += values[j] * *entry;
            }
        }
    }
}

impl<const D: usize> System<D> {
    /// Room for a number of markers.
    pub fn new(count: usize) -> Self {
        let zeros = || vec![Vector::zeros(); count];
        let matrix = Matrix {
            diagonal: vec![Block::zeros(); count],
            starts: Vec::with_capacity(count + 1),
            columns: vec![],
            entries: vec![],
            pivots: vec![],
            factors: vec![],
            exact: true,
        };
        Self {
            matrix,
            counts: [0; D],
            blocks: Vec::with_capacity(count),
            heads: vec![],
            next: Vec::with_capacity(count),
            near: Vec::with_capacity(count),
            residual: zeros(),
            scaled: zeros(),
            direction: zeros(),
            image: zeros(),
        }
    }

    /// Write the matrix of markers that have been placed and weighed.
    pub fn assemble(&mut self, markers: &Markers<D>, grid: &Grid<D>) {
        let per_volume = 1.0 / grid.cell_volume();
        self.matrix.starts.clear();
        self.matrix.columns.clear();
        self.matrix.entries.clear();
        self.sort_into_blocks(markers, grid);
        for j in 0..markers.len() {
            self.find_near(j);
            let Matrix { diagonal, starts, columns, entries, .. } = &mut self.matrix;
            starts.push(columns.len());
            let own = markers.shared(j, j, grid).unwrap_or_default();
            diagonal[j] = markers.inverse_drag(j) + Block::from_diagonal_element(per_volume * own);
            for &k in &self.near {
                if let Some(shared) = markers.shared(j, k, grid) {
                    columns.push(k);
                    entries.push(per_volume * shared);
                }
            }
        }
        self.matrix.starts.push(self.matrix.columns.len());
        self.matrix.factorize();
    }

    fn sort_into_blocks(&mut self, markers: &Markers<D>, grid: &Grid<D>) {
        let count = markers.len();
        // A block has one grid point more than the largest distance of two kernels that share a point, or more.
        self.counts = grid.cells.map(|cells| (cells / (2 * Kernel::of(D).reach)).max(1));
        self.heads.clear();
        self.heads.resize(self.counts.iter().product(), count);
        self.blocks.clear();
        self.next.clear();
        for k in 0..count {
            let first = markers.first_point(k);
            let block = from_fn(|axis| first[axis] * self.counts[axis] / grid.cells[axis]);
            let head = &mut self.heads[number(&block, &self.counts)];
            self.blocks.push(block);
            self.next.push(*head);
            *head = k;
        }
    }

    /// List the markers after `j` that may share a grid point with it, in ascending order.
    fn find_near(&mut self, j: usize) {
        self.near.clear();
        // The block itself and those on both sides; of two or one block along an axis each once.
        let around: [([usize; 3], usize); D] = from_fn(|axis| {
            let (own, count) = (self.blocks[j][axis], self.counts[axis]);
            let after = if own + 1 == count { 0 } else { own + 1 };
            let before = if own == 0 { count - 1 } else { own - 1 };
            ([own, after, before], count.min(3))
        });
        for code in 0..3_usize.pow(D as u32) {
            let (mut rest, mut twice) = (code, false);
            let block = from_fn(|axis| {
                let (blocks, count) = around[axis];
                let choice = rest % 3;
                (rest, twice) = (rest / 3, twice || choice >= count);
                blocks[choice]
            });
            let mut k = if twice { usize::MAX } else { self.heads[number(&block, &self.counts)] };
            while k < self.next.len() {
                if k > j {
                    self.near.push(k);
                }
                k = self.next[k];
            }
        }
        self.near.sort_unstable();
    }

    /// Solve for a right-hand side; return whether the solution was found.
    pub fn solve(&mut self, right_side: &[Vector<D>], solution: &mut [Vector<D>]) -> bool {
        let Self { matrix, residual, scaled, direction, image, .. } = self;
        if matrix.exact {
            solution.copy_from_slice(right_side);
            matrix.divide(solution);
            return solution.iter().flatten().all(|number| number.is_finite());
        }
        solution.fill(Vector::zeros());
        residual.copy_from_slice(right_side);
        let goal = TOLERANCE * TOLERANCE * dot(right_side, right_side);
        let mut before = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            if dot(residual, residual) <= goal {
                return true;
            }
            scaled.copy_from_slice(residual);
            matrix.divide(scaled);
            let product = dot(residual, scaled);
            let keep = product / before;
            before = product;
            for (p, z) in direction.iter_mut().zip(&*scaled) {
                *p = z + if keep > 0.0 { *p * keep } else { Vector::zeros() };
            }
            matrix.multiply(direction, image);
            let length = product / dot(direction, image);
            if !length.is_finite() {
                break;
            }
            solution.iter_mut().zip(&*direction).for_each(|(x, p)| *x += p * length);
            residual.iter_mut().zip(&*image).for_each(|(r, q)| *r -= q * length);
        }
        false
    }
}

/// Return the number of a block.
fn number<const D: usize>(block: &[usize; D], blocks: &[usize; D]) -> usize {
    block.iter().zip(blocks).fold(0, |number, (block, blocks)| number * blocks + block)
}

fn dot<const D: usize>(a: &[Vector<D>], b: &[Vector<D>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thin::slip::Slip;

    /// Count the pairs in the matrix of scattered markers on some cells, and all that share a point.
    fn pairs<const D: usize>(cells: [usize; D]) -> [usize; 2] {
        let grid = Grid::new(cells.map(|cells| [0.0, cells as f64]), cells);
        let mut markers = Markers::default();
        for k in 0..60 {
            markers.add(1.0, 1.0, 1.0, Slip::default(), []);
            let along = |axis: usize| 0.618 * f64::from(k * k + 1) * (1.0 + axis as f64).sqrt();
            markers.get_mut(k as usize).position = Vector::from_fn(|axis, _| along(axis) % cells[axis] as f64);
        }
        markers.find_cells(&grid);
        markers.weigh(|_| 1.0);
        let mut system = System::new(60);
        system.assemble(&markers, &grid);
        let all = (0..60).flat_map(|j| (j + 1..60).map(move |k| (j, k)));
        let shared: Vec<_> = all.filter(|&(j, k)| markers.shared(j, k, &grid).is_some()).collect();
        let Matrix { starts, columns, .. } = &system.matrix;
        let rows = (0..60).flat_map(|j| columns[starts[j]..starts[j + 1]].iter().map(move |k| (j, *k)));
        assert!(rows.eq(shared.iter().copied()), "{cells:?}");
        [shared.len(), 60 * 59 / 2]
    }

    #[test]
    fn the_matrix_has_every_pair_that_shares_a_grid_point() {
        for [shared, all] in [pairs([12, 8, 23]), pairs([31, 40, 16]), pairs([50, 61]), pairs([9, 14])] {
            assert!(shared > 20 && shared < all, "{shared} of {all}");
        }
    }

    /// Return the largest error of the solution for markers at some places, and whether the factor is the whole one.
    fn error(places: &[[f64; 2]]) -> (f64, bool) {
        let grid = Grid::new([[0.0, 40.0], [0.0, 30.0]], [40, 30]);
        let mut markers = Markers::default();
        for (k, place) in places.iter().enumerate() {
            let angle = k as f64;
            let axis = Vector::from([angle.cos(), angle.sin()]);
            markers.add(1.5, 1.5, 1e-5, Slip::along(0.1, 1.0, 3.0, 1.5), []);
            (markers.get_mut(k).position, markers.get_mut(k).along) = (Vector::from(*place), axis * axis.transpose());
        }
        markers.find_cells(&grid);
        markers.weigh(|point| 1.0 + 0.5 * (point as f64).sin());
        let mut system = System::new(places.len());
        system.assemble(&markers, &grid);
        let known: Vec<_> =
            (0..places.len()).map(|k| Vector::from([1.3 * k as f64, 0.7 * k as f64].map(f64::cos))).collect();
        let (mut right_side, mut solution) = (known.clone(), known.clone());
        system.matrix.multiply(&known, &mut right_side);
        assert!(system.solve(&right_side, &mut solution));
        let error = known.iter().zip(&solution).fold(0.0_f64, |most, (a, b)| most.max((a - b).amax()));
        (error, system.matrix.exact)
    }

    /// A factor that leaves something out is not taken for a whole one.
    #[test]
    fn straight_lines_need_no_iteration_and_others_find_the_solution_too() {
        for angle in [0.0, 0.3, 0.785, 1.2, 2.0] {
            let line: Vec<_> = (0..16)
                .map(|k| [f64::cos(angle), f64::sin(angle)].map(|part| 15.2 + 1.5 * f64::from(k) * part))
                .collect();
            let (off, exact) = error(&line);
            assert!(exact && off < 1e-12, "{angle}: {off}");
        }
        let hairpin: Vec<_> = (0..16).map(|k| [10.3 + 1.5 * f64::from(k % 8), 12.1 + 2.0 * f64::from(k / 8)]).collect();
        let (off, exact) = error(&hairpin);
        assert!(!exact && off < 1e-9, "{off}");
    }
}
