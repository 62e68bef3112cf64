//! Errors of the rod.

use crate::model::Scheme;

/// Largest rise of energy under constant loads, relative to the largest energy, with the trapezoid and generalised-α.
pub(crate) const LARGEST_GAIN: f64 = 0.01;

/// Reason why a rod cannot be built, loaded, restored or stepped.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A value lies outside its range.
    #[error("{name} is {value}, but it must be {allowed}")]
    Value {
        /// Name of the variable.
        name: String,
        /// Value, as text.
        value: String,
        /// Allowed values, as the end of the sentence "but it must be …".
        allowed: &'static str,
    },
    /// The length of an array does not match the number of nodes or segments.
    #[error("{name} has {length} entries, but {expected} are needed")]
    Length {
        /// Name of the array.
        name: String,
        /// Length of the array.
        length: usize,
        /// Required length.
        expected: usize,
    },
    /// The displaced fluid weighs more than the section.
    #[error(
        "the section weighs {line_density} kg/m and displaces {displaced} kg/m of fluid, but the difference, {} kg/m, \
         must not be negative", line_density - displaced
    )]
    NegativeMass {
        /// Mass per length of the section, kg/m.
        line_density: f64,
        /// Mass per length of the displaced fluid, kg/m.
        displaced: f64,
    },
    /// Newton's method does not converge, even in the smallest sub-step.
    #[error(
        "Newton's method stopped at a residual of {residual:.3e} N, above {tolerance:.3e} N, after {iterations} \
         iterations; rounding alone may leave {rounding:.3e} N"
    )]
    NotConverged {
        /// Largest component of the residual, N.
        residual: f64,
        /// Tolerance of the residual, N.
        tolerance: f64,
        /// Bound of the rounding error, N.
        rounding: f64,
        /// Iterations of all attempts.
        iterations: usize,
    },
    /// The trapezoid or generalised-α gains energy under constant forces, even in the smallest sub-step.
    #[error(
        "{} gains energy: under constant forces the energy of the rod less their work must not rise by more than \
         {:.3e} J (1 % of the largest kinetic or elastic energy), but it rises from {reference:.6e} J to \
         {energy:.6e} J, even in sub-steps of {dt:.3e} s; tr_bdf2 does not gain energy, {}a smaller step may help",
        name(scheme), LARGEST_GAIN * largest, if *scheme == Scheme::Trapezoid { "" } else { "a smaller rho_inf or " }
    )]
    EnergyGain {
        /// The scheme.
        scheme: Scheme,
        /// Limit of the energy less the work of the loads, J: [`crate::State::reference_energy`].
        reference: f64,
        /// Energy less the work of the loads at the end of the failed sub-step, J.
        energy: f64,
        /// Largest kinetic or elastic energy since the loads changed, J.
        largest: f64,
        /// Length of the failed sub-step, s.
        dt: f64,
    },
    /// The rod folds back on itself.
    #[error(
        "the rod folds back at node {node}: |e1||e2| + e1·e2 of the edges that meet there must be above {limit:.3e} m²"
    )]
    FoldBack {
        /// Node between the two edges.
        node: usize,
        /// Limit of |e1||e2| + e1·e2, m².
        limit: f64,
    },
    /// The projected bending model is singular in this shape.
    #[error(
        "the projected bending angle in the plane x{axis} is singular at node {node}: the projection of a segment \
         there vanishes or turns by more than a right angle; invariant bending has no such limit"
    )]
    Projection {
        /// Node between the two segments.
        node: usize,
        /// Second axis of the plane.
        axis: char,
    },
}

/// Return the name of a scheme with an energy guard.
fn name(scheme: &Scheme) -> String {
    match scheme {
        Scheme::GeneralisedAlpha { rho_inf } => format!("generalised_alpha with rho_inf = {rho_inf}"),
        Scheme::Trapezoid | Scheme::TrBdf2 | Scheme::Bdf2 => "trapezoid".into(),
    }
}

impl Error {
    pub(crate) fn value(name: impl Into<String>, value: impl Shown, allowed: &'static str) -> Self {
        Self::Value { name: name.into(), value: value.shown(), allowed }
    }
}

/// Value in a message.
pub(crate) trait Shown {
    fn shown(&self) -> String;
}

impl Shown for f64 {
    fn shown(&self) -> String {
        format!("{self:.3e}")
    }
}

impl Shown for &[f64] {
    fn shown(&self) -> String {
        let numbers: Vec<_> = self.iter().map(Shown::shown).collect();
        format!("[{}]", numbers.join(", "))
    }
}

impl Shown for usize {
    fn shown(&self) -> String {
        self.to_string()
    }
}

impl Shown for String {
    fn shown(&self) -> String {
        self.clone()
    }
}
