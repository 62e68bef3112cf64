//! Nodes, triangles and chains.

/// Nodes at rest and the triangles between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions of the nodes at rest, m.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of the triangles, all with the same sense of rotation.
    pub triangles: Vec<[usize; 3]>,
    /// Named chains of nodes along edges: veins, or the line of the root.
    pub chains: Vec<Chain>,
}

/// Named chain of nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    /// Name.
    pub name: String,
    /// Nodes in order.
    pub nodes: Vec<usize>,
}

/// Return the normal of a triangle times twice its area, m².
pub(crate) fn twice_normal([a, b, c]: &[[f64; 3]; 3]) -> [f64; 3] {
    let [p, q] = [b, c].map(|end| [0, 1, 2].map(|axis| end[axis] - a[axis]));
    [0, 1, 2].map(|axis| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        p[i] * q[j] - p[j] * q[i]
    })
}

/// Return the area of a triangle, m².
pub fn triangle_area(corners: &[[f64; 3]; 3]) -> f64 {
    0.5 * twice_normal(corners).iter().map(|component| component.powi(2)).sum::<f64>().sqrt()
}

/// Return the area of triangles, m².
pub fn area(nodes: &[[f64; 3]], triangles: &[[usize; 3]]) -> f64 {
    triangles.iter().map(|corners| triangle_area(&corners.map(|node| nodes[node]))).sum()
}

impl Mesh {
    /// Return the nodes of the chain `name`.
    pub fn chain(&self, name: &str) -> Option<&[usize]> {
        self.chains.iter().find(|chain| chain.name == name).map(|chain| &chain.nodes[..])
    }
}
