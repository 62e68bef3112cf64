use adapter::either;
use rod::Rod;
use scene::Scene;

use crate::unit::RodUnit;

/// A rod along x with a ball (a cylinder in the plane) that moves up by half a metre a second through its tip.
fn scene(contact: &str) -> Scene {
    let text = format!(
        r#"{{"name": "pushed", "time": {{"end": 0.2, "communication_step": 1e-3}},
            "beam": {{"root": {{"at": {{"position": [0, 0], "direction": [1, 0]}}}}, "length": 1.0,
                      "thickness": 0.02, "segments": 20}},
            "rod": {{"material": {{"section": {{"line_density": 1.0, "bending_stiffness": 0.1,
                                                "axial_stiffness": 1e3}}}}}}{contact}}}"#
    );
    Scene::from_json(&text).unwrap()
}

const CONTACT: &str = r#", "contact": {"obstacles": [{"shape": {"circle": {"radius": 0.1}}, "position": [0.9, -0.14],
    "motion": {"y": {"table": {"times": [0, 0.2], "values": [0, 0.1], "end_slopes": [0.5, 0.5]}}}}]}"#;

fn unit(contact: &str) -> RodUnit {
    let scene = scene(contact);
    let (beam, rod) = (scene.beam.clone().unwrap(), scene.rod.clone().unwrap());
    let mut unit = RodUnit::new("pushed".into(), scene, (beam, rod), Default::default(), None).unwrap();
    unit.build().unwrap();
    unit
}

#[test]
fn a_solid_moved_by_a_law_pushes_the_rod_and_stays_outside() {
    let [mut pushed, mut free] = [CONTACT, ""].map(unit);
    for k in 0..200 {
        let t = 1e-3 * f64::from(k);
        pushed.step(t, 1e-3).unwrap();
        free.step(t, 1e-3).unwrap();
    }
    let [x, y] = [0, 1].map(|axis| either!(pushed.body(), rod => rod.positions(axis)));
    let least = x.iter().zip(y).map(|(x, y)| (x - 0.9).hypot(y + 0.04)).fold(f64::INFINITY, f64::min);
    assert!(least > 0.1, "the centre line is {least} m from the middle of a cylinder of 0.1 m");
    assert!(y[20] > 0.05, "the tip is lifted by {} m", y[20]);
    assert!(either!(free.body(), rod => rod.positions(1)).iter().all(|y| *y == 0.0), "a rod without contact stays");
}

#[test]
fn a_rod_without_the_key_has_no_contact() {
    let scene = scene("");
    let rod =
        Rod::<2>::new(crate::from_scene::parameters(&scene, scene.beam.as_ref().unwrap(), scene.rod.as_ref().unwrap()));
    assert!(rod.unwrap().contact_forces().is_empty());
    let names = |contact: &str| fmi_export::Model::variables(&unit(contact)).len();
    assert_eq!(names(CONTACT), names("") + 1, "energy.contact");
}
