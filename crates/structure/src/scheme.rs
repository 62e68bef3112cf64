//! Time schemes as maps from the displacement of a step to velocity and acceleration.
//!
//! With the unknown u = x^{n+1} − x^n and the net force F, each scheme has
//!
//! ```text
//! v^{n+1} = c_v u + v*,      a^{n+1} = c_a u + a*,
//! m [(1 − α_m) a^{n+1} + α_m a^n] = (1 − α_f) F^{n+1} + α_f F^n.
//! ```
//!
//! | scheme | maps | α_m, α_f |
//! |---|---|---|
//! | trapezoid | Newmark, β = 1/4, γ = 1/2 | 0, 0 |
//! | generalised-α | Newmark, γ = 1/2 − α_m + α_f, β = (1 − α_m + α_f)²/4 | (2ρ − 1)/(ρ + 1), ρ/(ρ + 1) |
//! | BDF2 | v = 𝒟x, a = 𝒟v, with 𝒟 the two-step difference for unequal steps | 0, 0 |
//! | TR-BDF2 | trapezoid to γ = 2 − √2 of the step, BDF2 over the rest | 0, 0 |
//!
//! TR-BDF2 follows Bank et al. (1985, IEEE Trans. Electron Devices 32, 1992). Its γ gives both stages the same c_v
//! (Hosea & Shampine 1996, Appl. Numer. Math. 20, 21).
//!
//! Generalised-α follows Chung & Hulbert (1993, J. Appl. Mech. 60, 371), and ρ is the spectral radius at infinite
//! frequency. The scheme blends the forces of both ends of the step, so the elastic energy is always the energy of a
//! shape at the end of a step.
//!
//! The trapezoid does not damp axial waves that the step leaves unresolved. The bar of CSM3 in 32 segments, with axial
//! springs k_e and masses m, ran for 60 s at dt √(k_e/m) = 75 and gained energy from 370 on. Generalised-α with ρ = 0.5
//! and 0.8 and BDF2 lost energy up to 1.5e5, the stiffest case tried. Generalised-α may gain energy where a rod folds.
//! [`crate::Structure::guard`] watches the energy.
//!
//! The first step of BDF2 is backward Euler, with a local error of second order. So is each step more than
//! [`LARGEST_RATIO`] times as long as the step before.

use std::ops::{Add, Mul, Sub};

use method::Scheme;
use serde::{Deserialize, Serialize};

use crate::Error;

/// Largest ratio of neighbouring BDF2 steps; the limit of zero-stability is 1 + √2.
const LARGEST_RATIO: f64 = 2.4;

/// Share of a step in the trapezoidal stage of TR-BDF2.
pub const TRAPEZOID_PART: f64 = 2.0 - std::f64::consts::SQRT_2;

/// Refuse a spectral radius outside its range.
pub fn check_scheme<F>(scheme: Scheme) -> Result<(), Error<F>> {
    match scheme {
        Scheme::GeneralisedAlpha { rho_inf } if !(0.0..=1.0).contains(&rho_inf) => {
            Err(Error::value("scheme.generalised_alpha.rho_inf", rho_inf, "between 0 and 1"))
        }
        _ => Ok(()),
    }
}

/// Motion of one unknown at the beginning of a step: a position, m, or an angle, rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motion<V> {
    /// Position.
    pub x: V,
    /// Velocity.
    pub v: V,
    /// Acceleration.
    pub a: V,
    /// Position one step earlier (BDF2).
    pub previous_x: V,
    /// Velocity one step earlier (BDF2).
    pub previous_v: V,
}

/// Maps of one step or stage.
#[derive(Clone, Copy)]
pub struct StepRule {
    /// dv/du, 1/s.
    pub c_v: f64,
    /// da/du, 1/s².
    pub c_a: f64,
    /// Weight of the new acceleration, 1 − α_m.
    pub new_mass: f64,
    /// Weight of the old acceleration, α_m.
    pub old_mass: f64,
    /// Weight of the new force, 1 − α_f.
    pub new_force: f64,
    /// Weight of the old force, α_f.
    pub old_force: f64,
    history: History,
}

/// Contribution of earlier time levels: the factors of v* and a*.
#[derive(Clone, Copy)]
enum History {
    /// v* = v_by_v v + v_by_a a, a* = a_by_v v + a_by_a a.
    Newmark { v_by_v: f64, v_by_a: f64, a_by_v: f64, a_by_a: f64 },
    /// 𝒟y = new (y^{n+1} − y^n) − old (y^n − y^{n−1}).
    Differences { new: f64, old: f64 },
}

impl StepRule {
    /// Return the trapezoid over `dt`, s.
    pub fn trapezoid(dt: f64) -> Self {
        Self::newmark(0.0, 0.0, dt)
    }

    /// Return generalised-α over `dt`, s.
    pub fn generalised_alpha(rho_inf: f64, dt: f64) -> Self {
        Self::newmark((2.0 * rho_inf - 1.0) / (rho_inf + 1.0), rho_inf / (rho_inf + 1.0), dt)
    }

    /// Return BDF2 over `dt` after a step of `last_step`, s; 0 for the first step.
    pub fn bdf2(dt: f64, last_step: f64) -> Self {
        let (b_0, b_2) = if dt <= LARGEST_RATIO * last_step {
            let ratio = dt / last_step;
            ((1.0 + 2.0 * ratio) / (1.0 + ratio), ratio * ratio / (1.0 + ratio))
        } else {
            (1.0, 0.0)
        };
        let c_v = b_0 / dt;
        let history = History::Differences { new: c_v, old: b_2 / dt };
        Self { c_v, c_a: c_v * c_v, new_mass: 1.0, old_mass: 0.0, new_force: 1.0, old_force: 0.0, history }
    }

    /// Return Newmark's maps with the β and γ that make the blend second order and dissipative.
    fn newmark(alpha_m: f64, alpha_f: f64, dt: f64) -> Self {
        let gamma = 0.5 - alpha_m + alpha_f;
        let beta = 0.25 * (1.0 - alpha_m + alpha_f).powi(2);
        let (c_v, c_a) = (gamma / (beta * dt), 1.0 / (beta * dt * dt));
        Self {
            c_v,
            c_a,
            new_mass: 1.0 - alpha_m,
            old_mass: alpha_m,
            new_force: 1.0 - alpha_f,
            old_force: alpha_f,
            history: History::Newmark {
                v_by_v: 1.0 - gamma / beta,
                v_by_a: dt * (1.0 - 0.5 * gamma / beta),
                a_by_v: -1.0 / (beta * dt),
                a_by_a: 1.0 - 0.5 / beta,
            },
        }
    }

    /// Return the acceleration at the end of a step that ends with the velocity `v`; only of differences.
    #[inline(always)]
    pub(crate) fn acceleration<V>(&self, now: Motion<V>, v: V) -> Option<V>
    where
        V: Copy + Sub<Output = V> + Mul<f64, Output = V>,
    {
        match self.history {
            History::Differences { new, old } => Some((v - now.v) * new - (now.v - now.previous_v) * old),
            History::Newmark { .. } => None,
        }
    }

    /// Return the velocity v* and the acceleration a* at the end of a step without displacement, u = 0.
    #[inline(always)]
    pub fn at_no_displacement<V>(&self, now: Motion<V>) -> (V, V)
    where
        V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f64, Output = V>,
    {
        let Motion { x, v, a, previous_x, previous_v } = now;
        match self.history {
            History::Newmark { v_by_v, v_by_a, a_by_v, a_by_a } => (v * v_by_v + a * v_by_a, v * a_by_v + a * a_by_a),
            History::Differences { new, old } => {
                let v_star = (x - previous_x) * -old;
                (v_star, (v_star - v) * new - (v - previous_v) * old)
            }
        }
    }
}
