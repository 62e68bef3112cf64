//! How the log-linear drag grows below the surface: shared by the profile and the calibration of its wall target.

/// Euler's constant γ.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// How much steeper than the log-linear growth the core of a body is.
const STEEPNESS: f64 = 3.0;

/// Depth of the core below a wall without a target, e-folds. The flow along it has fallen to 0.7 % of λ times its shear
/// there, and the calibration of the surface holds as it is.
const CORE: f64 = 3.0;

/// The same below a wall with a target, whose calibration takes the core into account. A cylinder is porous under the
/// pressure of a fast flow where it lies deeper.
const CORE_WITH_TARGET: f64 = 1.5;

/// Growth, as an exponent, that the drag above a deep core stays at: 61 ν/dx², which the grid resolves. Held harder where
/// it is drawn to what a wall target asks for, the fluid makes waves that the grid does not, and forces go with C_eta.
const PLATEAU: f64 = 2.5;

/// Growth, as an exponent, that a body's drag reaches in the depth where it has cells wherever the grid lies. A bar of
/// two or three cells would be porous without it: the pressure on a flapping bar is ten times that of its stream.
const TIGHT: f64 = 7.0;

/// Where a deep core begins at the latest, as a share of the body's thickness. The jump of the pressure across a body drives
/// fluid through it at the speed of the jump over the density and the integral of the drag, and the soft part counts for
/// little in that (docs/dev/wall-model.md).
const SOFT_SHARE: f64 = 0.2;

/// Growth of the log-linear drag with the depth: exponential, and steeper in the core of a body.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// Length of e-fold growth, cells.
    pub decay_length_cells: f64,
    /// e-folds below the surface at which the core begins.
    core: f64,
    /// e-folds below the surface from which the drag stays as it is up to the core.
    plateau: f64,
}

impl Growth {
    /// Below a wall of the channel or in a zone, without a wall target.
    pub fn wall(decay_length_cells: f64) -> Self {
        Self::still(decay_length_cells, f64::INFINITY, None, false)
    }

    /// In a body of some thickness that stands still, with or without a wall target, whose core begins at a depth or where
    /// it does by default; all in cells.
    pub fn still(decay_length_cells: f64, thickness: f64, core_depth: Option<f64>, with_target: bool) -> Self {
        let (usual, plateau) = if with_target { (CORE_WITH_TARGET, PLATEAU) } else { (CORE, f64::INFINITY) };
        let deepest = core_depth.map_or(usual, |depth| depth.min(SOFT_SHARE * thickness) / decay_length_cells);
        Self::new(decay_length_cells, thickness, deepest, plateau)
    }

    /// In a body of some thickness (cells) that moves, which has no core that it can do without.
    ///
    /// Cells enter the body and leave it. Of what follows the body at the rate s, each holds the share a/(a + s). Over an
    /// exponential a of the decay length λ that is a logistic function, whose sum over the cells ripples with the place of
    /// the grid by `2 π λ/sinh(2 π² λ)` of a cell: 0.02 for a quarter of a cell, 0.2 in a core that is three times as steep.
    /// Forces flicker with a core, wherever it begins (docs/dev/wall-model.md).
    pub fn moving(decay_length_cells: f64, thickness: f64) -> Self {
        Self::new(decay_length_cells, thickness, f64::INFINITY, f64::INFINITY)
    }

    /// With a core that begins at `deepest` (e-folds), or earlier in a thin body.
    fn new(decay_length_cells: f64, thickness: f64, deepest: f64, plateau: f64) -> Self {
        let everywhere = 0.5 * (thickness - 1.0) / decay_length_cells;
        let above_plateau = everywhere - (TIGHT - everywhere) / (STEEPNESS - 1.0);
        let below_plateau = everywhere - (TIGHT - plateau) / STEEPNESS;
        Self { decay_length_cells, core: above_plateau.min(below_plateau).clamp(0.0, deepest), plateau }
    }

    /// Drag in ν/dx² at a depth (cells). At the surface it is what makes the flow vanish there in linear shear.
    pub fn drag(&self, depth: f64) -> f64 {
        let folds = depth / self.decay_length_cells;
        let held_back = (folds.min(self.core) - self.plateau).max(0.0);
        let growth = folds - held_back + (STEEPNESS - 1.0) * (folds - self.core).max(0.0);
        (growth - 2.0 * EULER_GAMMA).exp() / (self.decay_length_cells * self.decay_length_cells)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exponent(growth: &Growth, depth: f64) -> f64 {
        (growth.drag(depth) / growth.drag(0.0)).ln()
    }

    /// Above a deep core the drag stays where the grid resolves it; a thin body has a hard core all the same, and without
    /// a depth the core is where it was.
    #[test]
    fn the_drag_waits_for_a_deep_core() {
        let deep = Growth::still(0.25, f64::INFINITY, Some(2.0), true);
        for (depth, expected) in [(0.5, 2.0), (0.7, PLATEAU), (1.99, PLATEAU), (2.25, PLATEAU + 3.0)] {
            assert!((exponent(&deep, depth) - expected).abs() < 1e-12, "{} at {depth}", exponent(&deep, depth));
        }
        for thickness in [2.2, 2.5, 3.0, 4.0, 5.0] {
            let thin = Growth::still(0.25, thickness, Some(2.0), true);
            let tight = exponent(&thin, 0.5 * (thickness - 1.0));
            assert!(tight > TIGHT - 1e-9, "{tight} in a body of {thickness} cells");
        }
        let bar = Growth::still(0.25, 5.0, Some(2.0), true);
        for (depth, expected) in [(0.99, PLATEAU), (1.25, PLATEAU + 3.0)] {
            assert!((exponent(&bar, depth) - expected).abs() < 1e-12, "{} at {depth} in a bar", exponent(&bar, depth));
        }
        let usual = Growth::still(0.25, f64::INFINITY, None, true);
        assert!((exponent(&usual, 0.475) - 2.7).abs() < 1e-12, "{}", exponent(&usual, 0.475));
    }

    /// A body that moves has no core where it is tight without one, and else one that makes it just so.
    #[test]
    fn the_drag_of_a_body_that_moves_has_no_core() {
        let thick = Growth::moving(0.25, 5.0);
        for depth in [0.5, 1.0, 2.0] {
            assert!((exponent(&thick, depth) - depth / 0.25).abs() < 1e-12, "{} at {depth}", exponent(&thick, depth));
        }
        for thickness in [2.5, 3.0, 4.0] {
            let tight = exponent(&Growth::moving(0.25, thickness), 0.5 * (thickness - 1.0));
            assert!((tight - TIGHT).abs() < 1e-9, "{tight} in a body of {thickness} cells");
        }
    }

    /// How far the place of a face that follows at a rate (nu/dx²) is from its mean over the places of the grid, at most.
    fn ripple(growth: &Growth, rate: f64) -> f64 {
        const PLACES: i32 = 40;
        let shares = (0..PLACES).map(|place| {
            let aside = f64::from(place) / f64::from(PLACES);
            let share = |cell: i32| 1.0 / (1.0 + rate / growth.drag(f64::from(cell) + aside));
            (-30..30).map(share).sum::<f64>() - aside
        });
        let (least, most) = shares.fold((f64::MAX, f64::MIN), |(least, most), sum| (least.min(sum), most.max(sum)));
        0.5 * (most - least)
    }

    /// By Poisson's summation formula, for a logistic function.
    #[test]
    fn what_follows_a_body_ripples_less_without_a_core() {
        let expected = |decay: f64| {
            let argument = 2.0 * std::f64::consts::PI.powi(2) * decay;
            argument / std::f64::consts::PI / argument.sinh()
        };
        let smooth = ripple(&Growth::moving(0.25, 10.0), 100.0);
        let steep = ripple(&Growth::still(0.25, 30.0, None, true), 1e5);
        for (found, decay) in [(smooth, 0.25), (steep, 0.25 / STEEPNESS)] {
            let expected = expected(decay);
            assert!((found / expected - 1.0).abs() < 0.05, "{found} cells against {expected}");
        }
    }
}
