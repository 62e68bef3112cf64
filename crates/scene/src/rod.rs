//! The elastic model of the beam.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SceneError;
use crate::check::{Check, above, at_least, finite, require};

/// Elastic model of the beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// Material, or the section's own numbers.
    pub material: Material,
    /// Gravity, m/s²: as many components as the beam's root; absent where there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gravity: Vec<f64>,
    /// Damping force per length and velocity, kg/(m s) per metre of depth.
    #[serde(default)]
    pub damping: f64,
    /// Time scheme.
    #[serde(default)]
    pub scheme: RodScheme,
    /// Largest step of the rod's own inside a communication step, s; absent: the communication step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_step: Option<f64>,
}

/// What the rod is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Material {
    /// A plate of the beam's thickness in plane strain, one metre deep: EI = E h³ / (12 (1 − ν²)), EA = E h / (1 − ν²).
    PlaneStrain {
        /// Density, kg/m³.
        density: f64,
        /// Young's modulus E, Pa.
        youngs_modulus: f64,
        /// Poisson's ratio ν.
        poisson_ratio: f64,
    },
    /// The section's own numbers (per metre of depth in a two-dimensional scene).
    Section(Section),
}

/// Mass and stiffness of a section (per metre of depth in a two-dimensional scene).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Mass per length, kg/m.
    pub line_density: f64,
    /// Bending stiffness EI, N m².
    pub bending_stiffness: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
}

/// Time scheme of the rod; all are of second order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RodScheme {
    /// The trapezoidal rule of the thesis (eq. 2.7); no numerical dissipation, not safe for stiff axial modes.
    Trapezoid,
    /// Generalised-α (Chung & Hulbert 1993).
    GeneralisedAlpha {
        /// Spectral radius at infinite frequency, 0 … 1.
        rho_inf: f64,
    },
    /// Two-step backward differences: dissipative, and the same formula as the fluid's, so that a coupled step is consistent.
    #[default]
    Bdf2,
}

impl Material {
    /// Mass and stiffness of the section of a beam of the given thickness (m).
    pub fn section(&self, thickness: f64) -> Section {
        match *self {
            Self::Section(section) => section,
            Self::PlaneStrain { density, youngs_modulus, poisson_ratio } => {
                let plane_strain_modulus = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
                Section {
                    line_density: density * thickness,
                    bending_stiffness: plane_strain_modulus * thickness.powi(3) / 12.0,
                    axial_stiffness: plane_strain_modulus * thickness,
                }
            }
        }
    }
}

impl Check for Rod {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        self.material.check_at(&format!("{key}.material"))?;
        for (d, g) in self.gravity.iter().enumerate() {
            finite(&format!("{key}.gravity[{d}]"), *g)?;
        }
        at_least(&format!("{key}.damping"), self.damping, 0.0)?;
        if let RodScheme::GeneralisedAlpha { rho_inf } = self.scheme {
            require(
                (0.0..=1.0).contains(&rho_inf),
                &format!("{key}.scheme.generalised_alpha.rho_inf"),
                rho_inf,
                || "it must be between 0 and 1".into(),
            )?;
        }
        self.max_step.map_or(Ok(()), |step| above(&format!("{key}.max_step"), step, 0.0))
    }
}

impl Check for Material {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        match self {
            Self::PlaneStrain { density, youngs_modulus, poisson_ratio } => {
                above(&format!("{key}.plane_strain.density"), *density, 0.0)?;
                above(&format!("{key}.plane_strain.youngs_modulus"), *youngs_modulus, 0.0)?;
                require(
                    *poisson_ratio > -1.0 && *poisson_ratio < 0.5,
                    &format!("{key}.plane_strain.poisson_ratio"),
                    poisson_ratio,
                    || "it must be above -1 and below 0.5".into(),
                )
            }
            Self::Section(section) => {
                above(&format!("{key}.section.line_density"), section.line_density, 0.0)?;
                above(&format!("{key}.section.bending_stiffness"), section.bending_stiffness, 0.0)?;
                above(&format!("{key}.section.axial_stiffness"), section.axial_stiffness, 0.0)
            }
        }
    }
}
