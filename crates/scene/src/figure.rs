//! Figures that bodies fill: outlines in the plane, and solids in space.

use crate::body::{Axis, Body, Shape, Turn};
use crate::plane::Outline;

/// Samples along each side of the frame around a solid, by which its volume is measured.
const SAMPLES: usize = 16;

/// Points of a surface, about: many times the parts of a section that it may cover.
const POINTS: usize = 4096;

/// Samples along each side of the frame that two solids share.
const SHARED: usize = 8;

/// The place that a body fills.
#[derive(Clone, Debug)]
pub(crate) enum Figure {
    Flat(Outline),
    Solid(Solid),
    Sheet(Sheet),
}

/// A surface in space as points on it.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    points: Vec<[f64; 3]>,
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
    /// Return the outline of a figure of the plane.
    pub fn into_outline(self) -> Option<Outline> {
        if let Self::Flat(outline) = self { Some(outline) } else { None }
    }

    /// Return least and largest place along each axis of the box, m.
    pub fn frame(&self) -> &[[f64; 2]] {
        match self {
            Self::Flat(outline) => &outline.frame,
            Self::Solid(solid) => &solid.frame,
            Self::Sheet(sheet) => &sheet.frame,
        }
    }

    /// Whether two figures overlap by more than `depth`, m.
    pub fn overlaps(&self, other: &Self, depth: f64) -> bool {
        match (self, other) {
            (Self::Flat(a), Self::Flat(b)) => a.overlaps(b, depth),
            (Self::Solid(a), Self::Solid(b)) => a.overlaps(b, depth),
            (Self::Sheet(a), Self::Solid(b)) | (Self::Solid(b), Self::Sheet(a)) => {
                a.points.iter().any(|p| b.contains(*p))
            }
            _ => false,
        }
    }

    /// Return the share of the figure whose points have `property`.
    pub fn share(&self, property: impl Fn(&[f64]) -> bool) -> f64 {
        match self {
            Self::Flat(outline) => outline.share(|p| property(&p)),
            Self::Solid(solid) => solid.share(|p| property(&p)),
            Self::Sheet(sheet) => sheet.share(|p| property(p)),
        }
    }

    /// Return the larger of both shares of two figures that lie inside each other.
    pub fn shared(&self, other: &Self) -> f64 {
        match (self, other) {
            (Self::Flat(a), Self::Flat(b)) => a.shared(b),
            (Self::Solid(a), Self::Solid(b)) => f64::max(a.share(|p| b.contains(p)), b.share(|p| a.contains(p))),
            (Self::Sheet(a), Self::Solid(b)) | (Self::Solid(b), Self::Sheet(a)) => a.share(|p| b.contains(*p)),
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
        }
    }
}

impl Sheet {
    /// The surface of nodes in the axes of the box and triangles, which has some [`POINTS`] points or one a triangle.
    fn new(nodes: &[[f64; 3]], triangles: &[[usize; 3]]) -> Self {
        let frame = [0, 1, 2].map(|axis| {
            let along = nodes.iter().map(|node| node[axis]);
            [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
        });
        let n = (POINTS as f64 / triangles.len() as f64).sqrt().ceil().max(1.0);
        let mut points = Vec::new();
        for corners in triangles.iter().step_by(triangles.len().div_ceil(POINTS)) {
            let [a, b, c] = corners.map(|node| nodes[node]);
            for (i, j) in (0..n as usize).flat_map(|i| (0..n as usize - i).map(move |j| (i, j))) {
                let [s, t] = [i, j].map(|k| (k as f64 + 1.0 / 3.0) / n);
                points.push([0, 1, 2].map(|axis| a[axis] + s * (b[axis] - a[axis]) + t * (c[axis] - a[axis])));
            }
        }
        Self { points, frame }
    }

    fn share(&self, property: impl Fn(&[f64; 3]) -> bool) -> f64 {
        self.points.iter().filter(|p| property(p)).count() as f64 / self.points.len() as f64
    }

    fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        let part = |p: &[f64; 3], d: usize| (p[d] - ends[d][0]) / (ends[d][1] - ends[d][0]) * SAMPLES as f64;
        let mut met = [[false; SAMPLES]; SAMPLES];
        for p in &self.points {
            let [a, b] = [i, j].map(|d| part(p, d).clamp(0.0, SAMPLES as f64 - 1.0) as usize);
            met[a][b] = true;
        }
        met.as_flattened().iter().all(|met| *met)
    }
}

impl Solid {
    /// Return whether a point lies inside.
    fn contains(&self, p: [f64; 3]) -> bool {
        let from = [0, 1, 2].map(|d| p[d] - self.center[d]);
        let own = self.axes.map(|axis| dot(axis, from));
        let part = [0, 1, 2].map(|d| own[d] / self.half[d]);
        match self.form {
            Form::Ellipsoid => dot(part, part) <= 1.0,
            Form::Cuboid => part.iter().all(|x| x.abs() <= 1.0),
            Form::Cylinder(axis) => part[axis].abs() <= 1.0 && dot(part, part) - part[axis] * part[axis] <= 1.0,
        }
    }

    fn share(&self, property: impl Fn([f64; 3]) -> bool) -> f64 {
        let (mut all, mut some) = (0_u32, 0_u32);
        for p in grid(self.frame, SAMPLES).filter(|&p| self.contains(p)) {
            all += 1;
            some += u32::from(property(p));
        }
        if all > 0 { f64::from(some) / f64::from(all) } else { f64::from(u8::from(property(self.center))) }
    }

    fn overlaps(&self, other: &Self, depth: f64) -> bool {
        let frame =
            [0, 1, 2].map(|d| [self.frame[d][0].max(other.frame[d][0]), self.frame[d][1].min(other.frame[d][1])]);
        frame.iter().all(|[low, high]| high - low > depth)
            && grid(frame, SHARED).any(|p| self.contains(p) && other.contains(p))
    }

    fn covers(&self, axis: usize, ends: &[[f64; 2]]) -> bool {
        let mut section: [[f64; 2]; 3] = [ends[0], ends[1], ends[2]];
        section[axis] = [self.center[axis]; 2];
        let [low, high] = self.frame[axis];
        grid(section, SAMPLES).all(|mut p| {
            (0..=SAMPLES).any(|i| {
                p[axis] = low + (high - low) * i as f64 / SAMPLES as f64;
                self.contains(p)
            })
        })
    }
}

/// Return the middles of `n` parts along each side of a frame.
fn grid(frame: [[f64; 2]; 3], n: usize) -> impl Iterator<Item = [f64; 3]> {
    let at = move |[low, high]: [f64; 2], i: usize| low + (high - low) * (i as f64 + 0.5) / n as f64;
    (0..n * n * n).map(move |k| [at(frame[0], k / (n * n)), at(frame[1], k / n % n), at(frame[2], k % n)])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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
            return Figure::Sheet(Sheet::new(&nodes.iter().map(placed).collect::<Vec<_>>(), &triangles));
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
