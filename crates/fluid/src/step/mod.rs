//! The time schemes. A step makes the next flow in arrays of its own and swaps them with the present flow if it is
//! accepted.

mod rk2;
mod sbdf2;
mod substep;

use std::borrow::Cow;
use std::ops::Range;

use line_fft::Real;

use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::present::Present;
use crate::problem::Problem;
use crate::space::Space;
use crate::state::Memory;

pub use rk2::Rk2;
pub use sbdf2::{Differences, Sbdf2};
pub use substep::Substep;

/// Return `Pi − u²/2` (m²/s²) at a point.
pub fn static_pressure<R: Real, const D: usize>(pi: &[R], flow: &Flow<R, D>, point: usize) -> f64 {
    pi[point].to_f64() - 0.5 * square(flow.velocity_at(point))
}

/// Return the square of a vector.
pub fn square<const D: usize>(vector: [f64; D]) -> f64 {
    vector[1..].iter().fold(vector[0] * vector[0], |sum, component| sum + component * component)
}

/// A velocity to start from, m/s, at a point of a grid.
pub type StartVelocity<'a, const D: usize> = dyn Fn(&Grid<D>, usize) -> [f64; D] + 'a;

/// Write a velocity at all points of a grid.
pub fn fill<R: Real, const D: usize>(to: &mut [Field<R>; D], velocity: &StartVelocity<D>, grid: &Grid<D>) {
    for point in 0..grid.len() {
        for (to, u) in to.iter_mut().zip(velocity(grid, point)) {
            to[point] = R::rounded(u);
        }
    }
}

/// Reads the static pressure over the density, given at a point of the domain.
pub type DomainReader<'a> = dyn FnMut(&dyn Fn(usize) -> f64) + 'a;

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

    /// Put the grids of boxes to where the bodies are, or by ways (m) from where they began, before the first step.
    fn place_grids(&mut self, _: &[[f64; D]], _: &mut Flow<R, D>, _: &Present<D>, _: &Problem<D>) {}

    /// Return the ways that the grids of boxes have moved, m, the finest first.
    fn ways(&self) -> Vec<[f64; D]> {
        vec![]
    }

    /// Return the way that the grid of the bodies has moved, m, or that of another memory.
    fn way(&self, _: Option<&Memory<R, D>>) -> [f64; D] {
        [0.0; D]
    }

    /// Return the longest step that is stable with the bodies, s; none if there is no limit.
    fn longest_step(&self, _: &Problem<D>) -> Option<f64> {
        None
    }

    /// Start from the divergence-free part of a velocity.
    fn start(
        &mut self,
        velocity: &StartVelocity<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    );

    /// Make a step. After an error only the bodies have changed: they are at the end of the step.
    ///
    /// # Errors
    /// [`Error::Contact`], [`Error::Markers`] and [`Error::Diverged`].
    fn step(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error>;

    /// Write the loads on stations and bodies in a coming step of `dt` seconds in which these keep their velocities.
    ///
    /// Implicit drag acts on the bodies where that step ends: at their present places the loads would be late by a step,
    /// and the exchange would feed the rod. Explicit drag acts at their present places.
    fn predict_loads(&mut self, dt: f64, flow: &Flow<R, D>, present: &mut Present<D>, problem: &mut Problem<D>);

    /// Return Pi at the present time (m²/s²), which makes the rate of change free of divergence.
    fn total_pressure(&mut self, flow: &Flow<R, D>, present: &Present<D>, problem: &mut Problem<D>) -> &[R];

    /// Call `read` with the static pressure over the density, `Pi − u²/2` (m²/s²), at a point of the domain.
    fn read_in_domain(
        &mut self,
        flow: &Flow<R, D>,
        present: &Present<D>,
        problem: &mut Problem<D>,
        read: &mut DomainReader,
    ) {
        let pi = self.total_pressure(flow, present, problem);
        read(&|point| static_pressure(pi, flow, point));
    }

    /// Call `visit` with some points of the domain, in ascending order, by the flow there and the point of its own grid.
    fn for_each_in_domain<'a>(
        &'a self,
        flow: &'a Flow<R, D>,
        points: Range<usize>,
        mut visit: impl FnMut(&'a Flow<R, D>, usize),
    ) {
        points.for_each(|point| visit(flow, point));
    }

    /// Call `visit` with some points of the domain, in ascending order, by the flow around the grid of the bodies.
    fn for_each_in_coarse<'a>(
        &'a self,
        flow: &'a Flow<R, D>,
        points: Range<usize>,
        visit: impl FnMut(&'a Flow<R, D>, usize),
    ) {
        self.for_each_in_domain(flow, points, visit);
    }

    /// Return a component of the velocity on each grid, m/s, that of the bodies first, at a time (s) before the end of the
    /// `last` step (s) of `flow`: coarser flows may be ahead.
    fn velocities<'a>(&'a self, flow: &'a Flow<R, D>, axis: usize, _: f64, _last: f64) -> Vec<Cow<'a, [f64]>> {
        vec![R::field_to_f64(&flow.velocity[axis])]
    }

    /// Return the flow that has all points of the domain.
    fn of_domain<'a>(&'a self, flow: &'a Flow<R, D>) -> &'a Flow<R, D> {
        flow
    }

    /// Return a field of the flow over the domain, copied only if it is not in one piece and precision.
    fn over_domain<'a>(&'a self, flow: &'a Flow<R, D>, of: impl Fn(&'a Flow<R, D>) -> &'a Field<R>) -> Cow<'a, [f64]> {
        R::field_to_f64(of(flow))
    }

    /// Return the divergence of a velocity (m/s), 1/s.
    fn divergence(&mut self, velocity: &[Field<R>; D]) -> &[R];
}
