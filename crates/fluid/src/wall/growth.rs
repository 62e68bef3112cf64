//! How the log-linear drag grows below the surface: shared by the profile and the calibration of its wall target.

/// Euler's constant γ.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// How much steeper than the log-linear growth the core is.
const STEEPNESS: f64 = 3.0;

/// Depth of the core below a wall without a target, e-folds. The flow along it has fallen to 0.7 % of λ times its shear
/// there, and the calibration of the surface holds as it is.
const CORE: f64 = 3.0;

/// The same below a wall with a target, whose calibration takes the core into account. A cylinder or a bar is porous
/// under the pressure of a fast flow where it lies deeper.
const CORE_WITH_TARGET: f64 = 1.5;

/// Growth, as an exponent, that a body's drag reaches in the depth where it has cells wherever the grid lies. A bar of
/// two or three cells would be porous without it: the pressure on a flapping bar is ten times that of its stream.
const TIGHT: f64 = 7.0;

/// Growth of the log-linear drag with the depth: exponential, and steeper in the core of a body.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// Length of e-fold growth, cells.
    pub e_fold: f64,
    /// e-folds below the surface at which the core begins.
    core: f64,
}

impl Growth {
    /// In a body of some thickness without a wall target, all in cells.
    pub fn bare(e_fold: f64, thickness: f64) -> Self {
        Self::new(e_fold, thickness, CORE)
    }

    /// The same with a wall target.
    pub fn with_target(e_fold: f64, thickness: f64) -> Self {
        Self::new(e_fold, thickness, CORE_WITH_TARGET)
    }

    /// With the core at most so many e-folds deep.
    fn new(e_fold: f64, thickness: f64, deepest: f64) -> Self {
        let everywhere = 0.5 * (thickness - 1.0) / e_fold;
        let core = everywhere - (TIGHT - everywhere) / (STEEPNESS - 1.0);
        Self { e_fold, core: core.clamp(0.0, deepest) }
    }

    /// Drag in ν/dx² at a depth (cells). At the surface it is what makes the flow vanish there in linear shear.
    pub fn drag(&self, depth: f64) -> f64 {
        let folds = depth / self.e_fold;
        let growth = folds + (STEEPNESS - 1.0) * (folds - self.core).max(0.0);
        (growth - 2.0 * EULER_GAMMA).exp() / (self.e_fold * self.e_fold)
    }
}
