//! Master of the model that is linked in, through its C functions alone, in FMI 2.0.
#![allow(dead_code, reason = "each program uses a part")]

pub mod description;
pub mod logger;

use std::ffi::{CStr, CString};
use std::path::Path;
use std::ptr::null;

use description::{attribute, written};
use logger::{Messages, callbacks};
use nervure_fmi_export::sys::*;

macro_rules! import {
    ($($name:ident($($argument:ident: $type:ty),*) -> $result:ty;)*) => {
        // SAFETY: the signatures are those of the headers. Declared safe because every call of the programs passes
        // pointers that are null or valid for the length it states; refusing them is what the programs are about.
        unsafe extern "C" {
            $(pub safe fn $name($($argument: $type),*) -> $result;)*
        }
    };
}

nervure_fmi_export::__functions! { import, }

pub const OK: fmi2Status = fmi2Status::fmi2OK;
pub const ERROR: fmi2Status = fmi2Status::fmi2Error;
pub const CO_SIMULATION: fmi2Type = fmi2Type::fmi2CoSimulation;

/// Return a pointer to a string; null for none.
pub fn pointer(string: Option<&CStr>) -> *const fmi2Char {
    string.map_or(null(), CStr::as_ptr)
}

/// Return a path or text for C.
pub fn c_string(text: impl ToString) -> CString {
    CString::new(text.to_string()).expect("no text of a test has a NUL")
}

/// Return the model description for a folder of resources, or the message of its refusal.
pub fn describe(resources: Option<&CStr>) -> Result<String, String> {
    written(|buffer, capacity, needed| fmu_model_description(pointer(resources), buffer, capacity, needed))
}

/// Return the GUID of the model without resources.
pub fn guid() -> CString {
    c_string(attribute(&describe(None).expect("the model has a description"), "guid"))
}

/// Return an instance, or null.
pub fn instantiate(
    name: Option<&CStr>,
    kind: fmi2Type,
    guid: Option<&CStr>,
    resources: Option<&CStr>,
    functions: *const fmi2CallbackFunctions,
) -> fmi2Component {
    fmi2Instantiate(pointer(name), kind, pointer(guid), pointer(resources), functions, 0, 0)
}

/// Instance, freed at the end. The pointers of its methods are valid.
pub struct Fmu {
    pub c: fmi2Component,
    pub messages: Box<Messages>,
}

impl Fmu {
    /// Return an instance of a model without resources.
    pub fn new() -> Self {
        Self::of(&describe(None).expect("the model has a description"), None)
    }

    /// Return an instance of the model with this description, whose resources are in `folder`.
    pub fn of(xml: &str, folder: Option<&Path>) -> Self {
        let messages = Box::<Messages>::default();
        let guid = c_string(attribute(xml, "guid"));
        let location = folder.map(|folder| c_string(format!("file://{}", folder.display())));
        let c = instantiate(Some(c"one"), CO_SIMULATION, Some(&guid), location.as_deref(), &callbacks(&messages));
        assert!(!c.is_null(), "a model with a description has an instance: {messages:?}");
        Fmu { c, messages }
    }

    /// Return an instance initialised at time 0 without a stop time.
    pub fn initialised() -> Self {
        let fmu = Self::new();
        assert_eq!([fmu.setup(0.0, None), fmu.enter(), fmu.exit()], [OK; 3], "{:?}", fmu.messages);
        fmu
    }

    pub fn setup(&self, start: f64, stop: Option<f64>) -> fmi2Status {
        fmi2SetupExperiment(self.c, 0, 0.0, start, stop.is_some().into(), stop.unwrap_or(0.0))
    }

    pub fn enter(&self) -> fmi2Status {
        fmi2EnterInitializationMode(self.c)
    }

    pub fn exit(&self) -> fmi2Status {
        fmi2ExitInitializationMode(self.c)
    }

    pub fn step(&self, time: f64, step: f64) -> fmi2Status {
        fmi2DoStep(self.c, time, step, 1)
    }

    pub fn set(&self, references: &[u32], values: &[f64]) -> fmi2Status {
        assert_eq!(references.len(), values.len());
        fmi2SetReal(self.c, references.as_ptr(), references.len(), values.as_ptr())
    }

    pub fn read(&self, references: &[u32], values: &mut [f64]) -> fmi2Status {
        assert_eq!(references.len(), values.len());
        fmi2GetReal(self.c, references.as_ptr(), references.len(), values.as_mut_ptr())
    }

    pub fn try_get<const N: usize>(&self, references: [u32; N]) -> (fmi2Status, [f64; N]) {
        let mut values = [f64::NAN; N];
        (self.read(&references, &mut values), values)
    }

    pub fn get<const N: usize>(&self, references: [u32; N]) -> [f64; N] {
        let (status, values) = self.try_get(references);
        assert_eq!(status, OK, "{:?}", self.messages);
        values
    }

    /// Store the state at `state`, a new one for null.
    pub fn save(&self, state: &mut fmi2FMUstate) -> fmi2Status {
        fmi2GetFMUstate(self.c, state)
    }

    pub fn restore(&self, state: fmi2FMUstate) -> fmi2Status {
        fmi2SetFMUstate(self.c, state)
    }

    pub fn free(&self, state: &mut fmi2FMUstate) -> fmi2Status {
        fmi2FreeFMUstate(self.c, state)
    }

    pub fn serialize(&self, state: fmi2FMUstate) -> Vec<u8> {
        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(self.c, state, &mut size), OK, "{:?}", self.messages);
        let mut bytes = vec![0u8; size];
        let status = fmi2SerializeFMUstate(self.c, state, bytes.as_mut_ptr().cast(), size);
        assert_eq!(status, OK, "{:?}", self.messages);
        bytes
    }

    pub fn deserialize(&self, bytes: &[u8], state: &mut fmi2FMUstate) -> fmi2Status {
        fmi2DeSerializeFMUstate(self.c, bytes.as_ptr().cast(), bytes.len(), state)
    }

    /// Assert that a call was refused with a message that has all the parts.
    #[track_caller]
    pub fn assert_refused(&self, status: fmi2Status, parts: &[&str]) {
        assert_eq!(status, ERROR);
        let messages = self.messages.borrow();
        let last = messages.last().expect("a refusal is logged");
        assert!(parts.iter().all(|part| last.contains(part)), "{parts:?} are not all in: {last}");
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        fmi2FreeInstance(self.c)
    }
}
