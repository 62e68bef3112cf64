//! The coarse flow, and what the grids exchange.

use std::ops::Range;

use line_fft::{Real, ThreadTeam};

use super::levels::CoarseScheme;
use super::patch::Patch;
use super::transfer::{FilterRoom, Rows, Transfer};
use crate::error::Error;
use crate::flow::Flow;
use crate::parameters::{FineBox, Parameters};
use crate::present::Present;
use crate::problem::Problem;
use crate::space::Space;
use crate::spectral::Transforms;
use crate::state::{CoarseState, Link};
use crate::step::{DomainReader, StartVelocity, Substep};

/// Share of a fine step by which it may end after the coarse flow.
const SAME_TIME: f64 = 1e-9;

/// The coarse flow at a time, under the fine box.
pub struct Background<const D: usize> {
    /// The transfer.
    pub transfer: Transfer<D>,
    /// Coefficients of velocity, vorticity, and G.
    now: Vec<f64>,
}

impl<const D: usize> Background<D> {
    /// Return the coefficients of a component: of the velocity, then the vorticity, then G.
    pub fn component(&self, component: usize) -> &[f64] {
        &self.now[component * self.transfer.len()..][..self.transfer.len()]
    }

    /// Call `visit` with some fine points along each axis and a component there.
    pub fn for_each_of(
        &self,
        component: usize,
        points: &[Range<usize>; D],
        rows: &mut Rows,
        mut visit: impl FnMut(usize, f64),
    ) {
        let length = self.transfer.row_points();
        for plane in points[0].clone() {
            let values = self.transfer.interpolate(self.component(component), plane, rows);
            let first = plane * values.len();
            let own_rows = if D == 2 { 0..1 } else { points[1].clone() };
            for at in own_rows.flat_map(|row| points[D - 1].clone().map(move |column| row * length + column)) {
                visit(first + at, values[at]);
            }
        }
    }
}

/// The coarse flow of the whole domain, at a time when the fine flow has not yet reached it.
pub struct Coarse<R: Real, T, S, const D: usize>
where
    [f64; D]: Space<D>,
{
    /// What the fine flow sees of it.
    pub background: Background<D>,
    /// What is exchanged.
    pub link: Link,
    flow: Flow<R, D>,
    /// On one grid, or on two again.
    pub scheme: S,
    /// The last force with its pressure in the fine box.
    patch: Patch<R, T, D>,
    problem: Problem<D>,
    present: Present<D>,
    /// Fine steps in a coarse one: a gust is known for one alone.
    ratio: usize,
    spacing: [f64; D],
    /// What the last step has lost, for a fine step that fails: the flow two steps earlier, `1/tau` and the step before the
    /// one before, and the link.
    saved: Saved<R, D>,
    room: FilterRoom,
}

/// See [`Coarse`].
struct Saved<R: Real, const D: usize> {
    earlier: Flow<R, D>,
    inv_tau: f64,
    step_before: f64,
    link: Link,
}

impl<R: Real, T: Transforms<R, D>, S: CoarseScheme<R, D>, const D: usize> Coarse<R, T, S, D>
where
    [f64; D]: Space<D>,
{
    /// A uniform flow.
    pub fn new(parameters: &Parameters<D>, fine: &FineBox<D>, scheme: S) -> Self {
        let (grid, velocity) = (parameters.grid(), parameters.initial_velocity);
        let (transfer, flow) = (Transfer::new(&grid, fine), Flow::uniform(velocity, grid.len()));
        let numbers = (2 * D + <[f64; D]>::VORTICITY) * transfer.len();
        let link = Link {
            ends: [vec![0.0; numbers], vec![0.0; numbers]],
            impulse: vec![0.0; D * transfer.len()],
            elapsed: 0.0,
            force: vec![0.0; D * transfer.len()],
            ahead: 0.0,
            length: 0.0,
            step: 0.0,
            advection_rate: 0.0,
            moved: vec![0; D],
        };
        let mut own = Self {
            saved: Saved { earlier: flow.clone(), inv_tau: 0.0, step_before: 0.0, link: link.clone() },
            present: Present::without_bodies(&grid, velocity),
            problem: Problem::new(&parameters.without_bodies()),
            patch: Patch::new(&grid, fine.cells),
            ratio: if parameters.gust.is_some() { 1 } else { fine.ratio },
            spacing: grid.spacing,
            room: FilterRoom::default(),
            background: Background { transfer, now: vec![0.0; numbers] },
            link,
            flow,
            scheme,
        };
        own.write_both_ends();
        own
    }

    /// Start from the divergence-free part of a velocity at a time, s.
    pub fn start(&mut self, velocity: &StartVelocity<D>, time: f64) {
        (self.present.time, self.present.step) = (time, 0.0);
        self.scheme.start(velocity, &mut self.flow, &mut self.present, &mut self.problem);
        (self.link.elapsed, self.link.ahead, self.link.length) = (0.0, 0.0, 0.0);
        self.link.impulse.fill(0.0);
        self.link.force.fill(0.0);
        self.write_both_ends();
    }

    fn write_both_ends(&mut self) {
        self.write_end(&ThreadTeam::alone());
        let [before, end] = &mut self.link.ends;
        before.copy_from_slice(end);
        self.background.now.copy_from_slice(end);
    }

    /// Write the coefficients of the flow to the last end.
    fn write_end(&mut self, team: &ThreadTeam) {
        self.scheme.find_g(team);
        let Self { background: Background { transfer, .. }, link, flow, scheme, patch, room, .. } = self;
        let (of_flow, of_g) = link.ends[1].split_at_mut(flow.fields().count() * transfer.len());
        write_flow(transfer, flow, room, of_flow);
        for (axis, list) in of_g.chunks_exact_mut(transfer.len()).enumerate() {
            let g = |point: usize, place: usize| scheme.g(flow, axis, point) - patch.gradient(axis, place);
            transfer.write_coefficients(g, room, list);
        }
    }

    /// Return the coarse cells, and their part, by which a way (m) is longer than that which the box has moved along an
    /// axis.
    pub fn cells_left(&self, axis: usize, way: f64) -> f64 {
        way / self.spacing[axis] - f64::from(self.link.moved[axis])
    }

    /// Return the way that the box has moved, m.
    pub fn way(&self, link: &Link) -> [f64; D] {
        std::array::from_fn(|axis| f64::from(link.moved[axis]) * self.spacing[axis])
    }

    /// Move the box to where it is after moves by so many coarse cells, before the first step.
    ///
    /// `way` (m) is that of what the box follows, `ways` are those of the boxes around it, if they are given.
    pub fn place(&mut self, moved: &[i32], way: [f64; D], ways: &[[f64; D]]) {
        let Self { scheme, flow, present, problem, .. } = self;
        problem.box_displacement = way;
        scheme.place_grids(ways, flow, present, problem);
        self.link.moved.copy_from_slice(moved);
        self.background.transfer.place(moved);
        self.write_both_ends();
    }

    /// Move the box by a coarse cell along an axis, forwards or backwards, after a step.
    pub fn shift(&mut self, axis: usize, forwards: bool) {
        let Self { background: Background { transfer, .. }, link, .. } = self;
        let Link { ends: [from, to], impulse, force, moved, .. } = link;
        from.iter_mut().zip(to).for_each(|(from, to)| *from -= *to);
        let lists = |all| <[f64]>::chunks_exact_mut(all, transfer.len());
        lists(impulse).chain(lists(force)).for_each(|list| transfer.shift(list, axis, forwards, true));
        lists(from).for_each(|list| transfer.shift(list, axis, forwards, false));
        moved[axis] += if forwards { 1 } else { -1 };
        transfer.place(moved);
        self.take_force();
        self.patch.solve();
        self.write_end(&ThreadTeam::alone());
        let Self { background: Background { transfer, .. }, link, scheme, room, .. } = self;
        let ([from, to], before) = (&mut link.ends, &scheme.two_step().before);
        let first = before.fields().count() * transfer.len();
        from[first..].iter_mut().zip(&to[first..]).for_each(|(from, to)| *from += to);
        write_flow(transfer, before, room, &mut from[..first]);
    }

    /// Let a box that has this flow as its fine one go after a way (m) of what both boxes follow.
    pub fn follow(&mut self, way: [f64; D]) {
        let Self { scheme, flow, present, problem, .. } = self;
        problem.box_displacement = way;
        scheme.follow(flow, present, problem);
    }

    /// Return whether a fine step of `dt` (s) ends after the coarse flow.
    pub fn is_behind(&self, dt: f64) -> bool {
        self.link.ahead < dt * (1.0 - SAME_TIME)
    }

    /// Save everything for [`Self::undo`].
    pub fn save_for_undo(&mut self) {
        self.link.step = self.present.step;
        self.link.advection_rate = self.present.advection_rate;
        let (saved, memory) = (&mut self.saved, self.scheme.two_step());
        saved.earlier.copy_from(&memory.earlier);
        (saved.inv_tau, saved.step_before) = (memory.inv_tau, memory.step_before);
        saved.link.copy_from(&self.link);
        self.scheme.save_below();
    }

    /// Go back to before the step that was made since.
    pub fn undo(&mut self) {
        let Self { saved, flow, scheme, link, present, .. } = self;
        scheme.take_back(flow, &saved.earlier, saved.inv_tau, saved.step_before);
        scheme.undo_below();
        link.copy_from(&saved.link);
        (present.step, present.advection_rate) = (link.step, link.advection_rate);
    }

    /// Return a copy of everything that the next step depends on.
    pub fn state(&self) -> CoarseState<R, D> {
        let (flow, memory) = (self.flow.clone(), self.scheme.memory());
        let mut state = CoarseState { flow, memory, link: self.link.clone() };
        self.save(&mut state);
        state
    }

    /// Copy everything that the next step depends on.
    pub fn save(&self, state: &mut CoarseState<R, D>) {
        state.flow.copy_from(&self.flow);
        self.scheme.save(&mut state.memory);
        state.link.copy_from(&self.link);
        (state.link.step, state.link.advection_rate) = (self.present.step, self.present.advection_rate);
    }

    /// Return whether a state has the same size, and its numbers are finite.
    pub fn fits(&self, state: &CoarseState<R, D>) -> bool {
        self.flow.has_shape_of(&state.flow) && self.scheme.fits(&state.memory) && self.link.has_shape_of(&state.link)
    }

    /// Go to a state that fits.
    pub fn restore(&mut self, state: &CoarseState<R, D>) {
        self.background.transfer.place(&state.link.moved);
        self.flow.copy_from(&state.flow);
        self.scheme.restore(&state.memory);
        self.link.copy_from(&state.link);
        (self.present.step, self.present.advection_rate) = (state.link.step, state.link.advection_rate);
    }

    /// Take over `link.force` as the given acceleration and on the patch.
    fn take_force(&mut self) {
        let Self { background: Background { transfer, .. }, link, scheme, patch, room, .. } = self;
        patch.clear();
        let force = link.force.chunks_exact(transfer.len());
        for (axis, (source, force)) in scheme.force_mut().into_iter().flatten().zip(force).enumerate() {
            source.fill(R::zero());
            transfer.add_to_points(force, room, |point, place, part| {
                source[point] = R::rounded(source[point].to_f64() + part);
                patch.add(axis, place, part);
            });
        }
    }

    /// Make a step under the force `link.force`, as much longer than the fine one as the cells are larger but not shorter.
    /// After an error all is as it was saved.
    ///
    /// # Errors
    /// [`Error::Diverged`].
    pub fn step(&mut self, fine: &Substep<D>) -> Result<(), Error> {
        self.take_force();
        self.patch.solve();
        let Self { link, flow, scheme, problem, present, ratio, saved, .. } = self;
        let longest = fine.max_cfl / present.advection_rate.max(f64::MIN_POSITIVE);
        let dt = (*ratio as f64 * fine.dt).min(longest).max(fine.dt);
        let end = fine.end - fine.dt + link.ahead + dt;
        let step = Substep { dt, end, stations: &[], displacements: &[], ends: &[], ahead: None, ..*fine };
        let is_first = present.step == 0.0;
        scheme.step_in_place(&step, flow, present, problem).inspect_err(|_| link.copy_from(&saved.link))?;
        link.ahead += dt;
        link.length = dt;
        link.ends.swap(0, 1);
        self.write_end(fine.team);
        if is_first {
            // Before the first step nothing is known of G: 0 would be late by a step, and the order in time one.
            let first = (D + <[f64; D]>::VORTICITY) * self.background.transfer.len();
            let [before, end] = &mut self.link.ends;
            before[first..].copy_from_slice(&end[first..]);
        }
        Ok(())
    }

    /// Write the coarse flow at a time (s) after the present one to `now`. Beyond its last step it is continued.
    pub fn interpolate_at(&mut self, after: f64) {
        let Link { ends: [from, to], ahead, length, .. } = &self.link;
        let share = if *length == 0.0 { 1.0 } else { 1.0 - (ahead - after) / length };
        for (now, (from, to)) in self.background.now.iter_mut().zip(from.iter().zip(to)) {
            *now = from + share * (to - from);
        }
    }

    /// Return an upper bound of the advection rate of the coarse velocity on fine cells, 1/s.
    pub fn advection_rate(&self, spacing: &[f64; D]) -> f64 {
        let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
        (0..D).map(|axis| largest(self.background.component(axis)) / spacing[axis]).sum()
    }

    /// Return the advection rate on coarse cells, 1/s: outside the fine box the flow may be faster.
    pub fn own_advection_rate(&self) -> f64 {
        self.present.advection_rate
    }

    /// Return the flow.
    pub fn flow(&self) -> &Flow<R, D> {
        &self.flow
    }

    /// Write Pi of the coarse flow without the pressure of the last force in the fine box as coefficients, and return the
    /// mean of that pressure at the end of the box, both in m²/s².
    pub fn write_pressure(&mut self, coefficients: &mut [f64]) -> f64 {
        self.take_force();
        let Self { background: Background { transfer, .. }, flow, scheme, patch, problem, present, room, .. } = self;
        let (pi, own) = (scheme.total_pressure(flow, present, problem), patch.pressure());
        let outside = |point: usize, place: usize| pi[point].to_f64() - own[place].to_f64();
        transfer.write_coefficients(outside, room, coefficients);
        let plane = &own[..transfer.points_of_patch_plane()];
        plane.iter().map(|pi| pi.to_f64()).sum::<f64>() / plane.len() as f64
    }

    /// Call `read` with the static pressure over the density (m²/s²) at a point of the domain, which in the fine box is
    /// that at a fine point.
    pub fn read_in_domain(&mut self, at_fine: impl Fn(usize) -> f64, read: &mut DomainReader) {
        let Self { background: Background { transfer, .. }, flow, scheme, problem, present, .. } = self;
        let finer = |point: usize| transfer.in_box(point).map(&at_fine);
        scheme.read_around(&finer, flow, present, problem, read);
    }
}

/// Write the coefficients of velocity and vorticity.
fn write_flow<R: Real, const D: usize>(
    transfer: &Transfer<D>,
    flow: &Flow<R, D>,
    room: &mut FilterRoom,
    coefficients: &mut [f64],
) {
    for (field, list) in flow.fields().zip(coefficients.chunks_exact_mut(transfer.len())) {
        transfer.write_coefficients(|point, _| field[point].to_f64(), room, list);
    }
}
