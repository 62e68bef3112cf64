//! How a solid holds the fluid: the drag profile, and the wall target that corrects it at the surface.

mod growth;
mod profile;
mod target;

pub use profile::DragProfile;
pub use target::{Sample, WallTarget};
