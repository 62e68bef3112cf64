//! The spectral half of a step in space: viscosity, filter and projection onto divergence-free fields.
//!
//! As in two dimensions every mode is calculated in double precision. Waves that the filter damps to rounding in a step
//! are cut off: beyond `k = k_max` for the smooth one, so that a sphere of wavenumbers remains of the cube.

use std::array::from_fn;
use std::f64::consts::TAU;
use std::marker::PhantomData;

use line_fft::{Arithmetic, Complexes, F64_LANES, Kernel, Pack, Real, run};
use method::Filter;

use super::Implicit;
use crate::filter::{Damping, smooth_damping};
use crate::grid::Grid;

/// Wavenumbers and filter of one grid, for the lines of the spectra of [`line_fft::Fft3`].
pub struct Projection<R> {
    kx: Vec<f64>,
    ky: Vec<f64>,
    /// By row and part.
    kz: Vec<[f64; F64_LANES]>,
    /// Damping by the filter in a step of the CFL number 1, by row, |ky|, |kx| and part.
    damping: Vec<[f64; F64_LANES]>,
    /// Wavenumbers along y that are left in each row.
    kept: Vec<usize>,
    /// 1 over the gain of a mode in a round trip of the transforms, along x, along y with 1 over the number of points,
    /// and along z by row and part.
    inv_gain: ([Vec<f64>; 2], Vec<[f64; F64_LANES]>),
    precision: PhantomData<R>,
}

impl<R: Real> Projection<R> {
    /// Prepare wavenumbers and filter of a grid.
    pub fn new(grid: &Grid<3>, damping: impl Into<Damping>) -> Self {
        let of_modes = damping.into();
        let ([nx, ny, nz], size) = (grid.cells, grid.size);
        let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
        let wavenumbers = |axis: usize| -> Vec<f64> {
            let n = grid.cells[axis];
            (0..n).map(|i| TAU / size[axis] * signed(i, n)).collect()
        };
        let damping = |i: usize, j: usize, k: usize| {
            let fractions = [2.0 * i as f64 / nx as f64, 2.0 * j as f64 / ny as f64, 2.0 * k as f64 / nz as f64];
            let squared: f64 = fractions.iter().map(|fraction| fraction * fraction).sum();
            let is_cut = match of_modes {
                Damping::Of(Filter::Smooth) => squared >= 1.0,
                Damping::Of(Filter::TwoThirds) => 2.25 * squared >= 1.0,
                // The highest wave of an even grid has no odd derivative.
                Damping::Of(Filter::None) | Damping::EachAxis => fractions.iter().any(|fraction| *fraction >= 1.0),
            };
            match of_modes {
                _ if is_cut => f64::INFINITY,
                Damping::Of(Filter::Smooth) => smooth_damping(squared.sqrt()),
                Damping::Of(Filter::None | Filter::TwoThirds) => 0.0,
                Damping::EachAxis => fractions.into_iter().map(smooth_damping).sum(),
            }
        };
        let is_left = |j: usize, k: usize| damping(0, j, k) < f64::INFINITY;
        let modes = (0..=nz / 2).take_while(|k| is_left(0, *k)).count();
        let rows = modes.div_ceil(R::LANES);
        let part = |row: usize, part: usize| row * R::LANES + part * F64_LANES;
        let mut by_mode = Vec::with_capacity(rows * (ny / 2 + 1) * (nx / 2 + 1) * R::PARTS);
        for (row, j) in (0..rows).flat_map(|row| (0..=ny / 2).map(move |j| (row, j))) {
            for (i, p) in (0..=nx / 2).flat_map(|i| (0..R::PARTS).map(move |p| (i, p))) {
                by_mode.push(from_fn(|lane| damping(i, j, part(row, p) + lane)));
            }
        }
        let parts = (0..rows).flat_map(|row| (0..R::PARTS).map(move |p| part(row, p)));
        Self {
            kx: wavenumbers(0),
            ky: wavenumbers(1),
            kz: parts.map(|first| from_fn(|lane| TAU / size[2] * (first + lane) as f64)).collect(),
            damping: by_mode,
            kept: (0..rows).map(|row| (0..=ny / 2).take_while(|j| is_left(*j, row * R::LANES)).count()).collect(),
            inv_gain: ([vec![1.0; nx], vec![1.0 / grid.len() as f64; ny]], vec![[1.0; F64_LANES]; rows * R::PARTS]),
            precision: PhantomData,
        }
    }

    /// Return, for each row of modes along z, the number of wavenumbers along y that the filter leaves.
    pub fn kept(&self) -> Vec<usize> {
        self.kept.clone()
    }

    /// Compensate for the [`gains`](line_fft::Fft3::gains) of the transforms.
    pub fn set_gains(&mut self, [x, y, z]: &[Vec<f64>; 3]) {
        let ([inv_x, inv_y], inv_z) = &mut self.inv_gain;
        inv_x.iter_mut().zip(x).for_each(|(inv, gain)| *inv /= gain);
        inv_y.iter_mut().zip(y).for_each(|(inv, gain)| *inv /= gain);
        inv_z.as_flattened_mut().iter_mut().zip(z).for_each(|(inv, gain)| *inv /= gain);
    }

    /// Solve `(1 − tau nu ∇² + tau r) u + tau ∇Pi = w, ∇·u = 0` for a line of modes along x.
    ///
    /// The first three spectra hold w, unnormalised, and receive u; the others receive the vorticity of u.
    pub fn project(&self, step: &Implicit<3>, row: usize, j: usize, lines: &mut [Vec<Pack<R>>; 6]) {
        // Modes that the filter cuts off have infinite damping, also in still fluid.
        let cfl = step.cfl.max(f64::MIN_POSITIVE);
        let ([inv_gain_x, inv_gain_y], inv_gain_z) = &self.inv_gain;
        run(ProjectLine {
            k: (&self.kx, self.ky[j], self.of_row(&self.kz, row)),
            damping: self.damping_of(row, j),
            inv_gain: (inv_gain_x, inv_gain_y[j], self.of_row(inv_gain_z, row)),
            tau_nu: step.tau_nu,
            cfl,
            lines: lines.each_mut().map(|line| &mut line[..]),
        });
        if let (0, 0, Some(mean)) = (row, j, step.mean) {
            for (u, mean) in lines.iter_mut().zip(mean) {
                (u[0].re[0], u[0].im[0]) = (R::rounded(mean), R::zero());
            }
        }
    }

    /// Write `scale(k², damping) i k·u`, normalised, of the first three lines to the fourth.
    fn divergence(&self, row: usize, j: usize, lines: &mut [Vec<Pack<R>>; 6], scale: impl Fn(f64, f64) -> f64) {
        let inv_points = self.inv_gain.0[1][j];
        let ([x, y, z, to, ..], damping) = (lines, self.damping_of(row, j));
        let (kz, nx) = (self.of_row(&self.kz, row), self.kx.len());
        for i in 0..nx {
            for lane in 0..R::LANES {
                let (part, in_part) = (lane / F64_LANES, lane % F64_LANES);
                let k = [self.kx[i], self.ky[j], kz[part][in_part]];
                let damping = damping[i.min(nx - i) * R::PARTS + part][in_part];
                let scale = inv_points * scale(k.iter().map(|k| k * k).sum(), damping);
                let along = |part: &dyn Fn(&Pack<R>) -> R| -> f64 {
                    [&x[i], &y[i], &z[i]].iter().zip(k).map(|(pack, k)| k * part(pack).to_f64()).sum()
                };
                let (re, im) = (along(&|pack| pack.re[lane]), along(&|pack| pack.im[lane]));
                (to[i].re[lane], to[i].im[lane]) = (R::rounded(-scale * im), R::rounded(scale * re));
            }
        }
    }

    /// Write the spectrum of the divergence of the velocity in the first three lines to the fourth.
    pub fn divergence_of_velocity(&self, row: usize, j: usize, lines: &mut [Vec<Pack<R>>; 6]) {
        self.divergence(row, j, lines, |_, _| 1.0);
    }

    /// Write the spectrum of `Pi = −i k·w / (tau k²)` to the fourth line. The filter damps its short waves as those of a
    /// velocity in a step with a CFL number.
    pub fn pressure(&self, inv_tau: f64, cfl: f64, row: usize, j: usize, lines: &mut [Vec<Pack<R>>; 6]) {
        let cfl = cfl.max(f64::MIN_POSITIVE);
        self.divergence(
            row,
            j,
            lines,
            |k2, damping| {
                if k2 == 0.0 { 0.0 } else { -inv_tau / (k2 * (1.0 + cfl * damping)) }
            },
        );
    }

    fn of_row<'a>(&self, by_part: &'a [[f64; F64_LANES]], row: usize) -> &'a [[f64; F64_LANES]] {
        &by_part[row * R::PARTS..(row + 1) * R::PARTS]
    }

    /// Return the damping of a line by |kx| and part.
    fn damping_of(&self, row: usize, j: usize) -> &[[f64; F64_LANES]] {
        let (ny, length) = (self.ky.len(), (self.kx.len() / 2 + 1) * R::PARTS);
        &self.damping[(row * (ny / 2 + 1) + j.min(ny - j)) * length..][..length]
    }
}

/// [`Projection::project`] with the coefficients of the line: along x, of its ky, and along z by part.
struct ProjectLine<'a, R: Real> {
    k: (&'a [f64], f64, &'a [[f64; F64_LANES]]),
    inv_gain: (&'a [f64], f64, &'a [[f64; F64_LANES]]),
    damping: &'a [[f64; F64_LANES]],
    tau_nu: f64,
    cfl: f64,
    lines: [&'a mut [Pack<R>]; 6],
}

impl<R: Real> Kernel for ProjectLine<'_, R> {
    type Real = f64;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<f64>) {
        let (all_kx, ky, all_kz) = self.k;
        let (tau_nu, cfl, one) = (self.tau_nu.splat(), self.cfl.splat(), 1.0.splat());
        // Coefficients of each part of a row; in double precision a row has one part. The least number above 0 keeps 1/k²
        // of the mean finite, whose wavenumbers are 0, and changes no other.
        let [mut kz, mut k2_yz, mut scale] = [[0.0.splat(); 2]; 3];
        for part in 0..R::PARTS {
            kz[part] = f64::load(&all_kz[part]);
            k2_yz[part] = on.mul_add(kz[part], kz[part], (ky * ky + f64::MIN_POSITIVE).splat());
            scale[part] = on.mul(self.inv_gain.1.splat(), f64::load(&self.inv_gain.2[part]));
        }
        let ky = ky.splat();
        let nx = all_kx.len();
        let [wx, wy, wz, ox, oy, oz] = self.lines.map(|line| &mut line[..nx]);
        let (all_kx, inv_gain_x) = (&all_kx[..nx], &self.inv_gain.0[..nx]);
        for i in 0..nx {
            let (kx, inv_gain_x, mirror) = (all_kx[i].splat(), inv_gain_x[i].splat(), i.min(nx - i) * R::PARTS);
            for part in 0..R::PARTS {
                let damping = f64::load(&self.damping[mirror + part]);
                let k2 = on.mul_add(kx, kx, k2_yz[part]);
                let decay = on.mul_add(cfl, damping, on.mul_add(tau_nu, k2, one));
                let gain = on.div(on.mul(scale[part], inv_gain_x), decay);
                let inverse_k2 = on.div(one, k2);
                // u = w/(1 + tau nu k² + tau r), less its part along the wave.
                let (x, y, z) = (
                    wx[i].part(part).scaled(on, gain),
                    wy[i].part(part).scaled(on, gain),
                    wz[i].part(part).scaled(on, gain),
                );
                let along = x.scaled(on, kx).mul_add(on, ky, y).mul_add(on, kz[part], z).scaled(on, inverse_k2);
                wx[i].set_part(part, x.mul_sub(on, kx, along));
                wy[i].set_part(part, y.mul_sub(on, ky, along));
                wz[i].set_part(part, z.mul_sub(on, kz[part], along));
                let cross = |a, b: Complexes<f64>, c, d: Complexes<f64>| b.scaled(on, a).mul_sub(on, c, d).times_i(on);
                ox[i].set_part(part, cross(ky, z, kz[part], y));
                oy[i].set_part(part, cross(kz[part], x, kx, z));
                oz[i].set_part(part, cross(kx, y, ky, x));
            }
        }
    }
}
