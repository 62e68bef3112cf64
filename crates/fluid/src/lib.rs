//! Incompressible flow around fixed and moving bodies.
//!
//! The penalized Navier–Stokes equations (thesis eq. 3.3) in a periodic domain,
//!
//! ```text
//! ∂u/∂t + omega × u = −∇Pi + nu ∇²u − Σ_b a_b (u − u_b),   ∇·u = 0,
//! ```
//!
//! are solved by a Fourier pseudo-spectral method; `a_b` is the penalization rate of body b, 1/s: chi/C_eta for
//! a mask.
//!
//! A [`Fluid`] is made from [`Parameters`], in the plane (`D` = 2, the default) or in space (`D` = 3). Each communication
//! step sets the [`Stations`] of the flexible bodies, advances the fluid, and reads forces, [`Loads`] and fields. Inside,
//! `space` has what differs between the dimensions, `step` the time schemes, `spectral` the solve in Fourier space, `wall`
//! the profiles of `a`, `shapes` and `bodies` the rigid bodies and the beams with a mask, and `thin` the bodies that are
//! lines or surfaces. With the feature `scene` the parameters can be made from a scene.

mod bodies;
mod checks;
mod error;
mod field;
mod filter;
mod flow;
mod fluid;
mod force;
#[cfg(feature = "scene")]
mod from_scene;
mod grid;
mod gust;
mod kernel;
mod law;
mod limits;
mod outlet;
mod outputs;
mod parameters;
mod present;
mod pressures;
mod probe;
mod problem;
mod shapes;
mod solver;
mod space;
mod spectral;
mod state;
mod step;
mod thin;
mod timer;
mod two_grids;
mod wall;
mod zone;

pub use ::contact::{BodyFilm, BodyLaw, Loads, Skin, Stations};
pub use ::rigid::Pose;
pub use error::Error;
pub use fluid::Fluid;
pub use force::{Exchange, Force};
pub use geometry::plane::Outline;
pub use geometry::space::Solid;
pub use grid::Grid;
pub use gust::Gust;
pub use method::{Filter, Mask, Precision, Support, TimeScheme, WallCorrection};
pub use parameters::{
    Body, Carrier, Contact, Extent, FineBox, Flexible, Followed, Law, Laws, MiddleBox, Motion, Mount, Parameters, Zone,
};
pub use shapes::{Polyline, Shape, Triangulation};
pub use solver::Solvable;
pub use space::{Kinematics, Space, Spin, Turn};
pub use state::State;

/// Parts for benchmarks and tables: not part of the interface, and without promises.
#[cfg(feature = "internals")]
pub mod internals {
    pub use crate::spectral::{Implicit, Projection};
    pub use crate::timer::{Phase, PhaseTimer};
    pub use crate::wall::{DragProfile, WallTarget};
}

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
