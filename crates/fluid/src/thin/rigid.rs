//! Thin rigid bodies: their nodes move with the body, and on springs the forces on their markers respond.

use super::markers::Markers;
use crate::bodies::{Drag, Rigid, velocity_of};
use crate::force::Force;
use crate::parameters::Body;
use crate::space::{Freedoms, Kinematics, Space, Spin, Vector};
use contact::Stations;

/// The nodes of a thin rigid body.
pub struct RigidNodes<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Nodes from the pivot in the axes of the body, m.
    rest: Vec<Vector<D>>,
    /// Nodes at the present place, the pivot, and its velocity.
    pub nodes: Stations<D>,
    pub pivot: Vector<D>,
    pub velocity: Vector<D>,
    /// Angular velocity, rad/s.
    pub spin: Spin<D>,
    /// Whether the fluid moves the body in the present step.
    pub on_springs: bool,
}

/// Responses of the forces on all markers, over the density, to each freedom of a thin rigid body: m²/s and m³/s, in
/// space m³/s and m⁴/s.
pub type Responses<const D: usize> = Vec<Vec<Vector<D>>>;

impl<const D: usize> RigidNodes<D>
where
    [f64; D]: Space<D>,
{
    /// The nodes of a body at places in its axes, m.
    pub fn new(rest: &[[f64; D]], body: &Body<D>) -> Self {
        let from_pivot = rest.iter().map(|node| Vector::from(*node) - Vector::from(body.pivot));
        let on_springs = body.mount().is_some();
        Self {
            rest: from_pivot.collect(),
            nodes: Stations::at_rest(rest),
            pivot: Vector::zeros(),
            velocity: Vector::zeros(),
            spin: Default::default(),
            on_springs,
        }
    }

    /// Move to the place of the body.
    pub fn place(&mut self, rigid: &Rigid<D>) {
        let rates = rigid.pose.rates();
        self.on_springs = rigid.mount().is_some();
        (self.pivot, self.velocity, self.spin) = (rigid.pose.position, rigid.pose.velocity, rigid.pose.omega);
        for (k, rest) in self.rest.iter().enumerate() {
            let arm = <[f64; D]>::turn(&rigid.orientation, *rest);
            let (place, velocity) = (rigid.pose.position + arm, velocity_of(&rates, &arm));
            for axis in 0..D {
                (self.nodes.position[axis][k], self.nodes.velocity[axis][k]) = (place[axis], velocity[axis]);
            }
        }
    }
}

/// Return the velocity of a marker at `arm` (m) in the unit motion of a freedom.
pub fn motion<const D: usize>(freedom: usize, arm: &Vector<D>) -> Vector<D>
where
    [f64; D]: Space<D>,
{
    Vector::from(<[f64; D]>::jacobian(1.0, (*arm).into()).map(|along| along[freedom]))
}

/// Return the drag of a body with some markers, and how it falls with the velocities of the body.
pub fn drag<const D: usize>(
    force: Force<D>,
    own: impl Iterator<Item = usize>,
    centre: &Vector<D>,
    markers: &Markers<D>,
    responses: &Responses<D>,
    density: f64,
) -> Drag<D>
where
    [f64; D]: Space<D>,
{
    let mut impedance = [[0.0; 6]; 6];
    for k in own {
        let arm = markers.get(k).position - centre;
        for (freedom, row) in impedance.iter_mut().enumerate().take(<[f64; D]>::FREEDOMS) {
            let to = motion(freedom, &arm) * density;
            row.iter_mut().zip(responses).for_each(|(entry, from)| *entry += to.dot(&from[k]));
        }
    }
    Drag { force, impedance }
}

/// Return the matrix along the freedoms of a share of the layer of some markers that moves along the body, kg: the fluid
/// slides there and does not take it along.
pub fn sliding<const D: usize>(
    own: impl Iterator<Item = usize>,
    centre: &Vector<D>,
    markers: &Markers<D>,
    density: f64,
) -> [Freedoms; 6]
where
    [f64; D]: Space<D>,
{
    let mut matrix = [[0.0; 6]; 6];
    for k in own {
        let marker = markers.get(k);
        let motions = std::array::from_fn::<_, 6, _>(|freedom| match freedom < <[f64; D]>::FREEDOMS {
            true => marker.along * motion(freedom, &(marker.position - centre)),
            false => Vector::zeros(),
        });
        for (row, of_row) in matrix.iter_mut().zip(&motions) {
            row.iter_mut().zip(&motions).for_each(|(entry, of)| *entry += density * marker.layer * of_row.dot(of));
        }
    }
    matrix
}

/// Change the forces on all markers, and the velocities of the body's own, by a change of its velocities.
pub fn change<const D: usize>(
    change: &Freedoms,
    own: impl Iterator<Item = usize>,
    centre: &Vector<D>,
    responses: &Responses<D>,
    markers: &mut Markers<D>,
    force: &mut [Vector<D>],
) where
    [f64; D]: Space<D>,
{
    for (response, change) in responses.iter().zip(change) {
        force.iter_mut().zip(response).for_each(|(force, response)| *force -= response * *change);
    }
    for k in own {
        let marker = markers.get_mut(k);
        marker.velocity += velocity_of(change, &(marker.position - centre));
    }
}
