//! Tests of rods built from scenes.

use rod::Rod;
use scene::{Spanwise, SpanwiseProfile};

use super::*;

fn rod_of<const D: usize>(scene: &Scene) -> Rod<D> {
    let beam = scene.beam.as_ref().unwrap();
    let mut rod = Rod::new(parameters(scene, beam, scene.rod.as_ref().unwrap())).unwrap();
    rod.loads = loads(scene, D, beam.segments + 1);
    rod
}

/// Return a scene with this `beam.root`, and with `fluid` and `coupling` if it has a load.
fn scene(root: &str, load: Option<&str>) -> Scene {
    let coupled = load.map_or(String::new(), |load| {
        format!(
            r#""fluid": {{
                "density": 1000, "kinematic_viscosity": 1e-3,
                "box": {{ "x": [0, 2.5], "y": [0, 0.5], "cells": [320, 64] }},
                "cylinders": [{{ "center": [0.25, 0.25], "radius": 0.0625 }}],
                "mask": {{ "cosine": {{ "c_eta": 1e-4, "half_width": 1 }} }},
                "filter": "smooth", "time_stepping": {{ "max_step": 2e-4, "max_cfl": 0.4 }}
            }},
            "coupling": {{ "load": "{load}" }},"#
        )
    });
    let text = format!(
        r#"{{
            "name": "flag", "time": {{ "end": 1, "communication_step": 0.1 }}, {coupled}
            "beam": {{ "root": {root}, "length": 0.5, "thickness": 0.02, "segments": 4 }},
            "rod": {{ "material": {{ "plane_strain": {{
                "density": 1000, "youngs_modulus": 5.6e6, "poisson_ratio": 0.4
            }} }} }}
        }}"#
    );
    Scene::from_json(&text).unwrap()
}

const ON_CYLINDER: &str = r#"{ "on_cylinder": { "cylinder": 0 } }"#;
const AT: &str = r#"{ "at": { "position": [1, 2, 3], "direction": [0, 0, 2] } }"#;

#[test]
fn rod_lies_where_the_scene_puts_it() {
    let rod = rod_of::<2>(&scene(ON_CYLINDER, Some("momentum")));
    assert_eq!(rod.positions(0), [0.3125, 0.4375, 0.5625, 0.6875, 0.8125]);
    assert_eq!(rod.positions(1), [0.25; 5]);
    let rod = rod_of::<3>(&scene(AT, None));
    assert_eq!(rod.positions(2), [3.0, 3.125, 3.25, 3.375, 3.5]);
    assert_eq!(rod.velocities(0), [0.0; 5]);
}

#[test]
fn rod_has_the_loads_of_the_scene() {
    let zeros = |count| vec![0.0; count];
    let rod = rod_of::<3>(&scene(AT, None));
    assert_eq!(rod.loads, Loads { force: zeros(15), ..Loads::default() });
    let rod = rod_of::<2>(&scene(ON_CYLINDER, Some("momentum")));
    assert_eq!(rod.loads, Loads { force: zeros(10), impedance: zeros(5), ..Loads::default() });
    assert_eq!(rod.parameters().displaced, 20.0);
    let rod = rod_of::<2>(&scene(ON_CYLINDER, Some("pressure_jump")));
    assert_eq!(rod.loads, Loads { pressure_jump: zeros(5), ..Loads::default() });
    assert_eq!(rod.parameters().displaced, 0.0);
}

/// A linear thickness of root 0.1 and tip 0.02, by a law or by points, gives linear densities and a cubic bending
/// stiffness.
#[test]
fn scene_gives_the_taper() {
    let scene = |thickness: &str, material: &str| {
        let root = r#"{ "at": { "position": [0, 0], "direction": [1, 0] } }"#;
        let text = format!(
            r#"{{ "name": "tapered", "time": {{ "end": 1, "communication_step": 0.1 }},
            "beam": {{ "root": {root}, "length": 1, "thickness": {thickness}, "segments": 8 }},
            "rod": {{ "material": {material} }} }}"#
        );
        rod_of::<2>(&Scene::from_json(&text).unwrap())
    };
    let strain = r#"{ "plane_strain": { "density": 2, "youngs_modulus": 1e3, "poisson_ratio": 0.3 } }"#;
    let law = r#"{ "taper": { "root": 0.1, "tip": 0.02 } }"#;
    let table = r#"{ "points": { "s": [0, 0.5, 1], "values": [0.1, 0.06, 0.02] } }"#;
    let section = format!(
        r#"{{ "section": {{ "line_density": {{ "taper": {{ "root": 0.2, "tip": 0.04 }} }}, "axial_stiffness": {},
        "bending_stiffness": {{ "taper": {{ "root": 1, "tip": 0.008, "power": 3 }} }} }} }}"#,
        r#"{ "taper": { "root": 100, "tip": 20 } }"#
    );
    let linear: Vec<_> = (0..17).map(|i| 1.0 - 0.8 * f64::from(i) / 16.0).collect();
    let cubic = linear.iter().map(|ratio: &f64| ratio.powi(3)).collect();
    for (thickness, material) in [(law, strain), (table, strain), ("0.1", &section)] {
        let rod = scene(thickness, material);
        let found = &rod.parameters().taper;
        for (name, found, expected) in [
            ("line density", &found.line_density, &linear),
            ("bending", &found.bending_stiffness, &cubic),
            ("axial", &found.axial_stiffness, &linear),
        ] {
            assert_eq!(found.len(), expected.len(), "{thickness}, {name}");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{thickness}, {name}: {found} against {expected}");
            }
        }
        assert!(found.displaced.is_empty(), "there is no fluid");
    }
    assert_eq!(scene("0.1", strain).parameters().taper, Taper::default());
    let constant = Spanwise::Varying(SpanwiseProfile::Taper { root: 0.1, tip: 0.1, power: 1.0 });
    assert!((constant.at(0.3) - 0.1).abs() < 1e-16);
}
