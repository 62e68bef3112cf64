//! Two-dimensional real transforms that keep the cache warm.
//!
//! Physical fields are `[nx, ny]` with y contiguous. Along y eight columns are transformed together, two in each lane as
//! the real and the imaginary part of one line; along x four rows of modes in y are, one in each lane. Spectra are
//! therefore `[rows, nx]` of [`Pack`]s: row j holds the modes 4j … 4j + 3 in y. In single precision a vector has twice as
//! many lanes. Forward transforms are unnormalised.
//!
//! A plan can be shared by threads; each needs a [`Scratch`] of its own.

#![allow(clippy::needless_range_loop, reason = "what runs over lanes is clearest, and surely unrolled, by index")]

use std::array::from_fn;
use std::ops::Range;

use rustfft::num_complex::Complex;

use super::lines::Lines;
use super::pack::{Complexes, Pack};
use crate::simd::{Arithmetic, Kernel, Real, run};
use crate::threads::{Team, nothing};

/// Columns that are transformed together.
const fn block<R: Real>() -> usize {
    2 * R::LANES
}

/// Plans for the transforms of one grid.
pub struct Fft2<R: Real> {
    nx: usize,
    ny: usize,
    /// Rows of the spectra; modes above are left out.
    rows: usize,
    x: Lines<R>,
    y: Lines<R>,
}

/// What one thread needs for itself.
pub struct Scratch<R: Real> {
    /// Three rows of a spectrum.
    pub rows: [Vec<Pack<R>>; 3],
    /// A block of columns before and after its transform.
    columns: [Vec<Pack<R>>; 2],
    /// Room for a transform along a line.
    pub line: Vec<Complex<R>>,
}

impl<R: Real> Fft2<R> {
    /// Plan transforms of `[nx, ny]` fields, at least 8 points along each axis and two vectors along x, with the first `modes` in y of `ny/2 + 1`.
    pub fn new(nx: usize, ny: usize, modes: usize) -> Self {
        assert!(nx >= block::<R>() && ny >= 8 && modes <= ny / 2 + 1, "{nx} x {ny} points, {modes} modes in y");
        Self { nx, ny, rows: modes.div_ceil(R::LANES), x: Lines::new(nx), y: Lines::new(ny) }
    }

    /// Scratch space for one thread.
    pub fn scratch(&self) -> Scratch<R> {
        let packs = |n: usize| vec![Pack::default(); n];
        Scratch {
            rows: from_fn(|_| packs(self.nx)),
            columns: from_fn(|_| packs(self.ny)),
            line: vec![Complex::default(); self.x.scratch_len().max(self.y.scratch_len())],
        }
    }

    /// By how much a mode grows in an inverse transform and a forward one after it, over the number of points: the product
    /// of what it has along x, `[nx]`, and along y, by mode as far as a spectrum has them.
    pub fn gains(&self) -> [Vec<f64>; 2] {
        // Along y the modes of two columns are told apart by the mode and its mirror image.
        let y = self.y.gains();
        let along_y = |k: usize| if k < self.ny { 0.5 * (y[k] + y[(self.ny - k) % self.ny]) } else { 1.0 };
        [self.x.gains(), (0..self.rows * R::LANES).map(along_y).collect()]
    }

    /// A spectrum of zeros.
    pub fn spectrum(&self) -> Vec<Pack<R>> {
        vec![Pack::default(); self.rows * self.nx]
    }

    /// The columns in at most `parts` ranges that can be transformed apart, to the same bits however many.
    pub fn shares(&self, parts: usize) -> impl Iterator<Item = Range<usize>> + use<R> {
        let (nx, blocks) = (self.nx, self.nx / block::<R>());
        let parts = parts.min(blocks);
        let first = move |part: usize| if part == parts { nx } else { part * blocks / parts * block::<R>() };
        (0..parts).map(move |part| first(part)..first(part + 1))
    }

    /// Blocks of columns that are transformed together; the last two overlap where their number does not come out even.
    pub fn blocks(&self, columns: Range<usize>) -> impl Iterator<Item = Range<usize>> + use<R> {
        columns
            .clone()
            .step_by(block::<R>())
            .map(move |first| first.min(columns.end - block::<R>()))
            .map(|first| first..first + block::<R>())
    }

    /// Spectrum of a field, unnormalised.
    pub fn forward(&self, field: &[R], spectrum: &mut [Pack<R>], scratch: &mut Scratch<R>) {
        self.forward_along_y(&Team::alone(), [field], [&mut *spectrum], std::slice::from_mut(scratch));
        for row in spectrum.chunks_exact_mut(self.nx) {
            scratch.rows[0].copy_from_slice(row);
            self.x.forward::<false>(&scratch.rows[0], row, &mut scratch.line);
        }
    }

    /// Field of a spectrum, times `nx ny`; the spectrum is used up.
    pub fn inverse(&self, spectrum: &mut [Pack<R>], field: &mut [R], scratch: &mut Scratch<R>) {
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
        team: &Team,
        fields: [&[R]; N],
        mut spectra: [&mut [Pack<R>]; N],
        scratch: &mut [Scratch<R>],
    ) {
        let (nx, ny) = (self.nx, self.ny);
        if team.parts() == 1 {
            let scratch = &mut scratch[0];
            for (field, spectrum) in fields.into_iter().zip(spectra) {
                for columns in self.blocks(0..nx) {
                    let field = &field[columns.start * ny..columns.end * ny];
                    let first = columns.start;
                    self.forward_block(field, scratch, |row, column, pack| spectrum[row * nx + first + column] = pack);
                }
            }
            return;
        }
        // Each part has its columns of each row.
        let mut rows = spectra.each_mut().map(|spectrum| spectrum.chunks_exact_mut(nx).collect::<Vec<_>>());
        let mut take = |count: usize| {
            rows.each_mut().map(|rows| -> Vec<&mut [Pack<R>]> {
                rows.iter_mut().filter_map(|row| row.split_off_mut(..count)).collect()
            })
        };
        let shares: Vec<_> = self.shares(team.parts()).map(|columns| (take(columns.len()), columns)).collect();
        team.share_with(scratch, nothing, shares.into_iter(), |(spectra, share), scratch| {
            for (field, mut rows) in fields.into_iter().zip(spectra) {
                for columns in self.blocks(share.clone()) {
                    let field = &field[columns.start * ny..columns.end * ny];
                    let first = columns.start - share.start;
                    self.forward_block(field, scratch, |row, column, pack| rows[row][first + column] = pack);
                }
            }
        });
    }

    /// The other half of a forward transform: one row of the spectrum to another place.
    pub fn forward_along_x(&self, from: &[Pack<R>], to: &mut [Pack<R>], line: &mut [Complex<R>]) {
        self.x.forward::<false>(from, to, line);
    }

    /// Half an inverse transform: one row of the spectrum to another place, where it is what
    /// [`Self::inverse_along_y`] takes.
    pub fn inverse_along_x(&self, from: &[Pack<R>], to: &mut [Pack<R>], line: &mut [Complex<R>]) {
        self.x.forward::<true>(from, to, line);
    }

    /// The other half of an inverse transform, for a block of columns: their points from the spectrum.
    pub fn inverse_along_y(
        &self,
        spectrum: &[Pack<R>],
        columns: Range<usize>,
        points: &mut [R],
        Scratch { columns: [modes, lines], line, .. }: &mut Scratch<R>,
    ) {
        run(Pair { spectrum, nx: self.nx, rows: self.rows, first: columns.start, modes });
        self.y.forward::<false>(modes, lines, line);
        run(Scatter { lines, points });
    }

    /// Modes in y of the columns of a block; `store(row, column, modes)` puts them into the spectrum.
    fn forward_block(
        &self,
        field: &[R],
        Scratch { columns: [lines, modes], line, .. }: &mut Scratch<R>,
        store: impl FnMut(usize, usize, Pack<R>),
    ) {
        run(Gather { field, lines });
        self.y.forward::<false>(lines, modes, line);
        run(Unpair { modes, rows: self.rows, store });
    }
}

/// The first of some packs, rows to columns: of the real and of the imaginary parts.
#[inline(always)]
fn transposed_parts<R: Real>(on: impl Arithmetic<R>, packs: &[Pack<R>]) -> (R::Square, R::Square) {
    let (mut re, mut im) = (R::zeros(), R::zeros());
    let packs = &packs[..R::LANES];
    for l in 0..R::LANES {
        (re[l], im[l]) = (R::load(&packs[l].re), R::load(&packs[l].im));
    }
    (on.transposed(re), on.transposed(im))
}

/// Half of the columns of a block as real parts, the other half as imaginary parts.
struct Gather<'a, R: Real> {
    field: &'a [R],
    lines: &'a mut [Pack<R>],
}

impl<R: Real> Kernel for Gather<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let ny = self.lines.len();
        let (re_columns, im_columns) = self.field[..block::<R>() * ny].split_at(R::LANES * ny);
        let mut lines = self.lines.chunks_exact_mut(R::LANES);
        for (block, packs) in lines.by_ref().enumerate() {
            let (mut re, mut im) = (R::zeros(), R::zeros());
            for c in 0..R::LANES {
                let first = c * ny + block * R::LANES;
                (re[c], im[c]) = (R::gather(&re_columns[first..]), R::gather(&im_columns[first..]));
            }
            let (re, im) = (on.transposed(re), on.transposed(im));
            for j in 0..R::LANES {
                packs[j] = Complexes { re: re[j], im: im[j] }.pack();
            }
        }
        let rest = lines.into_remainder();
        let first = ny - rest.len();
        for (j, pack) in rest.iter_mut().enumerate() {
            for c in 0..R::LANES {
                pack.re[c] = re_columns[c * ny + first + j];
                pack.im[c] = im_columns[c * ny + first + j];
            }
        }
    }
}

/// The way back from [`Gather`], with real and imaginary parts exchanged.
struct Scatter<'a, R: Real> {
    lines: &'a [Pack<R>],
    points: &'a mut [R],
}

impl<R: Real> Kernel for Scatter<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let ny = self.lines.len();
        let (im_columns, re_columns) = self.points[..block::<R>() * ny].split_at_mut(R::LANES * ny);
        let lines = self.lines.chunks_exact(R::LANES);
        let rest = lines.remainder();
        for (block, packs) in lines.enumerate() {
            let (re, im) = transposed_parts(on, packs);
            for c in 0..R::LANES {
                let first = c * ny + block * R::LANES;
                im_columns[first..][..R::LANES].copy_from_slice(R::store(im[c]).as_ref());
                re_columns[first..][..R::LANES].copy_from_slice(R::store(re[c]).as_ref());
            }
        }
        let first = ny - rest.len();
        for (j, pack) in rest.iter().enumerate() {
            for c in 0..R::LANES {
                im_columns[c * ny + first + j] = pack.im[c];
                re_columns[c * ny + first + j] = pack.re[c];
            }
        }
    }
}

/// From the modes of a + i b, a and b real, to those of a and of b, and from columns to rows.
struct Unpair<'a, R: Real, F> {
    modes: &'a [Pack<R>],
    rows: usize,
    store: F,
}

impl<R: Real, F: FnMut(usize, usize, Pack<R>)> Kernel for Unpair<'_, R, F> {
    type Real = R;

    #[inline(always)]
    fn run(mut self, on: impl Arithmetic<R>) {
        let (ny, half) = (self.modes.len(), R::narrow(0.5).splat());
        for row in 0..self.rows {
            // The last row may go on with modes above ny/2, which nobody reads.
            let [mut a_re, mut a_im, mut b_re, mut b_im] = [R::zeros(); 4];
            for l in 0..R::LANES {
                let k = R::LANES * row + l;
                let z = Complexes::load(&self.modes[k]);
                let mirror = Complexes::load(&self.modes[if k == 0 { 0 } else { ny - k }]);
                a_re[l] = on.mul(half, on.add(z.re, mirror.re));
                a_im[l] = on.mul(half, on.sub(z.im, mirror.im));
                b_re[l] = on.mul(half, on.add(z.im, mirror.im));
                b_im[l] = on.mul(half, on.sub(mirror.re, z.re));
            }
            let (a_re, a_im) = (on.transposed(a_re), on.transposed(a_im));
            let (b_re, b_im) = (on.transposed(b_re), on.transposed(b_im));
            for c in 0..R::LANES {
                (self.store)(row, c, Complexes { re: a_re[c], im: a_im[c] }.pack());
                (self.store)(row, R::LANES + c, Complexes { re: b_re[c], im: b_im[c] }.pack());
            }
        }
    }
}

/// The way back from [`Unpair`], from and to numbers with real and imaginary parts exchanged.
struct Pair<'a, R: Real> {
    spectrum: &'a [Pack<R>],
    nx: usize,
    rows: usize,
    first: usize,
    modes: &'a mut [Pack<R>],
}

impl<R: Real> Kernel for Pair<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let ny = self.modes.len();
        for row in 0..self.rows {
            let packs = &self.spectrum[row * self.nx + self.first..][..block::<R>()];
            let ((a_im, a_re), (b_im, b_re)) = (transposed_parts(on, packs), transposed_parts(on, &packs[R::LANES..]));
            for l in 0..R::LANES.min(ny / 2 + 1 - R::LANES * row) {
                let k = R::LANES * row + l;
                if k == 0 || 2 * k == ny {
                    // Rounding leaves imaginary parts in the real modes.
                    self.modes[k] = Complexes { re: b_re[l], im: a_re[l] }.pack();
                } else {
                    let z = Complexes { re: on.add(a_im[l], b_re[l]), im: on.sub(a_re[l], b_im[l]) };
                    let mirror = Complexes { re: on.sub(b_re[l], a_im[l]), im: on.add(a_re[l], b_im[l]) };
                    self.modes[k] = z.pack();
                    self.modes[ny - k] = mirror.pack();
                }
            }
        }
        let left_out = R::LANES * self.rows;
        if left_out <= ny / 2 {
            self.modes[left_out..=ny - left_out].fill(Pack::default());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn a_wave_comes_back<R: Real>(rounding: f64) {
        // Each factor that has a pass of its own, odd and even lengths, and a length of large primes.
        for (nx, ny) in [
            (2 * block::<R>(), 12),
            (21, 9),
            (33, 16),
            (block::<R>(), 13),
            (28, 22),
            (400, 14),
            (650, 37),
            (74, 8),
            (18, 10),
        ] {
            let (p, q) = (3, 2);
            let wave =
                |i: usize, j: usize| (TAU * (p * i) as f64 / nx as f64 + TAU * (q * j) as f64 / ny as f64 + 0.3).cos();
            let field: Vec<_> = (0..nx * ny).map(|c| R::narrow(wave(c / ny, c % ny))).collect();
            let fft = Fft2::<R>::new(nx, ny, ny / 2 + 1);
            let (mut spectrum, mut scratch) = (fft.spectrum(), fft.scratch());
            fft.forward(&field, &mut spectrum, &mut scratch);
            for (i, j) in (0..nx).flat_map(|i| (0..=ny / 2).map(move |j| (i, j))) {
                let pack = &spectrum[j / R::LANES * nx + i];
                let value = Complex::new(pack.re[j % R::LANES].wide(), pack.im[j % R::LANES].wide());
                let expected = if (i, j) == (p, q) {
                    Complex::from_polar(0.5 * (nx * ny) as f64, 0.3)
                } else {
                    Complex::default()
                };
                let error = (value - expected).norm() / (nx * ny) as f64;
                assert!(error < rounding, "{nx}x{ny}, mode {i}, {j}: {value} against {expected}");
            }
            let mut back = vec![R::zero(); nx * ny];
            fft.inverse(&mut spectrum, &mut back, &mut scratch);
            for (a, b) in back.iter().zip(&field) {
                let (a, b) = (a.wide() / (nx * ny) as f64, b.wide());
                assert!((a - b).abs() < 10.0 * rounding, "{nx}x{ny}: {a} against {b}");
            }
        }
    }

    #[test]
    fn a_plane_wave_has_one_mode_and_comes_back() {
        a_wave_comes_back::<f64>(1e-15);
        a_wave_comes_back::<f32>(3e-7);
    }
}
