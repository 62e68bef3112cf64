//! Rigid bodies, still or moving. A cylinder is a circle that does not turn.
//!
//! A point at `r` from the pivot, whose velocity is v, moves with `v + omega × r`.

use super::body_pose::Pose;
use super::cells::Cells;
use super::measure::{Measure, Measured, Surface};
use super::mount::Released;
use super::section::{Nearest, Section};
use crate::force::Displaced;
use crate::grid::Grid;
use crate::parameters::{Body, Mask, Motion, Mount, Shape};
use crate::thin::kernel::LINE_THICKNESS_CELLS;
use crate::wall::DragProfile;

/// A body and the cells in which it drags the fluid.
pub struct Rigid {
    body: Body,
    section: Section,
    /// Drag in its cells; absent for a line, whose markers drag.
    profile: Option<DragProfile>,
    /// Present place and motion.
    pub pose: Pose,
    /// Sine and cosine of the angle.
    direction: (f64, f64),
    /// Cells at the present place.
    pub cells: Cells,
    /// What the solve of the present step found, of a body on springs.
    pub released: Option<Released>,
}

impl Body {
    /// Return mass and moment of inertia about the pivot of the displaced fluid of a density (kg/m³).
    pub(crate) fn displaced(&self, density: f64) -> [f64; 2] {
        self.inertia(&self.shape.section(), density)
    }

    /// Return mass and moment of inertia about the pivot of a section of a density (kg/m³).
    fn inertia(&self, &Section { area, centroid, polar }: &Section, density: f64) -> [f64; 2] {
        let arm = [0, 1].map(|axis| centroid[axis] - self.pivot[axis]);
        [density * area, density * (polar + area * (arm[0] * arm[0] + arm[1] * arm[1]))]
    }

    /// Return the layer of fluid that moves with a line of cells of a size (m), in a fluid of a density (kg/m³). On
    /// springs it has at most the inertia of the body.
    fn layer(&self, points: &[[f64; 2]], cell: f64, density: f64) -> Section {
        let layer = Section::of_layer(points, LINE_THICKNESS_CELLS * cell);
        let Some(Motion::Mount(mount)) = &self.motion else { return layer };
        let [mass, inertia] = self.inertia(&layer, density);
        let [moves, turns] = [mount.supports[0].or(mount.supports[1]).is_some(), mount.supports[2].is_some()];
        let arm = (layer.centroid[0] - self.pivot[0]).hypot(layer.centroid[1] - self.pivot[1]);
        // Largest eigenvalue of the inertia of the layer over its diagonal.
        let largest = if moves && turns { 1.0 + arm * (mass / inertia).sqrt() } else { 1.0 };
        let mut share = 1.0_f64;
        for (own, of_layer, is_free) in [(mount.mass, mass, moves), (mount.inertia, inertia, turns)] {
            if is_free {
                share = share.min(own / (of_layer * largest));
            }
        }
        Section { area: share * layer.area, polar: share * layer.polar, ..layer }
    }
}

impl Rigid {
    /// A body at t = 0.
    pub fn new(body: Body, grid: &Grid, mask: &Mask, nu: f64, density: f64) -> Self {
        let (body, cell) = (Body { shape: body.shape.oriented(), ..body }, grid.cell_size());
        let (section, profile) = match &body.shape {
            Shape::Line(points) => (body.layer(points, cell, density), None),
            shape => {
                let profile = DragProfile::of_body(shape.thickness(), body.motion.is_some(), mask, nu, cell);
                (shape.section(), Some(profile))
            }
        };
        let (pose, cells) = (Pose::default(), Cells::default());
        let mut rigid = Self { body, section, profile, pose, direction: (0.0, 1.0), cells, released: None };
        rigid.follow(0.0, grid);
        rigid
    }

    /// Return whether it is a line, without cells.
    pub fn is_line(&self) -> bool {
        self.profile.is_none()
    }

    /// Return whether the master or the fluid moves it, rather than a law.
    pub fn is_carried(&self) -> bool {
        matches!(self.body.motion, Some(Motion::Master | Motion::Mount(_)))
    }

    /// Return its springs and dampers, if it is on such.
    pub fn mount(&self) -> Option<&Mount> {
        if let Some(Motion::Mount(mount)) = &self.body.motion { Some(mount) } else { None }
    }

    /// Return its place and motion for those relative to its place at rest.
    pub fn pose_of(&self, displacement: &Pose) -> Pose {
        let [x, y] = [0, 1].map(|axis| self.body.position[axis] + displacement.position[axis]);
        Pose { position: [x, y], angle: self.body.angle + displacement.angle, ..*displacement }
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
        let arm = self.centroid(centroid, angle);
        // Velocity of the centroid relative to the pivot.
        let swing = [-omega * arm[1], omega * arm[0]];
        let momentum = [0, 1].map(|axis| mass * (velocity[axis] + swing[axis]));
        let angular = arm[0] * momentum[1] - arm[1] * momentum[0] + density * polar * omega;
        let transport = mass * (velocity[0] * swing[1] - velocity[1] * swing[0]);
        Displaced { momentum, angular, transport }
    }

    /// Return mass and polar moment of inertia about the pivot of the displaced fluid of a density (kg/m³), and the
    /// position of its centroid from the pivot, m.
    pub fn displaced_inertia(&self, density: f64) -> (f64, f64, [f64; 2]) {
        let ([mass, inertia], centroid) = (self.body.inertia(&self.section, density), self.section.centroid);
        (mass, inertia, self.centroid(centroid, self.pose.angle))
    }

    /// Return the position of a centroid in the axes of the body from the pivot, at an angle.
    fn centroid(&self, centroid: [f64; 2], angle: f64) -> [f64; 2] {
        turned([centroid[0] - self.body.pivot[0], centroid[1] - self.body.pivot[1]], angle.sin_cos())
    }

    /// Return the power (W/m) of a force (N/m) and a moment about the pivot (N m/m).
    pub fn power(&self, force: [f64; 2], moment: f64) -> f64 {
        let Pose { velocity, omega, .. } = self.pose;
        force[0] * velocity[0] + force[1] * velocity[1] + moment * omega
    }

    /// Move to the place that the laws give at time `t` (s), and list the cells.
    pub fn follow(&mut self, t: f64, grid: &Grid) {
        self.place(Pose::of(&self.body, t), grid);
    }

    /// Move to a place, and list the cells.
    pub fn place(&mut self, pose: Pose, grid: &Grid) {
        (self.pose, self.released) = (pose, None);
        self.direction = self.pose.angle.sin_cos();
        let Some(profile) = &self.profile else { return };
        let (Pose { position, .. }, (sin, cos), reach) = (self.pose, self.direction, profile.reach());
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
                cells.add(index, [x - position[0], y - position[1]], &measure, profile, grid);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Law;

    /// Force and moment about the moving pivot under which a rigid body as heavy as the fluid would move: with the
    /// acceleration a of the pivot and the centroid at r, `m (a + alpha × r − omega² r)` and
    /// `m r × a + (I + m r²) alpha`, I being the polar moment about the centroid.
    #[test]
    fn the_unsteady_term_is_the_inertia_of_the_displaced_fluid() {
        let motion = |amplitude: f64, frequency: f64| {
            Law::new(move |t| {
                let (sin, cos) = (frequency * t + 0.4).sin_cos();
                (amplitude * sin, amplitude * frequency * cos)
            })
        };
        let [x, y, angle] = [[0.3, 2.0], [0.2, 3.0], [0.8, 2.5]];
        let body = Body {
            shape: Shape::Ellipse([0.3, 0.1]),
            position: [0.0; 2],
            pivot: [-0.2, 0.05],
            angle: 0.3,
            motion: Some(Motion::Laws {
                displacement: [x, y].map(|[amplitude, frequency]| motion(amplitude, frequency)),
                angle: motion(angle[0], angle[1]),
            }),
        };
        let grid = Grid::new([[-1.0, 1.0]; 2], [16; 2]);
        let (t, dt, density) = (0.7, 1e-4, 2.0);
        let mask = Mask::Sharp { c_eta: 1.0, displacement_corrected: false };
        let mut rigid = Rigid::new(body, &grid, &mask, 1e-3, density);
        let [before, after] = [t - 0.5 * dt, t + 0.5 * dt].map(|t| {
            rigid.follow(t, &grid);
            rigid.displaced(density)
        });
        let found = after.rate_of_change(&before, dt);
        let at = |[amplitude, frequency]: [f64; 2]| {
            let (sin, cos) = (frequency * t + 0.4_f64).sin_cos();
            [amplitude * sin, amplitude * frequency * cos, -amplitude * frequency * frequency * sin]
        };
        let ([turn, omega, alpha], a) = (at(angle), [at(x)[2], at(y)[2]]);
        let r = turned([0.2, -0.05], (0.3 + turn).sin_cos());
        let mass = density * std::f64::consts::PI * 0.3 * 0.1;
        let polar = mass * 0.25 * (0.3 * 0.3 + 0.1 * 0.1);
        let force =
            [mass * (a[0] - alpha * r[1] - omega * omega * r[0]), mass * (a[1] + alpha * r[0] - omega * omega * r[1])];
        let moment = mass * (r[0] * a[1] - r[1] * a[0]) + (polar + mass * (r[0] * r[0] + r[1] * r[1])) * alpha;
        for (found, expected) in [(found.force[0], force[0]), (found.force[1], force[1]), (found.moment, moment)] {
            assert!((found - expected).abs() < 1e-6, "{found} against {expected}");
        }
    }
}
