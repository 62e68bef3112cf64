//! What may be a mistake in a scene, known before a run: places of its parts, the motions that laws prescribe, streams
//! that meet their own wake, wakes that stay symmetric, weights that no rod carries.

use serde::Serialize;

use crate::body::Body;
use crate::figure::{Cord, Figure, Sheet};
use crate::fluid::Fluid;
use crate::law::TimeLaw;
use crate::places::{self, AXES, Line, Obstacle, beyond, rounded, shown};
use crate::plane::{Outline, Point};
use crate::root::{RootLaws, RootMotion, RootSupport};
use crate::scene::{BeamWithRod, Scene};
use crate::space::Vector;

/// Times at which motions are looked at, over the whole run and once more at its beginning.
const TIMES: usize = 2000;

/// Times in a period of the fastest motion, at its beginning.
const TIMES_PER_PERIOD: f64 = 40.0;

/// Least Reynolds number at which the wake of a body may shed vortices: 47 for a cylinder (Provansal et al. 1987).
const SHEDDING: f64 = 45.0;

/// Least Reynolds number at which a body that is round on all sides may: 270 for a sphere (Johnson & Patel 1999).
const SHEDDING_ROUND: f64 = 270.0;

/// Tips of clamped linear beams sink by this number of lengths, times 8, under a weight that is hardly meant.
const HEAVIEST: f64 = 300.0;

/// Difference of the velocities of sponge and stream by the larger one above which it is told of.
const OTHER: f64 = 0.05;

/// Times at which they are compared.
const OTHER_TIMES: usize = 200;

/// Weight by bending stiffness of a rod in a fluid that is a chain.
const CHAIN: f64 = 1e5;

/// Largest strain under the own weight.
const STRETCH: f64 = 0.1;

/// What may be a mistake in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// Path of the key.
    pub key: String,
    /// Time from which it holds, s; absent where it holds from the start.
    pub time: Option<f64>,
    /// The whole as a sentence.
    pub text: String,
}

/// Return what may be a mistake in a scene without faults.
pub(crate) fn warnings(scene: &Scene, reynolds: Option<f64>) -> Vec<Warning> {
    let mut found = Vec::new();
    if let Some(fluid) = &scene.fluid {
        let parts = parts(scene, fluid);
        meetings(scene, fluid, &parts, &mut found);
        found.extend(own_wake(scene, fluid, &parts));
        found.extend(probes(fluid, &parts));
        found.extend(other_sponge(scene, fluid));
        found.extend(symmetry(scene, fluid, &parts, reynolds));
    }
    found.extend(scene.beams_with_rods().filter_map(|own| weight(scene, &own)));
    found
}

/// A body, a beam or the wing, which the fluid sees; what a law drives at its root moves as if it were rigid.
struct Part<'a> {
    key: String,
    motion: Motion<'a>,
    /// Index of the cylinder that holds the beam, which is a part of this index too.
    support: Option<usize>,
    kind: Kind,
    /// Half the thickness of a beam, m; infinite for others.
    half: f64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Body,
    Beam,
    Wing,
}

/// The motion of a part over time.
enum Motion<'a> {
    Rigid { body: Box<Body>, ends: Vec<[f64; 2]> },
    Still(Figure),
    Root { nodes: Vec<Vector>, form: Form, pivot: Vector, laws: &'a RootLaws },
}

/// The figure through nodes.
enum Form {
    /// Of half that thickness in the plane, m.
    Strip(f64),
    /// Of half that thickness in space, m.
    Cord(f64),
    /// Of these triangles.
    Sheet(Vec<[usize; 3]>),
}

impl Form {
    fn through(&self, nodes: Vec<Vector>) -> Figure {
        match self {
            Self::Strip(half) => Figure::Flat(strip(&nodes.iter().map(|&[x, y, _]| [x, y]).collect::<Vec<_>>(), *half)),
            Self::Cord(half) => Figure::Cord(Cord::new(nodes, *half)),
            Self::Sheet(triangles) => Figure::Sheet(Sheet::new(nodes, triangles.clone())),
        }
    }
}

impl<'a> Motion<'a> {
    /// The motion of what is held at its root.
    fn of_root(nodes: Vec<Vector>, form: Form, pivot: Vector, laws: Option<&'a RootLaws>) -> Self {
        match laws {
            Some(laws) => Self::Root { nodes, form, pivot, laws },
            None => Self::Still(form.through(nodes)),
        }
    }
}

impl Part<'_> {
    fn at(&self, t: f64) -> Figure {
        match &self.motion {
            Motion::Rigid { body, ends } => body.figure_at(t, ends),
            Motion::Still(figure) => figure.clone(),
            Motion::Root { nodes, form, pivot, laws } => {
                form.through(nodes.iter().map(|node| laws.moved(*node, *pivot, t)).collect())
            }
        }
    }

    fn moves(&self) -> bool {
        match &self.motion {
            Motion::Rigid { body, .. } => body.laws().is_some(),
            Motion::Still(_) => false,
            Motion::Root { .. } => true,
        }
    }

    /// Return the laws of the motion.
    fn laws(&self) -> Vec<&TimeLaw> {
        match &self.motion {
            Motion::Rigid { body, .. } => {
                body.laws().into_iter().flat_map(|own| [&own.x, &own.y, &own.z, &own.angle]).collect()
            }
            Motion::Still(_) => Vec::new(),
            Motion::Root { laws, .. } => {
                [&laws.x, &laws.y, &laws.z].into_iter().chain(laws.rotations.iter().map(|turn| &turn.angle)).collect()
            }
        }
    }

    /// Return the name in a sentence.
    fn name(&self) -> String {
        let rigid = match self.kind {
            Kind::Beam if self.moves() => " (as a rigid beam)",
            Kind::Wing if self.moves() => " (as a rigid wing)",
            _ => "",
        };
        format!("`{}`{rigid}", self.key)
    }
}

/// Return the outline of a line of that half thickness.
fn strip(points: &[Point], half: f64) -> Outline {
    let last = points.len() - 1;
    let side = |sign: f64| {
        (0..=last).map(move |i| {
            let (a, b) = (points[i.saturating_sub(1)], points[(i + 1).min(last)]);
            let length = f64::hypot(b[0] - a[0], b[1] - a[1]).max(f64::MIN_POSITIVE);
            let normal = [(a[1] - b[1]) / length, (b[0] - a[0]) / length];
            [points[i][0] + sign * half * normal[0], points[i][1] + sign * half * normal[1]]
        })
    };
    Outline::new(side(-1.0).chain(side(1.0).rev()))
}

fn parts<'a>(scene: &'a Scene, fluid: &Fluid) -> Vec<Part<'a>> {
    let ends: Vec<_> = fluid.r#box.ends().collect();
    let rigid = |Obstacle { key, body, .. }| Part {
        key,
        motion: Motion::Rigid { body: Box::new(body), ends: ends.clone() },
        support: None,
        kind: Kind::Body,
        half: f64::INFINITY,
    };
    let beams = scene.beams_with_rods().zip(places::lines(scene)).map(|(own, line)| {
        let laws = match own.rod.and_then(|rod| rod.root_motion.as_ref()) {
            Some(RootMotion::Laws(laws)) => Some(laws),
            _ => None,
        };
        let Line { key, nodes, half_thickness: half, support, .. } = line;
        let form = if fluid.is_space() { Form::Cord(half) } else { Form::Strip(half) };
        let root = nodes[0];
        Part { key, motion: Motion::of_root(nodes, form, root, laws), support, kind: Kind::Beam, half }
    });
    let wing = scene.wing.as_ref().map(|wing| {
        let mesh = wing.mesh.build();
        let (form, laws) = (Form::Sheet(mesh.triangles), wing.root_motion.as_ref());
        let motion = Motion::of_root(mesh.nodes, form, wing.pivot, laws);
        Part { key: "wing".into(), motion, support: None, kind: Kind::Wing, half: f64::INFINITY }
    });
    places::obstacles(fluid).into_iter().map(rigid).chain(beams).chain(wing).collect()
}

/// Return times of the run, from 0 on: closely at the beginning, then over all of it.
fn times(end: f64, parts: &[Part]) -> Vec<f64> {
    let fastest = parts.iter().flat_map(|part| part.laws()).filter_map(TimeLaw::frequency).fold(0.0, f64::max);
    let coarse = end / TIMES as f64;
    let fine = if fastest > 0.0 { f64::min(1.0 / (TIMES_PER_PERIOD * fastest), coarse) } else { coarse };
    let mut times: Vec<_> = (0..=TIMES).map(|i| i as f64 * fine).collect();
    let begin = fine * TIMES as f64;
    times.extend((0..=TIMES).map(|i| i as f64 * coarse).filter(|t| *t > begin));
    times
}

/// Add where parts reach over the edge of the box, into walls or zones, or meet one another, each once.
fn meetings(scene: &Scene, fluid: &Fluid, parts: &[Part], found: &mut Vec<Warning>) {
    let start: Vec<_> = parts.iter().map(|part| part.at(0.0)).collect();
    let known: Vec<Vec<String>> =
        start.iter().zip(parts).map(|(outline, part)| told(fluid, outline, part, 0.0, None, found)).collect();
    let lines = places::lines(scene);
    let bodies = parts.iter().filter(|part| part.kind == Kind::Body).count();
    for (j, (part, outline)) in parts.iter().zip(&start).enumerate() {
        for (i, other) in parts[..j].iter().enumerate() {
            let overlap = match (part.kind, other.kind) {
                (Kind::Body, Kind::Body) => start[i].overlaps(outline, 0.0),
                (Kind::Beam, Kind::Beam) => {
                    let [one, two] = [i, j].map(|part| &lines[part - bodies]);
                    one.overlaps(two)
                }
                _ => false, // Roots may be embedded
            };
            if overlap {
                let at = between(&start[i], outline);
                found.push(warning(part, 0.0, format!("{} overlaps `{}` near {at}", part.name(), other.key)));
            }
        }
    }
    if !parts.iter().any(Part::moves) {
        return;
    }
    let cell = fluid.r#box.spacing().into_iter().fold(f64::INFINITY, f64::min);
    let depth = |i: usize, j: usize| (cell / 4.0).min(parts[i].half / 2.0).min(parts[j].half / 2.0);
    let mut known = known;
    let mut met: Vec<_> =
        (0..parts.len()).map(|j| (0..j).map(|i| start[i].overlaps(&start[j], depth(i, j))).collect()).collect();
    let met: &mut Vec<Vec<bool>> = &mut met;
    for t in times(scene.time.end, parts).into_iter().skip(1) {
        let now: Vec<_> = parts
            .iter()
            .zip(&start)
            .map(|(part, still)| if part.moves() { part.at(t) } else { still.clone() })
            .collect();
        for (j, part) in parts.iter().enumerate() {
            if part.moves() {
                let more = told(fluid, &now[j], part, t, Some((&start[j], &known[j])), found);
                known[j].extend(more);
            }
            for (i, other) in parts[..j].iter().enumerate() {
                let apart = !met[j][i] && part.support != Some(i) && (part.moves() || other.moves());
                if apart && now[i].overlaps(&now[j], depth(i, j)) {
                    met[j][i] = true;
                    let at = between(&now[i], &now[j]);
                    let (name, other) = (part.name(), other.name());
                    found.push(warning(part, t, format!("{name} meets {other} near {at}")));
                }
            }
        }
    }
}

fn warning(part: &Part, t: f64, text: String) -> Warning {
    let time = (t > 0.0).then_some(t);
    let when = time.map_or("at the start".into(), |t| format!("at t = {} s", rounded(t)));
    Warning { key: part.key.clone(), time, text: format!("{text} {when}") }
}

/// Return the middle of the place that two outlines share.
fn between(a: &Figure, b: &Figure) -> String {
    let pairs = a.frame().iter().zip(b.frame());
    shown(&pairs.map(|(a, b)| (a[0].max(b[0]) + a[1].min(b[1])) / 2.0).collect::<Vec<_>>())
}

/// Add what is to be told of the place of a part alone at time `t` (s), and return the names of it; what a part did at
/// the start, or is known, is left out.
fn told(
    fluid: &Fluid,
    figure: &Figure,
    part: &Part,
    t: f64,
    before: Option<(&Figure, &Vec<String>)>,
    found: &mut Vec<Warning>,
) -> Vec<String> {
    let cell = fluid.r#box.spacing();
    let mut names = Vec::new();
    let mut tell = |name: &str, text: String| {
        if !before.is_some_and(|(_, known)| known.iter().any(|other| other == name)) {
            names.push(name.to_string());
            found.push(warning(part, t, text));
        }
    };
    let (name, frame) = (part.name(), figure.frame());
    for (axis, bounds) in fluid.r#box.ends().enumerate() {
        let over = beyond(frame[axis][0], bounds).max(beyond(frame[axis][1], bounds));
        if over > 1e-9 * (bounds[1] - bounds[0]) {
            let axis = AXES[axis];
            tell(
                "edge",
                format!(
                    "{name} reaches {} m over the edge of the box along {axis} and comes in at the other side",
                    rounded(over)
                ),
            );
        }
    }
    for (axis, walls) in places::walls(fluid) {
        let depth = |figure: &Figure| figure.frame()[axis].iter().map(|&at| beyond(at, walls)).fold(0.0, f64::max);
        let (now, start) = (depth(figure), before.map_or(0.0, |(start, _)| depth(start)));
        // A beam may be embedded in a wall.
        if now > start + cell[axis] && (before.is_some() || part.kind == Kind::Body) {
            tell("wall", format!("{name} reaches {} m into a wall of the channel", rounded(now)));
        }
    }
    if before.is_some()
        && let Some(reason) = places::blocked(fluid, figure)
    {
        tell("stream", format!("{name} {reason}"));
    }
    let inflow = fluid.inflow.as_ref().map(|inflow| ("inflow zone", inflow.x));
    let sponge = fluid.sponge.as_ref().map(|sponge| ("sponge", sponge.x));
    for (zone, [low, high]) in inflow.into_iter().chain(sponge) {
        let shared = frame[0][1].min(high) - frame[0][0].max(low);
        if shared > cell[0] * (1.0 + 1e-9) {
            tell(zone, format!("{name} reaches {} m into the {zone}, x [{low}, {high}],", rounded(shared)));
        }
    }
    names
}

/// Return what is to be told of probes that a body or a wall covers at the start.
fn probes(fluid: &Fluid, parts: &[Part]) -> Vec<Warning> {
    let rigid: Vec<_> =
        parts.iter().filter(|part| part.kind == Kind::Body).map(|part| (&part.key, part.at(0.0))).collect();
    let walls = places::walls(fluid);
    let covered = |p: &[f64]| {
        let body = rigid.iter().find(|(_, figure)| figure.contains(p)).map(|(key, _)| format!("`{key}`"));
        let in_wall = walls.iter().any(|(axis, ends)| p.get(*axis).is_some_and(|at| beyond(*at, *ends) > 0.0));
        body.or_else(|| in_wall.then(|| "a wall of the channel".into()))
    };
    let found = fluid.probes.iter().enumerate().filter_map(|(i, probe)| {
        let cover = covered(&probe.position)?;
        let (key, at) = (format!("fluid.probes[{i}].position"), shown(&probe.position));
        let text = format!("the probe `{}` at {at} lies in {cover} at the start, not in the fluid", probe.name);
        Some(Warning { key, time: None, text })
    });
    found.collect()
}

/// Return what is to be told of a sponge that brakes or drives the stream.
fn other_sponge(scene: &Scene, fluid: &Fluid) -> Option<Warning> {
    let sponge = &fluid.sponge.as_ref()?.mean_velocity;
    let (key, stream) = match (&fluid.inflow, &fluid.mean_flow) {
        (Some(inflow), _) => ("fluid.inflow.mean_velocity", &inflow.mean_velocity),
        (None, Some(mean)) => ("fluid.mean_flow.x", &mean.x),
        _ => return None,
    };
    let end = scene.time.end;
    let times = (0..=OTHER_TIMES).map(|i| end * i as f64 / OTHER_TIMES as f64);
    let apart = |t: f64| (sponge.value(t) - stream.value(t)).abs();
    let most = times.max_by(|a, b| apart(*a).total_cmp(&apart(*b)))?;
    let (given, wanted) = (rounded(sponge.value(most)), rounded(stream.value(most)));
    (apart(most) > OTHER * sponge.largest().max(stream.largest())).then(|| Warning {
        key: "fluid.sponge.mean_velocity".into(),
        time: Some(most),
        text: format!(
            "`fluid.sponge.mean_velocity` is {given} m/s and `{key}` {wanted} m/s at t = {} s: the sponge works \
             against the stream",
            rounded(most)
        ),
    })
}

/// Return what is to be told of a stream that meets its own wake. An inflow renews it, a sponge what passes along x.
fn own_wake(scene: &Scene, fluid: &Fluid, parts: &[Part]) -> Option<Warning> {
    if fluid.inflow.is_some() || parts.is_empty() {
        return None;
    }
    let steps = TIMES as f64;
    let h = scene.time.end / steps;
    let velocity = |axis: usize, t: f64| match &fluid.mean_flow {
        Some(mean) => mean.laws()[axis].1.value(t),
        None => fluid.initial_velocity.get(axis).copied().unwrap_or(0.0),
    };
    let [begin, end] = fluid.r#box.x;
    for (axis, [low, high]) in fluid.r#box.ends().enumerate() {
        let (mut way, mut way_x) = (0.0, 0.0);
        for i in 0..TIMES {
            way += h * velocity(axis, (i as f64 + 0.5) * h);
            way_x += h * velocity(0, (i as f64 + 0.5) * h);
            if fluid.sponge.is_some() && f64::abs(way_x) >= end - begin {
                break;
            }
            if f64::abs(way) >= high - low {
                let (key, time) = ("fluid.sponge".to_string(), (i + 1) as f64 * h);
                let name = parts[0].name();
                let text = format!(
                    "the stream along {} passes the periodic box without a `sponge`: {name} is in its own wake from \
                     t = {:.3} s on, and forces are off by tens of per cent",
                    AXES[axis],
                    rounded(time)
                );
                return Some(Warning { key, time: Some(time), text });
            }
        }
    }
    None
}

/// Return what is to be told of a scene whose wake stays symmetric.
fn symmetry(scene: &Scene, fluid: &Fluid, parts: &[Part], reynolds: Option<f64>) -> Option<Warning> {
    let driven = scene.beams_with_rods().any(|own| own.rod.is_some_and(|rod| rod.root_motion.is_some()))
        || scene.wing.as_ref().is_some_and(|wing| wing.root_motion.is_some());
    if parts.is_empty() || driven || fluid.disturbance.is_some() {
        return None;
    }
    let (ends, figures): (Vec<_>, Vec<_>) =
        (fluid.r#box.ends().collect(), parts.iter().map(|part| part.at(0.0)).collect());
    let fills = |axis: usize| {
        let [low, high]: [f64; 2] = ends[axis];
        figures.iter().any(|figure| figure.frame()[axis][1] - figure.frame()[axis][0] >= (high - low) * (1.0 - 1e-9))
    };
    let streams =
        |axis: usize| places::streams(fluid)[axis] || fluid.initial_velocity.get(axis).is_some_and(|u| *u != 0.0);
    let axis = (0..ends.len()).find(|&axis| streams(axis))?;
    let mut across: Vec<_> = (0..ends.len()).filter(|&other| other != axis && !fills(other)).collect();
    // What is flat is moved and sheds across itself, and a rigid plate along the stream does neither.
    let is_flat = |axis: usize| figures.iter().all(|figure| figure.frame()[axis][0] == figure.frame()[axis][1]);
    if across.iter().any(|&axis| is_flat(axis)) {
        across.retain(|&axis| is_flat(axis) && parts.iter().any(|part| part.kind != Kind::Body));
    }
    let is_round = across.len() == 2 && figures.iter().all(|figure| matches!(figure, Figure::Solid(_)));
    // A wing has no length among the dimensionless numbers.
    let of_wing = || {
        let frame = figures.last()?.frame();
        let mean = fluid.mean_flow.as_ref().map_or(0.0, |mean| mean.laws()[axis].1.largest());
        let speed = fluid.initial_velocity.get(axis).copied().unwrap_or(0.0).abs().max(mean);
        Some(speed * (frame[axis][1] - frame[axis][0]) / fluid.kinematic_viscosity)
    };
    let reynolds = if scene.wing.is_some() { of_wing() } else { reynolds };
    if across.is_empty() || reynolds.is_none_or(|re| re < if is_round { SHEDDING_ROUND } else { SHEDDING }) {
        return None;
    }
    let middles: Option<Vec<_>> = across
        .iter()
        .map(|&axis| if streams(axis) { None } else { plane_of_symmetry(scene, fluid, parts, &figures, axis) })
        .collect();
    let planes: Vec<_> =
        middles?.iter().zip(&across).map(|(at, &axis)| format!("{} = {}", AXES[axis], rounded(*at))).collect();
    let (key, remedy) = match fluid.is_space() {
        true => (
            "fluid.mean_flow",
            "a short pulse of `fluid.mean_flow` across it, or a place off the lines of the grid, makes",
        ),
        false => ("fluid.disturbance", "`fluid.disturbance` makes"),
    };
    Some(Warning {
        key: key.into(),
        time: None,
        text: format!(
            "bodies and stream are mirror images at {}: the wake may never shed vortices, and drag and lift are then \
             too small; {remedy} the start asymmetric",
            planes.join(" and at ")
        ),
    })
}

/// Return the middle of parts, their forces and the grid if they are mirror images along `across`.
fn plane_of_symmetry(scene: &Scene, fluid: &Fluid, parts: &[Part], figures: &[Figure], across: usize) -> Option<f64> {
    let mut laws = parts.iter().flat_map(|part| match &part.motion {
        Motion::Rigid { body, .. } => body
            .laws()
            .into_iter()
            .flat_map(|motion| [[&motion.x, &motion.y, &motion.z][across], &motion.angle])
            .collect(),
        _ => Vec::new(),
    });
    let released = fluid.bodies.iter().filter_map(|body| body.mount.as_ref()).any(|mount| {
        let supports = mount.supports();
        [supports[across.min(1)], supports[2]].into_iter().flatten().any(|own| own.rest * own.stiffness != 0.0)
    });
    let moved = released || fluid.bodies.iter().any(Body::is_driven) || laws.any(|law| law.largest_rate() > 0.0);
    let mut pulls = scene.beams_with_rods().filter_map(|own| own.rod?.gravity.get(across).copied());
    if moved || pulls.any(|g| g != 0.0) || scene.wing.as_ref().is_some_and(|wing| wing.gravity[across] != 0.0) {
        return None;
    }
    let middles = figures.iter().map(|figure| figure.frame()[across].iter().sum::<f64>() / 2.0);
    let middle = middles.sum::<f64>() / figures.len() as f64;
    let sides = figures.iter().flat_map(|figure| figure.frame().iter().map(|[low, high]| high - low));
    let close = 1e-9 * sides.fold(0.0, f64::max);
    let walls = places::walls(fluid).into_iter().find(|(axis, _)| *axis == across);
    let off_walls = walls.is_some_and(|(_, [low, high])| ((low + high) / 2.0 - middle).abs() > close);
    // The grid is symmetric at its lines and halfway between them.
    let [low, _] = fluid.r#box.ends().nth(across)?;
    let halves = 2.0 * (middle - low) / fluid.r#box.spacing()[across];
    let is_symmetric = || figures.iter().all(|figure| figure.is_mirrored(figures, across, middle, close));
    (!off_walls && (halves - halves.round()).abs() <= 1e-6 && is_symmetric()).then_some(middle)
}

/// Return what is to be told of a rod that is too heavy for its stiffness.
fn weight(scene: &Scene, own: &BeamWithRod) -> Option<Warning> {
    let rod = own.rod?;
    let (_, direction) = scene.beam_root(own.beam);
    let g = rod.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let along: f64 = rod.gravity.iter().zip(direction).map(|(g, d)| g * d).sum();
    let section = rod.material.section(&own.beam.thickness, 0.0);
    let length = own.beam.length;
    let bending = section.line_density * length.powi(3) / section.bending_stiffness;
    let stretch = section.line_density * g * length / section.axial_stiffness;
    let held = matches!(rod.root, RootSupport::Clamped | RootSupport::TorsionSpring { .. });
    let sinks = bending * (g * g - along * along).max(0.0).sqrt();
    let key = format!("{}rod.gravity", own.key());
    let effect = if stretch > STRETCH {
        format!("its weight stretches it by {:.2} of its length", stretch)
    } else if held && sinks > HEAVIEST {
        format!("as a linear beam it would sink by {:.0} lengths", sinks / 8.0)
    } else if scene.fluid.is_some() && bending * g > CHAIN {
        format!("its weight is {:.1e} of its bending stiffness", bending * g)
    } else {
        return None;
    };
    let name = own.name.map_or(String::new(), |name| format!(" `{name}`"));
    let text = format!("the rod{name} is too heavy for its stiffness: under `{key}`, {} m/s², {effect}", rounded(g));
    Some(Warning { key, time: None, text })
}
