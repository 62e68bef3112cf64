//! The bodies of a scene where they are at the time, and the drag that they exert on the fluid.

mod beam;
mod cells;
mod rigid;
mod shape;
mod stations;

use scene::Scene;

use crate::field::Field;
use crate::force::{BodyForce, Exchange, Force};
use crate::grid::Grid;
use crate::wall::DragProfile;
use crate::zone::Zone;
use line_fft::Real;

use beam::Beam;
pub use cells::Cell;
use cells::{Cells, Painted};
pub use rigid::Pose;
use rigid::Rigid;
pub use stations::{Loads, Stations};

/// Walls, zones, rigid bodies and beams, as a field of drag and as cells.
pub struct Bodies {
    /// The cylinders, then the other rigid bodies.
    rigid: Vec<Rigid>,
    /// Number of cylinders.
    cylinders: usize,
    beams: Vec<Beam>,
    /// Total drag rate Σ a_b, 1/s, `[nx, ny]`; absent where there is no body at all.
    rate: Option<Field<f64>>,
    painted: Painted,
    /// Density of the fluid, kg/m³.
    density: f64,
    /// Mass of the fluid in a cell, kg per metre of depth.
    pub cell_mass: f64,
}

/// The bodies without the field of their drag.
pub struct Changing<'a> {
    rigid: &'a mut [Rigid],
    beams: &'a mut [Beam],
}

impl Changing<'_> {
    /// Put those that move where they are at a time (s), the beams at their stations; they were at `before`.
    pub fn place(&mut self, time: f64, stations: &[Stations], before: &[Stations], grid: &Grid) {
        for rigid in self.rigid.iter_mut().filter(|rigid| rigid.moves()) {
            rigid.place(time, grid);
        }
        for (beam, (stations, before)) in self.beams.iter_mut().zip(stations.iter().zip(before)) {
            beam.place(stations, before, grid);
        }
    }

    /// Let those with a wall target sample the flow; `velocity` gives it at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; 2]) {
        self.rigid.iter_mut().for_each(|rigid| rigid.cells.sample(&velocity));
        self.beams.iter_mut().for_each(|beam| beam.here.cells.sample(&velocity));
    }
}

impl Bodies {
    /// The bodies of a scene with a fluid at t = 0, the still ones painted.
    pub fn new(scene: &Scene, fluid: &scene::Fluid, zones: &[Zone], grid: &Grid) -> Self {
        let (mask, nu) = (&fluid.mask, fluid.kinematic_viscosity);
        let bodies = fluid.cylinders.iter().map(scene::Body::from).chain(fluid.bodies.iter().cloned());
        let rigid: Vec<_> = bodies.map(|body| Rigid::new(body, grid, mask, nu)).collect();
        let beams: Vec<_> = scene.beams().map(|beam| Beam::new(beam, grid, mask, nu)).collect();
        let any = !zones.is_empty() || fluid.channel.is_some() || !rigid.is_empty() || !beams.is_empty();
        let mut bodies = Self {
            rigid,
            cylinders: fluid.cylinders.len(),
            beams,
            rate: any.then(|| Field::uniform(0.0, grid.len())),
            painted: Painted::default(),
            density: fluid.density,
            cell_mass: fluid.density * grid.cell_area(),
        };
        bodies.paint_still(fluid, zones, &DragProfile::new(mask, mask.c_eta(), nu, grid.cell_size()), grid);
        bodies
    }

    /// Grid points in which the bodies are painted that change, one that two of them share twice; and the total drag rate
    /// there, 1/s.
    pub fn painted(&self) -> impl Iterator<Item = (usize, f64)> {
        let rate = self.rate.as_deref().unwrap_or_default();
        self.painted.points().map(|point| (point, rate[point]))
    }

    fn paint_still(&mut self, fluid: &scene::Fluid, zones: &[Zone], profile: &DragProfile, grid: &Grid) {
        let Some(rate) = &mut self.rate else { return };
        if let Some(channel) = &fluid.channel {
            let [low, high] = channel.y;
            for j in 0..grid.ny {
                let distance = 0.5 * (high - low) - grid.periodic_y(grid.y(j) - 0.5 * (low + high)).abs();
                let wall = profile.rate(distance);
                (0..grid.nx).for_each(|i| rate[i * grid.ny + j] += wall);
            }
        }
        for &(i, zone) in zones.iter().flat_map(|zone| &zone.columns) {
            rate[i * grid.ny..(i + 1) * grid.ny].iter_mut().for_each(|r| *r += zone);
        }
        for rigid in self.rigid.iter().filter(|rigid| !rigid.changes()) {
            rigid.cells.iter().for_each(|cell| rate[cell.index] += cell.rate);
        }
    }

    /// Number of cylinders.
    pub fn cylinders(&self) -> usize {
        self.cylinders
    }

    /// Number of rigid bodies, cylinders among them.
    pub fn rigid(&self) -> usize {
        self.rigid.len()
    }

    /// Where a rigid body is, the cylinders being the first.
    pub fn pose(&self, rigid: usize) -> Pose {
        self.rigid[rigid].pose
    }

    /// Power (W/m) of a force on a rigid body.
    pub fn power(&self, rigid: usize, force: &Force) -> f64 {
        self.rigid[rigid].power(force.force, force.moment)
    }

    /// Total drag rate Σ a_b, 1/s, `[nx, ny]`; absent where there is no body at all.
    pub fn rate(&self) -> Option<&[f64]> {
        self.rate.as_deref()
    }

    /// Put the moving bodies where they are at a time (s), the beams at their stations; they were at `before`.
    pub fn place(&mut self, time: f64, stations: &[Stations], before: &[Stations], grid: &Grid) {
        self.changing().place(time, stations, before, grid);
        self.paint();
    }

    /// Let the bodies with a wall target sample the flow; `velocity` gives it at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; 2]) {
        self.changing().sample(velocity);
        self.paint();
    }

    /// The bodies, to be placed and to sample before they are painted.
    pub fn changing(&mut self) -> Changing<'_> {
        Changing { rigid: &mut self.rigid, beams: &mut self.beams }
    }

    /// The drag rate of what does not change (1/s), and the bodies, to be placed while that is read. [`Self::paint`] paints
    /// them again.
    pub fn apart(&mut self) -> (Option<&[f64]>, Changing<'_>) {
        if let Some(rate) = &mut self.rate {
            self.painted.erase(rate);
        }
        (self.rate.as_deref(), Changing { rigid: &mut self.rigid, beams: &mut self.beams })
    }

    /// Find where the beams get to at `ahead`, to which they go on from `stations`.
    pub fn look_ahead(&mut self, ahead: &[Stations], stations: &[Stations], grid: &Grid) {
        for (beam, (ahead, stations)) in self.beams.iter_mut().zip(ahead.iter().zip(stations)) {
            beam.look_ahead(ahead, stations, grid);
        }
    }

    /// Put the beams there; [`Self::sample`] paints them.
    pub fn go_ahead(&mut self) {
        self.beams.iter_mut().for_each(Beam::go_ahead);
    }

    /// Paint the bodies whose drag changes: they move, or have a wall target.
    pub fn paint(&mut self) {
        let Some(rate) = &mut self.rate else { return };
        self.painted.erase(rate);
        let rigid = self.rigid.iter().filter(|rigid| rigid.changes()).map(|rigid| &rigid.cells);
        for cells in rigid.chain(self.beams.iter().map(|beam| &beam.here.cells)) {
            self.painted.add(cells, rate);
        }
    }

    /// Add `weight(Σ a) a_b u_b` of all bodies to `w`.
    pub fn add_velocities<R: Real>(&self, weight: impl Fn(f64) -> f64, w: &mut [Field<R>; 2]) {
        let Some(rate) = &self.rate else { return };
        let rigid = self.rigid.iter().filter(|rigid| rigid.changes()).map(|rigid| &rigid.cells);
        let beams = self.beams.iter().map(|beam| &beam.here.cells);
        for cell in rigid.chain(beams).flat_map(Cells::iter) {
            let weight = weight(rate[cell.index]) * cell.rate;
            for (w, velocity) in w.iter_mut().zip(cell.velocity) {
                w[cell.index] = R::rounded(w[cell.index].to_f64() + weight * velocity);
            }
        }
    }

    /// The displaced fluid of all bodies as they are, the rigid ones first, with no force yet.
    pub fn without_force(&self, stations: &[Stations]) -> Vec<BodyForce> {
        let rigid = self.rigid.iter().map(|rigid| rigid.displaced(self.density));
        let beams = self.beams.iter().zip(stations).map(|(beam, stations)| beam.displaced(stations, self.density));
        rigid.chain(beams).map(|displaced| BodyForce { displaced, force: Force::default() }).collect()
    }

    /// Sum up the forces of a step of size `dt` (s) from `drag`, the drag on a cell over the density, m/s².
    ///
    /// The penalization integral lacks the rate of change of the momentum that the fluid displaced by a moving body
    /// would have (thesis eq. 3.20). What acts on a beam where it goes on into its cylinder acts on that.
    pub fn sum_up_forces(
        &self,
        dt: f64,
        drag: impl Fn(&Cell) -> [f64; 2],
        stations: &[Stations],
        forces: &mut [BodyForce],
        exchange: &mut [Exchange],
    ) {
        let drag = |cell: &Cell| drag(cell).map(|drag| self.cell_mass * drag);
        let (on_rigid, on_beams) = forces.split_at_mut(self.rigid.len());
        for (known, rigid) in on_rigid.iter_mut().zip(&self.rigid) {
            let mut sum = Force::default();
            rigid.cells.iter().for_each(|cell| sum.add(drag(cell), cell.arm));
            known.update(sum, rigid.displaced(self.density), dt);
        }
        for (k, ((known, beam), stations)) in on_beams.iter_mut().zip(&self.beams).zip(stations).enumerate() {
            let (mut sum, mut power) = (Force::default(), 0.0);
            for (cell, velocity) in beam.cells_and_velocities(stations) {
                let force = drag(cell);
                if let Some([u, v]) = velocity {
                    sum.add(force, cell.arm);
                    power += force[0] * u + force[1] * v;
                } else if let Some(holder) = beam.holder() {
                    let center = self.rigid[holder].pose.position;
                    let arm = [0, 1].map(|axis| stations.position[axis][0] + cell.arm[axis] - center[axis]);
                    on_rigid[holder].force.add(force, arm);
                }
            }
            exchange[k] = Exchange { force: sum.force, power, work: exchange[k].work + power * dt };
            known.update(sum, beam.displaced(stations, self.density), dt);
        }
    }

    /// Bring the drag on each beam's cells to its stations.
    ///
    /// `drag(cell)` is the force on the cell per metre of depth (N) and the rate at which it falls with the body's
    /// velocity there (kg/(m s)), per axis.
    pub fn collect_loads(&self, drag: impl Fn(&Cell) -> ([f64; 2], [f64; 2]), loads: &mut [Loads]) {
        self.beams.iter().zip(loads).for_each(|(beam, loads)| beam.collect(&drag, loads));
    }

    /// Point on the upper (`side` = 1) or lower (−1) surface of a beam, numbered from 0, at station `k`, m.
    pub fn surface_point(&self, beam: usize, stations: &Stations, k: usize, side: f64) -> [f64; 2] {
        self.beams[beam].surface_point(stations, k, side)
    }
}
