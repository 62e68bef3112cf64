//! Zones across the box that draw the flow to a velocity: the inflow and the sponge.

use std::f64::consts::PI;

use scene::{InflowProfile, TimeLaw};

use crate::grid::Grid;
use crate::wall::DragProfile;

/// A zone that draws the flow to `(shape(y) · law(t), 0)`.
pub struct Zone {
    /// Mean velocity, m/s.
    pub law: TimeLaw,
    /// Drag rate of the zone by column, 1/s, for the columns where it makes a difference.
    pub columns: Vec<(usize, f64)>,
    /// Velocity over its mean, by row.
    pub shape: Vec<f64>,
}

impl Zone {
    /// The inflow and the sponge of a scene, as far as it has them.
    pub fn of(fluid: &scene::Fluid, grid: &Grid) -> Vec<Self> {
        let inflow = fluid.inflow.as_ref().map(|inflow| Self::inflow(inflow, fluid, grid));
        let sponge = fluid.sponge.as_ref().map(|sponge| Self::sponge(sponge, fluid, grid));
        inflow.into_iter().chain(sponge).collect()
    }

    /// The ends of the inflow zone have the drag profile of the walls.
    fn inflow(inflow: &scene::Inflow, fluid: &scene::Fluid, grid: &Grid) -> Self {
        let profile = DragProfile::new(&fluid.mask, inflow.c_eta, fluid.kinematic_viscosity, grid.cell_size());
        let rate = |depth: f64| profile.rate(-depth);
        Self {
            law: inflow.mean_velocity.clone(),
            columns: columns(inflow.x, grid, rate),
            shape: shape(inflow.profile, fluid, grid),
        }
    }

    fn sponge(sponge: &scene::Sponge, fluid: &scene::Fluid, grid: &Grid) -> Self {
        let [from, to] = sponge.x;
        let rate = |depth: f64| (PI * depth.max(0.0) / (to - from)).sin().powi(2) / sponge.c_eta;
        Self {
            law: sponge.mean_velocity.clone(),
            columns: columns(sponge.x, grid, rate),
            shape: shape(sponge.profile, fluid, grid),
        }
    }
}

/// Columns where the rate, a function of the depth in the zone (m, negative outside), makes a difference.
fn columns([from, to]: [f64; 2], grid: &Grid, rate: impl Fn(f64) -> f64) -> Vec<(usize, f64)> {
    /// Rate that changes no bit of a flow, 1/s: the tail of the log-linear profile has fallen to it within 25 cells.
    const NONE: f64 = 1e-40;
    let (center, half) = (0.5 * (from + to), 0.5 * (to - from));
    (0..grid.nx)
        .map(|i| (i, rate(half - grid.periodic_x(grid.x(i) - center).abs())))
        .filter(|(_, rate)| *rate > NONE)
        .collect()
}

/// Velocity over its mean at each row.
fn shape(profile: InflowProfile, fluid: &scene::Fluid, grid: &Grid) -> Vec<f64> {
    match (profile, &fluid.channel) {
        (InflowProfile::Parabolic, Some(channel)) => {
            let [low, high] = channel.y;
            let parabola = |y: f64| 6.0 * (y - low) * (high - y) / (high - low).powi(2);
            (0..grid.ny).map(|j| parabola(grid.y(j)).max(0.0)).collect()
        }
        _ => vec![1.0; grid.ny],
    }
}
