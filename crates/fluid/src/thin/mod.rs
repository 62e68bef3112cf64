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
pub mod kernel;
mod line;
mod markers;
mod parts;
mod rigid;
pub mod surface;
mod system;

use line_fft::Real;

use crate::bodies::{Bodies, Carried, Loads, Stations};
use crate::field::Field;
use crate::force::{Displaced, Force};
use crate::grid::Grid;
use crate::parameters::{Body, Parameters, Shape, Surface};

pub use drag::MarkerDrag;
pub use kernel::{ROD_SECTION_CELLS, SURFACE_THICKNESS_CELLS};
use line::Line;
pub use markers::Markers;
pub use parts::Parts;
use rigid::{Responses, RigidLine};

/// The thin bodies of a fluid.
#[derive(Default)]
pub struct ThinBodies {
    /// Those of beams, with the number of the beam among all beams.
    lines: Vec<(usize, Line)>,
    rigid: Vec<RigidLine>,
    drag: MarkerDrag<2>,
    responses: Responses,
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
        let (mut lines, mut rigid, mut markers) = (Vec::new(), Vec::new(), Markers::default());
        let (c_eta, cell) = (parameters.mask.c_eta(), grid.cell_size());
        for (k, beam) in parameters.beams.iter().enumerate().filter(|(_, beam)| beam.surface == Surface::Line) {
            let free = [beam.support_cylinder.is_none(), true];
            lines.push((k, Line::new(&beam.stations, free, c_eta, cell, &mut markers)));
        }
        for (k, body) in (parameters.cylinders.len()..).zip(&parameters.bodies) {
            if let Body { shape: Shape::Line(points), .. } = body {
                let line = Line::new(points, [true; 2], c_eta, cell, &mut markers);
                rigid.push(RigidLine::new(k, body, points, line));
            }
        }
        let responses = std::array::from_fn(|_| vec![0.0; markers.len()]);
        Self { lines, rigid, drag: MarkerDrag::new(markers), responses, density: parameters.density }
    }

    /// Return whether there is none.
    pub fn is_empty(&self) -> bool {
        self.drag.markers.len() == 0
    }

    /// Move the lines to the stations of the beams and to the places of the bodies.
    pub fn place(&mut self, stations: &[Stations], bodies: &Bodies, grid: &Grid) {
        let markers = &mut self.drag.markers;
        self.lines.iter().for_each(|(beam, line)| line.place(&stations[*beam], markers));
        self.rigid.iter_mut().for_each(|line| line.place(&bodies.pose(line.rigid), markers));
        markers.find_cells(grid);
    }

    /// Take the drag into the local solve as [`MarkerDrag::apply`] does, and let the lines on springs move. `c` are the
    /// coefficients of the backward differences. Return whether the forces were found.
    pub fn apply<R: Real>(
        &mut self,
        c: [f64; 3],
        carried: &[Carried],
        bodies: &mut Bodies,
        first: impl Fn(usize, &[Field<R>; 2]) -> [f64; 2],
        w: &mut [Field<R>; 2],
        grid: &Grid,
    ) -> bool {
        let found =
            self.drag.solve(c[0], bodies.rate(), |point| first(point, w), grid) && self.release(c, carried, bodies);
        if found {
            self.drag.spread(w, grid);
        }
        found
    }

    /// Find the velocities of the lines on springs together with the forces.
    fn release(&mut self, c: [f64; 3], carried: &[Carried], bodies: &mut Bodies) -> bool {
        for line in &self.rigid {
            if !bodies.is_on_springs(line.rigid) {
                continue;
            }
            for (axis, response) in [None, Some(0), Some(1)].into_iter().zip(&mut self.responses) {
                if !self.drag.respond(|k, markers| line.arm(axis, k, markers), response) {
                    return false;
                }
            }
            let MarkerDrag { markers, force, .. } = &mut self.drag;
            let drag = line.drag(markers, force, &self.responses, self.density);
            if let Some(change) = bodies.release_line(line.rigid, c, carried, &drag) {
                line.change(change, &self.responses, markers, force);
            }
        }
        true
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
        for (beam, line) in &self.lines {
            line.collect(&self.drag.force, &self.drag.slope, self.density, &mut loads[*beam]);
        }
    }

    /// Return the number of each thin beam with the forces of the last solve and the fluid in the layer that moves with
    /// it; moments are about the root at `stations`.
    pub fn forces<'a>(&'a self, stations: &'a [Stations]) -> impl Iterator<Item = (usize, LineForce, Displaced)> + 'a {
        let MarkerDrag { markers, force, .. } = &self.drag;
        self.lines.iter().map(move |(beam, line)| {
            let stations = &stations[*beam];
            let root = stations.position.each_ref().map(|position| position[0]);
            let (force, power) = line.force(root, markers, force, self.density);
            (*beam, LineForce { force, power }, line.displaced(stations, markers, self.density))
        })
    }

    /// Return the number of each rigid line among all rigid bodies with the force on it in the last solve.
    pub fn forces_on_rigid(&self) -> impl Iterator<Item = (usize, Force)> + '_ {
        let MarkerDrag { markers, force, .. } = &self.drag;
        self.rigid.iter().map(move |line| (line.rigid, line.force(markers, force, self.density)))
    }

    /// Write the pressure jumps and the shear stresses of each thin beam at its stations, Pa, in a step of `dt` seconds
    /// from the stations `before`; both have a list for each beam.
    pub fn write_stresses(
        &self,
        dt: f64,
        stations: &[Stations],
        before: &[Stations],
        [jumps, shears]: [&mut [Vec<f64>]; 2],
    ) {
        for (beam, line) in &self.lines {
            let (beam, stresses) = (*beam, [&mut *jumps[*beam], &mut *shears[*beam]]);
            line.write_stresses(&self.drag.force, self.density, dt, &stations[beam], &before[beam], stresses);
        }
    }
}
