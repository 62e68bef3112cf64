//! The rule by which a surface takes the load of a fluid.
//!
//! The impedance D of a load acts across the surface. Along it the fluid slides, and the layer that moves with the surface
//! keeps its inertia: a layer of mass m at a node acts at the rate m/h in a step of length h, where that is less than D.

use crate::surface::twice_normal;

/// Layer of fluid that moves with a surface.
pub struct Layer {
    triangles: Vec<[usize; 3]>,
    /// Mass at each node, kg: `[nodes]`.
    masses: Vec<f64>,
    /// Normals of the nodes, weighted by areas: `[nodes]`.
    normals: Vec<[f64; 3]>,
}

impl Layer {
    /// Return a layer on triangles between so many `nodes`, each with the mass of its part, kg.
    pub fn new(nodes: usize, triangles: impl Iterator<Item = ([usize; 3], f64)>) -> Self {
        let mut layer = Self { triangles: Vec::new(), masses: vec![0.0; nodes], normals: vec![[0.0; 3]; nodes] };
        for (corners, mass) in triangles {
            corners.iter().for_each(|&node| layer.masses[node] += mass / 3.0);
            layer.triangles.push(corners);
        }
        layer
    }

    /// Find the normals of a shape, whose nodes are at `place`, m.
    pub fn find_normals(&mut self, place: impl Fn(usize) -> [f64; 3]) {
        self.normals.fill([0.0; 3]);
        for corners in &self.triangles {
            let normal = twice_normal(&corners.map(&place));
            for &node in corners {
                self.normals[node].iter_mut().zip(normal).for_each(|(sum, part)| *sum += part);
            }
        }
    }

    /// Return the normal of a node, of any length, and the rate (kg/s) of its load along the surface in a step of `h` (s),
    /// if `impedance` (kg/s) is the rate across.
    ///
    /// Without a layer, as on a vein beside a membrane, both rates are the same.
    pub fn rate(&self, node: usize, impedance: f64, h: f64) -> ([f64; 3], f64) {
        let mass = self.masses[node];
        (self.normals[node], if mass > 0.0 { (mass / h).min(impedance) } else { impedance })
    }
}

#[cfg(test)]
#[path = "layer/tests.rs"]
mod tests;
