//! The flow with its time scheme, in one precision behind an object: a communication step chooses no precision inside.

use std::borrow::Cow;
use std::ops::Range;

use line_fft::Real;

use crate::bodies::{PredictedBeams, Stations};
use crate::error::Error;
use crate::flow::Flow;
use crate::parameters::{Parameters, Precision};
use crate::present::Present;
use crate::problem::Problem;
use crate::state::{SolverState, State, Stored};
use crate::step::{Scheme, Substep, Work};

/// Reads the static pressure over the density, given at a grid point.
pub type PressureReader<'a> = dyn FnMut(&Problem, &dyn Fn(usize) -> f64) + 'a;

/// A flow that can be stepped.
pub trait FluidSolver: Send {
    /// Start from the divergence-free part of a velocity (m/s), given at a grid point.
    fn start(&mut self, velocity: &dyn Fn(usize) -> [f64; 2], present: &mut Present, problem: &mut Problem);

    /// Return the longest step that is stable with the bodies, s; none if there is no limit.
    fn longest_step(&self, problem: &Problem) -> Option<f64>;

    /// Make a step; see [`Scheme::step`].
    fn step(
        &mut self,
        step: Substep,
        present: &mut Present,
        problem: &mut Problem,
    ) -> Result<Option<PredictedBeams>, Error>;

    /// Write the loads for the coming step to `present`; see [`Scheme::predict_loads`].
    fn predict_loads(&self, predicted: Option<PredictedBeams>, present: &mut Present, problem: &mut Problem);

    /// Call `read` with the problem and the static pressure over the density, `Pi − u²/2` (m²/s²), at a grid point.
    fn read_pressure(&mut self, present: &Present, problem: &mut Problem, read: &mut PressureReader);

    /// Return the largest divergence (1/s) and the largest speed (m/s).
    fn divergence(&mut self) -> [f64; 2];

    /// Return a velocity component, m/s; in single precision a copy.
    fn velocity(&self, axis: usize) -> Cow<'_, [f64]>;

    /// Return the vorticity, 1/s; in single precision a copy.
    fn vorticity(&self) -> Cow<'_, [f64]>;

    /// Return the velocity interpolated by grid points and weights, m/s.
    fn velocity_by(&self, weights: &[(usize, f64)]) -> [f64; 2];

    /// Return the sum of the velocity along x over some points, m/s.
    fn sum_of_u(&self, points: Range<usize>) -> f64;

    /// Return the sums of the squared velocity (m²/s²) and of the squared vorticity (1/s²).
    fn squares(&self) -> [f64; 2];

    /// Return the number of threads that share a step.
    fn threads(&self) -> usize;

    /// Return a copy of everything that the next step depends on.
    fn state(&self, present: &Present) -> State;

    /// Overwrite a state of this fluid; allocates nothing.
    fn save(&self, present: &Present, state: &mut State);

    /// Return the stations of a state, or why it is not one of this fluid.
    fn check_state<'a>(&self, present: &Present, state: &'a State) -> Result<&'a [Stations], Error>;

    /// Go to a state of this fluid; fails, and changes nothing, if it is in another precision.
    fn restore(&mut self, state: &State, present: &mut Present) -> Result<(), Error>;
}

/// Make the solver of the wanted precision.
pub fn new_solver(parameters: &Parameters, problem: &Problem) -> Box<dyn FluidSolver> {
    match parameters.precision {
        Precision::Double => Box::new(Solver::<f64>::new(parameters, problem)),
        Precision::Single => Box::new(Solver::<f32>::new(parameters, problem)),
    }
}

/// The flow of a precision.
struct Solver<R: Real> {
    flow: Flow<R>,
    scheme: Scheme<R>,
    work: Work<R>,
}

impl<R: Real> Solver<R> {
    fn new(parameters: &Parameters, problem: &Problem) -> Self {
        let (velocity, work) = (parameters.initial_velocity, Work::new(parameters, &problem.grid));
        Self {
            flow: Flow::uniform(velocity, problem.grid.len()),
            scheme: Scheme::new(parameters.scheme, velocity, problem, &work),
            work,
        }
    }
}

impl<R: Stored> FluidSolver for Solver<R> {
    fn start(&mut self, velocity: &dyn Fn(usize) -> [f64; 2], present: &mut Present, problem: &mut Problem) {
        for point in 0..problem.grid.len() {
            for (w, u) in self.work.w.iter_mut().zip(velocity(point)) {
                w[point] = R::rounded(u);
            }
        }
        self.scheme.start(&mut self.flow, present, problem, &mut self.work);
    }

    fn longest_step(&self, problem: &Problem) -> Option<f64> {
        self.scheme.longest_step(problem)
    }

    fn step(
        &mut self,
        step: Substep,
        present: &mut Present,
        problem: &mut Problem,
    ) -> Result<Option<PredictedBeams>, Error> {
        self.scheme.step(step, &mut self.flow, present, problem, &mut self.work)
    }

    fn predict_loads(&self, predicted: Option<PredictedBeams>, present: &mut Present, problem: &mut Problem) {
        let mut loads = std::mem::take(&mut present.beams.loads);
        if !loads.is_empty() {
            self.scheme.predict_loads(predicted, &self.flow, present, problem, &mut loads);
        }
        present.beams.loads = loads;
    }

    fn read_pressure(&mut self, present: &Present, problem: &mut Problem, read: &mut PressureReader) {
        let Self { flow, scheme, work } = self;
        let pi = scheme.total_pressure(flow, present, problem, work);
        read(problem, &|point| {
            let [u, v] = flow.velocity_at(point);
            pi[point].to_f64() - 0.5 * (u * u + v * v)
        });
    }

    fn divergence(&mut self) -> [f64; 2] {
        let velocity @ [u, v] = &self.flow.velocity;
        let Work { spectral, projection, w: [divergence, _] } = &mut self.work;
        spectral.divergence(projection, velocity, divergence);
        let largest = divergence.iter().fold(0.0_f64, |most, divergence| most.max(divergence.to_f64().abs()));
        let fastest = u.iter().zip(&**v).fold(0.0_f64, |most, (u, v)| most.max(u.to_f64().hypot(v.to_f64())));
        [largest, fastest]
    }

    fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.flow.velocity[axis])
    }

    fn vorticity(&self) -> Cow<'_, [f64]> {
        R::field_to_f64(&self.flow.vorticity)
    }

    fn velocity_by(&self, weights: &[(usize, f64)]) -> [f64; 2] {
        let component = |u: &[R]| weights.iter().map(|&(point, weight)| weight * u[point].to_f64()).sum();
        self.flow.velocity.each_ref().map(|u| component(u))
    }

    fn sum_of_u(&self, points: Range<usize>) -> f64 {
        self.flow.velocity[0][points].iter().map(|u| u.to_f64()).sum()
    }

    fn squares(&self) -> [f64; 2] {
        let Flow { velocity: [u, v], vorticity } = &self.flow;
        let velocity = u.iter().zip(&**v).map(|(u, v)| u.to_f64().powi(2) + v.to_f64().powi(2)).sum();
        [velocity, vorticity.iter().map(|omega| omega.to_f64().powi(2)).sum()]
    }

    fn threads(&self) -> usize {
        self.work.spectral.threads()
    }

    fn state(&self, present: &Present) -> State {
        R::wrap(SolverState::new(present, &self.flow, self.scheme.memory()))
    }

    fn save(&self, present: &Present, state: &mut State) {
        if let Ok(state) = R::of_mut(state) {
            state.save(present, &self.flow);
            self.scheme.save(&mut state.memory);
        }
    }

    fn check_state<'a>(&self, present: &Present, state: &'a State) -> Result<&'a [Stations], Error> {
        let state = R::of(state)?;
        state.check(present, &self.flow, self.scheme.fits(&state.memory))
    }

    fn restore(&mut self, state: &State, present: &mut Present) -> Result<(), Error> {
        let state = R::of(state)?;
        state.restore(present, &mut self.flow);
        self.scheme.restore(&state.memory);
        Ok(())
    }
}
