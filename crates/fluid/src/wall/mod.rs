//! The drag of a solid: the profile across its surface, and the wall target that corrects the velocity there.

mod calibration;
mod growth;
mod profile;
mod target;

pub use profile::DragProfile;
pub use target::{Sample, WallTarget};
