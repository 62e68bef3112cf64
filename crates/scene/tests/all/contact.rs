//! The key `contact`.

use nervure_scene::Scene;

/// A rod of 20 kg/m² in steps of 5 ms, with a contact.
fn scene(contact: &str) -> Result<Scene, String> {
    let text = include_str!("../../../../scenes/csm1.json");
    let text = text.replacen("\"name\"", &format!("\"contact\": {contact}, \"name\""), 1);
    Scene::from_json(&text).map_err(|error| error.to_string())
}

#[test]
fn contact_lasts_ten_steps_over_a_thickness_by_default() {
    let scene = scene("{}").unwrap();
    let (contact, own) = (scene.contact.as_ref().unwrap(), scene.beams_with_rods().next().unwrap());
    let density = own.rod.unwrap().material.section(&own.beam.thickness, 0.0).line_density;
    let half = std::f64::consts::PI * (density / contact.stiffness(&scene, &own)).sqrt();
    let step = own.rod.unwrap().max_step.unwrap_or(scene.time.communication_step);
    assert!((half / step - 10.0).abs() < 1e-12, "{half} s in steps of {step} s");
    assert_eq!(contact.range(&scene, &own), own.beam.thickness.at(0.0));
}

#[test]
fn obstacles_that_rods_cannot_touch_are_refused() {
    let obstacle = |own: &str| format!("{{\"obstacles\": [{{{own}}}]}}");
    for (own, sentence) in [
        (
            r#""shape": {"ellipse": {"length": 2, "thickness": 1}}, "position": [0, 9]"#,
            "what touches is a circle, rectangle",
        ),
        (r#""shape": {"sphere": {"radius": 1}}, "position": [0, 9]"#, "in two dimensions it is a circle"),
        (r#""shape": {"circle": {"radius": 1}}, "position": [0, 9, 0]"#, "it must have 2 components like the beam"),
        (r#""shape": {"circle": {"radius": 1}}, "position": [0, 9], "motion": "master""#, "still or moved by laws"),
    ] {
        let refused = scene(&obstacle(own)).unwrap_err();
        assert!(refused.contains(sentence), "{own}: {refused}");
    }
    assert!(scene(&obstacle(r#""shape": {"circle": {"radius": 1}}, "position": [0, 9]"#)).is_ok());
}
