//! Numerical methods of fluid and rod as data, which scene files name and the solvers use.
#![forbid(unsafe_code)]

mod fluid;
mod rod;

pub use fluid::{
    Filter, LINE_THICKNESS_CELLS, Mask, Precision, ROD_RADIUS_CELLS, ROD_SECTION_CELLS, SURFACE_THICKNESS_CELLS,
    Support, Surface, TAIL, TimeScheme, WallCorrection, marker_reach,
};
pub use rod::{Axis, Bending, Calibration, Scheme, Section, Slide};
