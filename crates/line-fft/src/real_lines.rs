//! Real transforms of lines along the contiguous axis.
//!
//! A field is `[lines, length]`. A block of twice as many lines as a vector has lanes is transformed together, two
//! lines in each lane as the real and the imaginary part of one. The spectrum is `[rows, lines]` of [`Pack`]s: row j
//! holds the modes LANES j … LANES (j + 1) − 1 of every line.

#![allow(clippy::needless_range_loop, reason = "loops over lanes are clearest, and surely unrolled, by index")]

use std::ops::Range;

use rustfft::num_complex::Complex;

use crate::lines::Lines;
use crate::pack::{Complexes, Pack};
use crate::simd::{Arithmetic, Kernel, Real, run};
use crate::team::{ThreadTeam, nothing};

/// Lines that are transformed together.
pub const fn block<R: Real>() -> usize {
    2 * R::LANES
}

/// Plan for the real transforms of the lines of a field. Threads can share it; each needs a [`Block`].
pub struct RealLines<R: Real> {
    line: Lines<R>,
    length: usize,
    count: usize,
    rows: usize,
}

/// Scratch space of one thread: a block of lines before and after its transform.
pub struct Block<R: Real> {
    packs: [Vec<Pack<R>>; 2],
    line: Vec<Complex<R>>,
}

impl<R: Real> RealLines<R> {
    /// Plan transforms of `count` lines, at least a block, of `length` points, at least 8, that keep the first `modes`
    /// of `length/2 + 1`.
    pub fn new(count: usize, length: usize, modes: usize) -> Self {
        let fits = count >= block::<R>() && length >= 8 && modes <= length / 2 + 1;
        assert!(fits, "{count} lines of {length} points, {modes} modes");
        Self { line: Lines::new(length), length, count, rows: modes.div_ceil(R::LANES) }
    }

    /// Return the scratch space of a thread.
    pub fn block(&self) -> Block<R> {
        let packs = || vec![Pack::default(); self.length];
        Block { packs: [packs(), packs()], line: vec![Complex::default(); self.line.scratch_len()] }
    }

    /// Return a spectrum of zeros.
    pub fn spectrum(&self) -> Vec<Pack<R>> {
        vec![Pack::default(); self.rows * self.count]
    }

    /// Return [`Lines::gains`] of each mode of a spectrum.
    pub fn gains(&self) -> Vec<f64> {
        // A mode and its mirror image separate the modes of two lines.
        let gains = self.line.gains();
        let gain =
            |k: usize| if k < self.length { 0.5 * (gains[k] + gains[(self.length - k) % self.length]) } else { 1.0 };
        (0..self.rows * R::LANES).map(gain).collect()
    }

    /// Divide the lines into at most `parts` ranges. Transforms of the ranges have the same bits for any number of
    /// parts.
    pub fn shares(&self, parts: usize) -> impl Iterator<Item = Range<usize>> + use<R> {
        let (count, blocks) = (self.count, self.count / block::<R>());
        let parts = parts.min(blocks);
        let first = move |part: usize| if part == parts { count } else { part * blocks / parts * block::<R>() };
        (0..parts).map(move |part| first(part)..first(part + 1))
    }

    /// Divide a range into blocks of lines; the last two overlap if the lines do not fill whole blocks.
    pub fn blocks(&self, lines: Range<usize>) -> impl Iterator<Item = Range<usize>> + use<R> {
        lines
            .clone()
            .step_by(block::<R>())
            .map(move |first| first.min(lines.end - block::<R>()))
            .map(|first| first..first + block::<R>())
    }

    /// Write the unnormalised spectra of several fields; `blocks` has one for each thread of the team.
    pub fn forward<const N: usize>(
        &self,
        team: &ThreadTeam,
        fields: [&[R]; N],
        mut spectra: [&mut [Pack<R>]; N],
        blocks: &mut [Block<R>],
    ) {
        let (count, length) = (self.count, self.length);
        if team.parts() == 1 {
            let block = &mut blocks[0];
            for (field, spectrum) in fields.into_iter().zip(spectra) {
                for lines in self.blocks(0..count) {
                    let field = &field[lines.start * length..lines.end * length];
                    let first = lines.start;
                    self.forward_block(field, block, |row, line, pack| spectrum[row * count + first + line] = pack);
                }
            }
            return;
        }
        // Each part has its lines of each row.
        let mut rows = spectra.each_mut().map(|spectrum| spectrum.chunks_exact_mut(count).collect::<Vec<_>>());
        let mut take = |count: usize| {
            rows.each_mut().map(|rows| -> Vec<&mut [Pack<R>]> {
                rows.iter_mut().filter_map(|row| row.split_off_mut(..count)).collect()
            })
        };
        let shares: Vec<_> = self.shares(team.parts()).map(|lines| (take(lines.len()), lines)).collect();
        team.share_with(blocks, nothing, shares.into_iter(), |(spectra, share), block| {
            for (field, mut rows) in fields.into_iter().zip(spectra) {
                for lines in self.blocks(share.clone()) {
                    let field = &field[lines.start * length..lines.end * length];
                    let first = lines.start - share.start;
                    self.forward_block(field, block, |row, line, pack| rows[row][first + line] = pack);
                }
            }
        });
    }

    /// Write the points of a block of `lines`, times the length, from a spectrum with real and imaginary parts swapped,
    /// as [`Lines::forward`] with `EXCHANGE` writes it.
    pub fn inverse(
        &self,
        spectrum: &[Pack<R>],
        lines: Range<usize>,
        points: &mut [R],
        Block { packs: [modes, values], line }: &mut Block<R>,
    ) {
        run(Pair { spectrum, count: self.count, rows: self.rows, first: lines.start, modes });
        self.line.forward::<false>(modes, values, line);
        run(Scatter { lines: values, points });
    }

    /// Transform the lines of a block; `store(row, line, modes)` puts the modes into the spectrum.
    fn forward_block(
        &self,
        field: &[R],
        Block { packs: [values, modes], line }: &mut Block<R>,
        store: impl FnMut(usize, usize, Pack<R>),
    ) {
        run(Gather { field, lines: values });
        self.line.forward::<false>(values, modes, line);
        run(Unpair { modes, rows: self.rows, store });
    }
}

/// Transpose the first packs: return the real and the imaginary parts of each lane.
#[inline(always)]
fn transposed_parts<R: Real>(on: impl Arithmetic<R>, packs: &[Pack<R>]) -> (R::Square, R::Square) {
    let (mut re, mut im) = (R::zeros(), R::zeros());
    let packs = &packs[..R::LANES];
    for l in 0..R::LANES {
        (re[l], im[l]) = (R::load(&packs[l].re), R::load(&packs[l].im));
    }
    (on.transposed(re), on.transposed(im))
}

/// Load a block: half of its lines as real parts, the other half as imaginary parts.
struct Gather<'a, R: Real> {
    field: &'a [R],
    lines: &'a mut [Pack<R>],
}

impl<R: Real> Kernel for Gather<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let length = self.lines.len();
        let (re_lines, im_lines) = self.field[..block::<R>() * length].split_at(R::LANES * length);
        let mut lines = self.lines.chunks_exact_mut(R::LANES);
        for (block, packs) in lines.by_ref().enumerate() {
            let (mut re, mut im) = (R::zeros(), R::zeros());
            for c in 0..R::LANES {
                let first = c * length + block * R::LANES;
                (re[c], im[c]) = (R::gather(&re_lines[first..]), R::gather(&im_lines[first..]));
            }
            let (re, im) = (on.transposed(re), on.transposed(im));
            for j in 0..R::LANES {
                packs[j] = Complexes { re: re[j], im: im[j] }.pack();
            }
        }
        let rest = lines.into_remainder();
        let first = length - rest.len();
        for (j, pack) in rest.iter_mut().enumerate() {
            for c in 0..R::LANES {
                pack.re[c] = re_lines[c * length + first + j];
                pack.im[c] = im_lines[c * length + first + j];
            }
        }
    }
}

/// Store a block, the reverse of [`Gather`] with real and imaginary parts swapped.
struct Scatter<'a, R: Real> {
    lines: &'a [Pack<R>],
    points: &'a mut [R],
}

impl<R: Real> Kernel for Scatter<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let length = self.lines.len();
        let (im_lines, re_lines) = self.points[..block::<R>() * length].split_at_mut(R::LANES * length);
        let lines = self.lines.chunks_exact(R::LANES);
        let rest = lines.remainder();
        for (block, packs) in lines.enumerate() {
            let (re, im) = transposed_parts(on, packs);
            for c in 0..R::LANES {
                let first = c * length + block * R::LANES;
                im_lines[first..][..R::LANES].copy_from_slice(R::store(im[c]).as_ref());
                re_lines[first..][..R::LANES].copy_from_slice(R::store(re[c]).as_ref());
            }
        }
        let first = length - rest.len();
        for (j, pack) in rest.iter().enumerate() {
            for c in 0..R::LANES {
                im_lines[c * length + first + j] = pack.im[c];
                re_lines[c * length + first + j] = pack.re[c];
            }
        }
    }
}

/// Separate the modes of a + i b, a and b real, into the modes of a and of b, and transpose them to rows.
struct Unpair<'a, R: Real, F> {
    modes: &'a [Pack<R>],
    rows: usize,
    store: F,
}

impl<R: Real, F: FnMut(usize, usize, Pack<R>)> Kernel for Unpair<'_, R, F> {
    type Real = R;

    #[inline(always)]
    fn run(mut self, on: impl Arithmetic<R>) {
        let (length, half) = (self.modes.len(), R::rounded(0.5).splat());
        for row in 0..self.rows {
            // The last row may hold modes above length/2, which are not read.
            let [mut a_re, mut a_im, mut b_re, mut b_im] = [R::zeros(); 4];
            for l in 0..R::LANES {
                let k = R::LANES * row + l;
                let z = Complexes::load(&self.modes[k]);
                let mirror = Complexes::load(&self.modes[if k == 0 { 0 } else { length - k }]);
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

/// Join the modes of two lines, the reverse of [`Unpair`] for numbers with real and imaginary parts swapped.
struct Pair<'a, R: Real> {
    spectrum: &'a [Pack<R>],
    count: usize,
    rows: usize,
    first: usize,
    modes: &'a mut [Pack<R>],
}

impl<R: Real> Kernel for Pair<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let length = self.modes.len();
        for row in 0..self.rows {
            let packs = &self.spectrum[row * self.count + self.first..][..block::<R>()];
            let ((a_im, a_re), (b_im, b_re)) = (transposed_parts(on, packs), transposed_parts(on, &packs[R::LANES..]));
            for l in 0..R::LANES.min(length / 2 + 1 - R::LANES * row) {
                let k = R::LANES * row + l;
                if k == 0 || 2 * k == length {
                    // Rounding leaves imaginary parts in the real modes.
                    self.modes[k] = Complexes { re: b_re[l], im: a_re[l] }.pack();
                } else {
                    let z = Complexes { re: on.add(a_im[l], b_re[l]), im: on.sub(a_re[l], b_im[l]) };
                    let mirror = Complexes { re: on.sub(b_re[l], a_im[l]), im: on.add(a_re[l], b_im[l]) };
                    self.modes[k] = z.pack();
                    self.modes[length - k] = mirror.pack();
                }
            }
        }
        let left_out = R::LANES * self.rows;
        if left_out <= length / 2 {
            self.modes[left_out..=length - left_out].fill(Pack::default());
        }
    }
}
