//! A line of markers along the stations of a beam.
//!
//! A marker moves with the mean of a part of the line, and its force goes back to the stations by the transpose of that
//! mean, so that the power of the loads is the power of the drag. Every station has a share of a part, also where
//! there are more stations than markers.

use std::ops::Range;

use super::LineForce;
use super::kernel::LINE_THICKNESS_CELLS;
use super::markers::Markers;
use crate::bodies::{Loads, Stations, difference, unit};
use crate::force::{Displaced, Force};

/// Distance of neighbouring markers, cells. Closer markers make a matrix of useless condition, whose solutions
/// alternate; beyond 2 the line leaks.
const SPACING_CELLS: f64 = 1.5;

/// Length by which a free end is drawn in, cells, because the kernel reaches beyond the last marker. With it a line has
/// the added mass of a plate of its length.
const DRAWN_IN_CELLS: f64 = 0.1;

/// A line.
pub struct Line {
    /// Number of its beam among all beams.
    pub beam: usize,
    /// Shares of the points in each part, of which there is one for each marker.
    parts: Vec<Range<usize>>,
    shares: Vec<(usize, f64)>,
    /// Number of its first marker.
    first: usize,
    /// Fluid that moves with a marker, m².
    layer: f64,
    /// Length, m, and what the parts have of it at each station.
    length: f64,
    covered: Vec<f64>,
}

impl Line {
    /// A line through `points` (m) on cells of a size (m), with its markers; `free` tells which ends are free.
    pub fn new(
        beam: usize,
        points: &[[f64; 2]],
        free: [bool; 2],
        c_eta: f64,
        cell: f64,
        markers: &mut Markers<2>,
    ) -> Self {
        let mut arc = vec![0.0];
        for pair in points.windows(2) {
            arc.push(arc[arc.len() - 1] + (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
        }
        let length = arc[arc.len() - 1];
        let [begin, left] = free.map(|free| if free { (DRAWN_IN_CELLS * cell).min(0.25 * length) } else { 0.0 });
        let span = length - begin - left;
        let count = (span / (SPACING_CELLS * cell)).round().max(1.0);
        let (part, thickness) = (span / count, LINE_THICKNESS_CELLS * cell);
        let (first, mut parts, mut shares) = (markers.len(), Vec::new(), Vec::new());
        for k in 0..count as usize {
            let middle = begin + (k as f64 + 0.5) * part;
            // The first and the last part reach as far over their middle as to the end of the line.
            let mut half = 0.5 * part;
            if k == 0 {
                half = half.max(middle);
            }
            if k + 1 == count as usize {
                half = half.max(length - middle);
            }
            let from = shares.len();
            mean(&arc, middle - half, middle + half, &mut shares);
            parts.push(from..shares.len());
            markers.add(length / count, thickness / c_eta);
        }
        let mut covered = vec![0.0; points.len()];
        shares.iter().for_each(|&(point, share)| covered[point] += share * length / count);
        Self { beam, parts, shares, first, layer: thickness * length / count, length, covered }
    }

    /// Move the markers to stations.
    pub fn place(&self, stations: &Stations, markers: &mut Markers<2>) {
        for (k, part) in self.parts.iter().enumerate() {
            let shares = &self.shares[part.clone()];
            let mean = |values: &[Vec<f64>; 2]| {
                values.each_ref().map(|values| shares.iter().map(|&(point, share)| share * values[point]).sum::<f64>())
            };
            let marker = markers.get_mut(self.first + k);
            (marker.position, marker.velocity) = (mean(&stations.position), mean(&stations.velocity));
        }
    }

    /// Add the forces on the markers and their slopes, both over the density (kg/m³), to the loads on the stations.
    pub fn collect(&self, force: &[Vec<f64>; 2], slope: &[f64], density: f64, loads: &mut Loads) {
        loads.force.iter_mut().for_each(|force| force.fill(0.0));
        loads.impedance.fill(0.0);
        for (k, part) in self.parts.iter().enumerate() {
            for &(point, share) in &self.shares[part.clone()] {
                let weight = density * share;
                (0..2).for_each(|axis| loads.force[axis][point] += weight * force[axis][self.first + k]);
                loads.impedance[point] += weight * slope[self.first + k];
            }
        }
    }

    /// Return the sum of the forces on the markers, with the moment and the power.
    pub fn force(&self, stations: &Stations, markers: &Markers<2>, force: &[Vec<f64>; 2], density: f64) -> LineForce {
        let mut sum = LineForce::default();
        for k in self.first..self.first + self.parts.len() {
            let marker = markers.get(k);
            let force = [0, 1].map(|axis| density * force[axis][k]);
            sum.force.add(force, [0, 1].map(|axis| marker.position[axis] - stations.position[axis][0]));
            sum.power += force[0] * marker.velocity[0] + force[1] * marker.velocity[1];
        }
        sum
    }

    /// Return the fluid in the layer that moves with the line.
    pub fn displaced(&self, stations: &Stations, markers: &Markers<2>, density: f64) -> Displaced {
        let mut sum = Force::default();
        for k in self.first..self.first + self.parts.len() {
            let marker = markers.get(k);
            let momentum = marker.velocity.map(|velocity| density * self.layer * velocity);
            sum.add(momentum, [0, 1].map(|axis| marker.position[axis] - stations.position[axis][0]));
        }
        let ([vx, vy], momentum) = (stations.velocity.each_ref().map(|v| v[0]), sum.force);
        Displaced { momentum, angular: sum.moment, transport: vx * momentum[1] - vy * momentum[0] }
    }

    /// Write the pressure above less the pressure below the line at its stations, Pa. The layer that moves with the line
    /// takes a part of the force on the markers, which a line of no thickness would not need.
    pub fn write_jump(
        &self,
        force: &[Vec<f64>; 2],
        density: f64,
        dt: f64,
        stations: &Stations,
        before: &Stations,
        jump: &mut [f64],
    ) {
        let (length, last) = (self.length / self.parts.len() as f64, jump.len() - 1);
        for (k, jump) in jump.iter_mut().enumerate() {
            let [from, to] = [k.saturating_sub(1), (k + 1).min(last)];
            let [ex, ey] = unit(difference(&stations.position, [from, to]));
            let acceleration = [0, 1].map(|axis| (stations.velocity[axis][k] - before.velocity[axis][k]) / dt);
            *jump = density * self.layer / length * (acceleration[0] * ey - acceleration[1] * ex);
        }
        for (k, part) in self.parts.iter().enumerate() {
            for &(point, share) in &self.shares[part.clone()] {
                let [from, to] = [point.saturating_sub(1), (point + 1).min(last)];
                let [ex, ey] = unit(difference(&stations.position, [from, to]));
                let [fx, fy] = [0, 1].map(|axis| force[axis][self.first + k]);
                jump[point] += density * share / self.covered[point] * (fx * ey - fy * ex);
            }
        }
    }
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
