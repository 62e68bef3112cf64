//! The moving beam: its mask from the stations, and its loads back to them.
//!
//! The beam is the band of thickness h, linear in each segment, around the polyline of the stations, with a flat tip. A point of segment k
//! at the fraction t and the height n above the centre line moves with the section (shear-free):
//!
//! `u_s = (1 - t) v_k + t v_{k+1} - omega n e`, `omega = (v_{k+1} - v_k)·m / |segment|`,
//!
//! with e along and m normal to the segment. Loads go back through the transpose of this map, so that the power of the
//! station loads is that of the drag on the section.

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
    /// Thickness at the middle of each segment, m, and by how much the end of the segment is thicker than its beginning.
    thickness: Vec<[f64; 2]>,
    /// Drag of each segment.
    profiles: Vec<DragProfile>,
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

/// Direction and length of a segment, and the rate at which it turns.
#[derive(Clone, Copy, Debug)]
struct Frame {
    along: [f64; 2],
    length: f64,
    omega: f64,
    /// Rate at which it turned before the step, 1/s.
    omega_before: f64,
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
        let at: Vec<_> = beam.places().map(|s| beam.thickness.at(s)).collect();
        let anchor = match beam.root {
            scene::Root::OnCylinder { .. } => 0.5 * at[0],
            scene::Root::At { .. } => 0.0,
        };
        // Between the stations the thickness is linear, whatever its law.
        let ends = at.iter().step_by(2).zip(at.iter().step_by(2).skip(1));
        let thickness: Vec<_> = ends.map(|(start, end)| [0.5 * (start + end), end - start]).collect();
        let mut profiles: Vec<DragProfile> = Vec::with_capacity(beam.segments);
        for k in 0..beam.segments {
            // Calibrating a wall takes its time: segments of equal thickness share it.
            let known = if k > 0 && thickness[k][0] == thickness[k - 1][0] { profiles.last().copied() } else { None };
            profiles.push(known.unwrap_or_else(|| DragProfile::of_body(thickness[k][0], mask, nu, grid.cell_size())));
        }
        let still = Frame { along: [1.0, 0.0], length: 1.0, omega: 0.0, omega_before: 0.0 };
        Self {
            thickness,
            profiles,
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
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let (mut momentum, mut angular) = ([0.0; 2], 0.0);
        for (k, (frame, &[thickness, growth])) in self.frames.iter().zip(&self.thickness).enumerate() {
            let mass = density * thickness * frame.length;
            // The first moment of the mass over its distance from the middle, both in segments.
            let lean = density * growth * frame.length / 12.0;
            let [start, end] = [k, k + 1].map(|k| ([x[k] - x[0], y[k] - y[0]], [vx[k], vy[k]]));
            let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let (arm, velocity) = (middle(start.0, end.0), middle(start.1, end.1));
            momentum[0] += mass * velocity[0] + lean * (end.1[0] - start.1[0]);
            momentum[1] += mass * velocity[1] + lean * (end.1[1] - start.1[1]);
            // Simpson's rule is exact: position and velocity are linear along the segment.
            angular += mass / 6.0 * (cross(start.0, start.1) + 4.0 * cross(arm, velocity) + cross(end.0, end.1));
            angular += lean * (cross(end.0, end.1) - cross(start.0, start.1));
            angular += mass / 12.0 * (thickness.powi(2) + 0.25 * growth.powi(2)) * frame.omega;
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
            // The lines of equal drag have corners: with the Euclidean distance outside they would round them.
            let [thickness, growth] = self.thickness[place.segment as usize];
            let half = 0.5 * (thickness + (place.fraction.clamp(0.0, 1.0) - 0.5) * growth);
            let slope = 0.5 * growth / frame.length;
            let stretch = (1.0 + slope * slope).sqrt();
            let above = (place.height.abs() - half) / stretch;
            let distance = above.max(beyond);
            let profile = &self.profiles[place.segment as usize];
            let rate = profile.rate(distance);
            if rate > 0.0 {
                let place = Place { fraction: place.fraction.clamp(0.0, 1.0), ..place };
                let velocity = frame.section_velocity(&place, frame.omega, stations);
                self.cells.push(index, rate, velocity, place.arm);
                if let Some(target) = profile.target() {
                    // The nearest surface is that of the tip or the root, or that above or below.
                    let normal = if beyond > above {
                        frame.along.map(|component| if place.segment == 0 { -component } else { component })
                    } else {
                        let across = frame.normal().map(|component| component.copysign(component * place.height));
                        [0, 1].map(|axis| (across[axis] - slope * frame.along[axis]) / stretch)
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
        for (k, frame) in self.frames.iter_mut().enumerate() {
            let difference = |field: &[Vec<f64>; 2]| [field[0][k + 1] - field[0][k], field[1][k + 1] - field[1][k]];
            let [ex, ey] = difference(&stations.position);
            frame.length = ex.hypot(ey);
            frame.along = [ex / frame.length, ey / frame.length];
            let [mx, my] = frame.normal();
            [frame.omega, frame.omega_before] = [stations, before].map(|stations| {
                let [dvx, dvy] = difference(&stations.velocity);
                (dvx * mx + dvy * my) / frame.length
            });
        }
    }

    /// List the grid points that the mask may reach, each with the nearest segment.
    fn find_candidates(&mut self, stations: &Stations, grid: &Grid) {
        let last = self.frames.len() - 1;
        let reaches = |k: usize| {
            let [thickness, growth] = self.thickness[k];
            0.5 * (thickness + 0.5 * growth.abs()) + self.profiles[k].reach()
        };
        let root = [stations.position[0][0], stations.position[1][0]];
        // Past a station, outside of the bend, what lies between the normals of both its segments belongs to it.
        let wedge = |k: usize, reach: f64| {
            let [[ax, ay], [bx, by]] = [&self.frames[k - 1], &self.frames[k]].map(|frame| frame.along);
            let (sine, cosine) = (ax * by - ay * bx, ax * bx + ay * by);
            if cosine > 0.0 { reach * sine.abs() } else { reach }
        };
        let (slot, candidates) = (&mut self.slot, &mut self.candidates);
        for (k, frame) in self.frames.iter().enumerate() {
            let reach = reaches(k);
            let [x0, y0] = [stations.position[0][k], stations.position[1][k]];
            let [ex, ey] = frame.along;
            // The end segments own what lies beyond them; the others end at their stations.
            let (before, low) = if k == 0 { (reach + self.anchor, f64::NEG_INFINITY) } else { (wedge(k, reach), 0.0) };
            let (beyond, high) = if k == last { (reach, f64::INFINITY) } else { (wedge(k + 1, reach), 1.0) };
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
            let couple = -place.height * (fx * frame.along[0] + fy * frame.along[1]) / frame.length;
            let normal = frame.normal();
            let impedance = along_x * normal[0] * normal[0] + along_y * normal[1] * normal[1];
            for (axis, f) in [fx, fy].into_iter().enumerate() {
                loads.force[axis][k] += (1.0 - t) * f - couple * normal[axis];
                loads.force[axis][k + 1] += t * f + couple * normal[axis];
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
        let [thickness, growth] = self.thickness[k.min(self.frames.len() - 1)];
        let here = if k < self.frames.len() { thickness - 0.5 * growth } else { thickness + 0.5 * growth };
        let scale = side * 0.5 * here / sum[0].hypot(sum[1]);
        [stations.position[0][k] + scale * sum[0], stations.position[1][k] + scale * sum[1]]
    }
}

#[cfg(test)]
mod tests {
    use scene::{Along, FluidBox, PlaceLaw, Root};

    use super::*;

    const ROOT: [f64; 2] = [0.3, 0.2];
    const DIRECTION: [f64; 2] = [0.8, 0.6];
    const OMEGA: f64 = 1.7;
    /// Thickness at the root and at the tip.
    const ENDS: [f64; 2] = [0.2, 0.04];

    /// A beam of length 1 that tapers, turns about its root and moves along with it; painted with a sharp mask.
    fn turning() -> (Beam, Stations, Grid) {
        let grid = Grid::new(&FluidBox { x: [0.0, 1.5], y: [0.0, 1.5], cells: [600, 600] });
        let scene = scene::Beam {
            root: Root::At { position: ROOT.to_vec(), direction: DIRECTION.to_vec() },
            length: 1.0,
            thickness: Along::Varying(PlaceLaw::Taper { root: ENDS[0], tip: ENDS[1], power: 1.0 }),
            segments: 8,
            rest_angles: Vec::new(),
        };
        let mask = Mask::Sharp { c_eta: 1.0, displacement_corrected: false };
        let mut beam = Beam::new(&scene, &grid, &mask, 1e-3);
        let along = |axis: usize| (0..=8).map(move |k| ROOT[axis] + DIRECTION[axis] * f64::from(k) / 8.0).collect();
        let speed = |axis: usize| {
            let across = [-DIRECTION[1], DIRECTION[0]];
            (0..=8).map(move |k| 0.5 + OMEGA * across[axis] * f64::from(k) / 8.0).collect()
        };
        let stations = Stations { position: [along(0), along(1)], velocity: [speed(0), speed(1)] };
        beam.place(&stations, &stations, &grid);
        (beam, stations, grid)
    }

    #[test]
    fn mask_has_the_area_of_the_tapered_beam() {
        let (beam, _, grid) = turning();
        let sum = |weight: &dyn Fn(&Cell) -> f64| beam.cells.iter().map(weight).sum::<f64>() * grid.cell_area();
        let area = sum(&|_| 1.0);
        let centre = sum(&|cell| cell.arm[0] * DIRECTION[0] + cell.arm[1] * DIRECTION[1]) / area;
        // (h0 + h1) / 2 and (h0 + 2 h1) / (3 (h0 + h1)) of a trapezium.
        assert!((area / 0.12 - 1.0).abs() < 2e-3, "area {area}");
        assert!((centre / (0.28 / 0.72) - 1.0).abs() < 2e-3, "centre at {centre}");
    }

    #[test]
    fn drag_of_the_cosine_mask_falls_across_the_sloped_surface() {
        let (mut beam, stations, grid) = turning();
        let mask = Mask::Cosine { c_eta: 1.0, half_width: 6.0, displacement_corrected: false };
        beam.profiles =
            beam.thickness.iter().map(|h| DragProfile::of_body(h[0], &mask, 1e-3, grid.cell_size())).collect();
        beam.place(&stations, &stations, &grid);
        let slope = 0.5 * (ENDS[1] - ENDS[0]);
        for cell in beam.cells.iter() {
            let along = cell.arm[0] * DIRECTION[0] + cell.arm[1] * DIRECTION[1];
            let height = (cell.arm[1] * DIRECTION[0] - cell.arm[0] * DIRECTION[1]).abs();
            if (0.2..0.8).contains(&along) {
                let distance = (height - 0.5 * ENDS[0] - slope * along) / slope.hypot(1.0);
                let expected = beam.profiles[0].rate(distance);
                assert!((cell.rate - expected).abs() < 1e-9, "at {along}, {height}: {} against {expected}", cell.rate);
            }
        }
    }

    #[test]
    fn displaced_fluid_has_the_momentum_of_the_tapered_beam() {
        let (beam, stations, _) = turning();
        let found = beam.displaced(&stations, 2.0);
        let across = [-DIRECTION[1], DIRECTION[0]];
        // Integrals over 0 … 1 of h = h0 + (h1 − h0) s times 1, s and s², and of h³/12.
        let [h0, dh] = [ENDS[0], ENDS[1] - ENDS[0]];
        let moments = [h0 + dh / 2.0, h0 / 2.0 + dh / 3.0, h0 / 3.0 + dh / 4.0];
        let turning = (ENDS[0].powi(4) - ENDS[1].powi(4)) / (4.0 * (ENDS[0] - ENDS[1])) / 12.0;
        for (across, found) in across.iter().zip(found.momentum) {
            let expected = 2.0 * (0.5 * moments[0] + OMEGA * across * moments[1]);
            assert!((found - expected).abs() < 1e-14, "{found} against {expected}");
        }
        let shift = 0.5 * (DIRECTION[0] - DIRECTION[1]) * moments[1];
        let expected = 2.0 * (shift + OMEGA * (moments[2] + turning));
        assert!((found.angular - expected).abs() < 1e-14, "{} against {expected}", found.angular);
    }
}
