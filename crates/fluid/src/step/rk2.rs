//! Heun's method with the drag explicit and viscosity exact (thesis eq. 3.15 – 3.18, corrected).
//!
//! With `E = exp(−nu k² dt)`, P the projection and F the filter,
//!
//! ```text
//! f(t, u) = −omega × u − Σ a_b (u − u_b(t))                             point by point
//! u_1     = P F E [u^n + dt f(t^n, u^n)]                                wave by wave
//! u^{n+1} = P F ½ [E u^n + u_1 + dt f(t^{n+1}, u_1)]                    wave by wave
//! ```
//!
//! with `F = 1/(1 + dt r)`, r the rate of the filter. It is `E u^n + dt/2 (E k_1 + k_2)`. The spectrum of u^n is kept, so a step takes ten real transforms: twice two
//! forward and three inverse. The explicit drag is stable up to `dt Σ a = 2`; steps are divided to keep it at or below 1.

use std::f64::consts::TAU;
use std::mem::swap;

use super::Step;
use crate::bodies::{Bodies, Cell, Loads};
use crate::domain::Domain;
use crate::error::Error;
use crate::grid::Grid;
use crate::projection::Projection;
use crate::state::{Flow, Present};
use line_fft::Pack;
use line_fft::{Arithmetic, Kernel, Real, run};
use line_fft::{Team, nothing};

/// The scheme with its memory.
pub struct Rk2<R: Real> {
    /// Spectrum of the present velocity, m/s, `[rows, nx]` per component.
    pub u_hat: [Vec<Pack<R>>; 2],
    /// The flow that a step makes, and the spectrum of its velocity.
    next: Flow<R>,
    next_u_hat: [Vec<Pack<R>>; 2],
    decay: Decay,
}

/// The exact decay by viscosity, as factors for each kx, and for each ky.
struct Decay {
    kx2: Vec<f64>,
    ky2: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    /// What the transforms make of a mode: the spectrum of u^n has not gone through them.
    gains: [Vec<f64>; 2],
    /// What they were made for, `nu dt`, m².
    nu_dt: f64,
}

/// What comes out of a solve wave by wave.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// `P F w`, the beginning.
    Start,
    /// `P F E w`.
    First,
    /// `P F ½ (E u^n + w)`.
    Second,
}

impl<R: Real> Rk2<R> {
    /// From a uniform velocity, m/s.
    pub fn new(velocity: [f64; 2], domain: &Domain<R>) -> Self {
        let spectrum = domain.spectral.spectrum();
        let uniform = |velocity: f64| {
            let mut spectrum = spectrum.clone();
            spectrum[0].re[0] = R::rounded(velocity);
            spectrum
        };
        let decay = Decay::new(&domain.grid, domain.spectral.gains());
        let next = Flow::uniform([0.0; 2], domain.grid.len());
        Self { u_hat: velocity.map(uniform), next, next_u_hat: [spectrum.clone(), spectrum], decay }
    }

    pub fn start(&mut self, present: &mut Present<R>, domain: &mut Domain<R>) {
        present.advection_rate = self.solve_wave_by_wave(&Team::alone(), Stage::Start, present.time, 0.0, domain);
        self.take_over(&mut present.flow);
    }

    pub fn step(&mut self, step: Step, present: &mut Present<R>, domain: &mut Domain<R>) -> Result<(), Error> {
        let cfl = present.advection_rate * step.dt;
        self.decay.set_viscosity(step.dt * domain.nu);
        add_rate_of_change(present.time, &present.flow, step.dt, domain);
        domain.bodies.place(step.end, step.stations, &present.beams.stations, &domain.grid);
        step.check(self.solve_wave_by_wave(step.team, Stage::First, step.end, cfl, domain))?;
        add_rate_of_change(step.end, &self.next, step.dt, domain);
        let advection_rate = self.solve_wave_by_wave(step.team, Stage::Second, step.end, cfl, domain);
        step.check(advection_rate)?;

        self.take_over(&mut present.flow);
        sample(&present.flow, &mut domain.bodies);
        let drag = |cell: &Cell| present_drag(&present.flow, cell);
        let exchange = &mut present.beams.exchange;
        domain.bodies.sum_up_forces(step.dt, drag, step.stations, &mut present.bodies, exchange);
        step.finish(present, advection_rate);
        Ok(())
    }

    /// Make the new flow the present one.
    fn take_over(&mut self, flow: &mut Flow<R>) {
        swap(flow, &mut self.next);
        swap(&mut self.u_hat, &mut self.next_u_hat);
    }

    /// From `domain.w` to `next`, the flow after a stage at a time (s) of a step with a CFL number, and its advection
    /// rate, 1/s.
    fn solve_wave_by_wave(&mut self, team: &Team, stage: Stage, time: f64, cfl: f64, domain: &mut Domain<R>) -> f64 {
        domain.hold_mean_flow(time);
        domain.spectral.projection.set_step(0.0, cfl);
        let (nx, points) = (domain.grid.nx, domain.grid.len() as f64);
        let [u, v] = self.u_hat.each_ref().map(|u_hat| u_hat.chunks_exact(nx));
        let [next_u, next_v] = self.next_u_hat.each_mut().map(|u_hat| u_hat.chunks_exact_mut(nx));
        let rows = u.zip(v).zip(next_u.zip(next_v));
        let decay = &self.decay;
        let solve = |projection: &Projection<R>, row: usize, own: Row<R>, [u, v, omega]: [&mut [Pack<R>]; 3]| {
            let ((u_before, v_before), (u_after, v_after)) = own;
            decay.apply(stage, points, row, u, u_before);
            decay.apply(stage, points, row, v, v_before);
            projection.project(row, u, v, omega);
            if stage != Stage::First {
                u_after.copy_from_slice(u);
                v_after.copy_from_slice(v);
            }
        };
        domain.spectral.transform_along_y(team, &domain.w, &mut domain.clock);
        domain.spectral.solve(team, rows, solve, &mut self.next, &mut domain.clock, nothing)
    }
}

/// A row of both components of u^n, and where that of u^{n+1} goes.
type Row<'a, R> = ((&'a [Pack<R>], &'a [Pack<R>]), (&'a mut [Pack<R>], &'a mut [Pack<R>]));

impl Decay {
    /// For transforms with these gains.
    fn new(grid: &Grid, gains: [Vec<f64>; 2]) -> Self {
        let modes = gains[1].len();
        let Grid { nx, length, height, .. } = *grid;
        let kx2 = |i: usize| (TAU / length * i.min(nx - i) as f64).powi(2);
        let ky2 = |j: usize| (TAU / height * j as f64).powi(2);
        Self {
            kx2: (0..nx).map(kx2).collect(),
            ky2: (0..modes).map(ky2).collect(),
            x: vec![1.0; nx],
            y: vec![1.0; modes],
            gains,
            nu_dt: 0.0,
        }
    }

    fn set_viscosity(&mut self, nu_dt: f64) {
        if nu_dt == self.nu_dt {
            return;
        }
        self.nu_dt = nu_dt;
        let decay = |k2: f64| (-nu_dt * k2).exp();
        self.x.iter_mut().zip(&self.kx2).for_each(|(x, k2)| *x = decay(*k2));
        self.y.iter_mut().zip(&self.ky2).for_each(|(y, k2)| *y = decay(*k2));
    }

    /// From w to what a stage projects, in a row of one component; `before` is that of u^n over the number of points.
    fn apply<R: Real>(&self, stage: Stage, points: f64, row: usize, w: &mut [Pack<R>], before: &[Pack<R>]) {
        let [decay_y, gain_y] = [&self.y, &self.gains[1]].map(|of| &of[row * R::LANES..][..R::LANES]);
        for ((w, before), (decay_x, gain_x)) in w.iter_mut().zip(before).zip(self.x.iter().zip(&self.gains[0])) {
            for (lane, (decay_y, gain_y)) in decay_y.iter().zip(gain_y).enumerate() {
                let decay = decay_x * decay_y;
                let (re, im) = (w.re[lane].to_f64(), w.im[lane].to_f64());
                let (re, im) = match stage {
                    Stage::Start => (re, im),
                    Stage::First => (decay * re, decay * im),
                    Stage::Second => {
                        let points = points * gain_x * gain_y;
                        let (re_before, im_before) = (before.re[lane].to_f64(), before.im[lane].to_f64());
                        (0.5 * (re + points * decay * re_before), 0.5 * (im + points * decay * im_before))
                    }
                };
                (w.re[lane], w.im[lane]) = (R::rounded(re), R::rounded(im));
            }
        }
    }
}

/// Longest step that the explicit drag allows, s.
pub fn longest_step(bodies: &Bodies) -> f64 {
    let stiffest = bodies.rate().into_iter().flatten().fold(0.0_f64, |most, rate| most.max(*rate));
    1.0 / stiffest.max(f64::MIN_POSITIVE)
}

/// Let the bodies sample a flow.
fn sample<R: Real>(flow: &Flow<R>, bodies: &mut Bodies) {
    let [u, v] = &flow.velocity;
    bodies.sample(|point| [u[point].to_f64(), v[point].to_f64()]);
}

/// `u + dt f` for a flow at a time (s), into `domain.w`.
pub fn add_rate_of_change<R: Real>(time: f64, flow: &Flow<R>, dt: f64, domain: &mut Domain<R>) {
    sample(flow, &mut domain.bodies);
    let Flow { velocity: [u, v], vorticity: omega } = flow;
    let rate = domain.bodies.rate();
    let [wx, wy] = &mut domain.w;
    run(Explicit { dt, u, other: v, omega, sign: -1.0, rate, w: wx });
    run(Explicit { dt, u: v, other: u, omega, sign: 1.0, rate, w: wy });
    domain.add_velocities(time, |_| dt);
}

/// The drag as it is. A change of the body's velocity in the coming step moves the fluid along with `dt a_b/2`.
pub fn predict_loads<R: Real>(present: &Present<R>, bodies: &mut Bodies, loads: &mut [Loads]) {
    sample(&present.flow, bodies);
    let weight = bodies.cell_mass;
    let drag = |cell: &Cell| {
        let force = present_drag(&present.flow, cell).map(|drag| weight * drag);
        (force, cell.gain.map(|gain| weight * cell.rate * gain * (1.0 - 0.5 * present.step * cell.rate)))
    };
    bodies.collect_loads(drag, loads);
}

/// Drag of a flow on a cell over the density, `a_b (u − u_b)`, m/s².
fn present_drag<R: Real>(flow: &Flow<R>, cell: &Cell) -> [f64; 2] {
    [0, 1].map(|axis| cell.rate * (flow.velocity[axis][cell.index].to_f64() - cell.velocity[axis]))
}

/// `u + dt (−sign omega other − a u)`, with `sign omega other` this component of `omega × u`.
struct Explicit<'a, R> {
    dt: f64,
    u: &'a [R],
    other: &'a [R],
    omega: &'a [R],
    sign: f64,
    rate: Option<&'a [f64]>,
    w: &'a mut [R],
}

impl<R: Real> Kernel for Explicit<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<R>) {
        let Self { dt, sign, w, .. } = self;
        let n = w.len();
        let (u, other, omega) = (&self.u[..n], &self.other[..n], &self.omega[..n]);
        match self.rate.map(|rate| &rate[..n]) {
            Some(rate) => {
                for i in 0..n {
                    let u = u[i].to_f64();
                    w[i] = R::rounded(u - dt * (sign * omega[i].to_f64() * other[i].to_f64() + rate[i] * u));
                }
            }
            None => {
                for i in 0..n {
                    w[i] = R::rounded(u[i].to_f64() - dt * (sign * omega[i].to_f64() * other[i].to_f64()));
                }
            }
        }
    }
}
