//! The penalization rate a(d) as a function of the signed distance to the surface of a solid.
//!
//! The penalized momentum equation is `∂u/∂t + … = −a(d) (u − u_s)` with d > 0 in the fluid. A mask chi has
//! a = chi / C_eta. No-slip must hold at d = 0 for every profile: the shifts make it hold in linear shear.

use std::f64::consts::PI;

use method::Mask;

use super::calibration::calibrate;
use super::growth::Growth;
use super::target::{MIRROR_DEPTH, WallTarget};

/// A drag profile on one grid, in one fluid.
#[derive(Clone, Copy, Debug)]
pub enum DragProfile {
    /// `1/C_eta` for d < offset.
    Sharp {
        /// Largest rate, 1/s.
        rate: f64,
        /// Extent of the mask into the fluid, m.
        offset: f64,
    },
    /// `(1 + cos(π (d + shift + h)/(2h)))/2 / C_eta` for |d + shift| < h.
    Cosine {
        /// Largest rate, 1/s.
        rate: f64,
        /// Half the width of the layer, m.
        half_width: f64,
        /// Displacement of the layer into the solid, m.
        shift: f64,
    },
    /// `(ν/dx²) growth`, at most 1/C_eta.
    LogLinear {
        /// Largest rate, 1/s.
        rate: f64,
        /// `ν/dx²`, 1/s.
        unit: f64,
        /// Growth with the depth.
        growth: Growth,
        /// Size of a cell, m.
        cell: f64,
        /// Displacement of the profile into the solid, m; 0 without a wall target.
        shrink: f64,
        /// Correction of the velocity to which the fluid is drawn at the surface; absent: none.
        target: Option<WallTarget>,
    },
}

impl DragProfile {
    /// Profile of a wall or a zone, with relaxation time `c_eta` (s), viscosity `nu` (m²/s) and cells of size `dx` (m).
    pub fn new(mask: &Mask, c_eta: f64, nu: f64, dx: f64) -> Self {
        let rate = 1.0 / c_eta;
        match *mask {
            Mask::Sharp { .. } => Self::Sharp { rate, offset: -mask.shift(c_eta, nu, dx) },
            Mask::Cosine { half_width, .. } => {
                Self::Cosine { rate, half_width: half_width * dx, shift: mask.shift(c_eta, nu, dx) }
            }
            Mask::LogLinear { decay_length_cells, .. } => {
                let growth = Growth::wall(decay_length_cells);
                Self::LogLinear { rate, unit: nu / (dx * dx), growth, cell: dx, shrink: 0.0, target: None }
            }
        }
    }

    /// Profile of a body with a thickness (m), still or moving. A body thinner than two cells has no wall target.
    pub fn of_body(thickness: f64, moves: bool, mask: &Mask, nu: f64, dx: f64) -> Self {
        let mut profile = Self::new(mask, mask.c_eta(), nu, dx);
        let (
            Self::LogLinear { rate, growth, shrink, target, .. },
            &Mask::LogLinear { decay_length_cells, core_depth, wall_correction: wanted, .. },
        ) = (&mut profile, mask)
        else {
            return profile;
        };
        let cells = thickness / dx;
        let growth_of = |with_target| {
            if moves {
                Growth::moving(decay_length_cells, cells)
            } else {
                Growth::still(decay_length_cells, cells, core_depth, with_target)
            }
        };
        *growth = growth_of(false);
        let with_target = growth_of(true);
        if let Some((known, shift)) = calibrate(with_target, wanted).filter(|_| thickness >= MIRROR_DEPTH * dx) {
            *growth = with_target;
            *shrink = shift * dx;
            *target = Some(WallTarget { cell: dx, inertia: known.inertia * dx / nu, largest: *rate, ..known });
        }
        profile
    }

    /// Return the wall target that acts at signed distance `d` (m), if any.
    pub fn target(&self, d: f64) -> Option<&WallTarget> {
        match self {
            Self::LogLinear { target, .. } => target.as_ref().filter(|target| target.reaches(d)),
            _ => None,
        }
    }

    /// Return the penalization rate at signed distance `d` (m, positive in the fluid), 1/s.
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
            Self::LogLinear { rate, unit, growth, cell, shrink, .. } => {
                (unit * growth.drag(-(d + shrink) / cell)).min(rate)
            }
        }
    }

    /// Return the distance from the surface beyond which there is no drag, m.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Sharp { offset, .. } => offset,
            Self::Cosine { half_width, shift, .. } => (half_width - shift).max(0.0),
            Self::LogLinear { growth, cell, .. } => method::TAIL * growth.decay_length_cells * cell,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use method::WallCorrection;

    #[test]
    fn masks_know_how_far_they_drag_the_fluid() {
        let (nu, dx, c_eta) = (1e-3, 4e-3, 1e-3);
        let cosine = |half_width, displacement_corrected| Mask::Cosine { c_eta, half_width, displacement_corrected };
        let sharp = |displacement_corrected| Mask::Sharp { c_eta, displacement_corrected };
        let masks = [sharp(true), sharp(false), cosine(0.2, true), cosine(2.0, true), cosine(2.0, false)];
        for mask in masks.into_iter().chain([Mask::log_linear(c_eta)]) {
            let (known, profile) = (mask.reach(nu, dx), DragProfile::of_body(6.0 * dx, true, &mask, nu, dx));
            assert!((profile.reach() - known).abs() < 1e-15, "{mask:?}: {} beside {known} m", profile.reach());
            let [inside, outside] = [-1e-3, 1e-3].map(|cells| profile.rate(known + cells * dx));
            let is_tail = matches!(mask, Mask::LogLinear { .. });
            assert!(inside > 0.0 && (is_tail || outside == 0.0), "{mask:?}: {inside} and {outside} 1/s");
        }
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
            &Mask::LogLinear {
                c_eta: 1e-7,
                decay_length_cells: 0.3,
                core_depth: None,
                wall_correction: WallCorrection::None,
            },
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
}
