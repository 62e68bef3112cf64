//! Forces on a body in space: the penalization integral, and the unsteady term of the displaced fluid.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Force and moment of the fluid on a body in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Force {
    /// Force, N.
    pub force: [f64; 3],
    /// Moment about the pivot of the body, N m.
    pub moment: [f64; 3],
}

/// The force on a body, and what the next step needs for its unsteady term.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyForce {
    /// Force in the last step.
    pub force: Force,
    /// Displaced fluid at the end of the step.
    pub displaced: Displaced,
}

/// Momentum that the fluid displaced by a body would have. It is integrated over the true body, so that neither the width
/// of the mask nor its position on the grid matters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Displaced {
    /// Momentum, kg m/s.
    pub momentum: Vector3<f64>,
    /// Angular momentum about the pivot, kg m²/s.
    pub angular: Vector3<f64>,
    /// Cross product of the velocity of the pivot and the momentum, N m.
    pub transport: Vector3<f64>,
}

impl BodyForce {
    /// Become the force of a step of size `dt` (s), from force and moment of the drag and from the displaced fluid at its
    /// end.
    pub fn update(&mut self, [force, moment]: [Vector3<f64>; 2], displaced: Displaced, dt: f64) {
        let before = &self.displaced;
        let force = force + (displaced.momentum - before.momentum) / dt;
        let moment =
            moment + (displaced.angular - before.angular) / dt + 0.5 * (displaced.transport + before.transport);
        *self = Self { force: Force { force: force.into(), moment: moment.into() }, displaced };
    }
}
