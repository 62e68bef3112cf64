//! Equilibrium and stiffness.

use structure::{Balance, Structure, find_equilibrium};

use crate::banded::Banded;
use crate::base_motion::BaseState;
use crate::model::RootSupport;
use crate::newton::Problem;
use crate::{Error, Rod};

impl<const D: usize> Rod<D> {
    /// Move to the equilibrium under the present loads, at rest, as before a first step; ignore the impedance.
    ///
    /// If Newton's method fails, the loads grow in parts ([`structure::find_equilibrium`]). A pressure jump keeps its direction in the present shape.
    ///
    /// # Errors
    /// Newton's method may fail, and a free or sliding rod has no equilibrium. After an error the state is unchanged.
    pub fn solve_static(&mut self) -> Result<(), Error> {
        if self.parameters.support == RootSupport::Free {
            return Err(Error::value("support", "Free", "another support: a free rod has no equilibrium"));
        }
        if self.parameters.slide.is_some() {
            let allowed = "absent: a rod on a slide has no equilibrium";
            return Err(Error::value("slide", format!("{:?}", self.parameters.slide), allowed));
        }
        self.collect_loads()?;
        if self.hinge.is_some() {
            // Without damping the spring is in series with half a segment.
            self.elastic = self.parameters.elastic(self.core.state.own.direction);
        }
        let pressure = self.core.state.own.pressure.clone();
        self.follow_pressure(1.0);
        let settled = find_equilibrium(self).inspect_err(|_| {
            self.core.state.own.pressure = pressure;
            self.align();
        })?;
        self.place_at_rest(BaseState::of(&self.core.state), settled)
    }

    /// Return the stiffness ∂²U/∂x∂x of the present shape, N/m: the components of the first free node first.
    ///
    /// With shear, the unknown moment at the beginning of each segment precedes the components of its end node.
    pub fn stiffness(&mut self) -> Result<Banded, Error> {
        let Self { core, newton, elastic, .. } = self;
        let x = &core.state.positions;
        newton.assemble(Problem { elastic, balance: &Balance::at_rest(x.len()), origin: x }, x)?;
        Ok(newton.matrix.clone())
    }
}
