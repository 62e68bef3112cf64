//! A step in space: two-step backward differences with extrapolated advection, as in two dimensions
//! (`step/sbdf2.rs` has the equations). It takes nine real transforms: three forward and six inverse.

use std::mem::swap;
use std::ops::Range;

use line_fft::{Arithmetic, F64_LANES, Kernel, Real, Team, from_f64s, nothing, run, to_f64s};

use super::flow::{Flow, Memory};
use super::projection::Implicit;
use super::spectral::Spectral;
use crate::field::Field;
use crate::step::Differences;

/// The flow with the work space of a step, in one precision.
pub struct Solver<R: Real> {
    /// The flow and the memory of the scheme.
    pub memory: Memory<R>,
    /// Transforms.
    pub spectral: Spectral<R>,
    /// `w` of the step in work; nothing in it has a meaning between steps.
    pub w: [Field<R>; 3],
    plane: usize,
}

impl<R: Real> Solver<R> {
    /// A solver that begins with a uniform velocity (m/s) at `points` points, of which a plane of x has `plane`.
    pub fn new(velocity: [f64; 3], spectral: Spectral<R>, points: usize, plane: usize) -> Self {
        let w = [(); 3].map(|()| Field::uniform(R::zero(), points));
        Self { memory: Memory::uniform(velocity, points), spectral, w, plane }
    }

    /// Start from the velocity in `w`, and return the advection rate, 1/s. A step of no length leaves the projection of
    /// the solve wave by wave.
    pub fn start(&mut self, mean: Option<[f64; 3]>) -> f64 {
        let implicit = Implicit { tau_nu: 0.0, cfl: 0.0, mean };
        let rate = self.spectral.solve(&Team::alone(), &implicit, &self.w, &mut self.memory.before);
        self.take_over(0.0);
        rate
    }

    /// Write u* + tau G without the velocities of the bodies to `w`, with their drag rate `rate` (1/s).
    pub fn solve_locally(&mut self, team: &Team, scheme: &Differences, rate: Option<&[f64]>) {
        let (memory, plane) = (&self.memory, self.plane);
        let [x, y, z] = self.w.each_mut().map(|w| w.chunks_mut(plane));
        let parts = x.zip(y).zip(z).enumerate();
        team.share(nothing, parts, |(i, ((wx, wy), wz))| {
            let points = i * plane..(i + 1) * plane;
            let rate = rate.map(|rate| &rate[points.clone()]);
            run(LocalSolve { known: Known::of(memory, points), scheme, rate, w: [wx, wy, wz] });
        });
    }

    /// Return the velocity (m/s) at a grid point, extrapolated to the end of the step.
    pub fn extrapolated(&self, &Differences { e, .. }: &Differences) -> impl Fn(usize) -> [f64; 3] {
        let Memory { flow, before, .. } = &self.memory;
        move |point| {
            let (now, before) = (flow.velocity_at(point), before.velocity_at(point));
            [0, 1, 2].map(|axis| e[0] * now[axis] + e[1] * before[axis])
        }
    }

    /// Return the right-hand side of the local solve without the bodies (m/s²) at a grid point.
    pub fn right_side<'a>(&'a self, scheme: &'a Differences) -> impl Fn(usize) -> [f64; 3] + 'a {
        let known = Known::of(&self.memory, 0..self.w[0].len());
        move |point| known.right_side(scheme, point).map(|(r, _)| r)
    }

    /// Solve wave by wave for `w`, and return the advection rate of the new flow, 1/s. It takes the place of the flow
    /// before the present one until [`Self::take_over`].
    pub fn solve_wave_by_wave(&mut self, team: &Team, implicit: &Implicit) -> f64 {
        self.spectral.solve(team, implicit, &self.w, &mut self.memory.before)
    }

    /// Make the new flow the present one, the present one the previous, and keep w of a step with `inv_tau` (1/s).
    pub fn take_over(&mut self, inv_tau: f64) {
        let Memory { flow, before, w, .. } = &mut self.memory;
        swap(flow, before);
        swap(w, &mut self.w);
        self.memory.inv_tau = inv_tau;
    }
}

/// What the local solve reads.
struct Known<'a, R> {
    velocity: [&'a [R]; 3],
    vorticity: [&'a [R]; 3],
    /// Velocity and vorticity one step earlier.
    velocity_before: [&'a [R]; 3],
    vorticity_before: [&'a [R]; 3],
    /// `w = u + tau G` of the last step.
    w: [&'a [R]; 3],
    /// `1/tau` of the last step.
    inv_tau: f64,
}

impl<'a, R: Real> Known<'a, R> {
    fn of(memory: &'a Memory<R>, points: Range<usize>) -> Self {
        let part = |fields: &'a [Field<R>; 3]| fields.each_ref().map(|field| &field[points.clone()]);
        let Memory { flow, before, w, inv_tau } = memory;
        let parts = |flow: &'a Flow<R>| (part(&flow.velocity), part(&flow.vorticity));
        let ((velocity, vorticity), (velocity_before, vorticity_before)) = (parts(flow), parts(before));
        Self { velocity, vorticity, velocity_before, vorticity_before, w: part(w), inv_tau: *inv_tau }
    }

    /// Return the components of `c_1 u^n + c_2 u^{n−1} − e_1 N^n − e_2 N^{n−1} − G^n` and of G^n at point `i`.
    fn right_side(&self, &Differences { c, e, .. }: &Differences, i: usize) -> [(f64, f64); 3] {
        let at = |fields: &[&[R]; 3]| fields.map(|field| field[i].to_f64());
        let [u, omega, w] = [&self.velocity, &self.vorticity, &self.w].map(at);
        let [u_before, omega_before] = [&self.velocity_before, &self.vorticity_before].map(at);
        [0, 1, 2].map(|a| {
            let (b, d) = ((a + 1) % 3, (a + 2) % 3);
            let n = omega[b] * u[d] - omega[d] * u[b];
            let n_before = omega_before[b] * u_before[d] - omega_before[d] * u_before[b];
            let g = self.inv_tau * (w[a] - u[a]);
            (c[1] * u[a] + c[2] * u_before[a] - e[0] * n - e[1] * n_before - g, g)
        })
    }

    /// Return u* + tau G at point `i` without the velocities of the bodies, with their drag rate `rate` (1/s).
    fn solve(&self, scheme: &Differences, rate: f64, i: usize) -> [R; 3] {
        self.right_side(scheme, i).map(|(r, g)| R::rounded(r / (scheme.c[0] + rate) + scheme.tau * g))
    }
}

/// [`Known::solve`] at all points. Eighteen arrays are read and written at once, which takes most of the time.
struct LocalSolve<'a, R> {
    known: Known<'a, R>,
    scheme: &'a Differences,
    rate: Option<&'a [f64]>,
    w: [&'a mut [R]; 3],
}

impl<'a, R: Real> Kernel for LocalSolve<'a, R> {
    type Real = f64;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<f64>) {
        let Self { known, scheme, rate, w: [wx, wy, wz] } = self;
        let ([c_0, c_1, c_2], [e_1, e_2]) = (scheme.c.map(f64::splat), scheme.e.map(f64::splat));
        let [tau, inv_tau, one] = [scheme.tau, known.inv_tau, 1.0].map(f64::splat);
        let vectors = wx.len() / F64_LANES;
        let whole = |field: &'a [R]| &field.as_chunks::<F64_LANES>().0[..vectors];
        let (velocity, vorticity, last) = (known.velocity.map(whole), known.vorticity.map(whole), known.w.map(whole));
        let (velocity_before, vorticity_before) = (known.velocity_before.map(whole), known.vorticity_before.map(whole));
        let rates = rate.map(|rate| &rate.as_chunks::<F64_LANES>().0[..vectors]);
        let new = [&mut *wx, &mut *wy, &mut *wz].map(|w| &mut w.as_chunks_mut::<F64_LANES>().0[..vectors]);
        for i in 0..vectors {
            let (mut u, mut omega, mut u_before, mut omega_before) = ([one; 3], [one; 3], [one; 3], [one; 3]);
            for a in 0..3 {
                (u[a], omega[a]) = (to_f64s(&velocity[a][i]), to_f64s(&vorticity[a][i]));
                (u_before[a], omega_before[a]) = (to_f64s(&velocity_before[a][i]), to_f64s(&vorticity_before[a][i]));
            }
            let share = rates.map_or(tau, |rates| on.div(one, on.add(c_0, to_f64s(&rates[i]))));
            for a in 0..3 {
                let (b, d) = ((a + 1) % 3, (a + 2) % 3);
                let n = on.mul_sub(omega[d], u[b], on.mul(omega[b], u[d]));
                let n_before = on.mul_sub(omega_before[d], u_before[b], on.mul(omega_before[b], u_before[d]));
                let r = on.mul_add(c_2, u_before[a], on.mul(c_1, u[a]));
                let r = on.mul_sub(e_2, n_before, on.mul_sub(e_1, n, r));
                let g = on.mul(inv_tau, on.sub(to_f64s(&last[a][i]), u[a]));
                new[a][i] = from_f64s(on.mul_add(on.sub(r, g), share, on.mul(tau, g)));
            }
        }
        for i in vectors * F64_LANES..wx.len() {
            [wx[i], wy[i], wz[i]] = known.solve(scheme, rate.map_or(0.0, |rate| rate[i]), i);
        }
    }
}
