//! Circular cylinders, still or in prescribed motion.

use std::f64::consts::PI;

use crate::body::Cell;
use crate::drag::DragProfile;
use crate::grid::Grid;

/// A cylinder and the cells in which it drags the fluid.
pub struct Cylinder {
    shape: scene::Cylinder,
    /// Velocity of the centre, m/s.
    pub velocity: [f64; 2],
    /// Cells of the present position.
    pub cells: Vec<Cell>,
}

impl Cylinder {
    /// A cylinder at its place at t = 0.
    pub fn new(shape: &scene::Cylinder, grid: &Grid, profile: &DragProfile) -> Self {
        let mut cylinder = Self { shape: shape.clone(), velocity: [0.0; 2], cells: Vec::new() };
        cylinder.place(0.0, grid, profile);
        cylinder
    }

    /// Whether it moves at all.
    pub fn moves(&self) -> bool {
        self.shape.motion.is_some()
    }

    /// Mass of the fluid it displaces per metre of depth, kg/m.
    pub fn displaced_mass(&self, density: f64) -> f64 {
        density * PI * self.shape.radius.powi(2)
    }

    /// Move to where the prescribed motion has it at time `t` (s), and list its cells there.
    pub fn place(&mut self, t: f64, grid: &Grid, profile: &DragProfile) {
        let mut center = self.shape.center;
        if let Some(motion) = &self.shape.motion {
            for (axis, law) in [&motion.x, &motion.y].into_iter().enumerate() {
                let (displacement, rate) = law.value_and_rate(t);
                center[axis] += displacement;
                self.velocity[axis] = rate;
            }
        }
        let radius = self.shape.radius;
        let outer = radius + profile.reach();
        let (cells, velocity) = (&mut self.cells, self.velocity);
        cells.clear();
        grid.for_each_in(
            [center[0] - outer, center[0] + outer],
            [center[1] - outer, center[1] + outer],
            |index, x, y| {
                let rate = profile.rate((x - center[0]).hypot(y - center[1]) - radius);
                if rate > 0.0 {
                    cells.push(Cell { index, rate, velocity });
                }
            },
        );
    }
}
