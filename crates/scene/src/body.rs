//! Rigid bodies in the fluid: shape, place, motion and mount.

use std::iter;

use geometry::Section;
use geometry::vector::{cross, dot, minus, norm, turned, unit};
use geometry::{AXES, Chain, Placed, Surface};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Fault, Faults};
use crate::law::{TimeLaw, values_and_rates};
use crate::mount::Mount;
use crate::reference_scales::{ReferenceScales, vector};
use crate::root::{Rotation, Z_AXIS, turned_at_rate};
use crate::shape::Shape;

/// A rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Outline in the body's own axes.
    pub shape: Shape,
    /// Place of the pivot, m; motion and mount displace it from there.
    #[schemars(length(min = 2, max = 3))]
    pub position: Vec<f64>,
    /// Pivot in the body's own axes, m, about which the body turns and its moment is taken; by default their origin.
    #[serde(default = "origin")]
    #[schemars(length(min = 2, max = 3))]
    pub pivot: Vec<f64>,
    /// Angle from the x axis of the box to the body's own, rad, counter-clockwise; motion and mount turn it from
    /// there. Only in two dimensions.
    #[serde(default)]
    pub angle: f64,
    /// Turn from the axes of the box to those of the body, before the motion; only in three dimensions.
    #[serde(default)]
    pub turn: Option<Turn>,
    /// Prescribed motion, of a body on a mount until its release; absent for a body that is still.
    #[serde(default)]
    pub motion: Option<BodyDrive>,
    /// Springs and dampers on which the fluid moves the body; absent for one that is still or has only a motion.
    #[serde(default)]
    pub mount: Option<Mount>,
    /// Scales of its coefficients, in place of those that follow from shape and stream.
    #[serde(default)]
    pub reference: Option<ReferenceScales>,
}

/// What prescribes the motion of a body: laws, or the word `master`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
#[expect(clippy::large_enum_variant, reason = "a body has one")]
pub enum BodyDrive {
    /// Laws of time.
    Laws(BodyMotion),
    /// The master.
    Master(ByMaster),
}

/// What comes from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ByMaster {
    /// The master sets it: of a motion displacement, angle and their rates at the end of each communication step.
    Master,
}

fn origin() -> Vec<f64> {
    vec![0.0; 2]
}

/// A turn about an axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// Axis, of any length above 0.
    pub axis: [f64; 3],
    /// Angle, rad, positive by the right-hand rule.
    pub angle: f64,
}

impl Turn {
    /// Return the axis as a unit vector.
    pub fn unit_axis(&self) -> [f64; 3] {
        unit(self.axis)
    }
}

/// Prescribed motion of a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyMotion {
    /// Displacement of the pivot along x, m.
    #[serde(default)]
    pub x: TimeLaw,
    /// Displacement of the pivot along y, m.
    #[serde(default)]
    pub y: TimeLaw,
    /// Displacement of the pivot along z, m; only in three dimensions.
    #[serde(default)]
    pub z: TimeLaw,
    /// Angle about the pivot, rad, counter-clockwise; in three dimensions about `axis` by the right-hand rule.
    #[serde(default)]
    pub angle: TimeLaw,
    /// Axis of the box about which the body turns, of any length above 0, by default z; only in three dimensions.
    #[serde(default)]
    pub axis: Option<[f64; 3]>,
    /// Rotations about the pivot after that by `angle`, applied in order; only in three dimensions.
    #[serde(default)]
    pub rotations: Vec<Rotation>,
}

impl BodyMotion {
    /// Return the laws of the displacement along each axis.
    pub fn along(&self) -> [&TimeLaw; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// Return displacement, m, and velocity, m/s, at time `t` (s).
    pub(crate) fn displacement(&self, t: f64) -> ([f64; 3], [f64; 3]) {
        values_and_rates(self.along(), t)
    }

    /// Return all laws: of the displacement, then of the rotations.
    pub(crate) fn all(&self) -> impl Iterator<Item = &TimeLaw> {
        self.along().into_iter().chain(self.turns().map(|(_, angle)| angle))
    }

    /// Return axis and angle of the rotations, in order.
    pub fn turns(&self) -> impl Iterator<Item = ([f64; 3], &TimeLaw)> {
        let first = (self.axis.unwrap_or(Z_AXIS), &self.angle);
        iter::once(first).chain(self.rotations.iter().map(|own| (own.axis, &own.angle)))
    }
}

impl Body {
    /// Check that the parts exist in two dimensions, or in space; `key` is the path of the body.
    pub(crate) fn check_dimension(&self, key: &str, is_space: bool, faults: &mut Faults) {
        let (spatial, name) = self.shape.dimension(is_space);
        if let Shape::Plate { width, .. } = self.shape {
            let key = format!("{key}.shape.plate.width");
            faults.forbid(!is_space && width.is_some(), &key, || "the fluid has two dimensions".into());
        }
        faults.require(spatial == is_space, &format!("{key}.shape"), name, || match is_space {
            true => "in three dimensions it is a sphere, ellipsoid, cuboid, circular_cylinder, capsule, disk, \
                     triangulation or a plate with a width"
                .into(),
            false => "in two dimensions it is a circle, ellipse, rectangle, polygon, plate or polyline".into(),
        });
        if let Some(mount) = &self.mount {
            mount.check(&format!("{key}.mount"), is_space, faults);
            self.check_held(&format!("{key}.mount"), is_space, faults);
        }
        let flat_area = !is_space && self.reference.as_ref().is_some_and(|own| own.area.is_some());
        faults.forbid(flat_area, &format!("{key}.reference.area"), || {
            "in two dimensions forces are per metre of depth, and coefficients refer to a length".into()
        });
        let motion = self.laws();
        let axes = [
            ("turn.axis", self.turn.as_ref().map(|turn| turn.axis)),
            ("motion.axis", motion.and_then(|motion| motion.axis)),
        ];
        for (name, axis) in axes {
            axis.iter().for_each(|axis| _ = faults.direction(&format!("{key}.{name}"), axis));
        }
        if is_space {
            let fits = self.angle == 0.0;
            faults.require(fits, &format!("{key}.angle"), self.angle, || "use `turn` in three dimensions".into());
            return;
        }
        let flat = || "the fluid has two dimensions".into();
        faults.forbid(self.turn.is_some(), &format!("{key}.turn"), flat);
        faults.require(self.pivot.len() == 2, &format!("{key}.pivot"), format!("{:?}", self.pivot), || {
            "it must have 2 components like the box".into()
        });
        if let Some(motion) = motion {
            faults.forbid(motion.z != TimeLaw::default(), &format!("{key}.motion.z"), flat);
            faults.forbid(motion.axis.is_some(), &format!("{key}.motion.axis"), flat);
            faults.forbid(!motion.rotations.is_empty(), &format!("{key}.motion.rotations"), flat);
        }
    }
}

/// Relative tolerance of a direction along an axis of the box.
const ALONG: f64 = 1e-9;

impl Body {
    /// Return the shape at time `t` (s) in a box with these ends, m.
    pub(crate) fn shape_at(&self, t: f64, ends: &[[f64; 2]]) -> geometry::Shape {
        self.placed(self.pose_at(t), ends)
    }

    /// Return the shape with the pivot at `position` (m) after a turn (rad), in the plane from the x axis and in space
    /// about the vector from rest.
    pub(crate) fn shape_in(&self, position: &[f64], turn: &[f64], ends: &[[f64; 2]]) -> geometry::Shape {
        let turn = match *turn {
            [x, y, z] if norm([x, y, z]) > 0.0 => Some(([x, y, z], norm([x, y, z]))),
            [angle] => Some((Z_AXIS, angle - self.angle)),
            _ => None,
        };
        self.placed(self.pose(minus(vector(position), vector(&self.position)), turn), ends)
    }

    /// Return the axes of the body after turns about axes by angles, rad.
    fn axes(&self, turns: impl IntoIterator<Item = ([f64; 3], f64)>) -> [[f64; 3]; 3] {
        let by = |v, (axis, angle): ([f64; 3], f64)| turned(v, unit(axis), angle);
        let own = |d: usize| std::array::from_fn(|e| f64::from(u8::from(d == e)));
        let rest = self.turn.as_ref().map_or((Z_AXIS, self.angle), |turn| (turn.axis, turn.angle));
        let at_rest = [0, 1, 2].map(|d| by(own(d), rest));
        turns.into_iter().fold(at_rest, |axes, turn| axes.map(|axis| by(axis, turn)))
    }

    /// Return the axes of the body and their origin, m, at time `t`, s, or at an earlier release.
    pub fn pose_at(&self, t: f64) -> ([[f64; 3]; 3], [f64; 3]) {
        let Some(laws) = self.laws() else { return self.pose([0.0; 3], []) };
        let t = self.release().map_or(t, |release| t.min(release));
        self.pose(laws.displacement(t).0, laws.turns().map(|(axis, angle)| (axis, angle.value(t))))
    }

    /// Return the axes of the body and their origin, m, after a displacement (m) and turns about axes by angles, rad.
    fn pose(
        &self,
        displacement: [f64; 3],
        turns: impl IntoIterator<Item = ([f64; 3], f64)>,
    ) -> ([[f64; 3]; 3], [f64; 3]) {
        let axes = self.axes(turns);
        let across = |p: [f64; 3], d: usize| dot(p, axes.map(|axis| axis[d]));
        let (position, pivot) = (vector(&self.position), vector(&self.pivot));
        (axes, [0, 1, 2].map(|d| position[d] + displacement[d] - across(pivot, d)))
    }

    /// Return the axes of the body at rest.
    pub(crate) fn axes_at_rest(&self) -> [[f64; 3]; 3] {
        self.axes([])
    }

    /// Return the shape with these axes and their origin, m, in a box with these ends, m.
    fn placed(&self, (axes, origin): ([[f64; 3]; 3], [f64; 3]), ends: &[[f64; 2]]) -> geometry::Shape {
        let across = |p: [f64; 3], d: usize| dot(p, axes.map(|axis| axis[d]));
        let place = |p: [f64; 3]| [0, 1, 2].map(|d| origin[d] + across(p, d));
        if let Some(outline) = self.shape.outline() {
            let [[a, b, _], [c, d, _], _] = axes;
            return geometry::Shape::Outline(Placed::new(outline, [[a, b], [c, d]], [origin[0], origin[1]]));
        }
        if let Some(solid) = self.shape.solid(ends) {
            let body = Placed::new(solid, axes, origin);
            return geometry::Shape::Solid(if self.shape.is_endless() { body.clamped(ends) } else { body });
        }
        if let Some(points) = self.shape.line() {
            let places = points.iter().map(|[x, y]| place([*x, *y, 0.0])).collect();
            return geometry::Shape::Chain(Chain::uniform(places, 0.0));
        }
        let (nodes, triangles) = self.shape.surface().unwrap_or_default();
        geometry::Shape::Surface(Surface::new(nodes.into_iter().map(place).collect(), triangles))
    }
}

impl Check for Body {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        self.shape.check_at(&format!("{key}.shape"), faults);
        self.check_passage(key, faults);
        self.reference.check_at(&format!("{key}.reference"), faults);
        self.check_release(&format!("{key}.mount"), faults);
        let Some(motion) = self.laws() else { return };
        for (name, law) in AXES.into_iter().zip(motion.along()).chain([("angle", &motion.angle)]) {
            law.check_at(&format!("{key}.motion.{name}"), faults);
        }
        motion.rotations.check_at(&format!("{key}.motion.rotations"), faults);
    }
}

impl Body {
    /// Check that it is on the mount at all times or released to it; `key` is the path of the mount.
    fn check_release(&self, key: &str, faults: &mut Faults) {
        let Some(mount) = &self.mount else { return };
        let (release, laws) = (mount.release, self.laws());
        faults.forbid(self.motion.is_some() && (laws.is_none() || release.is_none()), key, || match laws {
            Some(_) => "`motion` moves the body already; `release` is the time from which the mount does".into(),
            None => "the master moves the body already; remove one of the two".into(),
        });
        faults.forbid(self.motion.is_none() && release.is_some(), &format!("{key}.release"), || {
            "the body has no `motion` from which it could be released".into()
        });
    }

    /// Check that the mount does not stop it at its release; `key` is the path of the mount.
    fn check_held(&self, key: &str, is_space: bool, faults: &mut Faults) {
        let (Some(laws), Some(release)) = (self.laws(), self.release()) else { return };
        let (_, velocity) = laws.displacement(release);
        let turns: Vec<_> = laws.turns().map(|(axis, law)| (unit(axis), law.value_and_rate(release))).collect();
        // The angular velocity is half the sum of e × e' over the axes.
        let omega = [0, 1, 2]
            .map(|d| turned_at_rate(turns.iter().copied(), std::array::from_fn(|e| f64::from(u8::from(d == e)))));
        let omega = omega.iter().fold([0.0; 3], |sum, (e, rate)| {
            let own = cross(*e, *rate);
            std::array::from_fn(|d| sum[d] + 0.5 * own[d])
        });
        let sum = |laws: &mut dyn Iterator<Item = &TimeLaw>| laws.map(TimeLaw::largest_rate).sum::<f64>();
        let least = [sum(&mut laws.along().into_iter()), sum(&mut laws.turns().map(|(_, law)| law))];
        for own in self.freedoms(is_space).iter().filter(|own| own.support.is_none()) {
            let rate = if own.turns { omega[own.axis] } else { velocity[own.axis] };
            if rate.abs() > ALONG * least[usize::from(own.turns)] {
                let reason = "`motion` still moves the body in this direction at its release";
                faults.push(Fault::needed(&format!("{key}.{}", own.name), reason));
            }
        }
    }

    /// Check that a cylinder through the whole box lies along it.
    fn check_passage(&self, key: &str, faults: &mut Faults) {
        let Shape::CircularCylinder { axis, length: None, .. } = self.shape else { return };
        let axis = std::array::from_fn(|d| f64::from(u8::from(d == axis as usize)));
        let axis = self.turn.as_ref().map_or(axis, |turn| turned(axis, turn.unit_axis(), turn.angle));
        let is_oblique = axis.iter().filter(|part| part.abs() > ALONG).count() > 1;
        let mut turns = self.laws().into_iter().flat_map(BodyMotion::turns);
        let leaves =
            turns.any(|(about, angle)| angle.largest() > 0.0 && norm(cross(axis, about)) > ALONG * norm(about));
        let name = if is_oblique { "turn" } else { "motion.angle" };
        faults.forbid(is_oblique || leaves, &format!("{key}.{name}"), || {
            "a cylinder through the whole box lies along it: choose its `axis`, or give it a `length`".into()
        });
    }

    /// Return the laws that move the body, if there are any.
    pub fn laws(&self) -> Option<&BodyMotion> {
        if let Some(BodyDrive::Laws(laws)) = &self.motion { Some(laws) } else { None }
    }

    /// Return the time at which it is released from its laws, s.
    pub fn release(&self) -> Option<f64> {
        self.mount.as_ref().and_then(|mount| mount.release)
    }

    /// Return whether the master moves the body.
    pub fn is_driven(&self) -> bool {
        matches!(self.motion, Some(BodyDrive::Master(_)))
    }
}

impl Body {
    /// Return the volume, m³, and its moments of inertia about the axes of the body through the pivot for a density of 1,
    /// m⁵, in a box with these ends (m); in the plane the area and its moment about z. A line or a surface has none.
    pub(crate) fn displaced(&self, ends: &[[f64; 2]]) -> (f64, [f64; 3]) {
        let pivot = vector(&self.pivot);
        if let Some(Section { area, centroid, polar }) = self.shape.outline().map(|outline| outline.section()) {
            let arm = (pivot[0] - centroid[0]).powi(2) + (pivot[1] - centroid[1]).powi(2);
            return (area, [0.0, 0.0, polar + area * arm]);
        }
        let Some(solid) = self.shape.solid(ends) else { return (0.0, [0.0; 3]) };
        let (volume, own) = solid.inertia([0, 1, 2].map(|d| ends.get(d).map_or(0.0, |[low, high]| high - low)));
        (volume, [0, 1, 2].map(|d| own[d] + volume * (dot(pivot, pivot) - pivot[d].powi(2))))
    }
}
