//! Triangulated surfaces with named chains of nodes.
#![forbid(unsafe_code)]

mod check;
mod generate;
mod layer;
mod surface;

pub use check::{Bend, Flaw, MeshEdge};
pub use generate::{ellipse, insect_wing, rectangle};
pub use layer::Layer;
pub use surface::{Chain, Mesh, area, triangle_area};
