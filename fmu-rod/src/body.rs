//! A rod in the plane or in space.

use rod::{Error, Obstacle, Rod, Statistics};
use scene::{Beam, Scene};
use serde::{Deserialize, Serialize};

use crate::{contact, from_scene};

/// Something of a rod in two or three dimensions.
#[derive(Clone, Serialize, Deserialize)]
pub enum Dimensions<P, S> {
    Planar(P),
    Spatial(S),
}

/// Parameters of a rod.
pub type Plan = Dimensions<rod::Parameters<2>, rod::Parameters<3>>;
/// A rod.
pub type Body = Dimensions<Rod<2>, Rod<3>>;
/// State of a [`Body`].
pub type BodyState = Dimensions<rod::RodState<2>, rod::RodState<3>>;

/// Evaluate one expression for a rod in either dimension.
macro_rules! either {
    ($body:expr, $rod:ident => $value:expr) => {
        match $body {
            $crate::body::Dimensions::Planar($rod) => $value,
            $crate::body::Dimensions::Spatial($rod) => $value,
        }
    };
}
pub(crate) use either;

impl Plan {
    /// Return the parameters of the rod of a scene.
    pub fn of(scene: &Scene, beam: &Beam, rod: &scene::Rod) -> Self {
        if scene.dimension(beam) == 2 {
            let place = |body: &scene::Body| Obstacle::of_outline(&body.shape.outline()?, contact::pose(body, 0.0));
            let contact = contact::of_rod(scene, beam, rod, place);
            return Self::Planar(rod::Parameters { contact, ..from_scene::parameters(scene, beam, rod) });
        }
        let endless = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
        let place = |body: &scene::Body| Obstacle::of_solid(&body.shape.solid(&endless)?, contact::pose(body, 0.0));
        let contact = contact::of_rod(scene, beam, rod, place);
        Self::Spatial(rod::Parameters { contact, ..from_scene::parameters(scene, beam, rod) })
    }

    /// Return the rod at rest, without loads.
    pub fn build(&self) -> Result<Body, Error> {
        Ok(match self {
            Self::Planar(parameters) => Body::Planar(Rod::new(parameters.clone())?),
            Self::Spatial(parameters) => Body::Spatial(Rod::new(parameters.clone())?),
        })
    }

    pub fn dimension(&self) -> usize {
        match self {
            Self::Planar(_) => 2,
            Self::Spatial(_) => 3,
        }
    }
}

impl Body {
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
