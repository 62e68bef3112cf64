//! Several rods in one fluid.

use nervure_scene::{Load, Scene};

/// FSI3 with two rods in place of one, with some of its text replaced.
fn two(replaced: &[(&str, &str)]) -> Result<Scene, String> {
    let text = include_str!("../../../../scenes/fsi3-325x72.json");
    let mut scene: serde_json::Value = serde_json::from_str(text).unwrap();
    let parts = scene.as_object_mut().unwrap();
    let (beam, rod) = (parts.remove("beam").unwrap(), parts.remove("rod").unwrap());
    parts.remove("coupling");
    parts.remove("reference");
    let mut list = Vec::new();
    for (name, angle) in [("front", 0.0), ("back", 3.0)] {
        let mut beam = beam.clone();
        beam["length"] = 0.1.into();
        beam["root"] = serde_json::json!({ "on_cylinder": { "cylinder": 0, "angle": angle } });
        list.push(serde_json::json!({ "name": name, "beam": beam, "rod": rod }));
    }
    parts.insert("rods".into(), list.into());
    let mut text = scene.to_string();
    for (old, new) in replaced {
        assert!(text.contains(old), "{old} is not in {text}");
        text = text.replacen(old, new, 1);
    }
    Scene::from_json(&text).map_err(|error| error.to_string())
}

#[test]
fn momentum_is_chosen_where_every_rod_may_take_it() {
    let (load, reason) = two(&[]).unwrap().chosen_load().unwrap();
    assert_eq!(load, Load::Momentum, "{reason}");
    // The keys of an object are sorted: the first density is the one of `front`.
    let lighter = two(&[(r#""plane_strain":{"density":1000.0"#, r#""plane_strain":{"density":900.0"#)]).unwrap();
    let (load, reason) = lighter.chosen_load().unwrap();
    assert_eq!(load, Load::PressureJump);
    assert!(reason.contains("the rod `front` weighs 0.9000"), "{reason}");
    // The unit of the other rod has the same load.
    let back = Scene { this_rod: Some("back".into()), ..lighter }.of_unit().unwrap();
    assert_eq!(back.load(), Some(Load::PressureJump));
    let (beam, rod) = (back.beam.as_ref().unwrap(), back.rod.as_ref().unwrap());
    assert_eq!(back.displaced_line_density(beam, rod)[0], 0.0);
}

#[test]
fn unit_sees_one_rod() {
    let scene = two(&[]).unwrap();
    assert!(scene.of_unit().is_none(), "which one?");
    for (i, name) in ["front", "back"].into_iter().enumerate() {
        let own = Scene { this_rod: Some(name.into()), ..scene.clone() }.of_unit().unwrap();
        assert_eq!(own.beam.as_ref(), Some(&scene.rods[i].beam));
        assert_eq!(own.name, format!("fsi3-325x72.{name}"));
        let (beam, rod) = (own.beam.as_ref().unwrap(), own.rod.as_ref().unwrap());
        assert_eq!(own.displaced_line_density(beam, rod)[0], 20.0);
        own.check().unwrap();
    }
}

#[test]
fn lists_that_make_no_sense_are_refused_by_key() {
    for (replaced, expected) in [
        ((r#""name":"back""#, r#""name":"Front""#), "`rods[1].name` is \"Front\", but another rod has this name"),
        (
            (r#""name":"back""#, r#""name":"fluid""#),
            "`rods[1].name` is \"fluid\", but `rod`, `wing`, `body`, `fluid` and `contact` are the",
        ),
        ((r#""name":"back""#, r#""name":"b-1""#), "`rods[1].name` is \"b-1\", but a name is a letter, then"),
        ((r#""angle":3.0"#, r#""angle":0.0"#), "`rods[1].beam.root` puts the beam onto the beam of `front`"),
        ((r#""cylinder":0"#, r#""cylinder":1"#), "`rods[0].beam.root.on_cylinder.cylinder` is 1, but"),
        (
            (r#""rods":"#, r#""this_rod":"side","rods":"#),
            "`this_rod` is \"side\", but the names in `rods` are `front` and `back`",
        ),
    ] {
        let refused = two(&[replaced]).map(|_| ()).unwrap_err();
        assert!(refused.contains(expected), "{refused}, but expected {expected}");
    }
    let both = |key: &str, value: &str| two(&[(r#""rods":"#, &format!(r#""{key}":{value},"rods":"#))]).unwrap_err();
    let beam = r#"{"root":{"on_cylinder":{"cylinder":0}},"length":0.1,"thickness":0.02,"segments":4}"#;
    assert!(both("beam", beam).contains("`beam` is not allowed here: the scene has `rods`"), "{}", both("beam", beam));
    let mut one = two(&[]).unwrap();
    let back = one.rods.pop().unwrap();
    assert!(
        one.check().unwrap_err().to_string().contains("`rods` is a list of one, but several rods are at least two")
    );
    one.rods.push(back);
    one.fluid = None;
    assert!(
        one.check().unwrap_err().to_string().contains("`fluid` is missing: several rods need a fluid or a `contact`")
    );
}
