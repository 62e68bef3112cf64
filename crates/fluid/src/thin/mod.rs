//! Thin bodies: the drag of lines of markers, solved exactly within the local solve of a step.
//!
//! A marker k at X_k stands for a part of a line of the length l_k (in space: of a surface of that area). With
//! interpolation E_k by a smooth kernel and its transpose, the drag on the fluid is `−Σ_k f_k δ_h(x − X_k)` with
//! `f_k = kappa l_k (E_k u* − U_k)`, the force on the part over the density. It is symmetric and monotone like the drag
//! of a mask, so the splitting of the step holds as it is. With `C = c_0 + Σ a` of the masks the local solve becomes
//!
//! ```text
//! (1/(kappa l) + E C⁻¹ Eᵗ/V) f = E C⁻¹ (r + Σ a u_b) − U,      u* = C⁻¹ (r + Σ a u_b − Eᵗ f/V)
//! ```
//!
//! with the volume V of a cell: a sparse, symmetric, positive definite system of as many rows as markers.

mod drag;
mod kernel;
mod line;
mod markers;
mod parts;
pub mod surface;
mod system;

use line_fft::Real;

use crate::bodies::{Loads, Stations};
use crate::error::Error;
use crate::field::Field;
use crate::force::{Displaced, Force};
use crate::grid::Grid;
use crate::parameters::{Parameters, Surface};

pub use drag::MarkerDrag;
pub use kernel::{LINE_THICKNESS_CELLS, ROD_SECTION_CELLS};
use line::Line;
pub use markers::Markers;
pub use parts::Parts;

/// The thin bodies of a fluid.
#[derive(Default)]
pub struct ThinBodies {
    lines: Vec<Line>,
    drag: MarkerDrag<2>,
    /// Density of the fluid, kg/m³.
    density: f64,
}

/// What the fluid exerted on a line in the last solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct LineForce {
    /// Force and moment about the root or the pivot.
    pub force: Force,
    /// Power of the force, W per metre of depth.
    pub power: f64,
}

impl ThinBodies {
    /// The thin bodies among rigid bodies and beams, not yet at a place.
    pub fn new(parameters: &Parameters, grid: &Grid) -> Self {
        let (mut lines, mut markers) = (Vec::new(), Markers::default());
        let (c_eta, cell) = (parameters.mask.c_eta(), grid.cell_size());
        for (k, beam) in parameters.beams.iter().enumerate().filter(|(_, beam)| beam.surface == Surface::Line) {
            let free = [beam.support_cylinder.is_none(), true];
            lines.push(Line::new(k, &beam.stations, free, c_eta, cell, &mut markers));
        }
        Self { lines, drag: MarkerDrag::new(markers), density: parameters.density }
    }

    /// Return whether there is none.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Move the lines to the stations of the beams.
    pub fn place(&mut self, stations: &[Stations], grid: &Grid) {
        let markers = &mut self.drag.markers;
        self.lines.iter().for_each(|line| line.place(&stations[line.beam], markers));
        markers.find_cells(grid);
    }

    /// Take the drag into the local solve; see [`MarkerDrag::apply`].
    pub fn apply<R: Real>(
        &mut self,
        c_0: f64,
        rate: Option<&[f64]>,
        first: impl Fn(usize, &[Field<R>; 2]) -> [f64; 2],
        w: &mut [Field<R>; 2],
        time: f64,
        grid: &Grid,
    ) -> Result<(), Error> {
        self.drag.apply(c_0, rate, first, w, time, grid)
    }

    /// List the grid points around the markers where the drag rate of the masks (1/s) is not 0.
    pub fn list_dragged(&mut self, rate: Option<&[f64]>) {
        self.drag.list_dragged(rate);
    }

    /// Return these points, and the sums to be written there.
    pub fn dragged_mut(&mut self) -> (&[usize], &mut [[f64; 2]]) {
        self.drag.dragged_mut()
    }

    /// Write the loads on the stations of thin beams in a local solve with `right_side` at a grid point. They are not
    /// finite if no solution was found.
    pub fn predict_loads(
        &mut self,
        c_0: f64,
        rate: Option<&[f64]>,
        right_side: impl Fn(usize) -> [f64; 2],
        grid: &Grid,
        loads: &mut [Loads],
    ) {
        self.drag.predict(c_0, rate, right_side, grid);
        for line in &self.lines {
            line.collect(&self.drag.force, &self.drag.slope, self.density, &mut loads[line.beam]);
        }
    }

    /// Return the number of each thin beam with the forces of the last solve and the fluid in the layer that moves with
    /// it; moments are about the root at `stations`.
    pub fn forces<'a>(&'a self, stations: &'a [Stations]) -> impl Iterator<Item = (usize, LineForce, Displaced)> + 'a {
        let MarkerDrag { markers, force, .. } = &self.drag;
        self.lines.iter().map(move |line| {
            let stations = &stations[line.beam];
            let force = line.force(stations, markers, force, self.density);
            (line.beam, force, line.displaced(stations, markers, self.density))
        })
    }

    /// Write the pressure above less the pressure below each thin beam at its stations, Pa, in a step of `dt` seconds
    /// from the stations `before`; `jumps` has a list for each beam.
    pub fn write_jumps(&self, dt: f64, stations: &[Stations], before: &[Stations], jumps: &mut [Vec<f64>]) {
        for line in &self.lines {
            let beam = line.beam;
            line.write_jump(&self.drag.force, self.density, dt, &stations[beam], &before[beam], &mut jumps[beam]);
        }
    }
}
