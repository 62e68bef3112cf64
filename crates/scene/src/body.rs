//! Rigid bodies in the fluid: their shape, and how they move.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Check, require};
use crate::{Cylinder, Motion, SceneError, TimeLaw};

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Its outline, in axes of its own.
    pub shape: Shape,
    /// Where its pivot is, m; where it moves, the point that its motion is added to.
    pub position: [f64; 2],
    /// The point in its own axes, m, about which it turns and its moment is taken; by default their origin.
    #[serde(default)]
    pub pivot: [f64; 2],
    /// Angle from the x axis of the box to its own, rad, positive to the left; its motion is added.
    #[serde(default)]
    pub angle: f64,
    /// Prescribed motion; absent for a still body.
    #[serde(default)]
    pub motion: Option<BodyMotion>,
}

/// Outline of a body. The origin of its axes is the middle of it, but for a polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// A circle.
    Circle {
        /// Radius, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
    },
    /// An ellipse.
    Ellipse {
        /// Length of its axis along its own x, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
        /// Length of its axis along its own y, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        thickness: f64,
    },
    /// A rectangle.
    Rectangle {
        /// Length along its own x, m, with the ends.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
        /// Thickness along its own y, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        thickness: f64,
        /// What its ends along its own x are.
        #[serde(default)]
        ends: Ends,
    },
    /// A polygon.
    Polygon {
        /// Its corners in their order, either way round, m; at least 3, at most 1000. Its sides must not cross.
        #[schemars(length(min = 3, max = 1000))]
        corners: Vec<[f64; 2]>,
    },
}

/// Ends of a rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Ends {
    /// Flat.
    #[default]
    Square,
    /// Half circles of the thickness.
    Round,
}

/// Prescribed motion of a body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyMotion {
    /// Displacement of its pivot along x, m.
    #[serde(default)]
    pub x: TimeLaw,
    /// Displacement of its pivot along y, m.
    #[serde(default)]
    pub y: TimeLaw,
    /// Angle about its pivot, rad, positive to the left.
    #[serde(default)]
    pub angle: TimeLaw,
}

/// A cylinder is a circle that does not turn.
impl From<&Cylinder> for Body {
    fn from(cylinder: &Cylinder) -> Self {
        let motion = |Motion { x, y }: Motion| BodyMotion { x, y, angle: TimeLaw::default() };
        Self {
            shape: Shape::Circle { radius: cylinder.radius },
            position: cylinder.center,
            pivot: [0.0; 2],
            angle: 0.0,
            motion: cylinder.motion.clone().map(motion),
        }
    }
}

impl Check for Body {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        self.shape.check_at(&format!("{key}.shape"))?;
        let Some(motion) = &self.motion else { return Ok(()) };
        motion.x.check_at(&format!("{key}.motion.x"))?;
        motion.y.check_at(&format!("{key}.motion.y"))?;
        motion.angle.check_at(&format!("{key}.motion.angle"))
    }
}

impl Check for Shape {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        match self {
            Self::Circle { .. } | Self::Ellipse { .. } => Ok(()),
            Self::Rectangle { length, thickness, ends } => {
                let fits = *ends == Ends::Square || thickness <= length;
                require(fits, &format!("{key}.rectangle.thickness"), thickness, || {
                    format!("with round ends it must be at most the length, {length}")
                })
            }
            Self::Polygon { corners } => check_corners(corners, &format!("{key}.polygon.corners")),
        }
    }
}

/// A polygon has sides of some length that do not cross or touch one another.
fn check_corners(corners: &[[f64; 2]], key: &str) -> Result<(), SceneError> {
    let n = corners.len();
    let side = |i: usize| (corners[i], corners[(i + 1) % n]);
    for i in 0..n {
        let (a, b) = side(i);
        require(a != b, &format!("{key}[{i}]"), format!("{a:?}"), || "the next corner is the same".into())?;
    }
    for i in 0..n {
        let (a, b) = side(i);
        for j in i + 1..n {
            let (c, d) = side(j);
            // Neighbours share a corner, and nothing else.
            let touch = if j == i + 1 {
                within(a, b, d) || within(c, d, a)
            } else if i == 0 && j == n - 1 {
                within(a, b, c) || within(c, d, b)
            } else {
                meet(a, b, c, d)
            };
            require(!touch, &format!("{key}[{i}]"), format!("{a:?}"), || {
                format!("the side that begins there meets the one that begins at corner {j}, {c:?}")
            })?;
        }
    }
    Ok(())
}

/// Twice the area of a triangle, positive where it goes round to the left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether `c` lies on the side from `a` to `b`.
fn within(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> bool {
    turn(a, b, c) == 0.0
        && [0, 1].iter().all(|&axis| a[axis].min(b[axis]) <= c[axis] && c[axis] <= a[axis].max(b[axis]))
}

/// Whether two sides have a point in common.
fn meet(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> bool {
    let apart = |a, b, c, d| turn(a, b, c) * turn(a, b, d) < 0.0;
    (apart(a, b, c, d) && apart(c, d, a, b)) || within(a, b, c) || within(a, b, d) || within(c, d, a) || within(c, d, b)
}

#[cfg(test)]
mod tests {
    use crate::Scene;

    /// What is said of a body in a box of 1 m around the origin.
    fn said_of(body: &str) -> String {
        let text = format!(
            r#"{{ "name": "test", "time": {{ "end": 1.0, "communication_step": 0.01 }}, "fluid": {{ "density": 1.0,
                "kinematic_viscosity": 0.01, "box": {{ "x": [-0.5, 0.5], "y": [-0.5, 0.5], "cells": [32, 32] }},
                "mask": {{ "log_linear": {{ "c_eta": 1e-4 }} }},
                "time_stepping": {{ "max_step": 0.01, "max_cfl": 0.4 }}, "bodies": [{body}] }} }}"#
        );
        Scene::from_json(&text).map_or_else(|error| error.to_string(), |_| "accepted".into())
    }

    #[test]
    fn bodies_that_cannot_be_are_refused_with_key_and_value() {
        let at = r#""position": [0, 0]"#;
        let polygon = |corners: &str| format!(r#"{{ "shape": {{ "polygon": {{ "corners": {corners} }} }}, {at} }}"#);
        let rectangle =
            |shape: &str| format!(r#"{{ "shape": {{ "rectangle": {{ "length": 0.1, {shape} }} }}, {at} }}"#);
        let shapes = "`fluid.bodies[0].shape";
        let cases = [
            (polygon("[[0, 0], [0.1, 0], [0, 0.1]]"), "accepted".into()),
            (polygon("[[0, 0], [0, 0.1], [0.1, 0]]"), "accepted".into()),
            (polygon("[[0, 0], [0.1, 0]]"), format!("{shapes}.polygon.corners` is")),
            (polygon("[[0, 0], [0.1, 0], [0.1, 0], [0, 0.1]]"), format!("{shapes}.polygon.corners[1]` is [0.1, 0.0]")),
            (
                polygon("[[0, 0], [0.1, 0.1], [0.1, 0], [0, 0.1]]"),
                format!("{shapes}.polygon.corners[0]` is [0.0, 0.0], but the side that begins there meets"),
            ),
            (polygon("[[0, 0], [0.2, 0], [0.1, 0]]"), format!("{shapes}.polygon.corners[0]` is")),
            (rectangle(r#""thickness": 0.2"#), "accepted".into()),
            (
                rectangle(r#""thickness": 0.2, "ends": "round""#),
                format!("{shapes}.rectangle.thickness` is 0.2, but with round ends it must be at most the length, 0.1"),
            ),
            (rectangle(r#""thickness": 0.0"#), format!("{shapes}.rectangle.thickness` is 0")),
            (rectangle(r#""thickness": 0.1, "ends": "pointed""#), format!("{shapes}.rectangle.ends` is")),
            (
                format!(r#"{{ "shape": {{ "ellipse": {{ "length": 0.1, "thickness": -0.1 }} }}, {at} }}"#),
                format!("{shapes}.ellipse.thickness` is -0.1"),
            ),
            (
                r#"{ "shape": { "circle": { "radius": 0.1 } }, "position": [0, 0.6] }"#.into(),
                "`fluid.bodies[0].position[1]` is 0.6, but it must lie inside the box".into(),
            ),
            (
                format!(
                    r#"{{ "shape": {{ "circle": {{ "radius": 0.1 }} }}, {at},
                        "motion": {{ "angle": {{ "table": {{ "times": [1, 0], "values": [0, 1] }} }} }} }}"#
                ),
                "`fluid.bodies[0].motion.angle.table.times` is".into(),
            ),
        ];
        for (body, expected) in cases {
            let found = said_of(&body);
            assert!(found.contains(&expected), "{body}: {found}, but expected {expected}");
        }
    }
}
