//! Rigid bodies, still or in prescribed motion. A cylinder is a circle that does not turn.
//!
//! A point at `r` from the pivot, whose velocity is v, moves with `v + omega × r`.

use scene::{Body, Mask};

use super::cells::{Cells, Near};
use super::shape::{Section, Shape};
use crate::force::Displaced;
use crate::grid::Grid;
use crate::wall::DragProfile;

/// A body and the cells in which it drags the fluid.
pub struct Rigid {
    body: Body,
    shape: Shape,
    section: Section,
    profile: DragProfile,
    /// Where it is now.
    pub pose: Pose,
    /// Cells of the present position.
    pub cells: Cells,
}

/// Place and motion of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position of the pivot, m.
    pub position: [f64; 2],
    /// Angle from the x axis of the box to that of the body, rad.
    pub angle: f64,
    /// Velocity of the pivot, m/s.
    pub velocity: [f64; 2],
    /// Rate at which it turns, rad/s.
    pub omega: f64,
}

impl Pose {
    /// Where a body is at a time (s).
    fn of(body: &Body, t: f64) -> Self {
        let mut pose = Self { position: body.position, angle: body.angle, ..Self::default() };
        if let Some(motion) = &body.motion {
            for (axis, law) in [&motion.x, &motion.y].into_iter().enumerate() {
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
    /// A body at its place at t = 0.
    pub fn new(body: Body, grid: &Grid, mask: &Mask, nu: f64) -> Self {
        let shape = Shape::new(&body.shape);
        let profile = DragProfile::of_body(shape.thickness(), body.motion.is_some(), mask, nu, grid.cell_size());
        let (section, pose, cells) = (shape.section(), Pose::default(), Cells::default());
        let mut rigid = Self { body, shape, section, profile, pose, cells };
        rigid.place(0.0, grid);
        rigid
    }

    /// Whether it moves at all.
    pub fn moves(&self) -> bool {
        self.body.motion.is_some()
    }

    /// Whether its drag on the fluid changes: it moves, or follows a wall target.
    pub fn changes(&self) -> bool {
        self.moves() || self.cells.have_targets()
    }

    /// The fluid of a density (kg/m³) that it displaces; moments are about the pivot.
    pub fn displaced(&self, density: f64) -> Displaced {
        let Section { area, centroid, polar } = self.section;
        let Pose { angle, velocity, omega, .. } = self.pose;
        let mass = density * area;
        let arm = turned([centroid[0] - self.body.pivot[0], centroid[1] - self.body.pivot[1]], angle.sin_cos());
        // The centroid's velocity is that of the pivot and this.
        let swing = [-omega * arm[1], omega * arm[0]];
        let momentum = [0, 1].map(|axis| mass * (velocity[axis] + swing[axis]));
        let angular = arm[0] * momentum[1] - arm[1] * momentum[0] + density * polar * omega;
        let transport = mass * (velocity[0] * swing[1] - velocity[1] * swing[0]);
        Displaced { momentum, angular, transport }
    }

    /// Power (W/m) of a force (N/m) and a moment about the pivot (N m/m) on it.
    pub fn power(&self, force: [f64; 2], moment: f64) -> f64 {
        let Pose { velocity, omega, .. } = self.pose;
        force[0] * velocity[0] + force[1] * velocity[1] + moment * omega
    }

    /// Move to where the prescribed motion has it at time `t` (s), and list its cells there.
    pub fn place(&mut self, t: f64, grid: &Grid) {
        self.pose = Pose::of(&self.body, t);
        let Pose { position, angle, velocity, omega } = self.pose;
        let (sin, cos) = angle.sin_cos();
        let (cells, shape, profile, pivot) = (&mut self.cells, &self.shape, &self.profile, self.body.pivot);
        let around = |axis: usize| {
            // The axis of the box in those of the body.
            let direction = [[cos, -sin], [sin, cos]][axis];
            let from_pivot = direction[0] * pivot[0] + direction[1] * pivot[1];
            let ahead = shape.extent(direction) - from_pivot + profile.reach();
            let behind = shape.extent(direction.map(|component| -component)) + from_pivot + profile.reach();
            [position[axis] - behind, position[axis] + ahead]
        };
        // A circle keeps all of the square around it.
        let farthest = if matches!(shape, Shape::Circle(_)) { f64::INFINITY } else { profile.reach() };
        cells.clear();
        grid.for_each_in(around(0), around(1), |index, x, y| {
            let arm = [x - position[0], y - position[1]];
            let own = [cos * arm[0] + sin * arm[1] + pivot[0], cos * arm[1] - sin * arm[0] + pivot[1]];
            let nearest = shape.nearest(own);
            let rate = profile.rate(nearest.distance);
            if rate > 0.0 && nearest.distance <= farthest {
                let there = [velocity[0] - omega * arm[1], velocity[1] + omega * arm[0]];
                cells.push(index, rate, there, arm);
                if let Some(target) = profile.target(nearest.distance) {
                    let [sx, sy] = turned([0, 1].map(|axis| nearest.surface[axis] - pivot[axis]), (sin, cos));
                    let surface = [position[0] + sx, position[1] + sy];
                    let normal = turned(nearest.normal, (sin, cos));
                    let near = Near { distance: nearest.distance, surface, normal, share: 1.0 };
                    cells.follow_last(target, near, there, grid);
                    cells.turn_last(target, nearest.distance, omega);
                }
            }
        });
    }
}

/// A vector turned to the left by an angle, given by its sine and cosine.
fn turned([x, y]: [f64; 2], (sin, cos): (f64, f64)) -> [f64; 2] {
    [cos * x - sin * y, cos * y + sin * x]
}
