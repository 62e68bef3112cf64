//! Two grids as the coarse flow of a finer one.

use std::ops::Range;
use std::ptr;

use line_fft::{Real, ThreadTeam};

use super::TwoGrids;
use super::levels::{Below, CoarseScheme};
use super::transfer::Transfer;
use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::present::Present;
use crate::problem::Problem;
use crate::space::Space;
use crate::spectral::Transforms;
use crate::state::TwoStep;
use crate::step::{DomainReader, Scheme, Substep, static_pressure};

impl<R: Real, T: Transforms<R, D>, S: CoarseScheme<R, D>, const D: usize> TwoGrids<R, T, S, D>
where
    [f64; D]: Space<D>,
{
    /// The same as the coarse flow of a finer one.
    pub fn below(self) -> Self {
        let force = self.fine.two_step().w.each_ref().map(|w| Field::uniform(R::zero(), w.len()));
        let below = Below { force, link: self.coarse.link.clone(), has_stepped: false };
        Self { below: Some(below), ..self }
    }
}

impl<R: Real, T: Transforms<R, D>, S: CoarseScheme<R, D>, const D: usize> CoarseScheme<R, D> for TwoGrids<R, T, S, D>
where
    [f64; D]: Space<D>,
{
    fn two_step(&self) -> &TwoStep<R, D> {
        self.fine.two_step()
    }

    fn take_back(&mut self, flow: &mut Flow<R, D>, two_steps_earlier: &Flow<R, D>, inv_tau: f64, step_before: f64) {
        self.fine.take_back(flow, two_steps_earlier, inv_tau, step_before);
    }

    fn save_below(&mut self) {
        let Self { below, coarse, .. } = self;
        below.iter_mut().for_each(|below| below.link.copy_from(&coarse.link));
    }

    fn undo_below(&mut self) {
        let Self { below, coarse, .. } = self;
        let Some(below) = below else { return };
        if below.has_stepped { coarse.undo() } else { coarse.link.copy_from(&below.link) }
    }

    fn force_mut(&mut self) -> Option<&mut [Field<R>; D]> {
        self.below.as_mut().map(|below| &mut below.force)
    }

    /// Write −I G_c to the given acceleration of the fine flow.
    fn find_g(&mut self, team: &ThreadTeam) {
        self.coarse.interpolate_at(0.0);
        self.write_source(team, false);
    }

    fn g(&self, flow: &Flow<R, D>, axis: usize, point: usize) -> f64 {
        let of_coarse = self.fine.source().map_or(0.0, |source| source[axis][point].to_f64());
        self.fine.g(flow, axis, point) - of_coarse
    }

    fn step_in_place(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error> {
        let is_behind = self.coarse.is_behind(step.dt);
        self.below.iter_mut().for_each(|below| below.has_stepped = is_behind);
        if !is_behind {
            return self.step_fine(step, flow, present, problem);
        }
        self.step_coarse(step, flow, present)?;
        self.step_fine(step, flow, present, problem).inspect_err(|_| self.coarse.undo())
    }

    fn follow(&mut self, flow: &mut Flow<R, D>, present: &Present<D>, problem: &Problem<D>) {
        if self.coarse.is_behind(present.step) {
            self.move_after(flow, present, problem);
            let way = self.way_of_followed(problem, &present.flexible.stations);
            self.coarse.follow(way);
        }
    }

    fn read_around(
        &mut self,
        finer: &dyn Fn(usize) -> Option<f64>,
        flow: &Flow<R, D>,
        present: &Present<D>,
        problem: &mut Problem<D>,
        read: &mut DomainReader,
    ) {
        self.total_pressure(flow, present, problem);
        let Self { fine, coarse, .. } = self;
        let pi = fine.source().map_or(&[][..], |source| &source[0]);
        coarse.read_in_domain(|own| finer(own).unwrap_or_else(|| static_pressure(pi, flow, own)), read);
    }

    fn for_each_around<'a>(
        &'a self,
        transfer: &Transfer<D>,
        flow: &'a Flow<R, D>,
        points: Range<usize>,
        mut visit: impl FnMut(&'a Flow<R, D>, usize, Option<usize>),
    ) {
        self.for_each_in_domain(flow, points, |of, own| {
            let finer = if ptr::eq(of, flow) { transfer.in_box(own) } else { None };
            visit(of, own, finer);
        });
    }
}
