//! What a law of time may not be meant to do: swing far beyond the points of its table, stop at once where the table
//! ends, or oscillate faster than the run follows; and a drag of solids that lets the flow through, or that rounding
//! drowns.

use std::f64::consts::PI;

use geometry::AXES;
use method::Precision;

use crate::fluid::Fluid;
use crate::flyer::HingeLaws;
use crate::law::TimeLaw;
use crate::mount::Freedom;
use crate::places::rounded;
use crate::root::{RootSupport, Rotation};
use crate::scene::Scene;
use crate::warning::Warning;

/// Part of the range of a table's values by which its spline may leave it.
const OVERSHOOT: f64 = 0.5;

/// Part of the range of a table's values that its last slope may cover in an interval.
const STOP: f64 = 0.1;

/// Largest relaxation time in solids by the time in which the flow passes one: a cylinder at Re 100 has 17 % more drag
/// at 0.1 and 2 % at 0.01.
const POROUS: f64 = 0.05;

/// The same by the time in which it passes the layer of a thin body: a swimmer is a fifth slower at 0.026, and those of
/// the shipped scenes are below 0.017.
const POROUS_LAYER: f64 = 0.02;

/// Least relaxation time in solids by the step, in both precisions: forces keep three digits.
const ROUNDED: f64 = 1e-12;
const ROUNDED_SINGLE: f64 = 1e-6;

/// Least communication steps in a period.
const STEPS: f64 = 8.0;

/// Communication steps in a period that are advised.
const ADVISED: f64 = 20.0;

/// Return the warning about the laws and springs of a scene.
pub(crate) fn of(scene: &Scene) -> Vec<Warning> {
    let step = scene.time.communication_step;
    let mut found = Vec::new();
    visit(scene, &mut |key, law, end| {
        law.visit(&key, &mut |key, law| {
            found.extend(tables(key, law, end));
            found.extend(sudden(key, law, step));
            found.extend(law.highest_frequency().and_then(|frequency| fast(key, "`", "", frequency, step)));
        });
    });
    let fluid = scene.fluid.iter();
    let bodies = fluid.flat_map(|fluid| fluid.bodies.iter().map(|body| body.freedoms(fluid.is_space())).enumerate());
    for (i, freedoms) in bodies {
        for Freedom { name, inertia, support, .. } in freedoms {
            let frequency = support.map_or(0.0, |support| (support.stiffness / inertia).sqrt() / (2.0 * PI));
            let key = format!("fluid.bodies[{i}].mount.{name}.stiffness");
            found.extend(fast(&key, "the spring of `", " without the fluid", frequency, step));
        }
    }
    let released = scene.fluid.iter().flat_map(|fluid| &fluid.bodies).enumerate();
    for (i, release) in released.filter_map(|(i, body)| Some((i, body.release()?))) {
        if release >= scene.time.end {
            let key = format!("fluid.bodies[{i}].mount.release");
            let text =
                format!("`{key}` is {} s, not before the end of the run: the body is never free", rounded(release));
            found.push(warning(&key, None, text));
        }
    }
    if let Some(flyer) = &scene.flyer {
        for (i, spring) in flyer.springs.iter().enumerate() {
            let frequency = (spring.support.stiffness / flyer.inertia_along(spring.along)).sqrt() / (2.0 * PI);
            let key = format!("flyer.springs[{i}].support.stiffness");
            found.extend(fast(&key, "the spring of `", " without what it carries", frequency, step));
        }
    }
    found
}

/// Return the warning about the penalization rate of solids; `passages` are the times in which the flow passes one, and
/// the layer of a thin one, s.
pub(crate) fn of_drag(fluid: &Fluid, step: f64, [passage, of_layer]: [Option<f64>; 2]) -> Option<Warning> {
    let (c_eta, step) = (fluid.mask.c_eta(), step.min(fluid.time_stepping.max_step));
    let least = step
        * match fluid.precision {
            Precision::Double => ROUNDED,
            Precision::Single => ROUNDED_SINGLE,
        };
    let (effect, other) = match passage {
        Some(passage) if c_eta > POROUS * passage => ("the flow passes through solids", POROUS * passage),
        _ if of_layer.is_some_and(|passage| c_eta > POROUS_LAYER * passage) => {
            ("the flow passes through thin bodies", POROUS_LAYER * of_layer.unwrap_or_default())
        }
        _ if c_eta < least => ("forces are the rounding of velocities", least),
        _ => return None,
    };
    let (given, allowed) = (format!("{c_eta:e}"), format!("{other:.1e}"));
    let side = if c_eta > other { "most" } else { "least" };
    let text =
        format!("`fluid.mask` has a `c_eta` of {given} s, at which {effect}: it should be at {side} {allowed} s");
    Some(warning("fluid.mask", None, text))
}

/// Call `see` with the key of every law of a scene, the law, and the time to which it holds, s.
fn visit(scene: &Scene, see: &mut dyn FnMut(String, &TimeLaw, f64)) {
    let end = scene.time.end;
    if let Some(fluid) = &scene.fluid {
        for zone in fluid.zones().into_iter().flatten() {
            see(format!("fluid.{}.mean_velocity", zone.name), zone.mean_velocity, end);
        }
        for (name, law) in fluid.mean_flow.iter().flat_map(|mean| mean.laws()) {
            see(format!("fluid.mean_flow.{name}"), law, end);
        }
    }
    let of_fluid = scene.fluid.iter().flat_map(Fluid::obstacles).map(|own| (own.key, own.body));
    let of_contact = scene.contact.iter().flat_map(|contact| contact.obstacles.iter().cloned().enumerate());
    let of_contact = of_contact.map(|(i, body)| (format!("contact.obstacles[{i}]"), body));
    for (key, body) in of_fluid.chain(of_contact) {
        let Some(motion) = body.laws() else { continue };
        let see =
            &mut |key: String, law: &TimeLaw| see(key, law, body.release().map_or(end, |release| release.min(end)));
        visit_motion(&format!("{key}.motion"), motion.along(), &motion.rotations, see);
        see(format!("{key}.motion.angle"), &motion.angle);
    }
    for own in scene.beams_with_rods() {
        let Some(rod) = own.rod else { continue };
        let key = format!("{}rod", own.key());
        if let Some(laws) = rod.laws() {
            visit_motion(&format!("{key}.root_motion.laws"), laws.along(), &laws.rotations, &mut |key, law| {
                see(key, law, end)
            });
        }
        if let RootSupport::Free { force_x, force_y, force_z } = &rod.root {
            for (name, law) in [("force_x", force_x), ("force_y", force_y), ("force_z", force_z)] {
                see(format!("{key}.root.free.{name}"), law, end);
            }
        }
    }
    for own in scene.wings() {
        let Some(laws) = own.wing.laws() else { continue };
        visit_motion(&format!("{}.root_motion", own.key), laws.along(), &laws.rotations, &mut |key, law| {
            see(key, law, end)
        });
    }
    for (i, hinge) in scene.flyer.iter().flat_map(|flyer| &flyer.hinges).enumerate() {
        let Some(HingeLaws { stroke, deviation, pitch }) = hinge.laws() else { continue };
        for (name, law) in [("stroke", stroke), ("deviation", deviation), ("pitch", pitch)] {
            see(format!("flyer.hinges[{i}].motion.{name}"), law, end);
        }
    }
}

/// Call `see` with the laws of a displacement and of rotations, and their keys below `key`.
fn visit_motion(key: &str, along: [&TimeLaw; 3], rotations: &[Rotation], see: &mut dyn FnMut(String, &TimeLaw)) {
    for (name, law) in AXES.into_iter().zip(along) {
        see(format!("{key}.{name}"), law);
    }
    for (i, turn) in rotations.iter().enumerate() {
        see(format!("{key}.rotations[{i}].angle"), &turn.angle);
    }
}

fn warning(key: &str, time: Option<f64>, text: String) -> Warning {
    Warning { key: key.into(), time, text }
}

/// Return the warning about a table in a run up to `end` (s).
fn tables(key: &str, law: &TimeLaw, end: f64) -> Vec<Warning> {
    let TimeLaw::Table(table) = law else { return Vec::new() };
    let mut found = Vec::new();
    let [low, high] = table.range();
    let (t, farthest) = table.farthest();
    if farthest > high + OVERSHOOT * (high - low) || farthest < low - OVERSHOOT * (high - low) {
        let (from, to, there, at) = (rounded(low), rounded(high), rounded(farthest), rounded(t));
        let text = format!(
            "`{key}` goes to {there} at t = {at} s, although its values lie between {from} and {to}: a smooth curve \
             swings beside points that are close together; give more points there, or a `cosine_ramp`"
        );
        found.push(warning(key, Some(t), text));
    }
    // A velocity that bends is no peak.
    let ends = if key.contains("motion.") { table.ends() } else { Vec::new() };
    for (t, slope, interval) in ends {
        if 0.0 < t && t < end && (slope * interval).abs() > STOP * (high - low) {
            let (at, slope) = (rounded(t), rounded(slope));
            let text = format!(
                "`{key}` starts or stops at once at t = {at} s, where its table ends with the slope {slope} per \
                 second: forces have a peak there; `end_slopes` of 0 make it smooth"
            );
            found.push(warning(key, Some(t), text));
        }
    }
    found
}

/// Return the warning about a ramp of a motion in communication steps of `step` (s).
fn sudden(key: &str, law: &TimeLaw, step: f64) -> Option<Warning> {
    let TimeLaw::CosineRamp { value, duration } = law else { return None };
    let steps = duration / step;
    (key.contains("motion.") && *value != 0.0 && steps < STEPS / 2.0 * (1.0 - 1e-9)).then(|| {
        let text = format!(
            "`{key}` moves by {} within {steps:.2} communication steps: the run does not follow it; a duration of {} s \
             would do",
            rounded(*value),
            rounded(ADVISED / 2.0 * step)
        );
        warning(key, None, text)
    })
}

/// Return the warning about an oscillation of so many Hz with communication steps of `step` (s).
fn fast(key: &str, before: &str, after: &str, frequency: f64, step: f64) -> Option<Warning> {
    let steps = 1.0 / (frequency * step);
    (steps < STEPS * (1.0 - 1e-9)).then(|| {
        let (frequency, steps, advised) = (rounded(frequency), format!("{steps:.2}"), 1.0 / (ADVISED * frequency));
        let text = format!(
            "{before}{key}` oscillates with {frequency} Hz{after}, and a period has {steps} communication steps: the \
             run does not follow it; a step of {} s would",
            rounded(advised)
        );
        warning(key, None, text)
    })
}
