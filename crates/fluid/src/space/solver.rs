//! The flow in space with its time scheme, in one precision behind an object.

use std::borrow::Cow;

use line_fft::{Real, Team};
use nalgebra::Vector3;

use super::flow::{ByPrecision, Flow, Stored};
use super::parameters::Parameters;
use super::problem::{Present, Problem};
use super::projection::Implicit;
use super::rigid::Cell;
use super::spectral::Spectral;
use super::step::Solver;
use crate::bodies::Stations;
use crate::error::Error;
use crate::field::Field;
use crate::parameters::Precision;
use crate::step::Differences;

/// A step of the fluid's own.
pub struct Step<'a> {
    /// Length, s.
    pub dt: f64,
    /// Time at the end, s.
    pub end: f64,
    /// Nodes of the thin bodies at the end.
    pub nodes: &'a [Stations<3>],
    /// Predicted nodes after the end, if loads are predicted after this step.
    pub ahead: Option<&'a [Stations<3>]>,
    /// Threads.
    pub team: &'a Team,
}

/// A flow that can be stepped.
pub trait FluidSolver: Send {
    /// Start from the divergence-free part of a velocity (m/s), given at a grid point, and return the advection rate,
    /// 1/s.
    fn start(&mut self, velocity: &dyn Fn(usize) -> [f64; 3], mean: Option<[f64; 3]>) -> f64;

    /// Make a step, and return the advection rate, 1/s; if it is longer than `limit` or not a number, the step is not
    /// taken, and only the bodies have changed.
    fn step(&mut self, step: &Step, limit: f64, present: &mut Present, problem: &mut Problem) -> Result<f64, Error>;

    /// Write the loads on the nodes in a coming step of the same length, with the thin bodies where they were placed
    /// ahead.
    fn predict_loads(&self, present: &mut Present, problem: &mut Problem);

    /// Make the pressure that [`Self::pressure_at`] reads until the next step, with the CFL number of the last one.
    fn make_pressure(&mut self, cfl: f64);

    /// Return the static pressure over the density at a grid point, `Pi − u²/2`, m²/s².
    fn pressure_at(&self, point: usize) -> f64;

    /// Return the largest divergence (1/s) and the largest speed (m/s).
    fn divergence(&mut self) -> [f64; 2];

    /// Return a velocity component, m/s; in single precision a copy.
    fn velocity(&self, axis: usize) -> Cow<'_, [f64]>;

    /// Return a vorticity component, 1/s; in single precision a copy.
    fn vorticity(&self, axis: usize) -> Cow<'_, [f64]>;

    /// Return the velocity at a grid point, m/s.
    fn velocity_at(&self, point: usize) -> [f64; 3];

    /// Return the sums of the squared velocity (m²/s²) and of the squared vorticity (1/s²).
    fn squares(&self) -> [f64; 2];

    /// Return the number of threads that share a step.
    fn threads(&self) -> usize;

    /// Return a copy of everything that the next step depends on.
    fn memory(&self) -> ByPrecision;

    /// Write that copy to `memory`; allocates nothing.
    fn save(&self, memory: &mut ByPrecision);

    /// Refuse a memory of another precision or size.
    fn check(&self, memory: &ByPrecision) -> Result<(), Error>;

    /// Go to a memory.
    fn restore(&mut self, memory: &ByPrecision) -> Result<(), Error>;
}

/// Return the solver in the precision of the parameters.
pub fn new_solver(parameters: &Parameters, problem: &Problem) -> Box<dyn FluidSolver> {
    match parameters.precision {
        Precision::Double => Box::new(Solver::<f64>::of(parameters, problem)),
        Precision::Single => Box::new(Solver::<f32>::of(parameters, problem)),
    }
}

impl<R: Real> Solver<R> {
    fn of(parameters: &Parameters, problem: &Problem) -> Self {
        let grid = &problem.grid;
        let spectral = Spectral::new(grid, parameters.filter, parameters.threads);
        Self::new(parameters.initial_velocity, spectral, grid.len(), grid.cells[1] * grid.cells[2])
    }
}

impl<R: Stored> FluidSolver for Solver<R> {
    fn start(&mut self, velocity: &dyn Fn(usize) -> [f64; 3], mean: Option<[f64; 3]>) -> f64 {
        for point in 0..self.w[0].len() {
            self.w.iter_mut().zip(velocity(point)).for_each(|(w, u)| w[point] = R::rounded(u));
        }
        self.start(mean)
    }

    fn step(&mut self, step: &Step, limit: f64, present: &mut Present, problem: &mut Problem) -> Result<f64, Error> {
        let scheme = Differences::new(step.dt, present.step);
        let Problem { bodies, thin, grid, .. } = problem;
        bodies.place(step.end, grid);
        bodies.sample(self.extrapolated(&scheme));
        self.solve_locally(step.team, &scheme, bodies.rate());
        bodies.add_velocities(step.end, scheme.c[0], grid, &mut self.w);
        if !thin.is_empty() {
            thin.place(step.nodes, &bodies.rigid, grid);
            let memory = &self.memory;
            let first = |point: usize, w: &[Field<R>; 3]| memory.u_star(&scheme, w, point);
            thin.apply(scheme.c[0], bodies.rate(), first, &mut self.w, step.end, grid)?;
        }
        let implicit = Implicit {
            tau_nu: scheme.tau * problem.nu,
            cfl: present.advection_rate * step.dt,
            mean: problem.mean_velocity(step.end),
        };
        let rate = self.solve_wave_by_wave(step.team, &implicit);
        if rate <= limit {
            let u_star = |point| Vector3::from(self.memory.u_star(&scheme, &self.w, point));
            let drag = |cell: &Cell| cell.rate * (u_star(cell.index) - cell.velocity);
            let Problem { bodies, thin, grid, .. } = problem;
            bodies.sum_up_forces(step.dt, drag, &mut present.bodies);
            thin.sum_up_forces(step.dt, step.nodes, &mut present.bodies, &mut present.exchange);
            if let Some(ahead) = step.ahead.filter(|ahead| !ahead.is_empty()) {
                thin.place(ahead, &bodies.rigid, grid);
            }
            Stations::copy_all(&mut present.nodes, step.nodes);
            self.take_over(scheme.c[0]);
        }
        Ok(rate)
    }

    fn predict_loads(&self, present: &mut Present, problem: &mut Problem) {
        let scheme = Differences::new(present.step, present.step);
        let Problem { bodies, thin, grid, .. } = problem;
        bodies.sample(self.extrapolated(&scheme));
        let add = |points: &[usize], sums: &mut [[f64; 3]]| {
            bodies.add_velocities_at(present.time + present.step, grid, points, sums);
        };
        thin.predict_loads(scheme.c[0], bodies.rate(), self.right_side(&scheme), add, grid, &mut present.loads);
    }

    fn make_pressure(&mut self, cfl: f64) {
        let Self { memory, spectral, w: [pi, ..], .. } = self;
        spectral.pressure(&memory.w, memory.inv_tau, cfl, pi);
    }

    fn pressure_at(&self, point: usize) -> f64 {
        self.w[0][point].to_f64() - 0.5 * square(self.memory.flow.velocity_at(point))
    }

    fn divergence(&mut self) -> [f64; 2] {
        let Self { memory, spectral, w: [_, divergence, _], .. } = self;
        spectral.divergence(&memory.flow.velocity, divergence);
        let largest = divergence.iter().fold(0.0_f64, |most, divergence| most.max(divergence.to_f64().abs()));
        let speeds = (0..divergence.len()).map(|point| square(memory.flow.velocity_at(point)));
        [largest, speeds.fold(0.0, f64::max).sqrt()]
    }

    fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.memory.flow.velocity[axis])
    }

    fn vorticity(&self, axis: usize) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.memory.flow.vorticity[axis])
    }

    fn velocity_at(&self, point: usize) -> [f64; 3] {
        self.memory.flow.velocity_at(point)
    }

    fn squares(&self) -> [f64; 2] {
        let Flow { velocity, vorticity } = &self.memory.flow;
        [velocity, vorticity]
            .map(|fields| fields.iter().flat_map(|field| field.iter()).map(|value| value.to_f64().powi(2)).sum())
    }

    fn threads(&self) -> usize {
        self.spectral.threads()
    }

    fn memory(&self) -> ByPrecision {
        R::wrap(self.memory.clone())
    }

    fn save(&self, memory: &mut ByPrecision) {
        if let Ok(memory) = R::of_mut(memory) {
            memory.copy_from(&self.memory);
        }
    }

    fn check(&self, memory: &ByPrecision) -> Result<(), Error> {
        if R::of(memory)?.fits(&self.memory) { Ok(()) } else { Err(Error::State("a field")) }
    }

    fn restore(&mut self, memory: &ByPrecision) -> Result<(), Error> {
        self.memory.copy_from(R::of(memory)?);
        Ok(())
    }
}

/// Return the square of a vector.
fn square(vector: [f64; 3]) -> f64 {
    vector.iter().map(|component| component * component).sum()
}
