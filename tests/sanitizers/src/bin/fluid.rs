//! The calls of a master, good and bad, on the fluid of a scene file: `fluid SCENE.json`.

use fmu_fluid as _;

#[path = "../calls.rs"]
mod calls;

fn main() {
    let scene = std::env::args().nth(1).expect("usage: fluid SCENE.json");
    calls::run(&std::fs::read(scene).expect("the scene can be read"));
}
