//! Memory of a rod besides the motion of its nodes.

use serde::{Deserialize, Serialize};
use structure::{Motion, Vector, finite};

use crate::Error;

/// Tolerance of the length of a unit vector, for rounding.
const UNIT_TOLERANCE: f64 = 1e-9;

/// State of a rod between two steps; nodes are numbered from root to tip.
pub type RodState<const D: usize> = structure::State<D, RodMemory<D>>;

/// Memory of a rod besides the motion of its nodes.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct RodMemory<const D: usize> {
    /// Unit tangent at the root.
    pub direction: Vector<D>,
    /// Rate of the unit tangent, 1/s.
    pub direction_rate: Vector<D>,
    /// Upper limit of the energy less the work of constant loads, J.
    ///
    /// With generalised-α it is the lowest value since the loads changed. With the trapezoid it is the first value less
    /// the energy lost by damping.
    pub reference_energy: f64,
    /// Largest kinetic or elastic energy since the loads changed, J; 0 without a reference.
    pub largest_energy: f64,
    /// Pressure that strains the rod, Pa; empty without such a strain.
    pub pressure: Vec<f64>,
    /// Angle θ of a torsion spring at the root; `None` without a spring and in space.
    pub hinge: Option<Motion<f64>>,
}

impl<const D: usize> RodMemory<D> {
    /// Return the memory of a rod at rest with the unit tangent `direction` at the root.
    pub(crate) fn at_rest(direction: Vector<D>, pressure: Vec<f64>, hinge: Option<Motion<f64>>) -> Self {
        let direction_rate = Vector::zeros();
        Self { direction, direction_rate, reference_energy: 0.0, largest_energy: 0.0, pressure, hinge }
    }

    /// Refuse numbers that are not finite, a tangent of another length and a negative largest energy.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if let Some(k) = self.pressure.iter().position(|p| !p.is_finite()) {
            return Err(Error::value(format!("state.pressure[{k}]"), self.pressure[k], "finite"));
        }
        finite("state.direction", self.direction.as_slice())?;
        finite("state.direction_rate", self.direction_rate.as_slice())?;
        if (self.direction.norm() - 1.0).abs() > UNIT_TOLERANCE {
            return Err(Error::value("state.direction", self.direction.as_slice(), "a vector of length 1"));
        }
        if let Some(Motion { x, v, a, previous_x, previous_v }) = self.hinge {
            finite("state.hinge", &[x, v, a, previous_x, previous_v])?;
        }
        if !self.reference_energy.is_finite() {
            return Err(Error::value("state.reference_energy", self.reference_energy, "finite"));
        }
        match self.largest_energy.is_finite() && self.largest_energy >= 0.0 {
            true => Ok(()),
            false => Err(Error::value("state.largest_energy", self.largest_energy, "a finite number of at least 0 J")),
        }
    }
}

impl<const D: usize> Clone for RodMemory<D> {
    fn clone(&self) -> Self {
        Self { pressure: self.pressure.clone(), ..*self }
    }

    fn clone_from(&mut self, other: &Self) {
        (self.direction, self.direction_rate) = (other.direction, other.direction_rate);
        (self.reference_energy, self.largest_energy) = (other.reference_energy, other.largest_energy);
        self.pressure.clone_from(&other.pressure);
        self.hinge = other.hinge;
    }
}
