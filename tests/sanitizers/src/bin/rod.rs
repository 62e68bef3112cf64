//! The calls of a master, good and bad, on the rod of a scene file: `rod SCENE.json`.

#[path = "../calls.rs"]
mod calls;
#[path = "../../../../fmu-rod/src/lib.rs"]
mod unit;

fn main() {
    let scene = std::env::args().nth(1).expect("usage: rod SCENE.json");
    calls::run(&std::fs::read(scene).expect("the scene can be read"));
}
