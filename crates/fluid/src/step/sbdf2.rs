//! Two-step backward differences with extrapolated advection.
//!
//! The step is split so that what is local in space and what is local in wavenumber are each solved exactly
//! (Douglas–Rachford in incremental form). With `c_0 … c_2` the difference coefficients, `e_1, e_2` the extrapolation,
//! `tau = 1/c_0`, `N = omega × u` and `G = ∇Pi − nu ∇²u + r u`, r being the rate of the filter,
//!
//! ```text
//! (c_0 + Σ a_b) u*  = c_1 u^n + c_2 u^{n−1} − e_1 N^n − e_2 N^{n−1} − G^n + Σ a_b u_b      point by point
//! (1 − tau nu ∇² + tau r) u^{n+1} + tau ∇Pi^{n+1} = u* + tau G^n,   ∇·u^{n+1} = 0         wave by wave
//! G^{n+1} = c_0 (u* + tau G^n − u^{n+1})                                                  point by point
//! ```
//!
//! The sum of the two is the scheme with both parts implicit but for `a tau (G^{n+1} − G^n)`, of second order. Both
//! parts are monotone, so neither stiff drag nor viscosity bounds the step; advection does. A step takes five real
//! transforms: two forward (u* + tau G) and three inverse (u, v, omega).
//!
//! The drag on the bodies in the step is `rho a_b (u* − u_b)`. It is linear in u_b with the slope
//! `−rho a_b (1 − a_b/(c_0 + Σ a))`, which is what the impedance of the loads is.

use std::iter::repeat;
use std::mem::swap;
use std::ops::Range;

use super::Step;
use crate::bodies::{Bodies, Cell, Loads};
use crate::clock::Phase;
use crate::domain::Domain;
use crate::error::Error;
use crate::field::Field;
use crate::grid::Grid;
use crate::projection::Projection;
use crate::state::{Flow, Present, TwoStep};
use line_fft::{Arithmetic, F64_LANES, Kernel, Real, from_f64s, run, to_f64s};
use line_fft::{Team, nothing};

/// Of `omega × u = (−omega v, omega u)`.
const SIGNS: [f64; 2] = [-1.0, 1.0];

/// The scheme with its memory.
pub struct Sbdf2<R: Real> {
    pub memory: TwoStep<R>,
}

impl<R: Real> Sbdf2<R> {
    /// With no step before.
    pub fn new(domain: &Domain<R>) -> Self {
        let n = domain.grid.len();
        let before = Flow::uniform([0.0; 2], n);
        let field = || Field::uniform(R::zero(), n);
        Self { memory: TwoStep { before, w: [field(), field()], per_tau: 0.0 } }
    }

    /// In no time viscosity does nothing: what is left of the solve wave by wave is the projection.
    pub fn start(&mut self, present: &mut Present<R>, domain: &mut Domain<R>) {
        domain.hold_mean_flow(present.time);
        present.advection_rate = self.solve_wave_by_wave(&Team::alone(), f64::MIN_POSITIVE, 0.0, domain, |_, _| {});
        self.take_over(&mut present.flow, domain);
        self.memory.per_tau = 0.0;
    }

    pub fn step(&mut self, step: Step, present: &mut Present<R>, domain: &mut Domain<R>) -> Result<(), Error> {
        let scheme = Differences::new(step.dt, present.step);
        self.place_and_solve(&step, &scheme, present, domain);
        domain.add_velocities(step.end, |rate| 1.0 / (scheme.c[0] + rate));
        domain.clock.mark(Phase::Velocities);
        domain.hold_mean_flow(step.end);
        let cfl = present.advection_rate * step.dt;
        let advection_rate = self.solve_wave_by_wave(step.team, scheme.tau, cfl, domain, |bodies, grid| {
            step.ahead.inspect(|ahead| bodies.look_ahead(ahead, step.stations, grid));
        });
        step.check(advection_rate)?;

        let memory = &self.memory;
        let drag = |cell: &Cell| {
            [0, 1].map(|axis| {
                let [u, w, w_next] =
                    [&present.flow.velocity, &memory.w, &domain.w].map(|field| field[axis][cell.index].to_f64());
                let g = memory.per_tau * (w - u);
                let u_star = w_next - scheme.tau * g;
                cell.rate * (u_star - cell.velocity[axis])
            })
        };
        let exchange = &mut present.beams.exchange;
        domain.bodies.sum_up_forces(step.dt, drag, step.stations, &mut present.bodies, exchange);
        domain.clock.mark(Phase::Forces);
        self.take_over(&mut present.flow, domain);
        self.memory.per_tau = scheme.c[0];
        step.finish(present, advection_rate);
        Ok(())
    }

    /// Put the bodies where they are at the end of the step, and solve for u* + tau G without their velocities, into
    /// `domain.w`. What has helpers solves around the bodies meanwhile, and again in them.
    fn place_and_solve(&self, step: &Step, scheme: &Differences, present: &Present<R>, domain: &mut Domain<R>) {
        let known = self.known(&present.flow);
        let Domain { bodies, grid, w, clock, .. } = domain;
        if step.team.is_alone() {
            bodies.changing().place(step.end, step.stations, &present.beams.stations, grid);
            clock.mark(Phase::Paint);
            bodies.sample(self.extrapolated(scheme, &present.flow));
            clock.mark(Phase::Sample);
            solve_locally(step.team, &known, scheme, bodies.rate(), w, nothing);
        } else {
            let (rate, mut changing) = bodies.apart();
            solve_locally(step.team, &known, scheme, rate, w, || {
                changing.place(step.end, step.stations, &present.beams.stations, grid);
                changing.sample(self.extrapolated(scheme, &present.flow));
            });
            bodies.paint();
            for (point, rate) in bodies.painted() {
                [w[0][point], w[1][point]] = known.solve(scheme, rate, point);
            }
        }
        clock.mark(Phase::Solve);
    }

    /// From `domain.w` to a new flow in the place of the one before, which is not needed any more; and its advection
    /// rate, 1/s. Meanwhile the bodies may look where they go next.
    fn solve_wave_by_wave(
        &mut self,
        team: &Team,
        tau: f64,
        cfl: f64,
        domain: &mut Domain<R>,
        look_ahead: impl FnOnce(&mut Bodies, &Grid) + Send,
    ) -> f64 {
        domain.spectral.projection.set_step(tau * domain.nu, cfl);
        let solve = |projection: &Projection<R>, row, (), [u, v, omega]: [&mut [_]; 3]| {
            projection.project(row, u, v, omega);
        };
        let Domain { spectral, bodies, grid, w, clock, .. } = domain;
        spectral.transform_along_y(team, w, clock);
        spectral.solve(team, repeat(()), solve, &mut self.memory.before, clock, || look_ahead(bodies, grid))
    }

    /// Make the new flow the present one, that the one before, and keep w.
    fn take_over(&mut self, flow: &mut Flow<R>, domain: &mut Domain<R>) {
        swap(flow, &mut self.memory.before);
        swap(&mut self.memory.w, &mut domain.w);
    }

    /// The drag `a_b (u* − u_b)`, with `u* = (r + a_b u_b)/(c_0 + Σ a)`.
    pub fn predict_loads(&self, present: &Present<R>, bodies: &mut Bodies, loads: &mut [Loads]) {
        let scheme = Differences::new(present.step, present.step);
        bodies.sample(self.extrapolated(&scheme, &present.flow));
        let Some(rate) = bodies.rate() else { return };
        let known = self.known(&present.flow);
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

    /// Velocity (m/s) at a grid point as it is at the end of the step, by extrapolation.
    fn extrapolated(&self, &Differences { e, .. }: &Differences, flow: &Flow<R>) -> impl Fn(usize) -> [f64; 2] {
        let (now, before) = (&flow.velocity, &self.memory.before.velocity);
        move |point| [0, 1].map(|axis| e[0] * now[axis][point].to_f64() + e[1] * before[axis][point].to_f64())
    }

    /// What the local solve reads.
    fn known<'a>(&'a self, flow: &'a Flow<R>) -> Known<'a, R> {
        let TwoStep { before, w, per_tau } = &self.memory;
        Known {
            velocity: flow.velocity.each_ref().map(|u| &**u),
            vorticity: &flow.vorticity,
            velocity_before: before.velocity.each_ref().map(|u| &**u),
            vorticity_before: &before.vorticity,
            w: w.each_ref().map(|w| &**w),
            per_tau: *per_tau,
        }
    }
}

/// u* + tau G without the velocities of the bodies, into `w`, where the drag rate is `rate` (1/s); `meanwhile` something
/// else is done.
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
struct Differences {
    /// `∂u/∂t ≈ c_0 u^{n+1} − c_1 u^n − c_2 u^{n−1}`, 1/s.
    c: [f64; 3],
    /// Extrapolation to the new time: `e_1 N^n + e_2 N^{n−1}`.
    e: [f64; 2],
    /// 1/c_0, s.
    tau: f64,
}

impl Differences {
    /// A step `dt` after one of `before` seconds; `before` = 0: the first step, by backward Euler.
    fn new(dt: f64, before: f64) -> Self {
        if before == 0.0 {
            return Self { c: [1.0 / dt, 1.0 / dt, 0.0], e: [1.0, 0.0], tau: dt };
        }
        let r = dt / before;
        let c_0 = (1.0 + 2.0 * r) / ((1.0 + r) * dt);
        let c = [c_0, (1.0 + r) / dt, -r * r / ((1.0 + r) * dt)];
        Self { c, e: [1.0 + r, -r], tau: 1.0 / c_0 }
    }
}

/// What the local solve reads at each point.
#[derive(Clone)]
struct Known<'a, R> {
    velocity: [&'a [R]; 2],
    vorticity: &'a [R],
    /// The same one step earlier.
    velocity_before: [&'a [R]; 2],
    vorticity_before: &'a [R],
    /// `w = u + tau G` of the last step.
    w: [&'a [R]; 2],
    /// `1/tau` of the last step.
    per_tau: f64,
}

impl<'a, R: Real> Known<'a, R> {
    /// The same for some of the points.
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

    /// At point `i`: the right-hand side without the bodies, `c_1 u^n + c_2 u^{n−1} − e_1 N^n − e_2 N^{n−1} − G^n`, and
    /// G^n, of a component.
    fn right_side(&self, &Differences { c, e, .. }: &Differences, axis: usize, i: usize) -> (f64, f64) {
        let [u, u_before] = [&self.velocity, &self.velocity_before].map(|velocity| velocity[axis][i].to_f64());
        let [v, v_before] = [&self.velocity, &self.velocity_before].map(|velocity| velocity[1 - axis][i].to_f64());
        let n = SIGNS[axis] * self.vorticity[i].to_f64() * v;
        let n_before = SIGNS[axis] * self.vorticity_before[i].to_f64() * v_before;
        let g = self.per_tau * (self.w[axis][i].to_f64() - u);
        (c[1] * u + c[2] * u_before - e[0] * n - e[1] * n_before - g, g)
    }

    /// u* + tau G at point `i` without the velocities of the bodies, whose drag rate there is `rate` (1/s).
    fn solve(&self, scheme: &Differences, rate: f64, i: usize) -> [R; 2] {
        [0, 1].map(|axis| {
            let (r, g) = self.right_side(scheme, axis, i);
            R::rounded(r / (scheme.c[0] + rate) + scheme.tau * g)
        })
    }
}

/// [`Known::solve`] at points with the total drag rate `rate`, with the same bits.
///
/// Eleven arrays are read and written at once: most of the time is spent on that, not on the arithmetic.
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
        let [tau, per_tau] = [scheme.tau, known.per_tau].map(f64::splat);
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
            let g = on.mul(per_tau, on.sub(to_f64s(&wx_last[i]), u));
            wx_new[i] = from_f64s(on.add(on.div(on.sub(r, g), total), on.mul(tau, g)));

            let r = on.add(on.mul(c_1, v), on.mul(c_2, v_before));
            let r = on.sub(r, on.mul(e_1, on.mul(omega, u)));
            let r = on.sub(r, on.mul(e_2, on.mul(omega_before, u_before)));
            let g = on.mul(per_tau, on.sub(to_f64s(&wy_last[i]), v));
            wy_new[i] = from_f64s(on.add(on.div(on.sub(r, g), total), on.mul(tau, g)));
        }
        for i in vectors * F64_LANES..wx.len() {
            [wx[i], wy[i]] = known.solve(scheme, rate.map_or(0.0, |rate| rate[i]), i);
        }
    }
}
