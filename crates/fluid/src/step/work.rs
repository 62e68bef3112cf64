//! Transforms, projection and work arrays of a step.

use line_fft::Real;

use crate::field::Field;
use crate::grid::Grid;
use crate::parameters::Parameters;
use crate::projection::Projection;
use crate::spectral::Spectral;

/// What a step works with in one precision. Nothing in it has a meaning between calls.
pub struct Work<R: Real> {
    /// Transforms.
    pub spectral: Spectral<R>,
    /// Viscosity, filter and projection.
    pub projection: Projection<R>,
    /// Velocity that goes into the solve wave by wave, m/s.
    pub w: [Field<R>; 2],
}

impl<R: Real> Work<R> {
    /// Plan for a grid.
    pub fn new(parameters: &Parameters, grid: &Grid) -> Self {
        let mut projection = Projection::new(grid, parameters.filter);
        let spectral = Spectral::new(grid, projection.modes(), parameters.threads);
        projection.set_gains(&spectral.gains());
        let field = || Field::uniform(R::zero(), grid.len());
        Self { spectral, projection, w: [field(), field()] }
    }
}
