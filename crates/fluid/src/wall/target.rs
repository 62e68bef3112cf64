//! The wall target: a weak correction of the velocity at a surface that takes out displacement, flux and slip.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::growth::Growth;
use crate::projection::smooth_damping;

/// Depth in the solid at which the mirror image's part ends, in cells.
pub const MIRROR_DEPTH: f64 = 2.0;

/// How far outside the surface the second difference's part goes, in cells.
const OUTSIDE: f64 = 1.0;

/// By how much farther, in cells, a second surface may be for a cell that both share.
const BETWEEN: f64 = 1.0;

/// Share of the drag that a flow through the surface adds, per cell Reynolds number of that flow a cell off.
///
/// The log-linear profile is made for a viscous layer, in which nu/dx² is the only rate. Where the flow comes to the wall
/// or leaves it, the fluid of the first cell changes in the time dx/u_n. Is that shorter, the flow cuts into the profile:
/// by half a cell in plane stagnation flow (Hiemenz 1911) at a cell Reynolds number of 16, and as much at a moving bar's
/// tip. With this share the bare profile keeps the wall of that flow within 0.15 cells for cell Reynolds numbers from 1 to
/// 32. The wall target alone makes up for some of it where it sees a plane wall, so that 0.25 would do there; at corners
/// it does not: a bar in prescribed motion, beside a moving mesh, supports the larger one (docs/dev/wall-model.md).
const INERTIA: f64 = 0.7;

/// The velocity that a solid with the log-linear profile draws the fluid at its surface to, in place of its own, u_b:
///
/// `u_b − mirror w(D/2) (u(D) − u_b) + curvature v (u(2) − 2 u(1) + u_b)`
///
/// along the surface and at the depth D, all lengths in cells. Across the surface the solid's own velocity stays: what
/// is drawn through the surface would be pumped against the drag. u(x) is the flow at the distance x outside, w falls
/// smoothly from 1 to 0; so does v, over `depth` inside and over one cell outside. The drag is
/// `1 + 0.7 |n·(u(1) − u_b)| dx/nu` times that of the profile, with the body's velocity u_b before the step, so that the
/// load is linear in that at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallTarget {
    /// Weight of the mirror image at the surface.
    pub mirror: f64,
    /// Weight of the second difference.
    pub curvature: f64,
    /// Where the second difference's part ends in the solid, cells.
    pub depth: f64,
    /// Size of a cell, and arm of the second difference, m.
    pub cell: f64,
    /// Share of the drag added per velocity through the surface, s/m.
    pub inertia: f64,
    /// Largest drag rate, 1/s.
    pub largest: f64,
}

/// Where a wall target samples the flow, and with what weight.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Distance from the surface into the fluid, m.
    pub off: f64,
    /// Weights of the velocity there along and across the surface, and in the flow through it.
    pub weight: [f64; 3],
}

impl WallTarget {
    /// What it samples for the point at signed distance `d` (m).
    pub fn samples(&self, d: f64) -> [Sample; 3] {
        let depth = -d / self.cell;
        let (mirror, curvature) = self.weights(depth);
        let through = fall((-depth / OUTSIDE).max(0.0));
        let across = if depth > 0.0 { -2.0 * self.mirror * mirrored_flux(depth) } else { 0.0 };
        [
            Sample { off: -d, weight: [-mirror, 0.0, 0.0] },
            Sample { off: self.cell, weight: [-2.0 * curvature, across, through] },
            Sample { off: 2.0 * self.cell, weight: [curvature, 0.0, 0.0] },
        ]
    }

    /// Whether it samples anything for the point at signed distance `d` (m).
    pub fn reaches(&self, d: f64) -> bool {
        -MIRROR_DEPTH.max(self.depth) * self.cell < d && d < OUTSIDE * self.cell
    }

    /// What each of several surfaces has of a cell at signed distances (m) from them, the largest of which is that from the
    /// body: all of it has the nearest, but where two are nearly as near they share it, so that a body that moves through
    /// the grid never turns a cell over from one to the other at once.
    pub fn shares<const N: usize>(&self, distances: [f64; N]) -> [f64; N] {
        let nearest = distances.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let weights = distances.map(|distance| fall((nearest - distance) / (BETWEEN * self.cell)));
        let sum: f64 = weights.iter().sum();
        weights.map(|weight| weight / sum)
    }

    /// Weights of the mirror image and of the second difference at a depth (cells).
    fn weights(&self, depth: f64) -> (f64, f64) {
        if depth > 0.0 {
            (self.mirror * fall(depth / MIRROR_DEPTH), self.curvature * fall(depth / self.depth))
        } else {
            (0.0, self.curvature * fall(-depth / OUTSIDE))
        }
    }
}

/// From 1 at 0 to 0 at 1 and beyond, smoothly.
fn fall(x: f64) -> f64 {
    if x < 1.0 { 1.0 + x * x * (2.0 * x - 3.0) } else { 0.0 }
}

/// `∫ x fall(x/2) dx` from `depth` to 2 (cells): what the mirror image of a shear of 1 carries along the wall below.
fn mirrored_flux(depth: f64) -> f64 {
    let s = (depth / MIRROR_DEPTH).min(1.0);
    MIRROR_DEPTH * MIRROR_DEPTH * (0.15 - s * s * (0.5 - s * s * (0.75 - 0.4 * s)))
}

/// The wall target for a growth of the drag (its cell and nu being 1), and the shift of the profile into the solid
/// (cells) that goes with it; absent where there is none, or none that contracts.
///
/// A flow `u = t d + g d²/2` along a wall sees a profile by four numbers: where its shear t seems to vanish, the flux
/// that it has beyond that of this shear, and the same of g: a slip and a flux. For the bare profile the first is 0,
/// flux and slip are (π²/6) λ² t and −(π²/6) λ² g, equal by the reciprocity of the operator `u″ − a u`. The weights and
/// the depth are those for which the flux, and with [`scene::WallCorrection::Curvature`] slip and flux of g, vanish; the
/// shift makes up for what they do to the first, and for where the grid sees the wall, as a mean over its places.
pub fn calibrate(growth: Growth, wanted: scene::WallCorrection) -> Option<(WallTarget, f64)> {
    let target = |[mirror, curvature, depth]: [f64; 3]| WallTarget {
        mirror,
        curvature,
        depth,
        cell: 1.0,
        inertia: INERTIA,
        largest: f64::INFINITY,
    };
    let count = match wanted {
        scene::WallCorrection::None => return None,
        scene::WallCorrection::Shear => 1,
        scene::WallCorrection::Curvature => 3,
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
    // Newton's method with differences from weak weights, with short strides: the errors are nearly linear in all but the
    // depth.
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
    // Rounded: processors that differ in the last digit, which the search makes more of, have the same wall.
    let rounded = |number: f64| (number * 1e7).round() * 1e-7;
    let target = target(unknowns.map(rounded));
    let mut shift = shear_flow(growth, &target).0;
    for _ in 0..5 {
        shift += wall_on_grid(growth, &target, shift)?;
    }
    let shift = rounded(shift);
    (shift.is_finite() && target.mirror + target.curvature < 1.0).then_some((target, shift))
}

/// How far outside of its place a grid sees the wall of a profile that is moved into the solid by `shift`, as a mean
/// over the places of the grid, cells: from plane Poiseuille flow with spectral derivatives and the smooth filter.
fn wall_on_grid(growth: Growth, target: &WallTarget, shift: f64) -> Option<f64> {
    /// Points of the box, cells between the walls and below the lower one, and places of the grid.
    const POINTS: usize = 64;
    const WIDTH: f64 = 24.0;
    const BELOW: f64 = 20.0;
    const PLACES: usize = 8;
    /// Advection rate of the flow that the filter is for, in nu/dx². The result is 0.007 without a filter, 0.012 for 1
    /// and 0.005 for 10.
    const ADVECTION: f64 = 1.0;
    // −u″ + r u of a point's own column of the periodic grid.
    let operator: Vec<f64> = (0..POINTS)
        .map(|point| {
            let mode = |n: usize| {
                let fraction = n as f64 / POINTS as f64;
                let rate = (ADVECTION * smooth_damping(2.0 * fraction)).min(HARDEST);
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
            let drag = growth.drag(-(d + shift)).min(HARDEST);
            matrix[(i, i)] += drag;
            for Sample { off, weight } in target.samples(d).into_iter().filter(|sample| sample.weight[0] != 0.0) {
                let at = if 2.0 * y(i) < WIDTH { off } else { WIDTH - off } - low;
                let (j, share) = (at.floor() as usize, at - at.floor());
                matrix[(i, j)] -= drag * weight[0] * (1.0 - share);
                matrix[(i, j + 1)] -= drag * weight[0] * share;
            }
        }
        let u = matrix.lu().solve(&DVector::from_element(POINTS, 1.0))?;
        // Away from the walls the flow is (b² − (y − c)²)/2: three points give b, half the width that it sees.
        let center = (0.5 * WIDTH - low).round() as usize;
        let [left, middle, right] = [center - 6, center, center + 6].map(|i| u[i]);
        let slope = (right - left) / 12.0;
        let bend = (left - 2.0 * middle + right) / 36.0;
        sum += 0.5 * WIDTH - (slope * slope / (bend * bend) - 2.0 * middle / bend).sqrt();
    }
    Some(sum / PLACES as f64)
}

/// Linear shear of slope 1 along a wall at d = 0: where the far field vanishes, and the flux beyond that of the far
/// field (cells).
fn shear_flow(growth: Growth, target: &WallTarget) -> (f64, f64) {
    let (u, h, end) = flow_along_wall(growth, target, 0.0, 1.0);
    let last = u[u.len() - 1];
    let wall = end - last;
    let flux = h * (u.iter().sum::<f64>() - 0.5 * last);
    (wall, flux - 0.5 * (end - wall).powi(2))
}

/// Curvature 1 without shear along a wall at d = 0, which far off is `d²/2 + slip`: the slip, and the flux beyond that of
/// the far field (cells).
fn bent_flow(growth: Growth, target: &WallTarget) -> (f64, f64) {
    let half_spacing = 0.5 / POINTS_PER_CELL as f64;
    let (u, h, end) = flow_along_wall(growth, target, 1.0, REACH as f64 - half_spacing);
    let last = u[u.len() - 1];
    let slip = last - 0.5 * end * end;
    let flux = h * (u.iter().sum::<f64>() - 0.5 * last);
    (slip, flux - (end.powi(3) / 6.0 + slip * end))
}

/// Drag in ν/dx² from which on more makes no difference.
const HARDEST: f64 = 1e6;

/// Resolution and extent (on both sides of the wall) of the one-dimensional problem.
const POINTS_PER_CELL: usize = 100;
const REACH: usize = 6;

/// When its iteration ends: u is of the order of [`REACH`], and the target contracts.
const CONVERGED: f64 = 1e-14;
const MOST_ITERATIONS: usize = 60;

/// Solve `u″ = a (u − u_t) + g`, lengths in cells and nu = 1, with u = 0 deep inside and a slope given half a spacing
/// before the end, by finite differences: u from `d = −REACH` on, the spacing, and the last d. The target u_t is weak:
/// it is iterated.
fn flow_along_wall(growth: Growth, target: &WallTarget, g: f64, slope: f64) -> (Vec<f64>, f64, f64) {
    let h = 1.0 / POINTS_PER_CELL as f64;
    let wall = REACH * POINTS_PER_CELL;
    let n = 2 * wall + 1;
    let distance = |i: usize| h * (i as f64 - wall as f64);
    let rate = |d: f64| growth.drag(-d).min(HARDEST);
    let rates: Vec<_> = (0..n).map(|i| rate(distance(i))).collect();
    let weights: Vec<_> = (0..n).map(|i| target.weights(-distance(i))).collect();
    // The pivots are the same in each iteration.
    let mut per_pivot = vec![0.0; n];
    for i in 1..n - 1 {
        per_pivot[i] = 1.0 / (-2.0 - h * h * rates[i] - per_pivot[i - 1]);
    }
    let (mut u, mut r) = (vec![0.0; n], vec![0.0; n]);
    for _ in 0..MOST_ITERATIONS {
        let second_difference = u[wall + 2 * POINTS_PER_CELL] - 2.0 * u[wall + POINTS_PER_CELL];
        for i in 1..n - 1 {
            let (mirror, curvature) = weights[i];
            let wanted = curvature * second_difference - mirror * u[n - 1 - i];
            r[i] = (h * h * (g - rates[i] * wanted) - r[i - 1]) * per_pivot[i];
        }
        let (mut next, mut change) = ((h * slope + r[n - 2]) / (1.0 + per_pivot[n - 2]), 0.0_f64);
        change = change.max((next - u[n - 1]).abs());
        u[n - 1] = next;
        for i in (1..n - 1).rev() {
            next = r[i] - per_pivot[i] * next;
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

    /// The bare profile has the excess flux (π²/6) λ² and, by reciprocity, the slip −(π²/6) λ²; the wall target takes
    /// both out.
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
            let targets = [scene::WallCorrection::Shear, scene::WallCorrection::Curvature];
            for (growth, wanted) in growths.into_iter().flat_map(|growth| targets.map(|wanted| (growth, wanted))) {
                let (target, shift) = calibrate(growth, wanted).expect("there is one");
                let (wall, flux) = shear_flow(growth, &target);
                let (slip, bent_flux) = bent_flow(growth, &target);
                assert!(
                    (wall - shift).abs() < 0.02 && flux.abs() < 1e-7,
                    "e-fold {decay_length_cells}: {wall}, {flux}"
                );
                if wanted == scene::WallCorrection::Curvature {
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

    /// Plane stagnation flow of the strain rate R (nu/dx²) against a wall with this target, in cells: how far its wall
    /// is inside its place, by the displacement of the far field (0.6479 layers of √(nu/R) at a wall, Hiemenz 1911).
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
        // Newton's method for the momentum along the wall; the flow through it is that of the iteration before.
        for _ in 0..40 {
            let v = through(&u);
            let drag = |i: usize| {
                let inertia = 1.0 + target.inertia * v[wall + PER_CELL];
                (growth.drag(-(d(i) + shift)) * inertia).min(HARDEST)
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

    /// Without the share of inertia the flow cuts into the bare profile; with it the wall stays.
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
