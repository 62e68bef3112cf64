//! What a master does with a unit, and what it must not do: NULL, wrong sizes, wrong handles, wrong order.

use std::ffi::{CStr, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};

use nervure_fmi_export::sys::*;

use master::description::{attribute, references};
use master::logger::{Messages, callbacks};
use master::*;

#[path = "../../../crates/fmi-export/tests/master/mod.rs"]
mod master;

/// Communication step, s, and a reference that no unit has.
const H: f64 = 4e-4;
const NOWHERE: u32 = u32::MAX;

/// The whole play with the unit of this program, whose resources hold `scene` as scene.json.
pub fn run(scene: &[u8]) {
    let folder = std::env::temp_dir().join(format!("sanitizers-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("the folder can be made");
    std::fs::write(folder.join("scene.json"), scene).expect("the scene can be written");
    let xml = description(&folder);
    let messages = Messages::default();
    let functions = callbacks(&messages);
    let make =
        |name: Option<&CStr>, guid: Option<&CStr>, place: Option<&CStr>, functions: *const fmi2CallbackFunctions| {
            instantiate(name, CO_SIMULATION, guid, place, functions)
        };
    let (guid, place) = (c_string(attribute(&xml, "guid")), c_string(format!("file://{}", folder.display())));
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

/// Return the model description, after calls with too little room for it and for a folder that does not exist.
fn description(folder: &Path) -> String {
    let (plain, mut needed) = (c_string(folder.display()), 0);
    let mut buffer = vec![0_u8; 1]; // on the heap, where a byte too many is found
    assert_eq!(fmu_model_description(plain.as_ptr(), buffer.as_mut_ptr().cast(), 1, &mut needed), 0);
    assert!(describe(Some(c"/nowhere")).is_err());
    describe(Some(&plain)).expect("the scene is good")
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
