//! The rod of a scene, without its unit; the file has tests of its own.

#[path = "../src/from_scene.rs"]
mod from_scene;
