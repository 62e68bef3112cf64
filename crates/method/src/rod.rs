//! Methods of the rod.

#[cfg(feature = "scene")]
use schemars::JsonSchema;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// An axis of the coordinates or of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    #[default]
    Z,
}

/// Mass and stiffness of a section at one place (per metre of depth in a two-dimensional scene).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Section {
    /// Mass per length, kg/m.
    pub line_density: f64,
    /// Bending stiffness EI, N m².
    pub bending_stiffness: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Shear stiffness GA_s, N; none where the section stays normal to the rod.
    pub shear_stiffness: Option<f64>,
}

/// Angle on which the bending energy depends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
pub enum Bending {
    /// Turning angle ψ between neighbouring segments, by 2 tan(ψ/2) (Bergou et al. 2008): the same in every frame.
    #[default]
    Invariant,
    /// Angles of the segments' projections into the planes xy and xz (thesis eqs. 2.1 and 2.4): depends on the frame
    /// and is singular where a projection vanishes, which is an error.
    Projected,
}

/// Calibration of the springs and masses of a discrete rod by the section.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "scene",
    derive(Serialize, Deserialize, JsonSchema),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Calibration {
    /// k_e = EA/l0, clamp spring EI/(l0/2), half a segment's mass at the tip: of second order in the length l0 of a
    /// segment.
    #[default]
    SecondOrder,
    /// Thesis, section 2.4.1: one k_e for segments of any length, clamp spring EI/l0, a whole segment's mass at every
    /// node. Of first order.
    Thesis {
        /// Axial stiffness of a segment, N/m, in place of EA.
        #[cfg_attr(feature = "scene", schemars(extend("exclusiveMinimum" = 0.0)))]
        k_e: f64,
    },
}

/// Time scheme of the rod; all are of second order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema))]
#[cfg_attr(feature = "scene", serde(rename_all = "snake_case", deny_unknown_fields), schemars(rename = "RodScheme"))]
pub enum Scheme {
    /// Trapezoidal rule (thesis eq. 2.7), without numerical dissipation; unsafe for stiff axial modes.
    Trapezoid,
    /// Generalised-α (Chung & Hulbert 1993).
    GeneralisedAlpha {
        /// Spectral radius at infinite frequency, 0 … 1.
        #[cfg_attr(feature = "scene", schemars(range(min = 0.0, max = 1.0)))]
        rho_inf: f64,
    },
    /// Trapezoidal rule to 2 − √2 of the step, then two-step backward differences (Bank et al. 1985; Hosea & Shampine
    /// 1996): damps stiff modes fully and resolved ones least, with two solves per step.
    #[default]
    TrBdf2,
    /// Two-step backward differences: dissipative, and consistent with the same scheme of the fluid.
    Bdf2,
}

/// Guide of the root: along one axis the root moves under the loads, in all else as `root` and `root_motion` say.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
pub struct Slide {
    /// Axis of the guide; z in three dimensions only.
    pub along: Axis,
    /// Mass that moves with the root besides the rod, kg (per metre of depth in two dimensions).
    #[cfg_attr(feature = "scene", serde(default), schemars(range(min = 0.0)))]
    pub mass: f64,
}
