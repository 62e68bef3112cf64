//! Contact of bodies on a mount.

use common::fluid_of;
use nervure_fluid::{Error, Fluid, Parameters};
use scene::Scene;

mod common;

/// Circles of 1 m that fall in a closed box of 4 x 5 m of fluid.
fn falling(bodies: &[(f64, [f64; 2])], contact: &str) -> Fluid {
    let body = |(density, [x, y]): &(f64, [f64; 2])| {
        let mass = density * std::f64::consts::PI / 4.0;
        format!(
            r#"{{ "shape": {{ "circle": {{ "radius": 0.5 }} }}, "position": [{x}, {y}],
            "mount": {{ "mass": {mass}, "inertia": {}, "gravity": [0, -1], "x": {{}}, "y": {{}}, "angle": {{}} }} }}"#,
            mass / 8.0
        )
    };
    let bodies: Vec<_> = bodies.iter().map(body).collect();
    let text = format!(
        r#"{{ "name": "falling", "time": {{ "end": 1.0, "communication_step": 0.02 }}, {contact} "fluid": {{
            "density": 1.0, "kinematic_viscosity": 0.02,
            "box": {{ "x": [-0.2, 4.2], "y": [-0.25, 5.25], "cells": [44, 55] }},
            "channel": {{ "x": [0, 4], "y": [0, 5] }},
            "bodies": [{}], "mask": {{ "log_linear": {{ "c_eta": 1e-4 }} }},
            "time_stepping": {{ "max_step": 0.02, "max_cfl": 0.4 }} }} }}"#,
        bodies.join(", ")
    );
    fluid_of(&Scene::from_json(&text).unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn bodies_that_fall_come_to_rest_on_the_floor_and_on_each_other() {
    let mut fluid = falling(&[(2.0, [2.0, 0.9]), (1.5, [2.02, 2.3])], r#""contact": { "friction": 0.3 },"#);
    let mut deepest = f64::INFINITY;
    for k in 0..1000 {
        let t = fluid.time();
        fluid.advance(t, 0.02).unwrap_or_else(|e| panic!("{e}"));
        let [one, two] = [fluid.pose(0).position, fluid.pose(1).position];
        if k % 50 == 0 { println!("{t:.2} {:.3?} {:.3?} {:.4?} {:.4?}", one.as_slice(), two.as_slice(), fluid.pose(0).velocity.as_slice(), fluid.pose(1).velocity.as_slice()); }
        deepest = deepest.min((one - two).norm() - 1.0).min(one[1] - 0.5).min(two[1] - 0.5);
    }
    println!("{deepest}");
}
