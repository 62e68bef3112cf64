//! Checks of numbers.

use ::contact::Law;

use crate::Error;

/// Refuse a number that is not finite or not above 0.
pub fn positive<F>(name: impl Into<String>, value: f64) -> Result<(), Error<F>> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(Error::value(name, value, "a finite number above 0")),
    }
}

/// Refuse a number that is not finite or below 0.
pub fn not_negative<F>(name: impl Into<String>, value: f64) -> Result<(), Error<F>> {
    match value.is_finite() && value >= 0.0 {
        true => Ok(()),
        false => Err(Error::value(name, value, "a finite number of at least 0")),
    }
}

/// Refuse a vector with a number that is not finite.
pub fn finite<F>(name: &str, vector: &[f64]) -> Result<(), Error<F>> {
    match vector.iter().all(|number| number.is_finite()) {
        true => Ok(()),
        false => Err(Error::value(name, vector, "finite")),
    }
}

/// Refuse a law of contact with a number outside its range.
pub fn check_law<F>(law: &Law) -> Result<(), Error<F>> {
    let Law { range, stiffness, depth, damping, friction, .. } = *law;
    positive("contact.range", range)?;
    positive("contact.stiffness", stiffness)?;
    positive("contact.depth", depth)?;
    not_negative("contact.damping", damping)?;
    not_negative("contact.friction", friction)
}
