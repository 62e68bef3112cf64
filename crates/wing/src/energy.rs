//! Energies of a wing.

/// Energies, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy, without the displaced fluid.
    pub kinetic: f64,
    /// Energy of the strain of the membrane, with its tension.
    pub stretching: f64,
    /// Energy of bending of the membrane.
    pub bending: f64,
    /// Energy of the veins.
    pub veins: f64,
    /// Energy of contact.
    pub contact: f64,
    /// Potential energy in gravity, 0 at rest.
    pub gravity: f64,
}

impl Energy {
    /// Return the sum of all energies.
    pub fn total(&self) -> f64 {
        self.kinetic + self.stretching + self.bending + self.veins + self.contact + self.gravity
    }
}

/// What a sub-step is compared with where no drive does work.
#[derive(Clone, Copy)]
pub(crate) struct EnergyBefore {
    pub(crate) energy: Energy,
    /// Exchange of energy below which all is rounding, J.
    pub(crate) rounding: f64,
}
