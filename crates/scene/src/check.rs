//! Checks that name the key, the value and what is allowed.

use std::fmt::Display;

use crate::SceneError;

/// Something in a scene whose values are checked against each other, under the path of its key. Types and ranges are
/// those of the schema, and checked before.
pub(crate) trait Check {
    fn check_at(&self, key: &str) -> Result<(), SceneError>;
}

impl<T: Check> Check for Option<T> {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        self.as_ref().map_or(Ok(()), |part| part.check_at(key))
    }
}

impl<T: Check> Check for Vec<T> {
    fn check_at(&self, key: &str) -> Result<(), SceneError> {
        self.iter().enumerate().try_for_each(|(i, part)| part.check_at(&format!("{key}[{i}]")))
    }
}

/// The general check; `allowed` ends the sentence "key is value, but …".
pub(crate) fn require(
    holds: bool,
    key: &str,
    value: impl Display,
    allowed: impl FnOnce() -> String,
) -> Result<(), SceneError> {
    if holds {
        return Ok(());
    }
    Err(SceneError::Value { key: key.into(), value: value.to_string(), allowed: allowed() })
}

/// An interval must have a positive length.
pub(crate) fn interval(key: &str, [low, high]: [f64; 2]) -> Result<(), SceneError> {
    require(low < high, key, format!("[{low}, {high}]"), || "it must be two numbers, the smaller first".into())
}
