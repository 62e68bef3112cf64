//! Two-step backward differences with extrapolated advection.
//!
//! The step is split so that the terms local in space and the terms local in wavenumber are each solved exactly
//! (Douglas–Rachford in incremental form). With the difference coefficients `c_0 … c_2`, the extrapolation `e_1 … e_3`,
//! `tau = 1/c_0`, `N = omega × u` and `G = ∇Pi − nu ∇²u + r u`, r being the rate of the filter,
//!
//! ```text
//! (c_0 + Σ a_b) u*  = c_1 u^n + c_2 u^{n−1} − Σ e_j N^{n+1−j} − G^n + Σ a_b u_b              point by point
//! (1 − tau nu ∇² + tau r) u^{n+1} + tau ∇Pi^{n+1} = u* + tau G^n,   ∇·u^{n+1} = 0         in Fourier space
//! G^{n+1} = c_0 (u* + tau G^n − u^{n+1})                                                  point by point
//! ```
//!
//! The extrapolation is the mean of those through the last two and three times, `2.5, −2, 0.5` in equal steps. Waves in a
//! stream without viscosity are then stable up to `k U dt = 0.67`; by two times alone the shortest grow in any step.
//!
//! The sum of both is the scheme with all terms implicit but `a tau (G^{n+1} − G^n)`, of second order. Both parts are
//! monotone, so neither stiff drag nor viscosity bounds the step; advection does. A step takes five real transforms in the
//! plane, two forward (u* + tau G) and three inverse (u, v, omega), and nine in space.
//!
//! The drag on the bodies in the step is `rho a_b (u* − u_b)`. It is linear in u_b with the slope
//! `−rho a_b (1 − a_b/(c_0 + Σ a))`, which gives the impedance of the loads.

use std::borrow::Cow;
use std::mem::swap;
use std::ops::Range;

use line_fft::{Arithmetic, F64_LANES, Kernel, Real, ThreadTeam, from_f64s, nothing, run, to_f64s};

use super::substep::Substep;
use super::{Scheme, StartVelocity, fill};
use crate::bodies::Cell;
use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::present::Present;
use crate::problem::Problem;
use crate::space::{Scalar, Space, Vector, Wide};
use crate::spectral::{Implicit, Transforms};
use crate::state::{Memory, TwoStep};
use crate::timer::Phase;

/// Most arrays of components: those of the vorticity in space.
const MOST: usize = 3;

/// Part of the extrapolation through three times. A half has the longest stable steps for waves without viscosity: a CFL
/// number of 0.21 in one dimension, none with a part of zero. Zero allows longer ones only at cell Reynolds numbers
/// U Δx/ν below 5 (4: 0.32 beside 0.29, 3: 0.41 and 0.32, 2: 0.61 and 0.39, roots of the scheme for a travelling wave),
/// where the largest `max_cfl`, 0.4, is hardly missed; so the part is the same everywhere.
const QUADRATIC: f64 = 0.5;

/// The scheme with its memory.
pub struct Sbdf2<R: Real, T, const D: usize> {
    memory: TwoStep<R, D>,
    transforms: T,
    /// Velocity that goes into the solve in Fourier space, m/s. Nothing in it has a meaning between steps.
    w: [Field<R>; D],
    /// Given acceleration, m/s²: absent where the fluid is on one grid.
    source: Option<[Field<R>; D]>,
}

impl<R: Real, T: Transforms<R, D>, const D: usize> Sbdf2<R, T, D>
where
    [f64; D]: Space<D>,
{
    /// A scheme without an earlier step.
    pub fn new(transforms: T, points: usize) -> Self {
        let fields = || [(); D].map(|()| Field::uniform(R::zero(), points));
        let [before, earlier] = [(); 2].map(|()| Flow::uniform([0.0; D], points));
        let memory = TwoStep { before, earlier, w: fields(), inv_tau: 0.0, step_before: 0.0 };
        Self { memory, transforms, w: fields(), source: None }
    }

    /// The same with a given acceleration, 0 at first.
    pub fn with_source(self) -> Self {
        let source = self.w.each_ref().map(|w| Field::uniform(R::zero(), w.len()));
        Self { source: Some(source), ..self }
    }

    /// Return the memory.
    pub fn two_step(&self) -> &TwoStep<R, D> {
        &self.memory
    }

    /// Return the memory, to be changed.
    pub fn two_step_mut(&mut self) -> &mut TwoStep<R, D> {
        &mut self.memory
    }

    /// Return the given acceleration, m/s².
    pub fn source(&self) -> Option<&[Field<R>; D]> {
        self.source.as_ref()
    }

    /// Return the given acceleration, m/s², to be set.
    pub fn source_mut(&mut self) -> Option<&mut [Field<R>; D]> {
        self.source.as_mut()
    }

    /// Return a component of G at a point, m/s².
    pub fn g(&self, flow: &Flow<R, D>, axis: usize, point: usize) -> f64 {
        self.memory.inv_tau * (self.memory.w[axis][point].to_f64() - flow.velocity[axis][point].to_f64())
    }

    /// Return `w`, that of the last step, and `1/tau` of the last step.
    pub fn w_and_last(&mut self) -> (&mut [Field<R>; D], &[Field<R>; D], f64) {
        (&mut self.w, &self.memory.w, self.memory.inv_tau)
    }

    /// Return `w` and the flow that [`Self::solve_in_fourier_space`] makes of it.
    pub fn solved(&mut self) -> (&mut [Field<R>; D], &mut Flow<R, D>) {
        (&mut self.w, &mut self.memory.earlier)
    }

    /// Return Pi (m²/s²) that belongs to `w` of the last step less a velocity, which `take_off` is to take off it. It is
    /// in the place of the given acceleration.
    pub fn pressure_without(&mut self, cfl: f64, take_off: impl FnOnce(&mut [Field<R>; D])) -> &mut [R] {
        let Self { memory, transforms, w, source } = self;
        w.iter_mut().zip(&memory.w).for_each(|(w, last)| w.copy_from_slice(last));
        take_off(w);
        let Some(pressure) = source.iter_mut().flatten().next() else { return &mut [] };
        transforms.pressure(w, memory.inv_tau, cfl, pressure);
        pressure
    }

    /// Return the divergence (1/s) of a velocity less another, which `take_off` is to take off it, in the same place.
    pub fn divergence_without(
        &mut self,
        velocity: &[Field<R>; D],
        take_off: impl FnOnce(&mut [Field<R>; D]),
    ) -> &mut [R] {
        let Self { transforms, w, source, .. } = self;
        w.iter_mut().zip(velocity).for_each(|(w, velocity)| w.copy_from_slice(velocity));
        take_off(w);
        let Some(divergence) = source.iter_mut().flatten().next() else { return &mut [] };
        transforms.divergence(w, divergence);
        divergence
    }

    /// Put the bodies to the end of the step, and write u* + tau G without their velocities to `w`. With helpers the
    /// solve around the bodies runs meanwhile, and is repeated in their cells.
    fn place_and_solve(
        &mut self,
        step: &Substep<D>,
        scheme: &Differences,
        flow: &Flow<R, D>,
        present: &Present<D>,
        problem: &mut Problem<D>,
    ) {
        let placement = step.placement(&present.flexible.stations);
        let Self { memory, w, source, .. } = self;
        let (known, extrapolated) = (Known::of(flow, memory, source), extrapolated(scheme, flow, memory));
        let Problem { bodies, grid, timer, .. } = problem;
        if step.team.is_alone() {
            bodies.moving().place(&placement, grid);
            timer.mark(Phase::Paint);
            bodies.sample(extrapolated);
            timer.mark(Phase::Sample);
            solve_locally(step.team, &known, scheme, bodies.rate(), w, nothing);
        } else {
            let (rate, mut moving) = bodies.split_still();
            solve_locally(step.team, &known, scheme, rate, w, || {
                moving.place(&placement, grid);
                moving.sample(extrapolated);
            });
            bodies.paint();
            for (point, rate) in bodies.painted() {
                let solved = known.solve(scheme, rate, point);
                w.iter_mut().zip(solved).for_each(|(w, solved)| w[point] = solved);
            }
        }
        timer.mark(Phase::Solve);
    }

    /// Make the new flow, which is in the place of the earliest, the present one and the present one the previous. Keep w
    /// of a step with `inv_tau` (1/s) after a step of `step` seconds.
    fn take_over(&mut self, flow: &mut Flow<R, D>, inv_tau: f64, step: f64) {
        let TwoStep { before, earlier, w, .. } = &mut self.memory;
        swap(flow, earlier);
        swap(before, earlier);
        swap(w, &mut self.w);
        (self.memory.inv_tau, self.memory.step_before) = (inv_tau, step);
    }

    /// Go back by a step, before which the flow two steps earlier, `1/tau` and the step before the last one were these.
    pub fn take_back(&mut self, flow: &mut Flow<R, D>, two_steps_earlier: &Flow<R, D>, inv_tau: f64, step_before: f64) {
        let TwoStep { before, earlier, w, .. } = &mut self.memory;
        swap(w, &mut self.w);
        swap(before, earlier);
        swap(flow, earlier);
        earlier.copy_from(two_steps_earlier);
        (self.memory.inv_tau, self.memory.step_before) = (inv_tau, step_before);
    }

    /// Put the bodies to the end of the step, and write u* + tau G to `w`.
    ///
    /// # Errors
    /// [`Error::Contact`] and [`Error::Markers`].
    pub fn solve_in_space(
        &mut self,
        step: &Substep<D>,
        flow: &Flow<R, D>,
        present: &Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<Differences, Error> {
        let scheme = Differences::new(step.dt, present.step, self.memory.step_before);
        self.place_and_solve(step, &scheme, flow, present, problem);
        let Self { memory, w, .. } = self;
        let share = scheme.tau * memory.inv_tau;
        let (velocity, w_last) = (&flow.velocity, &memory.w);
        let u_star = |point: usize, w: [f64; D]| {
            let tau_g = |axis: usize| share * (w_last[axis][point].to_f64() - velocity[axis][point].to_f64());
            std::array::from_fn(|axis| w[axis] - tau_g(axis))
        };
        let Problem { bodies, thin, grid, timer, .. } = problem;
        let time = step.end;
        bodies.add_velocities(time, |rate| 1.0 / (scheme.c[0] + rate), grid, w);
        bodies.solve_motion(scheme.c, &present.histories, step.ends, u_star, w, grid);
        bodies.solve_contact(scheme.c[0], [time - step.dt, time], &present.histories, w)?;
        thin.place(step.stations, &bodies.rigid, grid);
        if !thin.apply(scheme.c, &present.histories, bodies, u_star, w, grid) {
            return Err(Error::Markers { time });
        }
        timer.mark(Phase::Velocities);
        Ok(scheme)
    }

    /// Solve for the next flow with a prescribed `mean` velocity (m/s), and return its advection rate (1/s), which need
    /// not be found above `limit`.
    pub fn solve_in_fourier_space(
        &mut self,
        step: &Substep<D>,
        scheme: &Differences,
        mean: Option<[f64; D]>,
        limit: f64,
        present: &Present<D>,
        problem: &mut Problem<D>,
    ) -> f64 {
        let Self { memory, transforms, w, .. } = self;
        let implicit = Implicit { tau_nu: scheme.tau * problem.nu, cfl: present.cfl(step.dt), mean, limit };
        let Problem { bodies, grid, timer, .. } = problem;
        let find_cells_ahead = || {
            if let Some(ahead) = step.ahead {
                bodies.beams.iter_mut().for_each(|beam| beam.find_cells_ahead(ahead, step.stations, grid));
            }
        };
        transforms.solve(step.team, &implicit, w, &mut memory.earlier, timer, find_cells_ahead)
    }

    /// Sum up the forces, and make the next flow with its advection rate (1/s) the present one.
    pub fn accept(
        &mut self,
        step: &Substep<D>,
        scheme: &Differences,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
        advection_rate: f64,
    ) {
        problem.sum_up_forces(step.dt, self.drag(scheme, flow), step.stations, present);
        problem.timer.mark(Phase::Forces);
        self.take_over(flow, scheme.c[0], present.step);
        step.commit(scheme.c, present, &mut problem.bodies, advection_rate);
    }

    /// Return the drag on a cell of a mask over the density, m/s².
    pub fn drag<'a>(
        &'a self,
        scheme: &'a Differences,
        Flow { velocity, .. }: &'a Flow<R, D>,
    ) -> impl Fn(&Cell<D>) -> Vector<D> + 'a {
        let Self { memory: TwoStep { w: w_last, inv_tau, .. }, w, .. } = self;
        move |cell| {
            let u_star = Vector::from_fn(|axis, _| {
                let [u, w_last, w] = [velocity, w_last, w].map(|field| field[axis][cell.index].to_f64());
                let g = inv_tau * (w_last - u);
                w - scheme.tau * g
            });
            (u_star - cell.velocity) * cell.rate
        }
    }
}

impl<R: Real, T: Transforms<R, D>, const D: usize> Scheme<R, D> for Sbdf2<R, T, D>
where
    [f64; D]: Space<D>,
{
    fn threads(&self) -> usize {
        self.transforms.threads()
    }

    fn memory(&self) -> Memory<R, D> {
        Memory::Sbdf2(self.memory.clone())
    }

    fn fits(&self, memory: &Memory<R, D>) -> bool {
        matches!(memory, Memory::Sbdf2(memory) if self.memory.fits(memory))
    }

    fn save(&self, memory: &mut Memory<R, D>) {
        if let Memory::Sbdf2(memory) = memory {
            memory.copy_from(&self.memory);
        }
    }

    fn restore(&mut self, memory: &Memory<R, D>) {
        if let Memory::Sbdf2(memory) = memory {
            self.memory.copy_from(memory);
        }
    }

    /// A step of no length leaves the projection of the solve in Fourier space.
    fn start(
        &mut self,
        velocity: &StartVelocity<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) {
        fill(&mut self.w, velocity, &problem.grid);
        let mean = problem.mean_velocity(present.time);
        let implicit = Implicit { tau_nu: f64::MIN_POSITIVE * problem.nu, cfl: 0.0, mean, limit: f64::INFINITY };
        let Self { memory, transforms, w, .. } = self;
        let (team, timer) = (&ThreadTeam::alone(), &mut problem.timer);
        present.advection_rate = transforms.solve(team, &implicit, w, &mut memory.earlier, timer, nothing);
        self.take_over(flow, 0.0, 0.0);
    }

    fn step(
        &mut self,
        step: &Substep<D>,
        flow: &mut Flow<R, D>,
        present: &mut Present<D>,
        problem: &mut Problem<D>,
    ) -> Result<(), Error> {
        let scheme = self.solve_in_space(step, flow, present, problem)?;
        let mean = problem.mean_velocity(step.end);
        let advection_rate = self.solve_in_fourier_space(step, &scheme, mean, step.limit(), present, problem);
        step.check(advection_rate)?;
        self.accept(step, &scheme, flow, present, problem, advection_rate);
        Ok(())
    }

    /// Write the drag `a_b (u* − u_b)`, with `u* = (r + a_b u_b)/(c_0 + Σ a)`.
    fn predict_loads(&mut self, dt: f64, flow: &Flow<R, D>, present: &mut Present<D>, problem: &mut Problem<D>) {
        let scheme = Differences::new(dt, present.step, self.memory.step_before);
        let time = present.time + dt;
        let Problem { bodies, thin, grid, .. } = problem;
        bodies.beams.iter_mut().for_each(|beam| beam.move_ahead());
        bodies.place_predicted(&present.histories, dt, present.step, grid);
        bodies.sample(extrapolated(&scheme, flow, &self.memory));
        let Self { memory, w, source, .. } = self;
        let known = Known::of(flow, memory, source);
        let right_side = |point: usize| known.right_side(&scheme, point).map(|(r, _)| r);
        let loads = &mut present.flexible.loads;
        let add = |points: &[usize], sums: &mut [[f64; D]]| bodies.add_velocities_at(time, grid, points, sums);
        thin.predict_loads(scheme.c[0], bodies.rate(), right_side, add, grid, loads);
        let Some(rate) = bodies.rate() else { return };
        let weight = bodies.cell_mass;
        let drag = |cell: &Cell<D>| {
            let share = cell.rate / (scheme.c[0] + rate[cell.index]);
            let momentum = cell.velocity * cell.rate;
            let force = (Vector::from(right_side(cell.index)) + momentum) * share - momentum;
            (force * weight, cell.gain.map(|gain| weight * cell.rate * gain * (1.0 - share)))
        };
        bodies.beams.iter().for_each(|beam| beam.collect(drag, &mut loads[beam.number]));
        if !bodies.announce() {
            return;
        }
        // Zones and other bodies may drag the fluid in the same cells. Elsewhere `w` is not read.
        for cell in bodies.announced_cells() {
            let u_star = Vector::from(right_side(cell.index)) / (scheme.c[0] + rate[cell.index]);
            w.iter_mut().zip(&u_star).for_each(|(w, u)| w[cell.index] = R::rounded(*u));
        }
        bodies.add_velocities(time, |rate| 1.0 / (scheme.c[0] + rate), grid, w);
        bodies.set_announced(scheme.c[0], &present.histories, |point| w.each_ref().map(|w| w[point].to_f64()));
    }

    fn total_pressure(&mut self, _: &Flow<R, D>, present: &Present<D>, _: &mut Problem<D>) -> &[R] {
        let Self { memory, transforms, w, .. } = self;
        transforms.pressure(&memory.w, memory.inv_tau, present.cfl(present.step), &mut w[0]);
        &w[0]
    }

    fn velocities<'a>(&'a self, flow: &'a Flow<R, D>, axis: usize, before: f64, last: f64) -> Vec<Cow<'a, [f64]>> {
        vec![self.memory.velocity(flow, axis, before, last)]
    }

    fn divergence(&mut self, velocity: &[Field<R>; D]) -> &[R] {
        self.transforms.divergence(velocity, &mut self.w[0]);
        &self.w[0]
    }
}

/// Return the velocity (m/s) at a grid point, extrapolated to the end of the step.
fn extrapolated<R: Real, const D: usize>(
    &Differences { linear, .. }: &Differences,
    flow: &Flow<R, D>,
    memory: &TwoStep<R, D>,
) -> impl Fn(usize) -> [f64; D] {
    let (now, before) = (&flow.velocity, &memory.before.velocity);
    move |point| {
        std::array::from_fn(|axis| linear[0] * now[axis][point].to_f64() + linear[1] * before[axis][point].to_f64())
    }
}

/// Write u* + tau G without the velocities of the bodies to `w`, with the penalization rate `rate` (1/s); one thread
/// runs `meanwhile`.
fn solve_locally<R: Real, const D: usize>(
    team: &ThreadTeam,
    known: &Known<R, D>,
    scheme: &Differences,
    rate: Option<&[f64]>,
    w: &mut [Field<R>; D],
    meanwhile: impl FnOnce() + Send,
) where
    [f64; D]: Space<D>,
{
    let points = w[0].len();
    let share = points.div_ceil(team.parts());
    let mut parts = w.each_mut().map(|w| w.chunks_mut(share));
    let parts =
        (0..points).step_by(share).map(|first| (first, parts.each_mut().map(|parts| parts.next().unwrap_or_default())));
    team.share(meanwhile, parts, |(first, w)| {
        let points = first..first + w[0].len();
        let rate = rate.map(|rate| &rate[points.clone()]);
        let known = known.points(points);
        match known.source {
            Some(source) => run(LocalSolve { add: Source(source), known, scheme, rate, w }),
            None => run(LocalSolve { add: NoSource, known, scheme, rate, w }),
        }
    });
}

/// Coefficients of the two-step backward differences with a step that may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// `∂u/∂t ≈ c_0 u^{n+1} − c_1 u^n − c_2 u^{n−1}`, 1/s.
    pub c: [f64; 3],
    /// Extrapolation of the advection to the new time: `e_1 N^n + e_2 N^{n−1} + e_3 N^{n−2}`.
    pub e: [f64; 3],
    /// Linear extrapolation to the new time.
    pub linear: [f64; 2],
    /// 1/c_0, s.
    pub tau: f64,
}

impl Differences {
    /// Coefficients of a step `dt` after steps of `before` and, before that, `earlier` seconds; 0 stands for none.
    pub fn new(dt: f64, before: f64, earlier: f64) -> Self {
        if before == 0.0 {
            return Self { c: [1.0 / dt, 1.0 / dt, 0.0], e: [1.0, 0.0, 0.0], linear: [1.0, 0.0], tau: dt };
        }
        let r = dt / before;
        let c_0 = (1.0 + 2.0 * r) / ((1.0 + r) * dt);
        let c = [c_0, (1.0 + r) / dt, -r * r / ((1.0 + r) * dt)];
        let linear = [1.0 + r, -r];
        // Part of what the parabola through three times adds to the line through two: a multiple of a second difference,
        // which shorter steps before bound.
        let second = (QUADRATIC * dt * (dt + before) / (before + earlier)).min(before.min(earlier));
        let [before, earlier] = [before, earlier.max(f64::MIN_POSITIVE)].map(|step| second / step);
        let e = [linear[0] + before, linear[1] - before - earlier, earlier];
        Self { c, e, linear, tau: 1.0 / c_0 }
    }
}

/// What the local solve reads. Of the vorticity the plane has the first component.
#[derive(Clone)]
struct Known<'a, R, const D: usize> {
    velocity: [&'a [R]; D],
    vorticity: [&'a [R]; MOST],
    /// Velocity and vorticity one step earlier.
    velocity_before: [&'a [R]; D],
    vorticity_before: [&'a [R]; MOST],
    /// Velocity and vorticity two steps earlier.
    velocity_earlier: [&'a [R]; D],
    vorticity_earlier: [&'a [R]; MOST],
    /// `w = u + tau G` of the last step.
    w: [&'a [R]; D],
    /// `1/tau` of the last step.
    inv_tau: f64,
    source: Option<[&'a [R]; D]>,
}

impl<'a, R: Real, const D: usize> Known<'a, R, D>
where
    [f64; D]: Space<D>,
{
    fn of(
        flow: &'a Flow<R, D>,
        TwoStep { before, earlier, w, inv_tau, .. }: &'a TwoStep<R, D>,
        source: &'a Option<[Field<R>; D]>,
    ) -> Self {
        let vorticity = |flow: &'a Flow<R, D>| std::array::from_fn(|c| flow.vorticity.get(c).map_or(&[][..], |of| of));
        Self {
            velocity: flow.velocity.each_ref().map(|u| &**u),
            vorticity: vorticity(flow),
            velocity_before: before.velocity.each_ref().map(|u| &**u),
            vorticity_before: vorticity(before),
            velocity_earlier: earlier.velocity.each_ref().map(|u| &**u),
            vorticity_earlier: vorticity(earlier),
            w: w.each_ref().map(|w| &**w),
            inv_tau: *inv_tau,
            source: source.as_ref().map(|source| source.each_ref().map(|source| &**source)),
        }
    }

    /// Return the part for some of the points.
    fn points(&self, points: Range<usize>) -> Self {
        let part = |field: &'a [R]| if field.is_empty() { field } else { &field[points.clone()] };
        Self {
            velocity: self.velocity.map(part),
            vorticity: self.vorticity.map(part),
            velocity_before: self.velocity_before.map(part),
            vorticity_before: self.vorticity_before.map(part),
            velocity_earlier: self.velocity_earlier.map(part),
            vorticity_earlier: self.vorticity_earlier.map(part),
            w: self.w.map(part),
            source: self.source.map(|source| source.map(part)),
            ..*self
        }
    }

    /// Return the components, at point `i`, of `c_1 u^n + c_2 u^{n−1} − Σ e_j N^{n+1−j} − G^n` and the given
    /// acceleration, the right-hand side without the bodies, and of G^n.
    #[inline(always)]
    fn right_side(&self, &Differences { c, e, .. }: &Differences, i: usize) -> [(f64, f64); D] {
        let at = |fields: &[&[R]; D]| fields.map(|field| field[i].to_f64());
        let about = |fields: &[&[R]; MOST]| {
            let mut omega = [0.0; MOST];
            (0..<[f64; D]>::VORTICITY).for_each(|c| omega[c] = fields[c][i].to_f64());
            omega
        };
        let (u, u_before, w) = (at(&self.velocity), at(&self.velocity_before), at(&self.w));
        let r = std::array::from_fn(|a| c[1] * u[a] + c[2] * u_before[a]);
        let r = <[f64; D]>::subtract_advection(Scalar, r, e[0], about(&self.vorticity), u);
        let r = <[f64; D]>::subtract_advection(Scalar, r, e[1], about(&self.vorticity_before), u_before);
        let u_earlier = at(&self.velocity_earlier);
        let r = <[f64; D]>::subtract_advection(Scalar, r, e[2], about(&self.vorticity_earlier), u_earlier);
        std::array::from_fn(|a| {
            let g = self.inv_tau * (w[a] - u[a]);
            let r = self.source.map_or(r[a], |source| r[a] + source[a][i].to_f64());
            (r - g, g)
        })
    }

    /// Return u* + tau G at point `i` without the velocities of the bodies, with their penalization rate `rate` (1/s).
    fn solve(&self, scheme: &Differences, rate: f64, i: usize) -> [R; D] {
        self.right_side(scheme, i).map(|(r, g)| R::rounded(r / (scheme.c[0] + rate) + scheme.tau * g))
    }
}

/// What adds a given acceleration to the right-hand side in a vector of points; without one nothing is compiled in.
trait AddSource<const D: usize>: Copy {
    fn to(self, on: impl Arithmetic<f64>, vector: usize, r: [<f64 as Real>::Vector; D]) -> [<f64 as Real>::Vector; D];
}

#[derive(Clone, Copy)]
struct NoSource;

impl<const D: usize> AddSource<D> for NoSource {
    #[inline(always)]
    fn to(self, _: impl Arithmetic<f64>, _: usize, r: [<f64 as Real>::Vector; D]) -> [<f64 as Real>::Vector; D] {
        r
    }
}

#[derive(Clone, Copy)]
struct Source<'a, R, const D: usize>([&'a [R]; D]);

impl<R: Real, const D: usize> AddSource<D> for Source<'_, R, D> {
    #[inline(always)]
    fn to(self, on: impl Arithmetic<f64>, i: usize, r: [<f64 as Real>::Vector; D]) -> [<f64 as Real>::Vector; D] {
        std::array::from_fn(|a| on.add(r[a], to_f64s(&self.0[a].as_chunks::<F64_LANES>().0[i])))
    }
}

/// [`Known::solve`] at all points, with the same bits. Fourteen arrays in the plane and twenty-four in space are read
/// and written at once, which takes most of the time.
struct LocalSolve<'a, R, S, const D: usize> {
    add: S,
    known: Known<'a, R, D>,
    scheme: &'a Differences,
    rate: Option<&'a [f64]>,
    w: [&'a mut [R]; D],
}

impl<R: Real, S: AddSource<D>, const D: usize> Kernel for LocalSolve<'_, R, S, D>
where
    [f64; D]: Space<D>,
{
    type Real = f64;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<f64>) {
        let Self { add, known, scheme, rate, mut w } = self;
        let ([c_0, c_1, c_2], [e_1, e_2, e_3]) = (scheme.c.map(f64::splat), scheme.e.map(f64::splat));
        let [tau, inv_tau, zero] = [scheme.tau, known.inv_tau, 0.0].map(f64::splat);
        let (points, vectors) = (w[0].len(), w[0].len() / F64_LANES);
        let velocity = known.velocity.map(|field| &field.as_chunks::<F64_LANES>().0[..vectors]);
        let velocity_before = known.velocity_before.map(|field| &field.as_chunks::<F64_LANES>().0[..vectors]);
        let velocity_earlier = known.velocity_earlier.map(|field| &field.as_chunks::<F64_LANES>().0[..vectors]);
        let last = known.w.map(|field| &field.as_chunks::<F64_LANES>().0[..vectors]);
        let [mut vorticity, mut vorticity_before, mut vorticity_earlier] = [[&[][..]; MOST]; 3];
        for c in 0..<[f64; D]>::VORTICITY {
            vorticity[c] = &known.vorticity[c].as_chunks::<F64_LANES>().0[..vectors];
            vorticity_before[c] = &known.vorticity_before[c].as_chunks::<F64_LANES>().0[..vectors];
            vorticity_earlier[c] = &known.vorticity_earlier[c].as_chunks::<F64_LANES>().0[..vectors];
        }
        let rates = rate.map(|rate| &rate.as_chunks::<F64_LANES>().0[..vectors]);
        let new = w.each_mut().map(|w| &mut w.as_chunks_mut::<F64_LANES>().0[..vectors]);
        for i in 0..vectors {
            let [mut u, mut u_before, mut u_earlier, mut r] = [[zero; D]; 4];
            let [mut omega, mut omega_before, mut omega_earlier] = [[zero; MOST]; 3];
            for c in 0..<[f64; D]>::VORTICITY {
                (omega[c], omega_before[c]) = (to_f64s(&vorticity[c][i]), to_f64s(&vorticity_before[c][i]));
                omega_earlier[c] = to_f64s(&vorticity_earlier[c][i]);
            }
            for a in 0..D {
                (u[a], u_before[a]) = (to_f64s(&velocity[a][i]), to_f64s(&velocity_before[a][i]));
                u_earlier[a] = to_f64s(&velocity_earlier[a][i]);
                r[a] = on.add(on.mul(c_1, u[a]), on.mul(c_2, u_before[a]));
            }
            let r = <[f64; D]>::subtract_advection(Wide(on), r, e_1, omega, u);
            let r = <[f64; D]>::subtract_advection(Wide(on), r, e_2, omega_before, u_before);
            let r = <[f64; D]>::subtract_advection(Wide(on), r, e_3, omega_earlier, u_earlier);
            let r = add.to(on, i, r);
            let total = rates.map_or(c_0, |rates| on.add(c_0, to_f64s(&rates[i])));
            for a in 0..D {
                let g = on.mul(inv_tau, on.sub(to_f64s(&last[a][i]), u[a]));
                new[a][i] = from_f64s(on.add(on.div(on.sub(r[a], g), total), on.mul(tau, g)));
            }
        }
        for i in vectors * F64_LANES..points {
            let solved = known.solve(scheme, rate.map_or(0.0, |rate| rate[i]), i);
            w.iter_mut().zip(solved).for_each(|(w, solved)| w[i] = solved);
        }
    }
}
