//! Incompressible flow around fixed and moving bodies.
//!
//! The penalized Navier–Stokes equations (thesis eq. 3.3) in a periodic domain,
//!
//! ```text
//! ∂u/∂t + omega × u = −∇Pi + nu ∇²u − Σ_b a_b (u − u_b),   ∇·u = 0,
//! ```
//!
//! are solved by a Fourier pseudo-spectral method; `a_b` is the drag rate of body b (1/s; chi/C_eta for a mask).
//!
//! A [`Fluid`] is made from [`Parameters`]. Each communication step sets the [`Stations`] of the beams, advances the
//! fluid, and reads forces, [`Loads`] and fields. Inside, `step` has the time schemes, `wall` the profiles of `a`,
//! `bodies` the rigid bodies and the beams with a mask, and `thin` the bodies that are lines. [`space`] has the flow in
//! three dimensions. With the feature `scene` the parameters can be made from a scene.

mod bodies;
mod error;
mod field;
mod filter;
mod flow;
mod fluid;
mod force;
#[cfg(feature = "scene")]
mod from_scene;
mod grid;
mod limits;
mod outlet;
mod outputs;
mod parameters;
mod present;
mod pressures;
mod probe;
mod problem;
mod projection;
mod solver;
pub mod space;
mod spectral;
mod state;
mod step;
mod thin;
mod timer;
mod wall;
mod zone;

pub use bodies::{Loads, Pose, Stations};
pub use error::Error;
pub use fluid::Fluid;
pub use force::{Exchange, Force};
pub use grid::Grid;
pub use parameters::{
    Beam, Body, Cylinder, Filter, Law, Mask, Motion, Mount, Parameters, Precision, Shape, Support, Surface, TimeScheme,
    WallCorrection, Zone,
};
pub use state::State;

/// Parts for benchmarks and tables: not part of the interface, and without promises.
#[cfg(feature = "internals")]
pub mod internals {
    pub use crate::projection::{Implicit, Projection};
    pub use crate::timer::{Phase, PhaseTimer};
    pub use crate::wall::{DragProfile, WallTarget};
}

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
