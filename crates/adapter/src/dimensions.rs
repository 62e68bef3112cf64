//! Something of the plane or of space.

use serde::{Deserialize, Serialize};

/// Something of two or three dimensions.
#[derive(Clone, Serialize, Deserialize)]
pub enum Dimensions<P, S> {
    /// In the plane.
    Plane(P),
    /// In space.
    Space(S),
}

impl<P, S> Dimensions<P, S> {
    /// Return the number of dimensions.
    pub fn count(&self) -> usize {
        if matches!(self, Self::Plane(_)) { 2 } else { 3 }
    }
}

/// Evaluate one expression for something of either number of dimensions.
#[macro_export]
macro_rules! either {
    ($of:expr, $own:ident => $value:expr) => {
        match $of {
            $crate::Dimensions::Plane($own) => $value,
            $crate::Dimensions::Space($own) => $value,
        }
    };
}

/// Evaluate one expression for something, and return the value with as many dimensions.
#[macro_export]
macro_rules! of_both {
    ($of:expr, $own:ident => $value:expr) => {
        match $of {
            $crate::Dimensions::Plane($own) => $crate::Dimensions::Plane($value),
            $crate::Dimensions::Space($own) => $crate::Dimensions::Space($value),
        }
    };
}

/// Restore a state of as many dimensions.
#[macro_export]
macro_rules! restore {
    ($of:expr, $state:expr, $own:ident => $solver:expr) => {
        match ($of, $state) {
            ($crate::Dimensions::Plane($own), $crate::Dimensions::Plane(state)) => {
                $solver.restore(state).map_err(|e| e.to_string())
            }
            ($crate::Dimensions::Space($own), $crate::Dimensions::Space(state)) => {
                $solver.restore(state).map_err(|e| e.to_string())
            }
            _ => Err("it is the state of a unit with another number of dimensions".to_string()),
        }
    };
}
