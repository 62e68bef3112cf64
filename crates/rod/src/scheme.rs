//! Time schemes as maps from the displacement of a step to velocity and acceleration.
//!
//! With u = x^{n+1} − x^n the unknown, every scheme has
//!
//! ```text
//! v^{n+1} = c_v u + v*,      a^{n+1} = c_a u + a*,
//! m [(1 − α_m) a^{n+1} + α_m a^n] = (1 − α_f) F^{n+1} + α_f F^n,
//! ```
//!
//! F being the net force.
//!
//! | scheme | maps | α_m, α_f |
//! |---|---|---|
//! | trapezoid | Newmark, β = 1/4, γ = 1/2 | 0, 0 |
//! | generalised-α | Newmark, γ = 1/2 − α_m + α_f, β = (1 − α_m + α_f)²/4 | (2ρ − 1)/(ρ + 1), ρ/(ρ + 1) |
//! | BDF2 | v = 𝒟x, a = 𝒟v, 𝒟 the two-step difference for unequal steps | 0, 0 |
//!
//! Generalised-α is that of Chung & Hulbert (1993, J. Appl. Mech. 60, 371); ρ is the spectral radius at infinite
//! frequency. It blends the forces of the two ends, not their positions, so that the shape which the elastic energy
//! sees is that at the end of the step.
//!
//! The trapezoid does not damp axial waves that the step leaves unresolved: with the bar of CSM3 in 32 segments, each an
//! axial spring k_e on a mass m, it held for 60 s at dt √(k_e/m) = 75 and gained energy from 370 on. Generalised-α with
//! ρ = 0.5 and 0.8 and BDF2 lost energy up to 1.5e5, the stiffest tried.
//!
//! BDF2 takes its first step by backward Euler, whose local error is of second order, and does so again after a step
//! that is more than [`LARGEST_RATIO`] times as long as the one before.

use scene::RodScheme;

use crate::elastic::Vector;
use crate::state::State;

/// Two-step differences with variable steps are zero-stable up to a ratio of 1 + √2 between neighbouring steps.
const LARGEST_RATIO: f64 = 2.4;

/// The maps of one step.
pub(crate) struct StepRule {
    /// dv/du, 1/s.
    pub(crate) c_v: f64,
    /// da/du, 1/s².
    pub(crate) c_a: f64,
    /// Weight of the old acceleration.
    pub(crate) alpha_m: f64,
    /// Weight of the old force.
    pub(crate) alpha_f: f64,
    dt: f64,
    history: History,
}

/// How the levels before the step enter.
enum History {
    /// v and a of the old level.
    Newmark { beta: f64, gamma: f64 },
    /// 𝒟y = [b_0 (y^{n+1} − y^n) − b_2 (y^n − y^{n−1})] / dt.
    Differences { b_0: f64, b_2: f64 },
}

impl StepRule {
    /// Rule for a step of `dt` after one of `last_step`, s; 0 for the first.
    pub(crate) fn new(scheme: RodScheme, dt: f64, last_step: f64) -> Self {
        match scheme {
            RodScheme::Trapezoid => Self::newmark(0.0, 0.0, dt),
            RodScheme::GeneralisedAlpha { rho_inf } => {
                Self::newmark((2.0 * rho_inf - 1.0) / (rho_inf + 1.0), rho_inf / (rho_inf + 1.0), dt)
            }
            RodScheme::Bdf2 => {
                let (b_0, b_2) = if dt <= LARGEST_RATIO * last_step {
                    let ratio = dt / last_step;
                    ((1.0 + 2.0 * ratio) / (1.0 + ratio), ratio * ratio / (1.0 + ratio))
                } else {
                    (1.0, 0.0)
                };
                let c_v = b_0 / dt;
                let history = History::Differences { b_0, b_2 };
                Self { c_v, c_a: c_v * c_v, alpha_m: 0.0, alpha_f: 0.0, dt, history }
            }
        }
    }

    /// Newmark's maps with the β and γ that make the blend by `alpha_m`, `alpha_f` second order and dissipative.
    fn newmark(alpha_m: f64, alpha_f: f64, dt: f64) -> Self {
        let gamma = 0.5 - alpha_m + alpha_f;
        let beta = 0.25 * (1.0 - alpha_m + alpha_f).powi(2);
        let (c_v, c_a) = (gamma / (beta * dt), 1.0 / (beta * dt * dt));
        Self { c_v, c_a, alpha_m, alpha_f, dt, history: History::Newmark { beta, gamma } }
    }

    /// Velocity v* and acceleration a* that node `k` ends the step with if it does not move, u = 0.
    pub(crate) fn at_no_displacement<const D: usize>(&self, state: &State<D>, k: usize) -> (Vector<D>, Vector<D>) {
        let (v, a) = (state.velocities[k], state.accelerations[k]);
        match self.history {
            History::Newmark { beta, gamma } => (
                v * (1.0 - gamma / beta) + a * (self.dt * (1.0 - 0.5 * gamma / beta)),
                v / (-beta * self.dt) + a * (1.0 - 0.5 / beta),
            ),
            History::Differences { b_0, b_2 } => {
                let v_star = (state.positions[k] - state.previous_positions[k]) * (-b_2 / self.dt);
                let old_difference = (v - state.previous_velocities[k]) * (b_2 / self.dt);
                (v_star, (v_star - v) * (b_0 / self.dt) - old_difference)
            }
        }
    }
}
