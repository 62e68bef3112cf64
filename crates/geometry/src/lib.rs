//! Shapes in two and three dimensions: signed distance, normal, bounding box, and where they touch.
//!
//! [`plane::Outline`] and [`space::Solid`] are closed shapes in their own axes. In the box of a scene a [`Shape`] is
//! one of them, a [`Chain`] of capsules or a [`Surface`] of triangles; what lies in the plane has z = 0 there.
#![forbid(unsafe_code)]

mod bounds;
mod chain;
mod crossings;
mod placed;
pub mod plane;
mod polygon;
mod region;
mod segment;
mod shape;
pub mod space;
mod surface;
mod triangle;
pub mod vector;

pub use bounds::{AXES, Bounds, beyond, near_pairs};
pub use chain::Chain;
pub use crossings::Crossings;
pub use placed::Placed;
pub use region::{Nearest, Region, Section};
pub use segment::{crosses, distance, lies_on, meets, sides};
pub use shape::{Shape, Touch};
pub use surface::Surface;
