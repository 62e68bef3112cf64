//! Scene files: the parts of a simulation as data.
//!
//! A scene is one JSON file that the units carry in their `resources/`. It names the parts that exist; an absent part
//! costs no memory, no time and no variable. The JSON Schema (`modelDescription/scene.schema.json`) is made from these
//! types, and [`Scene::from_json`] refuses a scene that the solvers could not run, with a [`Fault`] for each key.
//!
//! All quantities are in SI units; a two-dimensional scene is one metre deep.
#![forbid(unsafe_code)]

mod beam;
mod body;
mod conform;
mod contact;
mod contact_checks;
mod contact_warnings;
mod coupling;
mod facts;
mod fault;
mod fluid;
mod flyer;
mod flyer_checks;
mod json;
mod lag_warnings;
mod law;
mod law_warnings;
mod layers;
mod load;
mod monitor;
mod mount;
mod mounted;
mod places;
mod read;
mod reference;
mod reference_scales;
mod relations;
mod rod;
mod rods;
mod root;
mod scales;
mod scene;
mod schema;
mod shape;
mod spanwise;
mod spline;
mod stepping;
mod surface;
mod unit;
mod warning;
mod warnings;
mod wing;
mod wing_checks;
mod wings;

pub use ::geometry::AXES;
pub use ::method::{
    Axis, Bending, Calibration, Filter, LINE_THICKNESS_CELLS, Mask, Precision, ROD_RADIUS_CELLS, ROD_SECTION_CELLS,
    SURFACE_THICKNESS_CELLS, Scheme as RodScheme, Section, Slide, Support, Surface, TimeScheme, WallCorrection,
};
pub use beam::{Beam, Root};
pub use body::{Body, BodyDrive, BodyMotion, ByMaster, Turn};
pub use contact::{Contact, Film};
pub use contact_checks::HalfSpace;
pub use coupling::{Acceleration, Coupling, CouplingScheme, Guards, Load};
pub use facts::{BeamFacts, Dimensionless, Facts, LawFacts, Resolution, WingFacts};
pub use fault::{Fault, FaultKind, SceneError};
pub use fluid::{
    Channel, Cylinder, FINE_BOX_RIM_CELLS, FineBox, Fluid, FluidBox, Inflow, InflowProfile, MeanFlow, MiddleBox,
    Motion, Probe, Sponge, Zone,
};
pub use flyer::{Flyer, FlyerHinge, FlyerSpring, FreedomName, HingeDrive, HingeLaws};
pub use law::TimeLaw;
pub use monitor::monitor_text;
pub use mount::{Freedom, Inertia, Mount};
pub use read::{check_text, facts_text};
pub use reference::{PublishedCoefficients, PublishedQuantity, PublishedRange, PublishedSpread, Reference};
pub use reference_scales::ReferenceScales;
pub use rod::{Material, Rod, SectionProfile};
pub use rods::NamedRod;
pub use root::{RootLaws, RootMotion, RootSupport, Rotation};
pub use scales::Scales;
pub use scene::{BeamWithRod, Display, Followed, Scene, Time, WingOfScene};
pub use shape::{Ends, Shape};
pub use spanwise::{Spanwise, SpanwiseProfile};
pub use stepping::TimeStepping;
pub use warning::Warning;
pub use wing::{Membrane, Region, Vein, Wing, WingChain, WingDrive, WingGroup, WingMesh, WingSupport};
pub use wings::NamedWing;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
