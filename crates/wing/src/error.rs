//! Errors of the wing.

/// Reason why a wing cannot be built, loaded, restored or stepped.
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
    /// The length of an array does not match the number of nodes or triangles.
    #[error("{name} has {length} entries, but {expected} are needed")]
    Length {
        /// Name of the array.
        name: String,
        /// Length of the array.
        length: usize,
        /// Required length.
        expected: usize,
    },
    /// An edge belongs to more than two triangles, or to two that run in the same direction.
    #[error(
        "the edge between nodes {} and {} belongs to {triangles} triangles in the direction of triangle {triangle}, \
         but it must belong to one: the triangles of a surface have the same sense of rotation", nodes[0], nodes[1]
    )]
    Edge {
        /// Ends of the edge.
        nodes: [usize; 2],
        /// Number of triangles in this direction.
        triangles: usize,
        /// Last of the triangles.
        triangle: usize,
    },
    /// Newton's method does not converge, even in the smallest sub-step.
    #[error(
        "Newton's method stopped at a residual of {residual:.3e} N, above {tolerance:.3e} N, after {iterations} \
         iterations"
    )]
    NotConverged {
        /// Largest component of the residual, N.
        residual: f64,
        /// Tolerance of the residual, N.
        tolerance: f64,
        /// Iterations of all attempts.
        iterations: usize,
    },
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
    /// The matrix of the wing is singular: a part of it is not held, or it buckles.
    #[error("the stiffness of the wing is singular: a part of it is not held, or it buckles under its loads")]
    Singular,
}

impl Error {
    pub(crate) fn value(name: impl Into<String>, value: impl std::fmt::Debug, allowed: &'static str) -> Self {
        Self::Value { name: name.into(), value: format!("{value:?}"), allowed }
    }
}
