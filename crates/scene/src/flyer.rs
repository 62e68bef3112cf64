//! A free rigid body that carries wings and rods at driven hinges.

use method::Support;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::{Body, ByMaster, Turn};
use crate::fault::{Check, Faults};
use crate::law::TimeLaw;
use crate::mount::Inertia;
use crate::root::turned_at_rate;

/// A free rigid body in space, the unit `body`. It moves in all directions that `held` does not name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Flyer {
    /// Mass, kg, without what it carries.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mass: f64,
    /// Moment of inertia about the centre of mass, kg m²: one number, or one for each axis of the body.
    pub inertia: Inertia,
    /// Products of inertia −∫ y z, −∫ z x and −∫ x y about the centre of mass, in the axes of the body, kg m².
    #[serde(default)]
    pub products_of_inertia: [f64; 3],
    /// Centre of mass from the pivot, in the axes of the body, m.
    #[serde(default)]
    pub centre_of_mass: [f64; 3],
    /// Place of the pivot at the start, m. The axes of the body are then those of the box.
    #[serde(default)]
    pub position: [f64; 3],
    /// Velocity at the start, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity at the start, rad/s.
    #[serde(default)]
    pub angular_velocity: [f64; 3],
    /// Directions in which it cannot move.
    #[serde(default)]
    pub held: Vec<FreedomName>,
    /// Springs and dampers, each in one direction.
    #[serde(default)]
    pub springs: Vec<FlyerSpring>,
    /// Gravity, m/s², for the body alone: wings and rods have their own.
    #[serde(default)]
    pub gravity: [f64; 3],
    /// Number of the body of `fluid.bodies` that has its shape, from 0, with `"motion": "master"`; absent for a body
    /// that the fluid does not feel.
    #[serde(default)]
    pub shape: Option<usize>,
    /// Shape at the start with which it touches what the key `contact` names, where it has none in the fluid: its
    /// `position` is that of the flyer.
    #[serde(default)]
    pub solid: Option<Body>,
    /// What it carries.
    pub hinges: Vec<FlyerHinge>,
}

/// A direction in which a body moves or turns about its pivot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FreedomName {
    /// Along x.
    X,
    /// Along y.
    Y,
    /// Along z.
    Z,
    /// About x.
    AngleX,
    /// About y.
    AngleY,
    /// About z.
    AngleZ,
}

/// A spring with a damper in one direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlyerSpring {
    /// Direction.
    pub along: FreedomName,
    /// Spring and damper.
    pub support: Support,
}

/// A driven hinge with a wing or a rod.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlyerHinge {
    /// Unit that it carries: `wing`, `rod`, or a name of `wings` or `rods`.
    pub carries: String,
    /// Place from the pivot of the body, in its axes, m: there is the `pivot` of the wing, or the root of the rod.
    pub position: [f64; 3],
    /// Turn from the axes of the wing's mesh to those of the body. A rod has the axes of the body.
    #[serde(default)]
    pub turn: Option<Turn>,
    /// Angles of the hinge; absent, they stay 0.
    #[serde(default)]
    pub motion: Option<HingeDrive>,
}

/// What moves a hinge: laws of its angles, or the word `master`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
#[expect(clippy::large_enum_variant, reason = "a hinge has one")]
pub enum HingeDrive {
    /// Laws of time.
    Laws(HingeLaws),
    /// The master.
    Master(ByMaster),
}

/// Angles of a hinge about the axes of what it carries: first pitch about x, then deviation about y, then stroke
/// about z.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HingeLaws {
    /// Angle about z, rad.
    #[serde(default)]
    pub stroke: TimeLaw,
    /// Angle about y, rad.
    #[serde(default)]
    pub deviation: TimeLaw,
    /// Angle about x, rad.
    #[serde(default)]
    pub pitch: TimeLaw,
}

impl HingeLaws {
    /// Return stroke, deviation and pitch, rad, with their rates, rad/s, at time `t`, s.
    pub fn angles(&self, t: f64) -> [(f64, f64); 3] {
        [&self.stroke, &self.deviation, &self.pitch].map(|law| law.value_and_rate(t))
    }
}

/// Largest distance of a hinge from the pivot along an axis, m, whose square is a number.
const FARTHEST: f64 = 1e100;

impl Flyer {
    /// Return whether it may go along x, y and z.
    pub(crate) fn goes_along(&self) -> impl Iterator<Item = bool> {
        [FreedomName::X, FreedomName::Y, FreedomName::Z].into_iter().map(|own| !self.held.contains(&own))
    }

    /// Return its mass, kg, or its moment of inertia about the pivot, kg m², against a motion in one direction, without
    /// what it carries.
    pub(crate) fn inertia_along(&self, along: FreedomName) -> f64 {
        let Some(axis) = (along as usize).checked_sub(FreedomName::AngleX as usize) else { return self.mass };
        let arms = self.centre_of_mass.iter().enumerate().filter(|(d, _)| *d != axis);
        self.inertia.about()[axis] + self.mass * arms.map(|(_, arm)| arm * arm).sum::<f64>()
    }
}

impl FlyerHinge {
    /// Return its laws, if it has such.
    pub fn laws(&self) -> Option<&HingeLaws> {
        if let Some(HingeDrive::Laws(laws)) = &self.motion { Some(laws) } else { None }
    }

    /// Return whether the master sets its angles.
    pub fn is_driven(&self) -> bool {
        matches!(self.motion, Some(HingeDrive::Master(_)))
    }

    /// Return a vector of the wing's mesh at the start, in the axes of the body.
    pub fn at_start(&self, vector: [f64; 3]) -> [f64; 3] {
        self.vector_at(0.0, vector).0
    }

    /// Return a vector of the wing's mesh at time `t` (s), in the axes of the body, and its rate, 1/s; without laws with
    /// all angles 0.
    pub(crate) fn vector_at(&self, t: f64, vector: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let [stroke, deviation, pitch] = self.laws().map_or([(0.0, 0.0); 3], |laws| laws.angles(t));
        let turns = [([1.0, 0.0, 0.0], pitch), ([0.0, 1.0, 0.0], deviation), ([0.0, 0.0, 1.0], stroke)];
        let fixed = self.turn.as_ref().map(|turn| (turn.unit_axis(), (turn.angle, 0.0)));
        turned_at_rate(turns.into_iter().chain(fixed), vector)
    }
}

impl Check for FlyerHinge {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let is_near = self.position.iter().all(|place| place.abs() <= FARTHEST);
        faults.require(is_near, &format!("{key}.position"), format!("{:?}", self.position), || {
            format!("each component must be from -{FARTHEST:e} to {FARTHEST:e} m")
        });
        if let Some(turn) = &self.turn {
            faults.direction(&format!("{key}.turn.axis"), &turn.axis);
        }
        if let Some(laws) = self.laws() {
            for (name, law) in [("stroke", &laws.stroke), ("deviation", &laws.deviation), ("pitch", &laws.pitch)] {
                law.check_at(&format!("{key}.motion.{name}"), faults);
            }
        }
    }
}
