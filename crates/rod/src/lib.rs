//! Elastic rod as a chain of masses and springs, in two or three dimensions.
//!
//! ```text
//! m_k x_k'' = f_k − c l_k x_k' − ∂U/∂x_k,      k = 1 … n, and k = 0 with a free root
//! ```
//!
//! Nodes are numbered from the root, 0, to the tip, n. A node carries the mass m_k and the length l_k of the half
//! segments beside it, so the tip of a uniform rod has half the mass of an inner node. The section may vary along the
//! rod. U is the energy of extension, bending and shear (`elastic`), f the sum of gravity and [`Loads`], and c the
//! damping. [`structure`] has the time schemes and `newton` the solver. All quantities are in SI units; in two
//! dimensions mass, force and energy are per metre of depth.

#![forbid(unsafe_code)]

mod banded;
mod base_motion;
mod contact;
mod discretization;
mod elastic;
mod error;
mod hinge;
mod memory;
mod model;
mod newton;
mod parameters;
mod rod;
mod shear;
mod statics;
mod step;
mod vertex;

pub use ::contact::{Film, Law, Obstacle, Pose, largest_stiffness};
pub use structure::{Drive, Exchange, Loads, RootResponse, Scheme, Statistics};

pub use crate::banded::{Banded, Singular};
pub use crate::base_motion::BaseMotion;
pub use crate::contact::Contact;
pub use crate::error::{BadShape, Error, RodError};
pub use crate::memory::{RodMemory, RodState};
pub use crate::model::{Bending, Calibration, RootSupport, Section, Slide, Taper};
pub use crate::parameters::Parameters;
pub use crate::rod::{Energy, Rod};
pub use crate::vertex::{CosineSlope, Edge, VertexDerivatives};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
