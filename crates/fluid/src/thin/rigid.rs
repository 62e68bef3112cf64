//! A rigid body that is a line.

use super::line::Line;
use super::markers::Markers;
use crate::bodies::{Drag, Pose, Stations};
use crate::force::Force;
use crate::parameters::Body;

/// A rigid line. Its points are stations without loads.
pub struct RigidLine {
    /// Number among all rigid bodies, with the cylinders.
    pub rigid: usize,
    line: Line,
    /// Points from the pivot in the axes of the body, m.
    points: Vec<[f64; 2]>,
    stations: Stations,
    pivot: [f64; 2],
}

/// Responses of the forces on all markers to motions of a rigid line, over the density, m²/s and m³/s: to a velocity of
/// the pivot along an axis, and to the parts of a turn along y and, negative, along x.
pub type Responses = [Vec<f64>; 3];

impl RigidLine {
    /// The body number `rigid` with the line that `line` makes through its points.
    pub fn new(rigid: usize, body: &Body, points: &[[f64; 2]], line: Line) -> Self {
        let points: Vec<_> = points.iter().map(|p| [0, 1].map(|axis| p[axis] - body.pivot[axis])).collect();
        Self { rigid, line, stations: Stations::at_rest(&points), points, pivot: body.position }
    }

    /// Move the markers to a pose.
    pub fn place(&mut self, pose: &Pose, markers: &mut Markers<2>) {
        let (sin, cos) = pose.angle.sin_cos();
        for (k, [x, y]) in self.points.iter().enumerate() {
            let arm = [cos * x - sin * y, sin * x + cos * y];
            let turn = [-pose.omega * arm[1], pose.omega * arm[0]];
            for axis in 0..2 {
                self.stations.position[axis][k] = pose.position[axis] + arm[axis];
                self.stations.velocity[axis][k] = pose.velocity[axis] + turn[axis];
            }
        }
        self.pivot = pose.position;
        self.line.place(&self.stations, markers);
    }

    /// Return the force on the markers, with the moment about the pivot.
    pub fn force(&self, markers: &Markers<2>, force: &[Vec<f64>; 2], density: f64) -> Force {
        self.line.force(self.pivot, markers, force, density).0
    }

    /// Return the arm of a marker from the pivot along an axis, or without an axis 1; of markers of other lines 0.
    pub fn arm(&self, axis: Option<usize>, marker: usize, markers: &Markers<2>) -> f64 {
        let arm = || axis.map_or(1.0, |axis| markers.get(marker).position[axis] - self.pivot[axis]);
        if self.line.markers().contains(&marker) { arm() } else { 0.0 }
    }

    /// Return the drag and how it falls with the velocities, from `[response to 1, to the arms along x, along y]`.
    pub fn drag(&self, markers: &Markers<2>, force: &[Vec<f64>; 2], responses: &Responses, density: f64) -> Drag {
        let mut impedance = [[0.0; 3]; 3];
        for k in self.line.markers() {
            let [x, y] = [0, 1].map(|axis| markers.get(k).position[axis] - self.pivot[axis]);
            let [one, along_x, along_y] = responses.each_ref().map(|response| density * response[k]);
            impedance[0][0] += one;
            impedance[1][1] += one;
            impedance[0][2] -= along_y;
            impedance[1][2] += along_x;
            impedance[2][2] += x * along_x + y * along_y;
        }
        [impedance[2][0], impedance[2][1]] = [impedance[0][2], impedance[1][2]];
        Drag { force: self.force(markers, force, density), impedance }
    }

    /// Change the forces on all markers, and the velocities of its own, by a change of the velocities of the pivot and
    /// the angle.
    pub fn change(
        &self,
        [u, v, omega]: [f64; 3],
        responses: &Responses,
        markers: &mut Markers<2>,
        force: &mut [Vec<f64>; 2],
    ) {
        let [one, along_x, along_y] = responses;
        for (k, one) in one.iter().enumerate() {
            force[0][k] -= u * one - omega * along_y[k];
            force[1][k] -= v * one + omega * along_x[k];
        }
        for k in self.line.markers() {
            let marker = markers.get_mut(k);
            let [x, y] = [0, 1].map(|axis| marker.position[axis] - self.pivot[axis]);
            marker.velocity[0] += u - omega * y;
            marker.velocity[1] += v + omega * x;
        }
    }
}
