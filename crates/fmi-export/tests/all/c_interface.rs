//! A master in Rust against the C functions of one exported model, in FMI 2.0.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::{CStr, c_void};
use std::ptr::{null, null_mut};

use nervure_fmi_export::sys::*;

use crate::integrator::*;
use crate::master::logger::{Messages, callbacks};
use crate::master::*;

const DISCARD: fmi2Status = fmi2Status::fmi2Discard;

/// Return a string that the glue keeps.
fn text<'a>(string: fmi2String) -> &'a CStr {
    // SAFETY: the standard's functions return null-terminated strings, and no test keeps one beyond its instance.
    unsafe { CStr::from_ptr(string) }
}

fn set_integer(fmu: &Fmu, reference: u32, value: i32) -> fmi2Status {
    fmi2SetInteger(fmu.c, &reference, 1, &value)
}

fn set_string(fmu: &Fmu, reference: u32, value: &CStr) -> fmi2Status {
    fmi2SetString(fmu.c, &reference, 1, &value.as_ptr())
}

#[test]
fn the_platform_is_default_and_the_version_two() {
    let [platform, version] = [fmi2GetTypesPlatform(), fmi2GetVersion()].map(text);
    assert_eq!([platform, version], [c"default", c"2.0"]);
}

#[test]
fn a_step_integrates_and_keeps_the_time() {
    let fmu = Fmu::new();
    assert_eq!(fmu.set(&[GAIN], &[2.0]), OK);
    assert_eq!([fmu.setup(5.0, Some(6.0)), fmu.enter(), fmu.exit()], [OK; 3]);
    assert_eq!(fmu.set(&[U[0], U[1], U[2], BIAS], &[1.0, 2.0, 3.0, 0.5]), OK);
    assert_eq!(fmu.step(5.0, 0.5), OK);
    assert_eq!(fmu.get([Y[2], Y[0], TIME]), [3.25, 1.25, 5.5]);
    assert_eq!(fmu.step(5.5, 0.5), OK);
    assert_eq!(fmu.get(Y), [2.5, 4.5, 6.5]);
    assert!(fmu.messages.borrow().is_empty(), "{:?}", fmu.messages);
}

#[test]
fn all_types_pass() {
    let fmu = Fmu::new();
    assert_eq!(
        [set_integer(&fmu, ORDER, 4), fmi2SetBoolean(fmu.c, &HOLD, 1, &1), set_string(&fmu, LABEL, c"fin")],
        [OK; 3]
    );
    assert_eq!([fmu.enter(), fmu.exit(), fmu.step(0.0, 1.0)], [OK; 3]);
    let (mut integers, mut booleans) = ([0; 2], [-1; 2]);
    let status = fmi2GetInteger(fmu.c, [ORDER, LENGTH].as_ptr(), 2, integers.as_mut_ptr());
    assert_eq!((status, integers), (OK, [4, 3]));
    let status = fmi2GetBoolean(fmu.c, [HELD, HOLD].as_ptr(), 2, booleans.as_mut_ptr());
    assert_eq!((status, booleans), (OK, [1, 1]));
    let mut strings = [null(); 2];
    assert_eq!(fmi2GetString(fmu.c, [ECHO, LABEL].as_ptr(), 2, strings.as_mut_ptr()), OK);
    assert_eq!(strings.map(text), [c"fin at 0", c"fin"]);
}

#[test]
fn a_call_out_of_order_is_refused_and_changes_nothing() {
    let fmu = Fmu::new();
    fmu.assert_refused(fmu.step(0.0, 0.1), &["fmi2DoStep", "instantiated"]);
    fmu.assert_refused(fmu.exit(), &["fmi2ExitInitializationMode", "instantiated"]);
    fmu.assert_refused(fmu.try_get(Y).0, &["fmi2GetReal", "instantiated"]);
    assert_eq!(fmu.enter(), OK);
    fmu.assert_refused(fmu.enter(), &["fmi2EnterInitializationMode", "initialization mode"]);
    fmu.assert_refused(fmu.setup(0.0, None), &["fmi2SetupExperiment", "initialization mode"]);
    assert_eq!([fmu.exit(), fmu.step(0.0, 0.1)], [OK; 2]);
    fmu.assert_refused(fmi2CancelStep(fmu.c), &["fmi2CancelStep", "step complete"]);
    assert_eq!(fmi2Terminate(fmu.c), OK);
    fmu.assert_refused(fmu.step(0.1, 0.1), &["fmi2DoStep", "terminated"]);
    fmu.assert_refused(fmu.set(&U, &[1.0; 3]), &["fmi2SetReal", "terminated"]);
    assert_eq!(fmu.get([TIME]), [0.1]);
}

#[test]
fn a_set_with_one_wrong_value_sets_nothing() {
    let fmu = Fmu::initialised();
    for (wrong, name) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")] {
        fmu.assert_refused(fmu.set(&U, &[1.0, 2.0, wrong]), &["u[3] = ", name, "must be finite"]);
        fmu.assert_refused(fmu.set(&[U[0], Y[0]], &[1.0, 2.0]), &["y[1]", "cannot be set"]);
        assert_eq!(fmu.get(U), [0.0; 3]);
    }
    assert_eq!(fmu.step(0.0, 0.1), OK, "a refused value does not end the simulation");
}

#[test]
fn limits_are_enforced_with_variable_value_and_limit() {
    let fmu = Fmu::new();
    fmu.assert_refused(fmu.set(&[GAIN], &[0.0]), &["gain", "0.000e0 must be finite and > 0"]);
    fmu.assert_refused(fmu.set(&[BIAS], &[1.5]), &["bias", "1.500e0 must be finite and >= -1 and <= 1"]);
    assert_eq!(fmu.set(&[BIAS], &[1.0]), OK);
    fmu.assert_refused(set_integer(&fmu, ORDER, 0), &["order", "0 must be >= 1"]);
}

#[test]
fn outputs_follow_what_is_set_during_initialisation() {
    let fmu = Fmu::new();
    assert_eq!([fmu.setup(0.5, None), fmu.enter()], [OK; 2]);
    for label in [c"one", c"two"] {
        assert_eq!(set_string(&fmu, LABEL, label), OK);
        let mut echo = null();
        assert_eq!(fmi2GetString(fmu.c, &ECHO, 1, &mut echo), OK);
        assert_eq!(text(echo).to_str(), Ok(&*format!("{} at 0.5", label.to_str().unwrap())));
    }
    assert_eq!(fmu.exit(), OK);
}

#[test]
fn nothing_is_written_before_all_references_are_known_to_be_right() {
    let fmu = Fmu::initialised();
    for wrong in [&[TIME, Y[0], 4000][..], &[TIME, Y[0], ORDER], &[Y[0], Y[1], u32::MAX]] {
        let mut values = [-7.0; 3];
        fmu.assert_refused(fmi2GetReal(fmu.c, wrong.as_ptr(), 3, values.as_mut_ptr()), &["fmi2GetReal"]);
        assert_eq!(values, [-7.0; 3], "{wrong:?}");
    }
}

/// A negative number of a master whose sizes have a sign: there are no such arrays behind the pointers.
#[test]
fn a_number_of_values_that_no_master_has_is_refused_before_anything_is_read() {
    let fmu = Fmu::initialised();
    for n in [1 << 31, (1 << 32) - 1, usize::MAX >> 3, usize::MAX] {
        let mut value = -7.0;
        fmu.assert_refused(fmi2GetReal(fmu.c, &TIME, n, &mut value), &["vr has", "at most 2147483647"]);
        fmu.assert_refused(fmi2SetReal(fmu.c, &U[0], n, &1.0), &["vr has", "at most 2147483647"]);
        fmu.assert_refused(fmi2GetString(fmu.c, &LABEL, n, &mut null()), &["vr has"]);
        assert_eq!((value, fmu.get(U)), (-7.0, [0.0; 3]));
    }
}

/// Such a state could not be restored.
#[test]
fn values_that_do_not_fit_make_no_state() {
    let fmu = Fmu::new();
    let mut state = null_mut();
    for enter in [false, true] {
        assert!(!enter || [fmu.setup(0.0, None), fmu.enter()] == [OK; 2]);
        assert_eq!(fmu.set(&[GAIN], &[UNFIT]), OK);
        fmu.assert_refused(fmu.save(&mut state), &["fmi2GetFMUstate", "gain = 99 does not fit"]);
        assert!(state.is_null());
        assert_eq!(fmu.set(&[GAIN], &[2.0]), OK);
        assert_eq!([fmu.save(&mut state), fmu.restore(state), fmu.free(&mut state)], [OK; 3]);
    }
    assert_eq!([fmu.exit(), fmu.set(&U, &[1.0; 3]), fmu.step(0.0, 0.5)], [OK; 3]);
    assert_eq!(fmu.get(Y), [1.0; 3]);
}

#[test]
fn only_inputs_and_tunable_parameters_are_set_between_steps() {
    let fmu = Fmu::initialised();
    fmu.assert_refused(fmu.set(&[GAIN], &[2.0]), &["gain", "fixed"]);
    fmu.assert_refused(set_string(&fmu, LABEL, c"x"), &["label", "fixed"]);
    fmu.assert_refused(fmu.set(&[TIME], &[2.0]), &["independent time"]);
    fmu.assert_refused(set_integer(&fmu, LENGTH, 2), &["local length"]);
    assert_eq!(fmu.set(&[BIAS], &[0.5]), OK);
}

#[test]
fn references_of_nothing_or_of_another_type_are_named() {
    let fmu = Fmu::initialised();
    fmu.assert_refused(fmu.try_get([Y[0], 99]).0, &["value reference 99"]);
    fmu.assert_refused(fmu.try_get([u32::MAX]).0, &["value reference 4294967295"]);
    fmu.assert_refused(fmu.try_get([HOLD]).0, &["value reference 11", "Boolean hold", "not of type Real"]);
    fmu.assert_refused(set_integer(&fmu, U[1], 1), &["value reference 4", "Real u[2]", "not of type Integer"]);
}

#[test]
fn null_pointers_are_refused() {
    let fmu = Fmu::initialised();
    assert_eq!(fmi2DoStep(null_mut(), 0.0, 1.0, 0), ERROR);
    fmi2FreeInstance(null_mut());
    fmu.assert_refused(fmi2GetReal(fmu.c, null(), 1, &mut 0.0), &["vr is NULL"]);
    fmu.assert_refused(fmi2GetReal(fmu.c, &0, 1, null_mut()), &["value is NULL"]);
    fmu.assert_refused(fmi2SetReal(fmu.c, &U[0], 1, null()), &["value is NULL"]);
    fmu.assert_refused(fmi2SetString(fmu.c, &LABEL, 1, &null()), &["a value is NULL"]);
    fmu.assert_refused(fmi2GetFMUstate(fmu.c, null_mut()), &["FMUstate is NULL"]);
    fmu.assert_refused(fmi2GetRealStatus(fmu.c, fmi2StatusKind::fmi2LastSuccessfulTime, null_mut()), &["NULL"]);
    assert_eq!(fmi2GetReal(fmu.c, null(), 0, null_mut()), OK);
    assert_eq!(fmi2SetReal(fmu.c, null(), 0, null()), OK);
}

#[test]
fn a_step_of_wrong_size_or_time_is_refused_and_changes_nothing() {
    let fmu = Fmu::new();
    assert_eq!([fmu.setup(0.0, Some(1.0)), fmu.enter(), fmu.exit()], [OK; 3]);
    for step in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        fmu.assert_refused(fmu.step(0.0, step), &["communicationStepSize", &format!("{step:.3e}"), "> 0"]);
    }
    for time in [0.1, -0.1, f64::NAN] {
        fmu.assert_refused(fmu.step(time, 0.1), &["currentCommunicationPoint", &format!("{time:.3e}"), "instance, 0"]);
    }
    fmu.assert_refused(fmu.step(0.0, 1.1), &["1.100e0", "stopTime = 1", "by 1.000e-1"]);
    assert_eq!(fmu.get([TIME]), [0.0]);
    assert_eq!(fmu.step(0.0, 1.0 + 1e-12), OK, "rounding is not an error");
}

#[test]
fn a_stop_time_before_the_start_is_refused() {
    let fmu = Fmu::new();
    fmu.assert_refused(fmu.setup(1.0, Some(1.0)), &["stopTime = 1", "startTime = 1"]);
    fmu.assert_refused(fmu.setup(f64::NAN, None), &["startTime = NaN"]);
}

#[test]
fn after_a_failed_step_a_stored_state_leads_on() {
    let fmu = Fmu::initialised();
    let mut state = null_mut();
    assert_eq!([fmu.save(&mut state), fmu.set(&U[..1], &[FAILING])], [OK; 2]);
    fmu.assert_refused(fmu.step(0.0, 0.1), &["fmi2DoStep", "u[1] = 13"]);
    fmu.assert_refused(fmu.step(0.0, 0.1), &["state \"error\""]);
    assert_eq!(fmu.get([TIME, U[0]]), [0.0, FAILING], "values can be looked at");
    assert_eq!([fmu.restore(state), fmu.step(0.0, 0.1)], [OK; 2]);
}

#[test]
fn an_output_that_is_not_finite_is_refused_and_named() {
    let fmu = Fmu::initialised();
    assert_eq!([fmu.set(&U[1..2], &[1e308]), fmu.step(0.0, 1e3)], [OK; 2]);
    fmu.assert_refused(fmu.try_get(Y).0, &["fmi2GetReal", "y[2] = inf is not finite"]);
    assert_eq!(fmu.get([Y[0], Y[2]]), [0.0; 2], "the others can be read");
}

#[test]
fn after_a_panic_a_stored_state_or_a_reset_leads_on() {
    let fmu = Fmu::initialised();
    let mut state = null_mut();
    assert_eq!([fmu.set(&U, &[1.0; 3]), fmu.step(0.0, 1.0), fmu.save(&mut state)], [OK; 3]);
    assert_eq!(fmu.set(&U[1..2], &[PANICKING]), OK);
    fmu.assert_refused(fmu.step(1.0, 1.0), &["panic at", "integrator", "u[2] = 666"]);
    fmu.assert_refused(fmu.try_get(Y).0, &["error after a panic"]);
    fmu.assert_refused(fmu.save(&mut state), &["error after a panic"]);
    assert_eq!([fmu.restore(state), fmu.step(1.0, 1.0)], [OK; 2]);
    assert_eq!(fmu.get(Y), [2.0; 3], "what the panicking step had done is gone");

    assert_eq!(fmu.set(&U[1..2], &[PANICKING]), OK);
    assert_eq!([fmu.step(2.0, 1.0), fmi2Reset(fmu.c), fmu.enter(), fmu.exit()], [ERROR, OK, OK, OK]);
    assert_eq!(fmu.get(Y), [0.0; 3]);
}

#[test]
fn a_reset_is_a_new_beginning() {
    let fmu = Fmu::new();
    assert_eq!([fmu.set(&[GAIN], &[2.0]), fmu.setup(1.0, Some(2.0)), fmu.enter(), fmu.exit()], [OK; 4]);
    assert_eq!([fmu.set(&U, &[1.0; 3]), fmu.step(1.0, 0.5), fmi2Reset(fmu.c)], [OK; 3]);
    assert_eq!([fmu.enter(), fmu.exit()], [OK; 2]);
    assert_eq!(fmu.get([TIME, GAIN, U[0], Y[0]]), [0.0, 1.0, 0.0, 0.0]);
    assert_eq!(fmu.step(0.0, 10.0), OK, "the stop time is forgotten");
}

#[test]
fn a_state_brings_back_time_inputs_and_outputs() {
    let fmu = Fmu::initialised();
    let mut state = null_mut();
    assert_eq!([fmu.set(&U, &[1.0, 2.0, 3.0]), fmu.step(0.0, 0.1), fmu.save(&mut state)], [OK; 3]);
    let all = [TIME, U[0], U[1], U[2], Y[0], Y[1], Y[2]];
    let before = fmu.get(all);
    assert_eq!([fmu.set(&U, &[9.0; 3]), fmu.step(0.1, 0.1)], [OK; 2]);
    assert_ne!(fmu.get(all), before);
    assert_eq!(fmu.restore(state), OK);
    assert_eq!(fmu.get(all), before);

    let first = state;
    assert_eq!([fmu.step(0.1, 0.1), fmu.save(&mut state)], [OK; 2]);
    assert_eq!(state, first, "a state that exists is overwritten");
    assert_eq!([fmu.step(0.2, 0.1), fmu.restore(state)], [OK; 2]);
    assert_eq!(fmu.get([TIME]), [0.2]);
}

#[test]
fn after_a_state_that_the_model_refuses_only_another_state_helps() {
    let fmu = Fmu::initialised();
    let (mut good, mut bad) = (null_mut(), null_mut());
    assert_eq!([fmu.save(&mut good), fmu.set(&U[..1], &[FOREIGN])], [OK; 2]);
    assert_eq!([fmu.step(0.0, 1.0), fmu.save(&mut bad)], [OK; 2]);
    fmu.assert_refused(fmu.restore(bad), &["the state is refused: y[1] = 4711 is foreign"]);
    fmu.assert_refused(fmu.step(0.0, 0.1), &["error after a panic or a refused state"]);
    assert_eq!([fmu.restore(good), fmu.step(0.0, 0.1)], [OK; 2]);
    assert_eq!(fmu.get([U[0]]), [0.0]);
}

#[test]
fn a_state_that_is_freed_or_foreign_is_refused() {
    let (fmu, other) = (Fmu::initialised(), Fmu::initialised());
    let mut state = null_mut();
    assert_eq!([fmu.free(&mut state), fmi2FreeFMUstate(fmu.c, null_mut())], [OK; 2]);
    assert_eq!(fmu.save(&mut state), OK);
    other.assert_refused(other.restore(state), &["does not belong to this instance"]);
    other.assert_refused(other.free(&mut { state }), &["does not belong to this instance"]);
    let mut freed = state;
    assert_eq!(fmu.free(&mut freed), OK);
    assert!(freed.is_null());
    fmu.assert_refused(fmu.restore(state), &["does not belong to this instance"]);
    fmu.assert_refused(fmu.free(&mut state), &["does not belong to this instance"]);
    let mut stack = 0.0;
    fmu.assert_refused(fmu.restore((&raw mut stack).cast::<c_void>()), &["does not belong to this instance"]);
    fmu.assert_refused(fmu.restore(null_mut()), &["0x0"]);
}

#[test]
fn bytes_carry_a_state_into_an_instance_that_was_only_loaded() {
    let (fmu, other) = (Fmu::new(), Fmu::new());
    assert_eq!([fmu.set(&[GAIN], &[0.1]), fmu.enter(), fmu.exit(), fmu.set(&U, &[0.1, 0.2, 0.3])], [OK; 4]);
    let mut state = null_mut();
    assert_eq!([fmu.step(0.0, 0.1), fmu.save(&mut state)], [OK; 2]);
    let bytes = fmu.serialize(state);
    let mut copy = null_mut();
    assert_eq!([other.deserialize(&bytes, &mut copy), other.restore(copy)], [OK; 2], "{:?}", other.messages);
    assert_eq!([fmu.step(0.1, 0.1), other.step(0.1, 0.1)], [OK; 2]);
    assert_eq!(other.get(Y).map(f64::to_bits), fmu.get(Y).map(f64::to_bits));
    assert_eq!(other.serialize(copy), bytes);
}

#[test]
fn damaged_bytes_are_refused_and_harm_nothing() {
    let fmu = Fmu::initialised();
    let mut state = null_mut();
    assert_eq!(fmu.save(&mut state), OK);
    let bytes = fmu.serialize(state);
    let mut copy = null_mut();
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        assert_eq!(fmu.deserialize(&damaged, &mut copy), ERROR, "byte {at}");
        assert_eq!(fmu.deserialize(&bytes[..at], &mut copy), ERROR, "{at} bytes");
        assert!(copy.is_null());
    }
    let status = fmi2SerializeFMUstate(fmu.c, state, [0].as_mut_ptr(), 1);
    fmu.assert_refused(status, &["size = 1", &bytes.len().to_string()]);
    assert_eq!(fmu.step(0.0, 0.1), OK);
}

#[test]
fn derivatives_are_refused_as_the_description_says() {
    let fmu = Fmu::initialised();
    let (y, u, mut out) = (Y.as_ptr(), U.as_ptr(), [0.0; 3]);
    let status = fmi2GetDirectionalDerivative(fmu.c, y, 3, u, 3, [1.0; 3].as_ptr(), out.as_mut_ptr());
    fmu.assert_refused(status, &["directional derivatives are not provided"]);
    let status = fmi2GetRealOutputDerivatives(fmu.c, y, 3, [1; 3].as_ptr(), out.as_mut_ptr());
    fmu.assert_refused(status, &["output derivatives are not provided"]);
    let status = fmi2SetRealInputDerivatives(fmu.c, u, 3, [1; 3].as_ptr(), [1.0; 3].as_ptr());
    fmu.assert_refused(status, &["input derivatives are not used"]);
    assert_eq!((fmu.step(0.0, 0.1), out), (OK, [0.0; 3]));
}

#[test]
fn the_status_of_a_synchronous_slave_is_its_time() {
    let fmu = Fmu::initialised();
    assert_eq!(fmu.step(0.0, 0.25), OK);
    let (mut real, mut boolean) = (0.0, 7);
    assert_eq!(fmi2GetRealStatus(fmu.c, fmi2StatusKind::fmi2LastSuccessfulTime, &mut real), OK);
    assert_eq!(fmi2GetBooleanStatus(fmu.c, fmi2StatusKind::fmi2Terminated, &mut boolean), OK);
    assert_eq!((real, boolean), (0.25, 0));
    assert_eq!(fmi2GetStatus(fmu.c, fmi2StatusKind::fmi2DoStepStatus, &mut { OK }), DISCARD);
    assert_eq!(fmi2GetIntegerStatus(fmu.c, fmi2StatusKind(77), &mut 0), DISCARD);
    assert_eq!(fmi2GetStringStatus(fmu.c, fmi2StatusKind::fmi2PendingStatus, &mut null()), DISCARD);
    assert_eq!(fmi2GetRealStatus(fmu.c, fmi2StatusKind::fmi2Terminated, &mut real), DISCARD);
}

#[test]
fn a_wrong_instantiation_returns_null_and_tells_why() {
    let guid = &*guid();
    for (name, kind, their_guid, resources, parts) in [
        (None, CO_SIMULATION, guid, None, ["instanceName", "NULL"]),
        (Some(c""), CO_SIMULATION, guid, None, ["instanceName", "empty"]),
        (Some(c"a"), fmi2Type::fmi2ModelExchange, guid, None, ["fmuType", "fmi2CoSimulation"]),
        (Some(c"a"), fmi2Type(9), guid, None, ["fmuType", "9"]),
        (Some(c"a"), CO_SIMULATION, c"{another}", None, ["{another}", "form"]),
        (Some(c"a"), CO_SIMULATION, guid, Some(c"http://a/b"), ["http", "not a folder"]),
        (Some(c"a"), CO_SIMULATION, guid, Some(c"file:///no%20where"), ["/no where", "100 %%"]),
    ] {
        let messages = Messages::default();
        assert!(instantiate(name, kind, Some(their_guid), resources, &callbacks(&messages)).is_null(), "{parts:?}");
        let messages = messages.borrow();
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert!(parts.iter().all(|part| messages[0].contains(part)), "{parts:?} are not all in {messages:?}");
    }
    assert!(instantiate(Some(c"a"), CO_SIMULATION, None, None, null()).is_null(), "without callbacks");
}

#[test]
fn resources_are_found_by_uri_or_path() {
    for location in [c"file:///", c"file:/", c"file://localhost/", c"/", c""] {
        let messages = Messages::default();
        let c = instantiate(Some(c"a"), CO_SIMULATION, Some(&guid()), Some(location), &callbacks(&messages));
        assert!(!c.is_null(), "{location:?}: {messages:?}");
        fmi2FreeInstance(c);
    }
}

#[test]
fn a_missing_logger_is_no_obstacle() {
    let functions = fmi2CallbackFunctions { logger: None, ..callbacks(&Messages::default()) };
    let c = instantiate(Some(c"a"), CO_SIMULATION, Some(&guid()), None, &functions);
    assert_eq!(fmi2DoStep(c, 0.0, 1.0, 0), ERROR);
    fmi2FreeInstance(c);
}

#[test]
fn information_is_logged_on_request_only() {
    for (on, categories) in
        [(0, vec![]), (1, vec![]), (1, vec![c"logEvents".as_ptr()]), (1, vec![c"logStatusError".as_ptr()])]
    {
        let fmu = Fmu::new();
        let status = fmi2SetDebugLogging(fmu.c, on, categories.len(), categories.as_ptr());
        assert_eq!([status, set_string(&fmu, LABEL, c"50 % #2"), fmu.enter(), fmu.exit()], [OK; 4]);
        let wanted = on == 1 && categories.first().is_none_or(|name| text(*name) == c"logEvents");
        let expected: &[&str] = if wanted { &["initialised 50 %% ##2"] } else { &[] };
        assert_eq!(*fmu.messages.borrow(), expected);
    }
}

#[test]
fn instances_do_not_know_each_other() {
    let (one, two) = (Fmu::initialised(), Fmu::initialised());
    assert_eq!([one.set(&U, &[1.0; 3]), two.set(&U, &[2.0; 3]), one.step(0.0, 1.0), two.step(0.0, 0.5)], [OK; 4]);
    assert_eq!((one.get(Y), two.get(Y)), ([1.0; 3], [1.0; 3]));
    assert_eq!([one.get([TIME]), two.get([TIME])], [[1.0], [0.5]]);
}

#[test]
fn a_failing_description_returns_its_message() {
    let message = describe(Some(c"/no/where")).unwrap_err();
    assert!(message.contains("/no/where"), "{message}");
}

// ---------------------------------------------------------------- allocations

/// The system's allocator, counting.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: both functions are the system's own.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller keeps the precondition.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the precondition.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_step_and_its_exchange_allocate_nothing() {
    let fmu = Fmu::initialised();
    let before = ALLOCATIONS.get();
    for i in 0..10 {
        assert_eq!([fmu.set(&U, &[1.0; 3]), fmu.step(f64::from(i), 1.0)], [OK; 2]);
        assert_eq!(fmu.get(Y), [f64::from(i + 1); 3]);
    }
    assert_eq!(ALLOCATIONS.get() - before, 0);
}
