//! Two-dimensional real transforms that keep the cache warm.
//!
//! Physical fields are `[nx, ny]` with y contiguous. Spectra are `[ny/2 + 1, nx]`: transposed, so that the complex
//! transforms along x run over contiguous rows and no second transpose is needed. Forward transforms are unnormalised.

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

pub use rustfft::num_complex::Complex64;

/// Rows that go through the transposition together: two cache lines of complex numbers.
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

    /// Spectrum of a field, unnormalised.
    pub fn forward(&mut self, field: &[f64], spectrum: &mut [Complex64]) {
        let (nx, ny, nk) = (self.nx, self.ny, self.ny / 2 + 1);
        for start in (0..nx).step_by(BLOCK) {
            let rows = BLOCK.min(nx - start);
            self.block_real[..rows * ny].copy_from_slice(&field[start * ny..(start + rows) * ny]);
            for row in 0..rows {
                self.real_forward
                    .process_with_scratch(
                        &mut self.block_real[row * ny..(row + 1) * ny],
                        &mut self.block_complex[row * nk..(row + 1) * nk],
                        &mut self.scratch,
                    )
                    .expect("the lengths are those of the plan");
            }
            for k in 0..nk {
                let target = &mut spectrum[k * nx + start..][..rows];
                for (row, value) in target.iter_mut().enumerate() {
                    *value = self.block_complex[row * nk + k];
                }
            }
        }
        self.forward.process_with_scratch(spectrum, &mut self.scratch);
    }

    /// Field of a spectrum, times `nx ny`; the spectrum is used up.
    pub fn inverse(&mut self, spectrum: &mut [Complex64], field: &mut [f64]) {
        let (nx, ny, nk) = (self.nx, self.ny, self.ny / 2 + 1);
        self.inverse.process_with_scratch(spectrum, &mut self.scratch);
        for start in (0..nx).step_by(BLOCK) {
            let rows = BLOCK.min(nx - start);
            for k in 0..nk {
                let source = &spectrum[k * nx + start..][..rows];
                for (row, value) in source.iter().enumerate() {
                    self.block_complex[row * nk + k] = *value;
                }
            }
            for row in 0..rows {
                let line = &mut self.block_complex[row * nk..(row + 1) * nk];
                // Rounding leaves imaginary parts in the two real modes, which the plan refuses.
                line[0].im = 0.0;
                if ny % 2 == 0 {
                    line[nk - 1].im = 0.0;
                }
                self.real_inverse
                    .process_with_scratch(
                        line,
                        &mut field[(start + row) * ny..(start + row + 1) * ny],
                        &mut self.scratch,
                    )
                    .expect("the lengths are those of the plan");
            }
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
