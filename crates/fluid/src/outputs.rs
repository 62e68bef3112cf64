//! What can be set and read of a fluid.

use std::borrow::Cow;

use crate::bodies::{Loads, Pose, Stations};
use crate::fluid::Fluid;
use crate::force::{Exchange, Force};
use crate::grid::Grid;
use crate::pressures::{PressurePlaces, Pressures};
use crate::problem::Problem;

impl Fluid {
    /// Return the grid.
    pub fn grid(&self) -> &Grid {
        &self.problem.grid
    }

    /// Return the time, s.
    pub fn time(&self) -> f64 {
        self.present.time
    }

    /// Return a velocity component (0: x, 1: y), m/s, `[nx, ny]`; in single precision a copy.
    pub fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        self.solver.velocity(axis)
    }

    /// Return the vorticity, 1/s, `[nx, ny]`; in single precision a copy.
    pub fn vorticity(&self) -> Cow<'_, [f64]> {
        self.solver.vorticity()
    }

    /// Return the static pressure p = rho (Pi − u²/2), Pa, `[nx, ny]`; Pi has zero mean over the domain. It takes three
    /// transforms.
    pub fn pressure(&mut self) -> Vec<f64> {
        let (mut pressure, points, density) = (Vec::new(), 0..self.problem.grid.len(), self.density);
        let mut read = |_: &Problem, at: &dyn Fn(usize) -> f64| {
            pressure.extend(points.clone().map(|point| density * at(point)));
        };
        self.solver.read_pressure(&self.present, &mut self.problem, &mut read);
        pressure
    }

    /// Return the velocity at a probe, numbered from 0, m/s.
    pub fn probe_velocity(&self, probe: usize) -> [f64; 2] {
        self.solver.velocity_by(&self.probes[probe].around)
    }

    /// Return the static pressure at a probe, Pa. The first pressure after a step takes three transforms.
    pub fn probe_pressure(&mut self, probe: usize) -> f64 {
        self.pressures().probes[probe]
    }

    /// Return the largest divergence of the velocity times the cell size over the largest speed. It takes three
    /// transforms.
    pub fn divergence(&mut self) -> f64 {
        let [largest, fastest] = self.solver.divergence();
        largest * self.problem.grid.cell_size() / fastest.max(f64::MIN_POSITIVE)
    }

    /// Return the CFL number max(|u|/dx + |v|/dy) dt of the last step.
    pub fn cfl(&self) -> f64 {
        self.present.cfl(self.present.step)
    }

    /// Return the flow rate through the column in the middle of the domain, m²/s.
    pub fn flow_rate(&self) -> f64 {
        let Grid { cells: [nx, ny], spacing: [_, dy], .. } = self.problem.grid;
        self.solver.sum_of_u(nx / 2 * ny..(nx / 2 + 1) * ny) * dy
    }

    /// Return the kinetic energy of the domain, J/m.
    pub fn kinetic_energy(&self) -> f64 {
        let [squares, _] = self.solver.squares();
        0.5 * self.density * squares * self.problem.grid.cell_volume()
    }

    /// Return half the integral of the squared vorticity over the domain, m²/s².
    pub fn enstrophy(&self) -> f64 {
        let [_, squares] = self.solver.squares();
        0.5 * squares * self.problem.grid.cell_volume()
    }

    /// Return the force of the fluid on all bodies in the last step, N per metre of depth.
    pub fn force(&self) -> [f64; 2] {
        let sum = |axis: usize| self.present.bodies.iter().map(|body| body.force.force[axis]).sum();
        [sum(0), sum(1)]
    }

    /// Return the force of the fluid on a cylinder, numbered from 0, in the last step.
    pub fn force_on_cylinder(&self, cylinder: usize) -> Force {
        let count = self.problem.bodies.cylinders();
        assert!(cylinder < count, "there are {count} cylinders");
        self.present.bodies[cylinder].force
    }

    /// Return the force of the fluid on a rigid body that is not a cylinder, numbered from 0, in the last step.
    pub fn force_on_body(&self, body: usize) -> Force {
        self.present.bodies[self.rigid(body)].force
    }

    /// Return the power of [`Self::force_on_body`] at the end of the step, W per metre of depth.
    pub fn power_on_body(&self, body: usize) -> f64 {
        let rigid = self.rigid(body);
        self.problem.bodies.power(rigid, &self.present.bodies[rigid].force)
    }

    /// Return place and motion of a rigid body that is not a cylinder, numbered from 0.
    pub fn pose(&self, body: usize) -> Pose {
        self.problem.bodies.pose(self.rigid(body))
    }

    /// Return the displacement of a body, numbered from 0, at the end of the coming step, to be set before
    /// [`Self::advance`]; only for a body that the master moves.
    ///
    /// # Panics
    /// For a body that moves otherwise.
    pub fn displacement_mut(&mut self, body: usize) -> &mut Pose {
        let rigid = self.rigid(body);
        let place = self.problem.bodies.carried().position(|(own, on_springs)| own == rigid && !on_springs);
        &mut self.motion.displaced_to[place.expect("the master moves the body")]
    }

    /// Return the displacements of the bodies that laws do not move at the end of the coming step.
    pub fn displacements(&self) -> &[Pose] {
        &self.motion.displaced_to
    }

    /// Return the same, to be set.
    pub fn displacements_mut(&mut self) -> &mut [Pose] {
        &mut self.motion.displaced_to
    }

    /// Return the number of a body among all rigid ones; the cylinders are the first.
    fn rigid(&self, body: usize) -> usize {
        let (cylinders, all) = (self.problem.bodies.cylinders(), self.problem.bodies.rigid());
        assert!(body < all - cylinders, "there are {} bodies", all - cylinders);
        cylinders + body
    }

    /// Return the force of the fluid on a beam, numbered from 0, in the last step.
    pub fn force_on_beam(&self, beam: usize) -> Force {
        self.present.bodies[self.problem.bodies.rigid() + beam].force
    }

    /// Return force, power and work of the drag on each beam, without the unsteady term of [`Self::force_on_beam`].
    pub fn exchange(&self) -> &[Exchange] {
        &self.present.beams.exchange
    }

    /// Return the loads on the stations of each beam for the coming step; empty if none are predicted.
    pub fn loads(&self) -> &[Loads] {
        &self.present.beams.loads
    }

    /// Return the stations of each beam at the end of the coming step.
    pub fn stations(&self) -> &[Stations] {
        &self.motion.target
    }

    /// Return the stations of each beam at the end of the coming step, to be set before [`Self::advance`].
    pub fn stations_mut(&mut self) -> &mut [Stations] {
        &mut self.motion.target
    }

    /// Return the pressure above less the pressure below the stations of each beam, Pa. The first pressure after a step
    /// takes three transforms.
    pub fn pressure_jump(&mut self) -> &[Vec<f64>] {
        &self.pressures().jump
    }

    /// Return the shear stress on both faces together of each beam that is a line, towards its tip at its stations, Pa;
    /// of another beam nothing.
    pub fn shear(&self) -> &[Vec<f64>] {
        &self.present.beams.line_shear
    }

    /// Return the mean of the pressures above and below the stations of each beam, less the mean over the outlet, Pa;
    /// empty if not wanted. The first pressure after a step takes three transforms.
    pub fn pressure_around(&mut self) -> &[Vec<f64>] {
        &self.pressures().around
    }

    fn pressures(&mut self) -> &Pressures {
        let Self { problem, present, solver, density, probes, outlet, pressures, .. } = self;
        pressures.get(|pressures| {
            solver.read_pressure(present, problem, &mut |problem, at| {
                let (grid, bodies, stations) = (&problem.grid, &problem.bodies, &present.beams.stations);
                let outlet = outlet.as_ref();
                let line_jump = &present.beams.line_jump;
                let density = *density;
                PressurePlaces { grid, density, probes, outlet, bodies, stations, line_jump }.read(at, pressures);
            });
        })
    }

    /// Return the timer of the phases of a step.
    #[cfg(feature = "internals")]
    pub fn timer(&mut self) -> &mut crate::timer::PhaseTimer {
        &mut self.problem.timer
    }
}
