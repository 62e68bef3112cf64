//! What a step takes over from its trial.
//!
//! Before a step the body that carries a wing asks for the reaction to a root that keeps its accelerations
//! ([`Wing::root_response`](crate::Wing::root_response)). The root then ends at a place that differs little. So Newton's
//! method starts from the end of the trial, moved with the root, and from the factors there. Directors of veins depend on
//! the way of the iteration, so a wing that has them starts from its usual guess. A trial serves the next step alone, of
//! the same length and under the same loads; a wing that is restored or placed forgets it.

use structure::{Core, Loads};

use crate::base::{Memory, RigidMotion};
use crate::geometry::Vector;

/// Relative difference of two lengths of a step that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// End of the last trial.
pub(crate) struct Trial {
    /// Whether the wing is as before the trial.
    is_fresh: bool,
    /// Whether the present step starts from the trial.
    pub(crate) serves: bool,
    /// Length of the step, s.
    duration: f64,
    loads: Loads,
    /// Positions at the end, m: `[nodes]`.
    positions: Vec<Vector>,
    base: RigidMotion,
}

impl Trial {
    /// Return a trial of a wing in this state that serves no step.
    pub(crate) fn none(core: &Core<3, Memory>) -> Self {
        Self {
            is_fresh: false,
            serves: false,
            duration: 0.0,
            loads: Loads::default(),
            positions: core.rest.clone(),
            base: core.state.own.base,
        }
    }

    /// Forget the trial.
    pub(crate) fn forget(&mut self) {
        (self.is_fresh, self.serves) = (false, false);
    }

    /// Keep the state after a step under `loads` that is about to be taken back.
    pub(crate) fn keep(&mut self, core: &Core<3, Memory>, loads: &Loads) {
        // A step in parts ends with another matrix.
        self.is_fresh = core.statistics.substeps == 1;
        self.duration = core.state.last_step;
        self.loads.copy_from(loads);
        self.positions.copy_from_slice(&core.state.positions);
        self.base = core.state.own.base;
    }

    /// Begin a step of `duration`, s, under `loads`; return whether it starts from the trial.
    pub(crate) fn begin(&mut self, duration: f64, loads: &Loads) -> bool {
        let is_as_long = (duration - self.duration).abs() <= ROUNDING * duration;
        self.serves = self.is_fresh && is_as_long && *loads == self.loads;
        self.is_fresh = false;
        self.serves
    }

    /// Move the first guess of a stage to the end of the trial, moved with the base about `origin` to `base`.
    pub(crate) fn guess(&self, base: &RigidMotion, origin: Vector, core: &mut Core<3, Memory>) {
        let rotation = base.matrix() * self.base.matrix().transpose();
        let [from, to] = [&self.base, base].map(|base| origin + Vector::from(base.displacement));
        for (k, guess) in core.guess.iter_mut().enumerate().filter(|(k, _)| !core.held[*k]) {
            *guess = to + rotation * (self.positions[k] - from);
        }
    }
}
