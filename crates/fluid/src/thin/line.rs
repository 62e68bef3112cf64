//! A line of markers along stations.

use std::ops::Range;

use super::kernel::LINE_THICKNESS_CELLS;
use super::markers::Markers;
use super::parts::Parts;
use crate::bodies::{Loads, Stations, difference, unit};
use crate::force::{Displaced, Force};

/// A line.
pub struct Line {
    parts: Parts,
    /// Equal parts, over which the force on a marker counts as stress, and the length of one, m.
    stressed: Parts,
    length: f64,
    /// Fluid that moves with a marker, m².
    layer: f64,
    /// Length of the line at each station, m.
    covered: Vec<f64>,
}

impl Line {
    /// A line through `points` (m) on cells of a size (m), with its markers; `free` tells which ends are free.
    pub fn new(points: &[[f64; 2]], free: [bool; 2], c_eta: f64, cell: f64, markers: &mut Markers<2>) -> Self {
        let (parts, length) = Parts::of_line(points, free, cell, markers.len());
        let (length, thickness) = (length / parts.len() as f64, LINE_THICKNESS_CELLS * cell);
        parts.markers().for_each(|_| markers.add(length, thickness / c_eta));
        let (stressed, mut covered) = (parts.equal(points), vec![0.0; points.len()]);
        for (_, shares) in stressed.iter() {
            shares.iter().for_each(|&(point, share)| covered[point] += share * length);
        }
        Self { parts, stressed, length, layer: thickness * length, covered }
    }

    /// Move the markers to stations.
    pub fn place(&self, stations: &Stations, markers: &mut Markers<2>) {
        self.parts.place(stations, markers);
    }

    /// Write the forces on the markers and their slopes, both over the density (kg/m³), as loads on the stations.
    pub fn collect(&self, force: &[Vec<f64>; 2], slope: &[f64], density: f64, loads: &mut Loads) {
        self.parts.collect(force, slope, density, loads);
    }

    /// Return the numbers of the markers.
    pub fn markers(&self) -> Range<usize> {
        self.parts.markers()
    }

    /// Return the sum of the forces on the markers with the moment about a point (m), and the power, W per metre of
    /// depth.
    pub fn force(&self, about: [f64; 2], markers: &Markers<2>, force: &[Vec<f64>; 2], density: f64) -> (Force, f64) {
        let (mut sum, mut power) = (Force::default(), 0.0);
        for k in self.markers() {
            let marker = markers.get(k);
            let force = [0, 1].map(|axis| density * force[axis][k]);
            sum.add(force, [0, 1].map(|axis| marker.position[axis] - about[axis]));
            power += force[0] * marker.velocity[0] + force[1] * marker.velocity[1];
        }
        (sum, power)
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

    /// Write the pressure above less the pressure below the line at its stations, and the shear stress on both faces
    /// together towards the tip, Pa. The layer that moves with the line takes a part of the force on the markers, which a
    /// line of no thickness would not need. Friction that jumps at an end makes it alternate from marker to marker, so the
    /// shear is of means with the weights 1, 2, 1.
    pub fn write_stresses(
        &self,
        force: &[Vec<f64>; 2],
        density: f64,
        dt: f64,
        stations: &Stations,
        before: &Stations,
        [jump, shear]: [&mut [f64]; 2],
    ) {
        let last = jump.len() - 1;
        let tangent = |k: usize| unit(difference(&stations.position, [k.saturating_sub(1), (k + 1).min(last)]));
        for k in 0..=last {
            let [ex, ey] = tangent(k);
            let [ax, ay] = [0, 1].map(|axis| (stations.velocity[axis][k] - before.velocity[axis][k]) / dt);
            let layer = density * self.layer / self.length;
            (jump[k], shear[k]) = (layer * (ax * ey - ay * ex), layer * (ax * ex + ay * ey));
        }
        let Range { start, end } = self.markers();
        for (k, shares) in self.stressed.iter() {
            let beside = [k.saturating_sub(1).max(start), k, k, (k + 1).min(end - 1)];
            let [fx, fy] = force.each_ref().map(|force| force[k]);
            let [mx, my] = force.each_ref().map(|force| 0.25 * beside.iter().map(|k| force[*k]).sum::<f64>());
            for &(point, share) in shares {
                let ([ex, ey], weight) = (tangent(point), density * share / self.covered[point]);
                jump[point] += weight * (fx * ey - fy * ex);
                shear[point] += weight * (mx * ex + my * ey);
            }
        }
    }
}
