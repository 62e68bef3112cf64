//! State of a rod between two steps.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::elastic::Vector;
use crate::hinge::HingeState;
use crate::root::Clamp;

/// Rounding that a unit vector may have.
const UNIT_TOLERANCE: f64 = 1e-9;

/// All that a rod remembers from one step to the next; each array has one entry per node, root to tip, `[n + 1]`.
///
/// Loads are inputs and not part of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize> {
    /// Positions, m.
    pub positions: Vec<Vector<D>>,
    /// Velocities, m/s.
    pub velocities: Vec<Vector<D>>,
    /// Accelerations, m/s².
    pub accelerations: Vec<Vector<D>>,
    /// Net forces on the nodes at the end of the last step, N (generalised-α blends with them).
    pub net_forces: Vec<Vector<D>>,
    /// Nodal forces of gravity and loads at the end of the last step, N (TR-BDF2).
    pub loads: Vec<Vector<D>>,
    /// Positions one step earlier, m (BDF2).
    pub previous_positions: Vec<Vector<D>>,
    /// Velocities one step earlier, m/s (BDF2).
    pub previous_velocities: Vec<Vector<D>>,
    /// Unit tangent at the clamp.
    pub direction: Vector<D>,
    /// Its rate, 1/s.
    pub direction_rate: Vector<D>,
    /// Length of the last step, s; 0 where there was none, so that the next step is a first step.
    pub last_step: f64,
    /// Energy less the work of the loads that it must not rise above while these are constant, J: the lowest since they last
    /// changed (generalised-α), or the first less what the damping has taken (trapezoid).
    pub reference_energy: f64,
    /// Largest kinetic or elastic energy since then, J; 0 where there is no reference, as after a change of the shape.
    pub largest_energy: f64,
    /// What the loads did.
    pub exchange: Exchange<D>,
    /// What a driven root did, or the force that tows a free one.
    pub drive: Drive<D>,
    /// Pressure that strains the rod, Pa; empty where none does.
    pub pressure: Vec<f64>,
    /// Angle of a torsion spring at the root; none where there is none, and in space.
    pub hinge: Option<HingeState>,
}

/// What the loads did to the rod: nodal forces with their impedance and pressure jump, without gravity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exchange<const D: usize> {
    /// Their sum at the end of the last step, N.
    pub force: Vector<D>,
    /// Their power there, W.
    pub power: f64,
    /// Their work since the start, J: the sum of power times step.
    pub work: f64,
}

impl<const D: usize> Exchange<D> {
    /// Nothing yet.
    pub fn none() -> Self {
        Self { force: Vector::zeros(), power: 0.0, work: 0.0 }
    }
}

/// What the clamp does to the rod while it is driven; 0 where the root is still.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive<const D: usize> {
    /// Force at the end of the last step, N: it carries the loads on node 0 and moves its mass as well.
    pub force: Vector<D>,
    /// Moment about the root there, N m; in two dimensions only the last component.
    pub moment: [f64; 3],
    /// Power of both there, W.
    pub power: f64,
    /// Their work since the start, J: the sum of power times step.
    pub work: f64,
}

impl<const D: usize> Drive<D> {
    /// Nothing yet.
    pub fn none() -> Self {
        Self { force: Vector::zeros(), moment: [0.0; 3], power: 0.0, work: 0.0 }
    }
}

impl<const D: usize> State<D> {
    /// At rest in the shape `positions`, clamped along the unit vector `direction`, before the first step; with the angle of
    /// a torsion spring at the root if there is one.
    pub fn at_rest(positions: Vec<Vector<D>>, direction: Vector<D>, hinge: Option<HingeState>) -> Self {
        let zeros = vec![Vector::zeros(); positions.len()];
        Self {
            velocities: zeros.clone(),
            accelerations: zeros.clone(),
            net_forces: zeros.clone(),
            loads: zeros.clone(),
            previous_positions: positions.clone(),
            previous_velocities: zeros,
            direction,
            direction_rate: Vector::zeros(),
            positions,
            last_step: 0.0,
            reference_energy: 0.0,
            largest_energy: 0.0,
            exchange: Exchange::none(),
            drive: Drive::none(),
            pressure: Vec::new(),
            hinge,
        }
    }

    /// The clamp: node 0 and its direction.
    pub(crate) fn clamp(&self) -> Clamp<D> {
        let (position, velocity) = (self.positions[0], self.velocities[0]);
        Clamp { position, velocity, direction: self.direction, direction_rate: self.direction_rate }
    }

    pub(crate) fn set_clamp(&mut self, clamp: &Clamp<D>) {
        (self.positions[0], self.velocities[0]) = (clamp.position, clamp.velocity);
        (self.direction, self.direction_rate) = (clamp.direction, clamp.direction_rate);
    }

    /// Take the clamp to where it is `dt` later, with the acceleration at the end of the cubic in between.
    pub(crate) fn move_clamp(&mut self, clamp: &Clamp<D>, dt: f64) {
        let (x, v) = (self.positions[0], self.velocities[0]);
        (self.previous_positions[0], self.previous_velocities[0]) = (x, v);
        self.accelerations[0] = (x - clamp.position) * (6.0 / (dt * dt)) + (v * 2.0 + clamp.velocity * 4.0) / dt;
        self.set_clamp(clamp);
    }

    /// Overwrite with `other` of the same number of nodes; unlike `clone_from` this allocates nothing.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.positions.copy_from_slice(&other.positions);
        self.velocities.copy_from_slice(&other.velocities);
        self.accelerations.copy_from_slice(&other.accelerations);
        self.net_forces.copy_from_slice(&other.net_forces);
        self.loads.copy_from_slice(&other.loads);
        self.previous_positions.copy_from_slice(&other.previous_positions);
        self.previous_velocities.copy_from_slice(&other.previous_velocities);
        self.direction = other.direction;
        self.direction_rate = other.direction_rate;
        self.last_step = other.last_step;
        (self.reference_energy, self.largest_energy) = (other.reference_energy, other.largest_energy);
        self.exchange = other.exchange;
        self.drive = other.drive;
        self.pressure.copy_from_slice(&other.pressure);
        self.hinge = other.hinge;
    }

    /// Each array must have `nodes` entries, all numbers be finite, and last step and largest energy not be negative.
    pub(crate) fn check(&self, nodes: usize) -> Result<(), Error> {
        for (name, array) in [
            ("positions", &self.positions),
            ("velocities", &self.velocities),
            ("accelerations", &self.accelerations),
            ("net_forces", &self.net_forces),
            ("loads", &self.loads),
            ("previous_positions", &self.previous_positions),
            ("previous_velocities", &self.previous_velocities),
        ] {
            if array.len() != nodes {
                return Err(Error::Length { name: format!("state.{name}"), length: array.len(), expected: nodes });
            }
            if let Some(k) = array.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
                return Err(Error::value(format!("state.{name}[{k}]"), array[k].as_slice(), "finite"));
            }
        }
        if let Some(k) = self.pressure.iter().position(|p| !p.is_finite()) {
            return Err(Error::value(format!("state.pressure[{k}]"), self.pressure[k], "finite"));
        }
        for (name, vector) in [("direction", self.direction), ("direction_rate", self.direction_rate)] {
            if vector.iter().any(|c| !c.is_finite()) {
                return Err(Error::value(format!("state.{name}"), vector.as_slice(), "finite"));
            }
        }
        if (self.direction.norm() - 1.0).abs() > UNIT_TOLERANCE {
            return Err(Error::value("state.direction", self.direction.as_slice(), "a vector of length 1"));
        }
        if !(self.last_step.is_finite() && self.last_step >= 0.0) {
            return Err(Error::value("state.last_step", self.last_step, "a finite number of at least 0 s"));
        }
        let Exchange { force, power, work } = self.exchange;
        if force.iter().chain([&power, &work]).any(|number| !number.is_finite()) {
            return Err(Error::value("state.exchange", format!("{:?}", self.exchange), "finite"));
        }
        let Drive { force, moment, power, work } = self.drive;
        if force.iter().chain(&moment).chain([&power, &work]).any(|number| !number.is_finite()) {
            return Err(Error::value("state.drive", format!("{:?}", self.drive), "finite"));
        }
        if let Some(hinge) = self.hinge.filter(|hinge| !hinge.is_finite()) {
            return Err(Error::value("state.hinge", format!("{hinge:?}"), "finite"));
        }
        if !self.reference_energy.is_finite() {
            return Err(Error::value("state.reference_energy", self.reference_energy, "finite"));
        }
        if !(self.largest_energy.is_finite() && self.largest_energy >= 0.0) {
            return Err(Error::value("state.largest_energy", self.largest_energy, "a finite number of at least 0 J"));
        }
        Ok(())
    }
}
