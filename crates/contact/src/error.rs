//! Why contact fails.

/// Reason why a step of a rod or a wing in contact fails.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub enum ContactError {
    /// Surfaces overlap too far.
    #[error(
        "what it touches overlaps it by {depth:.3e} m near node {node}, but less than {allowed:.3e} m are allowed; a \
         smaller step helps, or another place at the start"
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
    #[error("it passes through what it touches near node {node} in the smallest sub-step; a smaller step helps")]
    Through {
        /// Node beside the place.
        node: usize,
    },
    /// A sub-step may have missed a contact of the structure with itself.
    #[error(
        "a node moves by {moved:.3e} m in the smallest sub-step, but contact with itself was sought for at most \
         {allowed:.3e} m; a smaller step helps"
    )]
    Hasty {
        /// Largest motion of a node, m.
        moved: f64,
        /// Motion allowed for, m.
        allowed: f64,
    },
    /// Too many parts of the structure meet.
    #[error(
        "near node {node} it may touch {found} parts of itself, but at most {most} are allowed; a smaller \
         contact.range helps, or a smaller step"
    )]
    Crowded {
        /// Node beside the place.
        node: usize,
        /// Number of parts.
        found: usize,
        /// Largest number.
        most: usize,
    },
}

/// Reason why contact of rigid bodies fails, with their names.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BodyError {
    /// Two shapes whose contact is not known.
    #[error(
        "{} and {} cannot touch: in the plane a circle, rectangle or capsule touches all of them and walls, in space a \
         sphere, capsule, cuboid or cylinder does, but a cylinder without ends no wall and no other one", .0[0], .0[1]
    )]
    Touch([String; 2]),
    /// Two bodies that are too deep in each other: half a thickness, in space of edges 0.4 of the range.
    #[error(
        "{} and {} are deeper in each other at t = {time:.6e} s than half a thickness, or edges than 0.4 `contact.range`: \
         begin apart, or drive them less far", bodies[0], bodies[1]
    )]
    Deep {
        /// End of the step, s.
        time: f64,
        /// Their names.
        bodies: [String; 2],
    },
}

impl BodyError {
    /// Return the names of two parts: those of `names`, and walls behind them.
    pub fn names(pair: [usize; 2], names: impl IntoIterator<Item = impl AsRef<str>> + Clone) -> [String; 2] {
        let name = |part| names.clone().into_iter().nth(part).map(|name| name.as_ref().to_string());
        pair.map(|part| name(part).unwrap_or_else(|| "a wall".into()))
    }
}
