//! The time schemes. Each makes the next flow where no present one stands, and takes it over only if it is one.

mod rk2;
mod sbdf2;

use std::mem::take;

use scene::TimeScheme;

use crate::bodies::Stations;
use crate::domain::Domain;
use crate::error::Error;
use crate::state::{Memory, Present};
use line_fft::Real;
use line_fft::Team;

use rk2::Rk2;
use sbdf2::Sbdf2;

/// A time scheme with what it remembers of earlier steps.
pub enum Scheme<R: Real> {
    /// Two-step backward differences.
    Sbdf2(Sbdf2<R>),
    /// Heun's method.
    Rk2(Rk2<R>),
}

/// One step of the fluid's own.
#[derive(Clone, Copy)]
pub struct Step<'a> {
    /// Its length, s.
    pub dt: f64,
    /// Its end, s.
    pub end: f64,
    /// Stations of the beams at its end.
    pub stations: &'a [Stations],
    /// Where they go on to, if loads are predicted after it.
    pub ahead: Option<&'a [Stations]>,
    /// Largest CFL number.
    pub max_cfl: f64,
    /// The shortest step that the flow at its end may ask for, s.
    pub shortest: f64,
    /// Who makes it.
    pub team: &'a Team,
}

impl Step<'_> {
    /// Whether a flow with an advection rate (1/s) at the end is one.
    fn check(&self, advection_rate: f64) -> Result<(), Error> {
        let (needed, shortest) = (self.max_cfl / advection_rate, self.shortest);
        // Not a number is no step either.
        if needed >= shortest { Ok(()) } else { Err(Error::Diverged { time: self.end, needed, shortest }) }
    }

    /// Take the time and the stations of the end over.
    fn finish<R: Real>(&self, present: &mut Present<R>, advection_rate: f64) {
        (present.time, present.step, present.advection_rate) = (self.end, self.dt, advection_rate);
        Stations::copy_all(&mut present.beams.stations, self.stations);
    }
}

impl<R: Real> Scheme<R> {
    /// A scheme at the beginning, from a uniform velocity (m/s).
    pub fn new(scheme: TimeScheme, velocity: [f64; 2], domain: &Domain<R>) -> Self {
        match scheme {
            TimeScheme::Sbdf2 => Self::Sbdf2(Sbdf2::new(domain)),
            TimeScheme::Rk2 => Self::Rk2(Rk2::new(velocity, domain)),
        }
    }

    /// What the scheme remembers.
    pub fn memory(&self) -> Memory<R> {
        match self {
            Self::Sbdf2(scheme) => Memory::Sbdf2(scheme.memory.clone()),
            Self::Rk2(scheme) => Memory::Rk2(scheme.u_hat.clone()),
        }
    }

    /// Whether `memory` is of this scheme and size, and its numbers are finite.
    pub fn fits(&self, memory: &Memory<R>) -> bool {
        match (self, memory) {
            (Self::Sbdf2(scheme), Memory::Sbdf2(memory)) => {
                memory.has_shape_of(&scheme.memory) && memory.per_tau.is_finite()
            }
            (Self::Rk2(scheme), Memory::Rk2(u_hat)) => {
                u_hat.iter().zip(&scheme.u_hat).all(|(theirs, own)| theirs.len() == own.len())
            }
            _ => false,
        }
    }

    /// Copy what the scheme remembers into `memory`, which is of the same shape; allocates nothing.
    pub fn save(&self, memory: &mut Memory<R>) {
        match (self, memory) {
            (Self::Sbdf2(scheme), Memory::Sbdf2(memory)) => memory.copy_from(&scheme.memory),
            (Self::Rk2(scheme), Memory::Rk2(u_hat)) => copy(u_hat, &scheme.u_hat),
            _ => {}
        }
    }

    /// The way back from [`Self::save`].
    pub fn restore(&mut self, memory: &Memory<R>) {
        match (self, memory) {
            (Self::Sbdf2(scheme), Memory::Sbdf2(memory)) => scheme.memory.copy_from(memory),
            (Self::Rk2(scheme), Memory::Rk2(u_hat)) => copy(&mut scheme.u_hat, u_hat),
            _ => {}
        }
    }

    /// Longest step that the scheme can make through the bodies, s; none where it has no limit.
    pub fn longest_step(&self, domain: &Domain<R>) -> Option<f64> {
        match self {
            Self::Sbdf2(_) => None,
            Self::Rk2(_) => Some(rk2::longest_step(&domain.bodies)),
        }
    }

    /// Start from the part without divergence of the velocity in `domain.w`.
    pub fn start(&mut self, present: &mut Present<R>, domain: &mut Domain<R>) {
        present.step = 0.0;
        match self {
            Self::Sbdf2(scheme) => scheme.start(present, domain),
            Self::Rk2(scheme) => scheme.start(present, domain),
        }
    }

    /// Make a step. On an error everything is as before but the bodies, which are where the step would have ended.
    pub fn step(&mut self, step: Step, present: &mut Present<R>, domain: &mut Domain<R>) -> Result<(), Error> {
        match self {
            Self::Sbdf2(scheme) => scheme.step(step, present, domain),
            Self::Rk2(scheme) => scheme.step(step, present, domain),
        }
    }

    /// Loads on the stations in the coming step of the same size, were they to keep their velocities, with which they
    /// get to the `ahead` of the last step.
    ///
    /// The mask is put there for it. With the mask where it is, the loads would be late by the way of a step, and the
    /// exchange would feed the rod.
    pub fn predict_loads(&self, present: &mut Present<R>, domain: &mut Domain<R>) {
        if present.beams.loads.is_empty() {
            return;
        }
        let mut loads = take(&mut present.beams.loads);
        match self {
            Self::Sbdf2(scheme) => {
                domain.bodies.go_ahead();
                scheme.predict_loads(present, &mut domain.bodies, &mut loads);
            }
            // Its explicit drag is that of the mask where it is at the beginning of the step.
            Self::Rk2(_) => rk2::predict_loads(present, &mut domain.bodies, &mut loads),
        }
        present.beams.loads = loads;
    }

    /// Pi at the present time (m²/s²) into `domain.w[0]`: what makes the rate of change free of divergence.
    pub fn make_total_pressure(&self, present: &Present<R>, domain: &mut Domain<R>) {
        let cfl = present.advection_rate * present.step;
        match self {
            Self::Sbdf2(scheme) => domain.spectral.solve_for_pressure(&scheme.memory.w, scheme.memory.per_tau, cfl),
            Self::Rk2(_) => {
                // The velocity itself has no divergence.
                rk2::add_rate_of_change(present.time, &present.flow, 1.0, domain);
                domain.spectral.solve_for_pressure(&domain.w, 1.0, cfl);
            }
        }
        domain.spectral.pressure(&mut domain.w[0]);
    }
}

fn copy<T: Copy>(to: &mut [Vec<T>; 2], from: &[Vec<T>; 2]) {
    to.iter_mut().zip(from).for_each(|(to, from)| to.copy_from_slice(from));
}
