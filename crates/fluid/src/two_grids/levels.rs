//! What can be the coarse flow of two grids: that of one grid here, or of two again in `nested`.

use std::ops::Range;

use line_fft::{Real, ThreadTeam};

use super::transfer::Transfer;
use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::present::Present;
use crate::problem::Problem;
use crate::space::Space;
use crate::spectral::Transforms;
use crate::state::{Link, TwoStep};
use crate::step::{DomainReader, Sbdf2, Scheme, Substep, static_pressure};

/// A scheme of a coarse flow, without bodies.
pub trait CoarseScheme<R: Real, const D: usize>: Scheme<R, D>
where
    [f64; D]: Space<D>,
{
    /// Return what is remembered of the flow's own grid.
    fn two_step(&self) -> &TwoStep<R, D>;

    /// Go back by a step on the flow's own grid; see [`Sbdf2::take_back`].
    fn take_back(&mut self, flow: &mut Flow<R, D>, two_steps_earlier: &Flow<R, D>, inv_tau: f64, step_before: f64);

    /// Save what a step changes on coarser grids.
    fn save_below(&mut self) {}

    /// Go back to before the step that was made since on coarser grids.
    fn undo_below(&mut self) {}

    /// Return the force of a finer flow over the density, m/s², to be set.
    fn force_mut(&mut self) -> Option<&mut [Field<R>; D]>;

    /// Prepare [`Self::g`] at the present time.
    fn find_g(&mut self, _: &ThreadTeam) {}

    /// Return a component of G of the whole flow at a point, m/s².
    fn g(&self, flow: &Flow<R, D>, axis: usize, point: usize) -> f64;

    /// Make a step without moving a box. After an error nothing has changed.
    ///
    /// # Errors
    /// [`Error::Diverged`].
    fn step_in_place(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error>;

    /// Move the boxes after what they follow, if the coarser flows are not ahead.
    fn follow(&mut self, _: &mut Flow<R, D>, _: &Present<D>, _: &Problem<D>) {}

    /// Call `read` with the static pressure over the density (m²/s²) at a point of the domain, which is that of a finer
    /// flow where `finer` knows it at a point of the flow's own grid.
    fn read_around(
        &mut self,
        finer: &dyn Fn(usize) -> Option<f64>,
        flow: &Flow<R, D>,
        present: &Present<D>,
        problem: &mut Problem<D>,
        read: &mut DomainReader,
    );

    /// Call `visit` with some points of the domain, in ascending order, by the flow there, the point of its own grid, and
    /// that of a finer grid if it is in its box.
    fn for_each_around<'a>(
        &'a self,
        transfer: &Transfer<D>,
        flow: &'a Flow<R, D>,
        points: Range<usize>,
        visit: impl FnMut(&'a Flow<R, D>, usize, Option<usize>),
    );
}

impl<R: Real, T: Transforms<R, D>, const D: usize> CoarseScheme<R, D> for Sbdf2<R, T, D>
where
    [f64; D]: Space<D>,
{
    fn two_step(&self) -> &TwoStep<R, D> {
        self.two_step()
    }

    fn take_back(&mut self, flow: &mut Flow<R, D>, two_steps_earlier: &Flow<R, D>, inv_tau: f64, step_before: f64) {
        self.take_back(flow, two_steps_earlier, inv_tau, step_before);
    }

    fn force_mut(&mut self) -> Option<&mut [Field<R>; D]> {
        self.source_mut()
    }

    fn g(&self, flow: &Flow<R, D>, axis: usize, point: usize) -> f64 {
        self.g(flow, axis, point)
    }

    fn step_in_place(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error> {
        self.step(step, flow, present, problem)
    }

    fn read_around(
        &mut self,
        finer: &dyn Fn(usize) -> Option<f64>,
        flow: &Flow<R, D>,
        present: &Present<D>,
        problem: &mut Problem<D>,
        read: &mut DomainReader,
    ) {
        let pi = self.total_pressure(flow, present, problem);
        read(&|point| finer(point).unwrap_or_else(|| static_pressure(pi, flow, point)));
    }

    fn for_each_around<'a>(
        &'a self,
        transfer: &Transfer<D>,
        flow: &'a Flow<R, D>,
        points: Range<usize>,
        mut visit: impl FnMut(&'a Flow<R, D>, usize, Option<usize>),
    ) {
        transfer.for_each_of(points, |point, own| visit(flow, point, own));
    }
}

/// What the flow in a box needs to be the coarse flow of a finer one.
pub struct Below<R: Real, const D: usize> {
    /// Force of the finer flow, m/s².
    pub force: [Field<R>; D],
    /// What is exchanged with the coarser flow, as it was before the step, and whether that flow has made one since.
    pub link: Link,
    pub has_stepped: bool,
}
