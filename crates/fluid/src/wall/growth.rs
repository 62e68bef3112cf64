//! Growth of the log-linear drag below the surface, for the profile and the calibration of its wall target.

/// Euler's constant γ.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Growth in the core of a body over the log-linear growth.
const STEEPNESS: f64 = 3.0;

/// Depth of the core below a wall without a target, decay lengths. The flow along the wall has decreased there to 0.7 %
/// of λ times its shear, so the calibration of the surface is not affected.
const CORE_DEPTH: f64 = 3.0;

/// Depth of the core below a wall with a target, decay lengths; the calibration includes the core. With a deeper core a
/// cylinder would be porous under the pressure of a fast flow.
const CORE_DEPTH_WITH_TARGET: f64 = 1.5;

/// Exponent of the constant drag above a deep core: 61 ν/dx², which the grid resolves. With a larger drag towards a
/// wall target the fluid makes waves that the grid does not resolve, and forces depend on C_eta.
const PLATEAU: f64 = 2.5;

/// Exponent that the drag of a body reaches at the depth where it has cells for every position of the grid. A bar of
/// two or three cells would be porous otherwise: the pressure on a flapping bar is ten times the pressure of its
/// stream.
const TIGHT_EXPONENT: f64 = 7.0;

/// Largest depth of a deep core over the thickness of the body. The pressure jump across a body drives fluid through it
/// at the speed of the jump over the density and the integral of the drag; the soft part adds little to that integral
/// (docs/dev/wall-model.md).
const LARGEST_SOFT_FRACTION: f64 = 0.2;

/// Growth of the drag with the depth: exponential, and steeper in the core of a body.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// Decay length, cells.
    pub decay_length_cells: f64,
    /// Depth at which the core begins, decay lengths.
    core: f64,
    /// Depth from which the drag is constant up to the core, decay lengths.
    plateau: f64,
}

impl Growth {
    /// Growth below a wall of the channel or in a zone, without a wall target.
    pub fn wall(decay_length_cells: f64) -> Self {
        Self::still(decay_length_cells, f64::INFINITY, None, false)
    }

    /// Growth in a still body with a thickness, with or without a wall target. The core begins at a depth, or at the
    /// default depth; all in cells.
    pub fn still(decay_length_cells: f64, thickness: f64, core_depth: Option<f64>, with_target: bool) -> Self {
        let (usual, plateau) =
            if with_target { (CORE_DEPTH_WITH_TARGET, PLATEAU) } else { (CORE_DEPTH, f64::INFINITY) };
        let deepest =
            core_depth.map_or(usual, |depth| depth.min(LARGEST_SOFT_FRACTION * thickness) / decay_length_cells);
        Self::new(decay_length_cells, thickness, deepest, plateau)
    }

    /// Growth in a moving body with a thickness (cells); it has a core only if it is thin.
    ///
    /// Cells enter the body and leave it. A fluid that follows the body at the rate s has the velocity a/(a + s) of the
    /// body in a cell. With an exponential a of the decay length λ this is a logistic function, whose sum over the
    /// cells ripples with the position of the grid by `2 π λ/sinh(2 π² λ)` of a cell: 0.02 for a quarter of a cell, 0.2
    /// in a core three times as steep. So forces flicker with a core of any depth (docs/dev/wall-model.md).
    pub fn moving(decay_length_cells: f64, thickness: f64) -> Self {
        Self::new(decay_length_cells, thickness, f64::INFINITY, f64::INFINITY)
    }

    /// Growth with a core that begins at `deepest` (decay lengths), or earlier in a thin body.
    fn new(decay_length_cells: f64, thickness: f64, deepest: f64, plateau: f64) -> Self {
        let everywhere = 0.5 * (thickness - 1.0) / decay_length_cells;
        let above_plateau = everywhere - (TIGHT_EXPONENT - everywhere) / (STEEPNESS - 1.0);
        let below_plateau = everywhere - (TIGHT_EXPONENT - plateau) / STEEPNESS;
        Self { decay_length_cells, core: above_plateau.min(below_plateau).clamp(0.0, deepest), plateau }
    }

    /// Return the drag at a depth (cells), ν/dx². With its value at the surface, linear shear vanishes there.
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

    /// Above a deep core the drag is constant; a thin body has a hard core all the same, and the default depth is
    /// unchanged.
    #[test]
    fn the_drag_waits_for_a_deep_core() {
        let deep = Growth::still(0.25, f64::INFINITY, Some(2.0), true);
        for (depth, expected) in [(0.5, 2.0), (0.7, PLATEAU), (1.99, PLATEAU), (2.25, PLATEAU + 3.0)] {
            assert!((exponent(&deep, depth) - expected).abs() < 1e-12, "{} at {depth}", exponent(&deep, depth));
        }
        for thickness in [2.2, 2.5, 3.0, 4.0, 5.0] {
            let thin = Growth::still(0.25, thickness, Some(2.0), true);
            let tight = exponent(&thin, 0.5 * (thickness - 1.0));
            assert!(tight > TIGHT_EXPONENT - 1e-9, "{tight} in a body of {thickness} cells");
        }
        let bar = Growth::still(0.25, 5.0, Some(2.0), true);
        for (depth, expected) in [(0.99, PLATEAU), (1.25, PLATEAU + 3.0)] {
            assert!((exponent(&bar, depth) - expected).abs() < 1e-12, "{} at {depth} in a bar", exponent(&bar, depth));
        }
        let usual = Growth::still(0.25, f64::INFINITY, None, true);
        assert!((exponent(&usual, 0.475) - 2.7).abs() < 1e-12, "{}", exponent(&usual, 0.475));
    }

    /// A moving body has no core if it is tight without one, and otherwise a core that makes it just tight.
    #[test]
    fn the_drag_of_a_body_that_moves_has_no_core() {
        let thick = Growth::moving(0.25, 5.0);
        for depth in [0.5, 1.0, 2.0] {
            assert!((exponent(&thick, depth) - depth / 0.25).abs() < 1e-12, "{} at {depth}", exponent(&thick, depth));
        }
        for thickness in [2.5, 3.0, 4.0] {
            let tight = exponent(&Growth::moving(0.25, thickness), 0.5 * (thickness - 1.0));
            assert!((tight - TIGHT_EXPONENT).abs() < 1e-9, "{tight} in a body of {thickness} cells");
        }
    }

    /// Return the largest distance of a face that follows at a rate (nu/dx²) from its mean over positions of the grid.
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
