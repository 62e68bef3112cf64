//! The fluid in three dimensions.
//!
//! It solves the equations of the crate in a periodic box of three axes, by the same scheme, filter and wall as in two
//! dimensions.

mod flow;
mod fluid;
mod parameters;
mod problem;
mod projection;
mod solver;
mod spectral;
mod step;

pub use fluid::{Fluid, State};
pub use parameters::Parameters;
