//! What is wrong with a mesh.

use std::collections::HashMap;

use geometry::vector::{cross, dot, minus, norm};

use crate::surface::Mesh;

/// Longest edge and largest coordinate, and shortest longest edge of a triangle, m: squares of areas are normal numbers.
const LONGEST: f64 = 1e30;
const SHORTEST: f64 = 1e-30;

/// Least height of a triangle by its longest edge: one of less has no reliable normal.
const LEAST_HEIGHT: f64 = 1e-6;

/// Largest turn of a straight chain, rad: an angle from coordinates in single precision.
const STRAIGHT: f64 = 1e-6;

/// Distance of nodes in one place by the shortest edge of the mesh.
const ONE_PLACE: f64 = 1e-3;

/// Direction in which nodes of a regular mesh have different places.
const SKEW: [f64; 3] = [0.739_085, 0.550_318, 0.388_461];

/// What is wrong at one place of a mesh: `key` is `value`, but it must be `allowed`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flaw {
    /// `nodes[k]` or `triangles[t]`.
    pub key: String,
    /// Value there, as text.
    pub value: String,
    /// Allowed values, as the end of the sentence "but it must be …".
    pub allowed: &'static str,
}

/// Edge of the triangles: the places (triangle, corner opposite to the edge) of its one or two triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshEdge {
    /// Ends, in the direction of the first triangle.
    pub nodes: [usize; 2],
    /// First triangle.
    pub first: (usize, usize),
    /// Second triangle; `None` at the rim.
    pub second: Option<(usize, usize)>,
}

/// How a chain fails to be straight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bend {
    /// Neighbours lie in one place.
    Point,
    /// The chain turns there.
    Turn,
    /// The chain folds back there.
    Fold,
}

impl Mesh {
    /// Return the edges of the triangles, in the order of their first triangles.
    ///
    /// # Errors
    /// The first coordinate that is no number of a length, triangle that is flat or names nodes that do not exist, or
    /// edge of two triangles with opposite senses of rotation or of more.
    pub fn edges(&self) -> Result<Vec<MeshEdge>, Flaw> {
        if let Some(k) = self.nodes.iter().position(|node| !node.iter().all(|x| x.abs() <= LONGEST)) {
            let allowed = "a list of numbers from -1e30 to 1e30";
            return Err(Flaw { key: format!("nodes[{k}]"), value: format!("{:?}", self.nodes[k]), allowed });
        }
        let mut edges: Vec<MeshEdge> = Vec::with_capacity(self.triangles.len() * 3 / 2 + 1);
        let mut places = HashMap::with_capacity(edges.capacity());
        for (t, corners) in self.triangles.iter().enumerate() {
            let refuse = |allowed| Flaw { key: format!("triangles[{t}]"), value: format!("{corners:?}"), allowed };
            if corners.iter().any(|k| *k >= self.nodes.len()) {
                return Err(refuse("three numbers of nodes, counted from 0"));
            }
            let [a, b, c] = corners.map(|k| self.nodes[k]);
            let longest = [minus(b, a), minus(c, b), minus(a, c)].map(norm).into_iter().fold(0.0, f64::max);
            let height = norm(cross(minus(b, a), minus(c, a))) / (longest * longest);
            if !(longest >= SHORTEST && height > LEAST_HEIGHT) {
                return Err(refuse("a triangle with a height above 1e-6 of its longest edge, of at least 1e-30 m"));
            }
            for i in 0..3 {
                let nodes = [corners[(i + 1) % 3], corners[(i + 2) % 3]];
                let key = (nodes[0].min(nodes[1]), nodes[0].max(nodes[1]));
                let place = *places.entry(key).or_insert(edges.len());
                match edges.get_mut(place) {
                    None => edges.push(MeshEdge { nodes, first: (t, i), second: None }),
                    Some(edge) if edge.second.is_none() && edge.nodes[0] == nodes[1] => edge.second = Some((t, i)),
                    Some(_) => {
                        return Err(refuse(
                            "the only triangle at each of its edges in its direction: the triangles of a surface have \
                             the same sense of rotation",
                        ));
                    }
                }
            }
        }
        Ok(edges)
    }

    /// Return the first node that is in no triangle and on none of the `chains`.
    pub fn unused<'a>(&self, chains: impl Iterator<Item = &'a [usize]>) -> Option<usize> {
        let mut used = vec![false; self.nodes.len()];
        self.triangles.iter().flatten().copied().chain(chains.flatten().copied()).for_each(|k| used[k] = true);
        used.iter().position(|used| !used)
    }

    /// Return the least node of the part to which each node belongs: corners of a triangle and neighbours on one of the
    /// `chains` are of one part.
    pub fn parts<'a>(&self, chains: impl Iterator<Item = &'a [usize]>) -> Vec<usize> {
        fn least(part: &mut [usize], mut k: usize) -> usize {
            while part[k] != k {
                part[k] = part[part[k]];
                k = part[k];
            }
            k
        }
        let mut part: Vec<_> = (0..self.nodes.len()).collect();
        let sides = self.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c]]);
        for ends in sides.chain(chains.flat_map(|chain| chain.windows(2).map(|ends| [ends[0], ends[1]]))) {
            let [a, b] = ends.map(|k| least(&mut part, k));
            part[a.max(b)] = a.min(b);
        }
        (0..part.len()).map(|k| least(&mut part, k)).collect()
    }

    /// Return the pairs of nodes that lie in one place, the lower number first; each node is the second of at most one.
    pub fn doubled(&self) -> Vec<[usize; 2]> {
        let sides = self.triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let length = |[a, b]: [&usize; 2]| norm(minus(self.nodes[*a], self.nodes[*b]));
        let shortest = sides.map(length).fold(f64::INFINITY, f64::min);
        let near = ONE_PLACE * if shortest.is_finite() { shortest } else { SHORTEST };
        // In the order along a skew line, nodes in one place are neighbours, and few others.
        let along: Vec<_> = self.nodes.iter().map(|node| dot(*node, SKEW)).collect();
        let mut order: Vec<_> = (0..self.nodes.len()).collect();
        order.sort_by(|a, b| along[*a].total_cmp(&along[*b]));
        let mut pairs = Vec::new();
        for (i, &k) in order.iter().enumerate() {
            let before = order[..i].iter().rev().take_while(|other| along[k] - along[**other] <= near);
            let twin = before.filter(|other| norm(minus(self.nodes[k], self.nodes[**other])) <= near).min();
            pairs.extend(twin.map(|twin| [k.min(*twin), k.max(*twin)]));
        }
        pairs.sort_unstable();
        pairs
    }

    /// Return the first node at which a chain is not straight, and how; a fold before a turn.
    pub fn bend(&self, chain: &[usize]) -> Option<(usize, Bend)> {
        let edge = |i: usize| minus(self.nodes[chain[i + 1]], self.nodes[chain[i]]);
        let point = (1..chain.len()).find(|i| !norm(edge(i - 1)).is_normal()).map(|i| (chain[i - 1], Bend::Point));
        point.or_else(|| {
            let bends = (1..chain.len().saturating_sub(1)).filter_map(|i| {
                let [before, after] = [edge(i - 1), edge(i)].map(|edge| edge.map(|part| part / norm(edge)));
                let is_straight = norm(cross(before, after)) <= STRAIGHT;
                match dot(before, after) > 0.0 {
                    true => (!is_straight).then_some((chain[i], Bend::Turn)),
                    false => Some((chain[i], if is_straight { Bend::Fold } else { Bend::Turn })),
                }
            });
            bends.clone().find(|(_, bend)| *bend == Bend::Fold).or_else(|| bends.clone().next())
        })
    }
}
