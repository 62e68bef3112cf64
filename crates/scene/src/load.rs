//! The load of the fluid on the rods: the choice where a scene leaves it open, and the quantities that follow from it.

use method::{Surface, TimeScheme};

use crate::beam::Beam;
use crate::coupling::Load;
use crate::rod::{Material, Rod};
use crate::root::RootSupport;
use crate::scene::Scene;

impl Scene {
    /// Return whether its rods and wings, at least two, have no fluid, and their contact couples them.
    pub fn is_coupled_by_contact(&self) -> bool {
        let rods = self.beams_with_rods().filter(|own| own.rod.is_some()).count();
        self.fluid.is_none() && self.contact.is_some() && rods + self.wings().count() > 1
    }

    /// Return the load on the rods, given or chosen; none without a rod and what couples it.
    pub fn load(&self) -> Option<Load> {
        Some(self.chosen_load()?.0)
    }

    /// Return the load as [`Scene::load`] does, and the reason as a clause. Several rods have the same load, the one
    /// that suits the lightest.
    pub fn chosen_load(&self) -> Option<(Load, String)> {
        if self.fluid.is_none() {
            // The unit of one of several rods knows their load, but not the other ones.
            let given = self.coupling.as_ref().and_then(|coupling| coupling.load);
            let is_coupled = given.is_some() || self.is_coupled_by_contact();
            return is_coupled.then(|| (Load::Momentum, "contact gives forces with an impedance".into()));
        }
        let Weight { name, own, displaced, free, line } = self.lightest()?;
        if let Some(load) = self.coupling.as_ref().and_then(|coupling| coupling.load) {
            return Some((load, "the scene says so".into()));
        }
        let fluid = self.fluid.as_ref()?;
        let (ratio, step) = (own / displaced, self.time.communication_step);
        let largest = match fluid.time_stepping.scheme {
            TimeScheme::Sbdf2 => fluid.time_stepping.max_step,
            TimeScheme::Rk2 => fluid.time_stepping.max_step.min(fluid.mask.c_eta()),
        };
        let momentum = if line {
            format!("the fluid meets the rod{name} as a line, which suits any mass")
        } else {
            format!("the rod{name} weighs {ratio:.4} of the fluid it displaces, at least 1")
        };
        Some(if own < displaced {
            let needed = "the momentum load needs 1 or more";
            (Load::PressureJump, format!("the rod{name} weighs {ratio:.4} of the fluid it displaces; {needed}"))
        } else if own == displaced && free && !line {
            let needed = "a free rod needs more for the momentum load";
            (Load::PressureJump, format!("the rod{name} weighs {ratio:.4} of the fluid it displaces; {needed}"))
        } else if step > largest * (1.0 + STEP_ROUNDING) && !fluid.is_space() {
            let held = "the momentum load cannot be held over several steps of the fluid";
            let reason = format!("the step of {step} s is above {largest} s, the largest of the fluid; {held}");
            (Load::PressureJump, reason)
        } else {
            (Load::Momentum, momentum)
        })
    }

    /// Return the mass of the fluid that moves with a beam at its places, per length and metre of depth, kg/m²: `[2
    /// segments + 1]`; 0 without the momentum load. With that load the rod's own mass is reduced by it, because the
    /// fluid inside the mask or on the line has it.
    pub fn displaced_line_density(&self, beam: &Beam, rod: &Rod) -> Vec<f64> {
        match (self.load(), &self.fluid) {
            (Some(Load::Momentum), Some(fluid)) => beam.places().map(self.displaced(fluid, beam, rod)).collect(),
            _ => vec![0.0; 2 * beam.segments + 1],
        }
    }

    /// Return the mass of the fluid inside the mask at the places of a beam, as above, where it carries the rod by its
    /// weight but is not in the load: with the pressure jump. Empty elsewhere; a line displaces nothing.
    pub fn buoyant_line_density(&self, beam: &Beam) -> Vec<f64> {
        match (self.load(), &self.fluid, beam.surface) {
            (Some(Load::PressureJump), Some(fluid), Surface::Mask) => {
                beam.places().map(|s| fluid.density * beam.thickness.at(s)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Return whether the pressure around the rods strains them along their axis.
    pub fn axial_pressure_strain(&self) -> bool {
        self.coupling.as_ref().is_some_and(|coupling| coupling.axial_pressure_strain)
    }

    /// Return the strain by which the rod shrinks under pressure, 1/Pa; none without `axial_pressure_strain`. A stress
    /// of −p in the plane and no strain across it give (1 + ν)(1 − 2ν)/E.
    pub fn strain_per_pressure(&self) -> Option<f64> {
        let Material::PlaneStrain { youngs_modulus, poisson_ratio, .. } = self.rod.as_ref()?.material else {
            return None;
        };
        self.axial_pressure_strain().then_some((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio) / youngs_modulus)
    }

    /// Return the rod and place of least mass relative to the displaced fluid; of equal ones a free rod.
    pub(crate) fn lightest(&self) -> Option<Weight> {
        let fluid = self.fluid.as_ref()?;
        let rods = self.beams_with_rods().filter_map(|own| Some((own.in_sentence(), own.beam, own.rod?)));
        let weights = rods.flat_map(|(name, beam, rod)| {
            let (material, thickness) = (&rod.material, &beam.thickness);
            let (line, displaced) = (beam.surface == Surface::Line, self.displaced(fluid, beam, rod));
            beam.places().map(move |s| Weight {
                name: name.clone(),
                own: material.section(thickness, s).line_density,
                displaced: displaced(s),
                line,
                free: matches!(rod.root, RootSupport::Free { .. }) || rod.slide.is_some(),
            })
        });
        let ratio = |weight: &Weight| weight.own / weight.displaced;
        // A mask may need another load, a line does not.
        let heavier = |a: &Weight, b: &Weight| a.line.cmp(&b.line).then(ratio(a).total_cmp(&ratio(b)));
        weights.min_by(|a, b| heavier(a, b).then(b.free.cmp(&a.free)))
    }
}

/// Mass of a rod at one place and of the fluid it displaces there, per length and metre of depth, kg/m².
pub(crate) struct Weight {
    /// Name of the rod in a sentence, with a space in front; empty for the only rod.
    pub name: String,
    pub own: f64,
    pub displaced: f64,
    /// Whether the root is free: such a rod cannot move without a mass of its own if it has a mask.
    pub free: bool,
    /// Whether the fluid meets it as a line.
    pub line: bool,
}

/// Relative part by which the communication step may exceed the fluid's largest without being divided.
const STEP_ROUNDING: f64 = 1e-9;
