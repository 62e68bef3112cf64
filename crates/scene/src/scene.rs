//! A whole scene, and the geometry of its beams at rest.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::beam::{Beam, Root};
use crate::contact::Contact;
use crate::coupling::Coupling;
use crate::fluid::Fluid;
use crate::flyer::Flyer;
use crate::reference::Reference;
use crate::rod::Rod;
use crate::rods::NamedRod;
use crate::root::RootLaws;
use crate::stepping::TimeStepping;
use crate::wing::Wing;
use crate::wings::NamedWing;

/// Format of the scene files that this version reads; 1 is the format of nervure 0.2.
pub(crate) const FORMAT: u32 = 2;

/// A whole scene: at least a fluid, a rod or a wing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Place of the JSON Schema of this file, for editors.
    #[serde(rename = "$schema", default)]
    pub schema: Option<String>,
    /// Number of the format that the file follows; absent, it is the present one, 2.
    #[serde(default = "present_format")]
    #[schemars(range(min = 2, max = 2))]
    pub format: u32,
    /// Name of the units and the result folder: at most 100 letters, digits, `.`, `_` and `-`, the first one a letter,
    /// a digit or `_`.
    #[schemars(regex(pattern = NAME))]
    pub name: String,
    /// One sentence for people.
    #[serde(default)]
    pub description: String,
    /// Names of the units of length and time in pictures; absent where they are metres and seconds.
    #[serde(default)]
    pub display: Option<Display>,
    /// Clock of the co-simulation.
    pub time: Time,
    /// The fluid; absent in a rod-only scene.
    #[serde(default)]
    pub fluid: Option<Fluid>,
    /// Geometry of the only beam; absent without one.
    #[serde(default)]
    pub beam: Option<Beam>,
    /// Elastic model of the only beam; absent for a rigid beam.
    #[serde(default)]
    pub rod: Option<Rod>,
    /// Several beams, each with a rod that is a unit of its own, which the fluid or contact couples: at least two, in
    /// place of `beam` and `rod`.
    #[serde(default)]
    pub rods: Vec<NamedRod>,
    /// Name of one of `rods`, in the scene that the unit of this rod carries; absent elsewhere.
    #[serde(default)]
    pub this_rod: Option<String>,
    /// An elastic wing in space, alone or in a fluid of three dimensions.
    #[serde(default)]
    pub wing: Option<Wing>,
    /// Several elastic wings, each a unit of its own: at least two, in place of `wing`.
    #[serde(default)]
    pub wings: Vec<NamedWing>,
    /// Name of one of `wings`, in the scene that the unit of this wing carries; absent elsewhere.
    #[serde(default)]
    pub this_wing: Option<String>,
    /// A free rigid body that carries wings and rods in space.
    #[serde(default)]
    pub flyer: Option<Flyer>,
    /// Contact of rods, wings and bodies on a mount; absent, they pass through everything.
    #[serde(default)]
    pub contact: Option<Contact>,
    /// Coupling of fluid and rods; absent where the rules choose it, and without both.
    #[serde(default)]
    pub coupling: Option<Coupling>,
    /// Published values for comparison with a run; absent where there are none.
    #[serde(default)]
    pub reference: Option<Reference>,
}

/// Pattern of the name of a scene.
const NAME: &str = "^[A-Za-z0-9_][A-Za-z0-9._-]{0,99}$";

fn present_format() -> u32 {
    FORMAT
}

/// Clock of the co-simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// End of the run, s.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub end: f64,
    /// Communication step of the master, s. Each unit divides it into equal steps where it must.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub communication_step: f64,
}

/// Names of the units of length and time in pictures of a dimensionless scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Display {
    /// Unit of length, e.g. `chords`.
    pub length: String,
    /// Unit of time, e.g. `periods`.
    pub time: String,
}

/// A beam of a scene with its rod.
#[derive(Clone, Copy, Debug)]
pub struct BeamWithRod<'a> {
    /// Number among `rods`, from 1; none for the only beam.
    pub number: Option<usize>,
    /// Name among `rods`; none for the only beam.
    pub name: Option<&'a str>,
    /// Geometry of the beam.
    pub beam: &'a Beam,
    /// Elastic model; none for a rigid beam.
    pub rod: Option<&'a Rod>,
}

impl<'a> BeamWithRod<'a> {
    /// Return the laws of the root's motion, where laws move it.
    pub(crate) fn laws(&self) -> Option<&'a RootLaws> {
        self.rod?.laws()
    }

    /// Return the name of a rod in a sentence, with a space in front; empty for the only rod.
    pub(crate) fn in_sentence(&self) -> String {
        self.name.map_or(String::new(), |name| format!(" `{name}`"))
    }

    /// Return the name of the fluid's forces on the beam: `beam`, or `beam_1` and so on.
    pub fn force_name(&self) -> String {
        self.number.map_or("beam".into(), |number| format!("beam_{number}"))
    }

    /// Return the beginning of the keys of beam and rod.
    pub(crate) fn key(&self) -> String {
        self.number.map_or(String::new(), |number| format!("rods[{}].", number - 1))
    }
}

/// What a fine box follows, by its number among those of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Followed {
    /// A cylinder.
    Cylinder(usize),
    /// A body of the fluid.
    Body(usize),
    /// A beam or one of several wings, counted after the beams.
    Beam(usize),
    /// The only wing.
    Wing,
    /// A point that the master moves.
    Master,
}

impl Scene {
    /// Return what a fine box can follow, by the names of its outputs, or the word `master`.
    pub fn followable(&self) -> Vec<(String, Followed)> {
        let Some(fluid) = &self.fluid else { return vec![] };
        let beams = self
            .beams_with_rods()
            .enumerate()
            .map(|(k, own)| (own.number.map_or("beam".into(), |number| format!("beam[{number}]")), Followed::Beam(k)));
        let numbered = |kind: &'static str, count: usize| (0..count).map(move |k| (format!("{kind}[{}]", k + 1), k));
        let cylinders = numbered("cylinder", fluid.cylinders.len()).map(|(name, k)| (name, Followed::Cylinder(k)));
        let bodies = numbered("body", fluid.bodies.len()).map(|(name, k)| (name, Followed::Body(k)));
        let before = self.beams().count();
        let wings = self.wings().enumerate().map(|(k, own)| match own.number {
            Some(number) => (format!("wing[{number}]"), Followed::Beam(before + k)),
            None => ("wing".into(), Followed::Wing),
        });
        let master = [("master".into(), Followed::Master)];
        cylinders.chain(bodies).chain(beams).chain(wings).chain(master).collect()
    }

    /// Let a fine box without `follow` follow the shape of a flyer that may leave its place.
    pub(crate) fn follow_flyer(&mut self) {
        let (Some(fluid), Some(flyer)) = (&mut self.fluid, &self.flyer) else { return };
        let shape = flyer.shape.filter(|k| *k < fluid.bodies.len() && flyer.goes_along().any(|goes| goes));
        if let (Some(fine), Some(k)) = (&mut fluid.fine_box, shape) {
            fine.follow.get_or_insert_with(|| format!("body[{}]", k + 1));
        }
    }

    /// Return what the fine box follows.
    pub fn followed(&self) -> Option<Followed> {
        let name = self.fluid.as_ref()?.fine_box.as_ref()?.follow.as_ref()?;
        self.followable().into_iter().find(|(own, _)| own == name).map(|(_, part)| part)
    }

    /// Return the CFL number that divides the steps of the fluid: `max_cfl`, less without bodies.
    pub fn largest_cfl(&self, fluid: &Fluid) -> f64 {
        let TimeStepping { max_cfl, scheme, .. } = fluid.time_stepping;
        let parts = fluid.obstacles().count() + self.beams().count() + self.wings().count();
        if parts == 0 { max_cfl.min(scheme.largest_cfl_without_bodies()) } else { max_cfl }
    }

    /// Return the beams in the order in which the fluid counts them: `beam`, or the beams of `rods`.
    pub fn beams(&self) -> impl Iterator<Item = &Beam> {
        self.beams_with_rods().map(|own| own.beam)
    }

    /// Return the beams with their rods, in the same order.
    pub fn beams_with_rods(&self) -> impl Iterator<Item = BeamWithRod<'_>> {
        let only = self.beam.iter().map(|beam| BeamWithRod { number: None, name: None, beam, rod: self.rod.as_ref() });
        let several = (1..).zip(&self.rods).map(|(number, NamedRod { name, beam, rod })| BeamWithRod {
            number: Some(number),
            name: Some(name),
            beam,
            rod: Some(rod),
        });
        only.chain(several)
    }

    /// Return the number of space dimensions of the scene, 2 or 3: those of the fluid, or of the beams without one.
    pub fn dimensions(&self) -> usize {
        let of_beams = || self.beams().map(|beam| self.dimension(beam)).max().unwrap_or(3);
        self.fluid.as_ref().map_or_else(of_beams, |fluid| fluid.r#box.ends().count())
    }

    /// Return the number of space dimensions in which `beam` moves, 2 or 3.
    pub fn dimension(&self, beam: &Beam) -> usize {
        match &beam.root {
            Root::OnCylinder { .. } => 2,
            Root::At { position, .. } => position.len(),
        }
    }

    /// Return the position of the root of `beam` at rest, m, and the unit direction there; z = 0 in two dimensions.
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

    /// Return the positions of the stations of `beam` at rest from root to tip, m: `[segments + 1][3]`, z = 0 in two
    /// dimensions.
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

/// A wing of a scene.
#[derive(Clone, Debug)]
pub struct WingOfScene<'a> {
    /// Name of its unit: `wing`, or that among `wings`.
    pub name: &'a str,
    /// Number among `wings`, from 1; none for the only wing.
    pub number: Option<usize>,
    /// Key of the wing.
    pub key: String,
    /// The wing.
    pub wing: &'a Wing,
}

impl WingOfScene<'_> {
    /// Return the name of the fluid's forces on the wing: `wing`, or `wing_1` and so on.
    pub fn force_name(&self) -> String {
        self.number.map_or("wing".into(), |number| format!("wing_{number}"))
    }
}

impl Scene {
    /// Return the wings in the order in which the fluid counts them: `wing`, or those of `wings`.
    pub fn wings(&self) -> impl Iterator<Item = WingOfScene<'_>> {
        let only = self.wing.iter().map(|wing| WingOfScene { name: "wing", number: None, key: "wing".into(), wing });
        let several = (1..).zip(&self.wings).map(|(number, NamedWing { name, wing })| WingOfScene {
            name,
            number: Some(number),
            key: format!("wings[{}].wing", number - 1),
            wing,
        });
        only.chain(several)
    }

    /// Return the wing of the unit that carries this scene: `wing`, or that of `wings` which `this_wing` names.
    pub fn wing_of_unit(&self) -> Option<WingOfScene<'_>> {
        self.wings().find(|own| own.number.is_none() || self.this_wing.as_deref() == Some(own.name))
    }

    /// Return the nodes of a wing at rest, m: those of its mesh, or where the hinge of a flyer has them at the start.
    pub fn wing_nodes(&self, own: &WingOfScene) -> Vec<[f64; 3]> {
        let mut nodes = own.wing.mesh.build().nodes;
        if let Some(hinge) = self.hinge_of(own.name) {
            let place = self.place_of(hinge);
            for node in &mut nodes {
                let arm = hinge.at_start(std::array::from_fn(|d| node[d] - own.wing.pivot[d]));
                *node = std::array::from_fn(|d| place[d] + arm[d]);
            }
        }
        nodes
    }
}
