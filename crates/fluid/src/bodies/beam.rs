//! The moving beam: its mask from the stations, and its loads back to them.
//!
//! The beam is the band around the polyline of the stations, with a flat tip; its thickness is linear in each segment.
//! At a station the tangent is that of the bisector of its segments, and in between it turns linearly. A point belongs to
//! the place on the polyline to which the tangent is at right angles: so place, height and all that follows from them
//! are continuous in the point and in the stations, and so are the loads. At the fraction t of segment k and the height n
//! above the centre line it moves with the section (shear-free):
//!
//! `u_s = (1 - t) v_k + t v_{k+1} - omega n e`, `omega = (1 - t) omega_k + t omega_{k+1}`
//!
//! with e the tangent there. A station turns at the rate `omega_k = (v_j - v_i)·m / |x_j - x_i|` of the line from
//! station i to j around it, with the normal m, which is at least as long as the beam is thick. The rate over a segment
//! alone would be large for stations that go up and down in turn. Their drag would then be more than twice the announced
//! impedance, which is for sections that do not turn, and an explicit coupling would be unstable.
//!
//! Loads go back through the transpose of this map, so that the power of the station loads is that of the drag on the
//! section.

use std::mem::swap;

use scene::Mask;

use super::cells::{Cell, Cells, Near};
use super::stations::{Loads, Stations};
use crate::force::Displaced;
use crate::grid::Grid;
use crate::wall::DragProfile;

/// A grid point that the mask may reach.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    index: usize,
    segment: usize,
    /// Fraction along the segment; it may lie beyond the ends of the beam.
    fraction: f64,
    /// Height above the centre line, m.
    height: f64,
    /// Squared distance from its place on the polyline, m².
    distance_squared: f64,
    /// Position from the root, m.
    arm: [f64; 2],
}

/// Where in the beam a cell lies.
#[derive(Clone, Copy, Debug)]
struct Place {
    segment: usize,
    /// Fraction along the segment.
    fraction: f64,
    /// Height above the centre line, m.
    height: f64,
    /// Unit tangent.
    tangent: [f64; 2],
    /// Whether it is in the part that goes on behind the root: the cylinder there bears what acts on that.
    behind: bool,
}

/// The beam, where it is and where it goes next.
pub struct Beam {
    band: Band,
    /// The present position.
    pub here: Placed,
    /// Another, found before the beam goes there.
    ahead: Placed,
    search: Search,
}

/// What of a beam does not move.
struct Band {
    /// Thickness at the middle of each segment, m, and by how much the end of the segment is thicker than its beginning.
    thickness: Vec<[f64; 2]>,
    /// Drag of each segment.
    profiles: Vec<DragProfile>,
    /// How far the mask goes on behind the root, into the cylinder that the beam is clamped to, m.
    anchor: f64,
    /// The cylinder that it is clamped to.
    holder: Option<usize>,
}

/// A beam at some stations.
pub struct Placed {
    /// The cells in which it drags the fluid.
    pub cells: Cells,
    places: Vec<Place>,
    segments: Vec<Segment>,
    /// `[n + 1]`.
    sections: Vec<Section>,
}

/// What a search for the cells of a beam needs.
struct Search {
    /// For each grid point, 1 + its number among the candidates of the present search; 0 where it is none.
    slot: Vec<u32>,
    candidates: Vec<Candidate>,
}

/// Direction and length of a segment.
#[derive(Clone, Copy, Debug)]
struct Segment {
    along: [f64; 2],
    length: f64,
    /// How its upper surface rises from the centre line, and the length of that surface over its own.
    slope: f64,
    stretch: f64,
}

/// The section at a station.
#[derive(Clone, Copy, Debug)]
struct Section {
    /// Unit tangent.
    tangent: [f64; 2],
    /// Stations that tell how the section turns, the unit normal of the line between them, and its length, m.
    ends: [usize; 2],
    across: [f64; 2],
    span: f64,
    /// Rates at which it turns, and turned before the step, 1/s.
    omega: f64,
    omega_before: f64,
}

/// Left-hand normal of somebody who walks along.
fn normal([x, y]: [f64; 2]) -> [f64; 2] {
    [-y, x]
}

fn unit(vector: [f64; 2]) -> [f64; 2] {
    direction(vector).0
}

/// Direction, and length.
fn direction([x, y]: [f64; 2]) -> ([f64; 2], f64) {
    let length = x.hypot(y);
    ([x / length, y / length], length)
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// From one entry of a field to another.
fn difference(field: &[Vec<f64>; 2], [from, to]: [usize; 2]) -> [f64; 2] {
    field.each_ref().map(|f| f[to] - f[from])
}

/// Unit tangent at station `k`: that of the bisector of its segments, of which `along` gives the directions, from 0 to
/// `last`.
fn bisector(k: usize, last: usize, along: impl Fn(usize) -> [f64; 2]) -> [f64; 2] {
    let [behind, ahead] = [k.saturating_sub(1), k.min(last)].map(along);
    unit([behind[0] + ahead[0], behind[1] + ahead[1]])
}

/// What lies the fraction `t` of the way from `a` to `b`.
fn between(a: [f64; 2], b: [f64; 2], t: f64) -> [f64; 2] {
    [0, 1].map(|axis| (1.0 - t) * a[axis] + t * b[axis])
}

impl Place {
    /// Velocity of the section where the stations turn at the rates `omega` (1/s), m/s.
    fn velocity(&self, sections: &[Section], omega: impl Fn(&Section) -> f64, stations: &Stations) -> [f64; 2] {
        let (k, t) = (self.segment, self.fraction);
        let [start, end] = [k, k + 1].map(|k| stations.velocity.each_ref().map(|v| v[k]));
        let omega = (1.0 - t) * omega(&sections[k]) + t * omega(&sections[k + 1]);
        let center = between(start, end, t);
        [0, 1].map(|axis| center[axis] - omega * self.height * self.tangent[axis])
    }
}

impl Placed {
    /// List the cells at `stations`; they were at `before`.
    fn put(&mut self, band: &Band, search: &mut Search, stations: &Stations, before: &Stations, grid: &Grid) {
        self.orient(&band.thickness, stations, before);
        self.find_candidates(band, search, stations, grid);
        let last = self.segments.len() - 1;
        self.cells.clear();
        self.places.clear();
        for Candidate { index, segment: k, fraction, height, arm, .. } in search.candidates.drain(..) {
            search.slot[index] = 0;
            let Segment { length, slope, stretch, .. } = self.segments[k];
            let beyond = if k == 0 {
                -fraction * length - band.anchor
            } else if k == last {
                (fraction - 1.0) * length
            } else {
                f64::NEG_INFINITY
            };
            let behind = band.holder.is_some() && fraction < 0.0;
            let fraction = fraction.clamp(0.0, 1.0);
            // The lines of equal drag have corners: with the Euclidean distance outside they would round them.
            let [thickness, growth] = band.thickness[k];
            let half = 0.5 * (thickness + (fraction - 0.5) * growth);
            let [above, below] = [height, -height].map(|height| (height - half) / stretch);
            let distance = above.max(below).max(beyond);
            let profile = &band.profiles[k];
            let rate = profile.rate(distance);
            if rate > 0.0 {
                let tangent = unit(between(self.sections[k].tangent, self.sections[k + 1].tangent, fraction));
                let place = Place { segment: k, fraction, height, tangent, behind };
                self.cells.push(index, rate, place.velocity(&self.sections, |section| section.omega, stations), arm);
                if let Some(target) = profile.target(distance) {
                    let point = grid.point(index);
                    let before = place.velocity(&self.sections, |section| section.omega_before, before);
                    let across = normal(tangent);
                    let [upper, lower] = [1.0, -1.0]
                        .map(|side| [0, 1].map(|axis| (side * across[axis] - slope * tangent[axis]) / stretch));
                    let end = if k == 0 { tangent.map(|component| -component) } else { tangent };
                    let distances = [above, below, beyond];
                    let surfaces = distances.into_iter().zip([upper, lower, end]);
                    for ((distance, normal), share) in surfaces.zip(target.shares(distances)) {
                        if share > 0.0 && target.reaches(distance) {
                            let surface = [0, 1].map(|axis| point[axis] - distance * normal[axis]);
                            self.cells.follow_last(target, Near { distance, surface, normal, share }, before, grid);
                        }
                    }
                }
                self.places.push(place);
            }
        }
    }

    /// Directions of segments and sections at `stations`, and how these turn with the velocities there and with those
    /// `before`.
    fn orient(&mut self, thickness: &[[f64; 2]], stations: &Stations, before: &Stations) {
        for (k, (segment, [_, growth])) in self.segments.iter_mut().zip(thickness).enumerate() {
            let (along, length) = direction(difference(&stations.position, [k, k + 1]));
            let slope = 0.5 * growth / length;
            *segment = Segment { along, length, slope, stretch: (1.0 + slope * slope).sqrt() };
        }
        for (k, section) in self.sections.iter_mut().enumerate() {
            section.tangent = bisector(k, self.segments.len() - 1, |k| self.segments[k].along);
            let (line, span) = direction(difference(&stations.position, section.ends));
            (section.span, section.across) = (span, normal(line));
            [section.omega, section.omega_before] = [stations, before]
                .map(|stations| dot(difference(&stations.velocity, section.ends), section.across) / section.span);
        }
    }

    /// List the grid points that the mask may reach, each with the nearest of its places.
    fn find_candidates(&self, band: &Band, search: &mut Search, stations: &Stations, grid: &Grid) {
        /// Share of a segment by which its end may seem to lie beyond that of its neighbour.
        const ROUNDING: f64 = 1e-9;
        let last = self.segments.len() - 1;
        let root = [stations.position[0][0], stations.position[1][0]];
        let Search { slot, candidates } = search;
        for (k, &Segment { along: [ex, ey], length, .. }) in self.segments.iter().enumerate() {
            let [thickness, growth] = band.thickness[k];
            let reach = 0.5 * (thickness + 0.5 * growth.abs()) + band.profiles[k].reach();
            let [x0, y0] = [stations.position[0][k], stations.position[1][k]];
            // The tangents at both ends, along the segment and to the left.
            let [(c0, s0), (c1, s1)] = [k, k + 1].map(|k| {
                let [tx, ty] = self.sections[k].tangent;
                (tx * ex + ty * ey, ex * ty - ey * tx)
            });
            // How far the rectangle of the segment goes beyond its stations, with the leaning sections at both ends.
            let wedge = |c: f64, s: f64| if c > s.abs() { reach * s.abs() / c } else { reach };
            let before = if k == 0 { reach + band.anchor } else { wedge(c0, s0) };
            let beyond = if k == last { reach } else { wedge(c1, s1) };
            // The smallest upright rectangle around it.
            let end = length + beyond;
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
                // (r − t l e)·((1 − t) T_k + t T_{k+1}) = 0; beyond the ends of the beam the tangent stays.
                let start = ahead * c0 + side * s0;
                let stop = (ahead - length) * c1 + side * s1;
                let fraction = if (k == 0 && start < 0.0) || (k == last && stop > 0.0) {
                    ahead / length
                } else if start < -ROUNDING * length || stop > ROUNDING * length {
                    return;
                } else {
                    let (bend, rate) = (length * (c1 - c0), ahead * (c1 - c0) + side * (s1 - s0) - length * c0);
                    (2.0 * start / ((rate * rate + 4.0 * bend * start).sqrt() - rate)).clamp(0.0, 1.0)
                };
                if fraction.is_nan() {
                    return;
                }
                let off = ahead - fraction * length;
                let (height, arm) = (side.hypot(off).copysign(side), [x - root[0], y - root[1]]);
                let past = (fraction - fraction.clamp(0.0, 1.0)) * length;
                let distance_squared = height * height + past * past;
                let candidate = Candidate { index, segment: k, fraction, height, distance_squared, arm };
                match slot[index] {
                    0 => {
                        candidates.push(candidate);
                        slot[index] = candidates.len() as u32;
                    }
                    number => {
                        let known = &mut candidates[number as usize - 1];
                        if distance_squared < known.distance_squared {
                            *known = candidate;
                        }
                    }
                }
            });
        }
    }
}

impl Beam {
    /// The beam of a scene, not yet anywhere.
    pub fn new(beam: &scene::Beam, grid: &Grid, mask: &Mask, nu: f64) -> Self {
        let at: Vec<_> = beam.places().map(|s| beam.thickness.at(s)).collect();
        let (anchor, holder) = match beam.root {
            scene::Root::OnCylinder { cylinder, .. } => (0.5 * at[0], Some(cylinder)),
            scene::Root::At { .. } => (0.0, None),
        };
        // Between the stations the thickness is linear, whatever its law.
        let ends = at.iter().step_by(2).zip(at.iter().step_by(2).skip(1));
        let thickness: Vec<_> = ends.map(|(start, end)| [0.5 * (start + end), end - start]).collect();
        let (mut profiles, dx) = (Vec::<DragProfile>::with_capacity(beam.segments), grid.cell_size());
        for k in 0..beam.segments {
            // Calibrating a wall takes its time: segments of equal thickness share it.
            let known = if k > 0 && thickness[k][0] == thickness[k - 1][0] { profiles.last().copied() } else { None };
            profiles.push(known.unwrap_or_else(|| DragProfile::of_body(thickness[k][0], true, mask, nu, dx)));
        }
        let ahead = Segment { along: [1.0, 0.0], length: 1.0, slope: 0.0, stretch: 1.0 };
        let section = |k: usize| {
            let half = (0.5 * at[2 * k] * beam.segments as f64 / beam.length).ceil() as usize;
            let span = (2 * half).clamp(2, beam.segments);
            let from = k.saturating_sub(span / 2).min(beam.segments - span);
            let still = Section {
                tangent: [1.0, 0.0],
                ends: [0, 1],
                across: [0.0, 1.0],
                span: 1.0,
                omega: 0.0,
                omega_before: 0.0,
            };
            Section { ends: [from, from + span], ..still }
        };
        let nowhere = || Placed {
            cells: Cells::default(),
            places: Vec::new(),
            segments: vec![ahead; beam.segments],
            sections: (0..=beam.segments).map(section).collect(),
        };
        Self {
            band: Band { thickness, profiles, anchor, holder },
            here: nowhere(),
            ahead: nowhere(),
            search: Search { slot: vec![0; grid.len()], candidates: Vec::new() },
        }
    }

    /// The cylinder that it is clamped to.
    pub fn holder(&self) -> Option<usize> {
        self.band.holder
    }

    /// The fluid of a density (kg/m³) that it displaces at `stations`, where it was placed; moments are about the root.
    pub fn displaced(&self, stations: &Stations, density: f64) -> Displaced {
        let Stations { position: [x, y], velocity: [vx, vy] } = stations;
        let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let (mut momentum, mut angular) = ([0.0; 2], 0.0);
        for (k, (segment, &[thickness, growth])) in self.here.segments.iter().zip(&self.band.thickness).enumerate() {
            let mass = density * thickness * segment.length;
            // The first moment of the mass over its distance from the middle, both in segments.
            let lean = density * growth * segment.length / 12.0;
            let [start, end] = [k, k + 1].map(|k| ([x[k] - x[0], y[k] - y[0]], [vx[k], vy[k]]));
            let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let (arm, velocity) = (middle(start.0, end.0), middle(start.1, end.1));
            momentum[0] += mass * velocity[0] + lean * (end.1[0] - start.1[0]);
            momentum[1] += mass * velocity[1] + lean * (end.1[1] - start.1[1]);
            // Simpson's rule is exact: position and velocity are linear along the segment.
            angular += mass / 6.0 * (cross(start.0, start.1) + 4.0 * cross(arm, velocity) + cross(end.0, end.1));
            angular += lean * (cross(end.0, end.1) - cross(start.0, start.1));
            let omega = 0.5 * (self.here.sections[k].omega + self.here.sections[k + 1].omega);
            angular += mass / 12.0 * (thickness.powi(2) + 0.25 * growth.powi(2)) * omega;
        }
        Displaced { momentum, angular, transport: cross([vx[0], vy[0]], momentum) }
    }

    /// Move to `stations`; they were at `before`.
    pub fn place(&mut self, stations: &Stations, before: &Stations, grid: &Grid) {
        self.here.put(&self.band, &mut self.search, stations, before, grid);
    }

    /// Find where it gets to at `ahead`, to which it goes on from `stations`.
    pub fn look_ahead(&mut self, ahead: &Stations, stations: &Stations, grid: &Grid) {
        self.ahead.put(&self.band, &mut self.search, ahead, stations, grid);
    }

    /// Go there.
    pub fn go_ahead(&mut self) {
        swap(&mut self.here, &mut self.ahead);
    }

    /// The cells, each with the velocity of its section, m/s, unless the cylinder bears what acts on it.
    pub fn cells_and_velocities<'a>(
        &'a self,
        stations: &'a Stations,
    ) -> impl Iterator<Item = (&'a Cell, Option<[f64; 2]>)> {
        let velocity = |place: &Place| place.velocity(&self.here.sections, |section| section.omega, stations);
        self.here
            .cells
            .iter()
            .zip(&self.here.places)
            .map(move |(cell, place)| (cell, (!place.behind).then(|| velocity(place))))
    }

    /// Bring the drag on each cell to the stations.
    ///
    /// `drag(cell)` is the force on the cell per metre of depth (N) and the rate at which it falls with the body's
    /// velocity there (kg/(m s)), per axis. The impedance of a station is that for its motion across the beam.
    pub fn collect(&self, mut drag: impl FnMut(&Cell) -> ([f64; 2], [f64; 2]), loads: &mut Loads) {
        loads.force.iter_mut().for_each(|f| f.fill(0.0));
        loads.impedance.fill(0.0);
        let Placed { cells, places, sections, .. } = &self.here;
        for (cell, place) in cells.iter().zip(places).filter(|(_, place)| !place.behind) {
            let ([fx, fy], [along_x, along_y]) = drag(cell);
            let Place { segment: k, fraction: t, tangent, .. } = *place;
            let moment = -place.height * dot([fx, fy], tangent);
            let [nx, ny] = normal(tangent);
            let impedance = along_x * nx * nx + along_y * ny * ny;
            for (station, share) in [(k, 1.0 - t), (k + 1, t)] {
                let Section { ends: [from, to], across, span, .. } = sections[station];
                for (axis, f) in [fx, fy].into_iter().enumerate() {
                    let couple = share * moment / span * across[axis];
                    loads.force[axis][station] += share * f;
                    loads.force[axis][from] -= couple;
                    loads.force[axis][to] += couple;
                }
            }
            loads.impedance[k] += (1.0 - t) * impedance;
            loads.impedance[k + 1] += t * impedance;
        }
    }

    /// Points on the upper (`side` = 1) or lower (−1) surface at the stations, m.
    pub fn surface_point(&self, stations: &Stations, k: usize, side: f64) -> [f64; 2] {
        let last = self.here.segments.len() - 1;
        let [nx, ny] = normal(bisector(k, last, |k| unit(difference(&stations.position, [k, k + 1]))));
        let [thickness, growth] = self.band.thickness[k.min(last)];
        let here = if k < self.here.segments.len() { thickness - 0.5 * growth } else { thickness + 0.5 * growth };
        let height = side * 0.5 * here;
        [stations.position[0][k] + height * nx, stations.position[1][k] + height * ny]
    }
}

#[cfg(test)]
mod tests {
    use scene::{FluidBox, Root, Spanwise, SpanwiseProfile};

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
            thickness: Spanwise::Varying(SpanwiseProfile::Taper { root: ENDS[0], tip: ENDS[1], power: 1.0 }),
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
        let sum = |weight: &dyn Fn(&Cell) -> f64| beam.here.cells.iter().map(weight).sum::<f64>() * grid.cell_area();
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
        beam.band.profiles = beam
            .band
            .thickness
            .iter()
            .map(|h| DragProfile::of_body(h[0], true, &mask, 1e-3, grid.cell_size()))
            .collect();
        beam.place(&stations, &stations, &grid);
        let slope = 0.5 * (ENDS[1] - ENDS[0]);
        for cell in beam.here.cells.iter() {
            let along = cell.arm[0] * DIRECTION[0] + cell.arm[1] * DIRECTION[1];
            let height = (cell.arm[1] * DIRECTION[0] - cell.arm[0] * DIRECTION[1]).abs();
            if (0.2..0.8).contains(&along) {
                let distance = (height - 0.5 * ENDS[0] - slope * along) / slope.hypot(1.0);
                let expected = beam.band.profiles[0].rate(distance);
                assert!((cell.rate - expected).abs() < 1e-9, "at {along}, {height}: {} against {expected}", cell.rate);
            }
        }
    }

    /// A cell on the line where two surfaces are as near draws the fluid to the same velocity on both sides of it: one at
    /// a corner of the tip, outside or inside, and one in the middle of a thin beam.
    #[test]
    fn no_cell_turns_over_from_one_surface_to_the_other() {
        let grid = Grid::new(&FluidBox { x: [0.0, 1.0], y: [0.0, 1.0], cells: [100, 100] });
        let scene = scene::Beam {
            root: Root::At { position: vec![0.3, 0.5], direction: vec![1.0, 0.0] },
            length: 0.3,
            thickness: Spanwise::Constant(0.025),
            segments: 6,
            rest_angles: Vec::new(),
        };
        let target = scene::WallCorrection::Curvature;
        let mask = Mask::LogLinear { c_eta: 1e-5, decay_length_cells: 0.25, core_depth: None, wall_correction: target };
        let mut beam = Beam::new(&scene, &grid, &mask, 1e-3);
        let flow: Vec<_> = (0..grid.len()).map(|i| grid.point(i)).map(|[x, y]| [y + x * y, x - 2.0 * y * y]).collect();
        // A cell, and where the tip's upper corner is from it: on the bisector outside and inside, and far away.
        let [x, y] = grid.point(60 * grid.ny + 50);
        for [right, up] in [[0.003, 0.003], [-0.004, -0.004], [-0.1, -0.0125]] {
            let drawn = [-1e-10, 1e-10].map(|aside| {
                let root = [x - right - 0.3, y - up - 0.0125 + aside];
                let along = |axis: usize| (0..=6).map(|k| root[axis] + [0.05, 0.0][axis] * f64::from(k)).collect();
                let stations = Stations { position: [along(0), along(1)], velocity: [vec![0.0; 7], vec![0.0; 7]] };
                beam.place(&stations, &stations, &grid);
                beam.here.cells.sample(|point| flow[point]);
                beam.here
                    .cells
                    .iter()
                    .find(|cell| cell.index == 60 * grid.ny + 50)
                    .expect("the mask reaches it")
                    .velocity
            });
            let apart = (drawn[0][0] - drawn[1][0]).hypot(drawn[0][1] - drawn[1][1]);
            assert!(apart < 1e-6, "{right} m, {up} m: {drawn:?}");
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
