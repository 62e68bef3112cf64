//! A body as the cells in which it drags the fluid, and the force that this costs.

use crate::grid::Grid;

/// One cell of a body.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Index of the grid point.
    pub index: usize,
    /// Drag rate a of this body there, 1/s.
    pub rate: f64,
    /// Velocity that the body draws the fluid to, m/s.
    pub velocity: [f64; 2],
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
    pub fn push(&mut self, index: usize, rate: f64, velocity: [f64; 2]) {
        self.cells.push(Cell { index, rate, velocity, gain: 1.0 });
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
