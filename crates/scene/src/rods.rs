//! One of several rods, a unit of its own.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::beam::Beam;
use crate::fault::{Check, Faults, list};
use crate::rod::Rod;

/// One of several rods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedRod {
    /// Name of the unit, at most 40 characters: a letter, then letters, digits and `_`; not `rod` or `fluid`.
    #[schemars(regex(pattern = NAME))]
    pub name: String,
    /// Geometry of the beam.
    pub beam: Beam,
    /// Elastic model of the beam.
    pub rod: Rod,
}

/// Pattern of the name of a rod.
pub(crate) const NAME: &str = "^[A-Za-z][A-Za-z0-9_]{0,39}$";

/// Most characters of the name of a rod.
const NAME_LENGTH: usize = 40;

/// Names of the units of which a scene has only one.
pub(crate) const TAKEN: [&str; 5] = ["rod", "wing", "body", "fluid", "contact"];

impl Check for NamedRod {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        check_name(&self.name, &format!("{key}.name"), &TAKEN, faults);
    }
}

/// Check the name of a unit, which must not be one of those `taken`.
pub(crate) fn check_name(name: &str, key: &str, taken: &[&str], faults: &mut Faults) {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let begins = name.starts_with(|c: char| c.is_ascii_alphabetic());
    let good = begins && name.len() <= NAME_LENGTH && name.chars().all(word);
    faults.require(good, key, format!("{name:?}"), || {
        format!("a name is a letter, then letters a-z, A-Z, digits and _, at most {NAME_LENGTH} together")
    });
    let is_taken = taken.iter().any(|taken| taken.eq_ignore_ascii_case(name));
    let names = || list(taken, "and");
    faults.require(!is_taken, key, format!("{name:?}"), || format!("{} are the names of other units", names()));
}
