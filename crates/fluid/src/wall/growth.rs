//! How the log-linear drag grows below the surface: shared by the profile and the calibration of its wall target.

/// Euler's constant γ.
pub const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Depth in e-folds from which on the log-linear profile is steeper, and the factor. In linear shear the flow there has
/// fallen to 0.7 % of λ times the shear, so the fluid outside hardly sees it, and the calibration includes what it
/// sees; but a bar of two or three cells would be porous without it.
const CORE: f64 = 3.0;
const CORE_STEEPNESS: f64 = 3.0;

/// Growth of the log-linear drag from the surface to some e-folds below it.
pub fn growth(folds: f64) -> f64 {
    (folds + (CORE_STEEPNESS - 1.0) * (folds - CORE).max(0.0)).exp()
}
