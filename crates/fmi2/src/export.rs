//! The C functions, generic over the model, and the macro that gives them their names.
//!
//! Their common precondition is FMI 2.0's: an instance pointer is null or comes from `fmi2Instantiate` of the same
//! model, is not yet freed and not used by two threads at once; arrays have the length they are said to have; strings
//! are null-terminated.
#![allow(non_snake_case, reason = "the functions are named as in the standard")]
#![allow(clippy::missing_safety_doc, reason = "the precondition is the module's")]
#![allow(missing_docs, reason = "the functions are described in the standard")]

use std::ffi::{CStr, CString, c_char};
use std::path::Path;
use std::{ptr, slice};

use crate::guard;
use crate::instance::{self, Instance};
use crate::log::Log;
use crate::model::Model;
use crate::resource::{self, Resources};
use crate::state_machine::Function;
use crate::sys::*;
use crate::variable::Value;

/// Exports [`Model`] as an FMI 2.0 co-simulation library: all 34 functions of the standard, and one for packagers.
///
/// To be called once in a crate of type `cdylib`, which is then the library of one FMU.
///
/// `int fmu_model_description(const char *resources, char *buffer, size_t capacity, size_t *needed)` makes
/// `modelDescription.xml` for the resources in a folder (a plain path, or NULL). It returns 0 if the text is the
/// model description and 1 if it is an error message. `*needed` is its size with the final NUL; the text is written
/// only if the capacity suffices.
///
/// `int fmu_field(fmi2Component c, const char *name, double *buffer, size_t capacity, size_t *shape)` copies a field of
/// [`Model::field`](crate::Model::field). It returns 0, or 1 where there is none of that name or no instance in a state
/// that can be read; `shape` gets both lengths, and the values are written only if the capacity suffices.
#[macro_export]
macro_rules! export_fmu {
    ($model:ty) => {
        $crate::__export_functions! { $model =>
            fmi2GetTypesPlatform: fmi2GetTypesPlatformTYPE = () -> fmi2String;
            fmi2GetVersion: fmi2GetVersionTYPE = () -> fmi2String;
            fmi2SetDebugLogging: fmi2SetDebugLoggingTYPE =
                (c: fmi2Component, on: fmi2Boolean, n: usize, categories: *const fmi2String) -> fmi2Status;
            fmi2Instantiate: fmi2InstantiateTYPE =
                (name: fmi2String, kind: fmi2Type, guid: fmi2String, resources: fmi2String,
                 functions: *const fmi2CallbackFunctions, visible: fmi2Boolean, logging: fmi2Boolean) -> fmi2Component;
            fmi2FreeInstance: fmi2FreeInstanceTYPE = (c: fmi2Component) -> ();
            fmi2SetupExperiment: fmi2SetupExperimentTYPE =
                (c: fmi2Component, has_tolerance: fmi2Boolean, tolerance: fmi2Real, start: fmi2Real,
                 has_stop: fmi2Boolean, stop: fmi2Real) -> fmi2Status;
            fmi2EnterInitializationMode: fmi2EnterInitializationModeTYPE = (c: fmi2Component) -> fmi2Status;
            fmi2ExitInitializationMode: fmi2ExitInitializationModeTYPE = (c: fmi2Component) -> fmi2Status;
            fmi2Terminate: fmi2TerminateTYPE = (c: fmi2Component) -> fmi2Status;
            fmi2Reset: fmi2ResetTYPE = (c: fmi2Component) -> fmi2Status;
            fmi2GetReal: fmi2GetRealTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Real) -> fmi2Status;
            fmi2GetInteger: fmi2GetIntegerTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Integer) -> fmi2Status;
            fmi2GetBoolean: fmi2GetBooleanTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2Boolean) -> fmi2Status;
            fmi2GetString: fmi2GetStringTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *mut fmi2String) -> fmi2Status;
            fmi2SetReal: fmi2SetRealTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2Real) -> fmi2Status;
            fmi2SetInteger: fmi2SetIntegerTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2Integer) -> fmi2Status;
            fmi2SetBoolean: fmi2SetBooleanTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2Boolean) -> fmi2Status;
            fmi2SetString: fmi2SetStringTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, value: *const fmi2String) -> fmi2Status;
            fmi2GetFMUstate: fmi2GetFMUstateTYPE = (c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
            fmi2SetFMUstate: fmi2SetFMUstateTYPE = (c: fmi2Component, state: fmi2FMUstate) -> fmi2Status;
            fmi2FreeFMUstate: fmi2FreeFMUstateTYPE = (c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status;
            fmi2SerializedFMUstateSize: fmi2SerializedFMUstateSizeTYPE =
                (c: fmi2Component, state: fmi2FMUstate, size: *mut usize) -> fmi2Status;
            fmi2SerializeFMUstate: fmi2SerializeFMUstateTYPE =
                (c: fmi2Component, state: fmi2FMUstate, bytes: *mut fmi2Byte, size: usize) -> fmi2Status;
            fmi2DeSerializeFMUstate: fmi2DeSerializeFMUstateTYPE =
                (c: fmi2Component, bytes: *const fmi2Byte, size: usize, state: *mut fmi2FMUstate) -> fmi2Status;
            fmi2GetDirectionalDerivative: fmi2GetDirectionalDerivativeTYPE =
                (c: fmi2Component, unknown: *const fmi2ValueReference, n_unknown: usize,
                 known: *const fmi2ValueReference, n_known: usize, seed: *const fmi2Real,
                 derivative: *mut fmi2Real) -> fmi2Status;
            fmi2SetRealInputDerivatives: fmi2SetRealInputDerivativesTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, order: *const fmi2Integer,
                 value: *const fmi2Real) -> fmi2Status;
            fmi2GetRealOutputDerivatives: fmi2GetRealOutputDerivativesTYPE =
                (c: fmi2Component, vr: *const fmi2ValueReference, n: usize, order: *const fmi2Integer,
                 value: *mut fmi2Real) -> fmi2Status;
            fmi2DoStep: fmi2DoStepTYPE =
                (c: fmi2Component, time: fmi2Real, step: fmi2Real, no_rollback: fmi2Boolean) -> fmi2Status;
            fmi2CancelStep: fmi2CancelStepTYPE = (c: fmi2Component) -> fmi2Status;
            fmi2GetStatus: fmi2GetStatusTYPE =
                (c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status;
            fmi2GetRealStatus: fmi2GetRealStatusTYPE =
                (c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status;
            fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE =
                (c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Integer) -> fmi2Status;
            fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE =
                (c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2Boolean) -> fmi2Status;
            fmi2GetStringStatus: fmi2GetStringStatusTYPE =
                (c: fmi2Component, kind: fmi2StatusKind, value: *mut fmi2String) -> fmi2Status;
            fmu_model_description: ModelDescriptionTYPE =
                (resources: fmi2String, buffer: *mut fmi2Char, capacity: usize, needed: *mut usize) -> fmi2Integer;
            fmu_field: FieldTYPE =
                (c: fmi2Component, name: fmi2String, buffer: *mut fmi2Real, capacity: usize, shape: *mut usize)
                -> fmi2Integer;
        }
    };
}

/// Each function under its C name, with the header's type as a witness of its signature.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_functions {
    ($model:ty => $($name:ident: $header_type:ident = ($($argument:ident: $type:ty),*) -> $result:ty;)*) => {
        const _: () = {
            use $crate::export::{FieldTYPE, ModelDescriptionTYPE};
            use $crate::sys::*;
            $(
                // SAFETY: the names are the standard's own; a library exports one model.
                #[unsafe(no_mangle)]
                unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                    // SAFETY: the caller keeps the precondition of the standard, which is that of `export`.
                    unsafe { $crate::export::$name::<$model>($($argument),*) }
                }
                const _: $header_type = Some($name);
            )*
        };
    };
}

/// Type of `fmu_model_description`, see [`export_fmu!`](crate::export_fmu).
pub type ModelDescriptionTYPE =
    Option<unsafe extern "C" fn(fmi2String, *mut fmi2Char, usize, *mut usize) -> fmi2Integer>;

/// Type of `fmu_field`, see [`export_fmu!`](crate::export_fmu).
pub type FieldTYPE =
    Option<unsafe extern "C" fn(fmi2Component, fmi2String, *mut fmi2Real, usize, *mut usize) -> fmi2Integer>;

const OK: fmi2Status = fmi2Status::fmi2OK;
const ERROR: fmi2Status = fmi2Status::fmi2Error;

/// Calls `body` on the instance if the state machine allows the function. A refusal or panic is logged and becomes
/// `fmi2Error`.
///
/// # Safety
/// The module's precondition on `c`.
unsafe fn call_with_status<M: Model>(
    c: fmi2Component,
    function: Function,
    body: impl FnOnce(&mut Instance<M>) -> Result<fmi2Status, String>,
) -> fmi2Status {
    // SAFETY: `c` is null or a live instance that no other thread uses.
    let Some(instance) = (unsafe { c.cast::<Instance<M>>().as_mut() }) else {
        return ERROR;
    };
    let result = guard::catch(|| {
        instance.check_order(function)?;
        body(instance)
    });
    let message = match result {
        Ok(Ok(status)) => return status,
        Ok(Err(message)) => message,
        Err(message) => {
            instance.panicked();
            message
        }
    };
    instance.log.error(format_args!("{function}: {message}"));
    ERROR
}

/// [`call_with_status`] for a function that succeeds or fails.
///
/// # Safety
/// The module's precondition on `c`.
unsafe fn call<M: Model>(
    c: fmi2Component,
    function: Function,
    body: impl FnOnce(&mut Instance<M>) -> Result<(), String>,
) -> fmi2Status {
    // SAFETY: the caller keeps the precondition.
    unsafe { call_with_status(c, function, |instance| body(instance).map(|()| OK)) }
}

/// The array that a master passes as pointer and length.
///
/// # Safety
/// `pointer` is null or holds `n` values, which nobody changes during `'a`.
unsafe fn array<'a, T>(name: &str, pointer: *const T, n: usize) -> Result<&'a [T], String> {
    if n == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(format!("{name} is NULL, not {n} values"));
    }
    // SAFETY: the pointer is not null and the caller vouches for the rest.
    Ok(unsafe { slice::from_raw_parts(pointer, n) })
}

/// Refuses NULL for an array of `n` values to be written.
fn check_target<T>(name: &str, pointer: *mut T, n: usize) -> Result<(), String> {
    if n > 0 && pointer.is_null() {
        return Err(format!("{name} is NULL, not room for {n} values"));
    }
    Ok(())
}

/// The string, if it is not NULL.
///
/// # Safety
/// `pointer` is null or a null-terminated string, which nobody changes during `'a`.
unsafe fn string<'a>(name: &str, pointer: *const c_char) -> Result<&'a CStr, String> {
    if pointer.is_null() {
        return Err(format!("{name} is NULL"));
    }
    // SAFETY: the pointer is not null and the caller vouches for the rest.
    Ok(unsafe { CStr::from_ptr(pointer) })
}

/// The string as text, if it is not NULL and UTF-8.
///
/// # Safety
/// That of [`string`].
unsafe fn text<'a>(name: &str, pointer: *const c_char) -> Result<&'a str, String> {
    // SAFETY: the caller keeps the same precondition.
    let string = unsafe { string(name, pointer) }?;
    string.to_str().map_err(|_| format!("{name} = {string:?} is not UTF-8"))
}

pub unsafe extern "C" fn fmi2GetTypesPlatform<M: Model>() -> fmi2String {
    c"default".as_ptr()
}

pub unsafe extern "C" fn fmi2GetVersion<M: Model>() -> fmi2String {
    c"2.0".as_ptr()
}

pub unsafe extern "C" fn fmi2SetDebugLogging<M: Model>(
    c: fmi2Component,
    on: fmi2Boolean,
    n: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::SetDebugLogging, |instance| {
            let categories = array("categories", categories, n)?;
            let categories: Result<Vec<_>, _> = categories.iter().map(|name| string("a category", *name)).collect();
            instance.log.set_debug_logging(on != 0, &categories?)
        })
    }
}

pub unsafe extern "C" fn fmi2Instantiate<M: Model>(
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
        // SAFETY: the name is not null, and a string by the module's precondition.
        false => unsafe { CStr::from_ptr(name) }.to_owned(),
    };
    // SAFETY: the standard asks of the master that logger and environment outlive the instance.
    let log = unsafe { Log::new(functions.logger, functions.componentEnvironment, instance_name, logging != 0) };
    let loaded = guard::catch(|| {
        // SAFETY: the module's precondition on strings.
        let (name, guid, resources) = unsafe {
            let resources = (!resources.is_null()).then(|| text("fmuResourceLocation", resources)).transpose()?;
            (text("instanceName", name)?, text("fmuGUID", guid)?, resources)
        };
        if name.is_empty() {
            return Err("instanceName must not be empty".to_string());
        }
        if kind != fmi2Type::fmi2CoSimulation {
            return Err(format!("fmuType = {} must be fmi2CoSimulation", kind.0));
        }
        let folder = resources.filter(|location| !location.is_empty()).map(resource::folder).transpose()?;
        instance::load_described::<M>(folder.as_deref(), guid)
    });
    match loaded.and_then(|result| result) {
        Ok(loaded) => Box::into_raw(Box::new(Instance::new(log, loaded))).cast(),
        Err(message) => {
            log.error(format_args!("fmi2Instantiate: {message}"));
            ptr::null_mut()
        }
    }
}

pub unsafe extern "C" fn fmi2FreeInstance<M: Model>(c: fmi2Component) {
    if c.is_null() {
        return;
    }
    // SAFETY: by the module's precondition `c` is a live instance from `fmi2Instantiate`, which boxed it.
    let instance = unsafe { Box::from_raw(c.cast::<Instance<M>>()) };
    // There is no instance left to log a panic of the model's destructor, and nothing left to do about it.
    let _ = guard::catch(|| drop(instance));
}

pub unsafe extern "C" fn fmi2SetupExperiment<M: Model>(
    c: fmi2Component,
    _has_tolerance: fmi2Boolean,
    _tolerance: fmi2Real,
    start: fmi2Real,
    has_stop: fmi2Boolean,
    stop: fmi2Real,
) -> fmi2Status {
    let stop = (has_stop != 0).then_some(stop);
    // SAFETY: the module's precondition.
    unsafe { call::<M>(c, Function::SetupExperiment, |instance| instance.setup_experiment(start, stop)) }
}

macro_rules! without_arguments {
    ($($name:ident: $function:ident = $body:expr;)*) => {
        $(
            pub unsafe extern "C" fn $name<M: Model>(c: fmi2Component) -> fmi2Status {
                // SAFETY: the module's precondition.
                unsafe { call::<M>(c, Function::$function, $body) }
            }
        )*
    };
}

without_arguments! {
    fmi2EnterInitializationMode: EnterInitializationMode = |instance| { instance.enter_initialization(); Ok(()) };
    fmi2ExitInitializationMode: ExitInitializationMode = |instance| instance.exit_initialization();
    fmi2Terminate: Terminate = |instance| { instance.terminate(); Ok(()) };
    fmi2Reset: Reset = |instance| instance.reset();
    fmi2CancelStep: CancelStep = |_| Err("a step is never under way".into());
}

/// Reads values of Rust type `T` as the C type `C`.
///
/// # Safety
/// The module's precondition; `value` is null or has room for `n` values.
unsafe fn get<M: Model, T: Value, C>(
    c: fmi2Component,
    function: Function,
    (vr, n): (*const fmi2ValueReference, usize),
    value: *mut C,
    write: impl Fn(&T) -> C,
) -> fmi2Status {
    // SAFETY: `instance.get` hands out each position below `n` once, and `value` has room for `n` values.
    unsafe {
        call::<M>(c, function, |instance| {
            let references = array("vr", vr, n)?;
            check_target("value", value, n)?;
            instance.get::<T>(references, |position, values| {
                for (offset, source) in values.iter().enumerate() {
                    value.add(position + offset).write(write(source));
                }
            })
        })
    }
}

pub unsafe extern "C" fn fmi2GetReal<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { get::<M, f64, _>(c, Function::GetReal, (vr, n), value, |real| *real) }
}

pub unsafe extern "C" fn fmi2GetInteger<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { get::<M, i32, _>(c, Function::GetInteger, (vr, n), value, |integer| *integer) }
}

pub unsafe extern "C" fn fmi2GetBoolean<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { get::<M, bool, _>(c, Function::GetBoolean, (vr, n), value, |boolean| fmi2Boolean::from(*boolean)) }
}

pub unsafe extern "C" fn fmi2GetString<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition; one string is written for each of the `n` references.
    unsafe {
        call::<M>(c, Function::GetString, |instance| {
            let references = array("vr", vr, n)?;
            check_target("value", value, n)?;
            let mut strings = Vec::with_capacity(n);
            instance.get::<String>(references, |_, values| {
                strings.extend(values.iter().map(|text| CString::new(text.replace('\0', "\u{fffd}"))));
            })?;
            instance.strings = strings.into_iter().collect::<Result<_, _>>().expect("NUL was replaced");
            for (position, string) in instance.strings.iter().enumerate() {
                value.add(position).write(string.as_ptr());
            }
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2SetReal<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { call::<M>(c, Function::SetReal, |instance| instance.set(array("vr", vr, n)?, array("value", value, n)?)) }
}

pub unsafe extern "C" fn fmi2SetInteger<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *const fmi2Integer,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::SetInteger, |instance| instance.set(array("vr", vr, n)?, array("value", value, n)?))
    }
}

pub unsafe extern "C" fn fmi2SetBoolean<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *const fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::SetBoolean, |instance| {
            let values: Vec<bool> = array("value", value, n)?.iter().map(|value| *value != 0).collect();
            instance.set(array("vr", vr, n)?, &values)
        })
    }
}

pub unsafe extern "C" fn fmi2SetString<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    value: *const fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::SetString, |instance| {
            let values = array("value", value, n)?.iter();
            let values: Result<Vec<_>, _> = values.map(|value| text("a value", *value).map(str::to_string)).collect();
            instance.set(array("vr", vr, n)?, &values?)
        })
    }
}

/// The FMU state at `state`, zero if there is none.
///
/// # Safety
/// `state` is null or valid.
unsafe fn handle(state: *mut fmi2FMUstate) -> Result<usize, String> {
    check_target("FMUstate", state, 1)?;
    // SAFETY: the pointer is not null and the caller vouches for the rest.
    Ok(unsafe { *state }.addr())
}

pub unsafe extern "C" fn fmi2GetFMUstate<M: Model>(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::GetFMUstate, |instance| {
            *state = ptr::without_provenance_mut(instance.save(handle(state)?)?);
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2SetFMUstate<M: Model>(c: fmi2Component, state: fmi2FMUstate) -> fmi2Status {
    // SAFETY: the module's precondition; the state is a number that is only looked up.
    unsafe { call::<M>(c, Function::SetFMUstate, |instance| instance.restore(state.addr())) }
}

pub unsafe extern "C" fn fmi2FreeFMUstate<M: Model>(c: fmi2Component, state: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::FreeFMUstate, |instance| {
            if state.is_null() || (*state).is_null() {
                return Ok(());
            }
            instance.free(handle(state)?)?;
            *state = ptr::null_mut();
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2SerializedFMUstateSize<M: Model>(
    c: fmi2Component,
    state: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::SerializedFMUstateSize, |instance| {
            check_target("size", size, 1)?;
            *size = instance.serialize(state.addr())?.len();
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2SerializeFMUstate<M: Model>(
    c: fmi2Component,
    state: fmi2FMUstate,
    bytes: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    // SAFETY: the module's precondition; at most `size` bytes are written.
    unsafe {
        call::<M>(c, Function::SerializeFMUstate, |instance| {
            let serialized = instance.serialize(state.addr())?;
            if size < serialized.len() {
                return Err(format!("size = {size} must be at least {}", serialized.len()));
            }
            check_target("serializedState", bytes, size)?;
            ptr::copy_nonoverlapping(serialized.as_ptr(), bytes.cast(), serialized.len());
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2DeSerializeFMUstate<M: Model>(
    c: fmi2Component,
    bytes: *const fmi2Byte,
    size: usize,
    state: *mut fmi2FMUstate,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::DeSerializeFMUstate, |instance| {
            let bytes = array("serializedState", bytes.cast(), size)?;
            *state = ptr::without_provenance_mut(instance.deserialize(bytes, handle(state)?)?);
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2GetDirectionalDerivative<M: Model>(
    c: fmi2Component,
    unknown: *const fmi2ValueReference,
    n_unknown: usize,
    known: *const fmi2ValueReference,
    n_known: usize,
    seed: *const fmi2Real,
    derivative: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::GetDirectionalDerivative, |instance| {
            let (unknown, known) = (array("vUnknown_ref", unknown, n_unknown)?, array("vKnown_ref", known, n_known)?);
            let seed = array("dvKnown", seed, n_known)?;
            check_target("dvUnknown", derivative, n_unknown)?;
            let mut values = vec![0.0; n_unknown];
            instance.directional_derivative(unknown, known, seed, &mut values)?;
            ptr::copy_nonoverlapping(values.as_ptr(), derivative, n_unknown);
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2SetRealInputDerivatives<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::SetRealInputDerivatives, |instance| {
            let (references, orders) = (array("vr", vr, n)?, array("order", order, n)?);
            instance.set_input_derivatives(references, orders, array("value", value, n)?)
        })
    }
}

pub unsafe extern "C" fn fmi2GetRealOutputDerivatives<M: Model>(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    n: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M>(c, Function::GetRealOutputDerivatives, |instance| {
            let (references, orders) = (array("vr", vr, n)?, array("order", order, n)?);
            check_target("value", value, n)?;
            let mut values = vec![0.0; n];
            instance.output_derivatives(references, orders, &mut values)?;
            ptr::copy_nonoverlapping(values.as_ptr(), value, n);
            Ok(())
        })
    }
}

pub unsafe extern "C" fn fmi2DoStep<M: Model>(
    c: fmi2Component,
    time: fmi2Real,
    step: fmi2Real,
    _no_rollback: fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { call::<M>(c, Function::DoStep, |instance| instance.step(time, step)) }
}

/// Answers a question about the simulation's status. The standard's answer to a question about asynchronous steps,
/// which do not occur here, is `fmi2Discard`.
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
        call_with_status::<M>(c, function, |instance| {
            check_target("value", value, 1)?;
            let Some(answer) = answer(instance) else {
                return Ok(fmi2Status::fmi2Discard);
            };
            value.write(answer);
            Ok(OK)
        })
    }
}

pub unsafe extern "C" fn fmi2GetStatus<M: Model>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2Status,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::GetStatus, value, |_| None) }
}

pub unsafe extern "C" fn fmi2GetRealStatus<M: Model>(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Real,
) -> fmi2Status {
    let asks_for_time = kind == fmi2StatusKind::fmi2LastSuccessfulTime;
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::GetRealStatus, value, |instance| asks_for_time.then(|| instance.time())) }
}

pub unsafe extern "C" fn fmi2GetIntegerStatus<M: Model>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::GetIntegerStatus, value, |_| None) }
}

pub unsafe extern "C" fn fmi2GetBooleanStatus<M: Model>(
    c: fmi2Component,
    kind: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // A model never asks to end the simulation.
    let asks_for_end = kind == fmi2StatusKind::fmi2Terminated;
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::GetBooleanStatus, value, |_| asks_for_end.then_some(0)) }
}

pub unsafe extern "C" fn fmi2GetStringStatus<M: Model>(
    c: fmi2Component,
    _kind: fmi2StatusKind,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the module's precondition.
    unsafe { status::<M, _>(c, Function::GetStringStatus, value, |_| None) }
}

/// See [`export_fmu!`](crate::export_fmu).
///
/// # Safety
/// `resources` is null or a null-terminated string, `buffer` has room for `capacity` bytes, `needed` is null or valid.
pub unsafe extern "C" fn fmu_model_description<M: Model>(
    resources: fmi2String,
    buffer: *mut fmi2Char,
    capacity: usize,
    needed: *mut usize,
) -> fmi2Integer {
    let described = guard::catch(|| {
        // SAFETY: the function's precondition on strings.
        let resources = (!resources.is_null()).then(|| unsafe { text("resources", resources) }).transpose()?;
        let resources = Resources::read(resources.map(Path::new), M::RESOURCES)?;
        let (_, _, document) = instance::load::<M>(&resources)?;
        Ok(document.xml)
    });
    let (code, text) = match described.and_then(|result| result) {
        Ok(xml) => (0, xml),
        Err(message) => (1, message),
    };
    let text = CString::new(text.replace('\0', "\u{fffd}")).expect("NUL was replaced");
    let bytes = text.as_bytes_with_nul();
    // SAFETY: pointers that are null are left alone, and no more is written than there is room for.
    unsafe {
        if let Some(needed) = needed.as_mut() {
            *needed = bytes.len();
        }
        if !buffer.is_null() && bytes.len() <= capacity {
            ptr::copy_nonoverlapping(bytes.as_ptr(), buffer.cast(), bytes.len());
        }
    }
    code
}

/// See [`export_fmu!`](crate::export_fmu).
///
/// # Safety
/// The module's precondition on `c`; `name` is null or a null-terminated string, `buffer` has room for `capacity`
/// values, `shape` is null or has room for two.
pub unsafe extern "C" fn fmu_field<M: Model>(
    c: fmi2Component,
    name: fmi2String,
    buffer: *mut fmi2Real,
    capacity: usize,
    shape: *mut usize,
) -> fmi2Integer {
    let mut found = false;
    let look = |instance: &mut Instance<M>| {
        // SAFETY: the function's precondition on the name.
        let name = unsafe { text("name", name) }?;
        let Some((lengths, values)) = instance.field(name)? else { return Ok(()) };
        // SAFETY: pointers that are null are left alone, and no more is written than there is room for.
        unsafe {
            if !shape.is_null() {
                ptr::copy_nonoverlapping(lengths.as_ptr(), shape, lengths.len());
            }
            if !buffer.is_null() && values.len() <= capacity {
                ptr::copy_nonoverlapping(values.as_ptr(), buffer, values.len());
            }
        }
        found = true;
        Ok(())
    };
    // SAFETY: the module's precondition.
    let status = unsafe { call::<M>(c, Function::GetReal, look) };
    fmi2Integer::from(!(found && status == OK))
}
