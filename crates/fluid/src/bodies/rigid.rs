//! Rigid bodies, still or in prescribed motion. A cylinder is a circle that does not turn.
//!
//! A point at `r` from the pivot, whose velocity is v, moves with `v + omega × r`.

use super::cells::Cells;
use super::measure::{Measure, Measured, Surface};
use super::section::{Nearest, Section};
use crate::force::Displaced;
use crate::grid::Grid;
use crate::parameters::{Body, Mask, Shape};
use crate::wall::DragProfile;

/// A body and the cells in which it drags the fluid.
pub struct Rigid {
    body: Body,
    section: Section,
    profile: DragProfile,
    /// Present place and motion.
    pub pose: Pose,
    /// Sine and cosine of the angle.
    direction: (f64, f64),
    /// Cells at the present place.
    pub cells: Cells,
}

/// Place and motion of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position of the pivot, m.
    pub position: [f64; 2],
    /// Angle from the x axis of the domain to that of the body, rad.
    pub angle: f64,
    /// Velocity of the pivot, m/s.
    pub velocity: [f64; 2],
    /// Rate at which it turns, rad/s.
    pub omega: f64,
}

impl Pose {
    /// Return place and motion of a body at a time (s).
    fn of(body: &Body, t: f64) -> Self {
        let mut pose = Self { position: body.position, angle: body.angle, ..Self::default() };
        if let Some(motion) = &body.motion {
            for (axis, law) in motion.displacement.iter().enumerate() {
                let (displacement, rate) = law.value_and_rate(t);
                pose.position[axis] += displacement;
                pose.velocity[axis] = rate;
            }
            let (angle, rate) = motion.angle.value_and_rate(t);
            pose.angle += angle;
            pose.omega = rate;
        }
        pose
    }
}

impl Rigid {
    /// A body at t = 0.
    pub fn new(body: Body, grid: &Grid, mask: &Mask, nu: f64) -> Self {
        let body = Body { shape: body.shape.oriented(), ..body };
        let profile = DragProfile::of_body(body.shape.thickness(), body.motion.is_some(), mask, nu, grid.cell_size());
        let (section, pose, cells) = (body.shape.section(), Pose::default(), Cells::default());
        let mut rigid = Self { body, section, profile, pose, direction: (0.0, 1.0), cells };
        rigid.place(0.0, grid);
        rigid
    }

    /// Return whether it moves.
    pub fn moves(&self) -> bool {
        self.body.motion.is_some()
    }

    /// Return whether its drag on the fluid changes: it moves, or has a wall target.
    pub fn changes(&self) -> bool {
        self.moves() || self.cells.have_targets()
    }

    /// Return the displaced fluid of a density (kg/m³); moments are about the pivot.
    pub fn displaced(&self, density: f64) -> Displaced {
        let Section { area, centroid, polar } = self.section;
        let Pose { angle, velocity, omega, .. } = self.pose;
        let mass = density * area;
        let arm = turned([centroid[0] - self.body.pivot[0], centroid[1] - self.body.pivot[1]], angle.sin_cos());
        // Velocity of the centroid relative to the pivot.
        let swing = [-omega * arm[1], omega * arm[0]];
        let momentum = [0, 1].map(|axis| mass * (velocity[axis] + swing[axis]));
        let angular = arm[0] * momentum[1] - arm[1] * momentum[0] + density * polar * omega;
        let transport = mass * (velocity[0] * swing[1] - velocity[1] * swing[0]);
        Displaced { momentum, angular, transport }
    }

    /// Return the power (W/m) of a force (N/m) and a moment about the pivot (N m/m).
    pub fn power(&self, force: [f64; 2], moment: f64) -> f64 {
        let Pose { velocity, omega, .. } = self.pose;
        force[0] * velocity[0] + force[1] * velocity[1] + moment * omega
    }

    /// Move to the place at time `t` (s), and list the cells.
    pub fn place(&mut self, t: f64, grid: &Grid) {
        self.pose = Pose::of(&self.body, t);
        self.direction = self.pose.angle.sin_cos();
        let (Pose { position, .. }, (sin, cos), reach) = (self.pose, self.direction, self.profile.reach());
        let around = [0, 1].map(|axis| {
            // The axis of the domain in the axes of the body.
            let direction = [[cos, -sin], [sin, cos]][axis];
            let from_pivot = direction[0] * self.body.pivot[0] + direction[1] * self.body.pivot[1];
            let ahead = self.body.shape.extent(direction) - from_pivot + reach;
            let behind = self.body.shape.extent(direction.map(|component| -component)) + from_pivot + reach;
            [position[axis] - behind, position[axis] + ahead]
        });
        // A circle keeps the whole square around it.
        let farthest = if matches!(self.body.shape, Shape::Circle(_)) { f64::INFINITY } else { reach };
        let mut cells = std::mem::take(&mut self.cells);
        cells.clear();
        grid.for_each_in(around, |index, x, y| {
            let measure = self.measure(&[x, y]);
            if measure.distance() <= farthest {
                cells.add(index, [x - position[0], y - position[1]], &measure, &self.profile, grid);
            }
        });
        self.cells = cells;
    }
}

/// A place is a point, m.
impl Measured<1> for Rigid {
    type Place = [f64; 2];

    #[inline(always)]
    fn measure(&self, &[x, y]: &[f64; 2]) -> Measure<1> {
        let (Pose { position, velocity, omega, .. }, pivot) = (self.pose, self.body.pivot);
        let (sin, cos) = self.direction;
        let arm = [x - position[0], y - position[1]];
        let own = [cos * arm[0] + sin * arm[1] + pivot[0], cos * arm[1] - sin * arm[0] + pivot[1]];
        let Nearest { distance, surface, normal } = self.body.shape.nearest(own);
        let [fx, fy] = turned([0, 1].map(|axis| surface[axis] - pivot[axis]), (sin, cos));
        let foot = [position[0] + fx, position[1] + fy];
        let surfaces = [Surface { distance, foot, normal: turned(normal, (sin, cos)) }];
        let velocity = [velocity[0] - omega * arm[1], velocity[1] + omega * arm[0]];
        Measure { surfaces, velocity, velocity_before: velocity, spin: omega }
    }
}

/// Turn a vector to the left by an angle, given by its sine and cosine.
fn turned([x, y]: [f64; 2], (sin, cos): (f64, f64)) -> [f64; 2] {
    [cos * x - sin * y, cos * y + sin * x]
}
