//! Contact of rods, wings and bodies with what is in their way.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::Body;

/// Contact of rods with themselves, and of rods, membranes of wings and bodies on a mount with each other, and with walls,
/// cylinders and bodies of the fluid that are still or moved by laws. Without a fluid it couples several rods and wings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Gap between surfaces at which the force begins, m; absent: the least thickness of the beam or beams, or two cells,
    /// with a film its roughness.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub range: Option<f64>,
    /// Stiffness where surfaces meet, in two dimensions per metre of depth: of a rod per metre, N/m², of a wing per area,
    /// N/m³, of a body N/m, which acts at most as that by default; absent: a contact lasts ten steps.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stiffness: Option<f64>,
    /// Damping of the gap where surfaces meet, in two dimensions per metre of depth: of a rod per metre, kg/(m s), of a
    /// wing per area, kg/(m² s), of a body kg/s.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub damping: f64,
    /// Coefficient of friction.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub friction: f64,
    /// Film of the fluid between bodies: what the grid misses of it, below gaps of 1.25 cells; absent: none.
    #[serde(default)]
    pub film: Option<Film>,
    /// Solids besides those of the fluid, which does not see them: still, or moved by laws.
    #[serde(default)]
    pub obstacles: Vec<Body>,
}

/// Film between spheres, in two dimensions circles, and walls, by lubrication theory.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Film {
    /// Gap below which the force grows no more, m: the height of the roughness.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub roughness: f64,
}
