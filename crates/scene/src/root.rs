//! The root of a rod: its support and its prescribed motion.

use std::f64::consts::PI;

use geometry::AXES;
use geometry::vector::{cross, minus, turned, unit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::law::{TimeLaw, values_and_rates};

/// Support of the root of a rod.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[expect(clippy::large_enum_variant, reason = "a scene has one for each rod")]
pub enum RootSupport {
    /// The root neither moves nor turns freely.
    #[default]
    Clamped,
    /// The root does not move freely, and turns without resistance.
    Pinned,
    /// The root does not move freely, and turns against a torsion spring with the moment `stiffness (angle −
    /// rest_angle) + damping rate`. The angle is counted from the direction of the beam, between −π and π.
    TorsionSpring {
        /// Stiffness of the spring, N m/rad.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        stiffness: f64,
        /// Damping, N m s/rad; in the plane only.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        damping: f64,
        /// Angle at which the spring is at rest, rad, counter-clockwise; in the plane only. The rod still starts along
        /// the direction of the beam.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = -PI, "exclusiveMaximum" = PI))]
        rest_angle: f64,
    },
    /// The root moves and turns under the loads, gravity and a towing force.
    Free {
        /// Towing force along x, N.
        #[serde(default)]
        force_x: TimeLaw,
        /// Towing force along y, N.
        #[serde(default)]
        force_y: TimeLaw,
        /// Towing force along z, N; in three dimensions only.
        #[serde(default)]
        force_z: TimeLaw,
    },
}

/// Prescribed motion of the root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[expect(clippy::large_enum_variant, reason = "a scene has one for each rod")]
pub enum RootMotion {
    /// The master sets position, direction and rates of the root at the end of each communication step.
    Master,
    /// Laws of time.
    Laws(RootLaws),
}

/// Motion of the root from its place at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RootLaws {
    /// Displacement along x, m.
    #[serde(default)]
    pub x: TimeLaw,
    /// Displacement along y, m.
    #[serde(default)]
    pub y: TimeLaw,
    /// Displacement along z, m; in three dimensions only.
    #[serde(default)]
    pub z: TimeLaw,
    /// Rotations of the beam's direction, applied in order.
    #[serde(default)]
    pub rotations: Vec<Rotation>,
}

/// Rotation about a fixed axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Angle, rad.
    pub angle: TimeLaw,
    /// Axis, of any length but 0; in two dimensions only z.
    #[serde(default = "z_axis")]
    pub axis: [f64; 3],
}

/// Axis of rotations in two dimensions.
pub(crate) const Z_AXIS: [f64; 3] = [0.0, 0.0, 1.0];

fn z_axis() -> [f64; 3] {
    Z_AXIS
}

impl RootLaws {
    /// Return the laws of the displacement along each axis.
    pub(crate) fn along(&self) -> [&TimeLaw; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// Return all laws: of the displacement, then of the rotations.
    pub(crate) fn all(&self) -> impl Iterator<Item = &TimeLaw> {
        self.along().into_iter().chain(self.rotations.iter().map(|turn| &turn.angle))
    }

    /// Return displacement, m, and velocity, m/s, at time `t` (s).
    pub fn displacement(&self, t: f64) -> ([f64; 3], [f64; 3]) {
        values_and_rates(self.along(), t)
    }

    /// Return the function from the place of a point at rest to that at time `t` (s), m, if it moves with the base and
    /// turns about `pivot`.
    pub(crate) fn motion(&self, pivot: [f64; 3], t: f64) -> impl Fn([f64; 3]) -> [f64; 3] + use<> {
        let displacement = self.displacement(t).0;
        let turns: Vec<_> = self.rotations.iter().map(|own| (own.unit_axis(), own.angle.value(t))).collect();
        move |point| {
            let arm = turns.iter().fold(minus(point, pivot), |arm, (axis, angle)| turned(arm, *axis, *angle));
            std::array::from_fn(|d| pivot[d] + displacement[d] + arm[d])
        }
    }

    /// Return the direction at time `t` (s) of a vector that has `direction` at rest, and its rate, 1/s.
    pub fn direction(&self, t: f64, direction: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        turned_at_rate(self.rotations.iter().map(|own| (own.unit_axis(), own.angle.value_and_rate(t))), direction)
    }
}

/// Return a vector after turns about unit axes by angles, rad, in order, and its rate for the rates of these, rad/s.
pub(crate) fn turned_at_rate(
    turns: impl IntoIterator<Item = ([f64; 3], (f64, f64))>,
    vector: [f64; 3],
) -> ([f64; 3], [f64; 3]) {
    turns.into_iter().fold((vector, [0.0; 3]), |(vector, rate), (axis, (angle, omega))| {
        let (now, carried) = (turned(vector, axis, angle), turned(rate, axis, angle));
        let turning = cross(axis, now);
        (now, std::array::from_fn(|d| carried[d] + omega * turning[d]))
    })
}

impl Rotation {
    fn unit_axis(&self) -> [f64; 3] {
        unit(self.axis)
    }
}

impl RootSupport {
    /// Return the towing force on a free root at time `t` (s), N.
    pub fn towing_force(&self, t: f64) -> Option<[f64; 3]> {
        let Self::Free { force_x, force_y, force_z } = self else { return None };
        Some([force_x, force_y, force_z].map(|law| law.value(t)))
    }
}

impl Check for RootSupport {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let Self::Free { force_x, force_y, force_z } = self else { return };
        for (name, law) in [("force_x", force_x), ("force_y", force_y), ("force_z", force_z)] {
            law.check_at(&format!("{key}.free.{name}"), faults);
        }
    }
}

impl Check for RootLaws {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        for (name, law) in AXES.into_iter().zip(self.along()) {
            law.check_at(&format!("{key}.{name}"), faults);
        }
        self.rotations.check_at(&format!("{key}.rotations"), faults);
    }
}

impl Check for Rotation {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        self.angle.check_at(&format!("{key}.angle"), faults);
        faults.direction(&format!("{key}.axis"), &self.axis);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_of_the_direction_is_its_derivative() {
        let sine = |frequency| TimeLaw::Sine { mean: 0.2, amplitude: 0.9, frequency, phase: 0.3, ramp: 0.4 };
        let laws = RootLaws {
            rotations: vec![
                Rotation { angle: sine(1.0), axis: [0.0, 0.0, 2.0] },
                Rotation { angle: sine(1.7), axis: [1.0, 1.0, -0.5] },
            ],
            ..RootLaws::default()
        };
        let (rest, step) = ([0.6, 0.0, 0.8], 1e-5);
        for t in [0.1, 0.3, 1.2] {
            let (direction, rate) = laws.direction(t, rest);
            let norm = direction.iter().map(|c| c * c).sum::<f64>();
            assert!((norm - 1.0).abs() < 1e-14, "t = {t}: squared length {norm}");
            let (after, before) = (laws.direction(t + step, rest).0, laws.direction(t - step, rest).0);
            for d in 0..3 {
                let difference = (after[d] - before[d]) / (2.0 * step);
                assert!((rate[d] - difference).abs() < 1e-7, "t = {t}, {d}: {} against {difference}", rate[d]);
            }
        }
    }
}
