//! Two-dimensional incompressible flow around fixed and moving bodies.
//!
//! The penalized Navier–Stokes equations (thesis eq. 3.3) in a periodic box,
//!
//! ```text
//! ∂u/∂t + omega × u = −∇Pi + nu ∇²u − Σ_b a_b (u − u_b),   ∇·u = 0,
//! ```
//!
//! are solved by a Fourier pseudo-spectral method; `a_b` is the drag rate of body b (1/s; chi/C_eta for a mask).
//!
//! [`Fluid`] is the whole of the interface: made of a scene, told where the beam's [`Stations`] go, advanced, and asked
//! for forces, [`Loads`] and fields. Inside, `step` has the time schemes, `wall` the profiles of `a`, `bodies` the beam
//! and the rigid bodies.

mod bodies;
mod clock;
mod domain;
mod error;
mod field;
mod fluid;
mod force;
mod grid;
mod outlet;
mod precision;
mod probe;
mod projection;
mod spectral;
mod state;
mod step;
mod wall;
mod zone;

pub use bodies::{Loads, Pose, Stations};
pub use error::Error;
pub use force::{Exchange, Force};
pub use grid::Grid;
pub use precision::Fluid;
pub use state::State;

/// What benchmarks and tables measure apart from a fluid: no part of the interface, and without promises.
#[cfg(feature = "internals")]
pub mod internals {
    pub use crate::clock::{Clock, Phase};
    pub use crate::projection::Projection;
    pub use crate::wall::{DragProfile, WallTarget};
    pub use line_fft::Real;
    pub use line_fft::{Fft2, Pack, Scratch};
}
