//! Contract between a model and the export.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::log::Log;
use crate::resource::Resources;
use crate::variable::Variable;

/// Name, author and default experiment of a model.
#[derive(Clone, Debug)]
pub struct Description {
    /// Name of the model.
    pub model_name: String,
    /// Description in one sentence.
    pub text: String,
    /// Author; empty if unknown.
    pub author: String,
    /// Copyright notice; may be empty.
    pub copyright: String,
    /// Licence; may be empty.
    pub license: String,
    /// Default start time, s.
    pub start: f64,
    /// Default stop time, s.
    pub stop: f64,
    /// Default communication step, s.
    pub step: f64,
    /// Default relative tolerance.
    pub tolerance: f64,
}

impl Default for Description {
    /// Return an experiment from 0 to 1 s in steps of 0.1 s, without texts.
    fn default() -> Self {
        let [model_name, text, author, copyright, license] = [const { String::new() }; 5];
        Self { model_name, text, author, copyright, license, start: 0.0, stop: 1.0, step: 0.1, tolerance: 1e-6 }
    }
}

/// Model of a co-simulation unit, which [`export_fmu!`](crate::export_fmu) turns into an FMU.
///
/// The export owns time, call order, argument checks, logging and the FMU state; the model owns its numbers. An error
/// is a sentence with the name of the variable, the value and the limit. The logger of the master receives it.
pub trait Model: Sized + 'static {
    /// Name of the shared library in the folder `binaries` of the FMU, without its suffix.
    const IDENTIFIER: &'static str;

    /// Version of the library, usually `env!("CARGO_PKG_VERSION")`; part of the GUID.
    const VERSION: &'static str;

    /// Number of the layout of [`State`](Model::State), part of the GUID; increase it with each change of `State`.
    const STATE_LAYOUT: u32 = 1;

    /// Files in the folder `resources` of the FMU that define the model, part of the GUID.
    ///
    /// An FMU with an edited file is refused before the model is loaded.
    const RESOURCES: &'static [&'static str] = &[];

    /// Memory: all that decides the future of the model, beside parameters and inputs, which the export stores.
    ///
    /// Its numbers are finite: a serialized state with others is refused.
    type State: Clone + Serialize + DeserializeOwned;

    /// Read the model from its resources, at instantiation, at `fmi2Reset` and for a description.
    ///
    /// An error refuses the instance. A large model calls [`require_memory`](crate::require_memory) first.
    fn load(resources: &Resources) -> Result<Self, String>;

    /// Make what only an instance needs, such as a solver, after [`load`](Model::load): description, variables and start
    /// values do without.
    ///
    /// An error refuses the instance.
    fn build(&mut self) -> Result<(), String> {
        Ok(())
    }

    /// Return name, texts and default experiment.
    fn description(&self) -> Description;

    /// Return the variables, in the order of their value references.
    ///
    /// The list may depend on the resources, but on nothing that changes later. The export reads start values through
    /// it.
    fn variables(&self) -> Vec<Variable<Self>>;

    /// Compute all outputs for the present parameters and inputs.
    ///
    /// The export calls it at the end of initialisation, and during initialisation before it reads outputs after a
    /// change. The number of calls must not matter. After an error the model must be unchanged.
    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String>;

    /// Advance from `t` to exactly `t + h`, s.
    ///
    /// After an error the model must be unchanged, so that a master can restore a state and try a smaller step.
    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String>;

    /// Return the approximate size of a copy of the state, bytes; the export reserves it before a copy.
    fn state_bytes(&self) -> usize {
        size_of::<Self::State>()
    }

    /// Return a copy of the state.
    fn save(&self) -> Self::State;

    /// Restore a state, possibly of another instance or process, in a model that may only be loaded.
    ///
    /// The export has set the parameters before, and sets the inputs afterwards. Results of
    /// [`initialise`](Model::initialise) must be part of the state or be recomputed here. Serialized bytes may hold an
    /// invalid state. After an error the export accepts only another state or `fmi2Reset`.
    fn restore(&mut self, state: &Self::State) -> Result<(), String>;

    /// Return why outputs are not finite, where the model knows; the message about them ends with it.
    fn fault(&self) -> Option<String> {
        None
    }

    /// Return shape, slow axis first, and values of a field of up to three axes such as a vorticity.
    ///
    /// A host that knows the library reads the field by `fmu_field`, see [`export_fmu!`](crate::export_fmu).
    #[expect(unused_variables, reason = "the default has no field")]
    fn field(&mut self, name: &str) -> Option<(Vec<usize>, Vec<f64>)> {
        None
    }
}
