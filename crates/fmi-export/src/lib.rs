//! FMI 2.0 and 3.0 co-simulation export: a struct, a trait and a list of variables make an FMU of both versions.
//!
//! Implement [`Model`], list the variables with [`Real`], [`Integer`], [`Boolean`] and [`Text`], and call
//! [`export_fmu!`] in a crate of type `cdylib`. The model description with units, start values and GUID, the value
//! references and the access to values follow from the list. The export keeps time and call order, checks arguments,
//! catches panics, and stores, restores and serializes the FMU state. See also `examples/damped_oscillator.rs`.
//!
//! ```
//! use std::slice::{from_mut, from_ref};
//!
//! use nervure_fmi_export::{Description, Log, Model, Resources, Variable};
//!
//! struct Tank {
//!     inflow: f64,
//!     volume: f64,
//! }
//!
//! impl Model for Tank {
//!     const IDENTIFIER: &'static str = "tank";
//!     const VERSION: &'static str = "1.0";
//!     type State = f64;
//!
//!     fn load(_resources: &Resources) -> Result<Self, String> {
//!         Ok(Tank { inflow: 0.0, volume: 0.0 })
//!     }
//!
//!     fn description(&self) -> Description {
//!         let (model_name, text) = ("Tank".into(), "A tank that fills".into());
//!         Description { model_name, text, ..Description::default() }
//!     }
//!
//!     fn variables(&self) -> Vec<Variable<Self>> {
//!         type Real = nervure_fmi_export::Real<Tank>;
//!         vec![
//!             Real::input("inflow", "m3/s", "Flow into the tank", |tank| from_mut(&mut tank.inflow)).at_least(0.0),
//!             Real::output("volume", "m3", "Volume in the tank", |tank| from_ref(&tank.volume)).depends_on(&[]),
//!         ]
//!     }
//!
//!     fn initialise(&mut self, _start: f64, _log: &Log) -> Result<(), String> {
//!         Ok(())
//!     }
//!
//!     fn step(&mut self, _t: f64, h: f64, _log: &Log) -> Result<(), String> {
//!         self.volume += h * self.inflow;
//!         Ok(())
//!     }
//!
//!     fn save(&self) -> Self::State {
//!         self.volume
//!     }
//!
//!     fn restore(&mut self, state: &Self::State) -> Result<(), String> {
//!         self.volume = *state;
//!         Ok(())
//!     }
//! }
//!
//! nervure_fmi_export::export_fmu!(Tank);
//! ```

mod access;
mod description;
#[doc(hidden)]
pub mod export;
mod finite;
mod guard;
mod identity;
mod instance;
mod log;
mod memory;
mod model;
mod resource;
mod settings;
mod snapshot;
mod state_machine;
#[rustfmt::skip]
pub mod sys;
mod table;
#[doc(hidden)]
pub mod text;
mod units;
mod variable;
mod version;

pub use log::Log;
pub use memory::require_memory;
pub use model::{Description, Model};
pub use resource::Resources;
pub use variable::{Boolean, Integer, Real, Text, Variable};
