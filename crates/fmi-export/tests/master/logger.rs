//! Logger of FMI 2.0 that keeps its messages.

use std::cell::RefCell;
use std::ffi::CStr;
use std::mem::transmute;

use nervure_fmi_export::sys::*;

pub type Messages = RefCell<Vec<String>>;

type Fixed = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
type Variadic = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

unsafe extern "C" fn log(
    environment: fmi2ComponentEnvironment,
    _instance_name: fmi2String,
    _status: fmi2Status,
    _category: fmi2String,
    message: fmi2String,
) {
    // SAFETY: the environment is the one handed over in `callbacks`, the message a string by the standard.
    let (messages, message) = unsafe { (&*environment.cast::<Messages>(), CStr::from_ptr(message)) };
    messages.borrow_mut().push(message.to_string_lossy().into());
}

/// Return callbacks with a logger into `messages`, which outlive the instance.
pub fn callbacks(messages: &Messages) -> fmi2CallbackFunctions {
    fmi2CallbackFunctions {
        // SAFETY: stable Rust cannot define a variadic function. The glue passes no variadic arguments, and fixed
        // ones go where those of a function without variadic arguments go.
        logger: Some(unsafe { transmute::<Fixed, Variadic>(log) }),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: (&raw const *messages).cast_mut().cast(),
    }
}
