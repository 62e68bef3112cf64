//! The spectral half of a step: viscosity, filter and projection onto divergence-free fields.
//!
//! Every mode is calculated in double precision, for any precision of the spectra: the rounding of `1 + tau nu k²` to
//! single precision would be as large as what viscosity takes from a long wave in a step, and the same in every step.

use std::array::from_fn;
use std::f64::consts::TAU;
use std::marker::PhantomData;

use super::Implicit;
use crate::filter::{Damping, smooth_damping};
use crate::grid::Grid;
use line_fft::Pack;
use line_fft::{Arithmetic, F64_LANES, Kernel, Real, run};
use method::Filter;

/// Wavenumbers and filter of one grid, for the rows of a spectrum of [`line_fft::Fft2`].
pub struct Projection<R> {
    kx: Vec<f64>,
    /// By row and part.
    ky: Vec<[f64; F64_LANES]>,
    /// Damping by the filter in a step of the CFL number 1, `[rows, nx]` by part.
    damping: Vec<[f64; F64_LANES]>,
    /// `1/k²`, 0 for the mean, `[rows, nx]` by part.
    inverse_k2: Vec<[f64; F64_LANES]>,
    /// 1 over the number of points: the transforms are unnormalised.
    inv_points: f64,
    /// 1 over the gain of a mode in a round trip of the transforms, for each kx, and for each ky by row and part.
    inv_gain_x: Vec<f64>,
    inv_gain_y: Vec<[f64; F64_LANES]>,
    modes: usize,
    precision: PhantomData<R>,
}

impl<R: Real> Projection<R> {
    /// Prepare wavenumbers and filter of a grid.
    pub fn new(grid: &Grid<2>, damping: impl Into<Damping>) -> Self {
        let of_modes = damping.into();
        let ([nx, ny], [length, height]) = (grid.cells, grid.size);
        let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
        let kx: Vec<f64> = (0..nx).map(|i| TAU / length * signed(i, nx)).collect();
        let damping = |i: usize, j: usize| {
            let (p, q) = (2.0 * signed(i, nx).abs() / nx as f64, 2.0 * j as f64 / ny as f64);
            let fraction_squared = p * p + q * q;
            // The highest wave of an even grid has no odd derivative: it is always left out.
            if p >= 1.0 || q >= 1.0 {
                return f64::INFINITY;
            }
            match of_modes {
                Damping::Of(Filter::TwoThirds) if 2.25 * fraction_squared >= 1.0 => f64::INFINITY,
                Damping::Of(Filter::None | Filter::TwoThirds) => 0.0,
                Damping::Of(Filter::Smooth) => smooth_damping(fraction_squared.sqrt()),
                Damping::EachAxis => smooth_damping(p) + smooth_damping(q),
            }
        };
        let modes = (0..=ny / 2).rev().find(|&j| (0..nx).any(|i| damping(i, j) < f64::INFINITY)).map_or(0, |j| j + 1);
        let rows = modes.div_ceil(R::LANES);
        // First mode in y of a part of a row.
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
        let inv_points = 1.0 / grid.len() as f64;
        Self {
            inv_gain_x: vec![1.0; nx],
            inv_gain_y: vec![[1.0; F64_LANES]; rows * R::PARTS],
            kx,
            ky,
            damping,
            inverse_k2,
            inv_points,
            modes,
            precision: PhantomData,
        }
    }

    /// Return the number of modes in y that the filter leaves.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Compensate for the [`gains`](line_fft::Fft2::gains) of the transforms.
    pub fn set_gains(&mut self, [x, y]: &[Vec<f64>; 2]) {
        self.inv_gain_x = x.iter().map(|gain| 1.0 / gain).collect();
        self.inv_gain_y = y.as_chunks().0.iter().map(|gains| gains.map(|gain| 1.0 / gain)).collect();
    }

    /// Solve `(1 − tau nu ∇² + tau r) u + tau ∇Pi = w, ∇·u = 0` for the modes of a row.
    ///
    /// The spectra hold w, unnormalised, and receive u; the third receives the vorticity of u.
    pub fn project(&self, step: &Implicit<2>, row: usize, [wx, wy, omega]: [&mut [Pack<R>]; 3]) {
        let row_length = self.kx.len() * R::PARTS;
        let modes = row * row_length..(row + 1) * row_length;
        let (inverse_k2, damping) = (&self.inverse_k2[modes.clone()], &self.damping[modes]);
        let (inv_points, tau_nu) = (self.inv_points, step.tau_nu);
        // Modes that the filter cuts off have infinite damping, also in still fluid.
        let cfl = step.cfl.max(f64::MIN_POSITIVE);
        let [ky, inv_gain_y] = [&self.ky, &self.inv_gain_y].map(|of| &of[row * R::PARTS..(row + 1) * R::PARTS]);
        let (kx, inv_gain_x) = (&self.kx[..], &self.inv_gain_x[..]);
        let (x, y) = (&mut *wx, &mut *wy);
        run(ProjectRow {
            kx,
            ky,
            inverse_k2,
            damping,
            inv_gain_x,
            inv_gain_y,
            inv_points,
            tau_nu,
            cfl,
            wx: x,
            wy: y,
            omega,
        });
        if let (0, Some(mean)) = (row, step.mean) {
            for (w, mean) in [wx, wy].into_iter().zip(mean) {
                (w[0].re[0], w[0].im[0]) = (R::rounded(mean), R::rounded(0.0));
            }
        }
    }

    /// Write the divergence `i k·u / (nx ny)` of a velocity with unnormalised spectra.
    pub fn divergence(&self, ux: &[Pack<R>], uy: &[Pack<R>], divergence: &mut [Pack<R>]) {
        let nx = self.kx.len();
        let scale = self.inv_points;
        for (m, divergence) in divergence.iter_mut().enumerate() {
            let (kx, ux, uy) = (self.kx[m % nx], &ux[m], &uy[m]);
            for lane in 0..R::LANES {
                let ky = self.ky[m / nx * R::PARTS + lane / F64_LANES][lane % F64_LANES];
                divergence.re[lane] = R::rounded(-scale * (kx * ux.im[lane].to_f64() + ky * uy.im[lane].to_f64()));
                divergence.im[lane] = R::rounded(scale * (kx * ux.re[lane].to_f64() + ky * uy.re[lane].to_f64()));
            }
        }
    }

    /// Write the spectrum of `Pi = −i k·w / (tau k²)`. The filter damps its short waves as those of a velocity in a
    /// step with a CFL number.
    pub fn pressure(&self, wx: &[Pack<R>], wy: &[Pack<R>], inv_tau: f64, cfl: f64, pressure: &mut [Pack<R>]) {
        let cfl = cfl.max(f64::MIN_POSITIVE);
        let nx = self.kx.len();
        for (m, pressure) in pressure.iter_mut().enumerate() {
            let (kx, wx, wy) = (self.kx[m % nx], &wx[m], &wy[m]);
            for lane in 0..R::LANES {
                let (part, in_part) = (m * R::PARTS + lane / F64_LANES, lane % F64_LANES);
                let ky = self.ky[m / nx * R::PARTS + lane / F64_LANES][in_part];
                let filtered = self.inv_points / (1.0 + cfl * self.damping[part][in_part]);
                let scale = inv_tau * self.inverse_k2[part][in_part] * filtered;
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
    inv_gain_x: &'a [f64],
    inv_gain_y: &'a [[f64; F64_LANES]],
    inv_points: f64,
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
        // Coefficients of each part of a row; in double precision a row has one part.
        let [mut ky, mut along_y, mut scale] = [[0.0.splat(); 2]; 3];
        for part in 0..R::PARTS {
            ky[part] = f64::load(&self.ky[part]);
            along_y[part] = on.mul_add(tau_nu, on.mul(ky[part], ky[part]), 1.0.splat());
            scale[part] = on.mul(self.inv_points.splat(), f64::load(&self.inv_gain_y[part]));
        }
        let coefficients = self.inverse_k2.chunks_exact(R::PARTS).zip(self.damping.chunks_exact(R::PARTS));
        let modes = self.wx.iter_mut().zip(self.wy).zip(self.omega);
        let along_x = self.kx.iter().zip(self.inv_gain_x);
        for (((kx, inv_gain_x), (inverse_k2, damping)), ((wx, wy), omega)) in along_x.zip(coefficients).zip(modes) {
            let (kx, inv_gain_x) = (kx.splat(), inv_gain_x.splat());
            for part in 0..R::PARTS {
                let (inverse_k2, damping) = (f64::load(&inverse_k2[part]), f64::load(&damping[part]));
                let (ky, viscous) = (ky[part], on.mul_add(tau_nu, on.mul(kx, kx), along_y[part]));
                let gain = on.div(on.mul(scale[part], inv_gain_x), on.mul_add(cfl, damping, viscous));
                // u = w/(1 + tau nu k² + tau r), less its part along the wave.
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

#[cfg(test)]
mod tests {
    use line_fft::Pack;

    use super::*;

    /// A wave near the end of the grid has its part of Pi, damped as a velocity is: `−i k·w/(tau k²)/(1 + dt r)`.
    #[test]
    fn the_pressure_is_filtered_as_the_velocity_is() {
        let grid = Grid::new([[0.0, TAU]; 2], [16; 2]);
        let projection = Projection::<f64>::new(&grid, Filter::Smooth);
        let zeros = || vec![Pack::<f64>::default(); 16 * projection.modes().div_ceil(f64::LANES)];
        let (mut wx, wy, mut pressure) = (zeros(), zeros(), zeros());
        // The wave 7 along x, 7/8 of the highest.
        wx[7].re[0] = 3.0;
        let (inv_tau, cfl) = (2.0, 0.4);
        projection.pressure(&wx, &wy, inv_tau, cfl, &mut pressure);
        let damping = ((36.0 * 0.875_f64.powi(36)).exp() - 1.0) / 0.3;
        let expected = -3.0 * inv_tau / 7.0 / 256.0 / (1.0 + cfl * damping);
        assert!((pressure[7].im[0] / expected - 1.0).abs() < 1e-13, "{} against {expected}", pressure[7].im[0]);
        assert!(damping > 1.0 && pressure[7].re[0] == 0.0);
    }
}
