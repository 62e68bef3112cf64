//! Section of a wing across its span: twist and camber.
//!
//! The plane across the span at a share of it cuts the edges of the mesh at rest. The cuts move with their edges, and
//! the first and the last of them from the front to the back are the ends of the chord c.
//!
//! ```text
//! twist  = angle from c_rest to Rᵀ c about the span s,
//! camber = largest distance of a cut from the chord / |c|, positive on the side of the normal of the triangles.
//! ```
//!
//! R is the rotation of the base. The span lies in the plane of the wing, across the line of the root.

use std::collections::BTreeSet;

use mesh::Mesh;
use nalgebra::Matrix3;

use crate::geometry::{Geometry, Vector};

/// Place of the section, by the largest distance of a node from the line of the root along the span.
const SHARE: f64 = 0.75;
/// Nodes as near to the plane of the section, by that distance, lie in it.
const NEAR: f64 = 1e-9;

/// Section at three quarters of the span.
pub(crate) struct Section {
    /// Cut edges, and the share of the second end, from one end of the chord to the other.
    cuts: Vec<([usize; 2], f64)>,
    /// Span, of length 1.
    span: Vector,
    /// Chord at rest, m.
    chord: Vector,
    /// 1 or −1, by which span × chord points to the side of the normal of the triangles.
    side: f64,
}

impl Section {
    /// Return the section; `None` for a wing that has no line of the root or no cut, or none of a length.
    pub(crate) fn new(mesh: &Mesh, root: &[usize]) -> Option<Self> {
        let [begin, end] = [root.first()?, root.last()?].map(|k| mesh.node(*k));
        let corners = mesh.triangles.iter().map(|corners| corners.map(|k| mesh.node(k)));
        let normal: Vector = corners.map(|[a, b, c]| (b - a).cross(&(c - a))).sum();
        let across = (end - begin).cross(&normal).try_normalize(f64::MIN_POSITIVE)?;
        let place = |k: usize, span: &Vector| span.dot(&(mesh.node(k) - begin));
        let sum: f64 = (0..mesh.nodes.len()).map(|k| place(k, &across)).sum();
        let span = across * sum.signum();
        let extent = (0..mesh.nodes.len()).fold(0.0, |most: f64, k| most.max(place(k, &span)));
        let height = |k: usize| {
            let height = place(k, &span) - SHARE * extent;
            if height.abs() < NEAR * extent { 0.0 } else { height }
        };
        let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let cuts = sides.filter_map(|[a, b]| {
            let (h, other) = (height(a), height(b));
            match h == 0.0 {
                true => Some(([a, a], 0)),
                false if h * other < 0.0 => Some(([a.min(b), a.max(b)], 1)),
                false => None,
            }
        });
        let mut cuts: Vec<_> = cuts
            .collect::<BTreeSet<_>>()
            .into_iter()
            .map(|([a, b], _)| ([a, b], if a == b { 0.0 } else { height(a) / (height(a) - height(b)) }))
            .collect();
        let direction = span.cross(&normal);
        let at = |([a, b], share): &([usize; 2], f64)| mesh.node(*a).lerp(&mesh.node(*b), *share);
        cuts.sort_by(|p, q| direction.dot(&at(p)).total_cmp(&direction.dot(&at(q))));
        let chord = at(cuts.last()?) - at(cuts.first()?);
        let side = span.cross(&chord).dot(&normal).signum();
        (chord.norm() > NEAR * extent).then_some(Self { cuts, span, chord, side })
    }

    /// Return the cut `i` in the shape `x`.
    fn at(&self, i: usize, x: &[Vector]) -> Vector {
        let ([a, b], share) = self.cuts[i];
        x[a].lerp(&x[b], share)
    }

    /// Return the twist in the shape `x` on a base that is turned by R, rad.
    pub(crate) fn twist(&self, x: &[Vector], rotation: &Matrix3<f64>) -> f64 {
        let chord = rotation.transpose() * (self.at(self.cuts.len() - 1, x) - self.at(0, x));
        let across = |vector: &Vector| vector - self.span * self.span.dot(vector);
        let (rest, chord) = (across(&self.chord), across(&chord));
        self.span.dot(&rest.cross(&chord)).atan2(rest.dot(&chord))
    }

    /// Return the camber in the shape `x` on a base that is turned by R.
    pub(crate) fn camber(&self, x: &[Vector], rotation: &Matrix3<f64>) -> f64 {
        let first = self.at(0, x);
        let chord = self.at(self.cuts.len() - 1, x) - first;
        let along = chord / chord.norm();
        let normal = (rotation * self.span).cross(&along) * self.side;
        let offs = (1..self.cuts.len() - 1).map(|i| {
            let arm = self.at(i, x) - first;
            let off = arm - along * along.dot(&arm);
            off.norm().copysign(off.dot(&normal))
        });
        offs.fold(0.0, |most: f64, off| if off.abs() > most.abs() { off } else { most }) / chord.norm()
    }
}
