//! Elastic rod as a chain of masses and springs, in two or three dimensions.
//!
//! ```text
//! m_k x_k'' = f_k − c l_k x_k' − ∂U/∂x_k,      k = 1 … n, and k = 0 with a free root
//! ```
//!
//! Nodes are numbered from the root, 0, to the tip, n. A node carries the mass m_k and the length l_k of the half
//! segments beside it, so the tip of a uniform rod has half the mass of an inner node. The section may vary along the
//! rod. U is the energy of extension, bending and shear (`elastic`), f the sum of gravity and [`Loads`], and c the
//! damping. `scheme` describes the time schemes and `newton` the solver. All quantities are in SI units; in two
//! dimensions mass, force and energy are per metre of depth.

#![forbid(unsafe_code)]

mod banded;
mod base_motion;
mod discretization;
mod elastic;
mod error;
mod hinge;
mod loads;
mod model;
mod newton;
mod parameters;
mod rod;
mod scheme;
mod shear;
mod state;
mod statics;
mod step;
mod vector;
mod vertex;

pub use crate::banded::{Banded, Singular};
pub use crate::base_motion::BaseMotion;
pub use crate::error::Error;
pub use crate::loads::Loads;
pub use crate::model::{Bending, Calibration, RootSupport, Scheme, Section, Slide, Taper};
pub use crate::newton::Statistics;
pub use crate::parameters::Parameters;
pub use crate::rod::{Energy, Rod};
pub use crate::scheme::{Motion, StepRule, TRAPEZOID_PART};
pub use crate::state::{Drive, Exchange, HingeState, State};
pub use crate::vertex::{CosineSlope, Edge, VertexDerivatives};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
