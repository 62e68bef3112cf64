//! Figures that bodies, beams and the wing fill: outlines in the plane, solids, surfaces and cords in space.

use crate::body::{Axis, Body, Shape, Turn};
use crate::plane::Outline;
use crate::space::{self, ROUNDING, Vector, are_near, between, dot};

/// Samples along each side of the frame around a solid, by which its volume is measured.
const SAMPLES: usize = 16;

/// Points of a surface, about: many times the parts of a section that it may cover.
const POINTS: usize = 4096;

/// Samples along each side of the frame that two solids share.
const SHARED: usize = 8;

/// Places along each side of a cord at which it is looked for inside a solid.
const PLACES: usize = 4;

/// Part of a surface at its rim that may touch another.
const RIM: f64 = 1e-6;

/// Most triangles of a surface in the frame that it shares with another; of more, some are left out.
const MOST_NEAR: usize = 300;

/// The place that a body fills.
#[derive(Clone, Debug)]
pub(crate) enum Figure {
    Flat(Outline),
    Solid(Solid),
    Sheet(Sheet),
    Cord(Cord),
}

/// A surface in space.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    nodes: Vec<Vector>,
    triangles: Vec<[usize; 3]>,
    frame: [[f64; 2]; 3],
}

/// A beam in space: a line with half its thickness.
#[derive(Clone, Debug)]
pub(crate) struct Cord {
    points: Vec<Vector>,
    half: f64,
    frame: [[f64; 2]; 3],
}

/// A convex body in space.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    form: Form,
    /// Half its lengths along its own axes, m.
    half: [f64; 3],
    center: [f64; 3],
    /// Its own axes in those of the box.
    axes: [[f64; 3]; 3],
    /// Least and largest place along each axis of the box, m.
    frame: [[f64; 2]; 3],
}

/// Form of a solid.
#[derive(Clone, Copy, Debug)]
enum Form {
    Ellipsoid,
    Cuboid,
    /// Along that own axis.
    Cylinder(usize),
}

impl Figure {
    /// Return least and largest place along each axis of the box, m.
    pub fn frame(&self) -> &[[f64; 2]] {
        match self {
            Self::Flat(outline) => &outline.frame,
            Self::Solid(solid) => &solid.frame,
            Self::Sheet(sheet) => &sheet.frame,
            Self::Cord(cord) => &cord.frame,
        }
    }

    /// Whether two figures overlap by more than `depth`, m.
    pub fn overlaps(&self, other: &Self, depth: f64) -> bool {
        match (self, other) {
            (Self::Flat(a), Self::Flat(b)) => a.overlaps(b, depth),
            (Self::Solid(a), Self::Solid(b)) => a.overlaps(b, depth),
            (Self::Sheet(a), Self::Solid(b)) | (Self::Solid(b), Self::Sheet(a)) => {
                are_near(&a.frame, &b.frame, 0.0) && a.points().any(|p| b.contains(p, 0.0))
            }
            (Self::Sheet(a), Self::Sheet(b)) => a.meets(b, depth) || b.meets(a, depth),
            (Self::Cord(a), Self::Cord(b)) => a.distance(b) < a.half + b.half - depth,
            (Self::Cord(a), Self::Solid(b)) | (Self::Solid(b), Self::Cord(a)) => {
                are_near(&a.frame, &b.frame, 0.0) && a.places().any(|p| b.contains(p, a.half - depth))
            }
            (Self::Cord(a), Self::Sheet(b)) | (Self::Sheet(b), Self::Cord(a)) => a.touches(b, depth),
            (Self::Flat(_), _) | (_, Self::Flat(_)) => false,
        }
    }

    /// Whether a point lies inside.
    pub fn contains(&self, p: &[f64]) -> bool {
        match (self, p) {
            (Self::Flat(outline), &[x, y, ..]) => outline.contains([x, y]),
            (Self::Solid(solid), &[x, y, z]) => solid.contains([x, y, z], 0.0),
            _ => false,
        }
    }

    /// Return the share of the figure whose points have `property`.
    pub fn share(&self, property: impl Fn(&[f64]) -> bool) -> f64 {
        match self {
            Self::Flat(outline) => outline.share(|p| property(&p)),
            Self::Solid(solid) => solid.share(|p| property(&p)),
            Self::Sheet(sheet) => sheet.share(|p| property(&p)),
            Self::Cord(cord) => share(cord.points.iter(), |p| property(&p[..])),
        }
    }

    /// Return the larger of both shares of two figures that lie inside each other.
    pub fn shared(&self, other: &Self) -> f64 {
        match (self, other) {
            (Self::Flat(a), Self::Flat(b)) => a.shared(b),
            (Self::Solid(a), Self::Solid(b)) => {
                f64::max(a.share(|p| b.contains(p, 0.0)), b.share(|p| a.contains(p, 0.0)))
            }
            (Self::Sheet(a), Self::Solid(b)) | (Self::Solid(b), Self::Sheet(a)) => a.share(|p| b.contains(p, 0.0)),
            (Self::Sheet(a), Self::Sheet(b)) if are_near(&a.frame, &b.frame, 0.0) => {
                f64::max(a.share(|p| b.has(p)), b.share(|p| a.has(p)))
            }
            _ => 0.0,
        }
    }

    /// Whether a straight line along `axis` meets the figure wherever it passes through the section `ends` across. In
    /// the plane the frame says so.
    pub fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        match self {
            Self::Flat(_) => true,
            Self::Solid(solid) => solid.covers(axis, ends),
            Self::Sheet(sheet) => sheet.covers(axis, ends),
            Self::Cord(_) => false,
        }
    }

    /// Whether the image of the figure in the plane across `axis` at `middle` fills a figure of `all`, to `close`, m.
    pub fn is_mirrored(&self, all: &[Self], axis: usize, middle: f64, close: f64) -> bool {
        let image = |p: &[f64]| {
            let mut image = p.to_vec();
            image[axis] = 2.0 * middle - p[axis];
            image
        };
        let near = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() <= close * close;
        let (points, others): (Vec<_>, Vec<Vec<_>>) = (self.corners(), all.iter().map(Self::corners).collect());
        others.iter().any(|other| points.iter().all(|p| other.iter().any(|q| near(&image(p), q))))
    }

    /// Return points by which two figures of one kind and size are the same.
    fn corners(&self) -> Vec<Vec<f64>> {
        match self {
            Self::Flat(outline) => outline.corners().iter().map(|p| p.to_vec()).collect(),
            Self::Solid(solid) => solid.corners().iter().map(|p| p.to_vec()).collect(),
            Self::Sheet(Sheet { nodes: points, .. }) | Self::Cord(Cord { points, .. }) => {
                points.iter().map(|p| p.to_vec()).collect()
            }
        }
    }
}

/// Return the share of points with a property.
fn share<T>(points: impl Iterator<Item = T>, property: impl Fn(T) -> bool) -> f64 {
    let (all, some) = points.fold((0_u32, 0_u32), |(all, some), p| (all + 1, some + u32::from(property(p))));
    f64::from(some) / f64::from(all.max(1))
}

impl Cord {
    /// The beam through `points` of that half thickness, m.
    pub fn new(points: Vec<Vector>, half: f64) -> Self {
        let frame = space::frame(points.iter()).map(|[low, high]| [low - half, high + half]);
        Self { points, half, frame }
    }

    fn sides(&self) -> impl Iterator<Item = [Vector; 2]> + '_ {
        self.points.windows(2).map(|pair| [pair[0], pair[1]])
    }

    /// Return points along the line.
    fn places(&self) -> impl Iterator<Item = Vector> + '_ {
        self.sides().flat_map(|[a, b]| (0..=PLACES).map(move |i| between(a, b, i as f64 / PLACES as f64)))
    }

    /// Return the distance of two lines, m; infinite where their frames are apart.
    pub fn distance(&self, other: &Self) -> f64 {
        if !are_near(&self.frame, &other.frame, 0.0) {
            return f64::INFINITY;
        }
        let pairs = self.sides().flat_map(|one| other.sides().map(move |two| space::distance(one, two)));
        pairs.fold(f64::INFINITY, f64::min)
    }

    /// Return where a beam passes through a surface, not only with its root or its tip.
    pub fn piercing(&self, sheet: &Sheet) -> Option<Vector> {
        let (corners, last) = (sheet.near(&self.frame, 0.0), self.points.len() - 2);
        self.sides().enumerate().find_map(|(k, side)| {
            let mut shares = corners.iter().filter_map(|triangle| space::piercing(side, *triangle));
            let is_end = |share: f64| (k == 0 && share < ROUNDING) || (k == last && share > 1.0 - ROUNDING);
            shares.find(|share| !is_end(*share)).map(|share| between(side[0], side[1], share))
        })
    }

    /// Whether a beam reaches to a surface by more than `depth`, m, or through it.
    fn touches(&self, sheet: &Sheet, depth: f64) -> bool {
        let corners = sheet.near(&self.frame, 0.0);
        let close = (self.half - depth).max(0.0);
        let reaches = |side: [Vector; 2], triangle: &[Vector; 3]| {
            side.iter().any(|p| space::height(*p, *triangle) < close)
                || edges(*triangle).iter().any(|edge| space::distance(side, *edge) < close)
        };
        self.piercing(sheet).is_some() || self.sides().any(|side| corners.iter().any(|own| reaches(side, own)))
    }
}

/// Return the edges of a triangle.
fn edges([a, b, c]: [Vector; 3]) -> [[Vector; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

impl Sheet {
    /// The surface of nodes in the axes of the box and triangles.
    pub fn new(nodes: Vec<Vector>, triangles: Vec<[usize; 3]>) -> Self {
        let frame = space::frame(nodes.iter());
        Self { nodes, triangles, frame }
    }

    /// Return some [`POINTS`] points on the surface, or one a triangle.
    fn points(&self) -> impl Iterator<Item = Vector> + '_ {
        let count = self.triangles.len();
        let n = (POINTS as f64 / count as f64).sqrt().ceil().max(1.0) as usize;
        let at = move |[a, b, c]: [Vector; 3], i: usize, j: usize| {
            let [s, t] = [i, j].map(|k| (k as f64 + 1.0 / 3.0) / n as f64);
            [0, 1, 2].map(|axis| a[axis] + s * (b[axis] - a[axis]) + t * (c[axis] - a[axis]))
        };
        self.corners(count.div_ceil(POINTS)).flat_map(move |corners| {
            (0..n).flat_map(move |i| (0..n - i).map(move |j| (i, j))).map(move |(i, j)| at(corners, i, j))
        })
    }

    /// Return the corners of each triangle, or of some.
    fn corners(&self, stride: usize) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.triangles.iter().step_by(stride.max(1)).map(|corners| corners.map(|node| self.nodes[node]))
    }

    /// Return the triangles at most `gap` from a frame, of more than [`MOST_NEAR`] some.
    fn near(&self, frame: &[[f64; 2]; 3], gap: f64) -> Vec<[Vector; 3]> {
        if !are_near(&self.frame, frame, gap) {
            return Vec::new();
        }
        let all: Vec<_> =
            self.corners(1).filter(|corners| are_near(&space::frame(corners.iter()), frame, gap)).collect();
        let stride = all.len().div_ceil(MOST_NEAR).max(1);
        all.into_iter().step_by(stride).collect()
    }

    /// Whether an edge passes through the other surface, or comes closer than `gap` to it, m.
    fn meets(&self, other: &Self, gap: f64) -> bool {
        let own = self.near(&other.frame, gap);
        // The edge of one may lie on the other.
        let middle = other.frame.map(|[low, high]| (low + high) / 2.0);
        let inner = |corners: [Vector; 3]| corners.map(|corner| between(corner, middle, RIM));
        let others: Vec<_> = other.near(&self.frame, gap).into_iter().map(inner).collect();
        let framed: Vec<_> = others.iter().map(|corners| (corners, space::frame(corners.iter()))).collect();
        let through = |side: [Vector; 2], triangle: [Vector; 3]| {
            space::piercing(side, triangle).is_some_and(|share| ROUNDING < share && share < 1.0 - ROUNDING)
        };
        let close = |side: [Vector; 2], triangle: [Vector; 3]| {
            space::height(side[0], triangle) < gap
                || edges(triangle).iter().any(|edge| space::distance(side, *edge) < gap)
        };
        own.iter().any(|corners| {
            let frame = space::frame(corners.iter());
            let mut met = framed.iter().filter(|(_, other)| are_near(&frame, other, gap));
            met.any(|(other, _)| edges(*corners).iter().any(|side| through(*side, **other) || close(*side, **other)))
        })
    }

    /// Whether a point lies on the surface.
    fn has(&self, p: Vector) -> bool {
        let size = self.frame.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
        let close = 1e-6 * size;
        let framed = |corners: &[Vector; 3]| are_near(&space::frame(corners.iter()), &p.map(|at| [at, at]), close);
        self.corners(1).any(|corners| framed(&corners) && space::height(p, corners) <= close)
    }

    fn share(&self, property: impl Fn(Vector) -> bool) -> f64 {
        share(self.points(), property)
    }

    fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        let part = |p: &Vector, d: usize| (p[d] - ends[d][0]) / (ends[d][1] - ends[d][0]) * SAMPLES as f64;
        let mut met = [[false; SAMPLES]; SAMPLES];
        for p in self.points() {
            let [a, b] = [i, j].map(|d| part(&p, d).clamp(0.0, SAMPLES as f64 - 1.0) as usize);
            met[a][b] = true;
        }
        met.as_flattened().iter().all(|met| *met)
    }
}

impl Solid {
    /// Return half the least length, m.
    pub fn least_half(&self) -> f64 {
        self.half.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Return the corners of the cuboid around the body.
    fn corners(&self) -> Vec<Vector> {
        let [a, b, c] = self.half;
        let is_ball = matches!(self.form, Form::Ellipsoid) && a == b && b == c;
        let axes = if is_ball { [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], Z] } else { self.axes };
        let signed = |k: usize, own: usize| if k >> own & 1 == 0 { self.half[own] } else { -self.half[own] };
        let corner =
            |k: usize| [0, 1, 2].map(|d| self.center[d] + (0..3).map(|own| signed(k, own) * axes[own][d]).sum::<f64>());
        (0..8).map(corner).collect()
    }

    /// Return whether a point lies inside, or at most `by` (m) outside.
    pub fn contains(&self, p: Vector, by: f64) -> bool {
        let from = [0, 1, 2].map(|d| p[d] - self.center[d]);
        let own = self.axes.map(|axis| dot(axis, from));
        let part = [0, 1, 2].map(|d| own[d] / (self.half[d] + by).max(f64::MIN_POSITIVE));
        match self.form {
            Form::Ellipsoid => dot(part, part) <= 1.0,
            Form::Cuboid => part.iter().all(|x| x.abs() <= 1.0),
            Form::Cylinder(axis) => part[axis].abs() <= 1.0 && dot(part, part) - part[axis] * part[axis] <= 1.0,
        }
    }

    fn share(&self, property: impl Fn([f64; 3]) -> bool) -> f64 {
        let (mut all, mut some) = (0_u32, 0_u32);
        for p in grid(self.frame, SAMPLES).filter(|&p| self.contains(p, 0.0)) {
            all += 1;
            some += u32::from(property(p));
        }
        if all > 0 { f64::from(some) / f64::from(all) } else { f64::from(u8::from(property(self.center))) }
    }

    fn overlaps(&self, other: &Self, depth: f64) -> bool {
        let frame =
            [0, 1, 2].map(|d| [self.frame[d][0].max(other.frame[d][0]), self.frame[d][1].min(other.frame[d][1])]);
        frame.iter().all(|[low, high]| high - low > depth)
            && grid(frame, SHARED).any(|p| self.contains(p, 0.0) && other.contains(p, 0.0))
    }

    fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        let mut section: [[f64; 2]; 3] = [ends[0], ends[1], ends[2]];
        section[axis] = [self.center[axis]; 2];
        let [low, high] = self.frame[axis];
        grid(section, SAMPLES).all(|mut p| {
            (0..=SAMPLES).any(|i| {
                p[axis] = low + (high - low) * i as f64 / SAMPLES as f64;
                self.contains(p, 0.0)
            })
        })
    }
}

/// Return the middles of `n` parts along each side of a frame.
fn grid(frame: [[f64; 2]; 3], n: usize) -> impl Iterator<Item = [f64; 3]> {
    let at = move |[low, high]: [f64; 2], i: usize| low + (high - low) * (i as f64 + 0.5) / n as f64;
    (0..n * n * n).map(move |k| [at(frame[0], k / (n * n)), at(frame[1], k / n % n), at(frame[2], k % n)])
}

/// Return a vector after a turn about an axis by the right-hand rule.
fn turned(v: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let length = dot(axis, axis).sqrt();
    let n = axis.map(|component| component / length);
    let ((sin, cos), along) = (angle.sin_cos(), dot(n, v));
    let across = [n[1] * v[2] - n[2] * v[1], n[2] * v[0] - n[0] * v[2], n[0] * v[1] - n[1] * v[0]];
    [0, 1, 2].map(|d| cos * v[d] + sin * across[d] + (1.0 - cos) * along * n[d])
}

impl Body {
    /// Return the figure at time `t` (s) in a box with these ends, m.
    pub(crate) fn figure_at(&self, t: f64, ends: &[[f64; 2]]) -> Figure {
        let (form, surface) = (self.shape.form(ends), self.shape.surface());
        if form.is_none() && surface.is_none() {
            return Figure::Flat(self.outline_at(t));
        }
        let motion = self.laws();
        let place = motion.map_or([0.0; 3], |motion| [&motion.x, &motion.y, &motion.z].map(|law| law.value(t)));
        let moved = motion.map_or((Z, 0.0), |motion| (motion.axis.unwrap_or(Z), motion.angle.value(t)));
        let rest = self.turn.as_ref().map_or((Z, 0.0), |Turn { axis, angle }| (*axis, *angle));
        let axes = [0, 1, 2].map(|d| {
            let own = [0, 1, 2].map(|e| f64::from(u8::from(d == e)));
            turned(turned(own, rest.0, rest.1), moved.0, moved.1)
        });
        let pivot = |d: usize| self.pivot.get(d).copied().unwrap_or(0.0);
        let center =
            [0, 1, 2].map(|d| self.position[d] + place[d] - (0..3).map(|own| pivot(own) * axes[own][d]).sum::<f64>());
        let Some((form, half)) = form else {
            let (nodes, triangles) = surface.unwrap_or_default();
            let placed =
                |own: &[f64; 3]| [0, 1, 2].map(|d| center[d] + (0..3).map(|k| own[k] * axes[k][d]).sum::<f64>());
            return Figure::Sheet(Sheet::new(nodes.iter().map(placed).collect(), triangles));
        };
        let frame = [0, 1, 2].map(|d| {
            let reach = [0, 1, 2].map(|own| half[own] * axes[own][d].abs());
            let extent = match form {
                Form::Ellipsoid => dot(reach, reach).sqrt(),
                Form::Cuboid => reach.iter().sum(),
                Form::Cylinder(own) => reach[own] + (dot(reach, reach) - reach[own] * reach[own]).max(0.0).sqrt(),
            };
            let frame = [center[d] - extent, center[d] + extent];
            if self.shape.is_endless() { frame.map(|at| at.clamp(ends[d][0], ends[d][1])) } else { frame }
        });
        Figure::Solid(Solid { form, half, center, axes, frame })
    }
}

const Z: [f64; 3] = [0.0, 0.0, 1.0];

impl Shape {
    /// Whether it goes through the whole box, along which it lies.
    fn is_endless(&self) -> bool {
        matches!(self, Self::CircularCylinder { length: None, .. })
    }

    /// Return form and half the lengths of a shape in space; none of one in the plane.
    fn form(&self, ends: &[[f64; 2]]) -> Option<(Form, [f64; 3])> {
        Some(match self {
            Self::Sphere { radius } => (Form::Ellipsoid, [*radius; 3]),
            Self::Ellipsoid { lengths } => (Form::Ellipsoid, lengths.map(|length| length / 2.0)),
            Self::Cuboid { lengths } => (Form::Cuboid, lengths.map(|length| length / 2.0)),
            Self::CircularCylinder { axis, radius, length } => {
                let own = match axis {
                    Axis::X => 0,
                    Axis::Y => 1,
                    Axis::Z => 2,
                };
                let through = ends.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
                let mut half = [*radius; 3];
                half[own] = length.map_or(through, |length| length / 2.0);
                (Form::Cylinder(own), half)
            }
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The figure of a body in a box of 4 m.
    fn figure(body: &str, t: f64) -> Figure {
        let body: Body = serde_json::from_str(body).unwrap_or_else(|e| panic!("{e}"));
        body.figure_at(t, &[[-2.0, 2.0]; 3])
    }

    #[test]
    fn a_solid_has_its_frame_its_volume_and_its_overlaps() {
        let plate = figure(
            r#"{ "shape": { "cuboid": { "lengths": [2.0, 1.0, 0.2] } }, "position": [0.0, 0.0, 0.0],
                "pivot": [1.0, 0.0, 0.0], "turn": { "axis": [0, 0, 2], "angle": 1.5707963267948966 },
                "motion": {
                    "x": { "constant": 0.5 }, "angle": { "constant": 1.5707963267948966 }, "axis": [1, 0, 0] } }"#,
            0.0,
        );
        // The length goes to y, and then to z: the pivot is at its end.
        let expected = [[0.0, 1.0], [-0.1, 0.1], [-2.0, 0.0]];
        for (found, expected) in plate.frame().iter().zip(expected) {
            assert!((found[0] - expected[0]).abs() < 1e-12 && (found[1] - expected[1]).abs() < 1e-12, "{found:?}");
        }
        let ball = |x: f64| {
            figure(&format!(r#"{{ "shape": {{ "sphere": {{ "radius": 0.5 }} }}, "position": [{x}, 0, 0] }}"#), 0.0)
        };
        assert!((ball(0.0).share(|p| p[0] > 0.25) - 5.0 / 32.0).abs() < 0.02);
        assert!(ball(0.0).overlaps(&ball(0.9), 0.05) && !ball(0.0).overlaps(&ball(1.01), 0.0));
        assert!(
            ball(0.0).shared(&figure(r#"{ "shape": { "sphere": { "radius": 0.1 } }, "position": [0.3, 0, 0] }"#, 0.0))
                > 0.99
        );
        let tube = figure(
            r#"{ "shape": { "circular_cylinder": { "radius": 0.5, "axis": "y" } }, "position": [0, 0, 0] }"#,
            0.0,
        );
        assert_eq!(tube.frame()[1], [-2.0, 2.0]);
        assert!(!tube.covers(0, &[[-2.0, 2.0]; 3]) && tube.covers(0, &[[-2.0, 2.0], [-2.0, 2.0], [-0.4, 0.4]]));
    }
}
