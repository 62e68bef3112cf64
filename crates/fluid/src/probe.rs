//! Points whose velocity and pressure are outputs.

use nalgebra::{Matrix3xX, Vector3};

use crate::grid::Grid;
use line_fft::Real;

/// Over how many radii the pressure is read, a cell apart, for a probe in a wall's smeared surface, and how many cells
/// off the first point is. The pressure has a kink there, which rings from cell to cell, most at the first; the mean of
/// three neighbours by ¼, ½, ¼ does not see that, and a parabola through those of several cells carries it to the wall.
/// How far a parabola holds is a matter of the radius: on the pressure of 2D-1 by finite elements, one over 1.4 radii is
/// off by +0.5 to -0.5 % of the difference between front and back on grids of 450 to 1100 points, one over 16 cells by
/// +1.5 to -1.5 %.
/// The points end where they come as near to another still body as the first one is to this; of fewer than the least
/// number no parabola is drawn.
const OFF_WALL: f64 = 1.4;
const LEAST_OFF_WALL: usize = 6;
const FIRST_OFF_WALL: f64 = 1.5;

/// A point, and the grid points that its values come from.
pub struct Probe {
    /// Grid points around it and their shares: cubic interpolation along both axes, of fourth order in smooth flow.
    around: [(usize, f64); 16],
    /// The same for the pressure of a probe at a wall; absent elsewhere.
    at_wall: Option<Vec<(usize, f64)>>,
}

impl Probe {
    /// The probes of a scene.
    pub fn of(fluid: &scene::Fluid, grid: &Grid) -> Vec<Self> {
        let still = fluid.cylinders.iter().filter(|cylinder| cylinder.motion.is_none());
        let circles: Vec<_> = still.map(|cylinder| (cylinder.center, cylinder.radius)).collect();
        let walls = fluid.channel.as_ref().map(|channel| channel.y);
        fluid.probes.iter().map(|probe| Self::new(probe.position, &circles, walls, grid)).collect()
    }

    /// A probe at a point (m). Where that lies in the smeared surface of one of the still `circles` (centre and radius,
    /// m), its pressure is that of the flow outside, by the parabola along the normal that fits it best; `channel` has
    /// the walls' y (m).
    fn new(position: [f64; 2], circles: &[([f64; 2], f64)], channel: Option<[f64; 2]>, grid: &Grid) -> Self {
        let cell = grid.cell_size();
        let mut at_wall = None;
        for (own, &(center, radius)) in circles.iter().enumerate() {
            let offset = [position[0] - center[0], position[1] - center[1]];
            let from_center = offset[0].hypot(offset[1]);
            let distance = (from_center - radius) / cell;
            if distance.abs() >= 1.0 {
                continue;
            }
            let place = |i: usize| {
                let out = (radius + (i as f64 + FIRST_OFF_WALL) * cell) / from_center;
                [0, 1].map(|axis| center[axis] + out * offset[axis])
            };
            let clear = |[x, y]: [f64; 2]| {
                let gap = FIRST_OFF_WALL * cell;
                channel.is_none_or(|[low, high]| y - low >= gap && high - y >= gap)
                    && circles
                        .iter()
                        .enumerate()
                        .all(|(other, &([cx, cy], r))| other == own || (x - cx).hypot(y - cy) >= r + gap)
            };
            let wanted = (OFF_WALL * radius / cell).round().max(LEAST_OFF_WALL as f64) as usize;
            let count = (0..wanted).take_while(|&i| clear(place(i))).count();
            if count < LEAST_OFF_WALL {
                continue;
            }
            // The mean of x² over three neighbours is x² + ½.
            let powers = Matrix3xX::from_fn(count - 2, |power, i| {
                let x = i as f64 + 1.0 + FIRST_OFF_WALL;
                [1.0, x, x * x + 0.5][power]
            });
            let here = Vector3::new(1.0, distance, distance * distance);
            let Some(inverse) = (&powers * powers.transpose()).try_inverse() else { continue };
            let means = powers.transpose() * (inverse * here);
            let mut shares = vec![0.0; count];
            for (i, mean) in means.iter().enumerate() {
                (0..3).for_each(|k| shares[i + k] += mean * [0.25, 0.5, 0.25][k]);
            }
            let sample = |(i, share): (usize, f64)| {
                let around = grid.cubic_interpolation(place(i));
                around.map(|(point, weight)| (point, share * weight))
            };
            at_wall = Some(shares.into_iter().enumerate().flat_map(sample).collect());
        }
        Self { around: grid.cubic_interpolation(position), at_wall }
    }

    /// Velocity component there, given by its field.
    pub fn velocity<R: Real>(&self, field: &[R]) -> f64 {
        self.around.iter().map(|&(point, share)| share * field[point].to_f64()).sum()
    }

    /// Pressure there, given by its value at a grid point.
    pub fn pressure(&self, field: impl Fn(usize) -> f64) -> f64 {
        let around = self.at_wall.as_deref().unwrap_or(&self.around);
        around.iter().map(|&(point, share)| share * field(point)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// p = 1 + y outside a circle under a wall, noise inside: what is read does not see the noise, and nothing beyond
    /// the wall.
    #[test]
    fn pressure_at_a_wall_is_that_of_the_flow_before_it() {
        let grid = Grid::new(&scene::FluidBox { x: [0.0, 1.0], y: [0.0, 1.0], cells: [100, 100] });
        let whole = &grid;
        let (center, radius) = ([0.5, 0.5], 0.1);
        let field = |blocked: f64| {
            move |point: usize| {
                let [x, y] = whole.point(point);
                let inside = (x - center[0]).hypot(y - center[1]) < radius - 0.005;
                if inside || y > blocked { 1e3 * (point as f64).sin() } else { 1.0 + y }
            }
        };
        let probe = |channel| Probe::new([0.5, 0.6], &[(center, radius)], channel, &grid);
        for (channel, blocked) in [(None, 1.0), (Some([0.0, 0.72]), 0.72)] {
            let found = probe(channel).pressure(field(blocked));
            assert!((found - 1.6).abs() < 1e-9, "{channel:?}: {found}");
        }
        // Seven cells to the wall hold fewer than six points: the field as it is.
        assert!(probe(Some([0.0, 0.67])).at_wall.is_none());
    }
}
