//! Rigid bodies in space, still or in prescribed motion, as the cells in which they drag the fluid.
//!
//! A point at `r` from the pivot, whose velocity is v, moves with `v + omega × r`. The wall is that of two dimensions
//! (`wall/target.rs`), with the part of the flow along the surface as a vector, `u − (u·n) n`.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use super::force::Displaced;
use super::parameters::{Body, Turn};
use crate::grid::Grid;
use crate::parameters::Mask;
use crate::wall::{DragProfile, Sample};

/// A body and the cells in which it drags the fluid.
pub struct Rigid {
    body: Body,
    profile: DragProfile,
    /// Volume (m³) and moments of inertia for a density of 1 (m⁵).
    inertia: (f64, Vector3<f64>),
    /// Place and motion.
    pub pose: Pose,
    /// Turns the axes of the body to those of the domain.
    pub rotation: Matrix3<f64>,
    /// Cells at the present place.
    pub cells: Vec<Cell>,
    targeted: Vec<Targeted>,
    /// Samples of the targeted cells, in the same order.
    samples: Vec<Around>,
}

/// Place and motion of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position of the pivot, m.
    pub position: [f64; 3],
    /// Angle of the motion about its axis, rad.
    pub angle: f64,
    /// Velocity of the pivot, m/s.
    pub velocity: [f64; 3],
    /// Rate at which the body turns, rad/s.
    pub omega: [f64; 3],
}

/// One cell of a body.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Index of the grid point.
    pub index: usize,
    /// Drag rate a of this body, 1/s.
    pub rate: f64,
    /// Velocity to which the body draws the fluid, m/s.
    pub velocity: Vector3<f64>,
    /// Position from the pivot, m.
    pub arm: Vector3<f64>,
}

/// The wall target of a cell: the body draws the fluid to `u_b + (t W_t t + n W_n n)·(u(point) − u_b)`, summed over
/// points, with t along the surface and n across.
#[derive(Clone, Copy, Debug)]
struct Targeted {
    /// Number of the cell.
    cell: usize,
    /// Drag rate in still fluid, 1/s.
    rate: f64,
    /// Velocity of the body at the cell, m/s.
    body: Vector3<f64>,
    /// Velocity of the body along the surface at the points relative to that at the cell, times the weights, m/s.
    turned: Vector3<f64>,
    /// Unit normal n of the surface.
    normal: Vector3<f64>,
    /// End of the samples; they begin at the end of the previous ones.
    samples_end: usize,
}

/// A sampled point: eight grid points with their weights in an interpolation, and the weights of a [`Sample`].
type Around = ([(usize, f64); 8], [f64; 3]);

impl Turn {
    fn rotation(&self, angle: f64) -> Matrix3<f64> {
        Rotation3::from_axis_angle(&Unit::new_normalize(self.axis.into()), self.angle + angle).into_inner()
    }
}

impl Rigid {
    /// A body at t = 0.
    pub fn new(body: Body, grid: &Grid<3>, mask: &Mask, nu: f64) -> Self {
        let profile = DragProfile::of_body(body.shape.thickness(), body.motion.is_some(), mask, nu, grid.cell_size());
        let mut rigid = Self {
            inertia: body.shape.inertia(grid.size),
            body,
            profile,
            pose: Pose::default(),
            rotation: Matrix3::identity(),
            cells: Vec::new(),
            targeted: Vec::new(),
            samples: Vec::new(),
        };
        rigid.place(0.0, grid);
        rigid
    }

    /// Return whether it moves.
    pub fn moves(&self) -> bool {
        self.body.motion.is_some()
    }

    /// Return whether it drags the fluid in cells; a surface does by markers.
    pub fn is_solid(&self) -> bool {
        self.body.shape.is_solid()
    }

    /// Return whether its drag on the fluid changes: it moves, or has a wall target.
    pub fn changes(&self) -> bool {
        self.moves() || !self.targeted.is_empty()
    }

    /// Return the displaced fluid of a density (kg/m³).
    pub fn displaced(&self, density: f64) -> Displaced {
        let [velocity, omega] = [self.pose.velocity, self.pose.omega].map(Vector3::from);
        let (mass, arm) = (density * self.inertia.0, -(self.rotation * Vector3::from(self.body.pivot)));
        let momentum = mass * (velocity + omega.cross(&arm));
        let own = self.rotation * self.inertia.1.component_mul(&(self.rotation.transpose() * omega));
        Displaced { momentum, angular: arm.cross(&momentum) + density * own, transport: velocity.cross(&momentum) }
    }

    /// Move to the place at time `t` (s), and list the cells.
    pub fn place(&mut self, t: f64, grid: &Grid<3>) {
        let Self { body, profile, cells, targeted, samples, .. } = self;
        let mut pose = Pose { position: body.position, ..Pose::default() };
        let mut rotation = body.turn.rotation(0.0);
        if let Some(motion) = &body.motion {
            for (axis, law) in motion.displacement.iter().enumerate() {
                let (displacement, rate) = law.value_and_rate(t);
                pose.position[axis] += displacement;
                pose.velocity[axis] = rate;
            }
            let (angle, rate) = motion.angle.value_and_rate(t);
            let turn = Turn { axis: motion.axis, angle };
            rotation = turn.rotation(0.0) * rotation;
            (pose.angle, pose.omega) = (angle, (rate * Vector3::from(motion.axis).normalize()).into());
        }
        (self.pose, self.rotation) = (pose, rotation);
        if !body.shape.is_solid() {
            return;
        }
        let [position, velocity, omega, pivot] =
            [pose.position, pose.velocity, pose.omega, body.pivot].map(Vector3::from);
        let (to_body, reach) = (rotation.transpose(), profile.reach());
        let around = [0, 1, 2].map(|axis| {
            // The axis of the domain in the axes of the body; a body without ends fills a period.
            let direction = to_body.column(axis).into_owned();
            let from_pivot = direction.dot(&pivot);
            let extent = |direction| (body.shape.extent(direction) + reach).min(0.5 * grid.size[axis]);
            let (ahead, behind) = (extent(direction) - from_pivot, extent(-direction) + from_pivot);
            [position[axis] - behind, position[axis] + ahead]
        });
        cells.clear();
        targeted.clear();
        samples.clear();
        grid.for_each_in(around, |index, point| {
            let point = Vector3::from(point);
            let arm = point - position;
            let (distance, normal) = body.shape.nearest(to_body * arm + pivot);
            let rate = if distance <= reach { profile.rate(distance) } else { 0.0 };
            if rate <= 0.0 {
                return;
            }
            let velocity = velocity + omega.cross(&arm);
            if let Some(target) = profile.target(distance) {
                let normal = rotation * normal;
                let foot = point - distance * normal;
                let all = target.samples(distance);
                for sample in all.iter().filter(|sample| sample.weight != [0.0; 3]) {
                    let place = foot + sample.off * normal;
                    samples.push((grid.interpolation(place.into()), sample.weight));
                }
                let farther = |sample: &Sample| sample.weight[0] * (sample.off - distance);
                let turned = all.iter().map(farther).sum::<f64>() * omega.cross(&normal);
                let cell = cells.len();
                targeted.push(Targeted { cell, rate, body: velocity, turned, normal, samples_end: samples.len() });
            }
            cells.push(Cell { index, rate, velocity, arm });
        });
    }

    /// Sample the flow around the cells with a wall target; `velocity` gives it at a grid point, m/s.
    pub fn sample(&mut self, velocity: impl Fn(usize) -> [f64; 3]) {
        let DragProfile::LogLinear { target: Some(target), .. } = self.profile else { return };
        let mut begin = 0;
        for &Targeted { cell, rate, body, turned, normal, samples_end } in &self.targeted {
            let (mut along, mut across, mut through) = (-turned, 0.0, 0.0);
            for (around, weight) in &self.samples[begin..samples_end] {
                let mut relative = -body;
                for &(point, share) in around {
                    relative += share * Vector3::from(velocity(point));
                }
                let outward = relative.dot(&normal);
                along += weight[0] * (relative - outward * normal);
                across += weight[1] * outward;
                through += weight[2] * outward;
            }
            let cell = &mut self.cells[cell];
            cell.velocity = body + along + across * normal;
            cell.rate = (rate * (1.0 + target.inertia * through.abs())).min(target.largest);
            begin = samples_end;
        }
    }
}
