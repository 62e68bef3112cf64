//! An elastic wing: veins and a membrane between them.

use mesh::{Chain, Mesh};
use method::Scheme;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

use crate::body::ByMaster;
use crate::fault::{Check, Fault, Faults, list};
use crate::reference_scales::ReferenceScales;
use crate::root::RootLaws;

/// Most nodes of a wing.
const MOST_NODES: usize = 100_000;

/// An elastic wing in space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wing {
    /// Nodes and triangles at rest.
    pub mesh: WingMesh,
    /// Material of the membrane outside regions; absent for veins alone.
    #[serde(default)]
    pub membrane: Option<Membrane>,
    /// Parts of the membrane of other materials; the last one counts where several hold a triangle.
    #[serde(default)]
    #[schemars(length(max = 100))]
    pub regions: Vec<Region>,
    /// Veins.
    #[serde(default)]
    pub veins: Vec<Vein>,
    /// Chain of the mesh that the base holds; absent for a free wing. Generated meshes have `root`.
    #[serde(default)]
    pub root: Option<String>,
    /// Support of the root.
    #[serde(default)]
    pub support: WingSupport,
    /// Motion of the base from its place at rest; rotations are about `pivot`. Absent: at rest.
    #[serde(default)]
    pub root_motion: Option<WingDrive>,
    /// Centre of the rotations of the base, m.
    #[serde(default)]
    pub pivot: [f64; 3],
    /// Gravity, m/s².
    #[serde(default)]
    pub gravity: [f64; 3],
    /// Relaxation time of the strain, s: a mode of circular frequency ω has the damping ratio ω/2 times it.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub relaxation_time: f64,
    /// Scales of its coefficients, in place of those that follow from mesh, stream and drive.
    #[serde(default)]
    pub reference: Option<ReferenceScales>,
    /// Time scheme.
    #[serde(default)]
    pub scheme: Scheme,
    /// Largest step of the wing inside a communication step, s; absent: the communication step.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_step: Option<f64>,
}

/// What moves the base of a wing: laws of time, or the word `master`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
#[expect(clippy::large_enum_variant, reason = "a wing has one")]
pub enum WingDrive {
    /// Laws of time.
    Laws(RootLaws),
    /// The master.
    Master(ByMaster),
}

/// Mesh of a wing. Chains are named lines of nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(transform = one_of)]
pub enum WingMesh {
    /// A rectangle with its root on the y axis; chains `root`, `tip`, `left` and `right`.
    Rectangular {
        /// Length along x, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
        /// Width along y, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        width: f64,
        /// Triangles along x.
        #[schemars(range(min = 1, max = 1000))]
        along: usize,
    },
    /// An ellipse that begins on the y axis; chains `root` and `tip`, quarters of the outline.
    Elliptical {
        /// Length along x, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        length: f64,
        /// Width along y, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        width: f64,
        /// Triangles along x.
        #[schemars(range(min = 2, max = 1000))]
        along: usize,
    },
    /// A simplified insect wing along x; chains `root`, `margin`, `costa`, `radius`, `media`, `cubitus` and `anal`.
    Insect {
        /// Span, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        span: f64,
        /// Largest chord, m.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        chord: f64,
        /// Triangles along a vein.
        #[schemars(range(min = 4, max = 1000))]
        along: usize,
    },
    /// Nodes and triangles of any other program.
    Triangles {
        /// Positions of the nodes, m.
        nodes: Vec<[f64; 3]>,
        /// Nodes of the triangles, counted from 0, all in the same sense of rotation.
        triangles: Vec<[usize; 3]>,
        /// Chains.
        #[serde(default)]
        chains: Vec<WingChain>,
        /// Groups of triangles, for regions.
        #[serde(default)]
        groups: Vec<WingGroup>,
    },
    /// File of another program beside the scene's. `nervure` puts `triangles` in its place.
    #[serde(untagged)]
    File {
        /// Gmsh, VTK, OBJ or STL; lines of a physical group make a chain of its name, and triangles a group.
        file: String,
        /// Length of the unit of the file, m; by default 1.
        #[serde(default)]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        unit: Option<f64>,
    },
}

/// Say in the schema that a mesh has the keys of one variant alone, also of that without a tag.
fn one_of(schema: &mut Schema) {
    let Some(mut variants) = schema.remove("anyOf") else { return };
    for variant in variants.as_array_mut().into_iter().flatten() {
        variant["additionalProperties"] = false.into();
    }
    schema.insert("oneOf".into(), variants);
}

/// Named line of nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingChain {
    /// Name.
    pub name: String,
    /// Nodes in order, counted from 0, each once.
    #[schemars(length(min = 1))]
    pub nodes: Vec<usize>,
}

/// Named group of triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WingGroup {
    /// Name.
    pub name: String,
    /// Triangles, counted from 0.
    #[schemars(length(min = 1))]
    pub triangles: Vec<usize>,
}

/// Part of the membrane of a material of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Name; without a polygon the name of a group of the mesh.
    pub name: String,
    /// Corners of a polygon in x and y, m: the region has the triangles whose middle at rest lies inside.
    #[serde(default)]
    #[schemars(length(min = 3, max = 1000))]
    pub polygon: Option<Vec<[f64; 2]>>,
    /// Material.
    pub membrane: Membrane,
}

/// Material of a membrane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Membrane {
    /// Mass per area, kg/m².
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub areal_density: f64,
    /// Stiffness E h in its plane, N/m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub stretching_stiffness: f64,
    /// Bending stiffness E h³/(12 (1 − ν²)), N m.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub bending_stiffness: f64,
    /// Poisson's ratio ν.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = -1.0, "exclusiveMaximum" = 1.0))]
    pub poisson_ratio: f64,
    /// Tension at rest, N/m.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub tension: f64,
}

/// Vein along a chain of the mesh, straight at rest unless it has torsion. Veins with torsion that meet are joined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vein {
    /// Name of the chain, from base to tip.
    pub chain: String,
    /// Mass per length at the base, kg/m.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub line_density: f64,
    /// Bending stiffness EI at the base, N m².
    #[schemars(range(min = 0.0))]
    pub bending_stiffness: f64,
    /// Torsional stiffness GJ at the base, N m²: such a vein may curve, and the membrane turns with it.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub torsional_stiffness: f64,
    /// Axial stiffness EA at the base, N.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub axial_stiffness: f64,
    /// Diameter at the tip by the diameter at the base; mass and EA follow its square, EI and GJ its fourth power.
    #[serde(default = "one")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub tip_diameter: f64,
}

fn one() -> f64 {
    1.0
}

/// Support of the root of a wing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum WingSupport {
    /// Membrane and veins keep their direction at the root.
    #[default]
    Clamped,
    /// The wing turns freely about the nodes of the root.
    Pinned,
    /// The membrane turns about the line of the root against a spring along it.
    Hinge {
        /// Stiffness of the whole line, N m/rad.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        stiffness: f64,
    },
}

impl WingMesh {
    /// Return nodes, triangles and chains; none of a file.
    pub fn build(&self) -> Mesh {
        match self {
            &Self::Rectangular { length, width, along } => mesh::rectangle(length, width, along),
            &Self::Elliptical { length, width, along } => mesh::ellipse(length, width, along),
            &Self::Insect { span, chord, along } => mesh::insect_wing(span, chord, along),
            Self::Triangles { nodes, triangles, chains, .. } => Mesh {
                nodes: nodes.clone(),
                triangles: triangles.clone(),
                chains: chains.iter().map(|own| Chain { name: own.name.clone(), nodes: own.nodes.clone() }).collect(),
            },
            Self::File { .. } => Mesh { nodes: Vec::new(), triangles: Vec::new(), chains: Vec::new() },
        }
    }

    /// Return the names of the chains.
    pub fn chains(&self) -> Vec<&str> {
        match self {
            Self::Rectangular { .. } => vec!["root", "tip", "left", "right"],
            Self::Elliptical { .. } => vec!["root", "tip"],
            Self::Insect { .. } => vec!["root", "margin", "costa", "radius", "media", "cubitus", "anal"],
            Self::Triangles { chains, .. } => chains.iter().map(|chain| &chain.name[..]).collect(),
            Self::File { .. } => Vec::new(),
        }
    }

    /// Return the groups of triangles.
    pub(crate) fn groups(&self) -> &[WingGroup] {
        match self {
            Self::Triangles { groups, .. } => groups,
            _ => &[],
        }
    }
}

impl Region {
    /// Return the triangles of the region in a mesh with these groups.
    pub(crate) fn triangles(&self, mesh: &Mesh, groups: &[WingGroup]) -> Vec<usize> {
        let Some(polygon) = &self.polygon else {
            let group = groups.iter().find(|group| group.name == self.name);
            return group.map(|group| group.triangles.clone()).unwrap_or_default();
        };
        let is_inside = |corners: &[usize; 3]| {
            let places = corners.map(|k| mesh.nodes.get(k).copied().unwrap_or([f64::NAN; 3]));
            let [x, y] = [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / 3.0);
            // A ray towards +x crosses the sides an odd number of times.
            let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
            let crossed = sides
                .filter(|([ax, ay], [bx, by])| (*ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax));
            crossed.count() % 2 == 1
        };
        (0..mesh.triangles.len()).filter(|t| is_inside(&mesh.triangles[*t])).collect()
    }
}

impl Wing {
    /// Return the laws of its base, if it has such.
    pub fn laws(&self) -> Option<&RootLaws> {
        if let Some(WingDrive::Laws(laws)) = &self.root_motion { Some(laws) } else { None }
    }

    /// Return the material of each triangle of the built mesh: 0 for `membrane`, 1 and more for the `regions` in order;
    /// empty without regions.
    pub fn materials(&self, mesh: &Mesh) -> Vec<usize> {
        if self.regions.is_empty() {
            return Vec::new();
        }
        let mut materials = vec![0; mesh.triangles.len()];
        for (i, region) in self.regions.iter().enumerate() {
            for t in region.triangles(mesh, self.mesh.groups()) {
                if let Some(material) = materials.get_mut(t) {
                    *material = i + 1;
                }
            }
        }
        materials
    }
}

impl Check for Wing {
    fn check_at(&self, key: &str, faults: &mut Faults) {
        if let WingMesh::File { file, .. } = &self.mesh {
            return faults.refuse_file(&format!("{key}.mesh.file"), file);
        }
        self.reference.check_at(&format!("{key}.reference"), faults);
        let before = faults.len();
        let names = self.mesh.chains();
        let known = || match &names[..] {
            [] => "the mesh has no chains: physical groups of lines in a file of Gmsh make them, or \
                   `mesh.triangles.chains`"
                .into(),
            _ => format!("the chains of the mesh are {}", list(names.iter(), "and")),
        };
        if let Some(root) = &self.root {
            faults.require(names.contains(&&root[..]), &format!("{key}.root"), format!("{root:?}"), known);
        }
        for (i, vein) in self.veins.iter().enumerate() {
            let found = names.contains(&&vein.chain[..]);
            faults.require(found, &format!("{key}.veins[{i}].chain"), format!("{:?}", vein.chain), known);
        }
        let moves = self.root_motion.is_some() && self.root.is_none();
        faults.forbid(moves, &format!("{key}.root_motion"), || "a free wing has no `root`".into());
        let held = self.support != WingSupport::default() && self.root.is_none();
        faults.forbid(held, &format!("{key}.support"), || "a free wing has no `root`".into());
        if let Some(laws) = self.laws() {
            laws.check_at(&format!("{key}.root_motion"), faults);
        }
        match &self.mesh {
            WingMesh::Triangles { nodes, triangles, .. } => {
                let key = format!("{key}.mesh.triangles.nodes");
                faults.require(nodes.len() <= MOST_NODES, &key, nodes.len(), || {
                    format!("a wing has at most {MOST_NODES} nodes")
                });
                if self.membrane.is_none() && !triangles.is_empty() {
                    faults.push(Fault::needed("wing.membrane", "triangles need a material"));
                }
            }
            WingMesh::File { .. } => (),
            _ if self.membrane.is_none() => {
                faults.push(Fault::needed("wing.membrane", "a generated mesh has triangles, which need a material"));
            }
            WingMesh::Rectangular { length, width, along } | WingMesh::Elliptical { length, width, along } => {
                let nodes = *along as f64 * *along as f64 * width / length * 1.2;
                faults.require(nodes <= MOST_NODES as f64, &format!("{key}.mesh"), "a mesh too fine", || {
                    format!("it makes some {nodes:.0} nodes, and a wing has at most {MOST_NODES}")
                });
            }
            WingMesh::Insect { along, .. } => {
                faults.require(*along <= 350, &format!("{key}.mesh.insect.along"), along, || {
                    format!("a wing has at most {MOST_NODES} nodes: it must be <= 350")
                });
            }
        }
        if faults.len() == before {
            self.check_mesh(key, faults);
        }
    }
}
