//! Rigid bodies in the plane and in space: kinematics, springs and dampers, and a free body that carries others.
//!
//! [`SpringStep`] solves for the velocities of a body at the end of a step, with two-step backward differences.
//! [`Body`] adds the orientation as a quaternion, a centre of mass apart from the pivot, and hinges. All quantities
//! are in SI units.

#![forbid(unsafe_code)]

mod body;
mod carried;
mod flyer;
mod force;
mod hinge;
mod kinematics;
mod pose;
mod step;

pub use crate::body::{Body, BodyParameters, BodyState, Placed};
pub use crate::carried::Carried;
pub use crate::flyer::{FluidLoad, Flyer, FlyerState, HingeTurn};
pub use crate::force::{Drag, Force};
pub use crate::hinge::{RootResponse, force_about, rates_at};
pub use crate::kinematics::{Freedoms, Kinematics, Spin, Turn, Vector, join, split};
pub use crate::pose::Pose;
pub use crate::step::{Mass, SpringMotion, SpringStep};
