//! Geometry of the beam: what fluid and rod have in common.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SceneError;
use crate::check::{Check, above, finite, require};

/// A beam of constant thickness with a flat tip; its stations are the rod's nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// Where the beam is clamped.
    pub root: Root,
    /// Length from root to tip, m.
    pub length: f64,
    /// Thickness, m.
    pub thickness: f64,
    /// Number of segments, 2 to 65536; there are `segments + 1` stations, the first at the root.
    pub segments: usize,
    /// Direction of each segment at rest against that at the root, rad, positive to the left: `[segments]`; absent for
    /// a straight beam. In two dimensions only: a curved rod in space needs a material frame and its twist.
    #[serde(default)]
    pub rest_angles: Vec<f64>,
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
        require((2..=65536).contains(&self.segments), &format!("{key}.segments"), self.segments, || {
            "it must be between 2 and 65536".into()
        })?;
        let angles = &self.rest_angles;
        if !angles.is_empty() {
            let key = format!("{key}.rest_angles");
            require(angles.len() == self.segments, &key, format!("{} numbers long", angles.len()), || {
                format!("it must have one angle for each of the {} segments", self.segments)
            })?;
            let planar = !matches!(&self.root, Root::At { position, .. } if position.len() == 3);
            require(planar, &key, "present", || {
                "a curved rest shape in three dimensions needs a material frame and twist, which this rod has not"
                    .into()
            })?;
            for (segment, (before, angle)) in std::iter::once(&0.0).chain(angles).zip(angles).enumerate() {
                require((angle - before).abs() < PI, &format!("{key}[{segment}]"), angle, || {
                    format!("it must differ by less than π from that of the segment before, {before}")
                })?;
            }
        }
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
