//! One step of the fluid's own.

use line_fft::Team;

use crate::bodies::{Bodies, Pose, Stations};
use crate::error::Error;
use crate::present::Present;

/// One step of the fluid's own.
#[derive(Clone, Copy)]
pub struct Substep<'a> {
    /// Length, s.
    pub dt: f64,
    /// Time at the end, s.
    pub end: f64,
    /// Stations of the beams at the end.
    pub stations: &'a [Stations],
    /// Places at the end, from rest, of the bodies that laws do not move; predicted where the fluid moves them.
    pub displacements: &'a [Pose],
    /// Predicted stations after the end, if loads are predicted after this step.
    pub ahead: Option<&'a [Stations]>,
    /// Largest CFL number.
    pub max_cfl: f64,
    /// Shortest step that the flow at the end may require, s.
    pub shortest: f64,
    /// Threads.
    pub team: &'a Team,
}

impl Substep<'_> {
    /// Refuse a flow with an advection rate (1/s) that requires too short a step, or is not a number.
    pub fn check(&self, advection_rate: f64) -> Result<(), Error> {
        let (needed, shortest) = (self.max_cfl / advection_rate, self.shortest);
        if needed >= shortest { Ok(()) } else { Err(Error::Diverged { time: self.end, needed, shortest }) }
    }

    /// Make the end of the step the present time.
    pub fn finish(&self, present: &mut Present, bodies: &mut Bodies, advection_rate: f64) {
        (present.time, present.step, present.advection_rate) = (self.end, self.dt, advection_rate);
        bodies.settle(self.displacements, &mut present.carried);
        Stations::copy_all(&mut present.beams.stations, self.stations);
    }
}
