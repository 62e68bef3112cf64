//! Rods in a flow as one program, for the page in `page/`: fluid and rods of a scene are made by the crates of the
//! units and coupled without FMI. Built for a browser it is WebAssembly with the C interface of `interface`.

mod coupled;
#[path = "../../fmu-rod/src/from_scene.rs"] // the FMU exports a C interface, so nothing can depend on it
mod from_scene;
mod interface;
pub mod paint;

pub use coupled::{Coupled, Pull};
