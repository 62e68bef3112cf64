//! Torsion spring at the root, in the plane.
//!
//! The spring turns by θ, the half segment beside it by ψ − θ (plus the shear of the first segment). Both carry the
//! same moment:
//!
//! ```text
//! M = k_t (θ − θ0) + c_t θ' = k_h (ψ − θ).
//! ```
//!
//! A stage of the time scheme has θ' = c_v (θ − θ_n) + r*, hence M = K θ + B. In series, spring and half segment resist
//! ψ with the stiffness K k_h / (K + k_h) from the rest angle −B/K. Newton's matrix stays symmetric.

use structure::{Motion, StepRule};

/// Constants of the spring.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hinge {
    /// k_t, N m/rad.
    pub(crate) stiffness: f64,
    /// c_t, N m s/rad.
    pub(crate) damping: f64,
    /// θ0, rad.
    pub(crate) rest_angle: f64,
    /// k_h of the half segment beside the spring, N m.
    pub(crate) half_segment: f64,
}

/// M = K θ + B in a stage.
#[derive(Clone, Copy)]
pub(crate) struct StageSpring {
    slope: f64,
    offset: f64,
    half_segment: f64,
}

impl Hinge {
    /// Whether θ has a history besides the history of the nodes.
    pub(crate) fn is_damped(&self) -> bool {
        self.damping > 0.0
    }

    /// Return the spring at rest under the moment of the rod, N m.
    pub(crate) fn at_rest(&self, moment: f64) -> Motion<f64> {
        let angle = self.rest_angle + moment / self.stiffness;
        Motion { x: angle, v: 0.0, a: 0.0, previous_x: angle, previous_v: 0.0 }
    }

    /// Return the energy of the spring at the angle θ, J.
    pub(crate) fn energy(&self, angle: f64) -> f64 {
        0.5 * self.stiffness * (angle - self.rest_angle).powi(2)
    }

    /// Return the spring in a stage by `rule` from the motion `now`.
    pub(crate) fn stage(&self, rule: &StepRule, now: Motion<f64>) -> StageSpring {
        let Self { stiffness, damping, rest_angle, half_segment } = *self;
        let (rate, _) = rule.at_no_displacement(now);
        let slope = stiffness + damping * rule.c_v;
        let offset = damping * (rate - rule.c_v * now.x) - stiffness * rest_angle;
        StageSpring { slope, offset, half_segment }
    }
}

impl StageSpring {
    /// Return stiffness (N m) and rest angle (rad) of the series spring for ψ.
    pub(crate) fn in_series(&self) -> (f64, f64) {
        (self.slope * self.half_segment / (self.slope + self.half_segment), -self.offset / self.slope)
    }

    /// Return θ under the moment of the rod, N m.
    pub(crate) fn angle(&self, moment: f64) -> f64 {
        (moment - self.offset) / self.slope
    }
}

/// Return the motion after a stage by `rule` from the motion `now` to the angle `x`.
pub(crate) fn advanced(now: Motion<f64>, rule: &StepRule, x: f64) -> Motion<f64> {
    let (v, a) = rule.at_no_displacement(now);
    let turned = x - now.x;
    Motion { x, v: turned * rule.c_v + v, a: turned * rule.c_a + a, previous_x: now.x, previous_v: now.v }
}
