//! The impulse that a surface is owed.
//!
//! A surface takes the announced load `f − D (v − v_n)`. D is a number for each node and acts across, while along the
//! surface the layer keeps its inertia. What the fluid gives depends on the motion of all nodes together. The difference
//! is small but not in the mean: a wing that beats would weigh a hundredth less or more. So its force and moment join the
//! next load, as a rigid motion of the impedance; surface and fluid then lose no momentum.

use nalgebra::{SMatrix, SVector};

use super::rigid::motion;
use crate::space::{Freedoms, Kinematics, Space, Vector, join, split};
use contact::{Loads, Stations};

/// The load that a surface takes.
pub struct Taken<const D: usize> {
    triangles: Vec<[usize; 3]>,
    /// Mass of the layer at each node, kg.
    layers: Vec<f64>,
    /// Normals of the nodes, of any length.
    across: Vec<Vector<D>>,
}

impl<const D: usize> Taken<D>
where
    [f64; D]: Space<D>,
{
    /// The load on a surface of nodes at rest (m) that takes a layer of fluid along, kg/m².
    pub fn new(nodes: &[[f64; 3]], triangles: &[[usize; 3]], layer: f64) -> Self {
        let mut layers = vec![0.0; nodes.len()];
        for corners in triangles {
            let area = mesh::triangle_area(&corners.map(|node| nodes[node]));
            corners.iter().for_each(|node| layers[*node] += area * layer / 3.0);
        }
        Self { triangles: triangles.to_vec(), layers, across: vec![Vector::zeros(); nodes.len()] }
    }

    /// Return the force (N) and the moment about the origin that the surface takes of announced loads in a step of `h` (s)
    /// between two places.
    pub fn sum(&mut self, h: f64, [before, now]: [&Stations<D>; 2], loads: &Loads<D>) -> Freedoms {
        self.across.fill(Vector::zeros());
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|node| at(&before.position, node));
            let normal = <[f64; D]>::components(<[f64; D]>::cross(&(b - a), &(c - a)));
            corners.iter().for_each(|node| self.across[*node] += Vector::from_fn(|axis, _| normal[axis]));
        }
        let (mut force, mut moment) = (Vector::zeros(), Default::default());
        for (node, (normal, layer)) in self.across.iter().zip(&self.layers).enumerate() {
            let impedance = loads.impedance[node];
            let along = if *layer > 0.0 { (layer / h).min(impedance) } else { impedance };
            let change = at(&now.velocity, node) - at(&before.velocity, node);
            let across = normal / normal.norm().max(f64::MIN_POSITIVE);
            let taken = at(&loads.force, node) - change * along - across * (across.dot(&change) * (impedance - along));
            force += taken;
            moment += <[f64; D]>::cross(&at(&now.position, node), &taken);
        }
        join(&force, moment)
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
