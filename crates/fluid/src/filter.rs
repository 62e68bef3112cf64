//! The smooth filter `F_0 = exp(−α (k/k_max)^p)` (Hou & Li 2007) as a rate.
//!
//! Applied once in each step, the filter would be a drag on the short waves with the rate `(1/F_0 − 1)/dt`, which grows
//! without bound as the step is refined. Here the rate belongs to the flow: `r = (1/F_0 − 1) q/FILTER_CFL`, with q the
//! largest `|u|/dx + |v|/dy`, the rate at which waves of the grid's size are made. The term `−r u` stands in the
//! equations beside viscosity, so a solution has a limit in dt. A step of the CFL number [`FILTER_CFL`] damps as F_0
//! does.

use method::Filter;

const STRENGTH: f64 = 36.0;
const ORDER: i32 = 36;
const FILTER_CFL: f64 = 0.3;

/// Return the damping `(1/F_0 − 1)/FILTER_CFL` of a wave in a step of the CFL number 1, by the wavenumber over the
/// highest.
pub fn smooth_damping(fraction: f64) -> f64 {
    ((STRENGTH * fraction.powi(ORDER)).exp() - 1.0) / FILTER_CFL
}

/// What damps the short waves of a grid.
#[derive(Clone, Copy, Debug)]
pub enum Damping {
    /// A filter by the length of the wavenumber.
    Of(Filter),
    /// The smooth filter by the wavenumber along each axis: it leaves the corners, where a force on few cells has much.
    EachAxis,
}

impl From<Filter> for Damping {
    fn from(filter: Filter) -> Self {
        Self::Of(filter)
    }
}
