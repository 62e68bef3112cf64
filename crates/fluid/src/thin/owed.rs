//! The impulse that a surface is owed.
//!
//! A surface takes the announced load `f − D (v − v_n)`, with a number D for each node, by the rule of [`mesh::Layer`]. What
//! the fluid gives depends on the motion of all nodes together. The difference is small, but its mean does not vanish: a
//! wing that beats would weigh a hundredth more or less. So its force and moment join the next load, as a rigid motion of
//! the impedance; surface and fluid then lose no momentum.

use std::array::from_fn;

use mesh::Layer;
use nalgebra::{SMatrix, SVector};

use super::rigid::motion;
use crate::space::{Freedoms, Kinematics, Space, Vector, join, split};
use contact::{Loads, Stations};

/// The load that a surface takes.
pub struct Taken {
    layer: Layer,
}

impl Taken {
    /// The load on a surface of nodes at rest (m) that takes a layer of fluid along, kg/m².
    pub fn new(nodes: &[[f64; 3]], triangles: &[[usize; 3]], layer: f64) -> Self {
        let area = |corners: &[usize; 3]| mesh::triangle_area(&corners.map(|node| nodes[node]));
        let masses = triangles.iter().map(|corners| (*corners, area(corners) * layer));
        Self { layer: Layer::new(nodes.len(), masses) }
    }

    /// Return the force (N) and the moment about the origin that the surface takes of announced loads in a step of `h` (s)
    /// between two places.
    pub fn sum<const D: usize>(&mut self, h: f64, [before, now]: [&Stations<D>; 2], loads: &Loads<D>) -> Freedoms
    where
        [f64; D]: Space<D>,
    {
        self.layer.find_normals(|node| from_fn(|axis| before.position.get(axis).map_or(0.0, |along| along[node])));
        let (mut force, mut moment) = (Vector::zeros(), Default::default());
        for (node, &impedance) in loads.impedance.iter().enumerate() {
            let (normal, along) = self.layer.rate(node, impedance, h);
            let normal = Vector::<D>::from_fn(|axis, _| normal[axis]);
            let change = at(&now.velocity, node) - at(&before.velocity, node);
            let across = normal / normal.norm().max(f64::MIN_POSITIVE);
            let taken = at(&loads.force, node) - change * along - across * (across.dot(&change) * (impedance - along));
            force += taken;
            moment += <[f64; D]>::cross(&at(&now.position, node), &taken);
        }
        join(&force, moment)
    }

    /// Return the part of a change of the velocity of a node that lowers a load of contact, see
    /// [`super::ThinBodies::taken`], with the normals of [`Self::sum`]: along the surface a node answers to the rate of its
    /// layer at most.
    pub fn of_contact<const D: usize>(
        &self,
        h: f64,
        node: usize,
        [of_fluid, of_contact]: [f64; 2],
        change: Vector<D>,
    ) -> Vector<D> {
        let (normal, before) = self.layer.rate(node, of_fluid, h);
        let (_, all) = self.layer.rate(node, of_fluid + of_contact, h);
        let normal = Vector::<D>::from_fn(|axis, _| normal[axis]);
        let across = normal * (normal.dot(&change) / normal.norm_squared().max(f64::MIN_POSITIVE));
        across + (change - across) * ((all - before) / of_contact.max(f64::MIN_POSITIVE))
    }
}

/// Add a force (N) and a moment about the origin to the loads on some stations, as a rigid motion of their impedance.
pub fn pay<const D: usize>(owed: &Freedoms, stations: &Stations<D>, loads: &mut Loads<D>)
where
    [f64; D]: Space<D>,
{
    let whole: f64 = loads.impedance.iter().sum();
    let place = |node: usize| at(&stations.position, node);
    let weighed = loads.impedance.iter().enumerate().map(|(node, impedance)| place(node) * *impedance);
    let middle = weighed.sum::<Vector<D>>() / whole;
    let motions = |node: usize| {
        let arm = place(node) - middle;
        (0..<[f64; D]>::FREEDOMS).map(move |freedom| (freedom, motion(freedom, &arm)))
    };
    let (force, moment) = split(owed);
    let owed = join(&force, moment - <[f64; D]>::cross(&middle, &force));
    let mut matrix = SMatrix::<f64, 6, 6>::identity();
    matrix.view_mut((0, 0), (<[f64; D]>::FREEDOMS, <[f64; D]>::FREEDOMS)).fill(0.0);
    for (node, impedance) in loads.impedance.iter().enumerate() {
        for (i, row) in motions(node) {
            motions(node).for_each(|(j, column)| matrix[(i, j)] += impedance * row.dot(&column));
        }
    }
    // Without an impedance, or with all of it in a line, nothing can be paid.
    let Some(factor) = matrix.cholesky() else { return };
    let shares = factor.solve(&SVector::from(owed));
    for node in 0..stations.len() {
        let along = motions(node).map(|(freedom, motion)| motion * shares[freedom]).sum::<Vector<D>>();
        (0..D).for_each(|axis| loads.force[axis][node] += along[axis] * loads.impedance[node]);
    }
}

fn at<const D: usize>(of_nodes: &[Vec<f64>; D], node: usize) -> Vector<D> {
    of_nodes.each_ref().map(|along| along[node]).into()
}
