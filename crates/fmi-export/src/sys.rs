//! The C types and functions of FMI 2.0 and 3.0, generated from the official headers by `crates/fmi-export/bindgen`: do
//! not edit.
#![allow(missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals)]

pub type fmi3Boolean = u8;
pub type fmi3Clock = u8;
pub type fmi2Component = *mut ::std::os::raw::c_void;
pub type fmi2ComponentEnvironment = *mut ::std::os::raw::c_void;
pub type fmi2FMUstate = *mut ::std::os::raw::c_void;
pub type fmi2ValueReference = ::std::os::raw::c_uint;
pub type fmi2Real = f64;
pub type fmi2Integer = ::std::os::raw::c_int;
pub type fmi2Boolean = ::std::os::raw::c_int;
pub type fmi2Char = ::std::os::raw::c_char;
pub type fmi2String = *const fmi2Char;
pub type fmi2Byte = ::std::os::raw::c_char;
impl fmi2Status {
    pub const fmi2OK: fmi2Status = fmi2Status(0);
    pub const fmi2Warning: fmi2Status = fmi2Status(1);
    pub const fmi2Discard: fmi2Status = fmi2Status(2);
    pub const fmi2Error: fmi2Status = fmi2Status(3);
    pub const fmi2Fatal: fmi2Status = fmi2Status(4);
    pub const fmi2Pending: fmi2Status = fmi2Status(5);
}
#[repr(transparent)]
#[derive(Debug, Copy, Clone, Hash, PartialEq, Eq)]
pub struct fmi2Status(pub ::std::os::raw::c_uint);
impl fmi2Type {
    pub const fmi2ModelExchange: fmi2Type = fmi2Type(0);
    pub const fmi2CoSimulation: fmi2Type = fmi2Type(1);
}
#[repr(transparent)]
#[derive(Debug, Copy, Clone, Hash, PartialEq, Eq)]
pub struct fmi2Type(pub ::std::os::raw::c_uint);
impl fmi2StatusKind {
    pub const fmi2DoStepStatus: fmi2StatusKind = fmi2StatusKind(0);
    pub const fmi2PendingStatus: fmi2StatusKind = fmi2StatusKind(1);
    pub const fmi2LastSuccessfulTime: fmi2StatusKind = fmi2StatusKind(2);
    pub const fmi2Terminated: fmi2StatusKind = fmi2StatusKind(3);
}
#[repr(transparent)]
#[derive(Debug, Copy, Clone, Hash, PartialEq, Eq)]
pub struct fmi2StatusKind(pub ::std::os::raw::c_uint);
pub type fmi2CallbackLogger = ::std::option::Option<
    unsafe extern "C" fn(
        componentEnvironment: fmi2ComponentEnvironment,
        instanceName: fmi2String,
        status: fmi2Status,
        category: fmi2String,
        message: fmi2String,
        ...
    ),
>;
pub type fmi2CallbackAllocateMemory = ::std::option::Option<
    unsafe extern "C" fn(nobj: usize, size: usize) -> *mut ::std::os::raw::c_void,
>;
pub type fmi2CallbackFreeMemory = ::std::option::Option<
    unsafe extern "C" fn(obj: *mut ::std::os::raw::c_void),
>;
pub type fmi2StepFinished = ::std::option::Option<
    unsafe extern "C" fn(
        componentEnvironment: fmi2ComponentEnvironment,
        status: fmi2Status,
    ),
>;
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct fmi2CallbackFunctions {
    pub logger: fmi2CallbackLogger,
    pub allocateMemory: fmi2CallbackAllocateMemory,
    pub freeMemory: fmi2CallbackFreeMemory,
    pub stepFinished: fmi2StepFinished,
    pub componentEnvironment: fmi2ComponentEnvironment,
}
#[repr(C)]
#[derive(Debug, Copy, Clone)]
pub struct fmi2EventInfo {
    pub newDiscreteStatesNeeded: fmi2Boolean,
    pub terminateSimulation: fmi2Boolean,
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    pub nextEventTimeDefined: fmi2Boolean,
    pub nextEventTime: fmi2Real,
}
pub type fmi3Instance = *mut ::std::os::raw::c_void;
pub type fmi3InstanceEnvironment = *mut ::std::os::raw::c_void;
pub type fmi3FMUState = *mut ::std::os::raw::c_void;
pub type fmi3ValueReference = u32;
pub type fmi3Float32 = f32;
pub type fmi3Float64 = f64;
pub type fmi3Int8 = i8;
pub type fmi3UInt8 = u8;
pub type fmi3Int16 = i16;
pub type fmi3UInt16 = u16;
pub type fmi3Int32 = i32;
pub type fmi3UInt32 = u32;
pub type fmi3Int64 = i64;
pub type fmi3UInt64 = u64;
pub type fmi3Char = ::std::os::raw::c_char;
pub type fmi3String = *const fmi3Char;
pub type fmi3Byte = u8;
pub type fmi3Binary = *const fmi3Byte;
impl fmi3Status {
    pub const fmi3OK: fmi3Status = fmi3Status(0);
    pub const fmi3Warning: fmi3Status = fmi3Status(1);
    pub const fmi3Discard: fmi3Status = fmi3Status(2);
    pub const fmi3Error: fmi3Status = fmi3Status(3);
    pub const fmi3Fatal: fmi3Status = fmi3Status(4);
}
#[repr(transparent)]
#[derive(Debug, Copy, Clone, Hash, PartialEq, Eq)]
pub struct fmi3Status(pub ::std::os::raw::c_uint);
impl fmi3DependencyKind {
    pub const fmi3Independent: fmi3DependencyKind = fmi3DependencyKind(0);
    pub const fmi3Constant: fmi3DependencyKind = fmi3DependencyKind(1);
    pub const fmi3Fixed: fmi3DependencyKind = fmi3DependencyKind(2);
    pub const fmi3Tunable: fmi3DependencyKind = fmi3DependencyKind(3);
    pub const fmi3Discrete: fmi3DependencyKind = fmi3DependencyKind(4);
    pub const fmi3Dependent: fmi3DependencyKind = fmi3DependencyKind(5);
}
#[repr(transparent)]
#[derive(Debug, Copy, Clone, Hash, PartialEq, Eq)]
pub struct fmi3DependencyKind(pub ::std::os::raw::c_uint);
impl fmi3IntervalQualifier {
    pub const fmi3IntervalNotYetKnown: fmi3IntervalQualifier = fmi3IntervalQualifier(0);
    pub const fmi3IntervalUnchanged: fmi3IntervalQualifier = fmi3IntervalQualifier(1);
    pub const fmi3IntervalChanged: fmi3IntervalQualifier = fmi3IntervalQualifier(2);
}
#[repr(transparent)]
#[derive(Debug, Copy, Clone, Hash, PartialEq, Eq)]
pub struct fmi3IntervalQualifier(pub ::std::os::raw::c_uint);
pub type fmi3LogMessageCallback = ::std::option::Option<
    unsafe extern "C" fn(
        instanceEnvironment: fmi3InstanceEnvironment,
        status: fmi3Status,
        category: fmi3String,
        message: fmi3String,
    ),
>;
pub type fmi3ClockUpdateCallback = ::std::option::Option<
    unsafe extern "C" fn(instanceEnvironment: fmi3InstanceEnvironment),
>;
pub type fmi3IntermediateUpdateCallback = ::std::option::Option<
    unsafe extern "C" fn(
        instanceEnvironment: fmi3InstanceEnvironment,
        intermediateUpdateTime: fmi3Float64,
        intermediateVariableSetRequested: fmi3Boolean,
        intermediateVariableGetAllowed: fmi3Boolean,
        intermediateStepFinished: fmi3Boolean,
        canReturnEarly: fmi3Boolean,
        earlyReturnRequested: *mut fmi3Boolean,
        earlyReturnTime: *mut fmi3Float64,
    ),
>;
pub type fmi3LockPreemptionCallback = ::std::option::Option<unsafe extern "C" fn()>;
pub type fmi3UnlockPreemptionCallback = ::std::option::Option<unsafe extern "C" fn()>;

/// Pass the functions of FMI 2.0 and 3.0 for co-simulation to the macro `with`, after what is `given`.
#[doc(hidden)]
#[macro_export]
macro_rules! __standard_functions {
    ($with:path, $($given:tt)*) => {
        $with! { $($given)*
            fmi2GetTypesPlatform() -> *const ::std::os::raw::c_char;
            fmi2GetVersion() -> *const ::std::os::raw::c_char;
            fmi2SetDebugLogging(c: fmi2Component, loggingOn: fmi2Boolean, nCategories: usize,
                categories: *const fmi2String) -> fmi2Status;
            fmi2Instantiate(instanceName: fmi2String, fmuType: fmi2Type, fmuGUID: fmi2String,
                fmuResourceLocation: fmi2String, functions: *const fmi2CallbackFunctions, visible: fmi2Boolean,
                loggingOn: fmi2Boolean) -> fmi2Component;
            fmi2FreeInstance(c: fmi2Component) -> ();
            fmi2SetupExperiment(c: fmi2Component, toleranceDefined: fmi2Boolean, tolerance: fmi2Real,
                startTime: fmi2Real, stopTimeDefined: fmi2Boolean, stopTime: fmi2Real) -> fmi2Status;
            fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status;
            fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status;
            fmi2Terminate(c: fmi2Component) -> fmi2Status;
            fmi2Reset(c: fmi2Component) -> fmi2Status;
            fmi2GetReal(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Real)
                -> fmi2Status;
            fmi2GetInteger(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Integer)
                -> fmi2Status;
            fmi2GetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2Boolean)
                -> fmi2Status;
            fmi2GetString(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *mut fmi2String)
                -> fmi2Status;
            fmi2SetReal(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Real)
                -> fmi2Status;
            fmi2SetInteger(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Integer)
                -> fmi2Status;
            fmi2SetBoolean(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2Boolean)
                -> fmi2Status;
            fmi2SetString(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize, value: *const fmi2String)
                -> fmi2Status;
            fmi2GetFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status;
            fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status;
            fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status;
            fmi2SerializedFMUstateSize(c: fmi2Component, FMUstate: fmi2FMUstate, size: *mut usize) -> fmi2Status;
            fmi2SerializeFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate, arg1: *mut fmi2Byte, size: usize)
                -> fmi2Status;
            fmi2DeSerializeFMUstate(c: fmi2Component, serializedState: *const fmi2Byte, size: usize,
                FMUstate: *mut fmi2FMUstate) -> fmi2Status;
            fmi2GetDirectionalDerivative(c: fmi2Component, vUnknown_ref: *const fmi2ValueReference, nUnknown: usize,
                vKnown_ref: *const fmi2ValueReference, nKnown: usize, dvKnown: *const fmi2Real,
                dvUnknown: *mut fmi2Real) -> fmi2Status;
            fmi2SetRealInputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                order: *const fmi2Integer, value: *const fmi2Real) -> fmi2Status;
            fmi2GetRealOutputDerivatives(c: fmi2Component, vr: *const fmi2ValueReference, nvr: usize,
                order: *const fmi2Integer, value: *mut fmi2Real) -> fmi2Status;
            fmi2DoStep(c: fmi2Component, currentCommunicationPoint: fmi2Real, communicationStepSize: fmi2Real,
                noSetFMUStatePriorToCurrentPoint: fmi2Boolean) -> fmi2Status;
            fmi2CancelStep(c: fmi2Component) -> fmi2Status;
            fmi2GetStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status;
            fmi2GetRealStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status;
            fmi2GetIntegerStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Integer) -> fmi2Status;
            fmi2GetBooleanStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Boolean) -> fmi2Status;
            fmi2GetStringStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2String) -> fmi2Status;
            fmi3GetVersion() -> *const ::std::os::raw::c_char;
            fmi3SetDebugLogging(instance: fmi3Instance, loggingOn: fmi3Boolean, nCategories: usize,
                categories: *const fmi3String) -> fmi3Status;
            fmi3InstantiateModelExchange(instanceName: fmi3String, instantiationToken: fmi3String,
                resourcePath: fmi3String, visible: fmi3Boolean, loggingOn: fmi3Boolean,
                instanceEnvironment: fmi3InstanceEnvironment, logMessage: fmi3LogMessageCallback) -> fmi3Instance;
            fmi3InstantiateCoSimulation(instanceName: fmi3String, instantiationToken: fmi3String,
                resourcePath: fmi3String, visible: fmi3Boolean, loggingOn: fmi3Boolean, eventModeUsed: fmi3Boolean,
                earlyReturnAllowed: fmi3Boolean, requiredIntermediateVariables: *const fmi3ValueReference,
                nRequiredIntermediateVariables: usize, instanceEnvironment: fmi3InstanceEnvironment,
                logMessage: fmi3LogMessageCallback, intermediateUpdate: fmi3IntermediateUpdateCallback) -> fmi3Instance;
            fmi3InstantiateScheduledExecution(instanceName: fmi3String, instantiationToken: fmi3String,
                resourcePath: fmi3String, visible: fmi3Boolean, loggingOn: fmi3Boolean,
                instanceEnvironment: fmi3InstanceEnvironment, logMessage: fmi3LogMessageCallback,
                clockUpdate: fmi3ClockUpdateCallback, lockPreemption: fmi3LockPreemptionCallback,
                unlockPreemption: fmi3UnlockPreemptionCallback) -> fmi3Instance;
            fmi3FreeInstance(instance: fmi3Instance) -> ();
            fmi3EnterInitializationMode(instance: fmi3Instance, toleranceDefined: fmi3Boolean, tolerance: fmi3Float64,
                startTime: fmi3Float64, stopTimeDefined: fmi3Boolean, stopTime: fmi3Float64) -> fmi3Status;
            fmi3ExitInitializationMode(instance: fmi3Instance) -> fmi3Status;
            fmi3EnterEventMode(instance: fmi3Instance) -> fmi3Status;
            fmi3Terminate(instance: fmi3Instance) -> fmi3Status;
            fmi3Reset(instance: fmi3Instance) -> fmi3Status;
            fmi3GetFloat32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Float32, nValues: usize) -> fmi3Status;
            fmi3GetFloat64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Float64, nValues: usize) -> fmi3Status;
            fmi3GetInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Int8, nValues: usize) -> fmi3Status;
            fmi3GetUInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3UInt8, nValues: usize) -> fmi3Status;
            fmi3GetInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Int16, nValues: usize) -> fmi3Status;
            fmi3GetUInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3UInt16, nValues: usize) -> fmi3Status;
            fmi3GetInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Int32, nValues: usize) -> fmi3Status;
            fmi3GetUInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3UInt32, nValues: usize) -> fmi3Status;
            fmi3GetInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Int64, nValues: usize) -> fmi3Status;
            fmi3GetUInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3UInt64, nValues: usize) -> fmi3Status;
            fmi3GetBoolean(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Boolean, nValues: usize) -> fmi3Status;
            fmi3GetString(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3String, nValues: usize) -> fmi3Status;
            fmi3GetBinary(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                valueSizes: *mut usize, values: *mut fmi3Binary, nValues: usize) -> fmi3Status;
            fmi3GetClock(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *mut fmi3Clock) -> fmi3Status;
            fmi3SetFloat32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Float32, nValues: usize) -> fmi3Status;
            fmi3SetFloat64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Float64, nValues: usize) -> fmi3Status;
            fmi3SetInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Int8, nValues: usize) -> fmi3Status;
            fmi3SetUInt8(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3UInt8, nValues: usize) -> fmi3Status;
            fmi3SetInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Int16, nValues: usize) -> fmi3Status;
            fmi3SetUInt16(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3UInt16, nValues: usize) -> fmi3Status;
            fmi3SetInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Int32, nValues: usize) -> fmi3Status;
            fmi3SetUInt32(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3UInt32, nValues: usize) -> fmi3Status;
            fmi3SetInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Int64, nValues: usize) -> fmi3Status;
            fmi3SetUInt64(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3UInt64, nValues: usize) -> fmi3Status;
            fmi3SetBoolean(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Boolean, nValues: usize) -> fmi3Status;
            fmi3SetString(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3String, nValues: usize) -> fmi3Status;
            fmi3SetBinary(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                valueSizes: *const usize, values: *const fmi3Binary, nValues: usize) -> fmi3Status;
            fmi3SetClock(instance: fmi3Instance, valueReferences: *const fmi3ValueReference, nValueReferences: usize,
                values: *const fmi3Clock) -> fmi3Status;
            fmi3GetNumberOfVariableDependencies(instance: fmi3Instance, valueReference: fmi3ValueReference,
                nDependencies: *mut usize) -> fmi3Status;
            fmi3GetVariableDependencies(instance: fmi3Instance, dependent: fmi3ValueReference,
                elementIndicesOfDependent: *mut usize, independents: *mut fmi3ValueReference,
                elementIndicesOfIndependents: *mut usize, dependencyKinds: *mut fmi3DependencyKind,
                nDependencies: usize) -> fmi3Status;
            fmi3GetFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status;
            fmi3SetFMUState(instance: fmi3Instance, FMUState: fmi3FMUState) -> fmi3Status;
            fmi3FreeFMUState(instance: fmi3Instance, FMUState: *mut fmi3FMUState) -> fmi3Status;
            fmi3SerializedFMUStateSize(instance: fmi3Instance, FMUState: fmi3FMUState, size: *mut usize) -> fmi3Status;
            fmi3SerializeFMUState(instance: fmi3Instance, FMUState: fmi3FMUState, serializedState: *mut fmi3Byte,
                size: usize) -> fmi3Status;
            fmi3DeserializeFMUState(instance: fmi3Instance, serializedState: *const fmi3Byte, size: usize,
                FMUState: *mut fmi3FMUState) -> fmi3Status;
            fmi3GetDirectionalDerivative(instance: fmi3Instance, unknowns: *const fmi3ValueReference, nUnknowns: usize,
                knowns: *const fmi3ValueReference, nKnowns: usize, seed: *const fmi3Float64, nSeed: usize,
                sensitivity: *mut fmi3Float64, nSensitivity: usize) -> fmi3Status;
            fmi3GetAdjointDerivative(instance: fmi3Instance, unknowns: *const fmi3ValueReference, nUnknowns: usize,
                knowns: *const fmi3ValueReference, nKnowns: usize, seed: *const fmi3Float64, nSeed: usize,
                sensitivity: *mut fmi3Float64, nSensitivity: usize) -> fmi3Status;
            fmi3EnterConfigurationMode(instance: fmi3Instance) -> fmi3Status;
            fmi3ExitConfigurationMode(instance: fmi3Instance) -> fmi3Status;
            fmi3GetIntervalDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, intervals: *mut fmi3Float64, qualifiers: *mut fmi3IntervalQualifier)
                -> fmi3Status;
            fmi3GetIntervalFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64,
                qualifiers: *mut fmi3IntervalQualifier) -> fmi3Status;
            fmi3GetShiftDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, shifts: *mut fmi3Float64) -> fmi3Status;
            fmi3GetShiftFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, counters: *mut fmi3UInt64, resolutions: *mut fmi3UInt64) -> fmi3Status;
            fmi3SetIntervalDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, intervals: *const fmi3Float64) -> fmi3Status;
            fmi3SetIntervalFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64) -> fmi3Status;
            fmi3SetShiftDecimal(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, shifts: *const fmi3Float64) -> fmi3Status;
            fmi3SetShiftFraction(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, counters: *const fmi3UInt64, resolutions: *const fmi3UInt64) -> fmi3Status;
            fmi3EvaluateDiscreteStates(instance: fmi3Instance) -> fmi3Status;
            fmi3UpdateDiscreteStates(instance: fmi3Instance, discreteStatesNeedUpdate: *mut fmi3Boolean,
                terminateSimulation: *mut fmi3Boolean, nominalsOfContinuousStatesChanged: *mut fmi3Boolean,
                valuesOfContinuousStatesChanged: *mut fmi3Boolean, nextEventTimeDefined: *mut fmi3Boolean,
                nextEventTime: *mut fmi3Float64) -> fmi3Status;
            fmi3EnterContinuousTimeMode(instance: fmi3Instance) -> fmi3Status;
            fmi3CompletedIntegratorStep(instance: fmi3Instance, noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
                enterEventMode: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean) -> fmi3Status;
            fmi3SetTime(instance: fmi3Instance, time: fmi3Float64) -> fmi3Status;
            fmi3SetContinuousStates(instance: fmi3Instance, continuousStates: *const fmi3Float64,
                nContinuousStates: usize) -> fmi3Status;
            fmi3GetContinuousStateDerivatives(instance: fmi3Instance, derivatives: *mut fmi3Float64,
                nContinuousStates: usize) -> fmi3Status;
            fmi3GetEventIndicators(instance: fmi3Instance, eventIndicators: *mut fmi3Float64, nEventIndicators: usize)
                -> fmi3Status;
            fmi3GetContinuousStates(instance: fmi3Instance, continuousStates: *mut fmi3Float64,
                nContinuousStates: usize) -> fmi3Status;
            fmi3GetNominalsOfContinuousStates(instance: fmi3Instance, nominals: *mut fmi3Float64,
                nContinuousStates: usize) -> fmi3Status;
            fmi3GetNumberOfEventIndicators(instance: fmi3Instance, nEventIndicators: *mut usize) -> fmi3Status;
            fmi3GetNumberOfContinuousStates(instance: fmi3Instance, nContinuousStates: *mut usize) -> fmi3Status;
            fmi3EnterStepMode(instance: fmi3Instance) -> fmi3Status;
            fmi3GetOutputDerivatives(instance: fmi3Instance, valueReferences: *const fmi3ValueReference,
                nValueReferences: usize, orders: *const fmi3Int32, values: *mut fmi3Float64, nValues: usize)
                -> fmi3Status;
            fmi3DoStep(instance: fmi3Instance, currentCommunicationPoint: fmi3Float64,
                communicationStepSize: fmi3Float64, noSetFMUStatePriorToCurrentPoint: fmi3Boolean,
                eventHandlingNeeded: *mut fmi3Boolean, terminateSimulation: *mut fmi3Boolean,
                earlyReturn: *mut fmi3Boolean, lastSuccessfulTime: *mut fmi3Float64) -> fmi3Status;
            fmi3ActivateModelPartition(instance: fmi3Instance, clockReference: fmi3ValueReference,
                activationTime: fmi3Float64) -> fmi3Status;
        }
    };
}
