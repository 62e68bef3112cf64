//! A fluid with its bodies and beams: the communication step.

use std::f64::consts::PI;
use std::hint::black_box;

use line_fft::Team;

use crate::bodies::{Carried, Loads, Pose, PredictedBeams, Stations};
use crate::error::Error;
use crate::force::Exchange;
use crate::limits::StepLimits;
use crate::outlet::Outlet;
use crate::parameters::{Beam, Parameters, Surface};
use crate::present::{Beams, Present};
use crate::pressures::{Cached, Pressures};
use crate::probe::Probe;
use crate::problem::Problem;
use crate::solver::{FluidSolver, new_solver};
use crate::state::State;
use crate::step::Substep;
use crate::timer::Phase;

/// Memory of a fluid for each cell: numbers in its precision, of which 8 are the state and 8 a copy of it; and bytes
/// that do not depend on the precision, with the roundings of the allocations.
const NUMBERS_PER_CELL: usize = 27;
const BYTES_PER_CELL: usize = 44;

/// Memory of each beam for each cell, bytes: the number of a candidate.
const BYTES_PER_BEAM_AND_CELL: usize = 4;

/// Numbers of a state for each cell: velocity and vorticity at two times and two components of `w`, or less.
const STATE_NUMBERS_PER_CELL: usize = 8;

/// Memory of a station with its loads in the fluid and in a state, bytes.
const BYTES_PER_STATION: usize = 400;

/// A fluid with the bodies and beams in it.
///
/// In single precision its fields and transforms are of `f32`. Everything that is set and read is of `f64` in both.
pub struct Fluid {
    pub(crate) problem: Problem,
    pub(crate) present: Present,
    pub(crate) solver: Box<dyn FluidSolver>,
    pub(crate) density: f64,
    pub(crate) probes: Vec<Probe>,
    /// Reference of the pressure around the beams; absent if that pressure is not wanted.
    pub(crate) outlet: Option<Outlet>,
    pub(crate) pressures: Cached<Pressures>,
    pub(crate) motion: Motion,
    limits: StepLimits,
    bytes_per_number: usize,
    /// The state before a communication step of several steps, for errors within it; made when first needed.
    undo: Option<State>,
}

/// Stations of the beams and displacements of the bodies that laws do not move, in a communication step; every list is
/// empty without a beam or such a body.
pub(crate) struct Motion {
    /// At the beginning of the step.
    from: Vec<Stations>,
    /// At the end of a step of the fluid, or after the communication step with the velocities of its end.
    between: Vec<Stations>,
    /// At the end of the step, set from outside.
    pub target: Vec<Stations>,
    /// Displacements at the beginning of the step.
    displaced_from: Vec<Pose>,
    /// Displacements at the end of a step of the fluid.
    displaced: Vec<Pose>,
    /// Displacements at the end of the step, set from outside; of a body on springs unused.
    pub displaced_to: Vec<Pose>,
}

/// Return room for the stress on a thin beam.
fn line_stress(beam: &Beam) -> Vec<f64> {
    vec![0.0; if beam.surface == Surface::Line { beam.stations.len() } else { 0 }]
}

impl Fluid {
    /// A fluid at t = 0.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters with which no step can be made.
    pub fn new(parameters: &Parameters) -> Result<Self, Error> {
        parameters.check()?;
        let mut problem = Problem::new(parameters);
        let stations: Vec<_> = parameters.beams.iter().map(|beam| Stations::at_rest(&beam.stations)).collect();
        problem.place(0.0, &[], &stations, &stations);
        let carried = vec![Carried::default(); problem.bodies.carried().count()];
        let displaced = vec![Pose::default(); carried.len()];
        let [u, v] = parameters.initial_velocity;
        let [dx, dy] = problem.grid.spacing;
        let present = Present {
            time: 0.0,
            step: 0.0,
            advection_rate: u.abs() / dx + v.abs() / dy,
            bodies: problem.without_force(&stations),
            carried,
            beams: Beams {
                stations: stations.clone(),
                loads: stations.iter().filter(|_| parameters.loads).map(|s| Loads::none(s.len())).collect(),
                exchange: vec![Exchange::default(); stations.len()],
                line_jump: parameters.beams.iter().map(line_stress).collect(),
                line_shear: parameters.beams.iter().map(line_stress).collect(),
            },
        };
        let outlet = if parameters.pressure_around { Outlet::new(parameters, &problem.grid) } else { None };
        let mut fluid = Self {
            solver: new_solver(parameters, &problem),
            density: parameters.density,
            probes: Probe::all(parameters, &problem.grid),
            pressures: Cached::stale(Pressures::new(parameters.probes.len(), &stations, outlet.is_some())),
            outlet,
            motion: Motion {
                between: stations.clone(),
                target: stations.clone(),
                from: stations,
                displaced_from: displaced.clone(),
                displaced: displaced.clone(),
                displaced_to: displaced,
            },
            limits: StepLimits::new(parameters.max_step, parameters.max_cfl, parameters.communication_step),
            bytes_per_number: parameters.precision.bytes(),
            undo: None,
            present,
            problem,
        };
        if let Some(amplitude) = parameters.disturbance {
            fluid.disturb(parameters, amplitude);
        }
        Ok(fluid)
    }

    /// Start with a wave of each velocity along the other axis, m/s, which has no divergence and no mean.
    fn disturb(&mut self, Parameters { domain, initial_velocity, .. }: &Parameters, amplitude: f64) {
        let wave = |at: f64, [low, high]: [f64; 2]| amplitude * (2.0 * PI * (at - low) / (high - low)).sin();
        self.set_velocity(|x, y| [initial_velocity[0] + wave(y, domain[1]), initial_velocity[1] + wave(x, domain[0])]);
    }

    /// Return the approximate memory of a fluid, bytes.
    pub fn bytes(parameters: &Parameters) -> usize {
        let cells = parameters.cells.iter().product::<usize>();
        let beam = |stations: usize| BYTES_PER_STATION * stations + BYTES_PER_BEAM_AND_CELL * cells;
        let beams = parameters.beams.iter().map(|of| beam(of.stations.len()));
        (NUMBERS_PER_CELL * parameters.precision.bytes() + BYTES_PER_CELL) * cells + beams.sum::<usize>()
    }

    /// Return the approximate memory of a state, bytes.
    pub fn state_bytes(&self) -> usize {
        let stations = self.motion.target.iter().map(Stations::len).sum::<usize>();
        STATE_NUMBERS_PER_CELL * self.bytes_per_number * self.problem.grid.len() + BYTES_PER_STATION * stations
    }

    /// Start at another time than 0 (s): the bodies are in their places at that time.
    pub fn start_at(&mut self, time: f64) {
        self.present.time = time;
        self.place_at_present();
        self.present.bodies = self.problem.bodies.without_force(&self.present.beams.stations);
    }

    /// Start again from the divergence-free part of a velocity field (m/s at a point in m).
    pub fn set_velocity(&mut self, velocity: impl Fn(f64, f64) -> [f64; 2]) {
        let grid = self.problem.grid;
        let at = |index: usize| {
            let [x, y] = grid.point(index);
            velocity(x, y)
        };
        self.pressures.invalidate();
        self.solver.start(&at, &mut self.present, &mut self.problem);
    }

    /// Continue the flow of another fluid on the same grid, with the same beams and carried bodies and perhaps other
    /// cylinders: its time, its velocity, and its beams with their loads.
    ///
    /// # Errors
    /// Another grid, other beams or other carried bodies; then nothing changes.
    pub fn continue_from(&mut self, other: &Self) -> Result<(), Error> {
        let (own, known) = (&self.present, &other.present);
        for (part, fits) in [
            ("a field", self.problem.grid.cells == other.problem.grid.cells),
            ("the list of bodies", own.carried.len() == known.carried.len()),
            ("the list of beams", own.beams.have_shape_of(&known.beams)),
        ] {
            if !fits {
                return Err(Error::State(part));
            }
        }
        self.present.beams.copy_from(&known.beams);
        self.present.carried.copy_from_slice(&known.carried);
        Stations::copy_all(&mut self.motion.target, &known.beams.stations);
        self.motion.displaced_to.copy_from_slice(&other.motion.displaced_to);
        self.start_at(known.time);
        self.pressures.invalidate();
        let [u, v] = [0, 1].map(|axis| other.velocity(axis));
        self.solver.start(&|point| [u[point], v[point]], &mut self.present, &mut self.problem);
        Ok(())
    }

    /// Advance from `t` to `t + h` (s); the stations move from their present places to those of [`Self::stations_mut`].
    ///
    /// The steps are equal; if the flow becomes too fast for them, the remaining time is divided again.
    ///
    /// # Errors
    /// Numbers that are not finite, and a flow or stations that need more than a hundred times the usual number of
    /// steps. An error leaves everything unchanged; only after [`Error::Loads`] a state has to be restored.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        self.problem.timer.start();
        self.limits.check(t, h)?;
        self.limits.check_beams(&self.motion.target, &self.problem.grid)?;
        self.limits.check_bodies(&self.problem.bodies, &self.motion.displaced_to, &self.problem.grid)?;
        let explicit = self.solver.longest_step(&self.problem);
        let substeps = self.limits.divide(t, h, self.present.advection_rate, explicit)?;
        Stations::copy_all(&mut self.motion.from, &self.present.beams.stations);
        self.motion
            .displaced_from
            .iter_mut()
            .zip(&self.present.carried)
            .for_each(|(from, carried)| *from = carried.now);
        // A single step changes nothing before it is known to be good.
        let several = substeps > 1.0;
        if several {
            self.save_for_undo()?;
        }
        let threads = self.solver.threads();
        let predicted = match Team::with(threads, |team| self.make_steps(team, substeps, t, h)) {
            Ok(predicted) => predicted,
            Err(error) => {
                if let Some(undo) = self.undo.as_ref().filter(|_| several) {
                    self.solver.restore(undo, &mut self.present)?;
                }
                self.place_at_present();
                return Err(error);
            }
        };
        self.pressures.invalidate();
        self.solver.predict_loads(predicted, &mut self.present, &mut self.problem);
        self.problem.timer.mark(Phase::Loads);
        if !self.present.beams.loads.iter().all(Loads::are_finite) {
            // The previous flow is lost. Without a rate no step can be made before a state is restored.
            self.present.advection_rate = f64::NAN;
            return Err(Error::Loads { time: self.present.time });
        }
        Ok(())
    }

    /// Make the steps of a communication step, at first `substeps`, and return the beams that the last one predicted.
    fn make_steps(&mut self, team: &Team, mut substeps: f64, t: f64, h: f64) -> Result<Option<PredictedBeams>, Error> {
        // Shares of `h` that are done, and that were done when the rest was divided into `substeps`.
        let (mut done, mut divided, mut substep) = (0.0, 0.0, 0.0);
        let mut dt = h / substeps;
        let StepLimits { max_cfl, shortest, .. } = self.limits;
        loop {
            let rate = self.present.advection_rate;
            if substep > 0.0 && rate * dt > max_cfl {
                let left = h * (1.0 - done);
                (divided, substep, substeps) = (done, 0.0, (left * rate / max_cfl).ceil());
                dt = left / substeps;
            }
            substep += 1.0;
            done = if substep == substeps { 1.0 } else { divided + (1.0 - divided) * (substep / substeps) };
            let is_last = done == 1.0;
            let Motion { from, between, target, displaced_from, displaced, displaced_to } = &mut self.motion;
            let (carried, ends) = (&self.present.carried, displaced_from.iter().zip(&*displaced_to));
            for (((_, on_springs), placed), (carried, (a, b))) in
                self.problem.bodies.carried().zip(&mut *displaced).zip(carried.iter().zip(ends))
            {
                *placed = if on_springs {
                    carried.predicted(dt, self.present.step)
                } else if is_last {
                    *b
                } else {
                    Pose::interpolated(a, b, done, h)
                };
            }
            let (stations, ahead) = if is_last {
                between.iter_mut().zip(&*target).for_each(|(ahead, target)| ahead.extrapolate(target, h));
                (&*target, (!self.present.beams.loads.is_empty()).then_some(&**between))
            } else {
                let ends = from.iter().zip(&*target);
                between.iter_mut().zip(ends).for_each(|(now, (a, b))| now.interpolate(a, b, done, h));
                (&*between, None)
            };
            let step =
                Substep { dt, end: t + done * h, stations, displacements: displaced, ahead, max_cfl, shortest, team };
            let predicted = self.solver.step(step, &mut self.present, &mut self.problem)?;
            if is_last {
                return Ok(predicted);
            }
        }
    }

    /// Put the bodies to their present places.
    fn place_at_present(&mut self) {
        let (stations, displaced) = (&self.present.beams.stations, &mut self.motion.displaced);
        displaced.iter_mut().zip(&self.present.carried).for_each(|(now, carried)| *now = carried.now);
        self.problem.place(self.present.time, displaced, stations, stations);
    }

    fn save_for_undo(&mut self) -> Result<(), Error> {
        match &mut self.undo {
            Some(undo) => self.solver.save(&self.present, undo),
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
        self.solver.state(&self.present)
    }

    /// Go to a state of a fluid with the same parameters.
    ///
    /// # Errors
    /// A state of other parameters, or with numbers that are not finite; it changes nothing.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        let stations = self.solver.check_state(&self.present, state)?;
        self.limits.check_beams(stations, &self.problem.grid)?;
        self.solver.restore(state, &mut self.present)?;
        Stations::copy_all(&mut self.motion.target, &self.present.beams.stations);
        self.motion.displaced_to.iter_mut().zip(&self.present.carried).for_each(|(to, carried)| *to = carried.now);
        self.pressures.invalidate();
        self.place_at_present();
        Ok(())
    }
}
