//! Zones across the domain that draw the flow to a velocity: the inflow and the sponge.

use std::f64::consts::PI;

use method::Mask;

use crate::grid::Grid;
use crate::law::Law;
use crate::parameters::Zone;
use crate::wall::DragProfile;

/// A zone that draws the flow to `(shape(y) · mean_velocity(t), 0)`.
pub struct DrivingZone {
    /// Mean velocity, m/s.
    pub mean_velocity: Law,
    /// Columns with a penalization rate that has an effect, and the rate, 1/s.
    pub columns: Vec<(usize, f64)>,
    /// Velocity over its mean, by row.
    pub shape: Vec<f64>,
}

impl DrivingZone {
    /// Return the inflow and the sponge, if present, in a fluid of viscosity `nu` (m²/s) with the walls of a `channel` at
    /// two y, m.
    pub fn all<const D: usize>(
        [inflow, sponge]: [&Option<Zone>; 2],
        mask: &Mask,
        nu: f64,
        channel: Option<[f64; 2]>,
        grid: &Grid<D>,
    ) -> Vec<Self> {
        let new = |zone: &Zone, rate: &dyn Fn(f64) -> f64| Self {
            mean_velocity: zone.mean_velocity.clone(),
            columns: columns(zone.x, grid, rate),
            shape: shape(zone.parabolic, channel, grid),
        };
        let inflow = inflow.as_ref().map(|zone| {
            let profile = DragProfile::new(mask, zone.c_eta, nu, grid.cell_size());
            new(zone, &|depth| profile.rate(-depth))
        });
        let sponge = sponge.as_ref().map(|zone| {
            let [from, to] = zone.x;
            new(zone, &|depth| (PI * depth.max(0.0) / (to - from)).sin().powi(2) / zone.c_eta)
        });
        inflow.into_iter().chain(sponge).collect()
    }
}

/// Return the columns where `rate`, a function of the depth in the zone (m, negative outside), has an effect.
fn columns<const D: usize>([from, to]: [f64; 2], grid: &Grid<D>, rate: &dyn Fn(f64) -> f64) -> Vec<(usize, f64)> {
    /// Rate that changes no bit of a flow, 1/s: the tail of the log-linear profile is below it after 25 cells.
    const NO_EFFECT: f64 = 1e-40;
    let (center, half) = (0.5 * (from + to), 0.5 * (to - from));
    (0..grid.cells[0])
        .map(|i| (i, rate(half - grid.periodic(0, grid.coordinate(0, i) - center).abs())))
        .filter(|(_, rate)| *rate > NO_EFFECT)
        .collect()
}

/// Return the velocity over its mean at each row.
fn shape<const D: usize>(parabolic: bool, channel: Option<[f64; 2]>, grid: &Grid<D>) -> Vec<f64> {
    let rows = 0..grid.cells[1];
    match channel {
        Some([low, high]) if parabolic => {
            let parabola = |y: f64| 6.0 * (y - low) * (high - y) / (high - low).powi(2);
            rows.map(|j| parabola(grid.coordinate(1, j)).max(0.0)).collect()
        }
        _ => vec![1.0; rows.len()],
    }
}
