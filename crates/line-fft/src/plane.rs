//! Real transforms of fields on two axes.
//!
//! Fields are `[nx, ny]`, y contiguous, and spectra `[rows, nx]` of [`Pack`]s, with modes in y in the lanes. Forward
//! transforms are unnormalised. The halves along each axis are separate, so that work on a row of modes can be done
//! between them, while the row is in the cache.

use std::array::from_fn;
use std::slice::from_mut;

use rustfft::num_complex::Complex;

use crate::lines::Lines;
use crate::pack::Pack;
use crate::real_lines::{Block, RealLines};
use crate::simd::Real;
use crate::team::ThreadTeam;

/// Plan for the transforms of one grid. Threads can share it; each needs a [`Scratch`] and a [`Block`].
pub struct Fft2<R: Real> {
    /// Complex transforms of a row of a spectrum.
    pub x: Lines<R>,
    /// Real transforms of the columns of a field.
    pub y: RealLines<R>,
    shape: [usize; 2],
}

/// Scratch space of one thread.
pub struct Scratch<R: Real> {
    /// Three rows of a spectrum.
    pub rows: [Vec<Pack<R>>; 3],
    /// Scratch space of a transform along a row.
    pub line: Vec<Complex<R>>,
}

impl<R: Real> Fft2<R> {
    /// Plan transforms of `[nx, ny]` fields that keep the first `modes` in y of `ny/2 + 1`; there must be at least 8
    /// points along y and two vectors along x.
    pub fn new(nx: usize, ny: usize, modes: usize) -> Self {
        Self { x: Lines::new(nx), y: RealLines::new(nx, ny, modes), shape: [nx, ny] }
    }

    /// Return the scratch space of a thread along x.
    pub fn scratch(&self) -> Scratch<R> {
        let row = |_| vec![Pack::default(); self.shape[0]];
        Scratch { rows: from_fn(row), line: vec![Complex::default(); self.x.scratch_len()] }
    }

    /// Return a spectrum of zeros.
    pub fn spectrum(&self) -> Vec<Pack<R>> {
        self.y.spectrum()
    }

    /// Return the gains of a round trip over the number of points: the gain of a mode is the product of a factor by its
    /// wavenumber along x, `[nx]`, and a factor by its wavenumber along y, for each mode of a spectrum.
    pub fn gains(&self) -> [Vec<f64>; 2] {
        [self.x.gains(), self.y.gains()]
    }

    /// Write the unnormalised spectrum of a field.
    pub fn forward(&self, field: &[R], spectrum: &mut [Pack<R>], scratch: &mut Scratch<R>, block: &mut Block<R>) {
        self.y.forward(&ThreadTeam::alone(), [field], [&mut *spectrum], from_mut(block));
        self.along_x::<false>(spectrum, scratch);
    }

    /// Write the field of a spectrum, times the number of points; the spectrum is overwritten.
    pub fn inverse(&self, spectrum: &mut [Pack<R>], field: &mut [R], scratch: &mut Scratch<R>, block: &mut Block<R>) {
        self.along_x::<true>(spectrum, scratch);
        let [nx, ny] = self.shape;
        for columns in self.y.blocks(0..nx) {
            let points = columns.start * ny..columns.end * ny;
            self.y.inverse(spectrum, columns, &mut field[points], block);
        }
    }

    /// Transform each row of a spectrum in place.
    fn along_x<const EXCHANGE: bool>(&self, spectrum: &mut [Pack<R>], Scratch { rows, line }: &mut Scratch<R>) {
        for row in spectrum.chunks_exact_mut(self.shape[0]) {
            rows[0].copy_from_slice(row);
            self.x.forward::<EXCHANGE>(&rows[0], row, line);
        }
    }
}
