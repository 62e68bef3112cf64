//! Parameters of a wing.

use ::contact::{Law, Obstacle};
use mesh::Mesh;
use serde::{Deserialize, Serialize};
use structure::{Scheme, check_law, check_scheme, finite, not_negative, positive};

use crate::Error;
use crate::geometry::{Geometry, refused};
use crate::section::Section;

/// Half the thickness of the membrane for itself, over the range.
pub(crate) const SKIN: f64 = 0.25;

/// Most parts of an edge between points that touch.
const MOST_PARTS: f64 = 16.0;

/// Material of a region of the membrane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Membrane {
    /// Mass per area, kg/m².
    pub areal_density: f64,
    /// Stiffness E h in its plane, N/m.
    pub stretching_stiffness: f64,
    /// Bending stiffness D = E h³/(12 (1 − ν²)), N m; 0 bends freely.
    pub bending_stiffness: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Tension in the rest shape, N/m, equal in all directions.
    pub tension: f64,
}

/// Vein along a chain of nodes; without torsion its rest shape is straight.
#[derive(Clone, Debug, PartialEq)]
pub struct Vein {
    /// Name.
    pub name: String,
    /// Nodes from base to tip.
    pub nodes: Vec<usize>,
    /// Mass per length at the base, kg/m.
    pub line_density: f64,
    /// Bending stiffness EI at the base, N m².
    pub bending_stiffness: f64,
    /// Torsional stiffness GJ at the base, N m²; 0 for a vein without torsion.
    ///
    /// A vein with torsion may curve and branch: where it begins or ends at a node of another one, both are joined
    /// rigidly. The membrane beside it turns with it.
    pub torsional_stiffness: f64,
    /// Axial stiffness EA at the base, N.
    pub axial_stiffness: f64,
    /// Diameter at each node by the diameter at the base; empty for a uniform vein.
    ///
    /// Mass and EA follow its square, EI and GJ its fourth power.
    pub diameter: Vec<f64>,
}

/// Support of the root.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Support {
    /// The membrane at edges between root nodes, and veins that begin there, keep their direction.
    #[default]
    Clamped,
    /// The root nodes are held, and the wing turns freely about them.
    Pinned,
    /// The membrane turns about the edges between root nodes against springs along them; veins turn freely.
    TorsionSpring {
        /// Stiffness of all springs together, N m/rad.
        stiffness: f64,
    },
}

/// Nodes that move with the base.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Root {
    /// Held nodes; empty for a free wing.
    pub nodes: Vec<usize>,
    /// Support.
    pub support: Support,
    /// Centre of the rotations of the base, m.
    pub origin: [f64; 3],
}

/// What a membrane touches, and how; for obstacles it has no thickness.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Forces per area.
    pub law: Law,
    /// Whether the membrane touches itself.
    pub with_itself: bool,
    /// Obstacles.
    pub obstacles: Vec<Obstacle<3>>,
}

/// Parameters of a wing, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// Nodes and triangles at rest.
    pub mesh: Mesh,
    /// Materials of the membrane.
    pub membranes: Vec<Membrane>,
    /// Material of each triangle, as an index of `membranes`; empty if all have the first.
    pub regions: Vec<usize>,
    /// Veins.
    pub veins: Vec<Vein>,
    /// Root.
    pub root: Root,
    /// Gravity, m/s².
    pub gravity: [f64; 3],
    /// Relaxation time τ of strain, curvature and the length of veins, s.
    ///
    /// Forces are those of the strain plus τ times its rate (Kelvin–Voigt), so a rigid motion is not damped. A mode of
    /// circular frequency ω has the damping ratio τ ω/2. Bending of veins is not damped.
    pub relaxation_time: f64,
    /// Mass of the fluid that moves with the membrane, per area, kg/m², if the loads account for its inertia.
    ///
    /// The membrane carries the mass that it has more, at least a thousandth of its own; gravity pulls all of it.
    pub displaced_density: f64,
    /// Contact; absent, the wing passes through everything.
    pub contact: Option<Contact>,
    /// Time scheme.
    pub scheme: Scheme,
    /// Longest sub-step, s.
    pub max_step: Option<f64>,
}

impl Membrane {
    /// Return the membrane of an isotropic plate of thickness h.
    pub fn plate(youngs_modulus: f64, poisson_ratio: f64, thickness: f64, density: f64) -> Self {
        let stretching_stiffness = youngs_modulus * thickness;
        Self {
            areal_density: density * thickness,
            stretching_stiffness,
            bending_stiffness: stretching_stiffness * thickness * thickness / (12.0 * (1.0 - poisson_ratio.powi(2))),
            poisson_ratio,
            tension: 0.0,
        }
    }
}

impl Vein {
    /// Return a uniform vein without torsion.
    pub fn new(name: &str, nodes: &[usize], line_density: f64, bending_stiffness: f64, axial_stiffness: f64) -> Self {
        let (name, nodes, diameter) = (name.into(), nodes.to_vec(), Vec::new());
        Self { name, nodes, line_density, bending_stiffness, torsional_stiffness: 0.0, axial_stiffness, diameter }
    }

    /// Return the diameter at the place `i`, by the diameter at the base.
    pub(crate) fn diameter_at(&self, i: usize) -> f64 {
        self.diameter.get(i).copied().unwrap_or(1.0)
    }
}

impl Contact {
    /// Refuse numbers outside their ranges for a wing of this `mesh`.
    fn check(&self, mesh: &Mesh) -> Result<(), Error> {
        let range = self.law.range;
        check_law(&self.law)?;
        self.obstacles.iter().try_for_each(|own| finite("contact.obstacles", own.pose.origin.as_slice()))?;
        if self.parts(mesh) > MOST_PARTS {
            return Err(Error::value("contact.range", range, "beside solids at least a 27th of the longest edge"));
        }
        if self.with_itself && self.parts_for_itself(mesh) > MOST_PARTS {
            return Err(Error::value("contact.range", range, "at least an eighth of the longest edge"));
        }
        Ok(())
    }

    /// Return the parts of an edge between points that touch obstacles: one where there are only planes. Nothing comes
    /// closer to an equilateral triangle than to all its corners by more than an edge over √3.
    pub(crate) fn parts(&self, mesh: &Mesh) -> f64 {
        if self.obstacles.iter().all(Obstacle::is_half_space) {
            return 1.0;
        }
        (longest_edge(mesh) / 3_f64.sqrt() / self.law.range).ceil().max(1.0)
    }

    /// Return the parts of an edge between points that touch the membrane itself, so that no edge passes between two
    /// points of another one.
    pub(crate) fn parts_for_itself(&self, mesh: &Mesh) -> f64 {
        (longest_edge(mesh) / (2.0 * SKIN * self.law.range)).ceil().max(1.0)
    }
}

impl Parameters {
    /// Return a free wing of one material, without veins and gravity.
    pub fn new(mesh: Mesh, membrane: Membrane) -> Self {
        Self {
            mesh,
            membranes: vec![membrane],
            regions: Vec::new(),
            veins: Vec::new(),
            root: Root::default(),
            gravity: [0.0; 3],
            relaxation_time: 0.0,
            displaced_density: 0.0,
            contact: None,
            scheme: Scheme::default(),
            max_step: None,
        }
    }

    /// Return the material of triangle `t`.
    pub(crate) fn membrane(&self, t: usize) -> &Membrane {
        &self.membranes[self.regions.get(t).copied().unwrap_or(0)]
    }

    /// Return whether the wing has a section with twist and camber.
    pub fn have_section(&self) -> bool {
        Section::new(&self.mesh, &self.root.nodes).is_some()
    }

    /// Refuse a parameter outside its range.
    ///
    /// # Errors
    /// The parameter is named with its value.
    pub fn check(&self) -> Result<(), Error> {
        let nodes = self.mesh.nodes.len();
        if nodes < 2 {
            return Err(Error::value("mesh.nodes", nodes, "at least 2 nodes"));
        }
        self.mesh.edges().map_err(refused)?;
        for (i, membrane) in self.membranes.iter().enumerate() {
            positive(format!("membranes[{i}].areal_density"), membrane.areal_density)?;
            positive(format!("membranes[{i}].stretching_stiffness"), membrane.stretching_stiffness)?;
            not_negative(format!("membranes[{i}].bending_stiffness"), membrane.bending_stiffness)?;
            not_negative(format!("membranes[{i}].tension"), membrane.tension)?;
            if !(membrane.poisson_ratio > -1.0 && membrane.poisson_ratio < 1.0) {
                let name = format!("membranes[{i}].poisson_ratio");
                return Err(Error::value(name, membrane.poisson_ratio, "between −1 and 1"));
            }
        }
        not_negative("displaced_density", self.displaced_density)?;
        let triangles = self.mesh.triangles.len();
        if !self.regions.is_empty() {
            Error::check_length("regions", self.regions.len(), triangles)?;
        }
        if let Some(t) = self.regions.iter().position(|&region| region >= self.membranes.len()) {
            return Err(Error::value(format!("regions[{t}]"), self.regions[t], "the number of a material, from 0"));
        }
        if triangles > 0 && self.membranes.is_empty() {
            return Err(Error::value("membranes", "empty", "at least one material"));
        }
        for vein in &self.veins {
            let name = |key: &str| format!("veins.{}.{key}", vein.name);
            positive(name("line_density"), vein.line_density)?;
            positive(name("axial_stiffness"), vein.axial_stiffness)?;
            not_negative(name("bending_stiffness"), vein.bending_stiffness)?;
            not_negative(name("torsional_stiffness"), vein.torsional_stiffness)?;
            if vein.nodes.len() < 2 || vein.nodes.iter().any(|&k| k >= nodes) {
                return Err(Error::value(
                    name("nodes"),
                    &vein.nodes[..],
                    "at least two numbers of nodes, counted from 0",
                ));
            }
            if !vein.diameter.is_empty() {
                Error::check_length(name("diameter"), vein.diameter.len(), vein.nodes.len())?;
            }
            check_torsion(vein, &self.mesh)?;
            for (i, &ratio) in vein.diameter.iter().enumerate() {
                positive(name(&format!("diameter[{i}]")), ratio)?;
            }
        }
        if let Some(&k) = self.root.nodes.iter().find(|&&k| k >= nodes) {
            return Err(Error::value("root.nodes", k, "the number of a node, counted from 0"));
        }
        if let Support::TorsionSpring { stiffness } = self.root.support {
            positive("root.support.stiffness", stiffness)?;
        }
        finite("root.origin", &self.root.origin)?;
        finite("gravity", &self.gravity)?;
        not_negative("relaxation_time", self.relaxation_time)?;
        if let Some(longest) = self.max_step {
            positive("max_step", longest)?;
        }
        check_scheme(self.scheme)?;
        self.contact.as_ref().map_or(Ok(()), |contact| contact.check(&self.mesh))?;
        match self.mesh.unused(self.veins.iter().map(|vein| &vein.nodes[..])) {
            Some(k) => Err(Error::value(format!("mesh.nodes[{k}]"), "in no triangle and no vein", "part of the wing")),
            None => Ok(()),
        }
    }
}

/// Refuse a vein with torsion that has no bending stiffness or a node twice.
fn check_torsion(vein: &Vein, mesh: &Mesh) -> Result<(), Error> {
    let name = |key: &str| format!("veins.{}.{key}", vein.name);
    if vein.torsional_stiffness > 0.0 && vein.bending_stiffness == 0.0 {
        return Err(Error::value(name("bending_stiffness"), 0.0, "above 0, as the vein has torsion"));
    }
    let mut seen = vec![false; mesh.nodes.len()];
    match vein.nodes.iter().find(|k| std::mem::replace(&mut seen[**k], true)) {
        Some(&k) if vein.torsional_stiffness > 0.0 => {
            Err(Error::value(name("nodes"), k, "once in the vein: one with torsion does not cross itself"))
        }
        _ => Ok(()),
    }
}

fn longest_edge(mesh: &Mesh) -> f64 {
    let edges = mesh.triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.map(|[a, b]| (mesh.node(*a) - mesh.node(*b)).norm()).fold(0.0, f64::max)
}
