//! Parameters that a master may set before the start without another scene file.

use rod::{Error, Rod, Section};

use crate::body::{Body, either};

/// Parameters of the rod, in SI units.
#[derive(Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Section at the root.
    pub section: Section,
    pub displaced_line_density: f64,
    pub damping: f64,
    pub clamp_compliance_length: f64,
    pub gravity: [f64; 3],
}

impl Parameters {
    /// Return the parameters of a rod.
    pub fn of(body: &Body) -> Self {
        either!(body, rod => Self::of_rod(rod))
    }

    fn of_rod<const D: usize>(rod: &Rod<D>) -> Self {
        let own = rod.parameters();
        Self {
            section: own.section,
            displaced_line_density: own.displaced,
            damping: own.damping,
            clamp_compliance_length: own.clamp_compliance_length,
            gravity: std::array::from_fn(|axis| own.gravity.get(axis).copied().unwrap_or(0.0)),
        }
    }

    /// Rebuild a rod with these parameters unless it has them already.
    pub fn apply(&self, body: &mut Body) -> Result<(), Error> {
        either!(body, rod => self.apply_to(rod))
    }

    fn apply_to<const D: usize>(&self, rod: &mut Rod<D>) -> Result<(), Error> {
        if Self::of_rod(rod) == *self {
            return Ok(());
        }
        let mut rebuilt = Rod::new(rod::Parameters {
            section: self.section,
            displaced: self.displaced_line_density,
            damping: self.damping,
            clamp_compliance_length: self.clamp_compliance_length,
            gravity: std::array::from_fn(|axis| self.gravity[axis]),
            ..rod.parameters().clone()
        })?;
        rebuilt.loads.clone_from(&rod.loads);
        rebuilt.base_motion = rod.base_motion;
        *rod = rebuilt;
        Ok(())
    }
}
