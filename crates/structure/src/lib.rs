//! Structure of nodes, in two or three dimensions: what elastic rods and wings share.
//!
//! ```text
//! M x'' = f − c x' − F(x, x'),      f = gravity + loads
//! ```
//!
//! A [`Structure`] adds the elastic forces F, the masses M, its supports and a solver for one stage of a time scheme.
//! This crate has the rest: nodes with their [`State`] ([`Core`]), [`Loads`], time schemes ([`StepRule`]), sub-steps
//! ([`step`]), the growth of loads towards an equilibrium ([`find_equilibrium`]), and [`Error`]. All quantities are in
//! SI units; in two dimensions mass, force and energy are per metre of depth.

#![forbid(unsafe_code)]

mod check;
mod core;
mod cubic;
mod error;
mod loads;
mod newton;
mod root;
mod scheme;
mod state;
mod statics;
mod step;
mod vector;

pub use crate::check::{check_law, finite, not_negative, positive};
pub use crate::core::{Core, first_weight};
pub use crate::cubic::cubic;
pub use crate::error::{Error, Shown};
pub use crate::loads::Loads;
pub use crate::newton::{Balance, Imbalance, RELATIVE_UPDATE, Residual, Statistics};
pub use crate::root::{Mounted, root_response};
pub use crate::scheme::{Motion, StepRule, TRAPEZOID_PART, check_scheme};
pub use crate::state::{Drive, Exchange, State};
pub use crate::statics::find_equilibrium;
pub use crate::step::{Reaction, Span, Structure, step};
pub use crate::vector::{Matrix, Vector, cross};
pub use method::Scheme;
pub use rigid::RootResponse;
