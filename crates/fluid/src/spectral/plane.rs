//! Transforms of a step in the plane.

use std::iter::repeat;
use std::sync::atomic::{AtomicU64, Ordering};

use line_fft::{Block, Fft2, Pack, Real, Scratch, ThreadTeam, nothing, run};

pub use super::plane_projection::Projection;
use super::{AdvectionRate, Implicit, SharedSum, Transforms, bound, worth, write_within};
use crate::field::Field;
use crate::filter::Damping;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::timer::{Phase, PhaseTimer};

/// Transforms of one grid, with room for the spectra.
pub struct PlaneTransforms<R: Real> {
    grid: Grid<2>,
    fft: Fft2<R>,
    /// Viscosity, filter and projection.
    pub projection: Projection<R>,
    /// Spectra of both components and of the vorticity or pressure.
    spectra: [Vec<Pack<R>>; 3],
    /// Scratch space of each thread, along x and along y.
    scratch: Vec<Scratch<R>>,
    blocks: Vec<Block<R>>,
}

impl<R: Real> PlaneTransforms<R> {
    /// Return a spectrum of zeros, `[rows, nx]`.
    pub fn spectrum(&self) -> Vec<Pack<R>> {
        self.fft.spectrum()
    }

    /// Return the gains of a round trip, by kx and by ky.
    pub fn gains(&self) -> [Vec<f64>; 2] {
        self.fft.gains()
    }

    /// Transform `w`, call `solve(row, own, [u, v, omega])` for each row, which makes the spectra of a flow from those of
    /// w in `u` and `v`, and transform these back along x. Return an upper bound of the flow's largest `|u|/dx + |v|/dy`
    /// (1/s), which is not a number if a mode is not finite.
    ///
    /// `own` is an element of the iterator for each row. Each row goes through both transforms along x and through
    /// `solve` while it is in the cache. One thread runs `meanwhile` while the helpers begin.
    pub fn solve_rows<T: Send>(
        &mut self,
        team: &ThreadTeam,
        w: &[Field<R>; 2],
        own: impl Iterator<Item = T> + Send,
        solve: impl Fn(&Projection<R>, usize, T, [&mut [Pack<R>]; 3]) + Sync,
        timer: &mut PhaseTimer,
        meanwhile: impl FnOnce() + Send,
    ) -> f64 {
        let Self { grid, fft, projection, spectra, scratch, blocks } = self;
        let [u_hat, v_hat, omega_hat] = spectra;
        fft.y.forward(team, w.each_ref().map(|w| &**w), [&mut *u_hat, &mut *v_hat], blocks);
        timer.mark(Phase::Forward);
        let meanwhile = if team.is_alone() {
            meanwhile();
            timer.mark(Phase::Loads);
            None
        } else {
            Some(meanwhile)
        };
        let [u_rows, v_rows, omega_rows] =
            [u_hat, v_hat, omega_hat].map(|spectrum| spectrum.chunks_exact_mut(grid.cells[0]));
        let rows = u_rows.zip(v_rows).zip(omega_rows).zip(own).enumerate();
        let first = || meanwhile.into_iter().for_each(|meanwhile| meanwhile());
        let largest = SharedSum::default();
        team.share_with(scratch, first, rows, |(row, (((u_hat, v_hat), omega_hat), own)), scratch| {
            let Scratch { rows: [u, v, omega], line } = scratch;
            fft.x.forward::<false>(u_hat, u, line);
            fft.x.forward::<false>(v_hat, v, line);
            solve(projection, row, own, [&mut *u, &mut *v, &mut *omega]);
            largest.add(bound([&u[..], &v[..]].into_iter().zip(grid.spacing)));
            fft.x.forward::<true>(u, u_hat, line);
            fft.x.forward::<true>(v, v_hat, line);
            fft.x.forward::<true>(omega, omega_hat, line);
        });
        timer.mark(Phase::Rows);
        largest.into_inner()
    }

    /// Write the flow of the spectra, and return its largest `|u|/dx + |v|/dy`, 1/s.
    pub fn write(&mut self, team: &ThreadTeam, flow: &mut Flow<R, 2>, timer: &mut PhaseTimer) -> f64 {
        let Self { grid, fft, spectra: [u_hat, v_hat, omega_hat], blocks, .. } = self;
        let (ny, inv_spacing) = (grid.cells[1], grid.spacing.map(|spacing| R::rounded(1.0 / spacing)));
        let Flow { velocity: [u, v], vorticity } = flow;
        // Numbers that are not negative have the order of their bits.
        let largest = AtomicU64::new(0);
        let [mut u_rest, mut v_rest, mut omega_rest] = [&mut **u, &mut **v, &mut *vorticity[0]];
        let shares = fft.y.shares(team.parts()).filter_map(|share| {
            let points = ..share.len() * ny;
            let (u, v) = (u_rest.split_off_mut(points)?, v_rest.split_off_mut(points)?);
            Some((share, u, v, omega_rest.split_off_mut(points)?))
        });
        team.share_with(blocks, nothing, shares, |(share, u, v, omega), block| {
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

    /// Write the field whose spectrum `write` makes from those of two fields.
    fn scalar(
        &mut self,
        of: &[Field<R>; 2],
        scalar: &mut [R],
        write: impl FnOnce(&Projection<R>, &[Pack<R>], &[Pack<R>], &mut [Pack<R>]),
    ) {
        let Self { fft, projection, spectra: [x_hat, y_hat, scalar_hat], scratch, blocks, .. } = self;
        let (scratch, block) = (&mut scratch[0], &mut blocks[0]);
        fft.forward(&of[0], x_hat, scratch, block);
        fft.forward(&of[1], y_hat, scratch, block);
        write(projection, x_hat, y_hat, scalar_hat);
        fft.inverse(scalar_hat, scalar, scratch, block);
    }
}

impl<R: Real> Transforms<R, 2> for PlaneTransforms<R> {
    fn new(grid: &Grid<2>, damping: Damping, threads: usize) -> Self {
        let mut projection = Projection::new(grid, damping);
        let threads = worth::<R>(threads, grid.len());
        let fft = Fft2::new(grid.cells[0], grid.cells[1], projection.modes());
        projection.set_gains(&fft.gains());
        Self {
            grid: *grid,
            projection,
            spectra: [fft.spectrum(), fft.spectrum(), fft.spectrum()],
            scratch: (0..threads).map(|_| fft.scratch()).collect(),
            blocks: (0..threads).map(|_| fft.y.block()).collect(),
            fft,
        }
    }

    fn threads(&self) -> usize {
        self.scratch.len()
    }

    fn solve(
        &mut self,
        team: &ThreadTeam,
        implicit: &Implicit<2>,
        w: &[Field<R>; 2],
        flow: &mut Flow<R, 2>,
        timer: &mut PhaseTimer,
        meanwhile: impl FnOnce() + Send,
    ) -> f64 {
        let solve = |projection: &Projection<R>, row: usize, (), spectra: [&mut [Pack<R>]; 3]| {
            projection.project(implicit, row, spectra);
        };
        let bound = self.solve_rows(team, w, repeat(()), solve, timer, meanwhile);
        write_within(bound, implicit.limit, flow, |flow| self.write(team, flow, timer))
    }

    fn pressure(&mut self, w: &[Field<R>; 2], inv_tau: f64, cfl: f64, pressure: &mut [R]) {
        self.scalar(w, pressure, |projection, wx, wy, pi| projection.pressure(wx, wy, inv_tau, cfl, pi));
    }

    fn divergence(&mut self, velocity: &[Field<R>; 2], divergence: &mut [R]) {
        self.scalar(velocity, divergence, |projection, u, v, divergence| projection.divergence(u, v, divergence));
    }
}
