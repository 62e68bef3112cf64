//! The small system of the forces on the markers, and its solution by conjugate gradients.

use super::markers::Markers;
use crate::grid::Grid;

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
        for j in 0..markers.len() {
            self.starts.push(self.columns.len());
            let own = markers.shared(j, j, grid).unwrap_or_default();
            self.diagonal[j] = markers.inverse_drag(j) + per_volume * own;
            for k in j + 1..markers.len() {
                if let Some(shared) = markers.shared(j, k, grid) {
                    self.columns.push(k);
                    self.entries.push(per_volume * shared);
                }
            }
        }
        self.starts.push(self.columns.len());
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

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
