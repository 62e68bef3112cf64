//! The C functions, generic over the model, and the macro that gives them their names.
//!
//! Their common precondition is that of the standard: an instance pointer is null or comes from `fmi2Instantiate` or
//! `fmi3InstantiateCoSimulation` of the same model, is not yet freed and not used by two threads at once; arrays have
//! the length they are said to have; strings are null-terminated.
#![allow(non_snake_case, reason = "the functions are named as in the standard")]
#![allow(clippy::missing_safety_doc, reason = "the precondition is the module's")]
#![allow(missing_docs, reason = "the functions are described in the standard")]

/// The functions of the FMU state, which differ between the versions in names and types only.
macro_rules! state_functions {
    (
        $instance:ty, $state:ty, $byte:ty, $status:ty;
        $get:ident, $set:ident, $free:ident;
        $size:ident, $serialize:ident, $deserialize:ident;
    ) => {
        pub unsafe extern "C" fn $get<M: Model>(c: $instance, state: *mut $state) -> $status {
            // SAFETY: the module's precondition.
            unsafe {
                call::<M, _>(c, Function::$get, |instance| {
                    *state = ptr::without_provenance_mut(instance.save(handle(state)?)?);
                    Ok(())
                })
            }
        }

        pub unsafe extern "C" fn $set<M: Model>(c: $instance, state: $state) -> $status {
            // SAFETY: the module's precondition; the state is a number that is only looked up.
            unsafe { call::<M, _>(c, Function::$set, |instance| instance.restore(state.addr())) }
        }

        pub unsafe extern "C" fn $free<M: Model>(c: $instance, state: *mut $state) -> $status {
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

        pub unsafe extern "C" fn $size<M: Model>(c: $instance, state: $state, size: *mut usize) -> $status {
            // SAFETY: the module's precondition.
            unsafe {
                call::<M, _>(c, Function::$size, |instance| {
                    check_target("size", size, 1)?;
                    *size = instance.serialize(state.addr())?.len();
                    Ok(())
                })
            }
        }

        pub unsafe extern "C" fn $serialize<M: Model>(
            c: $instance,
            state: $state,
            bytes: *mut $byte,
            size: usize,
        ) -> $status {
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

        pub unsafe extern "C" fn $deserialize<M: Model>(
            c: $instance,
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

mod fmi2;
mod fmi3;

use std::ffi::{CStr, CString, c_char, c_void};
use std::path::Path;
use std::{ptr, slice};

use crate::guard;
use crate::instance::{self, Instance};
use crate::log::Log;
use crate::model::Model;
use crate::resource::Resources;
use crate::state_machine::Function;
use crate::sys::*;
use crate::variable::Value;
use crate::version::Version;

pub use fmi2::*;
pub use fmi3::*;

/// Exports [`Model`] as a library for co-simulation under FMI 2.0 and 3.0: all functions of both standards, those for
/// packagers, and one for fields.
///
/// To be called once in a crate of type `cdylib`, which is then the library of one FMU.
///
/// `int fmu_model_description(const char *resources, char *buffer, size_t capacity, size_t *needed)` makes
/// `modelDescription.xml` of FMI 2.0 for the resources in a folder (a plain path, or NULL), and
/// `fmu_model_description_3` with the same arguments that of FMI 3.0. They return 0 if the text is the model description
/// and 1 if it is an error message. `*needed` is its size with the final NUL; the text is written only if the capacity
/// suffices.
///
/// `int fmu_field(void *instance, const char *name, double *buffer, size_t capacity, size_t *shape)` copies a field of
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
            fmi3GetVersion: fmi3GetVersionTYPE = () -> fmi3String;
            fmi3SetDebugLogging: fmi3SetDebugLoggingTYPE =
                (c: fmi3Instance, on: fmi3Boolean, n: usize, categories: *const fmi3String) -> fmi3Status;
            fmi3InstantiateModelExchange: fmi3InstantiateModelExchangeTYPE =
                (name: fmi3String, token: fmi3String, resources: fmi3String, visible: fmi3Boolean,
                 logging: fmi3Boolean, environment: fmi3InstanceEnvironment, log_message: fmi3LogMessageCallback)
                -> fmi3Instance;
            fmi3InstantiateCoSimulation: fmi3InstantiateCoSimulationTYPE =
                (name: fmi3String, token: fmi3String, resources: fmi3String, visible: fmi3Boolean,
                 logging: fmi3Boolean, event_mode: fmi3Boolean, early_return: fmi3Boolean,
                 intermediate_variables: *const fmi3ValueReference, n_intermediate_variables: usize,
                 environment: fmi3InstanceEnvironment, log_message: fmi3LogMessageCallback,
                 intermediate_update: fmi3IntermediateUpdateCallback) -> fmi3Instance;
            fmi3InstantiateScheduledExecution: fmi3InstantiateScheduledExecutionTYPE =
                (name: fmi3String, token: fmi3String, resources: fmi3String, visible: fmi3Boolean,
                 logging: fmi3Boolean, environment: fmi3InstanceEnvironment, log_message: fmi3LogMessageCallback,
                 clock_update: fmi3ClockUpdateCallback, lock: fmi3LockPreemptionCallback,
                 unlock: fmi3UnlockPreemptionCallback) -> fmi3Instance;
            fmi3FreeInstance: fmi3FreeInstanceTYPE = (c: fmi3Instance) -> ();
            fmi3EnterInitializationMode: fmi3EnterInitializationModeTYPE =
                (c: fmi3Instance, tolerance_defined: fmi3Boolean, tolerance: fmi3Float64, start_time: fmi3Float64,
                 stop_time_defined: fmi3Boolean, stop_time: fmi3Float64) -> fmi3Status;
            fmi3ExitInitializationMode: fmi3ExitInitializationModeTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3EnterEventMode: fmi3EnterEventModeTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3Terminate: fmi3TerminateTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3Reset: fmi3ResetTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3GetFloat32: fmi3GetFloat32TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Float32, n_values: usize)
                -> fmi3Status;
            fmi3GetFloat64: fmi3GetFloat64TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Float64, n_values: usize)
                -> fmi3Status;
            fmi3GetInt8: fmi3GetInt8TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Int8, n_values: usize)
                -> fmi3Status;
            fmi3GetUInt8: fmi3GetUInt8TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3UInt8, n_values: usize)
                -> fmi3Status;
            fmi3GetInt16: fmi3GetInt16TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Int16, n_values: usize)
                -> fmi3Status;
            fmi3GetUInt16: fmi3GetUInt16TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3UInt16, n_values: usize)
                -> fmi3Status;
            fmi3GetInt32: fmi3GetInt32TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Int32, n_values: usize)
                -> fmi3Status;
            fmi3GetUInt32: fmi3GetUInt32TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3UInt32, n_values: usize)
                -> fmi3Status;
            fmi3GetInt64: fmi3GetInt64TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Int64, n_values: usize)
                -> fmi3Status;
            fmi3GetUInt64: fmi3GetUInt64TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3UInt64, n_values: usize)
                -> fmi3Status;
            fmi3GetBoolean: fmi3GetBooleanTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Boolean, n_values: usize)
                -> fmi3Status;
            fmi3GetString: fmi3GetStringTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3String, n_values: usize)
                -> fmi3Status;
            fmi3GetBinary: fmi3GetBinaryTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, value_sizes: *mut usize,
                 values: *mut fmi3Binary, n_values: usize) -> fmi3Status;
            fmi3GetClock: fmi3GetClockTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *mut fmi3Clock) -> fmi3Status;
            fmi3SetFloat32: fmi3SetFloat32TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Float32, n_values: usize)
                -> fmi3Status;
            fmi3SetFloat64: fmi3SetFloat64TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Float64, n_values: usize)
                -> fmi3Status;
            fmi3SetInt8: fmi3SetInt8TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Int8, n_values: usize)
                -> fmi3Status;
            fmi3SetUInt8: fmi3SetUInt8TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3UInt8, n_values: usize)
                -> fmi3Status;
            fmi3SetInt16: fmi3SetInt16TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Int16, n_values: usize)
                -> fmi3Status;
            fmi3SetUInt16: fmi3SetUInt16TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3UInt16, n_values: usize)
                -> fmi3Status;
            fmi3SetInt32: fmi3SetInt32TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Int32, n_values: usize)
                -> fmi3Status;
            fmi3SetUInt32: fmi3SetUInt32TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3UInt32, n_values: usize)
                -> fmi3Status;
            fmi3SetInt64: fmi3SetInt64TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Int64, n_values: usize)
                -> fmi3Status;
            fmi3SetUInt64: fmi3SetUInt64TYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3UInt64, n_values: usize)
                -> fmi3Status;
            fmi3SetBoolean: fmi3SetBooleanTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Boolean, n_values: usize)
                -> fmi3Status;
            fmi3SetString: fmi3SetStringTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3String, n_values: usize)
                -> fmi3Status;
            fmi3SetBinary: fmi3SetBinaryTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, value_sizes: *const usize,
                 values: *const fmi3Binary, n_values: usize) -> fmi3Status;
            fmi3SetClock: fmi3SetClockTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, values: *const fmi3Clock) -> fmi3Status;
            fmi3GetNumberOfVariableDependencies: fmi3GetNumberOfVariableDependenciesTYPE =
                (c: fmi3Instance, value_reference: fmi3ValueReference, n_dependencies: *mut usize) -> fmi3Status;
            fmi3GetVariableDependencies: fmi3GetVariableDependenciesTYPE =
                (c: fmi3Instance, dependent: fmi3ValueReference, element_indices_of_dependent: *mut usize,
                 independents: *mut fmi3ValueReference, element_indices_of_independents: *mut usize,
                 dependency_kinds: *mut fmi3DependencyKind, n_dependencies: usize) -> fmi3Status;
            fmi3GetFMUState: fmi3GetFMUStateTYPE = (c: fmi3Instance, f_m_u_state: *mut fmi3FMUState) -> fmi3Status;
            fmi3SetFMUState: fmi3SetFMUStateTYPE = (c: fmi3Instance, f_m_u_state: fmi3FMUState) -> fmi3Status;
            fmi3FreeFMUState: fmi3FreeFMUStateTYPE = (c: fmi3Instance, f_m_u_state: *mut fmi3FMUState) -> fmi3Status;
            fmi3SerializedFMUStateSize: fmi3SerializedFMUStateSizeTYPE =
                (c: fmi3Instance, f_m_u_state: fmi3FMUState, size: *mut usize) -> fmi3Status;
            fmi3SerializeFMUState: fmi3SerializeFMUStateTYPE =
                (c: fmi3Instance, f_m_u_state: fmi3FMUState, serialized_state: *mut fmi3Byte, size: usize)
                -> fmi3Status;
            fmi3DeserializeFMUState: fmi3DeserializeFMUStateTYPE =
                (c: fmi3Instance, serialized_state: *const fmi3Byte, size: usize, f_m_u_state: *mut fmi3FMUState)
                -> fmi3Status;
            fmi3GetDirectionalDerivative: fmi3GetDirectionalDerivativeTYPE =
                (c: fmi3Instance, unknowns: *const fmi3ValueReference, n_unknowns: usize,
                 knowns: *const fmi3ValueReference, n_knowns: usize, seed: *const fmi3Float64, n_seed: usize,
                 sensitivity: *mut fmi3Float64, n_sensitivity: usize) -> fmi3Status;
            fmi3GetAdjointDerivative: fmi3GetAdjointDerivativeTYPE =
                (c: fmi3Instance, unknowns: *const fmi3ValueReference, n_unknowns: usize,
                 knowns: *const fmi3ValueReference, n_knowns: usize, seed: *const fmi3Float64, n_seed: usize,
                 sensitivity: *mut fmi3Float64, n_sensitivity: usize) -> fmi3Status;
            fmi3EnterConfigurationMode: fmi3EnterConfigurationModeTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3ExitConfigurationMode: fmi3ExitConfigurationModeTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3GetIntervalDecimal: fmi3GetIntervalDecimalTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, intervals: *mut fmi3Float64,
                 qualifiers: *mut fmi3IntervalQualifier) -> fmi3Status;
            fmi3GetIntervalFraction: fmi3GetIntervalFractionTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, counters: *mut fmi3UInt64,
                 resolutions: *mut fmi3UInt64, qualifiers: *mut fmi3IntervalQualifier) -> fmi3Status;
            fmi3GetShiftDecimal: fmi3GetShiftDecimalTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, shifts: *mut fmi3Float64) -> fmi3Status;
            fmi3GetShiftFraction: fmi3GetShiftFractionTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, counters: *mut fmi3UInt64,
                 resolutions: *mut fmi3UInt64) -> fmi3Status;
            fmi3SetIntervalDecimal: fmi3SetIntervalDecimalTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, intervals: *const fmi3Float64) -> fmi3Status;
            fmi3SetIntervalFraction: fmi3SetIntervalFractionTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, counters: *const fmi3UInt64,
                 resolutions: *const fmi3UInt64) -> fmi3Status;
            fmi3SetShiftDecimal: fmi3SetShiftDecimalTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, shifts: *const fmi3Float64) -> fmi3Status;
            fmi3SetShiftFraction: fmi3SetShiftFractionTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, counters: *const fmi3UInt64,
                 resolutions: *const fmi3UInt64) -> fmi3Status;
            fmi3EvaluateDiscreteStates: fmi3EvaluateDiscreteStatesTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3UpdateDiscreteStates: fmi3UpdateDiscreteStatesTYPE =
                (c: fmi3Instance, discrete_states_need_update: *mut fmi3Boolean,
                 terminate_simulation: *mut fmi3Boolean, nominals_of_continuous_states_changed: *mut fmi3Boolean,
                 values_of_continuous_states_changed: *mut fmi3Boolean, next_event_time_defined: *mut fmi3Boolean,
                 next_event_time: *mut fmi3Float64) -> fmi3Status;
            fmi3EnterContinuousTimeMode: fmi3EnterContinuousTimeModeTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3CompletedIntegratorStep: fmi3CompletedIntegratorStepTYPE =
                (c: fmi3Instance, no_set_f_m_u_state_prior_to_current_point: fmi3Boolean,
                 enter_event_mode: *mut fmi3Boolean, terminate_simulation: *mut fmi3Boolean) -> fmi3Status;
            fmi3SetTime: fmi3SetTimeTYPE = (c: fmi3Instance, time: fmi3Float64) -> fmi3Status;
            fmi3SetContinuousStates: fmi3SetContinuousStatesTYPE =
                (c: fmi3Instance, continuous_states: *const fmi3Float64, n_continuous_states: usize) -> fmi3Status;
            fmi3GetContinuousStateDerivatives: fmi3GetContinuousStateDerivativesTYPE =
                (c: fmi3Instance, derivatives: *mut fmi3Float64, n_continuous_states: usize) -> fmi3Status;
            fmi3GetEventIndicators: fmi3GetEventIndicatorsTYPE =
                (c: fmi3Instance, event_indicators: *mut fmi3Float64, n_event_indicators: usize) -> fmi3Status;
            fmi3GetContinuousStates: fmi3GetContinuousStatesTYPE =
                (c: fmi3Instance, continuous_states: *mut fmi3Float64, n_continuous_states: usize) -> fmi3Status;
            fmi3GetNominalsOfContinuousStates: fmi3GetNominalsOfContinuousStatesTYPE =
                (c: fmi3Instance, nominals: *mut fmi3Float64, n_continuous_states: usize) -> fmi3Status;
            fmi3GetNumberOfEventIndicators: fmi3GetNumberOfEventIndicatorsTYPE =
                (c: fmi3Instance, n_event_indicators: *mut usize) -> fmi3Status;
            fmi3GetNumberOfContinuousStates: fmi3GetNumberOfContinuousStatesTYPE =
                (c: fmi3Instance, n_continuous_states: *mut usize) -> fmi3Status;
            fmi3EnterStepMode: fmi3EnterStepModeTYPE = (c: fmi3Instance) -> fmi3Status;
            fmi3GetOutputDerivatives: fmi3GetOutputDerivativesTYPE =
                (c: fmi3Instance, vr: *const fmi3ValueReference, n: usize, orders: *const fmi3Int32,
                 values: *mut fmi3Float64, n_values: usize) -> fmi3Status;
            fmi3DoStep: fmi3DoStepTYPE =
                (c: fmi3Instance, current_communication_point: fmi3Float64, communication_step_size: fmi3Float64,
                 no_set_f_m_u_state_prior_to_current_point: fmi3Boolean, event_handling_needed: *mut fmi3Boolean,
                 terminate_simulation: *mut fmi3Boolean, early_return: *mut fmi3Boolean,
                 last_successful_time: *mut fmi3Float64) -> fmi3Status;
            fmi3ActivateModelPartition: fmi3ActivateModelPartitionTYPE =
                (c: fmi3Instance, clock_reference: fmi3ValueReference, activation_time: fmi3Float64) -> fmi3Status;
            fmu_model_description: ModelDescriptionTYPE =
                (resources: fmi2String, buffer: *mut fmi2Char, capacity: usize, needed: *mut usize) -> fmi2Integer;
            fmu_model_description_3: ModelDescriptionTYPE =
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

/// How a call on an instance ended.
enum Outcome {
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

/// Calls `body` on the instance if the state machine allows the function. A refusal or panic is logged and becomes an
/// error.
///
/// # Safety
/// The module's precondition on `c`.
unsafe fn call_with_outcome<M: Model>(
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

/// [`call_with_outcome`] for a function that succeeds or fails, with the status of either version.
///
/// # Safety
/// The module's precondition on `c`.
unsafe fn call<M: Model, S: From<Outcome>>(
    c: *mut c_void,
    function: Function,
    body: impl FnOnce(&mut Instance<M>) -> Result<(), String>,
) -> S {
    // SAFETY: the caller keeps the precondition.
    unsafe { call_with_outcome(c, function, |instance| body(instance).map(|()| Outcome::Ok)) }.into()
}

/// Makes an instance, or tells the master's logger why there is none.
fn instantiate<M: Model>(
    function: &str,
    log: Log,
    loaded: impl FnOnce() -> Result<instance::Loaded<M>, String>,
) -> *mut c_void {
    match guard::catch(loaded).and_then(|result| result) {
        Ok(loaded) => Box::into_raw(Box::new(Instance::new(log, loaded))).cast(),
        Err(message) => {
            log.error(format_args!("{function}: {message}"));
            ptr::null_mut()
        }
    }
}

/// Frees an instance.
///
/// # Safety
/// The module's precondition on `c`.
unsafe fn free<M: Model>(c: *mut c_void) {
    if c.is_null() {
        return;
    }
    // SAFETY: by the module's precondition `c` is a live instance, which `instantiate` boxed.
    let instance = unsafe { Box::from_raw(c.cast::<Instance<M>>()) };
    // There is no instance left to log a panic of the model's destructor, and nothing left to do about it.
    let _ = guard::catch(|| drop(instance));
}

/// Turns log categories on or off.
///
/// # Safety
/// The module's precondition on strings and arrays.
unsafe fn set_logging<M: Model>(
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

/// Writes the values of variables, `n` together, as the C type `C`.
///
/// # Safety
/// `value` has room for `n` values.
unsafe fn get_values<M: Model, T: Value, C>(
    instance: &mut Instance<M>,
    references: &[u32],
    (value, n): (*mut C, usize),
    write: impl Fn(&T) -> C,
) -> Result<(), String> {
    check_target("value", value, n)?;
    instance.get::<T>(references, |position, values| {
        for (offset, source) in values.iter().enumerate() {
            // SAFETY: `instance.get` hands out each position below `n` once, and `value` has room for `n` values.
            unsafe { value.add(position + offset).write(write(source)) };
        }
    })
}

/// Writes the values of String variables, `n` together, which live until the next call.
///
/// # Safety
/// `value` has room for `n` pointers.
unsafe fn get_strings<M: Model>(
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
        // SAFETY: one string is written for each of the `n` values.
        unsafe { value.add(position).write(string.as_ptr()) };
    }
    Ok(())
}

/// Sets String variables from `n` texts.
///
/// # Safety
/// The module's precondition on strings and arrays.
unsafe fn set_strings<M: Model>(
    instance: &mut Instance<M>,
    references: &[u32],
    (value, n): (*const *const c_char, usize),
) -> Result<(), String> {
    // SAFETY: the caller keeps the precondition.
    let values = unsafe { array("value", value, n)?.iter().map(|value| text("a value", *value).map(str::to_string)) };
    instance.set(references, &values.collect::<Result<Vec<_>, _>>()?)
}

/// Writes `values` to where the master has room for as many.
///
/// # Safety
/// `target` has room for the values.
unsafe fn put(name: &str, values: &[f64], target: *mut f64) -> Result<(), String> {
    check_target(name, target, values.len())?;
    // SAFETY: the target is not null where there are values, and the caller vouches for the rest.
    unsafe { ptr::copy_nonoverlapping(values.as_ptr(), target, values.len()) };
    Ok(())
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

/// The FMU state at `state`, zero if there is none.
///
/// # Safety
/// `state` is null or valid.
unsafe fn handle(state: *mut *mut c_void) -> Result<usize, String> {
    check_target("FMUstate", state, 1)?;
    // SAFETY: the pointer is not null and the caller vouches for the rest.
    Ok(unsafe { *state }.addr())
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
    // SAFETY: the caller keeps the same precondition.
    unsafe { describe::<M>(Version::Fmi2, resources, (buffer, capacity), needed) }
}

/// See [`export_fmu!`](crate::export_fmu).
///
/// # Safety
/// That of [`fmu_model_description`].
pub unsafe extern "C" fn fmu_model_description_3<M: Model>(
    resources: fmi2String,
    buffer: *mut fmi2Char,
    capacity: usize,
    needed: *mut usize,
) -> fmi2Integer {
    // SAFETY: the caller keeps the same precondition.
    unsafe { describe::<M>(Version::Fmi3, resources, (buffer, capacity), needed) }
}

/// # Safety
/// That of [`fmu_model_description`].
unsafe fn describe<M: Model>(
    version: Version,
    resources: fmi2String,
    (buffer, capacity): (*mut fmi2Char, usize),
    needed: *mut usize,
) -> fmi2Integer {
    let described = guard::catch(|| {
        // SAFETY: the function's precondition on strings.
        let resources = (!resources.is_null()).then(|| unsafe { text("resources", resources) }).transpose()?;
        let resources = Resources::read(resources.map(Path::new), M::RESOURCES)?;
        let (_, _, document) = instance::load::<M>(&resources, version)?;
        Ok(document.xml)
    });
    // SAFETY: the function's precondition.
    unsafe { crate::text::write(described.and_then(|result| result), (buffer.cast(), capacity), needed) }
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
    let status: fmi2Status = unsafe { call::<M, _>(c, Function::fmi2GetReal, look) };
    fmi2Integer::from(!(found && status == fmi2Status::fmi2OK))
}
