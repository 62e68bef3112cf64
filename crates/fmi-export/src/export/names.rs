//! Names and signatures of the exported functions.

/// Export a [`Model`] as a library for co-simulation: the functions of FMI 2.0 and 3.0, functions for packagers, and
/// fields.
///
/// Call the macro once in a crate of type `cdylib`, the library of one FMU.
///
/// `int fmu_model_description(const char *resources, char *buffer, size_t capacity, size_t *needed)` writes
/// `modelDescription.xml` of FMI 2.0 for the resources in a folder (a plain path, or NULL). `fmu_model_description_3`
/// has the same arguments and writes the file of FMI 3.0. They return 0 for a model description and 1 for an error
/// message. `*needed` is the size of the text with its final NUL. The text is written only if the capacity suffices.
///
/// `int fmu_field(void *instance, const char *name, double *buffer, size_t capacity, size_t *shape)` copies a field of
/// [`Model::field`](crate::Model::field). It returns 0, or 1 without a field of this name or without a readable
/// instance. `shape` receives the lengths, up to three. The values are written only if the capacity suffices.
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

/// Export each function under its C name, and check its signature against the type in the header.
#[doc(hidden)]
#[macro_export]
macro_rules! __export_functions {
    ($model:ty => $($name:ident: $header_type:ident = ($($argument:ident: $type:ty),*) -> $result:ty;)*) => {
        const _: () = {
            use $crate::export::{FieldTYPE, ModelDescriptionTYPE};
            use $crate::sys::*;
            $(
                // SAFETY: the names belong to the standard; a library exports one model.
                #[unsafe(no_mangle)]
                unsafe extern "C" fn $name($($argument: $type),*) -> $result {
                    // SAFETY: the caller keeps the precondition of the standard, the precondition of `export`.
                    unsafe { $crate::export::$name::<$model>($($argument),*) }
                }
                const _: $header_type = Some($name);
            )*
        };
    };
}
