//! The fluid of a scene, in the precision that the scene asks for: what can be set and read is the same in both.

use std::borrow::Cow;

use scene::{Precision, Scene};
use serde::{Deserialize, Serialize};

use crate::bodies::{Loads, Pose, Stations};
use crate::error::Error;
use crate::fluid::FluidIn;
use crate::force::{Exchange, Force};
use crate::grid::Grid;
use crate::state::State;

/// One of two, by the precision of the fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ByPrecision<D, S> {
    /// Double precision.
    Double(D),
    /// Single precision.
    Single(S),
}

use ByPrecision::{Double, Single};

/// A fluid with the bodies of a scene in it.
///
/// In single precision its fields and transforms are of `f32`. All that is set and read is of `f64` in both.
pub struct Fluid(ByPrecision<FluidIn<f64>, FluidIn<f32>>);

/// The same in both precisions.
macro_rules! in_either {
    ($by_precision:expr, $fluid:ident => $value:expr) => {
        match $by_precision {
            Double($fluid) => $value,
            Single($fluid) => $value,
        }
    };
}

impl Fluid {
    /// The fluid of a scene at t = 0.
    pub fn new(scene: &Scene) -> Result<Self, Error> {
        let fluid = scene.fluid.as_ref().ok_or_else(|| Error::NoFluid(scene.name.clone()))?;
        Ok(Self(match fluid.precision {
            Precision::Double => Double(FluidIn::new(scene, fluid)),
            Precision::Single => Single(FluidIn::new(scene, fluid)),
        }))
    }

    /// Memory that the fluid of a scene takes, about, bytes; 0 without a fluid.
    pub fn bytes(scene: &Scene) -> usize {
        scene.fluid.as_ref().map_or(0, |fluid| match fluid.precision {
            Precision::Double => FluidIn::<f64>::bytes(scene, fluid),
            Precision::Single => FluidIn::<f32>::bytes(scene, fluid),
        })
    }

    /// Memory that a state takes, about, bytes.
    pub fn state_bytes(&self) -> usize {
        in_either!(&self.0, fluid => fluid.state_bytes())
    }

    /// Start anew from a velocity field (m/s at a point in m), of which the divergence-free part is taken.
    pub fn set_velocity(&mut self, velocity: impl Fn(f64, f64) -> [f64; 2]) {
        in_either!(&mut self.0, fluid => fluid.set_velocity(velocity));
    }

    /// Advance from `t` to `t + h` (s); the stations go from where they are to where they were set.
    ///
    /// The steps are equal, but those that are left are divided anew where the flow has become too fast for them on the
    /// way. Refuses what would take more than a hundred times as many as usual. An error leaves everything as it was;
    /// only after [`Error::Loads`] a state has to be put back.
    pub fn advance(&mut self, t: f64, h: f64) -> Result<(), Error> {
        in_either!(&mut self.0, fluid => fluid.advance(t, h))
    }

    /// A copy of everything that the next step depends on.
    pub fn state(&self) -> State {
        State(match &self.0 {
            Double(fluid) => Double(fluid.state()),
            Single(fluid) => Single(fluid.state()),
        })
    }

    /// Go back (or on) to a state of this scene; a state that is refused changes nothing.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        match (&mut self.0, &state.0) {
            (Double(fluid), Double(state)) => fluid.restore(state),
            (Single(fluid), Single(state)) => fluid.restore(state),
            (Double(_), Single(_)) => Err(Error::Precision { state: "single", own: "double" }),
            (Single(_), Double(_)) => Err(Error::Precision { state: "double", own: "single" }),
        }
    }

    /// The grid.
    pub fn grid(&self) -> &Grid {
        in_either!(&self.0, fluid => fluid.grid())
    }

    /// Time, s.
    pub fn time(&self) -> f64 {
        in_either!(&self.0, fluid => fluid.time())
    }

    /// Velocity component (0: x, 1: y), m/s, `[nx, ny]`; in single precision a copy.
    pub fn velocity(&self, axis: usize) -> Cow<'_, [f64]> {
        in_either!(&self.0, fluid => fluid.velocity(axis))
    }

    /// Vorticity, 1/s, `[nx, ny]`; in single precision a copy.
    pub fn vorticity(&self) -> Cow<'_, [f64]> {
        in_either!(&self.0, fluid => fluid.vorticity())
    }

    /// Static pressure p = rho (Pi − u²/2), Pa, `[nx, ny]`; Pi has zero mean over the box.
    pub fn pressure(&mut self) -> Vec<f64> {
        in_either!(&mut self.0, fluid => fluid.pressure())
    }

    /// Velocity at a probe, numbered from 0 as in the scene, m/s.
    pub fn probe_velocity(&self, probe: usize) -> [f64; 2] {
        in_either!(&self.0, fluid => fluid.probe_velocity(probe))
    }

    /// Static pressure at a probe, Pa. The first after a step costs three transforms.
    pub fn probe_pressure(&mut self, probe: usize) -> f64 {
        in_either!(&mut self.0, fluid => fluid.probe_pressure(probe))
    }

    /// Largest divergence of the velocity times the cell size over the largest speed; three transforms.
    pub fn divergence(&mut self) -> f64 {
        in_either!(&mut self.0, fluid => fluid.divergence())
    }

    /// CFL number max(|u|/dx + |v|/dy) dt of the last step.
    pub fn cfl(&self) -> f64 {
        in_either!(&self.0, fluid => fluid.cfl())
    }

    /// Flow rate through the column in the middle of the box, m²/s.
    pub fn flow_rate(&self) -> f64 {
        in_either!(&self.0, fluid => fluid.flow_rate())
    }

    /// Kinetic energy of the whole box, J/m.
    pub fn kinetic_energy(&self) -> f64 {
        in_either!(&self.0, fluid => fluid.kinetic_energy())
    }

    /// Half the integral of the squared vorticity over the whole box, m²/s².
    pub fn enstrophy(&self) -> f64 {
        in_either!(&self.0, fluid => fluid.enstrophy())
    }

    /// Force of the fluid on all bodies in the last step, N per metre of depth.
    pub fn force(&self) -> [f64; 2] {
        in_either!(&self.0, fluid => fluid.force())
    }

    /// Force of the fluid on a cylinder, numbered from 0, in the last step.
    pub fn force_on_cylinder(&self, cylinder: usize) -> Force {
        in_either!(&self.0, fluid => fluid.force_on_cylinder(cylinder))
    }

    /// Force of the fluid on a body of `fluid.bodies`, numbered from 0, in the last step.
    pub fn force_on_body(&self, body: usize) -> Force {
        in_either!(&self.0, fluid => fluid.force_on_body(body))
    }

    /// Power of that force at the end of the step, W per metre of depth.
    pub fn power_on_body(&self, body: usize) -> f64 {
        in_either!(&self.0, fluid => fluid.power_on_body(body))
    }

    /// Where a body of `fluid.bodies` is, and how it moves.
    pub fn pose(&self, body: usize) -> Pose {
        in_either!(&self.0, fluid => fluid.pose(body))
    }

    /// Force of the fluid on a beam, numbered from 0, in the last step.
    pub fn force_on_beam(&self, beam: usize) -> Force {
        in_either!(&self.0, fluid => fluid.force_on_beam(beam))
    }

    /// What the fluid did to each beam, without the unsteady term of [`Self::force_on_beam`].
    pub fn exchange(&self) -> &[Exchange] {
        in_either!(&self.0, fluid => fluid.exchange())
    }

    /// Loads on the stations of each beam for the coming step; empty where the scene uses the pressure jump.
    pub fn loads(&self) -> &[Loads] {
        in_either!(&self.0, fluid => fluid.loads())
    }

    /// Stations of each beam at the end of the coming step.
    pub fn stations(&self) -> &[Stations] {
        in_either!(&self.0, fluid => fluid.stations())
    }

    /// Stations of each beam at the end of the coming step, to be set before [`Self::advance`].
    pub fn stations_mut(&mut self) -> &mut [Stations] {
        in_either!(&mut self.0, fluid => fluid.stations_mut())
    }

    /// Pressure jump p_above − p_below at the stations of each beam, Pa; made when first asked for after a step.
    pub fn pressure_jump(&mut self) -> &[Vec<f64>] {
        in_either!(&mut self.0, fluid => fluid.pressure_jump())
    }

    /// Pressure around the stations of each beam, the mean of that above and below, less the mean over the outlet, Pa; made when
    /// first asked for after a step. Empty where the scene does not want its level.
    pub fn pressure_around(&mut self) -> &[Vec<f64>] {
        in_either!(&mut self.0, fluid => fluid.pressure_around())
    }

    /// Times the phases of a step.
    #[cfg(feature = "internals")]
    pub fn clock(&mut self) -> &mut crate::clock::Clock {
        in_either!(&mut self.0, fluid => fluid.clock())
    }
}
