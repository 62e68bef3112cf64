//! A warning.

use serde::Serialize;

/// What may be a mistake in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// Path of the key.
    pub key: String,
    /// Time from which it holds, s; absent where it holds from the start.
    pub time: Option<f64>,
    /// The whole as a sentence.
    pub text: String,
}
