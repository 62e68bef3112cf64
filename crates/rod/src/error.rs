//! Errors of the rod.

use scene::RodScheme;

/// Largest rise of energy under constant loads, by the largest energy, with the trapezoid and generalised-α.
pub(crate) const LARGEST_GAIN: f64 = 0.01;

/// Why a rod could not be built, loaded, restored or stepped.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A value that no rod can work with.
    #[error("{name} is {value}, but it must be {allowed}")]
    Value {
        /// Name of the variable.
        name: String,
        /// The value that was found.
        value: String,
        /// What would be allowed, as the end of the sentence "but it must be …".
        allowed: &'static str,
    },
    /// An array that does not fit the nodes.
    #[error("{name} has {length} entries, but {expected} are needed")]
    Length {
        /// Name of the array.
        name: String,
        /// Its length.
        length: usize,
        /// The length it must have.
        expected: usize,
    },
    /// More fluid is displaced than the section weighs.
    #[error(
        "the section weighs {line_density} kg/m and displaces {displaced} kg/m of fluid, but the mass left to the rod \
         under this load, {} kg/m, must not be negative", line_density - displaced
    )]
    NegativeMass {
        /// Mass per length of the section, kg/m.
        line_density: f64,
        /// Mass per length of the displaced fluid, kg/m.
        displaced: f64,
    },
    /// The scene has no rod of this dimension.
    #[error("the scene {scene:?} has no {dimension}-dimensional beam with a rod")]
    NoRod {
        /// Name of the scene.
        scene: String,
        /// The dimension asked for.
        dimension: usize,
    },
    /// Newton's method gave up, also with smaller sub-steps.
    #[error(
        "Newton's method stopped at a residual of {residual:.3e} N, above {tolerance:.3e} N, after {iterations} iterations; \
         rounding alone may leave {rounding:.3e} N"
    )]
    NotConverged {
        /// Largest component of the residual, N.
        residual: f64,
        /// Its tolerance, N.
        tolerance: f64,
        /// What the rounding of the positions may leave of it, N.
        rounding: f64,
        /// Iterations of all attempts.
        iterations: usize,
    },
    /// The trapezoid or generalised-α gains energy from nothing, also with smaller sub-steps.
    #[error(
        "{} gains energy: while only constant forces work on the rod, its energy less their work must not rise by more than \
         {:.3e} J (1 % of the largest kinetic or elastic energy), but it would from {reference:.6e} J to {energy:.6e} J, also in \
         sub-steps of {dt:.3e} s; tr_bdf2 does not gain, {}a smaller step may help",
        name(scheme), LARGEST_GAIN * largest, if *scheme == RodScheme::Trapezoid { "" } else { "a smaller rho_inf or " }
    )]
    EnergyGain {
        /// The scheme.
        scheme: RodScheme,
        /// Energy less the work of the loads that it must not rise above, J: [`crate::State::reference_energy`].
        reference: f64,
        /// The same at the end of the sub-step that failed, J.
        energy: f64,
        /// Largest kinetic or elastic energy since then, J.
        largest: f64,
        /// Length of that sub-step, s.
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
    /// Nothing to differentiate.
    #[error(
        "sensitivities are those of a step taken in one piece with a regular tangent, but the last one took {substeps} \
         sub-steps (0 where there was none since the start or since a state was put back)"
    )]
    NoSensitivity {
        /// Sub-steps of the last step.
        substeps: usize,
    },
    /// The projected bending model is singular in this shape.
    #[error(
        "the projected bending angle in the plane x{axis} is singular at node {node}: the projection of a segment there \
         vanishes or turns by more than a right angle; the invariant bending model has no such limit"
    )]
    Projection {
        /// Node between the two segments.
        node: usize,
        /// The plane's other axis.
        axis: char,
    },
}

/// A scheme with an energy guard as scenes name it.
fn name(scheme: &RodScheme) -> String {
    match scheme {
        RodScheme::GeneralisedAlpha { rho_inf } => format!("generalised_alpha with rho_inf = {rho_inf}"),
        RodScheme::Trapezoid | RodScheme::TrBdf2 | RodScheme::Bdf2 => "trapezoid".into(),
    }
}

impl Error {
    pub(crate) fn value(name: impl Into<String>, value: impl Shown, allowed: &'static str) -> Self {
        Self::Value { name: name.into(), value: value.shown(), allowed }
    }
}

/// A value as messages show it.
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
