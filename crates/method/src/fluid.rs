//! Methods of the fluid.

use std::f64::consts::PI;

#[cfg(feature = "scene")]
use schemars::JsonSchema;
#[cfg(feature = "scene")]
use serde::{Deserialize, Serialize};

/// Default length over which the drag of a log-linear mask grows by e, cells.
const DECAY_LENGTH_CELLS: f64 = 0.25;

/// Distance from the surface in decay lengths beyond which the log-linear drag is neglected. In linear shear the
/// neglected part would move the wall by `e^{−2γ} (x² + 2x + 2) e^{−x} λ`, 1.7e-3 λ.
pub const TAIL: f64 = 10.0;

/// Return the grid points on each side of a marker of a line or surface that it drags, in so many dimensions.
pub const fn marker_reach(dimensions: usize) -> usize {
    if dimensions == 2 { 3 } else { 2 }
}

/// Thickness of the plate that a line of markers in the plane stands for, cells: twice the mean of |Y|, where Y is the
/// difference of two independent variables whose density is the kernel.
///
/// In a shear flow along the line the plane of no slip lies the mean of |Y| off the line on both sides, exactly. Across
/// the line a wave of the wavenumber k, interpolated and spread, loses the factor `1 − |k| mean|Y|` to first order, as
/// the potential flow between two vortex sheets at that distance. Of the quintic B-spline itself Y would
/// have the density of that of degree 11, and the thickness would be 1.603.
pub const LINE_THICKNESS_CELLS: f64 = 2_286_280_459.0 / 1_556_755_200.0;

/// The same of a surface in space. Y has the density of the B-spline of degree 7.
pub const SURFACE_THICKNESS_CELLS: f64 = 1487.0 / 1134.0;

/// Cross-section of the rod that a line of markers in space stands for, cells²: the inverse of the density at 0 of the
/// difference of two points of the kernel in the plane across the line.
///
/// A force on the line gives its markers the velocity ½ p(0) f t/rho in a fluid without viscosity, and f t/(2 rho A) to
/// a cylinder of the section A with the fluid in it. Its radius is 1.18 cells.
pub const ROD_SECTION_CELLS: f64 = (315.0 / 151.0) * (315.0 / 151.0);

/// Radius of the cylinder that drags like such a line in slow viscous flow, across and along, cells: exp(mean ln|Y|), Y
/// being that difference.
pub const ROD_RADIUS_CELLS: f64 = 0.873_538_9;

#[cfg(feature = "scene")]
fn a_quarter() -> f64 {
    DECAY_LENGTH_CELLS
}

#[cfg(feature = "scene")]
fn yes() -> bool {
    true
}

/// Drag rate of a solid as a function of the signed distance to its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "scene",
    derive(Serialize, Deserialize, JsonSchema),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum Mask {
    /// chi = 1 inside and 0 outside (thesis ch. 3). The wall is shifted by √(ν C_eta), so that no-slip holds at the
    /// surface.
    Sharp {
        /// Relaxation time C_eta, s.
        #[cfg_attr(feature = "scene", schemars(extend("exclusiveMinimum" = 0.0)))]
        c_eta: f64,
        /// Whether the wall is shifted; otherwise the mask is the one of the thesis.
        #[cfg_attr(feature = "scene", serde(default = "yes"))]
        displacement_corrected: bool,
    },
    /// Cosine layer around the surface (thesis eq. 4.1), shifted so that no-slip holds at the surface (Hester, Vasil &
    /// Burns 2021).
    Cosine {
        /// Relaxation time C_eta, s.
        #[cfg_attr(feature = "scene", schemars(extend("exclusiveMinimum" = 0.0)))]
        c_eta: f64,
        /// Half the width of the layer, grid cells.
        #[cfg_attr(feature = "scene", schemars(extend("exclusiveMinimum" = 0.0)))]
        half_width: f64,
        /// Whether the layer is shifted; otherwise the mask is the one of the thesis.
        #[cfg_attr(feature = "scene", serde(default = "yes"))]
        displacement_corrected: bool,
    },
    /// Drag rate that grows exponentially with depth. No-slip then holds at the surface wherever the grid lies.
    LogLinear {
        /// Smallest relaxation time, s, reached inside the solid.
        #[cfg_attr(feature = "scene", schemars(extend("exclusiveMinimum" = 0.0)))]
        c_eta: f64,
        /// Depth over which the drag rate grows by a factor e, grid cells. A quarter is the shortest that the grid
        /// resolves: the wall keeps its place to 0.03 cells wherever the grid lies.
        #[cfg_attr(feature = "scene", serde(default = "a_quarter"), schemars(extend("exclusiveMinimum" = 0.0)))]
        decay_length_cells: f64,
        /// Depth at which the core of a still body begins, grid cells. In the core the drag rate grows three times as
        /// fast, up to 1/C_eta; above a deep core it stays at the value that the grid resolves. Absent: one and a half
        /// decay lengths, three without a wall correction. With 2 the forces depend much less on C_eta, but a body of
        /// fewer than 25 cells across is porous. The depth is at most a fifth of a body's thickness. A beam or a moving
        /// body has a core only where it is thinner than about four cells.
        #[cfg_attr(feature = "scene", serde(default), schemars(extend("exclusiveMinimum" = 0.0)))]
        core_depth: Option<f64>,
        /// Velocity to which the bodies draw the fluid at their surface.
        #[cfg_attr(feature = "scene", serde(default))]
        wall_correction: WallCorrection,
    },
}

/// Velocity to which a body draws the fluid at its surface. It decides which flows along a wall are right to the order
/// of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
pub enum Precision {
    /// 16 digits.
    #[default]
    Double,
    /// 7 digits at half the memory. Unfit for small differences, such as a lift of 1e-5 of the drag, or orders of
    /// convergence.
    Single,
}

/// Filter of aliasing errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
pub enum Filter {
    /// exp(−36 (k/k_max)³⁶) (Hou & Li 2007).
    #[default]
    Smooth,
    /// Truncation outside the ellipse of two thirds (thesis eq. 3.14).
    TwoThirds,
    /// No filter.
    None,
}

/// Time scheme of the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
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
    /// Both schemes are unstable for advection without viscosity, `sbdf2` above a quarter. Up to this number the fastest
    /// growing wave under the smooth filter grows by at most three fifths in a step (57 %, `rk2` 52 %).
    pub fn largest_cfl(self) -> f64 {
        match self {
            Self::Sbdf2 => 0.4,
            Self::Rk2 => 0.6,
        }
    }

    /// Return the largest CFL number in a fluid without bodies, where a stream may be as fast everywhere as the CFL
    /// number counts: with `sbdf2` that above which waves grow without viscosity.
    pub fn largest_cfl_without_bodies(self) -> f64 {
        match self {
            Self::Sbdf2 => 0.25,
            Self::Rk2 => self.largest_cfl(),
        }
    }

    /// Return the name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sbdf2 => "sbdf2",
            Self::Rk2 => "rk2",
        }
    }
}

impl Precision {
    /// Return the size of a number, bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::Double => size_of::<f64>(),
            Self::Single => size_of::<f32>(),
        }
    }

    /// Return the fewest grid points along x: the number of columns that are transformed together.
    pub fn fewest_columns(self) -> usize {
        match self {
            Self::Double => 8,
            Self::Single => 16,
        }
    }
}

impl Mask {
    /// Return a log-linear mask with the default decay length and the correction of curvature.
    pub fn log_linear(c_eta: f64) -> Self {
        let wall_correction = WallCorrection::default();
        Self::LogLinear { c_eta, decay_length_cells: DECAY_LENGTH_CELLS, core_depth: None, wall_correction }
    }

    /// Return the relaxation time C_eta deep inside the solid, s.
    pub fn c_eta(&self) -> f64 {
        match *self {
            Self::Sharp { c_eta, .. } | Self::Cosine { c_eta, .. } | Self::LogLinear { c_eta, .. } => c_eta,
        }
    }

    /// Return the displacement of the mask into the solid with a relaxation time (s), a viscosity (m²/s) and cells of
    /// size `dx` (m), m.
    pub fn shift(&self, c_eta: f64, nu: f64, dx: f64) -> f64 {
        let eps = (nu * c_eta).sqrt();
        match *self {
            Self::Sharp { displacement_corrected: true, .. } => -eps,
            Self::Cosine { displacement_corrected: true, half_width, .. } => {
                eps * cosine_wall_displacement(half_width * dx / eps)
            }
            _ => 0.0,
        }
    }

    /// Return the distance from the surface of a body beyond which there is no drag, with a viscosity (m²/s) and cells
    /// of size `dx` (m), m.
    pub fn reach(&self, nu: f64, dx: f64) -> f64 {
        let half_width = match *self {
            Self::Sharp { .. } => 0.0,
            Self::Cosine { half_width, .. } => half_width,
            Self::LogLinear { decay_length_cells, .. } => TAIL * decay_length_cells,
        };
        (half_width * dx - self.shift(self.c_eta(), nu, dx)).max(0.0)
    }
}

/// Return the displacement of the no-slip wall by a cosine mask of half-width `h`, both in units of eps = √(ν C_eta),
/// positive if the body is too thick: the zero of the solution of u″ = chi u that decays into the solid and is linear
/// in the fluid (Hester, Vasil & Burns 2021).
fn cosine_wall_displacement(h: f64) -> f64 {
    const STEPS: usize = 4000;
    let chi = |x: f64| 0.5 * (1.0 + (PI * (x + h) / (2.0 * h)).cos());
    let dx = 2.0 * h / STEPS as f64;
    // The Riccati form, r = u'/u, r' = chi - r², cannot overflow.
    let slope = |x: f64, r: f64| chi(x) - r * r;
    let mut r = 1.0;
    for step in 0..STEPS {
        let x = -h + step as f64 * dx;
        let k1 = slope(x, r);
        let k2 = slope(x + 0.5 * dx, r + 0.5 * dx * k1);
        let k3 = slope(x + 0.5 * dx, r + 0.5 * dx * k2);
        let k4 = slope(x + dx, r + dx * k3);
        r += dx / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    h - 1.0 / r
}

/// How a beam meets the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(rename_all = "snake_case"))]
pub enum Surface {
    /// Markers along the beam drag the fluid. Whatever the beam's thickness, the line stands for a plate of 1.5 cells,
    /// in space for a rod with a radius of 0.87 (slow flow) to 1.18 cells (added mass), and the rod may have any mass,
    /// with one exchange per step.
    Line,
    /// The mask of the band around the beam, which wants four cells of thickness or more.
    #[default]
    Mask,
}

/// Spring and damper in parallel, in two dimensions per metre of depth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize, JsonSchema), serde(deny_unknown_fields))]
pub struct Support {
    /// Stiffness, N/m, about the pivot N m/rad.
    #[cfg_attr(feature = "scene", serde(default), schemars(range(min = 0.0)))]
    pub stiffness: f64,
    /// Damping, N s/m, about the pivot N m s/rad.
    #[cfg_attr(feature = "scene", serde(default), schemars(range(min = 0.0)))]
    pub damping: f64,
    /// Displacement, m, or angle, rad, at which the spring has no force. The body starts at 0.
    #[cfg_attr(feature = "scene", serde(default))]
    pub rest: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the displacement against half-width, both in eps, computed independently from the same equation.
    #[test]
    fn the_cosine_mask_is_displaced_as_published() {
        let table = [(1.0, -0.841), (2.0, -0.466), (3.0, 0.027), (5.0, 1.207), (10.0, 4.680), (20.0, 12.5)];
        for (h, expected) in table {
            let shift = cosine_wall_displacement(h);
            assert!((shift - expected).abs() < 6e-3_f64.max(4e-3 * h), "h = {h} eps: {shift} against {expected}");
        }
        assert!(cosine_wall_displacement(2.9490).abs() < 1e-3, "{}", cosine_wall_displacement(2.9490));
    }
}
