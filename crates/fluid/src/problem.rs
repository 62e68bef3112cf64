//! What a step of any precision and scheme works with: grid, fluid, zones and bodies.

use std::mem::take;

use line_fft::Real;

use crate::bodies::{Bodies, Carried, Cell, Loads, Pose, Stations};
use crate::error::Error;
use crate::field::Field;
use crate::force::{BodyForce, Exchange};
use crate::grid::Grid;
use crate::parameters::{Law, Parameters};
use crate::present::Present;
use crate::thin::{LineForce, ThinBodies};
use crate::timer::PhaseTimer;
use crate::zone::DrivingZone;

/// The domain with the bodies in it.
pub struct Problem {
    /// The grid.
    pub grid: Grid,
    /// Kinematic viscosity, m²/s.
    pub nu: f64,
    /// Walls, zones, rigid bodies and beams as drag.
    pub bodies: Bodies,
    /// Bodies that are lines.
    pub thin: ThinBodies,
    /// Times of the phases of a step.
    pub timer: PhaseTimer,
    /// Inflow and sponge.
    zones: Vec<DrivingZone>,
    /// Prescribed mean velocity; absent: free.
    mean_flow: Option<[Law; 2]>,
}

impl Problem {
    /// The domain at t = 0.
    pub fn new(parameters: &Parameters) -> Self {
        let grid = Grid::new(parameters.domain, parameters.cells);
        let Parameters { inflow, sponge, mask, kinematic_viscosity: nu, channel, .. } = parameters;
        let zones = DrivingZone::all([inflow, sponge], mask, *nu, *channel, &grid);
        Self {
            nu: parameters.kinematic_viscosity,
            bodies: Bodies::new(parameters, &zones, &grid),
            thin: ThinBodies::new(parameters, &grid),
            timer: PhaseTimer::default(),
            mean_flow: parameters.mean_flow.clone(),
            zones,
            grid,
        }
    }

    /// Put all bodies to their places at a time (s), the beams moving from the stations `before` to `stations`.
    /// `displaced` has the poses of bodies that are carried.
    pub fn place(&mut self, time: f64, displaced: &[Pose], stations: &[Stations], before: &[Stations]) {
        self.bodies.place(time, displaced, stations, before, &self.grid);
        self.place_thin(stations);
    }

    /// Put the thin bodies to `stations`.
    pub fn place_thin(&mut self, stations: &[Stations]) {
        self.thin.place(stations, &self.bodies, &self.grid);
    }

    /// Return the prescribed mean velocity at a time (s), m/s; none if it is free.
    pub fn mean_velocity(&self, time: f64) -> Option<[f64; 2]> {
        self.mean_flow.as_ref().map(|laws| laws.each_ref().map(|law| law.value(time)))
    }

    /// Add `weight(Σ a) a_b u_b` of all zones and bodies at a time (s) to `w`.
    pub fn add_velocities<R: Real>(&self, time: f64, weight: impl Fn(f64) -> f64, w: &mut [Field<R>; 2]) {
        let Some(rate) = self.bodies.rate() else { return };
        let rows = self.grid.cells[1];
        for DrivingZone { mean_velocity, columns, shape } in &self.zones {
            let mean = mean_velocity.value(time);
            for &(i, zone) in columns {
                let column = i * rows..(i + 1) * rows;
                let (wx, rate) = (&mut w[0][column.clone()], &rate[column]);
                for ((wx, rate), shape) in wx.iter_mut().zip(rate).zip(shape) {
                    *wx = R::rounded(wx.to_f64() + weight(*rate) * zone * mean * shape);
                }
            }
        }
        self.bodies.add_velocities(weight, w);
    }

    /// Add `Σ a_b u_b` of all zones and bodies at a time (s) to `sums` at some points in ascending order.
    fn add_velocities_at(&self, time: f64, points: &[usize], sums: &mut [[f64; 2]]) {
        if points.is_empty() {
            return;
        }
        let rows = self.grid.cells[1];
        for DrivingZone { mean_velocity, columns, shape } in &self.zones {
            let mean = mean_velocity.value(time);
            for (sum, point) in sums.iter_mut().zip(points) {
                if let Ok(column) = columns.binary_search_by_key(&(point / rows), |(i, _)| *i) {
                    sum[0] += columns[column].1 * mean * shape[point % rows];
                }
            }
        }
        self.bodies.add_velocities_at(points, sums);
    }

    /// Take the drag of the thin bodies, with beams at `stations`, at a time (s) into `w`. `c` are the coefficients of the
    /// backward differences; `u_star(axis, point, w)` is the velocity of the local solve without them at a grid point.
    pub fn solve_on_lines<R: Real>(
        &mut self,
        c: [f64; 3],
        carried: &[Carried],
        time: f64,
        stations: &[Stations],
        u_star: impl Fn(usize, usize, f64) -> f64,
        w: &mut [Field<R>; 2],
    ) -> Result<(), Error> {
        if self.thin.is_empty() {
            return Ok(());
        }
        self.place_thin(stations);
        let first = |point: usize, w: &[Field<R>; 2]| [0, 1].map(|axis| u_star(axis, point, w[axis][point].to_f64()));
        let found = self.thin.apply(c, carried, &mut self.bodies, first, w, &self.grid);
        if found { Ok(()) } else { Err(Error::Markers { time }) }
    }

    /// Write the loads on the thin beams in the local solve of a coming step to `time` (s), with `right_side` at a grid
    /// point and the coefficient `c_0` (1/s) of the difference in time.
    pub fn predict_loads_on_lines(
        &mut self,
        c_0: f64,
        time: f64,
        right_side: impl Fn(usize) -> [f64; 2],
        loads: &mut [Loads],
    ) {
        if self.thin.is_empty() {
            return;
        }
        let mut thin = take(&mut self.thin);
        let rate = self.bodies.rate();
        thin.list_dragged(rate);
        let (points, sums) = thin.dragged_mut();
        self.add_velocities_at(time, points, sums);
        thin.predict_loads(c_0, rate, right_side, &self.grid, loads);
        self.thin = thin;
    }

    /// Return the displaced fluid of all bodies, the rigid ones first, without a force.
    pub fn without_force(&self, stations: &[Stations]) -> Vec<BodyForce> {
        let mut forces = self.bodies.without_force(stations);
        for (beam, _, displaced) in self.thin.forces(stations) {
            forces[self.bodies.rigid() + beam].displaced = displaced;
        }
        forces
    }

    /// Sum up the forces of a step of size `dt` (s); `drag` is that of the masks, see [`Bodies::sum_up_forces`].
    pub fn sum_up_forces(
        &self,
        dt: f64,
        drag: impl Fn(&Cell) -> [f64; 2],
        stations: &[Stations],
        present: &mut Present,
    ) {
        let (forces, exchange) = (&mut present.bodies, &mut present.beams.exchange);
        self.bodies.sum_up_forces(dt, drag, stations, forces, exchange);
        for (beam, LineForce { force, power }, displaced) in self.thin.forces(stations) {
            exchange[beam] = Exchange { force: force.force, power, work: exchange[beam].work + power * dt };
            forces[self.bodies.rigid() + beam].update(force, displaced, dt);
        }
        for (rigid, own) in self.thin.forces_on_rigid() {
            forces[rigid].force.add(own.force, [0.0; 2]);
            forces[rigid].force.moment += own.moment;
        }
        let beams = &mut present.beams;
        let stresses = [&mut *beams.line_jump, &mut *beams.line_shear];
        self.thin.write_stresses(dt, stations, &beams.stations, stresses);
    }
}
