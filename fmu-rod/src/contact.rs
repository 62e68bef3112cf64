//! Conversion of the contact of a scene to that of a rod.

use adapter::{obstacles, obstacles_in_space};
use rod::{Contact, Obstacle};
use scene::{Beam, BeamWithRod, Scene};

/// Return what a rod in the plane touches.
pub fn in_plane(scene: &Scene, beam: &Beam, rod: &scene::Rod) -> Option<Contact<2>> {
    let make = |body: &scene::Body| Obstacle::of_outline(&body.shape.outline()?, body.place_at(0.0));
    of_rod(scene, beam, rod, || obstacles(scene, make))
}

/// Return what a rod in space touches.
pub fn in_space(scene: &Scene, beam: &Beam, rod: &scene::Rod) -> Option<Contact<3>> {
    of_rod(scene, beam, rod, || obstacles_in_space(scene))
}

fn of_rod<const D: usize>(
    scene: &Scene,
    beam: &Beam,
    rod: &scene::Rod,
    obstacles: impl Fn() -> Vec<Obstacle<D>>,
) -> Option<Contact<D>> {
    let contact = scene.contact.as_ref()?;
    let own = BeamWithRod { number: None, name: None, beam, rod: Some(rod) };
    let radius: Vec<_> = beam.places().step_by(2).map(|s| 0.5 * beam.thickness.at(s)).collect();
    Some(Contact { law: contact.law(scene, &own), radius, with_itself: true, obstacles: obstacles() })
}
