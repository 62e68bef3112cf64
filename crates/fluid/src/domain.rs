//! The box with all that is in it, and the work arrays of a step: what both time schemes work with.

use scene::{MeanFlow, Scene};

use crate::bodies::Bodies;
use crate::clock::Clock;
use crate::field::Field;
use crate::grid::Grid;
use crate::spectral::Spectral;
use crate::zone::Zone;
use line_fft::Real;

/// The box of a scene.
pub struct Domain<R: Real> {
    /// Its grid.
    pub grid: Grid,
    /// Kinematic viscosity, m²/s.
    pub nu: f64,
    /// Inflow and sponge.
    pub zones: Vec<Zone>,
    /// Mean velocity that is held; absent where it is free.
    pub mean_flow: Option<MeanFlow>,
    /// Walls, zones, rigid bodies and beams as drag.
    pub bodies: Bodies,
    /// Transforms and projection.
    pub spectral: Spectral<R>,
    /// What a step hands to the spectral solve, m/s. Between steps the first holds Pi (m²/s²), if that was asked for.
    pub w: [Field<R>; 2],
    /// Times the phases of a step.
    pub clock: Clock,
}

impl<R: Real> Domain<R> {
    /// The box of a scene with a fluid, at t = 0.
    pub fn new(scene: &Scene, fluid: &scene::Fluid) -> Self {
        let grid = Grid::new(&fluid.r#box);
        let zones = Zone::of(fluid, &grid);
        let field = || Field::uniform(R::zero(), grid.len());
        Self {
            nu: fluid.kinematic_viscosity,
            mean_flow: fluid.mean_flow.clone(),
            bodies: Bodies::new(scene, fluid, &zones, &grid),
            zones,
            spectral: Spectral::new(&grid, fluid.filter, fluid.threads),
            w: [field(), field()],
            clock: Clock::default(),
            grid,
        }
    }

    /// Tell the projection what the mean flow is at a time (s).
    pub fn hold_mean_flow(&mut self, time: f64) {
        if let Some(MeanFlow { x, y }) = &self.mean_flow {
            self.spectral.projection.mean = Some([x, y].map(|law| law.value(time)));
        }
    }

    /// Add `weight(Σ a) a_b u_b` of all zones and bodies at a time (s) to `w`.
    pub fn add_velocities(&mut self, time: f64, weight: impl Fn(f64) -> f64) {
        let Some(rate) = self.bodies.rate() else { return };
        for Zone { law, columns, shape } in &self.zones {
            let mean = law.value(time);
            for &(i, zone) in columns {
                let column = i * self.grid.ny..(i + 1) * self.grid.ny;
                let (wx, rate) = (&mut self.w[0][column.clone()], &rate[column]);
                for ((wx, rate), shape) in wx.iter_mut().zip(rate).zip(shape) {
                    *wx = R::rounded(wx.to_f64() + weight(*rate) * zone * mean * shape);
                }
            }
        }
        self.bodies.add_velocities(weight, &mut self.w);
    }
}
