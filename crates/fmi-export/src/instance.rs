//! One instance of an FMU: everything behind the C functions that touches no raw pointer.
//!
//! A method that refuses its arguments leaves the instance as it was; one whose model fails puts it into the error
//! state.

use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::Path;

use crate::description::{self, Document};
use crate::identity;
use crate::log::Log;
use crate::memory::require_memory;
use crate::model::{Model, Span};
use crate::resource::Resources;
use crate::snapshot::{Clock, Origin, Snapshot};
use crate::state_machine::{self, Function, Mode};
use crate::table::{Run, Table};
use crate::variable::{Causality, Value, Variability, Variable};
use crate::version::Version;

pub(crate) struct Instance<M: Model> {
    pub log: Log,
    resources: Resources,
    origin: Origin,
    model: M,
    table: Table<M>,
    clock: Clock,
    /// Whether outputs are still to be made from what was set during initialisation.
    stale: bool,
    /// The FMU states given out, by the number that a master holds as a pointer: the address of the snapshot, so that
    /// the states of two instances never share a number.
    snapshots: BTreeMap<usize, Box<Snapshot<M::State>>>,
    /// What `GetString` returned last, kept alive until its next call.
    pub strings: Vec<CString>,
}

/// Shape and values of a field to look at.
type Field = ([usize; 2], Vec<f64>);

/// Masters add up their steps: times within this share of the larger of time and step are the same.
const TIME_TOLERANCE: f64 = 1e-9;

const START: Clock = Clock { mode: Mode::Instantiated, time: 0.0, stop: None };

/// A model with its table and description.
pub(crate) fn load<M: Model>(resources: &Resources, version: Version) -> Result<(M, Table<M>, Document), String> {
    let mut model = M::load(resources)?;
    let table = Table::new(model.variables(), version)?;
    let document = description::document(&table, &mut model, resources)?;
    Ok((model, table, document))
}

/// What an instance begins with.
pub(crate) struct Loaded<M: Model> {
    resources: Resources,
    origin: Origin,
    model: M,
    table: Table<M>,
}

/// The model in a folder of resources, which must be the one that the master read the description of.
pub(crate) fn load_described<M: Model>(
    folder: Option<&Path>,
    guid: &str,
    version: Version,
) -> Result<Loaded<M>, String> {
    let resources = Resources::read(folder, M::RESOURCES)?;
    identity::check_origin::<M>(guid, &resources)?;
    let (model, table, document) = load::<M>(&resources, version)?;
    if document.guid != guid {
        return Err(format!("the GUID {guid} belongs to another model description than that of {}", document.guid));
    }
    let name = format!("{} by {}", model.description().model_name, identity::maker::<M>());
    if name.len() > usize::from(u16::MAX) {
        return Err(format!("the name of the model has {} bytes, but may have {}", name.len(), u16::MAX));
    }
    Ok(Loaded { resources, origin: Origin { name, guid: guid.to_string() }, model, table })
}

/// Room for a state that grows while it is made, by the size of the state: the vector that it is written to doubles.
const SERIALIZED: usize = 4;

impl<M: Model> Instance<M> {
    pub fn new(log: Log, Loaded { resources, origin, model, table }: Loaded<M>) -> Self {
        let (snapshots, strings) = (BTreeMap::new(), Vec::new());
        Instance { log, resources, origin, model, table, clock: START, stale: true, snapshots, strings }
    }

    pub fn check_order(&self, function: Function) -> Result<(), String> {
        state_machine::check(function, self.clock.mode)
    }

    /// The model is no longer to be trusted.
    pub fn panicked(&mut self) {
        self.clock.mode = Mode::Panicked;
    }

    /// Last communication point reached, s.
    pub fn time(&self) -> f64 {
        self.clock.time
    }

    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), String> {
        if !start.is_finite() {
            return Err(format!("startTime = {start:.3e} must be finite"));
        }
        if let Some(stop) = stop
            && !(stop.is_finite() && stop > start)
        {
            return Err(format!("stopTime = {stop:.3e} must be finite and greater than startTime = {start:.3e}"));
        }
        self.clock.time = start;
        self.clock.stop = stop;
        Ok(())
    }

    pub fn enter_initialization(&mut self) {
        self.clock.mode = Mode::Initialization;
    }

    pub fn exit_initialization(&mut self) -> Result<(), String> {
        let result = self.refresh();
        self.clock.mode = if result.is_ok() { Mode::StepComplete } else { Mode::Error };
        result
    }

    /// Makes the outputs valid for what was set, where initialisation has not ended.
    fn refresh(&mut self) -> Result<(), String> {
        if self.stale && !self.initialised() {
            self.model.initialise(self.clock.time, &self.log)?;
            self.stale = false;
        }
        Ok(())
    }

    pub fn terminate(&mut self) {
        self.clock.mode = Mode::Terminated;
    }

    pub fn reset(&mut self) -> Result<(), String> {
        self.reload()?;
        self.clock = START;
        Ok(())
    }

    fn reload(&mut self) -> Result<(), String> {
        self.model = M::load(&self.resources)?;
        self.table = Table::new(self.model.variables(), self.table.version)?;
        self.stale = true;
        Ok(())
    }

    pub fn step(&mut self, time: f64, step: f64) -> Result<(), String> {
        let now = self.clock.time;
        if !(step.is_finite() && step > 0.0) {
            return Err(format!("communicationStepSize = {step:.3e} must be finite and > 0"));
        }
        let tolerance = TIME_TOLERANCE * now.abs().max(step);
        if !time.is_finite() || (time - now).abs() > tolerance {
            let off = time - now;
            return Err(format!(
                "currentCommunicationPoint = {time:.3e} must be the instance's time {now:.3e}, but is off by {off:.3e}"
            ));
        }
        let end = time + step;
        if let Some(stop) = self.clock.stop
            && end > stop + tolerance
        {
            let past = end - stop;
            return Err(format!(
                "the step of {step:.3e} from {time:.3e} must not pass stopTime = {stop:.3e}, but does by {past:.3e}"
            ));
        }
        let result = self.model.step(time, step, &self.log);
        match result {
            Ok(()) => self.clock.time = end,
            Err(_) => self.clock.mode = Mode::Error,
        }
        result
    }

    /// Refuses references that are no variables of a type of FMI 3.0, or that have not `n` values together.
    pub fn check_whole(&self, references: &[u32], type_name: &str, n: usize) -> Result<(), String> {
        let mut total = 0;
        for run in self.table.runs(references) {
            let run = run?;
            if self.table.variables[run.variable].type_name(self.table.version) != type_name {
                return Err(self.table.wrong_type(&run, type_name));
            }
            total += run.elements.len();
        }
        check_count("nValues", n, total)
    }

    /// Reads values: `sink` receives them in pieces, each with its position in `references`. A Real that is not finite
    /// is an error, so that no NaN passes silently.
    pub fn get<T: Value>(&mut self, references: &[u32], mut sink: impl FnMut(usize, &[T])) -> Result<(), String> {
        let clock = [self.clock.time];
        if !self.initialised() && self.table.runs(references).flatten().any(|run| self.is_calculated(&run)) {
            self.refresh()?;
        }
        for run in self.table.runs(references) {
            let run = run?;
            let values = self
                .table
                .read::<T>(run.variable, &mut self.model, &clock)?
                .ok_or_else(|| self.table.wrong_type(&run, T::TYPE))?;
            let values = &values[run.elements.clone()];
            self.table.variables[run.variable].check_finite(values, run.elements.start)?;
            sink(run.position, values);
        }
        Ok(())
    }

    fn is_calculated(&self, run: &Run) -> bool {
        let Variable { causality, variability, .. } = self.table.variables[run.variable];
        matches!(causality, Causality::Output | Causality::Local | Causality::CalculatedParameter)
            && variability != Variability::Constant
    }

    /// Writes values: all or, if one is refused, none.
    pub fn set<T: Value + Clone>(&mut self, references: &[u32], values: &[T]) -> Result<(), String> {
        for run in self.table.runs(references) {
            let run = run?;
            self.check_settable::<T>(&run)?;
            let piece = &values[run.position..][..run.elements.len()];
            self.table.variables[run.variable].check(piece, run.elements.start)?;
        }
        for run in self.table.runs(references) {
            let run = run?;
            let variable = &self.table.variables[run.variable];
            let target = T::field(&variable.access)
                .and_then(|field| field.write(&mut self.model))
                .ok_or_else(|| format!("{} cannot be set", variable.name))?;
            variable.checked_length(target.len())?;
            let length = run.elements.len();
            target[run.elements].clone_from_slice(&values[run.position..][..length]);
        }
        self.stale = true;
        Ok(())
    }

    fn check_settable<T: Value>(&self, run: &Run) -> Result<(), String> {
        let variable = &self.table.variables[run.variable];
        if T::TYPE != variable.access.type_name() {
            return Err(self.table.wrong_type(run, T::TYPE));
        }
        let Variable { causality, variability, .. } = variable;
        match causality {
            Causality::Input => Ok(()),
            Causality::Parameter if *variability == Variability::Tunable || !self.initialised() => Ok(()),
            Causality::Parameter => {
                Err(format!("parameter {} is fixed once initialisation has ended", self.table.name(run)))
            }
            Causality::Output | Causality::Local | Causality::CalculatedParameter | Causality::Independent => {
                Err(format!("{} {} cannot be set", causality.name(), self.table.name(run)))
            }
        }
    }

    fn initialised(&self) -> bool {
        !matches!(self.clock.mode, Mode::Instantiated | Mode::Initialization)
    }

    /// `d unknown / d known` times `seed`: `n` values.
    pub fn directional_derivative(
        &mut self,
        unknown: &[u32],
        known: &[u32],
        seed: &[f64],
        n: usize,
    ) -> Result<Vec<f64>, String> {
        self.prepare_derivative()?;
        let unknown = self.table.spans(unknown, Causality::Output)?;
        let known = self.table.spans(known, Causality::Input)?;
        check_count("nSeed", seed.len(), count(&known))?;
        check_count("nSensitivity", n, count(&unknown))?;
        let mut derivative = vec![0.0; n];
        self.model.directional_derivative(&unknown, &known, seed, &mut derivative)?;
        check_derivative(&derivative)?;
        Ok(derivative)
    }

    /// `seed` times `d unknown / d known`: `n` values, each from the directional derivative along one known.
    pub fn adjoint_derivative(
        &mut self,
        unknown: &[u32],
        known: &[u32],
        seed: &[f64],
        n: usize,
    ) -> Result<Vec<f64>, String> {
        self.prepare_derivative()?;
        let unknown = self.table.spans(unknown, Causality::Output)?;
        let known = self.table.spans(known, Causality::Input)?;
        check_count("nSeed", seed.len(), count(&unknown))?;
        check_count("nSensitivity", n, count(&known))?;
        let (mut column, mut direction, mut derivative) = (vec![0.0; seed.len()], vec![0.0; n], Vec::new());
        for k in 0..n {
            direction[k] = 1.0;
            self.model.directional_derivative(&unknown, &known, &direction, &mut column)?;
            direction[k] = 0.0;
            derivative.push(seed.iter().zip(&column).map(|(seed, value)| seed * value).sum());
        }
        check_derivative(&derivative)?;
        Ok(derivative)
    }

    fn prepare_derivative(&mut self) -> Result<(), String> {
        if !M::DIRECTIONAL_DERIVATIVE {
            return Err("directional derivatives are not provided".into());
        }
        self.refresh()
    }

    /// Time derivatives of outputs, `n` values.
    pub fn output_derivatives(&mut self, outputs: &[u32], orders: &[i32], n: usize) -> Result<Vec<f64>, String> {
        if !M::OUTPUT_DERIVATIVE {
            return Err("output derivatives are not provided".into());
        }
        check_first_order(orders)?;
        let spans = self.table.spans(outputs, Causality::Output)?;
        check_count("nValues", n, count(&spans))?;
        let mut derivative = vec![0.0; n];
        let mut rest = &mut *derivative;
        for span in spans {
            let piece = rest.split_off_mut(..span.elements.len()).expect("as many values as elements");
            self.model.output_derivative(&span, piece)?;
        }
        check_derivative(&derivative)?;
        Ok(derivative)
    }

    pub fn set_input_derivatives(&mut self, inputs: &[u32], orders: &[i32], derivative: &[f64]) -> Result<(), String> {
        if !M::INPUT_DERIVATIVE {
            return Err("input derivatives are not used".into());
        }
        check_first_order(orders)?;
        check_derivative(derivative)?;
        let mut rest = derivative;
        for span in self.table.spans(inputs, Causality::Input)? {
            let piece = rest.split_off(..span.elements.len()).expect("one value per reference");
            self.model.set_input_derivative(&span, piece)?;
        }
        Ok(())
    }

    /// Keeps the present state, in the place of `handle` if it is not zero. Returns its handle.
    pub fn save(&mut self, handle: usize) -> Result<usize, String> {
        require_memory(self.model.state_bytes())?;
        let snapshot = Snapshot { clock: self.clock, model: self.model.save() };
        self.keep(handle, snapshot)
    }

    /// A field to look at.
    pub fn field(&mut self, name: &str) -> Result<Option<Field>, String> {
        self.refresh()?;
        require_memory(self.model.state_bytes())?;
        Ok(self.model.field(name))
    }

    pub fn restore(&mut self, handle: usize) -> Result<(), String> {
        if self.clock.mode == Mode::Panicked {
            self.reload()?;
        }
        let snapshot = find(&self.snapshots, handle)?;
        self.stale = true;
        let result = self.model.restore(&snapshot.model);
        self.clock = match &result {
            Ok(()) => snapshot.clock,
            Err(_) => Clock { mode: Mode::Panicked, ..self.clock },
        };
        result.map_err(|message| format!("the state is refused: {message}"))
    }

    pub fn free(&mut self, handle: usize) -> Result<(), String> {
        find(&self.snapshots, handle)?;
        self.snapshots.remove(&handle);
        Ok(())
    }

    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, String> {
        require_memory(SERIALIZED * self.model.state_bytes())?;
        find(&self.snapshots, handle)?.to_bytes(&self.origin)
    }

    /// Keeps a serialized state, in the place of `handle` if it is not zero. Returns its handle.
    pub fn deserialize(&mut self, bytes: &[u8], handle: usize) -> Result<usize, String> {
        require_memory(SERIALIZED * bytes.len())?;
        self.keep(handle, Snapshot::from_bytes(bytes, &self.origin)?)
    }

    fn keep(&mut self, handle: usize, snapshot: Snapshot<M::State>) -> Result<usize, String> {
        if handle == 0 {
            let snapshot = Box::new(snapshot);
            let handle = (&raw const *snapshot).addr();
            self.snapshots.insert(handle, snapshot);
            return Ok(handle);
        }
        let place = self.snapshots.get_mut(&handle).ok_or_else(|| unknown_state(handle))?;
        **place = snapshot;
        Ok(handle)
    }
}

fn find<S>(snapshots: &BTreeMap<usize, Box<Snapshot<S>>>, handle: usize) -> Result<&Snapshot<S>, String> {
    snapshots.get(&handle).map(Box::as_ref).ok_or_else(|| unknown_state(handle))
}

fn unknown_state(handle: usize) -> String {
    format!("FMU state {handle:#x} is not one of this instance")
}

/// Number of values of some variables.
fn count(spans: &[Span]) -> usize {
    spans.iter().map(|span| span.elements.len()).sum()
}

/// Refuses an array of another length than that of the variables; in FMI 2.0 both are the same.
fn check_count(name: &str, n: usize, expected: usize) -> Result<(), String> {
    match n == expected {
        true => Ok(()),
        false => Err(format!("{name} = {n} must be {expected}, the number of values of the variables")),
    }
}

fn check_derivative(derivative: &[f64]) -> Result<(), String> {
    match derivative.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(format!("the derivative {value:.3e} is not finite")),
    }
}

fn check_first_order(orders: &[i32]) -> Result<(), String> {
    match orders.iter().find(|order| **order != 1) {
        None => Ok(()),
        Some(order) => Err(format!("the derivative's order {order} must be 1")),
    }
}
