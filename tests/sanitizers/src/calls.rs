//! What a master does with a unit, and what it must not do: NULL, wrong sizes, wrong handles, wrong order.

use std::ffi::{CStr, CString, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};

use fmi_export::sys::*;

macro_rules! import {
    ($($name:ident($($type:ty),*) -> $result:ty;)*) => {
        // SAFETY: the signatures are those of the header. Declared safe because every call in this file passes pointers
        // that are null or valid for the length it states.
        unsafe extern "C" {
            $(safe fn $name($(_: $type),*) -> $result;)*
        }
    };
}

type Vr = *const fmi2ValueReference;

import! {
    fmi2SetDebugLogging(fmi2Component, fmi2Boolean, usize, *const fmi2String) -> fmi2Status;
    fmi2Instantiate(fmi2String, fmi2Type, fmi2String, fmi2String, *const fmi2CallbackFunctions, fmi2Boolean,
                    fmi2Boolean) -> fmi2Component;
    fmi2FreeInstance(fmi2Component) -> ();
    fmi2SetupExperiment(fmi2Component, fmi2Boolean, f64, f64, fmi2Boolean, f64) -> fmi2Status;
    fmi2EnterInitializationMode(fmi2Component) -> fmi2Status;
    fmi2ExitInitializationMode(fmi2Component) -> fmi2Status;
    fmi2Terminate(fmi2Component) -> fmi2Status;
    fmi2Reset(fmi2Component) -> fmi2Status;
    fmi2GetReal(fmi2Component, Vr, usize, *mut f64) -> fmi2Status;
    fmi2GetInteger(fmi2Component, Vr, usize, *mut i32) -> fmi2Status;
    fmi2GetBoolean(fmi2Component, Vr, usize, *mut fmi2Boolean) -> fmi2Status;
    fmi2GetString(fmi2Component, Vr, usize, *mut fmi2String) -> fmi2Status;
    fmi2SetReal(fmi2Component, Vr, usize, *const f64) -> fmi2Status;
    fmi2SetInteger(fmi2Component, Vr, usize, *const i32) -> fmi2Status;
    fmi2SetBoolean(fmi2Component, Vr, usize, *const fmi2Boolean) -> fmi2Status;
    fmi2SetString(fmi2Component, Vr, usize, *const fmi2String) -> fmi2Status;
    fmi2GetFMUstate(fmi2Component, *mut fmi2FMUstate) -> fmi2Status;
    fmi2SetFMUstate(fmi2Component, fmi2FMUstate) -> fmi2Status;
    fmi2FreeFMUstate(fmi2Component, *mut fmi2FMUstate) -> fmi2Status;
    fmi2SerializedFMUstateSize(fmi2Component, fmi2FMUstate, *mut usize) -> fmi2Status;
    fmi2SerializeFMUstate(fmi2Component, fmi2FMUstate, *mut fmi2Byte, usize) -> fmi2Status;
    fmi2DeSerializeFMUstate(fmi2Component, *const fmi2Byte, usize, *mut fmi2FMUstate) -> fmi2Status;
    fmi2GetDirectionalDerivative(fmi2Component, Vr, usize, Vr, usize, *const f64, *mut f64) -> fmi2Status;
    fmi2SetRealInputDerivatives(fmi2Component, Vr, usize, *const i32, *const f64) -> fmi2Status;
    fmi2GetRealOutputDerivatives(fmi2Component, Vr, usize, *const i32, *mut f64) -> fmi2Status;
    fmi2DoStep(fmi2Component, f64, f64, fmi2Boolean) -> fmi2Status;
    fmi2CancelStep(fmi2Component) -> fmi2Status;
    fmi2GetRealStatus(fmi2Component, fmi2StatusKind, *mut f64) -> fmi2Status;
    fmi2GetStringStatus(fmi2Component, fmi2StatusKind, *mut fmi2String) -> fmi2Status;
    fmu_model_description(fmi2String, *mut fmi2Char, usize, *mut usize) -> i32;
    fmu_field(fmi2Component, fmi2String, *mut f64, usize, *mut usize) -> i32;
}

const OK: fmi2Status = fmi2Status::fmi2OK;
const ERROR: fmi2Status = fmi2Status::fmi2Error;

/// Communication step, s, and a reference that no unit has.
const H: f64 = 4e-4;
const NOWHERE: u32 = u32::MAX;

unsafe extern "C" fn log(
    _environment: fmi2ComponentEnvironment,
    _instance_name: fmi2String,
    _status: fmi2Status,
    _category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the message is a string by the standard.
    eprintln!("  {}", unsafe { CStr::from_ptr(message) }.to_string_lossy());
}

/// The whole play with the unit of this program, whose resources hold `scene` as scene.json.
pub fn run(scene: &[u8]) {
    let folder = std::env::temp_dir().join(format!("sanitizers-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the folder can be made");
    std::fs::write(folder.join("scene.json"), scene).expect("the scene can be written");
    let (xml, guid) = description(&folder);
    let functions = callbacks();
    let make =
        |name: Option<&CStr>, guid: Option<&CStr>, place: Option<&CStr>, functions: *const fmi2CallbackFunctions| {
            let pointer = |string: Option<&CStr>| string.map_or(null(), CStr::as_ptr);
            fmi2Instantiate(pointer(name), fmi2Type::fmi2CoSimulation, pointer(guid), pointer(place), functions, 0, 1)
        };
    let place = CString::new(format!("file://{}", folder.display())).expect("without NUL");
    let (name, guid, place) = (Some(c"unit"), Some(guid.as_c_str()), Some(place.as_c_str()));
    let refused = [
        make(None, guid, place, &functions),
        make(name, None, place, &functions),
        make(name, Some(c"{}"), place, &functions),
        make(name, guid, None, &functions),
        make(name, guid, Some(c"file:///nowhere"), &functions),
        make(name, guid, place, null()),
    ];
    assert!(refused.iter().all(|c| c.is_null()));
    nothing(null_mut());
    fmi2FreeInstance(null_mut());

    let (one, other) = (make(name, guid, place, &functions), make(name, guid, place, &functions));
    assert!(!one.is_null() && !other.is_null());
    for c in [one, other] {
        nothing(c);
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, &c"logEvents".as_ptr()), OK);
        assert_eq!([fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), fmi2EnterInitializationMode(c)], [OK; 2]);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
    }
    let inputs = references(&xml, "input");
    let outputs = references(&xml, "output");
    steps(one, &inputs, &outputs);
    let bytes = states(one, other);
    derivatives(one, &inputs, &outputs);
    fields(one);
    nothing(one);

    assert_eq!(fmi2Reset(one), OK);
    let mut state = null_mut();
    assert_eq!(fmi2DeSerializeFMUstate(one, bytes.as_ptr().cast(), bytes.len(), &mut state), OK);
    assert_eq!([fmi2SetFMUstate(one, state), fmi2DoStep(one, 4.0 * H, H, 1)], [OK; 2]);
    // A state that is not freed goes with its instance.
    assert_eq!(fmi2Terminate(other), OK);
    [one, other].into_iter().for_each(|c| fmi2FreeInstance(c));
    std::fs::remove_dir_all(&folder).expect("the folder is ours");
}

fn callbacks() -> fmi2CallbackFunctions {
    type Fixed = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
    type Variadic = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    fmi2CallbackFunctions {
        // SAFETY: as in `crates/fmi-export/tests/c_interface.rs`: no variadic argument is ever passed.
        logger: Some(unsafe { std::mem::transmute::<Fixed, Variadic>(log) }),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: null_mut(),
    }
}

/// The model description, read into a buffer of exactly its size, and its GUID.
fn description(folder: &Path) -> (String, CString) {
    let plain = CString::new(folder.to_str().expect("a plain path")).expect("without NUL");
    let mut needed = 0;
    assert_eq!(fmu_model_description(c"/nowhere".as_ptr(), null_mut(), 0, &mut needed), 1);
    assert_eq!(fmu_model_description(plain.as_ptr(), null_mut(), 0, &mut needed), 0);
    let mut buffer = vec![0_u8; needed];
    fmu_model_description(plain.as_ptr(), buffer.as_mut_ptr().cast(), 1, &mut needed);
    assert_eq!(fmu_model_description(plain.as_ptr(), buffer.as_mut_ptr().cast(), needed, &mut needed), 0);
    assert_eq!(buffer.pop(), Some(0));
    let xml = String::from_utf8(buffer).expect("XML is UTF-8");
    let guid = attribute(&xml, "guid");
    (xml, CString::new(guid).expect("without NUL"))
}

fn attribute(text: &str, name: &str) -> String {
    let (_, rest) = text.split_once(&format!(" {name}=\"")).expect("the description has it");
    rest.split_once('"').expect("it ends").0.to_owned()
}

/// References of the Real variables of a causality.
fn references(xml: &str, causality: &str) -> Vec<u32> {
    let variables = xml.split("<ScalarVariable").skip(1);
    let chosen = variables.filter(|v| v.contains(&format!("causality=\"{causality}\"")) && v.contains("<Real"));
    chosen.map(|v| attribute(v, "valueReference").parse().expect("a number")).collect()
}

/// Calls that every instance refuses at any time, and NULL as well; none may read or write through a bad pointer.
fn nothing(c: fmi2Component) {
    let (mut real, mut integer, mut text) = (0.0, 0, null());
    let somewhere = (&raw mut real).cast::<c_void>();
    let statuses = [
        fmi2GetReal(c, null(), 3, &mut real),
        fmi2GetReal(c, &NOWHERE, 1, null_mut()),
        fmi2GetReal(c, &NOWHERE, 1, &mut real),
        fmi2GetInteger(c, null(), 3, null_mut()),
        fmi2GetInteger(c, &NOWHERE, 1, &mut integer),
        fmi2GetBoolean(c, null(), 3, null_mut()),
        fmi2GetBoolean(c, &NOWHERE, 1, &mut integer),
        fmi2GetString(c, null(), 3, null_mut()),
        fmi2GetString(c, &NOWHERE, 1, &mut text),
        fmi2SetReal(c, null(), 3, null()),
        fmi2SetReal(c, &NOWHERE, 1, null()),
        fmi2SetReal(c, &NOWHERE, 1, &real),
        fmi2SetInteger(c, null(), 3, null()),
        fmi2SetInteger(c, &NOWHERE, 1, &integer),
        fmi2SetBoolean(c, &NOWHERE, 1, &integer),
        fmi2SetString(c, null(), 3, null()),
        fmi2SetString(c, &NOWHERE, 1, &null()),
        fmi2SetString(c, &NOWHERE, 1, &c"text".as_ptr()),
        fmi2SetDebugLogging(c, 1, 2, null()),
        fmi2SetDebugLogging(c, 1, 1, &null()),
        fmi2GetFMUstate(c, null_mut()),
        fmi2SetFMUstate(c, null_mut()),
        fmi2SetFMUstate(c, somewhere),
        fmi2FreeFMUstate(c, &mut { somewhere }),
        fmi2SerializedFMUstateSize(c, somewhere, null_mut()),
        fmi2SerializeFMUstate(c, somewhere, null_mut(), 100),
        fmi2DeSerializeFMUstate(c, null(), 100, &mut null_mut()),
        fmi2DeSerializeFMUstate(c, c"no state".as_ptr(), 8, &mut null_mut()),
        fmi2GetDirectionalDerivative(c, null(), 1, null(), 1, null(), null_mut()),
        fmi2GetDirectionalDerivative(c, &NOWHERE, 1, &NOWHERE, 1, &1.0, &mut real),
        fmi2SetRealInputDerivatives(c, &NOWHERE, 1, null(), null()),
        fmi2GetRealOutputDerivatives(c, &NOWHERE, 1, &1, null_mut()),
        fmi2DoStep(c, f64::NAN, H, 1),
        fmi2DoStep(c, 0.0, -H, 1),
        fmi2CancelStep(c),
    ];
    for (i, status) in statuses.iter().enumerate() {
        assert_ne!(*status, OK, "call {i}");
    }
    assert_ne!(fmi2GetRealStatus(c, fmi2StatusKind::fmi2LastSuccessfulTime, null_mut()), OK);
    assert_ne!(fmi2GetStringStatus(c, fmi2StatusKind::fmi2PendingStatus, &mut text), OK);
    assert_eq!(fmu_field(c, c"no such field".as_ptr(), null_mut(), 0, null_mut()), 1);
}

/// Four steps, every input set and every output fetched around each, through arrays of exactly their size.
fn steps(c: fmi2Component, inputs: &[u32], outputs: &[u32]) {
    for k in 0..4 {
        let mut given = vec![0.0; inputs.len()];
        assert_eq!(fmi2GetReal(c, inputs.as_ptr(), inputs.len(), given.as_mut_ptr()), OK);
        assert_eq!(fmi2SetReal(c, inputs.as_ptr(), inputs.len(), given.as_ptr()), OK);
        assert_eq!(fmi2DoStep(c, f64::from(k) * H, H, 1), OK);
        let mut values = vec![f64::NAN; outputs.len()];
        assert_eq!(fmi2GetReal(c, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), OK);
        assert!(values.iter().all(|value| value.is_finite()));
    }
    assert_eq!(fmi2DoStep(c, 99.0, H, 1), ERROR);
}

/// Get, set, serialize, deserialize and free, and each of them wrongly; returns the bytes of a state.
fn states(one: fmi2Component, other: fmi2Component) -> Vec<u8> {
    let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
    assert_eq!([fmi2GetFMUstate(one, &mut state), fmi2GetFMUstate(one, &mut state)], [OK; 2]);
    assert_eq!(fmi2SetFMUstate(other, state), ERROR);
    assert_eq!([fmi2DoStep(one, 4.0 * H, H, 1), fmi2SetFMUstate(one, state)], [OK; 2]);
    assert_eq!(fmi2SerializedFMUstateSize(one, state, &mut size), OK);
    let mut bytes = vec![0_u8; size];
    assert_eq!(fmi2SerializeFMUstate(one, state, bytes.as_mut_ptr().cast(), size - 1), ERROR);
    assert_eq!(fmi2SerializeFMUstate(one, state, bytes.as_mut_ptr().cast(), size), OK);
    for length in [0, 1, 63, 64, size / 2, size - 1] {
        // A vector of its own, so that a read beyond the end is one beyond an allocation.
        let cut = bytes[..length].to_vec();
        assert_eq!(fmi2DeSerializeFMUstate(other, cut.as_ptr().cast(), length, &mut copy), ERROR);
    }
    assert_eq!(fmi2DeSerializeFMUstate(other, bytes.as_ptr().cast(), size, &mut copy), OK);
    assert_eq!([fmi2SetFMUstate(other, copy), fmi2DoStep(other, 4.0 * H, H, 1)], [OK; 2]);
    let freed = state;
    assert_eq!([fmi2FreeFMUstate(one, &mut state), fmi2FreeFMUstate(one, &mut state)], [OK; 2]);
    assert_eq!([fmi2SetFMUstate(one, freed), fmi2FreeFMUstate(one, &mut { freed })], [ERROR; 2]);
    bytes
}

/// Derivatives of the last step, where the unit has them.
fn derivatives(c: fmi2Component, inputs: &[u32], outputs: &[u32]) {
    let (seed, orders) = (vec![1.0; inputs.len()], vec![1; inputs.len().max(outputs.len())]);
    let mut values = vec![0.0; outputs.len()];
    fmi2DoStep(c, 4.0 * H, H, 1);
    fmi2GetDirectionalDerivative(
        c,
        outputs.as_ptr(),
        outputs.len(),
        inputs.as_ptr(),
        inputs.len(),
        seed.as_ptr(),
        values.as_mut_ptr(),
    );
    fmi2GetRealOutputDerivatives(c, outputs.as_ptr(), outputs.len(), orders.as_ptr(), values.as_mut_ptr());
    fmi2SetRealInputDerivatives(c, inputs.as_ptr(), inputs.len(), orders.as_ptr(), seed.as_ptr());
}

/// Every field, where the unit shows any, into a buffer of exactly its size.
fn fields(c: fmi2Component) {
    for name in [c"vorticity", c"u", c"v", c"p"] {
        let mut shape = [0; 2];
        if fmu_field(c, name.as_ptr(), null_mut(), 0, shape.as_mut_ptr()) == 0 {
            let mut values = vec![0.0; shape[0] * shape[1]];
            assert_eq!(fmu_field(c, name.as_ptr(), values.as_mut_ptr(), values.len(), shape.as_mut_ptr()), 0);
        }
    }
}
