//! The part of a step that is solved in Fourier space: from a velocity to a flow without divergence, and to the
//! pressure.
//!
//! The plane and space differ in the order of their transforms, which a step depends on, so each has its own.

pub mod plane;
mod plane_projection;
mod volume;
mod volume_projection;

use std::sync::{Mutex, PoisonError};

use line_fft::{Arithmetic, Kernel, Pack, Real, ThreadTeam, run};

use crate::field::{Field, is_available};
use crate::filter::Damping;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::timer::PhaseTimer;

pub use plane::PlaneTransforms;
#[cfg(feature = "internals")]
pub use plane_projection::Projection;
pub use volume::VolumeTransforms;

/// Least bytes of a field for each thread. With a team on a busy machine, two threads with 94 kB each made a step of
/// FSI3 longer by a quarter; on two idle cores, with 280 kB each, they made a run shorter by a seventh.
const LEAST_BYTES_PER_THREAD: usize = 250_000;

/// Most numbers in the lanes of a pack.
const MOST_LANES: usize = 8;

/// Coefficients of the solve in Fourier space in a step.
#[derive(Clone, Copy, Debug)]
pub struct Implicit<const D: usize> {
    /// `tau nu`, m².
    pub tau_nu: f64,
    /// CFL number.
    pub cfl: f64,
    /// Prescribed mean velocity, m/s; absent: free.
    pub mean: Option<[f64; D]>,
    /// Largest advection rate of a flow that is wanted, 1/s.
    pub limit: f64,
}

/// Transforms of one grid, with room for the spectra.
pub trait Transforms<R: Real, const D: usize>: Send {
    /// Plan for a grid, a damping of short waves, and at most `threads` threads.
    fn new(grid: &Grid<D>, damping: Damping, threads: usize) -> Self;

    /// Return the number of threads that share the work.
    fn threads(&self) -> usize;

    /// Solve `(1 − tau nu ∇² + tau r) u + tau ∇Pi = w, ∇·u = 0`, and return the largest `|u|/dx + |v|/dy + …` (1/s) of
    /// the solution. If that is at most the limit the solution is written to `flow`; otherwise it may be NaN, and `flow`
    /// stays as it is. One thread runs `meanwhile` while the helpers begin.
    fn solve(
        &mut self,
        team: &ThreadTeam,
        implicit: &Implicit<D>,
        w: &[Field<R>; D],
        flow: &mut Flow<R, D>,
        timer: &mut PhaseTimer,
        meanwhile: impl FnOnce() + Send,
    ) -> f64;

    /// Write Pi (m²/s²) that belongs to `w` (m/s) of a step with `inv_tau` (1/s) and a CFL number.
    fn pressure(&mut self, w: &[Field<R>; D], inv_tau: f64, cfl: f64, pressure: &mut [R]);

    /// Write the divergence (1/s) of a velocity (m/s).
    fn divergence(&mut self, velocity: &[Field<R>; D], divergence: &mut [R]);
}

/// Return the number of threads, of at most `threads`, that share fields of so many points.
fn worth<R: Real>(threads: usize, points: usize) -> usize {
    threads.min(size_of::<R>() * points / LEAST_BYTES_PER_THREAD).max(1)
}

/// Sum of the moduli of the modes of a line; not a number if one is not finite.
struct Moduli<'a, R: Real> {
    line: &'a [Pack<R>],
    sum: &'a mut f64,
}

impl<R: Real> Kernel for Moduli<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<R>) {
        /// Independent sums: no addition waits for the previous one.
        const SUMS: usize = 4;
        let mut sums = [[R::zero(); MOST_LANES]; SUMS];
        let (quartets, rest) = self.line.as_chunks::<SUMS>();
        for quartet in quartets {
            for (sums, Pack { re, im }) in sums.iter_mut().zip(quartet) {
                for lane in 0..R::LANES {
                    sums[lane] += re[lane].abs() + im[lane].abs();
                }
            }
        }
        for Pack { re, im } in rest {
            (0..R::LANES).for_each(|lane| sums[0][lane] += re[lane].abs() + im[lane].abs());
        }
        *self.sum = sums.as_flattened().iter().map(|sum| sum.to_f64()).sum();
    }
}

/// Return a bound of what the modes of a line add to `|u|/dx + |v|/dy + …`, 1/s, from the lines of all components of the
/// velocity: the moduli, twice for both signs of the wavenumber in the lanes.
fn bound<'a, R: Real>(components: impl Iterator<Item = (&'a [Pack<R>], f64)>) -> f64 {
    let part = |(line, spacing): (&[Pack<R>], f64)| {
        let mut sum = 0.0;
        run(Moduli { line, sum: &mut sum });
        2.0 * sum / spacing
    };
    components.map(part).sum()
}

/// A sum that threads add to, in any order.
#[derive(Default)]
struct SharedSum(Mutex<f64>);

impl SharedSum {
    fn add(&self, part: f64) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) += part;
    }

    fn into_inner(self) -> f64 {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Let `back` write a flow and return its advection rate (1/s), for which `bound` is an upper bound. If that exceeds
/// `limit`, `flow` is written only after the rate is known not to.
fn write_within<R: Real, const D: usize>(
    bound: f64,
    limit: f64,
    flow: &mut Flow<R, D>,
    mut back: impl FnMut(&mut Flow<R, D>) -> f64,
) -> f64 {
    if bound <= limit {
        return back(flow);
    }
    let room = size_of::<R>() * flow.velocity.iter().chain(&flow.vorticity).map(|field| field.len()).sum::<usize>();
    if bound.is_nan() || bound >= R::OVERFLOW_GUARD.to_f64() || !is_available(room) {
        return f64::NAN;
    }
    let mut next = flow.clone();
    let rate = back(&mut next);
    if rate <= limit {
        flow.copy_from(&next);
    }
    rate
}

/// Largest `|u|/dx + |v|/dy + …`, 1/s.
pub struct AdvectionRate<'a, R, const D: usize> {
    /// One over the spacing, 1/m.
    pub inv_spacing: [R; D],
    /// Velocity, m/s.
    pub velocity: [&'a [R]; D],
    /// Where it is written.
    pub largest: &'a mut R,
}

impl<R: Real, const D: usize> Kernel for AdvectionRate<'_, R, D> {
    type Real = R;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<R>) {
        /// Independent maxima: no comparison waits for the previous one.
        const LANES: usize = 8;
        let Self { inv_spacing, velocity, .. } = self;
        let n = velocity[0].len();
        let chunks = velocity.map(|u| &u.as_chunks::<LANES>().0[..n / LANES]);
        let mut largest = [R::zero(); LANES];
        for i in 0..n / LANES {
            let mut rates = [R::zero(); LANES];
            for (chunks, inv_spacing) in chunks.iter().zip(inv_spacing) {
                for (rate, u) in rates.iter_mut().zip(&chunks[i]) {
                    *rate += u.abs() * inv_spacing;
                }
            }
            for (largest, rate) in largest.iter_mut().zip(rates) {
                *largest = if rate > *largest { rate } else { *largest };
            }
        }
        for i in n / LANES * LANES..n {
            let components = velocity.iter().zip(inv_spacing);
            let rate = components.fold(R::zero(), |rate, (u, inv_spacing)| rate + u[i].abs() * inv_spacing);
            largest[0] = if rate > largest[0] { rate } else { largest[0] };
        }
        *self.largest = largest.into_iter().fold(R::zero(), |a, b| if a > b { a } else { b });
    }
}
