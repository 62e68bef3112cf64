//! Contact of rods with what is in their way.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::Body;

/// Contact of rods with themselves, with solids, and with walls, cylinders and bodies of the fluid that are still or
/// moved by laws. Bodies that the fluid or the master moves do not take part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Gap between surfaces at which the force begins, m; absent: the least thickness of the beam, or two cells.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub range: Option<f64>,
    /// Stiffness per metre of rod where surfaces meet, N/m² (per metre of depth in two dimensions); absent: a contact
    /// lasts ten steps.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness: Option<f64>,
    /// Damping of the gap per metre of rod where surfaces meet, kg/(m s).
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub damping: f64,
    /// Coefficient of friction.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// Solids besides those of the fluid, which does not see them: still, or moved by laws.
    #[serde(default)]
    pub obstacles: Vec<Body>,
}
