//! The C types of FMI 2.0, generated from the official headers by `crates/fmi2/bindgen`: do not edit.
#![allow(missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals)]

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
pub type fmi2GetTypesPlatformTYPE = ::std::option::Option<
    unsafe extern "C" fn() -> *const ::std::os::raw::c_char,
>;
pub type fmi2GetVersionTYPE = ::std::option::Option<
    unsafe extern "C" fn() -> *const ::std::os::raw::c_char,
>;
pub type fmi2SetDebugLoggingTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        loggingOn: fmi2Boolean,
        nCategories: usize,
        categories: *const fmi2String,
    ) -> fmi2Status,
>;
pub type fmi2InstantiateTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        instanceName: fmi2String,
        fmuType: fmi2Type,
        fmuGUID: fmi2String,
        fmuResourceLocation: fmi2String,
        functions: *const fmi2CallbackFunctions,
        visible: fmi2Boolean,
        loggingOn: fmi2Boolean,
    ) -> fmi2Component,
>;
pub type fmi2FreeInstanceTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component),
>;
pub type fmi2SetupExperimentTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        toleranceDefined: fmi2Boolean,
        tolerance: fmi2Real,
        startTime: fmi2Real,
        stopTimeDefined: fmi2Boolean,
        stopTime: fmi2Real,
    ) -> fmi2Status,
>;
pub type fmi2EnterInitializationModeTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component) -> fmi2Status,
>;
pub type fmi2ExitInitializationModeTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component) -> fmi2Status,
>;
pub type fmi2TerminateTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component) -> fmi2Status,
>;
pub type fmi2ResetTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component) -> fmi2Status,
>;
pub type fmi2GetRealTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *mut fmi2Real,
    ) -> fmi2Status,
>;
pub type fmi2GetIntegerTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *mut fmi2Integer,
    ) -> fmi2Status,
>;
pub type fmi2GetBooleanTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *mut fmi2Boolean,
    ) -> fmi2Status,
>;
pub type fmi2GetStringTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *mut fmi2String,
    ) -> fmi2Status,
>;
pub type fmi2SetRealTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *const fmi2Real,
    ) -> fmi2Status,
>;
pub type fmi2SetIntegerTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *const fmi2Integer,
    ) -> fmi2Status,
>;
pub type fmi2SetBooleanTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *const fmi2Boolean,
    ) -> fmi2Status,
>;
pub type fmi2SetStringTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        value: *const fmi2String,
    ) -> fmi2Status,
>;
pub type fmi2GetFMUstateTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status,
>;
pub type fmi2SetFMUstateTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status,
>;
pub type fmi2FreeFMUstateTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status,
>;
pub type fmi2SerializedFMUstateSizeTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        FMUstate: fmi2FMUstate,
        size: *mut usize,
    ) -> fmi2Status,
>;
pub type fmi2SerializeFMUstateTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        FMUstate: fmi2FMUstate,
        arg1: *mut fmi2Byte,
        size: usize,
    ) -> fmi2Status,
>;
pub type fmi2DeSerializeFMUstateTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        serializedState: *const fmi2Byte,
        size: usize,
        FMUstate: *mut fmi2FMUstate,
    ) -> fmi2Status,
>;
pub type fmi2GetDirectionalDerivativeTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vUnknown_ref: *const fmi2ValueReference,
        nUnknown: usize,
        vKnown_ref: *const fmi2ValueReference,
        nKnown: usize,
        dvKnown: *const fmi2Real,
        dvUnknown: *mut fmi2Real,
    ) -> fmi2Status,
>;
pub type fmi2EnterEventModeTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component) -> fmi2Status,
>;
pub type fmi2NewDiscreteStatesTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        fmi2eventInfo: *mut fmi2EventInfo,
    ) -> fmi2Status,
>;
pub type fmi2EnterContinuousTimeModeTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component) -> fmi2Status,
>;
pub type fmi2CompletedIntegratorStepTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
        enterEventMode: *mut fmi2Boolean,
        terminateSimulation: *mut fmi2Boolean,
    ) -> fmi2Status,
>;
pub type fmi2SetTimeTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component, time: fmi2Real) -> fmi2Status,
>;
pub type fmi2SetContinuousStatesTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component, x: *const fmi2Real, nx: usize) -> fmi2Status,
>;
pub type fmi2GetDerivativesTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        derivatives: *mut fmi2Real,
        nx: usize,
    ) -> fmi2Status,
>;
pub type fmi2GetEventIndicatorsTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        eventIndicators: *mut fmi2Real,
        ni: usize,
    ) -> fmi2Status,
>;
pub type fmi2GetContinuousStatesTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component, x: *mut fmi2Real, nx: usize) -> fmi2Status,
>;
pub type fmi2GetNominalsOfContinuousStatesTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        x_nominal: *mut fmi2Real,
        nx: usize,
    ) -> fmi2Status,
>;
pub type fmi2SetRealInputDerivativesTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        order: *const fmi2Integer,
        value: *const fmi2Real,
    ) -> fmi2Status,
>;
pub type fmi2GetRealOutputDerivativesTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        vr: *const fmi2ValueReference,
        nvr: usize,
        order: *const fmi2Integer,
        value: *mut fmi2Real,
    ) -> fmi2Status,
>;
pub type fmi2DoStepTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        currentCommunicationPoint: fmi2Real,
        communicationStepSize: fmi2Real,
        noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
    ) -> fmi2Status,
>;
pub type fmi2CancelStepTYPE = ::std::option::Option<
    unsafe extern "C" fn(c: fmi2Component) -> fmi2Status,
>;
pub type fmi2GetStatusTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        s: fmi2StatusKind,
        value: *mut fmi2Status,
    ) -> fmi2Status,
>;
pub type fmi2GetRealStatusTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        s: fmi2StatusKind,
        value: *mut fmi2Real,
    ) -> fmi2Status,
>;
pub type fmi2GetIntegerStatusTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        s: fmi2StatusKind,
        value: *mut fmi2Integer,
    ) -> fmi2Status,
>;
pub type fmi2GetBooleanStatusTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        s: fmi2StatusKind,
        value: *mut fmi2Boolean,
    ) -> fmi2Status,
>;
pub type fmi2GetStringStatusTYPE = ::std::option::Option<
    unsafe extern "C" fn(
        c: fmi2Component,
        s: fmi2StatusKind,
        value: *mut fmi2String,
    ) -> fmi2Status,
>;
