//! The time schemes. A step makes the next flow in arrays of its own and swaps them with the present flow if it is
//! accepted.

mod rk2;
mod sbdf2;
mod substep;

use line_fft::Real;

use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::present::Present;
use crate::problem::Problem;
use crate::space::Space;
use crate::state::Memory;

pub use rk2::Rk2;
pub use sbdf2::Sbdf2;
pub use substep::Substep;

/// A time scheme with its memory of earlier steps and its work space.
pub trait Scheme<R: Real, const D: usize>: Send
where
    [f64; D]: Space<D>,
{
    /// Return the number of threads that share a step.
    fn threads(&self) -> usize;

    /// Return a copy of the memory.
    fn memory(&self) -> Memory<R, D>;

    /// Return whether `memory` is of this scheme and size, and its numbers are finite.
    fn fits(&self, memory: &Memory<R, D>) -> bool;

    /// Copy the memory to `memory`, which [`Self::fits`]; allocates nothing.
    fn save(&self, memory: &mut Memory<R, D>);

    /// Copy the memory from `memory`, which [`Self::fits`].
    fn restore(&mut self, memory: &Memory<R, D>);

    /// Return the longest step that is stable with the bodies, s; none if there is no limit.
    fn longest_step(&self, _: &Problem<D>) -> Option<f64> {
        None
    }

    /// Return room for the velocity from which [`Self::start`] starts, m/s. Nothing in it has a meaning between calls.
    fn room(&mut self) -> &mut [Field<R>; D];

    /// Start from the divergence-free part of the velocity in [`Self::room`].
    fn start(&mut self, flow: &mut Flow<R, D>, present: &mut Present<D>, problem: &mut Problem<D>);

    /// Make a step. After an error only the bodies have changed: they are at the end of the step.
    ///
    /// # Errors
    /// [`Error::Markers`] and [`Error::Diverged`].
    fn step(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error>;

    /// Write the loads on the stations in a coming step of the same length in which the stations keep their velocities.
    ///
    /// Implicit drag acts on the bodies where that step ends: at their present places the loads would be late by a step,
    /// and the exchange would feed the rod. Explicit drag acts at their present places.
    fn predict_loads(&self, flow: &Flow<R, D>, present: &mut Present<D>, problem: &mut Problem<D>);

    /// Return Pi at the present time (m²/s²), which makes the rate of change free of divergence.
    fn total_pressure(&mut self, flow: &Flow<R, D>, present: &Present<D>, problem: &mut Problem<D>) -> &[R];

    /// Return the divergence of a velocity (m/s), 1/s.
    fn divergence(&mut self, velocity: &[Field<R>; D]) -> &[R];
}
