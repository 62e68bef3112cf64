//! Errors of the rod.

use structure::Scheme;

/// Largest rise of energy under constant loads, relative to the largest energy, with the trapezoid and generalised-α.
pub(crate) const LARGEST_GAIN: f64 = 0.01;

/// Reason why a rod cannot be built, loaded, restored or stepped.
pub type Error = structure::Error<RodError>;

/// Reason that only a rod has.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum RodError {
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
        /// Limit of the energy less the work of the loads, J: [`crate::RodMemory::reference_energy`].
        reference: f64,
        /// Energy less the work of the loads at the end of the failed sub-step, J.
        energy: f64,
        /// Largest kinetic or elastic energy since the loads changed, J.
        largest: f64,
        /// Length of the failed sub-step, s.
        dt: f64,
    },
    /// Contact fails.
    #[error(transparent)]
    Contact(#[from] contact::ContactError),
    /// The shape has no finite bending energy.
    #[error(transparent)]
    Shape(#[from] BadShape),
}

/// Shape without a finite bending energy.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum BadShape {
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

impl From<BadShape> for Error {
    fn from(shape: BadShape) -> Self {
        RodError::Shape(shape).into()
    }
}

/// Return the name of a scheme with an energy guard.
fn name(scheme: &Scheme) -> String {
    match scheme {
        Scheme::GeneralisedAlpha { rho_inf } => format!("generalised_alpha with rho_inf = {rho_inf}"),
        Scheme::Trapezoid | Scheme::TrBdf2 | Scheme::Bdf2 => "trapezoid".into(),
    }
}
