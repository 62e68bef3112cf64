//! Geometry of the beam: what fluid and rod have in common.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SceneError;
use crate::check::{Check, above, finite, require};

/// A straight beam of constant thickness with a flat tip; its stations are the rod's nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// Where the beam is clamped.
    pub root: Root,
    /// Length from root to tip, m.
    pub length: f64,
    /// Thickness, m.
    pub thickness: f64,
    /// Number of segments; there are `segments + 1` stations, the first at the root.
    pub segments: usize,
}

/// Where a beam is clamped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Root {
    /// On the surface of a cylinder, pointing outwards.
    OnCylinder {
        /// Which of the fluid's cylinders, from 0.
        cylinder: usize,
        /// Angle of the outward direction from the x axis, rad.
        #[serde(default)]
        angle: f64,
    },
    /// At a point, in two or three dimensions.
    At {
        /// Position, m: 2 or 3 components.
        position: Vec<f64>,
        /// Direction of the beam at the root; any length but 0.
        direction: Vec<f64>,
    },
}

impl Check for Beam {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        above(&format!("{key}.length"), self.length, 0.0)?;
        above(&format!("{key}.thickness"), self.thickness, 0.0)?;
        require(self.segments >= 2, &format!("{key}.segments"), self.segments, || "it must be at least 2".into())?;
        match &self.root {
            Root::OnCylinder { angle, .. } => finite(&format!("{key}.root.on_cylinder.angle"), *angle),
            Root::At { position, direction } => {
                let good = |v: &[f64]| matches!(v.len(), 2 | 3) && v.iter().all(|c| c.is_finite());
                require(good(position), &format!("{key}.root.at.position"), format!("{position:?}"), || {
                    "it must be 2 or 3 finite numbers".into()
                })?;
                let points =
                    direction.len() == position.len() && good(direction) && direction.iter().any(|&c| c != 0.0);
                require(points, &format!("{key}.root.at.direction"), format!("{direction:?}"), || {
                    format!("it must be {} finite numbers, not all 0", position.len())
                })
            }
        }
    }
}
