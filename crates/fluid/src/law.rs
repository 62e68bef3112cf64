//! Laws of time.

use std::fmt;
use std::sync::Arc;

/// A function of time (s) with its rate.
#[derive(Clone)]
pub struct Law(Arc<dyn Fn(f64) -> (f64, f64) + Send + Sync>);

impl Law {
    /// A law from its value and its rate (1/s) at a time (s).
    pub fn new(value_and_rate: impl Fn(f64) -> (f64, f64) + Send + Sync + 'static) -> Self {
        Self(Arc::new(value_and_rate))
    }

    /// A constant value.
    pub fn constant(value: f64) -> Self {
        Self::new(move |_| (value, 0.0))
    }

    /// Return the value at a time (s).
    pub fn value(&self, t: f64) -> f64 {
        self.value_and_rate(t).0
    }

    /// Return the value and its rate (1/s) at a time (s).
    pub fn value_and_rate(&self, t: f64) -> (f64, f64) {
        (self.0)(t)
    }
}

impl fmt::Debug for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Law")
    }
}
