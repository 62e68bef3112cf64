//! The coupling of fluid and rods: load, scheme and guards.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Coupling of fluid, or contact, and rods. Load and scheme follow rules where they are absent (`docs/theory/coupling.md`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// Load of the fluid on the rod. Absent: `momentum` where the rod is heavy enough and the fluid makes one step
    /// between two exchanges, otherwise `pressure_jump`.
    #[serde(default)]
    pub load: Option<Load>,
    /// Order of the steps of both units within a communication step. Absent: `explicit` with the load `momentum`,
    /// `iterated` with `pressure_jump`.
    #[serde(default)]
    pub scheme: Option<CouplingScheme>,
    /// Whether the pressure around the rod also strains it along its axis. The load `momentum` knows only differences
    /// of the pressure; here its zero is the mean over the outlet, the upstream end of the inflow zone. Needs that
    /// load, an inflow and a material in plane strain, and costs the fluid three transforms per step.
    #[serde(default)]
    pub axial_pressure_strain: bool,
    /// Limits that stop an unstable explicit run. Absent: the defaults where both units are nervure's, none with a
    /// foreign unit.
    #[serde(default)]
    pub guards: Option<Guards>,
}

/// Limits that stop an unstable run with the scheme `explicit` or `parallel_explicit`, by the powers across the
/// interface: an unstable run may stay finite. A limit of `null` is off. With this key the limits hold for foreign
/// units too, which then need the outputs `load.power` of the rod and, with the load `momentum`, `beam.power` of the
/// fluid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Guards {
    /// Number of steps over which means of magnitudes fade, and before which no run is stopped; at least 1.
    #[schemars(range(min = 1))]
    pub window_steps: u32,
    /// Largest difference between the power on the rod and the power from the fluid with the load `momentum`, relative
    /// to the latter, in means of magnitudes: 0.04 in FSI3, 1 in a run that diverges. `null`: off.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub largest_imbalance: Option<f64>,
    /// Largest second difference over steps of the power on the rod with the load `pressure_jump`, relative to the
    /// power, in means of magnitudes: 4 for a sawtooth, 2.4 for noise, below 0.8 in stable runs. `null`: off.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub largest_noise: Option<f64>,
    /// Mean power below which noise stops no run, W per metre of depth: the power on a rod at rest is rounding.
    #[schemars(range(min = 0.0))]
    pub min_power: f64,
}

impl Default for Guards {
    fn default() -> Self {
        Self { window_steps: 500, largest_imbalance: Some(0.5), largest_noise: Some(1.5), min_power: 1e-9 }
    }
}

/// Load of the fluid on the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// Momentum that the penalization takes from the fluid, with its impedance. The rod's mass is then reduced by the
    /// mass of the fluid it displaces.
    Momentum,
    /// Jump of the static pressure across the beam (thesis eq. 4.2). The rod has its whole mass.
    PressureJump,
}

/// Order of the steps of both units within a communication step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum CouplingScheme {
    /// One step each: first the rod, then the fluid with the rod's new state (serial, Gauss–Seidel).
    Explicit,
    /// One step each, both from the state at the beginning (parallel, Jacobi).
    ParallelExplicit,
    /// Steps with rollback of both units until the interface agrees. Not with the load `momentum`.
    Iterated {
        /// Residual of the interface displacement at which the step is accepted, relative to its change over the step.
        #[serde(default = "default_tolerance")]
        #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0))]
        tolerance: f64,
        /// Largest number of iterations in a step; a step that needs more is an error.
        #[serde(default = "default_max_iterations")]
        #[schemars(range(min = 2))]
        max_iterations: u32,
        /// Acceleration of the iteration.
        #[serde(default)]
        acceleration: Acceleration,
    },
}

/// Acceleration of the iteration, which makes the next guess from the residuals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Acceleration {
    /// Relaxation by Aitken's formula (Küttler & Wall 2008).
    Aitken,
    /// Interface quasi-Newton with the inverse Jacobian from least squares (Degroote et al. 2009).
    #[default]
    IqnIls,
}

fn default_tolerance() -> f64 {
    1e-4
}

fn default_max_iterations() -> u32 {
    50
}

impl Load {
    /// Return the word that scenes use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Momentum => "momentum",
            Self::PressureJump => "pressure_jump",
        }
    }
}
