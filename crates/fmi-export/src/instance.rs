//! Instance of an FMU: the part of the C functions without raw pointers.
//!
//! A method that refuses its arguments leaves the instance unchanged. A failure of the model puts the instance into the
//! error state.

use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::Path;

use crate::access::Value;
use crate::description::{self, Document};
use crate::identity;
use crate::log::Log;
use crate::memory::require_memory;
use crate::model::Model;
use crate::resource::Resources;
use crate::settings::Settings;
use crate::snapshot::{InstanceTime, Origin, Snapshot};
use crate::state_machine::{self, Function, Mode};
use crate::table::{Run, Table};
use crate::variable::{Causality, Variability, Variable};
use crate::version::Version;

/// Instance of the model `M`.
pub(crate) struct Instance<M: Model> {
    pub log: Log,
    resources: Resources,
    origin: Origin,
    model: M,
    table: Table<M>,
    time: InstanceTime,
    /// Whether outputs are older than the values set during initialisation.
    stale: bool,
    /// FMU states by the handle that a master holds as a pointer.
    ///
    /// The handle is the address of the snapshot, so handles of two instances differ.
    snapshots: BTreeMap<usize, Box<Snapshot<M::State>>>,
    /// Results of the last `GetString`, valid until its next call.
    pub strings: Vec<CString>,
}

/// Shape and values of a field.
type Field = (Vec<usize>, Vec<f64>);

/// Tolerance for the sums of steps in masters, relative to the larger of time and step.
const TIME_TOLERANCE: f64 = 1e-9;

/// Mode and time of a new instance.
const START: InstanceTime = InstanceTime { mode: Mode::Instantiated, time: 0.0, stop: None };

/// Load a model, without what only an instance needs, and return it with its table and description.
pub(crate) fn load<M: Model>(resources: &Resources, version: Version) -> Result<(M, Table<M>, Document), String> {
    let mut model = M::load(resources)?;
    let table = Table::new(model.variables(), version)?;
    let document = description::document(&table, &mut model, resources)?;
    Ok((model, table, document))
}

/// Contents of a new instance.
pub(crate) struct Loaded<M: Model> {
    resources: Resources,
    origin: Origin,
    model: M,
    table: Table<M>,
}

/// Load the model of a folder of resources; refuse the GUID of another description.
pub(crate) fn load_described<M: Model>(
    folder: Option<&Path>,
    guid: &str,
    version: Version,
) -> Result<Loaded<M>, String> {
    let resources = Resources::read(folder, M::RESOURCES)?;
    identity::check_origin::<M>(guid, &resources)?;
    let (mut model, table, document) = load::<M>(&resources, version)?;
    if document.guid != guid {
        return Err(format!(
            "the GUID {guid} belongs to another model description, whose GUID is not {}",
            document.guid
        ));
    }
    let name = format!("{} by {}", model.description().model_name, identity::maker::<M>());
    if name.len() > usize::from(u16::MAX) {
        return Err(format!("the name of the model has {} bytes, but at most {} are allowed", name.len(), u16::MAX));
    }
    model.build()?;
    Ok(Loaded { resources, origin: Origin { name, guid: guid.to_string() }, model, table })
}

/// Memory to serialize a state, relative to its size: the vector of bytes doubles as it grows.
const SERIALIZED: usize = 4;

impl<M: Model> Instance<M> {
    /// Return a new instance.
    pub fn new(log: Log, Loaded { resources, origin, model, table }: Loaded<M>) -> Self {
        let (snapshots, strings) = (BTreeMap::new(), Vec::new());
        Instance { log, resources, origin, model, table, time: START, stale: true, snapshots, strings }
    }

    /// Refuse a function that the mode does not allow.
    pub fn check_order(&self, function: Function) -> Result<(), String> {
        state_machine::check(function, self.time.mode)
    }

    /// Mark the model as unusable after a panic.
    pub fn panicked(&mut self) {
        self.time.mode = Mode::Panicked;
    }

    /// Return the last communication point, s.
    pub fn time(&self) -> f64 {
        self.time.time
    }

    /// Set start and stop time, s.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), String> {
        if !start.is_finite() {
            return Err(format!("startTime = {start:.3e} must be finite"));
        }
        if let Some(stop) = stop
            && !(stop.is_finite() && stop > start)
        {
            return Err(format!("stopTime = {stop:.3e} must be finite and greater than startTime = {start:.3e}"));
        }
        self.time.time = start;
        self.time.stop = stop;
        self.stale = true;
        Ok(())
    }

    /// Enter the initialization mode.
    pub fn enter_initialization(&mut self) {
        self.time.mode = Mode::Initialization;
    }

    /// Initialise the model and leave the initialization mode.
    pub fn exit_initialization(&mut self) -> Result<(), String> {
        let result = self.refresh();
        self.time.mode = if result.is_ok() { Mode::StepComplete } else { Mode::Error };
        result
    }

    /// Initialise the model again, before the end of initialisation, if values were set.
    fn refresh(&mut self) -> Result<(), String> {
        if self.stale && !self.initialised() {
            self.model.initialise(self.time.time, &self.log)?;
            self.stale = false;
        }
        Ok(())
    }

    /// End the simulation.
    pub fn terminate(&mut self) {
        self.time.mode = Mode::Terminated;
    }

    /// Return to the state after instantiation.
    pub fn reset(&mut self) -> Result<(), String> {
        self.reload()?;
        self.time = START;
        Ok(())
    }

    /// Load the model again.
    fn reload(&mut self) -> Result<(), String> {
        let mut model = M::load(&self.resources)?;
        let table = Table::new(model.variables(), self.table.version)?;
        model.build()?;
        (self.model, self.table) = (model, table);
        self.stale = true;
        Ok(())
    }

    /// Advance by `step`, s, from `time`, s.
    pub fn step(&mut self, time: f64, step: f64) -> Result<(), String> {
        let now = self.time.time;
        if !(step.is_finite() && step > 0.0) {
            return Err(format!("communicationStepSize = {step:.3e} must be finite and > 0"));
        }
        let tolerance = TIME_TOLERANCE * now.abs().max(step);
        if !time.is_finite() || (time - now).abs() > tolerance {
            let off = time - now;
            return Err(format!(
                "currentCommunicationPoint = {time:.3e} must be the time of the instance, {now:.3e}, but differs by \
                 {off:.3e}"
            ));
        }
        let end = time + step;
        if let Some(stop) = self.time.stop
            && end > stop + tolerance
        {
            let past = end - stop;
            return Err(format!(
                "the step of {step:.3e} from {time:.3e} must not pass stopTime = {stop:.3e}, but passes it by \
                 {past:.3e}"
            ));
        }
        let result = self.model.step(time, step, &self.log);
        match result {
            Ok(()) => self.time.time = end,
            Err(_) => self.time.mode = Mode::Error,
        }
        result
    }

    /// Refuse references to variables of another FMI 3.0 type, and a total number of values other than `n`.
    pub fn check_references(&self, references: &[u32], type_name: &str, n: usize) -> Result<(), String> {
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

    /// Read values: `sink` receives pieces, each with its position in the array of values.
    ///
    /// A Real that is not finite is an error.
    pub fn get<T: Value>(&mut self, references: &[u32], mut sink: impl FnMut(usize, &[T])) -> Result<(), String> {
        // Nothing is written before all references are known to be right.
        for run in self.table.runs(references) {
            let run = run?;
            if self.table.variables[run.variable].access.type_name() != T::TYPE {
                return Err(self.table.wrong_type(&run, T::TYPE));
            }
        }
        if !self.initialised() && self.table.runs(references).flatten().any(|run| self.is_calculated(&run)) {
            self.refresh()?;
        }
        for run in self.table.runs(references) {
            let run = run?;
            let read = self.table.read::<T, _>(run.variable, &mut self.model, self.time.time, |values| {
                let values = &values[run.elements.clone()];
                self.table.variables[run.variable].check_finite(values, run.elements.start)?;
                sink(run.position, values);
                Ok(())
            });
            read.map_err(|refused: String| match self.model.fault() {
                Some(fault) => format!("{refused}: {fault}"),
                None => refused,
            })?;
        }
        Ok(())
    }

    /// Whether a variable depends on values set during initialisation.
    fn is_calculated(&self, run: &Run) -> bool {
        let Variable { causality, variability, .. } = self.table.variables[run.variable];
        matches!(causality, Causality::Output | Causality::Local | Causality::CalculatedParameter)
            && variability != Variability::Constant
    }

    /// Write all values, or none if one is refused.
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
            variable.check_length(target.len())?;
            let length = run.elements.len();
            target[run.elements].clone_from_slice(&values[run.position..][..length]);
        }
        self.stale = true;
        Ok(())
    }

    /// Refuse a variable of another type and a variable that the mode does not let a master set.
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

    /// Whether initialisation has ended.
    fn initialised(&self) -> bool {
        !matches!(self.time.mode, Mode::Instantiated | Mode::Initialization)
    }

    /// Store the present state and return its handle; a `handle` other than 0 is reused.
    ///
    /// Before the end of initialisation the model is initialised first: values that do not fit would make a state that
    /// cannot be restored.
    pub fn save(&mut self, handle: usize) -> Result<usize, String> {
        self.refresh()?;
        require_memory(self.model.state_bytes())?;
        let [parameters, inputs] = [Causality::Parameter, Causality::Input]
            .map(|causality| Settings::of(&self.table, &mut self.model, causality));
        self.keep(handle, Snapshot { instance: self.time, parameters, inputs, model: self.model.save() })
    }

    /// Return a field of the model.
    pub fn field(&mut self, name: &str) -> Result<Option<Field>, String> {
        self.refresh()?;
        require_memory(self.model.state_bytes())?;
        Ok(self.model.field(name))
    }

    /// Restore a stored state.
    pub fn restore(&mut self, handle: usize) -> Result<(), String> {
        if self.time.mode == Mode::Panicked {
            self.reload()?;
        }
        let snapshot = find(&self.snapshots, handle)?;
        self.stale = true;
        let Snapshot { instance, parameters, inputs, model } = snapshot;
        let result = parameters
            .apply(&self.table, &mut self.model, Causality::Parameter)
            .and_then(|()| self.model.restore(model))
            .and_then(|()| inputs.apply(&self.table, &mut self.model, Causality::Input));
        self.time = match &result {
            Ok(()) => *instance,
            Err(_) => InstanceTime { mode: Mode::Panicked, ..self.time },
        };
        result.map_err(|message| format!("the state is refused: {message}"))
    }

    /// Free a stored state.
    pub fn free(&mut self, handle: usize) -> Result<(), String> {
        find(&self.snapshots, handle)?;
        self.snapshots.remove(&handle);
        Ok(())
    }

    /// Return a stored state as bytes.
    pub fn serialize(&self, handle: usize) -> Result<Vec<u8>, String> {
        require_memory(SERIALIZED * self.model.state_bytes())?;
        find(&self.snapshots, handle)?.to_bytes(&self.origin)
    }

    /// Store a serialized state and return its handle; a `handle` other than 0 is reused.
    pub fn deserialize(&mut self, bytes: &[u8], handle: usize) -> Result<usize, String> {
        require_memory(SERIALIZED * bytes.len())?;
        self.keep(handle, Snapshot::from_bytes(bytes, &self.origin)?)
    }

    /// Store a snapshot under `handle`, or under a new handle for 0; return the handle.
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
    format!("FMU state {handle:#x} does not belong to this instance")
}

/// Refuse a number of values other than the total length of the variables.
fn check_count(name: &str, n: usize, expected: usize) -> Result<(), String> {
    match n == expected {
        true => Ok(()),
        false => Err(format!("{name} = {n} must be {expected}, the total number of values of the variables")),
    }
}
