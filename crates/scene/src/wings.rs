//! One of several wings, a unit of its own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::rods::{TAKEN, check_name};
use crate::wing::Wing;

/// One of several wings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedWing {
    /// Name of the unit, at most 40 characters: a letter, then letters, digits and `_`; not that of another unit.
    #[schemars(regex(pattern = crate::rods::NAME))]
    pub name: String,
    /// The wing.
    pub wing: Wing,
}

impl Check for NamedWing {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        check_name(&self.name, &format!("{key}.name"), &TAKEN, faults);
    }
}
