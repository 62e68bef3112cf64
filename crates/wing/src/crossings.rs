//! Triangles that cross each other: a wing passes through itself, for nothing holds its parts apart.

use crate::face::Face;
use crate::geometry::Vector;

/// Search along the x axis, with its scratch.
pub(crate) struct Crossings {
    /// Box around each triangle: its least and its greatest coordinates.
    boxes: Vec<[Vector; 2]>,
    /// Triangles by their least x.
    order: Vec<usize>,
}

impl Crossings {
    pub(crate) fn new(triangles: usize) -> Self {
        Self { boxes: vec![[Vector::zeros(); 2]; triangles], order: (0..triangles).collect() }
    }

    /// Return the number of pairs of triangles without a common corner that cross in the shape `x`.
    pub(crate) fn count(&mut self, faces: &[Face], x: &[Vector]) -> usize {
        let Self { boxes, order } = self;
        for (own, face) in boxes.iter_mut().zip(faces) {
            let [a, b, c] = face.nodes.map(|k| x[k]);
            *own = [a.inf(&b).inf(&c), a.sup(&b).sup(&c)];
        }
        order.sort_unstable_by(|&i, &j| boxes[i][0].x.total_cmp(&boxes[j][0].x));
        let mut found = 0;
        for (place, &i) in order.iter().enumerate() {
            let [low, high] = boxes[i];
            for &j in order[place + 1..].iter().take_while(|&&j| boxes[j][0].x <= high.x) {
                let [other_low, other_high] = boxes[j];
                let apart = (1..3).any(|d| other_low[d] > high[d] || other_high[d] < low[d]);
                let [own, other] = [faces[i].nodes, faces[j].nodes];
                if apart || own.iter().any(|k| other.contains(k)) {
                    continue;
                }
                let [own, other] = [own, other].map(|nodes| nodes.map(|k| x[k]));
                found += usize::from(pierces(&own, &other) || pierces(&other, &own));
            }
        }
        found
    }
}

/// Return whether an edge of one triangle passes through another; edges in its plane do not.
fn pierces(edges: &[Vector; 3], [a, b, c]: &[Vector; 3]) -> bool {
    let normal = (b - a).cross(&(c - a));
    let heights = edges.map(|p| normal.dot(&(p - a)));
    (0..3).any(|i| {
        let (h, next) = (heights[i], heights[(i + 1) % 3]);
        if h * next >= 0.0 {
            return false;
        }
        let through = edges[i] + (edges[(i + 1) % 3] - edges[i]) * (h / (h - next));
        [(a, b), (b, c), (c, a)].iter().all(|(p, q)| (*q - *p).cross(&(through - *p)).dot(&normal) >= 0.0)
    })
}
