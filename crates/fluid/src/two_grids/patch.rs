//! The pressure of the exchanged force in the fine box, on its coarse cells.

use line_fft::{Real, ThreadTeam, nothing};

use crate::field::Field;
use crate::filter::Damping;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::space::Space;
use crate::spectral::{Implicit, Transforms};
use crate::timer::PhaseTimer;
use method::Filter;

/// The periodic box of coarse cells under the fine box.
pub struct Patch<R: Real, T, const D: usize>
where
    [f64; D]: Space<D>,
{
    transforms: T,
    /// Force on its cells, over the density, m/s².
    force: [Field<R>; D],
    /// The part of the force without divergence, in place of a velocity.
    without_gradient: Flow<R, D>,
    pressure: Field<R>,
}

impl<R: Real, T: Transforms<R, D>, const D: usize> Patch<R, T, D>
where
    [f64; D]: Space<D>,
{
    /// A patch with so many cells of a grid, without a force.
    pub fn new(coarse: &Grid<D>, cells: [usize; D]) -> Self {
        let size = std::array::from_fn(|axis| [0.0, cells[axis] as f64 * coarse.spacing[axis]]);
        let grid = Grid::new(size, cells);
        let points = grid.len();
        Self {
            transforms: T::new(&grid, Damping::Of(Filter::None), 1),
            force: [(); D].map(|()| Field::uniform(R::zero(), points)),
            without_gradient: Flow::uniform([0.0; D], points),
            pressure: Field::uniform(R::zero(), points),
        }
    }

    /// Remove the force.
    pub fn clear(&mut self) {
        self.force.iter_mut().for_each(|force| force.fill(R::zero()));
    }

    /// Add to a component of the force at a point.
    pub fn add(&mut self, axis: usize, point: usize, part: f64) {
        self.force[axis][point] = R::rounded(self.force[axis][point].to_f64() + part);
    }

    /// Find the gradient of the pressure of the force.
    pub fn solve(&mut self) {
        let implicit = Implicit { tau_nu: f64::MIN_POSITIVE, cfl: 0.0, mean: None, limit: f64::INFINITY };
        let Self { transforms, force, without_gradient, .. } = self;
        let timer = &mut PhaseTimer::default();
        transforms.solve(&ThreadTeam::alone(), &implicit, force, without_gradient, timer, nothing);
    }

    /// Return a component of the gradient at a point, m/s².
    pub fn gradient(&self, axis: usize, point: usize) -> f64 {
        self.force[axis][point].to_f64() - self.without_gradient.velocity[axis][point].to_f64()
    }

    /// Return the pressure of the force over the density, m²/s².
    pub fn pressure(&mut self) -> &[R] {
        self.transforms.pressure(&self.force, 1.0, 0.0, &mut self.pressure);
        &self.pressure
    }
}
