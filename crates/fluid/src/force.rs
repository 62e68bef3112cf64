//! What the fluid does to a body: the penalization integral, and the unsteady term of the fluid that it displaces.

use serde::{Deserialize, Serialize};

/// Force and moment of the fluid on a body in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Force {
    /// Force, N per metre of depth.
    pub force: [f64; 2],
    /// Moment about the centre of a cylinder or the root of a beam, N m per metre of depth, positive to the left.
    pub moment: f64,
}

impl Force {
    /// Add a force (N/m) that acts at `arm` (m) from the point that the moment is taken about.
    pub fn add(&mut self, [fx, fy]: [f64; 2], arm: [f64; 2]) {
        self.force[0] += fx;
        self.force[1] += fy;
        self.moment += arm[0] * fy - arm[1] * fx;
    }
}

/// What the fluid did to a beam, by the drag on its cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Exchange {
    /// Sum of the drag in the last step, N per metre of depth.
    pub force: [f64; 2],
    /// Its power, with the velocity of the section at the end of the step, W per metre of depth.
    pub power: f64,
    /// Its work since the start, J per metre of depth: the sum of power times step.
    pub work: f64,
}

/// What the next step has to know of a body's force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyForce {
    /// Force in the last step.
    pub force: Force,
    /// The fluid that the body displaced at its end.
    pub displaced: Displaced,
}

impl BodyForce {
    /// Take what `drag` did in a step of size `dt` (s), and the unsteady term of what is displaced at its end.
    pub fn update(&mut self, drag: Force, displaced: Displaced, dt: f64) {
        let unsteady = displaced.rate_of_change(&self.displaced, dt);
        let force = [0, 1].map(|axis| drag.force[axis] + unsteady.force[axis]);
        *self = Self { force: Force { force, moment: drag.moment + unsteady.moment }, displaced };
    }
}

/// Momentum that the fluid displaced by a body would have, per metre of depth.
///
/// It is taken over the true section, so that neither the mask's width nor its way through the grid enters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Displaced {
    /// Momentum, kg/s.
    pub momentum: [f64; 2],
    /// Angular momentum about the point that the body's moment is taken about, kg m/s.
    pub angular: f64,
    /// Cross product of that point's velocity and the momentum, N m/m.
    pub transport: f64,
}

impl Displaced {
    /// Its rate of change over `dt` seconds, as a force and a moment.
    pub fn rate_of_change(&self, before: &Self, dt: f64) -> Force {
        let force = [0, 1].map(|axis| (self.momentum[axis] - before.momentum[axis]) / dt);
        let moment = (self.angular - before.angular) / dt + 0.5 * (self.transport + before.transport);
        Force { force, moment }
    }
}
