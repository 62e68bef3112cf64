//! Warnings about the places of bodies, beams and the wing over time: before a run as far as laws move them, and during
//! a run. Contact keeps bodies on a mount apart from other bodies.

use std::collections::BTreeMap;

use geometry::vector::{minus, norm};
use geometry::{AXES, Bounds, Chain, Crossings, Shape, Surface, Touch, beyond, near_pairs};
use serde::{Deserialize, Serialize};

use crate::beam::Beam;
use crate::body::Body;
use crate::contact_checks;
use crate::fluid::Fluid;
use crate::places::{blocked, rounded, shown, walls, zones};
use crate::read::kept;
use crate::scene::Scene;
use crate::warning::Warning;

/// Change of the length of a rod, by the smaller of the length and that at rest, above which the run warns of it.
const STRETCH: f64 = 0.5;

/// Relative tolerance of a limit.
const ROUNDING: f64 = 1e-9;

/// A body, a beam or the wing.
pub(crate) struct Part {
    /// Path of its key.
    pub key: String,
    /// Name in a sentence.
    pub name: String,
    /// Shape at rest.
    pub rest: Shape,
    /// Whether it can move.
    pub moves: bool,
    /// Whether it can change its shape.
    pub deforms: bool,
    /// Largest thickness of a beam, m; infinite for others.
    pub thickness: f64,
    /// How far beyond its shape it drags the fluid, m.
    pub reach: f64,
    /// Whether it is on a mount, where the key `contact` acts on it.
    pub is_mounted: bool,
    /// Whether it is a body that the master moves, which rods and wings do not touch.
    pub is_driven: bool,
    /// Whether it is the body of the flyer, or what that carries and does not touch.
    pub of_flyer: bool,
}

impl Part {
    fn is_body(&self) -> bool {
        self.key.starts_with("fluid.")
    }
}

/// What is known of the parts from earlier times.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Memory {
    /// How far each thing had gone at the first time, m; none once it is warned of: a root may be embedded.
    reached: BTreeMap<String, Option<f64>>,
    /// Edges or triangles of the second part that touched the first part of a pair then; an empty list of a body.
    touched: BTreeMap<String, Vec<usize>>,
}

/// Checks the places of parts again and again, and warns of each thing once.
pub(crate) struct Monitor<'a> {
    pub scene: &'a Scene,
    pub parts: Vec<&'a Part>,
    /// None before the first time.
    pub memory: Option<Memory>,
    /// Number of dimensions.
    pub axes: usize,
    /// Whether nobody warns of the places at the first time, which were checked before the run.
    pub is_run: bool,
}

/// Takes the name of a limit, how far a part has gone and how far it may, whether nobody warns of where it is at the
/// first time, and a sentence without name and time.
type See<'a> = &'a mut dyn FnMut(&str, [f64; 2], bool, &dyn Fn() -> String);

impl Monitor<'_> {
    /// Return the warnings at time `t` (s) from the present shapes; the place of a part may be unknown.
    pub fn check(&mut self, t: f64, now: &[Option<Shape>]) -> Vec<Warning> {
        let (mut found, is_first) = (Vec::new(), self.memory.is_none());
        let (fluid, has_contact) = (self.scene.fluid.as_ref(), self.scene.contact.is_some());
        let lacks_contact = || !has_contact && contact_checks::is_possible(self.scene);
        let memory = self.memory.get_or_insert_default();
        let known = self.parts.iter().zip(now).filter_map(|(part, shape)| Some((*part, shape.as_ref()?)));
        let known: Vec<_> = known.collect();
        for (part, shape) in &known {
            let is_run = self.is_run;
            let see: See = &mut |limit, [reached, allowed], may_start, text| {
                let first = Some(if is_run || may_start { reached } else { 0.0 });
                let before = memory.reached.entry(format!("{} {limit}", part.key)).or_insert(first);
                if before.is_some_and(|before| reached > before + allowed) {
                    *before = None;
                    found.push(warning(&part.key, t, &format!("{} {}", part.name, text())));
                }
            };
            if let Some(fluid) = fluid.filter(|_| part.moves || (!is_run && t == 0.0)) {
                // Before a run a rod or a wing counts as rigid, but contact bends it at a wall.
                let is_held_off = has_contact && !is_run && !part.is_body();
                limits(fluid, part, shape, is_held_off, &lacks_contact, see);
            }
            if part.deforms {
                own_shape(part, shape, self.axes, see);
            }
        }
        let cell = fluid.map_or(0.0, |fluid| fluid.spacing().into_iter().fold(f64::INFINITY, f64::min));
        let bounds: Vec<_> = known.iter().map(|(_, shape)| shape.bounds()).collect();
        for [i, j] in near_pairs(&bounds, cell) {
            let (one, two) = (known[i], known[j]);
            let is_surface = |(_, shape): (_, &Shape)| matches!(shape, Shape::Surface(_));
            if self.is_run
                && fluid.is_some()
                && !has_contact
                && (one.0.deforms || two.0.deforms)
                && is_surface(one)
                && is_surface(two)
                && let Some(place) = memory.meets("nears", one, two, cell, is_first)
            {
                let (name, other, at) = (&two.0.name, &one.0.name, shown(&place[..self.axes]));
                let text = format!("{name} comes within a cell of {other} near {at}, where their kernels overlap,");
                found.push(warning(&two.0.key, t, &text));
            }
            let touches = match (one.0.is_body(), two.0.is_body()) {
                (true, true) => one.0.is_mounted || two.0.is_mounted,
                (false, false) => true,
                _ => {
                    let body = if one.0.is_body() { one.0 } else { two.0 };
                    !body.is_driven || (body.of_flyer && !(one.0.of_flyer && two.0.of_flyer))
                }
            };
            if (one.0.moves || two.0.moves)
                && !(touches && has_contact)
                && let Some(place) = memory.meets("meets", one, two, cell / 4.0, is_first)
            {
                let rounding = ROUNDING * norm(place);
                let place = place.map(|at| if at.abs() < rounding { 0.0 } else { at });
                let at = shown(&place[..self.axes]);
                let help = if touches && lacks_contact() { " without the key `contact`" } else { "" };
                let text =
                    format!("{} meets {} near {at}, and nothing keeps them apart{help},", two.0.name, one.0.name);
                found.push(warning(&two.0.key, t, &text));
            }
        }
        found
    }
}

impl Memory {
    /// Return where two parts meet, closer than `depth` (m) and beyond what touched at the first time, once under this
    /// `verb`.
    fn meets(
        &mut self,
        verb: &str,
        (one, shape): (&Part, &Shape),
        (other, other_shape): (&Part, &Shape),
        depth: f64,
        is_first: bool,
    ) -> Option<[f64; 3]> {
        let pair = format!("{} {verb} {}", other.key, one.key);
        if self.reached.contains_key(&pair) {
            return None;
        }
        let touch = shape.touched_by(other_shape, depth)?;
        let elements = if let Touch::At(elements) = &touch { elements.as_slice() } else { &[] };
        if is_first {
            self.touched.insert(pair, elements.to_vec());
            return None;
        }
        let is_new = |start: &Vec<usize>| {
            let half = if one.thickness.is_finite() { one.thickness / 2.0 } else { 0.0 };
            let margin = 2.0 * (half + (0..other.rest.elements()).map(|k| other.rest.size(k)).fold(0.0, f64::max));
            let apart = |a: usize, b: usize| norm(minus(other.rest.middle(a), other.rest.middle(b)));
            elements.iter().any(|&k| start.iter().all(|&known| apart(k, known) > margin))
        };
        self.touched.get(&pair).is_none_or(is_new).then(|| {
            self.reached.insert(pair, None);
            other_shape.place(&touch, shape)
        })
    }
}

/// Return the sentence of a warning with its time.
fn warning(key: &str, t: f64, text: &str) -> Warning {
    let time = (t > 0.0).then_some(t);
    let when = time.map_or("at the start".into(), |t| format!("at t = {} s", rounded(t)));
    Warning { key: key.into(), time, text: format!("{text} {when}") }
}

/// Show how far a part reaches over the edges of the box, into walls that do not hold it off and zones, and whether it
/// stops the stream.
fn limits(fluid: &Fluid, part: &Part, shape: &Shape, is_held_off: bool, lacks_contact: &dyn Fn() -> bool, see: See) {
    let (cell, bounds): (_, Bounds<3>) = (fluid.spacing(), shape.bounds());
    let out = |axis: usize, ends| beyond(bounds[axis][0], ends).max(beyond(bounds[axis][1], ends));
    // What a wall holds off does not pass the edge behind it.
    let walls = walls(fluid);
    let is_free = |axis: usize| !is_held_off || walls.iter().all(|(across, _)| *across != axis);
    for (axis, ends) in fluid.r#box.ends().enumerate().filter(|(axis, _)| is_free(*axis)) {
        let (over, name) = (out(axis, ends), AXES[axis]);
        see(&format!("edge {name}"), [over, ROUNDING * (ends[1] - ends[0])], false, &|| {
            format!("reaches {} m over the edge of the box along {name} and comes in at the other side", rounded(over))
        });
    }
    for (axis, ends) in walls.iter().copied().filter(|_| !is_held_off) {
        let reached = out(axis, ends);
        // A beam may be embedded in a wall.
        see(&format!("wall {}", AXES[axis]), [reached, cell[axis].min(part.thickness)], !part.is_body(), &|| {
            let help = if part.is_mounted && lacks_contact() { ", without the key `contact`," } else { "" };
            format!("reaches {} m into a wall of the channel{help}", rounded(reached))
        });
    }
    if let Some(inner) =
        fluid.inner_of_fine_box().filter(|_| fluid.fine_box.as_ref().is_some_and(|fine| !fine.follows()))
    {
        for (axis, [low, high]) in inner.into_iter().enumerate() {
            // A run ends at the first point of the rim with drag.
            let over = out(axis, [low + part.reach, high - part.reach]);
            let ended = (over - cell[axis] * (1.0 - ROUNDING)).max(0.0);
            see(&format!("rim {}", AXES[axis]), [ended, 0.0], false, &|| {
                let [over, reach] = [over, part.reach].map(rounded);
                format!("reaches {over} m into the rim of `fine_box` with the {reach} m of its drag, where a run ends,")
            });
        }
    }
    let stops = blocked(fluid, shape);
    let is_blocked = f64::from(u8::from(stops.is_some()));
    see("stream", [is_blocked, 0.0], true, &|| stops.clone().unwrap_or_default());
    for (zone, [low, high]) in zones(fluid) {
        let shared = (bounds[0][1].min(high) - bounds[0][0].max(low)).max(0.0);
        see(zone, [shared, cell[0] * (1.0 + ROUNDING)], false, &|| {
            format!("reaches {} m into the {zone}, x [{low}, {high}],", rounded(shared))
        });
    }
}

/// Show how far a part that changes its shape stretches, and whether it meets itself.
fn own_shape(part: &Part, shape: &Shape, axes: usize, see: See) {
    match (shape, &part.rest) {
        (Shape::Chain(now), Shape::Chain(rest)) => {
            let ratio = (now.length() / rest.length()).max(ROUNDING);
            see("length", [ratio.max(1.0 / ratio) - 1.0, STRETCH], true, &|| {
                let ratio = format!("{ratio:.1e}").parse::<f64>().unwrap_or(ratio);
                format!("is {ratio} times as long as at rest: its axial stiffness is small for its loads")
            });
            let fold = now.fold();
            see("itself", [f64::from(u8::from(fold.is_some())), 0.0], true, &|| {
                let at = shown(&fold.unwrap_or_default()[..axes]);
                format!("meets itself near {at}, and nothing keeps its parts apart,")
            });
        }
        (Shape::Surface(surface), _) => {
            let (triangles, nodes) = (surface.triangles(), surface.nodes());
            let count = Crossings::new(triangles.len()).count(|k| triangles[k], |node| nodes[node]);
            see("itself", [count as f64, 0.0], true, &|| {
                "passes through itself, and nothing keeps its parts apart,".into()
            });
        }
        _ => (),
    }
}

/// Places of the parts of a run at one time.
#[derive(Deserialize)]
struct Places {
    /// Time, s.
    time: f64,
    /// What the answer of the time before has as `memory`.
    memory: Option<Memory>,
    /// Place of the pivot, m, and angle, in space rotation vector from rest, rad, of each body of the fluid; none where
    /// its laws say it.
    bodies: Vec<Option<Vec<f64>>>,
    /// Stations of each beam, m; none of one that nobody knows.
    beams: Vec<Option<Vec<Vec<f64>>>>,
    /// Nodes of each wing, m; none of one that nobody knows.
    wings: Vec<Option<Vec<[f64; 3]>>>,
}

/// Warnings and memory after one time of a run.
#[derive(Serialize)]
struct Answer {
    warnings: Vec<String>,
    memory: Option<Memory>,
}

/// Check the places of a run at one time, as a JSON object, for the text of its scene; return the sentences of new
/// `warnings`, and the `memory` for the next time. Without a scene it is `null`.
pub fn monitor_text(places: &str, scene: Option<&str>) -> String {
    let scene = scene.and_then(kept);
    let answer = scene.zip(serde_json::from_str(places).ok()).map(|(scene, places)| check_run(&scene, places));
    serde_json::to_string(&answer).expect("an answer is plain JSON")
}

fn check_run(scene: &Scene, places: Places) -> Answer {
    let fluid = scene.fluid.as_ref();
    let ends: Vec<_> = fluid.iter().flat_map(|fluid| fluid.r#box.ends()).collect();
    let (mut parts, mut now) = (Vec::new(), Vec::new());
    let keys = |is: fn(&Body) -> bool| -> Vec<_> {
        let all = fluid.iter().flat_map(|fluid| fluid.obstacles());
        all.filter(|own| is(&own.body)).map(|own| own.key).collect()
    };
    let (mounted, driven) = (keys(|body| body.mount.is_some()), keys(Body::is_driven));
    let shape = scene.flyer.as_ref().and_then(|flyer| flyer.shape);
    let rods = scene.beams_with_rods().map(|own| (own.name.unwrap_or("rod"), own.key() + "beam"));
    let wings = scene.wings().map(|own| (own.name, own.key));
    let carried = rods.chain(wings).filter(|(name, _)| scene.hinge_of(name).is_some()).map(|(_, key)| key);
    let of_flyer: Vec<_> = shape.map(|k| format!("fluid.bodies[{k}]")).into_iter().chain(carried).collect();
    let mut add = |key: String, name: String, shapes: [Option<Shape>; 2], moves: bool, beam: Option<&Beam>| {
        let of_flyer = of_flyer.contains(&key);
        if let [Some(rest), Some(shape)] = shapes {
            let [is_mounted, is_driven] = [&mounted, &driven].map(|keys| keys.contains(&key));
            let deforms = !key.starts_with("fluid.");
            let thickness = beam.map_or(f64::INFINITY, Beam::largest_thickness);
            let reach = fluid.map_or(0.0, |fluid| fluid.reach(&rest, beam));
            parts.push(Part { deforms, key, name, rest, moves, thickness, reach, is_mounted, is_driven, of_flyer });
            now.push(Some(shape));
        }
    };
    let cylinders = fluid.map_or(0, |fluid| fluid.cylinders.len());
    let free = (0..cylinders).map(|_| None).chain(places.bodies);
    for (own, pose) in fluid.iter().flat_map(|fluid| fluid.obstacles()).zip(free) {
        let (body, rest) = (&own.body, own.body.shape_at(0.0, &ends));
        let shape = match &pose {
            Some(pose) => {
                pose.split_at_checked(ends.len()).map(|(position, turn)| body.shape_in(position, turn, &ends))
            }
            None => Some(body.shape_at(places.time, &ends)),
        };
        add(own.key, own.name, [Some(rest), shape], pose.is_some(), None);
    }
    for (own, stations) in scene.beams_with_rods().zip(places.beams) {
        let stations_at = own.beam.places().step_by(2);
        let half: Vec<_> = stations_at.map(|s| own.beam.thickness.at(s) / 2.0).collect();
        let point = |p: &Vec<f64>| [0, 1, 2].map(|d| p.get(d).copied().unwrap_or(0.0));
        let stations: Option<Vec<_>> = stations.map(|all| all.iter().map(point).collect());
        let stations = stations.filter(|all| all.len() == half.len());
        let [rest, shape] = [Some(scene.beam_stations(own.beam)), stations]
            .map(|points| points.map(|points| Shape::Chain(Chain::new(points, &half))));
        let name = own.name.map_or("the rod".into(), |name| format!("the rod {name}"));
        add(own.key() + "beam", name, [rest, shape], true, Some(own.beam));
    }
    for (own, nodes) in scene.wings().zip(places.wings) {
        let (triangles, rest) = (own.wing.mesh.build().triangles, scene.wing_nodes(&own));
        let surface = |nodes| Shape::Surface(Surface::new(nodes, triangles.clone()));
        let nodes = nodes.filter(|nodes| nodes.len() == rest.len() && !triangles.is_empty());
        let name = own.number.map_or("the wing".into(), |_| format!("the wing {}", own.name));
        add(own.key, name, [Some(surface(rest)), nodes.map(surface)], true, None);
    }
    let axes = scene.dimensions();
    let mut monitor = Monitor { scene, parts: parts.iter().collect(), memory: places.memory, axes, is_run: true };
    let warnings = monitor.check(places.time, &now).into_iter().map(|warning| warning.text).collect();
    Answer { warnings, memory: monitor.memory }
}
