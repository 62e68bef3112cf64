//! Triangles of one surface that cross each other.

use crate::bounds::{Bounds, around, visit_near};
use crate::vector::{between, cross, dot, minus};

/// Search along the x axis, with its scratch.
#[derive(Debug)]
pub struct Crossings {
    /// Bounding box of each triangle.
    bounds: Vec<Bounds<3>>,
    /// Triangles by their least x.
    order: Vec<usize>,
}

impl Crossings {
    /// Prepare the search among so many triangles.
    pub fn new(triangles: usize) -> Self {
        Self { bounds: vec![[[0.0; 2]; 3]; triangles], order: (0..triangles).collect() }
    }

    /// Return the number of pairs of triangles without a common node that cross, from the nodes of each triangle and
    /// the position of each node, m.
    pub fn count(&mut self, triangle: impl Fn(usize) -> [usize; 3], position: impl Fn(usize) -> [f64; 3]) -> usize {
        let Self { bounds, order } = self;
        for (k, own) in bounds.iter_mut().enumerate() {
            *own = around(&triangle(k).map(&position));
        }
        let mut found = 0;
        visit_near(bounds, order, 0.0, |i, j| {
            let [own, other] = [triangle(i), triangle(j)];
            if !own.iter().any(|k| other.contains(k)) {
                let [own, other] = [own, other].map(|nodes| nodes.map(&position));
                found += usize::from(pierces(own, other) || pierces(other, own));
            }
        });
        found
    }
}

/// Return whether an edge of one triangle passes through another; edges in its plane do not.
fn pierces(edges: [[f64; 3]; 3], [a, b, c]: [[f64; 3]; 3]) -> bool {
    let normal = cross(minus(b, a), minus(c, a));
    let heights = edges.map(|p| dot(normal, minus(p, a)));
    (0..3).any(|i| {
        let (h, next) = (heights[i], heights[(i + 1) % 3]);
        if h * next >= 0.0 {
            return false;
        }
        let through = between(edges[i], edges[(i + 1) % 3], h / (h - next));
        [(a, b), (b, c), (c, a)].iter().all(|(p, q)| dot(cross(minus(*q, *p), minus(through, *p)), normal) >= 0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of each triangle one edge passes through the other. Whichever it is and whichever triangle comes first, wherever
    /// they lie, the pair is counted once; with a common node or apart it is not.
    #[test]
    fn triangles_that_pass_through_each_other_are_counted() {
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [0.1, 0.9, 0.0]];
        let steep = |z: f64| [[0.3, 0.2, z], [0.4, 0.3, z + 1.0], [1.6, 0.9, z + 0.2]];
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        let skew =
            |[x, y, z]: [f64; 3]| [0.6 * x - 0.8 * y, 0.48 * x + 0.36 * y - 0.8 * z, 0.64 * x + 0.48 * y + 0.6 * z];
        let turns = |[x, y, z]: [f64; 3]| [[x, y, z], [y, z, x], [z, x, y], skew([x, y, z])];
        for (z, met) in [(-0.1, 1), (0.1, 0), (-1.1, 0)] {
            let nodes = [flat, steep(z)].concat();
            for (turn, first, second) in (0..4).flat_map(|t| orders.iter().flat_map(move |a| orders.map(|b| (t, a, b))))
            {
                let (first, second) = (*first, second.map(|k| 3 + k));
                for pair in [[first, second], [second, first]] {
                    let found = Crossings::new(2).count(|k| pair[k], |node| turns(nodes[node])[turn]);
                    assert_eq!(found, met, "{pair:?} at {z}, turn {turn}");
                }
            }
        }
        let joined = [[0, 1, 2], [0, 4, 3]];
        assert_eq!(Crossings::new(2).count(|k| joined[k], |node| [flat, steep(-0.5)].concat()[node]), 0);
    }
}
