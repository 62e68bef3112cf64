//! Scenes that cannot be run: each fault has its kind, its key, its place and its sentence.

use nervure_scene::FaultKind::{Conflict, Duplicate, Format, Missing, Range, Syntax, Type, Unknown};
use nervure_scene::{Fault, Scene, SceneError, check_text};

const CSM1: &str = include_str!("../../../../scenes/csm1.json");
const FSI3: &str = include_str!("../../../../scenes/fsi3-325x72.json");

/// Return `text` with each old piece replaced by a new one.
fn replaced(text: &str, pieces: &[(&str, &str)]) -> String {
    pieces.iter().fold(text.to_string(), |text, (old, new)| {
        assert!(text.contains(old), "{old} is not in the scene");
        text.replace(old, new)
    })
}

/// Return the faults of a text, none if it is a scene that can be run.
fn faults(text: &str) -> Vec<Fault> {
    match Scene::from_json(text) {
        Ok(_) => Vec::new(),
        Err(SceneError::Faults(faults)) => faults,
        Err(error) => panic!("{error}"),
    }
}

/// Return the sentences of the faults of a text, joined by line breaks.
fn sentences(text: &str) -> String {
    faults(text).iter().map(|fault| fault.text.as_str()).collect::<Vec<_>>().join("\n")
}

#[test]
fn every_kind_of_fault_has_its_own_sentence() {
    let end = r#""end": 4.0"#;
    for (old, new, kind, key, sentence) in [
        (end, r#""end": 0.0"#, Range, "time.end", "`time.end` is out of range: 0.0 is not > 0"),
        (end, r#""end": "late""#, Type, "time.end", "`time.end` must be a number > 0, not \"late\""),
        (end, r#""end": NaN"#, Type, "time.end", "`time.end` must be a number > 0, not NaN"),
        (end, r#""end": 1e999"#, Type, "time.end", "`time.end` must be a number > 0, not 1e999"),
        (r#"{ "end": 4.0, "#, "{ ", Missing, "time.end", "missing required key `time.end` (a number > 0)"),
        (
            r#""description""#,
            r#""descripton""#,
            Unknown,
            "descripton",
            "unknown key `descripton`: did you mean `description`?",
        ),
        (r#""name": "csm1""#, r#""name": "a b""#, Conflict, "name", "`name` is \"a b\", but a name has 1 to 100"),
        (end, r#""end": 4.0, "end": 5.0"#, Duplicate, "time.end", "duplicate key `time.end`: line 6 has it already"),
        (
            r#""format": 2"#,
            r#""format": 3"#,
            Format,
            "format",
            "but this version reads format 2: install a newer nervure",
        ),
        (end, r#""end": 4.0,"#, Syntax, "", "not JSON: there is a comma before `}`"),
        (end, r#""end": 4.0 // s"#, Syntax, "", "not JSON: comments are not allowed"),
        (
            r#""segments": 64"#,
            r#""segments": 1"#,
            Range,
            "beam.segments",
            "`beam.segments` is out of range: 1 is not from 2 to 65536",
        ),
        (
            r#""segments": 64"#,
            r#""segments": 64.5"#,
            Type,
            "beam.segments",
            "`beam.segments` must be a whole number from 2 to 65536, not 64.5",
        ),
    ] {
        let new = if new.ends_with(",") || new.contains("//") { format!("{new}\n}},") } else { new.into() };
        let found = faults(&replaced(CSM1, &[(old, &new)]));
        let [fault] = found.as_slice() else { panic!("{new}: {found:?}") };
        assert_eq!((fault.kind, fault.key.as_str()), (kind, key), "{fault:?}");
        assert!(fault.text.contains(sentence), "{fault:?}");
        assert!(fault.line.is_some() && fault.column.is_some(), "{fault:?}");
    }
}

#[test]
fn all_keys_types_and_ranges_are_checked_in_one_pass() {
    let text = r#"{
  "name": 7,
  "time": { "end": -1 },
  "fluit": {},
  "coupling": { "load": "momntum" }
}"#;
    let found = faults(text);
    let data: Vec<_> = found.iter().map(|fault| (fault.kind, fault.key.as_str(), fault.line, fault.column)).collect();
    assert_eq!(
        data,
        [
            (Type, "name", Some(2), Some(3)),
            (Missing, "time.communication_step", Some(3), Some(3)),
            (Range, "time.end", Some(3), Some(13)),
            (Unknown, "fluit", Some(4), Some(3)),
            (Type, "coupling.load", Some(5), Some(17)),
        ]
    );
    assert!(found[4].text.ends_with("; did you mean \"momentum\"?"), "{:?}", found[4]);
    let range = &found[2];
    assert_eq!((range.value.as_deref(), range.allowed.as_deref()), (Some("-1"), Some("> 0")));
}

#[test]
fn independent_contradictions_are_listed_together() {
    let text = replaced(
        CSM1,
        &[(r#""gravity": [0.0, -2.0]"#, r#""gravity": [0, 0, 0]"#), (r#""name": "csm1""#, r#""name": "-""#)],
    );
    let keys: Vec<_> = faults(&text).into_iter().map(|fault| (fault.kind, fault.key)).collect();
    assert_eq!(keys, [(Conflict, "name".into()), (Conflict, "rod.gravity".into())]);
}

#[test]
fn a_list_of_faults_is_bounded() {
    let angles = vec!["false"; 5000].join(", ");
    let text = replaced(CSM1, &[(r#""segments": 64"#, &format!(r#""segments": 64, "rest_angles": [{angles}]"#))]);
    assert_eq!(faults(&text).len(), 20);
}

#[test]
fn a_file_of_the_earlier_format_gets_the_list_of_renamed_keys() {
    let ramp = r#""cosine_ramp": { "value": 2.0, "duration": 2.0 }"#;
    let text = replaced(FSI3, &[(r#""format": 2"#, r#""format": 1"#), (ramp, r#""steady": 2.0"#)]);
    let found = faults(&text);
    let keys: Vec<_> = found.iter().map(|fault| (fault.kind, fault.key.as_str())).collect();
    assert_eq!(keys, [(Format, "format"), (Unknown, "fluid.inflow.mean_velocity.steady")]);
    assert!(found[0].text.contains("rename `e_fold` to `decay_length_cells`"), "{}", found[0].text);
    assert!(found[1].text.ends_with("it is called `constant` since format 2"), "{}", found[1].text);
}

#[test]
fn the_text_is_bounded_in_length_and_depth() {
    let long = format!("{{\"name\": \"{}\"}}", "x".repeat(4 << 20));
    assert_eq!(sentences(&long), "the scene has 4.0 MB, but at most 4 MB are allowed");
    let deep = faults(&"[".repeat(1000));
    assert_eq!((deep[0].kind, deep[0].line, deep[0].column), (Syntax, Some(1), Some(65)));
    assert_eq!(deep[0].text, "lists and objects are nested more than 64 deep");
}

#[test]
fn text_that_is_not_json_has_a_place() {
    for (text, line, column, sentence) in [
        ("", 1, 1, "not JSON: the text ends where a value is expected"),
        ("[]", 1, 1, "a scene is an object in braces, not []"),
        ("{\n  \"a\": 1\n  \"b\": 2 }", 3, 3, "not JSON: `,` or `}` is expected"),
        ("{ \"a\": 'x' }", 1, 8, "not JSON: texts stand in double quotes"),
        ("{ \"ä\": tru }", 1, 8, "not JSON: `tru` is not a value"),
        ("{ \"a\": \"x }", 1, 8, "not JSON: a text has no closing quote"),
        ("{ \"a\": \"\\x\" }", 1, 8, "not JSON: a text holds an unescaped control character or an invalid escape"),
        ("{ \"a\": 01 }", 1, 8, "not JSON: `01` is not a value"),
        ("{ a: 1 }", 1, 3, "not JSON: a key in double quotes is expected"),
        ("{} {}", 1, 4, "not JSON: nothing may follow the end of the scene"),
    ] {
        let found = faults(text);
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        let fault = &found[0];
        assert_eq!((fault.line, fault.column, fault.text.as_str()), (Some(line), Some(column), sentence), "{text}");
    }
}

#[test]
fn a_changed_value_has_no_place_in_the_original() {
    let list = |text: &str| -> serde_json::Value { serde_json::from_str(&check_text(text, Some(CSM1))).unwrap() };
    let changed = list(&replaced(CSM1, &[(r#""length": 0.35"#, r#""length": -1"#)]));
    assert_eq!((&changed[0]["key"], &changed[0]["line"]), (&"beam.length".into(), &serde_json::Value::Null));
    assert_eq!(check_text(CSM1, Some("not JSON")), "[]");
    let original = replaced(CSM1, &[(r#""length": 0.35"#, r#""length": -1"#)]);
    let other = replaced(&original, &[(r#""end": 4.0"#, r#""end": 5.0"#)]);
    let kept: serde_json::Value = serde_json::from_str(&check_text(&other, Some(&original))).unwrap();
    assert!(kept[0]["line"].is_u64(), "{kept}");
    let missing = replaced(CSM1, &[(r#"{ "end": 4.0, "#, "{ ")]);
    let kept: serde_json::Value = serde_json::from_str(&check_text(&missing, Some(&missing))).unwrap();
    assert!(kept[0]["line"].is_u64(), "{kept}");
    assert_eq!(list(&missing)[0]["line"], serde_json::Value::Null);
}

#[test]
fn every_shipped_scene_can_be_run_and_stays_valid() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let scene = Scene::from_file(&entry.unwrap().path()).unwrap();
        scene.check().unwrap();
        count += 1;
    }
    assert!(count > 30, "{count}");
}

#[test]
fn reference_needs_source_and_units() {
    let unit = r#""tip_ux": { "unit": "m","#;
    for (old, new, expected) in [
        ("Turek & Hron 2006, CSM1", " ", "`reference.source` is \" \", but it must not be empty"),
        (unit, r#""tip_ux": {"#, "missing required key `reference.quantities.tip_ux.unit` (a text in quotes)"),
        (unit, r#""tip_ux": { "unit": "","#, "`reference.quantities.tip_ux.unit` is \"\", but it must not be empty"),
        (
            unit,
            r#""tip_ux": { "unit": "m", "frequency_hz": 0.0,"#,
            "`reference.quantities.tip_ux.frequency_hz` is out of range: 0.0 is not > 0",
        ),
        (unit, r#""tip_ux": { "unit": "m", "frequency_hz": null,"#, ""),
        (
            unit,
            r#""tip_ux": { "unit": "mm","#,
            "`reference.quantities.tip_ux.unit` is \"mm\", but a run evaluates tip_ux in m: convert the values",
        ),
        (
            unit,
            r#""tip_uw": { "unit": "m","#,
            "`reference.quantities.tip_uw` is not allowed here: a run evaluates `tip_ux`, `tip_uy`, `tip_uz`, `drag` \
             and `lift`",
        ),
    ] {
        assert_eq!(sentences(&replaced(CSM1, &[(old, new)])), expected);
    }
    let spread = |range: &str| {
        let quantities = format!(r#"{{ "tip_ux": {{ "unit": "m", "mean": {range} }} }}"#);
        let spread = format!(r#""spread": {{ "source": "x", "quantities": {quantities} }}, "quantities""#);
        sentences(&replaced(CSM1, &[(r#""quantities""#, &spread)]))
    };
    assert_eq!(spread("[-2.0, -1.0]"), "");
    let expected = "`reference.spread.quantities.tip_ux.mean` is [-1, -2], but the first number must be the smaller";
    assert_eq!(spread("[-1.0, -2.0]"), expected);
}

/// The sentences about a body in a box of 1 m around the origin.
fn of_body(body: &str) -> String {
    sentences(&format!(
        r#"{{ "name": "test", "time": {{ "end": 1.0, "communication_step": 0.01 }}, "fluid": {{ "density": 1.0,
            "kinematic_viscosity": 0.01, "box": {{ "x": [-0.5, 0.5], "y": [-0.5, 0.5], "cells": [32, 32] }},
            "mask": {{ "log_linear": {{ "c_eta": 1e-4 }} }},
            "time_stepping": {{ "max_step": 0.01, "max_cfl": 0.4 }}, "bodies": [{body}] }} }}"#
    ))
}

#[test]
fn bodies_that_cannot_be_are_refused_with_key_and_value() {
    let at = r#""position": [0, 0]"#;
    let polygon = |corners: &str| format!(r#"{{ "shape": {{ "polygon": {{ "corners": {corners} }} }}, {at} }}"#);
    let rectangle = |shape: &str| format!(r#"{{ "shape": {{ "rectangle": {{ "length": 0.1, {shape} }} }}, {at} }}"#);
    let line = |points: &str| format!(r#"{{ "shape": {{ "polyline": {{ "points": {points} }} }}, {at} }}"#);
    let shapes = "`fluid.bodies[0].shape";
    let accepted = [
        polygon("[[0, 0], [0.1, 0], [0, 0.1]]"),
        polygon("[[0, 0], [0, 0.1], [0.1, 0]]"),
        rectangle(r#""thickness": 0.2"#),
        line("[[0, 0], [0.1, 0]]"),
        line("[[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]]"),
    ];
    for body in accepted {
        assert_eq!(of_body(&body), "", "{body}");
    }
    let cases = [
        (
            polygon("[[0, 0], [0.1, 0]]"),
            format!("{shapes}.polygon.corners` must be a list of 3 to 1000 lists, not a list of 2"),
        ),
        (
            polygon("[[0, 0], [0.1, 0], [0.1, 0], [0, 0.1]]"),
            format!("{shapes}.polygon.corners[1]` is [0.1, 0.0], but the next corner is the same"),
        ),
        (
            polygon("[[0, 0], [0.1, 0.1], [0.1, 0], [0, 0.1]]"),
            format!("{shapes}.polygon.corners[0]` is [0.0, 0.0], but the side that begins there meets"),
        ),
        (
            line("[[0, 0], [0.1, 0], [0.1, 0.1], [0.05, -0.1]]"),
            format!("{shapes}.polyline.points[0]` is [0.0, 0.0], but the side that begins there meets"),
        ),
        (
            line("[[0, 0], [0, 0]]"),
            format!("{shapes}.polyline.points[0]` is [0.0, 0.0], but the next corner is the same"),
        ),
        (polygon("[[0, 0], [0.2, 0], [0.1, 0]]"), format!("{shapes}.polygon.corners[0]` is")),
        (
            rectangle(r#""thickness": 0.2, "ends": "round""#),
            format!("{shapes}.rectangle.thickness` is 0.2, but with round ends it must be at most the length, 0.1"),
        ),
        (rectangle(r#""thickness": 0.0"#), format!("{shapes}.rectangle.thickness` is out of range: 0.0")),
        (rectangle(r#""thickness": 0.1, "ends": "pointed""#), format!("{shapes}.rectangle.ends` must be")),
        (
            format!(r#"{{ "shape": {{ "ellipse": {{ "length": 0.1, "thickness": -0.1 }} }}, {at} }}"#),
            format!("{shapes}.ellipse.thickness` is out of range: -0.1"),
        ),
        (
            r#"{ "shape": { "circle": { "radius": 0.1 } }, "position": [0, 0.6] }"#.into(),
            "`fluid.bodies[0].position[1]` is 0.6, but it must lie inside the box".into(),
        ),
        (
            format!(
                r#"{{ "shape": {{ "circle": {{ "radius": 0.1 }} }}, {at},
                    "motion": {{ "angle": {{ "table": {{ "times": [1, 0], "values": [0, 1] }} }} }} }}"#
            ),
            "`fluid.bodies[0].motion.angle.table.times` is [1.0, 0.0], but times must increase".into(),
        ),
    ];
    for (body, expected) in cases {
        let found = of_body(&body);
        assert!(found.contains(&expected), "{body}: {found}, but expected {expected}");
    }
}
