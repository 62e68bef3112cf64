//! Loads on the nodes.

use serde::{Deserialize, Serialize};

use crate::Error;

/// Loads on the nodes, of a rod from root to tip, constant over a step; an empty array is an absent load.
///
/// Loads on held nodes act on their support alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Nodal forces, N, component after component: `[D, nodes]`, so the components are `force.chunks_exact(nodes)`.
    pub force: Vec<f64>,
    /// Pressure jump across a rod, p_top − p_bottom, Pa: `[nodes]`; in two dimensions only.
    ///
    /// Top is the side of the left-hand normal n, and the load per length is −\[p\] n. The normal is the normal of the
    /// shape at the beginning of the step.
    pub pressure_jump: Vec<f64>,
    /// Impedance D of the nodal forces, kg/s, at least 0: `[nodes]`.
    ///
    /// A node that moves at the velocity v receives the force f − D (v − v_ref), where v_ref is its velocity at the
    /// beginning of the step. Coupling with a fluid as dense as the rod is unstable at D = 0. On a wing with a layer of
    /// displaced fluid D acts across the surface; along it, the mass of the layer over the step does, if D is larger.
    pub impedance: Vec<f64>,
    /// Mean pressure around the section, Pa: `[nodes]`.
    ///
    /// It strains a rod by `strain_per_pressure` and exerts no force: nodal forces that follow from pressure
    /// differences do not contain its level (docs/theory/coupling.md). The strain lags by the period of the first axial
    /// mode. A wing ignores it.
    pub pressure: Vec<f64>,
}

impl Loads {
    /// Copy the loads of as many nodes; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.force.clone_from(&other.force);
        self.pressure_jump.clone_from(&other.pressure_jump);
        self.impedance.clone_from(&other.impedance);
        self.pressure.clone_from(&other.pressure);
    }

    /// Refuse arrays of a wrong length, numbers that are not finite and a negative impedance.
    pub(crate) fn check<const D: usize, F>(&self, nodes: usize) -> Result<(), Error<F>> {
        for (name, array, expected) in [
            ("force", &self.force, D * nodes),
            ("pressure_jump", &self.pressure_jump, if D == 2 { nodes } else { 0 }),
            ("impedance", &self.impedance, nodes),
            ("pressure", &self.pressure, nodes),
        ] {
            if !array.is_empty() {
                Error::check_length(format_args!("loads.{name}"), array.len(), expected)?;
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
