//! Rods in a flow of a plane, or wings in a flow of space, as one program for the page in `page/`: the parts of a
//! scene are made by the crates of the units and coupled without FMI. Built for a browser it is WebAssembly with the C
//! interface of `interface`.

mod coupled;
mod interface;
pub mod paint;
pub mod project;
mod rod_in_flow;
mod wing_in_flow;

pub use coupled::Coupled;
pub use rod_in_flow::{Pull, RodsInFlow};
pub use wing_in_flow::WingsInFlow;
