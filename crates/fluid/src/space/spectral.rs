//! Transforms of a step in space: from a velocity to a flow without divergence, and to the pressure.

use std::sync::atomic::{AtomicU64, Ordering};

use line_fft::{Arithmetic, Fft3, Kernel, Pack, Real, Team, VolumeScratch, run};

use super::flow::Flow;
use super::projection::{Implicit, Projection};
use crate::field::Field;
use crate::grid::Grid;
use crate::parameters::Filter;
use crate::spectral::LEAST_BYTES_PER_THREAD;

/// Transforms of one grid, with room for the spectra of velocity and vorticity.
pub struct Spectral<R: Real> {
    inv_spacing: [R; 3],
    fft: Fft3<R>,
    projection: Projection<R>,
    spectra: [Vec<Pack<R>>; 6],
    /// Scratch space of each thread.
    scratch: Vec<VolumeScratch<R, 6>>,
}

impl<R: Real> Spectral<R> {
    /// Plan for a grid and at most `threads` threads.
    pub fn new(grid: &Grid<3>, filter: Filter, threads: usize) -> Self {
        let threads = threads.min(size_of::<R>() * grid.len() / LEAST_BYTES_PER_THREAD).max(1);
        let mut projection = Projection::new(grid, filter);
        let fft = Fft3::new(grid.cells, projection.kept());
        projection.set_gains(&fft.gains());
        Self {
            inv_spacing: grid.spacing.map(|spacing| R::rounded(1.0 / spacing)),
            spectra: std::array::from_fn(|_| fft.spectrum()),
            scratch: (0..threads).map(|_| fft.scratch()).collect(),
            fft,
            projection,
        }
    }

    /// Return the number of threads that share the work.
    pub fn threads(&self) -> usize {
        self.scratch.len()
    }

    /// Write the `flow` that solves the equations of a step wave by wave for `w`, and return its largest
    /// `|u|/dx + |v|/dy + |w|/dz` (1/s). If that is not finite, return NaN and leave `flow`.
    pub fn solve(&mut self, team: &Team, implicit: &Implicit, w: &[Field<R>; 3], flow: &mut Flow<R>) -> f64 {
        let Self { inv_spacing, fft, projection, spectra, scratch } = self;
        fft.forward(team, w.each_ref().map(|w| &**w), spectra, scratch);
        let project = |row: usize, j: usize, lines: &mut [Vec<Pack<R>>; 6]| projection.project(implicit, row, j, lines);
        fft.along_x(team, spectra, [0..3, 0..6], scratch, project);
        if !spectra[..3].iter().all(|spectrum| fft.first_plane(spectrum).iter().all(is_finite)) {
            return f64::NAN;
        }
        let Flow { velocity: [u, v, w], vorticity: [ox, oy, oz] } = flow;
        let fields = [u, v, w, ox, oy, oz].map(|field| &mut **field);
        // Numbers that are not negative have the order of their bits.
        let largest = AtomicU64::new(0);
        fft.inverse(team, spectra.each_ref().map(|spectrum| &**spectrum), fields, scratch, |[u, v, w, ..]| {
            let mut here = R::zero();
            run(AdvectionRate { inv_spacing: *inv_spacing, velocity: [u, v, w], largest: &mut here });
            largest.fetch_max(here.to_f64().to_bits(), Ordering::Relaxed);
        });
        f64::from_bits(largest.into_inner())
    }

    /// Write the divergence (1/s) of a velocity (m/s).
    pub fn divergence(&mut self, velocity: &[Field<R>; 3], divergence: &mut [R]) {
        self.scalar(velocity, divergence, |projection, row, j, lines| projection.divergence_of_velocity(row, j, lines));
    }

    /// Write Pi (m²/s²) that belongs to `w` (m/s) of a step with `inv_tau` (1/s) and a CFL number.
    pub fn pressure(&mut self, w: &[Field<R>; 3], inv_tau: f64, cfl: f64, pressure: &mut [R]) {
        self.scalar(w, pressure, |projection, row, j, lines| projection.pressure(inv_tau, cfl, row, j, lines));
    }

    fn scalar(
        &mut self,
        of: &[Field<R>; 3],
        scalar: &mut [R],
        write: impl Fn(&Projection<R>, usize, usize, &mut [Vec<Pack<R>>; 6]) + Sync,
    ) {
        let Self { fft, projection, spectra, scratch, .. } = self;
        let team = &Team::alone();
        fft.forward(team, of.each_ref().map(|field| &**field), spectra, scratch);
        fft.along_x(team, spectra, [0..3, 3..4], scratch, |row, j, lines| write(projection, row, j, lines));
        fft.inverse(team, [&*spectra[3]], [scalar], scratch, |_| ());
    }
}

/// Return whether modes along x are finite. A transform along x spreads what is not a number over its line, and of a
/// number above [`Real::OVERFLOW_GUARD`] at least the rounding.
fn is_finite<R: Real>(mode: &Pack<R>) -> bool {
    [mode.re, mode.im].iter().all(|lanes| lanes.as_ref().iter().all(|part| part.abs() < R::OVERFLOW_GUARD))
}

/// Largest `|u|/dx + |v|/dy + |w|/dz`, 1/s.
struct AdvectionRate<'a, R> {
    inv_spacing: [R; 3],
    velocity: [&'a [R]; 3],
    largest: &'a mut R,
}

impl<R: Real> Kernel for AdvectionRate<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<R>) {
        /// Independent maxima: no comparison waits for the previous one.
        const LANES: usize = 8;
        let Self { inv_spacing: [inv_dx, inv_dy, inv_dz], velocity: [u, v, w], .. } = self;
        let rate = |u: R, v: R, w: R| u.abs() * inv_dx + v.abs() * inv_dy + w.abs() * inv_dz;
        let mut largest = [R::zero(); LANES];
        let ((u, u_rest), (v, v_rest), (w, w_rest)) =
            (u.as_chunks::<LANES>(), v.as_chunks::<LANES>(), w.as_chunks::<LANES>());
        for ((u, v), w) in u.iter().zip(v).zip(w) {
            for lane in 0..LANES {
                let rate = rate(u[lane], v[lane], w[lane]);
                largest[lane] = if rate > largest[lane] { rate } else { largest[lane] };
            }
        }
        let rest = u_rest.iter().zip(v_rest).zip(w_rest).map(|((u, v), w)| rate(*u, *v, *w));
        *self.largest = largest.into_iter().chain(rest).fold(R::zero(), |a, b| if a > b { a } else { b });
    }
}
