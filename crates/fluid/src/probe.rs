//! Points whose velocity and pressure are outputs.

use nalgebra::{Matrix3xX, Vector3};

use crate::grid::Grid;

/// Distances from a wall at which the pressure is read for a probe in its smeared surface, in cells. The pressure has a kink
/// there, which rings from cell to cell: a parabola fitted over several cells does not see that.
const OFF_WALL: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

/// A point, and the grid points that its values come from.
pub struct Probe {
    /// Grid points around it and their shares: cubic interpolation along both axes, of fourth order in smooth flow.
    around: [(usize, f64); 16],
    /// The same for the pressure of a probe at a wall; absent elsewhere.
    at_wall: Option<Vec<(usize, f64)>>,
}

impl Probe {
    /// A probe at a point (m). Where that lies in the smeared surface of a still circle (centre and radius, m), its pressure
    /// is that of the flow outside, by the parabola along the normal that fits it best.
    pub fn new(position: [f64; 2], still_circles: impl Iterator<Item = ([f64; 2], f64)>, grid: &Grid) -> Self {
        let cell = grid.cell_size();
        let mut at_wall = None;
        for (center, radius) in still_circles {
            let offset = [position[0] - center[0], position[1] - center[1]];
            let from_center = offset[0].hypot(offset[1]);
            let distance = (from_center - radius) / cell;
            if distance.abs() >= OFF_WALL[0] {
                continue;
            }
            let powers = Matrix3xX::from_fn(OFF_WALL.len(), |power, i| OFF_WALL[i].powi(power as i32));
            let here = Vector3::new(1.0, distance, distance * distance);
            let Some(inverse) = (&powers * powers.transpose()).try_inverse() else { continue };
            let shares = powers.transpose() * (inverse * here);
            let look = |i: usize| {
                let out = (radius + OFF_WALL[i] * cell) / from_center;
                let around = grid.cubic_interpolation([0, 1].map(|axis| center[axis] + out * offset[axis]));
                around.map(|(point, weight)| (point, shares[i] * weight))
            };
            at_wall = Some((0..OFF_WALL.len()).flat_map(look).collect());
        }
        Self { around: grid.cubic_interpolation(position), at_wall }
    }

    /// Velocity component there, given by its field.
    pub fn velocity(&self, field: &[f64]) -> f64 {
        self.around.iter().map(|&(point, share)| share * field[point]).sum()
    }

    /// Pressure there, given by its value at a grid point.
    pub fn pressure(&self, field: impl Fn(usize) -> f64) -> f64 {
        let around = self.at_wall.as_deref().unwrap_or(&self.around);
        around.iter().map(|&(point, share)| share * field(point)).sum()
    }
}
