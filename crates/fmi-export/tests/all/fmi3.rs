//! A master in Rust against the C functions of one exported model, in FMI 3.0: what is not as in FMI 2.0.

use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};

use nervure_fmi_export::sys::*;

use crate::integrator::*;
use crate::master::description::{attribute, written};
use crate::master::{Fmu as Fmu2, *};

const OK: fmi3Status = fmi3Status::fmi3OK;
const ERROR: fmi3Status = fmi3Status::fmi3Error;

/// What the logger received: status and text.
type Messages = RefCell<Vec<(u32, String)>>;

unsafe extern "C" fn log(environment: fmi3InstanceEnvironment, status: fmi3Status, _: fmi3String, message: fmi3String) {
    // SAFETY: the environment is the one handed over in `instantiate`, the message a string by the standard.
    let (messages, message) = unsafe { (&*environment.cast::<Messages>(), CStr::from_ptr(message)) };
    messages.borrow_mut().push((status.0, message.to_str().unwrap().into()));
}

/// Return the token of the model.
fn token() -> CString {
    let xml = written(|buffer, capacity, needed| fmu_model_description_3(null(), buffer, capacity, needed));
    c_string(attribute(&xml.unwrap(), "instantiationToken"))
}

fn instantiate(token: &CStr, resources: Option<&CStr>, logging: u8, events: u8, messages: &Messages) -> fmi3Instance {
    let environment = (&raw const *messages).cast_mut().cast();
    let (name, token) = (c"one".as_ptr(), token.as_ptr());
    fmi3InstantiateCoSimulation(
        name,
        token,
        pointer(resources),
        0,
        logging,
        events,
        0,
        null(),
        0,
        environment,
        Some(log),
        None,
    )
}

/// An instance, freed at the end. The methods' pointers are all valid.
struct Fmu {
    c: fmi3Instance,
    messages: Box<Messages>,
}

impl Fmu {
    fn new() -> Self {
        let messages = Box::<Messages>::default();
        let c = instantiate(&token(), None, 1, 0, &messages);
        assert!(!c.is_null(), "{messages:?}");
        Fmu { c, messages }
    }

    /// Initialised, from time 0 without a stop time.
    fn initialised() -> Self {
        let fmu = Self::new();
        assert_eq!([fmu.enter(0.0, None), fmu.exit()], [OK; 2], "{:?}", fmu.messages);
        fmu
    }

    fn enter(&self, start: f64, stop: Option<f64>) -> fmi3Status {
        fmi3EnterInitializationMode(self.c, 0, 0.0, start, stop.is_some().into(), stop.unwrap_or(0.0))
    }

    fn exit(&self) -> fmi3Status {
        fmi3ExitInitializationMode(self.c)
    }

    /// Status, flags and the time reached.
    fn step(&self, time: f64, step: f64) -> (fmi3Status, [u8; 3], f64) {
        let (mut flags, mut reached) = ([7; 3], f64::NAN);
        let [event, end, early] = &mut flags;
        let status = fmi3DoStep(self.c, time, step, 1, event, end, early, &mut reached);
        (status, flags, reached)
    }

    fn set(&self, references: &[u32], values: &[f64]) -> fmi3Status {
        fmi3SetFloat64(self.c, references.as_ptr(), references.len(), values.as_ptr(), values.len())
    }

    fn try_get<const N: usize>(&self, references: &[u32]) -> (fmi3Status, [f64; N]) {
        let mut values = [f64::NAN; N];
        let status = fmi3GetFloat64(self.c, references.as_ptr(), references.len(), values.as_mut_ptr(), N);
        (status, values)
    }

    fn get<const N: usize>(&self, references: &[u32]) -> [f64; N] {
        let (status, values) = self.try_get(references);
        assert_eq!(status, OK, "{:?}", self.messages);
        values
    }

    /// The call was refused and the last message has all the parts.
    #[track_caller]
    fn assert_refused(&self, status: fmi3Status, parts: &[&str]) {
        assert_eq!(status, ERROR);
        let messages = self.messages.borrow();
        let (status, last) = messages.last().expect("a refusal is logged");
        assert_eq!(*status, ERROR.0);
        assert!(parts.iter().all(|part| last.contains(part)), "{parts:?} are not all in: {last}");
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        fmi3FreeInstance(self.c)
    }
}

#[test]
fn the_version_is_three() {
    // SAFETY: the function returns a null-terminated string that stays.
    assert_eq!(unsafe { CStr::from_ptr(fmi3GetVersion()) }, c"3.0");
}

#[test]
fn an_array_passes_as_a_whole_and_a_step_tells_its_time() {
    let fmu = Fmu::new();
    assert_eq!([fmu.set(&[GAIN], &[2.0]), fmu.enter(5.0, Some(6.0)), fmu.exit()], [OK; 3]);
    assert_eq!(fmu.set(&[U[0], BIAS], &[1.0, 2.0, 3.0, 0.5]), OK);
    assert_eq!(fmu.step(5.0, 0.5), (OK, [0; 3], 5.5));
    assert_eq!(fmu.get(&[TIME, Y[0], GAIN]), [5.5, 1.25, 2.25, 3.25, 2.0]);
    fmu.assert_refused(fmu.step(5.5, 0.75).0, &["fmi3DoStep", "must not pass stopTime = 6.000e0"]);
    assert_eq!(fmu.step(5.5, 0.5), (OK, [0; 3], 6.0));
    assert_eq!(fmi3Terminate(fmu.c), OK);
}

#[test]
fn the_number_of_values_is_that_of_the_variables() {
    let fmu = Fmu::initialised();
    fmu.assert_refused(fmu.set(&[U[0]], &[1.0]), &["fmi3SetFloat64", "nValues = 1 must be 3"]);
    fmu.assert_refused(fmu.try_get::<4>(&[Y[0]]).0, &["fmi3GetFloat64", "nValues = 4 must be 3"]);
    fmu.assert_refused(fmu.set(&[U[1]], &[1.0; 2]), &["value reference 4 does not exist"]);
    fmu.assert_refused(fmu.set(&[U[0]], &[1.0, f64::NAN, 2.0]), &["u[2] = NaN must be finite"]);
    assert_eq!(fmu.get(&[U[0]]), [0.0; 3], "nothing was set");
}

#[test]
fn all_types_pass_and_each_only_as_itself() {
    let fmu = Fmu::new();
    let label = c"fin".as_ptr();
    assert_eq!(fmi3SetInt32(fmu.c, &ORDER, 1, &2, 1), OK);
    assert_eq!(fmi3SetInt64(fmu.c, &MODE, 1, &2, 1), OK);
    assert_eq!(fmi3SetBoolean(fmu.c, &HOLD, 1, &255, 1), OK, "a byte that is no bool");
    assert_eq!(fmi3SetString(fmu.c, &LABEL, 1, &label, 1), OK);
    fmu.assert_refused(fmi3SetInt64(fmu.c, &MODE, 1, &3, 1), &["mode = 3 must be >= 1 and <= 2"]);
    fmu.assert_refused(fmi3SetInt64(fmu.c, &MODE, 1, &(1 << 40), 1), &["no enumeration has the item 1099511627776"]);
    fmu.assert_refused(fmi3SetInt32(fmu.c, &MODE, 1, &1, 1), &["the Enumeration mode, is not of type Int32"]);
    fmu.assert_refused(fmi3SetInt64(fmu.c, &ORDER, 1, &1, 1), &["the Int32 order, is not of type Enumeration"]);
    assert_eq!([fmu.enter(0.0, None), fmu.exit()], [OK; 2]);
    assert_eq!(fmu.step(0.0, 1.0).0, OK);
    let (mut order, mut mode, mut held, mut echo) = (0, 0, 7, null());
    assert_eq!(fmi3GetInt32(fmu.c, &ORDER, 1, &mut order, 1), OK);
    assert_eq!(fmi3GetInt64(fmu.c, &MODE, 1, &mut mode, 1), OK);
    assert_eq!(fmi3GetBoolean(fmu.c, &HELD, 1, &mut held, 1), OK);
    assert_eq!(fmi3GetString(fmu.c, &ECHO, 1, &mut echo, 1), OK);
    // SAFETY: the glue's string lives until the next call.
    assert_eq!((order, mode, held, unsafe { CStr::from_ptr(echo) }), (2, 2, 1, c"fin at 0"));
    let mut single = 0.0;
    let status = fmi3GetFloat32(fmu.c, &GAIN, 1, &mut single, 1);
    fmu.assert_refused(status, &["fmi3GetFloat32", "the Float64 gain, is not of type Float32"]);
    fmu.assert_refused(fmi3GetClock(fmu.c, &GAIN, 1, &mut 0), &["gain, is not of type Clock"]);
    assert_eq!(fmi3GetFloat32(fmu.c, null(), 0, null_mut(), 0), OK, "of no variables there are no values");
}

#[test]
fn what_is_not_there_is_refused_with_the_reason_and_changes_nothing() {
    let fmu = Fmu::initialised();
    fmu.assert_refused(fmi3EnterEventMode(fmu.c), &["fmi3EnterEventMode: the unit has no event mode"]);
    fmu.assert_refused(fmi3EnterStepMode(fmu.c), &["fmi3EnterStepMode: the unit has no event mode"]);
    fmu.assert_refused(fmi3EvaluateDiscreteStates(fmu.c), &["the unit has no event mode"]);
    fmu.assert_refused(fmi3EnterConfigurationMode(fmu.c), &["the unit has no structural parameters"]);
    fmu.assert_refused(fmi3EnterContinuousTimeMode(fmu.c), &["supports co-simulation only"]);
    fmu.assert_refused(fmi3ActivateModelPartition(fmu.c, 0, 0.0), &["supports co-simulation only"]);
    fmu.assert_refused(fmi3GetShiftDecimal(fmu.c, null(), 0, null_mut()), &["the unit has no clocks"]);
    fmu.assert_refused(fmi3GetNumberOfVariableDependencies(fmu.c, 0, &mut 0), &["modelDescription.xml"]);
    fmu.assert_refused(fmu.enter(0.0, None), &["fmi3EnterInitializationMode", "step complete"]);
    assert_eq!(fmu.step(0.0, 1.0).0, OK);
    assert_eq!([fmi3EnterEventMode(null_mut()), fmi3Reset(null_mut())], [ERROR; 2]);
}

#[test]
fn null_pointers_are_refused() {
    let fmu = Fmu::initialised();
    fmu.assert_refused(fmi3GetFloat64(fmu.c, null(), 1, &mut 0.0, 1), &["valueReferences is NULL, but needs 1 values"]);
    fmu.assert_refused(fmi3GetFloat64(fmu.c, &GAIN, 1, null_mut(), 1), &["value is NULL"]);
    fmu.assert_refused(fmi3SetFloat64(fmu.c, &BIAS, 1, null(), 1), &["values is NULL"]);
    fmu.assert_refused(fmi3GetFMUState(fmu.c, null_mut()), &["FMUstate is NULL"]);
    let (mut flag, mut end, mut time) = (0, 0, 0.0);
    let status = fmi3DoStep(fmu.c, 0.0, 1.0, 1, &mut flag, null_mut(), &mut end, &mut time);
    fmu.assert_refused(status, &["terminateSimulation is NULL"]);
    let status = fmi3DoStep(fmu.c, 0.0, 1.0, 1, &mut flag, &mut flag, &mut end, null_mut());
    fmu.assert_refused(status, &["lastSuccessfulTime is NULL"]);
    assert_eq!(fmu.get(&[TIME]), [0.0], "no step was made");
}

#[test]
fn nothing_is_said_where_logging_is_off() {
    let fmu = Fmu::initialised();
    assert_eq!(fmu.messages.borrow()[..], [(0, "initialised début".to_string())]);
    assert_eq!(fmi3SetDebugLogging(fmu.c, 0, 0, null()), OK);
    assert_eq!(fmu.set(&[U[0]], &[FAILING; 3]), OK);
    assert_eq!(fmu.step(0.0, 1.0), (ERROR, [0; 3], 0.0));
    assert_eq!(fmu.messages.borrow().len(), 1, "{:?}", fmu.messages);
    assert_eq!(fmi3SetDebugLogging(fmu.c, 1, 1, &c"logStatusError".as_ptr()), OK);
    fmu.assert_refused(fmu.step(0.0, 1.0).0, &["the state \"error\" does not allow this call"]);

    let silent = Messages::default();
    assert!(instantiate(&token(), Some(c"/no"), 0, 0, &silent).is_null() && silent.borrow().is_empty());
}

#[test]
fn a_wrong_instantiation_returns_null_and_tells_why() {
    let (messages, two, three) = (Messages::default(), guid(), token());
    assert!(instantiate(&two, None, 1, 0, &messages).is_null());
    assert!(instantiate(&three, None, 1, 1, &messages).is_null());
    assert!(instantiate(&three, Some(c"/no/folder"), 1, 0, &messages).is_null());
    let environment = (&raw const messages).cast_mut().cast();
    let (name, token) = (c"one".as_ptr(), three.as_ptr());
    assert!(fmi3InstantiateModelExchange(name, token, null(), 0, 1, environment, Some(log)).is_null());
    let said = messages.borrow();
    for ((_, message), part) in
        said.iter().zip(["belongs to another model description", "event", "not a folder, 100 %", "co-simulation only"])
    {
        assert!(message.starts_with("fmi3Instantiate") && message.contains(part), "{message}");
    }
    assert!(said.len() == 4 && !said[2].1.contains("%%"), "{said:?}: a message is no format string");
}

#[test]
fn after_a_failure_or_a_panic_a_stored_state_leads_on() {
    let fmu = Fmu::initialised();
    let mut state = null_mut();
    assert_eq!([fmu.set(&[U[0]], &[1.0; 3]), fmu.step(0.0, 1.0).0, fmi3GetFMUState(fmu.c, &mut state)], [OK; 3]);
    for (value, part) in [(FAILING, "u[1] = 13 must not"), (PANICKING, "panic at")] {
        assert_eq!(fmu.set(&[U[0]], &[value; 3]), OK);
        let (status, _, reached) = fmu.step(1.0, 1.0);
        fmu.assert_refused(status, &["fmi3DoStep", part]);
        assert_eq!(reached, 1.0);
        assert_eq!([fmi3SetFMUState(fmu.c, state), fmu.step(1.0, 1.0).0], [OK; 2]);
        assert_eq!(fmu.get(&[TIME, Y[0]]), [2.0; 4]);
        assert_eq!(fmi3SetFMUState(fmu.c, state), OK);
    }
    assert_eq!([fmi3FreeFMUState(fmu.c, &mut state), fmi3Reset(fmu.c), fmu.enter(0.0, None)], [OK; 3]);
    assert!(state.is_null());
    fmu.assert_refused(fmi3SetFMUState(fmu.c, 1 as _), &["does not belong to this instance"]);
}

#[test]
fn bytes_carry_a_state_on_but_not_from_the_other_version() {
    let (fmu, other) = (Fmu::initialised(), Fmu::new());
    let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
    assert_eq!([fmu.set(&[U[0]], &[0.1; 3]), fmu.step(0.0, 0.1).0, fmi3GetFMUState(fmu.c, &mut state)], [OK; 3]);
    assert_eq!(fmi3SerializedFMUStateSize(fmu.c, state, &mut size), OK);
    let mut bytes = vec![0; size];
    fmu.assert_refused(fmi3SerializeFMUState(fmu.c, state, bytes.as_mut_ptr(), size - 1), &["must be at least"]);
    assert_eq!(fmi3SerializeFMUState(fmu.c, state, bytes.as_mut_ptr(), size), OK);
    assert_eq!(fmi3DeserializeFMUState(other.c, bytes.as_ptr(), size, &mut copy), OK);
    assert_eq!(fmi3SetFMUState(other.c, copy), OK);
    assert_eq!([fmu.step(0.1, 0.1).0, other.step(0.1, 0.1).0], [OK; 2]);
    assert_eq!(other.get::<3>(&[Y[0]]).map(f64::to_bits), fmu.get::<3>(&[Y[0]]).map(f64::to_bits));

    let (two, mut state) = (Fmu2::new(), null_mut());
    assert_eq!(two.save(&mut state), fmi2Status::fmi2OK);
    let bytes = two.serialize(state);
    let status = fmi3DeserializeFMUState(fmu.c, bytes.as_ptr(), bytes.len(), &mut copy);
    fmu.assert_refused(status, &["with another model description", guid().to_str().unwrap()]);
}

#[test]
fn derivatives_are_refused_as_the_description_says() {
    let fmu = Fmu::new();
    assert_eq!([fmu.enter(0.0, None), fmu.exit()], [OK; 2]);
    let (y, u, mut values) = (&Y[0], &U[0], [0.0; 3]);
    let (seed, out) = ([1.0; 3], values.as_mut_ptr());
    let status = fmi3GetDirectionalDerivative(fmu.c, y, 1, u, 1, seed.as_ptr(), 3, out, 3);
    fmu.assert_refused(status, &["directional derivatives are not provided"]);
    let status = fmi3GetAdjointDerivative(fmu.c, y, 1, u, 1, seed.as_ptr(), 3, out, 3);
    fmu.assert_refused(status, &["adjoint derivatives are not provided"]);
    fmu.assert_refused(fmi3GetOutputDerivatives(fmu.c, y, 1, &1, out, 3), &["output derivatives are not provided"]);
    assert_eq!((fmu.step(0.0, 1.0).0, values), (OK, [0.0; 3]));
}
