//! What rods and wings of a scene touch, as obstacles.

use contact::Obstacle;
use scene::{Body, Scene};

/// Return the solids that rods and wings touch, each as `make` makes it, then the walls.
pub fn obstacles<const D: usize>(scene: &Scene, make: impl Fn(&Body) -> Option<Obstacle<D>>) -> Vec<Obstacle<D>> {
    let walls = scene.contact_walls().into_iter().map(|(point, normal)| {
        let [point, normal] = [point, normal].map(|vector| std::array::from_fn(|d| vector[d]));
        Obstacle::plane(point, normal)
    });
    scene.contact_bodies().iter().filter_map(make).chain(walls).collect()
}

/// Return them in space.
pub fn obstacles_in_space(scene: &Scene) -> Vec<Obstacle<3>> {
    obstacles(scene, solid_of)
}

/// Return a body in space, without an end where it has none.
pub fn solid_of(body: &Body) -> Option<Obstacle<3>> {
    let endless = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
    Obstacle::of_solid(&body.shape.solid(&endless)?, body.place_at(0.0))
}
