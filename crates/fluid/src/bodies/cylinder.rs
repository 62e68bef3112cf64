//! Circular cylinders, still or in prescribed motion.

use std::f64::consts::PI;

use scene::Mask;

use super::cells::Cells;
use crate::force::Displaced;
use crate::grid::Grid;
use crate::wall::DragProfile;

/// A cylinder and the cells in which it drags the fluid.
pub struct Cylinder {
    shape: scene::Cylinder,
    profile: DragProfile,
    /// Velocity of the centre, m/s.
    pub velocity: [f64; 2],
    /// Cells of the present position.
    pub cells: Cells,
}

impl Cylinder {
    /// A cylinder at its place at t = 0.
    pub fn new(shape: &scene::Cylinder, grid: &Grid, mask: &Mask, nu: f64) -> Self {
        let profile = DragProfile::of_body(2.0 * shape.radius, mask, nu, grid.cell_size());
        let mut cylinder = Self { shape: shape.clone(), profile, velocity: [0.0; 2], cells: Cells::default() };
        cylinder.place(0.0, grid);
        cylinder
    }

    /// Whether it moves at all.
    pub fn moves(&self) -> bool {
        self.shape.motion.is_some()
    }

    /// Whether its drag on the fluid changes: it moves, or follows a wall target.
    pub fn changes(&self) -> bool {
        self.moves() || self.cells.have_targets()
    }

    /// The fluid of a density (kg/m³) that it displaces; it does not turn.
    pub fn displaced(&self, density: f64) -> Displaced {
        let mass = density * PI * self.shape.radius.powi(2);
        Displaced { momentum: self.velocity.map(|velocity| mass * velocity), ..Displaced::default() }
    }

    /// Move to where the prescribed motion has it at time `t` (s), and list its cells there.
    pub fn place(&mut self, t: f64, grid: &Grid) {
        let mut center = self.shape.center;
        if let Some(motion) = &self.shape.motion {
            for (axis, law) in [&motion.x, &motion.y].into_iter().enumerate() {
                let (displacement, rate) = law.value_and_rate(t);
                center[axis] += displacement;
                self.velocity[axis] = rate;
            }
        }
        let radius = self.shape.radius;
        let (cells, profile, velocity) = (&mut self.cells, &self.profile, self.velocity);
        let outer = radius + profile.reach();
        cells.clear();
        let (low, high) = (center.map(|c| c - outer), center.map(|c| c + outer));
        grid.for_each_in([low[0], high[0]], [low[1], high[1]], |index, x, y| {
            let offset = [x - center[0], y - center[1]];
            let from_center = offset[0].hypot(offset[1]);
            let distance = from_center - radius;
            let rate = profile.rate(distance);
            if rate > 0.0 {
                cells.push(index, rate, velocity, offset);
                if let Some(target) = profile.target() {
                    let normal = offset.map(|component| component / from_center.max(f64::MIN_POSITIVE));
                    let surface = [center[0] + radius * normal[0], center[1] + radius * normal[1]];
                    cells.follow_last(target, distance, surface, normal, velocity, grid);
                }
            }
        });
    }
}
