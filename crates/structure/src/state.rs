//! State of a structure between two steps.

use std::slice;

use serde::{Deserialize, Serialize};

use crate::scheme::Motion;
use crate::{Error, Vector};

/// Memory of a structure from one step to the next; an array has one entry per node.
///
/// Loads are inputs and not part of the state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize, M> {
    /// Positions, m.
    pub positions: Vec<Vector<D>>,
    /// Velocities, m/s.
    pub velocities: Vec<Vector<D>>,
    /// Accelerations, m/s².
    pub accelerations: Vec<Vector<D>>,
    /// Net forces on the nodes at the end of the last step, N (generalised-α).
    pub net_forces: Vec<Vector<D>>,
    /// Nodal forces of gravity and loads at the end of the last step, N (TR-BDF2).
    pub loads: Vec<Vector<D>>,
    /// Positions one step earlier, m (BDF2).
    pub previous_positions: Vec<Vector<D>>,
    /// Velocities one step earlier, m/s (BDF2).
    pub previous_velocities: Vec<Vector<D>>,
    /// Length of the last step, s; 0 before the first step.
    pub last_step: f64,
    /// Exchange with the loads.
    pub exchange: Exchange<D>,
    /// Exchange with the base that moves the held nodes, or with the force that tows a free rod.
    pub drive: Drive<D>,
    /// Memory of this kind of structure alone; its `clone_from` allocates nothing.
    pub own: M,
}

/// Force, power and work of the loads on the structure: nodal forces with impedance and pressure jump, without gravity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exchange<const D: usize> {
    /// Sum of the loads at the end of the last step, N.
    pub force: Vector<D>,
    /// Power of the loads at the end of the last step, W.
    pub power: f64,
    /// Work of the loads since the start, J: the sum of power times step.
    pub work: f64,
}

/// Force, moment, power and work of the drive on the structure; 0 for a root at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive<const D: usize> {
    /// Force at the end of the last step, N; it balances the loads on held nodes and accelerates their mass.
    pub force: Vector<D>,
    /// Moment about the root or the centre of the base at the end of the last step, N m; in two dimensions only the
    /// last component.
    pub moment: [f64; 3],
    /// Power of force and moment at the end of the last step, W.
    pub power: f64,
    /// Work of force and moment since the start, J: the sum of power times step.
    pub work: f64,
}

impl<const D: usize, M: Clone> State<D, M> {
    /// Return the state at rest in the shape `positions`.
    pub fn at_rest(positions: Vec<Vector<D>>, own: M) -> Self {
        let zeros = vec![Vector::zeros(); positions.len()];
        Self {
            velocities: zeros.clone(),
            accelerations: zeros.clone(),
            net_forces: zeros.clone(),
            loads: zeros.clone(),
            previous_positions: positions.clone(),
            previous_velocities: zeros,
            positions,
            last_step: 0.0,
            exchange: Exchange { force: Vector::zeros(), power: 0.0, work: 0.0 },
            drive: Drive { force: Vector::zeros(), moment: [0.0; 3], power: 0.0, work: 0.0 },
            own,
        }
    }

    /// Return the motion of node `k`.
    #[inline(always)]
    pub(crate) fn motion(&self, k: usize) -> Motion<Vector<D>> {
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
        self.last_step = other.last_step;
        (self.exchange, self.drive) = (other.exchange, other.drive);
        self.own.clone_from(&other.own);
    }

    /// Refuse an exchange or a drive that is not finite: loads or a motion of the root that are too large.
    pub(crate) fn check_exchange<F>(&self) -> Result<(), Error<F>> {
        let (exchange, drive) = (&self.exchange, &self.drive);
        let parts = [
            ("state.exchange.force", exchange.force.as_slice()),
            ("state.exchange.power", slice::from_ref(&exchange.power)),
            ("state.exchange.work", slice::from_ref(&exchange.work)),
            ("state.drive.force", drive.force.as_slice()),
            ("state.drive.moment", &drive.moment),
            ("state.drive.power", slice::from_ref(&drive.power)),
            ("state.drive.work", slice::from_ref(&drive.work)),
        ];
        match parts.into_iter().find(|(_, numbers)| numbers.iter().any(|number| !number.is_finite())) {
            Some((name, numbers)) => Err(Error::value(name, numbers, "finite")),
            None => Ok(()),
        }
    }

    /// Refuse arrays of a wrong length, numbers that are not finite, and a negative last step, except in `own`.
    pub fn check<F>(&self, nodes: usize) -> Result<(), Error<F>> {
        for (name, array) in [
            ("positions", &self.positions),
            ("velocities", &self.velocities),
            ("accelerations", &self.accelerations),
            ("net_forces", &self.net_forces),
            ("loads", &self.loads),
            ("previous_positions", &self.previous_positions),
            ("previous_velocities", &self.previous_velocities),
        ] {
            Error::check_length(format_args!("state.{name}"), array.len(), nodes)?;
            if let Some(k) = array.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
                return Err(Error::value(format!("state.{name}[{k}]"), array[k].as_slice(), "finite"));
            }
        }
        if !(self.last_step.is_finite() && self.last_step >= 0.0) {
            return Err(Error::value("state.last_step", self.last_step, "a finite number of at least 0 s"));
        }
        self.check_exchange()
    }
}
