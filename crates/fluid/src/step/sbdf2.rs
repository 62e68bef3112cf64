//! Two-step backward differences with extrapolated advection.
//!
//! The step is split so that the terms local in space and the terms local in wavenumber are each solved exactly
//! (Douglas–Rachford in incremental form). With the difference coefficients `c_0 … c_2`, the extrapolation `e_1, e_2`,
//! `tau = 1/c_0`, `N = omega × u` and `G = ∇Pi − nu ∇²u + r u`, r being the rate of the filter,
//!
//! ```text
//! (c_0 + Σ a_b) u*  = c_1 u^n + c_2 u^{n−1} − e_1 N^n − e_2 N^{n−1} − G^n + Σ a_b u_b      point by point
//! (1 − tau nu ∇² + tau r) u^{n+1} + tau ∇Pi^{n+1} = u* + tau G^n,   ∇·u^{n+1} = 0         wave by wave
//! G^{n+1} = c_0 (u* + tau G^n − u^{n+1})                                                  point by point
//! ```
//!
//! The sum of both is the scheme with all terms implicit but `a tau (G^{n+1} − G^n)`, of second order. Both parts are
//! monotone, so neither stiff drag nor viscosity bounds the step; advection does. A step takes five real transforms:
//! two forward (u* + tau G) and three inverse (u, v, omega).
//!
//! The drag on the bodies in the step is `rho a_b (u* − u_b)`. It is linear in u_b with the slope
//! `−rho a_b (1 − a_b/(c_0 + Σ a))`, which gives the impedance of the loads.

use std::iter::repeat;
use std::mem::swap;
use std::ops::Range;

use line_fft::{Arithmetic, F64_LANES, Kernel, Pack, Real, Team, from_f64s, nothing, run, to_f64s};

use super::substep::Substep;
use super::work::Work;
use crate::bodies::{Bodies, Cell, Loads, PredictedBeams};
use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::present::Present;
use crate::problem::Problem;
use crate::projection::Implicit;
use crate::state::TwoStep;
use crate::timer::Phase;

/// Signs in `omega × u = (−omega v, omega u)`.
const SIGNS: [f64; 2] = [-1.0, 1.0];

/// The scheme with its memory.
pub struct Sbdf2<R: Real> {
    pub memory: TwoStep<R>,
}

impl<R: Real> Sbdf2<R> {
    /// A scheme without an earlier step.
    pub fn new(problem: &Problem) -> Self {
        let n = problem.grid.len();
        let before = Flow::uniform([0.0; 2], n);
        let field = || Field::uniform(R::zero(), n);
        Self { memory: TwoStep { before, w: [field(), field()], inv_tau: 0.0 } }
    }

    /// Start from the velocity in `work.w`. A step of no length leaves the projection of the solve wave by wave.
    pub fn start(&mut self, flow: &mut Flow<R>, present: &mut Present, problem: &mut Problem, work: &mut Work<R>) {
        let implicit =
            Implicit { tau_nu: f64::MIN_POSITIVE * problem.nu, cfl: 0.0, mean: problem.mean_velocity(present.time) };
        present.advection_rate = self.solve_wave_by_wave(&Team::alone(), implicit, problem, work, |_| {});
        self.take_over(flow, work);
        self.memory.inv_tau = 0.0;
    }

    pub fn step(
        &mut self,
        step: Substep,
        flow: &mut Flow<R>,
        present: &mut Present,
        problem: &mut Problem,
        work: &mut Work<R>,
    ) -> Result<Option<PredictedBeams>, Error> {
        let scheme = Differences::new(step.dt, present.step);
        self.place_and_solve(&step, &scheme, flow, present, problem, &mut work.w);
        problem.add_velocities(step.end, |rate| 1.0 / (scheme.c[0] + rate), &mut work.w);
        let (memory, velocity) = (&self.memory, &flow.velocity);
        let u_star = |axis: usize, point: usize, w: f64| {
            let [u, w_last] = [velocity, &memory.w].map(|field| field[axis][point].to_f64());
            w - scheme.tau * memory.inv_tau * (w_last - u)
        };
        problem.bodies.release(scheme.c, &present.carried, u_star, &mut work.w);
        problem.solve_on_lines(scheme.c, &present.carried, step.end, step.stations, u_star, &mut work.w)?;
        problem.timer.mark(Phase::Velocities);
        let implicit = Implicit {
            tau_nu: scheme.tau * problem.nu,
            cfl: present.cfl(step.dt),
            mean: problem.mean_velocity(step.end),
        };
        let (mut predicted, grid) = (None, problem.grid);
        let advection_rate = self.solve_wave_by_wave(step.team, implicit, problem, work, |bodies| {
            predicted = step.ahead.map(|ahead| bodies.predict(ahead, step.stations, &grid));
        });
        step.check(advection_rate)?;

        let memory = &self.memory;
        let drag = |cell: &Cell| {
            [0, 1].map(|axis| {
                let [u, w, w_next] = [&flow.velocity, &memory.w, &work.w].map(|field| field[axis][cell.index].to_f64());
                let g = memory.inv_tau * (w - u);
                let u_star = w_next - scheme.tau * g;
                cell.rate * (u_star - cell.velocity[axis])
            })
        };
        problem.sum_up_forces(step.dt, drag, step.stations, present);
        problem.timer.mark(Phase::Forces);
        self.take_over(flow, work);
        self.memory.inv_tau = scheme.c[0];
        step.finish(present, &mut problem.bodies, advection_rate);
        if let Some(ahead) = step.ahead {
            problem.place_thin(ahead);
        }
        Ok(predicted)
    }

    /// Put the bodies to the end of the step, and write u* + tau G without their velocities to `w`. With helpers the
    /// solve around the bodies runs meanwhile, and is repeated in their cells.
    fn place_and_solve(
        &self,
        step: &Substep,
        scheme: &Differences,
        flow: &Flow<R>,
        present: &Present,
        problem: &mut Problem,
        w: &mut [Field<R>; 2],
    ) {
        let known = self.known(flow);
        let Problem { bodies, grid, timer, .. } = problem;
        if step.team.is_alone() {
            bodies.moving().place(step.end, step.displacements, step.stations, &present.beams.stations, grid);
            timer.mark(Phase::Paint);
            bodies.sample(self.extrapolated(scheme, flow));
            timer.mark(Phase::Sample);
            solve_locally(step.team, &known, scheme, bodies.rate(), w, nothing);
        } else {
            let (rate, mut moving) = bodies.split_static();
            solve_locally(step.team, &known, scheme, rate, w, || {
                moving.place(step.end, step.displacements, step.stations, &present.beams.stations, grid);
                moving.sample(self.extrapolated(scheme, flow));
            });
            bodies.paint();
            for (point, rate) in bodies.painted() {
                [w[0][point], w[1][point]] = known.solve(scheme, rate, point);
            }
        }
        timer.mark(Phase::Solve);
    }

    /// Make a new flow from `work.w` in the place of the previous one, which is not needed any more, and return its
    /// advection rate, 1/s. Meanwhile `predict` may run with the bodies.
    fn solve_wave_by_wave(
        &mut self,
        team: &Team,
        implicit: Implicit,
        problem: &mut Problem,
        work: &mut Work<R>,
        predict: impl FnOnce(&mut Bodies) + Send,
    ) -> f64 {
        let Work { spectral, projection, w } = work;
        let Problem { bodies, timer, .. } = problem;
        let solve = |row: usize, (), spectra: [&mut [Pack<R>]; 3]| projection.project(&implicit, row, spectra);
        let along_y = spectral.transform_along_y(team, w, timer);
        along_y.solve(team, repeat(()), solve, &mut self.memory.before, timer, || predict(bodies))
    }

    /// Make the new flow the present one, the present one the previous, and keep w.
    fn take_over(&mut self, flow: &mut Flow<R>, work: &mut Work<R>) {
        swap(flow, &mut self.memory.before);
        swap(&mut self.memory.w, &mut work.w);
    }

    /// Write the drag `a_b (u* − u_b)`, with `u* = (r + a_b u_b)/(c_0 + Σ a)`.
    pub fn predict_loads(
        &self,
        predicted: Option<PredictedBeams>,
        flow: &Flow<R>,
        present: &Present,
        problem: &mut Problem,
        loads: &mut [Loads],
    ) {
        if let Some(predicted) = predicted {
            problem.bodies.move_to_predicted(predicted);
        }
        let scheme = Differences::new(present.step, present.step);
        problem.bodies.sample(self.extrapolated(&scheme, flow));
        let known = self.known(flow);
        let right_side = |point: usize| [0, 1].map(|axis| known.right_side(&scheme, axis, point).0);
        problem.predict_loads_on_lines(scheme.c[0], present.time + present.step, right_side, loads);
        let bodies = &problem.bodies;
        let Some(rate) = bodies.rate() else { return };
        let weight = bodies.cell_mass;
        let drag = |cell: &Cell| {
            let share = cell.rate / (scheme.c[0] + rate[cell.index]);
            let force = [0, 1].map(|axis| {
                let (r, _) = known.right_side(&scheme, axis, cell.index);
                let momentum = cell.rate * cell.velocity[axis];
                weight * (share * (r + momentum) - momentum)
            });
            (force, cell.gain.map(|gain| weight * cell.rate * gain * (1.0 - share)))
        };
        bodies.collect_loads(drag, loads);
    }

    /// Return the velocity (m/s) at a grid point, extrapolated to the end of the step.
    fn extrapolated(&self, &Differences { e, .. }: &Differences, flow: &Flow<R>) -> impl Fn(usize) -> [f64; 2] {
        let (now, before) = (&flow.velocity, &self.memory.before.velocity);
        move |point| [0, 1].map(|axis| e[0] * now[axis][point].to_f64() + e[1] * before[axis][point].to_f64())
    }

    /// Return what the local solve reads.
    fn known<'a>(&'a self, flow: &'a Flow<R>) -> Known<'a, R> {
        let TwoStep { before, w, inv_tau } = &self.memory;
        Known {
            velocity: flow.velocity.each_ref().map(|u| &**u),
            vorticity: &flow.vorticity,
            velocity_before: before.velocity.each_ref().map(|u| &**u),
            vorticity_before: &before.vorticity,
            w: w.each_ref().map(|w| &**w),
            inv_tau: *inv_tau,
        }
    }
}

/// Write u* + tau G without the velocities of the bodies to `w`, with the drag rate `rate` (1/s); one thread runs
/// `meanwhile`.
fn solve_locally<R: Real>(
    team: &Team,
    known: &Known<R>,
    scheme: &Differences,
    rate: Option<&[f64]>,
    w: &mut [Field<R>; 2],
    meanwhile: impl FnOnce() + Send,
) {
    let share = w[0].len().div_ceil(team.parts());
    let [wx, wy] = w.each_mut().map(|w| w.chunks_mut(share));
    team.share(meanwhile, (0..).step_by(share).zip(wx.zip(wy)), |(first, (wx, wy))| {
        let points = first..first + wx.len();
        let rate = rate.map(|rate| &rate[points.clone()]);
        run(LocalSolve { known: known.points(points), scheme, rate, w: [wx, wy] });
    });
}

/// Coefficients of the two-step backward differences with a step that may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// `∂u/∂t ≈ c_0 u^{n+1} − c_1 u^n − c_2 u^{n−1}`, 1/s.
    pub c: [f64; 3],
    /// Extrapolation to the new time: `e_1 N^n + e_2 N^{n−1}`.
    pub e: [f64; 2],
    /// 1/c_0, s.
    pub tau: f64,
}

impl Differences {
    /// Coefficients of a step `dt` after one of `before` seconds; backward Euler if `before` = 0.
    pub fn new(dt: f64, before: f64) -> Self {
        if before == 0.0 {
            return Self { c: [1.0 / dt, 1.0 / dt, 0.0], e: [1.0, 0.0], tau: dt };
        }
        let r = dt / before;
        let c_0 = (1.0 + 2.0 * r) / ((1.0 + r) * dt);
        let c = [c_0, (1.0 + r) / dt, -r * r / ((1.0 + r) * dt)];
        Self { c, e: [1.0 + r, -r], tau: 1.0 / c_0 }
    }
}

/// What the local solve reads.
#[derive(Clone)]
struct Known<'a, R> {
    velocity: [&'a [R]; 2],
    vorticity: &'a [R],
    /// Velocity and vorticity one step earlier.
    velocity_before: [&'a [R]; 2],
    vorticity_before: &'a [R],
    /// `w = u + tau G` of the last step.
    w: [&'a [R]; 2],
    /// `1/tau` of the last step.
    inv_tau: f64,
}

impl<'a, R: Real> Known<'a, R> {
    /// Return the part for some of the points.
    fn points(&self, points: Range<usize>) -> Self {
        let part = |field: &'a [R]| &field[points.clone()];
        Self {
            velocity: self.velocity.map(part),
            vorticity: part(self.vorticity),
            velocity_before: self.velocity_before.map(part),
            vorticity_before: part(self.vorticity_before),
            w: self.w.map(part),
            ..*self
        }
    }

    /// Return a component, at point `i`, of `c_1 u^n + c_2 u^{n−1} − e_1 N^n − e_2 N^{n−1} − G^n`, the right-hand side
    /// without the bodies, and of G^n.
    #[inline(always)] // A call for each component reads all twice.
    fn right_side(&self, &Differences { c, e, .. }: &Differences, axis: usize, i: usize) -> (f64, f64) {
        let [u, u_before] = [&self.velocity, &self.velocity_before].map(|velocity| velocity[axis][i].to_f64());
        let [v, v_before] = [&self.velocity, &self.velocity_before].map(|velocity| velocity[1 - axis][i].to_f64());
        let n = SIGNS[axis] * self.vorticity[i].to_f64() * v;
        let n_before = SIGNS[axis] * self.vorticity_before[i].to_f64() * v_before;
        let g = self.inv_tau * (self.w[axis][i].to_f64() - u);
        (c[1] * u + c[2] * u_before - e[0] * n - e[1] * n_before - g, g)
    }

    /// Return u* + tau G at point `i` without the velocities of the bodies, with their drag rate `rate` (1/s).
    fn solve(&self, scheme: &Differences, rate: f64, i: usize) -> [R; 2] {
        [0, 1].map(|axis| {
            let (r, g) = self.right_side(scheme, axis, i);
            R::rounded(r / (scheme.c[0] + rate) + scheme.tau * g)
        })
    }
}

/// [`Known::solve`] at all points, with the same bits. Eleven arrays are read and written at once, which takes most of
/// the time.
struct LocalSolve<'a, R> {
    known: Known<'a, R>,
    scheme: &'a Differences,
    rate: Option<&'a [f64]>,
    w: [&'a mut [R]; 2],
}

impl<'a, R: Real> Kernel for LocalSolve<'a, R> {
    type Real = f64;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<f64>) {
        let Self { known, scheme, rate, w: [wx, wy] } = self;
        let ([c_0, c_1, c_2], [e_1, e_2]) = (scheme.c.map(f64::splat), scheme.e.map(f64::splat));
        let [tau, inv_tau] = [scheme.tau, known.inv_tau].map(f64::splat);
        let vectors = wx.len() / F64_LANES;
        let whole = |field: &'a [R]| &field.as_chunks::<F64_LANES>().0[..vectors];
        let ([u, v], omega) = (known.velocity.map(whole), whole(known.vorticity));
        let ([u_before, v_before], omega_before) = (known.velocity_before.map(whole), whole(known.vorticity_before));
        let ([wx_last, wy_last], rates) =
            (known.w.map(whole), rate.map(|rate| &rate.as_chunks::<F64_LANES>().0[..vectors]));
        let (wx_new, wy_new) = (&mut wx.as_chunks_mut().0[..vectors], &mut wy.as_chunks_mut().0[..vectors]);
        for i in 0..vectors {
            let (u, v, omega) = (to_f64s(&u[i]), to_f64s(&v[i]), to_f64s(&omega[i]));
            let (u_before, v_before, omega_before) =
                (to_f64s(&u_before[i]), to_f64s(&v_before[i]), to_f64s(&omega_before[i]));
            let total = rates.map_or(c_0, |rates| on.add(c_0, to_f64s(&rates[i])));

            let r = on.add(on.mul(c_1, u), on.mul(c_2, u_before));
            let r = on.add(r, on.mul(e_1, on.mul(omega, v)));
            let r = on.add(r, on.mul(e_2, on.mul(omega_before, v_before)));
            let g = on.mul(inv_tau, on.sub(to_f64s(&wx_last[i]), u));
            wx_new[i] = from_f64s(on.add(on.div(on.sub(r, g), total), on.mul(tau, g)));

            let r = on.add(on.mul(c_1, v), on.mul(c_2, v_before));
            let r = on.sub(r, on.mul(e_1, on.mul(omega, u)));
            let r = on.sub(r, on.mul(e_2, on.mul(omega_before, u_before)));
            let g = on.mul(inv_tau, on.sub(to_f64s(&wy_last[i]), v));
            wy_new[i] = from_f64s(on.add(on.div(on.sub(r, g), total), on.mul(tau, g)));
        }
        for i in vectors * F64_LANES..wx.len() {
            [wx[i], wy[i]] = known.solve(scheme, rate.map_or(0.0, |rate| rate[i]), i);
        }
    }
}
