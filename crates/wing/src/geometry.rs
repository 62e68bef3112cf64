//! Edges and checks of a mesh.

use std::collections::HashMap;

use mesh::Mesh;
use nalgebra::Vector3;

use crate::{Error, WingError};

/// A point, a velocity or a force.
pub(crate) type Vector = Vector3<f64>;

/// Edge of the membrane: the places (triangle, corner opposite to the edge) of its one or two triangles.
pub(crate) struct MeshEdge {
    /// Ends, in the direction of the first triangle.
    pub(crate) nodes: [usize; 2],
    pub(crate) first: (usize, usize),
    pub(crate) second: Option<(usize, usize)>,
}

/// Geometry of a mesh.
pub(crate) trait Geometry {
    /// Return the position of node `k` at rest.
    fn node(&self, k: usize) -> Vector;

    /// Return the edges of the triangles, in the order of their first triangles.
    fn edges(&self) -> Result<Vec<MeshEdge>, Error>;

    /// Refuse numbers that are not finite, and corners that do not exist or coincide.
    fn check(&self) -> Result<(), Error>;
}

impl Geometry for Mesh {
    fn node(&self, k: usize) -> Vector {
        Vector::from(self.nodes[k])
    }

    fn edges(&self) -> Result<Vec<MeshEdge>, Error> {
        let mut edges: Vec<MeshEdge> = Vec::with_capacity(self.triangles.len() * 3 / 2 + 1);
        let mut places = HashMap::with_capacity(edges.capacity());
        for (t, corners) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                let nodes = [corners[(i + 1) % 3], corners[(i + 2) % 3]];
                let key = (nodes[0].min(nodes[1]), nodes[0].max(nodes[1]));
                let place = *places.entry(key).or_insert(edges.len());
                match edges.get_mut(place) {
                    None => edges.push(MeshEdge { nodes, first: (t, i), second: None }),
                    Some(edge) if edge.second.is_none() && edge.nodes[0] == nodes[1] => edge.second = Some((t, i)),
                    Some(_) => return Err(WingError::Edge { nodes, triangles: 2, triangle: t }.into()),
                }
            }
        }
        Ok(edges)
    }

    fn check(&self) -> Result<(), Error> {
        let count = self.nodes.len();
        if count < 2 {
            return Err(Error::value("mesh.nodes", count, "at least 2 nodes"));
        }
        if let Some(k) = self.nodes.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            return Err(Error::value(format!("mesh.nodes[{k}]"), &self.nodes[k][..], "finite"));
        }
        for (t, corners) in self.triangles.iter().enumerate() {
            let name = || format!("mesh.triangles[{t}]");
            if corners.iter().any(|&k| k >= count) {
                return Err(Error::value(name(), &corners[..], "three numbers of nodes, counted from 0"));
            }
            let [a, b, c] = corners.map(|k| self.node(k));
            let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
            // A triangle of less height has no reliable normal.
            let height = (b - a).cross(&(c - a)).norm() / (longest * longest);
            if height.is_nan() || height <= 1e-6 {
                return Err(Error::value(
                    name(),
                    &corners[..],
                    "a triangle with a height above 1e-6 of its longest edge",
                ));
            }
        }
        Ok(())
    }
}
