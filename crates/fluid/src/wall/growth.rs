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

/// Growth, as an exponent, that the drag above a deep core stays at: 61 ν/dx², which the grid resolves. Held harder where
/// it is drawn to what a wall target asks for, the fluid makes waves that the grid does not, and forces go with C_eta.
const PLATEAU: f64 = 2.5;

/// Growth, as an exponent, that a body's drag reaches in the depth where it has cells wherever the grid lies. A bar of
/// two or three cells would be porous without it: the pressure on a flapping bar is ten times that of its stream.
const TIGHT: f64 = 7.0;

/// Where a deep core begins at the latest, as a share of the body's thickness. The jump of the pressure across a body drives
/// fluid through it at the speed of the jump over the density and the integral of the drag, and the soft part counts for
/// little in that (docs/driven-bar.md).
const SOFT_SHARE: f64 = 0.2;

/// Growth of the log-linear drag with the depth: exponential, and steeper in the core of a body.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// Length of e-fold growth, cells.
    pub e_fold: f64,
    /// e-folds below the surface at which the core begins.
    core: f64,
    /// e-folds below the surface from which the drag stays as it is up to the core.
    plateau: f64,
}

impl Growth {
    /// In a body of some thickness without a wall target, whose core begins at a depth or where it does by default; all
    /// in cells.
    pub fn bare(e_fold: f64, thickness: f64, core_depth: Option<f64>) -> Self {
        Self::new(e_fold, thickness, core_depth, CORE, f64::INFINITY)
    }

    /// The same with a wall target.
    pub fn with_target(e_fold: f64, thickness: f64, core_depth: Option<f64>) -> Self {
        Self::new(e_fold, thickness, core_depth, CORE_WITH_TARGET, PLATEAU)
    }

    /// With a core that is `usual` e-folds deep where no depth is given.
    fn new(e_fold: f64, thickness: f64, core_depth: Option<f64>, usual: f64, plateau: f64) -> Self {
        let deepest = core_depth.map_or(usual, |depth| depth.min(SOFT_SHARE * thickness) / e_fold);
        let everywhere = 0.5 * (thickness - 1.0) / e_fold;
        let above_plateau = everywhere - (TIGHT - everywhere) / (STEEPNESS - 1.0);
        let below_plateau = everywhere - (TIGHT - plateau) / STEEPNESS;
        Self { e_fold, core: above_plateau.min(below_plateau).clamp(0.0, deepest), plateau }
    }

    /// Drag in ν/dx² at a depth (cells). At the surface it is what makes the flow vanish there in linear shear.
    pub fn drag(&self, depth: f64) -> f64 {
        let folds = depth / self.e_fold;
        let held_back = (folds.min(self.core) - self.plateau).max(0.0);
        let growth = folds - held_back + (STEEPNESS - 1.0) * (folds - self.core).max(0.0);
        (growth - 2.0 * EULER_GAMMA).exp() / (self.e_fold * self.e_fold)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Above a deep core the drag stays where the grid resolves it; a thin body has a hard core all the same, and without
    /// a depth the core is where it was.
    #[test]
    fn the_drag_waits_for_a_deep_core() {
        let exponent = |growth: &Growth, depth: f64| (growth.drag(depth) / growth.drag(0.0)).ln();
        let deep = Growth::with_target(0.25, f64::INFINITY, Some(2.0));
        for (depth, expected) in [(0.5, 2.0), (0.7, PLATEAU), (1.99, PLATEAU), (2.25, PLATEAU + 3.0)] {
            assert!((exponent(&deep, depth) - expected).abs() < 1e-12, "{} at {depth}", exponent(&deep, depth));
        }
        for thickness in [2.2, 2.5, 3.0, 4.0, 5.0] {
            let thin = Growth::with_target(0.25, thickness, Some(2.0));
            let tight = exponent(&thin, 0.5 * (thickness - 1.0));
            assert!(tight > TIGHT - 1e-9, "{tight} in a body of {thickness} cells");
        }
        let bar = Growth::with_target(0.25, 5.0, Some(2.0));
        for (depth, expected) in [(0.99, PLATEAU), (1.25, PLATEAU + 3.0)] {
            assert!((exponent(&bar, depth) - expected).abs() < 1e-12, "{} at {depth} in a bar", exponent(&bar, depth));
        }
        let usual = Growth::with_target(0.25, f64::INFINITY, None);
        assert!((exponent(&usual, 0.475) - 2.7).abs() < 1e-12, "{}", exponent(&usual, 0.475));
    }
}
