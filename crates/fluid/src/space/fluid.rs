//! A fluid in space: the communication step, and what can be read.

use std::borrow::Cow;
use std::hint::black_box;

use line_fft::Team;
use serde::{Deserialize, Serialize};

use super::flow::ByPrecision;
use super::force::Force;
use super::parameters::Parameters;
use super::problem::{Present, Problem};
use super::rigid::Pose;
use super::solver::{FluidSolver, Step, new_solver};
use crate::bodies::{Loads, Stations};
use crate::error::Error;
use crate::force::Exchange;
use crate::grid::Grid;
use crate::limits::StepLimits;

/// Numbers of a state for each cell: velocity and vorticity at two times and `w`.
const STATE_NUMBERS_PER_CELL: usize = 15;

/// Bytes of the drag rate of solids for each cell.
const RATE_BYTES_PER_CELL: usize = 8;

/// Memory of a node with its loads in the fluid and in a state, and of a marker with its grid points, bytes.
const BYTES_PER_NODE: usize = 600;
const BYTES_PER_MARKER: usize = 4000;

/// Numbers of a fluid for each cell: those of the state, `w`, and six spectra, which may be a row of a vector longer than
/// the field.
const NUMBERS_PER_CELL: usize = STATE_NUMBERS_PER_CELL + 3 + 7;

/// A fluid in space. In single precision its fields and transforms are of `f32`; everything that is set and read is of
/// `f64` in both.
pub struct Fluid {
    problem: Problem,
    present: Present,
    solver: Box<dyn FluidSolver>,
    density: f64,
    /// Grid points and weights of the probes.
    probes: Vec<[(usize, f64); 64]>,
    pressure_is_current: bool,
    motion: Motion,
    limits: StepLimits,
    bytes_per_number: usize,
    /// The state before a communication step of several steps, for errors within it; made when first needed.
    undo: Option<State>,
}

/// Nodes of the thin bodies in a communication step.
struct Motion {
    names: Vec<String>,
    /// At the beginning of the step.
    from: Vec<Stations<3>>,
    /// At the end of a step of the fluid, or after the communication step with the velocities of its end.
    between: Vec<Stations<3>>,
    /// At the end of the step, set from outside.
    target: Vec<Stations<3>>,
}

/// A state of a fluid in space. It fits every fluid with the same parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    present: Present,
    memory: ByPrecision,
}

impl Fluid {
    /// A fluid at t = 0.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters with which no step can be made.
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.check()?;
        let mut problem = Problem::new(parameters);
        let nodes: Vec<_> = parameters.flexible.iter().map(|body| Stations::at_rest(&body.nodes)).collect();
        problem.place(0.0, &nodes);
        let velocity = parameters.initial_velocity.iter().zip(problem.grid.spacing);
        let present = Present {
            time: 0.0,
            step: 0.0,
            advection_rate: velocity.map(|(u, spacing)| u.abs() / spacing).sum(),
            bodies: problem.without_force(&nodes),
            loads: nodes.iter().map(|nodes| Loads::none(nodes.len())).collect(),
            exchange: vec![Exchange::default(); nodes.len()],
            nodes: nodes.clone(),
        };
        Ok(Self {
            solver: new_solver(parameters, &problem),
            density: parameters.density,
            probes: parameters.probes.iter().map(|probe| problem.grid.cubic_interpolation(*probe)).collect(),
            pressure_is_current: false,
            motion: Motion {
                names: parameters.flexible.iter().map(|body| body.name.clone()).collect(),
                from: nodes.clone(),
                between: nodes.clone(),
                target: nodes,
            },
            limits: StepLimits::new(parameters.max_step, parameters.max_cfl, parameters.communication_step),
            bytes_per_number: parameters.precision.bytes(),
            undo: None,
            present,
            problem,
        })
    }

    /// Return the approximate memory of a fluid, bytes.
    pub fn bytes(parameters: &Parameters) -> usize {
        let cells = parameters.cells.iter().product::<usize>();
        let nodes = parameters.flexible.iter().map(|body| body.nodes.len()).sum::<usize>();
        let thin = BYTES_PER_NODE * nodes + BYTES_PER_MARKER * parameters.markers();
        (NUMBERS_PER_CELL * parameters.precision.bytes() + RATE_BYTES_PER_CELL) * cells + thin
    }

    /// Return the approximate memory of a state, bytes.
    pub fn state_bytes(&self) -> usize {
        let nodes = self.motion.target.iter().map(Stations::len).sum::<usize>();
        STATE_NUMBERS_PER_CELL * self.bytes_per_number * self.problem.grid.len() + BYTES_PER_NODE * nodes
    }

    /// Start at another time than 0 (s): the bodies are in their places at that time.
    pub fn start_at(&mut self, time: f64) {
        self.present.time = time;
        self.problem.place(time, &self.present.nodes);
        self.present.bodies = self.problem.without_force(&self.present.nodes);
    }

    /// Start again from the divergence-free part of a velocity field (m/s at a point in m).
    pub fn set_velocity(&mut self, velocity: impl Fn([f64; 3]) -> [f64; 3]) {
        let grid = self.problem.grid;
        let mean = self.problem.mean_velocity(self.present.time);
        self.present.step = 0.0;
        self.pressure_is_current = false;
        self.present.advection_rate = self.solver.start(&|index| velocity(grid.point(index)), mean);
    }

    /// Return the nodes of the thin bodies at the end of the coming step.
    pub fn nodes(&self) -> &[Stations<3>] {
        &self.motion.target
    }

    /// Return the same, to be set.
    pub fn nodes_mut(&mut self) -> &mut [Stations<3>] {
        &mut self.motion.target
    }

    /// Return the loads on the nodes of each thin body in the coming step.
    pub fn loads(&self) -> &[Loads<3>] {
        &self.present.loads
    }

    /// Return the exchange with each thin body in the last step.
    pub fn exchange(&self) -> &[Exchange<3>] {
        &self.present.exchange
    }

    /// Return the number of markers of the thin bodies.
    pub fn markers(&self) -> usize {
        self.problem.thin.markers()
    }

    /// Advance from `t` to `t + h` (s); the nodes move from their present places to those of [`Self::nodes_mut`].
    ///
    /// The steps are equal; if the flow becomes too fast for them, the remaining time is divided again.
    ///
    /// # Errors
    /// Numbers that are not finite, and a flow or nodes that need more than a hundred times the usual number of
    /// steps. After [`Error::Diverged`] and [`Error::Loads`] a state has to be restored.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.limits.check(t, h)?;
        check_nodes(&self.motion.names, &self.motion.target, &self.limits, &self.problem.grid)?;
        let substeps = self.limits.divide(t, h, self.present.advection_rate, None)?;
        self.pressure_is_current = false;
        Stations::copy_all(&mut self.motion.from, &self.present.nodes);
        let several = substeps > 1.0;
        if several {
            self.save_for_undo()?;
        }
        let result = Team::with(self.solver.threads(), |team| self.make_steps(team, substeps, t, h));
        match (&result, &self.undo) {
            (Err(_), Some(undo)) if several => {
                self.present.clone_from(&undo.present);
                self.solver.restore(&undo.memory)?;
                self.problem.place(self.present.time, &self.present.nodes);
            }
            // Nothing but the places of the bodies has changed.
            (Err(Error::Markers { .. }), _) => self.problem.place(self.present.time, &self.present.nodes),
            // The new flow has taken the place of the one before the last.
            (Err(_), _) => self.present.advection_rate = f64::NAN,
            (Ok(()), _) => {}
        }
        result?;
        if !self.present.loads.is_empty() {
            self.solver.predict_loads(&mut self.present, &mut self.problem);
            if !self.present.loads.iter().all(Loads::are_finite) {
                self.present.advection_rate = f64::NAN;
                return Err(Error::Loads { time: self.present.time });
            }
        }
        Ok(())
    }

    /// Make the steps of a communication step, at first `substeps`.
    fn make_steps(&mut self, team: &Team, mut substeps: f64, t: f64, h: f64) -> Result<(), Error> {
        // Shares of `h` that are done, and that were done when the rest was divided into `substeps`.
        let (mut done, mut divided, mut substep) = (0.0, 0.0, 0.0);
        let mut dt = h / substeps;
        let StepLimits { max_cfl, shortest, .. } = self.limits;
        while done < 1.0 {
            let rate = self.present.advection_rate;
            if substep > 0.0 && rate * dt > max_cfl {
                let left = h * (1.0 - done);
                (divided, substep, substeps) = (done, 0.0, (left * rate / max_cfl).ceil());
                dt = left / substeps;
            }
            substep += 1.0;
            done = if substep == substeps { 1.0 } else { divided + (1.0 - divided) * (substep / substeps) };
            let Motion { from, between, target, .. } = &mut self.motion;
            let (nodes, ahead) = if done == 1.0 {
                between.iter_mut().zip(&*target).for_each(|(ahead, target)| ahead.extrapolate(target, h));
                (&*target, Some(&**between))
            } else {
                let ends = from.iter().zip(&*target);
                between.iter_mut().zip(ends).for_each(|(now, (a, b))| now.interpolate(a, b, done, h));
                (&*between, None)
            };
            let step = Step { dt, end: t + done * h, nodes, ahead, team };
            let rate = self.solver.step(&step, max_cfl / shortest, &mut self.present, &mut self.problem)?;
            let needed = max_cfl / rate;
            if needed.is_nan() || needed < shortest {
                return Err(Error::Diverged { time: step.end, needed, shortest });
            }
            (self.present.time, self.present.step, self.present.advection_rate) = (step.end, dt, rate);
        }
        Ok(())
    }

    fn save_for_undo(&mut self) -> Result<(), Error> {
        match &mut self.undo {
            Some(undo) => {
                undo.present.clone_from(&self.present);
                self.solver.save(&mut undo.memory);
            }
            None => {
                // Rust ends the process if memory runs out, so ask for it before.
                let (bytes, mut probe) = (self.state_bytes(), Vec::<u8>::new());
                probe.try_reserve_exact(bytes).map_err(|_| Error::Memory { bytes })?;
                drop(black_box(probe));
                self.undo = Some(self.state());
            }
        }
        Ok(())
    }

    /// Return a copy of everything that the next step depends on.
    pub fn state(&self) -> State {
        State { present: self.present.clone(), memory: self.solver.memory() }
    }

    /// Go to a state of a fluid with the same parameters.
    ///
    /// # Errors
    /// A state of other parameters, or with numbers that are not finite; it changes nothing.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        let Present { time, step, advection_rate, .. } = state.present;
        if ![time, step, advection_rate].iter().all(|number| number.is_finite()) {
            return Err(Error::State("the time or a step"));
        }
        let fits = state.present.bodies.len() == self.present.bodies.len()
            && state.present.exchange.len() == self.present.exchange.len();
        if !fits {
            return Err(Error::State("the list of bodies"));
        }
        let Present { nodes, loads, .. } = &state.present;
        let fits = same(nodes, &self.present.nodes, Stations::has_shape_of)
            && same(loads, &self.present.loads, Loads::has_shape_of);
        if !fits || check_nodes(&self.motion.names, nodes, &self.limits, &self.problem.grid).is_err() {
            return Err(Error::State("the list of nodes"));
        }
        self.solver.check(&state.memory)?;
        self.solver.restore(&state.memory)?;
        self.present.clone_from(&state.present);
        Stations::copy_all(&mut self.motion.target, &self.present.nodes);
        self.problem.place(time, &self.present.nodes);
        self.pressure_is_current = false;
        Ok(())
    }

    /// Return the grid.
    pub fn grid(&self) -> &Grid<3> {
        &self.problem.grid
    }

    /// Return the time, s.
    pub fn time(&self) -> f64 {
        self.present.time
    }

    /// Return a velocity component (0: x, 1: y, 2: z), m/s, `[nx, ny, nz]`; in single precision a copy.
    pub fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        self.solver.velocity(axis)
    }

    /// Return a vorticity component, 1/s, `[nx, ny, nz]`; in single precision a copy.
    pub fn vorticity(&self, axis: usize) -> Cow<'_, [f64]> {
        self.solver.vorticity(axis)
    }

    /// Return the static pressure p = rho (Pi − u²/2), Pa, `[nx, ny, nz]`; Pi has zero mean over the domain. It takes
    /// four transforms.
    pub fn pressure(&mut self) -> Vec<f64> {
        self.make_pressure();
        (0..self.problem.grid.len()).map(|point| self.density * self.solver.pressure_at(point)).collect()
    }

    fn make_pressure(&mut self) {
        if !self.pressure_is_current {
            self.solver.make_pressure(self.cfl());
            self.pressure_is_current = true;
        }
    }

    /// Return the velocity at a probe, numbered from 0, m/s.
    pub fn probe_velocity(&self, probe: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (point, weight) in self.probes[probe] {
            sum.iter_mut().zip(self.solver.velocity_at(point)).for_each(|(sum, u)| *sum += weight * u);
        }
        sum
    }

    /// Return the static pressure at a probe, Pa. The first pressure after a step takes four transforms.
    pub fn probe_pressure(&mut self, probe: usize) -> f64 {
        self.make_pressure();
        let parts = self.probes[probe].iter().map(|&(point, weight)| weight * self.solver.pressure_at(point));
        self.density * parts.sum::<f64>()
    }

    /// Return the force of the fluid on all bodies in the last step, N.
    pub fn force(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.present.bodies.iter().map(|body| body.force.force[axis]).sum())
    }

    /// Return the force of the fluid on a thin body, numbered from 0, in the last step.
    pub fn force_on_thin(&self, body: usize) -> Force {
        self.present.bodies[self.problem.bodies.rigid.len() + body].force
    }

    /// Return the force of the fluid on a rigid body, numbered from 0, in the last step.
    pub fn force_on_body(&self, body: usize) -> Force {
        self.present.bodies[body].force
    }

    /// Return the power of [`Self::force_on_body`] at the end of the step, W.
    pub fn power_on_body(&self, body: usize) -> f64 {
        let (Force { force, moment }, Pose { velocity, omega, .. }) = (self.force_on_body(body), self.pose(body));
        (0..3).map(|axis| force[axis] * velocity[axis] + moment[axis] * omega[axis]).sum()
    }

    /// Return place and motion of a body, numbered from 0.
    pub fn pose(&self, body: usize) -> Pose {
        self.problem.bodies.rigid[body].pose
    }

    /// Return the largest divergence of the velocity times the cell size over the largest speed. It takes four
    /// transforms.
    pub fn divergence(&mut self) -> f64 {
        let [largest, fastest] = self.solver.divergence();
        largest * self.problem.grid.cell_size() / fastest.max(f64::MIN_POSITIVE)
    }

    /// Return the CFL number max(|u|/dx + |v|/dy + |w|/dz) dt of the last step.
    pub fn cfl(&self) -> f64 {
        self.present.advection_rate * self.present.step
    }

    /// Return the flow rate through the plane in the middle of the domain along x, m³/s.
    pub fn flow_rate(&self) -> f64 {
        let Grid { cells: [nx, ny, nz], spacing: [_, dy, dz], .. } = self.problem.grid;
        let points = nx / 2 * ny * nz..(nx / 2 + 1) * ny * nz;
        points.map(|point| self.solver.velocity_at(point)[0]).sum::<f64>() * dy * dz
    }

    /// Return the kinetic energy of the domain, J.
    pub fn kinetic_energy(&self) -> f64 {
        let [squares, _] = self.solver.squares();
        0.5 * self.density * squares * self.problem.grid.cell_volume()
    }

    /// Return half the integral of the squared vorticity over the domain, m³/s².
    pub fn enstrophy(&self) -> f64 {
        let [_, squares] = self.solver.squares();
        0.5 * squares * self.problem.grid.cell_volume()
    }
}

/// Refuse nodes that no step can reach.
fn check_nodes(names: &[String], all: &[Stations<3>], limits: &StepLimits, grid: &Grid<3>) -> Result<(), Error> {
    names.iter().zip(all).try_for_each(|(name, nodes)| limits.check_nodes(name, nodes, grid))
}

/// Return whether two lists are as long, and their elements fit one another.
fn same<T>(a: &[T], b: &[T], fits: impl Fn(&T, &T) -> bool) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| fits(a, b))
}
