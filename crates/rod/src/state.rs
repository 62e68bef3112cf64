//! State of a rod between two steps.

use serde::{Deserialize, Serialize};

use crate::Error;
use crate::base_motion::BaseState;
use crate::scheme::Motion;
use crate::vector::Vector;

/// Tolerance of the length of a unit vector, for rounding.
const UNIT_TOLERANCE: f64 = 1e-9;

/// Memory of a rod from one step to the next; an array has one entry per node, from root to tip, `[n + 1]`.
///
/// Loads are inputs and not part of the state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize> {
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
    /// Unit tangent at the root.
    pub direction: Vector<D>,
    /// Rate of the unit tangent, 1/s.
    pub direction_rate: Vector<D>,
    /// Length of the last step, s; 0 before the first step.
    pub last_step: f64,
    /// Upper limit of the energy less the work of constant loads, J.
    ///
    /// With generalised-α it is the lowest value since the loads changed. With the trapezoid it is the first value less
    /// the energy lost by damping.
    pub reference_energy: f64,
    /// Largest kinetic or elastic energy since the loads changed, J; 0 without a reference.
    pub largest_energy: f64,
    /// Exchange with the loads.
    pub exchange: Exchange<D>,
    /// Exchange with a driven root, or with the force that tows a free root.
    pub drive: Drive<D>,
    /// Pressure that strains the rod, Pa; empty without such a strain.
    pub pressure: Vec<f64>,
    /// Angle of a torsion spring at the root; `None` without a spring and in space.
    pub hinge: Option<HingeState>,
}

/// Angle θ of a torsion spring between two steps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HingeState {
    /// θ, rad.
    pub angle: f64,
    /// θ', rad/s.
    pub rate: f64,
    /// θ'', rad/s².
    pub acceleration: f64,
    /// θ one step earlier, rad (BDF2).
    pub previous_angle: f64,
    /// θ' one step earlier, rad/s (BDF2).
    pub previous_rate: f64,
}

/// Force, power and work of the loads on the rod: nodal forces with impedance and pressure jump, without gravity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exchange<const D: usize> {
    /// Sum of the loads at the end of the last step, N.
    pub force: Vector<D>,
    /// Power of the loads at the end of the last step, W.
    pub power: f64,
    /// Work of the loads since the start, J: the sum of power times step.
    pub work: f64,
}

/// Force, moment, power and work of the drive on the rod; 0 for a root at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Drive<const D: usize> {
    /// Force at the end of the last step, N; it balances the loads on node 0 and accelerates the mass of node 0.
    pub force: Vector<D>,
    /// Moment about the root at the end of the last step, N m; in two dimensions only the last component.
    pub moment: [f64; 3],
    /// Power of force and moment at the end of the last step, W.
    pub power: f64,
    /// Work of force and moment since the start, J: the sum of power times step.
    pub work: f64,
}

impl HingeState {
    /// Return the motion of the angle.
    pub(crate) fn motion(&self) -> Motion<f64> {
        let Self { angle, rate, acceleration, previous_angle, previous_rate } = *self;
        Motion { x: angle, v: rate, a: acceleration, previous_x: previous_angle, previous_v: previous_rate }
    }

    fn is_finite(&self) -> bool {
        let Self { angle, rate, acceleration, previous_angle, previous_rate } = *self;
        [angle, rate, acceleration, previous_angle, previous_rate].iter().all(|number| number.is_finite())
    }
}

impl<const D: usize> Exchange<D> {
    /// Return the exchange before the first step.
    pub fn none() -> Self {
        Self { force: Vector::zeros(), power: 0.0, work: 0.0 }
    }
}

impl<const D: usize> Drive<D> {
    /// Return the drive before the first step.
    pub fn none() -> Self {
        Self { force: Vector::zeros(), moment: [0.0; 3], power: 0.0, work: 0.0 }
    }
}

impl<const D: usize> State<D> {
    /// Return the state at rest in the shape `positions`, with the unit tangent `direction` at the root.
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

    /// Return the state of node 0 and of the tangent there.
    pub(crate) fn base(&self) -> BaseState<D> {
        let (position, velocity) = (self.positions[0], self.velocities[0]);
        BaseState { position, velocity, direction: self.direction, direction_rate: self.direction_rate }
    }

    /// Set the state of node 0 and of the tangent there.
    pub(crate) fn set_base(&mut self, base: &BaseState<D>) {
        (self.positions[0], self.velocities[0]) = (base.position, base.velocity);
        (self.direction, self.direction_rate) = (base.direction, base.direction_rate);
    }

    /// Move node 0 to its state `dt` later, with the acceleration at the end of the cubic in between.
    pub(crate) fn move_base(&mut self, base: &BaseState<D>, dt: f64) {
        let (x, v) = (self.positions[0], self.velocities[0]);
        (self.previous_positions[0], self.previous_velocities[0]) = (x, v);
        self.accelerations[0] = (x - base.position) * (6.0 / (dt * dt)) + (v * 2.0 + base.velocity * 4.0) / dt;
        self.set_base(base);
    }

    /// Give the tangent at node 0, and node 0 in all components but `axis`, the state `base`; `root` is the motion of
    /// node 0 `dt` earlier.
    pub(crate) fn move_slide(&mut self, root: &Motion<Vector<D>>, base: &BaseState<D>, dt: f64, axis: usize) {
        let (x, v, a) = (self.positions[0], self.velocities[0], self.accelerations[0]);
        (self.positions[0], self.velocities[0]) = (root.x, root.v);
        self.move_base(base, dt);
        self.positions[0][axis] = x[axis];
        self.velocities[0][axis] = v[axis];
        self.accelerations[0][axis] = a[axis];
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
        self.direction = other.direction;
        self.direction_rate = other.direction_rate;
        self.last_step = other.last_step;
        (self.reference_energy, self.largest_energy) = (other.reference_energy, other.largest_energy);
        self.exchange = other.exchange;
        self.drive = other.drive;
        self.pressure.copy_from_slice(&other.pressure);
        self.hinge = other.hinge;
    }

    /// Refuse an exchange or a drive that is not finite: loads or a motion of the root that are too large.
    pub(crate) fn check_exchange(&self) -> Result<(), Error> {
        let Exchange { force, power, work } = self.exchange;
        if force.iter().chain([&power, &work]).any(|number| !number.is_finite()) {
            return Err(Error::value("state.exchange", format!("{:?}", self.exchange), "finite"));
        }
        let Drive { force, moment, power, work } = self.drive;
        if force.iter().chain(&moment).chain([&power, &work]).any(|number| !number.is_finite()) {
            return Err(Error::value("state.drive", format!("{:?}", self.drive), "finite"));
        }
        Ok(())
    }

    /// Refuse arrays of a wrong length, numbers that are not finite, and a negative last step or largest energy.
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
        self.check_exchange()?;
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
