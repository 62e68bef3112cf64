//! Two-dimensional real transforms that keep the cache warm.
//!
//! Physical fields are `[nx, ny]` with y contiguous. Along y eight columns are transformed together, two in each lane as
//! the real and the imaginary part of one line; along x four rows of modes in y are, one in each lane. Spectra are
//! therefore `[rows, nx]` of [`Quad`]s: row j holds the modes 4j … 4j + 3 in y. Forward transforms are unnormalised.
//!
//! A plan can be shared by threads; each needs a [`Scratch`] of its own.

#![allow(clippy::needless_range_loop, reason = "what runs over lanes is clearest, and surely unrolled, by index")]

use std::array::from_fn;
use std::ops::Range;

use pulp::f64x4 as Four;
use rustfft::num_complex::Complex64;

use super::lines::Lines;
use super::quad::{Complex4, Quad};
use crate::simd::{Arithmetic, Kernel, LANES, run, splat};
use crate::threads::on_threads;

/// Columns that are transformed together.
const BLOCK: usize = 2 * LANES;

/// Plans for the transforms of one grid.
pub struct Fft2 {
    nx: usize,
    ny: usize,
    /// Rows of the spectra; modes above are left out.
    rows: usize,
    x: Lines,
    y: Lines,
}

/// What one thread needs for itself.
pub struct Scratch {
    /// Three rows of a spectrum.
    pub rows: [Vec<Quad>; 3],
    /// A block of columns before and after its transform.
    columns: [Vec<Quad>; 2],
    /// Room for a transform along a line.
    pub line: Vec<Complex64>,
}

impl Fft2 {
    /// Plan transforms of `[nx, ny]` fields, at least 8 points along each axis, with the first `modes` in y of `ny/2 + 1`.
    pub fn new(nx: usize, ny: usize, modes: usize) -> Self {
        assert!(nx >= BLOCK && ny >= BLOCK && modes <= ny / 2 + 1, "{nx} x {ny} points, {modes} modes in y");
        Self { nx, ny, rows: modes.div_ceil(LANES), x: Lines::new(nx), y: Lines::new(ny) }
    }

    /// Scratch space for one thread.
    pub fn scratch(&self) -> Scratch {
        let quads = |n: usize| vec![Quad::default(); n];
        Scratch {
            rows: from_fn(|_| quads(self.nx)),
            columns: from_fn(|_| quads(self.ny)),
            line: vec![Complex64::default(); self.x.scratch_len().max(self.y.scratch_len())],
        }
    }

    /// A spectrum of zeros.
    pub fn spectrum(&self) -> Vec<Quad> {
        vec![Quad::default(); self.rows * self.nx]
    }

    /// The columns in at most `parts` ranges that can be transformed apart, to the same bits however many.
    pub fn shares(&self, parts: usize) -> impl Iterator<Item = Range<usize>> + use<> {
        let (nx, blocks) = (self.nx, self.nx / BLOCK);
        let parts = parts.min(blocks);
        let first = move |part: usize| if part == parts { nx } else { part * blocks / parts * BLOCK };
        (0..parts).map(move |part| first(part)..first(part + 1))
    }

    /// Blocks of columns that are transformed together; the last two overlap where their number does not come out even.
    pub fn blocks(&self, columns: Range<usize>) -> impl Iterator<Item = Range<usize>> + use<> {
        columns
            .clone()
            .step_by(BLOCK)
            .map(move |first| first.min(columns.end - BLOCK))
            .map(|first| first..first + BLOCK)
    }

    /// Spectrum of a field, unnormalised.
    pub fn forward(&self, field: &[f64], spectrum: &mut [Quad], scratch: &mut Scratch) {
        self.forward_along_y([field], [&mut *spectrum], std::slice::from_mut(scratch));
        for row in spectrum.chunks_exact_mut(self.nx) {
            scratch.rows[0].copy_from_slice(row);
            self.x.forward::<false>(&scratch.rows[0], row, &mut scratch.line);
        }
    }

    /// Field of a spectrum, times `nx ny`; the spectrum is used up.
    pub fn inverse(&self, spectrum: &mut [Quad], field: &mut [f64], scratch: &mut Scratch) {
        for row in spectrum.chunks_exact_mut(self.nx) {
            scratch.rows[0].copy_from_slice(row);
            self.x.forward::<true>(&scratch.rows[0], row, &mut scratch.line);
        }
        for columns in self.blocks(0..self.nx) {
            let points = columns.start * self.ny..columns.end * self.ny;
            self.inverse_along_y(spectrum, columns, &mut field[points], scratch);
        }
    }

    /// Half a forward transform of several fields: modes in y of every column.
    pub fn forward_along_y<const N: usize>(
        &self,
        fields: [&[f64]; N],
        mut spectra: [&mut [Quad]; N],
        scratch: &mut [Scratch],
    ) {
        let (nx, ny) = (self.nx, self.ny);
        if let [scratch] = scratch {
            for (field, spectrum) in fields.into_iter().zip(spectra) {
                for columns in self.blocks(0..nx) {
                    let field = &field[columns.start * ny..columns.end * ny];
                    let first = columns.start;
                    self.forward_block(field, scratch, |row, column, quad| spectrum[row * nx + first + column] = quad);
                }
            }
            return;
        }
        // Each thread gets its columns of each row.
        let mut rows = spectra.each_mut().map(|spectrum| spectrum.chunks_exact_mut(nx).collect::<Vec<_>>());
        let mut take = |count: usize| {
            rows.each_mut().map(|rows| -> Vec<&mut [Quad]> {
                rows.iter_mut().filter_map(|row| row.split_off_mut(..count)).collect()
            })
        };
        let shares: Vec<_> = self.shares(scratch.len()).map(|columns| (take(columns.len()), columns)).collect();
        on_threads(shares.into_iter().zip(scratch), |((spectra, share), scratch)| {
            for (field, mut rows) in fields.into_iter().zip(spectra) {
                for columns in self.blocks(share.clone()) {
                    let field = &field[columns.start * ny..columns.end * ny];
                    let first = columns.start - share.start;
                    self.forward_block(field, scratch, |row, column, quad| rows[row][first + column] = quad);
                }
            }
        });
    }

    /// The other half of a forward transform: one row of the spectrum to another place.
    pub fn forward_along_x(&self, from: &[Quad], to: &mut [Quad], line: &mut [Complex64]) {
        self.x.forward::<false>(from, to, line);
    }

    /// Half an inverse transform: one row of the spectrum to another place, where it is what
    /// [`Self::inverse_along_y`] takes.
    pub fn inverse_along_x(&self, from: &[Quad], to: &mut [Quad], line: &mut [Complex64]) {
        self.x.forward::<true>(from, to, line);
    }

    /// The other half of an inverse transform, for a block of columns: their points from the spectrum.
    pub fn inverse_along_y(
        &self,
        spectrum: &[Quad],
        columns: Range<usize>,
        points: &mut [f64],
        Scratch { columns: [modes, lines], line, .. }: &mut Scratch,
    ) {
        run(Pair { spectrum, nx: self.nx, rows: self.rows, first: columns.start, modes });
        self.y.forward::<false>(modes, lines, line);
        run(Scatter { lines, points });
    }

    /// Modes in y of the columns of a block; `store(row, column, modes)` puts them into the spectrum.
    fn forward_block(
        &self,
        field: &[f64],
        Scratch { columns: [lines, modes], line, .. }: &mut Scratch,
        store: impl FnMut(usize, usize, Quad),
    ) {
        run(Gather { field, lines });
        self.y.forward::<false>(lines, modes, line);
        run(Unpair { modes, rows: self.rows, store });
    }
}

/// Rows to columns.
#[inline(always)]
fn transposed(a: [Four; LANES]) -> [Four; LANES] {
    [
        Four(a[0].0, a[1].0, a[2].0, a[3].0),
        Four(a[0].1, a[1].1, a[2].1, a[3].1),
        Four(a[0].2, a[1].2, a[2].2, a[3].2),
        Four(a[0].3, a[1].3, a[2].3, a[3].3),
    ]
}

/// Rows to columns of the real and of the imaginary parts.
#[inline(always)]
fn transposed_parts(quads: &[Quad; LANES]) -> ([Four; LANES], [Four; LANES]) {
    let [mut re, mut im] = [[splat(0.0); LANES]; 2];
    for l in 0..LANES {
        (re[l], im[l]) = (pulp::cast(quads[l].re), pulp::cast(quads[l].im));
    }
    (transposed(re), transposed(im))
}

/// Half of the columns of a block as real parts, the other half as imaginary parts.
struct Gather<'a> {
    field: &'a [f64],
    lines: &'a mut [Quad],
}

impl Kernel for Gather<'_> {
    #[inline(always)]
    fn run(self, _: impl Arithmetic) {
        let ny = self.lines.len();
        let columns: [&[f64]; BLOCK] = from_fn(|c| &self.field[c * ny..][..ny]);
        let (whole, rest) = self.lines.as_chunks_mut::<LANES>();
        for (block, quads) in whole.iter_mut().enumerate() {
            let [mut re, mut im] = [[splat(0.0); LANES]; 2];
            for c in 0..LANES {
                re[c] = pulp::cast(columns[c].as_chunks::<LANES>().0[block]);
                im[c] = pulp::cast(columns[LANES + c].as_chunks::<LANES>().0[block]);
            }
            let (re, im) = (transposed(re), transposed(im));
            for j in 0..LANES {
                quads[j] = Complex4 { re: re[j], im: im[j] }.quad();
            }
        }
        let first = ny - rest.len();
        for (j, quad) in rest.iter_mut().enumerate() {
            for c in 0..LANES {
                quad.re[c] = columns[c][first + j];
                quad.im[c] = columns[LANES + c][first + j];
            }
        }
    }
}

/// The way back from [`Gather`], with real and imaginary parts exchanged.
struct Scatter<'a> {
    lines: &'a [Quad],
    points: &'a mut [f64],
}

impl Kernel for Scatter<'_> {
    #[inline(always)]
    fn run(self, _: impl Arithmetic) {
        let ny = self.lines.len();
        let mut rest = self.points;
        let columns: [&mut [f64]; BLOCK] = from_fn(|_| {
            let (column, others) = std::mem::take(&mut rest).split_at_mut(ny);
            rest = others;
            column
        });
        let (whole, rest) = self.lines.as_chunks::<LANES>();
        for (block, quads) in whole.iter().enumerate() {
            let (re, im) = transposed_parts(quads);
            for c in 0..LANES {
                columns[c].as_chunks_mut::<LANES>().0[block] = pulp::cast(im[c]);
                columns[LANES + c].as_chunks_mut::<LANES>().0[block] = pulp::cast(re[c]);
            }
        }
        let first = ny - rest.len();
        for (j, quad) in rest.iter().enumerate() {
            for c in 0..LANES {
                columns[c][first + j] = quad.im[c];
                columns[LANES + c][first + j] = quad.re[c];
            }
        }
    }
}

/// From the modes of a + i b, a and b real, to those of a and of b, and from columns to rows.
struct Unpair<'a, F> {
    modes: &'a [Quad],
    rows: usize,
    store: F,
}

impl<F: FnMut(usize, usize, Quad)> Kernel for Unpair<'_, F> {
    #[inline(always)]
    fn run(mut self, on: impl Arithmetic) {
        let (ny, half) = (self.modes.len(), splat(0.5));
        for row in 0..self.rows {
            // The last row may go on with modes above ny/2, which nobody reads.
            let [mut a_re, mut a_im, mut b_re, mut b_im] = [[splat(0.0); LANES]; 4];
            for l in 0..LANES {
                let k = LANES * row + l;
                let z = Complex4::load(&self.modes[k]);
                let mirror = Complex4::load(&self.modes[if k == 0 { 0 } else { ny - k }]);
                a_re[l] = on.mul_f64s(half, on.add_f64s(z.re, mirror.re));
                a_im[l] = on.mul_f64s(half, on.sub_f64s(z.im, mirror.im));
                b_re[l] = on.mul_f64s(half, on.add_f64s(z.im, mirror.im));
                b_im[l] = on.mul_f64s(half, on.sub_f64s(mirror.re, z.re));
            }
            let (a_re, a_im, b_re, b_im) = (transposed(a_re), transposed(a_im), transposed(b_re), transposed(b_im));
            for c in 0..LANES {
                (self.store)(row, c, Complex4 { re: a_re[c], im: a_im[c] }.quad());
                (self.store)(row, LANES + c, Complex4 { re: b_re[c], im: b_im[c] }.quad());
            }
        }
    }
}

/// The way back from [`Unpair`], from and to numbers with real and imaginary parts exchanged.
struct Pair<'a> {
    spectrum: &'a [Quad],
    nx: usize,
    rows: usize,
    first: usize,
    modes: &'a mut [Quad],
}

impl Kernel for Pair<'_> {
    #[inline(always)]
    fn run(self, on: impl Arithmetic) {
        let ny = self.modes.len();
        for row in 0..self.rows {
            let (quads, _) = self.spectrum[row * self.nx + self.first..][..BLOCK].as_chunks::<LANES>();
            let ((a_im, a_re), (b_im, b_re)) = (transposed_parts(&quads[0]), transposed_parts(&quads[1]));
            for l in 0..LANES.min(ny / 2 + 1 - LANES * row) {
                let k = LANES * row + l;
                if k == 0 || 2 * k == ny {
                    // Rounding leaves imaginary parts in the real modes.
                    self.modes[k] = Complex4 { re: b_re[l], im: a_re[l] }.quad();
                } else {
                    let z = Complex4 { re: on.add_f64s(a_im[l], b_re[l]), im: on.sub_f64s(a_re[l], b_im[l]) };
                    let mirror = Complex4 { re: on.sub_f64s(b_re[l], a_im[l]), im: on.add_f64s(a_re[l], b_im[l]) };
                    self.modes[k] = z.quad();
                    self.modes[ny - k] = mirror.quad();
                }
            }
        }
        let left_out = LANES * self.rows;
        if left_out <= ny / 2 {
            self.modes[left_out..=ny - left_out].fill(Quad::default());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn a_plane_wave_has_one_mode_and_comes_back() {
        // Each factor that has a pass of its own, odd and even lengths, and a length of large primes.
        for (nx, ny) in [(20, 12), (15, 9), (33, 16), (8, 13), (28, 22), (400, 14), (650, 37), (74, 8), (10, 10)] {
            let (p, q) = (3, 2);
            let wave =
                |i: usize, j: usize| (TAU * (p * i) as f64 / nx as f64 + TAU * (q * j) as f64 / ny as f64 + 0.3).cos();
            let field: Vec<f64> = (0..nx * ny).map(|c| wave(c / ny, c % ny)).collect();
            let fft = Fft2::new(nx, ny, ny / 2 + 1);
            let (mut spectrum, mut scratch) = (fft.spectrum(), fft.scratch());
            fft.forward(&field, &mut spectrum, &mut scratch);
            for (i, j) in (0..nx).flat_map(|i| (0..=ny / 2).map(move |j| (i, j))) {
                let quad = &spectrum[j / LANES * nx + i];
                let value = Complex64::new(quad.re[j % LANES], quad.im[j % LANES]);
                let expected = if (i, j) == (p, q) {
                    Complex64::from_polar(0.5 * (nx * ny) as f64, 0.3)
                } else {
                    Complex64::default()
                };
                let error = (value - expected).norm() / (nx * ny) as f64;
                assert!(error < 1e-15, "{nx}x{ny}, mode {i}, {j}: {value} against {expected}");
            }
            let mut back = vec![0.0; nx * ny];
            fft.inverse(&mut spectrum, &mut back, &mut scratch);
            for (a, b) in back.iter().zip(&field) {
                assert!((a / (nx * ny) as f64 - b).abs() < 1e-14, "{a} against {b}");
            }
        }
    }
}
