//! Transforms of a step in space.

use std::array::from_fn;
use std::sync::atomic::{AtomicU64, Ordering};

use line_fft::{Fft3, Pack, Real, ThreadTeam, VolumeScratch, run};

use super::volume_projection::Projection;
use super::{AdvectionRate, Implicit, SharedSum, Transforms, bound, worth, write_within};
use crate::field::Field;
use crate::filter::Damping;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::timer::{Phase, PhaseTimer};

/// Transforms of one grid, with room for the spectra of velocity and vorticity.
pub struct VolumeTransforms<R: Real> {
    spacing: [f64; 3],
    fft: Fft3<R>,
    projection: Projection<R>,
    spectra: [Vec<Pack<R>>; 6],
    /// Scratch space of each thread.
    scratch: Vec<VolumeScratch<R, 6>>,
}

impl<R: Real> VolumeTransforms<R> {
    /// Write the flow of the spectra, and return its largest `|u|/dx + |v|/dy + |w|/dz`, 1/s.
    fn write(&mut self, team: &ThreadTeam, flow: &mut Flow<R, 3>) -> f64 {
        let Self { spacing, fft, spectra, scratch, .. } = self;
        let Flow { velocity: [u, v, w], vorticity } = flow;
        let [ox, oy, oz] = &mut vorticity[..] else { return f64::NAN };
        let fields = [u, v, w, ox, oy, oz].map(|field| &mut **field);
        let inv_spacing = spacing.map(|spacing| R::rounded(1.0 / spacing));
        // Numbers that are not negative have the order of their bits.
        let largest = AtomicU64::new(0);
        fft.inverse(team, spectra.each_ref().map(|spectrum| &**spectrum), fields, scratch, |[u, v, w, ..]| {
            let mut here = R::zero();
            run(AdvectionRate { inv_spacing, velocity: [u, v, w], largest: &mut here });
            largest.fetch_max(here.to_f64().to_bits(), Ordering::Relaxed);
        });
        f64::from_bits(largest.into_inner())
    }

    fn scalar(
        &mut self,
        of: &[Field<R>; 3],
        scalar: &mut [R],
        write: impl Fn(&Projection<R>, usize, usize, &mut [Vec<Pack<R>>; 6]) + Sync,
    ) {
        let Self { fft, projection, spectra, scratch, .. } = self;
        let team = &ThreadTeam::alone();
        fft.forward(team, of.each_ref().map(|field| &**field), spectra, scratch);
        fft.along_x(team, spectra, [0..3, 3..4], scratch, |row, j, lines| write(projection, row, j, lines));
        fft.inverse(team, [&*spectra[3]], [scalar], scratch, |_| ());
    }
}

impl<R: Real> Transforms<R, 3> for VolumeTransforms<R> {
    fn new(grid: &Grid<3>, damping: Damping, threads: usize) -> Self {
        let mut projection = Projection::new(grid, damping);
        let fft = Fft3::new(grid.cells, projection.kept());
        projection.set_gains(&fft.gains());
        Self {
            spacing: grid.spacing,
            spectra: from_fn(|_| fft.spectrum()),
            scratch: (0..worth::<R>(threads, grid.len())).map(|_| fft.scratch()).collect(),
            fft,
            projection,
        }
    }

    fn threads(&self) -> usize {
        self.scratch.len()
    }

    fn solve(
        &mut self,
        team: &ThreadTeam,
        implicit: &Implicit<3>,
        w: &[Field<R>; 3],
        flow: &mut Flow<R, 3>,
        timer: &mut PhaseTimer,
        meanwhile: impl FnOnce() + Send,
    ) -> f64 {
        meanwhile();
        timer.mark(Phase::Loads);
        let Self { spacing, fft, projection, spectra, scratch } = self;
        fft.forward(team, w.each_ref().map(|w| &**w), spectra, scratch);
        timer.mark(Phase::Forward);
        let largest = SharedSum::default();
        fft.along_x(team, spectra, [0..3, 0..6], scratch, |row, j, lines| {
            projection.project(implicit, row, j, lines);
            largest.add(bound(lines[..3].iter().map(|line| &line[..]).zip(*spacing)));
        });
        timer.mark(Phase::Rows);
        let rate = write_within(largest.into_inner(), implicit.limit, flow, |flow| self.write(team, flow));
        timer.mark(Phase::Back);
        rate
    }

    fn pressure(&mut self, w: &[Field<R>; 3], inv_tau: f64, cfl: f64, pressure: &mut [R]) {
        self.scalar(w, pressure, |projection, row, j, lines| projection.pressure(inv_tau, cfl, row, j, lines));
    }

    fn divergence(&mut self, velocity: &[Field<R>; 3], divergence: &mut [R]) {
        self.scalar(velocity, divergence, |projection, row, j, lines| projection.divergence_of_velocity(row, j, lines));
    }
}
