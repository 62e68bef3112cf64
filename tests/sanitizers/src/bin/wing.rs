//! The calls of a master, good and bad, on the wing of a scene file: `wing SCENE.json`.

use fmu_wing as _;

#[path = "../calls.rs"]
mod calls;

fn main() {
    let scene = std::env::args().nth(1).expect("usage: wing SCENE.json");
    calls::run(&std::fs::read(scene).expect("the scene can be read"));
}
