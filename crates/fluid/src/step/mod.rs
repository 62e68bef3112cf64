//! The time schemes. A step makes the next flow in arrays of its own and swaps them with the present flow if it is
//! finite.

mod rk2;
mod sbdf2;
mod substep;
mod work;

use line_fft::Real;

use crate::bodies::{Loads, PredictedBeams};
use crate::error::Error;
use crate::flow::Flow;
use crate::parameters::TimeScheme;
use crate::present::Present;
use crate::problem::Problem;
use crate::state::Memory;

use rk2::Rk2;
pub use sbdf2::Differences;
use sbdf2::Sbdf2;
pub use substep::Substep;
pub use work::Work;

/// A time scheme with its memory of earlier steps.
pub enum Scheme<R: Real> {
    /// Two-step backward differences.
    Sbdf2(Sbdf2<R>),
    /// Heun's method.
    Rk2(Rk2<R>),
}

impl<R: Real> Scheme<R> {
    /// A scheme that begins with a uniform velocity (m/s).
    pub fn new(scheme: TimeScheme, velocity: [f64; 2], problem: &Problem, work: &Work<R>) -> Self {
        match scheme {
            TimeScheme::Sbdf2 => Self::Sbdf2(Sbdf2::new(problem)),
            TimeScheme::Rk2 => Self::Rk2(Rk2::new(velocity, problem, work)),
        }
    }

    /// Return a copy of the memory.
    pub fn memory(&self) -> Memory<R> {
        match self {
            Self::Sbdf2(scheme) => Memory::Sbdf2(scheme.memory.clone()),
            Self::Rk2(scheme) => Memory::Rk2(scheme.u_hat.clone()),
        }
    }

    /// Return whether `memory` is of this scheme and size, and its numbers are finite.
    pub fn fits(&self, memory: &Memory<R>) -> bool {
        match (self, memory) {
            (Self::Sbdf2(scheme), Memory::Sbdf2(memory)) => {
                memory.has_shape_of(&scheme.memory) && memory.inv_tau.is_finite()
            }
            (Self::Rk2(scheme), Memory::Rk2(u_hat)) => {
                u_hat.iter().zip(&scheme.u_hat).all(|(theirs, own)| theirs.len() == own.len())
            }
            _ => false,
        }
    }

    /// Copy the memory to `memory`, which [`Self::fits`]; allocates nothing.
    pub fn save(&self, memory: &mut Memory<R>) {
        match (self, memory) {
            (Self::Sbdf2(scheme), Memory::Sbdf2(memory)) => memory.copy_from(&scheme.memory),
            (Self::Rk2(scheme), Memory::Rk2(u_hat)) => copy(u_hat, &scheme.u_hat),
            _ => {}
        }
    }

    /// Copy the memory from `memory`, which [`Self::fits`].
    pub fn restore(&mut self, memory: &Memory<R>) {
        match (self, memory) {
            (Self::Sbdf2(scheme), Memory::Sbdf2(memory)) => scheme.memory.copy_from(memory),
            (Self::Rk2(scheme), Memory::Rk2(u_hat)) => copy(&mut scheme.u_hat, u_hat),
            _ => {}
        }
    }

    /// Return the longest step that is stable with the bodies, s; none if there is no limit.
    pub fn longest_step(&self, problem: &Problem) -> Option<f64> {
        match self {
            Self::Sbdf2(_) => None,
            Self::Rk2(_) => Some(rk2::longest_step(&problem.bodies)),
        }
    }

    /// Start from the divergence-free part of the velocity in `work.w`.
    pub fn start(&mut self, flow: &mut Flow<R>, present: &mut Present, problem: &mut Problem, work: &mut Work<R>) {
        present.step = 0.0;
        match self {
            Self::Sbdf2(scheme) => scheme.start(flow, present, problem, work),
            Self::Rk2(scheme) => scheme.start(flow, present, problem, work),
        }
    }

    /// Make a step, and return where the beams are predicted to be after it if that was asked for and found.
    ///
    /// After an error only the bodies have changed: they are at the end of the step.
    pub fn step(
        &mut self,
        step: Substep,
        flow: &mut Flow<R>,
        present: &mut Present,
        problem: &mut Problem,
        work: &mut Work<R>,
    ) -> Result<Option<PredictedBeams>, Error> {
        match self {
            Self::Sbdf2(scheme) => scheme.step(step, flow, present, problem, work),
            Self::Rk2(scheme) => scheme.step(step, flow, present, problem, work).map(|()| None),
        }
    }

    /// Write the loads on the stations in a coming step of the same length in which the stations keep their velocities.
    ///
    /// Implicit drag acts on the beams where that step ends, at `predicted`: at their present places the loads would be
    /// late by a step, and the exchange would feed the rod. Explicit drag acts at their present places.
    pub fn predict_loads(
        &self,
        predicted: Option<PredictedBeams>,
        flow: &Flow<R>,
        present: &Present,
        problem: &mut Problem,
        loads: &mut [Loads],
    ) {
        match self {
            Self::Sbdf2(scheme) => scheme.predict_loads(predicted, flow, present, problem, loads),
            Self::Rk2(_) => rk2::predict_loads(flow, present, &mut problem.bodies, loads),
        }
    }

    /// Return Pi at the present time (m²/s²), which makes the rate of change free of divergence.
    pub fn total_pressure<'a>(
        &self,
        flow: &Flow<R>,
        present: &Present,
        problem: &mut Problem,
        work: &'a mut Work<R>,
    ) -> &'a [R] {
        let cfl = present.cfl(present.step);
        if let Self::Rk2(_) = self {
            // The velocity in it has no divergence.
            rk2::add_rate_of_change(present.time, flow, 1.0, problem, &mut work.w);
        }
        let Work { spectral, projection, w } = work;
        let pressure = match self {
            Self::Sbdf2(scheme) => spectral.pressure(projection, &scheme.memory.w, scheme.memory.inv_tau, cfl),
            Self::Rk2(_) => spectral.pressure(projection, w, 1.0, cfl),
        };
        pressure.write(&mut w[0]);
        &w[0]
    }
}

fn copy<T: Copy>(to: &mut [Vec<T>; 2], from: &[Vec<T>; 2]) {
    to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
}
