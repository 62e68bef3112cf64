//! Rigid bodies in the plane and in space: kinematics, springs and dampers, and a free body that carries others.
//!
//! [`MountedStep`] solves for the motion of a body on springs in a step, with two-step backward differences.
//! [`Body`] has the orientation as a quaternion, and a centre of mass apart from the pivot; [`Flyer`] adds hinges. All
//! quantities are in SI units.

#![forbid(unsafe_code)]

mod body;
mod flyer;
mod force;
mod hinge;
mod history;
mod kinematics;
mod mounted;
mod pose;
mod step;

pub use crate::body::{Body, BodyParameters, BodyState, FreeStep, Placed};
pub use crate::flyer::{FluidLoad, Flyer, FlyerState, HingeTurn};
pub use crate::force::{Drag, Force};
pub use crate::hinge::{RootResponse, force_about, rates_at};
pub use crate::history::DisplacementHistory;
pub use crate::kinematics::{Freedoms, Kinematics, Spin, Turn, Vector, join, nearest, split};
pub use crate::mounted::{MountedStep, SpringDynamics};
pub use crate::pose::Pose;
pub use crate::step::{Mass, SpringMotion};
