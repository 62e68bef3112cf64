//! Scales of coefficients that a scene names.

use geometry::vector::{cross, norm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};

/// Least part of a direction across the drag that lift can be along.
pub(crate) const ACROSS: f64 = 0.1;

/// Scales of coefficients, in place of those that follow from the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferenceScales {
    /// Length L, m.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length: Option<f64>,
    /// Area A, m²; only in three dimensions.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub area: Option<f64>,
    /// Speed U, m/s.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub speed: Option<f64>,
    /// Direction of the drag, of any length above 0; thrust is against it.
    #[serde(default)]
    #[schemars(length(min = 2, max = 3))]
    pub drag: Option<Vec<f64>>,
    /// Direction of the lift, of which the part across the drag counts.
    #[serde(default)]
    #[schemars(length(min = 2, max = 3))]
    pub lift: Option<Vec<f64>>,
}

impl Check for ReferenceScales {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        for (name, given) in [("drag", &self.drag), ("lift", &self.lift)] {
            let has_length = given.as_ref().is_none_or(|own| own.iter().any(|part| *part != 0.0));
            faults.require(has_length, &format!("{key}.{name}"), "zeros", || "a direction has a length".into());
        }
        if let (Some(drag), Some(lift)) = (&self.drag, &self.lift) {
            let (d, l) = (vector(drag), vector(lift));
            let is_across = norm(cross(d, l)) > ACROSS * norm(d) * norm(l);
            faults.require(is_across || norm(d) * norm(l) == 0.0, &format!("{key}.lift"), format!("{lift:?}"), || {
                format!("it is across the drag, {drag:?}")
            });
        }
    }
}

pub(crate) fn vector(components: &[f64]) -> [f64; 3] {
    std::array::from_fn(|d| components.get(d).copied().unwrap_or(0.0))
}
