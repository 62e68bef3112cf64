//! Functions of FMI 3.0. Functions of absent capabilities return an error with the reason.

use std::ffi::c_void;
use std::ptr;

use super::call::*;
use crate::instance::Instance;
use crate::log::Log;
use crate::model::Model;
use crate::state_machine::Function;
use crate::sys::*;
use crate::version::Version;

pub unsafe fn fmi3GetVersion<M: Model>() -> fmi3String {
    c"3.0".as_ptr()
}

pub unsafe fn fmi3SetDebugLogging<M: Model>(
    c: fmi3Instance,
    on: fmi3Boolean,
    n: usize,
    categories: *const fmi3String,
) -> fmi3Status {
    // SAFETY: the module's precondition.
    unsafe { call::<M, _>(c, Function::fmi3SetDebugLogging, |instance| set_logging(instance, on != 0, n, categories)) }
}

pub unsafe fn fmi3InstantiateCoSimulation<M: Model>(
    name: fmi3String,
    token: fmi3String,
    resources: fmi3String,
    _visible: fmi3Boolean,
    logging: fmi3Boolean,
    event_mode: fmi3Boolean,
    _early_return: fmi3Boolean,
    _intermediate_variables: *const fmi3ValueReference,
    _n_intermediate_variables: usize,
    environment: fmi3InstanceEnvironment,
    log_message: fmi3LogMessageCallback,
    _intermediate_update: fmi3IntermediateUpdateCallback,
) -> fmi3Instance {
    // SAFETY: by the standard, logger and environment outlive the instance.
    let log = unsafe { Log::fmi3(log_message, environment, logging != 0) };
    instantiate::<M>("fmi3InstantiateCoSimulation", log, || {
        if event_mode != 0 {
            return Err(format!("eventModeUsed must be false: {NO_EVENTS}"));
        }
        // SAFETY: the module's precondition on strings.
        unsafe { load(Version::Fmi3, name, ["instantiationToken", "resourcePath"], [token, resources]) }
    })
}

pub unsafe fn fmi3InstantiateModelExchange<M: Model>(
    _name: fmi3String,
    _token: fmi3String,
    _resources: fmi3String,
    _visible: fmi3Boolean,
    logging: fmi3Boolean,
    environment: fmi3InstanceEnvironment,
    log_message: fmi3LogMessageCallback,
) -> fmi3Instance {
    // SAFETY: by the standard, the logger accepts the environment.
    let log = unsafe { Log::fmi3(log_message, environment, logging != 0) };
    instantiate::<M>("fmi3InstantiateModelExchange", log, || Err(ONLY_CO_SIMULATION.into()))
}

pub unsafe fn fmi3InstantiateScheduledExecution<M: Model>(
    _name: fmi3String,
    _token: fmi3String,
    _resources: fmi3String,
    _visible: fmi3Boolean,
    logging: fmi3Boolean,
    environment: fmi3InstanceEnvironment,
    log_message: fmi3LogMessageCallback,
    _clock_update: fmi3ClockUpdateCallback,
    _lock: fmi3LockPreemptionCallback,
    _unlock: fmi3UnlockPreemptionCallback,
) -> fmi3Instance {
    // SAFETY: by the standard, the logger accepts the environment.
    let log = unsafe { Log::fmi3(log_message, environment, logging != 0) };
    instantiate::<M>("fmi3InstantiateScheduledExecution", log, || Err(ONLY_CO_SIMULATION.into()))
}

pub unsafe fn fmi3FreeInstance<M: Model>(c: fmi3Instance) {
    // SAFETY: the module's precondition.
    unsafe { free::<M>(c) }
}

pub unsafe fn fmi3EnterInitializationMode<M: Model>(
    c: fmi3Instance,
    _has_tolerance: fmi3Boolean,
    _tolerance: fmi3Float64,
    start: fmi3Float64,
    has_stop: fmi3Boolean,
    stop: fmi3Float64,
) -> fmi3Status {
    let stop = (has_stop != 0).then_some(stop);
    // SAFETY: the module's precondition.
    unsafe {
        call::<M, _>(c, Function::fmi3EnterInitializationMode, |instance| {
            instance.setup_experiment(start, stop)?;
            instance.enter_initialization();
            Ok(())
        })
    }
}

without_arguments! {
    fmi3Status;
    fmi3ExitInitializationMode = |instance| instance.exit_initialization();
    fmi3Terminate = |instance| { instance.terminate(); Ok(()) };
    fmi3Reset = |instance| instance.reset();
}

/// Return the value references; refuse variables of another type and a total of values other than `n_values`.
///
/// # Safety
/// The module's precondition on arrays.
unsafe fn references<'a, M: Model>(
    instance: &Instance<M>,
    (vr, n): (*const fmi3ValueReference, usize),
    type_name: &str,
    n_values: usize,
) -> Result<&'a [u32], String> {
    // SAFETY: the caller keeps the precondition.
    let references = unsafe { array("valueReferences", vr, n) }?;
    instance.check_references(references, type_name, n_values)?;
    Ok(references)
}

macro_rules! getters {
    ($($name:ident($value:ty, $type_name:literal) = $write:expr;)*) => {
        $(
            pub unsafe fn $name<M: Model>(
                c: fmi3Instance,
                vr: *const fmi3ValueReference,
                n: usize,
                values: *mut $value,
                n_values: usize,
            ) -> fmi3Status {
                // SAFETY: the module's precondition.
                unsafe {
                    call::<M, _>(c, Function::$name, |instance| {
                        let references = references(instance, (vr, n), $type_name, n_values)?;
                        get_values(instance, references, (values, n_values), $write)
                    })
                }
            }
        )*
    };
}

/// Return the items of enumerations, which the standard reads and writes as Int64.
fn items(values: &[i64]) -> Result<Vec<i32>, String> {
    let item = |value: &i64| i32::try_from(*value).map_err(|_| format!("no enumeration has the item {value}"));
    values.iter().map(item).collect()
}

getters! {
    fmi3GetFloat64(fmi3Float64, "Float64") = |value: &f64| *value;
    fmi3GetInt32(fmi3Int32, "Int32") = |value: &i32| *value;
    fmi3GetInt64(fmi3Int64, "Enumeration") = |value: &i32| fmi3Int64::from(*value);
    fmi3GetBoolean(fmi3Boolean, "Boolean") = |value: &bool| fmi3Boolean::from(*value);
}

pub unsafe fn fmi3GetString<M: Model>(
    c: fmi3Instance,
    vr: *const fmi3ValueReference,
    n: usize,
    values: *mut fmi3String,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M, _>(c, Function::fmi3GetString, |instance| {
            let references = references(instance, (vr, n), "String", n_values)?;
            get_strings(instance, references, (values, n_values))
        })
    }
}

macro_rules! setters {
    ($($name:ident($value:ty, $type_name:literal) = |$values:ident| $read:expr;)*) => {
        $(
            pub unsafe fn $name<M: Model>(
                c: fmi3Instance,
                vr: *const fmi3ValueReference,
                n: usize,
                values: *const $value,
                n_values: usize,
            ) -> fmi3Status {
                // SAFETY: the module's precondition.
                unsafe {
                    call::<M, _>(c, Function::$name, |instance| {
                        let references = references(instance, (vr, n), $type_name, n_values)?;
                        let $values = array("values", values, n_values)?;
                        instance.set(references, $read)
                    })
                }
            }
        )*
    };
}

setters! {
    fmi3SetFloat64(fmi3Float64, "Float64") = |values| values;
    fmi3SetInt32(fmi3Int32, "Int32") = |values| values;
    fmi3SetInt64(fmi3Int64, "Enumeration") = |values| &items(values)?;
    fmi3SetBoolean(fmi3Boolean, "Boolean") = |values| &values.iter().map(|value| *value != 0).collect::<Vec<_>>();
}

pub unsafe fn fmi3SetString<M: Model>(
    c: fmi3Instance,
    vr: *const fmi3ValueReference,
    n: usize,
    values: *const fmi3String,
    n_values: usize,
) -> fmi3Status {
    // SAFETY: the module's precondition.
    unsafe {
        call::<M, _>(c, Function::fmi3SetString, |instance| {
            let references = references(instance, (vr, n), "String", n_values)?;
            set_strings(instance, references, (values, n_values))
        })
    }
}

/// Define the functions of types that no variable has: they refuse each reference by name.
macro_rules! without_variables {
    ($($name:ident($type_name:literal, $($argument:ty),+);)*) => {
        $(
            pub unsafe fn $name<M: Model>(
                c: fmi3Instance,
                vr: *const fmi3ValueReference,
                n: usize,
                $(_: $argument,)+
                n_values: usize,
            ) -> fmi3Status {
                // SAFETY: the module's precondition.
                unsafe {
                    call::<M, _>(c, Function::$name, |instance| {
                        references(instance, (vr, n), $type_name, n_values).map(|_| ())
                    })
                }
            }
        )*
    };
}

without_variables! {
    fmi3GetFloat32("Float32", *mut fmi3Float32);
    fmi3SetFloat32("Float32", *const fmi3Float32);
    fmi3GetInt8("Int8", *mut fmi3Int8);
    fmi3SetInt8("Int8", *const fmi3Int8);
    fmi3GetUInt8("UInt8", *mut fmi3UInt8);
    fmi3SetUInt8("UInt8", *const fmi3UInt8);
    fmi3GetInt16("Int16", *mut fmi3Int16);
    fmi3SetInt16("Int16", *const fmi3Int16);
    fmi3GetUInt16("UInt16", *mut fmi3UInt16);
    fmi3SetUInt16("UInt16", *const fmi3UInt16);
    fmi3GetUInt32("UInt32", *mut fmi3UInt32);
    fmi3SetUInt32("UInt32", *const fmi3UInt32);
    fmi3GetUInt64("UInt64", *mut fmi3UInt64);
    fmi3SetUInt64("UInt64", *const fmi3UInt64);
    fmi3GetBinary("Binary", *mut usize, *mut fmi3Binary);
    fmi3SetBinary("Binary", *const usize, *const fmi3Binary);
}

macro_rules! without_clocks {
    ($($name:ident($values:ty);)*) => {
        $(
            pub unsafe fn $name<M: Model>(
                c: fmi3Instance,
                vr: *const fmi3ValueReference,
                n: usize,
                _values: $values,
            ) -> fmi3Status {
                // SAFETY: the module's precondition.
                unsafe { call::<M, _>(c, Function::$name, |instance| references(instance, (vr, n), "Clock", 0).map(|_| ())) }
            }
        )*
    };
}

without_clocks! {
    fmi3GetClock(*mut fmi3Clock);
    fmi3SetClock(*const fmi3Clock);
}

state_functions! {
    fmi3FMUState, fmi3Byte, fmi3Status;
    fmi3GetFMUState, fmi3SetFMUState, fmi3FreeFMUState;
    fmi3SerializedFMUStateSize, fmi3SerializeFMUState, fmi3DeserializeFMUState;
}

not_provided! {
    fmi3Status;
    fmi3GetDirectionalDerivative(
        *const fmi3ValueReference, usize, *const fmi3ValueReference, usize, *const fmi3Float64, usize,
        *mut fmi3Float64, usize
    ) = "directional derivatives are not provided";
    fmi3GetAdjointDerivative(
        *const fmi3ValueReference, usize, *const fmi3ValueReference, usize, *const fmi3Float64, usize,
        *mut fmi3Float64, usize
    ) = "adjoint derivatives are not provided";
    fmi3GetOutputDerivatives(*const fmi3ValueReference, usize, *const fmi3Int32, *mut fmi3Float64, usize)
        = "output derivatives are not provided";
}

pub unsafe fn fmi3DoStep<M: Model>(
    c: fmi3Instance,
    time: fmi3Float64,
    step: fmi3Float64,
    _no_rollback: fmi3Boolean,
    event_handling_needed: *mut fmi3Boolean,
    terminate_simulation: *mut fmi3Boolean,
    early_return: *mut fmi3Boolean,
    last_successful_time: *mut fmi3Float64,
) -> fmi3Status {
    // SAFETY: the module's precondition; null targets are refused.
    unsafe {
        call::<M, _>(c, Function::fmi3DoStep, |instance| {
            let flags = [
                ("eventHandlingNeeded", event_handling_needed),
                ("terminateSimulation", terminate_simulation),
                ("earlyReturn", early_return),
            ];
            flags.iter().try_for_each(|(name, flag)| check_target(name, *flag, 1))?;
            check_target("lastSuccessfulTime", last_successful_time, 1)?;
            // The step may panic, so the targets are set before it.
            flags.iter().for_each(|(_, flag)| flag.write(0));
            last_successful_time.write(instance.time());
            instance.step(time, step)?;
            last_successful_time.write(instance.time());
            Ok(())
        })
    }
}

const NO_EVENTS: &str = "the unit has no event mode";
const NO_CLOCKS: &str = "the unit has no clocks";
const NO_CONFIGURATION: &str = "the unit has no structural parameters";
const NO_DEPENDENCIES: &str = "dependencies are listed for whole variables, in modelDescription.xml";
const ONLY_CO_SIMULATION: &str = "the unit supports co-simulation only";

/// Define the functions of absent capabilities: they return an error in each state.
macro_rules! refused {
    ($($reason:ident => { $($name:ident($($argument:ty),*);)* })*) => {
        $($(
            pub unsafe fn $name<M: Model>(c: fmi3Instance, $(_: $argument),*) -> fmi3Status {
                // SAFETY: the module's precondition.
                if let Some(instance) = unsafe { c.cast::<Instance<M>>().as_ref() } {
                    instance.log.error(format_args!("{}: {}", stringify!($name), $reason));
                }
                fmi3Status::fmi3Error
            }
        )*)*
    };
}

refused! {
    NO_DEPENDENCIES => {
        fmi3GetNumberOfVariableDependencies(fmi3ValueReference, *mut usize);
        fmi3GetVariableDependencies(
            fmi3ValueReference, *mut usize, *mut fmi3ValueReference, *mut usize, *mut fmi3DependencyKind, usize
        );
    }
    NO_CONFIGURATION => {
        fmi3EnterConfigurationMode();
        fmi3ExitConfigurationMode();
    }
    NO_EVENTS => {
        fmi3EnterEventMode();
        fmi3EnterStepMode();
        fmi3EvaluateDiscreteStates();
        fmi3UpdateDiscreteStates(
            *mut fmi3Boolean, *mut fmi3Boolean, *mut fmi3Boolean, *mut fmi3Boolean, *mut fmi3Boolean, *mut fmi3Float64
        );
    }
    NO_CLOCKS => {
        fmi3GetIntervalDecimal(*const fmi3ValueReference, usize, *mut fmi3Float64, *mut fmi3IntervalQualifier);
        fmi3GetIntervalFraction(
            *const fmi3ValueReference, usize, *mut fmi3UInt64, *mut fmi3UInt64, *mut fmi3IntervalQualifier
        );
        fmi3GetShiftDecimal(*const fmi3ValueReference, usize, *mut fmi3Float64);
        fmi3GetShiftFraction(*const fmi3ValueReference, usize, *mut fmi3UInt64, *mut fmi3UInt64);
        fmi3SetIntervalDecimal(*const fmi3ValueReference, usize, *const fmi3Float64);
        fmi3SetIntervalFraction(*const fmi3ValueReference, usize, *const fmi3UInt64, *const fmi3UInt64);
        fmi3SetShiftDecimal(*const fmi3ValueReference, usize, *const fmi3Float64);
        fmi3SetShiftFraction(*const fmi3ValueReference, usize, *const fmi3UInt64, *const fmi3UInt64);
    }
    ONLY_CO_SIMULATION => {
        fmi3EnterContinuousTimeMode();
        fmi3CompletedIntegratorStep(fmi3Boolean, *mut fmi3Boolean, *mut fmi3Boolean);
        fmi3SetTime(fmi3Float64);
        fmi3SetContinuousStates(*const fmi3Float64, usize);
        fmi3GetContinuousStateDerivatives(*mut fmi3Float64, usize);
        fmi3GetEventIndicators(*mut fmi3Float64, usize);
        fmi3GetContinuousStates(*mut fmi3Float64, usize);
        fmi3GetNominalsOfContinuousStates(*mut fmi3Float64, usize);
        fmi3GetNumberOfEventIndicators(*mut usize);
        fmi3GetNumberOfContinuousStates(*mut usize);
        fmi3ActivateModelPartition(fmi3ValueReference, fmi3Float64);
    }
}
