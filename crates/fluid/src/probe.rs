//! Points whose velocity and pressure are outputs.

use nalgebra::{Matrix3xX, Vector3};

use crate::grid::Grid;

/// At how many points, a cell apart, the pressure is read for a probe in a wall's smeared surface, and how many cells off the
/// first one is. The pressure has a kink there, which rings from cell to cell, most at the first; the mean of three neighbours by
/// ¼, ½, ¼ does not see that, and a parabola through those of several cells carries it to the wall. Nothing else may stand there.
const OFF_WALL: usize = 16;
const FIRST_OFF_WALL: f64 = 2.0;

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
            if distance.abs() >= 1.0 {
                continue;
            }
            // The mean of x² over three neighbours is x² + ½.
            let powers = Matrix3xX::from_fn(OFF_WALL - 2, |power, i| {
                let x = i as f64 + 1.0 + FIRST_OFF_WALL;
                [1.0, x, x * x + 0.5][power]
            });
            let here = Vector3::new(1.0, distance, distance * distance);
            let Some(inverse) = (&powers * powers.transpose()).try_inverse() else { continue };
            let means = powers.transpose() * (inverse * here);
            let mut shares = [0.0; OFF_WALL];
            for (i, mean) in means.iter().enumerate() {
                (0..3).for_each(|k| shares[i + k] += mean * [0.25, 0.5, 0.25][k]);
            }
            let look = |(i, share): (usize, f64)| {
                let out = (radius + (i as f64 + FIRST_OFF_WALL) * cell) / from_center;
                let around = grid.cubic_interpolation([0, 1].map(|axis| center[axis] + out * offset[axis]));
                around.map(|(point, weight)| (point, share * weight))
            };
            at_wall = Some(shares.into_iter().enumerate().flat_map(look).collect());
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
