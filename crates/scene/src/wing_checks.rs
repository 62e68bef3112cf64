//! What is wrong with the mesh of a wing, its veins, root and regions, and what may be a mistake there.

use std::collections::BTreeSet;

use mesh::{Bend, Mesh, MeshEdge};

use crate::fault::{Faults, list};
use crate::shape::check_corners;
use crate::warning::Warning;
use crate::wing::{Wing, WingMesh, WingSupport};

impl Wing {
    /// Add what is wrong with the mesh of this wing, whose key is `key`, and with what refers to it.
    pub(crate) fn check_mesh(&self, key: &str, faults: &mut Faults) {
        let (mesh, before) = (self.mesh.build(), faults.len());
        let checked = Checked { wing: self, key, mesh: &mesh, held: held(self, &mesh) };
        let Some(edges) = checked.mesh(faults).filter(|_| faults.len() == before) else { return };
        checked.veins(&edges, faults);
        checked.root(&edges, faults);
        checked.regions(faults);
    }
}

/// Return what may be a mistake in a wing without faults, the value of `key`.
pub(crate) fn warnings(wing: &Wing, key: &str) -> Vec<Warning> {
    let mesh = wing.mesh.build();
    let mut found = Vec::new();
    let doubled = mesh.doubled();
    if let Some([first, second]) = doubled.first() {
        let text = format!(
            "{} of the wing lie in the place of others, as {second} of {first}: the mesh is open there",
            if doubled.len() == 1 { "a node".into() } else { format!("{} nodes", doubled.len()) }
        );
        found.push(Warning { key: format!("{key}.mesh"), time: None, text });
    }
    let parts = region_triangles(wing, &mesh);
    for (j, part) in parts.iter().enumerate() {
        for (i, other) in parts[..j].iter().enumerate() {
            let both = part.intersection(other).count();
            if both > 0 && both < part.len() {
                let (key, name) = (format!("{key}.regions[{j}]"), &wing.regions[i].name);
                let text = format!(
                    "`{key}` ({}) crosses the region {name}: {both} triangles lie in both, and have its material",
                    wing.regions[j].name
                );
                found.push(Warning { key, time: None, text });
            }
        }
    }
    found
}

/// Return whether the root holds each node.
fn held(wing: &Wing, mesh: &Mesh) -> Vec<bool> {
    let root = wing.root.as_deref().and_then(|name| mesh.chain(name)).unwrap_or_default();
    let mut held = vec![false; mesh.nodes.len()];
    root.iter().filter(|k| **k < mesh.nodes.len()).for_each(|k| held[*k] = true);
    held
}

/// Return the triangles of each region.
fn region_triangles(wing: &Wing, mesh: &Mesh) -> Vec<BTreeSet<usize>> {
    wing.regions.iter().map(|region| region.triangles(mesh, wing.mesh.groups()).into_iter().collect()).collect()
}

struct Checked<'a> {
    wing: &'a Wing,
    key: &'a str,
    mesh: &'a Mesh,
    /// Whether the root holds each node.
    held: Vec<bool>,
}

impl Checked<'_> {
    /// Check nodes, triangles, chains and groups, and return the edges.
    fn mesh(&self, faults: &mut Faults) -> Option<Vec<MeshEdge>> {
        let (key, count) = (format!("{}.mesh", self.key), self.mesh.nodes.len());
        let edges = self.mesh.edges();
        let WingMesh::Triangles { chains, groups, .. } = &self.wing.mesh else {
            let reason = || "its triangles need a height above 1e-6 of their longest edge, of 1e-30 to 1e30 m".into();
            faults.require(edges.is_ok(), &key, "a mesh too narrow, small or large", reason);
            return edges.ok();
        };
        let key = format!("{key}.triangles");
        faults.require(count > 1, &format!("{key}.nodes"), format!("a list of {count}"), || {
            "a wing has at least 2 nodes".into()
        });
        if let Err(flaw) = &edges {
            let reason = || format!("it must be {}", flaw.allowed);
            faults.require(false, &format!("{key}.{}", flaw.key), &flaw.value, reason);
        }
        for (i, chain) in chains.iter().enumerate() {
            let key = format!("{key}.chains[{i}]");
            let twin = chains[..i].iter().any(|other| other.name == chain.name);
            faults.require(!twin, &format!("{key}.name"), format!("{:?}", chain.name), || {
                "another chain has this name".into()
            });
            self.check_list(&chain.nodes, count, "nodes", &key, faults);
        }
        for (i, group) in groups.iter().enumerate() {
            let key = format!("{key}.groups[{i}]");
            let twin = groups[..i].iter().any(|other| other.name == group.name);
            faults.require(!twin, &format!("{key}.name"), format!("{:?}", group.name), || {
                "another group has this name".into()
            });
            self.check_list(&group.triangles, self.mesh.triangles.len(), "triangles", &key, faults);
        }
        edges.ok()
    }

    /// Check that a list of `count` nodes or triangles has each at most once; `key` is the chain or group.
    fn check_list(&self, list: &[usize], count: usize, what: &str, key: &str, faults: &mut Faults) {
        let mut seen = BTreeSet::new();
        let twice = list.iter().position(|k| !seen.insert(*k));
        if let Some(i) = list.iter().position(|k| *k >= count) {
            faults.require(false, &format!("{key}.{what}[{i}]"), list[i], || match count {
                0 => format!("the mesh has no {what}"),
                _ => format!("the mesh has {what} 0 to {}", count - 1),
            });
        } else if let Some(i) = twice {
            faults.require(false, &format!("{key}.{what}[{i}]"), list[i], || "the list has it already".into());
        }
    }

    /// Return the nodes of the vein `i`.
    fn vein(&self, i: usize) -> &[usize] {
        self.mesh.chain(&self.wing.veins[i].chain).unwrap_or_default()
    }

    /// Return a node with its place.
    fn shown(&self, k: usize) -> String {
        format!("node {k}, at {},", crate::places::shown(&self.mesh.nodes[k]))
    }

    /// Check that veins are lines from base to tip, straight ones or along edges of triangles.
    fn veins(&self, edges: &[MeshEdge], faults: &mut Faults) {
        let key_of = |[a, b]: [usize; 2]| [a.min(b), a.max(b)];
        let edges: BTreeSet<_> = edges.iter().map(|edge| key_of(edge.nodes)).collect();
        let corners: BTreeSet<_> = self.mesh.triangles.iter().flatten().collect();
        let mut taken = BTreeSet::new();
        for (i, vein) in self.wing.veins.iter().enumerate() {
            let (key, nodes) = (format!("{}.veins[{i}].chain", self.key), self.vein(i));
            let mut refuse = |reason: String| faults.require(false, &key, format!("{:?}", vein.chain), || reason);
            let torsion = vein.torsional_stiffness > 0.0;
            let stiff = vein.bending_stiffness > 0.0;
            let bend = self.mesh.bend(nodes).filter(|(_, bend)| stiff && !torsion || *bend != Bend::Turn);
            let mut steps = nodes.windows(2).filter(|_| torsion).map(|ends| [ends[0], ends[1]]);
            let off =
                steps.clone().find(|ends| ends.iter().all(|k| corners.contains(k)) && !edges.contains(&key_of(*ends)));
            let shared = steps.find(|ends| !taken.insert(key_of(*ends)));
            if self.wing.veins[..i].iter().any(|other| other.chain == vein.chain) {
                refuse("another vein lies along this chain".into());
            } else if nodes.len() < 2 {
                refuse("the chain has one node, and a vein at least two".into());
            } else if let Some((k, bend)) = bend {
                refuse(match bend {
                    Bend::Point => format!("its {} and the next lie in one place", self.shown(k)),
                    Bend::Fold => format!("it folds back at its {} and a vein has each place once", self.shown(k)),
                    Bend::Turn => format!(
                        "it turns at its {} and a vein is straight at rest: give it a `torsional_stiffness`, or no \
                         `bending_stiffness`",
                        self.shown(k)
                    ),
                });
            } else if let Some([a, b]) = off {
                let reason = "share no edge of a triangle: a vein with torsion runs along edges";
                refuse(format!("its {} and node {b} {reason}", self.shown(a)));
            } else if let Some([a, b]) = shared {
                refuse(format!("its {} and node {b} lie on another vein with torsion", self.shown(a)));
            } else if self.held[nodes[nodes.len() - 1]] && !self.held[nodes[0]] {
                refuse(
                    "it ends at the root, and a vein runs from base to tip: turn the list of its nodes round".into(),
                );
            }
            let key = format!("{}.veins[{i}].bending_stiffness", self.key);
            faults.require(stiff || !torsion, &key, vein.bending_stiffness, || {
                "a vein with torsion needs it above 0".into()
            });
        }
    }

    /// Check that the wing is of one part or that the root holds each, and that the support can hold it.
    fn root(&self, edges: &[MeshEdge], faults: &mut Faults) {
        let Self { wing, mesh, held, key } = self;
        let veins = || (0..wing.veins.len()).map(|i| self.vein(i));
        if let Some(k) = mesh.unused(veins()) {
            let key = format!("{key}.mesh.triangles.nodes[{k}]");
            faults.require(false, &key, format!("{:?}", mesh.nodes[k]), || "it is in no triangle and no vein".into());
            return;
        }
        let parts = mesh.parts(veins());
        let holds: BTreeSet<_> = parts.iter().zip(held).filter(|(_, held)| **held).map(|(part, _)| *part).collect();
        let is_loose = |part: usize| if wing.root.is_some() { !holds.contains(&part) } else { part != 0 };
        if let Some(k) = parts.iter().position(|part| is_loose(*part)) {
            let twin = mesh.doubled().into_iter().find(|[a, b]| parts[*a] != parts[*b]);
            let twin = twin.map(|[a, b]| format!("; nodes {a} and {b} lie in one place")).unwrap_or_default();
            let count = parts.iter().filter(|part| **part == parts[k]).count();
            let from = if wing.root.is_some() { "the root" } else { "the rest" };
            faults.require(false, &format!("{key}.mesh"), "of several parts", || {
                format!("{count} nodes, as {} share no triangle and no vein with {from}{twin}", self.shown(k))
            });
        }
        let Some(root) = &wing.root else { return };
        let holds_edge = edges.iter().any(|edge| edge.nodes.iter().all(|k| held[*k]));
        let holds_vein = veins().any(|nodes| held[nodes[0]]);
        let (fits, support) = match wing.support {
            WingSupport::Pinned => (true, ""),
            WingSupport::Clamped => (holds_edge || holds_vein, "clamped"),
            WingSupport::Hinge { .. } => (holds_edge, "a hinge"),
        };
        let key = format!("{key}.root");
        faults.require(fits, &key, format!("{root:?}"), || {
            format!("it holds no edge of a triangle, which {support} needs; a wing that is pinned needs one node")
        });
        let all = held.iter().all(|held| *held);
        faults.require(!all, &key, format!("{root:?}"), || "it holds all nodes: nothing could move".into());
    }

    /// Check that regions have polygons without crossings, and triangles that no later region has.
    fn regions(&self, faults: &mut Faults) {
        let Self { wing, mesh, key, .. } = self;
        let groups = wing.mesh.groups();
        let bare = wing.membrane.is_none() && !wing.regions.is_empty();
        faults.forbid(bare, &format!("{key}.regions"), || "regions are parts of a `membrane`".into());
        let parts = region_triangles(wing, mesh);
        for (i, region) in wing.regions.iter().enumerate() {
            let own = format!("{key}.regions[{i}]");
            let Some(corners) = &region.polygon else {
                let is_group = groups.iter().any(|group| group.name == region.name);
                faults.require(is_group, &format!("{own}.name"), format!("{:?}", region.name), || match groups {
                    [] => "the mesh has no groups: a region needs a `polygon`".into(),
                    _ => {
                        let names = list(groups.iter().map(|group| &group.name), "and");
                        format!("the groups of the mesh are {names}; another region needs a `polygon`")
                    }
                });
                continue;
            };
            let own = format!("{own}.polygon");
            check_corners(corners, true, &own, faults);
            faults.require(!parts[i].is_empty(), &own, format!("{corners:?}"), || {
                "the middle of a triangle must lie inside".into()
            });
        }
        for (i, region) in wing.regions.iter().enumerate().filter(|(i, _)| !parts[*i].is_empty()) {
            let seen = parts[i].iter().any(|t| !parts[i + 1..].iter().any(|later| later.contains(t)));
            faults.require(seen, &format!("{key}.regions[{i}]"), format!("{:?}", region.name), || {
                "later regions have all of its triangles".into()
            });
        }
    }
}
