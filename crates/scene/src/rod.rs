//! The elastic model of a beam.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fault::{Check, Faults};
use crate::root::{RootMotion, RootSupport, Slide};
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
    pub scheme: RodScheme,
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

/// Mass and stiffness of a section at one place (per metre of depth in a two-dimensional scene).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Mass per length, kg/m.
    pub line_density: f64,
    /// Bending stiffness EI, N m².
    pub bending_stiffness: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Shear stiffness GA_s, N; none where the section stays normal to the rod.
    pub shear_stiffness: Option<f64>,
}

/// Angle on which the bending energy depends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Bending {
    /// Turning angle ψ between neighbouring segments, by 2 tan(ψ/2) (Bergou et al. 2008): the same in every frame.
    #[default]
    Invariant,
    /// Angles of the segments' projections into the planes xy and xz (thesis eqs. 2.1 and 2.4): depends on the frame
    /// and is singular where a projection vanishes, which is an error.
    Projected,
}

/// Calibration of the springs and masses of a discrete rod by the section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Calibration {
    /// k_e = EA/l0, clamp spring EI/(l0/2), half a segment's mass at the tip: of second order in the length l0 of a
    /// segment.
    #[default]
    SecondOrder,
    /// Thesis, section 2.4.1: one k_e for segments of any length, clamp spring EI/l0, a whole segment's mass at every
    /// node. Of first order.
    Thesis {
        /// Axial stiffness of a segment, N/m, in place of EA.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        k_e: f64,
    },
}

/// Time scheme of the rod; all are of second order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RodScheme {
    /// Trapezoidal rule (thesis eq. 2.7), without numerical dissipation; unsafe for stiff axial modes.
    Trapezoid,
    /// Generalised-α (Chung & Hulbert 1993).
    GeneralisedAlpha {
        /// Spectral radius at infinite frequency, 0 … 1.
        #[schemars(range(min = 0.0, max = 1.0))]
        rho_inf: f64,
    },
    /// Trapezoidal rule to 2 − √2 of the step, then two-step backward differences (Bank et al. 1985; Hosea & Shampine
    /// 1996): damps stiff modes fully and resolved ones least, with two solves per step.
    #[default]
    TrBdf2,
    /// Two-step backward differences: dissipative, and consistent with the same scheme of the fluid.
    Bdf2,
}

impl Material {
    /// Whether a number of the section has a profile.
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

impl Check for Rod {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        if let Material::Section(section) = &self.material {
            section.check_at(&format!("{key}.material.section"), faults);
        }
        self.root.check_at(&format!("{key}.root"), faults);
        if let Some(RootMotion::Laws(laws)) = &self.root_motion {
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
