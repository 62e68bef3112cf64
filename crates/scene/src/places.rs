//! Places of bodies, beams and zones that no scene can mean. What may be meant is a [warning](crate::warnings).

use geometry::{AXES, Chain, Shape, Surface, beyond, crosses, sides};

use crate::beam::{Beam, Root};
use crate::fault::{Fault, Faults};
use crate::fluid::{Fluid, NOTHING, Obstacle};
use crate::law::TimeLaw;
use crate::scene::{BeamWithRod, Scene, WingOfScene};

/// Least share of its area in an inflow zone or a sponge with which a body is refused.
const IN_ZONE: f64 = 0.5;

/// Least share of its area in another body or beyond a wall with which a body is refused.
const HIDDEN: f64 = 0.95;

/// Part of the sum of half thicknesses below which the distance of two beams is an overlap.
const ALONG: f64 = 0.95;

/// Most stations of a beam at which it is checked.
const MOST_STATIONS: usize = 128;

/// Relative tolerance of a limit.
const ROUNDING: f64 = 1e-9;

/// A beam of a scene as a line, with half its thickness.
pub(crate) struct Line {
    /// Path of the beam, e.g. `rods[0].beam`.
    pub key: String,
    /// Some of the stations at rest, the first at the root and the last at the tip, m; z = 0 in two dimensions.
    pub nodes: Vec<[f64; 3]>,
    /// The same with half the largest thickness.
    pub chain: Chain,
    /// Number of dimensions.
    pub axes: usize,
    /// Half the largest thickness, m.
    pub half_thickness: f64,
    /// Index of the cylinder that holds the beam.
    pub support: Option<usize>,
}

/// Return the beams as lines.
pub(crate) fn lines(scene: &Scene) -> Vec<Line> {
    scene.beams_with_rods().map(|own| line(scene, &own)).collect()
}

fn line(scene: &Scene, own: &BeamWithRod) -> Line {
    let beam: &Beam = own.beam;
    let stations = scene.beam_stations(beam);
    let stride = beam.segments.div_ceil(MOST_STATIONS);
    let mut nodes: Vec<_> = stations.iter().step_by(stride).copied().collect();
    if !beam.segments.is_multiple_of(stride) {
        nodes.extend(stations.last());
    }
    let half_thickness = beam.largest_thickness() / 2.0;
    Line {
        key: format!("{}beam", own.key()),
        chain: Chain::uniform(nodes.clone(), half_thickness),
        nodes,
        axes: scene.dimension(beam),
        half_thickness,
        support: match beam.root {
            Root::OnCylinder { cylinder, .. } => Some(cylinder),
            Root::At { .. } => None,
        },
    }
}

impl Line {
    /// Return the path of the place of the root.
    pub fn place(&self) -> String {
        match self.support {
            Some(_) => format!("{}.root.on_cylinder.angle", self.key),
            None => format!("{}.root.at.position", self.key),
        }
    }

    fn shown(&self, p: &[f64; 3]) -> String {
        shown(&p[..self.axes])
    }

    /// Return root and tip.
    fn ends(&self) -> [[f64; 3]; 2] {
        [self.nodes[0], self.nodes[self.nodes.len() - 1]]
    }

    /// Return whether beams overlap between their ends, or half of one lies in the other.
    pub fn overlaps(&self, other: &Self) -> bool {
        let close = ALONG * (self.half_thickness + other.half_thickness);
        if !self.chain.is_near(&other.chain, 0.0) {
            return false;
        }
        let inside = |a: &Self, b: &Self| {
            let near = |p: &[f64; 3]| b.chain.distance_of(*p);
            let by_end = a.ends().iter().any(|end| near(end) < 2.0 * close);
            (by_end, 2 * a.nodes.iter().filter(|p| near(p) < close).count() >= a.nodes.len())
        };
        let ((by_one, one), (by_other, two)) = (inside(self, other), inside(other, self));
        one || two || (!by_one && !by_other && self.chain.distance(&other.chain) < close)
    }

    fn refused(&self, reason: &str) -> Fault {
        Fault::conflict(&self.place(), &self.shown(&self.nodes[0]), reason)
    }

    fn meets(&self, key: &str, at: &[f64; 3]) -> Fault {
        self.refused(&format!("the beam meets `{key}` at {}", self.shown(at)))
    }
}

/// Return whether a stream passes the bodies along each axis, so that a closed section stops it.
pub(crate) fn streams(fluid: &Fluid) -> [bool; 3] {
    let flows = |law: &TimeLaw| law.largest() > 0.0;
    let along_x = fluid.inflow.as_ref().is_some_and(|inflow| flows(&inflow.mean_velocity));
    let mut streams = fluid.mean_flow.as_ref().map_or([false; 3], |mean| mean.laws().map(|(_, law)| flows(law)));
    streams[0] |= along_x;
    streams
}

/// Add the places that no scene can mean.
pub(crate) fn check(scene: &Scene, faults: &mut Faults) {
    let Some(fluid) = &scene.fluid else { return };
    if let Some(name) = fluid.fine_box.as_ref().and_then(|fine| fine.follow.as_ref()) {
        let is_known = name == NOTHING || scene.followed().is_some();
        faults.require(is_known, "fluid.fine_box.follow", format!("{name:?}"), || {
            let names = scene.followable().into_iter().map(|(name, _)| name).chain([NOTHING.into()]);
            let known: Vec<_> = names.map(|name| format!("`{name}`")).collect();
            format!("it must be one of {}", known.join(", "))
        });
    }
    check_widths(fluid, faults);
    check_ends(scene, fluid, faults);
    if faults.len() > 0 {
        return;
    }
    let (ends, obstacles): (Vec<_>, Vec<_>) = (fluid.r#box.ends().collect(), fluid.obstacles().collect());
    let shapes: Vec<_> = obstacles.iter().map(|obstacle| obstacle.body.shape_at(0.0, &ends)).collect();
    check_bodies(fluid, &obstacles, &shapes, faults);
    for own in scene.wings() {
        let shape = wing_at_start(scene, &own);
        if let Some(reason) = shape.and_then(|wing| misplaced(fluid, &wing, "wing").or_else(|| in_rim(fluid, &wing))) {
            faults.push(Fault::conflict(&format!("{}.mesh", own.key), "the mesh of the wing", &reason));
        }
    }
    let lines = lines(scene);
    for (j, line) in lines.iter().enumerate() {
        check_line(fluid, line, faults);
        if let Some(reason) = line.nodes.iter().find_map(|node| of_rim(fluid, &node.map(|at| [at; 2]))) {
            faults.push(line.refused(&reason));
        }
        for (i, (obstacle, shape)) in obstacles.iter().zip(&shapes).enumerate() {
            if line.support != Some(i)
                && let Some(fault) = passage(fluid, line, &obstacle.key, shape)
            {
                faults.push(fault);
            }
        }
        if let Some((i, at)) = (0..j).find_map(|i| Some((i, crossing(&lines[i], line)?))) {
            faults.push(line.meets(&lines[i].key, &at));
        }
    }
}

/// Check that no body lies where it cannot be meant, or inside another.
fn check_bodies(fluid: &Fluid, obstacles: &[Obstacle], shapes: &[Shape], faults: &mut Faults) {
    let refused =
        |Obstacle { place, body, .. }: &Obstacle, reason: &str| Fault::conflict(place, &shown(&body.position), reason);
    for (obstacle, shape) in obstacles.iter().zip(shapes) {
        if let Some(reason) = misplaced(fluid, shape, "body").or_else(|| in_rim(fluid, shape)) {
            faults.push(refused(obstacle, &reason));
        }
    }
    for (j, (obstacle, shape)) in obstacles.iter().zip(shapes).enumerate() {
        if let Some(i) = (0..j).find(|&i| shapes[i].shared(shape) > HIDDEN) {
            let reason = format!("one of this body and `{}` lies inside the other", obstacles[i].key);
            faults.push(refused(obstacle, &reason));
        }
    }
}

/// Return a point with five digits.
pub(crate) fn shown(point: &[f64]) -> String {
    let all: Vec<_> = point.iter().map(|at| rounded(*at).to_string()).collect();
    format!("[{}]", all.join(", "))
}

/// Return a number with three digits, and as a power of ten where it is long.
pub(crate) fn three_digits(value: f64) -> String {
    let short = format!("{:.2e}", value.min(f64::MAX));
    let rounded: f64 = short.parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs()) { rounded.to_string() } else { short }
}

/// Return a number with five digits behind its largest unit, without zeros at the end.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Return inflow zone and sponge with their ends along x, m.
pub(crate) fn zones(fluid: &Fluid) -> impl Iterator<Item = (&'static str, [f64; 2])> {
    let inflow = fluid.inflow.as_ref().map(|inflow| ("inflow zone", inflow.x));
    inflow.into_iter().chain(fluid.sponge.as_ref().map(|sponge| ("sponge", sponge.x)))
}

/// Check that zones and the channel have a cell, and that zones leave fluid between them.
fn check_widths(fluid: &Fluid, faults: &mut Faults) {
    let spacing = fluid.r#box.spacing();
    let (dx, [x0, x1]) = (spacing[0], fluid.r#box.x);
    let mut free = x1 - x0;
    for (name, [low, high]) in zones(fluid) {
        let (key, value) = (format!("fluid.{}.x", name.trim_end_matches(" zone")), format!("[{low}, {high}]"));
        faults.require(high - low >= dx * (1.0 - ROUNDING), &key, &value, || {
            format!("the zone must be at least a cell wide, {dx} m")
        });
        free -= high - low;
        faults.require(free >= dx * (1.0 - ROUNDING), &key, &value, || {
            format!("the zones must leave at least a cell of the box, [{x0}, {x1}], to the flow")
        });
    }
    for (axis, [low, high]) in walls(fluid) {
        let (cell, key) = (spacing[axis], format!("fluid.channel.{}", AXES[axis]));
        faults.require(high - low >= cell * (1.0 - ROUNDING), &key, format!("[{low}, {high}]"), || {
            format!("the channel must be at least a cell {}, {cell} m", ["long", "high", "wide"][axis])
        });
    }
}

/// Check that cylinders, stations and the wing lie inside the box at rest, and that no two beams of the plane are the
/// same.
fn check_ends(scene: &Scene, fluid: &Fluid, faults: &mut Faults) {
    let ends: Vec<_> = fluid.r#box.ends().collect();
    for (i, cylinder) in fluid.cylinders.iter().enumerate() {
        fluid.check_place(&format!("fluid.cylinders[{i}].center"), &cylinder.center, faults);
    }
    let beams = scene.beams_with_rods().map(|own| (own.key() + "beam.root", scene.beam_stations(own.beam)));
    let wings = scene.wings().map(|own| (own.key.clone() + ".mesh", scene.wing_nodes(&own)));
    for (key, nodes) in beams.chain(wings) {
        let is_outside = |p: &&[f64; 3]| p.iter().zip(&ends).any(|(at, ends)| beyond(*at, *ends) > 0.0);
        if let Some(node) = nodes.iter().find(is_outside) {
            let at: Vec<_> = node[..ends.len()].iter().map(f64::to_string).collect();
            let what = if key.ends_with("wing.mesh") { "node" } else { "station" };
            let effect = format!("puts a {what} at ({})", at.join(", "));
            faults.push(Fault::consequence(&key, &effect, &bounds_of("outside the box ", &ends)));
        }
    }
    let mut known: Vec<([[f64; 3]; 2], &str)> = Vec::new();
    for own in scene.beams_with_rods().filter(|_| !fluid.is_space()) {
        let (stations, key) = (scene.beam_stations(own.beam), format!("{}beam.root", own.key()));
        let ends = [stations[0], stations[stations.len() - 1]];
        if let Some((_, other)) = known.iter().find(|(other, _)| *other == ends) {
            let reason = "but no two beams may have the same root and tip";
            faults.push(Fault::consequence(&key, &format!("puts the beam onto the beam of `{other}`"), reason));
        }
        known.push((ends, own.name.unwrap_or_default()));
    }
}

/// Return the ends of the box behind some words.
fn bounds_of(words: &str, ends: &[[f64; 2]]) -> String {
    let each: Vec<_> = ends.iter().zip(AXES).map(|(ends, axis)| format!("{axis} {ends:?}")).collect();
    words.to_string() + &each.join(", ")
}

/// Return the surface of a wing at the start; none without triangles.
fn wing_at_start(scene: &Scene, own: &WingOfScene) -> Option<Shape> {
    let (mut nodes, triangles) = (scene.wing_nodes(own), own.wing.mesh.build().triangles);
    if let Some(laws) = own.wing.laws() {
        nodes = nodes.into_iter().map(laws.motion(own.wing.pivot, 0.0)).collect();
    }
    (!triangles.is_empty()).then(|| Shape::Surface(Surface::new(nodes, triangles)))
}

/// Return why `what`, which has this shape, cannot be at its place at t = 0.
fn misplaced(fluid: &Fluid, shape: &Shape, what: &str) -> Option<String> {
    let ends: Vec<_> = fluid.r#box.ends().collect();
    if shape.share(|p| p.iter().zip(&ends).any(|(at, ends)| beyond(*at, *ends) > 0.0)) > HIDDEN {
        return Some(bounds_of(&format!("the {what} lies outside the box, "), &ends));
    }
    for (axis, walls) in walls(fluid) {
        if shape.share(|p| beyond(p[axis], walls) > 0.0) > HIDDEN {
            let axis = AXES[axis];
            return Some(format!("the {what} lies in a wall of the channel, whose fluid is at {axis} {walls:?}"));
        }
    }
    if let Some(reason) = blocked(fluid, shape) {
        return Some(format!("the {what} {reason}"));
    }
    let (name, x) = zones(fluid).find(|(_, x)| shape.share(|p| beyond(p[0], *x) == 0.0) > IN_ZONE)?;
    Some(format!("most of the {what} lies in the {name}, x {x:?}, whose velocity is imposed inside bodies too"))
}

/// Return the walls of the channel, m, by the number of the axis across them.
pub(crate) fn walls(fluid: &Fluid) -> Vec<(usize, [f64; 2])> {
    fluid.walls().into_iter().enumerate().filter_map(|(axis, ends)| Some((axis, ends?))).collect()
}

/// Return what a body with this shape stops by leaving no way around it.
pub(crate) fn blocked(fluid: &Fluid, shape: &Shape) -> Option<String> {
    let (cell, streams, bounds) = (fluid.spacing(), streams(fluid), shape.bounds());
    let ends: Vec<_> = fluid.r#box.ends().collect();
    let mut walled = ends.clone();
    for (axis, walls) in walls(fluid) {
        walled[axis] = walls;
    }
    (0..ends.len()).filter(|&axis| streams[axis]).find_map(|axis| {
        let is_walled = walls(fluid).iter().any(|(across, _)| *across != axis);
        let (what, section) = if is_walled { ("channel", &walled) } else { ("box", &ends) };
        let is_open = |other: usize| {
            let ([low, high], [from, to]) = (section[other], bounds[other]);
            (from - low).max(0.0) + (high - to).max(0.0) >= cell[other] * (1.0 - ROUNDING)
        };
        let mut across = (0..ends.len()).filter(|&other| other != axis);
        let [low, high] = section[usize::from(axis == 0)];
        let stops = !across.any(is_open) && shape.covers(axis, section);
        stops.then(|| format!("fills the {what} from {low} to {high} and stops the stream along {}", AXES[axis]))
    })
}

/// Return that a shape at rest reaches into the rim of the fine box.
fn in_rim(fluid: &Fluid, shape: &Shape) -> Option<String> {
    of_rim(fluid, &shape.bounds())
}

/// Return the same of what lies between two ends along each axis, m.
fn of_rim(fluid: &Fluid, bounds: &[[f64; 2]; 3]) -> Option<String> {
    let inner = fluid.inner_of_fine_box()?;
    let name = fluid.fine_box.iter().filter(|fine| fine.follows()).find_map(|fine| fine.follow.as_ref());
    let follows = name.map_or(String::new(), |name| format!(", which follows `{name}`,"));
    let sides = inner.into_iter().zip(bounds).zip(AXES);
    sides
        .filter(|((inner, own), _)| own[0] < inner[0] || own[1] > inner[1])
        .map(|((inner, own), axis)| {
            let [own, inner] = [own, &inner].map(|ends| shown(ends));
            format!("it reaches over {axis} {own}, and the rim of `fine_box`{follows} leaves {axis} {inner}")
        })
        .next()
}

/// Check that a beam neither passes through a wall of the channel nor lies in a zone.
fn check_line(fluid: &Fluid, line: &Line, faults: &mut Faults) {
    let cell = fluid.spacing();
    for (axis, walls) in walls(fluid) {
        // A root may be embedded in a wall; what leaves the channel never comes from there.
        let in_wall = |p: &[f64; 3]| beyond(p[axis], walls) > cell[axis];
        let free = line.nodes.iter().position(|p| !in_wall(p));
        let reason = match free.map(|free| line.nodes[free..].iter().find(|p| in_wall(p))) {
            None => Some("the beam lies in a wall of the channel".into()),
            Some(Some(p)) => Some(format!("the beam passes through a wall of the channel at {}", line.shown(p))),
            Some(None) => None,
        };
        if let Some(reason) = reason {
            faults.push(line.refused(&format!("{reason}, whose fluid is at {} {walls:?}", AXES[axis])));
        }
    }
    for (name, [low, high]) in zones(fluid) {
        let inside = line.nodes.iter().filter(|p| low + cell[0] < p[0] && p[0] < high - cell[0]).count();
        faults.require(
            inside as f64 <= IN_ZONE * line.nodes.len() as f64,
            &line.place(),
            line.shown(&line.nodes[0]),
            || format!("most of the beam lies in the {name}, x [{low}, {high}]"),
        );
    }
}

/// Return the fault of a beam that passes through the body of `key`, or whose root is inside a cylinder that does not
/// hold it.
fn passage(fluid: &Fluid, line: &Line, key: &str, shape: &Shape) -> Option<Fault> {
    match shape {
        Shape::Surface(surface) => return line.chain.piercing(surface).map(|at| line.meets(key, &at)),
        Shape::Chain(other) => return strict_crossing(&line.chain, other).map(|at| line.meets(key, &at)),
        Shape::Outline(_) | Shape::Solid(_) => (),
    }
    let is_cylinder = key.starts_with("fluid.cylinders");
    let cell = fluid.largest_cell();
    let deep = cell.min(shape.thickness() / 4.0);
    let inside = |p: &[f64; 3]| shape.distance(*p) < -deep;
    // A root may be embedded in a body, and a beam may begin at the surface of any.
    let free = line.nodes.iter().position(|p| !inside(p));
    let reason = match free {
        None => format!("the beam lies inside `{key}`"),
        Some(1..) if is_cylinder => format!("the root lies inside `{key}`; `on_cylinder` holds a beam at its surface"),
        Some(free) => {
            let at = line.nodes[free..].iter().find(|p| inside(p))?;
            format!("the beam passes through `{key}` at {}", line.shown(at))
        }
    };
    Some(line.refused(&reason))
}

/// Return the begin of an edge that has its ends on both sides of an edge of another line of the plane, which has its
/// ends on both sides of the first.
fn strict_crossing(line: &Chain, other: &Chain) -> Option<[f64; 3]> {
    let flat = |[a, b]: [[f64; 3]; 2]| [a, b].map(|[x, y, _]| [x, y]);
    let crossed = |edge: &[[f64; 3]; 2]| sides(other.points()).any(|own| crosses(flat(*edge), flat(own)));
    sides(line.points()).find(crossed).map(|[begin, _]| begin)
}

/// Return a point at which two beams cross, or from which on they lie on each other. An end of one may touch the other.
fn crossing(a: &Line, b: &Line) -> Option<[f64; 3]> {
    let close = a.half_thickness.min(b.half_thickness) / 4.0;
    if !a.chain.is_near(&b.chain, close) {
        return None;
    }
    let touches = |one: &Line, other: &Line| one.ends().iter().any(|end| other.chain.distance_of(*end) < close);
    let lies_on = |one: &Line, other: &Line| {
        let near: Vec<_> = one.nodes.iter().filter(|p| other.chain.distance_of(**p) < close).collect();
        (near.len() * 10 > one.nodes.len().max(10)).then(|| *near[0])
    };
    let crosses = !touches(a, b) && !touches(b, a) && a.chain.distance(&b.chain) < close;
    let apart = |p: &&[f64; 3]| a.chain.distance_of(**p);
    let nearest = || b.nodes.iter().min_by(|p, q| apart(p).total_cmp(&apart(q))).copied();
    let in_plane = || if a.axes == 2 { strict_crossing(&a.chain, &b.chain) } else { None };
    let crossed = if crosses { nearest() } else { in_plane() };
    crossed.or_else(|| lies_on(b, a)).or_else(|| lies_on(a, b))
}
