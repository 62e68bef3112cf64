//! Checks that name the key, the value and what is allowed.

use std::fmt::Display;

use crate::SceneError;

/// Something in a scene that can be checked under the path of its key.
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

/// `value` must be finite and above `limit`.
pub(crate) fn above(key: &str, value: f64, limit: f64) -> Result<(), SceneError> {
    require(value.is_finite() && value > limit, key, value, || format!("it must be a finite number above {limit}"))
}

/// `value` must be finite and at least `limit`.
pub(crate) fn at_least(key: &str, value: f64, limit: f64) -> Result<(), SceneError> {
    require(value.is_finite() && value >= limit, key, value, || {
        format!("it must be a finite number of at least {limit}")
    })
}

/// `value` must be finite.
pub(crate) fn finite(key: &str, value: f64) -> Result<(), SceneError> {
    require(value.is_finite(), key, value, || "it must be a finite number".into())
}

/// An interval must be finite and have a positive length.
pub(crate) fn interval(key: &str, [low, high]: [f64; 2]) -> Result<(), SceneError> {
    require(low.is_finite() && high.is_finite() && low < high, key, format!("[{low}, {high}]"), || {
        "it must be two finite numbers, the smaller first".into()
    })
}
