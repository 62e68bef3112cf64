//! Checks of the numerical method of the fluid, and its steps.

use method::{Mask, TimeScheme};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};

/// Steps of the fluid inside a communication step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend(
    "if" = { "properties": { "scheme": { "const": TimeScheme::Rk2 } }, "required": ["scheme"] },
    "then" = { "properties": { "max_cfl": { "maximum": TimeScheme::Rk2.largest_cfl() } } },
    "else" = { "properties": { "max_cfl": { "maximum": TimeScheme::Sbdf2.largest_cfl() } } }
))]
pub struct TimeStepping {
    /// Largest step, s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_step: f64,
    /// Largest CFL number max(|u|/dx + |v|/dy) dt, at most 0.4 with `sbdf2` and 0.6 with `rk2`: above, advection is
    /// unstable. A step that would exceed it is divided.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_cfl: f64,
    /// Time scheme.
    #[serde(default)]
    pub scheme: TimeScheme,
}

/// Largest thickness of a wall's layer by the cells of the shorter side of the box.
const THICKEST_LAYER: f64 = 0.25;

/// Check that the layer of the wall of a mask, the value of `key`, fits a box of so many `cells`.
pub(crate) fn check_mask(mask: &Mask, key: &str, cells: &[usize], faults: &mut Faults) {
    let shortest = cells.iter().copied().min().unwrap_or_default();
    let largest = THICKEST_LAYER * shortest as f64;
    let lengths = match *mask {
        Mask::Sharp { .. } => [None; 2],
        Mask::Cosine { half_width, .. } => [Some(("cosine.half_width", half_width)), None],
        Mask::LogLinear { decay_length_cells, core_depth, .. } => [
            Some(("log_linear.decay_length_cells", decay_length_cells)),
            core_depth.map(|d| ("log_linear.core_depth", d)),
        ],
    };
    for (name, length) in lengths.into_iter().flatten() {
        faults.require(length <= largest, &format!("{key}.{name}"), length, || {
            let all = cells.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
            format!("it is a number of cells, and the box has {all}: it must be <= {largest}")
        });
    }
}
impl Check for TimeStepping {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        let Self { max_cfl, scheme, .. } = self;
        let largest = scheme.largest_cfl();
        faults.require(*max_cfl <= largest, &format!("{key}.max_cfl"), max_cfl, || {
            format!("advection with the scheme {} is unstable above {largest}", scheme.name())
        });
    }
}
