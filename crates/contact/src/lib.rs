//! Contact of parts with each other and with obstacles, in two or three dimensions.
//!
//! A [`Law`] turns the gap g between two surfaces into a force along their common normal. All parts of it are
//! derivatives of convex functions of g, so an implicit step with contact stays a minimum of a potential:
//!
//! ```text
//! U(g) penalty,      (1/Δt) [∫ Γ dg − Γ(g_0) g] damper and film,      μ N_0 |s| friction with the slip s.
//! ```
//!
//! [`Obstacle`] has closest points, [`Meeting`] the forces on a point of what deforms, [`SurfacePoint`] the points of
//! triangles, [`Cells`] finds candidates, [`BodyContacts`] solves for rigid bodies, [`FlexibleContact`] announces the
//! loads of rods and wings that others move, and [`ContactCoupling`] does so without a fluid.
//! All quantities are in SI units.

#![forbid(unsafe_code)]

mod bodies;
mod cells;
mod coupling;
mod encounter;
mod error;
mod feature;
mod flexible;
mod law;
mod obstacle;
mod stations;
mod surface;

pub use bodies::{BodyContacts, BodyFilm, BodyLaw, Part, PartMotion, nearest_image};
pub use cells::{Cells, MOST_PARTNERS};
pub use coupling::{ContactCoupling, ContactExchange, CouplingError, CouplingState};
pub use encounter::{Encounter, Meeting, Obstacles, Push, keep_one_of_each_bend};
pub use error::{BodyError, ContactError};
pub use flexible::{FastMeeting, FlexibleBody, FlexibleContact, MountPush, MountedBody, Party, Skin};
pub use law::{Before, Film, FilmPower, Friction, HELD, Law, Response, largest_stiffness};
pub use obstacle::{Nearest, Obstacle, Pose};
pub use rigid::Kinematics;
pub use stations::{Loads, Stations};
pub use surface::{SurfacePoint, nearest_of_triangle, points_of_surface};
