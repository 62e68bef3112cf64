//! Forces on a body: the penalization integral, and the unsteady term of the displaced fluid.

use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

pub use rigid::Force;

use crate::space::{Space, Spin, Vector};

/// Force, power and work of the drag on a flexible body, in the plane per metre of depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exchange<const D: usize = 2> {
    /// Sum of the drag in the last step, N.
    #[serde(with = "BigArray")]
    pub force: [f64; D],
    /// Power, with the velocity of the sections at the end of the step, W.
    pub power: f64,
    /// Work since the start, J: the sum of power times step.
    pub work: f64,
}

/// The force on a body, and what the next step needs for its unsteady term.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BodyForce<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Force in the last step.
    pub force: Force<D>,
    /// Displaced fluid at the end of the step.
    pub displaced: Displaced<D>,
}

/// Momentum that the fluid displaced by a body would have, in the plane per metre of depth. It is integrated over the
/// true body, so that neither the width of the mask nor its position on the grid matters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Displaced<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Momentum, kg m/s.
    pub momentum: Vector<D>,
    /// Angular momentum about the point about which the body's moment is taken, kg m²/s.
    pub angular: Spin<D>,
    /// Cross product of that point's velocity and the momentum, N m.
    pub transport: Spin<D>,
}

impl<const D: usize> Default for Exchange<D> {
    fn default() -> Self {
        Self { force: [0.0; D], power: 0.0, work: 0.0 }
    }
}

impl<const D: usize> Default for Displaced<D>
where
    [f64; D]: Space<D>,
{
    fn default() -> Self {
        Self { momentum: Vector::zeros(), angular: Default::default(), transport: Default::default() }
    }
}

impl<const D: usize> BodyForce<D>
where
    [f64; D]: Space<D>,
{
    /// Become the force of a step of size `dt` (s), from the drag and from the displaced fluid at its end.
    pub fn update(&mut self, drag: Force<D>, displaced: Displaced<D>, dt: f64) {
        self.update_with(drag, displaced.rate_of_change(&self.displaced, dt), displaced);
    }

    /// Become the force of a step from the drag, the unsteady term, and the displaced fluid at its end.
    pub fn update_with(&mut self, drag: Force<D>, unsteady: Force<D>, displaced: Displaced<D>) {
        *self = Self { force: drag.plus(&unsteady), displaced };
    }
}

impl<const D: usize> Displaced<D>
where
    [f64; D]: Space<D>,
{
    /// Return the rate of change over `dt` seconds, as a force and a moment.
    pub fn rate_of_change(&self, before: &Self, dt: f64) -> Force<D> {
        let force = (self.momentum - before.momentum) / dt;
        Force { force, moment: (self.angular - before.angular) / dt + (self.transport + before.transport) * 0.5 }
    }
}
