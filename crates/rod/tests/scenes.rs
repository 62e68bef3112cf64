//! Rods made from scenes.

use nervure_rod::{Error, Loads, Rod};
use scene::Scene;

/// A scene with the given `beam.root`, and with `fluid` and `coupling` where there is a load.
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
            "rod": {{ "material": {{ "plane_strain": {{ "density": 1000, "youngs_modulus": 5.6e6, "poisson_ratio": 0.4 }} }} }}
        }}"#
    );
    Scene::from_json(&text).unwrap()
}

const ON_CYLINDER: &str = r#"{ "on_cylinder": { "cylinder": 0 } }"#;
const AT: &str = r#"{ "at": { "position": [1, 2, 3], "direction": [0, 0, 2] } }"#;

#[test]
fn rod_lies_where_the_scene_puts_it() {
    let rod = Rod::<2>::from_scene(&scene(ON_CYLINDER, Some("momentum"))).unwrap();
    assert_eq!(rod.positions(0), [0.3125, 0.4375, 0.5625, 0.6875, 0.8125]);
    assert_eq!(rod.positions(1), [0.25; 5]);
    let rod = Rod::<3>::from_scene(&scene(AT, None)).unwrap();
    assert_eq!(rod.positions(2), [3.0, 3.125, 3.25, 3.375, 3.5]);
    assert_eq!(rod.velocities(0), [0.0; 5]);
}

#[test]
fn rod_has_the_loads_of_the_scene() {
    let zeros = |count| vec![0.0; count];
    let rod = Rod::<3>::from_scene(&scene(AT, None)).unwrap();
    assert_eq!(rod.loads, Loads { force: zeros(15), ..Loads::default() });
    let rod = Rod::<2>::from_scene(&scene(ON_CYLINDER, Some("momentum"))).unwrap();
    assert_eq!(rod.loads, Loads { force: zeros(10), impedance: zeros(5), ..Loads::default() });
    assert_eq!(rod.parameters().displaced, 20.0);
    let rod = Rod::<2>::from_scene(&scene(ON_CYLINDER, Some("pressure_jump"))).unwrap();
    assert_eq!(rod.loads, Loads { pressure_jump: zeros(5), ..Loads::default() });
    assert_eq!(rod.parameters().displaced, 0.0);
}

#[test]
fn scene_without_a_rod_of_the_dimension_is_refused() {
    let mut rigid = scene(AT, None);
    rigid.rod = None;
    for found in [Rod::<2>::from_scene(&scene(AT, None)), Rod::<2>::from_scene(&rigid)] {
        assert!(matches!(found, Err(Error::NoRod { dimension: 2, .. })));
    }
}
