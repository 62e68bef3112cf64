//! A line of markers along the stations of a beam.

use super::LineForce;
use super::kernel::LINE_THICKNESS_CELLS;
use super::markers::Markers;
use super::parts::Parts;
use crate::bodies::{Loads, Stations, difference, unit};
use crate::force::{Displaced, Force};

/// A line.
pub struct Line {
    /// Number of its beam among all beams.
    pub beam: usize,
    parts: Parts,
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
        let (parts, length) = Parts::of_line(points, free, cell, markers.len());
        let (count, thickness) = (parts.len() as f64, LINE_THICKNESS_CELLS * cell);
        parts.markers().for_each(|_| markers.add(length / count, thickness / c_eta));
        let mut covered = vec![0.0; points.len()];
        for &(point, share) in parts.iter().flat_map(|(_, shares)| shares) {
            covered[point] += share * length / count;
        }
        Self { beam, parts, layer: thickness * length / count, length, covered }
    }

    /// Move the markers to stations.
    pub fn place(&self, stations: &Stations, markers: &mut Markers<2>) {
        self.parts.place(stations, markers);
    }

    /// Write the forces on the markers and their slopes, both over the density (kg/m³), as loads on the stations.
    pub fn collect(&self, force: &[Vec<f64>; 2], slope: &[f64], density: f64, loads: &mut Loads) {
        self.parts.collect(force, slope, density, loads);
    }

    /// Return the sum of the forces on the markers, with the moment and the power.
    pub fn force(&self, stations: &Stations, markers: &Markers<2>, force: &[Vec<f64>; 2], density: f64) -> LineForce {
        let mut sum = LineForce::default();
        for k in self.parts.markers() {
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
        for k in self.parts.markers() {
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
        for (marker, shares) in self.parts.iter() {
            for &(point, share) in shares {
                let [from, to] = [point.saturating_sub(1), (point + 1).min(last)];
                let [ex, ey] = unit(difference(&stations.position, [from, to]));
                let [fx, fy] = [0, 1].map(|axis| force[axis][marker]);
                jump[point] += density * share / self.covered[point] * (fx * ey - fy * ex);
            }
        }
    }
}
