//! How a solid holds the fluid: the drag rate a(d) as a function of the signed distance to its surface.
//!
//! The penalized momentum equation is `∂u/∂t + … = −a(d) (u − u_s)` with d > 0 in the fluid. A mask chi has
//! a = chi / C_eta. Whatever the profile, no-slip has to hold at d = 0: the shifts below see to that in linear shear.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use scene::Mask;

/// Euler's constant γ.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// e-folds from the surface into the fluid beyond which the log-linear drag is left out (the other profiles end by
/// themselves). In linear shear what is left out would move the wall by `e^{−2γ} (x² + 2x + 2) e^{−x} λ`, 1.7e-3 λ.
const TAIL: f64 = 10.0;

/// e-folds below the surface from which on the log-linear profile is steeper, and the factor. In linear shear the flow has fallen
/// to 0.7 % of λ times the shear there, so that the fluid outside does not see it (the calibration takes in what it sees);
/// but a bar of two or three cells would be porous without it.
const CORE: f64 = 3.0;
const CORE_STEEPNESS: f64 = 3.0;

/// A drag profile on one grid, in one fluid.
#[derive(Clone, Copy, Debug)]
pub enum DragProfile {
    /// `1/C_eta` for d < offset.
    Sharp {
        /// Largest rate, 1/s.
        rate: f64,
        /// How far the mask reaches into the fluid, m.
        offset: f64,
    },
    /// `(1 + cos(π (d + shift + h)/(2h)))/2 / C_eta` for |d + shift| < h.
    Cosine {
        /// Largest rate, 1/s.
        rate: f64,
        /// Half the width of the layer, m.
        half_width: f64,
        /// How far the layer is moved into the solid, m.
        shift: f64,
    },
    /// `min((ν/λ²) exp(−2γ) exp(folds), 1/C_eta)` with `−(d + shrink)/λ` e-folds, three times as steep in the core.
    LogLinear {
        /// Largest rate, 1/s.
        rate: f64,
        /// Rate at d = −shrink, 1/s.
        surface_rate: f64,
        /// Length of e-fold growth λ, m.
        e_fold: f64,
        /// How far the profile is moved into the solid, m; 0 without a wall target.
        shrink: f64,
        /// What the solid draws the fluid to; absent: its own velocity.
        target: Option<WallTarget>,
    },
}

/// What a solid with the log-linear profile draws the fluid at its surface to, in place of its own velocity u_b:
///
/// `u_b − mirror w(D/2) (u(D) − u_b) + curvature v (u(2) − 2 u(1) + u_b)`
///
/// along the surface (across it, its own velocity stays: what is drawn through the surface would be pumped against the drag) and
/// at the depth D, all lengths in cells: u(x) is the flow at the distance x outside, w falls smoothly from 1 to 0; v is
/// w(D/depth) inside and 1 outside up to half a cell, as far as the drag matters.
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

/// Where a wall target looks, and what for.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Distance from the surface into the fluid, m.
    pub off: f64,
    /// Weights of the velocity there along and across the surface.
    pub weight: [f64; 2],
}

impl WallTarget {
    /// What it looks at for the point at signed distance `d` (m).
    pub fn looks(&self, d: f64) -> [Look; 3] {
        let depth = -d / self.cell;
        let (mirror, curvature) = self.weights(depth);
        let across = if depth > 0.0 { -2.0 * self.mirror * mirrored_flux(depth) } else { 0.0 };
        [
            Look { off: -d, weight: [-mirror, 0.0] },
            Look { off: self.cell, weight: [-2.0 * curvature, across] },
            Look { off: 2.0 * self.cell, weight: [curvature, 0.0] },
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

/// Growth of the log-linear drag from the surface to some e-folds below it.
fn growth(folds: f64) -> f64 {
    (folds + (CORE_STEEPNESS - 1.0) * (folds - CORE).max(0.0)).exp()
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

impl DragProfile {
    /// Profile of `mask` with relaxation time `c_eta` (s) for viscosity `nu` (m²/s) and cells of size `dx` (m).
    pub fn new(mask: &Mask, c_eta: f64, nu: f64, dx: f64) -> Self {
        let rate = 1.0 / c_eta;
        let eps = (nu * c_eta).sqrt();
        match *mask {
            Mask::Sharp { displacement_corrected, .. } => {
                Self::Sharp { rate, offset: if displacement_corrected { eps } else { 0.0 } }
            }
            Mask::Cosine { half_width, displacement_corrected, .. } => {
                let half_width = half_width * dx;
                let displacement =
                    if displacement_corrected { eps * cosine_wall_displacement(half_width / eps) } else { 0.0 };
                Self::Cosine { rate, half_width, shift: displacement }
            }
            Mask::LogLinear { e_fold, target, .. } => {
                let length = e_fold * dx;
                let surface_rate = nu / (length * length) * (-2.0 * EULER_GAMMA).exp();
                let plain = Self::LogLinear { rate, surface_rate, e_fold: length, shrink: 0.0, target: None };
                let Some((target, shrink)) = calibrate(e_fold, target) else { return plain };
                let target = Some(WallTarget { cell: dx, ..target });
                Self::LogLinear { rate, surface_rate, e_fold: length, shrink: shrink * dx, target }
            }
        }
    }

    /// The same without a wall target: for walls and zones, along which the flow is fully resolved.
    pub fn plain(mut self) -> Self {
        if let Self::LogLinear { shrink, target, .. } = &mut self {
            (*shrink, *target) = (0.0, None);
        }
        self
    }

    /// The profile of a body of some thickness (m): one of less than two cells has no wall target.
    pub fn of_body(self, thickness: f64) -> Self {
        match self.target() {
            Some(target) if thickness < MIRROR_DEPTH * target.cell => self.plain(),
            _ => self,
        }
    }

    /// What the solid draws the fluid to, if that is not its own velocity.
    pub fn target(&self) -> Option<&WallTarget> {
        match self {
            Self::LogLinear { target, .. } => target.as_ref(),
            _ => None,
        }
    }

    /// Drag rate at signed distance `d` (m, positive in the fluid), 1/s.
    pub fn rate(&self, d: f64) -> f64 {
        match *self {
            Self::Sharp { rate, offset } => {
                if d < offset {
                    rate
                } else {
                    0.0
                }
            }
            Self::Cosine { rate, half_width, shift } => {
                let depth = ((d + shift + half_width) / (2.0 * half_width)).clamp(0.0, 1.0);
                rate * 0.5 * (1.0 + (PI * depth).cos())
            }
            Self::LogLinear { rate, surface_rate, e_fold, shrink, .. } => {
                (surface_rate * growth(-(d + shrink) / e_fold)).min(rate)
            }
        }
    }

    /// Distance from the surface beyond which the fluid feels nothing, m.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Sharp { offset, .. } => offset,
            Self::Cosine { half_width, shift, .. } => (half_width - shift).max(0.0),
            Self::LogLinear { e_fold, .. } => TAIL * e_fold,
        }
    }
}

/// Depth in the solid at which the mirror image's part ends, in cells.
const MIRROR_DEPTH: f64 = 2.0;

/// How far outside the surface the second difference's part goes, in cells.
const OUTSIDE: f64 = 0.5;

/// The wall target for an e-fold length in cells (its own cell being 1), and the shift of the profile into the solid (cells)
/// that goes with it; absent where there is none.
///
/// A flow `u = t d + g d²/2` along a wall sees a profile by four numbers: where its shear t seems to vanish, the flux that it
/// has beyond that of this shear, and the same of g: a slip and a flux. For the bare profile the first is 0, flux and slip are
/// (π²/6) λ² t and −(π²/6) λ² g, equal by the reciprocity of the operator `u″ − a u`. The weights and the depth are those for
/// which the flux, and with [`scene::WallTarget::Curvature`] slip and flux of g, vanish; the shift makes up for what they do to
/// the first.
fn calibrate(e_fold: f64, wanted: scene::WallTarget) -> Option<(WallTarget, f64)> {
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

/// Linear shear of slope 1 along a wall at d = 0: where the far field vanishes, and the flux beyond that of the far field
/// (cells).
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

/// Solve `u″ = a (u − u_t) + g`, lengths in cells and nu = 1, with u = 0 deep inside and a slope given half a spacing before the
/// end, by finite differences: u from `d = −REACH` on, the spacing, and the last d. The target u_t is weak: it is iterated.
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

/// Displacement of the no-slip wall by the cosine mask of half-width `h` (in units of eps = √(ν C_eta)), in the same
/// unit, positive where the body is too fat: where the solution of u″ = chi u that decays into the solid and is linear
/// in the fluid would vanish (Hester, Vasil & Burns 2021).
fn cosine_wall_displacement(h: f64) -> f64 {
    const STEPS: usize = 4000;
    let chi = |x: f64| 0.5 * (1.0 + (PI * (x + h) / (2.0 * h)).cos());
    let dx = 2.0 * h / STEPS as f64;
    // Riccati form of the equation: r = u'/u, r' = chi - r²; it cannot overflow.
    let slope = |x: f64, r: f64| chi(x) - r * r;
    let mut r = 1.0;
    for step in 0..STEPS {
        let x = -h + step as f64 * dx;
        let k1 = slope(x, r);
        let k2 = slope(x + 0.5 * dx, r + 0.5 * dx * k1);
        let k3 = slope(x + 0.5 * dx, r + 0.5 * dx * k2);
        let k4 = slope(x + dx, r + dx * k3);
        r += dx / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    h - 1.0 / r
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the displacement against half-width, both in eps, computed independently from the same equation.
    #[test]
    fn the_cosine_mask_is_displaced_as_published() {
        let table = [(1.0, -0.841), (2.0, -0.466), (3.0, 0.027), (5.0, 1.207), (10.0, 4.680), (20.0, 12.5)];
        for (h, expected) in table {
            let shift = cosine_wall_displacement(h);
            assert!((shift - expected).abs() < 6e-3_f64.max(4e-3 * h), "h = {h} eps: {shift} against {expected}");
        }
        assert!(cosine_wall_displacement(2.9490).abs() < 1e-3, "{}", cosine_wall_displacement(2.9490));
    }

    /// Without correction the masks are those of the thesis: chi = 1 for d < 0, and 1/2 at d = 0 (eq. 4.1).
    #[test]
    fn uncorrected_masks_stand_where_the_thesis_has_them() {
        let (nu, dx, c_eta) = (1e-3, 4e-3, 1e-3);
        let chi = |mask: Mask, d: f64| c_eta * DragProfile::new(&mask, c_eta, nu, dx).rate(d);
        let sharp = |displacement_corrected| Mask::Sharp { c_eta, displacement_corrected };
        let cosine = |displacement_corrected| Mask::Cosine { c_eta, half_width: 1.0, displacement_corrected };
        assert_eq!([-1e-9, 0.0].map(|d| chi(sharp(false), d)), [1.0, 0.0]);
        assert_eq!([0.99e-3, 1.01e-3].map(|d| chi(sharp(true), d)), [1.0, 0.0]);
        for (d, expected) in [(-dx, 1.0), (-0.5 * dx, 0.853_553_390_6), (0.0, 0.5), (dx, 0.0)] {
            let found = chi(cosine(false), d);
            assert!((found - expected).abs() < 1e-10, "chi({d}) = {found}, not {expected}");
        }
        // h = 4 eps: too fat by 0.593 eps (Hester, Vasil & Burns 2021).
        let shifted = chi(cosine(true), -0.593e-3);
        assert!((shifted - 0.5).abs() < 1e-3, "chi = {shifted} at the shifted middle of the layer");
    }

    /// In linear shear, ν u″ = a(d) u, the far field of the log-linear profile is u ∝ d.
    #[test]
    fn the_log_linear_profile_holds_the_wall_at_zero() {
        let (nu, dx) = (1e-3, 4e-3);
        let profile = DragProfile::new(
            &Mask::LogLinear { c_eta: 1e-7, e_fold: 0.3, target: scene::WallTarget::None },
            1e-7,
            nu,
            dx,
        );
        let (from, to, steps) = (-8.0 * dx, 8.0 * dx, 400_000);
        let h = (to - from) / steps as f64;
        let slope = |d: f64, r: f64| profile.rate(d) / nu - r * r;
        let mut r = (profile.rate(from) / nu).sqrt();
        for step in 0..steps {
            let d = from + step as f64 * h;
            let k1 = slope(d, r);
            let k2 = slope(d + h, r + h * k1);
            r += 0.5 * h * (k1 + k2);
        }
        let wall = to - 1.0 / r;
        assert!(wall.abs() < 1e-3 * dx, "no-slip at {wall} m, cells of {dx} m");
    }

    /// The bare profile has the excess flux (π²/6) λ² and, by reciprocity, the slip −(π²/6) λ²; the wall target takes both
    /// out.
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
