//! Transforms of a step: from a velocity to a flow without divergence, and to the pressure.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::field::Field;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::projection::Projection;
use crate::timer::{Phase, PhaseTimer};
use line_fft::{Arithmetic, Kernel, Real, run};
use line_fft::{Block, Fft2, Pack, Scratch};
use line_fft::{Team, nothing};

/// Least bytes of a field for each thread. With a team on a busy machine, two threads with 94 kB each made a step of
/// FSI3 longer by a quarter.
pub const LEAST_BYTES_PER_THREAD: usize = 320_000;

/// Transforms of one grid, with room for the spectra.
pub struct Spectral<R: Real> {
    grid: Grid,
    fft: Fft2<R>,
    /// Spectra of both components and of the vorticity or pressure.
    spectra: [Vec<Pack<R>>; 3],
    /// Scratch space of each thread, along x and along y.
    scratch: Vec<Scratch<R>>,
    blocks: Vec<Block<R>>,
}

/// The modes along y of a pair of fields, from which [`AlongY::solve`] makes a flow.
pub struct AlongY<'a, R: Real>(&'a mut Spectral<R>);

/// The spectrum of the total pressure.
pub struct PressureSpectrum<'a, R: Real>(&'a mut Spectral<R>);

impl<R: Real> Spectral<R> {
    /// Plan for a grid, the first `modes` in y, and at most `threads` threads.
    pub fn new(grid: &Grid, modes: usize, threads: usize) -> Self {
        let threads = threads.min(size_of::<R>() * grid.len() / LEAST_BYTES_PER_THREAD).max(1);
        let fft = Fft2::new(grid.cells[0], grid.cells[1], modes);
        Self {
            grid: *grid,
            spectra: [fft.spectrum(), fft.spectrum(), fft.spectrum()],
            scratch: (0..threads).map(|_| fft.scratch()).collect(),
            blocks: (0..threads).map(|_| fft.y.block()).collect(),
            fft,
        }
    }

    /// Return the number of threads that share the work.
    pub fn threads(&self) -> usize {
        self.scratch.len()
    }

    /// Return a spectrum of zeros, `[rows, nx]`.
    pub fn spectrum(&self) -> Vec<Pack<R>> {
        self.fft.spectrum()
    }

    /// Return the gains of a round trip, by kx and by ky.
    pub fn gains(&self) -> [Vec<f64>; 2] {
        self.fft.gains()
    }

    /// Transform `w` along y.
    pub fn transform_along_y(&mut self, team: &Team, w: &[Field<R>; 2], timer: &mut PhaseTimer) -> AlongY<'_, R> {
        let [u_hat, v_hat, _] = &mut self.spectra;
        self.fft.y.forward(team, w.each_ref().map(|w| &**w), [u_hat, v_hat], &mut self.blocks);
        timer.mark(Phase::Forward);
        AlongY(self)
    }

    /// Return whether the flow of the spectra is finite, seen in the modes of the first column before the flow is made.
    /// A transform along x spreads what is not a number over its row, and of a number above [`Real::OVERFLOW_GUARD`] at
    /// least the rounding.
    fn is_finite(&self) -> bool {
        let [u_hat, v_hat, _] = &self.spectra;
        let nx = self.grid.cells[0];
        let mut modes = u_hat.iter().step_by(nx).chain(v_hat.iter().step_by(nx));
        modes.all(|mode| {
            [mode.re, mode.im].iter().all(|lanes| lanes.as_ref().iter().all(|part| part.abs() < R::OVERFLOW_GUARD))
        })
    }

    /// Return the spectrum of Pi that belongs to `w` (m/s) of a step with `inv_tau` (1/s) and a CFL number.
    pub fn pressure(
        &mut self,
        projection: &Projection<R>,
        w: &[Field<R>; 2],
        inv_tau: f64,
        cfl: f64,
    ) -> PressureSpectrum<'_, R> {
        let [wx_hat, wy_hat, pi_hat] = &mut self.spectra;
        let (scratch, block) = (&mut self.scratch[0], &mut self.blocks[0]);
        self.fft.forward(&w[0], wx_hat, scratch, block);
        self.fft.forward(&w[1], wy_hat, scratch, block);
        projection.pressure(wx_hat, wy_hat, inv_tau, cfl, pi_hat);
        PressureSpectrum(self)
    }

    /// Write the divergence (1/s) of a velocity (m/s).
    pub fn divergence(&mut self, projection: &Projection<R>, velocity: &[Field<R>; 2], divergence: &mut [R]) {
        let [u_hat, v_hat, divergence_hat] = &mut self.spectra;
        let (scratch, block) = (&mut self.scratch[0], &mut self.blocks[0]);
        self.fft.forward(&velocity[0], u_hat, scratch, block);
        self.fft.forward(&velocity[1], v_hat, scratch, block);
        projection.divergence(u_hat, v_hat, divergence_hat);
        self.fft.inverse(divergence_hat, divergence, scratch, block);
    }
}

impl<R: Real> PressureSpectrum<'_, R> {
    /// Write Pi, m²/s².
    pub fn write(self, pi: &mut [R]) {
        let Spectral { fft, spectra: [_, _, pi_hat], scratch, blocks, .. } = self.0;
        fft.inverse(pi_hat, pi, &mut scratch[0], &mut blocks[0]);
    }
}

impl<R: Real> AlongY<'_, R> {
    /// Write `flow` and return its largest `|u|/dx + |v|/dy` (1/s). If that is not finite, return NaN and leave `flow`.
    ///
    /// `solve(row, own, [u, v, omega])` makes the spectra of the flow from those of w in `u` and `v`, row by row; `own`
    /// is an element of the iterator for each row. Each row goes through both transforms along x and through `solve`
    /// while it is in the cache. One thread runs `meanwhile` while the helpers begin.
    pub fn solve<T: Send>(
        self,
        team: &Team,
        own: impl Iterator<Item = T> + Send,
        solve: impl Fn(usize, T, [&mut [Pack<R>]; 3]) + Sync,
        flow: &mut Flow<R>,
        timer: &mut PhaseTimer,
        meanwhile: impl FnOnce() + Send,
    ) -> f64 {
        let spectral = self.0;
        let ([nx, ny], spacing) = (spectral.grid.cells, spectral.grid.spacing);
        let fft = &spectral.fft;
        let meanwhile = if team.is_alone() {
            meanwhile();
            timer.mark(Phase::Loads);
            None
        } else {
            Some(meanwhile)
        };

        let [u_rows, v_rows, omega_rows] = spectral.spectra.each_mut().map(|spectrum| spectrum.chunks_exact_mut(nx));
        let rows = u_rows.zip(v_rows).zip(omega_rows).zip(own).enumerate();
        let first = || meanwhile.into_iter().for_each(|meanwhile| meanwhile());
        team.share_with(&mut spectral.scratch, first, rows, |(row, (((u_hat, v_hat), omega_hat), own)), scratch| {
            let Scratch { rows: [u, v, omega], line } = scratch;
            fft.x.forward::<false>(u_hat, u, line);
            fft.x.forward::<false>(v_hat, v, line);
            solve(row, own, [&mut *u, &mut *v, &mut *omega]);
            fft.x.forward::<true>(u, u_hat, line);
            fft.x.forward::<true>(v, v_hat, line);
            fft.x.forward::<true>(omega, omega_hat, line);
        });
        timer.mark(Phase::Rows);
        if !spectral.is_finite() {
            return f64::NAN;
        }

        let Flow { velocity: [u, v], vorticity } = flow;
        let [u_hat, v_hat, omega_hat] = &spectral.spectra;
        let inv_spacing = spacing.map(|spacing| R::rounded(1.0 / spacing));
        // Numbers that are not negative have the order of their bits.
        let largest = AtomicU64::new(0);
        let [mut u_rest, mut v_rest, mut omega_rest] = [&mut *u, &mut *v, vorticity].map(|field| &mut **field);
        let fft = &spectral.fft;
        let shares = fft.y.shares(team.parts()).filter_map(|share| {
            let points = ..share.len() * ny;
            let (u, v) = (u_rest.split_off_mut(points)?, v_rest.split_off_mut(points)?);
            Some((share, u, v, omega_rest.split_off_mut(points)?))
        });
        team.share_with(&mut spectral.blocks, nothing, shares, |(share, u, v, omega), block| {
            for columns in fft.y.blocks(share.clone()) {
                let points = (columns.start - share.start) * ny..(columns.end - share.start) * ny;
                let [u, v, omega] = [&mut *u, &mut *v, &mut *omega].map(|field| &mut field[points.clone()]);
                fft.y.inverse(u_hat, columns.clone(), u, block);
                fft.y.inverse(v_hat, columns.clone(), v, block);
                fft.y.inverse(omega_hat, columns, omega, block);
                let mut here = R::zero();
                run(AdvectionRate { inv_spacing, velocity: [u, v], largest: &mut here });
                largest.fetch_max(here.to_f64().to_bits(), Ordering::Relaxed);
            }
        });
        timer.mark(Phase::Back);
        f64::from_bits(largest.into_inner())
    }
}

/// Largest `|u|/dx + |v|/dy`, 1/s.
struct AdvectionRate<'a, R> {
    inv_spacing: [R; 2],
    velocity: [&'a [R]; 2],
    largest: &'a mut R,
}

impl<R: Real> Kernel for AdvectionRate<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<R>) {
        /// Independent maxima: no comparison waits for the previous one.
        const LANES: usize = 8;
        let Self { inv_spacing: [inv_dx, inv_dy], velocity: [u, v], .. } = self;
        let mut largest = [R::zero(); LANES];
        let ((u, u_rest), (v, v_rest)) = (u.as_chunks::<LANES>(), v.as_chunks::<LANES>());
        for (u, v) in u.iter().zip(v) {
            for lane in 0..LANES {
                let rate = u[lane].abs() * inv_dx + v[lane].abs() * inv_dy;
                largest[lane] = if rate > largest[lane] { rate } else { largest[lane] };
            }
        }
        let rest = u_rest.iter().zip(v_rest).map(|(u, v)| u.abs() * inv_dx + v.abs() * inv_dy);
        *self.largest = largest.into_iter().chain(rest).fold(R::zero(), |a, b| if a > b { a } else { b });
    }
}
