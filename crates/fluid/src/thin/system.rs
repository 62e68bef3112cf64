//! The small system of the forces on the markers, and its solution by conjugate gradients.

use super::markers::Markers;
use crate::grid::Grid;

/// Grid points in a block along an axis, at least: one more than the distance of two kernels that share a point.
const BLOCK: usize = 4;

/// Residual over the right-hand side at which a solution is taken.
const TOLERANCE: f64 = 1e-12;

/// Most iterations. Some 15 are needed where bodies keep apart, the square root of c_0 C_eta more where they lie on
/// each other.
const MOST_ITERATIONS: usize = 2000;

/// The matrix `1/(kappa l) + E C⁻¹ Eᵗ/V` in rows, and room for its solution.
#[derive(Default)]
pub struct System {
    diagonal: Vec<f64>,
    /// Beginning of each row in `columns` and `entries`, which hold the part above the diagonal.
    starts: Vec<usize>,
    columns: Vec<usize>,
    entries: Vec<f64>,
    /// First marker in each block of grid points, and the next one in the same block after each marker; the number of
    /// markers if there is none.
    heads: Vec<usize>,
    next: Vec<usize>,
    near: Vec<usize>,
    residual: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
}

impl System {
    /// Room for a number of markers.
    pub fn new(count: usize) -> Self {
        let zeros = || vec![0.0; count];
        Self {
            diagonal: zeros(),
            residual: zeros(),
            direction: zeros(),
            image: zeros(),
            starts: Vec::with_capacity(count + 1),
            ..Self::default()
        }
    }

    /// Write the matrix of markers that have been placed and weighed.
    pub fn assemble<const D: usize>(&mut self, markers: &Markers<D>, grid: &Grid<D>) {
        let per_volume = 1.0 / grid.cell_volume();
        self.starts.clear();
        self.columns.clear();
        self.entries.clear();
        let blocks = grid.cells.map(|cells| (cells / BLOCK).max(1));
        let block = |k: usize| {
            let first = markers.first_point(k);
            std::array::from_fn(|axis| first[axis] * blocks[axis] / grid.cells[axis])
        };
        self.sort_into_blocks(markers.len(), &blocks, &block);
        for j in 0..markers.len() {
            self.starts.push(self.columns.len());
            let own = markers.shared(j, j, grid).unwrap_or_default();
            self.diagonal[j] = markers.inverse_drag(j) + per_volume * own;
            self.find_near(j, &blocks, &block);
            for &k in &self.near {
                if let Some(shared) = markers.shared(j, k, grid) {
                    self.columns.push(k);
                    self.entries.push(per_volume * shared);
                }
            }
        }
        self.starts.push(self.columns.len());
    }

    fn sort_into_blocks<const D: usize>(
        &mut self,
        count: usize,
        blocks: &[usize; D],
        block: &impl Fn(usize) -> [usize; D],
    ) {
        self.heads.clear();
        self.heads.resize(blocks.iter().product(), count);
        self.next.clear();
        for k in 0..count {
            let head = &mut self.heads[number(&block(k), blocks)];
            self.next.push(*head);
            *head = k;
        }
    }

    /// List the markers after `j` that may share a grid point with it, in ascending order.
    fn find_near<const D: usize>(&mut self, j: usize, blocks: &[usize; D], block: &impl Fn(usize) -> [usize; D]) {
        self.near.clear();
        let own = block(j);
        for mut code in 0..3_usize.pow(D as u32) {
            let mut around = own;
            let mut twice = false;
            for (around, &blocks) in around.iter_mut().zip(blocks) {
                // The blocks on both sides; of two or one block along an axis each once.
                *around = (*around + blocks + code % 3 - 1) % blocks;
                twice |= code % 3 >= blocks;
                code /= 3;
            }
            let mut k = if twice { usize::MAX } else { self.heads[number(&around, blocks)] };
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
    pub fn solve(&mut self, right_side: &[f64], solution: &mut [f64]) -> bool {
        solution.fill(0.0);
        self.residual.copy_from_slice(right_side);
        let goal = TOLERANCE * TOLERANCE * dot(right_side, right_side);
        let mut before = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            if dot(&self.residual, &self.residual) <= goal {
                return true;
            }
            let scaled = self.residual.iter().zip(&self.diagonal).map(|(r, d)| r * r / d).sum::<f64>();
            let keep = scaled / before;
            before = scaled;
            for ((p, r), d) in self.direction.iter_mut().zip(&self.residual).zip(&self.diagonal) {
                *p = r / d + if keep > 0.0 { keep * *p } else { 0.0 };
            }
            self.multiply();
            let length = scaled / dot(&self.direction, &self.image);
            if !length.is_finite() {
                break;
            }
            solution.iter_mut().zip(&self.direction).for_each(|(x, p)| *x += length * p);
            self.residual.iter_mut().zip(&self.image).for_each(|(r, q)| *r -= length * q);
        }
        false
    }

    /// Write the matrix times `direction` to `image`.
    fn multiply(&mut self) {
        let Self { diagonal, starts, columns, entries, direction, image, .. } = self;
        image.iter_mut().zip(diagonal).zip(&*direction).for_each(|((q, d), p)| *q = *d * p);
        for j in 0..direction.len() {
            let row = starts[j]..starts[j + 1];
            for (k, entry) in columns[row.clone()].iter().zip(&entries[row]) {
                image[j] += entry * direction[*k];
                image[*k] += entry * direction[j];
            }
        }
    }
}

/// Return the number of a block.
fn number<const D: usize>(block: &[usize; D], blocks: &[usize; D]) -> usize {
    block.iter().zip(blocks).fold(0, |number, (block, blocks)| number * blocks + block)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Count the pairs in the matrix of scattered markers on some cells, and all that share a point.
    fn pairs<const D: usize>(cells: [usize; D]) -> [usize; 2] {
        let grid = Grid::new(cells.map(|cells| [0.0, cells as f64]), cells);
        let mut markers = Markers::default();
        for k in 0..60 {
            markers.add(1.0, 1.0);
            let along = |axis: usize| 0.618 * f64::from(k * k + 1) * (1.0 + axis as f64).sqrt();
            markers.get_mut(k as usize).position = std::array::from_fn(|axis| along(axis) % cells[axis] as f64);
        }
        markers.find_cells(&grid);
        markers.weigh(|_| 1.0);
        let mut system = System::new(60);
        system.assemble(&markers, &grid);
        let all = (0..60).flat_map(|j| (j + 1..60).map(move |k| (j, k)));
        let shared: Vec<_> = all.filter(|&(j, k)| markers.shared(j, k, &grid).is_some()).collect();
        let rows =
            (0..60).flat_map(|j| system.columns[system.starts[j]..system.starts[j + 1]].iter().map(move |k| (j, *k)));
        assert!(rows.eq(shared.iter().copied()), "{cells:?}");
        [shared.len(), 60 * 59 / 2]
    }

    #[test]
    fn the_matrix_has_every_pair_that_shares_a_grid_point() {
        for [shared, all] in [pairs([12, 8, 23]), pairs([31, 40, 16]), pairs([50, 61]), pairs([9, 14])] {
            assert!(shared > 20 && shared < all, "{shared} of {all}");
        }
    }
}
