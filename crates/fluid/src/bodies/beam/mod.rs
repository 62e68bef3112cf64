//! Beams in the plane: their masks, their present poses, and their loads.
//!
//! Loads go back to the stations through the transpose of the map from stations to cells ([`pose`]), so that the power
//! of the loads is the power of the drag on the sections. The types have any number of dimensions, but only parameters
//! in the plane have such beams.

mod frame;
mod mask;
mod pose;
mod search;
pub mod vector;

use std::mem::swap;

use method::Mask;

use super::cells::{Cell, Cells};
use crate::force::{Displaced, Force};
use crate::grid::Grid;
use crate::parameters::{Extent, Parameters};
use crate::space::{Kinematics, Space, Vector};
use contact::{Loads, Stations};
use frame::StationSection;
use mask::BeamMask;
use pose::{BeamPose, Place};
use search::Search;
use vector::{bisector, cross, difference, dot, in_plane, lifted, normal, unit};

/// A beam with a mask.
pub struct Beam<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// Its number among all flexible bodies, from 0.
    pub number: usize,
    mask: BeamMask,
    /// The present pose.
    pose: BeamPose<D>,
    /// The pose after the coming step, and whether it has been found.
    ahead: BeamPose<D>,
    is_ahead_found: bool,
    search: Search,
}

impl<const D: usize> Beam<D>
where
    [f64; D]: Space<D>,
{
    /// Return the flexible bodies that have a mask, without a place yet.
    pub fn all(parameters: &Parameters<D>, grid: &Grid<D>) -> Vec<Self> {
        let &Parameters { ref mask, kinematic_viscosity: nu, .. } = parameters;
        let beam = |(number, extent): (usize, &Extent)| {
            let Extent::Band { length, thickness, support } = extent else { return None };
            Some(Self::new(number, *length, thickness, *support, grid, mask, nu))
        };
        parameters.flexible.iter().map(|body| &body.extent).enumerate().filter_map(beam).collect()
    }

    /// The beam with a number, a length and thicknesses (m), without a place yet.
    fn new(
        number: usize,
        length: f64,
        thickness: &[f64],
        support: Option<usize>,
        grid: &Grid<D>,
        mask: &Mask,
        nu: f64,
    ) -> Self {
        let pose = BeamPose::new(length, thickness);
        let (mask, search) = (BeamMask::new(thickness, support, grid.cell_size(), mask, nu), Search::new(grid));
        Self { number, mask, ahead: pose.clone(), is_ahead_found: false, pose, search }
    }

    /// Move from the stations `before` to `stations`, of which there is a list for each flexible body.
    pub fn place(&mut self, stations: &[Stations<D>], before: &[Stations<D>], grid: &Grid<D>) {
        let Self { number, mask, pose, is_ahead_found, search, .. } = self;
        *is_ahead_found = false;
        pose.find_cells(mask, search, &stations[*number], &before[*number], grid);
    }

    /// Find the cells at the stations `ahead`, to which the beam moves from `stations`, for [`Self::move_ahead`].
    pub fn find_cells_ahead(&mut self, ahead: &[Stations<D>], stations: &[Stations<D>], grid: &Grid<D>) {
        let Self { number, mask, ahead: pose, is_ahead_found, search, .. } = self;
        pose.find_cells(mask, search, &ahead[*number], &stations[*number], grid);
        *is_ahead_found = true;
    }

    /// Find the cells ahead once more, if they were found, after a step that leads elsewhere.
    pub fn find_cells_ahead_again(&mut self, ahead: &[Stations<D>], stations: &[Stations<D>], grid: &Grid<D>) {
        if self.is_ahead_found {
            self.find_cells_ahead(ahead, stations, grid);
        }
    }

    /// Move to the stations of [`Self::find_cells_ahead`]; the cells then sample and are painted.
    pub fn move_ahead(&mut self) {
        if self.is_ahead_found {
            swap(&mut self.pose, &mut self.ahead);
            self.is_ahead_found = false;
        }
    }

    /// Return the cells.
    pub fn cells(&self) -> &Cells<D> {
        &self.pose.cells
    }

    /// Return the cells, to sample the flow.
    pub fn cells_mut(&mut self) -> &mut Cells<D> {
        &mut self.pose.cells
    }

    /// Return force and power of the beam at its present stations, from the drag on its cells (N), and call `on_support`
    /// with the number of the rigid body that bears the drag on a cell, the drag, and the position of the cell (m).
    pub fn force(
        &self,
        drag: impl Fn(&Cell<D>) -> Vector<D>,
        stations: &Stations<D>,
        mut on_support: impl FnMut(usize, Vector<D>, Vector<D>),
    ) -> (Force<D>, f64) {
        let (mut sum, mut power) = (Force::default(), 0.0);
        let root = Vector::from(stations.position.each_ref().map(|position| position[0]));
        for (cell, velocity) in self.pose.cells_and_velocities(stations) {
            let force = drag(cell);
            if let Some([u, v]) = velocity {
                sum.add(&force, &cell.arm);
                power += force[0] * u + force[1] * v;
            } else if let Some(support) = self.mask.support {
                on_support(support, force, root + cell.arm);
            }
        }
        (sum, power)
    }

    /// Return the displaced fluid of a density (kg/m³) at the present `stations`; moments are about the root.
    pub fn displaced(&self, stations: &Stations<D>, density: f64) -> Displaced<D> {
        let ([x, y], [vx, vy]) = (in_plane(&stations.position), in_plane(&stations.velocity));
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
        let about_z = |spin: f64| <[f64; D]>::spin([spin, 0.0, 0.0]);
        let transport = about_z(cross([vx[0], vy[0]], momentum));
        Displaced { momentum: lifted(momentum), angular: about_z(angular), transport }
    }

    /// Write the loads on the stations from the drag on the cells.
    ///
    /// The impedance of a station is for motion across the beam.
    ///
    /// `drag(cell)` is the force on the cell (N) and the rate at which it decreases with the velocity of the body (kg/s),
    /// per axis.
    pub fn collect(&self, drag: impl Fn(&Cell<D>) -> (Vector<D>, Vector<D>), loads: &mut Loads<D>) {
        loads.force.iter_mut().for_each(|f| f.fill(0.0));
        loads.impedance.fill(0.0);
        let BeamPose { cells, places, frame } = &self.pose;
        for (cell, place) in cells.iter().zip(places).filter(|(_, place)| !place.is_behind_root) {
            let (force, along) = drag(cell);
            let ([fx, fy], [along_x, along_y]) = ([force[0], force[1]], [along[0], along[1]]);
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
    fn surface_point(&self, stations: &Stations<D>, k: usize, side: f64) -> [f64; 2] {
        let last = self.mask.thickness.len() - 1;
        let [nx, ny] = normal(bisector(k, last, |k| unit(difference(&stations.position, [k, k + 1]))));
        let [thickness, growth] = self.mask.thickness[k.min(last)];
        let here = if k <= last { thickness - 0.5 * growth } else { thickness + 0.5 * growth };
        let height = side * 0.5 * here;
        [stations.position[0][k] + height * nx, stations.position[1][k] + height * ny]
    }

    /// Return the points on the upper and the lower surface at a station, m.
    pub fn faces(&self, stations: &Stations<D>, station: usize) -> [Vector<D>; 2] {
        [1.0, -1.0].map(|side| lifted(self.surface_point(stations, station, side)))
    }
}

#[cfg(test)]
mod tests {
    use std::slice::from_ref;

    use super::*;
    use crate::wall::DragProfile;
    use method::WallCorrection;

    const ROOT: [f64; 2] = [0.3, 0.2];
    const DIRECTION: [f64; 2] = [0.8, 0.6];
    const OMEGA: f64 = 1.7;
    /// Thickness at the root and at the tip.
    const ENDS: [f64; 2] = [0.2, 0.04];

    /// A beam of length 1 that tapers, turns about its root and moves along with it; painted with a sharp mask.
    fn turning() -> (Beam<2>, Stations<2>, Grid<2>) {
        let grid = Grid::new([[0.0, 1.5]; 2], [600; 2]);
        let thickness = |k: i32| ENDS[0] + (ENDS[1] - ENDS[0]) * f64::from(k) / 16.0;
        let thickness: Vec<_> = (0..=16).map(thickness).collect();
        let mask = Mask::Sharp { c_eta: 1.0, displacement_corrected: false };
        let mut beam = Beam::new(0, 1.0, &thickness, None, &grid, &mask, 1e-3);
        let along = |axis: usize| (0..=8).map(move |k| ROOT[axis] + DIRECTION[axis] * f64::from(k) / 8.0).collect();
        let speed = |axis: usize| {
            let across = [-DIRECTION[1], DIRECTION[0]];
            (0..=8).map(move |k| 0.5 + OMEGA * across[axis] * f64::from(k) / 8.0).collect()
        };
        let stations = Stations { position: [along(0), along(1)], velocity: [speed(0), speed(1)] };
        beam.place(from_ref(&stations), from_ref(&stations), &grid);
        (beam, stations, grid)
    }

    #[test]
    fn mask_has_the_area_of_the_tapered_beam() {
        let (beam, _, grid) = turning();
        let sum =
            |weight: &dyn Fn(&Cell<2>) -> f64| beam.pose.cells.iter().map(weight).sum::<f64>() * grid.cell_volume();
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
        beam.place(from_ref(&stations), from_ref(&stations), &grid);
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
        let target = WallCorrection::Curvature;
        let mask = Mask::LogLinear { c_eta: 1e-5, decay_length_cells: 0.25, core_depth: None, wall_correction: target };
        let mut beam = Beam::new(0, 0.3, &[0.025; 13], None, &grid, &mask, 1e-3);
        let flow: Vec<_> = (0..grid.len()).map(|i| grid.point(i)).map(|[x, y]| [y + x * y, x - 2.0 * y * y]).collect();
        // A cell, and its position relative to the upper corner of the tip: on the bisector outside and inside, and far
        // away.
        let [x, y] = grid.point(60 * grid.cells[1] + 50);
        for [right, up] in [[0.003, 0.003], [-0.004, -0.004], [-0.1, -0.0125]] {
            let drawn = [-1e-10, 1e-10].map(|aside| {
                let root = [x - right - 0.3, y - up - 0.0125 + aside];
                let along = |axis: usize| (0..=6).map(|k| root[axis] + [0.05, 0.0][axis] * f64::from(k)).collect();
                let stations = Stations { position: [along(0), along(1)], velocity: [vec![0.0; 7], vec![0.0; 7]] };
                beam.place(from_ref(&stations), from_ref(&stations), &grid);
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
        for (across, found) in across.iter().zip(&found.momentum) {
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
