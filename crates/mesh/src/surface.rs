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

impl Mesh {
    /// Return the nodes of the chain `name`.
    pub fn chain(&self, name: &str) -> Option<&[usize]> {
        self.chains.iter().find(|chain| chain.name == name).map(|chain| &chain.nodes[..])
    }
}
