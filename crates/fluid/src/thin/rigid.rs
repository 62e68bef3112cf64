//! Thin rigid bodies: their nodes move with the body, and on springs the forces on their markers respond.

use super::markers::Markers;
use crate::bodies::{Drag, Rigid, velocity_of};
use crate::force::Force;
use crate::space::{Freedoms, Space, Vector};
use crate::stations::Stations;

/// The nodes of a thin rigid body.
pub struct RigidNodes<const D: usize> {
    /// Nodes from the pivot in the axes of the body, m.
    rest: Vec<Vector<D>>,
    /// Nodes at the present place, and the pivot.
    pub nodes: Stations<D>,
    pub pivot: Vector<D>,
}

/// Responses of the forces on all markers to motions of a thin rigid body, over the density: to a velocity of the pivot
/// along an axis, then to one along an axis in proportion to the arm along each axis, m²/s and m³/s.
pub type Responses = Vec<Vec<f64>>;

impl<const D: usize> RigidNodes<D>
where
    [f64; D]: Space<D>,
{
    /// Nodes at places in the axes of the body, m, with its pivot there.
    pub fn new(rest: &[[f64; D]], pivot: [f64; D]) -> Self {
        let from_pivot = rest.iter().map(|node| Vector::from(*node) - Vector::from(pivot));
        Self { rest: from_pivot.collect(), nodes: Stations::at_rest(rest), pivot: Vector::zeros() }
    }

    /// Move to the place of the body.
    pub fn place(&mut self, rigid: &Rigid<D>) {
        let rates = rigid.pose.rates();
        self.pivot = rigid.pose.position;
        for (k, rest) in self.rest.iter().enumerate() {
            let arm = <[f64; D]>::turn(&rigid.orientation, *rest);
            let (place, velocity) = (rigid.pose.position + arm, velocity_of(&rates, &arm));
            for axis in 0..D {
                (self.nodes.position[axis][k], self.nodes.velocity[axis][k]) = (place[axis], velocity[axis]);
            }
        }
    }
}

/// Return the motion of a marker at `arm` (m) to which response number `k` belongs.
pub fn motion<const D: usize>(k: usize, arm: &Vector<D>) -> f64 {
    if k == 0 { 1.0 } else { arm[k - 1] }
}

/// Return, for each axis, the force on marker `k` for each freedom of the body.
fn response<const D: usize>(responses: &Responses, k: usize) -> [Freedoms; D]
where
    [f64; D]: Space<D>,
{
    <[f64; D]>::jacobian(responses[0][k], std::array::from_fn(|axis| responses[1 + axis][k]))
}

/// Return the drag of a body with some markers, and how it falls with the velocities of the body.
pub fn drag<const D: usize>(
    force: Force<D>,
    own: impl Iterator<Item = usize>,
    centre: &Vector<D>,
    markers: &Markers<D>,
    responses: &Responses,
    density: f64,
) -> Drag<D>
where
    [f64; D]: Space<D>,
{
    let mut impedance = [[0.0; 6]; 6];
    for k in own {
        let arm = Vector::from(markers.get(k).position) - centre;
        let (along, response) = (<[f64; D]>::jacobian(1.0, arm.into()), response::<D>(responses, k));
        for (to, from) in along.iter().zip(response) {
            for (row, to) in impedance.iter_mut().zip(to).take(<[f64; D]>::FREEDOMS) {
                row.iter_mut().zip(from).for_each(|(entry, from)| *entry += to * density * from);
            }
        }
    }
    Drag { force, impedance }
}

/// Change the forces on all markers, and the velocities of the body's own, by a change of its velocities.
pub fn change<const D: usize>(
    change: &Freedoms,
    own: impl Iterator<Item = usize>,
    centre: &Vector<D>,
    responses: &Responses,
    markers: &mut Markers<D>,
    force: &mut [Vec<f64>; D],
) where
    [f64; D]: Space<D>,
{
    for k in 0..markers.len() {
        for (force, response) in force.iter_mut().zip(response::<D>(responses, k)) {
            force[k] -= response.iter().zip(change).map(|(response, change)| response * change).sum::<f64>();
        }
    }
    for k in own {
        let marker = markers.get_mut(k);
        let velocity = velocity_of(change, &(Vector::from(marker.position) - centre));
        marker.velocity.iter_mut().zip(&velocity).for_each(|(own, change)| *own += change);
    }
}
