//! Geometry of a beam, which fluid and rod share.

use std::f64::consts::PI;

use method::Surface;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::spanwise::Spanwise;

/// A beam with a flat tip. Its stations are the nodes of the rod.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Beam {
    /// Place and direction of the root at rest.
    pub root: Root,
    /// Length from root to tip, m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub length: f64,
    /// Thickness, m: a number, or a profile along the span.
    pub thickness: Spanwise,
    /// Number of segments, 2 to 65536; there are `segments + 1` stations, the first at the root.
    #[schemars(range(min = 2, max = 65536))]
    pub segments: usize,
    /// How the beam meets the fluid; no effect without one.
    #[serde(default)]
    pub surface: Surface,
    /// Angle of each segment at rest from the direction at the root, rad, counter-clockwise: `[segments]`; absent for a
    /// straight beam. In two dimensions only: a curved rod in space needs a material frame and its twist.
    #[serde(default)]
    pub rest_angles: Vec<f64>,
}

/// Place and direction of a beam's root at rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Root {
    /// On the surface of a cylinder, pointing outwards.
    OnCylinder {
        /// Index of the cylinder in `fluid.cylinders`, from 0.
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
    /// Return its largest thickness, m.
    pub(crate) fn largest_thickness(&self) -> f64 {
        self.places().map(|s| self.thickness.at(s)).fold(0.0, f64::max)
    }

    /// Return the places of the stations and, between them, of the middles of the segments, 0 at the root and 1 at the
    /// tip: `[2 segments + 1]`.
    pub fn places(&self) -> impl Iterator<Item = f64> {
        let last = 2 * self.segments;
        (0..=last).map(move |i| i as f64 / last as f64)
    }
}

impl Check for Beam {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        self.thickness.check_at(&format!("{key}.thickness"), faults);
        self.check_rest_angles(&format!("{key}.rest_angles"), faults);
        let Root::At { position, direction } = &self.root else { return };
        let (key, count) = (format!("{key}.root.at.direction"), position.len());
        if faults.require(direction.len() == count, &key, format!("{direction:?}"), || {
            format!("it must have {count} components like the position")
        }) {
            faults.direction(&key, direction);
        }
    }
}

impl Beam {
    fn check_rest_angles(&self, key: &str, faults: &mut Faults) {
        let angles = &self.rest_angles;
        if angles.is_empty() {
            return;
        }
        faults.require(angles.len() == self.segments, key, format!("a list of {}", angles.len()), || {
            format!("the beam has {} segments, each with one angle", self.segments)
        });
        let spatial = matches!(&self.root, Root::At { position, .. } if position.len() == 3);
        faults.forbid(spatial, key, || {
            "a curved rest shape in three dimensions needs a material frame, which the rod lacks".into()
        });
        for (segment, (before, angle)) in std::iter::once(&0.0).chain(angles).zip(angles).enumerate() {
            if (angle - before).abs() >= PI {
                faults.require(false, &format!("{key}[{segment}]"), angle, || {
                    format!("it must differ by less than pi from the angle of the segment before, {before}")
                });
            }
        }
    }
}
