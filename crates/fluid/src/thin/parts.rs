//! Parts of a body, one for each marker, and how they hang on its nodes.
//!
//! A marker moves with the mean of a part, and its force goes back to the nodes by the transpose of that mean, so that
//! the power of the loads is the power of the drag. Every node has a share of a part, also where there are more nodes
//! than markers.

use std::ops::Range;

use super::markers::Markers;
use crate::kernel::Kernel;
use crate::space::Vector;
use contact::{Loads, Stations};

/// Shares of the nodes in each part.
#[derive(Default)]
pub struct Parts {
    parts: Vec<Range<usize>>,
    shares: Vec<(usize, f64)>,
    /// Number of the first marker.
    first: usize,
}

impl Parts {
    /// No part yet; the first one belongs to the marker with a number.
    pub fn new(first: usize) -> Self {
        Self { first, ..Self::default() }
    }

    /// Parts of a line through points (m) for cells of a size (m), the distance of each from the nearest free end (m), and
    /// the length of the line; `free` tells which ends are free and so `drawn_in`, cells.
    pub fn of_line<const D: usize>(
        points: &[[f64; D]],
        free: [bool; 2],
        drawn_in: f64,
        cell: f64,
        first: usize,
    ) -> (Self, Vec<f64>, f64) {
        let arc = arc(points);
        let length = arc[arc.len() - 1];
        let kernel = Kernel::of(D);
        let [begin, left] = free.map(|free| if free { (drawn_in * cell).min(0.25 * length) } else { 0.0 });
        let span = length - begin - left;
        let count = (span / (kernel.spacing * cell)).round().max(1.0);
        let (part, mut parts, mut edges) = (span / count, Self::new(first), Vec::new());
        for k in 0..count as usize {
            let middle = begin + (k as f64 + 0.5) * part;
            let ends = free.into_iter().zip([middle, length - middle]).filter(|(free, _)| *free);
            edges.push(ends.map(|(_, distance)| distance).fold(length, f64::min));
            // The first and the last part reach as far over their middle as to the end of the line.
            let mut half = 0.5 * part;
            if k == 0 {
                half = half.max(middle);
            }
            if k + 1 == count as usize {
                half = half.max(length - middle);
            }
            parts.add(|shares| mean(&arc, middle - half, middle + half, shares));
        }
        (parts, edges, length)
    }

    /// As many equal parts of the line through points (m), which cover it once.
    pub fn equal<const D: usize>(&self, points: &[[f64; D]]) -> Self {
        let (arc, mut parts) = (arc(points), Self::new(self.first));
        let part = arc[arc.len() - 1] / self.len() as f64;
        for k in 0..self.len() {
            parts.add(|shares| mean(&arc, k as f64 * part, (k + 1) as f64 * part, shares));
        }
        parts
    }

    /// Add a part; `add` appends the shares of its nodes to a list that begins with those of other parts.
    pub fn add(&mut self, add: impl FnOnce(&mut Vec<(usize, f64)>)) {
        let from = self.shares.len();
        add(&mut self.shares);
        self.parts.push(from..self.shares.len());
    }

    /// Return the number of parts.
    pub fn len(&self) -> usize {
        self.parts.len()
    }

    /// Return the numbers of the markers.
    pub fn markers(&self) -> Range<usize> {
        self.first..self.first + self.parts.len()
    }

    /// Return the number of each marker with the shares of the nodes.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &[(usize, f64)])> {
        self.markers().zip(&self.parts).map(|(marker, part)| (marker, &self.shares[part.clone()]))
    }

    /// Move the markers to the nodes.
    pub fn place<const D: usize>(&self, nodes: &Stations<D>, markers: &mut Markers<D>) {
        self.means(&nodes.position).for_each(|(k, position)| markers.get_mut(k).position = position);
        self.means(&nodes.velocity).for_each(|(k, velocity)| markers.get_mut(k).velocity = velocity);
    }

    /// Return the number of each marker with the mean of what the nodes have.
    pub fn means<const D: usize>(&self, of_nodes: &[Vec<f64>; D]) -> impl Iterator<Item = (usize, Vector<D>)> {
        self.iter().map(move |(marker, shares)| {
            let mean = |of: &Vec<f64>| shares.iter().map(|&(node, share)| share * of[node]).sum::<f64>();
            (marker, Vector::from(of_nodes.each_ref().map(mean)))
        })
    }

    /// Write the forces on the markers and their slopes, both over the density (kg/m³), as loads on the nodes.
    pub fn collect<const D: usize>(
        &self,
        force: impl Fn(usize) -> Vector<D>,
        slope: &[f64],
        density: f64,
        loads: &mut Loads<D>,
    ) {
        loads.force.iter_mut().for_each(|force| force.fill(0.0));
        loads.impedance.fill(0.0);
        for (marker, shares) in self.iter() {
            let force = force(marker);
            for &(node, share) in shares {
                let weight = density * share;
                (0..D).for_each(|axis| loads.force[axis][node] += weight * force[axis]);
                loads.impedance[node] += weight * slope[marker];
            }
        }
    }
}

/// Return the places of points along the line through them, m.
fn arc<const D: usize>(points: &[[f64; D]]) -> Vec<f64> {
    let mut arc = vec![0.0];
    for pair in points.windows(2) {
        let step = (0..D).fold(0.0, |step: f64, axis| step.hypot(pair[1][axis] - pair[0][axis]));
        arc.push(arc[arc.len() - 1] + step);
    }
    arc
}

/// Add the shares of points at the places `arc` in the mean from `from` to `to` of what is linear between them.
fn mean(arc: &[f64], from: f64, to: f64, shares: &mut Vec<(usize, f64)>) {
    let begin = shares.len();
    let mut add = |point: usize, share: f64| match shares[begin..].last_mut() {
        Some(last) if last.0 == point => last.1 += share,
        _ => shares.push((point, share)),
    };
    for k in 0..arc.len() - 1 {
        let (low, high) = (arc[k].max(from), arc[k + 1].min(to));
        if low < high {
            let fraction = (0.5 * (low + high) - arc[k]) / (arc[k + 1] - arc[k]);
            let share = (high - low) / (to - from);
            add(k, share * (1.0 - fraction));
            add(k + 1, share * fraction);
        }
    }
}
