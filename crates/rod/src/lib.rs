//! Mass-spring elastic rod in two or three dimensions, clamped at its root, or pinned, on a torsion spring, or free.
//!
//! ```text
//! m_k x_k'' = f_k − c l_k x_k' − ∂U/∂x_k,      k = 1 … n, and k = 0 where the root is free
//! ```
//!
//! Nodes run from the clamped root, 0, to the tip, n. Each carries the mass of the half segments beside it and half
//! of their length l_k, so the tip has half of an inner node's; the section may change along the rod. U is the energy of extension and bending of
//! `elastic`, f the gravity and the [`Loads`]; `scheme` has the time schemes and `newton` the solver. All quantities
//! are in SI units; in two dimensions mass, force and energy are per metre of depth.

mod banded;
mod elastic;
mod error;
mod hinge;
mod newton;
mod parameters;
mod rod;
mod root;
mod scheme;
mod sensitivity;
mod shear;
mod state;

pub use crate::banded::{Banded, Singular};
pub use crate::error::Error;
pub use crate::hinge::HingeState;
pub use crate::newton::Statistics;
pub use crate::parameters::{Hold, Loads, Parameters, Taper};
pub use crate::rod::{Energy, Rod};
pub use crate::root::Root;
pub use crate::sensitivity::Sensitivity;
pub use crate::state::{Drive, Exchange, State};
