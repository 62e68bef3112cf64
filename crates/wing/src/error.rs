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
    /// Something lies too deep behind the surface of the wing.
    #[error(
        "what the wing touches lies {depth:.3e} m beyond it near node {node}, but the depth must be less than \
         {allowed:.3e} m; a smaller step helps, or another place at the start"
    )]
    Deep {
        /// Node beside the place.
        node: usize,
        /// Depth, m.
        depth: f64,
        /// Depth that no force reaches, m.
        allowed: f64,
    },
    /// A sub-step may have missed a contact.
    #[error("the wing passes through what it touches near node {node} in the smallest sub-step; a smaller step helps")]
    Through {
        /// Node beside the place.
        node: usize,
    },
    /// A sub-step may have missed a contact of the wing with itself.
    #[error(
        "a node moves by {moved:.3e} m in the smallest sub-step, but contact of the wing with itself was sought for at \
         most {allowed:.3e} m; a smaller step helps"
    )]
    Hasty {
        /// Largest motion of a node, m.
        moved: f64,
        /// Motion allowed for, m.
        allowed: f64,
    },
    /// Too many layers of the wing meet.
    #[error(
        "near node {node} the wing may touch {found} layers of itself, but at most {most} are allowed; a smaller \
         contact.range helps, or a smaller step"
    )]
    Crowded {
        /// Node beside the place.
        node: usize,
        /// Number of layers.
        found: usize,
        /// Largest number.
        most: usize,
    },
    /// The matrix of the wing is singular: a part of it is not held, or it buckles.
    #[error("the stiffness of the wing is singular: a part of it is not held, or it buckles under its loads")]
    Singular,
}
