//! The outlet, the reference of the pressure around beams.

use crate::grid::Grid;
use crate::parameters::Parameters;

/// Distances from the inflow zone of the two columns from which the pressure is extrapolated to the outlet, cells. In
/// the zone the pressure rises again, and the kink is smeared over the edge of the zone.
const COLUMNS_BEFORE: [f64; 2] = [8.0, 4.0];

/// The upstream end of the inflow zone, across the channel.
pub struct Outlet {
    /// Columns and their weights: a straight line through both.
    columns: [(usize, f64); 2],
    /// Rows between the walls.
    rows: Vec<usize>,
    rows_of_grid: usize,
}

impl Outlet {
    /// Return the outlet of a domain with an inflow.
    pub fn new(parameters: &Parameters, grid: &Grid) -> Option<Self> {
        let end = parameters.inflow.as_ref()?.x[0];
        let position = (end - grid.coordinate(0, 0)) / grid.spacing[0];
        let [far, near] = COLUMNS_BEFORE.map(|before| (position - before).floor());
        let weight = (position - far) / (near - far);
        let index = |column: f64| column.rem_euclid(grid.cells[0] as f64) as usize;
        let is_open =
            |j: &usize| parameters.channel.is_none_or(|[low, high]| (low..high).contains(&grid.coordinate(1, *j)));
        Some(Self {
            columns: [(index(far), 1.0 - weight), (index(near), weight)],
            rows: (0..grid.cells[1]).filter(is_open).collect(),
            rows_of_grid: grid.cells[1],
        })
    }

    /// Return the mean over the outlet of a quantity, given at a grid point.
    pub fn mean(&self, at: impl Fn(usize) -> f64) -> f64 {
        let rows = self.rows.len() as f64;
        let column = |i: usize| self.rows.iter().map(|j| at(i * self.rows_of_grid + j)).sum::<f64>() / rows;
        self.columns.iter().map(|&(i, weight)| weight * column(i)).sum()
    }
}
