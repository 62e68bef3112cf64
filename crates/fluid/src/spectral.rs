//! The half of a step that is local in wavenumber: from a velocity to a flow without divergence, and the pressure.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::clock::{Clock, Phase};
use crate::field::Field;
use crate::grid::Grid;
use crate::projection::Projection;
use crate::state::Flow;
use line_fft::{Arithmetic, Kernel, Real, run};
use line_fft::{Block, Fft2, Pack, Scratch};
use line_fft::{Team, nothing};

/// Bytes of a field that are worth a thread of their own. Where threads were started four times in a step, two of them made
/// a step of FSI3 longer by 30 to 130 % with 94 kB each, and by -39 to +14 % with 374 kB; with a team, on a busy machine, by
/// a quarter with 94 kB.
const LEAST_SHARE: usize = 320_000;

/// Transforms and projection of one grid, with room for the spectra.
pub struct Spectral<R: Real> {
    grid: Grid,
    fft: Fft2<R>,
    /// Viscosity, filter and projection.
    pub projection: Projection<R>,
    /// Spectra of both components and of the vorticity or pressure.
    spectra: [Vec<Pack<R>>; 3],
    /// Scratch space of each thread, along x and along y.
    scratch: Vec<Scratch<R>>,
    blocks: Vec<Block<R>>,
}

impl<R: Real> Spectral<R> {
    /// Plan for a grid and at most so many threads.
    pub fn new(grid: &Grid, filter: scene::Filter, threads: usize) -> Self {
        let threads = threads.min(size_of::<R>() * grid.len() / LEAST_SHARE).max(1);
        let mut projection = Projection::new(grid, filter);
        let fft = Fft2::new(grid.nx, grid.ny, projection.modes());
        projection.set_gains(&fft.gains());
        Self {
            grid: *grid,
            spectra: [fft.spectrum(), fft.spectrum(), fft.spectrum()],
            scratch: (0..threads).map(|_| fft.scratch()).collect(),
            blocks: (0..threads).map(|_| fft.y.block()).collect(),
            fft,
            projection,
        }
    }

    /// Number of threads that share the work.
    pub fn threads(&self) -> usize {
        self.scratch.len()
    }

    /// A spectrum of zeros, `[rows, nx]`.
    pub fn spectrum(&self) -> Vec<Pack<R>> {
        self.fft.spectrum()
    }

    /// What the transforms make of a mode, by kx and by ky.
    pub fn gains(&self) -> [Vec<f64>; 2] {
        self.fft.gains()
    }

    /// The modes along y of `w`, from which [`Self::solve`] goes on.
    pub fn transform_along_y(&mut self, team: &Team, w: &[Field<R>; 2], clock: &mut Clock) {
        let [u_hat, v_hat, _] = &mut self.spectra;
        self.fft.y.forward(team, [&w[0], &w[1]], [u_hat, v_hat], &mut self.blocks);
        clock.mark(Phase::Forward);
    }

    /// On to `flow`, and the largest `|u|/dx + |v|/dy` in it (1/s); where that would not be finite it is not a number, and
    /// `flow` stays as it was.
    ///
    /// `solve(projection, row, own, [u, v, omega])` makes the spectra of the flow from those of w in `u` and `v`, row by
    /// row. `own` is what the caller has for each row. Between the two passes along y, each row
    /// goes through both transforms along x and through `solve` while it is in the cache. Helpers, if there are any, begin
    /// with that while one thread does what is to be done `meanwhile`.
    pub fn solve<T: Send>(
        &mut self,
        team: &Team,
        own: impl Iterator<Item = T> + Send,
        solve: impl Fn(&Projection<R>, usize, T, [&mut [Pack<R>]; 3]) + Sync,
        flow: &mut Flow<R>,
        clock: &mut Clock,
        meanwhile: impl FnOnce() + Send,
    ) -> f64 {
        let [u_hat, v_hat, omega_hat] = &mut self.spectra;
        let (fft, projection, nx, ny) = (&self.fft, &self.projection, self.grid.nx, self.grid.ny);
        let meanwhile = if team.is_alone() {
            meanwhile();
            clock.mark(Phase::Loads);
            None
        } else {
            Some(meanwhile)
        };

        let rows = [&mut *u_hat, v_hat, omega_hat].map(|spectrum| spectrum.chunks_exact_mut(nx));
        let [u_rows, v_rows, omega_rows] = rows;
        let rows = u_rows.zip(v_rows).zip(omega_rows).zip(own).enumerate();
        let first = || meanwhile.into_iter().for_each(|meanwhile| meanwhile());
        team.share_with(&mut self.scratch, first, rows, |(row, (((u_hat, v_hat), omega_hat), own)), scratch| {
            let Scratch { rows: [u, v, omega], line } = scratch;
            fft.x.forward::<false>(u_hat, u, line);
            fft.x.forward::<false>(v_hat, v, line);
            solve(projection, row, own, [&mut *u, &mut *v, &mut *omega]);
            fft.x.forward::<true>(u, u_hat, line);
            fft.x.forward::<true>(v, v_hat, line);
            fft.x.forward::<true>(omega, omega_hat, line);
        });
        clock.mark(Phase::Rows);
        if !self.is_finite() {
            return f64::NAN;
        }

        let Flow { velocity: [u, v], vorticity } = flow;
        let [u_hat, v_hat, omega_hat] = &self.spectra;
        let (per_dx, per_dy) = (R::rounded(1.0 / self.grid.dx), R::rounded(1.0 / self.grid.dy));
        // Numbers not below 0 are ordered like their bits.
        let largest = AtomicU64::new(0);
        let [mut u_rest, mut v_rest, mut omega_rest] = [&mut *u, &mut *v, vorticity].map(|field| &mut **field);
        let shares = fft.y.shares(team.parts()).filter_map(|share| {
            let points = ..share.len() * ny;
            let (u, v) = (u_rest.split_off_mut(points)?, v_rest.split_off_mut(points)?);
            Some((share, u, v, omega_rest.split_off_mut(points)?))
        });
        team.share_with(&mut self.blocks, nothing, shares, |(share, u, v, omega), block| {
            for columns in fft.y.blocks(share.clone()) {
                let points = (columns.start - share.start) * ny..(columns.end - share.start) * ny;
                let [u, v, omega] = [&mut *u, &mut *v, &mut *omega].map(|field| &mut field[points.clone()]);
                fft.y.inverse(u_hat, columns.clone(), u, block);
                fft.y.inverse(v_hat, columns.clone(), v, block);
                fft.y.inverse(omega_hat, columns, omega, block);
                let mut here = R::zero();
                run(AdvectionRate { per_dx, per_dy, u, v, largest: &mut here });
                largest.fetch_max(here.to_f64().to_bits(), Ordering::Relaxed);
            }
        });
        clock.mark(Phase::Back);
        f64::from_bits(largest.into_inner())
    }

    /// Whether the flow of the spectra is finite, seen before it is made, from the modes of the first column. A transform
    /// along x spreads what is not a number over its row, and of what is larger than [`Real::OVERFLOW_GUARD`] at least its rounding.
    fn is_finite(&self) -> bool {
        let [u_hat, v_hat, _] = &self.spectra;
        let mut modes = u_hat.iter().step_by(self.grid.nx).chain(v_hat.iter().step_by(self.grid.nx));
        modes.all(|mode| {
            [mode.re, mode.im].iter().all(|lanes| lanes.as_ref().iter().all(|part| part.abs() < R::OVERFLOW_GUARD))
        })
    }

    /// Find Pi that belongs to `w` (m/s) of a step with `per_tau` (1/s) and a CFL number, for [`Self::pressure`].
    pub fn solve_for_pressure(&mut self, w: &[Field<R>; 2], per_tau: f64, cfl: f64) {
        let [wx_hat, wy_hat, pi_hat] = &mut self.spectra;
        let (scratch, block) = (&mut self.scratch[0], &mut self.blocks[0]);
        self.fft.forward(&w[0], wx_hat, scratch, block);
        self.fft.forward(&w[1], wy_hat, scratch, block);
        self.projection.pressure(wx_hat, wy_hat, per_tau, cfl, pi_hat);
    }

    /// Pi, m²/s², as [`Self::solve_for_pressure`] found it.
    pub fn pressure(&mut self, pi: &mut [R]) {
        self.fft.inverse(&mut self.spectra[2], pi, &mut self.scratch[0], &mut self.blocks[0]);
    }

    /// Divergence (1/s) of a velocity (m/s).
    pub fn divergence(&mut self, velocity: &[Field<R>; 2], divergence: &mut [R]) {
        let [u_hat, v_hat, divergence_hat] = &mut self.spectra;
        let (scratch, block) = (&mut self.scratch[0], &mut self.blocks[0]);
        self.fft.forward(&velocity[0], u_hat, scratch, block);
        self.fft.forward(&velocity[1], v_hat, scratch, block);
        self.projection.divergence(u_hat, v_hat, divergence_hat);
        self.fft.inverse(divergence_hat, divergence, scratch, block);
    }
}

/// Largest `|u|/dx + |v|/dy`, 1/s.
struct AdvectionRate<'a, R> {
    per_dx: R,
    per_dy: R,
    u: &'a [R],
    v: &'a [R],
    largest: &'a mut R,
}

impl<R: Real> Kernel for AdvectionRate<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<R>) {
        /// Independent maxima, so that no comparison waits for the one before.
        const LANES: usize = 8;
        let Self { per_dx, per_dy, u, v, .. } = self;
        let mut largest = [R::zero(); LANES];
        let ((u, u_rest), (v, v_rest)) = (u.as_chunks::<LANES>(), v.as_chunks::<LANES>());
        for (u, v) in u.iter().zip(v) {
            for lane in 0..LANES {
                let rate = u[lane].abs() * per_dx + v[lane].abs() * per_dy;
                largest[lane] = if rate > largest[lane] { rate } else { largest[lane] };
            }
        }
        let rest = u_rest.iter().zip(v_rest).map(|(u, v)| u.abs() * per_dx + v.abs() * per_dy);
        *self.largest = largest.into_iter().chain(rest).fold(R::zero(), |a, b| if a > b { a } else { b });
    }
}
