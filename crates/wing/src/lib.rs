//! Elastic wing: a network of veins and a triangulated membrane, in space.
//!
//! ```text
//! M x'' = f − ∂U/∂x − τ d(∂U/∂x)/dt,      U = U_membrane + U_plate + U_veins + U_contact
//! ```
//!
//! x are the positions of the nodes and M is the consistent mass matrix of linear elements. The membrane strains by
//! constant-strain triangles with the law of St. Venant–Kirchhoff and an isotropic pretension ([`Membrane`]). It
//! bends as a plate of Kirchhoff with constant moments in each triangle and hinges at the edges (`plate`). Veins are
//! chains of nodes with the springs of the elastic rod ([`rod`]); with torsion they have directors and may curve
//! (`twist`). The root is free, or it is held and moves as a
//! rigid body ([`RigidMotion`]). Time schemes are those of [`structure`]. All quantities are in SI units.

#![forbid(unsafe_code)]

mod base;
mod contact;
mod dissection;
mod elastic;
mod energy;
mod error;
mod face;
mod frames;
mod geometry;
mod itself;
mod modes;
mod newton;
mod parameters;
mod plate;
mod section;
mod sparse;
mod statics;
mod step;
mod supernodes;
mod system;
mod trial;
mod twist;
mod vein;
mod wing;

pub use ::contact::{Law, Obstacle, Pose};
pub use mesh::{Chain, Mesh, ellipse, insect_wing, rectangle};
pub use structure::{Drive, Exchange, Loads, RootResponse, Scheme, Statistics};

pub use crate::base::{Memory, RigidMotion, WingState};
pub use crate::energy::Energy;
pub use crate::error::{Error, WingError};
pub use crate::parameters::{Contact, Membrane, Parameters, Root, Support, Vein};
pub use crate::twist::Twist;
pub use crate::wing::Wing;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
