//! Geometry of the beam: what fluid and rod have in common.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Check, require};
use crate::{SceneError, Spanwise};

/// A beam with a flat tip; its stations are the rod's nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// Where the beam is clamped.
    pub root: Root,
    /// Length from root to tip, m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length: f64,
    /// Thickness, m: a number, or a law of the place along the beam.
    pub thickness: Spanwise,
    /// Number of segments, 2 to 65536; there are `segments + 1` stations, the first at the root.
    #[schemars(range(min = 2, max = 65536))]
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
        #[schemars(length(min = 2, max = 3))]
        position: Vec<f64>,
        /// Direction of the beam at the root; any length but 0.
        #[schemars(length(min = 2, max = 3))]
        direction: Vec<f64>,
    },
}

impl Beam {
    /// Places of the stations and of the middles of the segments in turn, 0 at the root and 1 at the tip:
    /// `[2 segments + 1]`.
    pub fn places(&self) -> impl Iterator<Item = f64> {
        let last = 2 * self.segments;
        (0..=last).map(move |i| i as f64 / last as f64)
    }
}

impl Check for Beam {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        self.thickness.check_at(&format!("{key}.thickness"))?;
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
        let Root::At { position, direction } = &self.root else { return Ok(()) };
        let points = direction.len() == position.len() && direction.iter().any(|&c| c != 0.0);
        require(points, &format!("{key}.root.at.direction"), format!("{direction:?}"), || {
            format!("it must be {} numbers, not all 0", position.len())
        })
    }
}
