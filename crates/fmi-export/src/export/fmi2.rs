//! Functions of FMI 2.0.

use std::ffi::{CStr, CString, c_void};
use std::ptr;

use super::call::*;
use crate::instance::Instance;
use crate::log::Log;
use crate::model::Model;
use crate::state_machine::Function;
use crate::sys::*;
use crate::version::Version;

pub unsafe fn fmi2GetTypesPlatform<M: Model>() -> fmi2String {
    c"default".as_ptr()
}

pub unsafe fn fmi2GetVersion<M: Model>() -> fmi2String {
    c"2.0".as_ptr()
}

pub unsafe fn fmi2SetDebugLogging<M: Model>(
    c: fmi2Component,
    on: fmi2Boolean,
    n: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { call::<M, _>(c, Function::fmi2SetDebugLogging, |instance| set_logging(instance, on != 0, n, categories)) }
}

pub unsafe fn fmi2Instantiate<M: Model>(
    name: fmi2String,
    kind: fmi2Type,
    guid: fmi2String,
    resources: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    logging: fmi2Boolean,
) -> fmi2Component {
    // SAFETY: `functions` is null or valid by the module's precondition; what it holds is copied.
    let Some(functions) = (unsafe { functions.as_ref() }) else {
        return ptr::null_mut();
    };
    let instance_name = match name.is_null() {
        true => CString::default(),
        // SAFETY: the name is not null and a string by the module's precondition.
        false => unsafe { CStr::from_ptr(name) }.to_owned(),
    };
    // SAFETY: by the standard, logger and environment outlive the instance.
    let log = unsafe { Log::fmi2(functions.logger, functions.componentEnvironment, instance_name, logging != 0) };
    instantiate::<M>("fmi2Instantiate", log, || {
        if kind != fmi2Type::fmi2CoSimulation {
            return Err(format!("fmuType = {} must be fmi2CoSimulation", kind.0));
        }
        // SAFETY: the module's precondition on strings.
        unsafe { load(Version::Fmi2, name, ["fmuGUID", "fmuResourceLocation"], [guid, resources]) }
    })
}

pub unsafe fn fmi2FreeInstance<M: Model>(c: fmi2Component) {
    // SAFETY: the module's precondition.
    unsafe { free::<M>(c) }
}

pub unsafe fn fmi2SetupExperiment<M: Model>(
    c: fmi2Component,
    _has_tolerance: fmi2Boolean,
    _tolerance: fmi2Real,
    start: fmi2Real,
    has_stop: fmi2Boolean,
    stop: fmi2Real,
) -> fmi2Status {
    let stop = (has_stop != 0).then_some(stop);
    // SAFETY: the module's precondition.
    unsafe { call::<M, _>(c, Function::fmi2SetupExperiment, |instance| instance.setup_experiment(start, stop)) }
}

without_arguments! {
    fmi2Status;
    fmi2EnterInitializationMode = |instance| { instance.enter_initialization(); Ok(()) };
    fmi2ExitInitializationMode = |instance| instance.exit_initialization();
    fmi2Terminate = |instance| { instance.terminate(); Ok(()) };
    fmi2Reset = |instance| instance.reset();
    fmi2CancelStep = |_| Err("no step runs asynchronously".into());
}

macro_rules! getters {
    ($($name:ident($value:ty) = $write:expr;)*) => {
        $(
            pub unsafe fn $name<M: Model>(
                c: fmi2Component,
                vr: *const fmi2ValueReference,
                n: usize,
                value: *mut $value,
            ) -> fmi2Status {
                // SAFETY: the module's precondition.
                unsafe {
                    call::<M, _>(c, Function::$name, |instance| {
                        get_values(instance, array("vr", vr, n)?, (value, n), $write)
                    })
                }
            }
        )*
    };
}

getters! {
    fmi2GetReal(fmi2Real) = |real: &f64| *real;
    fmi2GetInteger(fmi2Integer) = |integer: &i32| *integer;
    fmi2GetBoolean(fmi2Boolean) = |boolean: &bool| fmi2Boolean::from(*boolean);
}

pub unsafe fn fmi2GetString<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M, _>(c, Function::fmi2GetString, |instance| get_strings(instance, array("vr", vr, n)?, (value, n)))
    }
}

macro_rules! setters {
    ($($name:ident($value:ty) = |$values:ident| $read:expr;)*) => {
        $(
            pub unsafe fn $name<M: Model>(
                c: fmi2Component,
                vr: *const fmi2ValueReference,
                n: usize,
                value: *const $value,
            ) -> fmi2Status {
                // SAFETY: the module's precondition.
                unsafe {
                    call::<M, _>(c, Function::$name, |instance| {
                        let (references, $values) = (array("vr", vr, n)?, array("value", value, n)?);
                        instance.set(references, $read)
                    })
                }
            }
        )*
    };
}

setters! {
    fmi2SetReal(fmi2Real) = |values| values;
    fmi2SetInteger(fmi2Integer) = |values| values;
    fmi2SetBoolean(fmi2Boolean) = |values| &values.iter().map(|value| *value != 0).collect::<Vec<_>>();
}

pub unsafe fn fmi2SetString<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M, _>(c, Function::fmi2SetString, |instance| set_strings(instance, array("vr", vr, n)?, (value, n)))
    }
}

state_functions! {
    fmi2FMUstate, fmi2Byte, fmi2Status;
    fmi2GetFMUstate, fmi2SetFMUstate, fmi2FreeFMUstate;
    fmi2SerializedFMUstateSize, fmi2SerializeFMUstate, fmi2DeSerializeFMUstate;
}

not_provided! {
    fmi2Status;
    fmi2GetDirectionalDerivative(
        *const fmi2ValueReference, usize, *const fmi2ValueReference, usize, *const fmi2Real, *mut fmi2Real
    ) = "directional derivatives are not provided";
    fmi2SetRealInputDerivatives(*const fmi2ValueReference, usize, *const fmi2Integer, *const fmi2Real)
        = "input derivatives are not used";
    fmi2GetRealOutputDerivatives(*const fmi2ValueReference, usize, *const fmi2Integer, *mut fmi2Real)
        = "output derivatives are not provided";
}

pub unsafe fn fmi2DoStep<M: Model>(
    c: fmi2Component,
    time: fmi2Real,
    step: fmi2Real,
    _no_rollback: fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { call::<M, _>(c, Function::fmi2DoStep, |instance| instance.step(time, step)) }
}

/// Answer a question about the status. The answer about asynchronous steps, which no unit has, is `fmi2Discard`.
///
/// # Safety
/// The module's precondition; `value` is null or valid.
unsafe fn status<M: Model, T>(
    c: fmi2Component,
    function: Function,
    value: *mut T,
    answer: impl FnOnce(&Instance<M>) -> Option<T>,
) -> fmi2Status {
    // SAFETY: the caller keeps the precondition.
    unsafe {
        call_with_outcome::<M>(c, function, |instance| {
            check_target("value", value, 1)?;
            let Some(answer) = answer(instance) else {
                return Ok(Outcome::Discard);
            };
            value.write(answer);
            Ok(Outcome::Ok)
        })
    }
    .into()
}

pub unsafe fn fmi2GetStatus<M: Model>(c: fmi2Component, _kind: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::fmi2GetStatus, value, |_| None) }
}

pub unsafe fn fmi2GetRealStatus<M: Model>(c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status {
    let asks_for_time = kind == fmi2StatusKind::fmi2LastSuccessfulTime;
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::fmi2GetRealStatus, value, |instance| asks_for_time.then(|| instance.time())) }
}

pub unsafe fn fmi2GetIntegerStatus<M: Model>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::fmi2GetIntegerStatus, value, |_| None) }
}

pub unsafe fn fmi2GetBooleanStatus<M: Model>(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // A model never asks to end the simulation.
    let asks_for_end = kind == fmi2StatusKind::fmi2Terminated;
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::fmi2GetBooleanStatus, value, |_| asks_for_end.then_some(0)) }
}

pub unsafe fn fmi2GetStringStatus<M: Model>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::fmi2GetStringStatus, value, |_| None) }
}
