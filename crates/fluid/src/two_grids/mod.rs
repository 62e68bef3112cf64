//! Two grids: a box of fine cells around the bodies in a domain of coarse cells.
//!
//! The coarse flow U fills the domain, the fine flow u the box. With N = omega × u, the coarse G_c = ∇P − nu ∇²U + r U,
//! cubic splines I from the coarse to the fine points, and their adjoint S,
//!
//! ```text
//! ∂U/∂t + N(U) + G_c = m,      m = S (f + d + W u'/T)                                  on coarse cells
//! ∂u/∂t + N(u) + ∇p' − nu ∇²u' + r u' = f − d − I (G_c − ∇q),    u' = u − I U, ∇·u' = 0      on fine cells
//! ```
//!
//! f is the force of the bodies. The correction u' is what the coarse cells cannot carry: it is periodic in the box, because
//! the rim damps it (d) and gives what it takes to U, and it fades, because U receives the same force and, at the rate 1/T
//! inside the rim (W), what is left. The bodies, their forces and all that is read of the flow see the sum u alone, on which
//! the exchange has no direct effect: what U receives leaves u' by definition.
//!
//! The pressure q of m, were the box periodic, is in G_c and taken off: p' has the pressure of f at once, and only the
//! difference between the box and the domain comes with the coarse step. Were all of it late, thin bodies would be unstable.
//!
//! Both are stepped by [`Sbdf2`], U with steps as much longer as its cells are larger, ahead of u and linear between its
//! steps, under the mean force of the last of them.
//!
//! The box follows a body, or a point that the master moves, by whole coarse cells. The correction u', its pressure and the bodies are periodic and stay in
//! place: in all stored flows the cells that the box leaves become those that it newly covers, with another coarse flow.

mod coarse;
mod levels;
mod nested;
mod patch;
mod transfer;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use line_fft::{Real, ThreadTeam, nothing, run};

use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::parameters::{FineBox, Followed, Parameters};
use crate::present::Present;
use crate::problem::Problem;
use crate::space::{Space, Vector};
use crate::spectral::{AdvectionRate, Transforms};
use crate::state::{Memory, TwoGridsMemory, TwoStep};
use crate::step::{Differences, DomainReader, Sbdf2, Scheme, StartVelocity, Substep};
use contact::Stations;

use coarse::{Background, Coarse};
use levels::Below;
pub use levels::CoarseScheme;
use transfer::Rows;

/// Distance from its place in the box at which a followed body moves the box, coarse cells. A body that goes to and fro less
/// than twice the rest to one does not.
const SLACK: f64 = 0.6;

/// Rate of the damping at the end of the box, times the time in which the fastest flow crosses a coarse cell. Half and
/// twice as much move no drag, lift or frequency of `studies/two_grids.py` by more than 0.3 % at a ratio of 2.
const DAMPING: f64 = 3.0;

/// Most components of the vorticity.
const MOST: usize = 3;

/// A fine flow in a coarse one.
pub struct TwoGrids<R: Real, T, S, const D: usize>
where
    [f64; D]: Space<D>,
{
    fine: Sbdf2<R, T, D>,
    coarse: Coarse<R, T, S, D>,
    /// Absent where no finer flow has this one as its coarse one.
    below: Option<Below<R, D>>,
    spacing: [f64; D],
    ratio: f64,
    /// Largest CFL number of a step.
    max_cfl: f64,
    /// What the box follows, and its place where the box has not moved, m.
    follows: Option<(Followed, Vector<D>)>,
    /// Coarse cells along each axis by which the box may move back and forth, between walls and zones.
    range: [[f64; 2]; D],
    /// By point along each axis: the share of the damping's rate, W, and what the damping leaves in a step.
    damping: [Vec<f64>; D],
    window: [Vec<f64>; D],
    left: [Vec<f64>; D],
    /// Restrictions of each fine plane across x, by component.
    of_planes: Vec<f64>,
    /// Restriction of what the damping takes in a step, times its length, m/s.
    damped: Vec<f64>,
    /// Room of each thread.
    room: Vec<Room>,
    /// Coefficients of the coarse pressure.
    pressure: Vec<f64>,
}

#[derive(Clone)]
struct Room {
    rows: Rows,
    /// Fine values of a row that are restricted, and the restriction along the last axis.
    row: Vec<f64>,
    of_row: Vec<f64>,
}

impl<R: Real, T: Transforms<R, D>, S: CoarseScheme<R, D>, const D: usize> TwoGrids<R, T, S, D>
where
    [f64; D]: Space<D>,
{
    /// A uniform flow on both grids, with the bodies of a problem at t = 0. The box may move by a `range` of coarse cells
    /// back and forth along each axis; `scheme` is that of the coarse flow.
    pub fn new(
        parameters: &Parameters<D>,
        fine: &FineBox<D>,
        range: [[f64; 2]; D],
        problem: &Problem<D>,
        scheme: S,
    ) -> Self {
        let (grid, coarse) = (fine.grid(&parameters.grid()), Coarse::new(parameters, fine, scheme));
        let transforms = T::new(&grid, parameters.filter.into(), parameters.threads);
        let threads = transforms.threads();
        let transfer = &coarse.background.transfer;
        let ones = || std::array::from_fn(|axis| vec![1.0; grid.cells[axis]]);
        let stations: Vec<_> = parameters.flexible.iter().map(|body| Stations::at_rest(&body.nodes)).collect();
        let of_plane = transfer.plane_len();
        let room =
            Room { rows: transfer.rows(), row: vec![0.0; grid.cells[D - 1]], of_row: vec![0.0; transfer.row_len()] };
        let mut own = Self {
            spacing: grid.spacing,
            ratio: fine.ratio as f64,
            max_cfl: parameters.max_cfl,
            follows: fine.follows.map(|body| (body, problem.place_of(body, &stations))),
            range,
            damping: ones(),
            window: ones(),
            left: ones(),
            of_planes: vec![0.0; transfer.planes() * D * of_plane],
            damped: vec![0.0; D * transfer.len()],
            room: vec![room; threads],
            pressure: vec![0.0; transfer.len()],
            fine: Sbdf2::new(transforms, grid.len()).with_source(),
            below: None,
            coarse,
        };
        own.place_rim();
        own
    }

    /// Put damping and W to where the box is.
    fn place_rim(&mut self) {
        let Self { coarse: Coarse { background: Background { transfer, .. }, .. }, damping, window, .. } = self;
        for (axis, (damping, window)) in damping.iter_mut().zip(window).enumerate() {
            for (point, (damping, window)) in damping.iter_mut().zip(window).enumerate() {
                let distance = transfer.distance_from_end(axis, point);
                *damping = smooth_step(distance / FineBox::<D>::RIM);
                *window = 1.0 - smooth_step((distance - FineBox::<D>::RIM) / FineBox::<D>::GROWTH);
            }
        }
    }

    /// Return the coarse cells along an axis by which what the box follows has left its place in it.
    fn cells_left(&self, axis: usize, problem: &Problem<D>, stations: &[Stations<D>]) -> f64 {
        let Some((body, home)) = self.follows else { return 0.0 };
        self.coarse.cells_left(axis, problem.place_of(body, stations)[axis] - home[axis])
    }

    /// Return the way of what the box follows since it was at rest, m.
    fn way_of_followed(&self, problem: &Problem<D>, stations: &[Stations<D>]) -> [f64; D] {
        let way = self.follows.map(|(body, home)| problem.place_of(body, stations) - home);
        way.map_or([0.0; D], Into::into)
    }

    /// Move the box after what it follows, by at most a coarse cell along each axis.
    fn move_after(&mut self, flow: &mut Flow<R, D>, present: &Present<D>, problem: &Problem<D>) {
        for axis in 0..D {
            let (left, moved) =
                (self.cells_left(axis, problem, &present.flexible.stations), self.coarse.link.moved[axis]);
            let to = f64::from(moved) + left.signum();
            let [least, most] = self.range[axis];
            // Not a number is no way.
            let moves = left.abs() > SLACK && (least..=most).contains(&to);
            if !moves {
                continue;
            }
            let forwards = left > 0.0;
            let transfer = &self.coarse.background.transfer;
            // The points of a coarse cell, and the seam at its other end.
            let changing = transfer.points_in(axis, if forwards { 0 } else { transfer.cells()[axis] - 1 });
            let seam = transfer.points_in(axis, usize::from(forwards)).start;
            let all = problem.grid.cells.map(|cells| 0..cells);
            let parts = [changing, seam..seam + 1].map(|along| {
                let mut points = all.clone();
                points[axis] = along;
                points
            });
            parts.iter().for_each(|points| self.add_coarse_at(points, -1.0, flow, present.step));
            self.coarse.shift(axis, forwards);
            self.place_rim();
            parts.iter().for_each(|points| self.add_coarse_at(points, 1.0, flow, present.step));
        }
    }

    /// Add a multiple of the coarse flow to some of the points along each axis, at all stored times, the last `step` (s)
    /// apart. G does not change.
    fn add_coarse_at(&mut self, points: &[Range<usize>; D], factor: f64, flow: &mut Flow<R, D>, step: f64) {
        let Self { fine, coarse, room, .. } = self;
        let TwoStep { before, earlier, w, step_before, .. } = fine.two_step_mut();
        for (after, flow, mut w) in [(0.0, flow, Some(w)), (-step, before, None), (-step - *step_before, earlier, None)]
        {
            coarse.interpolate_at(after);
            for (component, field) in flow.fields_mut().enumerate() {
                let mut w = w.as_mut().and_then(|w| w.get_mut(component));
                coarse.background.for_each_of(component, points, &mut room[0].rows, |point, value| {
                    let add = |field: &mut Field<R>| field[point] = R::rounded(field[point].to_f64() + factor * value);
                    add(field);
                    w.as_deref_mut().into_iter().for_each(add);
                });
            }
        }
    }

    /// Return the greatest rate at which the fastest flow crosses a coarse cell, 1/s. An exchange at half and at twice this
    /// rate moves the same numbers by at most 0.4 %.
    fn crossing_rate(&self, present: &Present<D>) -> f64 {
        present.advection_rate / self.ratio
    }

    /// Find the force on the coarse fluid: the mean since its last step, and W u' over the time of crossing a cell.
    fn gather(&mut self, team: &ThreadTeam, flow: &Flow<R, D>, crossing_rate: f64) {
        self.coarse.interpolate_at(0.0);
        let Self { coarse, window, of_planes, room, .. } = self;
        let background = &coarse.background;
        let (transfer, of_plane) = (&background.transfer, background.transfer.plane_len());
        let planes = points_of_planes(&flow.velocity, transfer.planes());
        let parts = planes.zip(of_planes.chunks_exact_mut(D * of_plane)).enumerate();
        team.share_with(room, nothing, parts, |(plane, (velocity, of_planes)), Room { rows, row: own, of_row }| {
            let sums = of_planes.chunks_exact_mut(of_plane);
            for ((axis, velocity), sums) in velocity.into_iter().enumerate().zip(sums) {
                sums.fill(0.0);
                let values = transfer.interpolate(background.component(axis), plane, rows);
                let length = own.len();
                let lines = velocity.chunks_exact(length).zip(values.chunks_exact(length));
                for (row, (velocity, values)) in lines.enumerate() {
                    let of_rows = across(window, plane, row);
                    for (((own, u), coarse), w) in own.iter_mut().zip(velocity).zip(values).zip(&window[D - 1]) {
                        *own = of_rows * w * (u.to_f64() - coarse);
                    }
                    transfer.restrict_row(row, own, 0..0, of_row, sums);
                }
            }
        });
        let Coarse { background: Background { transfer, .. }, link, .. } = coarse;
        let (length, mean) = (transfer.len(), if link.elapsed > 0.0 { 1.0 / link.elapsed } else { 0.0 });
        for axis in 0..D {
            let (force, impulse) = (&mut link.force[axis * length..][..length], &mut link.impulse[axis * length..]);
            force.iter_mut().zip(&*impulse).for_each(|(force, impulse)| *force = mean * impulse);
            let planes = of_planes.chunks_exact(D * of_plane).map(|of| &of[axis * of_plane..][..of_plane]);
            transfer.restrict_planes(planes, crossing_rate, force);
        }
        link.impulse.fill(0.0);
        link.elapsed = 0.0;
    }

    /// Write −I G_c, and with `all` what a finer flow gives, to the given acceleration of the fine flow.
    fn write_source(&mut self, team: &ThreadTeam, all: bool) {
        let Self { fine, coarse, below, room, .. } = self;
        let force = below.as_ref().filter(|_| all).map(|below| &below.force);
        let Some(source) = fine.source_mut() else { return };
        let background = &coarse.background;
        let (transfer, first) = (&background.transfer, D + <[f64; D]>::VORTICITY);
        let parts = points_of_planes_mut(source, transfer.planes()).enumerate();
        team.share_with(room, nothing, parts, |(plane, source), Room { rows, .. }| {
            for (axis, source) in source.into_iter().enumerate() {
                let values = transfer.interpolate(background.component(first + axis), plane, rows);
                source.iter_mut().zip(values).for_each(|(source, g)| *source = R::rounded(-g));
                if let Some(force) = force {
                    let force = &force[axis][plane * source.len()..];
                    let both = source.iter_mut().zip(force);
                    both.for_each(|(source, m)| *source = R::rounded(source.to_f64() + m.to_f64()));
                }
            }
        });
    }

    /// Take I U off `w` = u* + tau G, damp what is left of u* in the rim, and restrict what that takes in a step of `dt`
    /// with c_0 (1/s), and what a finer flow gives.
    fn take_off(&mut self, team: &ThreadTeam, flow: &Flow<R, D>, c_0: f64, dt: f64, crossing_rate: f64) {
        for (left, share) in self.left.iter_mut().flatten().zip(self.damping.iter().flatten()) {
            *left = 1.0 / (1.0 + DAMPING * crossing_rate * share / c_0);
        }
        let Self { fine, coarse, below, left, of_planes, damped, room, .. } = self;
        let force = below.as_ref().map(|below| &below.force);
        let background = &coarse.background;
        let (transfer, of_plane) = (&background.transfer, background.transfer.plane_len());
        let (w, last, inv_tau) = fine.w_and_last();
        let (share, points) = (inv_tau / c_0, w[0].len() / transfer.planes());
        let planes = points_of_planes_mut(w, transfer.planes());
        let parts = planes.zip(of_planes.chunks_exact_mut(D * of_plane)).enumerate();
        team.share_with(room, nothing, parts, |(plane, (w, of_planes)), Room { rows, row: own, of_row }| {
            let sums = of_planes.chunks_exact_mut(of_plane);
            for ((axis, w), sums) in w.into_iter().enumerate().zip(sums) {
                sums.fill(0.0);
                let (last, velocity) = (&last[axis][plane * points..], &flow.velocity[axis][plane * points..]);
                let values = transfer.interpolate(background.component(axis), plane, rows);
                w.iter_mut().zip(values).for_each(|(w, coarse)| *w = R::rounded(w.to_f64() - coarse));
                for (row, w) in w.chunks_exact_mut(own.len()).enumerate() {
                    let known = row * own.len()..(row + 1) * own.len();
                    let force = force.map(|force| &force[axis][plane * points..][known.clone()]);
                    let (last, velocity) = (&last[known.clone()], &velocity[known]);
                    let of_rows = across(left, plane, row);
                    let nothing = if of_rows == 1.0 { transfer.between_rims(FineBox::<D>::RIM) } else { 0..0 };
                    force.iter().for_each(|_| own.fill(0.0));
                    for cells in [0..nothing.start, nothing.end..transfer.cells()[D - 1]] {
                        for k in cells.flat_map(|cell| transfer.points_in(D - 1, cell)) {
                            let tau_g = share * (last[k].to_f64() - velocity[k].to_f64());
                            own[k] = (1.0 - of_rows * left[D - 1][k]) * (w[k].to_f64() - tau_g);
                            w[k] = R::rounded(w[k].to_f64() - own[k]);
                        }
                    }
                    let nothing = if let Some(force) = force {
                        own.iter_mut().zip(force).for_each(|(own, m)| *own += m.to_f64() / c_0);
                        0..0
                    } else {
                        nothing
                    };
                    transfer.restrict_row(row, own, nothing, of_row, sums);
                }
            }
        });
        damped.fill(0.0);
        for (axis, damped) in damped.chunks_exact_mut(transfer.len()).enumerate() {
            let planes = of_planes.chunks_exact(D * of_plane).map(|of| &of[axis * of_plane..][..of_plane]);
            transfer.restrict_planes(planes, c_0 * dt, damped);
        }
    }

    /// Add the coarse flow to the new fine one and to `w`, and return the advection rate of the sum, 1/s.
    fn add_coarse(&mut self, team: &ThreadTeam) -> f64 {
        let Self { fine, coarse, room, spacing, .. } = self;
        let background = &coarse.background;
        let (transfer, (w, next)) = (&background.transfer, fine.solved());
        let planes = transfer.planes();
        let inv_spacing = spacing.map(|spacing| R::rounded(1.0 / spacing));
        let largest = AtomicU64::new(0);
        let points = next.velocity[0].len() / planes;
        let mut vorticity = next.vorticity.iter_mut().map(|of| of.chunks_exact_mut(points));
        let mut vorticity: [_; MOST] = std::array::from_fn(|_| vorticity.next());
        let mut of_plane = || vorticity.each_mut().map(|planes| planes.as_mut().and_then(Iterator::next));
        let parts = points_of_planes_mut(w, planes).zip(points_of_planes_mut(&mut next.velocity, planes));
        let parts = parts.map(|(w, velocity)| (w, velocity, of_plane())).enumerate();
        team.share_with(room, nothing, parts, |(plane, (w, mut velocity, vorticity)), Room { rows, .. }| {
            for (axis, (w, u)) in w.into_iter().zip(velocity.iter_mut()).enumerate() {
                let values = transfer.interpolate(background.component(axis), plane, rows);
                for ((w, u), coarse) in w.iter_mut().zip(&mut **u).zip(values) {
                    (*w, *u) = (R::rounded(w.to_f64() + coarse), R::rounded(u.to_f64() + coarse));
                }
            }
            for (component, omega) in vorticity.into_iter().flatten().enumerate() {
                let values = transfer.interpolate(background.component(D + component), plane, rows);
                for (omega, coarse) in omega.iter_mut().zip(values) {
                    *omega = R::rounded(omega.to_f64() + coarse);
                }
            }
            let mut here = R::zero();
            run(AdvectionRate { inv_spacing, velocity: velocity.each_ref().map(|u| &**u), largest: &mut here });
            largest.fetch_max(here.to_f64().to_bits(), Ordering::Relaxed);
        });
        f64::from_bits(largest.into_inner())
    }

    /// Refuse bodies that reach into the rim or where W is not 1.
    fn check_places(&self, time: f64, problem: &Problem<D>, stations: &[Stations<D>]) -> Result<(), Error> {
        let (grid, mut outside) = (&problem.grid, None);
        let mut check = |point: usize| {
            let mut rest = point;
            for axis in (0..D).rev() {
                if self.window[axis][rest % grid.cells[axis]] < 1.0 {
                    outside = Some(point);
                }
                rest /= grid.cells[axis];
            }
        };
        problem.thin.for_each_force(grid, |point, _| check(point));
        problem.bodies.cells().for_each(|cell| check(cell.index));
        let low = grid.moved(&self.way(None)).low();
        let mut place = outside.map(|point| grid.image(point, &low).point(point).to_vec());
        // A body that jumps may be in another period of the box.
        let jumps =
            |axis: usize| self.cells_left(axis, problem, stations).abs() * self.ratio > 0.5 * grid.cells[axis] as f64;
        if let Some((body, _)) = self.follows.filter(|(body, _)| *body != Followed::Master)
            && (0..D).any(jumps)
        {
            place = Some(problem.place_of(body, stations).iter().copied().collect());
        }
        place.map_or(Ok(()), |place| Err(Error::Rim { time, place, rim: FineBox::<D>::RIM + FineBox::<D>::GROWTH }))
    }

    /// Add the forces on the fluid in the step to the impulse.
    fn add_forces(&mut self, scheme: &Differences, dt: f64, flow: &Flow<R, D>, problem: &Problem<D>) {
        let Self { fine, coarse: Coarse { background: Background { transfer, .. }, link, .. }, damped, .. } = self;
        link.impulse.iter_mut().zip(&*damped).for_each(|(impulse, damped)| *impulse += damped);
        let mut add = |point: usize, force: Vector<D>| {
            transfer.restrict_point(point, (force * dt).into(), &mut link.impulse);
        };
        problem.thin.for_each_force(&problem.grid, &mut add);
        let drag = fine.drag(scheme, flow);
        problem.bodies.cells().for_each(|cell| add(cell.index, -drag(cell)));
        link.elapsed += dt;
    }

    /// Make a step of the coarse flow, which the fine one has reached, before its own `step`. [`Coarse::undo`] takes it back.
    fn step_coarse(&mut self, step: &Substep<D>, flow: &Flow<R, D>, present: &Present<D>) -> Result<(), Error> {
        self.coarse.save_for_undo();
        self.gather(step.team, flow, self.crossing_rate(present));
        self.coarse.step(step)
    }

    /// Make the step of the fine flow, which the coarse one has reached.
    fn step_fine(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error> {
        let crossing_rate = self.crossing_rate(present);
        self.coarse.interpolate_at(step.dt);
        self.write_source(step.team, true);
        let scheme = self.fine.solve_in_space(step, flow, present, problem)?;
        self.check_places(step.end, problem, step.stations)?;
        self.take_off(step.team, flow, scheme.c[0], step.dt, crossing_rate);
        // The flow before the last one is lost only if the sum is slow enough.
        let limit = step.limit() - self.coarse.advection_rate(&self.spacing);
        let advection_rate = self.fine.solve_in_fourier_space(step, &scheme, None, limit, present, problem);
        let is_slow = advection_rate <= limit;
        if !is_slow {
            return step.check(advection_rate.max(step.limit() * (1.0 + f64::EPSILON)));
        }
        let advection_rate = self.add_coarse(step.team).max(self.coarse.own_advection_rate());
        self.add_forces(&scheme, step.dt, flow, problem);
        self.coarse.link.ahead -= step.dt;
        self.fine.accept(step, &scheme, flow, present, problem, advection_rate);
        Ok(())
    }
}

impl<R: Real, T: Transforms<R, D>, S: CoarseScheme<R, D>, const D: usize> Scheme<R, D> for TwoGrids<R, T, S, D>
where
    [f64; D]: Space<D>,
{
    fn threads(&self) -> usize {
        self.room.len()
    }

    fn memory(&self) -> Memory<R, D> {
        let (fine, coarse) = (self.fine.two_step().clone(), self.coarse.state());
        Memory::TwoGrids(Box::new(TwoGridsMemory { fine, coarse }))
    }

    fn fits(&self, memory: &Memory<R, D>) -> bool {
        matches!(memory, Memory::TwoGrids(memory)
            if self.fine.two_step().fits(&memory.fine) && self.coarse.fits(&memory.coarse))
    }

    fn save(&self, memory: &mut Memory<R, D>) {
        if let Memory::TwoGrids(memory) = memory {
            memory.fine.copy_from(self.fine.two_step());
            self.coarse.save(&mut memory.coarse);
        }
    }

    fn restore(&mut self, memory: &Memory<R, D>) {
        if let Memory::TwoGrids(memory) = memory {
            self.fine.two_step_mut().copy_from(&memory.fine);
            self.coarse.restore(&memory.coarse);
            self.place_rim();
        }
    }

    fn place_grids(&mut self, ways: &[[f64; D]], flow: &mut Flow<R, D>, present: &Present<D>, problem: &Problem<D>) {
        let moved = std::array::from_fn::<_, D, _>(|axis| {
            let left = match ways.first() {
                Some(way) => self.coarse.cells_left(axis, way[axis]),
                None => self.cells_left(axis, problem, &present.flexible.stations),
            };
            let [least, most] = self.range[axis];
            (f64::from(self.coarse.link.moved[axis]) + left.round()).clamp(least, most) as i32
        });
        let others = ways.get(1..).unwrap_or_default();
        if moved[..] != self.coarse.link.moved || !others.is_empty() {
            let all = problem.grid.cells.map(|cells| 0..cells);
            self.add_coarse_at(&all, -1.0, flow, 0.0);
            self.coarse.place(&moved, self.way_of_followed(problem, &present.flexible.stations), others);
            self.place_rim();
            self.add_coarse_at(&all, 1.0, flow, 0.0);
        }
    }

    fn way(&self, memory: Option<&Memory<R, D>>) -> [f64; D] {
        let link = if let Some(Memory::TwoGrids(memory)) = memory { &memory.coarse.link } else { &self.coarse.link };
        self.coarse.way(link)
    }

    fn ways(&self) -> Vec<[f64; D]> {
        [self.way(None)].into_iter().chain(self.coarse.scheme.ways()).collect()
    }

    fn start(
        &mut self,
        velocity: &StartVelocity<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) {
        let team = &ThreadTeam::alone();
        self.coarse.start(velocity, present.time);
        let background: [_; D] = std::array::from_fn(|axis| {
            let Self { coarse: Coarse { background, .. }, room, .. } = self;
            let (transfer, mut all) = (&background.transfer, vec![]);
            for plane in 0..transfer.planes() {
                all.extend_from_slice(transfer.interpolate(background.component(axis), plane, &mut room[0].rows));
            }
            all
        });
        let low = problem.grid.moved(&self.way(None)).low();
        let correction = |grid: &Grid<D>, point: usize| {
            let u = velocity(&grid.image(point, &low), point);
            std::array::from_fn(|axis| u[axis] - background[axis][point])
        };
        self.fine.start(&correction, flow, present, problem);
        // The flow that was started, and its w, are those of the correction.
        std::mem::swap(flow, self.fine.solved().1);
        present.advection_rate = self.add_coarse(team).max(self.coarse.own_advection_rate());
        std::mem::swap(flow, self.fine.solved().1);
    }

    fn step(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error> {
        self.step_in_place(step, flow, present, problem)?;
        self.follow(flow, present, problem);
        Ok(())
    }

    fn predict_loads(&mut self, dt: f64, flow: &Flow<R, D>, present: &mut Present<D>, problem: &mut Problem<D>) {
        let (team, max_cfl) = (&ThreadTeam::alone(), self.max_cfl);
        let end = present.time + dt;
        let step = Substep {
            dt,
            end,
            stations: &[],
            displacements: &[],
            ends: &[],
            ahead: None,
            max_cfl,
            shortest: 0.0,
            team,
        };
        // A load that is announced is that of the coming step, which may begin with a coarse one.
        let is_ahead =
            problem.bodies.announce() && self.coarse.is_behind(dt) && self.step_coarse(&step, flow, present).is_ok();
        self.coarse.interpolate_at(dt);
        if is_ahead {
            self.coarse.undo();
        }
        self.write_source(team, true);
        self.fine.predict_loads(dt, flow, present, problem);
    }

    fn total_pressure(&mut self, _: &Flow<R, D>, present: &Present<D>, problem: &mut Problem<D>) -> &[R] {
        self.coarse.interpolate_at(0.0);
        let of_force = self.coarse.write_pressure(&mut self.pressure);
        let Self { fine, coarse, room, pressure, .. } = self;
        let (background, rows) = (&coarse.background, &mut room[0].rows);
        let transfer = &background.transfer;
        let pi = fine.pressure_without(present.cfl(present.step), |w| {
            take_off_all(background, w, rows);
        });
        // The pressure of the correction, less that of the force which the coarse flow received, is 0 at the end of the box.
        let plane = problem.grid.len() / transfer.planes();
        let at_end = pi[transfer.points_in(0, 0).start * plane..][..plane].iter().map(|pi| pi.to_f64()).sum::<f64>()
            / plane as f64
            - of_force;
        for (plane, pi) in pi.chunks_exact_mut(plane).enumerate() {
            let values = transfer.interpolate(pressure, plane, rows);
            for (pi, of_coarse) in pi.iter_mut().zip(values) {
                *pi = R::rounded(pi.to_f64() - at_end + of_coarse);
            }
        }
        pi
    }

    fn read_in_domain(
        &mut self,
        flow: &Flow<R, D>,
        present: &Present<D>,
        problem: &mut Problem<D>,
        read: &mut DomainReader,
    ) {
        self.read_around(&|_| None, flow, present, problem, read);
    }

    fn for_each_in_domain<'a>(
        &'a self,
        flow: &'a Flow<R, D>,
        points: Range<usize>,
        mut visit: impl FnMut(&'a Flow<R, D>, usize),
    ) {
        let Coarse { background: Background { transfer, .. }, scheme, .. } = &self.coarse;
        scheme.for_each_around(transfer, self.coarse.flow(), points, |around, point, own| match own {
            Some(own) => visit(flow, own),
            None => visit(around, point),
        });
    }

    fn for_each_in_coarse<'a>(
        &'a self,
        _: &'a Flow<R, D>,
        points: Range<usize>,
        visit: impl FnMut(&'a Flow<R, D>, usize),
    ) {
        self.coarse.scheme.for_each_in_domain(self.coarse.flow(), points, visit);
    }

    fn velocities<'a>(&'a self, flow: &'a Flow<R, D>, axis: usize, before: f64, last: f64) -> Vec<Cow<'a, [f64]>> {
        let (own, Coarse { link, scheme, .. }) =
            (self.fine.two_step().velocity(flow, axis, before, last), &self.coarse);
        let coarser = scheme.velocities(self.coarse.flow(), axis, before + link.ahead, link.length);
        [own].into_iter().chain(coarser).collect()
    }

    fn of_domain<'a>(&'a self, _: &'a Flow<R, D>) -> &'a Flow<R, D> {
        self.coarse.scheme.of_domain(self.coarse.flow())
    }

    fn over_domain<'a>(&'a self, flow: &'a Flow<R, D>, of: impl Fn(&'a Flow<R, D>) -> &'a Field<R>) -> Cow<'a, [f64]> {
        let points = of(self.of_domain(flow)).len();
        let mut field = Vec::with_capacity(points);
        self.for_each_in_domain(flow, 0..points, |flow, own| field.push(of(flow)[own].to_f64()));
        field.into()
    }

    fn divergence(&mut self, velocity: &[Field<R>; D]) -> &[R] {
        self.coarse.interpolate_at(0.0);
        let Self { fine, coarse, room, .. } = self;
        fine.divergence_without(velocity, |w| {
            take_off_all(&coarse.background, w, &mut room[0].rows);
        })
    }
}

/// Take the coarse velocity off `w`.
fn take_off_all<R: Real, const D: usize>(background: &Background<D>, w: &mut [Field<R>; D], rows: &mut Rows) {
    let transfer = &background.transfer;
    for (plane, w) in points_of_planes_mut(w, transfer.planes()).enumerate() {
        for (axis, w) in w.into_iter().enumerate() {
            let values = transfer.interpolate(background.component(axis), plane, rows);
            w.iter_mut().zip(values).for_each(|(w, coarse)| *w = R::rounded(w.to_f64() - coarse));
        }
    }
}

/// Return the product of a row's numbers along all axes but the last.
#[inline(always)]
fn across<const D: usize>(along: &[Vec<f64>; D], plane: usize, row: usize) -> f64 {
    if D == 2 { along[0][plane] } else { along[0][plane] * along[1][row] }
}

/// Return the points of each plane across x, by component.
fn points_of_planes<R, const D: usize>(fields: &[Field<R>; D], planes: usize) -> impl Iterator<Item = [&[R]; D]> {
    let points = fields_len(fields) / planes;
    (0..planes).map(move |plane| fields.each_ref().map(|field| &field[plane * points..][..points]))
}

/// Return the same, to be changed.
fn points_of_planes_mut<R, const D: usize>(
    fields: &mut [Field<R>; D],
    planes: usize,
) -> impl Iterator<Item = [&mut [R]; D]> {
    let points = fields_len(fields) / planes;
    let mut parts = fields.each_mut().map(|field| field.chunks_exact_mut(points));
    (0..planes).map(move |_| parts.each_mut().map(|parts| parts.next().unwrap_or_default()))
}

fn fields_len<R, const D: usize>(fields: &[Field<R>; D]) -> usize {
    fields[0].len()
}

/// Return 1 at 0 and below, 0 at 1 and above, and a cubic between.
fn smooth_step(x: f64) -> f64 {
    let s = 1.0 - x.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_know_the_width_of_the_rim() {
        assert_eq!(FineBox::<2>::RIM + FineBox::<2>::GROWTH, scene::FINE_BOX_RIM_CELLS);
    }
}
