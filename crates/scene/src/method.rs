//! The numerical method of the fluid: drag of solids, precision, filter and time stepping.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};

fn a_quarter() -> f64 {
    0.25
}

fn yes() -> bool {
    true
}

/// Drag rate of a solid as a function of the signed distance to its surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Mask {
    /// chi = 1 inside and 0 outside (thesis ch. 3). The wall is shifted by √(ν C_eta), so that no-slip holds at the
    /// surface.
    Sharp {
        /// Relaxation time C_eta, s.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        c_eta: f64,
        /// Whether the wall is shifted; otherwise the mask is the one of the thesis.
        #[serde(default = "yes")]
        displacement_corrected: bool,
    },
    /// Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds at the surface (Hester, Vasil &
    /// Burns 2021).
    Cosine {
        /// Relaxation time C_eta, s.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        c_eta: f64,
        /// Half the width of the layer, grid cells.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        half_width: f64,
        /// Whether the layer is shifted; otherwise the mask is the one of the thesis.
        #[serde(default = "yes")]
        displacement_corrected: bool,
    },
    /// Drag rate that grows exponentially with depth. No-slip then holds at the surface wherever the grid lies.
    LogLinear {
        /// Smallest relaxation time, s, reached inside the solid.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        c_eta: f64,
        /// Depth over which the drag rate grows by a factor e, grid cells. A quarter is the shortest that the grid
        /// resolves: the wall keeps its place to 0.03 cells wherever the grid lies.
        #[serde(default = "a_quarter")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        decay_length_cells: f64,
        /// Depth at which the core of a still body begins, grid cells. In the core the drag rate grows three times as
        /// fast, up to 1/C_eta; above a deep core it stays at the value that the grid resolves. Absent: one and a half
        /// decay lengths, three without a wall correction. With 2 the forces depend much less on C_eta, but a body of
        /// fewer than 25 cells across is porous. The depth is at most a fifth of a body's thickness. A beam or a moving
        /// body has a core only where it is thinner than about four cells.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        core_depth: Option<f64>,
        /// Velocity to which the bodies draw the fluid at their surface.
        #[serde(default)]
        wall_correction: WallCorrection,
    },
}

/// Velocity to which a body draws the fluid at its surface. It decides which flows along a wall are right to the order
/// of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WallCorrection {
    /// Velocity of the body. No-slip holds at the surface in linear shear, but the smooth drag lets a flux through.
    None,
    /// Inside the body, weakly, the mirror image of the flow outside. The flux is that of linear shear.
    Shear,
    /// As `shear`, with a correction at the surface by the second difference of the flow outside. No-slip also holds
    /// where a pressure gradient bends the velocity profile.
    #[default]
    Curvature,
}

/// Precision of the fields and transforms. Bodies, forces and loads are always in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 16 digits.
    #[default]
    Double,
    /// 7 digits at half the memory. Unfit for small differences, such as a lift of 1e-5 of the drag, or orders of
    /// convergence.
    Single,
}

/// Filter of aliasing errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Filter {
    /// exp(−36 (k/k_max)³⁶) (Hou & Li 2007).
    #[default]
    Smooth,
    /// Truncation outside the ellipse of two thirds (thesis eq. 3.14).
    TwoThirds,
    /// No filter.
    None,
}

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

/// Time scheme of the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeScheme {
    /// Two-step backward differences with implicit drag and viscosity: only advection limits the step.
    #[default]
    Sbdf2,
    /// Heun's method with explicit drag and exact viscosity (thesis eq. 3.15 – 3.18): a step above C_eta is divided.
    Rk2,
}

impl TimeScheme {
    /// Return the largest CFL number of a scene.
    ///
    /// Both schemes are weakly unstable for advection without viscosity. Up to this number the fastest growing wave
    /// under the smooth filter grows by at most half in a step (52 %).
    pub fn largest_cfl(self) -> f64 {
        match self {
            Self::Sbdf2 => 0.4,
            Self::Rk2 => 0.6,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Sbdf2 => "sbdf2",
            Self::Rk2 => "rk2",
        }
    }
}

impl Precision {
    /// Return the fewest grid points along x: the number of columns that are transformed together.
    pub(crate) fn fewest_columns(self) -> usize {
        match self {
            Self::Double => 8,
            Self::Single => 16,
        }
    }
}

impl Mask {
    /// Return the relaxation time C_eta deep inside the solid, s.
    pub fn c_eta(&self) -> f64 {
        match *self {
            Self::Sharp { c_eta, .. } | Self::Cosine { c_eta, .. } | Self::LogLinear { c_eta, .. } => c_eta,
        }
    }
}

/// Largest thickness of a wall's layer by the cells of the shorter side of the box.
const THICKEST_LAYER: f64 = 0.25;

impl Mask {
    /// Check that the layer of the wall fits a box of so many `cells`; the mask is the value of `key`.
    pub(crate) fn check_at(&self, key: &str, cells: &[usize], faults: &mut Faults) {
        let shortest = cells.iter().copied().min().unwrap_or_default();
        let largest = THICKEST_LAYER * shortest as f64;
        let lengths = match *self {
            Self::Sharp { .. } => [None; 2],
            Self::Cosine { half_width, .. } => [Some(("cosine.half_width", half_width)), None],
            Self::LogLinear { decay_length_cells, core_depth, .. } => [
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
