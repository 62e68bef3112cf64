//! The trait that a model implements.

use std::ops::Range;

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::description::Description;
use crate::log::Log;
use crate::resource::Resources;
use crate::variable::Variable;

/// A co-simulation unit: what [`export_fmu!`](crate::export_fmu) makes an FMU of.
///
/// The glue owns time, call order, argument checks, logging and the FMU state; the model owns its numbers.
/// Every error is a sentence naming the variable, the value and the limit; it reaches the master's logger.
pub trait Model: Sized + 'static {
    /// Name of the shared library in the FMU's `binaries` folder, without its ending.
    const IDENTIFIER: &'static str;

    /// Version of the library, `env!("CARGO_PKG_VERSION")` as a rule. It is part of the GUID.
    const VERSION: &'static str;

    /// To be raised whenever [`State`](Model::State) changes: a state of another layout is refused by its GUID.
    const STATE_LAYOUT: u32 = 1;

    /// Files in the FMU's folder `resources` that decide what the model is. They are part of the GUID: an FMU in which
    /// one was edited is refused before it is loaded.
    const RESOURCES: &'static [&'static str] = &[];

    /// [`directional_derivative`](Model::directional_derivative) is implemented.
    const DIRECTIONAL_DERIVATIVE: bool = false;

    /// [`output_derivative`](Model::output_derivative) is implemented.
    const OUTPUT_DERIVATIVE: bool = false;

    /// [`set_input_derivative`](Model::set_input_derivative) is implemented.
    const INPUT_DERIVATIVE: bool = false;

    /// Everything that decides the model's future: inputs, parameters and memory, but no scratch.
    type State: Clone + Serialize + DeserializeOwned;

    /// Makes the model as it is before a master sets anything. Called at instantiation and again by `fmi2Reset`, with
    /// the same resources; an error refuses the instance. What is large asks for its memory first
    /// ([`require_memory`](crate::require_memory)).
    fn load(resources: &Resources) -> Result<Self, String>;

    /// Name, text and default experiment.
    fn description(&self) -> Description;

    /// The variables, in the order of their value references. The list may depend on what was loaded (array lengths,
    /// parts that are present), and on nothing that changes later. Start values are read through it.
    fn variables(&self) -> Vec<Variable<Self>>;

    /// Makes all outputs valid for the parameters and inputs that are set. Called when initialisation ends, and before,
    /// whenever outputs are asked for after something was set; it must not matter how often. On an error the model must
    /// be as it was.
    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String>;

    /// Advances from `t` to exactly `t + h`, in s. On an error the model must be as it was before the call, so that
    /// a master may restore a state and try a smaller step. No glue can check that.
    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String>;

    /// Bytes that a copy of the state takes, about; the glue asks for them before it copies or serializes one.
    fn state_bytes(&self) -> usize {
        size_of::<Self::State>()
    }

    /// Copies out the state.
    fn save(&self) -> Self::State;

    /// Puts a state back. It may come from another instance or process and meet a model that was only loaded: what
    /// [`initialise`](Model::initialise) computes must be in the state, or be recomputed here. What was made by somebody else
    /// may be no state of this model: after an error the glue lets nothing but another state or `fmi2Reset` happen.
    fn restore(&mut self, state: &Self::State) -> Result<(), String>;

    /// Directional derivative of outputs with respect to inputs: `derivative = (d unknown / d known) seed`. `seed` and
    /// `derivative` hold the spans' elements one after the other.
    #[expect(unused_variables, reason = "the default supports nothing")]
    fn directional_derivative(
        &mut self,
        unknown: &[Span],
        known: &[Span],
        seed: &[f64],
        derivative: &mut [f64],
    ) -> Result<(), String> {
        Err("directional derivatives are not provided".into())
    }

    /// Time derivative of outputs at the current time, in the output's unit per second.
    #[expect(unused_variables, reason = "the default supports nothing")]
    fn output_derivative(&mut self, outputs: &Span, derivative: &mut [f64]) -> Result<(), String> {
        Err("output derivatives are not provided".into())
    }

    /// Time derivative of inputs at the current time, in the input's unit per second, to be used in the next step only.
    #[expect(unused_variables, reason = "the default supports nothing")]
    fn set_input_derivative(&mut self, inputs: &Span, derivative: &[f64]) -> Result<(), String> {
        Err("input derivatives are not used".into())
    }

    /// A two-dimensional field to look at, such as a flow's vorticity: its shape, slow axis first, and its values. FMI 2.0
    /// has no arrays of that size; hosts that know the library get it from `fmu_field`, see
    /// [`export_fmu!`](crate::export_fmu).
    #[expect(unused_variables, reason = "the default shows nothing")]
    fn field(&mut self, name: &str) -> Option<([usize; 2], Vec<f64>)> {
        None
    }
}

/// Neighbouring elements of one variable: `x[3]` to `x[5]` are `name = "x"`, `elements = 2..5`. A scalar is `0..1`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span<'a> {
    /// Name in the list of variables.
    pub name: &'a str,
    /// Elements, counted from zero.
    pub elements: Range<usize>,
}
