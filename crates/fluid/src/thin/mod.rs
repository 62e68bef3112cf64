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

mod kernel;
mod line;
mod markers;
mod system;

use std::mem::take;

use line_fft::Real;

use crate::bodies::{Loads, Stations};
use crate::error::Error;
use crate::field::Field;
use crate::force::{Displaced, Force};
use crate::grid::Grid;
use crate::parameters::{Parameters, Surface};

use line::Line;
use markers::Markers;
use system::System;

/// The thin bodies of a fluid.
#[derive(Default)]
pub struct ThinBodies {
    lines: Vec<Line>,
    markers: Markers<2>,
    system: System,
    /// Force on each marker over the density, m³/s² per metre of depth, per axis.
    force: [Vec<f64>; 2],
    /// Decrease of that force if all markers become faster, m²/s.
    slope: Vec<f64>,
    right_side: Vec<f64>,
    /// Grid points around the markers with the drag of a mask, in ascending order, and `Σ a u_b` there, m/s².
    dragged: Vec<usize>,
    sums: Vec<[f64; 2]>,
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
        let mut thin = Self { density: parameters.density, ..Self::default() };
        let (c_eta, cell) = (parameters.mask.c_eta(), grid.cell_size());
        for (k, beam) in parameters.beams.iter().enumerate().filter(|(_, beam)| beam.surface == Surface::Line) {
            let free = [beam.support_cylinder.is_none(), true];
            thin.lines.push(Line::new(k, &beam.stations, free, c_eta, cell, &mut thin.markers));
        }
        let count = thin.markers.len();
        thin.force = [vec![0.0; count], vec![0.0; count]];
        (thin.slope, thin.right_side) = (vec![0.0; count], vec![0.0; count]);
        thin.system = System::new(count);
        thin
    }

    /// Return whether there is none.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Move the lines to the stations of the beams.
    pub fn place(&mut self, stations: &[Stations], grid: &Grid) {
        self.lines.iter().for_each(|line| line.place(&stations[line.beam], &mut self.markers));
        self.markers.find_cells(grid);
    }

    /// Solve for the forces. `first` gives the velocity of the local solve without the thin bodies at a grid point,
    /// and `rate` the drag rate of the masks (1/s); `c_0` is the coefficient of the difference in time (1/s). Return
    /// whether the solution was found.
    fn solve(&mut self, c_0: f64, rate: Option<&[f64]>, first: impl Fn(usize) -> [f64; 2], grid: &Grid) -> bool {
        self.markers.weigh(|point| 1.0 / (c_0 + rate.map_or(0.0, |rate| rate[point])));
        self.system.assemble(&self.markers, grid);
        (0..2).all(|axis| {
            self.markers.interpolate(|point| first(point)[axis], &mut self.right_side);
            let velocities = self.markers.velocities().map(|velocity| velocity[axis]);
            self.right_side.iter_mut().zip(velocities).for_each(|(flow, own)| *flow -= own);
            self.system.solve(&self.right_side, &mut self.force[axis])
        })
    }

    /// Take the drag into the local solve: `w`, which holds u* + tau G without the thin bodies, gets their part.
    /// `first` gives that u* at a grid point; see [`Self::solve`].
    pub fn apply<R: Real>(
        &mut self,
        c_0: f64,
        rate: Option<&[f64]>,
        first: impl Fn(usize, &[Field<R>; 2]) -> [f64; 2],
        w: &mut [Field<R>; 2],
        time: f64,
        grid: &Grid,
    ) -> Result<(), Error> {
        if !self.solve(c_0, rate, |point| first(point, w), grid) {
            return Err(Error::Markers { time });
        }
        let scale = 1.0 / grid.cell_volume();
        for (axis, w) in w.iter_mut().enumerate() {
            self.markers.spread(&self.force[axis], |point, weight| {
                w[point] = R::rounded(w[point].to_f64() - scale * weight);
            });
        }
        Ok(())
    }

    /// List the grid points around the markers where the drag rate of the masks (1/s) is not 0.
    pub fn list_dragged(&mut self, rate: Option<&[f64]>) {
        self.dragged.clear();
        if let Some(rate) = rate {
            self.dragged.extend(self.markers.points().iter().filter(|point| rate[**point] > 0.0));
            self.dragged.sort_unstable();
            self.dragged.dedup();
        }
        self.sums.clear();
        self.sums.resize(self.dragged.len(), [0.0; 2]);
    }

    /// Return these points, and the sums to be written there.
    pub fn dragged_mut(&mut self) -> (&[usize], &mut [[f64; 2]]) {
        (&self.dragged, &mut self.sums)
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
        let (dragged, sums) = (take(&mut self.dragged), take(&mut self.sums));
        let first = |point: usize| match dragged.binary_search(&point) {
            Ok(k) => [0, 1].map(|axis| {
                let rate = rate.map_or(0.0, |rate| rate[point]);
                (right_side(point)[axis] + sums[k][axis]) / (c_0 + rate)
            }),
            Err(_) => right_side(point).map(|r| r / c_0),
        };
        let mut found = self.solve(c_0, rate, first, grid);
        (self.dragged, self.sums) = (dragged, sums);
        self.right_side.fill(1.0);
        found &= self.system.solve(&self.right_side, &mut self.slope);
        if !found {
            self.slope.fill(f64::NAN);
        }
        for line in &self.lines {
            line.collect(&self.force, &self.slope, self.density, &mut loads[line.beam]);
        }
    }

    /// Return the number of each thin beam with the forces of the last solve and the fluid in the layer that moves with
    /// it; moments are about the root at `stations`.
    pub fn forces<'a>(&'a self, stations: &'a [Stations]) -> impl Iterator<Item = (usize, LineForce, Displaced)> + 'a {
        self.lines.iter().map(|line| {
            let stations = &stations[line.beam];
            let force = line.force(stations, &self.markers, &self.force, self.density);
            (line.beam, force, line.displaced(stations, &self.markers, self.density))
        })
    }

    /// Write the pressure above less the pressure below each thin beam at its stations, Pa, in a step of `dt` seconds
    /// from the stations `before`; `jumps` has a list for each beam.
    pub fn write_jumps(&self, dt: f64, stations: &[Stations], before: &[Stations], jumps: &mut [Vec<f64>]) {
        for line in &self.lines {
            let beam = line.beam;
            line.write_jump(&self.force, self.density, dt, &stations[beam], &before[beam], &mut jumps[beam]);
        }
    }
}
