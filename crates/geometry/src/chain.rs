//! Chains of capsules: beams, and lines of no thickness.

use std::f64::consts::PI;

use crate::bounds::{Bounds, are_near, around, grown};
use crate::segment::{self, sides};
use crate::surface::Surface;
use crate::triangle::{ROUNDING, piercing};
use crate::vector::{between, dot, minus, norm};

/// Least cosine between the edges of a chain and its way from end to end with which it cannot touch itself: 2/π, for
/// only over an arc of π/2 thicknesses its ends may come one thickness close.
const ONWARD: f64 = 0.65;

/// Parts of the length of two neighbours that lie between edges which are no neighbours.
const APART: f64 = 0.75;

/// A line with half its thickness; in the plane z = 0.
#[derive(Clone, Debug)]
pub struct Chain {
    pub(crate) points: Vec<[f64; 3]>,
    /// Half the thickness of each edge, m.
    pub(crate) half: Vec<f64>,
    pub(crate) bounds: Bounds<3>,
}

impl Chain {
    /// Make the chain through `points` (m) with half its thickness at each, m.
    pub fn new(points: Vec<[f64; 3]>, half: &[f64]) -> Self {
        let half: Vec<_> = half.windows(2).map(|ends| ends[0].max(ends[1])).collect();
        Self { points: Vec::new(), half, bounds: [[0.0; 2]; 3] }.through(points)
    }

    /// Return the chain of the same thickness through other points (m), as many.
    pub(crate) fn through(&self, points: Vec<[f64; 3]>) -> Self {
        let (half, bounds) = (self.half.clone(), around(&points));
        Self { bounds: grown(bounds, half.iter().copied().fold(0.0, f64::max)), points, half }
    }

    /// Make the chain through `points` (m) with one half thickness, m.
    pub fn uniform(points: Vec<[f64; 3]>, half: f64) -> Self {
        let all = vec![half; points.len()];
        Self::new(points, &all)
    }

    /// Return the edges with half their thickness, m.
    pub(crate) fn edges(&self) -> impl Iterator<Item = ([[f64; 3]; 2], f64)> + Clone + '_ {
        sides(&self.points).zip(self.half.iter().copied())
    }

    /// Return the points of the line, m.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Return the length, m.
    pub fn length(&self) -> f64 {
        sides(&self.points).map(|[a, b]| norm(minus(b, a))).sum()
    }

    /// Return the distance of a point from the line, m.
    pub fn distance_of(&self, p: [f64; 3]) -> f64 {
        sides(&self.points).map(|edge| segment::distance(edge, [p; 2])).fold(f64::INFINITY, f64::min)
    }

    /// Return the distance of two lines, m; infinite where their bounding boxes are apart.
    pub fn distance(&self, other: &Self) -> f64 {
        if !are_near(&self.bounds, &other.bounds, 0.0) {
            return f64::INFINITY;
        }
        let pairs =
            sides(&self.points).flat_map(|one| sides(&other.points).map(move |two| segment::distance(one, two)));
        pairs.fold(f64::INFINITY, f64::min)
    }

    /// Return whether the bounding boxes of two chains are at most `gap` apart, m.
    pub fn is_near(&self, other: &Self, gap: f64) -> bool {
        are_near(&self.bounds, &other.bounds, gap)
    }

    /// Return where the line passes through a surface, not only with one of its ends.
    pub fn piercing(&self, surface: &Surface) -> Option<[f64; 3]> {
        let (corners, last) = (surface.near(&self.bounds, 0.0), self.half.len() - 1);
        sides(&self.points).enumerate().find_map(|(k, edge)| {
            let mut shares = corners.iter().filter_map(|triangle| piercing(edge, *triangle));
            let is_end = |share: f64| (k == 0 && share < ROUNDING) || (k == last && share > 1.0 - ROUNDING);
            shares.find(|share| !is_end(*share)).map(|share| between(edge[0], edge[1], share))
        })
    }

    /// Return where the chain touches itself: the begin of an edge that touches a later one, no neighbour.
    pub fn fold(&self) -> Option<[f64; 3]> {
        let way = minus(self.points[self.points.len() - 1], self.points[0]);
        let edges: Vec<_> = self.edges().collect();
        let least = ONWARD * norm(way);
        if edges.iter().all(|([a, b], _)| dot(minus(*b, *a), way) >= least * norm(minus(*b, *a))) {
            return None;
        }
        let lengths: Vec<_> = edges.iter().map(|([a, b], _)| norm(minus(*b, *a))).collect();
        let mut end = 0.0;
        let arcs: Vec<_> = lengths.iter().map(|length| (end += length, end - length / 2.0).1).collect();
        let touches = |i: usize, j: usize| {
            let (thick, long, arc) = (edges[i].1 + edges[j].1, lengths[i] + lengths[j], arcs[j] - arcs[i]);
            // Neighbours are half their length apart, and in a narrow bend edges may only cross.
            let least = if arc > PI / 2.0 * thick + long { thick } else { ROUNDING * long };
            let middles = [i, j].map(|k| between(edges[k].0[0], edges[k].0[1], 0.5));
            arc > APART * long
                && norm(minus(middles[1], middles[0])) < thick + long / 2.0
                && segment::distance(edges[i].0, edges[j].0) < least
        };
        (0..edges.len()).find(|&i| (i + 1..edges.len()).any(|j| touches(i, j))).map(|i| edges[i].0[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_touches_itself_only_where_it_turns_back() {
        let arc = |turn: f64, pitch: f64| {
            let at = |k: i32| {
                let angle = turn * f64::from(k) / 40.0;
                [angle.cos(), angle.sin(), pitch * angle]
            };
            Chain::uniform((0..=40).map(at).collect(), 0.05)
        };
        assert_eq!(arc(0.5, 0.0).fold(), None, "nearly straight");
        assert_eq!(arc(5.5, 0.0).fold(), None, "an open ring");
        let met = arc(6.5, 0.0).fold().expect("a closed ring");
        assert!(norm(minus(met, [1.0, 0.0, 0.0])) < 0.3, "{met:?}");
        assert_eq!(arc(6.5, 0.1).fold(), None, "a helix");
    }
}
