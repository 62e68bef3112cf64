//! Scales of the coefficients of a body, a beam or a wing: length, area, and the directions of drag, lift and side.
//!
//! In space, a body has three sides along its own axes. Its area is its largest projection along one of them, and its
//! length the one of the two longest sides that lies more along the stream, or the shorter one where both are equally
//! oblique: the chord of a plate, the diameter of a cylinder across the stream. A wing has its one-sided area, and by
//! that divided by the other side its mean chord. In the plane the length is that of `Shape::size`.
//!
//! Drag is along the stream, also one that only swings past a body at rest. In still fluid it is along the line on which
//! a body is driven without a turn, along the own x axis of another body, and from the root of a beam or a wing to its
//! tip. Lift is across the drag: in the plane
//! to its left, in space towards the thinnest side of a body, or else across its longest side, or else along its motion;
//! in still fluid first along the motion, and for a wing that turns along the axis of the turn that is most across the
//! drag. Where none of these exists, lift is along the own axis after the one nearest to the drag. Side completes a
//! right-handed system. So all turn with body and stream.

use geometry::vector::{cross, dot, minus, norm, unit};
use mesh::Mesh;
use serde::Serialize;

use crate::body::Body;
use crate::reference_scales::{ACROSS, ReferenceScales, vector};
use crate::root::RootLaws;
use crate::scene::{BeamWithRod, Scene};
use crate::shape::{areas, extents};
use crate::wing::Wing;

/// Largest ratio of two sides of which one is the thinner.
const THINNER: f64 = 0.999;

/// Least area along the mean normal by the whole area of a flat surface.
const FLAT: f64 = 0.95;

/// Times at which a motion is followed for its largest velocity.
const TIMES: usize = 4000;

/// Scales of the coefficients of a body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scales {
    /// L, m.
    pub length: f64,
    /// A, m²; absent in the plane, where forces are per metre of depth.
    pub area: Option<f64>,
    /// U of this body alone, m/s; absent where it is that of the dimensionless numbers.
    pub speed: Option<f64>,
    /// Unit vector of the drag.
    pub drag: [f64; 3],
    /// Unit vector of the lift.
    pub lift: [f64; 3],
    /// Unit vector of the side force.
    pub side: [f64; 3],
}

/// What the rules need of a body.
struct Sized {
    axes: [[f64; 3]; 3],
    sides: [f64; 3],
    area: f64,
    /// Direction of the drag in still fluid.
    heading: [f64; 3],
    motion: Option<[f64; 3]>,
    turn: Option<[f64; 3]>,
}

/// Return the scales of all bodies, beams and wings by the name of their force, in the order of the fluid, in a
/// `stream`.
pub(crate) fn scales(scene: &Scene, stream: Option<[f64; 3]>) -> Vec<(String, Scales)> {
    let Some(fluid) = &scene.fluid else { return Vec::new() };
    let (ends, end): (Vec<_>, _) = (fluid.r#box.ends().collect(), scene.time.end);
    let swing = fluid
        .mean_flow
        .as_ref()
        .and_then(|flow| direction(fastest(|t| flow.laws().map(|(_, law)| law.value_and_rate(t).0), end)));
    let is_space = ends.len() == 3;
    let mut found = Vec::new();
    let mut add = |name: String, mut sized: Sized, length: Option<f64>, chosen: Option<&ReferenceScales>| {
        sized.heading = swing.filter(|_| sized.motion.or(sized.turn).is_none()).unwrap_or(sized.heading);
        let [drag, lift, side] = directions(&sized, chosen, stream, is_space);
        let area = chosen.and_then(|own| own.area).or(is_space.then_some(sized.area));
        let length =
            chosen.and_then(|own| own.length).or(length).unwrap_or_else(|| chord(&sized, stream.unwrap_or(drag)));
        found.push((name, Scales { length, area, speed: chosen.and_then(|own| own.speed), drag, lift, side }));
    };
    for own in fluid.obstacles() {
        let length = (!is_space).then(|| own.body.shape.size()[0]);
        add(own.force, of_body(&own.body, &ends, end), length, own.body.reference.as_ref());
    }
    for own in scene.beams_with_rods() {
        add(own.force_name(), of_beam(scene, &own), Some(own.beam.length), None);
    }
    for own in scene.wings() {
        let (name, wing) = (own.force_name(), own.wing);
        let sized = of_wing(wing, end);
        let [mean_chord, _] = mean_chord_and_span(&sized, stream.unwrap_or_default());
        add(name, sized, Some(mean_chord), wing.reference.as_ref());
    }
    found
}

/// Return the two longest sides, each with its direction.
fn longest(sized: &Sized) -> [(f64, [f64; 3]); 2] {
    let mut sides: Vec<_> = sized.sides.into_iter().zip(sized.axes).collect();
    sides.sort_by(|a, b| b.0.total_cmp(&a.0));
    [sides[0], sides[1]]
}

/// Return the side along the stream, m, and the other one.
fn chord_and_span(sized: &Sized, stream: [f64; 3]) -> [f64; 2] {
    let [(long, of_long), (short, of_short)] = longest(sized);
    let along = |axis| dot(axis, stream).abs();
    if along(of_long) > along(of_short) + ACROSS * norm(stream) { [long, short] } else { [short, long] }
}

fn chord(sized: &Sized, stream: [f64; 3]) -> f64 {
    chord_and_span(sized, stream)[0]
}

fn mean_chord_and_span(sized: &Sized, stream: [f64; 3]) -> [f64; 2] {
    let [_, span] = chord_and_span(sized, stream);
    [sized.area / span, span]
}

/// Return the mean chord and the span of a wing in a stream, m.
pub(crate) fn sides_of_wing(wing: &Wing, stream: Option<[f64; 3]>) -> [f64; 2] {
    mean_chord_and_span(&of_wing(wing, 0.0), stream.unwrap_or_default())
}

/// Return the distance from an `axis` through the pivot of a body in space to its farthest node, corner or end of an own
/// axis, m.
pub(crate) fn reach_from_axis(body: &Body, axis: [f64; 3], ends: &[[f64; 2]]) -> f64 {
    let axes = body.axes_at_rest();
    let distance = |point: [f64; 3]| {
        let arm = minus(point, vector(&body.pivot));
        let arm: [f64; 3] = std::array::from_fn(|e| (0..3).map(|d| arm[d] * axes[d][e]).sum());
        norm(cross(arm, axis)) / norm(axis)
    };
    body.shape.points(ends).into_iter().map(distance).fold(0.0, f64::max)
}

fn of_body(body: &Body, ends: &[[f64; 2]], end: f64) -> Sized {
    let axes = body.axes_at_rest();
    let motion = body.laws().and_then(|laws| direction(fastest(|t| laws.displacement(t).1, end)));
    let turns = body.laws().is_some_and(|laws| laws.turns().any(|(_, angle)| angle.largest_rate() > 0.0));
    let (sides, area) = body.shape.sides(ends);
    Sized { axes, sides, area, heading: motion.filter(|_| !turns).unwrap_or(axes[0]), motion, turn: None }
}

fn of_beam(scene: &Scene, own: &BeamWithRod) -> Sized {
    let (_, heading) = scene.beam_root(own.beam);
    let beam = own.beam;
    let n = beam.segments;
    let mean = (0..n).map(|i| beam.thickness.at((i as f64 + 0.5) / n as f64)).sum::<f64>() / n as f64;
    let (motion, _) = of_laws(own.laws(), scene.time.end, heading);
    let across = cross(if heading[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] }, heading);
    let across = unit(across);
    Sized {
        axes: [heading, across, cross(heading, across)],
        sides: [beam.length, mean, mean],
        area: beam.length * mean,
        heading,
        motion,
        turn: None,
    }
}

fn of_wing(wing: &Wing, end: f64) -> Sized {
    let mesh = wing.mesh.build();
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let root = wing.root.as_ref().and_then(|name| mesh.chain(name)).unwrap_or_default();
    let middle = |nodes: &mut dyn Iterator<Item = [f64; 3]>| {
        let (sum, count) =
            nodes.fold(([0.0; 3], 0.0), |(sum, count), node| (std::array::from_fn(|d| sum[d] + node[d]), count + 1.0));
        sum.map(|part| part / f64::max(count, 1.0))
    };
    let from = middle(&mut root.iter().map(|node| mesh.nodes[*node]));
    let to = middle(&mut mesh.nodes.iter().copied());
    let apart = if root.is_empty() { axes[0] } else { minus(to, from) };
    let nearest = (0..3).max_by(|a, b| apart[*a].abs().total_cmp(&apart[*b].abs())).unwrap_or(0);
    let heading = axes[nearest].map(|part| part * apart[nearest].signum());
    let (motion, turn) = of_laws(wing.laws(), end, heading);
    let Mesh { nodes, triangles, .. } = mesh;
    Sized { axes, sides: extents(&nodes), area: mesh::area(&nodes, &triangles), heading, motion, turn }
}

/// Return the direction in which a base is fastest, and the axis of a rotation most across a direction.
fn of_laws(laws: Option<&RootLaws>, end: f64, heading: [f64; 3]) -> (Option<[f64; 3]>, Option<[f64; 3]>) {
    let Some(laws) = laws else { return (None, None) };
    let turning = laws.rotations.iter().filter(|turn| turn.angle.largest_rate() > 0.0);
    let axes = turning.filter_map(|turn| direction(turn.axis));
    let most = axes.min_by(|a, b| dot(*a, heading).abs().total_cmp(&dot(*b, heading).abs()));
    (direction(fastest(|t| laws.displacement(t).1, end)), most)
}

/// Return the largest of velocities up to `end` (s).
pub(crate) fn fastest(velocity: impl Fn(f64) -> [f64; 3], end: f64) -> [f64; 3] {
    let times = (0..=TIMES).map(|i| end * i as f64 / TIMES as f64);
    times.map(velocity).max_by(|a, b| norm(*a).total_cmp(&norm(*b))).unwrap_or_default()
}

/// Return the unit vector along a vector whose largest component is positive; none of a vector of no length.
fn direction(vector: [f64; 3]) -> Option<[f64; 3]> {
    let largest = vector.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    (largest != 0.0).then(|| vector.map(|part| part / norm(vector) * largest.signum()))
}

/// Return the directions of drag, lift and side.
fn directions(
    sized: &Sized,
    chosen: Option<&ReferenceScales>,
    stream: Option<[f64; 3]>,
    is_space: bool,
) -> [[f64; 3]; 3] {
    let given = |own: &Option<Vec<f64>>| Some(vector(own.as_ref()?));
    let drag = chosen.and_then(|own| given(&own.drag)).or(stream).unwrap_or(sized.heading);
    let drag = unit(drag);
    let across = |v: [f64; 3]| -> Option<[f64; 3]> {
        let along = dot(v, drag);
        let part: [f64; 3] = std::array::from_fn(|d| v[d] - along * drag[d]);
        // Rounding of an axis across the drag is no part of it.
        let part = part.map(|c| if c.abs() < 1e-12 * norm(v) { 0.0 } else { c });
        (norm(part) > ACROSS * norm(v)).then(|| unit(part))
    };
    let along = sized.axes.map(|axis| dot(axis, drag).abs());
    let nearest = (0..3).max_by(|a, b| along[*a].total_cmp(&along[*b]).then(b.cmp(a))).unwrap_or(0);
    let next = [1, 2].map(|i| sized.axes[(nearest + i) % 3]);
    let [thin, long] = odd_sides(sized);
    let across_long = long.map(|axis| cross(axis, drag)).filter(|axis| norm(*axis) > ACROSS);
    let order = match stream {
        Some(_) => [thin, across_long, sized.motion, None],
        None => [sized.motion, sized.turn, thin, across_long],
    };
    let lift = chosen.and_then(|own| across(given(&own.lift)?)).or_else(|| match is_space {
        true => order.into_iter().flatten().chain(next).find_map(across),
        false => Some([-drag[1], drag[0], 0.0]),
    });
    let lift = lift.expect("one of two directions is across the drag");
    [drag, lift, cross(drag, lift)].map(|axis| axis.map(|part| part + 0.0)) // No zero has a sign
}

/// Return the directions of the thinnest and the longest side; none where another one is as thin or as long.
fn odd_sides(sized: &Sized) -> [Option<[f64; 3]>; 2] {
    let mut sides: Vec<_> = sized.sides.into_iter().zip(sized.axes).collect();
    sides.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [thin, long] = [(0, 1), (1, 2)].map(|(a, b)| sides[a].0 < THINNER * sides[b].0);
    [thin.then_some(sides[0].1), long.then_some(sides[2].1)]
}

/// Return the second longest and the shortest side of a body in space, m.
pub(crate) fn two_sides(body: &Body, ends: &[[f64; 2]]) -> [f64; 2] {
    let (mut sides, _) = body.shape.sides(ends);
    sides.sort_by(f64::total_cmp);
    [sides[1], sides[0]]
}

/// Return the normal of a plate, a disk or a flat surface before its motion.
pub(crate) fn thin_normal(body: &Body) -> Option<[f64; 3]> {
    let (nodes, triangles) = body.shape.surface()?;
    let areas = areas(&nodes, &triangles);
    let sum = areas.iter().fold([0.0; 3], |sum, area| std::array::from_fn(|d| sum[d] + area[d]));
    let is_flat = norm(sum) > FLAT * areas.iter().map(|area| norm(*area)).sum::<f64>();
    let axes = body.axes_at_rest();
    is_flat.then(|| std::array::from_fn(|e| (0..3).map(|d| sum[d] * axes[d][e]).sum::<f64>() / norm(sum)))
}
