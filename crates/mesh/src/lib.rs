//! Triangulated surfaces with named chains of nodes.
#![forbid(unsafe_code)]

mod generate;
mod surface;

pub use generate::{ellipse, insect_wing, rectangle};
pub use surface::{Chain, Mesh, area, triangle_area};
