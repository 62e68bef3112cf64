//! Prints the JSON Schema of scene files.

fn main() {
    print!("{}", scene::Scene::json_schema());
}
