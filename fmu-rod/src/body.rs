//! A rod in the plane or in space.

use adapter::{Dimensions, of_both};
use rod::{Error, Rod};
use scene::{Beam, Scene};

use crate::{contact, from_scene};

/// Parameters of a rod.
pub type Plan = Dimensions<rod::Parameters<2>, rod::Parameters<3>>;
/// A rod.
pub type Body = Dimensions<Rod<2>, Rod<3>>;
/// State of a [`Body`].
pub type BodyState = Dimensions<rod::RodState<2>, rod::RodState<3>>;

/// Return the parameters of the rod of a scene.
pub fn plan(scene: &Scene, beam: &Beam, rod: &scene::Rod) -> Plan {
    if scene.dimension(beam) == 2 {
        let contact = contact::in_plane(scene, beam, rod);
        return Plan::Plane(rod::Parameters { contact, ..from_scene::parameters(scene, beam, rod) });
    }
    let contact = contact::in_space(scene, beam, rod);
    Plan::Space(rod::Parameters { contact, ..from_scene::parameters(scene, beam, rod) })
}

/// Return the rod of a plan at rest, without loads.
pub fn build(plan: &Plan) -> Result<Body, Error> {
    Ok(of_both!(plan, parameters => Rod::new(parameters.clone())?))
}
