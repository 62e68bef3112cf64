//! The wall target: a weak correction of the velocity at a surface that takes out displacement, flux and slip.

use nalgebra::{Matrix3, Vector3};

use super::growth::{EULER_GAMMA, growth};

/// Depth in the solid at which the mirror image's part ends, in cells.
pub const MIRROR_DEPTH: f64 = 2.0;

/// How far outside the surface the second difference's part goes, in cells.
const OUTSIDE: f64 = 0.5;

/// The velocity that a solid with the log-linear profile draws the fluid at its surface to, in place of its own, u_b:
///
/// `u_b − mirror w(D/2) (u(D) − u_b) + curvature v (u(2) − 2 u(1) + u_b)`
///
/// along the surface and at the depth D, all lengths in cells. Across the surface the solid's own velocity stays: what
/// is drawn through the surface would be pumped against the drag. u(x) is the flow at the distance x outside, w falls
/// smoothly from 1 to 0; v is w(D/depth) inside and 1 outside up to half a cell, as far as the drag matters.
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
}

/// Where a wall target samples the flow, and with what weight.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Distance from the surface into the fluid, m.
    pub off: f64,
    /// Weights of the velocity there along and across the surface.
    pub weight: [f64; 2],
}

impl WallTarget {
    /// What it samples for the point at signed distance `d` (m).
    pub fn samples(&self, d: f64) -> [Sample; 3] {
        let depth = -d / self.cell;
        let (mirror, curvature) = self.weights(depth);
        let across = if depth > 0.0 { -2.0 * self.mirror * mirrored_flux(depth) } else { 0.0 };
        [
            Sample { off: -d, weight: [-mirror, 0.0] },
            Sample { off: self.cell, weight: [-2.0 * curvature, across] },
            Sample { off: 2.0 * self.cell, weight: [curvature, 0.0] },
        ]
    }

    /// Weights of the mirror image and of the second difference at a depth (cells).
    fn weights(&self, depth: f64) -> (f64, f64) {
        if depth > 0.0 {
            (self.mirror * fall(depth / MIRROR_DEPTH), self.curvature * fall(depth / self.depth))
        } else {
            (0.0, if depth > -OUTSIDE { self.curvature } else { 0.0 })
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

/// The wall target for an e-fold length in cells (its own cell being 1), and the shift of the profile into the solid
/// (cells) that goes with it; absent where there is none.
///
/// A flow `u = t d + g d²/2` along a wall sees a profile by four numbers: where its shear t seems to vanish, the flux
/// that it has beyond that of this shear, and the same of g: a slip and a flux. For the bare profile the first is 0,
/// flux and slip are (π²/6) λ² t and −(π²/6) λ² g, equal by the reciprocity of the operator `u″ − a u`. The weights and
/// the depth are those for which the flux, and with [`scene::WallTarget::Curvature`] slip and flux of g, vanish; the
/// shift makes up for what they do to the first.
pub fn calibrate(e_fold: f64, wanted: scene::WallTarget) -> Option<(WallTarget, f64)> {
    let target = |[mirror, curvature, depth]: [f64; 3]| WallTarget { mirror, curvature, depth, cell: 1.0 };
    let count = match wanted {
        scene::WallTarget::None => return None,
        scene::WallTarget::Shear => 1,
        scene::WallTarget::Curvature => 3,
    };
    let errors = |unknowns: [f64; 3]| {
        let target = target(unknowns);
        let (_, flux) = shear_flow(e_fold, &target);
        if count == 1 {
            return Vector3::new(flux, 0.0, 0.0);
        }
        let (slip, bent_flux) = bent_flow(e_fold, &target);
        Vector3::new(flux, slip, bent_flux)
    };
    // Newton's method with differences from weak weights: all errors are nearly linear.
    let mut unknowns = [0.1, if count == 1 { 0.0 } else { 0.1 }, 1.0];
    for _ in 0..8 {
        const STEP: f64 = 1e-3;
        let here = errors(unknowns);
        let mut jacobian = Matrix3::identity();
        for i in 0..count {
            let mut moved = unknowns;
            moved[i] += STEP;
            jacobian.set_column(i, &((errors(moved) - here) / STEP));
        }
        let change = jacobian.lu().solve(&here)?;
        unknowns.iter_mut().zip(change.iter()).for_each(|(unknown, change)| *unknown -= change);
    }
    let target = target(unknowns);
    Some((target, shear_flow(e_fold, &target).0))
}

/// Linear shear of slope 1 along a wall at d = 0: where the far field vanishes, and the flux beyond that of the far
/// field (cells).
fn shear_flow(e_fold: f64, target: &WallTarget) -> (f64, f64) {
    let (u, h, end) = flow_along_wall(e_fold, target, 0.0, 1.0);
    let last = u[u.len() - 1];
    let wall = end - last;
    let flux = h * (u.iter().sum::<f64>() - 0.5 * last);
    (wall, flux - 0.5 * (end - wall).powi(2))
}

/// Curvature 1 without shear along a wall at d = 0, which far off is `d²/2 + slip`: the slip, and the flux beyond that of
/// the far field (cells).
fn bent_flow(e_fold: f64, target: &WallTarget) -> (f64, f64) {
    let half_spacing = 0.5 / POINTS_PER_CELL as f64;
    let (u, h, end) = flow_along_wall(e_fold, target, 1.0, REACH as f64 - half_spacing);
    let last = u[u.len() - 1];
    let slip = last - 0.5 * end * end;
    let flux = h * (u.iter().sum::<f64>() - 0.5 * last);
    (slip, flux - (end.powi(3) / 6.0 + slip * end))
}

/// Resolution and extent (on both sides of the wall) of the one-dimensional problem.
const POINTS_PER_CELL: usize = 100;
const REACH: usize = 6;

/// Solve `u″ = a (u − u_t) + g`, lengths in cells and nu = 1, with u = 0 deep inside and a slope given half a spacing
/// before the end, by finite differences: u from `d = −REACH` on, the spacing, and the last d. The target u_t is weak:
/// it is iterated.
fn flow_along_wall(e_fold: f64, target: &WallTarget, g: f64, slope: f64) -> (Vec<f64>, f64, f64) {
    let h = 1.0 / POINTS_PER_CELL as f64;
    let wall = REACH * POINTS_PER_CELL;
    let n = 2 * wall + 1;
    let distance = |i: usize| h * (i as f64 - wall as f64);
    // Deep inside the rate is so large that any larger one makes no difference.
    let surface_rate = (-2.0 * EULER_GAMMA).exp() / (e_fold * e_fold);
    let rate = |d: f64| (surface_rate * growth(-d / e_fold)).min(1e6);
    let rates: Vec<_> = (0..n).map(|i| rate(distance(i))).collect();
    let weights: Vec<_> = (0..n).map(|i| target.weights(-distance(i))).collect();
    let (mut u, mut c, mut r) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for _ in 0..60 {
        let second_difference = u[wall + 2 * POINTS_PER_CELL] - 2.0 * u[wall + POINTS_PER_CELL];
        for i in 1..n - 1 {
            let (mirror, curvature) = weights[i];
            let wanted = curvature * second_difference - mirror * u[n - 1 - i];
            let source = h * h * (g - rates[i] * wanted);
            let pivot = -2.0 - h * h * rates[i] - c[i - 1];
            (c[i], r[i]) = (1.0 / pivot, (source - r[i - 1]) / pivot);
        }
        u[n - 1] = (h * slope + r[n - 2]) / (1.0 + c[n - 2]);
        for i in (1..n - 1).rev() {
            u[i] = r[i] - c[i] * u[i + 1];
        }
    }
    (u, h, distance(n - 1))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// The bare profile has the excess flux (π²/6) λ² and, by reciprocity, the slip −(π²/6) λ²; the wall target takes
    /// both out.
    #[test]
    fn the_wall_target_takes_out_displacement_fluxes_and_slip() {
        for e_fold in [0.15, 0.2, 0.25, 0.3] {
            let bare = WallTarget { mirror: 0.0, curvature: 0.0, depth: 1.0, cell: 1.0 };
            let (wall, flux) = shear_flow(e_fold, &bare);
            let expected = PI * PI / 6.0 * e_fold * e_fold;
            assert!(wall.abs() < 2e-3, "e-fold {e_fold}: wall at {wall} cells");
            assert!((flux / expected - 1.0).abs() < 0.02, "e-fold {e_fold}: excess flux {flux} against {expected}");
            let (slip, _) = bent_flow(e_fold, &bare);
            assert!((slip / expected + 1.0).abs() < 0.02, "e-fold {e_fold}: slip {slip} against {}", -expected);
            for wanted in [scene::WallTarget::Shear, scene::WallTarget::Curvature] {
                let (target, shift) = calibrate(e_fold, wanted).expect("there is one");
                let (wall, flux) = shear_flow(e_fold, &target);
                let (slip, bent_flux) = bent_flow(e_fold, &target);
                assert!((wall - shift).abs() < 1e-12 && flux.abs() < 1e-9, "e-fold {e_fold}: {wall}, {flux}");
                if wanted == scene::WallTarget::Curvature {
                    assert!(
                        slip.abs() < 1e-9 && bent_flux.abs() < 1e-9,
                        "e-fold {e_fold}: slip {slip}, flux {bent_flux}"
                    );
                }
                assert!(target.mirror > 0.0 && target.mirror + target.curvature < 1.0, "{target:?} does not contract");
            }
        }
    }
}
