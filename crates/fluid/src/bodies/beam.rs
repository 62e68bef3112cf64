//! A beam: its mask, its present pose, and its loads.
//!
//! Loads go back to the stations through the transpose of the map from stations to cells ([`super::pose`]), so that the
//! power of the loads is the power of the drag on the sections.

use super::cells::Cell;
use super::frame::StationSection;
use super::mask::BeamMask;
use super::pose::{BeamPose, Place};
use super::search::Search;
use super::stations::{Loads, Stations};
use super::vector::{bisector, cross, difference, dot, normal, unit};
use crate::force::Displaced;
use crate::grid::Grid;
use crate::parameters::{self, Mask};

/// A beam with a mask.
pub struct Beam {
    /// Its number among all beams, from 0.
    pub number: usize,
    mask: BeamMask,
    /// The present pose.
    pub pose: BeamPose,
    search: Search,
}

impl Beam {
    /// The beam with a number, without a place yet.
    pub fn new(number: usize, beam: &parameters::Beam, grid: &Grid, mask: &Mask, nu: f64) -> Self {
        Self { number, mask: BeamMask::new(beam, grid, mask, nu), pose: BeamPose::new(beam), search: Search::new(grid) }
    }

    /// Return the cylinder that the beam is clamped to.
    pub fn support_cylinder(&self) -> Option<usize> {
        self.mask.support_cylinder
    }

    /// Move from the stations `before` to `stations`.
    pub fn place(&mut self, stations: &Stations, before: &Stations, grid: &Grid) {
        self.pose.find_cells(&self.mask, &mut self.search, stations, before, grid);
    }

    /// Write the pose at the stations `ahead`, to which the beam moves from `stations`.
    pub fn find_cells(&mut self, pose: &mut BeamPose, ahead: &Stations, stations: &Stations, grid: &Grid) {
        pose.find_cells(&self.mask, &mut self.search, ahead, stations, grid);
    }

    /// Return the cells, each with the velocity of its section (m/s) unless the cylinder bears its drag.
    pub fn cells_and_velocities<'a>(
        &'a self,
        stations: &'a Stations,
    ) -> impl Iterator<Item = (&'a Cell, Option<[f64; 2]>)> {
        self.pose.cells_and_velocities(stations)
    }

    /// Return the displaced fluid of a density (kg/m³) at the present `stations`; moments are about the root.
    pub fn displaced(&self, stations: &Stations, density: f64) -> Displaced {
        let Stations { position: [x, y], velocity: [vx, vy] } = stations;
        let frame = &self.pose.frame;
        let (mut momentum, mut angular) = ([0.0; 2], 0.0);
        for (k, (segment, &[thickness, growth])) in frame.segments.iter().zip(&self.mask.thickness).enumerate() {
            let mass = density * thickness * segment.length;
            // First moment of the mass about the middle of the segment, over its length.
            let lean = density * growth * segment.length / 12.0;
            let [start, end] = [k, k + 1].map(|k| ([x[k] - x[0], y[k] - y[0]], [vx[k], vy[k]]));
            let middle = |a: [f64; 2], b: [f64; 2]| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            let (arm, velocity) = (middle(start.0, end.0), middle(start.1, end.1));
            momentum[0] += mass * velocity[0] + lean * (end.1[0] - start.1[0]);
            momentum[1] += mass * velocity[1] + lean * (end.1[1] - start.1[1]);
            // Simpson's rule is exact: position and velocity are linear along the segment.
            angular += mass / 6.0 * (cross(start.0, start.1) + 4.0 * cross(arm, velocity) + cross(end.0, end.1));
            angular += lean * (cross(end.0, end.1) - cross(start.0, start.1));
            let omega = 0.5 * (frame.sections[k].omega + frame.sections[k + 1].omega);
            angular += mass / 12.0 * (thickness.powi(2) + 0.25 * growth.powi(2)) * omega;
        }
        Displaced { momentum, angular, transport: cross([vx[0], vy[0]], momentum) }
    }

    /// Write the loads on the stations from the drag on the cells.
    ///
    /// `drag(cell)` is the force on the cell per metre of depth (N) and the rate at which it decreases with the
    /// velocity of the body (kg/(m s)), per axis. The impedance of a station is for motion across the beam.
    pub fn collect(&self, mut drag: impl FnMut(&Cell) -> ([f64; 2], [f64; 2]), loads: &mut Loads) {
        loads.force.iter_mut().for_each(|f| f.fill(0.0));
        loads.impedance.fill(0.0);
        let BeamPose { cells, places, frame } = &self.pose;
        for (cell, place) in cells.iter().zip(places).filter(|(_, place)| !place.is_behind_root) {
            let ([fx, fy], [along_x, along_y]) = drag(cell);
            let Place { segment: k, fraction: t, tangent, .. } = *place;
            let moment = -place.height * dot([fx, fy], tangent);
            let [nx, ny] = normal(tangent);
            let impedance = along_x * nx * nx + along_y * ny * ny;
            for (station, share) in [(k, 1.0 - t), (k + 1, t)] {
                let StationSection { ends: [from, to], across, span, .. } = frame.sections[station];
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

    /// Return the point on the upper (`side` = 1) or lower (−1) surface at station `k`, m.
    pub fn surface_point(&self, stations: &Stations, k: usize, side: f64) -> [f64; 2] {
        let last = self.mask.thickness.len() - 1;
        let [nx, ny] = normal(bisector(k, last, |k| unit(difference(&stations.position, [k, k + 1]))));
        let [thickness, growth] = self.mask.thickness[k.min(last)];
        let here = if k <= last { thickness - 0.5 * growth } else { thickness + 0.5 * growth };
        let height = side * 0.5 * here;
        [stations.position[0][k] + height * nx, stations.position[1][k] + height * ny]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::WallCorrection;
    use crate::wall::DragProfile;

    const ROOT: [f64; 2] = [0.3, 0.2];
    const DIRECTION: [f64; 2] = [0.8, 0.6];
    const OMEGA: f64 = 1.7;
    /// Thickness at the root and at the tip.
    const ENDS: [f64; 2] = [0.2, 0.04];

    /// A beam of length 1 that tapers, turns about its root and moves along with it; painted with a sharp mask.
    fn turning() -> (Beam, Stations, Grid) {
        let grid = Grid::new([[0.0, 1.5]; 2], [600; 2]);
        let thickness = |k: i32| ENDS[0] + (ENDS[1] - ENDS[0]) * f64::from(k) / 16.0;
        let parameters = parameters::Beam {
            stations: vec![ROOT; 9],
            length: 1.0,
            thickness: (0..=16).map(thickness).collect(),
            support_cylinder: None,
            surface: parameters::Surface::Mask,
        };
        let mask = Mask::Sharp { c_eta: 1.0, displacement_corrected: false };
        let mut beam = Beam::new(0, &parameters, &grid, &mask, 1e-3);
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
        let sum = |weight: &dyn Fn(&Cell) -> f64| beam.pose.cells.iter().map(weight).sum::<f64>() * grid.cell_volume();
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
        beam.mask.profiles = beam
            .mask
            .thickness
            .iter()
            .map(|h| DragProfile::of_body(h[0], true, &mask, 1e-3, grid.cell_size()))
            .collect();
        beam.place(&stations, &stations, &grid);
        let slope = 0.5 * (ENDS[1] - ENDS[0]);
        for cell in beam.pose.cells.iter() {
            let along = cell.arm[0] * DIRECTION[0] + cell.arm[1] * DIRECTION[1];
            let height = (cell.arm[1] * DIRECTION[0] - cell.arm[0] * DIRECTION[1]).abs();
            if (0.2..0.8).contains(&along) {
                let distance = (height - 0.5 * ENDS[0] - slope * along) / slope.hypot(1.0);
                let expected = beam.mask.profiles[0].rate(distance);
                assert!((cell.rate - expected).abs() < 1e-9, "at {along}, {height}: {} against {expected}", cell.rate);
            }
        }
    }

    /// A cell on the line where two surfaces are equally near draws the fluid to the same velocity on both sides of the
    /// line: at a corner of the tip, outside and inside, and in the middle of a thin beam.
    #[test]
    fn no_cell_switches_abruptly_from_one_surface_to_the_other() {
        let grid = Grid::new([[0.0, 1.0]; 2], [100; 2]);
        let parameters = parameters::Beam {
            stations: vec![[0.3, 0.5]; 7],
            length: 0.3,
            thickness: vec![0.025; 13],
            support_cylinder: None,
            surface: parameters::Surface::Mask,
        };
        let target = WallCorrection::Curvature;
        let mask = Mask::LogLinear { c_eta: 1e-5, decay_length_cells: 0.25, core_depth: None, wall_correction: target };
        let mut beam = Beam::new(0, &parameters, &grid, &mask, 1e-3);
        let flow: Vec<_> = (0..grid.len()).map(|i| grid.point(i)).map(|[x, y]| [y + x * y, x - 2.0 * y * y]).collect();
        // A cell, and its position relative to the upper corner of the tip: on the bisector outside and inside, and far
        // away.
        let [x, y] = grid.point(60 * grid.cells[1] + 50);
        for [right, up] in [[0.003, 0.003], [-0.004, -0.004], [-0.1, -0.0125]] {
            let drawn = [-1e-10, 1e-10].map(|aside| {
                let root = [x - right - 0.3, y - up - 0.0125 + aside];
                let along = |axis: usize| (0..=6).map(|k| root[axis] + [0.05, 0.0][axis] * f64::from(k)).collect();
                let stations = Stations { position: [along(0), along(1)], velocity: [vec![0.0; 7], vec![0.0; 7]] };
                beam.place(&stations, &stations, &grid);
                beam.pose.cells.sample(|point| flow[point]);
                beam.pose
                    .cells
                    .iter()
                    .find(|cell| cell.index == 60 * grid.cells[1] + 50)
                    .expect("the mask reaches it")
                    .velocity
            });
            let apart = (drawn[0][0] - drawn[1][0]).hypot(drawn[0][1] - drawn[1][1]);
            assert!(apart < 1e-6, "{right} m, {up} m: {drawn:?}");
        }
    }

    /// Root and tip, and the straight lines between their corners.
    #[test]
    fn surface_points_of_the_tapered_beam_lie_on_its_sides() {
        let (beam, stations, _) = turning();
        for k in 0..=8_u8 {
            let s = f64::from(k) / 8.0;
            let half = 0.5 * (ENDS[0] + (ENDS[1] - ENDS[0]) * s);
            for side in [1.0, -1.0] {
                let point = beam.surface_point(&stations, k.into(), side);
                for (axis, across) in [-DIRECTION[1], DIRECTION[0]].into_iter().enumerate() {
                    let expected = ROOT[axis] + DIRECTION[axis] * s + side * half * across;
                    assert!((point[axis] - expected).abs() < 1e-14, "station {k}: {point:?}, not {expected}");
                }
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
        // The root moves with 0.5 m/s along both axes.
        let expected = 0.5 * (found.momentum[1] - found.momentum[0]);
        assert!((found.transport - expected).abs() < 1e-14 && expected.abs() > 0.1, "{}", found.transport);
    }
}
