//! The outlet, the reference of the pressure around beams.

use crate::grid::Grid;
use crate::parameters::Parameters;
use crate::space::Space;

/// Distances from the inflow zone of the two columns from which the pressure is extrapolated to the outlet, cells. In
/// the zone the pressure rises again, and the kink is smeared over the edge of the zone.
const COLUMNS_BEFORE: [f64; 2] = [8.0, 4.0];

/// The upstream end of the inflow zone, across the channel.
pub struct Outlet {
    /// Planes across x, columns of the grid in the plane, and their weights: a straight line through both.
    columns: [(usize, f64); 2],
    /// Points of a plane between the walls.
    points: Vec<usize>,
    points_of_plane: usize,
}

impl Outlet {
    /// Return the outlet of a domain with an inflow.
    pub fn new<const D: usize>(parameters: &Parameters<D>, grid: &Grid<D>) -> Option<Self>
    where
        [f64; D]: Space<D>,
    {
        let end = parameters.inflow.as_ref()?.x[0];
        let position = (end - grid.coordinate(0, 0)) / grid.spacing[0];
        let [far, near] = COLUMNS_BEFORE.map(|before| (position - before).floor());
        let weight = (position - far) / (near - far);
        let index = |column: f64| column.rem_euclid(grid.cells[0] as f64) as usize;
        let is_open = |point: &usize| {
            let place = grid.point(*point);
            let mut pairs = parameters.walls.iter().zip(place).skip(1);
            pairs.all(|(walls, at)| walls.is_none_or(|[low, high]| (low..high).contains(&at)))
        };
        let points_of_plane = grid.len() / grid.cells[0];
        Some(Self {
            columns: [(index(far), 1.0 - weight), (index(near), weight)],
            points: (0..points_of_plane).filter(is_open).collect(),
            points_of_plane,
        })
    }

    /// Return the mean over the outlet of a quantity, given at a grid point.
    pub fn mean(&self, at: impl Fn(usize) -> f64) -> f64 {
        let points = self.points.len() as f64;
        let column = |i: usize| self.points.iter().map(|j| at(i * self.points_of_plane + j)).sum::<f64>() / points;
        self.columns.iter().map(|&(i, weight)| weight * column(i)).sum()
    }
}
