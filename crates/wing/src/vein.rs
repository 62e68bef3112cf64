//! Segments and vertices of veins: the springs of the rod.

use rod::{CosineSlope, Edge, VertexDerivatives};

use crate::geometry::Vector;

/// Limit of 1 + cos of the turning angle of a vein; beyond it the vein counts as folded.
const FOLD: f64 = 1e-12;

/// Axial spring between two nodes.
pub(crate) struct Segment {
    pub(crate) nodes: [usize; 2],
    /// Length at rest, m.
    pub(crate) length: f64,
    /// EA/l, N/m.
    pub(crate) stiffness: f64,
    /// Mass, kg.
    pub(crate) mass: f64,
}

/// Bending spring at a node.
pub(crate) struct Vertex {
    /// Node before; `None` stands for the direction of the support.
    pub(crate) before: Option<usize>,
    /// The node and the node after it.
    pub(crate) nodes: [usize; 2],
    /// Unit tangent of the support at rest.
    pub(crate) direction: Vector,
    /// EI by the length of vein that belongs to the vertex, N m.
    pub(crate) stiffness: f64,
}

impl Vertex {
    /// Return both edges and 1 + cos of the angle between them; `None` at a fold.
    fn edges(&self, x: &[Vector], direction: Vector) -> Option<(Edge<3>, Edge<3>, f64)> {
        let [node, next] = self.nodes.map(|k| x[k]);
        let before = match self.before {
            Some(k) => Edge::between(x[k], node),
            None => Edge::between(node - direction, node),
        };
        let after = Edge::between(node, next);
        let above_fold = 1.0 + before.t.dot(&after.t);
        (above_fold > FOLD).then_some((before, after, above_fold))
    }

    /// Return the energy, J.
    pub(crate) fn energy(&self, x: &[Vector], direction: Vector) -> Option<f64> {
        let (before, after, above_fold) = self.edges(x, direction)?;
        Some(self.stiffness * (after.t - before.t).norm_squared() / above_fold)
    }

    /// Return the gradient by the edges before and after, N.
    pub(crate) fn gradient(&self, x: &[Vector], direction: Vector) -> Option<[Vector; 2]> {
        let (before, after, above_fold) = self.edges(x, direction)?;
        let slope = CosineSlope::new(before, after, above_fold, self.stiffness);
        Some([slope.c_by_before * slope.by_c, slope.c_by_after * slope.by_c])
    }

    /// Return the derivatives by the edges before and after.
    pub(crate) fn derivatives(&self, x: &[Vector], direction: Vector) -> Option<VertexDerivatives<3>> {
        let (before, after, above_fold) = self.edges(x, direction)?;
        let slope = CosineSlope::new(before, after, above_fold, self.stiffness);
        Some(VertexDerivatives::straight(before, after, &slope))
    }
}
