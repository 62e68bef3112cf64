//! The torsion spring at the root in the plane.
//!
//! The spring turns by θ, half a segment beside it by ψ − θ (and what the first one shears), and both carry the same moment:
//!
//! ```text
//! M = k_t (θ − θ0) + c_t θ' = k_h (ψ − θ).
//! ```
//!
//! A stage of the time scheme has θ' = c_v (θ − θ_n) + r*, so M = K θ + B there, and for ψ both together are a spring of the
//! stiffness K k_h / (K + k_h) that is at rest at −B/K. Newton's matrix stays symmetric, and damping costs nothing.

use serde::{Deserialize, Serialize};

use crate::scheme::StepRule;

/// What the spring is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hinge {
    /// k_t, N m/rad.
    pub(crate) stiffness: f64,
    /// c_t, N m s/rad.
    pub(crate) damping: f64,
    /// θ0, rad.
    pub(crate) rest_angle: f64,
    /// k_h of half a segment, N m.
    pub(crate) beside: f64,
}

/// The angle by which it turns, between two steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HingeState {
    /// θ, rad.
    pub angle: f64,
    /// Its rate, rad/s.
    pub rate: f64,
    /// Rate of the rate, rad/s².
    pub acceleration: f64,
    /// θ one step earlier, rad (BDF2).
    pub previous_angle: f64,
    /// Its rate there, rad/s (BDF2).
    pub previous_rate: f64,
}

/// M = K θ + B in a stage.
#[derive(Clone, Copy)]
pub(crate) struct StageSpring {
    slope: f64,
    offset: f64,
    beside: f64,
}

impl Hinge {
    /// Whether it has a history besides that of the nodes.
    pub(crate) fn is_damped(&self) -> bool {
        self.damping > 0.0
    }

    /// At rest under the moment of the rod, N m.
    pub(crate) fn at_rest(&self, moment: f64) -> HingeState {
        let angle = self.rest_angle + moment / self.stiffness;
        HingeState { angle, rate: 0.0, acceleration: 0.0, previous_angle: angle, previous_rate: 0.0 }
    }

    /// Energy of the spring turned by θ, J.
    pub(crate) fn energy(&self, angle: f64) -> f64 {
        0.5 * self.stiffness * (angle - self.rest_angle).powi(2)
    }

    /// In a stage by `rule` from `state`.
    pub(crate) fn stage(&self, rule: &StepRule, state: &HingeState) -> StageSpring {
        let Self { stiffness, damping, rest_angle, beside } = *self;
        let (rate, _) = rule.scalar_at_no_displacement(state);
        let slope = stiffness + damping * rule.c_v;
        StageSpring { slope, offset: damping * (rate - rule.c_v * state.angle) - stiffness * rest_angle, beside }
    }
}

impl StageSpring {
    /// Stiffness (N m) and rest angle (rad) of the spring for ψ.
    pub(crate) fn for_rod(&self) -> (f64, f64) {
        (self.slope * self.beside / (self.slope + self.beside), -self.offset / self.slope)
    }

    /// θ under the moment of the rod, N m.
    pub(crate) fn angle(&self, moment: f64) -> f64 {
        (moment - self.offset) / self.slope
    }
}

impl HingeState {
    /// Go on to `angle` in a stage by `rule`.
    pub(crate) fn advance(&mut self, rule: &StepRule, angle: f64) {
        let (rate, acceleration) = rule.scalar_at_no_displacement(self);
        let turned = angle - self.angle;
        (self.previous_angle, self.previous_rate) = (self.angle, self.rate);
        self.angle = angle;
        self.rate = turned * rule.c_v + rate;
        self.acceleration = turned * rule.c_a + acceleration;
    }

    /// Whether all are finite.
    pub(crate) fn is_finite(&self) -> bool {
        let Self { angle, rate, acceleration, previous_angle, previous_rate } = *self;
        [angle, rate, acceleration, previous_angle, previous_rate].iter().all(|number| number.is_finite())
    }
}
