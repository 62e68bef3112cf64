//! Layers at moving bodies and oblique plates that are too thin for the grid, so that forces are too small.
//!
//! A motion of the circular frequency ω has a Stokes layer of √(2 ν/ω), one that starts at once a layer of √(ν t). The
//! frequency of any law is its largest acceleration by its largest rate.

use geometry::vector::dot;

use crate::fluid::Fluid;
use crate::law::TimeLaw;
use crate::places::rounded;
use crate::scales::{Scales, thin_normal};
use crate::scene::Scene;
use crate::warning::Warning;

/// Least cells in the layer of a moving body: forces on a sphere are a quarter too small at 0.32 in a Stokes layer, a
/// seventh at 0.32 and a twentieth at 0.5 after a start.
const OF_BODY: f64 = 0.8;

/// Least cells in the layer of a root: those of the shipped scenes, compared with published forces, begin at 0.68.
const OF_ROOT: f64 = 0.6;

/// Part of the run that a start may spoil.
const START: f64 = 0.3;

/// Part of the largest rate or acceleration from which on a start is sudden.
const SUDDEN: f64 = 0.1;

/// Least cells in the boundary layer √(ν L/(2 U)) of an oblique plate: with 0.5, its lift is a twentieth off.
const OBLIQUE: f64 = 0.5;

/// Least components of the normal of a plate along and across the stream for a lift.
const LIFTS: f64 = 0.1;

/// Return the warnings about the layers of a scene, whose bodies have `scales` in a flow of `speed` (m/s).
pub(crate) fn layers(scene: &Scene, fluid: &Fluid, scales: &[(String, Scales)], speed: Option<f64>) -> Vec<Warning> {
    let cell = fluid.largest_cell();
    let nu = fluid.kinematic_viscosity;
    let mut found = Vec::new();
    let mut moves = |key: String, laws: Vec<&TimeLaw>, least: f64| {
        found.extend(of_motion(key, &laws, least, [nu, cell, scene.time.end]));
    };
    for own in fluid.obstacles() {
        if let Some(laws) = own.body.laws() {
            moves(format!("{}.motion", own.key), laws.all().collect(), OF_BODY);
        }
    }
    for own in scene.beams_with_rods() {
        if let Some(laws) = own.laws() {
            moves(format!("{}rod.root_motion", own.key()), laws.all().collect(), OF_ROOT);
        }
    }
    for own in scene.wings() {
        if let Some(laws) = own.wing.laws() {
            moves(format!("{}.root_motion", own.key), laws.all().collect(), OF_ROOT);
        }
    }
    let plates = fluid.obstacles().filter(|own| fluid.is_space() && own.body.shape.surface().is_some());
    for own in plates {
        let Some(scales) = scales.iter().find_map(|(name, scales)| (*name == own.force).then_some(scales)) else {
            continue;
        };
        let Some((normal, speed)) = thin_normal(&own.body).zip(scales.speed.or(speed)) else { continue };
        let along = dot(normal, scales.drag).abs();
        let is_oblique = along > LIFTS && (1.0 - along * along).sqrt() > LIFTS;
        let turns = own.body.laws().is_some_and(|laws| laws.turns().any(|(_, angle)| angle.largest_rate() > 0.0));
        let layer = (0.5 * nu * scales.length / speed).sqrt() / cell;
        if (is_oblique || turns) && layer < OBLIQUE {
            found.push(Warning {
                text: format!(
                    "the boundary layer of `{}`, an oblique plate, has {} cells, and its chord {}: with less than \
                     {OBLIQUE} in the layer, its lift can be off by some per cent",
                    own.key,
                    rounded(layer),
                    rounded(scales.length / cell)
                ),
                key: own.key,
                time: None,
            });
        }
    }
    found
}

/// Return the warning about the laws of one motion, whose layer wants so many cells, from viscosity (m²/s), cell (m) and
/// end of the run (s).
fn of_motion(key: String, laws: &[&TimeLaw], least: f64, [nu, cell, end]: [f64; 3]) -> Option<Warning> {
    let moving = || laws.iter().filter(|law| law.largest_rate() > 0.0);
    let omega = moving().map(|law| law.largest_acceleration() / law.largest_rate()).fold(0.0, f64::max);
    let layer = (2.0 * nu / omega).sqrt() / cell;
    let resolved = (least * cell).powi(2) / nu;
    let text = if layer < least {
        format!(
            "`{key}` has a Stokes layer of {} cells: with less than {least}, forces can be too small by a quarter; \
             finer cells resolve it",
            rounded(layer)
        )
    } else if resolved > START * end && moving().any(|law| law.starts_at_once(SUDDEN)) {
        format!(
            "`{key}` starts at once: until t = {} s, when the layer at the surface has {least} cells, forces are too \
             small; finer cells shorten this time",
            rounded(resolved)
        )
    } else {
        return None;
    };
    Some(Warning { key, time: None, text })
}
