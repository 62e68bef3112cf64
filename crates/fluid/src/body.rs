//! A body as the cells in which it drags the fluid, and the force that this costs.

/// One cell of a body.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Index of the grid point.
    pub index: usize,
    /// Drag rate a of this body there, 1/s.
    pub rate: f64,
    /// Velocity of the body there, m/s.
    pub velocity: [f64; 2],
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
    pub fn add(&mut self, cells: &[Cell], rate: &mut [f64]) {
        for cell in cells {
            self.before.push((cell.index, rate[cell.index]));
            rate[cell.index] += cell.rate;
        }
    }
}
