//! Numerical methods of fluid and rod as data, which scene files name and the solvers use.
#![forbid(unsafe_code)]

mod fluid;
mod rod;

pub use fluid::{Filter, Mask, Precision, Support, Surface, TAIL, TimeScheme, WallCorrection, marker_reach};
pub use rod::{Axis, Bending, Calibration, Scheme, Section, Slide};
