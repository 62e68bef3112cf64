//! What the targets do to the unit that is linked in, through its C functions alone.
#![allow(dead_code, reason = "each target uses one half")]

use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::path::{Path, PathBuf};
use std::ptr::null_mut;
use std::sync::LazyLock;

use fmi_export::sys::*;
use scene::{Scene, WingMesh};

use super::KIND;

unsafe extern "C" {
    safe fn fmi2Instantiate(
        name: fmi2String,
        kind: fmi2Type,
        guid: fmi2String,
        resources: fmi2String,
        functions: *const fmi2CallbackFunctions,
        visible: fmi2Boolean,
        logging: fmi2Boolean,
    ) -> fmi2Component;
    safe fn fmi2FreeInstance(c: fmi2Component);
    safe fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status;
    safe fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status;
    safe fn fmi2DoStep(c: fmi2Component, time: f64, step: f64, no_rollback: fmi2Boolean) -> fmi2Status;
    safe fn fmi2GetReal(c: fmi2Component, vr: *const u32, n: usize, value: *mut f64) -> fmi2Status;
    safe fn fmi2GetFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
    safe fn fmi2SetFMUstate(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status;
    safe fn fmi2SerializedFMUstateSize(c: fmi2Component, state: fmi2FMUstate, size: *mut usize) -> fmi2Status;
    safe fn fmi2SerializeFMUstate(
        c: fmi2Component,
        state: fmi2FMUstate,
        bytes: *mut fmi2Byte,
        size: usize,
    ) -> fmi2Status;
    safe fn fmi2FreeFMUstate(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
    safe fn fmi2DeSerializeFMUstate(
        c: fmi2Component,
        bytes: *const fmi2Byte,
        size: usize,
        state: *mut fmi2FMUstate,
    ) -> fmi2Status;
    safe fn fmu_model_description(
        resources: fmi2String,
        buffer: *mut fmi2Char,
        capacity: usize,
        needed: *mut usize,
    ) -> fmi2Integer;
}

const OK: fmi2Status = fmi2Status::fmi2OK;

/// Communication step of the scenes of the units, s: that of `tests/reliability/scene.json` and `wing.json`.
const STEP: f64 = 2e-4;

/// A panic inside the unit becomes an error there, and a finding here.
fn assert_no_panic(message: &str) {
    assert!(!message.contains("panic at"), "{message}");
}

unsafe extern "C" fn log(
    _environment: fmi2ComponentEnvironment,
    _name: fmi2String,
    _status: fmi2Status,
    _category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the message is a string by the standard.
    let message = unsafe { CStr::from_ptr(message) };
    PANICS.with_borrow_mut(|panics| {
        panics.extend(message.to_str().ok().filter(|m| m.contains("panic at")).map(String::from))
    });
}

thread_local! {
    /// Messages about panics, which the logger may not raise itself: it is called by the unit.
    static PANICS: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

fn assert_no_panics() {
    PANICS.with_borrow(|panics| assert!(panics.is_empty(), "{panics:?}"));
}

/// An initialised instance at t = 0 with the references of its Real outputs.
struct Unit {
    c: fmi2Component,
    /// The header of its states up to the length of the payload (crates/fmi-export/src/snapshot.rs).
    header: Vec<u8>,
    outputs: Vec<u32>,
}

impl Unit {
    /// The unit of the scene in `folder`, unless it refuses that scene.
    fn new(folder: &Path) -> Option<Self> {
        let plain = CString::new(folder.to_str().expect("the folder is ours")).expect("without NUL");
        let mut needed = 0;
        fmu_model_description(plain.as_ptr(), null_mut(), 0, &mut needed);
        let mut buffer = vec![0_u8; needed];
        let refused = fmu_model_description(plain.as_ptr(), buffer.as_mut_ptr().cast(), needed, &mut needed) != 0;
        buffer.pop();
        let text = String::from_utf8(buffer).expect("descriptions and messages are UTF-8");
        if refused {
            assert_no_panic(&text);
            return None;
        }
        let attribute = |text: &str, name: &str| {
            let (_, rest) = text.split_once(&format!(" {name}=\"")).expect("the description has it");
            rest.split_once('"').expect("it ends").0.to_owned()
        };
        let variables = text.split("<ScalarVariable").skip(1);
        let outputs = variables.filter(|v| v.contains("causality=\"output\"") && v.contains("<Real"));
        let outputs = outputs.map(|v| attribute(v, "valueReference").parse().expect("a number")).collect();
        let guid = attribute(&text, "guid");
        let (id, location) = (CString::new(guid.as_str()), CString::new(format!("file://{}", folder.display())));
        type Fixed = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
        type Variadic =
            unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
        let callbacks = fmi2CallbackFunctions {
            // SAFETY: as in `crates/fmi-export/tests/c_interface.rs`: no variadic argument is ever passed.
            logger: Some(unsafe { std::mem::transmute::<Fixed, Variadic>(log) }),
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: null_mut(),
        };
        let (id, location) = (id.expect("without NUL"), location.expect("without NUL"));
        let kind = fmi2Type::fmi2CoSimulation;
        let c = fmi2Instantiate(c"unit".as_ptr(), kind, id.as_ptr(), location.as_ptr(), &callbacks, 0, 0);
        assert_no_panics();
        assert!(!c.is_null(), "a scene that has a description has an instance");
        let ready = fmi2EnterInitializationMode(c) == OK && fmi2ExitInitializationMode(c) == OK;
        let unit = Unit { c, header: state_header(c), outputs };
        assert_no_panics();
        ready.then_some(unit)
    }

    /// The Real outputs, which have to be finite.
    fn outputs(&self) -> Vec<f64> {
        let mut values = vec![f64::NAN; self.outputs.len()];
        let status = fmi2GetReal(self.c, self.outputs.as_ptr(), values.len(), values.as_mut_ptr());
        assert_no_panics();
        assert!(status != OK || values.iter().all(|value| value.is_finite()), "{values:?}");
        values
    }

    /// Whether a step succeeds.
    fn step(&self, t: f64, h: f64) -> bool {
        let made = fmi2DoStep(self.c, t, h, 0) == OK;
        assert_no_panics();
        made
    }
}

impl Drop for Unit {
    fn drop(&mut self) {
        fmi2FreeInstance(self.c);
    }
}

/// The header of a state of an instance up to the length of its payload.
fn state_header(c: fmi2Component) -> Vec<u8> {
    let (mut state, mut size) = (null_mut(), 0);
    if fmi2GetFMUstate(c, &mut state) != OK || fmi2SerializedFMUstateSize(c, state, &mut size) != OK {
        return Vec::new();
    }
    let mut bytes = vec![0_u8; size];
    assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), size), OK);
    assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
    let name = usize::from(u16::from_le_bytes([bytes[12], bytes[13]]));
    bytes.truncate(14 + name + 38);
    bytes
}

/// `target/fuzz`, for files.
fn scratch() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/fuzz")
}

/// Any bytes as a scene file: refused, or a unit that makes two steps or says why not.
pub fn scene(data: &[u8]) {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = scratch().join(format!("scene-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("the folder can be made");
        folder
    });
    let Ok(text) = str::from_utf8(data) else { return };
    let Ok(scene) = Scene::from_json(text) else { return };
    // What is allowed and takes long is left out.
    let cells = scene.fluid.as_ref().map_or(0, |fluid| fluid.r#box.cells.iter().product());
    let threads = scene.fluid.as_ref().map_or(1, |fluid| fluid.threads);
    let along = match scene.wing.as_ref().map(|wing| &wing.mesh) {
        Some(
            WingMesh::Rectangular { along, .. } | WingMesh::Elliptical { along, .. } | WingMesh::Insect { along, .. },
        ) => *along,
        _ => 0,
    };
    let segments: usize = scene.beams().map(|beam| beam.segments).sum();
    if cells > 2048 || threads > 2 || along > 16 || segments > 24 {
        return;
    }
    let own = scene.fluid.as_ref().map(|fluid| fluid.time_stepping.max_step);
    let rods = scene.rod.iter().chain(scene.rods.iter().map(|own| &own.rod)).filter_map(|rod| rod.max_step);
    let h = own.into_iter().chain(rods).fold(scene.time.communication_step, f64::min);
    std::fs::write(FOLDER.join("scene.json"), text).expect("the scene can be written");
    let Some(unit) = Unit::new(&FOLDER) else { return };
    unit.outputs();
    for k in 0..2 {
        if !unit.step(f64::from(k) * h, h) {
            break;
        }
        unit.outputs();
    }
}

/// A unit, its state at t = 0, and its outputs after a step from there.
struct Good {
    unit: Unit,
    clean: fmi2FMUstate,
    expected: Vec<f64>,
}

impl Good {
    fn new() -> Self {
        let unit = Unit::new(&scratch().join(KIND)).expect("its scene is good");
        let mut clean = null_mut();
        assert_eq!(fmi2GetFMUstate(unit.c, &mut clean), OK);
        assert!(unit.step(0.0, STEP));
        Good { clean, expected: unit.outputs(), unit }
    }
}

thread_local! {
    static GOOD: Good = Good::new();
}

/// Any bytes as the payload of a serialized state, under a right header and checksum: refused, or a state from which
/// steps succeed with finite outputs or fail; after it a good state leads to the same bits as ever.
pub fn state(payload: &[u8]) {
    GOOD.with(|Good { unit, clean, expected }| {
        let bytes =
            [&unit.header[..], &(payload.len() as u64).to_le_bytes(), &crc32fast::hash(payload).to_le_bytes(), payload]
                .concat();
        let mut state = null_mut();
        if fmi2DeSerializeFMUstate(unit.c, bytes.as_ptr().cast(), bytes.len(), &mut state) == OK {
            if fmi2SetFMUstate(unit.c, state) == OK {
                unit.outputs();
                for k in 0..4 {
                    if unit.step(f64::from(k) * STEP, STEP) {
                        unit.outputs();
                    }
                }
            }
            assert_eq!(fmi2FreeFMUstate(unit.c, &mut state), OK);
        }
        assert_no_panics();
        assert_eq!(fmi2SetFMUstate(unit.c, *clean), OK);
        assert!(unit.step(0.0, STEP), "a good state leads nowhere any more");
        assert!(unit.outputs().iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits()), "{expected:?}");
    });
}
