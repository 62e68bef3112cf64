//! Two-dimensional incompressible flow around fixed and moving bodies.
//!
//! The penalized Navier–Stokes equations (thesis eq. 3.3) in a periodic box,
//!
//! ```text
//! ∂u/∂t + omega × u = −∇Pi + nu ∇²u − Σ_b a_b (u − u_b),   ∇·u = 0,
//! ```
//!
//! are solved by a Fourier pseudo-spectral method; `a_b` is the drag rate of body b (1/s; chi/C_eta for a mask).
//! [`solver`] has the scheme, [`drag`] the profiles of `a`, [`beam`] and [`cylinder`] the bodies.

pub mod beam;
pub mod body;
pub mod cylinder;
pub mod drag;
pub mod fft;
pub mod grid;
pub mod kernel;
mod lines;
mod probe;
pub mod projection;
mod quad;
pub mod solver;
mod zone;

pub use beam::{Exchange, Loads, Stations};
pub use grid::Grid;
pub use solver::{Error, Fluid, Force, Phase, State};
