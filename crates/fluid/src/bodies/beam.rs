//! The moving beam: its mask from the stations, and its loads back to them.
//!
//! The beam is the rectangle of thickness h around the polyline of the stations, with a flat tip. A point of segment k
//! at the fraction t and the height n above the centre line moves with the section (shear-free):
//!
//! `u_s = (1 - t) v_k + t v_{k+1} - omega n e`, `omega = (v_j - v_i)·m / |x_j - x_i|`,
//!
//! with e along the segment, and m normal to the line from station i to j. These are as far apart as the beam is thick:
//! a section does not turn within less. Loads go back through the transpose of this map, so that the power of the station
//! loads is that of the drag on the section.
//!
//! The rate of turning over a segment alone, finer than the thickness, would be large for stations that go up and down in
//! turn. Their drag would then be more than twice the announced impedance, which is for sections that do not turn, and an
//! explicit coupling would be unstable.

use scene::Mask;

use super::cells::{Cell, Cells};
use super::stations::{Loads, Stations};
use crate::force::Displaced;
use crate::grid::Grid;
use crate::wall::DragProfile;

/// Where in the beam a cell lies.
#[derive(Clone, Copy, Debug)]
struct Place {
    segment: u32,
    /// Fraction along the segment.
    fraction: f64,
    /// Height above the centre line, m.
    height: f64,
    /// Squared distance to the segment, m²: the nearest segment owns the cell.
    distance_squared: f64,
    /// Position from the root, m.
    arm: [f64; 2],
}

/// The beam and the cells in which it drags the fluid.
pub struct Beam {
    thickness: f64,
    /// Number of segments, odd, over which the sections of the middle one turn.
    turning_segments: usize,
    profile: DragProfile,
    /// How far the mask goes on behind the root, into the cylinder that the beam is clamped to, m.
    anchor: f64,
    /// Cells of the present position.
    pub cells: Cells,
    places: Vec<Place>,
    frames: Vec<Frame>,
    /// For each grid point, 1 + its number among the candidates of the present painting; 0 where it is none.
    slot: Vec<u32>,
    candidates: Vec<(usize, Place)>,
}

/// Direction and length of a segment, and the rate at which its sections turn.
#[derive(Clone, Copy, Debug)]
struct Frame {
    along: [f64; 2],
    length: f64,
    /// The line between the stations that tell how the sections turn.
    turning: Line,
    omega: f64,
    /// Rate at which they turned before the step, 1/s.
    omega_before: f64,
}

/// A line between two stations.
#[derive(Clone, Copy, Debug)]
struct Line {
    ends: [usize; 2],
    normal: [f64; 2],
    length: f64,
}

impl Line {
    fn between(ends: [usize; 2], position: &[Vec<f64>; 2]) -> Self {
        let [dx, dy] = [0, 1].map(|axis| position[axis][ends[1]] - position[axis][ends[0]]);
        let length = dx.hypot(dy);
        Self { ends, normal: [-dy / length, dx / length], length }
    }

    /// The rate at which it turns, 1/s.
    fn omega(&self, velocity: &[Vec<f64>; 2]) -> f64 {
        let [dvx, dvy] = [0, 1].map(|axis| velocity[axis][self.ends[1]] - velocity[axis][self.ends[0]]);
        (dvx * self.normal[0] + dvy * self.normal[1]) / self.length
    }
}

impl Frame {
    /// Left-hand normal of somebody who walks from root to tip.
    fn normal(&self) -> [f64; 2] {
        [-self.along[1], self.along[0]]
    }

    /// Velocity of the section at a place of this segment that turns at the rate `omega` (1/s), m/s.
    fn section_velocity(&self, place: &Place, omega: f64, stations: &Stations) -> [f64; 2] {
        let (k, t) = (place.segment as usize, place.fraction);
        [0, 1].map(|axis| {
            let v = &stations.velocity[axis];
            (1.0 - t) * v[k] + t * v[k + 1] - omega * place.height * self.along[axis]
        })
    }
}

impl Beam {
    /// The beam of a scene, not yet anywhere.
    pub fn new(beam: &scene::Beam, grid: &Grid, mask: &Mask, nu: f64) -> Self {
        let anchor = match beam.root {
            scene::Root::OnCylinder { .. } => 0.5 * beam.thickness,
            scene::Root::At { .. } => 0.0,
        };
        let line = Line { ends: [0, 1], normal: [0.0, 1.0], length: 1.0 };
        let still = Frame { along: [1.0, 0.0], length: 1.0, turning: line, omega: 0.0, omega_before: 0.0 };
        let as_thick = (beam.thickness * beam.segments as f64 / beam.length).ceil() as usize | 1;
        Self {
            thickness: beam.thickness,
            turning_segments: as_thick.min(beam.segments),
            profile: DragProfile::of_body(beam.thickness, mask, nu, grid.cell_size()),
            anchor,
            cells: Cells::default(),
            places: Vec::new(),
            frames: vec![still; beam.segments],
            slot: vec![0; grid.len()],
            candidates: Vec::new(),
        }
    }

    /// The fluid of a density (kg/m³) that it displaces at `stations`, where it was placed; moments are about the root.
    pub fn displaced(&self, stations: &Stations, density: f64) -> Displaced {
        let Stations { position: [x, y], velocity: [vx, vy] } = stations;
        let line_density = density * self.thickness;
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let (mut momentum, mut angular) = ([0.0; 2], 0.0);
        for (k, frame) in self.frames.iter().enumerate() {
            let mass = line_density * frame.length;
            let [start, end] = [k, k + 1].map(|k| ([x[k] - x[0], y[k] - y[0]], [vx[k], vy[k]]));
            let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let (arm, velocity) = (middle(start.0, end.0), middle(start.1, end.1));
            momentum[0] += mass * velocity[0];
            momentum[1] += mass * velocity[1];
            // Simpson's rule is exact: position and velocity are linear along the segment.
            angular += mass / 6.0 * (cross(start.0, start.1) + 4.0 * cross(arm, velocity) + cross(end.0, end.1));
            angular += mass / 12.0 * self.thickness.powi(2) * frame.omega;
        }
        Displaced { momentum, angular, transport: cross([vx[0], vy[0]], momentum) }
    }

    /// Move to `stations` and list the cells there; they were at `before`.
    pub fn place(&mut self, stations: &Stations, before: &Stations, grid: &Grid) {
        self.orient(stations, before);
        self.find_candidates(stations, grid);
        let last = self.frames.len() as u32 - 1;
        self.cells.clear();
        self.places.clear();
        for (index, place) in self.candidates.drain(..) {
            self.slot[index] = 0;
            let frame = &self.frames[place.segment as usize];
            let beyond = if place.segment == 0 {
                -place.fraction * frame.length - self.anchor
            } else if place.segment == last {
                (place.fraction - 1.0) * frame.length
            } else {
                f64::NEG_INFINITY
            };
            // The lines of equal drag are rectangles: with the Euclidean distance outside they would round the corners.
            let above = place.height.abs() - 0.5 * self.thickness;
            let distance = above.max(beyond);
            let rate = self.profile.rate(distance);
            if rate > 0.0 {
                let place = Place { fraction: place.fraction.clamp(0.0, 1.0), ..place };
                let velocity = frame.section_velocity(&place, frame.omega, stations);
                self.cells.push(index, rate, velocity, place.arm);
                if let Some(target) = self.profile.target() {
                    // The nearest surface is that of the tip or the root, or that above or below.
                    let normal = if beyond > above {
                        frame.along.map(|component| if place.segment == 0 { -component } else { component })
                    } else {
                        frame.normal().map(|component| component.copysign(component * place.height))
                    };
                    let point = grid.point(index);
                    let surface = [0, 1].map(|axis| point[axis] - distance * normal[axis]);
                    let before = frame.section_velocity(&place, frame.omega_before, before);
                    self.cells.follow_last(target, distance, surface, normal, before, grid);
                }
                self.places.push(place);
            }
        }
    }

    /// Directions and turning rates of the segments at `stations`, with the velocities there and with those `before`.
    fn orient(&mut self, stations: &Stations, before: &Stations) {
        let last = self.frames.len() - self.turning_segments;
        for (k, frame) in self.frames.iter_mut().enumerate() {
            let [ex, ey] = [0, 1].map(|axis| stations.position[axis][k + 1] - stations.position[axis][k]);
            frame.length = ex.hypot(ey);
            frame.along = [ex / frame.length, ey / frame.length];
            let from = k.saturating_sub(self.turning_segments / 2).min(last);
            frame.turning = Line::between([from, from + self.turning_segments], &stations.position);
            frame.omega = frame.turning.omega(&stations.velocity);
            frame.omega_before = frame.turning.omega(&before.velocity);
        }
    }

    /// List the grid points that the mask may reach, each with the nearest segment.
    fn find_candidates(&mut self, stations: &Stations, grid: &Grid) {
        let reach = 0.5 * self.thickness + self.profile.reach();
        let last = self.frames.len() - 1;
        let root = [stations.position[0][0], stations.position[1][0]];
        // Past a station, outside of the bend, what lies between the normals of both its segments belongs to it.
        let wedge = |k: usize| {
            let [[ax, ay], [bx, by]] = [&self.frames[k - 1], &self.frames[k]].map(|frame| frame.along);
            let (sine, cosine) = (ax * by - ay * bx, ax * bx + ay * by);
            if cosine > 0.0 { reach * sine.abs() } else { reach }
        };
        let (slot, candidates) = (&mut self.slot, &mut self.candidates);
        for (k, frame) in self.frames.iter().enumerate() {
            let [x0, y0] = [stations.position[0][k], stations.position[1][k]];
            let [ex, ey] = frame.along;
            // The end segments own what lies beyond them; the others end at their stations.
            let (before, low) = if k == 0 { (reach + self.anchor, f64::NEG_INFINITY) } else { (wedge(k), 0.0) };
            let (beyond, high) = if k == last { (reach, f64::INFINITY) } else { (wedge(k + 1), 1.0) };
            // The smallest upright rectangle around the segment's own one.
            let end = frame.length + beyond;
            let around = |start: f64, along: f64, across: f64| {
                let (a, b) = (start - before * along, start + end * along);
                let margin = reach * across.abs();
                [a.min(b) - margin, a.max(b) + margin]
            };
            grid.for_each_in(around(x0, ex, ey), around(y0, ey, ex), |index, x, y| {
                let (rx, ry) = (x - x0, y - y0);
                let ahead = rx * ex + ry * ey;
                let side = ex * ry - ey * rx;
                if ahead < -before || ahead > end || side.abs() > reach {
                    return;
                }
                let projection = ahead / frame.length;
                let clamped = projection.clamp(0.0, 1.0);
                let miss = (projection - clamped) * frame.length;
                let distance_squared = side * side + miss * miss;
                // Past an inner station the height is the distance to that station.
                let fraction = projection.clamp(low, high);
                let off = (projection - fraction) * frame.length;
                let height = if off == 0.0 { side } else { side.hypot(off).copysign(side) };
                let arm = [x - root[0], y - root[1]];
                let place = Place { segment: k as u32, fraction, height, distance_squared, arm };
                match slot[index] {
                    0 => {
                        candidates.push((index, place));
                        slot[index] = candidates.len() as u32;
                    }
                    number => {
                        let known = &mut candidates[number as usize - 1].1;
                        if distance_squared < known.distance_squared {
                            *known = place;
                        }
                    }
                }
            });
        }
    }

    /// Velocity of the section, m/s, in each of the cells, in their order.
    pub fn section_velocities<'a>(&'a self, stations: &'a Stations) -> impl Iterator<Item = [f64; 2]> + 'a {
        self.places.iter().map(|place| {
            let frame = &self.frames[place.segment as usize];
            frame.section_velocity(place, frame.omega, stations)
        })
    }

    /// Bring the drag on each cell to the stations.
    ///
    /// `drag(cell)` is the force on the cell per metre of depth (N) and the rate at which it falls with the body's
    /// velocity there (kg/(m s)), per axis. The impedance of a station is that for its motion across the beam.
    pub fn collect(&self, mut drag: impl FnMut(&Cell) -> ([f64; 2], [f64; 2]), loads: &mut Loads) {
        loads.force.iter_mut().for_each(|f| f.fill(0.0));
        loads.impedance.fill(0.0);
        for (cell, place) in self.cells.iter().zip(&self.places) {
            let ([fx, fy], [along_x, along_y]) = drag(cell);
            let (k, t) = (place.segment as usize, place.fraction);
            let frame = &self.frames[k];
            let Line { ends: [from, to], normal: across, length } = frame.turning;
            let couple = -place.height * (fx * frame.along[0] + fy * frame.along[1]) / length;
            let normal = frame.normal();
            let impedance = along_x * normal[0] * normal[0] + along_y * normal[1] * normal[1];
            for (axis, f) in [fx, fy].into_iter().enumerate() {
                loads.force[axis][k] += (1.0 - t) * f;
                loads.force[axis][k + 1] += t * f;
                loads.force[axis][from] -= couple * across[axis];
                loads.force[axis][to] += couple * across[axis];
            }
            loads.impedance[k] += (1.0 - t) * impedance;
            loads.impedance[k + 1] += t * impedance;
        }
    }

    /// Points on the upper (`side` = 1) or lower (−1) surface at the stations, m.
    pub fn surface_point(&self, stations: &Stations, k: usize, side: f64) -> [f64; 2] {
        let before = self.frames[k.saturating_sub(1)].normal();
        let after = self.frames[k.min(self.frames.len() - 1)].normal();
        let sum = [before[0] + after[0], before[1] + after[1]];
        let scale = side * 0.5 * self.thickness / sum[0].hypot(sum[1]);
        [stations.position[0][k] + scale * sum[0], stations.position[1][k] + scale * sum[1]]
    }
}
