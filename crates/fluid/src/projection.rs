//! The spectral half of a step: viscosity, filter and projection onto divergence-free fields.

use std::array::from_fn;
use std::f64::consts::TAU;

use scene::Filter;

use crate::grid::Grid;
use crate::simd::{Arithmetic, Kernel, LANES, run, splat};
use crate::transform::{Complex4, Quad};

/// Strength and order of the smooth filter exp(−α (k/k_max)^p) (Hou & Li 2007).
const FILTER_STRENGTH: f64 = 36.0;
const FILTER_ORDER: i32 = 36;

/// Wavenumbers and filter of one grid, for the rows of [`crate::transform`]: four modes in y at a time.
pub struct Projection {
    kx: Vec<f64>,
    ky: Vec<[f64; LANES]>,
    /// Filter over the number of points (the transforms are unnormalised), `[rows, nx]`.
    filter: Vec<[f64; LANES]>,
    /// `1/k²`, 0 for the mean, `[rows, nx]`.
    inverse_k2: Vec<[f64; LANES]>,
    /// `filter / (1 + tau nu k²)` for the `tau nu` it was last made for.
    gain: Vec<[f64; LANES]>,
    tau_nu: f64,
    /// Mean velocity that is held, m/s; absent where it is free.
    pub mean: Option<[f64; 2]>,
    modes: usize,
}

impl Projection {
    /// Wavenumbers and filter of `grid`.
    pub fn new(grid: &Grid, filter: Filter) -> Self {
        let Grid { nx, ny, length, height, .. } = *grid;
        let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
        let kx: Vec<f64> = (0..nx).map(|i| TAU / length * signed(i, nx)).collect();
        let factor = |i: usize, j: usize| {
            let (p, q) = (2.0 * signed(i, nx).abs() / nx as f64, 2.0 * j as f64 / ny as f64);
            let fraction_squared = p * p + q * q;
            // The highest wave of an even grid has no odd derivative: it is always left out.
            if p >= 1.0 || q >= 1.0 {
                return 0.0;
            }
            match filter {
                Filter::None => 1.0,
                Filter::Smooth => (-FILTER_STRENGTH * fraction_squared.powi(FILTER_ORDER / 2)).exp(),
                Filter::TwoThirds => f64::from(2.25 * fraction_squared < 1.0),
            }
        };
        let modes = (0..=ny / 2).rev().find(|&j| (0..nx).any(|i| factor(i, j) > 0.0)).map_or(0, |j| j + 1);
        let rows = modes.div_ceil(LANES);
        let by_mode = |value: &dyn Fn(usize, usize) -> f64| -> Vec<[f64; LANES]> {
            (0..rows * nx).map(|m| from_fn(|lane| value(m % nx, m / nx * LANES + lane))).collect()
        };
        let filter = by_mode(&|i, j| factor(i, j) / grid.len() as f64);
        let ky = |j: usize| TAU / height * j as f64;
        let inverse_k2 = by_mode(&|i, j| if i + j == 0 { 0.0 } else { 1.0 / (kx[i] * kx[i] + ky(j) * ky(j)) });
        let ky = (0..rows).map(|row| from_fn(|lane| ky(row * LANES + lane))).collect();
        Self { inverse_k2, gain: filter.clone(), tau_nu: 0.0, mean: None, kx, ky, filter, modes }
    }

    /// Number of modes in y that the filter leaves.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Make ready for steps with `tau nu` (m²).
    pub fn set_viscosity(&mut self, tau_nu: f64) {
        if tau_nu == self.tau_nu {
            return;
        }
        self.tau_nu = tau_nu;
        let nx = self.kx.len();
        for (m, (gain, filter)) in self.gain.iter_mut().zip(&self.filter).enumerate() {
            *gain = from_fn(|lane| {
                let k2 = self.kx[m % nx].powi(2) + self.ky[m / nx][lane].powi(2);
                filter[lane] / (1.0 + tau_nu * k2)
            });
        }
    }

    /// Solve `(1 − tau nu ∇²) u + tau ∇Pi = F w, ∇·u = 0` for the modes of a row.
    ///
    /// `wx` and `wy` hold w, unnormalised, and get u; `omega` gets the vorticity of u.
    pub fn project(&self, row: usize, wx: &mut [Quad], wy: &mut [Quad], omega: &mut [Quad]) {
        let modes = row * self.kx.len()..(row + 1) * self.kx.len();
        let (inverse_k2, gain) = (&self.inverse_k2[modes.clone()], &self.gain[modes]);
        run(ProjectRow { kx: &self.kx, ky: self.ky[row], inverse_k2, gain, wx: &mut *wx, wy: &mut *wy, omega });
        if let (0, Some(mean)) = (row, self.mean) {
            for (w, mean) in [wx, wy].into_iter().zip(mean) {
                (w[0].re[0], w[0].im[0]) = (mean, 0.0);
            }
        }
    }

    /// The divergence of a velocity from its unnormalised spectra, `i k·u / (nx ny)`.
    pub fn divergence(&self, ux: &[Quad], uy: &[Quad], divergence: &mut [Quad]) {
        let nx = self.kx.len();
        // The mean passes every filter.
        let scale = self.filter[0][0];
        for (m, divergence) in divergence.iter_mut().enumerate() {
            let (kx, ux, uy) = (self.kx[m % nx], &ux[m], &uy[m]);
            for (lane, ky) in self.ky[m / nx].iter().enumerate() {
                divergence.re[lane] = -scale * (kx * ux.im[lane] + ky * uy.im[lane]);
                divergence.im[lane] = scale * (kx * ux.re[lane] + ky * uy.re[lane]);
            }
        }
    }

    /// The Pi that belongs to it, from the whole spectra of w: `−i k·w F / (tau k²)`.
    pub fn pressure(&self, wx: &[Quad], wy: &[Quad], per_tau: f64, pressure: &mut [Quad]) {
        let nx = self.kx.len();
        for (m, pressure) in pressure.iter_mut().enumerate() {
            let (kx, wx, wy) = (self.kx[m % nx], &wx[m], &wy[m]);
            for (lane, ky) in self.ky[m / nx].iter().enumerate() {
                let scale = per_tau * self.inverse_k2[m][lane] * self.filter[m][lane];
                pressure.re[lane] = scale * (kx * wx.im[lane] + ky * wy.im[lane]);
                pressure.im[lane] = -scale * (kx * wx.re[lane] + ky * wy.re[lane]);
            }
        }
    }
}

/// [`Projection::project`] with the coefficients of the row.
struct ProjectRow<'a> {
    kx: &'a [f64],
    ky: [f64; LANES],
    inverse_k2: &'a [[f64; LANES]],
    gain: &'a [[f64; LANES]],
    wx: &'a mut [Quad],
    wy: &'a mut [Quad],
    omega: &'a mut [Quad],
}

impl Kernel for ProjectRow<'_> {
    #[inline(always)]
    fn run(self, on: impl Arithmetic) {
        let ky = pulp::cast(self.ky);
        let coefficients = self.kx.iter().zip(self.inverse_k2).zip(self.gain);
        let modes = self.wx.iter_mut().zip(self.wy).zip(self.omega);
        for (((kx, inverse_k2), gain), ((wx, wy), omega)) in coefficients.zip(modes) {
            let (kx, inverse_k2, gain) = (splat(*kx), pulp::cast(*inverse_k2), pulp::cast(*gain));
            // F w/(1 + tau nu k²), then what of it is along the wave.
            let (x, y) = (Complex4::load(wx).scaled(on, gain), Complex4::load(wy).scaled(on, gain));
            let along = x.scaled(on, kx).mul_add(on, ky, y).scaled(on, inverse_k2);
            let curl = y.scaled(on, kx).mul_sub(on, ky, x);
            *wx = x.mul_sub(on, kx, along).quad();
            *wy = y.mul_sub(on, ky, along).quad();
            *omega = curl.times_i(on).quad();
        }
    }
}
