//! What a step of any precision and scheme works with: grid, fluid, zones and bodies.

use line_fft::Real;

use crate::bodies::Bodies;
use crate::field::Field;
use crate::grid::Grid;
use crate::parameters::{Law, Parameters};
use crate::timer::PhaseTimer;
use crate::zone::DrivingZone;

/// The domain with the bodies in it.
pub struct Problem {
    /// The grid.
    pub grid: Grid,
    /// Kinematic viscosity, m²/s.
    pub nu: f64,
    /// Walls, zones, rigid bodies and beams as drag.
    pub bodies: Bodies,
    /// Times of the phases of a step.
    pub timer: PhaseTimer,
    /// Inflow and sponge.
    zones: Vec<DrivingZone>,
    /// Prescribed mean velocity; absent: free.
    mean_flow: Option<[Law; 2]>,
}

impl Problem {
    /// The domain at t = 0.
    pub fn new(parameters: &Parameters) -> Self {
        let grid = Grid::new(parameters.domain, parameters.cells);
        let Parameters { inflow, sponge, mask, kinematic_viscosity: nu, channel, .. } = parameters;
        let zones = DrivingZone::all([inflow, sponge], mask, *nu, *channel, &grid);
        Self {
            nu: parameters.kinematic_viscosity,
            bodies: Bodies::new(parameters, &zones, &grid),
            timer: PhaseTimer::default(),
            mean_flow: parameters.mean_flow.clone(),
            zones,
            grid,
        }
    }

    /// Return the prescribed mean velocity at a time (s), m/s; none if it is free.
    pub fn mean_velocity(&self, time: f64) -> Option<[f64; 2]> {
        self.mean_flow.as_ref().map(|laws| laws.each_ref().map(|law| law.value(time)))
    }

    /// Add `weight(Σ a) a_b u_b` of all zones and bodies at a time (s) to `w`.
    pub fn add_velocities<R: Real>(&self, time: f64, weight: impl Fn(f64) -> f64, w: &mut [Field<R>; 2]) {
        let Some(rate) = self.bodies.rate() else { return };
        let rows = self.grid.cells[1];
        for DrivingZone { mean_velocity, columns, shape } in &self.zones {
            let mean = mean_velocity.value(time);
            for &(i, zone) in columns {
                let column = i * rows..(i + 1) * rows;
                let (wx, rate) = (&mut w[0][column.clone()], &rate[column]);
                for ((wx, rate), shape) in wx.iter_mut().zip(rate).zip(shape) {
                    *wx = R::rounded(wx.to_f64() + weight(*rate) * zone * mean * shape);
                }
            }
        }
        self.bodies.add_velocities(weight, w);
    }
}
