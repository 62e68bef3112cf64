//! Loads on the nodes.

use serde::{Deserialize, Serialize};

use crate::Error;

/// Loads on the nodes, from root to tip, constant over a step; an empty array is an absent load.
///
/// Loads on a held node 0 act on its support alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Nodal forces, N, component after component: `[D, n + 1]`, so the components are `force.chunks_exact(n + 1)`.
    pub force: Vec<f64>,
    /// Pressure jump across the rod, p_top − p_bottom, Pa: `[n + 1]`; in two dimensions only.
    ///
    /// Top is the side of the left-hand normal n, and the load per length is −\[p\] n. The normal is the normal of the
    /// shape at the beginning of the step.
    pub pressure_jump: Vec<f64>,
    /// Impedance D of the nodal forces, kg/s, at least 0: `[n + 1]`.
    ///
    /// A node that moves at the velocity v receives the force f − D (v − v_ref), where v_ref is its velocity at the
    /// beginning of the step. Coupling with a fluid as dense as the rod is unstable at D = 0.
    pub impedance: Vec<f64>,
    /// Mean pressure around the section, Pa: `[n + 1]`.
    ///
    /// It strains the rod by `strain_per_pressure` and exerts no force: nodal forces that follow from pressure
    /// differences do not contain its level (docs/theory/coupling.md). The strain lags by the period of the first axial
    /// mode.
    pub pressure: Vec<f64>,
}

impl Loads {
    /// Refuse arrays of a wrong length, numbers that are not finite and a negative impedance.
    pub(crate) fn check<const D: usize>(&self, nodes: usize) -> Result<(), Error> {
        for (name, array, expected) in [
            ("force", &self.force, D * nodes),
            ("pressure_jump", &self.pressure_jump, if D == 2 { nodes } else { 0 }),
            ("impedance", &self.impedance, nodes),
            ("pressure", &self.pressure, nodes),
        ] {
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
