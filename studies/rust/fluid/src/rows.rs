//! rustfft as one would use it: real lines along y by realfft, a transpose by blocks, complex lines along x.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;
use rustfft::FftPlanner;
use transpose::transpose;

const FITS: &str = "the sizes are those of the plan";

/// A field `[nx, ny]` forward and back.
pub fn pair(nx: usize, ny: usize) -> impl FnMut() {
    let (mut real, mut complex, modes) = (RealFftPlanner::new(), FftPlanner::new(), ny / 2 + 1);
    let (forward, inverse) = (real.plan_fft_forward(ny), real.plan_fft_inverse(ny));
    let along_x = [complex.plan_fft_forward(nx), complex.plan_fft_inverse(nx)];
    let lengths = [along_x[0].get_inplace_scratch_len(), along_x[1].get_inplace_scratch_len()];
    let length = lengths.into_iter().fold(forward.get_scratch_len().max(inverse.get_scratch_len()), usize::max);
    let [mut columns, mut rows, mut scratch] = [nx * modes, nx * modes, length].map(|n| vec![Complex64::default(); n]);
    let (field, mut back, mut line) = (crate::noise(nx * ny), vec![0.0; nx * ny], vec![0.0; ny]);
    move || {
        for (field, modes) in field.chunks_exact(ny).zip(columns.chunks_exact_mut(modes)) {
            line.copy_from_slice(field); // the transform uses it up
            forward.process_with_scratch(&mut line, modes, &mut scratch).expect(FITS);
        }
        transpose(&columns, &mut rows, modes, nx);
        along_x.iter().for_each(|fft| fft.process_with_scratch(&mut rows, &mut scratch));
        transpose(&rows, &mut columns, nx, modes);
        for (modes, back) in columns.chunks_exact_mut(modes).zip(back.chunks_exact_mut(ny)) {
            // Rounding leaves imaginary parts in the real modes, which realfft takes for an error.
            modes[0].im = 0.0;
            if ny.is_multiple_of(2) {
                modes[ny / 2].im = 0.0;
            }
            inverse.process_with_scratch(modes, back, &mut scratch).expect(FITS);
        }
    }
}
