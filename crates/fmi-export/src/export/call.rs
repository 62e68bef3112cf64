//! Calls on an instance, and arrays, strings and values behind raw pointers.

use std::ffi::{CStr, CString, c_char, c_void};
use std::{ptr, slice};

use crate::access::Value;
use crate::guard;
use crate::instance::{self, Instance, Loaded};
use crate::log::Log;
use crate::model::Model;
use crate::resource;
use crate::state_machine::Function;
use crate::sys::{fmi2Status, fmi3Status};
use crate::version::Version;

/// Define functions that take nothing but the instance.
macro_rules! without_arguments {
    ($status:ty; $($name:ident = $body:expr;)*) => {
        $(
            pub unsafe fn $name<M: Model>(c: *mut c_void) -> $status {
                // SAFETY: the module's precondition.
                unsafe { call::<M, _>(c, Function::$name, $body) }
            }
        )*
    };
}

/// Define the functions of capabilities that no unit has: they return an error with the reason.
macro_rules! not_provided {
    ($status:ty; $($name:ident($($argument:ty),*) = $reason:literal;)*) => {
        $(
            pub unsafe fn $name<M: Model>(c: *mut c_void, $(_: $argument),*) -> $status {
                // SAFETY: the module's precondition.
                unsafe { call::<M, _>(c, Function::$name, |_| Err($reason.into())) }
            }
        )*
    };
}

/// Define the functions of the FMU state, which have different names and types in both versions.
macro_rules! state_functions {
    (
        $state:ty, $byte:ty, $status:ty;
        $get:ident, $set:ident, $free:ident;
        $size:ident, $serialize:ident, $deserialize:ident;
    ) => {
        pub unsafe fn $get<M: Model>(c: *mut c_void, state: *mut $state) -> $status {
            // SAFETY: the module's precondition.
            unsafe {
                call::<M, _>(c, Function::$get, |instance| {
                    *state = ptr::without_provenance_mut(instance.save(handle(state)?)?);
                    Ok(())
                })
            }
        }

        pub unsafe fn $set<M: Model>(c: *mut c_void, state: $state) -> $status {
            // SAFETY: the module's precondition; the state is a handle that is not dereferenced.
            unsafe { call::<M, _>(c, Function::$set, |instance| instance.restore(state.addr())) }
        }

        pub unsafe fn $free<M: Model>(c: *mut c_void, state: *mut $state) -> $status {
            // SAFETY: the module's precondition.
            unsafe {
                call::<M, _>(c, Function::$free, |instance| {
                    if state.is_null() || (*state).is_null() {
                        return Ok(());
                    }
                    instance.free(handle(state)?)?;
                    *state = ptr::null_mut();
                    Ok(())
                })
            }
        }

        pub unsafe fn $size<M: Model>(c: *mut c_void, state: $state, size: *mut usize) -> $status {
            // SAFETY: the module's precondition.
            unsafe {
                call::<M, _>(c, Function::$size, |instance| {
                    check_target("size", size, 1)?;
                    *size = instance.serialize(state.addr())?.len();
                    Ok(())
                })
            }
        }

        pub unsafe fn $serialize<M: Model>(c: *mut c_void, state: $state, bytes: *mut $byte, size: usize) -> $status {
            // SAFETY: the module's precondition; at most `size` bytes are written.
            unsafe {
                call::<M, _>(c, Function::$serialize, |instance| {
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

        pub unsafe fn $deserialize<M: Model>(
            c: *mut c_void,
            bytes: *const $byte,
            size: usize,
            state: *mut $state,
        ) -> $status {
            // SAFETY: the module's precondition.
            unsafe {
                call::<M, _>(c, Function::$deserialize, |instance| {
                    let bytes = array("serializedState", bytes.cast(), size)?;
                    *state = ptr::without_provenance_mut(instance.deserialize(bytes, handle(state)?)?);
                    Ok(())
                })
            }
        }
    };
}

pub(super) use {not_provided, state_functions, without_arguments};

/// Result of a call on an instance.
pub(super) enum Outcome {
    Ok,
    Discard,
    Error,
}

impl From<Outcome> for fmi2Status {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Ok => fmi2Status::fmi2OK,
            Outcome::Discard => fmi2Status::fmi2Discard,
            Outcome::Error => fmi2Status::fmi2Error,
        }
    }
}

impl From<Outcome> for fmi3Status {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Ok => fmi3Status::fmi3OK,
            Outcome::Discard => fmi3Status::fmi3Discard,
            Outcome::Error => fmi3Status::fmi3Error,
        }
    }
}

/// Call `body` on the instance if the state machine allows the function. Log a refusal or a panic as an error.
///
/// # Safety
/// The module's precondition on `c`.
pub(super) unsafe fn call_with_outcome<M: Model>(
    c: *mut c_void,
    function: Function,
    body: impl FnOnce(&mut Instance<M>) -> Result<Outcome, String>,
) -> Outcome {
    // SAFETY: `c` is null or a live instance that no other thread uses.
    let Some(instance) = (unsafe { c.cast::<Instance<M>>().as_mut() }) else {
        return Outcome::Error;
    };
    let result = guard::catch(|| {
        instance.check_order(function)?;
        body(instance)
    });
    let message = match result {
        Ok(Ok(outcome)) => return outcome,
        Ok(Err(message)) => message,
        Err(message) => {
            instance.panicked();
            message
        }
    };
    instance.log.error(format_args!("{function}: {message}"));
    Outcome::Error
}

/// Call `body` as [`call_with_outcome`] does, for a function that succeeds or fails.
///
/// # Safety
/// The module's precondition on `c`.
pub(super) unsafe fn call<M: Model, S: From<Outcome>>(
    c: *mut c_void,
    function: Function,
    body: impl FnOnce(&mut Instance<M>) -> Result<(), String>,
) -> S {
    // SAFETY: the caller keeps the precondition.
    unsafe { call_with_outcome(c, function, |instance| body(instance).map(|()| Outcome::Ok)) }.into()
}

/// Return a new instance, or log the reason of the failure and return null.
pub(super) fn instantiate<M: Model>(
    function: &str,
    log: Log,
    loaded: impl FnOnce() -> Result<Loaded<M>, String>,
) -> *mut c_void {
    match guard::catch(loaded).and_then(|result| result) {
        Ok(loaded) => Box::into_raw(Box::new(Instance::new(log, loaded))).cast(),
        Err(message) => {
            log.error(format_args!("{function}: {message}"));
            ptr::null_mut()
        }
    }
}

/// Load the model of a new instance from what the master passes; `names` are those of GUID and location.
///
/// # Safety
/// The module's precondition on strings.
pub(super) unsafe fn load<M: Model>(
    version: Version,
    name: *const c_char,
    names: [&str; 2],
    [guid, location]: [*const c_char; 2],
) -> Result<Loaded<M>, String> {
    // SAFETY: the caller keeps the precondition.
    let (name, guid, location) = unsafe {
        let location = (!location.is_null()).then(|| text(names[1], location)).transpose()?;
        (text("instanceName", name)?, text(names[0], guid)?, location)
    };
    if name.is_empty() {
        return Err("instanceName must not be empty".to_string());
    }
    let folder = location.filter(|location| !location.is_empty()).map(resource::folder).transpose()?;
    instance::load_described(folder.as_deref(), guid, version)
}

/// Free an instance.
///
/// # Safety
/// The module's precondition on `c`.
pub(super) unsafe fn free<M: Model>(c: *mut c_void) {
    if c.is_null() {
        return;
    }
    // SAFETY: by the module's precondition `c` is a live instance from the box in `instantiate`.
    let instance = unsafe { Box::from_raw(c.cast::<Instance<M>>()) };
    // A panic of the model's destructor has no instance left that could log it.
    let _ = guard::catch(|| drop(instance));
}

/// Turn log categories on or off.
///
/// # Safety
/// The module's precondition on strings and arrays.
pub(super) unsafe fn set_logging<M: Model>(
    instance: &Instance<M>,
    on: bool,
    n: usize,
    categories: *const *const c_char,
) -> Result<(), String> {
    // SAFETY: the caller keeps the precondition.
    unsafe {
        let categories = array("categories", categories, n)?;
        let categories: Result<Vec<_>, _> = categories.iter().map(|name| string("a category", *name)).collect();
        instance.log.set_debug_logging(on, &categories?)
    }
}

/// Write the values of variables, `n` in total, as the C type `C`.
///
/// # Safety
/// `value` has room for `n` values.
pub(super) unsafe fn get_values<M: Model, T: Value, C>(
    instance: &mut Instance<M>,
    references: &[u32],
    (value, n): (*mut C, usize),
    write: impl Fn(&T) -> C,
) -> Result<(), String> {
    check_target("value", value, n)?;
    instance.get::<T>(references, |position, values| {
        for (offset, source) in values.iter().enumerate() {
            // SAFETY: `Instance::get` passes each position below `n` once, and `value` has room for `n` values.
            unsafe { value.add(position + offset).write(write(source)) };
        }
    })
}

/// Write the values of String variables, `n` in total; they live until the next call.
///
/// # Safety
/// `value` has room for `n` pointers.
pub(super) unsafe fn get_strings<M: Model>(
    instance: &mut Instance<M>,
    references: &[u32],
    (value, n): (*mut *const c_char, usize),
) -> Result<(), String> {
    check_target("value", value, n)?;
    let mut strings = Vec::new();
    instance.get::<String>(references, |_, values| {
        strings.extend(values.iter().map(|text| CString::new(text.replace('\0', "\u{fffd}"))));
    })?;
    instance.strings = strings.into_iter().collect::<Result<_, _>>().expect("NUL was replaced");
    for (position, string) in instance.strings.iter().enumerate() {
        // SAFETY: each of the `n` values gets one string.
        unsafe { value.add(position).write(string.as_ptr()) };
    }
    Ok(())
}

/// Set String variables from `n` texts.
///
/// # Safety
/// The module's precondition on strings and arrays.
pub(super) unsafe fn set_strings<M: Model>(
    instance: &mut Instance<M>,
    references: &[u32],
    (value, n): (*const *const c_char, usize),
) -> Result<(), String> {
    // SAFETY: the caller keeps the precondition.
    let values = unsafe { array("value", value, n)?.iter().map(|value| text("a value", *value).map(str::to_string)) };
    instance.set(references, &values.collect::<Result<Vec<_>, _>>()?)
}

/// Largest number of values in a call: above it a master passed a negative number.
const MOST: usize = i32::MAX as usize;

/// Return the array that a master passes as pointer and length.
///
/// # Safety
/// `pointer` is null or holds `n` values that do not change during `'a`.
pub(super) unsafe fn array<'a, T>(name: &str, pointer: *const T, n: usize) -> Result<&'a [T], String> {
    if n == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(format!("{name} is NULL, but needs {n} values"));
    }
    if n > MOST {
        return Err(format!("{name} has {n} values, but at most {MOST} are allowed"));
    }
    // SAFETY: the pointer is not null; the caller guarantees the rest.
    Ok(unsafe { slice::from_raw_parts(pointer, n) })
}

/// Refuse NULL as the target of `n` values.
pub(super) fn check_target<T>(name: &str, pointer: *mut T, n: usize) -> Result<(), String> {
    if n > 0 && pointer.is_null() {
        return Err(format!("{name} is NULL, but needs room for {n} values"));
    }
    Ok(())
}

/// Return a string; refuse NULL.
///
/// # Safety
/// `pointer` is null or a null-terminated string that does not change during `'a`.
pub(super) unsafe fn string<'a>(name: &str, pointer: *const c_char) -> Result<&'a CStr, String> {
    if pointer.is_null() {
        return Err(format!("{name} is NULL"));
    }
    // SAFETY: the pointer is not null; the caller guarantees the rest.
    Ok(unsafe { CStr::from_ptr(pointer) })
}

/// Return a string as text; refuse NULL and text that is not UTF-8.
///
/// # Safety
/// The precondition of [`string`].
pub(super) unsafe fn text<'a>(name: &str, pointer: *const c_char) -> Result<&'a str, String> {
    // SAFETY: the caller keeps the same precondition.
    let string = unsafe { string(name, pointer) }?;
    string.to_str().map_err(|_| format!("{name} = {string:?} is not UTF-8"))
}

/// Return the handle of the FMU state at `state`; 0 for none.
///
/// # Safety
/// `state` is null or valid.
pub(super) unsafe fn handle(state: *mut *mut c_void) -> Result<usize, String> {
    check_target("FMUstate", state, 1)?;
    // SAFETY: the pointer is not null; the caller guarantees the rest.
    Ok(unsafe { *state }.addr())
}
