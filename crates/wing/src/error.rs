//! Errors of the wing.

/// Reason why a wing cannot be built, loaded, restored or stepped.
pub type Error = structure::Error<WingError>;

/// Reason that only a wing has.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum WingError {
    /// Two neighbouring triangles or two segments of a vein fold onto each other, or a triangle loses its area.
    #[error("the wing folds at nodes {} and {}: {what}", nodes[0], nodes[1])]
    Fold {
        /// Nodes of the edge or segment.
        nodes: [usize; 2],
        /// What is wrong, as a sentence.
        what: &'static str,
    },
    /// A wing without a drive gains more energy than its loads put in, even in the smallest sub-step.
    #[error(
        "the wing gains {gain:.3e} J that nothing puts in, of {exchanged:.3e} J that it exchanges in the smallest \
         sub-step; a shorter time.communication_step or stiffer bending helps"
    )]
    Gain {
        /// Gain, J.
        gain: f64,
        /// Kinetic energy before and after, changes of the other energies, and work of the loads, J.
        exchanged: f64,
    },
    /// Contact fails.
    #[error(transparent)]
    Contact(#[from] contact::ContactError),
    /// The matrix of the wing is singular: a part of it is not held, or it buckles.
    #[error("the stiffness of the wing is singular: a part of it is not held, or it buckles under its loads")]
    Singular,
}
