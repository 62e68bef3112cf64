//! Conversion of a scene to the parameters and loads of a rod.

use rod::{Loads, Parameters, RootSupport, Slide, Taper};
use scene::{Beam, Load, Material, Scene, Surface};

/// Return the parameters of the rod of a scene, without contact.
pub fn parameters<const D: usize>(scene: &Scene, beam: &Beam, rod: &scene::Rod) -> Parameters<D> {
    let (attachment, direction) = scene.beam_root(beam);
    let displaced = scene.displaced_line_density(beam, rod);
    Parameters {
        attachment: std::array::from_fn(|d| attachment[d]),
        direction: std::array::from_fn(|d| direction[d]),
        length: beam.length,
        segments: beam.segments,
        rest_angles: beam.rest_angles.clone(),
        section: rod.material.section(&beam.thickness, 0.0),
        displaced: displaced[0],
        displaced_weighs: beam.surface == Surface::Line || scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space()),
        buoyant: scene.buoyant_line_density(beam),
        taper: taper(beam, &rod.material, &displaced),
        strain_per_pressure: scene.strain_per_pressure().unwrap_or(0.0),
        gravity: std::array::from_fn(|d| rod.gravity.get(d).copied().unwrap_or(0.0)),
        damping: rod.damping,
        bending: rod.bending,
        calibration: rod.calibration,
        support: match rod.root {
            scene::RootSupport::Clamped => RootSupport::Clamped,
            scene::RootSupport::Pinned => RootSupport::Pinned,
            scene::RootSupport::TorsionSpring { stiffness, damping, rest_angle } => {
                RootSupport::TorsionSpring { stiffness, damping, rest_angle }
            }
            scene::RootSupport::Free { .. } => RootSupport::Free,
        },
        slide: rod.slide.as_ref().map(|slide| Slide { axis: slide.along as usize, mass: slide.mass }),
        clamp_compliance_length: rod.clamp_compliance_length,
        contact: None,
        scheme: rod.scheme,
        max_step: Some(rod.max_step.unwrap_or(scene.time.communication_step)),
    }
}

/// Return the profiles of section and thickness along the beam; the profile of a constant is empty.
fn taper(beam: &Beam, material: &Material, displaced: &[f64]) -> Taper {
    let relative = |values: &[f64]| match values[0] {
        root if values.iter().all(|&value| value == root) => Vec::new(),
        root => values.iter().map(|value| value / root).collect(),
    };
    let along = |value: &dyn Fn(f64) -> f64| relative(&beam.places().map(value).collect::<Vec<_>>());
    let section = |s: f64| material.section(&beam.thickness, s);
    Taper {
        line_density: along(&|s| section(s).line_density),
        displaced: relative(displaced),
        bending_stiffness: along(&|s| section(s).bending_stiffness),
        axial_stiffness: along(&|s| section(s).axial_stiffness),
        shear_stiffness: along(&|s| section(s).shear_stiffness.unwrap_or(1.0)),
    }
}

/// Return the loads of a scene, with the value 0 and the lengths of their arrays.
pub fn loads(scene: &Scene, dimension: usize, nodes: usize) -> Loads {
    let zeros = |count: usize| vec![0.0; count];
    match scene.load() {
        None => {
            let pressure_jump = zeros(if dimension == 2 { nodes } else { 0 });
            Loads { force: zeros(dimension * nodes), pressure_jump, ..Loads::default() }
        }
        Some(Load::Momentum) => {
            let pressure = zeros(if scene.strain_per_pressure().unwrap_or(0.0) > 0.0 { nodes } else { 0 });
            Loads { force: zeros(dimension * nodes), impedance: zeros(nodes), pressure, ..Loads::default() }
        }
        Some(Load::PressureJump) => Loads { pressure_jump: zeros(nodes), ..Loads::default() },
    }
}

#[cfg(test)]
#[path = "from_scene/tests.rs"] // the study of the rod includes this file by its path
mod tests;
