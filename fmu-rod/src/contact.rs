//! Conversion of the contact of a scene to that of a rod.

use rod::{Contact, Obstacle, Pose};
use scene::{Beam, BeamWithRod, Body, Scene};

/// Return what the rod touches: the solids of the scene, each as `place` makes it, then the walls.
pub fn of_rod<const D: usize>(
    scene: &Scene,
    beam: &Beam,
    rod: &scene::Rod,
    place: impl Fn(&Body) -> Option<Obstacle<D>>,
) -> Option<Contact<D>> {
    let contact = scene.contact.as_ref()?;
    let own = BeamWithRod { number: None, name: None, beam, rod: Some(rod) };
    let radius: Vec<_> = beam.places().step_by(2).map(|s| 0.5 * beam.thickness.at(s)).collect();
    let law = contact.law(scene, &own);
    let walls = scene.contact_walls().into_iter().map(|(point, normal)| {
        let [point, normal] = [point, normal].map(|vector| std::array::from_fn(|d| vector[d]));
        Obstacle::plane(point, normal)
    });
    let obstacles = scene.contact_bodies().iter().filter_map(place).chain(walls).collect();
    Some(Contact { law, radius, with_itself: true, obstacles })
}

/// Return the place of a solid at time `t`, s.
pub fn pose<const D: usize>(body: &Body, t: f64) -> Pose<D> {
    let (axes, origin) = body.pose_at(t);
    let vector = |own: [f64; 3]| std::array::from_fn::<f64, D, _>(|d| own[d]).into();
    Pose { axes: std::array::from_fn(|d| vector(axes[d])), origin: vector(origin) }
}

#[cfg(test)]
#[path = "contact/tests.rs"]
mod tests;
