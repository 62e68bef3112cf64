//! Forces on a body: the penalization integral, and the unsteady term of the displaced fluid.

use serde::{Deserialize, Serialize};

/// Force and moment of the fluid on a body in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Force {
    /// Force, N per metre of depth.
    pub force: [f64; 2],
    /// Moment about the pivot of a body or the root of a beam, N m per metre of depth, positive to the left.
    pub moment: f64,
}

impl Force {
    /// Add a force (N/m) that acts at `arm` (m) from the point about which the moment is taken.
    pub fn add(&mut self, [fx, fy]: [f64; 2], arm: [f64; 2]) {
        self.force[0] += fx;
        self.force[1] += fy;
        self.moment += arm[0] * fy - arm[1] * fx;
    }
}

/// Force, power and work of the drag on a beam or a wing; in two dimensions per metre of depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub struct Exchange<const D: usize = 2> {
    /// Sum of the drag in the last step, N.
    pub force: [f64; D],
    /// Power, with the velocity of the sections at the end of the step, W.
    pub power: f64,
    /// Work since the start, J: the sum of power times step.
    pub work: f64,
}

impl<const D: usize> Default for Exchange<D> {
    fn default() -> Self {
        Self { force: [0.0; D], power: 0.0, work: 0.0 }
    }
}

/// The force on a body, and what the next step needs for its unsteady term.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyForce {
    /// Force in the last step.
    pub force: Force,
    /// Displaced fluid at the end of the step.
    pub displaced: Displaced,
}

impl BodyForce {
    /// Become the force of a step of size `dt` (s), from the drag and from the displaced fluid at its end.
    pub fn update(&mut self, drag: Force, displaced: Displaced, dt: f64) {
        self.update_with(drag, displaced.rate_of_change(&self.displaced, dt), displaced);
    }

    /// Become the force of a step from the drag, the unsteady term, and the displaced fluid at its end.
    pub fn update_with(&mut self, drag: Force, unsteady: Force, displaced: Displaced) {
        let force = [0, 1].map(|axis| drag.force[axis] + unsteady.force[axis]);
        *self = Self { force: Force { force, moment: drag.moment + unsteady.moment }, displaced };
    }
}

/// Momentum that the fluid displaced by a body would have, per metre of depth.
///
/// It is integrated over the true section, so that neither the width of the mask nor its position on the grid matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Displaced {
    /// Momentum, kg/s.
    pub momentum: [f64; 2],
    /// Angular momentum about the point about which the body's moment is taken, kg m/s.
    pub angular: f64,
    /// Cross product of that point's velocity and the momentum, N m/m.
    pub transport: f64,
}

impl Displaced {
    /// Return the rate of change over `dt` seconds, as a force and a moment.
    pub fn rate_of_change(&self, before: &Self, dt: f64) -> Force {
        let force = [0, 1].map(|axis| (self.momentum[axis] - before.momentum[axis]) / dt);
        let moment = (self.angular - before.angular) / dt + 0.5 * (self.transport + before.transport);
        Force { force, moment }
    }
}
