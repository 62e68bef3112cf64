//! Two-dimensional real transforms that keep the cache warm.
//!
//! Physical fields are `[nx, ny]` with y contiguous. Spectra are `[ny/2 + 1, nx]`: transposed, so that the complex
//! transforms along x run over contiguous rows and no second transpose is needed. Forward transforms are unnormalised.

use std::ops::Range;
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

pub use rustfft::num_complex::Complex64;

/// Why a transform cannot fail.
const LENGTHS: &str = "the lengths are those of the plan";

/// Columns that go through the transposition together: two cache lines of complex numbers.
const BLOCK: usize = 8;

/// Plans and scratch space for transforms of one grid.
pub struct Fft2 {
    nx: usize,
    ny: usize,
    real_forward: Arc<dyn RealToComplex<f64>>,
    real_inverse: Arc<dyn ComplexToReal<f64>>,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    scratch: Vec<Complex64>,
    block_real: Vec<f64>,
    block_complex: Vec<Complex64>,
}

impl Fft2 {
    /// Plan transforms of `[nx, ny]` fields.
    pub fn new(nx: usize, ny: usize) -> Self {
        let mut real = RealFftPlanner::new();
        let mut complex = FftPlanner::new();
        let (real_forward, real_inverse) = (real.plan_fft_forward(ny), real.plan_fft_inverse(ny));
        let (forward, inverse) = (complex.plan_fft_forward(nx), complex.plan_fft_inverse(nx));
        let scratch_len = [
            real_forward.get_scratch_len(),
            real_inverse.get_scratch_len(),
            forward.get_inplace_scratch_len(),
            inverse.get_inplace_scratch_len(),
        ]
        .into_iter()
        .max()
        .unwrap_or(0);
        Self {
            nx,
            ny,
            real_forward,
            real_inverse,
            forward,
            inverse,
            scratch: vec![Complex64::default(); scratch_len],
            block_real: vec![0.0; BLOCK * ny],
            block_complex: vec![Complex64::default(); BLOCK * (ny / 2 + 1)],
        }
    }

    /// Number of complex values in a spectrum, `(ny/2 + 1) nx`.
    pub fn spectrum_len(&self) -> usize {
        (self.ny / 2 + 1) * self.nx
    }

    /// Blocks of columns `first..end` that are worth transforming together.
    pub fn blocks(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let nx = self.nx;
        (0..nx).step_by(BLOCK).map(move |first| first..(first + BLOCK).min(nx))
    }

    /// Spectrum of a field, unnormalised.
    pub fn forward(&mut self, field: &[f64], spectrum: &mut [Complex64]) {
        self.forward_along_y(field, spectrum);
        self.forward_along_x(spectrum);
    }

    /// Field of a spectrum, times `nx ny`; the spectrum is used up.
    pub fn inverse(&mut self, spectrum: &mut [Complex64], field: &mut [f64]) {
        self.inverse_along_x(spectrum);
        for columns in self.blocks() {
            let points = columns.start * self.ny..columns.end * self.ny;
            self.inverse_along_y(spectrum, columns, &mut field[points]);
        }
    }

    /// Half a forward transform: modes in y of every column.
    pub fn forward_along_y(&mut self, field: &[f64], spectrum: &mut [Complex64]) {
        let (nx, ny, nk) = (self.nx, self.ny, self.ny / 2 + 1);
        for columns in self.blocks() {
            let count = columns.len();
            self.block_real[..count * ny].copy_from_slice(&field[columns.start * ny..columns.end * ny]);
            let lines = self.block_real.chunks_exact_mut(ny).zip(self.block_complex.chunks_exact_mut(nk));
            for (line, modes) in lines.take(count) {
                self.real_forward.process_with_scratch(line, modes, &mut self.scratch).expect(LENGTHS);
            }
            for k in 0..nk {
                for (column, target) in spectrum[k * nx..(k + 1) * nx][columns.clone()].iter_mut().enumerate() {
                    *target = self.block_complex[column * nk + k];
                }
            }
        }
    }

    /// The other half of forward transforms: whole rows of modes in y, `nx` values each.
    pub fn forward_along_x(&mut self, rows: &mut [Complex64]) {
        self.forward.process_with_scratch(rows, &mut self.scratch);
    }

    /// Half an inverse transform: whole rows of modes in y, `nx` values each.
    pub fn inverse_along_x(&mut self, rows: &mut [Complex64]) {
        self.inverse.process_with_scratch(rows, &mut self.scratch);
    }

    /// The other half of an inverse transform, for a block of columns: their points from the spectrum.
    pub fn inverse_along_y(&mut self, spectrum: &[Complex64], columns: Range<usize>, points: &mut [f64]) {
        let (nx, ny, nk) = (self.nx, self.ny, self.ny / 2 + 1);
        for k in 0..nk {
            for (column, value) in spectrum[k * nx..(k + 1) * nx][columns.clone()].iter().enumerate() {
                self.block_complex[column * nk + k] = *value;
            }
        }
        for (modes, line) in self.block_complex.chunks_exact_mut(nk).zip(points.chunks_exact_mut(ny)) {
            // Rounding leaves imaginary parts in the real modes, which the plan refuses.
            modes[0].im = 0.0;
            if ny % 2 == 0 {
                modes[nk - 1].im = 0.0;
            }
            self.real_inverse.process_with_scratch(modes, line, &mut self.scratch).expect(LENGTHS);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn a_plane_wave_has_one_mode_and_comes_back() {
        for (nx, ny) in [(20, 12), (15, 9), (33, 16)] {
            let (p, q) = (3, 2);
            let wave =
                |i: usize, j: usize| (TAU * (p * i) as f64 / nx as f64 + TAU * (q * j) as f64 / ny as f64 + 0.3).cos();
            let field: Vec<f64> = (0..nx * ny).map(|c| wave(c / ny, c % ny)).collect();
            let mut fft = Fft2::new(nx, ny);
            let mut spectrum = vec![Complex64::default(); fft.spectrum_len()];
            fft.forward(&field, &mut spectrum);
            for (mode, value) in spectrum.iter().enumerate() {
                let expected = if mode == q * nx + p {
                    Complex64::from_polar(0.5 * (nx * ny) as f64, 0.3)
                } else {
                    Complex64::default()
                };
                assert!((value - expected).norm() < 1e-11, "{nx}x{ny}, mode {mode}: {value} against {expected}");
            }
            let mut back = vec![0.0; nx * ny];
            fft.inverse(&mut spectrum, &mut back);
            for (a, b) in back.iter().zip(&field) {
                assert!((a / (nx * ny) as f64 - b).abs() < 1e-14, "{a} against {b}");
            }
        }
    }
}
