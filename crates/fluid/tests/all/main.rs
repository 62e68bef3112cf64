//! All tests from outside in one program: each of its own would optimize what the crate is generic in once more.

mod asymmetric;
mod beam;
mod beams;
mod carried;
#[path = "../common/cases.rs"]
mod cases;
#[path = "../common/mod.rs"]
mod common;
mod contact;
mod exact;
mod features;
mod lines;
#[path = "../common/measures.rs"]
mod measures;
mod robust;
mod single;
mod space;
mod space_bodies;
mod space_surfaces;
mod space_thin;
mod two_grids;
mod undo;
