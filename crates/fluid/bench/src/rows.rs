//! rustfft as one would use it: real lines along y by realfft, a transpose by blocks, complex lines along x.

use std::sync::Arc;

use realfft::num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

/// Lines and columns that are transposed together: 16 kB on either side, half of the first cache.
const BLOCK: usize = 32;

/// A pair of real two-dimensional transforms of one grid.
pub struct RustFft {
    cells: [usize; 2],
    along_y: (Arc<dyn RealToComplex<f64>>, Arc<dyn ComplexToReal<f64>>),
    along_x: [Arc<dyn Fft<f64>>; 2],
    field: Vec<f64>,
    back: Vec<f64>,
    /// A line along y, which its transform uses up.
    line: Vec<f64>,
    /// Spectra `[nx, modes]` and `[modes, nx]`.
    spectra: [Vec<Complex64>; 2],
    scratch: Vec<Complex64>,
}

impl RustFft {
    pub fn new(nx: usize, ny: usize) -> Self {
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        let along_y = (real.plan_fft_forward(ny), real.plan_fft_inverse(ny));
        let along_x = [complex.plan_fft_forward(nx), complex.plan_fft_inverse(nx)];
        let scratch = [along_x[0].get_inplace_scratch_len(), along_x[1].get_inplace_scratch_len()];
        let scratch = scratch[0].max(scratch[1]).max(along_y.0.get_scratch_len()).max(along_y.1.get_scratch_len());
        let spectrum = vec![Complex64::default(); nx * (ny / 2 + 1)];
        let (field, back, line) = (crate::noise(nx * ny), vec![0.0; nx * ny], vec![0.0; ny]);
        let (spectra, scratch) = ([spectrum.clone(), spectrum], vec![Complex64::default(); scratch]);
        Self { cells: [nx, ny], along_y, along_x, field, back, line, spectra, scratch }
    }

    /// The field forward and back.
    pub fn pair(&mut self) {
        let [nx, ny] = self.cells;
        let (modes, [columns, rows], scratch) = (ny / 2 + 1, &mut self.spectra, &mut self.scratch);
        for (field, modes) in self.field.chunks_exact(ny).zip(columns.chunks_exact_mut(modes)) {
            self.line.copy_from_slice(field);
            let scratch = &mut scratch[..self.along_y.0.get_scratch_len()];
            self.along_y
                .0
                .process_with_scratch(&mut self.line, modes, scratch)
                .expect("the sizes are those of the plan");
        }
        transpose(columns, rows, nx, modes);
        self.along_x.iter().for_each(|fft| fft.process_with_scratch(rows, scratch));
        transpose(rows, columns, modes, nx);
        for (modes, back) in columns.chunks_exact_mut(modes).zip(self.back.chunks_exact_mut(ny)) {
            // Rounding leaves imaginary parts in the real modes, which realfft takes for an error.
            modes[0].im = 0.0;
            if ny % 2 == 0 {
                modes[ny / 2].im = 0.0;
            }
            let scratch = &mut scratch[..self.along_y.1.get_scratch_len()];
            self.along_y.1.process_with_scratch(modes, back, scratch).expect("the sizes are those of the plan");
        }
    }
}

/// `[rows, columns]` to `[columns, rows]`.
fn transpose(from: &[Complex64], to: &mut [Complex64], rows: usize, columns: usize) {
    for (i0, j0) in (0..rows).step_by(BLOCK).flat_map(|i| (0..columns).step_by(BLOCK).map(move |j| (i, j))) {
        for j in j0..columns.min(j0 + BLOCK) {
            for i in i0..rows.min(i0 + BLOCK) {
                to[j * rows + i] = from[i * columns + j];
            }
        }
    }
}
