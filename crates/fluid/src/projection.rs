//! The spectral half of a step: viscosity, filter and projection onto divergence-free fields.
//!
//! All of it is calculated in double precision, mode by mode, whatever the precision of the spectra: a factor `1 + tau nu k²`
//! rounded to single would be off by as much as viscosity takes from a long wave in a step, in every step alike.

use std::array::from_fn;
use std::f64::consts::TAU;
use std::marker::PhantomData;

use scene::Filter;

use crate::grid::Grid;
use line_fft::Pack;
use line_fft::{Arithmetic, F64_LANES, Kernel, Real, run};

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

/// Wavenumbers and filter of one grid, for the rows of a spectrum of [`line_fft::Fft2`]: [`Real::PARTS`] times four modes in y at a
/// time.
pub struct Projection<R> {
    kx: Vec<f64>,
    /// By row and part.
    ky: Vec<[f64; F64_LANES]>,
    /// What the filter takes in a step of the CFL number 1, `(1/F_0 − 1)/FILTER_CFL`, `[rows, nx]` by part.
    damping: Vec<[f64; F64_LANES]>,
    /// `1/k²`, 0 for the mean, `[rows, nx]` by part.
    inverse_k2: Vec<[f64; F64_LANES]>,
    /// 1 over the number of points: the transforms are unnormalised.
    per_points: f64,
    /// 1 over what rounding makes of a mode in the transforms: a factor for each kx, and for each ky by row and part.
    per_gain_x: Vec<f64>,
    per_gain_y: Vec<[f64; F64_LANES]>,
    /// `tau nu`, m², and the CFL number of the step.
    tau_nu: f64,
    cfl: f64,
    /// Mean velocity that is held, m/s; absent where it is free.
    pub mean: Option<[f64; 2]>,
    modes: usize,
    precision: PhantomData<R>,
}

impl<R: Real> Projection<R> {
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
        let rows = modes.div_ceil(R::LANES);
        // The first mode in y of a part of a row.
        let first = |row: usize, part: usize| row * R::LANES + part * F64_LANES;
        let by_mode = |value: &dyn Fn(usize, usize) -> f64| -> Vec<[f64; F64_LANES]> {
            let place = |n: usize| (n / R::PARTS % nx, first(n / R::PARTS / nx, n % R::PARTS));
            let modes = (0..rows * nx * R::PARTS).map(place);
            modes.map(|(i, first)| from_fn(|lane| value(i, first + lane))).collect()
        };
        let damping = by_mode(&damping);
        let ky = |j: usize| TAU / height * j as f64;
        let inverse_k2 = by_mode(&|i, j| if i + j == 0 { 0.0 } else { 1.0 / (kx[i] * kx[i] + ky(j) * ky(j)) });
        let parts = (0..rows).flat_map(|row| (0..R::PARTS).map(move |part| first(row, part)));
        let ky = parts.map(|first| from_fn(|lane| ky(first + lane))).collect();
        let per_points = 1.0 / grid.len() as f64;
        Self {
            per_gain_x: vec![1.0; nx],
            per_gain_y: vec![[1.0; F64_LANES]; rows * R::PARTS],
            kx,
            ky,
            damping,
            inverse_k2,
            per_points,
            tau_nu: 0.0,
            cfl: 0.0,
            mean: None,
            modes,
            precision: PhantomData,
        }
    }

    /// Number of modes in y that the filter leaves.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Take out what transforms with these [`Fft2::gains`](line_fft::Fft2::gains) make of a mode in a step.
    pub fn set_gains(&mut self, [x, y]: &[Vec<f64>; 2]) {
        self.per_gain_x = x.iter().map(|gain| 1.0 / gain).collect();
        self.per_gain_y = y.as_chunks().0.iter().map(|gains| gains.map(|gain| 1.0 / gain)).collect();
    }

    /// Make ready for a step with `tau nu` (m²) and a CFL number.
    pub fn set_step(&mut self, tau_nu: f64, cfl: f64) {
        // What the filter cuts off has infinite damping, in still fluid too.
        (self.tau_nu, self.cfl) = (tau_nu, cfl.max(f64::MIN_POSITIVE));
    }

    /// Solve `(1 − tau nu ∇² + tau r) u + tau ∇Pi = w, ∇·u = 0` for the modes of a row.
    ///
    /// `wx` and `wy` hold w, unnormalised, and get u; `omega` gets the vorticity of u.
    pub fn project(&self, row: usize, wx: &mut [Pack<R>], wy: &mut [Pack<R>], omega: &mut [Pack<R>]) {
        let row_length = self.kx.len() * R::PARTS;
        let modes = row * row_length..(row + 1) * row_length;
        let (inverse_k2, damping) = (&self.inverse_k2[modes.clone()], &self.damping[modes]);
        let Self { per_points, tau_nu, cfl, .. } = *self;
        let [ky, per_gain_y] = [&self.ky, &self.per_gain_y].map(|of| &of[row * R::PARTS..(row + 1) * R::PARTS]);
        let (kx, per_gain_x) = (&self.kx[..], &self.per_gain_x[..]);
        let (x, y) = (&mut *wx, &mut *wy);
        run(ProjectRow {
            kx,
            ky,
            inverse_k2,
            damping,
            per_gain_x,
            per_gain_y,
            per_points,
            tau_nu,
            cfl,
            wx: x,
            wy: y,
            omega,
        });
        if let (0, Some(mean)) = (row, self.mean) {
            for (w, mean) in [wx, wy].into_iter().zip(mean) {
                (w[0].re[0], w[0].im[0]) = (R::rounded(mean), R::rounded(0.0));
            }
        }
    }

    /// The divergence of a velocity from its unnormalised spectra, `i k·u / (nx ny)`.
    pub fn divergence(&self, ux: &[Pack<R>], uy: &[Pack<R>], divergence: &mut [Pack<R>]) {
        let nx = self.kx.len();
        let scale = self.per_points;
        for (m, divergence) in divergence.iter_mut().enumerate() {
            let (kx, ux, uy) = (self.kx[m % nx], &ux[m], &uy[m]);
            for lane in 0..R::LANES {
                let ky = self.ky[m / nx * R::PARTS + lane / F64_LANES][lane % F64_LANES];
                divergence.re[lane] = R::rounded(-scale * (kx * ux.im[lane].to_f64() + ky * uy.im[lane].to_f64()));
                divergence.im[lane] = R::rounded(scale * (kx * ux.re[lane].to_f64() + ky * uy.re[lane].to_f64()));
            }
        }
    }

    /// The Pi that belongs to it, from the whole spectra of w: `−i k·w / (tau k²)`, with as much of the short waves left
    /// out as the filter takes from a velocity in a step with a CFL number.
    pub fn pressure(&self, wx: &[Pack<R>], wy: &[Pack<R>], per_tau: f64, cfl: f64, pressure: &mut [Pack<R>]) {
        let cfl = cfl.max(f64::MIN_POSITIVE);
        let nx = self.kx.len();
        for (m, pressure) in pressure.iter_mut().enumerate() {
            let (kx, wx, wy) = (self.kx[m % nx], &wx[m], &wy[m]);
            for lane in 0..R::LANES {
                let (part, in_part) = (m * R::PARTS + lane / F64_LANES, lane % F64_LANES);
                let ky = self.ky[m / nx * R::PARTS + lane / F64_LANES][in_part];
                let filtered = self.per_points / (1.0 + cfl * self.damping[part][in_part]);
                let scale = per_tau * self.inverse_k2[part][in_part] * filtered;
                pressure.re[lane] = R::rounded(scale * (kx * wx.im[lane].to_f64() + ky * wy.im[lane].to_f64()));
                pressure.im[lane] = R::rounded(-scale * (kx * wx.re[lane].to_f64() + ky * wy.re[lane].to_f64()));
            }
        }
    }
}

/// [`Projection::project`] with the coefficients of the row.
struct ProjectRow<'a, R: Real> {
    kx: &'a [f64],
    ky: &'a [[f64; F64_LANES]],
    inverse_k2: &'a [[f64; F64_LANES]],
    damping: &'a [[f64; F64_LANES]],
    per_gain_x: &'a [f64],
    per_gain_y: &'a [[f64; F64_LANES]],
    per_points: f64,
    tau_nu: f64,
    cfl: f64,
    wx: &'a mut [Pack<R>],
    wy: &'a mut [Pack<R>],
    omega: &'a mut [Pack<R>],
}

impl<R: Real> Kernel for ProjectRow<'_, R> {
    type Real = f64;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<f64>) {
        let (tau_nu, cfl) = (self.tau_nu.splat(), self.cfl.splat());
        // What the parts of a row have of their own; in double precision there is one.
        let [mut ky, mut along_y, mut scale] = [[0.0.splat(); 2]; 3];
        for part in 0..R::PARTS {
            ky[part] = f64::load(&self.ky[part]);
            along_y[part] = on.mul_add(tau_nu, on.mul(ky[part], ky[part]), 1.0.splat());
            scale[part] = on.mul(self.per_points.splat(), f64::load(&self.per_gain_y[part]));
        }
        let coefficients = self.inverse_k2.chunks_exact(R::PARTS).zip(self.damping.chunks_exact(R::PARTS));
        let modes = self.wx.iter_mut().zip(self.wy).zip(self.omega);
        let along_x = self.kx.iter().zip(self.per_gain_x);
        for (((kx, per_gain_x), (inverse_k2, damping)), ((wx, wy), omega)) in along_x.zip(coefficients).zip(modes) {
            let (kx, per_gain_x) = (kx.splat(), per_gain_x.splat());
            for part in 0..R::PARTS {
                let (inverse_k2, damping) = (f64::load(&inverse_k2[part]), f64::load(&damping[part]));
                let (ky, viscous) = (ky[part], on.mul_add(tau_nu, on.mul(kx, kx), along_y[part]));
                let gain = on.div(on.mul(scale[part], per_gain_x), on.mul_add(cfl, damping, viscous));
                // w/(1 + tau nu k² + tau r), then what of it is along the wave.
                let (x, y) = (wx.part(part).scaled(on, gain), wy.part(part).scaled(on, gain));
                let along = x.scaled(on, kx).mul_add(on, ky, y).scaled(on, inverse_k2);
                let curl = y.scaled(on, kx).mul_sub(on, ky, x);
                wx.set_part(part, x.mul_sub(on, kx, along));
                wy.set_part(part, y.mul_sub(on, ky, along));
                omega.set_part(part, curl.times_i(on));
            }
        }
    }
}
