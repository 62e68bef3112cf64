//! What a step of any precision and scheme works with: grid, fluid and bodies.

use crate::bodies::{Bodies, Cell, Placement};
use crate::force::BodyForce;
use crate::grid::Grid;
use crate::law::Law;
use crate::parameters::{Followed, Parameters};
use crate::present::Present;
use crate::space::{Space, Vector};
use crate::thin::ThinBodies;
use crate::timer::PhaseTimer;
use contact::Stations;

/// The domain with the bodies in it.
pub struct Problem<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// The grid.
    pub grid: Grid<D>,
    /// Kinematic viscosity, m²/s.
    pub nu: f64,
    /// Walls, zones, rigid bodies and beams as drag.
    pub bodies: Bodies<D>,
    /// Bodies that are lines or surfaces of markers.
    pub thin: ThinBodies<D>,
    /// Times of the phases of a step.
    pub timer: PhaseTimer,
    /// Displacement that the master gives the fine box, m.
    pub box_displacement: [f64; D],
    /// Prescribed mean velocity; absent: free.
    mean_flow: Option<[Law; D]>,
}

impl<const D: usize> Problem<D>
where
    [f64; D]: Space<D>,
{
    /// The domain at t = 0.
    pub fn new(parameters: &Parameters<D>) -> Self {
        let grid = parameters.grid();
        let (mut bodies, mut thin) = (Bodies::new(parameters, &grid), ThinBodies::new(parameters, &grid));
        thin.give_layers(&mut bodies.rigid);
        Self {
            nu: parameters.kinematic_viscosity,
            bodies,
            thin,
            timer: PhaseTimer::default(),
            box_displacement: [0.0; D],
            mean_flow: parameters.mean_flow.clone(),
            grid,
        }
    }

    /// Put all bodies to their places.
    pub fn place(&mut self, to: &Placement<D>) {
        self.bodies.place(to, &self.grid);
        self.place_thin(to.stations);
    }

    /// Put the thin bodies to `stations` and to the places of the rigid bodies.
    pub fn place_thin(&mut self, stations: &[Stations<D>]) {
        self.thin.place(stations, &self.bodies.rigid, &self.grid);
    }

    /// Return the place of what the fine box follows, m; of a point its displacement.
    pub fn place_of(&self, body: Followed, stations: &[Stations<D>]) -> Vector<D> {
        match body {
            Followed::Rigid(body) => self.bodies.rigid[body].pose.position + self.bodies.rigid[body].centroid(),
            Followed::Flexible(body) => stations[body].middle(),
            Followed::Master => self.box_displacement.into(),
        }
    }

    /// Return the prescribed mean velocity at a time (s), m/s; none if it is free.
    pub fn mean_velocity(&self, time: f64) -> Option<[f64; D]> {
        self.mean_flow.as_ref().map(|laws| laws.each_ref().map(|law| law.value(time)))
    }

    /// Return the displaced fluid of all bodies, the rigid ones first, without a force.
    pub fn without_force(&self, stations: &[Stations<D>]) -> Vec<BodyForce<D>> {
        let mut forces = vec![BodyForce::default(); self.bodies.rigid.len() + stations.len()];
        self.bodies.set_displaced(stations, &mut forces);
        self.thin.set_displaced(stations, &mut forces);
        forces
    }

    /// Sum up the forces of a step of size `dt` (s); `drag` is that of the masks, see [`Bodies::sum_up_forces`].
    pub fn sum_up_forces(
        &self,
        dt: f64,
        drag: impl Fn(&Cell<D>) -> Vector<D>,
        stations: &[Stations<D>],
        present: &mut Present<D>,
    ) {
        let (forces, flexible) = (&mut present.bodies, &mut present.flexible);
        self.bodies.sum_up_forces(dt, drag, stations, forces, &mut flexible.exchange);
        let exchange = (&mut *flexible.exchange, &mut *flexible.owed);
        self.thin.sum_up_forces(dt, stations, &flexible.stations, forces, exchange);
        let stresses = (&mut *flexible.jump, &mut *flexible.shear);
        self.thin.write_stresses(dt, stations, &flexible.stations, stresses);
    }
}
