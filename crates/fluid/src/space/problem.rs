//! What a step in space works with in any precision.

use serde::{Deserialize, Serialize};

use super::bodies::Bodies;
use super::force::BodyForce;
use super::parameters::Parameters;
use super::thin::ThinBodies;
use crate::bodies::{Loads, Stations};
use crate::force::Exchange;
use crate::grid::Grid;
use crate::parameters::Law;

/// The domain with the bodies in it.
pub struct Problem {
    /// The grid.
    pub grid: Grid<3>,
    /// Kinematic viscosity, m²/s.
    pub nu: f64,
    /// Walls, zones and rigid bodies as drag.
    pub bodies: Bodies,
    /// Bodies that are lines or surfaces of markers.
    pub thin: ThinBodies,
    /// Prescribed mean velocity; absent: free.
    mean_flow: Option<[Law; 3]>,
}

/// The present time, without the flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Present {
    /// Time, s.
    pub time: f64,
    /// Last step, s; 0 before the first.
    pub step: f64,
    /// Largest `|u|/dx + |v|/dy + |w|/dz`, 1/s.
    pub advection_rate: f64,
    /// Forces on the rigid bodies, then on the thin ones.
    pub bodies: Vec<BodyForce>,
    /// Nodes of the thin bodies.
    pub nodes: Vec<Stations<3>>,
    /// Loads on them in the coming step.
    pub loads: Vec<Loads<3>>,
    /// Exchange with them.
    pub exchange: Vec<Exchange<3>>,
}

impl Problem {
    /// The domain at t = 0.
    pub fn new(parameters: &Parameters) -> Self {
        let grid = Grid::new(parameters.domain, parameters.cells);
        Self {
            grid,
            bodies: Bodies::new(parameters, &grid),
            thin: ThinBodies::new(parameters, &grid),
            nu: parameters.kinematic_viscosity,
            mean_flow: parameters.mean_flow.clone(),
        }
    }

    /// Put all bodies to their places at a time (s), with the nodes of the thin ones.
    pub fn place(&mut self, time: f64, nodes: &[Stations<3>]) {
        self.bodies.place(time, &self.grid);
        self.thin.place(nodes, &self.bodies.rigid, &self.grid);
    }

    /// Return the displaced fluid of all bodies, the rigid ones first, without a force.
    pub fn without_force(&self, nodes: &[Stations<3>]) -> Vec<BodyForce> {
        let mut forces = self.bodies.without_force();
        forces.resize(forces.len() + nodes.len(), BodyForce::default());
        self.thin.set_displaced(nodes, &mut forces);
        forces
    }

    /// Return the prescribed mean velocity at a time (s), m/s; none if it is free.
    pub fn mean_velocity(&self, time: f64) -> Option<[f64; 3]> {
        self.mean_flow.as_ref().map(|laws| laws.each_ref().map(|law| law.value(time)))
    }
}
