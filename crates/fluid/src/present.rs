//! The present time: bodies and beams as the fluid last saw them. All of it is in double precision.

use serde::{Deserialize, Serialize};

use crate::bodies::{Carried, Loads, Stations};
use crate::force::{BodyForce, Exchange};

/// What a fluid of any precision and scheme has at the present time, without the flow.
#[derive(Clone, Debug)]
pub struct Present {
    /// Time, s.
    pub time: f64,
    /// Last step, s; 0 before the first.
    pub step: f64,
    /// Largest `|u|/dx + |v|/dy`, 1/s.
    pub advection_rate: f64,
    /// Forces on the cylinders, the other rigid bodies and the beams.
    pub bodies: Vec<BodyForce>,
    /// Displacements of the bodies that laws do not move.
    pub carried: Vec<Carried>,
    /// The beams.
    pub beams: Beams,
}

/// The beams as the fluid last saw them; every list is empty without one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beams {
    /// Stations.
    pub stations: Vec<Stations>,
    /// Loads for the coming step; empty if no loads are predicted.
    pub loads: Vec<Loads>,
    /// Forces, powers and works of the fluid on the beams.
    pub exchange: Vec<Exchange>,
    /// Pressure above less the pressure below the stations of each thin beam, Pa; empty for a beam with a mask.
    pub line_jump: Vec<Vec<f64>>,
    /// Shear stress on both faces of each thin beam towards its tip, Pa, in the same places.
    pub line_shear: Vec<Vec<f64>>,
}

impl Present {
    /// Return the CFL number of the last step, or of a step of another length (s) in the present flow.
    pub fn cfl(&self, step: f64) -> f64 {
        self.advection_rate * step
    }
}

impl Beams {
    /// Copy `other`, which has the same shape; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        Stations::copy_all(&mut self.stations, &other.stations);
        self.loads.iter_mut().zip(&other.loads).for_each(|(own, other)| own.copy_from(other));
        self.exchange.copy_from_slice(&other.exchange);
        for (own, other) in [(&mut self.line_jump, &other.line_jump), (&mut self.line_shear, &other.line_shear)] {
            own.iter_mut().zip(other).for_each(|(own, other)| own.copy_from_slice(other));
        }
    }

    /// Return whether `other` has as many beams with as many stations.
    pub fn have_shape_of(&self, other: &Self) -> bool {
        let lengths = |beams: &Self| [beams.stations.len(), beams.loads.len(), beams.exchange.len()];
        let stresses =
            |beams: &Self| [&beams.line_jump, &beams.line_shear].map(|of| of.iter().map(Vec::len).collect::<Vec<_>>());
        lengths(self) == lengths(other)
            && stresses(self) == stresses(other)
            && self.stations.iter().zip(&other.stations).all(|(a, b)| a.has_shape_of(b))
            && self.loads.iter().zip(&other.loads).all(|(a, b)| a.has_shape_of(b))
    }
}
