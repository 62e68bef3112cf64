//! A rod in the plane or in space.

use rod::{Error, Loads, Rod, Statistics};
use scene::{Beam, Scene};
use serde::{Deserialize, Serialize};

use crate::from_scene;

/// A rod in two or three dimensions.
pub enum Body {
    Planar(Rod<2>),
    Spatial(Rod<3>),
}

/// State of a [`Body`].
#[derive(Clone, Serialize, Deserialize)]
pub enum BodyState {
    Planar(rod::RodState<2>),
    Spatial(rod::RodState<3>),
}

/// Evaluate one expression for a rod in either dimension.
macro_rules! either {
    ($body:expr, $rod:ident => $value:expr) => {
        match $body {
            Body::Planar($rod) => $value,
            Body::Spatial($rod) => $value,
        }
    };
}
pub(crate) use either;

impl Body {
    pub fn new(scene: &Scene, beam: &Beam, rod: &scene::Rod) -> Result<Self, Error> {
        Ok(match scene.dimension(beam) {
            2 => Self::Planar(from_scene::build(scene, beam, rod)?),
            _ => Self::Spatial(from_scene::build(scene, beam, rod)?),
        })
    }

    pub fn dimension(&self) -> usize {
        match self {
            Self::Planar(_) => 2,
            Self::Spatial(_) => 3,
        }
    }

    /// Return the number of stations.
    pub fn stations(&self) -> usize {
        self.positions(0).len()
    }

    pub fn loads(&self) -> &Loads {
        either!(self, rod => &rod.loads)
    }

    pub fn loads_mut(&mut self) -> &mut Loads {
        either!(self, rod => &mut rod.loads)
    }

    /// Return component `axis` of the nodal forces.
    pub fn force_mut(&mut self, axis: usize) -> &mut [f64] {
        let stations = self.stations();
        &mut self.loads_mut().force[axis * stations..(axis + 1) * stations]
    }

    pub fn positions(&self, axis: usize) -> &[f64] {
        either!(self, rod => rod.positions(axis))
    }

    pub fn velocities(&self, axis: usize) -> &[f64] {
        either!(self, rod => rod.velocities(axis))
    }

    pub fn step(&mut self, h: f64) -> Result<(), Error> {
        either!(self, rod => rod.step(h))
    }

    pub fn statistics(&self) -> Statistics {
        either!(self, rod => rod.statistics())
    }

    pub fn save(&self) -> BodyState {
        match self {
            Self::Planar(rod) => BodyState::Planar(rod.state().clone()),
            Self::Spatial(rod) => BodyState::Spatial(rod.state().clone()),
        }
    }

    pub fn restore(&mut self, state: &BodyState) -> Result<(), String> {
        let result = match (self, state) {
            (Self::Planar(rod), BodyState::Planar(state)) => rod.restore(state),
            (Self::Spatial(rod), BodyState::Spatial(state)) => rod.restore(state),
            _ => return Err("the state and the rod differ in the number of space dimensions".into()),
        };
        result.map_err(|e| e.to_string())
    }
}
