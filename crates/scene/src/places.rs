//! Places of bodies, beams and zones that no scene can mean. What may be meant is a [warning](crate::warnings).

use crate::beam::{Beam, Root};
use crate::body::Body;
use crate::fault::{Fault, Faults};
use crate::figure::{Cord, Figure, Sheet};
use crate::fluid::Fluid;
use crate::law::TimeLaw;
use crate::plane::{Outline, Point, cross, distance, meet, sides};
use crate::scene::{BeamWithRod, Scene};
use crate::space::Vector;

/// Least share of its area in an inflow zone or a sponge with which a body is refused.
const IN_ZONE: f64 = 0.5;

/// Least share of its area in another body or beyond a wall with which a body is refused.
const HIDDEN: f64 = 0.95;

/// Part of the sum of half thicknesses below which the distance of two beams is an overlap.
const ALONG: f64 = 0.95;

/// Most stations of a beam at which it is looked at.
const MOST_STATIONS: usize = 128;

/// Relative tolerance of a limit.
const ROUNDING: f64 = 1e-9;

/// A rigid body of a scene, a cylinder or another one.
pub(crate) struct Obstacle {
    /// Path of the body, e.g. `fluid.bodies[0]`.
    pub key: String,
    /// Path of its place.
    pub place: String,
    pub body: Body,
}

/// A beam of a scene as a line, with half its thickness.
pub(crate) struct Line {
    /// Path of the beam, e.g. `rods[0].beam`.
    pub key: String,
    /// Some of the stations at rest, the first at the root and the last at the tip, m; z = 0 in two dimensions.
    pub nodes: Vec<Vector>,
    /// The same in the plane.
    pub points: Vec<Point>,
    /// Whether it has three dimensions.
    pub is_space: bool,
    /// Half the largest thickness, m.
    pub half_thickness: f64,
    /// Index of the cylinder that holds the beam.
    pub support: Option<usize>,
}

/// Return the rigid bodies, cylinders first.
pub(crate) fn obstacles(fluid: &Fluid) -> Vec<Obstacle> {
    let cylinders = fluid.cylinders.iter().enumerate().map(|(i, cylinder)| Obstacle {
        key: format!("fluid.cylinders[{i}]"),
        place: format!("fluid.cylinders[{i}].center"),
        body: cylinder.into(),
    });
    let bodies = fluid.bodies.iter().enumerate().map(|(i, body)| Obstacle {
        key: format!("fluid.bodies[{i}]"),
        place: format!("fluid.bodies[{i}].position"),
        body: body.clone(),
    });
    cylinders.chain(bodies).collect()
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
    Line {
        key: format!("{}beam", own.key()),
        points: nodes.iter().map(|&[x, y, _]| [x, y]).collect(),
        nodes,
        is_space: scene.dimension(beam) == 3,
        half_thickness: beam.places().map(|s| beam.thickness.at(s)).fold(0.0, f64::max) / 2.0,
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

    /// Return the place of the root.
    fn root(&self) -> String {
        shown(&self.nodes[0][..if self.is_space { 3 } else { 2 }])
    }

    /// Return the beam as a figure in space.
    pub fn cord(&self) -> Cord {
        Cord::new(self.nodes.clone(), self.half_thickness)
    }

    /// Whether beams overlap between their ends, or half of one lies in the other.
    pub fn overlaps(&self, other: &Self) -> bool {
        let close = ALONG * (self.half_thickness + other.half_thickness);
        let inside = |a: &Self, b: &Self| {
            let cord = b.cord();
            let near = |p: &Vector| Cord::new(vec![*p; 2], 2.0 * close).distance(&cord);
            let last = a.nodes.len() - 1;
            let by_end = [0, last].iter().any(|&end| near(&a.nodes[end]) < 2.0 * close);
            (by_end, 2 * a.nodes.iter().filter(|p| near(p) < close).count() > last)
        };
        let ((by_one, one), (by_other, two)) = (inside(self, other), inside(other, self));
        one || two || (!by_one && !by_other && self.cord().distance(&other.cord()) < close)
    }

    fn refused(&self, reason: &str) -> Fault {
        Fault::conflict(&self.place(), &self.root(), reason)
    }

    /// Return the distance of a point from the line, m.
    pub fn distance(&self, p: Point) -> f64 {
        sides(&self.points).map(|(a, b)| distance(p, a, b)).fold(f64::INFINITY, f64::min)
    }
}

/// Whether a stream passes the bodies along each axis, so that a closed section stops it.
pub(crate) fn streams(fluid: &Fluid) -> [bool; 3] {
    let flows = |law: &TimeLaw| law.largest() > 0.0;
    let along_x = fluid.inflow.as_ref().is_some_and(|inflow| flows(&inflow.mean_velocity));
    let mut streams = fluid.mean_flow.as_ref().map_or([false; 3], |mean| mean.laws().map(|(_, law)| flows(law)));
    streams[0] |= along_x;
    streams
}

/// Return how far `at` lies outside `[low, high]`, m.
pub(crate) fn beyond(at: f64, [low, high]: [f64; 2]) -> f64 {
    (low - at).max(at - high).max(0.0)
}

/// Add the places that no scene can mean.
pub(crate) fn check(scene: &Scene, faults: &mut Faults) {
    let Some(fluid) = &scene.fluid else { return };
    check_widths(fluid, faults);
    if fluid.is_space() {
        check_in_space(scene, fluid, faults);
    } else {
        check_outside(scene, fluid, faults);
    }
    if faults.len() > 0 {
        return;
    }
    let obstacles = obstacles(fluid);
    check_bodies(fluid, &obstacles, faults);
    let lines = lines(scene);
    if fluid.is_space() {
        if let Some(reason) = wing_at(scene, 0.0).and_then(|wing| misplaced(fluid, &Figure::Sheet(wing), "wing")) {
            faults.push(Fault::conflict("wing.mesh", "the mesh of the wing", &reason));
        }
        return check_lines_in_space(fluid, &lines, &obstacles, faults);
    }
    let outlines: Vec<_> = obstacles.iter().map(|obstacle| obstacle.body.outline_at(0.0)).collect();
    for line in &lines {
        check_line(fluid, line, faults);
        for (i, (obstacle, outline)) in obstacles.iter().zip(&outlines).enumerate() {
            if let Some(points) = obstacle.body.line_at_rest() {
                check_crossing(line, obstacle, &points, faults);
            } else if line.support != Some(i) {
                check_passage(fluid, line, obstacle, outline, faults);
            }
        }
    }
    for (j, line) in lines.iter().enumerate() {
        if let Some((i, at)) = (0..j).find_map(|i| Some((i, crossing(&lines[i], line)?))) {
            faults.push(line.refused(&format!("the beam meets `{}` at {}", lines[i].key, shown(&at))));
        }
    }
}

/// Check that no body lies where it cannot be meant, or inside another.
fn check_bodies(fluid: &Fluid, obstacles: &[Obstacle], faults: &mut Faults) {
    let ends: Vec<_> = fluid.r#box.ends().collect();
    let figures: Vec<_> = obstacles.iter().map(|obstacle| obstacle.body.figure_at(0.0, &ends)).collect();
    for (obstacle, figure) in obstacles.iter().zip(&figures) {
        if let Some(reason) = misplaced(fluid, figure, "body") {
            faults.push(refused(obstacle, &reason));
        }
    }
    for (j, (obstacle, figure)) in obstacles.iter().zip(&figures).enumerate() {
        if let Some(i) = (0..j).find(|&i| figures[i].shared(figure) > HIDDEN) {
            let reason = format!("one of this body and `{}` lies inside the other", obstacles[i].key);
            faults.push(refused(obstacle, &reason));
        }
    }
}

/// Check that beams and the wing lie inside the box at rest.
fn check_in_space(scene: &Scene, fluid: &Fluid, faults: &mut Faults) {
    let beams = scene.beams_with_rods().map(|own| (format!("{}beam.root", own.key()), scene.beam_stations(own.beam)));
    let wing = scene.wing.iter().map(|wing| ("wing.mesh".into(), wing.mesh.build().nodes));
    for (key, nodes) in beams.chain(wing) {
        let ends: Vec<_> = fluid.r#box.ends().collect();
        let inside = |node: &&[f64; 3]| node.iter().zip(&ends).all(|(at, [low, high])| (low..=high).contains(&at));
        if let Some(node) = nodes.iter().find(|node| !inside(node)) {
            faults.push(Fault::conflict(&key, &format!("{node:?}"), "this node lies outside the box at rest"));
        }
    }
}

fn refused(Obstacle { place, body, .. }: &Obstacle, reason: &str) -> Fault {
    Fault::conflict(place, &shown(&body.position), reason)
}

/// Return a point with five digits.
pub(crate) fn shown(point: &[f64]) -> String {
    let all: Vec<_> = point.iter().map(|at| rounded(*at).to_string()).collect();
    format!("[{}]", all.join(", "))
}

/// Return a number with five digits behind its largest unit, without zeros at the end.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

/// Check that zones and the channel have a cell, and that zones leave fluid between them.
fn check_widths(fluid: &Fluid, faults: &mut Faults) {
    let spacing = fluid.r#box.spacing();
    let (dx, [x0, x1]) = (spacing[0], fluid.r#box.x);
    let inflow = fluid.inflow.as_ref().map(|inflow| ("inflow", inflow.x));
    let sponge = fluid.sponge.as_ref().map(|sponge| ("sponge", sponge.x));
    let mut free = x1 - x0;
    for (name, [low, high]) in inflow.into_iter().chain(sponge) {
        let (key, value) = (format!("fluid.{name}.x"), format!("[{low}, {high}]"));
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

/// Check that cylinders and stations lie inside the box at rest, and that no two beams are the same.
fn check_outside(scene: &Scene, fluid: &Fluid, faults: &mut Faults) {
    let inside = |p: f64, [low, high]: [f64; 2]| (low..=high).contains(&p);
    for (i, cylinder) in fluid.cylinders.iter().enumerate() {
        fluid.check_place(&format!("fluid.cylinders[{i}].center"), &cylinder.center, faults);
    }
    let mut known: Vec<([[f64; 3]; 2], &str)> = Vec::new();
    for own in scene.beams_with_rods() {
        let stations = scene.beam_stations(own.beam);
        let key = format!("{}beam.root", own.key());
        let out = stations.iter().find(|[x, y, _]| !(inside(*x, fluid.r#box.x) && inside(*y, fluid.r#box.y)));
        if let Some([x, y, _]) = out {
            let (box_x, box_y) = (fluid.r#box.x, fluid.r#box.y);
            let reason = format!("outside the box x {box_x:?}, y {box_y:?}");
            faults.push(Fault::consequence(&key, &format!("puts a station at ({x}, {y})"), &reason));
        }
        let ends = [stations[0], stations[stations.len() - 1]];
        if let Some((_, other)) = known.iter().find(|(other, _)| *other == ends) {
            let reason = "but no two beams may have the same root and tip";
            faults.push(Fault::consequence(&key, &format!("puts the beam onto the beam of `{other}`"), reason));
        }
        known.push((ends, own.name.unwrap_or_default()));
    }
}

/// Return the surface of the wing at time `t` (s), as if it were rigid; none without triangles.
pub(crate) fn wing_at(scene: &Scene, t: f64) -> Option<Sheet> {
    let wing = scene.wing.as_ref()?;
    let mesh = wing.mesh.build();
    let moved = |node: &Vector| match &wing.root_motion {
        Some(laws) => laws.moved(*node, wing.pivot, t),
        None => *node,
    };
    (!mesh.triangles.is_empty()).then(|| Sheet::new(mesh.nodes.iter().map(moved).collect(), mesh.triangles))
}

/// Return why `what`, which has this figure, cannot be at its place at t = 0.
fn misplaced(fluid: &Fluid, figure: &Figure, what: &str) -> Option<String> {
    let bounds: Vec<_> = fluid.r#box.ends().collect();
    let outside = |p: &[f64]| p.iter().zip(&bounds).any(|(at, ends)| beyond(*at, *ends) > 0.0);
    if figure.share(outside) > HIDDEN {
        let each: Vec<_> = bounds.iter().zip(AXES).map(|(ends, axis)| format!("{axis} {ends:?}")).collect();
        return Some(format!("the {what} lies outside the box, {}", each.join(", ")));
    }
    for (axis, walls) in walls(fluid) {
        if figure.share(|p| beyond(p[axis], walls) > 0.0) > HIDDEN {
            let axis = AXES[axis];
            return Some(format!("the {what} lies in a wall of the channel, whose fluid is at {axis} {walls:?}"));
        }
    }
    if let Some(reason) = blocked(fluid, figure) {
        return Some(format!("the {what} {reason}"));
    }
    let inflow = fluid.inflow.as_ref().map(|inflow| ("inflow zone", inflow.x));
    let sponge = fluid.sponge.as_ref().map(|sponge| ("sponge", sponge.x));
    let (name, x) =
        inflow.into_iter().chain(sponge).find(|(_, x)| figure.share(|p| beyond(p[0], *x) == 0.0) > IN_ZONE)?;
    Some(format!("most of the {what} lies in the {name}, x {x:?}, whose velocity is imposed inside bodies too"))
}

/// Names of the axes.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Return the walls of the channel, m, by the number of the axis across them.
pub(crate) fn walls(fluid: &Fluid) -> Vec<(usize, [f64; 2])> {
    let Some(channel) = &fluid.channel else { return Vec::new() };
    [channel.x, Some(channel.y), channel.z]
        .into_iter()
        .enumerate()
        .filter_map(|(axis, ends)| Some((axis, ends?)))
        .collect()
}

/// Return what a body with this figure stops by leaving no way around it.
pub(crate) fn blocked(fluid: &Fluid, figure: &Figure) -> Option<String> {
    let (cell, streams) = (fluid.r#box.spacing(), streams(fluid));
    let ends: Vec<_> = fluid.r#box.ends().collect();
    let mut walled = ends.clone();
    for (axis, walls) in walls(fluid) {
        walled[axis] = walls;
    }
    (0..ends.len()).filter(|&axis| streams[axis]).find_map(|axis| {
        let is_walled = axis == 0 && fluid.channel.is_some();
        let (what, section) = if is_walled { ("channel", &walled) } else { ("box", &ends) };
        let is_open = |other: usize| {
            let ([low, high], [from, to]) = (section[other], figure.frame()[other]);
            (from - low).max(0.0) + (high - to).max(0.0) >= cell[other] * (1.0 - ROUNDING)
        };
        let mut across = (0..ends.len()).filter(|&other| other != axis);
        let [low, high] = section[usize::from(axis == 0)];
        let stops = !across.any(is_open) && figure.covers(axis, section);
        stops.then(|| format!("fills the {what} from {low} to {high} and stops the stream along {}", AXES[axis]))
    })
}

/// Check that a beam neither passes through a wall of the channel nor lies in a zone.
fn check_line(fluid: &Fluid, line: &Line, faults: &mut Faults) {
    let (cell, axes) = (fluid.r#box.spacing(), if line.is_space { 3 } else { 2 });
    for (axis, walls) in walls(fluid) {
        // A root may be embedded in a wall; what leaves the channel never comes from there.
        let in_wall = |p: &Vector| beyond(p[axis], walls) > cell[axis];
        let free = line.nodes.iter().position(|p| !in_wall(p));
        let reason = match free.map(|free| line.nodes[free..].iter().find(|p| in_wall(p))) {
            None => Some("the beam lies in a wall of the channel".into()),
            Some(Some(p)) => Some(format!("the beam passes through a wall of the channel at {}", shown(&p[..axes]))),
            Some(None) => None,
        };
        if let Some(reason) = reason {
            faults.push(line.refused(&format!("{reason}, whose fluid is at {} {walls:?}", AXES[axis])));
        }
    }
    let dx = cell[0];
    let inflow = fluid.inflow.as_ref().map(|inflow| ("inflow zone", inflow.x));
    let sponge = fluid.sponge.as_ref().map(|sponge| ("sponge", sponge.x));
    for (name, [low, high]) in inflow.into_iter().chain(sponge) {
        let inside = line.points.iter().filter(|p| low + dx < p[0] && p[0] < high - dx).count();
        faults.require(inside as f64 <= IN_ZONE * line.points.len() as f64, &line.place(), line.root(), || {
            format!("most of the beam lies in the {name}, x [{low}, {high}]")
        });
    }
}

/// Check that a beam does not pass through a body, and that its root is not inside a cylinder that does not hold it.
fn check_passage(fluid: &Fluid, line: &Line, obstacle: &Obstacle, outline: &Outline, faults: &mut Faults) {
    let [dx, dy] = fluid.r#box.in_plane();
    let size = outline.frame.iter().map(|[low, high]| high - low).fold(f64::INFINITY, f64::min);
    let deep = dx.max(dy).min(size / 4.0);
    if let Some(fault) = passage(line, &obstacle.key, |&[x, y, _]| outline.depth([x, y]) > deep) {
        faults.push(fault);
    }
}

/// Return the fault of a beam that passes through a body, in which points are inside.
fn passage(line: &Line, key: &str, inside: impl Fn(&Vector) -> bool) -> Option<Fault> {
    let is_cylinder = key.starts_with("fluid.cylinders");
    // A root may be embedded in a body, and a beam may begin at the surface of any.
    let free = line.nodes.iter().position(|p| !inside(p));
    let reason = match free {
        None => format!("the beam lies inside `{key}`"),
        Some(1..) if is_cylinder => format!("the root lies inside `{key}`; `on_cylinder` holds a beam at its surface"),
        Some(free) => {
            let at = line.nodes[free..].iter().find(|p| inside(p))?;
            format!("the beam passes through `{key}` at {}", shown(&at[..if line.is_space { 3 } else { 2 }]))
        }
    };
    Some(line.refused(&reason))
}

/// Check that beams in space do not pass through walls, bodies or one another.
fn check_lines_in_space(fluid: &Fluid, lines: &[Line], obstacles: &[Obstacle], faults: &mut Faults) {
    let ends: Vec<_> = fluid.r#box.ends().collect();
    let cell = fluid.r#box.spacing().into_iter().fold(0.0, f64::max);
    for line in lines {
        check_line(fluid, line, faults);
        for Obstacle { key, body, .. } in obstacles {
            let fault = match body.figure_at(0.0, &ends) {
                Figure::Solid(solid) => {
                    let deep = cell.min(solid.least_half() / 2.0);
                    passage(line, key, |p| solid.contains(*p, -deep))
                }
                Figure::Sheet(sheet) => {
                    let at = line.cord().piercing(&sheet);
                    at.map(|at| line.refused(&format!("the beam meets `{key}` at {}", shown(&at))))
                }
                _ => None,
            };
            if let Some(fault) = fault {
                faults.push(fault);
            }
        }
    }
    for (j, line) in lines.iter().enumerate() {
        if let Some((i, at)) = (0..j).find_map(|i| Some((i, crossing_in_space(&lines[i], line)?))) {
            faults.push(line.refused(&format!("the beam meets `{}` at {}", lines[i].key, shown(&at))));
        }
    }
}

/// Return a point at which two beams in space cross, or from which on they lie on each other. An end of one may touch
/// the other.
fn crossing_in_space(a: &Line, b: &Line) -> Option<Vector> {
    let point = |p: Vector| Cord::new(vec![p, p], 0.0);
    let (one, other) = (a.cord(), b.cord());
    let close = a.half_thickness.min(b.half_thickness) / 4.0;
    let touches = |line: &Line, cord: &Cord| {
        [line.nodes[0], line.nodes[line.nodes.len() - 1]].iter().any(|end| point(*end).distance(cord) < close)
    };
    let lies_on = |line: &Line, cord: &Cord| {
        let near: Vec<_> = line.nodes.iter().filter(|p| point(**p).distance(cord) < close).collect();
        (near.len() * 10 > line.nodes.len().max(10)).then(|| *near[0])
    };
    let crosses = !touches(a, &other) && !touches(b, &one) && one.distance(&other) < close;
    let nearest = || {
        let apart = |p: &&Vector| point(**p).distance(&one);
        b.nodes.iter().min_by(|p, q| apart(p).total_cmp(&apart(q))).copied()
    };
    if crosses { nearest() } else { lies_on(b, &one).or_else(|| lies_on(a, &other)) }
}

/// Check that a beam does not cross a rigid line.
fn check_crossing(line: &Line, obstacle: &Obstacle, points: &[Point], faults: &mut Faults) {
    let pairs = sides(&line.points).flat_map(|own| sides(points).map(move |other| (own, other)));
    if let Some(((at, _), _)) = pairs.into_iter().find(|((p, q), (r, s))| cross(*p, *q, *r, *s)) {
        faults.push(line.refused(&format!("the beam meets `{}` at {}", obstacle.key, shown(&at))));
    }
}

/// Return a point at which two beams cross, or from which on they lie on each other. An end of one may touch the other.
fn crossing(a: &Line, b: &Line) -> Option<Point> {
    let touches = |one: &Line, other: &Line| {
        let ends = [one.points[0], one.points[one.points.len() - 1]];
        ends.iter().any(|end| other.distance(*end) <= ROUNDING * one.half_thickness)
    };
    let touch = touches(a, b) || touches(b, a);
    let pairs = sides(&a.points).flat_map(|one| sides(&b.points).map(move |other| (one, other)));
    let crossed = |((p, q), (r, s)): &((Point, Point), (Point, Point))| {
        if touch { cross(*p, *q, *r, *s) } else { meet(*p, *q, *r, *s) }
    };
    let first = pairs.into_iter().find(crossed).map(|((p, _), _)| p);
    let lies_on = |one: &Line, other: &Line| {
        let close = other.half_thickness.min(one.half_thickness) / 4.0;
        let near: Vec<_> = one.points.iter().filter(|p| other.distance(**p) < close).copied().collect();
        (near.len() * 10 > one.points.len().max(10)).then(|| near[0])
    };
    first.or_else(|| lies_on(a, b)).or_else(|| lies_on(b, a))
}
