//! Forces that lag behind in slow viscous flow.
//!
//! With `sbdf2` the drag acts on u*, which viscosity and pressure correct a step later. The force on a body in viscous
//! flow therefore follows what changes it late, by
//!
//! ```text
//! T = 20 ν Δt²/L²,   L = √(l h)
//! ```
//!
//! with its length l and its thickness h, which counts as a tenth of the length at least. Circles, spheres, ellipses,
//! rectangles, plates and disks that oscillate at ω L²/ν from 0.08 to 6 have forces that are ω T off, within a factor of
//! two, and T is the time in which the drag of a cylinder in a steady stream reaches 1 - 1/e. It is longer in a gap
//! narrower than L.

use method::{Surface, TimeScheme};

use crate::fluid::Fluid;
use crate::law::TimeLaw;
use crate::places::three_digits;
use crate::scales::{sides_of_wing, two_sides};
use crate::scene::Scene;
use crate::warning::Warning;

/// T ν⁻¹ (L/Δt)².
const LAG: f64 = 20.0;

/// Largest T by the time in which a force changes: forces are then some 5 % off.
const SHORT: f64 = 0.05;

/// Least thickness of a body by its length: a plate across itself is as late as a body of that thickness.
const THINNEST: f64 = 0.1;

/// Rate at which what is free follows the fluid, by ν/L²: a cylinder as heavy as the fluid that falls wants a step below
/// 0.02 L²/ν.
const FREE: f64 = 6.25;

/// What the fluid drags.
struct Dragged {
    key: String,
    /// Length and thickness, m.
    size: [f64; 2],
    /// Largest rate of laws that move it, 1/s.
    rate: f64,
    /// Whether the fluid moves it.
    is_free: bool,
}

/// Return the warning about the longest step of a fluid, from the forces that are the latest.
pub(crate) fn of_step(scene: &Scene, fluid: &Fluid) -> Option<Warning> {
    if fluid.time_stepping.scheme == TimeScheme::Rk2 {
        return None;
    }
    let nu = fluid.kinematic_viscosity;
    let dt = scene.time.communication_step.min(fluid.time_stepping.max_step);
    let of_flow = of_velocities(fluid).max(1.0 / scene.time.end);
    let limits = dragged(scene, fluid).into_iter().map(|own| {
        let [length, thickness] = own.size;
        let square = length * thickness.max(THINNEST * length);
        let free = if own.is_free { FREE * nu / square } else { 0.0 };
        let rate = own.rate.max(of_flow).max(free);
        (own.key, LAG * nu * dt * dt / square, (SHORT * square / (LAG * nu * rate)).sqrt())
    });
    let (key, lag, limit) = limits.min_by(|a, b| a.2.total_cmp(&b.2))?;
    let text = format!(
        "forces on `{key}` lag behind by {} s, {} steps, in so viscous a flow: with a `max_step` of at most {} s they \
         are within some 5 %",
        three_digits(lag),
        three_digits(lag / dt),
        three_digits(0.99 * limit)
    );
    (dt > limit).then(|| Warning { key: "fluid.time_stepping.max_step".into(), time: None, text })
}

/// Return the rate at which the velocity of the stream changes, 1/s.
fn of_velocities(fluid: &Fluid) -> f64 {
    let along_x = fluid.inflow.iter().map(|inflow| &inflow.mean_velocity);
    let mean = fluid.mean_flow.iter().flat_map(|flow| flow.laws().map(|(_, law)| law));
    let of_law = |law: &TimeLaw| law.largest_rate() / law.largest();
    along_x.chain(mean).map(of_law).filter(|rate| rate.is_finite()).fold(0.0, f64::max)
}

/// Return the rate at which a motion changes its velocity, 1/s.
fn of_motion<'a>(laws: impl Iterator<Item = &'a TimeLaw>) -> f64 {
    let of_law = |law: &TimeLaw| law.largest_acceleration() / law.largest_rate();
    laws.map(of_law).filter(|rate| rate.is_finite()).fold(0.0, f64::max)
}

fn dragged(scene: &Scene, fluid: &Fluid) -> Vec<Dragged> {
    let (ends, flies): (Vec<_>, _) = (fluid.r#box.ends().collect(), scene.flyer.as_ref().and_then(|own| own.shape));
    let of_flyer = flies.map(|k| format!("fluid.bodies[{k}]"));
    let bodies = fluid.obstacles().map(|own| Dragged {
        size: if fluid.is_space() { two_sides(&own.body, &ends) } else { own.body.shape.size() },
        rate: own.body.laws().map_or(0.0, |laws| of_motion(laws.all())),
        is_free: own.body.mount.is_some() || of_flyer.as_ref() == Some(&own.key),
        key: own.key,
    });
    let beams = scene.beams_with_rods().map(|own| Dragged {
        key: format!("{}beam", own.key()),
        size: [own.beam.length, if own.beam.surface == Surface::Line { 0.0 } else { own.beam.largest_thickness() }],
        rate: own.laws().map_or(0.0, |laws| of_motion(laws.all())),
        is_free: own.rod.is_some(),
    });
    let wings = scene.wings().map(|own| Dragged {
        size: [sides_of_wing(own.wing, None)[0], 0.0],
        rate: own.wing.laws().map_or(0.0, |laws| of_motion(laws.all())),
        is_free: true,
        key: own.key,
    });
    bodies.chain(beams).chain(wings).collect()
}
