//! Points whose velocity and pressure are outputs.

use crate::grid::Grid;

/// A point, and the grid points that its values come from.
pub struct Probe {
    /// Grid points around it and their shares: cubic interpolation along both axes, of fourth order in smooth flow. At a
    /// wall, where the pressure has a kink, it is of first order like any other that reads both sides.
    around: [(usize, f64); 16],
}

impl Probe {
    /// A probe at a point (m).
    pub fn new(position: [f64; 2], grid: &Grid) -> Self {
        Self { around: grid.cubic_interpolation(position) }
    }

    /// Value there of a field, given by its value at a grid point.
    pub fn value(&self, field: impl Fn(usize) -> f64) -> f64 {
        self.around.iter().map(|&(point, share)| share * field(point)).sum()
    }
}
