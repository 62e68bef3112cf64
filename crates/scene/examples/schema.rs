//! Prints the JSON Schema of scene files.

fn main() {
    print!("{}", nervure_scene::Scene::json_schema());
}
