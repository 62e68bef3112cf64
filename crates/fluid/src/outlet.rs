//! The outlet, where the level of the pressure is 0.

use crate::grid::Grid;

/// How many cells before the inflow zone the two columns lie whose pressure is carried on to the outlet: in the zone it rises
/// again, and the kink is smeared over the zone's edge.
const BEFORE: [f64; 2] = [8.0, 4.0];

/// The upstream end of the inflow zone, across the channel.
pub struct Outlet {
    /// Columns and their shares: the straight line through both.
    columns: [(usize, f64); 2],
    /// Rows between the walls.
    rows: Vec<usize>,
    ny: usize,
}

impl Outlet {
    /// That of a scene with an inflow.
    pub fn of(fluid: &scene::Fluid, grid: &Grid) -> Option<Self> {
        let end = fluid.inflow.as_ref()?.x[0];
        let column = |before: f64| ((end - grid.x(0)) / grid.dx - before).floor();
        let [far, near] = BEFORE.map(column);
        let share = ((end - grid.x(0)) / grid.dx - far) / (near - far);
        let index = |column: f64| column.rem_euclid(grid.nx as f64) as usize;
        let open =
            |j: &usize| fluid.channel.as_ref().is_none_or(|channel| (channel.y[0]..channel.y[1]).contains(&grid.y(*j)));
        Some(Self {
            columns: [(index(far), 1.0 - share), (index(near), share)],
            rows: (0..grid.ny).filter(open).collect(),
            ny: grid.ny,
        })
    }

    /// The mean over it of what `at` gives at a grid point.
    pub fn mean(&self, at: impl Fn(usize) -> f64) -> f64 {
        let column = |i: usize| self.rows.iter().map(|j| at(i * self.ny + j)).sum::<f64>() / self.rows.len() as f64;
        self.columns.iter().map(|&(i, share)| share * column(i)).sum()
    }
}
