//! How fluid and rod exchange, and what is chosen where the scene leaves it open.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::check::require;
use crate::{Material, RootSupport, Scene, SceneError, TimeScheme};

/// How fluid and rod exchange; what is left out is chosen by the rules of `docs/theory/coupling.md`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// What the fluid does to the rod; absent: `momentum` where the rod is heavy enough for it and the fluid makes one step
    /// between two exchanges, else `pressure_jump`.
    #[serde(default)]
    pub load: Option<Load>,
    /// How often the two sides are asked within one communication step; absent: `explicit` under the load `momentum`,
    /// `iterated` under `pressure_jump`.
    #[serde(default)]
    pub scheme: Option<CouplingScheme>,
    /// Whether the pressure around the rod strains it along itself, too, beside the load `momentum`, which knows only differences
    /// of the pressure. Its zero is the mean over the outlet, the upstream end of the inflow zone. Needs that load, an inflow and a
    /// material in plane strain; costs the fluid three transforms in each step.
    #[serde(default)]
    pub axial_pressure_strain: bool,
    /// When an explicit run is stopped as unstable; absent: as with `{}` where both units are those of this project, not at all
    /// where one is another's.
    #[serde(default)]
    pub guards: Option<Guards>,
}

/// When a run with the scheme `explicit` or `parallel_explicit` is stopped as unstable, by the powers that cross the interface:
/// what is unstable may well stay finite. A guard of `null` is off. Where the scene has this key the guards are for the units of
/// others too; they need the outputs `load.power` of the rod and, under the load `momentum`, `beam.power` of the fluid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Guards {
    /// Steps over which means of the magnitudes fade, and before which nothing is stopped; at least 1.
    #[schemars(range(min = 1))]
    pub window_steps: u32,
    /// Largest difference of the powers that the rod takes and that the fluid gives under the load `momentum`, relative to the
    /// latter, means of the magnitudes: 0.04 in FSI3, 1 where it blows up. `null`: off.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub largest_imbalance: Option<f64>,
    /// Largest second difference, from step to step, of the power that the rod takes under the load `pressure_jump`, relative to
    /// the power, means of the magnitudes: 4 for a sawtooth, 2.4 for noise, below 0.8 in runs that hold. `null`: off.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub largest_noise: Option<f64>,
    /// Mean power below which noise stops nothing, W per metre of depth: a rod at rest takes nothing but rounding.
    #[schemars(range(min = 0.0))]
    pub min_power: f64,
}

impl Default for Guards {
    fn default() -> Self {
        Self { window_steps: 500, largest_imbalance: Some(0.5), largest_noise: Some(1.5), min_power: 1e-9 }
    }
}

/// What the fluid does to the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// Momentum that the penalization takes from the fluid, with its impedance; the rod then carries only the
    /// difference between its own mass and that of the fluid it displaces.
    Momentum,
    /// Jump of the static pressure across the beam (thesis eq. 4.2); the rod carries its whole mass.
    PressureJump,
}

/// How often the two sides are asked within one communication step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum CouplingScheme {
    /// Once, one after the other: first the rod, then the fluid with the rod's new state (serial, Gauss–Seidel).
    Explicit,
    /// Once, side by side: both step from what was known at the beginning (parallel, Jacobi).
    ParallelExplicit,
    /// Until the interface agrees, with rollback of both units. In no case with the load `momentum`.
    Iterated {
        /// Residual of the interface displacement at which the step is accepted, relative to its change over the step.
        #[serde(default = "default_tolerance")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        tolerance: f64,
        /// Largest number of iterations in a step; more is an error.
        #[serde(default = "default_max_iterations")]
        #[schemars(range(min = 2))]
        max_iterations: u32,
        /// What brings the next guess from the residuals.
        #[serde(default)]
        acceleration: Acceleration,
    },
}

/// What brings the next guess of an iteration from the residuals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Acceleration {
    /// Relaxation by Aitken's formula (Küttler & Wall 2008).
    Aitken,
    /// Interface quasi-Newton with the inverse Jacobian from least squares (Degroote et al. 2009).
    #[default]
    IqnIls,
}

fn default_tolerance() -> f64 {
    1e-4
}

fn default_max_iterations() -> u32 {
    50
}

impl Load {
    /// As scenes write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Momentum => "momentum",
            Self::PressureJump => "pressure_jump",
        }
    }
}

impl Scene {
    /// The load that the rod takes, which the scene gives or leaves to the rule; none where there are not both units.
    pub fn load(&self) -> Option<Load> {
        Some(self.chosen_load()?.0)
    }

    /// As [`Scene::load`], with the reason, as the rest of a sentence. Several rods take the same load: that which suits the
    /// lightest.
    pub fn chosen_load(&self) -> Option<(Load, String)> {
        let Weight { name, own, displaced, free } = self.lightest()?;
        if let Some(load) = self.coupling.as_ref().and_then(|coupling| coupling.load) {
            return Some((load, "the scene says so".into()));
        }
        let fluid = self.fluid.as_ref()?;
        let (ratio, step) = (own / displaced, self.time.communication_step);
        let largest = match fluid.time_stepping.scheme {
            TimeScheme::Sbdf2 => fluid.time_stepping.max_step,
            TimeScheme::Rk2 => fluid.time_stepping.max_step.min(fluid.mask.c_eta()),
        };
        Some(if own < displaced {
            let needed = "the momentum load needs 1 or more";
            (Load::PressureJump, format!("the rod{name} weighs {ratio:.4} of the fluid it displaces; {needed}"))
        } else if own == displaced && free {
            let needed = "a free rod needs more for the momentum load";
            (Load::PressureJump, format!("the rod{name} weighs {ratio:.4} of the fluid it displaces; {needed}"))
        } else if step > largest * (1.0 + STEP_ROUNDING) {
            let held = "the momentum load is not to be held over several of the fluid's";
            let reason = format!("the step of {step} s is above {largest} s, the fluid's largest; {held}");
            (Load::PressureJump, reason)
        } else {
            (Load::Momentum, format!("the rod{name} weighs {ratio:.4} of the fluid it displaces, at least 1"))
        })
    }

    /// Mass of the fluid that the beam displaces at its root, per length and metre of depth, kg/m²: what a rod under
    /// the momentum load must leave out of its own mass, because the fluid inside the mask carries it. 0 where the
    /// load is not that one.
    pub fn displaced_line_density(&self) -> f64 {
        match (self.load(), &self.fluid, &self.beam) {
            (Some(Load::Momentum), Some(fluid), Some(beam)) => fluid.density * beam.thickness.at(0.0),
            _ => 0.0,
        }
    }

    /// Whether the scene wants its rods to follow the level of the pressure.
    pub fn axial_pressure_strain(&self) -> bool {
        self.coupling.as_ref().is_some_and(|coupling| coupling.axial_pressure_strain)
    }

    /// Strain by which the rod shrinks under pressure from all sides, 1/Pa, where the scene wants it to follow the level of
    /// the pressure: no stress but −p in the plane, none of the strain across it, gives (1 + ν)(1 − 2ν)/E.
    pub fn strain_per_pressure(&self) -> Option<f64> {
        let Material::PlaneStrain { youngs_modulus, poisson_ratio, .. } = self.rod.as_ref()?.material else {
            return None;
        };
        self.axial_pressure_strain().then_some((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio) / youngs_modulus)
    }

    /// Whether the level of the pressure can strain the rods, if the scene wants that.
    fn check_pressure_level(&self, load: Load) -> Result<(), SceneError> {
        let mut rods = self.rods_by_name();
        let plane_strain = rods.all(|(_, _, rod)| matches!(rod.material, Material::PlaneStrain { .. }));
        let inflow = self.fluid.as_ref().is_some_and(|fluid| fluid.inflow.is_some());
        for (there, needed) in [
            (load == Load::Momentum, "the load momentum"),
            (plane_strain, "a material in plane_strain, whose Poisson's ratio is known"),
            (inflow, "an inflow, at whose outlet the level is 0"),
        ] {
            let key = "coupling.axial_pressure_strain";
            require(there || !self.axial_pressure_strain(), key, true, || format!("it needs {needed}"))?;
        }
        Ok(())
    }

    /// The rod that is lightest by the fluid that it displaces, where it is so; of equal ones first one that is free.
    fn lightest(&self) -> Option<Weight> {
        let fluid = self.fluid.as_ref()?;
        let weights = self.rods_by_name().flat_map(|(name, beam, rod)| {
            let (material, thickness) = (&rod.material, &beam.thickness);
            beam.places().map(move |s| Weight {
                name: name.map_or(String::new(), |name| format!(" `{name}`")),
                own: material.section(thickness, s).line_density,
                displaced: fluid.density * thickness.at(s),
                free: matches!(rod.root, RootSupport::Free { .. }),
            })
        });
        weights.min_by(|a, b| (a.own / a.displaced).total_cmp(&(b.own / b.displaced)).then(b.free.cmp(&a.free)))
    }

    /// Whether the two sides can exchange like this.
    pub(crate) fn check_coupling(&self) -> Result<(), SceneError> {
        let coupled = self.fluid.is_some() && (self.rod.is_some() || !self.rods.is_empty());
        require(coupled || self.coupling.is_none(), "coupling", "present", || {
            "it may be there only when the scene has both a fluid and a rod".into()
        })?;
        let Some((load, _)) = self.chosen_load() else { return Ok(()) };
        if let (Load::Momentum, Some(Weight { name, own, displaced, free })) = (load, self.lightest()) {
            let ratio = own / displaced;
            require(own >= displaced, "coupling.load", "momentum", || {
                format!(
                    "the rod{name} weighs {ratio:.4} of the fluid it displaces, less than 1; leave the load out or take pressure_jump"
                )
            })?;
            require(own > displaced || !free, "coupling.load", "momentum", || {
                format!(
                    "the free rod{name} weighs {ratio:.4} of the fluid it displaces, which leaves it no mass; leave the load out or take \
                     pressure_jump"
                )
            })?;
        }
        self.check_pressure_level(load)?;
        let scheme = self.coupling.as_ref().and_then(|coupling| coupling.scheme);
        if let Some(CouplingScheme::Iterated { .. }) = scheme {
            require(load == Load::PressureJump, "coupling.scheme", "iterated", || {
                "with the load momentum it must be explicit: that load with its impedance is already implicit".into()
            })?;
        }
        Ok(())
    }
}

/// Mass of a rod at one place and of the fluid it displaces there, per length and metre of depth, kg/m².
struct Weight {
    /// Name of the rod in a sentence, with a space in front; empty of a rod that has none.
    name: String,
    own: f64,
    displaced: f64,
    /// Whether nothing holds the root: without a mass of its own such a rod could not even begin to move.
    free: bool,
}

/// Part by which the communication step may exceed the fluid's largest without being divided, as in the fluid itself.
const STEP_ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    /// FSI3 with some of its text replaced.
    fn fsi3(replaced: &[(&str, &str)]) -> Result<Scene, SceneError> {
        let mut text = include_str!("../../../scenes/fsi3-325x72.json").to_string();
        for (old, new) in replaced {
            assert!(text.contains(old), "{old} is not in the scene");
            text = text.replace(old, new);
        }
        Scene::from_json(&text)
    }

    const GIVEN: &str = r#""coupling": { "load": "momentum", "scheme": "explicit" }"#;
    const OPEN: (&str, &str) = (GIVEN, r#""coupling": {}"#);
    const ROD: &str = r#""plane_strain": { "density": 1000.0"#;

    #[test]
    fn load_follows_from_density_ratio_and_step() {
        let light = (ROD, r#""plane_strain": { "density": 999.0"#);
        let long = (r#""communication_step": 4e-4"#, r#""communication_step": 5e-4"#);
        let rk2 = (r#""max_step": 4e-4"#, r#""max_step": 4e-4, "scheme": "rk2""#);
        for (replaced, load, reason) in [
            (vec![], Load::Momentum, "the scene says so"),
            (vec![OPEN], Load::Momentum, "weighs 1.0000 of the fluid"),
            (vec![OPEN, light], Load::PressureJump, "weighs 0.9990 of the fluid"),
            (vec![OPEN, long], Load::PressureJump, "the step of 0.0005 s is above 0.0004 s"),
            (vec![OPEN, rk2], Load::PressureJump, "the step of 0.0004 s is above 0.000001 s"),
        ] {
            let (found, why) = fsi3(&replaced).unwrap().chosen_load().unwrap();
            assert_eq!(found, load, "{replaced:?}: {why}");
            assert!(why.contains(reason), "{why}");
        }
    }

    #[test]
    fn coupling_may_be_left_out_altogether() {
        let scene = fsi3(&[(&format!(",\n  {GIVEN}"), "")]).unwrap();
        assert_eq!((scene.load(), scene.displaced_line_density()), (Some(Load::Momentum), 20.0));
    }

    #[test]
    fn momentum_load_on_a_light_rod_is_refused() {
        let error = fsi3(&[(ROD, r#""plane_strain": { "density": 990.0"#)]).unwrap_err().to_string();
        assert!(error.contains("`coupling.load` is momentum") && error.contains("weighs 0.9900"), "{error}");
    }

    #[test]
    fn level_of_the_pressure_needs_what_it_is_made_of() {
        let (given, wanted) = (GIVEN, r#""coupling": { "axial_pressure_strain": true }"#);
        assert_eq!(fsi3(&[]).unwrap().strain_per_pressure(), None);
        let strain = fsi3(&[(given, wanted)]).unwrap().strain_per_pressure().unwrap();
        assert!((strain / (1.4 * 0.2 / 5.6e6) - 1.0).abs() < 1e-14, "{strain}");
        let section = r#""section": { "line_density": 20.0, "bending_stiffness": 4.0, "axial_stiffness": 1e5 }"#;
        let material = r#""plane_strain": { "density": 1000.0, "youngs_modulus": 5.6e6, "poisson_ratio": 0.4, "shear_factor": 0.862 }"#;
        for (replaced, reason) in [
            (vec![(given, wanted), (ROD, r#""plane_strain": { "density": 900.0"#)], "it needs the load momentum"),
            (vec![(given, wanted), (material, section)], "it needs a material in plane_strain"),
            (vec![(given, wanted), (r#""inflow": {"#, r#""sponge": {"#)], "it needs an inflow"),
        ] {
            let error = fsi3(&replaced).unwrap_err().to_string();
            assert!(error.contains("`coupling.axial_pressure_strain` is true") && error.contains(reason), "{error}");
        }
    }

    #[test]
    fn guards_have_defaults_and_each_can_be_off() {
        let guards = |text: &str| {
            let coupling = format!(r#""coupling": {{ "load": "momentum", "guards": {text} }}"#);
            fsi3(&[(GIVEN, &coupling)]).map(|scene| scene.coupling.unwrap().guards.unwrap())
        };
        let whole =
            Guards { window_steps: 500, largest_imbalance: Some(0.5), largest_noise: Some(1.5), min_power: 1e-9 };
        assert_eq!(guards("{}").unwrap(), whole);
        let off = guards(r#"{ "largest_imbalance": null }"#).unwrap();
        assert_eq!(off, Guards { largest_imbalance: None, ..whole });
        for (wrong, expected) in [
            (
                r#"{ "window_steps": 0 }"#,
                "`coupling.guards.window_steps` is 0, but it must be a whole number of at least 1",
            ),
            (r#"{ "largest_imbalance": 0.0 }"#, "`coupling.guards.largest_imbalance` is 0.0, but it must be"),
            (
                r#"{ "largest_noise": -1.5 }"#,
                "`coupling.guards.largest_noise` is -1.5, but it must be a number above 0, or null",
            ),
            (
                r#"{ "min_power": -1e-9 }"#,
                "`coupling.guards.min_power` is -1e-9, but it must be a number of at least 0",
            ),
        ] {
            let refused = guards(wrong).unwrap_err().to_string();
            assert!(refused.contains(expected), "{refused}, but expected {expected}");
        }
    }

    #[test]
    fn iteration_has_defaults() {
        let iterated = (GIVEN, r#""coupling": { "load": "pressure_jump", "scheme": { "iterated": {} } }"#);
        let acceleration = Acceleration::IqnIls;
        let expected = CouplingScheme::Iterated { tolerance: 1e-4, max_iterations: 50, acceleration };
        assert_eq!(fsi3(&[iterated]).unwrap().coupling.unwrap().scheme, Some(expected));
    }
}
