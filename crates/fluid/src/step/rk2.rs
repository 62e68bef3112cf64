//! Heun's method with the drag explicit and viscosity exact (thesis eq. 3.15 – 3.18, corrected).
//!
//! With `E = exp(−nu k² dt)`, the projection P and the filter F,
//!
//! ```text
//! f(t, u) = −omega × u − Σ a_b (u − u_b(t))                             point by point
//! u_1     = P F E [u^n + dt f(t^n, u^n)]                                in Fourier space
//! u^{n+1} = P F ½ [E u^n + u_1 + dt f(t^{n+1}, u_1)]                    in Fourier space
//! ```
//!
//! with `F = 1/(1 + dt r)`, r being the rate of the filter. This is `E u^n + dt/2 (E k_1 + k_2)`. The spectrum of u^n
//! is kept, so a step takes ten real transforms: twice two forward and three inverse. The explicit drag is stable up to
//! `dt Σ a = 2`; steps are divided to keep it at or below 1.

use std::f64::consts::TAU;
use std::mem::swap;

use line_fft::{Arithmetic, Kernel, Pack, Real, ThreadTeam, nothing, run};

use super::substep::Substep;
use super::{Scheme, StartVelocity, fill};
use crate::bodies::{Bodies, Cell};
use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::grid::Grid;
use crate::present::Present;
use crate::problem::Problem;
use crate::space::Vector;
use crate::spectral::plane::{PlaneTransforms, Projection};
use crate::spectral::{Implicit, Transforms};
use crate::state::Memory;

/// The scheme with its memory, in the plane.
pub struct Rk2<R: Real> {
    transforms: PlaneTransforms<R>,
    /// Velocity that goes into the solve in Fourier space, m/s. Nothing in it has a meaning between steps.
    w: [Field<R>; 2],
    /// Spectrum of the present velocity, m/s, `[rows, nx]` per component.
    u_hat: [Vec<Pack<R>>; 2],
    /// The flow that a step makes, and the spectrum of its velocity.
    next: Flow<R, 2>,
    next_u_hat: [Vec<Pack<R>>; 2],
    decay: Decay,
}

/// Exact decay by viscosity: a factor for each kx and for each ky.
struct Decay {
    kx2: Vec<f64>,
    ky2: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    /// Gains of a round trip of the transforms, which the spectrum of u^n has not made.
    gains: [Vec<f64>; 2],
    /// `nu dt` of the factors, m².
    nu_dt: f64,
}

/// Result of a solve in Fourier space.
#[derive(Clone, Copy, PartialEq)]
enum Stage {
    /// `P F w`, at the start.
    Start,
    /// `P F E w`.
    First,
    /// `P F ½ (E u^n + w)`.
    Second,
}

impl<R: Real> Rk2<R> {
    /// A scheme that begins with a uniform velocity, m/s.
    pub fn new(transforms: PlaneTransforms<R>, velocity: [f64; 2], grid: &Grid<2>) -> Self {
        let spectrum = transforms.spectrum();
        let uniform = |velocity: f64| {
            let mut spectrum = spectrum.clone();
            spectrum[0].re[0] = R::rounded(velocity);
            spectrum
        };
        let decay = Decay::new(grid, transforms.gains());
        let w = [(); 2].map(|()| Field::uniform(R::zero(), grid.len()));
        let next = Flow::uniform([0.0; 2], grid.len());
        Self { transforms, w, u_hat: velocity.map(uniform), next, next_u_hat: [spectrum.clone(), spectrum], decay }
    }

    /// Make the new flow the present one.
    fn take_over(&mut self, flow: &mut Flow<R, 2>) {
        swap(flow, &mut self.next);
        swap(&mut self.u_hat, &mut self.next_u_hat);
    }

    /// Make the flow after a stage from `w` in `next`, and return its advection rate, 1/s; not a number if it is not
    /// finite.
    fn solve_stage(
        &mut self,
        team: &ThreadTeam,
        stage: Stage,
        implicit: &Implicit<2>,
        problem: &mut Problem<2>,
    ) -> f64 {
        let (nx, points) = (problem.grid.cells[0], problem.grid.len() as f64);
        let [u, v] = self.u_hat.each_ref().map(|u_hat| u_hat.chunks_exact(nx));
        let [next_u, next_v] = self.next_u_hat.each_mut().map(|u_hat| u_hat.chunks_exact_mut(nx));
        let rows = u.zip(v).zip(next_u.zip(next_v));
        let decay = &self.decay;
        let solve = |projection: &Projection<R>, row: usize, own: Row<R>, [u, v, omega]: [&mut [Pack<R>]; 3]| {
            let ((u_before, v_before), (u_after, v_after)) = own;
            decay.apply(stage, points, row, u, u_before);
            decay.apply(stage, points, row, v, v_before);
            projection.project(implicit, row, [&mut *u, &mut *v, omega]);
            if stage != Stage::First {
                u_after.copy_from_slice(u);
                v_after.copy_from_slice(v);
            }
        };
        let timer = &mut problem.timer;
        let bound = self.transforms.solve_rows(team, &self.w, rows, solve, timer, nothing);
        if bound < R::OVERFLOW_GUARD.to_f64() { self.transforms.write(team, &mut self.next, timer) } else { f64::NAN }
    }
}

impl<R: Real> Scheme<R, 2> for Rk2<R> {
    fn threads(&self) -> usize {
        self.transforms.threads()
    }

    fn memory(&self) -> Memory<R, 2> {
        Memory::Rk2(self.u_hat.clone())
    }

    fn fits(&self, memory: &Memory<R, 2>) -> bool {
        let same = |u_hat: &[Vec<Pack<R>>; 2]| u_hat.iter().zip(&self.u_hat).all(|(a, b)| a.len() == b.len());
        matches!(memory, Memory::Rk2(u_hat) if same(u_hat))
    }

    fn save(&self, memory: &mut Memory<R, 2>) {
        if let Memory::Rk2(u_hat) = memory {
            copy(u_hat, &self.u_hat);
        }
    }

    fn restore(&mut self, memory: &Memory<R, 2>) {
        if let Memory::Rk2(u_hat) = memory {
            copy(&mut self.u_hat, u_hat);
        }
    }

    fn longest_step(&self, problem: &Problem<2>) -> Option<f64> {
        let stiffest = problem.bodies.rate().into_iter().flatten().fold(0.0_f64, |most, rate| most.max(*rate));
        Some(1.0 / stiffest.max(f64::MIN_POSITIVE))
    }

    fn start(
        &mut self,
        velocity: &StartVelocity<2>,
        flow: &mut Flow<R, 2>,
        present: &mut Present<2>,
        problem: &mut Problem<2>,
    ) {
        fill(&mut self.w, velocity, &problem.grid);
        let limit = f64::INFINITY;
        let implicit = Implicit { tau_nu: 0.0, cfl: 0.0, mean: problem.mean_velocity(present.time), limit };
        present.advection_rate = self.solve_stage(&ThreadTeam::alone(), Stage::Start, &implicit, problem);
        self.take_over(flow);
    }

    fn step(
        &mut self,
        step: &Substep<2>,
        flow: &mut Flow<R, 2>,
        present: &mut Present<2>,
        problem: &mut Problem<2>,
    ) -> Result<(), Error> {
        let mean = problem.mean_velocity(step.end);
        let implicit = Implicit { tau_nu: 0.0, cfl: present.cfl(step.dt), mean, limit: step.limit() };
        self.decay.set_viscosity(step.dt * problem.nu);
        add_rate_of_change(present.time, flow, step.dt, problem, &mut self.w);
        problem.bodies.place(&step.placement(&present.flexible.stations), &problem.grid);
        step.check(self.solve_stage(step.team, Stage::First, &implicit, problem))?;
        add_rate_of_change(step.end, &self.next, step.dt, problem, &mut self.w);
        let advection_rate = self.solve_stage(step.team, Stage::Second, &implicit, problem);
        step.check(advection_rate)?;

        self.take_over(flow);
        problem.bodies.sample(|point| flow.velocity_at(point));
        problem.sum_up_forces(step.dt, |cell| present_drag(flow, cell), step.stations, present);
        step.commit([1.0 / step.dt, 1.0 / step.dt, 0.0], present, &mut problem.bodies, advection_rate);
        Ok(())
    }

    /// Write the present drag on the beams. A change of a body's velocity in the coming step takes the fluid along by
    /// `dt a_b/2`.
    fn predict_loads(&mut self, step: f64, flow: &Flow<R, 2>, present: &mut Present<2>, problem: &mut Problem<2>) {
        let Bodies { beams, cell_mass: weight, .. } = &problem.bodies;
        let drag = |cell: &Cell<2>| {
            let slope = cell.gain.map(|gain| weight * cell.rate * gain * (1.0 - 0.5 * step * cell.rate));
            (present_drag(flow, cell) * *weight, slope)
        };
        beams.iter().for_each(|beam| beam.collect(drag, &mut present.flexible.loads[beam.number]));
    }

    fn total_pressure(&mut self, flow: &Flow<R, 2>, present: &Present<2>, problem: &mut Problem<2>) -> &[R] {
        let Self { transforms, w, next, .. } = self;
        // The velocity in it has no divergence.
        add_rate_of_change(present.time, flow, 1.0, problem, w);
        let pressure = &mut next.vorticity[0];
        transforms.pressure(w, 1.0, present.cfl(present.step), pressure);
        pressure
    }

    fn divergence(&mut self, velocity: &[Field<R>; 2]) -> &[R] {
        self.transforms.divergence(velocity, &mut self.w[0]);
        &self.w[0]
    }
}

fn copy<T: Copy>(to: &mut [Vec<T>; 2], from: &[Vec<T>; 2]) {
    to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
}

/// A row of both components of u^n and of u^{n+1}.
type Row<'a, R> = ((&'a [Pack<R>], &'a [Pack<R>]), (&'a mut [Pack<R>], &'a mut [Pack<R>]));

impl Decay {
    /// Prepare for transforms with these gains.
    fn new(grid: &Grid<2>, gains: [Vec<f64>; 2]) -> Self {
        let modes = gains[1].len();
        let (nx, [length, height]) = (grid.cells[0], grid.size);
        let kx2 = |i: usize| (TAU / length * i.min(nx - i) as f64).powi(2);
        let ky2 = |j: usize| (TAU / height * j as f64).powi(2);
        Self {
            kx2: (0..nx).map(kx2).collect(),
            ky2: (0..modes).map(ky2).collect(),
            x: vec![1.0; nx],
            y: vec![1.0; modes],
            gains,
            nu_dt: 0.0,
        }
    }

    fn set_viscosity(&mut self, nu_dt: f64) {
        if nu_dt == self.nu_dt {
            return;
        }
        self.nu_dt = nu_dt;
        let decay = |k2: f64| (-nu_dt * k2).exp();
        self.x.iter_mut().zip(&self.kx2).for_each(|(x, k2)| *x = decay(*k2));
        self.y.iter_mut().zip(&self.ky2).for_each(|(y, k2)| *y = decay(*k2));
    }

    /// Turn w into what a stage projects, in a row of one component; `before` is the row of u^n over the number of
    /// points.
    fn apply<R: Real>(&self, stage: Stage, points: f64, row: usize, w: &mut [Pack<R>], before: &[Pack<R>]) {
        let [decay_y, gain_y] = [&self.y, &self.gains[1]].map(|of| &of[row * R::LANES..][..R::LANES]);
        for ((w, before), (decay_x, gain_x)) in w.iter_mut().zip(before).zip(self.x.iter().zip(&self.gains[0])) {
            for (lane, (decay_y, gain_y)) in decay_y.iter().zip(gain_y).enumerate() {
                let decay = decay_x * decay_y;
                let (re, im) = (w.re[lane].to_f64(), w.im[lane].to_f64());
                let (re, im) = match stage {
                    Stage::Start => (re, im),
                    Stage::First => (decay * re, decay * im),
                    Stage::Second => {
                        let points = points * gain_x * gain_y;
                        let (re_before, im_before) = (before.re[lane].to_f64(), before.im[lane].to_f64());
                        (0.5 * (re + points * decay * re_before), 0.5 * (im + points * decay * im_before))
                    }
                };
                (w.re[lane], w.im[lane]) = (R::rounded(re), R::rounded(im));
            }
        }
    }
}

/// Write `u + dt f` for a flow at a time (s) to `w`.
fn add_rate_of_change<R: Real>(time: f64, flow: &Flow<R, 2>, dt: f64, problem: &mut Problem<2>, w: &mut [Field<R>; 2]) {
    problem.bodies.sample(|point| flow.velocity_at(point));
    let Flow { velocity: [u, v], vorticity } = flow;
    let omega = &vorticity[0];
    let rate = problem.bodies.rate();
    let [wx, wy] = &mut *w;
    run(Explicit { dt, u, other: v, omega, sign: -1.0, rate, w: wx });
    run(Explicit { dt, u: v, other: u, omega, sign: 1.0, rate, w: wy });
    problem.bodies.add_velocities(time, |_| dt, &problem.grid, w);
}

/// Return the drag of a flow on a cell over the density, `a_b (u − u_b)`, m/s².
fn present_drag<R: Real>(flow: &Flow<R, 2>, cell: &Cell<2>) -> Vector<2> {
    (Vector::from(flow.velocity_at(cell.index)) - cell.velocity) * cell.rate
}

/// `u + dt (−sign omega other − a u)`, with `sign omega other` this component of `omega × u`.
struct Explicit<'a, R> {
    dt: f64,
    u: &'a [R],
    other: &'a [R],
    omega: &'a [R],
    sign: f64,
    rate: Option<&'a [f64]>,
    w: &'a mut [R],
}

impl<R: Real> Kernel for Explicit<'_, R> {
    type Real = R;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<R>) {
        let Self { dt, sign, w, .. } = self;
        let n = w.len();
        let (u, other, omega) = (&self.u[..n], &self.other[..n], &self.omega[..n]);
        match self.rate.map(|rate| &rate[..n]) {
            Some(rate) => {
                for i in 0..n {
                    let u = u[i].to_f64();
                    w[i] = R::rounded(u - dt * (sign * omega[i].to_f64() * other[i].to_f64() + rate[i] * u));
                }
            }
            None => {
                for i in 0..n {
                    w[i] = R::rounded(u[i].to_f64() - dt * (sign * omega[i].to_f64() * other[i].to_f64()));
                }
            }
        }
    }
}
