//! Surfaces of triangles: wings, plates and disks.

use crate::bounds::{Bounds, are_near, around};
use crate::placed::share;
use crate::segment;
use crate::triangle::{ROUNDING, edges, height, piercing};
use crate::vector::between;

/// Points of a surface, about: many times the parts of a section that it may cover.
const POINTS: usize = 4096;

/// Parts of a section along each axis that a surface may cover.
const PARTS: usize = 16;

/// Part of a surface at its rim that may touch another.
const RIM: f64 = 1e-6;

/// Distance from a surface, by its size, within which a point lies on it.
const ON: f64 = 1e-6;

/// Most triangles of a surface in the bounding box of another; of more, some are left out.
const MOST_NEAR: usize = 300;

/// A surface in space.
#[derive(Clone, Debug)]
pub struct Surface {
    pub(crate) nodes: Vec<[f64; 3]>,
    pub(crate) triangles: Vec<[usize; 3]>,
    pub(crate) bounds: Bounds<3>,
}

impl Surface {
    /// Make the surface of nodes (m) and triangles.
    pub fn new(nodes: Vec<[f64; 3]>, triangles: Vec<[usize; 3]>) -> Self {
        let bounds = around(&nodes);
        Self { nodes, triangles, bounds }
    }

    /// Return the nodes, m.
    pub fn nodes(&self) -> &[[f64; 3]] {
        &self.nodes
    }

    /// Return the triangles.
    pub fn triangles(&self) -> &[[usize; 3]] {
        &self.triangles
    }

    /// Return the corners of a triangle.
    pub(crate) fn triangle(&self, k: usize) -> [[f64; 3]; 3] {
        self.triangles[k].map(|node| self.nodes[node])
    }

    /// Return some [`POINTS`] points on the surface, or one a triangle.
    fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        (0..self.triangles.len()).step_by(self.triangles.len().div_ceil(POINTS).max(1)).flat_map(|k| self.points_of(k))
    }

    /// Return the points on a triangle.
    pub(crate) fn points_of(&self, k: usize) -> impl Iterator<Item = [f64; 3]> + use<> {
        let n = (POINTS as f64 / self.triangles.len() as f64).sqrt().ceil().max(1.0) as usize;
        let [a, b, c] = self.triangle(k);
        (0..n).flat_map(move |i| (0..n - i).map(move |j| (i, j))).map(move |(i, j)| {
            let [s, t] = [i, j].map(|k| (k as f64 + 1.0 / 3.0) / n as f64);
            [0, 1, 2].map(|axis| a[axis] + s * (b[axis] - a[axis]) + t * (c[axis] - a[axis]))
        })
    }

    /// Return the triangles at most `gap` (m) from a bounding box, of more than [`MOST_NEAR`] some.
    pub(crate) fn near(&self, bounds: &Bounds<3>, gap: f64) -> Vec<[[f64; 3]; 3]> {
        if !are_near(&self.bounds, bounds, gap) {
            return Vec::new();
        }
        let all = (0..self.triangles.len()).map(|k| self.triangle(k));
        let all: Vec<_> = all.filter(|corners| are_near(&around(corners), bounds, gap)).collect();
        let stride = all.len().div_ceil(MOST_NEAR).max(1);
        all.into_iter().step_by(stride).collect()
    }

    /// Return whether an edge passes through the other surface, or comes closer than `gap` to it, m.
    pub(crate) fn meets(&self, other: &Self, gap: f64) -> bool {
        let own = self.near(&other.bounds, gap);
        // The edge of one may lie on the other.
        let middle = other.bounds.map(|[low, high]| (low + high) / 2.0);
        let inner = |corners: [[f64; 3]; 3]| corners.map(|corner| between(corner, middle, RIM));
        let others: Vec<_> = other.near(&self.bounds, gap).into_iter().map(inner).collect();
        let bounded: Vec<_> = others.iter().map(|corners| (corners, around(corners))).collect();
        let through = |edge: [[f64; 3]; 2], triangle: [[f64; 3]; 3]| {
            piercing(edge, triangle).is_some_and(|share| ROUNDING < share && share < 1.0 - ROUNDING)
        };
        let close = |edge: [[f64; 3]; 2], triangle: [[f64; 3]; 3]| {
            height(edge[0], triangle) < gap || edges(triangle).iter().any(|side| segment::distance(edge, *side) < gap)
        };
        own.iter().any(|corners| {
            let bounds = around(corners);
            let mut met = bounded.iter().filter(|(_, other)| are_near(&bounds, other, gap));
            met.any(|(other, _)| edges(*corners).iter().any(|edge| through(*edge, **other) || close(*edge, **other)))
        })
    }

    /// Return whether a point lies on the surface.
    pub(crate) fn has(&self, p: [f64; 3]) -> bool {
        let close = ON * self.bounds.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
        let mut near = (0..self.triangles.len()).map(|k| self.triangle(k));
        near.any(|corners| are_near(&around(&corners), &p.map(|at| [at; 2]), close) && height(p, corners) <= close)
    }

    /// Return the share of the surface whose points have `property`.
    pub(crate) fn share(&self, property: impl Fn([f64; 3]) -> bool) -> f64 {
        share(self.points(), property)
    }

    /// Return whether a straight line along `axis` meets the surface wherever it passes the section with these `ends`
    /// (m).
    pub(crate) fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        let part = |p: &[f64; 3], d: usize| (p[d] - ends[d][0]) / (ends[d][1] - ends[d][0]) * PARTS as f64;
        let mut met = [[false; PARTS]; PARTS];
        for p in self.points() {
            let [a, b] = [1, 2].map(|k| part(&p, (axis + k) % 3).clamp(0.0, PARTS as f64 - 1.0) as usize);
            met[a][b] = true;
        }
        met.as_flattened().iter().all(|met| *met)
    }
}
