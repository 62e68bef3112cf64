//! The bodies at their present places, and the drag that they exert on the fluid.

mod beam;
mod body_pose;
mod cells;
mod frame;
mod mask;
mod measure;
mod mount;
mod polygon;
mod pose;
mod rigid;
mod search;
mod section;
mod shape;
mod stations;
mod vector;

use std::mem::swap;

use line_fft::Real;

use crate::field::Field;
use crate::force::{BodyForce, Exchange, Force};
use crate::grid::Grid;
use crate::parameters::{Body, Parameters, Surface};
use crate::wall::DragProfile;
use crate::zone::DrivingZone;

pub use beam::Beam;
pub use body_pose::Pose;
pub use cells::Cell;
use cells::{Cells, Painted};
use measure::{Measured, Walls};
pub use mount::Carried;
pub use mount::Drag;
use mount::Release;
use pose::BeamPose;
use rigid::Rigid;
pub use stations::{Loads, Stations};
pub use vector::{difference, unit};

/// Walls, zones, rigid bodies and beams with a mask, as a field of drag and as cells.
pub struct Bodies {
    /// The cylinders, then the other rigid bodies.
    rigid: Vec<Rigid>,
    /// Number of cylinders.
    cylinders: usize,
    /// The beams with a mask.
    beams: Vec<Beam>,
    /// Total drag rate Σ a_b, 1/s, `[nx, ny]`; absent without a body.
    rate: Option<Field<f64>>,
    painted: Painted,
    /// Density of the fluid, kg/m³.
    density: f64,
    /// Mass of the fluid in a cell, kg per metre of depth.
    pub cell_mass: f64,
    /// Room for predicted poses, while none are in use.
    spare: Option<Vec<BeamPose>>,
}

/// The beams at their predicted stations; made by [`Bodies::predict`] for [`Bodies::move_to_predicted`].
pub struct PredictedBeams(Vec<BeamPose>);

/// The bodies without the field of their drag.
pub struct MovingBodies<'a> {
    rigid: &'a mut [Rigid],
    beams: &'a mut [Beam],
}

impl MovingBodies<'_> {
    /// Move the bodies to their places at a time (s), those without a law by `displacements` from rest, and the beams
    /// from the stations `before` to `stations`.
    pub fn place(
        &mut self,
        time: f64,
        displacements: &[Pose],
        stations: &[Stations],
        before: &[Stations],
        grid: &Grid,
    ) {
        let mut displacements = displacements.iter().peekable();
        for rigid in self.rigid.iter_mut().filter(|rigid| rigid.moves()) {
            match displacements.next_if(|_| rigid.is_carried()) {
                Some(displacement) => rigid.place(rigid.pose_of(displacement), grid),
                None => rigid.follow(time, grid),
            }
        }
        for beam in &mut *self.beams {
            beam.place(&stations[beam.number], &before[beam.number], grid);
        }
    }

    /// Let bodies with a wall target sample the flow; `velocity` gives it at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; 2]) {
        self.rigid.iter_mut().for_each(|rigid| rigid.cells.sample(&velocity));
        self.beams.iter_mut().for_each(|beam| beam.pose.cells.sample(&velocity));
    }
}

impl Bodies {
    /// The bodies at t = 0, the still ones painted.
    pub fn new(parameters: &Parameters, zones: &[DrivingZone], grid: &Grid) -> Self {
        let &Parameters { ref mask, kinematic_viscosity: nu, density, channel, .. } = parameters;
        let bodies = parameters.cylinders.iter().map(Body::from).chain(parameters.bodies.iter().cloned());
        let rigid: Vec<_> = bodies.map(|body| Rigid::new(body, grid, mask, nu, density)).collect();
        let masked = parameters.beams.iter().enumerate().filter(|(_, beam)| beam.surface == Surface::Mask);
        let beams: Vec<_> = masked.map(|(number, beam)| Beam::new(number, beam, grid, mask, nu)).collect();
        let thick = !beams.is_empty() || rigid.iter().any(|rigid| !rigid.is_line());
        let any = !zones.is_empty() || channel.is_some() || thick;
        let mut bodies = Self {
            rigid,
            cylinders: parameters.cylinders.len(),
            beams,
            rate: any.then(|| Field::uniform(0.0, grid.len())),
            painted: Painted::default(),
            density,
            cell_mass: density * grid.cell_volume(),
            spare: None,
        };
        let walls = channel.map(|y| Walls { y, period: grid.size[1] });
        bodies.paint_still(walls, zones, &DragProfile::new(mask, mask.c_eta(), nu, grid.cell_size()), grid);
        bodies
    }

    /// Return the grid points in which changing bodies are painted, with the total drag rate, 1/s. A point that two
    /// bodies share is there twice.
    pub fn painted(&self) -> impl Iterator<Item = (usize, f64)> {
        let rate = self.rate.as_deref().unwrap_or_default();
        self.painted.points().map(|point| (point, rate[point]))
    }

    fn paint_still(&mut self, walls: Option<Walls>, zones: &[DrivingZone], profile: &DragProfile, grid: &Grid) {
        let Some(rate) = &mut self.rate else { return };
        let [nx, ny] = grid.cells;
        if let Some(walls) = walls {
            for j in 0..ny {
                let wall = profile.rate(walls.measure(&grid.point(j)).distance());
                (0..nx).for_each(|i| rate[i * ny + j] += wall);
            }
        }
        for &(i, zone) in zones.iter().flat_map(|zone| &zone.columns) {
            rate[i * ny..(i + 1) * ny].iter_mut().for_each(|r| *r += zone);
        }
        for rigid in self.rigid.iter().filter(|rigid| !rigid.changes()) {
            rigid.cells.iter().for_each(|cell| rate[cell.index] += cell.rate);
        }
    }

    /// Return the number of cylinders.
    pub fn cylinders(&self) -> usize {
        self.cylinders
    }

    /// Return the number of rigid bodies, with the cylinders.
    pub fn rigid(&self) -> usize {
        self.rigid.len()
    }

    /// Return place and motion of a rigid body; the cylinders are the first.
    pub fn pose(&self, rigid: usize) -> Pose {
        self.rigid[rigid].pose
    }

    /// Return place and motion of a rigid body at a displacement from rest.
    pub fn displaced_pose(&self, rigid: usize, displacement: &Pose) -> Pose {
        self.rigid[rigid].pose_of(displacement)
    }

    /// Return the power (W/m) of a force on a rigid body.
    pub fn power(&self, rigid: usize, force: &Force) -> f64 {
        self.rigid[rigid].power(force.force, force.moment)
    }

    /// Return the total drag rate Σ a_b, 1/s, `[nx, ny]`; none without a body.
    pub fn rate(&self) -> Option<&[f64]> {
        self.rate.as_deref()
    }

    /// Move the bodies as [`MovingBodies::place`] does, and paint them.
    pub fn place(
        &mut self,
        time: f64,
        displacements: &[Pose],
        stations: &[Stations],
        before: &[Stations],
        grid: &Grid,
    ) {
        self.moving().place(time, displacements, stations, before, grid);
        self.paint();
    }

    /// Return the numbers of the rigid bodies that the master or the fluid moves, and whether each is on springs.
    pub fn carried(&self) -> impl Iterator<Item = (usize, bool)> {
        let numbered = self.rigid.iter().enumerate().filter(|(_, rigid)| rigid.is_carried());
        numbered.map(|(k, rigid)| (k, rigid.mount().is_some()))
    }

    /// Let the bodies on springs move: find their velocities together with the drag of the fluid, and add what the
    /// change does to `u*` to `w`.
    ///
    /// `c` are the coefficients of the backward differences; `u_star(axis, index, w)` is `u*` at a grid point.
    pub fn release<R: Real>(
        &mut self,
        c: [f64; 3],
        carried: &[Carried],
        u_star: impl Fn(usize, usize, f64) -> f64,
        w: &mut [Field<R>; 2],
    ) {
        let Some(rate) = &self.rate else { return };
        for (rigid, carried) in self.rigid.iter_mut().filter(|rigid| rigid.is_carried()).zip(carried) {
            let Some(&mount) = rigid.mount().filter(|_| !rigid.is_line()) else { continue };
            let mut drag = Drag::default();
            for cell in rigid.cells.iter() {
                let share = cell.rate / (c[0] + rate[cell.index]);
                let slip =
                    [0, 1].map(|axis| u_star(axis, cell.index, w[axis][cell.index].to_f64()) - cell.velocity[axis]);
                let weight = self.cell_mass * cell.rate;
                drag.add(slip.map(|slip| weight * slip), cell.gain.map(|gain| weight * gain * (1.0 - share)), cell.arm);
            }
            let fluid = rigid.displaced_inertia(self.density);
            let release = Release { mount, carried, c, fluid, predicted: rigid.pose.rates() };
            let released = release.solve(&drag);
            let [u, v, omega] = released.change;
            for cell in rigid.cells.iter_mut() {
                let share = cell.rate / (c[0] + rate[cell.index]);
                let change = [u - omega * cell.arm[1], v + omega * cell.arm[0]];
                for (axis, w) in w.iter_mut().enumerate() {
                    let change = cell.gain[axis] * change[axis];
                    cell.velocity[axis] += change;
                    w[cell.index] = R::rounded(w[cell.index].to_f64() + share * change);
                }
            }
            rigid.released = Some(released);
        }
    }

    /// Return whether a rigid body is on springs.
    pub fn is_on_springs(&self, rigid: usize) -> bool {
        self.rigid[rigid].mount().is_some()
    }

    /// Let a line on springs move under a drag, as [`Self::release`] does; return the change of the velocities of its
    /// pivot and its angle, none if the line is not on springs.
    pub fn release_line(&mut self, rigid: usize, c: [f64; 3], carried: &[Carried], drag: &Drag) -> Option<[f64; 3]> {
        let place = self.carried().position(|(own, on_springs)| own == rigid && on_springs)?;
        let rigid = &mut self.rigid[rigid];
        let (fluid, predicted) = (rigid.displaced_inertia(self.density), rigid.pose.rates());
        let release = Release { mount: *rigid.mount()?, carried: &carried[place], c, fluid, predicted };
        let released = release.solve(drag);
        rigid.released = Some(released);
        Some(released.change)
    }

    /// Put the bodies that laws do not move to where they are after a step in which they were placed by
    /// `displacements`, and write that.
    pub fn settle(&mut self, displacements: &[Pose], carried: &mut [Carried]) {
        let bodies = self.rigid.iter_mut().filter(|rigid| rigid.is_carried());
        for ((rigid, carried), placed) in bodies.zip(carried).zip(displacements) {
            let (now, acceleration) = match &rigid.released {
                Some(released) => (released.displacement, released.acceleration),
                None => (*placed, [0.0; 3]),
            };
            *carried = Carried { now, before: carried.now, acceleration };
            rigid.pose = rigid.pose_of(&now);
        }
    }

    /// Let bodies with a wall target sample the flow, and paint them; `velocity` gives the flow at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; 2]) {
        self.moving().sample(velocity);
        self.paint();
    }

    /// Return the bodies, to be moved and to sample before they are painted.
    pub fn moving(&mut self) -> MovingBodies<'_> {
        MovingBodies { rigid: &mut self.rigid, beams: &mut self.beams }
    }

    /// Return the drag rate of still bodies (1/s), and the bodies, to be moved while the rate is read and then to be
    /// painted with [`Self::paint`].
    pub fn split_static(&mut self) -> (Option<&[f64]>, MovingBodies<'_>) {
        if let Some(rate) = &mut self.rate {
            self.painted.erase(rate);
        }
        (self.rate.as_deref(), MovingBodies { rigid: &mut self.rigid, beams: &mut self.beams })
    }

    /// Return the beams at the stations `ahead`, to which they move from `stations`.
    pub fn predict(&mut self, ahead: &[Stations], stations: &[Stations], grid: &Grid) -> PredictedBeams {
        let room = || self.beams.iter().map(|beam| beam.pose.clone()).collect();
        let mut poses: Vec<BeamPose> = self.spare.take().unwrap_or_else(room);
        for (beam, pose) in self.beams.iter_mut().zip(&mut poses) {
            beam.find_cells(pose, &ahead[beam.number], &stations[beam.number], grid);
        }
        PredictedBeams(poses)
    }

    /// Move the beams to predicted stations; [`Self::sample`] paints them.
    pub fn move_to_predicted(&mut self, PredictedBeams(mut poses): PredictedBeams) {
        self.beams.iter_mut().zip(&mut poses).for_each(|(beam, pose)| swap(&mut beam.pose, pose));
        self.spare = Some(poses);
    }

    /// Paint the bodies whose drag changes: those that move or have a wall target.
    pub fn paint(&mut self) {
        let Some(rate) = &mut self.rate else { return };
        self.painted.erase(rate);
        let rigid = self.rigid.iter().filter(|rigid| rigid.changes()).map(|rigid| &rigid.cells);
        for cells in rigid.chain(self.beams.iter().map(|beam| &beam.pose.cells)) {
            self.painted.add(cells, rate);
        }
    }

    /// Add `weight(Σ a) a_b u_b` of all bodies to `w`.
    pub fn add_velocities<R: Real>(&self, weight: impl Fn(f64) -> f64, w: &mut [Field<R>; 2]) {
        let Some(rate) = &self.rate else { return };
        let rigid = self.rigid.iter().filter(|rigid| rigid.changes()).map(|rigid| &rigid.cells);
        let beams = self.beams.iter().map(|beam| &beam.pose.cells);
        for cell in rigid.chain(beams).flat_map(Cells::iter) {
            let weight = weight(rate[cell.index]) * cell.rate;
            for (w, velocity) in w.iter_mut().zip(cell.velocity) {
                w[cell.index] = R::rounded(w[cell.index].to_f64() + weight * velocity);
            }
        }
    }

    /// Add `Σ a_b u_b` of all bodies to `sums` at some points in ascending order.
    pub fn add_velocities_at(&self, points: &[usize], sums: &mut [[f64; 2]]) {
        let rigid = self.rigid.iter().filter(|rigid| rigid.changes()).map(|rigid| &rigid.cells);
        let beams = self.beams.iter().map(|beam| &beam.pose.cells);
        for cell in rigid.chain(beams).flat_map(Cells::iter) {
            if let Ok(k) = points.binary_search(&cell.index) {
                (0..2).for_each(|axis| sums[k][axis] += cell.rate * cell.velocity[axis]);
            }
        }
    }

    /// Return the displaced fluid of all bodies with a mask, the rigid ones first, without a force.
    pub fn without_force(&self, stations: &[Stations]) -> Vec<BodyForce> {
        let mut forces = vec![BodyForce::default(); self.rigid.len() + stations.len()];
        let (on_rigid, on_beams) = forces.split_at_mut(self.rigid.len());
        on_rigid.iter_mut().zip(&self.rigid).for_each(|(own, rigid)| own.displaced = rigid.displaced(self.density));
        for beam in &self.beams {
            on_beams[beam.number].displaced = beam.displaced(&stations[beam.number], self.density);
        }
        forces
    }

    /// Sum up the forces of a step of size `dt` (s) from `drag`, the drag on a cell over the density, m/s².
    ///
    /// The penalization integral lacks the rate of change of the momentum that the fluid displaced by a moving body
    /// would have (thesis eq. 3.20). The drag on the part of a beam inside its cylinder acts on the cylinder.
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
            let displaced = rigid.displaced(self.density);
            match &rigid.released {
                Some(released) => known.update_with(sum, released.unsteady, displaced),
                None => known.update(sum, displaced, dt),
            }
        }
        for beam in &self.beams {
            let (k, stations) = (beam.number, &stations[beam.number]);
            let (mut sum, mut power) = (Force::default(), 0.0);
            for (cell, velocity) in beam.cells_and_velocities(stations) {
                let force = drag(cell);
                if let Some([u, v]) = velocity {
                    sum.add(force, cell.arm);
                    power += force[0] * u + force[1] * v;
                } else if let Some(support) = beam.support_cylinder() {
                    let center = self.rigid[support].pose.position;
                    let arm = [0, 1].map(|axis| stations.position[axis][0] + cell.arm[axis] - center[axis]);
                    on_rigid[support].force.add(force, arm);
                }
            }
            exchange[k] = Exchange { force: sum.force, power, work: exchange[k].work + power * dt };
            on_beams[k].update(sum, beam.displaced(stations, self.density), dt);
        }
    }

    /// Write the loads on the stations of each beam with a mask from the drag on its cells.
    ///
    /// `drag(cell)` is the force on the cell per metre of depth (N) and the rate at which it decreases with the
    /// velocity of the body (kg/(m s)), per axis.
    pub fn collect_loads(&self, drag: impl Fn(&Cell) -> ([f64; 2], [f64; 2]), loads: &mut [Loads]) {
        self.beams.iter().for_each(|beam| beam.collect(&drag, &mut loads[beam.number]));
    }

    /// Return a beam, counted among all from 0, if it has a mask.
    pub fn masked_beam(&self, beam: usize) -> Option<&Beam> {
        self.beams.iter().find(|own| own.number == beam)
    }
}
