//! The fluid in three dimensions.
//!
//! It solves the equations of the crate in a periodic box of three axes, by the same scheme, filter and wall as in two
//! dimensions.

mod bodies;
mod flow;
mod fluid;
mod force;
mod parameters;
mod problem;
mod projection;
mod rigid;
mod shape;
mod solver;
mod spectral;
mod step;
mod thin;

pub use fluid::{Fluid, State};
pub use force::Force;
pub use parameters::{Body, Extent, Flexible, Motion, Parameters, Shape, Turn};
pub use rigid::Pose;
