//! The program has the digits of the units that the Python tool couples, and continues a flow with another scene.

use lab::{Pull, RodsInFlow, WingsInFlow};
use serde_json::{Value, json};

const RECORDED: &str = include_str!("../../tests/simulation/recorded.json");
const FSI3: &str = include_str!("../../scenes/fsi3-325x72.json");
const RECORDED_WING: &str = include_str!("wing.json");
const WING: &str = include_str!("../../scenes/wing-hover-64x64x84.json");

/// Digits of `series.csv` are ten; the rest is the rounding of other processors.
const TOLERANCE: f64 = 1e-9;

#[test]
fn fsi3_has_the_digits_of_the_coupled_units() {
    let recorded: Value = serde_json::from_str(RECORDED).expect("JSON");
    let early = |name: &str| recorded["early"][name][0].as_f64().expect("a number");
    let mut run = RodsInFlow::new(FSI3).expect("a scene that runs");
    for _ in 0..250 {
        run.step().expect("a step");
    }
    let sample = run.sample();
    let expected = [0.1, early("drag"), early("lift"), early("tip_ux"), early("tip_uy")];
    assert_eq!(sample.len(), expected.len());
    for (found, expected) in sample.iter().zip(expected) {
        assert!((found - expected).abs() < TOLERANCE * expected.abs(), "{found} is not {expected}");
    }
}

/// The recorded scene of a wing, and what was recorded of it.
fn wing() -> (Value, Value) {
    let recorded: Value = serde_json::from_str(RECORDED_WING).expect("JSON");
    let mut scene: Value = serde_json::from_str(WING).expect("JSON");
    for (path, value) in recorded["set"].as_object().expect("keys") {
        *scene.pointer_mut(&format!("/{}", path.replace('.', "/"))).expect("a key") = value.clone();
    }
    (scene, recorded)
}

/// Ten digits, of the largest force and of the largest motion, at a time when the wing moves and twists.
#[test]
fn a_wing_has_the_digits_of_the_coupled_units() {
    let (scene, recorded) = wing();
    let mut run = WingsInFlow::new(&scene.to_string()).expect("a scene that runs");
    for _ in 0..recorded["steps"].as_u64().expect("a number") {
        run.step().expect("a step");
    }
    let sample = run.sample();
    let names = ["time", "drag", "lift", "side", "tip_ux", "tip_uy", "tip_uz", "section_twist"];
    assert_eq!(sample.len(), names.len());
    for (found, name) in sample.iter().zip(names) {
        let expected = recorded["outputs"][name].as_f64().expect("a number");
        let largest = if name.starts_with("tip") { 1e-3 } else { expected.abs().max(1e-2) };
        assert!((found - expected).abs() < TOLERANCE * largest, "{name}: {found} is not {expected}");
    }
}

#[test]
fn a_wing_of_the_same_values_continues_with_the_same_digits() {
    let (scene, _) = wing();
    let mut runs = [(); 2].map(|()| WingsInFlow::new(&scene.to_string()).expect("a scene that runs"));
    runs.iter_mut().for_each(|run| (0..10).for_each(|_| run.step().expect("a step")));
    runs[1].change(&scene.to_string()).expect("a flow that fits");
    let [unchanged, changed] = runs.map(|mut run| {
        run.step().expect("a step");
        run.sample()
    });
    assert_eq!(changed, unchanged);
}

/// FSI3 on a coarse grid in a channel that runs from the start.
fn small_fsi3() -> Value {
    let mut scene: Value = serde_json::from_str(FSI3).expect("JSON");
    scene["fluid"]["box"]["cells"] = json!([160, 36]);
    scene["fluid"]["inflow"]["mean_velocity"] = json!({ "constant": 2.0 });
    scene
}

/// Return the samples after a step, without and with a change of a scene before it.
fn unchanged_and_changed(mut scene: Value, change: impl FnOnce(&mut Value)) -> [Vec<f64>; 2] {
    let mut runs = [(); 2].map(|()| RodsInFlow::new(&scene.to_string()).expect("a scene that runs"));
    runs.iter_mut().for_each(|run| (0..50).for_each(|_| run.step().expect("a step")));
    change(&mut scene);
    runs[1].change(&scene.to_string()).expect("a flow that fits");
    runs.map(|mut run| {
        run.step().expect("a step");
        run.sample()
    })
}

/// The root may be still or driven.
#[test]
fn a_scene_with_the_same_values_continues_with_the_same_digits() {
    let mut driven = small_fsi3();
    let swing = |amplitude: f64| json!({ "sine": { "amplitude": amplitude, "frequency": 3.0, "phase": 0.4 } });
    driven["rod"]["root_motion"] =
        json!({ "laws": { "x": swing(0.002), "y": swing(0.005), "rotations": [{ "angle": swing(0.1) }] } });
    for scene in [small_fsi3(), driven] {
        let [unchanged, changed] = unchanged_and_changed(scene, |_| {});
        assert_eq!(changed, unchanged);
    }
}

#[test]
fn a_flow_goes_on_around_a_new_cylinder() {
    let [unchanged, changed] = unchanged_and_changed(small_fsi3(), |scene| {
        let cylinders = scene["fluid"]["cylinders"].as_array_mut().expect("a list");
        cylinders.push(json!({ "center": [1.2, 0.2], "radius": 0.04 }));
    });
    assert_eq!(changed[0], unchanged[0], "time");
    for (changed, unchanged) in changed[3..].iter().zip(&unchanged[3..]) {
        assert!((changed - unchanged).abs() < 1e-7, "the tip is at {changed}, not {unchanged}");
    }
    let [without, with] = [unchanged[1], changed[1]];
    assert!(with > 2.0 * without, "the cylinder stops the fluid in it: drag {with}, {without} without");
}

/// A spring pulls by the stretch that a step ends with: one that is far too stiff for the mass of a station puts it
/// onto its end, and holds it there.
#[test]
fn a_stiff_spring_holds_a_station() {
    let mut run = RodsInFlow::new(&small_fsi3().to_string()).expect("a scene that runs");
    let station = run.positions(0, 0).len() - 1;
    let way = 1e-4;
    let to = [0, 1].map(|axis| run.positions(0, axis)[station] + way);
    run.set_pull(Some(Pull { rod: 0, station, to, stiffness: 1e9 }));
    for step in 1..=40 {
        run.step().expect("a step");
        let off = [0, 1].map(|axis| run.positions(0, axis)[station] - to[axis]);
        let allowed = if step < 10 { way } else { 0.03 * way };
        assert!(off[0].hypot(off[1]) < allowed, "after {step} steps the station is off by {off:?} m");
    }
}

#[test]
fn what_it_cannot_run_is_a_sentence() {
    let refused = |key: &str, value: Value| {
        let mut scene = small_fsi3();
        *scene.pointer_mut(key).expect("a key") = value;
        RodsInFlow::new(&scene.to_string()).err().expect("refused")
    };
    assert!(RodsInFlow::new("{").err().expect("refused").contains("line"));
    assert!(refused("/coupling/scheme", json!("parallel_explicit")).contains("must be `explicit`"));
    assert!(refused("/fluid/density", json!(-1.0)).contains("fluid.density"));
    let light = refused("/coupling", json!({ "load": "pressure_jump" }));
    assert!(light.contains("needs iterations"), "{light}");
    let refused = |key: &str, value: Value| {
        let (mut scene, _) = wing();
        scene[key] = value;
        WingsInFlow::new(&scene.to_string()).err().expect("refused")
    };
    assert!(refused("contact", json!({})).contains("contact of wings, which is not simulated here"));
}
