//! The spectral half of a step: viscosity, filter and projection onto divergence-free fields.

use std::array::from_fn;
use std::f64::consts::TAU;

use scene::Filter;

use crate::grid::Grid;
use crate::simd::{Arithmetic, Kernel, LANES, run, splat};
use crate::transform::{Complex4, Quad};

/// Strength and order of the smooth filter `F_0 = exp(−α (k/k_max)^p)` (Hou & Li 2007).
///
/// Applied once in each step, as it is meant, it would be a drag on the short waves with the rate `(1/F_0 − 1)/dt`, which
/// grows without bound as the step is refined. Here the rate belongs to the flow: `r = (1/F_0 − 1) q/FILTER_CFL` with q
/// its largest `|u|/dx + |v|/dy`, the rate at which waves of the grid's size are made. It stands in the equations as a
/// term `−r u` like viscosity does, so a solution has a limit in dt; at the CFL number [`FILTER_CFL`] a step does what
/// one application of F_0 does.
const FILTER_STRENGTH: f64 = 36.0;
const FILTER_ORDER: i32 = 36;
const FILTER_CFL: f64 = 0.3;

/// What the smooth filter takes of a wave in a step of the CFL number 1, by the wavenumber over the highest.
pub fn smooth_damping(fraction: f64) -> f64 {
    ((FILTER_STRENGTH * fraction.powi(FILTER_ORDER)).exp() - 1.0) / FILTER_CFL
}

/// Wavenumbers and filter of one grid, for the rows of [`crate::transform`]: four modes in y at a time.
pub struct Projection {
    kx: Vec<f64>,
    ky: Vec<[f64; LANES]>,
    /// What the filter takes in a step of the CFL number 1, `(1/F_0 − 1)/FILTER_CFL`, `[rows, nx]`.
    damping: Vec<[f64; LANES]>,
    /// `1/k²`, 0 for the mean, `[rows, nx]`.
    inverse_k2: Vec<[f64; LANES]>,
    /// 1 over the number of points: the transforms are unnormalised.
    per_points: f64,
    /// `tau nu`, m², and the CFL number of the step.
    tau_nu: f64,
    cfl: f64,
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
        let damping = |i: usize, j: usize| {
            let (p, q) = (2.0 * signed(i, nx).abs() / nx as f64, 2.0 * j as f64 / ny as f64);
            let fraction_squared = p * p + q * q;
            // The highest wave of an even grid has no odd derivative: it is always left out.
            if p >= 1.0 || q >= 1.0 {
                return f64::INFINITY;
            }
            match filter {
                Filter::TwoThirds if 2.25 * fraction_squared >= 1.0 => f64::INFINITY,
                Filter::None | Filter::TwoThirds => 0.0,
                Filter::Smooth => smooth_damping(fraction_squared.sqrt()),
            }
        };
        let modes = (0..=ny / 2).rev().find(|&j| (0..nx).any(|i| damping(i, j) < f64::INFINITY)).map_or(0, |j| j + 1);
        let rows = modes.div_ceil(LANES);
        let by_mode = |value: &dyn Fn(usize, usize) -> f64| -> Vec<[f64; LANES]> {
            (0..rows * nx).map(|m| from_fn(|lane| value(m % nx, m / nx * LANES + lane))).collect()
        };
        let damping = by_mode(&damping);
        let ky = |j: usize| TAU / height * j as f64;
        let inverse_k2 = by_mode(&|i, j| if i + j == 0 { 0.0 } else { 1.0 / (kx[i] * kx[i] + ky(j) * ky(j)) });
        let ky = (0..rows).map(|row| from_fn(|lane| ky(row * LANES + lane))).collect();
        let per_points = 1.0 / grid.len() as f64;
        Self { kx, ky, damping, inverse_k2, per_points, tau_nu: 0.0, cfl: 0.0, mean: None, modes }
    }

    /// Number of modes in y that the filter leaves.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Make ready for a step with `tau nu` (m²) and a CFL number.
    pub fn set_step(&mut self, tau_nu: f64, cfl: f64) {
        // What the filter cuts off has infinite damping, in still fluid too.
        (self.tau_nu, self.cfl) = (tau_nu, cfl.max(f64::MIN_POSITIVE));
    }

    /// Solve `(1 − tau nu ∇² + tau r) u + tau ∇Pi = w, ∇·u = 0` for the modes of a row.
    ///
    /// `wx` and `wy` hold w, unnormalised, and get u; `omega` gets the vorticity of u.
    pub fn project(&self, row: usize, wx: &mut [Quad], wy: &mut [Quad], omega: &mut [Quad]) {
        let modes = row * self.kx.len()..(row + 1) * self.kx.len();
        let (inverse_k2, damping) = (&self.inverse_k2[modes.clone()], &self.damping[modes]);
        let Self { per_points, tau_nu, cfl, .. } = *self;
        let (kx, ky) = (&self.kx[..], self.ky[row]);
        run(ProjectRow { kx, ky, inverse_k2, damping, per_points, tau_nu, cfl, wx: &mut *wx, wy: &mut *wy, omega });
        if let (0, Some(mean)) = (row, self.mean) {
            for (w, mean) in [wx, wy].into_iter().zip(mean) {
                (w[0].re[0], w[0].im[0]) = (mean, 0.0);
            }
        }
    }

    /// The divergence of a velocity from its unnormalised spectra, `i k·u / (nx ny)`.
    pub fn divergence(&self, ux: &[Quad], uy: &[Quad], divergence: &mut [Quad]) {
        let nx = self.kx.len();
        let scale = self.per_points;
        for (m, divergence) in divergence.iter_mut().enumerate() {
            let (kx, ux, uy) = (self.kx[m % nx], &ux[m], &uy[m]);
            for (lane, ky) in self.ky[m / nx].iter().enumerate() {
                divergence.re[lane] = -scale * (kx * ux.im[lane] + ky * uy.im[lane]);
                divergence.im[lane] = scale * (kx * ux.re[lane] + ky * uy.re[lane]);
            }
        }
    }

    /// The Pi that belongs to it, from the whole spectra of w: `−i k·w / (tau k²)`, with as much of the short waves left
    /// out as the filter takes from a velocity in a step with a CFL number.
    pub fn pressure(&self, wx: &[Quad], wy: &[Quad], per_tau: f64, cfl: f64, pressure: &mut [Quad]) {
        let cfl = cfl.max(f64::MIN_POSITIVE);
        let nx = self.kx.len();
        for (m, pressure) in pressure.iter_mut().enumerate() {
            let (kx, wx, wy) = (self.kx[m % nx], &wx[m], &wy[m]);
            for (lane, ky) in self.ky[m / nx].iter().enumerate() {
                let filtered = self.per_points / (1.0 + cfl * self.damping[m][lane]);
                let scale = per_tau * self.inverse_k2[m][lane] * filtered;
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
    damping: &'a [[f64; LANES]],
    per_points: f64,
    tau_nu: f64,
    cfl: f64,
    wx: &'a mut [Quad],
    wy: &'a mut [Quad],
    omega: &'a mut [Quad],
}

impl Kernel for ProjectRow<'_> {
    #[inline(always)]
    fn run(self, on: impl Arithmetic) {
        let ky = pulp::cast(self.ky);
        let (per_points, tau_nu, cfl) = (splat(self.per_points), splat(self.tau_nu), splat(self.cfl));
        let along_y = on.mul_add(tau_nu, on.mul_f64s(ky, ky), splat(1.0));
        let coefficients = self.kx.iter().zip(self.inverse_k2).zip(self.damping);
        let modes = self.wx.iter_mut().zip(self.wy).zip(self.omega);
        for (((kx, inverse_k2), damping), ((wx, wy), omega)) in coefficients.zip(modes) {
            let (kx, inverse_k2, damping) = (splat(*kx), pulp::cast(*inverse_k2), pulp::cast(*damping));
            let viscous = on.mul_add(tau_nu, on.mul_f64s(kx, kx), along_y);
            let gain = on.div_f64s(per_points, on.mul_add(cfl, damping, viscous));
            // w/(1 + tau nu k² + tau r), then what of it is along the wave.
            let (x, y) = (Complex4::load(wx).scaled(on, gain), Complex4::load(wy).scaled(on, gain));
            let along = x.scaled(on, kx).mul_add(on, ky, y).scaled(on, inverse_k2);
            let curl = y.scaled(on, kx).mul_sub(on, ky, x);
            *wx = x.mul_sub(on, kx, along).quad();
            *wy = y.mul_sub(on, ky, along).quad();
            *omega = curl.times_i(on).quad();
        }
    }
}
