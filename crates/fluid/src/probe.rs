//! Points at which velocity and pressure are read.

use nalgebra::{Matrix3xX, Vector3};

use crate::grid::Grid;
use crate::parameters::Parameters;

/// Extrapolation of the pressure to a probe in the smeared surface of a still cylinder, where the pressure has a kink.
///
/// The kink rings from cell to cell, most at the first. The mean of three neighbours by 1/4, 1/2, 1/4 removes the
/// ringing, and a parabola through the means at points a cell apart extrapolates to the wall. The parabola holds over a
/// length that scales with the radius: against finite elements on 2D-1, one over 1.4 radii is off by +0.5 to −0.5 % of
/// the pressure difference between front and back on grids of 450 to 1100 points, one over 16 cells by +1.5 to −1.5 %.
/// The points end before they are nearer to another still body than the first point is to this one; fewer than the
/// least number give no parabola.
const FIT_LENGTH_IN_RADII: f64 = 1.4;
const LEAST_FIT_POINTS: usize = 6;
const FIRST_POINT_IN_CELLS: f64 = 1.5;

/// A point, with the grid points and weights that its values come from.
pub struct Probe {
    /// Cubic interpolation along both axes, of fourth order in smooth flow.
    pub around: [(usize, f64); 16],
    /// Points and weights of the pressure of a probe at a wall; absent elsewhere.
    at_wall: Option<Vec<(usize, f64)>>,
}

impl Probe {
    /// Return the probes.
    pub fn all(parameters: &Parameters, grid: &Grid) -> Vec<Self> {
        let still = parameters.cylinders.iter().filter(|cylinder| cylinder.motion.is_none());
        let circles: Vec<_> = still.map(|cylinder| (cylinder.center, cylinder.radius)).collect();
        parameters.probes.iter().map(|probe| Self::new(*probe, &circles, parameters.channel, grid)).collect()
    }

    /// A probe at a point (m), with the still `circles` (centre and radius, m) and the y of the walls of a channel (m).
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
                let out = (radius + (i as f64 + FIRST_POINT_IN_CELLS) * cell) / from_center;
                [0, 1].map(|axis| center[axis] + out * offset[axis])
            };
            let clear = |[x, y]: [f64; 2]| {
                let gap = FIRST_POINT_IN_CELLS * cell;
                channel.is_none_or(|[low, high]| y - low >= gap && high - y >= gap)
                    && circles
                        .iter()
                        .enumerate()
                        .all(|(other, &([cx, cy], r))| other == own || (x - cx).hypot(y - cy) >= r + gap)
            };
            let wanted = (FIT_LENGTH_IN_RADII * radius / cell).round().max(LEAST_FIT_POINTS as f64) as usize;
            let count = (0..wanted).take_while(|&i| clear(place(i))).count();
            if count < LEAST_FIT_POINTS {
                continue;
            }
            // The mean of x² over three neighbours is x² + ½.
            let powers = Matrix3xX::from_fn(count - 2, |power, i| {
                let x = i as f64 + 1.0 + FIRST_POINT_IN_CELLS;
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

    /// Return the pressure, given at a grid point.
    pub fn pressure(&self, at: impl Fn(usize) -> f64) -> f64 {
        let around = self.at_wall.as_deref().unwrap_or(&self.around);
        around.iter().map(|&(point, share)| share * at(point)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// p = 1 + y + 5 (y − 0.6)² outside a circle under a wall, noise inside and beyond the wall: the noise is not read.
    #[test]
    fn pressure_at_a_wall_is_that_of_the_flow_before_it() {
        let grid = Grid::new([[0.0, 1.0]; 2], [100; 2]);
        let whole = &grid;
        let (center, radius) = ([0.5, 0.5], 0.1);
        let field = |blocked: f64| {
            move |point: usize| {
                let [x, y] = whole.point(point);
                let inside = (x - center[0]).hypot(y - center[1]) < radius - 0.005;
                if inside || y > blocked { 1e3 * (point as f64).sin() } else { 1.0 + y + 5.0 * (y - 0.6).powi(2) }
            }
        };
        let probe = |channel| Probe::new([0.5, 0.6], &[(center, radius)], channel, &grid);
        for (channel, blocked) in [(None, 1.0), (Some([0.0, 0.72]), 0.72)] {
            let found = probe(channel).pressure(field(blocked));
            assert!((found - 1.6).abs() < 1e-9, "{channel:?}: {found}");
        }
        // Seven cells to the wall hold fewer than six points: no extrapolation.
        assert!(probe(Some([0.0, 0.67])).at_wall.is_none());
    }
}
