//! Runs that try the fluid's stability, and how they end. The stability table and a test share them.

use nervure_fluid::{Fluid, Parameters};
use scene::Scene;

/// Faster than this (m/s) is no flow any more: the peak of the inflow is 1.5 m/s.
const TOO_FAST: f64 = 10.0;

/// How a run ended.
#[derive(Debug)]
pub enum Outcome {
    /// To the end, everything finite, at most this fast at the end of any communication step, m/s.
    Ok { fastest: f64 },
    /// To the end and finite, but this fast, m/s.
    Wild { fastest: f64 },
    /// To the end, but with something that is not a number.
    NotFinite,
    /// Refused (at no time) or given up, with the message.
    Error { time: Option<f64>, message: String },
}

/// What is varied for the cylinder in a channel.
#[derive(Clone, Copy)]
pub struct Case<'a> {
    /// `sbdf2` or `rk2`.
    pub scheme: &'a str,
    /// Kind of mask and its keys but `c_eta`.
    pub mask: (&'a str, &'a str),
    /// Relaxation time, s.
    pub c_eta: f64,
    /// Largest CFL number.
    pub cfl: f64,
    /// Reynolds number of the cylinder's diameter and the mean inflow.
    pub reynolds: f64,
}

/// The profile of the shipped scenes.
pub const LOG_LINEAR: (&str, &str) = ("log_linear", "");

/// The Schäfer–Turek channel on 200 x 40 points, started by a jump of the inflow from 0 to 1 m/s.
pub fn channel(case: Case) -> Result<Scene, String> {
    let cylinders = r#"[{ "center": [0.2, 0.2], "radius": 0.05 }]"#;
    channel_with(case, cylinders, r#"{ "constant": 1.0 }"#)
}

/// The same with other cylinders and another inflow.
pub fn channel_with(case: Case, cylinders: &str, inflow: &str) -> Result<Scene, String> {
    let Case { scheme, mask: (kind, keys), c_eta, cfl, reynolds } = case;
    let text = format!(
        r#"{{ "name": "stability", "time": {{ "end": 3.0, "communication_step": 0.01 }}, "fluid": {{
            "density": 1.0, "kinematic_viscosity": {},
            "box": {{ "x": [-0.752, 2.2], "y": [-0.0902, 0.5002], "cells": [200, 40] }},
            "channel": {{ "y": [0.0, 0.41] }},
            "inflow": {{ "x": [-0.752, 0.0], "profile": "parabolic", "mean_velocity": {inflow}, "c_eta": {} }},
            "cylinders": {cylinders},
            "mask": {{ "{kind}": {{ "c_eta": {c_eta} {keys} }} }},
            "time_stepping": {{ "max_step": 0.01, "max_cfl": {cfl}, "scheme": "{scheme}" }} }} }}"#,
        0.1 / reynolds,
        c_eta.max(1e-4),
    );
    Scene::from_json(&text).map_err(|e| e.to_string())
}

/// Bodies and inflows that are hard on a solver, each with its name.
pub fn hard_scenes(case: Case) -> Result<Vec<(&'static str, Scene)>, String> {
    let steady = r#"{ "constant": 1.0 }"#;
    let with = |cylinders: &str| channel_with(case, cylinders, steady);
    Ok(vec![
        (
            "cylinders that touch both walls",
            with(r#"[{ "center": [0.2, 0.05], "radius": 0.05 }, { "center": [0.5, 0.37], "radius": 0.06 }]"#)?,
        ),
        (
            "two cylinders a third of a cell apart",
            with(r#"[{ "center": [0.2, 0.1475], "radius": 0.05 }, { "center": [0.2, 0.2525], "radius": 0.05 }]"#)?,
        ),
        ("a cylinder that blocks two thirds of the channel", with(r#"[{ "center": [0.3, 0.2], "radius": 0.137 }]"#)?),
        (
            "a cylinder that leaves through the end of the box and comes in again",
            with(
                r#"[{ "center": [1.8, 0.2], "radius": 0.05, "motion": { "x": { "table":
                { "times": [0.0, 0.5, 3.0], "values": [0.0, 0.3, 3.4] } } } }]"#,
            )?,
        ),
        (
            "a cylinder that swings through the wall",
            with(
                r#"[{ "center": [0.4, 0.2], "radius": 0.05, "motion": { "y": { "sine":
                { "amplitude": 0.25, "frequency": 1.0 } } } }]"#,
            )?,
        ),
        (
            "an inflow that jumps to its reverse within a millisecond",
            channel_with(
                case,
                r#"[{ "center": [0.2, 0.2], "radius": 0.05 }]"#,
                r#"{ "table": { "times": [1.0, 1.001], "values": [1.0, -1.0] } }"#,
            )?,
        ),
    ])
}

/// Run a scene for a number of communication steps.
pub fn outcome(scene: Result<Scene, String>, steps: usize) -> Outcome {
    let refused = |message| Outcome::Error { time: None, message };
    let scene = match scene {
        Ok(scene) => scene,
        Err(message) => return refused(message),
    };
    let mut fluid = match Parameters::<2>::try_from(&scene).and_then(|parameters| Fluid::new(&parameters)) {
        Ok(fluid) => fluid,
        Err(error) => return refused(error.to_string()),
    };
    let (h, mut fastest) = (scene.time.communication_step, 0.0_f64);
    for step in 0..steps {
        if let Err(error) = fluid.advance(h * step as f64, h) {
            return Outcome::Error { time: Some(fluid.time()), message: error.to_string() };
        }
        let (u, v) = (fluid.velocity(0), fluid.velocity(1));
        let speeds = u.iter().zip(&*v).map(|(u, v)| u.hypot(*v));
        fastest = speeds.fold(fastest, |most, speed| if speed > most { speed } else { most });
    }
    let numbers = [&*fluid.velocity(0), &fluid.velocity(1), &fluid.vorticity(0), &fluid.force()].concat();
    if numbers.iter().chain(&fluid.pressure()).any(|number| !number.is_finite()) {
        Outcome::NotFinite
    } else if fastest < TOO_FAST {
        Outcome::Ok { fastest }
    } else {
        Outcome::Wild { fastest }
    }
}
