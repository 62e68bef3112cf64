//! The calls of a master, good and bad, on the rod of a scene file: `rod SCENE.json`.

use fmu_rod as _;

#[path = "../calls.rs"]
mod calls;

fn main() {
    let scene = std::env::args().nth(1).expect("usage: rod SCENE.json");
    calls::run(&std::fs::read(scene).expect("the scene can be read"));
}
