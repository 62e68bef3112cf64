//! The wing of a scene in its fluid.

#[path = "../src/from_scene.rs"]
#[allow(dead_code, reason = "the unit needs the poses, too")]
mod from_scene;

use scene::{SURFACE_THICKNESS_CELLS, Scene};

/// The fluid moves a layer with the wing whose thickness is measured by its largest cells, whatever their axis.
#[test]
fn a_wing_leaves_out_the_mass_of_the_layer_that_the_fluid_moves_with_it() {
    let fine = r#""fine_box": { "x": [-0.8, 0.8], "y": [-0.8, 0.8], "z": [-0.8, 0.8] },"#;
    for (cells, fine, largest) in [
        ([16, 20, 40], "", 2.0 / 16.0),
        ([40, 16, 20], "", 2.0 / 16.0),
        ([20, 40, 16], "", 2.0 / 16.0),
        ([40, 40, 40], fine, 1.0 / 40.0),
    ] {
        let text = format!(
            r#"{{ "name": "own", "time": {{ "end": 1.0, "communication_step": 0.01 }},
            "fluid": {{ "density": 3.0, "kinematic_viscosity": 0.01, "initial_velocity": [1.0, 0.0, 0.0],
                "box": {{ "x": [-1.0, 1.0], "y": [-1.0, 1.0], "z": [-1.0, 1.0], "cells": {cells:?} }}, {fine}
                "time_stepping": {{ "max_step": 0.01, "max_cfl": 0.4 }},
                "mask": {{ "log_linear": {{ "c_eta": 1e-4 }} }} }},
            "wing": {{ "mesh": {{ "rectangular": {{ "length": 0.5, "width": 0.3, "along": 4 }} }},
                "membrane": {{ "areal_density": 1.0, "stretching_stiffness": 1e3, "bending_stiffness": 1e-3 }},
                "root": "root" }} }}"#
        );
        let scene = Scene::from_json(&text).unwrap_or_else(|e| panic!("{e}"));
        let wing = scene.wing.as_ref().expect("it has one");
        let found = from_scene::parameters(&scene, wing).displaced_density;
        let expected = 3.0 * SURFACE_THICKNESS_CELLS * largest;
        assert!((found - expected).abs() < 1e-12, "{cells:?} {fine}: {found} kg/m² in place of {expected}");
    }
}
