//! What the rods of a scene touch, and what is wrong with its contact.

use method::Bending;

use crate::body::Body;
use crate::contact::Contact;
use crate::fault::{Check, Faults};
use crate::scene::{BeamWithRod, Scene};
use crate::shape::Shape;

/// Steps in the shortest contact, for the default stiffness.
const STEPS: f64 = 10.0;

/// Cells of the fluid in the default range.
const RANGE_CELLS: f64 = 2.0;

/// A half space: a point of its plane, m, and the normal outwards.
pub type HalfSpace = ([f64; 3], [f64; 3]);

impl Contact {
    /// Return the gap at which the force begins on a rod of this scene, m.
    pub fn range(&self, scene: &Scene, own: &BeamWithRod) -> f64 {
        let thickness = own.beam.places().map(|s| own.beam.thickness.at(s)).fold(f64::INFINITY, f64::min);
        let cells = scene.fluid.iter().flat_map(|fluid| fluid.spacing()).fold(0.0, f64::max);
        self.range.unwrap_or(if cells > 0.0 { RANGE_CELLS * cells } else { thickness })
    }

    /// Return the stiffness per metre of a rod of this scene, N/m².
    pub fn stiffness(&self, scene: &Scene, own: &BeamWithRod) -> f64 {
        let Some(rod) = own.rod else { return 0.0 };
        let density = |s: f64| rod.material.section(&own.beam.thickness, s).line_density;
        let lightest = own.beam.places().map(density).fold(f64::INFINITY, f64::min);
        let step = rod.max_step.unwrap_or(f64::INFINITY).min(scene.time.communication_step);
        self.stiffness.unwrap_or(lightest * (std::f64::consts::PI / (STEPS * step)).powi(2))
    }
}

impl Scene {
    /// Return the solids that rods touch: those of `contact`, and those of the fluid that are still or moved by laws.
    pub fn contact_bodies(&self) -> Vec<Body> {
        let Some(contact) = &self.contact else { return Vec::new() };
        let of_fluid = self.fluid.iter().flat_map(|fluid| fluid.obstacles()).map(|own| own.body);
        let of_fluid = of_fluid.filter(|body| body.mount.is_none() && !body.is_driven());
        contact.obstacles.iter().cloned().chain(of_fluid).collect()
    }

    /// Return the walls that rods touch.
    pub fn contact_walls(&self) -> Vec<HalfSpace> {
        let channel = self.fluid.as_ref().filter(|_| self.contact.is_some()).and_then(|fluid| fluid.channel.as_ref());
        let walls = channel.map_or([None; 3], |channel| [channel.x, channel.y, channel.z]);
        let along = |axis: usize, size: f64| std::array::from_fn(|d| if d == axis { size } else { 0.0 });
        let pair = |(axis, ends): (usize, Option<[f64; 2]>)| {
            ends.map(|[low, high]| [(along(axis, low), along(axis, 1.0)), (along(axis, high), along(axis, -1.0))])
        };
        walls.into_iter().enumerate().filter_map(pair).flatten().collect()
    }
}

/// Check the contact of a scene.
pub(crate) fn check(scene: &Scene, faults: &mut Faults) {
    let Some(contact) = &scene.contact else { return };
    let rods: Vec<_> = scene.beams_with_rods().filter_map(|own| own.rod.map(|_| scene.dimension(own.beam))).collect();
    let is_space = rods.first() == Some(&3);
    faults.forbid(rods.is_empty(), "contact", || "the scene has no rod, and only rods touch".into());
    let projected = scene.beams_with_rods().any(|own| own.rod.is_some_and(|rod| rod.bending == Bending::Projected));
    faults.forbid(projected, "contact", || "a rod with projected bending cannot turn as contact may want".into());
    for (i, body) in contact.obstacles.iter().enumerate() {
        let key = format!("contact.obstacles[{i}]");
        body.check_at(&key, faults);
        body.check_dimension(&key, is_space, faults);
        let count = if is_space { 3 } else { 2 };
        let place = format!("{:?}", body.position);
        faults.require(body.position.len() == count, &format!("{key}.position"), place, || {
            format!("it must have {count} components like the beam")
        });
        let free = body.mount.is_some() || body.is_driven();
        faults.forbid(free, &format!("{key}.{}", if body.mount.is_some() { "mount" } else { "motion" }), || {
            "an obstacle is still or moved by laws".into()
        });
        faults
            .forbid(body.reference.is_some(), &format!("{key}.reference"), || "an obstacle has no coefficients".into());
    }
    let of_fluid = scene.fluid.iter().flat_map(|fluid| fluid.obstacles()).map(|own| (own.key, own.body));
    let own = contact.obstacles.iter().cloned().enumerate().map(|(i, body)| (format!("contact.obstacles[{i}]"), body));
    for (key, body) in own.chain(of_fluid).filter(|(_, body)| !has_contact(&body.shape)) {
        let (_, name) = body.shape.dimension(is_space);
        faults.require(false, &format!("{key}.shape"), name, || {
            "rods touch a circle, rectangle, sphere, cuboid, circular_cylinder or capsule".into()
        });
    }
}

/// Return whether rods touch a shape.
fn has_contact(shape: &Shape) -> bool {
    matches!(
        shape,
        Shape::Circle { .. }
            | Shape::Rectangle { .. }
            | Shape::Sphere { .. }
            | Shape::Cuboid { .. }
            | Shape::CircularCylinder { .. }
            | Shape::Capsule { .. }
    )
}
