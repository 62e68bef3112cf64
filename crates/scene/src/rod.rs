//! The elastic model of a beam.

use method::{Bending, Calibration, Scheme, Section, Slide};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::root::{RootLaws, RootMotion, RootSupport};
use crate::spanwise::Spanwise;

/// Elastic model of the beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// Material, or mass and stiffness of the section.
    pub material: Material,
    /// Gravity, m/s², with as many components as the beam's root; absent without gravity.
    #[serde(default)]
    #[schemars(length(max = 3))]
    pub gravity: Vec<f64>,
    /// Damping force per length and velocity, kg/(m s) per metre of depth.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub damping: f64,
    /// Bending model.
    #[serde(default)]
    pub bending: Bending,
    /// Calibration of springs and masses.
    #[serde(default)]
    pub calibration: Calibration,
    /// Length of beam, m, whose bending compliance is added to that of the clamp, for an elastic foundation.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub clamp_compliance_length: f64,
    /// Support of the root.
    #[serde(default)]
    pub root: RootSupport,
    /// Guide along which the root moves freely, as a swimmer does; absent: `root` holds it in all directions.
    #[serde(default)]
    pub slide: Option<Slide>,
    /// Prescribed motion of the root; absent for a still or a free root.
    #[serde(default)]
    pub root_motion: Option<RootMotion>,
    /// Time scheme.
    #[serde(default)]
    pub scheme: Scheme,
    /// Largest step of the rod inside a communication step, s; absent: the communication step.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_step: Option<f64>,
}

/// Material of a rod, or mass and stiffness of its section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Material {
    /// A plate of the beam's thickness h in plane strain, one metre deep: EI = E h³ / (12 (1 − ν²)), EA = E h / (1 −
    /// ν²).
    PlaneStrain {
        /// Density, kg/m³.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        density: f64,
        /// Young's modulus E, Pa.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        youngs_modulus: f64,
        /// Poisson's ratio ν.
        #[schemars(extend("exclusiveMinimum" = -1.0, "exclusiveMaximum" = 0.5))]
        poisson_ratio: f64,
        /// Shear correction factor k of GA_s = k E h / (2 (1 + ν)), > 0 and <= 1; 10/(12 − ν) for a plate (Cowper
        /// 1966). Absent: the section stays normal to the rod.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
        shear_factor: Option<f64>,
    },
    /// Mass and stiffness of the section (per metre of depth in a two-dimensional scene).
    Section(SectionProfile),
}

/// Mass and stiffness of the section (per metre of depth in a two-dimensional scene), each a number or a profile along
/// the span.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Section")]
pub struct SectionProfile {
    /// Mass per length, kg/m.
    pub line_density: Spanwise,
    /// Bending stiffness EI, N m².
    pub bending_stiffness: Spanwise,
    /// Axial stiffness EA, N.
    pub axial_stiffness: Spanwise,
    /// Shear stiffness GA_s, N, of a rod in the plane with invariant bending; absent: the section stays normal to the
    /// rod.
    #[serde(default)]
    pub shear_stiffness: Option<Spanwise>,
}

impl Material {
    /// Return whether a number of the section has a profile.
    pub fn varies(&self) -> bool {
        let Self::Section(section) = self else { return false };
        let SectionProfile { line_density, bending_stiffness, axial_stiffness, shear_stiffness } = section;
        [line_density, bending_stiffness, axial_stiffness].into_iter().chain(shear_stiffness).any(Spanwise::varies)
    }

    /// Return mass and stiffness of the section at the place `s` (0 at the root, 1 at the tip) of a beam of `thickness`
    /// (m).
    pub fn section(&self, thickness: &Spanwise, s: f64) -> Section {
        match *self {
            Self::Section(ref section) => Section {
                line_density: section.line_density.at(s),
                bending_stiffness: section.bending_stiffness.at(s),
                axial_stiffness: section.axial_stiffness.at(s),
                shear_stiffness: section.shear_stiffness.as_ref().map(|shear| shear.at(s)),
            },
            Self::PlaneStrain { density, youngs_modulus, poisson_ratio, shear_factor } => {
                let thickness = thickness.at(s);
                let shear_modulus = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
                let plane_strain_modulus = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
                Section {
                    line_density: density * thickness,
                    bending_stiffness: plane_strain_modulus * thickness.powi(3) / 12.0,
                    axial_stiffness: plane_strain_modulus * thickness,
                    shear_stiffness: shear_factor.map(|factor| factor * shear_modulus * thickness),
                }
            }
        }
    }
}

impl Rod {
    /// Return the laws of the root's motion, where laws move it.
    pub(crate) fn laws(&self) -> Option<&RootLaws> {
        if let Some(RootMotion::Laws(laws)) = &self.root_motion { Some(laws) } else { None }
    }
}

impl Check for Rod {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        if let Material::Section(section) = &self.material {
            section.check_at(&format!("{key}.material.section"), faults);
        }
        self.root.check_at(&format!("{key}.root"), faults);
        if let Some(laws) = self.laws() {
            laws.check_at(&format!("{key}.root_motion.laws"), faults);
        }
    }
}

impl Check for SectionProfile {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        for (name, quantity) in [
            ("line_density", &self.line_density),
            ("bending_stiffness", &self.bending_stiffness),
            ("axial_stiffness", &self.axial_stiffness),
        ] {
            quantity.check_at(&format!("{key}.{name}"), faults);
        }
        self.shear_stiffness.check_at(&format!("{key}.shear_stiffness"), faults);
    }
}
