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
//! which is `E u^n + dt/2 (E k_1 + k_2)`. The spectrum of u^n is kept, so a step takes ten real transforms: twice two
//! forward and three inverse. The explicit drag is stable up to `dt Σ a = 2`; steps are divided to keep it at or below 1.

use std::array::from_fn;
use std::f64::consts::TAU;

use multiversion::multiversion;

use super::{Error, Flow, Fluid};
use crate::grid::Grid;
use crate::kernel;
use crate::quad::{LANES, Quad};

/// The exact decay by viscosity, as factors for each kx, and for the ky of each row.
pub(super) struct Rk2 {
    kx2: Vec<f64>,
    ky2: Vec<[f64; LANES]>,
    decay_x: Vec<f64>,
    decay_y: Vec<[f64; LANES]>,
    /// What they were made for, `nu dt`, m².
    nu_dt: f64,
}

/// What comes out of a solve wave by wave.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Stage {
    /// `P F w`, the beginning.
    Start,
    /// `P F E w`.
    First,
    /// `P F ½ (E u^n + w)`.
    Second,
}

impl Rk2 {
    /// For spectra of `rows` rows.
    pub fn new(grid: &Grid, rows: usize) -> Self {
        let Grid { nx, length, height, .. } = *grid;
        let kx2 = |i: usize| (TAU / length * i.min(nx - i) as f64).powi(2);
        let ky2 = |j: usize| (TAU / height * j as f64).powi(2);
        Self {
            kx2: (0..nx).map(kx2).collect(),
            ky2: (0..rows).map(|row| from_fn(|lane| ky2(row * LANES + lane))).collect(),
            decay_x: vec![1.0; nx],
            decay_y: vec![[1.0; LANES]; rows],
            nu_dt: 0.0,
        }
    }

    fn set_viscosity(&mut self, nu_dt: f64) {
        if nu_dt == self.nu_dt {
            return;
        }
        self.nu_dt = nu_dt;
        let decay = |k2: f64| (-nu_dt * k2).exp();
        self.decay_x.iter_mut().zip(&self.kx2).for_each(|(x, k2)| *x = decay(*k2));
        self.decay_y.iter_mut().zip(&self.ky2).for_each(|(y, k2)| *y = k2.map(decay));
    }
}

impl Fluid {
    /// One step of size `dt` to the time `end`; the bodies are still where they were, the stations at their end.
    pub(super) fn step_rk2(&mut self, dt: f64, end: f64) -> Result<(), Error> {
        if let Some(rk2) = &mut self.rk2 {
            rk2.set_viscosity(dt * self.nu);
        }
        self.add_rate_of_change(dt);
        self.state.time = end;
        self.paint_moving_bodies();
        self.solve_stage(Stage::First);
        self.add_rate_of_change(dt);
        self.solve_stage(Stage::Second);
        self.state.step = dt;
        self.look();
        self.sum_up_forces(dt, Self::present_drag);
        self.finish_step(dt)
    }

    /// Longest step that the explicit drag allows, s.
    pub(super) fn longest_explicit_step(&self) -> f64 {
        let stiffest = self.rate.iter().flatten().fold(0.0_f64, |most, rate| most.max(*rate));
        1.0 / stiffest.max(f64::MIN_POSITIVE)
    }

    /// `u + dt f` at the present time, into `w`.
    pub(super) fn add_rate_of_change(&mut self, dt: f64) {
        self.look();
        let Flow { velocity: [u, v], vorticity } = &self.state.flow;
        let rate = self.rate.as_deref();
        explicit(dt, u, v, vorticity, -1.0, rate, &mut self.w[0]);
        explicit(dt, v, u, vorticity, 1.0, rate, &mut self.w[1]);
        self.add_body_velocities(|_| dt);
    }

    /// From w to the flow after a stage.
    pub(super) fn solve_stage(&mut self, stage: Stage) {
        self.hold_mean_flow();
        let Some(Rk2 { decay_x, decay_y, .. }) = &self.rk2 else { return };
        let [u_hat, v_hat, omega_hat] = &mut self.spectra;
        let [u_before, v_before] = &mut self.state.u_hat;
        let scratch = &mut self.scratch[0];
        self.fft.forward(&self.w[0], u_hat, scratch);
        self.fft.forward(&self.w[1], v_hat, scratch);
        let (nx, points) = (self.grid.nx, self.grid.len() as f64);
        self.projection.set_viscosity(0.0);
        for (row, decay_y) in decay_y.iter().enumerate() {
            let modes = row * nx..(row + 1) * nx;
            let [u_hat, v_hat, omega_hat] =
                [&mut *u_hat, v_hat, omega_hat].map(|spectrum| &mut spectrum[modes.clone()]);
            let [u_before, v_before] = [&mut *u_before, v_before].map(|spectrum| &mut spectrum[modes.clone()]);
            for (w, before) in [(&mut *u_hat, &*u_before), (&mut *v_hat, &*v_before)] {
                for ((w, before), decay_x) in w.iter_mut().zip(before).zip(decay_x) {
                    for (lane, decay_y) in decay_y.iter().enumerate() {
                        let decay = decay_x * decay_y;
                        let (re, im) = (&mut w.re[lane], &mut w.im[lane]);
                        match stage {
                            Stage::Start => {}
                            Stage::First => (*re, *im) = (decay * *re, decay * *im),
                            Stage::Second => {
                                *re = 0.5 * (*re + points * decay * before.re[lane]);
                                *im = 0.5 * (*im + points * decay * before.im[lane]);
                            }
                        }
                    }
                }
            }
            self.projection.project(row, u_hat, v_hat, omega_hat);
            if stage != Stage::First {
                u_before.copy_from_slice(u_hat);
                v_before.copy_from_slice(v_hat);
            }
        }
        let Flow { velocity: [u, v], vorticity } = &mut self.state.flow;
        for (spectrum, field) in [(u_hat, &mut *u), (v_hat, &mut *v), (omega_hat, vorticity)] {
            self.fft.inverse(spectrum, field, scratch);
        }
        let largest = kernel::advection_rate(1.0 / self.grid.dx, 1.0 / self.grid.dy, u, v);
        // A transform spreads what is not a number to every point: the first tells of all.
        self.state.advection_rate = if (u[0] + v[0]).is_finite() { largest } else { f64::NAN };
    }

    /// Spectrum of a uniform velocity, for the state at the beginning.
    pub(super) fn uniform_spectrum(&self, velocity: f64) -> Vec<Quad> {
        let mut spectrum = self.fft.spectrum();
        spectrum[0].re[0] = velocity;
        spectrum
    }
}

/// `u + dt (−sign omega other − a u)`, with `sign omega other` this component of `omega × u`.
#[multiversion(targets("x86_64+avx2+fma"))]
fn explicit(dt: f64, u: &[f64], other: &[f64], omega: &[f64], sign: f64, rate: Option<&[f64]>, w: &mut [f64]) {
    let n = w.len();
    let (u, other, omega) = (&u[..n], &other[..n], &omega[..n]);
    match rate.map(|rate| &rate[..n]) {
        Some(rate) => (0..n).for_each(|i| w[i] = u[i] - dt * (sign * omega[i] * other[i] + rate[i] * u[i])),
        None => (0..n).for_each(|i| w[i] = u[i] - dt * (sign * omega[i] * other[i])),
    }
}
