//! Errors of a structure.

use std::fmt::Display;

/// Reason why a structure cannot be built, loaded, restored or stepped; `F` has the reasons that only its kind has.
#[derive(Debug, thiserror::Error)]
pub enum Error<F> {
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
    /// The length of an array does not match the number of nodes or elements.
    #[error("{name} has {length} entries, but {expected} are needed")]
    Length {
        /// Name of the array.
        name: String,
        /// Length of the array.
        length: usize,
        /// Required length.
        expected: usize,
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
    /// The elastic forces of the structure fail.
    #[error(transparent)]
    Structure(#[from] F),
}

impl<F> Error<F> {
    /// Return the error of the `value` of the variable `name`; `allowed` ends the sentence "but it must be …".
    pub fn value(name: impl Into<String>, value: impl Shown, allowed: &'static str) -> Self {
        Self::Value { name: name.into(), value: value.shown(), allowed }
    }

    /// Refuse an array of a wrong length.
    pub fn check_length(name: impl Display, length: usize, expected: usize) -> Result<(), Self> {
        if length == expected { Ok(()) } else { Err(Self::Length { name: name.to_string(), length, expected }) }
    }
}

/// Value in a message.
pub trait Shown {
    /// Return the value as text.
    fn shown(&self) -> String;
}

impl Shown for f64 {
    fn shown(&self) -> String {
        format!("{self:.3e}")
    }
}

impl Shown for usize {
    fn shown(&self) -> String {
        self.to_string()
    }
}

impl<T: Shown> Shown for &[T] {
    fn shown(&self) -> String {
        let numbers: Vec<_> = self.iter().map(Shown::shown).collect();
        format!("[{}]", numbers.join(", "))
    }
}

impl Shown for &str {
    fn shown(&self) -> String {
        (*self).into()
    }
}

impl Shown for String {
    fn shown(&self) -> String {
        self.clone()
    }
}
