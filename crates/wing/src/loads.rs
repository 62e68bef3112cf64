//! Loads on the nodes.

use serde::{Deserialize, Serialize};

use crate::Error;

/// Loads on the nodes, constant over a step; an empty array is an absent load. Loads on held nodes act on the root.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Nodal forces, N, component after component: `[3, nodes]`.
    pub force: Vec<f64>,
    /// Impedance D of the nodal forces, kg/s, at least 0: `[nodes]`.
    ///
    /// A node that moves at the velocity v receives the force f − D (v − v_ref), where v_ref is its velocity at the
    /// beginning of the step.
    pub impedance: Vec<f64>,
}

impl Loads {
    /// Refuse arrays of a wrong length, numbers that are not finite and a negative impedance.
    pub(crate) fn check(&self, nodes: usize) -> Result<(), Error> {
        for (name, array, expected) in [("force", &self.force, 3 * nodes), ("impedance", &self.impedance, nodes)] {
            if !array.is_empty() && array.len() != expected {
                return Err(Error::Length { name: format!("loads.{name}"), length: array.len(), expected });
            }
            if let Some(k) = array.iter().position(|value| !value.is_finite()) {
                return Err(Error::value(format!("loads.{name}[{k}]"), array[k], "finite"));
            }
        }
        match self.impedance.iter().position(|&d| d < 0.0) {
            Some(k) => Err(Error::value(format!("loads.impedance[{k}]"), self.impedance[k], "at least 0 kg/s")),
            None => Ok(()),
        }
    }
}
