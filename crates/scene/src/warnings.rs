//! What may be a mistake in a scene, known before a run: places of its parts, the motions that laws prescribe, streams
//! that meet their own wake, wakes that stay symmetric, weights that no rod carries.

use std::iter;

use geometry::{AXES, Shape, Surface, Touch, beyond};

use crate::beam::Beam;
use crate::body::{Body, BodyMotion};
use crate::contact_warnings;
use crate::fault::legible;
use crate::fluid::{Fluid, Obstacle};
use crate::flyer::Flyer;
use crate::law::TimeLaw;
use crate::monitor::{Monitor, Part};
use crate::mount::Freedom;
use crate::places::{self, Line, rounded, shown, three_digits};
use crate::root::{RootLaws, RootSupport};
use crate::scene::{BeamWithRod, Scene};
use crate::warning::Warning;
use crate::wing_checks;

/// Most times at which motions are checked, over the whole run and once more at its beginning.
const TIMES: usize = 2000;

/// Most shapes at the times of either, and least times where too many parts move.
const MOST_SHAPES: usize = 100_000;
const FEWEST_TIMES: usize = 100;

/// Edges or triangles that count like a shape.
const ELEMENTS: usize = 100;

/// Times in a period of the fastest motion, at its beginning.
const TIMES_PER_PERIOD: f64 = 40.0;

/// Least Reynolds number at which the wake of a body may shed vortices: 47 for a cylinder (Provansal et al. 1987).
const SHEDDING: f64 = 45.0;

/// Least Reynolds number at which a body that is round on all sides may: 270 for a sphere (Johnson & Patel 1999).
const SHEDDING_ROUND: f64 = 270.0;

/// Tips of clamped linear beams sink by this number of lengths, times 8, under a weight that is hardly meant.
const HEAVIEST: f64 = 300.0;

/// Difference of the velocities of sponge and stream by the larger one above which it is a warning.
const OTHER: f64 = 0.05;

/// Times at which they are compared.
const OTHER_TIMES: usize = 200;

/// Weight by bending stiffness of a rod in a fluid that is a chain.
const CHAIN: f64 = 1e5;

/// Largest strain under the own weight.
const STRETCH: f64 = 0.1;

/// Return what may be a mistake in a scene without faults.
pub(crate) fn warnings(scene: &Scene, reynolds: Option<f64>) -> Vec<Warning> {
    let mut found = Vec::new();
    let ends: Vec<_> = scene.fluid.iter().flat_map(|fluid| fluid.r#box.ends()).collect();
    let parts = parts(scene, &ends);
    let start: Vec<_> = parts.iter().map(|own| own.motion.shape_at(&own.part.rest, 0.0, &ends)).collect();
    overlaps(scene, &parts, &start, &mut found);
    if let Some(fluid) = &scene.fluid {
        found.extend(motions(scene, &parts, &start, &ends));
        found.extend(own_wake(scene, fluid, &parts));
        found.extend(carried_along(scene, fluid, &ends));
        found.extend(probes(fluid, &parts, &start));
        found.extend(other_sponge(scene, fluid));
        found.extend(symmetry(scene, fluid, &parts, &start, reynolds));
    }
    found.extend(scene.beams_with_rods().filter_map(|own| weight(scene, &own)));
    found.extend(scene.beams_with_rods().filter_map(|own| contact_warnings::of_rod(scene, &own)));
    found.extend(contact_warnings::of_bodies(scene));
    found.extend(contact_warnings::of_flyer(scene));
    found.extend(scene.wings().flat_map(|own| wing_checks::warnings(own.wing, &own.key)));
    for own in &mut found {
        own.text = legible(&own.text);
    }
    found
}

/// A part with its motion; what a law drives at its root moves as if it were rigid.
struct Moving<'a> {
    part: Part,
    motion: Motion<'a>,
}

/// The motion of a part over time.
enum Motion<'a> {
    Body(Box<Body>),
    Root { pivot: [f64; 3], laws: Option<&'a RootLaws> },
}

impl Motion<'_> {
    /// Return the shape at time `t` (s) of a part with this shape at rest.
    fn shape_at(&self, rest: &Shape, t: f64, ends: &[[f64; 2]]) -> Shape {
        match self {
            Self::Body(body) => body.shape_at(t, ends),
            Self::Root { laws: Some(laws), pivot } => rest.moved(laws.motion(*pivot, t)),
            Self::Root { laws: None, .. } => rest.clone(),
        }
    }
}

impl Moving<'_> {
    fn is_body(&self) -> bool {
        matches!(self.motion, Motion::Body(_))
    }

    /// Return the laws of the motion.
    fn laws(&self) -> Vec<&TimeLaw> {
        match &self.motion {
            Motion::Body(body) => body.laws().into_iter().flat_map(BodyMotion::all).collect(),
            Motion::Root { laws, .. } => laws.iter().flat_map(|laws| laws.all()).collect(),
        }
    }
}

fn parts<'a>(scene: &'a Scene, ends: &[[f64; 2]]) -> Vec<Moving<'a>> {
    let fluid = scene.fluid.as_ref();
    let part = |key: String, rest, moves: bool, rigid: &str, beam: Option<&Beam>| {
        let name = format!("`{key}`{}", if moves { rigid } else { "" });
        let thickness = beam.map_or(f64::INFINITY, Beam::largest_thickness);
        let reach = fluid.map_or(0.0, |fluid| fluid.reach(&rest, beam));
        let (is_mounted, is_driven, of_flyer) = (false, false, false);
        Part { key, name, rest, moves, deforms: false, thickness, reach, is_mounted, is_driven, of_flyer }
    };
    let rigid = |Obstacle { key, body, .. }: Obstacle| Moving {
        part: Part {
            is_mounted: body.mount.is_some(),
            is_driven: body.is_driven(),
            ..part(key, body.shape_at(0.0, ends), body.laws().is_some(), "", None)
        },
        motion: Motion::Body(Box::new(body)),
    };
    let beams = scene.beams_with_rods().zip(places::lines(scene)).map(|(own, line)| {
        let laws = own.laws();
        let Line { key, nodes, chain, .. } = line;
        let part = part(key, Shape::Chain(chain), laws.is_some(), " (as a rigid beam)", Some(own.beam));
        Moving { part, motion: Motion::Root { pivot: nodes[0], laws } }
    });
    let wings = scene.wings().filter(|_| fluid.is_some() && scene.flyer.is_none()).map(|own| {
        let (mesh, laws) = (own.wing.mesh.build(), own.wing.laws());
        let rest = Shape::Surface(Surface::new(mesh.nodes, mesh.triangles));
        let part = part(own.key, rest, laws.is_some(), " (as a rigid wing)", None);
        Moving { part, motion: Motion::Root { pivot: own.wing.pivot, laws } }
    });
    fluid.iter().flat_map(|fluid| fluid.obstacles()).map(rigid).chain(beams).chain(wings).collect()
}

/// Return times of the run, from 0 on: closely at the beginning, then over all of it.
fn times(end: f64, parts: &[Moving]) -> Vec<f64> {
    let fastest = parts.iter().flat_map(|part| part.laws()).filter_map(TimeLaw::frequency).fold(0.0, f64::max);
    let moving = parts.iter().filter(|own| own.part.moves);
    let shapes = moving.map(|own| 1 + own.part.rest.elements() / ELEMENTS).sum::<usize>().max(1);
    let count = (MOST_SHAPES / shapes).clamp(FEWEST_TIMES, TIMES);
    let coarse = end / count as f64;
    let fine = if fastest > 0.0 { f64::min(1.0 / (TIMES_PER_PERIOD * fastest), coarse) } else { coarse };
    let mut times: Vec<_> = (0..=count).map(|i| i as f64 * fine).collect();
    let begin = fine * count as f64;
    times.extend((0..=count).map(|i| i as f64 * coarse).filter(|t| *t > begin));
    times
}

/// Append the warnings about bodies on bodies and beams on beams at the start, where roots may be embedded.
fn overlaps(scene: &Scene, parts: &[Moving], start: &[Shape], found: &mut Vec<Warning>) {
    let axes = scene.dimensions();
    let (lines, bodies) = (places::lines(scene), parts.iter().filter(|part| part.is_body()).count());
    for j in 0..bodies + lines.len() {
        for i in if j < bodies { 0..j } else { bodies..j } {
            let touch = match j < bodies {
                true => start[i].touched_by(&start[j], 0.0),
                false => lines[i - bodies].overlaps(&lines[j - bodies]).then_some(Touch::Whole),
            };
            if let Some(touch) = touch {
                let (Part { key, name, .. }, other) = (&parts[j].part, &parts[i].part.key);
                let at = shown(&start[j].place(&touch, &start[i])[..axes]);
                let text = format!("{name} overlaps `{other}` near {at} at the start");
                found.push(Warning { key: key.clone(), time: None, text });
            }
        }
    }
}

/// Return the warnings about the motions that laws prescribe.
fn motions(scene: &Scene, moving: &[Moving], start: &[Shape], ends: &[[f64; 2]]) -> Vec<Warning> {
    let parts = moving.iter().map(|own| &own.part).collect();
    let mut monitor = Monitor { scene, parts, memory: None, axes: ends.len(), is_run: false };
    let mut now: Vec<_> = start.iter().cloned().map(Some).collect();
    let mut found = monitor.check(0.0, &now);
    let is_moving = moving.iter().any(|own| own.part.moves);
    for t in times(scene.time.end, moving).into_iter().skip(1).take_while(|_| is_moving) {
        for (shape, own) in now.iter_mut().zip(moving).filter(|(_, own)| own.part.moves) {
            *shape = Some(own.motion.shape_at(&own.part.rest, t, ends));
        }
        found.extend(monitor.check(t, &now));
    }
    found
}

/// Return the warnings about probes that a body or a wall covers at the start.
fn probes(fluid: &Fluid, parts: &[Moving], start: &[Shape]) -> Vec<Warning> {
    let walls = places::walls(fluid);
    // A probe may lie on a surface.
    let deep = 1e-9 * fluid.r#box.spacing()[0];
    let covered = |p: &[f64]| {
        let at = [p[0], p[1], p.get(2).copied().unwrap_or(0.0)];
        let body = parts.iter().zip(start).find(|(_, shape)| shape.distance(at) < -deep);
        let body = body.map(|(own, _)| format!("`{}`", own.part.key));
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

/// Return the warning about a sponge that brakes or drives the stream.
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

/// Return the warning about a stream that meets its own wake. An inflow renews it, a sponge what passes along x.
fn own_wake(scene: &Scene, fluid: &Fluid, parts: &[Moving]) -> Option<Warning> {
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
                let name = &parts[0].part.name;
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

/// Return the warning about a body that falls or rises in a periodic box in which nothing holds the fluid.
fn carried_along(scene: &Scene, fluid: &Fluid, ends: &[[f64; 2]]) -> Option<Warning> {
    let driven = fluid.mean_flow.is_some() || fluid.inflow.is_some() || fluid.sponge.is_some();
    let stands = |own: &Obstacle| own.body.motion.is_none() && own.body.mount.is_none();
    let weighs = |flyer: &Flyer| flyer.goes_along().zip(flyer.gravity).any(|(goes, own)| goes && own != 0.0);
    let flies = scene.flyer.as_ref().is_some_and(weighs) && !fluid.obstacles().any(|own| stands(&own));
    if flies && !driven && fluid.channel.is_none() {
        let text = "the flyer gives its weight to the fluid, which nothing holds in the periodic box: all of it gains \
                    speed; `\"mean_flow\": {}`, a `channel` or a `sponge` holds the fluid";
        return Some(Warning { key: "flyer.gravity".into(), time: None, text: text.into() });
    }
    let is_held = |own: Obstacle| own.body.mount.is_none();
    let parts = scene.wings().next().is_some() || scene.beams().next().is_some() || fluid.obstacles().any(is_held);
    if driven || parts || fluid.channel.is_some() {
        return None;
    }
    let i = fluid.bodies.iter().position(|body| body.free_weight(fluid.density, ends).iter().any(|own| *own != 0.0))?;
    let text = format!(
        "`fluid.bodies[{i}]` falls or rises, and nothing holds the fluid in the periodic box: both gain speed together; \
         `\"mean_flow\": {{}}` holds the fluid"
    );
    Some(Warning { key: format!("fluid.bodies[{i}].mount.gravity"), time: None, text })
}

/// Return the warning about a scene whose wake stays symmetric.
fn symmetry(
    scene: &Scene,
    fluid: &Fluid,
    parts: &[Moving],
    shapes: &[Shape],
    reynolds: Option<f64>,
) -> Option<Warning> {
    let driven = scene.beams_with_rods().any(|own| own.rod.is_some_and(|rod| rod.root_motion.is_some()))
        || scene.wings().any(|own| own.wing.root_motion.is_some())
        || scene.flyer.is_some();
    if parts.is_empty() || driven || fluid.disturbance.is_some() {
        return None;
    }
    let ends: Vec<_> = fluid.r#box.ends().collect();
    let extent = |shape: &Shape, axis: usize| shape.bounds()[axis][1] - shape.bounds()[axis][0];
    let fills =
        |axis: usize| shapes.iter().any(|own| extent(own, axis) >= (ends[axis][1] - ends[axis][0]) * (1.0 - 1e-9));
    let streams =
        |axis: usize| places::streams(fluid)[axis] || fluid.initial_velocity.get(axis).is_some_and(|u| *u != 0.0);
    let axis = (0..ends.len()).find(|&axis| streams(axis))?;
    let mut across: Vec<_> = (0..ends.len()).filter(|&other| other != axis && !fills(other)).collect();
    // What is flat is moved and sheds across itself, and a rigid plate along the stream does neither.
    let is_flat = |axis: usize| shapes.iter().all(|own| extent(own, axis) == 0.0);
    if across.iter().any(|&axis| is_flat(axis)) {
        across.retain(|&axis| is_flat(axis) && parts.iter().any(|part| !part.is_body()));
    }
    let is_round = across.len() == 2 && shapes.iter().all(|own| matches!(own, Shape::Solid(_)));
    if across.is_empty() || reynolds.is_none_or(|re| re < if is_round { SHEDDING_ROUND } else { SHEDDING }) {
        return None;
    }
    let middles: Option<Vec<_>> = across
        .iter()
        .map(|&axis| if streams(axis) { None } else { plane_of_symmetry(scene, fluid, parts, shapes, axis) })
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
fn plane_of_symmetry(scene: &Scene, fluid: &Fluid, parts: &[Moving], shapes: &[Shape], across: usize) -> Option<f64> {
    let mut laws = parts.iter().flat_map(|part| match &part.motion {
        Motion::Body(body) => body
            .laws()
            .into_iter()
            .flat_map(|motion| iter::once(motion.along()[across]).chain(motion.turns().map(|(_, angle)| angle)))
            .collect(),
        _ => Vec::new(),
    });
    let is_off = |own: &Freedom| own.support.is_some_and(|own| own.rest * own.stiffness != 0.0);
    let released = fluid.bodies.iter().any(|body| {
        let breaks = |own: &Freedom| is_off(own) && own.turns != (own.axis == across);
        let pull = body.mount.as_ref().and_then(|mount| mount.gravity.get(across)).copied().unwrap_or(0.0);
        pull != 0.0 || body.freedoms(fluid.is_space()).iter().any(breaks)
    });
    let moved = released || fluid.bodies.iter().any(Body::is_driven) || laws.any(|law| law.largest_rate() > 0.0);
    let mut pulls = scene.beams_with_rods().filter_map(|own| own.rod?.gravity.get(across).copied());
    if moved || pulls.any(|g| g != 0.0) || scene.wings().any(|own| own.wing.gravity[across] != 0.0) {
        return None;
    }
    let middles = shapes.iter().map(|shape| shape.bounds()[across].iter().sum::<f64>() / 2.0);
    let middle = middles.sum::<f64>() / shapes.len() as f64;
    let extents = shapes.iter().flat_map(|shape| shape.bounds().map(|[low, high]| high - low));
    let close = 1e-9 * extents.fold(0.0, f64::max);
    let walls = places::walls(fluid).into_iter().find(|(axis, _)| *axis == across);
    let off_walls = walls.is_some_and(|(_, [low, high])| ((low + high) / 2.0 - middle).abs() > close);
    // The grid is symmetric at its lines and halfway between them.
    let [low, _] = fluid.r#box.ends().nth(across)?;
    let halves = 2.0 * (middle - low) / fluid.r#box.spacing()[across];
    let is_symmetric = || shapes.iter().all(|shape| shape.is_mirrored(shapes, across, middle, close));
    (!off_walls && (halves - halves.round()).abs() <= 1e-6 && is_symmetric()).then_some(middle)
}

/// Return the warning about a rod that is too heavy for its stiffness.
fn weight(scene: &Scene, own: &BeamWithRod) -> Option<Warning> {
    let rod = own.rod?;
    let (_, direction) = scene.beam_root(own.beam);
    let g = rod.gravity.iter().fold(0.0_f64, |g, part| g.hypot(*part));
    let along: f64 = rod.gravity.iter().zip(direction).map(|(part, d)| part / g.max(f64::MIN_POSITIVE) * d).sum();
    let section = rod.material.section(&own.beam.thickness, 0.0);
    let length = own.beam.length;
    let bending = section.line_density * length.powi(3) / section.bending_stiffness;
    let stretch = section.line_density * g * length / section.axial_stiffness;
    let held = matches!(rod.root, RootSupport::Clamped | RootSupport::TorsionSpring { .. });
    let sinks = bending * g * (1.0 - along * along).max(0.0).sqrt();
    let key = format!("{}rod.gravity", own.key());
    let effect = if stretch > STRETCH {
        format!("its weight stretches it by {} of its length", three_digits(stretch))
    } else if held && sinks > HEAVIEST {
        format!("as a linear beam it would sink by {} lengths", three_digits(sinks / 8.0))
    } else if scene.fluid.is_some() && bending * g > CHAIN {
        format!("its weight is {} of its bending stiffness", three_digits(bending * g))
    } else {
        return None;
    };
    let (name, g) = (own.in_sentence(), three_digits(g));
    let text = format!("the rod{name} is too heavy for its stiffness: under `{key}`, {g} m/s², {effect}");
    Some(Warning { key, time: None, text })
}
