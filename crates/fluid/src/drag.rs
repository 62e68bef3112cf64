//! How a solid holds the fluid: the drag rate a(d) as a function of the signed distance to its surface.
//!
//! The penalized momentum equation is `∂u/∂t + … = −a(d) (u − u_s)` with d > 0 in the fluid. A mask chi has
//! a = chi / C_eta. Whatever the profile, no-slip has to hold at d = 0: the shifts below see to that in linear shear.

use std::f64::consts::PI;

use scene::Mask;

/// Euler's constant γ.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Drag rates below this fraction of 1/C_eta are left out (log-linear profile only; the others end by themselves).
const NEGLIGIBLE: f64 = 1e-9;

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
    /// `min((ν/λ²) exp(−2γ) exp(−(d + shrink)/λ), 1/C_eta)`.
    LogLinear {
        /// Largest rate, 1/s.
        rate: f64,
        /// Rate at d = −shrink, 1/s.
        surface_rate: f64,
        /// Length of e-fold growth λ, m.
        e_fold: f64,
        /// How far the profile is moved into the solid, m; 0 without reflection.
        shrink: f64,
        /// What the solid pulls the fluid towards; absent: its own velocity.
        reflection: Option<Reflection>,
    },
}

/// A weak pull towards the mirror image of the flow outside: at the depth 0 < D < `depth` the fluid is drawn to
/// `u_b − weight(D) (u(mirror) − u_b)`, `weight = strength (1 + cos(π D/depth))/2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflection {
    /// Weight at the surface.
    pub strength: f64,
    /// Depth at which it ends, m.
    pub depth: f64,
}

impl Reflection {
    /// Weight of the mirror image at signed distance `d` (m); 0 outside the layer.
    pub fn weight(&self, d: f64) -> f64 {
        if -self.depth < d && d < 0.0 { 0.5 * self.strength * (1.0 + (PI * d / self.depth).cos()) } else { 0.0 }
    }
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
            Mask::LogLinear { e_fold, reflect, .. } => {
                let length = e_fold * dx;
                let surface_rate = nu / (length * length) * (-2.0 * EULER_GAMMA).exp();
                let plain = Self::LogLinear { rate, surface_rate, e_fold: length, shrink: 0.0, reflection: None };
                if !reflect {
                    return plain;
                }
                let (strength, shrink) = calibrate_reflection(e_fold);
                let reflection = Some(Reflection { strength, depth: REFLECTION_DEPTH * dx });
                Self::LogLinear { rate, surface_rate, e_fold: length, shrink: shrink * dx, reflection }
            }
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
                (surface_rate * (-(d + shrink) / e_fold).exp()).min(rate)
            }
        }
    }

    /// The pull towards a mirror image, where the profile has one and the body is thick enough for it: at least twice
    /// the layer's depth.
    pub fn reflection(&self, thickness: f64) -> Option<Reflection> {
        match self {
            Self::LogLinear { reflection: Some(reflection), .. } if thickness >= 2.0 * reflection.depth => {
                Some(*reflection)
            }
            _ => None,
        }
    }

    /// Distance from the surface beyond which the fluid feels nothing, m.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Sharp { offset, .. } => offset,
            Self::Cosine { half_width, shift, .. } => (half_width - shift).max(0.0),
            Self::LogLinear { rate, surface_rate, e_fold, .. } => {
                (e_fold * (surface_rate / (NEGLIGIBLE * rate)).ln()).max(0.0)
            }
        }
    }
}

/// Depth of the reflecting layer in grid cells.
const REFLECTION_DEPTH: f64 = 2.0;

/// Strength of the reflection and shift of the profile into the solid (in cells) for an e-fold length in cells, such that
/// in linear shear both the displacement of the wall and the excess flux along it vanish.
fn calibrate_reflection(e_fold: f64) -> (f64, f64) {
    let excess = |strength: f64| shear_flow(e_fold, strength).1;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    let strength = 0.5 * (low + high);
    (strength, shear_flow(e_fold, strength).0)
}

/// Linear shear of slope 1 along a wall at d = 0 with the log-linear profile and a reflection: where the far field
/// vanishes, and the flux beyond that of the far field (lengths in cells).
///
/// Solves u″ = a (u + weight u(mirror)) by finite differences, the mirror image by iteration, which converges because
/// it is weak.
fn shear_flow(e_fold: f64, strength: f64) -> (f64, f64) {
    const POINTS_PER_CELL: usize = 100;
    const REACH: usize = 6;
    let h = 1.0 / POINTS_PER_CELL as f64;
    let n = 2 * REACH * POINTS_PER_CELL + 1;
    let distance = |i: usize| h * i as f64 - REACH as f64;
    let reflection = Reflection { strength, depth: REFLECTION_DEPTH };
    // Deep inside the rate is so large that any larger one makes no difference.
    let rate = |d: f64| ((-2.0 * EULER_GAMMA - d / e_fold).exp() / (e_fold * e_fold)).min(1e6);
    let rates: Vec<_> = (0..n).map(|i| rate(distance(i))).collect();
    let weights: Vec<_> = (0..n).map(|i| reflection.weight(distance(i))).collect();
    let (mut u, mut c, mut r) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
    for _ in 0..30 {
        // u_0 = 0 deep inside, u' = 1 far outside; tridiagonal elimination.
        (c[0], r[0]) = (0.0, 0.0);
        for i in 1..n - 1 {
            let source = h * h * rates[i] * weights[i] * u[n - 1 - i];
            let pivot = -2.0 - h * h * rates[i] - c[i - 1];
            (c[i], r[i]) = (1.0 / pivot, (source - r[i - 1]) / pivot);
        }
        u[n - 1] = (h + r[n - 2]) / (1.0 + c[n - 2]);
        for i in (0..n - 1).rev() {
            u[i] = r[i] - c[i] * u[i + 1];
        }
    }
    let end = distance(n - 1);
    let wall = end - u[n - 1];
    let flux = h * (u.iter().sum::<f64>() - 0.5 * u[n - 1]);
    (wall, flux - 0.5 * (end - wall).powi(2))
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
        let profile = DragProfile::new(&Mask::LogLinear { c_eta: 1e-7, e_fold: 0.3, reflect: false }, 1e-7, nu, dx);
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

    /// Without reflection the excess flux of the profile is (π²/6) λ²; with it, nothing is left.
    #[test]
    fn the_reflection_takes_out_displacement_and_excess_flux() {
        for e_fold in [0.15, 0.2, 0.3] {
            let (wall, flux) = shear_flow(e_fold, 0.0);
            let expected = PI * PI / 6.0 * e_fold * e_fold;
            assert!(wall.abs() < 2e-3, "e-fold {e_fold}: wall at {wall} cells");
            assert!((flux / expected - 1.0).abs() < 0.02, "e-fold {e_fold}: excess flux {flux} against {expected}");
            let (strength, shrink) = calibrate_reflection(e_fold);
            let (wall, flux) = shear_flow(e_fold, strength);
            assert!((wall - shrink).abs() < 1e-12 && flux.abs() < 1e-9, "e-fold {e_fold}: {wall}, {flux}");
            assert!((0.0..0.3).contains(&strength) && (0.0..0.06).contains(&shrink), "{strength}, {shrink}");
            println!("e-fold {e_fold}: strength {strength:.4}, shrink {shrink:.4} cells");
        }
    }
}
