//! The mount of a rigid body, on which the fluid and gravity move it.

use std::fmt;

use method::Support;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Fault, Faults, list};

/// Mass of a body, whose centre is the pivot, its supports, and gravity. It is held in the directions that are absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mount {
    /// Mass, kg, in two dimensions per metre of depth.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mass: f64,
    /// Moment of inertia about the pivot, kg m², in two dimensions per metre of depth; in three dimensions one number, or
    /// one for each axis of the body. It is needed where the body turns, and absent elsewhere.
    #[serde(default)]
    pub inertia: Option<Inertia>,
    /// Support along x; absent where the body is held.
    #[serde(default)]
    pub x: Option<Support>,
    /// Support along y; absent where the body is held.
    #[serde(default)]
    pub y: Option<Support>,
    /// Support along z; absent where the body is held. Only in three dimensions.
    #[serde(default)]
    pub z: Option<Support>,
    /// Support about the pivot; absent where the body is held. Only in two dimensions.
    #[serde(default)]
    pub angle: Option<Support>,
    /// Support about an axis along x through the pivot; absent where the body is held. Only in three dimensions.
    #[serde(default)]
    pub angle_x: Option<Support>,
    /// Support about an axis along y through the pivot; absent where the body is held. Only in three dimensions.
    #[serde(default)]
    pub angle_y: Option<Support>,
    /// Support about an axis along z through the pivot; absent where the body is held. Only in three dimensions.
    #[serde(default)]
    pub angle_z: Option<Support>,
    /// Gravity, m/s², with as many components as the box; absent without gravity. The fluid carries the body with the
    /// weight of what it displaces, which forces leave out.
    #[serde(default)]
    #[schemars(length(max = 3))]
    pub gravity: Vec<f64>,
    /// Time from which the mount moves the body, s; before, its `motion` does, whose velocity it keeps. A step of the
    /// fluid that ends later is free. Absent without a motion.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub release: Option<f64>,
}

/// Moments of inertia.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
pub enum Inertia {
    /// The same about each axis.
    Same(#[schemars(extend("exclusiveMinimum" = 0.0))] f64),
    /// About each axis of the body.
    Each([f64; 3]),
}

/// Part of the sum of the moments of inertia by which one of a flat body may exceed the others.
const ROUNDING: f64 = 1e-9;

/// What moments of inertia about principal axes have to be.
pub(crate) const OF_A_BODY: &str = "moment must be at most the sum of the other two";

impl Inertia {
    /// Return the moments about the axes of the body, kg m².
    pub fn about(self) -> [f64; 3] {
        match self {
            Self::Same(about) => [about; 3],
            Self::Each(about) => about,
        }
    }

    /// Return whether a body can have these moments with the products −∫ y z, −∫ z x and −∫ x y: its second moments
    /// ∫ x xᵀ, half the trace less the matrix of inertia, are positive, or 0 across a flat body.
    pub(crate) fn is_of_a_body(self, [yz, zx, xy]: [f64; 3]) -> bool {
        let about = self.about();
        let trace: f64 = about.iter().sum();
        let [x, y, z] = about.map(|about| (0.5 + ROUNDING) * trace - about);
        is_positive([[x, -xy, -zx], [-xy, y, -yz], [-zx, -yz, z]])
    }
}

/// Return whether a symmetric matrix is positive definite: whether all pivots of its elimination are above 0.
pub(crate) fn is_positive(mut matrix: [[f64; 3]; 3]) -> bool {
    for k in 0..3 {
        let row = matrix[k];
        if row[k].is_nan() || row[k] <= 0.0 {
            return false;
        }
        for other in &mut matrix[k + 1..] {
            let share = other[k] / row[k];
            for (entry, above) in other.iter_mut().zip(row) {
                *entry -= share * above;
            }
        }
    }
    true
}

impl fmt::Display for Inertia {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Same(about) => write!(formatter, "{about}"),
            Self::Each(about) => write!(formatter, "{about:?}"),
        }
    }
}

/// A direction in which a mount may let a body move.
#[derive(Clone, Copy, Debug)]
pub struct Freedom {
    /// Key of the support, e.g. `y` or `angle_z`.
    pub name: &'static str,
    /// Axis along or about which the body moves.
    pub axis: usize,
    /// Whether the body turns about the axis.
    pub turns: bool,
    /// Mass, kg, or moment of inertia about the axis, kg m²; 0 where it is absent.
    pub inertia: f64,
    /// Its support; absent where the body is held.
    pub support: Option<Support>,
}

impl Mount {
    /// Return the moments of inertia about the axes of the body, kg m²; 0 where they are absent.
    pub fn inertias(&self) -> [f64; 3] {
        self.inertia.map_or([0.0; 3], Inertia::about)
    }

    /// Return the supports with their keys: along the axes, then about the pivot.
    pub fn supports(&self, is_space: bool) -> impl Iterator<Item = (&'static str, Option<Support>)> {
        let plane = [("x", self.x), ("y", self.y), ("angle", self.angle)];
        let about = [("angle_x", self.angle_x), ("angle_y", self.angle_y), ("angle_z", self.angle_z)];
        let space = [("x", self.x), ("y", self.y), ("z", self.z)].into_iter().chain(about);
        plane.into_iter().filter(move |_| !is_space).chain(space.filter(move |_| is_space))
    }

    /// Check what needs no shape; `key` is the path of the mount.
    pub(crate) fn check(&self, key: &str, is_space: bool, faults: &mut Faults) {
        for (name, support) in self.supports(!is_space).filter(|(name, _)| !["x", "y"].contains(name)) {
            faults.forbid(support.is_some(), &format!("{key}.{name}"), || match is_space {
                true => "use `angle_x`, `angle_y` and `angle_z` in three dimensions".into(),
                false => "the fluid has two dimensions".into(),
            });
        }
        if self.supports(is_space).all(|(_, support)| support.is_none()) {
            let free = list(self.supports(is_space).map(|(name, _)| name), "or");
            faults.push(Fault::needed(&format!("{key}.y"), &format!("a mount leaves a direction free: {free}")));
        }
        let name = format!("{key}.inertia");
        let turns = self.supports(is_space).any(|(name, support)| name.starts_with("angle") && support.is_some());
        match self.inertia {
            None if turns => faults.push(Fault::needed(&name, "a body that turns has a moment of inertia")),
            Some(_) if !turns => {
                faults.forbid(true, &name, || match is_space {
                    true => "the body does not turn: it has no `angle_x`, `angle_y` or `angle_z`".into(),
                    false => "the body does not turn: it has no `angle`".into(),
                });
            }
            Some(Inertia::Each(about)) => {
                faults.require(is_space, &name, format!("{about:?}"), || "in two dimensions it is one number".into());
                let fits = about.iter().all(|about| *about > 0.0);
                faults.require(fits, &name, format!("{about:?}"), || "each moment must be > 0".into());
                let is_known = !is_space || !fits || Inertia::Each(about).is_of_a_body([0.0; 3]);
                faults.require(is_known, &name, format!("{about:?}"), || format!("each {OF_A_BODY}"));
            }
            _ => (),
        }
        let (axes, count) = (if is_space { 3 } else { 2 }, self.gravity.len());
        faults.require([0, axes].contains(&count), &format!("{key}.gravity"), format!("{:?}", self.gravity), || {
            format!("it must have {axes} components like the box")
        });
    }
}
