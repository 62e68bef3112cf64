//! The spectral half of a step: viscosity, filter and projection onto divergence-free fields.

use std::f64::consts::TAU;

use multiversion::multiversion;
use scene::Filter;

use crate::fft::Complex64;
use crate::grid::Grid;

/// Strength and order of the smooth filter exp(−α (k/k_max)^p) (Hou & Li 2007).
const FILTER_STRENGTH: f64 = 36.0;
const FILTER_ORDER: i32 = 36;

/// Wavenumbers and filter of one grid.
pub struct Projection {
    kx: Vec<f64>,
    ky: Vec<f64>,
    /// Filter over the number of points (the transforms are unnormalised), `[ny/2 + 1, nx]`.
    filter: Vec<f64>,
    /// `1/k²`, 0 for the mean, `[ny/2 + 1, nx]`.
    inverse_k2: Vec<f64>,
    /// `filter / (1 + tau nu k²)` for the `tau nu` it was last made for.
    gain: Vec<f64>,
    tau_nu: f64,
    /// Mean velocity that is held, m/s; absent where it is free.
    pub mean: Option<[f64; 2]>,
}

impl Projection {
    /// Wavenumbers and filter of `grid`.
    pub fn new(grid: &Grid, filter: Filter) -> Self {
        let Grid { nx, ny, length, height, .. } = *grid;
        let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
        let kx: Vec<f64> = (0..nx).map(|i| TAU / length * signed(i, nx)).collect();
        let ky: Vec<f64> = (0..=ny / 2).map(|j| TAU / height * j as f64).collect();
        let factor = |i: usize, j: usize| {
            let (p, q) = (2.0 * signed(i, nx).abs() / nx as f64, 2.0 * j as f64 / ny as f64);
            let fraction_squared = p * p + q * q;
            // The highest wave of an even grid has no odd derivative: it is always left out.
            if p == 1.0 || q == 1.0 {
                return 0.0;
            }
            match filter {
                Filter::None => 1.0,
                Filter::Smooth => (-FILTER_STRENGTH * fraction_squared.powi(FILTER_ORDER / 2)).exp(),
                Filter::TwoThirds => f64::from(2.25 * fraction_squared < 1.0),
            }
        };
        let modes = || (0..(ny / 2 + 1) * nx).map(|m| (m % nx, m / nx));
        let filter: Vec<f64> = modes().map(|(i, j)| factor(i, j) / grid.len() as f64).collect();
        let inverse_k2 = modes().map(|(i, j)| if i + j == 0 { 0.0 } else { 1.0 / (kx[i] * kx[i] + ky[j] * ky[j]) });
        Self { inverse_k2: inverse_k2.collect(), gain: filter.clone(), tau_nu: 0.0, mean: None, kx, ky, filter }
    }

    /// Make ready for steps with `tau nu` (m²).
    pub fn set_viscosity(&mut self, tau_nu: f64) {
        if tau_nu == self.tau_nu {
            return;
        }
        self.tau_nu = tau_nu;
        let nx = self.kx.len();
        for (m, (gain, filter)) in self.gain.iter_mut().zip(&self.filter).enumerate() {
            let k2 = self.kx[m % nx].powi(2) + self.ky[m / nx].powi(2);
            *gain = filter / (1.0 + tau_nu * k2);
        }
    }

    /// Solve `(1 − tau nu ∇²) u + tau ∇Pi = F w, ∇·u = 0` for the modes of row `j` of ky.
    ///
    /// `wx` and `wy` hold w, unnormalised, and get u; `omega` gets the vorticity of u.
    pub fn project(&self, j: usize, wx: &mut [Complex64], wy: &mut [Complex64], omega: &mut [Complex64]) {
        let modes = j * self.kx.len()..(j + 1) * self.kx.len();
        let (inverse_k2, gain) = (&self.inverse_k2[modes.clone()], &self.gain[modes]);
        project_row(&Row { kx: &self.kx, ky: self.ky[j], inverse_k2, gain }, wx, wy, omega);
        if let (0, Some([u, v])) = (j, self.mean) {
            (wx[0], wy[0]) = (u.into(), v.into());
        }
    }

    /// The divergence of a velocity from its unnormalised spectra, `i k·u / (nx ny)`.
    pub fn divergence(&self, ux: &[Complex64], uy: &[Complex64], divergence: &mut [Complex64]) {
        let nx = self.kx.len();
        // The mean passes every filter.
        let per_points = self.filter[0];
        for (m, divergence) in divergence.iter_mut().enumerate() {
            let along = ux[m] * self.kx[m % nx] + uy[m] * self.ky[m / nx];
            *divergence = Complex64::new(-along.im, along.re) * per_points;
        }
    }

    /// The Pi that belongs to it, from the whole spectra of w: `−i k·w F / (tau k²)`.
    pub fn pressure(&self, wx: &[Complex64], wy: &[Complex64], per_tau: f64, pressure: &mut [Complex64]) {
        let nx = self.kx.len();
        for (j, row) in pressure.chunks_exact_mut(nx).enumerate() {
            for (i, (pressure, kx)) in row.iter_mut().zip(&self.kx).enumerate() {
                let m = j * nx + i;
                let along = (wx[m] * kx + wy[m] * self.ky[j]) * (self.inverse_k2[m] * self.filter[m]);
                *pressure = Complex64::new(along.im, -along.re) * per_tau;
            }
        }
    }
}

/// Coefficients of the modes of one ky.
struct Row<'a> {
    kx: &'a [f64],
    ky: f64,
    inverse_k2: &'a [f64],
    gain: &'a [f64],
}

/// [`Projection::project`] for the processor at hand.
#[multiversion(targets("x86_64+avx2+fma"))]
fn project_row(
    &Row { kx, ky, inverse_k2, gain }: &Row,
    wx: &mut [Complex64],
    wy: &mut [Complex64],
    omega: &mut [Complex64],
) {
    let n = kx.len();
    let (inverse_k2, gain) = (&inverse_k2[..n], &gain[..n]);
    let (wx, wy, omega) = (&mut wx[..n], &mut wy[..n], &mut omega[..n]);
    for i in 0..n {
        let (kx, g) = (kx[i], gain[i]);
        let along = (wx[i] * kx + wy[i] * ky) * (inverse_k2[i] * g);
        let curl = (wy[i] * kx - wx[i] * ky) * g;
        wx[i] = wx[i] * g - along * kx;
        wy[i] = wy[i] * g - along * ky;
        omega[i] = Complex64::new(-curl.im, curl.re);
    }
}
