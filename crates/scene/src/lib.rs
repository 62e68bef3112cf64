//! Scene files: what is in the box, as data.
//!
//! A scene is one JSON file that both units carry in their `resources/`. It names the parts that exist; an absent
//! part costs no memory, no time and no variable. The JSON Schema (`modelDescription/scene.schema.json`) is made
//! from these very types, and [`Scene::from_json`] refuses what the solvers could not run, naming the key, the value
//! and what is allowed.
//!
//! Everything is in SI units; a two-dimensional scene is one metre deep.

mod beam;
mod body;
mod check;
mod coupling;
mod fluid;
mod law;
mod reference;
mod rod;
mod rods;
mod schema;
mod spanwise;
mod text;

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use beam::{Beam, Root};
pub use body::{Body, BodyMotion, Ends, Shape};
pub use coupling::{Acceleration, Coupling, CouplingScheme, Guards, Load};
pub use fluid::{
    Channel, Cylinder, Filter, Fluid, FluidBox, Inflow, InflowProfile, Mask, MeanFlow, Motion, Precision, Probe,
    Sponge, TimeScheme, TimeStepping, WallCorrection,
};
pub use law::TimeLaw;
pub use reference::{PublishedCoefficients, PublishedQuantity, PublishedRange, PublishedSpread, Reference};
pub use rod::{
    Bending, Calibration, Material, Rod, RodScheme, RootLaws, RootMotion, RootSupport, Rotation, Section,
    SectionProfile,
};
pub use rods::NamedRod;
pub use spanwise::{Spanwise, SpanwiseProfile};

use check::{Check, require};
use rod::Z_AXIS;

/// A whole scene: at least a fluid or a rod.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Where the JSON Schema of this file is; read by editors only.
    #[serde(rename = "$schema", default)]
    pub schema: Option<String>,
    /// Number of the format that the file follows; absent, it is the present one, 2.
    #[serde(default = "present_format")]
    #[schemars(range(min = 2, max = 2))]
    pub format: u32,
    /// Short name of at most 100 characters: letters, digits, `.`, `_` and `-`, the first one a letter, a digit or `_`;
    /// names the units and the result folder.
    #[schemars(regex(pattern = NAME))]
    pub name: String,
    /// One sentence for people.
    #[serde(default)]
    pub description: String,
    /// What pictures call a length and a time of 1; absent where they are metres and seconds.
    #[serde(default)]
    pub display: Option<Display>,
    /// Clock of the co-simulation.
    pub time: Time,
    /// The fluid; absent in a rod-only scene.
    #[serde(default)]
    pub fluid: Option<Fluid>,
    /// Geometry of the beam that the fluid sees and the rod moves; absent in a scene without one.
    #[serde(default)]
    pub beam: Option<Beam>,
    /// Elastic model of the beam; absent where the beam is rigid.
    #[serde(default)]
    pub rod: Option<Rod>,
    /// Several beams in the fluid, each with a rod that is a unit of its own: at least two, in the place of `beam` and `rod`.
    #[serde(default)]
    pub rods: Vec<NamedRod>,
    /// Name of the one of `rods` that a rod's unit is, in the scene that it carries; absent elsewhere.
    #[serde(default)]
    pub this_rod: Option<String>,
    /// How fluid and rod exchange; absent where it is left to the rules, refused where there are not both.
    #[serde(default)]
    pub coupling: Option<Coupling>,
    /// Published values that a run is compared with; absent where there are none.
    #[serde(default)]
    pub reference: Option<Reference>,
}

/// Format of the scene files that this version reads: 1 was that of nervure 0.2.
const FORMAT: u32 = 2;

fn present_format() -> u32 {
    FORMAT
}

/// What a name of a scene looks like.
const NAME: &str = "^[A-Za-z0-9_][A-Za-z0-9._-]{0,99}$";

/// Most characters of a name: file names of its units stay within what file systems take.
const NAME_LENGTH: usize = 100;

/// Most steps of a unit's own in a communication step, and most communication steps in a run: more never end.
const MOST_SUBSTEPS: f64 = 1e5;
const MOST_STEPS: f64 = 1e12;

/// Clock of the co-simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// End of the run, s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub end: f64,
    /// Communication step of the master, s. Each unit takes as many equal steps of its own inside as it needs.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub communication_step: f64,
}

/// What pictures call a length and a time of 1 in a scene whose numbers are multiples of its own scales.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Display {
    /// A length of 1, e.g. `chords`.
    pub length: String,
    /// A time of 1, e.g. `periods`.
    pub time: String,
}

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file could not be read.
    #[error("cannot read the scene file {path}: {source}")]
    Read {
        /// Path that was asked for.
        path: String,
        /// Answer of the system.
        source: std::io::Error,
    },
    /// Not JSON, or a key that is there twice.
    #[error("scene key `{key}`: {source}")]
    Parse {
        /// Path of the key inside the file.
        key: String,
        /// What the parser found, with line and column.
        source: serde_json::Error,
    },
    /// A key that is missing or unknown, or a value that no solver could run.
    #[error("scene key `{key}` is {value}, but {allowed}")]
    Value {
        /// Path of the key inside the file.
        key: String,
        /// The value that was found.
        value: String,
        /// What would be allowed, as the end of the sentence "but …".
        allowed: String,
    },
}

impl Scene {
    /// Read and check a scene file.
    pub fn from_file(path: &Path) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.display().to_string(), source })?;
        Self::from_json(&text)
    }

    /// Read and check a scene from JSON text.
    pub fn from_json(text: &str) -> Result<Self, SceneError> {
        let tree = text::parse(text)?;
        text::check(&tree)?;
        let scene: Self = serde_path_to_error::deserialize(&tree)
            .map_err(|e| SceneError::Parse { key: e.path().to_string(), source: e.into_inner() })?;
        scene.check_relations()?;
        Ok(scene)
    }

    /// Check every value; the first that cannot be run is the error.
    pub fn check(&self) -> Result<(), SceneError> {
        text::check(&serde_json::to_value(self).expect("a scene is plain JSON"))?;
        self.check_relations()
    }

    /// Check what the schema cannot say: words, and what relates several keys.
    fn check_relations(&self) -> Result<(), SceneError> {
        let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
        let begins = self.name.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
        let good = begins && self.name.len() <= NAME_LENGTH && self.name.chars().all(plain);
        require(good, "name", format!("{:?}", self.name), || {
            format!(
                "it must be 1 to {NAME_LENGTH} of the letters a-z, A-Z, the digits and . _ -, and begin with a letter, a \
                 digit or _"
            )
        })?;
        let Time { end, communication_step } = self.time;
        require(
            end / communication_step <= MOST_STEPS,
            "time.communication_step",
            format!("{communication_step:?}"),
            || format!("it must be at least {:e}: a run has at most {MOST_STEPS:e} steps", end / MOST_STEPS),
        )?;
        require(self.fluid.is_some() || self.rod.is_some(), "fluid", "missing", || {
            let several = "several rods need a fluid that couples them";
            if self.rods.is_empty() { "a scene needs a fluid, a rod with a beam, or both" } else { several }.into()
        })?;
        self.check_rods()?;
        self.check_substeps()?;
        self.fluid.check_at("fluid")?;
        self.check_beam(self.beam.as_ref(), self.rod.as_ref(), "")?;
        for (i, NamedRod { beam, rod, .. }) in self.rods.iter().enumerate() {
            self.check_beam(Some(beam), Some(rod), &format!("rods[{i}]."))?;
        }
        self.check_places()?;
        self.reference.check_at("reference")?;
        self.check_coupling()
    }

    /// Check a beam with its rod, whose keys begin with `at`.
    fn check_beam(&self, beam: Option<&Beam>, rod: Option<&Rod>, at: &str) -> Result<(), SceneError> {
        let key = |key: &str| format!("{at}{key}");
        if let Some(beam) = beam {
            beam.check_at(&key("beam"))?;
        }
        if let Some(rod) = rod {
            rod.check_at(&key("rod"))?;
        }
        if let Some(Beam { root: Root::OnCylinder { cylinder, .. }, .. }) = beam {
            let count = self.fluid.as_ref().map_or(0, |f| f.cylinders.len());
            require(*cylinder < count, &key("beam.root.on_cylinder.cylinder"), cylinder, || match count {
                0 => "the scene has no cylinder".into(),
                count => format!("it must be at most {}: the scene has {count}, counted from 0", count - 1),
            })?;
        }

        if let Some(rod) = rod {
            let Some(beam) = beam else {
                return require(false, "beam", "missing", || "a rod needs a beam: its geometry".into());
            };
            let dimension = self.dimension(beam);
            require(
                rod.gravity.is_empty() || rod.gravity.len() == dimension,
                &key("rod.gravity"),
                format!("{:?}", rod.gravity),
                || format!("it must have {dimension} components like the beam's root"),
            )?;
            check_hold(rod, beam, dimension, &key("rod"))?;
            let tapered = beam.thickness.varies() || rod.material.varies();
            require(
                !tapered || rod.calibration == Calibration::SecondOrder,
                &key("rod.calibration"),
                "thesis",
                || "of a rod that changes along its length it must be second_order".into(),
            )?;
            if let (2, Some(RootMotion::Laws(laws))) = (dimension, &rod.root_motion) {
                let key = key("rod.root_motion.laws");
                require(laws.z == TimeLaw::default(), &format!("{key}.z"), "present", || {
                    "a beam in two dimensions has no z".into()
                })?;
                for (i, Rotation { axis, .. }) in laws.rotations.iter().enumerate() {
                    require(*axis == Z_AXIS, &format!("{key}.rotations[{i}].axis"), format!("{axis:?}"), || {
                        format!("a beam in two dimensions turns about {Z_AXIS:?}")
                    })?;
                }
            }
        }
        if let (Some(fluid), Some(beam)) = (&self.fluid, beam) {
            require(self.dimension(beam) == 2, &key("beam.root"), "three-dimensional", || {
                "a beam in the two-dimensional fluid needs a root with 2 components".into()
            })?;
            for [x, y, _] in self.beam_stations(beam) {
                let inside = |p: f64, [low, high]: [f64; 2]| (low..=high).contains(&p);
                require(
                    inside(x, fluid.r#box.x) && inside(y, fluid.r#box.y),
                    &key("beam.root"),
                    format!("a station at ({x}, {y})"),
                    || format!("the beam must lie inside the box x {:?}, y {:?}", fluid.r#box.x, fluid.r#box.y),
                )?;
            }
        }
        Ok(())
    }

    /// Steps so short that no run would end are refused where they are asked for: a unit could only say of the first
    /// step that it is too long.
    fn check_substeps(&self) -> Result<(), SceneError> {
        let step = self.time.communication_step;
        let reachable = |key: &str, longest: f64| {
            require(step / longest <= MOST_SUBSTEPS, key, format!("{longest:?}"), || {
                let least = step / MOST_SUBSTEPS;
                format!(
                    "it must be at least {least:e}: a communication step of {step} s has at most {MOST_SUBSTEPS} steps"
                )
            })
        };
        let several = self.rods.iter().enumerate().map(|(i, own)| (format!("rods[{i}].rod.max_step"), &own.rod));
        for (key, rod) in self.rod.iter().map(|rod| ("rod.max_step".to_string(), rod)).chain(several) {
            rod.max_step.map_or(Ok(()), |longest| reachable(&key, longest))?;
        }
        let Some(fluid) = &self.fluid else { return Ok(()) };
        let TimeStepping { max_step, max_cfl, .. } = fluid.time_stepping;
        reachable("fluid.time_stepping.max_step", max_step)?;
        let rate = fluid.advection_rate();
        require(rate * step / max_cfl <= MOST_SUBSTEPS, "fluid.time_stepping.max_cfl", format!("{max_cfl:?}"), || {
            format!(
                "it must be at least {:.3e}: the flow that drives the scene has the CFL number {:.3e} in a communication step of \
                 {step} s, which has at most {MOST_SUBSTEPS} steps",
                1.001 * rate * step / MOST_SUBSTEPS, // what it is rounded to will do
                rate * step
            )
        })
    }

    /// Number of space dimensions in which `beam` moves, 2 or 3.
    pub fn dimension(&self, beam: &Beam) -> usize {
        match &beam.root {
            Root::OnCylinder { .. } => 2,
            Root::At { position, .. } => position.len(),
        }
    }

    /// Position of the root of `beam` at rest, m, and its unit direction there; z = 0 in two dimensions.
    pub fn beam_root(&self, beam: &Beam) -> ([f64; 3], [f64; 3]) {
        match &beam.root {
            Root::OnCylinder { cylinder, angle } => {
                let cylinder = &self.fluid.as_ref().expect("checked: the cylinder exists").cylinders[*cylinder];
                let direction = [angle.cos(), angle.sin(), 0.0];
                let [x, y] = cylinder.center;
                ([x + cylinder.radius * direction[0], y + cylinder.radius * direction[1], 0.0], direction)
            }
            Root::At { position, direction } => {
                let norm = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
                let vector = |v: &[f64], scale: f64| [v[0] / scale, v[1] / scale, v.get(2).map_or(0.0, |z| z / scale)];
                (vector(position, 1.0), vector(direction, norm))
            }
        }
    }

    /// Rest positions of the stations of `beam` from root to tip, m: `[segments + 1][3]`, z = 0 in two dimensions.
    pub fn beam_stations(&self, beam: &Beam) -> Vec<[f64; 3]> {
        let (root, direction) = self.beam_root(beam);
        let mut stations = Vec::with_capacity(beam.segments + 1);
        if beam.rest_angles.is_empty() {
            let at = |s: f64| std::array::from_fn(|d| root[d] + s * direction[d]);
            stations.extend((0..=beam.segments).map(|k| at(beam.length * k as f64 / beam.segments as f64)));
            return stations;
        }
        let l0 = beam.length / beam.segments as f64;
        let [mut x, mut y, z] = root;
        stations.push(root);
        for (sin, cos) in beam.rest_angles.iter().map(|angle| angle.sin_cos()) {
            x += l0 * (cos * direction[0] - sin * direction[1]);
            y += l0 * (sin * direction[0] + cos * direction[1]);
            stations.push([x, y, z]);
        }
        stations
    }
}

/// What a root that is not clamped does not go with; `of` is the key of the rod.
fn check_hold(rod: &Rod, beam: &Beam, dimension: usize, of: &str) -> Result<(), SceneError> {
    let (key, absent) = (&format!("{of}.root"), TimeLaw::default());
    let name = match &rod.root {
        RootSupport::Clamped => return Ok(()),
        RootSupport::Pinned => "pinned",
        RootSupport::TorsionSpring { damping, rest_angle, .. } => {
            for (name, value) in [("damping", damping), ("rest_angle", rest_angle)] {
                require(dimension == 2 || *value == 0.0, &format!("{key}.torsion_spring.{name}"), value, || {
                    "it must be 0 in three dimensions, where the spring is the same in all directions and the rod has no \
                     material frame"
                        .into()
                })?;
            }
            "torsion_spring"
        }
        RootSupport::Free { force_z, .. } => {
            require(dimension == 3 || *force_z == absent, &format!("{key}.free.force_z"), "present", || {
                "a beam in two dimensions has no z".into()
            })?;
            "free"
        }
    };
    let free = matches!(rod.root, RootSupport::Free { .. });
    require(!free || matches!(beam.root, Root::At { .. }), key, name, || {
        "a beam on a cylinder has a root that it holds".into()
    })?;
    require(!free || rod.root_motion.is_none(), &format!("{of}.root_motion"), "present", || {
        "a free root has no prescribed motion; rod.root.free has the forces that tow it".into()
    })?;
    let turns = matches!(&rod.root_motion, Some(RootMotion::Laws(laws)) if !laws.rotations.is_empty());
    require(rod.root != RootSupport::Pinned || !turns, &format!("{of}.root_motion.laws.rotations"), "present", || {
        "a pinned root has no direction that could be turned".into()
    })?;
    require(rod.bending == Bending::Invariant, &format!("{of}.bending"), "projected", || {
        format!("with a root that is {name} it must be invariant")
    })?;
    require(rod.calibration == Calibration::SecondOrder, &format!("{of}.calibration"), "thesis", || {
        format!("with a root that is {name} it must be second_order")
    })?;
    let clamped = matches!(rod.root, RootSupport::TorsionSpring { .. });
    require(
        clamped || rod.clamp_compliance_length == 0.0,
        &format!("{of}.clamp_compliance_length"),
        rod.clamp_compliance_length,
        || format!("it must be 0 with a root that is {name}: there is no clamp"),
    )
}

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
