//! All tests from outside in one program: each of its own would optimize what the crate is generic in once more.

mod c_interface;
mod fmi3;
#[path = "../integrator/mod.rs"]
mod integrator;
#[path = "../master/mod.rs"]
mod master;
