//! A body as the cells in which it drags the fluid, and the force that this costs.

use serde::{Deserialize, Serialize};

use crate::grid::Grid;
use crate::solver::Force;

/// One cell of a body.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Index of the grid point.
    pub index: usize,
    /// Drag rate a of this body there, 1/s.
    pub rate: f64,
    /// Velocity that the body draws the fluid to, m/s.
    pub velocity: [f64; 2],
    /// Its position from the point that the body's moment is taken about, m.
    pub arm: [f64; 2],
    /// How fast that velocity changes with the body's own there: 1, and more where the body reflects.
    pub gain: f64,
}

/// A cell whose body draws the fluid to the mirror image of the flow outside.
#[derive(Clone, Copy, Debug)]
struct Mirror {
    /// Which of the cells.
    cell: usize,
    /// Velocity of the body there, m/s.
    velocity: [f64; 2],
    /// Weight of the mirror image.
    weight: f64,
    /// Grid points around the mirror image and their shares.
    around: [(usize, f64); 4],
}

/// The cells of a body.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    cells: Vec<Cell>,
    mirrors: Vec<Mirror>,
}

impl Cells {
    /// Forget all.
    pub fn clear(&mut self) {
        self.cells.clear();
        self.mirrors.clear();
    }

    /// Add a cell that moves with the body.
    pub fn push(&mut self, index: usize, rate: f64, velocity: [f64; 2], arm: [f64; 2]) {
        self.cells.push(Cell { index, rate, velocity, arm, gain: 1.0 });
    }

    /// Let the cell added last reflect the flow at the point `image` (m) with a weight, if that is above 0.
    pub fn reflect_last(&mut self, weight: f64, image: [f64; 2], grid: &Grid) {
        let Some(cell) = self.cells.last_mut().filter(|_| weight > 0.0) else { return };
        cell.gain += weight;
        let (cell, velocity) = (self.cells.len() - 1, self.cells[self.cells.len() - 1].velocity);
        self.mirrors.push(Mirror { cell, velocity, weight, around: grid.interpolation(image) });
    }

    /// Look at the flow outside anew: `u_b − weight (u(mirror) − u_b)`.
    pub fn reflect(&mut self, flow: &[Vec<f64>; 2]) {
        for mirror in &self.mirrors {
            for (axis, flow) in flow.iter().enumerate() {
                let body = mirror.velocity[axis];
                let image: f64 = mirror.around.iter().map(|&(point, share)| share * flow[point]).sum();
                self.cells[mirror.cell].velocity[axis] = body - mirror.weight * (image - body);
            }
        }
    }

    /// The cells, in the order in which they were added.
    pub fn iter(&self) -> std::slice::Iter<'_, Cell> {
        self.cells.iter()
    }

    /// Whether some of the fluid is drawn to a velocity other than 0.
    pub fn reflects(&self) -> bool {
        !self.mirrors.is_empty()
    }
}

/// Momentum that the fluid displaced by a body would have, per metre of depth.
///
/// It is taken over the true section, so that neither the mask's width nor its way through the grid enters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Displaced {
    /// Momentum, kg/s.
    pub momentum: [f64; 2],
    /// Angular momentum about the point that the body's moment is taken about, kg m/s.
    pub angular: f64,
    /// Cross product of that point's velocity and the momentum, N m/m.
    pub transport: f64,
}

impl Displaced {
    /// Its rate of change over `dt` seconds, as a force and a moment.
    pub fn rate_of_change(&self, before: &Self, dt: f64) -> Force {
        let force = [0, 1].map(|axis| (self.momentum[axis] - before.momentum[axis]) / dt);
        let moment = (self.angular - before.angular) / dt + 0.5 * (self.transport + before.transport);
        Force { force, moment }
    }
}

/// Adds the cells of moving bodies to the drag rate of the still ones, and takes them out again.
///
/// What was there is kept and put back in reverse order, so that painting leaves no rounding behind.
#[derive(Clone, Debug, Default)]
pub struct Painted {
    before: Vec<(usize, f64)>,
}

impl Painted {
    /// Take everything out of `rate` that was added since.
    pub fn erase(&mut self, rate: &mut [f64]) {
        while let Some((index, before)) = self.before.pop() {
            rate[index] = before;
        }
    }

    /// Add the cells of a body to `rate`.
    pub fn add(&mut self, cells: &Cells, rate: &mut [f64]) {
        for cell in cells.iter() {
            self.before.push((cell.index, rate[cell.index]));
            rate[cell.index] += cell.rate;
        }
    }
}
