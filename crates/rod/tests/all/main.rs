//! All tests from outside in one program: each of its own would optimize what the crate is generic in once more.

mod allocations;
mod carried;
#[path = "../common/mod.rs"]
mod common;
mod contact;
mod dynamics;
mod errors;
mod flight;
#[path = "../common/modes.rs"]
mod modes;
mod root_motion;
mod roots;
mod shear;
mod statics;
mod stations;
mod taper;
mod thrown;
