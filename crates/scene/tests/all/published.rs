//! What the crate publishes: the schema, and facts of scenes.

use nervure_scene::{Scene, facts_text};

fn shipped(name: &str) -> String {
    let path = format!("{}/../../scenes/{name}.json", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn committed_schema_is_that_of_the_types() {
    let path = format!("{}/../../modelDescription/scene.schema.json", env!("CARGO_MANIFEST_DIR"));
    let committed = std::fs::read_to_string(path).unwrap();
    assert!(committed == Scene::json_schema(), "`make schema` writes it anew");
}

#[test]
fn numbers_of_fsi3_are_those_of_turek_and_hron() {
    let facts = Scene::from_json(&shipped("fsi3-325x72")).unwrap().facts();
    let numbers = facts.dimensionless.unwrap();
    let close = |found: Option<f64>, expected: f64| (found.unwrap() / expected - 1.0).abs() < 1e-12;
    assert!(
        close(numbers.velocity, 2.0) && close(numbers.length, 0.1) && close(numbers.reynolds, 200.0),
        "{numbers:?}"
    );
    // EI = E h³ / (12 (1 − ν²)) with E = 5.6 MPa, ν = 0.4, h = 0.02 m; L = 0.35 m.
    let stiffness = 5.6e6 * 0.02f64.powi(3) / 12.0 / 0.84;
    assert!(close(facts.beams[0].bending_stiffness.as_ref().map(|all| all[0]), stiffness), "{:?}", facts.beams[0]);
    assert!(close(numbers.stiffness, stiffness / (1e3 * 4.0 * 0.35f64.powi(3))), "{numbers:?}");
    assert!(close(numbers.density_ratio, 1.0) && close(numbers.mass_ratio, 0.02 / 0.35), "{numbers:?}");
    assert_eq!(facts.laws["fluid.inflow.mean_velocity"].settles, Some((2.0, 2.0)));
}

#[test]
fn values_along_a_tapered_beam_are_at_its_stations() {
    let scene = Scene::from_json(&shipped("vein-hover-tapered-288x256")).unwrap();
    let beam = scene.beam.as_ref().unwrap();
    let thickness = &scene.facts().beams[0].thickness;
    assert_eq!(thickness.len(), beam.segments + 1);
    assert_eq!((thickness[0], thickness[beam.segments]), (beam.thickness.at(0.0), beam.thickness.at(1.0)));
    assert!(thickness.windows(2).all(|pair| pair[0] > pair[1]));
}

#[test]
fn a_scene_with_faults_has_no_facts() {
    assert_eq!(facts_text("{}"), "null");
    assert!(facts_text(&shipped("csm1")).contains("\"dimensionless\":null"));
}
