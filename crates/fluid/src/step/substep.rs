//! One step of the fluid's own.

use line_fft::ThreadTeam;

use crate::bodies::{Bodies, Placement, Pose};
use crate::error::Error;
use crate::present::Present;
use crate::space::Space;
use contact::Stations;

/// One step of the fluid's own.
#[derive(Clone, Copy)]
pub struct Substep<'a, const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Length, s.
    pub dt: f64,
    /// Time at the end, s.
    pub end: f64,
    /// Stations of the flexible bodies at the end.
    pub stations: &'a [Stations<D>],
    /// Displacements at the end of the bodies that the master or the fluid moves, perhaps from a release on; predicted
    /// where the fluid moves them or announces their loads.
    pub displacements: &'a [Pose<D>],
    /// Displacements at the end of the bodies that the master moves.
    pub ends: &'a [Pose<D>],
    /// Predicted stations after the end, if loads are predicted after this step.
    pub ahead: Option<&'a [Stations<D>]>,
    /// Largest CFL number.
    pub max_cfl: f64,
    /// Shortest step that the flow at the end may require, s.
    pub shortest: f64,
    /// Threads.
    pub team: &'a ThreadTeam,
}

impl<'a, const D: usize> Substep<'a, D>
where
    [f64; D]: Space<D>,
{
    /// Return where the bodies are put at the end, the flexible ones from the stations `before`.
    pub fn placement(&self, before: &'a [Stations<D>]) -> Placement<'a, D> {
        let &Self { end: time, stations, displacements, .. } = self;
        Placement { time, displacements, stations, before }
    }

    /// Return the largest advection rate that the flow at the end may have, 1/s.
    pub fn limit(&self) -> f64 {
        self.max_cfl / self.shortest
    }

    /// Refuse a flow with an advection rate (1/s) above the limit, or that is not a number.
    pub fn check(&self, advection_rate: f64) -> Result<(), Error> {
        if advection_rate <= self.limit() {
            return Ok(());
        }
        let (needed, shortest) = (self.max_cfl / advection_rate, self.shortest);
        Err(Error::Diverged { time: self.end, needed, shortest })
    }

    /// Make the end of the step, which has the coefficients `c` of the backward differences, the present time.
    pub fn commit(&self, c: [f64; 3], present: &mut Present<D>, bodies: &mut Bodies<D>, advection_rate: f64) {
        (present.time, present.step, present.advection_rate) = (self.end, self.dt, advection_rate);
        bodies.commit(self.displacements, self.dt, c, &mut present.histories);
        Stations::copy_all(&mut present.flexible.stations, self.stations);
    }
}
