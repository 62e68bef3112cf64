//! Walls, zones and rigid bodies in space, as a field of drag and as cells.

use line_fft::Real;
use nalgebra::Vector3;

use super::force::BodyForce;
use super::parameters::Parameters;
use super::rigid::{Cell, Rigid};
use crate::field::Field;
use crate::grid::Grid;
use crate::wall::DragProfile;
use crate::zone::DrivingZone;

/// Walls, zones and rigid bodies.
pub struct Bodies {
    /// The rigid bodies.
    pub rigid: Vec<Rigid>,
    zones: Vec<DrivingZone>,
    /// Total drag rate Σ a_b, 1/s; absent without a solid.
    rate: Option<Field<f64>>,
    /// Rates before bodies were painted, restored in reverse order, so that painting leaves no rounding behind.
    painted: Vec<(usize, f64)>,
    density: f64,
    cell_mass: f64,
}

impl Bodies {
    /// The bodies at t = 0, the still ones painted.
    pub fn new(parameters: &Parameters, grid: &Grid<3>) -> Self {
        let &Parameters { ref mask, kinematic_viscosity: nu, density, ref walls, .. } = parameters;
        let zones = DrivingZone::all([&parameters.inflow, &parameters.sponge], mask, nu, walls[1], grid);
        let rigid: Vec<_> = parameters.bodies.iter().map(|body| Rigid::new(body.clone(), grid, mask, nu)).collect();
        let has_walls = walls.iter().any(Option::is_some);
        let any = !zones.is_empty() || has_walls || rigid.iter().any(Rigid::is_solid);
        let mut rate = any.then(|| Field::uniform(0.0, grid.len()));
        if let Some(rate) = &mut rate {
            let profile = DragProfile::new(mask, mask.c_eta(), nu, grid.cell_size());
            if has_walls {
                rate.iter_mut().enumerate().for_each(|(c, rate)| *rate = profile.rate(depth(walls, grid, c)));
            }
            let [_, ny, nz] = grid.cells;
            for &(i, zone) in zones.iter().flat_map(|zone| &zone.columns) {
                rate[i * ny * nz..(i + 1) * ny * nz].iter_mut().for_each(|rate| *rate += zone);
            }
            for cell in rigid.iter().filter(|rigid| !rigid.changes()).flat_map(|rigid| &rigid.cells) {
                rate[cell.index] += cell.rate;
            }
        }
        Self { rigid, zones, rate, painted: Vec::new(), density, cell_mass: density * grid.cell_volume() }
    }

    /// Return the total drag rate Σ a_b, 1/s, `[nx, ny, nz]`; none without a body.
    pub fn rate(&self) -> Option<&[f64]> {
        self.rate.as_deref()
    }

    /// Move the bodies to their places at a time (s).
    pub fn place(&mut self, time: f64, grid: &Grid<3>) {
        self.rigid.iter_mut().filter(|rigid| rigid.moves()).for_each(|rigid| rigid.place(time, grid));
    }

    /// Let bodies with a wall target sample the flow, and paint them; `velocity` gives the flow at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; 3]) {
        let Some(rate) = &mut self.rate else { return };
        while let Some((index, before)) = self.painted.pop() {
            rate[index] = before;
        }
        for rigid in self.rigid.iter_mut().filter(|rigid| rigid.changes()) {
            rigid.sample(&velocity);
            for cell in &rigid.cells {
                self.painted.push((cell.index, rate[cell.index]));
                rate[cell.index] += cell.rate;
            }
        }
    }

    /// Add `a_b u_b/(c_0 + Σ a)` of all zones and bodies at a time (s) to `w`, with `c_0` in 1/s.
    pub fn add_velocities<R: Real>(&self, time: f64, c_0: f64, grid: &Grid<3>, w: &mut [Field<R>; 3]) {
        let Some(rate) = &self.rate else { return };
        let ny = grid.cells[1];
        let line = grid.cells[2];
        for DrivingZone { mean_velocity, columns, shape } in &self.zones {
            let mean = mean_velocity.value(time);
            for (&(i, zone), (j, shape)) in columns.iter().flat_map(|at| shape.iter().enumerate().map(move |s| (at, s)))
            {
                let points = (i * ny + j) * line..(i * ny + j + 1) * line;
                for (w, rate) in w[0][points.clone()].iter_mut().zip(&rate[points]) {
                    *w = R::rounded(w.to_f64() + zone * mean * shape / (c_0 + rate));
                }
            }
        }
        for cell in self.rigid.iter().filter(|rigid| rigid.changes()).flat_map(|rigid| &rigid.cells) {
            let weight = cell.rate / (c_0 + rate[cell.index]);
            for (w, velocity) in w.iter_mut().zip(&cell.velocity) {
                w[cell.index] = R::rounded(w[cell.index].to_f64() + weight * velocity);
            }
        }
    }

    /// Add `Σ a_b u_b` of all zones and bodies at a time (s) to `sums` at some points in ascending order.
    pub fn add_velocities_at(&self, time: f64, grid: &Grid<3>, points: &[usize], sums: &mut [[f64; 3]]) {
        if points.is_empty() {
            return;
        }
        let [_, ny, nz] = grid.cells;
        for DrivingZone { mean_velocity, columns, shape } in &self.zones {
            let mean = mean_velocity.value(time);
            for (sum, point) in sums.iter_mut().zip(points) {
                if let Ok(column) = columns.binary_search_by_key(&(point / (ny * nz)), |(i, _)| *i) {
                    sum[0] += columns[column].1 * mean * shape[point / nz % ny];
                }
            }
        }
        for cell in self.rigid.iter().filter(|rigid| rigid.changes()).flat_map(|rigid| &rigid.cells) {
            if let Ok(k) = points.binary_search(&cell.index) {
                (0..3).for_each(|axis| sums[k][axis] += cell.rate * cell.velocity[axis]);
            }
        }
    }

    /// Return the displaced fluid of the bodies without a force.
    pub fn without_force(&self) -> Vec<BodyForce> {
        let displaced = self.rigid.iter().map(|rigid| rigid.displaced(self.density));
        displaced.map(|displaced| BodyForce { displaced, ..BodyForce::default() }).collect()
    }

    /// Sum up the forces on solids of a step of size `dt` (s) from `drag`, the drag on a cell over the density, m/s².
    pub fn sum_up_forces(&self, dt: f64, drag: impl Fn(&Cell) -> Vector3<f64>, forces: &mut [BodyForce]) {
        for (known, rigid) in forces.iter_mut().zip(&self.rigid).filter(|(_, rigid)| rigid.is_solid()) {
            let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
            for cell in &rigid.cells {
                let drag = self.cell_mass * drag(cell);
                force += drag;
                moment += cell.arm.cross(&drag);
            }
            known.update([force, moment], rigid.displaced(self.density), dt);
        }
    }
}

/// Return the distance (m) of a grid point from the nearest wall, negative in it.
fn depth(walls: &[Option<[f64; 2]>; 3], grid: &Grid<3>, index: usize) -> f64 {
    let point = grid.point(index);
    let pairs = walls.iter().enumerate().filter_map(|(axis, pair)| pair.map(|[low, high]| (axis, low, high)));
    let distances =
        pairs.map(|(axis, low, high)| 0.5 * (high - low) - grid.periodic(axis, point[axis] - 0.5 * (low + high)).abs());
    distances.fold(f64::INFINITY, f64::min)
}
