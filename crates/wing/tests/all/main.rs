//! All tests from outside in one program: each of its own would optimize what the crate is generic in once more.

mod contact;
mod dynamics;
mod flight;
mod frames;
mod meshes;
mod plates;
mod root;
mod section;
mod thrown;
mod twists;
mod veins;
