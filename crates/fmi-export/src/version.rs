//! Versions of the standard.

/// Version of the standard for a master or a model description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Version {
    /// FMI 2.0: each element of an array is a scalar variable; value references are consecutive.
    Fmi2,
    /// FMI 3.0: an array is one variable with the value reference of its first element in FMI 2.0.
    Fmi3,
}
