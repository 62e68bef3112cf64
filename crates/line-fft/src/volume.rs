//! Real transforms of fields on three axes.
//!
//! Fields are `[nx, ny, nz]`, z contiguous, and spectra `[nx, rows, ny]` of [`Pack`]s, with modes in z in the lanes. A
//! plane of x is transformed along z and y while it is in the cache; lines along x are collected from all planes in
//! blocks of neighbours. Waves that a filter cuts are left out of the transforms along x. Forward transforms are
//! unnormalised.

use std::array::from_fn;
use std::marker::PhantomData;
use std::ops::Range;

use rustfft::num_complex::Complex;

use crate::lines::Lines;
use crate::pack::Pack;
use crate::real_lines::{Block, RealLines};
use crate::simd::Real;
use crate::team::{ThreadTeam, nothing};

/// Lines along x that are collected together: four packs in a row are as fast to read as more, and the lines of six
/// spectra stay in the second cache.
const NEIGHBOURS: usize = 4;

/// Plan for the transforms of one grid. Threads can share it; each needs a [`VolumeScratch`].
pub struct Fft3<R: Real> {
    x: Lines<R>,
    y: Lines<R>,
    z: RealLines<R>,
    shape: [usize; 3],
    /// For each row, the number of wavenumbers along y, with one sign and 0, that the filter leaves.
    kept: Vec<usize>,
}

/// Scratch space of one thread for up to `N` spectra.
pub struct VolumeScratch<R: Real, const N: usize> {
    /// A plane of a spectrum, `[rows, ny]`.
    plane: Vec<Pack<R>>,
    row: Vec<Pack<R>>,
    block: Block<R>,
    /// Collected lines along x of each spectrum, `[NEIGHBOURS, nx]`, and one transformed line of each.
    collected: [Vec<Pack<R>>; N],
    lines: [Vec<Pack<R>>; N],
    line: Vec<Complex<R>>,
}

/// A spectrum whose lines along x are written by several threads.
struct Shared<'a, T> {
    start: *mut T,
    len: usize,
    borrow: PhantomData<&'a mut [T]>,
}

// SAFETY: threads access disjoint elements, see `Shared::at`.
unsafe impl<T: Send> Sync for Shared<'_, T> {}

impl<'a, T: Copy> Shared<'a, T> {
    fn new(slice: &'a mut [T]) -> Self {
        Self { start: slice.as_mut_ptr(), len: slice.len(), borrow: PhantomData }
    }

    /// Return some elements.
    ///
    /// # Safety
    /// No other thread accesses them at the same time, and the previous borrow of them has ended.
    #[allow(clippy::mut_from_ref, reason = "threads share the slice and access disjoint elements")]
    unsafe fn at(&self, range: Range<usize>) -> &mut [T] {
        assert!(range.start <= range.end && range.end <= self.len);
        // SAFETY: it lies in the slice, and the caller promises that nobody else accesses it.
        unsafe { std::slice::from_raw_parts_mut(self.start.add(range.start), range.len()) }
    }
}

impl<R: Real> Fft3<R> {
    /// Plan transforms of fields of a `shape`. `kept` has, for each row of modes along z that is not cut off, the number
    /// of wavenumbers along y from 0 that the filter leaves. There must be at least 8 points along z, a block of lines
    /// along y, and two points along x.
    pub fn new(shape: [usize; 3], kept: Vec<usize>) -> Self {
        let [nx, ny, nz] = shape;
        let modes = (kept.len() * R::LANES).min(nz / 2 + 1);
        Self { x: Lines::new(nx), y: Lines::new(ny), z: RealLines::new(ny, nz, modes), shape, kept }
    }

    /// Return the scratch space of a thread.
    pub fn scratch<const N: usize>(&self) -> VolumeScratch<R, N> {
        let [nx, ny, _] = self.shape;
        let packs = |n: usize| vec![Pack::default(); n];
        VolumeScratch {
            plane: packs(self.kept.len() * ny),
            row: packs(ny),
            block: self.z.block(),
            collected: from_fn(|_| packs(NEIGHBOURS * nx)),
            lines: from_fn(|_| packs(nx)),
            line: vec![Complex::default(); self.x.scratch_len().max(self.y.scratch_len())],
        }
    }

    /// Return a spectrum of zeros.
    pub fn spectrum(&self) -> Vec<Pack<R>> {
        vec![Pack::default(); self.shape[0] * self.plane_len()]
    }

    /// Return the gains of a round trip over the number of points, by the wavenumbers along x, y and z.
    pub fn gains(&self) -> [Vec<f64>; 3] {
        [self.x.gains(), self.y.gains(), self.z.gains()]
    }

    /// Return the number of packs in a plane of a spectrum.
    fn plane_len(&self) -> usize {
        self.kept.len() * self.shape[1]
    }

    /// Return whether the filter leaves a wavenumber along y, by its index, in a row.
    fn keeps(&self, row: usize, j: usize) -> bool {
        j.min(self.shape[1] - j) < self.kept[row]
    }

    /// Transform fields along z and y; [`Self::along_x`] completes their spectra.
    pub fn forward<const M: usize, const N: usize>(
        &self,
        team: &ThreadTeam,
        fields: [&[R]; M],
        spectra: &mut [Vec<Pack<R>>; N],
        scratch: &mut [VolumeScratch<R, N>],
    ) {
        let ([_, ny, nz], length) = (self.shape, self.plane_len());
        for (field, spectrum) in fields.into_iter().zip(spectra) {
            let planes = field.chunks_exact(ny * nz).zip(spectrum.chunks_exact_mut(length));
            team.share_with(scratch, nothing, planes, |(points, modes), VolumeScratch { plane, block, line, .. }| {
                self.z.forward(&ThreadTeam::alone(), [points], [&mut *plane], std::slice::from_mut(block));
                for (from, to) in plane.chunks_exact(ny).zip(modes.chunks_exact_mut(ny)) {
                    self.y.forward::<false>(from, to, line);
                }
            });
        }
    }

    /// Transform the first `inputs` spectra along x, call `solve(row, j, lines)` with the lines of all spectra for each
    /// wavenumber along y that the filter leaves, and transform the `outputs` back along x.
    pub fn along_x<const N: usize>(
        &self,
        team: &ThreadTeam,
        spectra: &mut [Vec<Pack<R>>; N],
        [inputs, outputs]: [Range<usize>; 2],
        scratch: &mut [VolumeScratch<R, N>],
        solve: impl Fn(usize, usize, &mut [Vec<Pack<R>>; N]) + Sync,
    ) {
        let ([nx, ny, _], length) = (self.shape, self.plane_len());
        let spectra = spectra.each_mut().map(|spectrum| Shared::new(spectrum));
        let blocks = (0..self.kept.len()).flat_map(|row| (0..ny).step_by(NEIGHBOURS).map(move |first| (row, first)));
        let blocks = blocks.map(|(row, first)| (row, first..(first + NEIGHBOURS).min(ny)));
        let blocks = blocks.filter(|(row, js)| js.clone().any(|j| self.keeps(*row, j)));
        team.share_with(scratch, nothing, blocks, |(row, js), VolumeScratch { collected, lines, line, .. }| {
            let place = |i: usize| i * length + row * ny + js.start..i * length + row * ny + js.end;
            for c in inputs.clone() {
                for i in 0..nx {
                    // SAFETY: this block of lines belongs to this call alone.
                    let packs = unsafe { spectra[c].at(place(i)) };
                    packs.iter().enumerate().for_each(|(b, pack)| collected[c][b * nx + i] = *pack);
                }
            }
            for (b, j) in js.clone().enumerate().filter(|(_, j)| self.keeps(row, *j)) {
                let own = b * nx..(b + 1) * nx;
                for c in inputs.clone() {
                    self.x.forward::<false>(&collected[c][own.clone()], &mut lines[c], line);
                }
                solve(row, j, lines);
                for c in outputs.clone() {
                    self.x.forward::<true>(&lines[c], &mut collected[c][own.clone()], line);
                }
            }
            for c in outputs.clone() {
                for i in 0..nx {
                    // SAFETY: as above.
                    let packs = unsafe { spectra[c].at(place(i)) };
                    packs.iter_mut().enumerate().for_each(|(b, pack)| *pack = collected[c][b * nx + i]);
                }
            }
        });
    }

    /// Write fields, times the number of points, from spectra after [`Self::along_x`], and call `read` with the points of
    /// each plane.
    pub fn inverse<const M: usize, const N: usize>(
        &self,
        team: &ThreadTeam,
        spectra: [&[Pack<R>]; M],
        fields: [&mut [R]; M],
        scratch: &mut [VolumeScratch<R, N>],
        read: impl Fn([&[R]; M]) + Sync,
    ) {
        let ([nx, ny, nz], length) = (self.shape, self.plane_len());
        let mut planes = fields.map(|field| field.chunks_exact_mut(ny * nz));
        let planes = (0..nx).map(|i| (i, planes.each_mut().map(|planes| planes.next().unwrap_or_default())));
        team.share_with(scratch, nothing, planes, |(i, mut points), VolumeScratch { plane, row, block, line, .. }| {
            for (spectrum, points) in spectra.into_iter().zip(&mut points) {
                let modes = spectrum[i * length..][..length].chunks_exact(ny);
                for ((from, to), &kept) in modes.zip(plane.chunks_exact_mut(ny)).zip(&self.kept) {
                    // Parts are swapped already: the forward transform is the inverse one, with swapped parts.
                    let cut = kept..(ny + 1 - kept).max(kept);
                    row[..cut.start].copy_from_slice(&from[..cut.start]);
                    row[cut.clone()].fill(Pack::default());
                    row[cut.end..].copy_from_slice(&from[cut.end..]);
                    self.y.forward::<false>(row, to, line);
                }
                for lines in self.z.blocks(0..ny) {
                    self.z.inverse(plane, lines.clone(), &mut points[lines.start * nz..lines.end * nz], block);
                }
            }
            read(points.each_ref().map(|points| &**points));
        });
    }
}
