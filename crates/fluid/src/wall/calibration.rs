//! Calibration of the wall target by one-dimensional flows along a wall.

use std::f64::consts::TAU;

use method::WallCorrection;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::growth::Growth;
use super::target::{INERTIA, Sample, WallTarget};
use crate::filter::smooth_damping;

/// Return the wall target for a growth of the drag (with cell and nu equal to 1), and the displacement of the profile
/// into the solid (cells); none if there is no correction, or none that contracts.
///
/// Four numbers describe the effect of a profile on a flow `u = t d + g d²/2` along a wall: the zero of the shear t,
/// the excess flux of the shear, and slip and excess flux of g. For the bare profile the zero is at 0, and flux and
/// slip are (π²/6) λ² t and −(π²/6) λ² g, equal by the reciprocity of the operator `u″ − a u`. With the calibrated
/// weights and depth the flux of the shear vanishes, and with [`WallCorrection::Curvature`] slip and flux of g as well.
/// The displacement compensates for their effect on the zero, and for the position of the wall on a grid, as a mean
/// over positions of the grid.
pub fn calibrate(growth: Growth, wanted: WallCorrection) -> Option<(WallTarget, f64)> {
    let target = |[mirror, curvature, depth]: [f64; 3]| WallTarget {
        mirror,
        curvature,
        depth,
        cell: 1.0,
        inertia: INERTIA,
        largest: f64::INFINITY,
    };
    let count = match wanted {
        WallCorrection::None => return None,
        WallCorrection::Shear => 1,
        WallCorrection::Curvature => 3,
    };
    let errors = |unknowns: [f64; 3]| {
        let target = target(unknowns);
        let (_, flux) = shear_flow(growth, &target);
        if count == 1 {
            return Vector3::new(flux, 0.0, 0.0);
        }
        let (slip, bent_flux) = bent_flow(growth, &target);
        Vector3::new(flux, slip, bent_flux)
    };
    // Newton's method with differences and short strides from weak weights: the errors are nearly linear in the
    // weights.
    let mut unknowns = [0.1, if count == 1 { 0.0 } else { 0.1 }, 1.0];
    for _ in 0..30 {
        const STEP: f64 = 1e-3;
        const STRIDE: f64 = 0.05;
        let here = errors(unknowns);
        let mut jacobian = Matrix3::identity();
        for i in 0..count {
            let mut moved = unknowns;
            moved[i] += STEP;
            jacobian.set_column(i, &((errors(moved) - here) / STEP));
        }
        let change = jacobian.lu().solve(&here)?;
        let change = change * (STRIDE / change.amax()).min(1.0);
        unknowns.iter_mut().zip(change.iter()).for_each(|(unknown, change)| *unknown -= change);
        if change.amax() < 1e-12 {
            break;
        }
    }
    // Rounded, so that processors that differ in the last digit have the same wall: the search amplifies the
    // difference.
    let rounded = |number: f64| (number * 1e7).round() * 1e-7;
    let target = target(unknowns.map(rounded));
    let mut shift = shear_flow(growth, &target).0;
    for _ in 0..5 {
        shift += wall_on_grid(growth, &target, shift)?;
    }
    let shift = rounded(shift);
    (shift.is_finite() && target.mirror + target.curvature < 1.0).then_some((target, shift))
}

/// Return the displacement (cells, outwards) of the wall on a grid, for a profile that is moved into the solid by
/// `shift`: the mean over positions of the grid, from plane Poiseuille flow with spectral derivatives and the smooth
/// filter.
fn wall_on_grid(growth: Growth, target: &WallTarget, shift: f64) -> Option<f64> {
    /// Points of the domain, cells between the walls and below the lower one, and positions of the grid.
    const POINTS: usize = 64;
    const WIDTH: f64 = 24.0;
    const BELOW: f64 = 20.0;
    const PLACES: usize = 8;
    /// Advection rate in the filter, nu/dx². The result is 0.007 without a filter, 0.012 for 1 and 0.005 for 10.
    const ADVECTION: f64 = 1.0;
    // −u″ + r u, as the response to a point of the periodic grid.
    let operator: Vec<f64> = (0..POINTS)
        .map(|point| {
            let mode = |n: usize| {
                let fraction = n as f64 / POINTS as f64;
                let rate = (ADVECTION * smooth_damping(2.0 * fraction)).min(LARGEST_DRAG);
                let pair = if 2 * n == POINTS { 1.0 } else { 2.0 };
                pair * ((TAU * fraction).powi(2) + rate) * (TAU * fraction * point as f64).cos() / POINTS as f64
            };
            (1..=POINTS / 2).map(mode).sum()
        })
        .collect();
    let mut sum = 0.0;
    for place in 0..PLACES {
        let low = -BELOW + place as f64 / PLACES as f64;
        let y = |i: usize| low + i as f64;
        let mut matrix = DMatrix::from_fn(POINTS, POINTS, |i, j| operator[i.abs_diff(j)]);
        for i in 0..POINTS {
            let d = y(i).min(WIDTH - y(i));
            let drag = growth.drag(-(d + shift)).min(LARGEST_DRAG);
            matrix[(i, i)] += drag;
            for Sample { off, weight } in target.samples(d).into_iter().filter(|sample| sample.weight[0] != 0.0) {
                let at = if 2.0 * y(i) < WIDTH { off } else { WIDTH - off } - low;
                let (j, share) = (at.floor() as usize, at - at.floor());
                matrix[(i, j)] -= drag * weight[0] * (1.0 - share);
                matrix[(i, j + 1)] -= drag * weight[0] * share;
            }
        }
        let u = matrix.lu().solve(&DVector::from_element(POINTS, 1.0))?;
        // Far from the walls the flow is (b² − (y − c)²)/2: three points give b, half the apparent width.
        let center = (0.5 * WIDTH - low).round() as usize;
        let [left, middle, right] = [center - 6, center, center + 6].map(|i| u[i]);
        let slope = (right - left) / 12.0;
        let bend = (left - 2.0 * middle + right) / 36.0;
        sum += 0.5 * WIDTH - (slope * slope / (bend * bend) - 2.0 * middle / bend).sqrt();
    }
    Some(sum / PLACES as f64)
}

/// Return, for linear shear of slope 1 along a wall at d = 0, the zero of the far field and the flux beyond it (cells).
fn shear_flow(growth: Growth, target: &WallTarget) -> (f64, f64) {
    let (u, h, end) = flow_along_wall(growth, target, 0.0, 1.0);
    let last = u[u.len() - 1];
    let wall = end - last;
    let flux = h * (u.iter().sum::<f64>() - 0.5 * last);
    (wall, flux - 0.5 * (end - wall).powi(2))
}

/// Return, for a flow of curvature 1 without shear along a wall at d = 0, the slip of the far field `d²/2 + slip` and
/// the flux beyond it (cells).
fn bent_flow(growth: Growth, target: &WallTarget) -> (f64, f64) {
    let half_spacing = 0.5 / POINTS_PER_CELL as f64;
    let (u, h, end) = flow_along_wall(growth, target, 1.0, REACH as f64 - half_spacing);
    let last = u[u.len() - 1];
    let slip = last - 0.5 * end * end;
    let flux = h * (u.iter().sum::<f64>() - 0.5 * last);
    (slip, flux - (end.powi(3) / 6.0 + slip * end))
}

/// Drag in ν/dx² above which a larger drag has no effect.
const LARGEST_DRAG: f64 = 1e6;

/// Resolution and extent (on both sides of the wall) of the one-dimensional problem.
const POINTS_PER_CELL: usize = 100;
const REACH: usize = 6;

/// Change at which the iteration ends: u is of the order of [`REACH`], and the target contracts.
const CONVERGED: f64 = 1e-14;
const MAX_ITERATIONS: usize = 60;

/// Solve `u″ = a (u − u_t) + g` by finite differences, with lengths in cells, nu = 1, u = 0 deep inside and a slope
/// given half a spacing before the end. Return u from `d = −REACH`, the spacing, and the last d. The target u_t is weak
/// and is iterated.
fn flow_along_wall(growth: Growth, target: &WallTarget, g: f64, slope: f64) -> (Vec<f64>, f64, f64) {
    let h = 1.0 / POINTS_PER_CELL as f64;
    let wall = REACH * POINTS_PER_CELL;
    let n = 2 * wall + 1;
    let distance = |i: usize| h * (i as f64 - wall as f64);
    let rate = |d: f64| growth.drag(-d).min(LARGEST_DRAG);
    let rates: Vec<_> = (0..n).map(|i| rate(distance(i))).collect();
    let weights: Vec<_> = (0..n).map(|i| target.weights(-distance(i))).collect();
    // The pivots are the same in all iterations.
    let mut inv_pivot = vec![0.0; n];
    for i in 1..n - 1 {
        inv_pivot[i] = 1.0 / (-2.0 - h * h * rates[i] - inv_pivot[i - 1]);
    }
    let (mut u, mut r) = (vec![0.0; n], vec![0.0; n]);
    for _ in 0..MAX_ITERATIONS {
        let second_difference = u[wall + 2 * POINTS_PER_CELL] - 2.0 * u[wall + POINTS_PER_CELL];
        for i in 1..n - 1 {
            let (mirror, curvature) = weights[i];
            let wanted = curvature * second_difference - mirror * u[n - 1 - i];
            r[i] = (h * h * (g - rates[i] * wanted) - r[i - 1]) * inv_pivot[i];
        }
        let (mut next, mut change) = ((h * slope + r[n - 2]) / (1.0 + inv_pivot[n - 2]), 0.0_f64);
        change = change.max((next - u[n - 1]).abs());
        u[n - 1] = next;
        for i in (1..n - 1).rev() {
            next = r[i] - inv_pivot[i] * next;
            change = change.max((next - u[i]).abs());
            u[i] = next;
        }
        if change < CONVERGED {
            break;
        }
    }
    (u, h, distance(n - 1))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// The bare profile has the excess flux (π²/6) λ² and, by reciprocity, the slip −(π²/6) λ²; the wall target removes
    /// both.
    #[test]
    fn the_wall_target_takes_out_displacement_fluxes_and_slip() {
        for decay_length_cells in [0.15, 0.2, 0.25, 0.3] {
            let growth = Growth::wall(decay_length_cells);
            let bare = WallTarget { mirror: 0.0, curvature: 0.0, depth: 1.0, cell: 1.0, inertia: 0.0, largest: 1e6 };
            let (wall, flux) = shear_flow(growth, &bare);
            let expected = PI * PI / 6.0 * decay_length_cells * decay_length_cells;
            assert!(wall.abs() < 2e-3, "e-fold {decay_length_cells}: wall at {wall} cells");
            assert!(
                (flux / expected - 1.0).abs() < 0.02,
                "e-fold {decay_length_cells}: excess flux {flux} against {expected}"
            );
            let (slip, _) = bent_flow(growth, &bare);
            assert!(
                (slip / expected + 1.0).abs() < 0.02,
                "e-fold {decay_length_cells}: slip {slip} against {}",
                -expected
            );
            let still = |core_depth| Growth::still(decay_length_cells, f64::INFINITY, core_depth, true);
            let growths = [
                still(None),
                still(Some(2.0)),
                Growth::moving(decay_length_cells, 5.0),
                Growth::moving(decay_length_cells, 3.0),
            ];
            let targets = [WallCorrection::Shear, WallCorrection::Curvature];
            for (growth, wanted) in growths.into_iter().flat_map(|growth| targets.map(|wanted| (growth, wanted))) {
                let (target, shift) = calibrate(growth, wanted).expect("there is one");
                let (wall, flux) = shear_flow(growth, &target);
                let (slip, bent_flux) = bent_flow(growth, &target);
                assert!(
                    (wall - shift).abs() < 0.02 && flux.abs() < 1e-7,
                    "e-fold {decay_length_cells}: {wall}, {flux}"
                );
                if wanted == WallCorrection::Curvature {
                    assert!(
                        slip.abs() < 1e-7 && bent_flux.abs() < 1e-7,
                        "e-fold {decay_length_cells}: slip {slip}, flux {bent_flux}"
                    );
                }
                assert!(target.mirror > 0.0 && target.mirror + target.curvature < 1.0, "{target:?} does not contract");
                let on_grid = wall_on_grid(growth, &target, shift).expect("there is one");
                assert!(on_grid.abs() < 1e-4, "e-fold {decay_length_cells}: the grid sees the wall at {on_grid} cells");
            }
        }
    }

    /// Return the distance (cells) of the apparent wall inside its place in plane stagnation flow of a strain rate
    /// (nu/dx²), by the displacement of the far field (0.6479 layers of √(nu/R) at a wall, Hiemenz 1911).
    fn wall_in_stagnation_flow(strain: f64, target: &WallTarget, growth: Growth, shift: f64) -> f64 {
        const PER_CELL: usize = 20;
        let (h, wall) = (1.0 / PER_CELL as f64, 2 * PER_CELL + PER_CELL / 2);
        let n = wall + ((7.0 / strain.sqrt()).max(1.5) / h) as usize + 2 * PER_CELL;
        let d = |i: usize| (i as f64 - wall as f64) * h;
        let mut u = DVector::from_fn(n, |i, _| strain * (1.0 - (-1.2 * strain.sqrt() * d(i).max(0.0)).exp()));
        let through = |u: &DVector<f64>| {
            let mut sum = 0.0;
            let flows = (0..n).map(|i| {
                sum += if i > 0 { 0.5 * h * (u[i - 1] + u[i]) } else { 0.0 };
                sum
            });
            flows.collect::<Vec<f64>>()
        };
        // Newton's method for the momentum along the wall, with the flow through it from the previous iteration.
        for _ in 0..40 {
            let v = through(&u);
            let drag = |i: usize| {
                let inertia = 1.0 + target.inertia * v[wall + PER_CELL];
                (growth.drag(-(d(i) + shift)) * inertia).min(LARGEST_DRAG)
            };
            let mut matrix = DMatrix::<f64>::identity(n, n);
            let mut right = DVector::zeros(n);
            right[n - 1] = strain;
            for i in 1..n - 1 {
                let around = [(i - 1, 1.0 / (h * h) - v[i] / (2.0 * h)), (i + 1, 1.0 / (h * h) + v[i] / (2.0 * h))];
                matrix[(i, i)] = -2.0 / (h * h) - 2.0 * u[i] - drag(i);
                around.into_iter().for_each(|(j, weight)| matrix[(i, j)] = weight);
                for Sample { off, weight } in target.samples(d(i)) {
                    matrix[(i, (wall as f64 + off / h).round() as usize)] += drag(i) * weight[0];
                }
                right[i] = -strain * strain - u[i] * u[i];
            }
            let next = matrix.lu().solve(&right).expect("it can be solved");
            u = 0.5 * (u + next);
        }
        d(n - 1) - through(&u)[n - 1] / strain - 0.6479 / strain.sqrt()
    }

    /// Without the drag of inertia the flow cuts into the bare profile; with it the wall stays.
    #[test]
    fn the_wall_stays_where_the_flow_comes_to_it() {
        let growth = Growth::wall(0.25);
        let bare = WallTarget { mirror: 0.0, curvature: 0.0, depth: 1.0, cell: 1.0, inertia: INERTIA, largest: 1e6 };
        for (reynolds, without) in [(1.0, -0.15), (4.0, -0.3), (16.0, -0.45)] {
            let wall = wall_in_stagnation_flow(reynolds, &bare, growth, 0.0);
            assert!(wall.abs() < 0.15, "cell Reynolds number {reynolds}: wall {wall} cells outside");
            let cut = wall_in_stagnation_flow(reynolds, &WallTarget { inertia: 0.0, ..bare }, growth, 0.0);
            assert!(cut < without, "cell Reynolds number {reynolds}: {cut} without inertia");
        }
    }
}
