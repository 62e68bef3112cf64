//! Parameters that a master may set before the start without another scene file.

use adapter::either;
use rod::Section;

use crate::body::Plan;

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
    /// Return the parameters of a plan.
    pub fn of(plan: &Plan) -> Self {
        either!(plan, own => Self {
            section: own.section,
            displaced_line_density: own.displaced,
            damping: own.damping,
            clamp_compliance_length: own.clamp_compliance_length,
            gravity: std::array::from_fn(|axis| own.gravity.get(axis).copied().unwrap_or(0.0)),
        })
    }

    /// Write the parameters to a plan.
    pub fn apply(&self, plan: &mut Plan) {
        either!(plan, own => {
            own.section = self.section;
            own.displaced = self.displaced_line_density;
            own.damping = self.damping;
            own.clamp_compliance_length = self.clamp_compliance_length;
            own.gravity = std::array::from_fn(|axis| self.gravity[axis]);
        });
    }
}
