//! All tests from outside in one program: each of its own would optimize what the crate is generic in once more.

mod contact;
mod load;
mod published;
mod refused;
mod several_rods;
