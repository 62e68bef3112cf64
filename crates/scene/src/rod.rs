//! The elastic model of the beam.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::{Check, require};
use crate::{SceneError, Spanwise, TimeLaw};

/// Elastic model of the beam.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rod {
    /// Material, or the section's own numbers.
    pub material: Material,
    /// Gravity, m/s²: as many components as the beam's root; absent where there is none.
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
    /// How the section's numbers become springs and masses.
    #[serde(default)]
    pub calibration: Calibration,
    /// Length by which the clamp lies behind the root, m: the elastic part of the foundation. It only softens the clamp.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub clamp_compliance_length: f64,
    /// How the root is held.
    #[serde(default)]
    pub root: RootSupport,
    /// Prescribed motion of the root; absent where it is still, and where the root is free.
    #[serde(default)]
    pub root_motion: Option<RootMotion>,
    /// Time scheme.
    #[serde(default)]
    pub scheme: RodScheme,
    /// Largest step of the rod's own inside a communication step, s; absent: the communication step.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_step: Option<f64>,
}

/// What the rod is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Material {
    /// A plate of the beam's thickness in plane strain, one metre deep: at every place EI = E h³ / (12 (1 − ν²)), EA = E h / (1 − ν²).
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
        /// Shear correction factor k of GA_s = k E h / (2 (1 + ν)), above 0 and at most 1; 10/(12 − ν) for a plate (Cowper 1966). Absent: the
        /// section stays at right angles to the rod.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
        shear_factor: Option<f64>,
    },
    /// The section's own numbers (per metre of depth in a two-dimensional scene).
    Section(SectionProfile),
}

/// Mass and stiffness of the section (per metre of depth in a two-dimensional scene), each a number or a law of the place along
/// the beam.
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
    /// Shear stiffness GA_s, N, of a rod in the plane with invariant bending; absent: the section stays at right angles to the rod.
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
    /// Shear stiffness GA_s, N; none where the section stays at right angles to the rod.
    pub shear_stiffness: Option<f64>,
}

/// What bending energy depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Bending {
    /// The true turning angle ψ between neighbouring segments, by 2 tan(ψ/2) (Bergou et al. 2008): the same in every
    /// frame.
    #[default]
    Invariant,
    /// Angles of the segments' projections into the planes xy and xz (thesis eqs. 2.1 and 2.4): depends on the frame and
    /// is singular where a projection vanishes, which is an error.
    Projected,
}

/// How the section's numbers become springs and masses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Calibration {
    /// k_e = EA/l0, clamp spring EI/(l0/2), half a segment's mass at the tip: of second order in the segments' length l0.
    #[default]
    SecondOrder,
    /// That of the thesis, section 2.4.1: the same k_e for every segment whatever its length, clamp spring EI/l0, a whole
    /// segment's mass at every node. Of first order.
    Thesis {
        /// Axial stiffness of a segment, N/m; takes the place of EA.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        k_e: f64,
    },
}

/// How the root of a rod is held.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RootSupport {
    /// It neither moves nor turns by itself.
    #[default]
    Clamped,
    /// It does not move by itself, and turns without resistance.
    Pinned,
    /// It does not move by itself, and turns against a torsion spring with the moment `stiffness (angle − rest_angle) + damping rate`,
    /// the angle being that from the direction of the beam, between −π and π.
    TorsionSpring {
        /// Stiffness of the spring, N m/rad.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        stiffness: f64,
        /// Damping, N m s/rad; in the plane only.
        #[serde(default)]
        #[schemars(range(min = 0.0))]
        damping: f64,
        /// Angle at which the spring is at rest, rad, positive to the left; in the plane only. The rod begins along the beam's direction
        /// all the same.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = -PI, "exclusiveMaximum" = PI))]
        rest_angle: f64,
    },
    /// It moves and turns as the loads, gravity and a force that tows it will.
    Free {
        /// Towing force along x, N.
        #[serde(default)]
        force_x: TimeLaw,
        /// Towing force along y, N.
        #[serde(default)]
        force_y: TimeLaw,
        /// Towing force along z, N; in three dimensions only.
        #[serde(default)]
        force_z: TimeLaw,
    },
}

/// Prescribed motion of the root.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RootMotion {
    /// The master sets the root's position, direction and their rates at the end of each of its steps.
    Master,
    /// Laws of time.
    Laws(RootLaws),
}

/// Motion of the root from its place at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RootLaws {
    /// Displacement along x, m.
    #[serde(default)]
    pub x: TimeLaw,
    /// Displacement along y, m.
    #[serde(default)]
    pub y: TimeLaw,
    /// Displacement along z, m; in three dimensions only.
    #[serde(default)]
    pub z: TimeLaw,
    /// Rotations of the beam's direction, the first one applied first.
    #[serde(default)]
    pub rotations: Vec<Rotation>,
}

/// Rotation about a fixed axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotation {
    /// Angle, rad.
    pub angle: TimeLaw,
    /// Axis, of any length but 0; in two dimensions there is only z.
    #[serde(default = "z_axis")]
    pub axis: [f64; 3],
}

/// Axis of rotations in two dimensions.
pub(crate) const Z_AXIS: [f64; 3] = [0.0, 0.0, 1.0];

fn z_axis() -> [f64; 3] {
    Z_AXIS
}

impl RootSupport {
    /// Force that tows a free root at time `t` (s), N.
    pub fn towing_force(&self, t: f64) -> Option<[f64; 3]> {
        let Self::Free { force_x, force_y, force_z } = self else { return None };
        Some([force_x, force_y, force_z].map(|law| law.value(t)))
    }
}

impl RootLaws {
    /// Displacement, m, and velocity, m/s, at time `t` (s).
    pub fn displacement(&self, t: f64) -> ([f64; 3], [f64; 3]) {
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|law| law.value_and_rate(t));
        ([x.0, y.0, z.0], [x.1, y.1, z.1])
    }

    /// What `direction` at rest is at time `t` (s), and its rate, 1/s.
    pub fn direction(&self, t: f64, direction: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        self.rotations.iter().fold((direction, [0.0; 3]), |(direction, rate), rotation| {
            let norm = rotation.axis.iter().map(|c| c * c).sum::<f64>().sqrt();
            let axis = rotation.axis.map(|c| c / norm);
            let (angle, omega) = rotation.angle.value_and_rate(t);
            let turned = rotate(axis, angle, direction);
            let (carried, turning) = (rotate(axis, angle, rate), cross(axis, turned));
            (turned, std::array::from_fn(|d| carried[d] + omega * turning[d]))
        })
    }
}

/// `v` turned by `angle` about the unit vector `axis` (Rodrigues).
fn rotate(axis: [f64; 3], angle: f64, v: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = angle.sin_cos();
    let across = cross(axis, v);
    let along: f64 = axis.iter().zip(v).map(|(a, v)| a * v).sum();
    std::array::from_fn(|d| cos * v[d] + sin * across[d] + (1.0 - cos) * along * axis[d])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
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
        #[schemars(range(min = 0.0, max = 1.0))]
        rho_inf: f64,
    },
    /// Trapezoid to 2 − √2 of the step, then two-step backward differences over the rest (Bank et al. 1985; Hosea &
    /// Shampine 1996): as dissipative where it must be, least where it need not, two solves a step.
    #[default]
    TrBdf2,
    /// Two-step backward differences: dissipative, and the same formula as the fluid's, so that a coupled step is consistent.
    Bdf2,
}

impl Material {
    /// Whether a law gives one of the section's numbers.
    pub fn varies(&self) -> bool {
        let Self::Section(section) = self else { return false };
        let SectionProfile { line_density, bending_stiffness, axial_stiffness, shear_stiffness } = section;
        [line_density, bending_stiffness, axial_stiffness].into_iter().chain(shear_stiffness).any(Spanwise::varies)
    }

    /// Mass and stiffness of the section at the place `s` (0 at the root, 1 at the tip) of a beam of this thickness (m).
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
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        if let Material::Section(section) = &self.material {
            section.check_at(&format!("{key}.material.section"))?;
        }
        if let RootSupport::Free { force_x, force_y, force_z } = &self.root {
            for (name, law) in [("force_x", force_x), ("force_y", force_y), ("force_z", force_z)] {
                law.check_at(&format!("{key}.root.free.{name}"))?;
            }
        }
        match &self.root_motion {
            Some(RootMotion::Laws(laws)) => laws.check_at(&format!("{key}.root_motion.laws")),
            _ => Ok(()),
        }
    }
}

impl Check for SectionProfile {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        for (name, law) in [
            ("line_density", &self.line_density),
            ("bending_stiffness", &self.bending_stiffness),
            ("axial_stiffness", &self.axial_stiffness),
        ] {
            law.check_at(&format!("{key}.{name}"))?;
        }
        self.shear_stiffness.check_at(&format!("{key}.shear_stiffness"))
    }
}

impl Check for RootLaws {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        for (name, law) in [("x", &self.x), ("y", &self.y), ("z", &self.z)] {
            law.check_at(&format!("{key}.{name}"))?;
        }
        self.rotations.check_at(&format!("{key}.rotations"))
    }
}

impl Check for Rotation {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        self.angle.check_at(&format!("{key}.angle"))?;
        let points = self.axis.iter().any(|&c| c != 0.0);
        require(points, &format!("{key}.axis"), format!("{:?}", self.axis), || "it must be 3 numbers, not all 0".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_of_the_direction_is_its_derivative() {
        let sine = |frequency| TimeLaw::Sine { mean: 0.2, amplitude: 0.9, frequency, phase: 0.3, ramp: 0.4 };
        let laws = RootLaws {
            rotations: vec![
                Rotation { angle: sine(1.0), axis: [0.0, 0.0, 2.0] },
                Rotation { angle: sine(1.7), axis: [1.0, 1.0, -0.5] },
            ],
            ..RootLaws::default()
        };
        let (rest, step) = ([0.6, 0.0, 0.8], 1e-5);
        for t in [0.1, 0.3, 1.2] {
            let (direction, rate) = laws.direction(t, rest);
            let norm = direction.iter().map(|c| c * c).sum::<f64>();
            assert!((norm - 1.0).abs() < 1e-14, "t = {t}: squared length {norm}");
            let (after, before) = (laws.direction(t + step, rest).0, laws.direction(t - step, rest).0);
            for d in 0..3 {
                let difference = (after[d] - before[d]) / (2.0 * step);
                assert!((rate[d] - difference).abs() < 1e-7, "t = {t}, {d}: {} against {difference}", rate[d]);
            }
        }
    }
}
