//! State of a wing between two steps.

use rod::{Drive, Exchange, Motion};
use serde::{Deserialize, Serialize};

use crate::geometry::Vector;
use crate::{Error, Pose};

/// Memory of a wing from one step to the next; an array has one entry per node.
///
/// Loads are inputs and not part of the state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Positions, m.
    pub positions: Vec<Vector>,
    /// Velocities, m/s.
    pub velocities: Vec<Vector>,
    /// Accelerations, m/s².
    pub accelerations: Vec<Vector>,
    /// Net forces at the end of the last step, N (generalised-α).
    pub net_forces: Vec<Vector>,
    /// Nodal forces of gravity and loads at the end of the last step, N (TR-BDF2).
    pub loads: Vec<Vector>,
    /// Positions one step earlier, m (BDF2).
    pub previous_positions: Vec<Vector>,
    /// Velocities one step earlier, m/s (BDF2).
    pub previous_velocities: Vec<Vector>,
    /// Pose of the base.
    pub pose: Pose,
    /// Length of the last step, s; 0 before the first step.
    pub last_step: f64,
    /// Exchange with the loads.
    pub exchange: Exchange<3>,
    /// Exchange with the base; 0 for a wing without a root.
    pub drive: Drive<3>,
}

impl State {
    /// Return the state at rest in the shape `positions`.
    pub(crate) fn at_rest(positions: Vec<Vector>, pose: Pose) -> Self {
        let zeros = vec![Vector::zeros(); positions.len()];
        Self {
            velocities: zeros.clone(),
            accelerations: zeros.clone(),
            net_forces: zeros.clone(),
            loads: zeros.clone(),
            previous_positions: positions.clone(),
            previous_velocities: zeros,
            positions,
            pose,
            last_step: 0.0,
            exchange: Exchange::none(),
            drive: Drive::none(),
        }
    }

    fn arrays(&self) -> [(&'static str, &Vec<Vector>); 7] {
        [
            ("positions", &self.positions),
            ("velocities", &self.velocities),
            ("accelerations", &self.accelerations),
            ("net_forces", &self.net_forces),
            ("loads", &self.loads),
            ("previous_positions", &self.previous_positions),
            ("previous_velocities", &self.previous_velocities),
        ]
    }

    /// Return the motion of node `k`.
    pub(crate) fn motion(&self, k: usize) -> Motion<Vector> {
        Motion {
            x: self.positions[k],
            v: self.velocities[k],
            a: self.accelerations[k],
            previous_x: self.previous_positions[k],
            previous_v: self.previous_velocities[k],
        }
    }

    /// Copy `other`, of the same number of nodes, without allocation.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.positions.copy_from_slice(&other.positions);
        self.velocities.copy_from_slice(&other.velocities);
        self.accelerations.copy_from_slice(&other.accelerations);
        self.net_forces.copy_from_slice(&other.net_forces);
        self.loads.copy_from_slice(&other.loads);
        self.previous_positions.copy_from_slice(&other.previous_positions);
        self.previous_velocities.copy_from_slice(&other.previous_velocities);
        (self.pose, self.last_step) = (other.pose, other.last_step);
        (self.exchange, self.drive) = (other.exchange, other.drive);
    }

    /// Refuse arrays of a wrong length, numbers that are not finite, and a negative last step.
    pub(crate) fn check(&self, nodes: usize) -> Result<(), Error> {
        for (name, array) in self.arrays() {
            if array.len() != nodes {
                return Err(Error::Length { name: format!("state.{name}"), length: array.len(), expected: nodes });
            }
            if let Some(k) = array.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
                return Err(Error::value(format!("state.{name}[{k}]"), array[k].as_slice(), "finite"));
            }
        }
        self.pose.check()?;
        if !(self.last_step.is_finite() && self.last_step >= 0.0) {
            return Err(Error::value("state.last_step", self.last_step, "a finite number of at least 0 s"));
        }
        let Exchange { force, power, work } = self.exchange;
        if force.iter().chain([&power, &work]).any(|number| !number.is_finite()) {
            return Err(Error::value("state.exchange", self.exchange, "finite"));
        }
        let Drive { force, moment, power, work } = self.drive;
        if force.iter().chain(&moment).chain([&power, &work]).any(|number| !number.is_finite()) {
            return Err(Error::value("state.drive", self.drive, "finite"));
        }
        Ok(())
    }
}
