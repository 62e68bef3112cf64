//! The versions of the standard that a library speaks.

/// Version of the standard that a master uses, and a description is written for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Version {
    /// 2.0: an array is as many scalar variables, with value references in a row.
    Fmi2,
    /// 3.0: an array is one variable. Its value reference is that of its first element in 2.0.
    Fmi3,
}
