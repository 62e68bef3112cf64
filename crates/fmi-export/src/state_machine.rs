//! Calling sequence of co-simulation (FMI 2.0.4, section 4.2.4; FMI 3.0.2, sections 2.3 and 4.2).

use std::fmt;

use serde::{Deserialize, Serialize};

/// Mode of an instance.
///
/// The states "step in progress", "step canceled" and "step failed" of the standard belong to asynchronous or discarded
/// steps, and "fatal" to failures that affect other instances. None of them occurs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Mode {
    Instantiated,
    Initialization,
    StepComplete,
    Terminated,
    /// The model returned an error and is unchanged.
    Error,
    /// The model panicked and may be inconsistent; only a reset or a stored state helps.
    Panicked,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Mode::Instantiated => "instantiated",
            Mode::Initialization => "initialization mode",
            Mode::StepComplete => "step complete",
            Mode::Terminated => "terminated",
            Mode::Error => "error",
            Mode::Panicked => "error after a panic or a refused state",
        })
    }
}

/// Define the functions in rows with a column per [`Mode`]; `x` marks an allowed call.
macro_rules! functions {
    ($($row:literal: $($function:ident)*;)*) => {
        /// Functions of an instance, by their names in C.
        #[allow(non_camel_case_types, reason = "the functions have the names of the standard")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Function {
            $($($function,)*)*
        }

        fn row(function: Function) -> &'static str {
            match function {
                $($(Function::$function)|* => $row,)*
            }
        }

        #[cfg(test)]
        const TABLE: &[(&[Function], &str)] = &[$((&[$(Function::$function),*], $row)),*];
    };
}

functions! {
//   Instantiated
//   | Initialization
//   | | StepComplete
//   | | | Terminated
//   | | | | Error
//   | | | | | Panicked
    "x x x x x x": fmi2SetDebugLogging fmi2Reset fmi2SetFMUstate fmi2FreeFMUstate
                   fmi3SetDebugLogging fmi3Reset fmi3SetFMUState fmi3FreeFMUState
                   fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate
                   fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState;
    "x x x x x -": fmi2GetFMUstate fmi3GetFMUState;
    "x - - - - -": fmi2SetupExperiment fmi2EnterInitializationMode fmi3EnterInitializationMode;
    "- x - - - -": fmi2ExitInitializationMode fmi3ExitInitializationMode;
    "- - x - - -": fmi2Terminate fmi2DoStep fmi3Terminate fmi3DoStep;
    "- - - - - -": fmi2CancelStep;
    "- x x x x -": fmi2GetReal fmi2GetInteger fmi2GetBoolean fmi2GetString fmi2GetDirectionalDerivative
                   fmi3GetFloat32 fmi3GetFloat64 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32
                   fmi3GetUInt32 fmi3GetInt64 fmi3GetUInt64 fmi3GetBoolean fmi3GetString fmi3GetBinary fmi3GetClock
                   fmi3GetDirectionalDerivative fmi3GetAdjointDerivative;
    "x x x - - -": fmi2SetReal fmi2SetInteger fmi2SetBoolean fmi2SetString fmi2SetRealInputDerivatives
                   fmi3SetFloat32 fmi3SetFloat64 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32
                   fmi3SetUInt32 fmi3SetInt64 fmi3SetUInt64 fmi3SetBoolean fmi3SetString fmi3SetBinary fmi3SetClock;
    "- - x x x -": fmi2GetRealOutputDerivatives fmi3GetOutputDerivatives;
    "- - x x x x": fmi2GetStatus fmi2GetRealStatus fmi2GetIntegerStatus fmi2GetBooleanStatus fmi2GetStringStatus;
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

/// Refuse a call that the mode does not allow.
pub(crate) fn check(function: Function, mode: Mode) -> Result<(), String> {
    if row(function).as_bytes()[2 * mode as usize] == b'x' {
        return Ok(());
    }
    let remedy = if matches!(mode, Mode::Error | Mode::Panicked) { ": restore a state, or reset" } else { "" };
    Err(format!("the state \"{mode}\" does not allow this call{remedy}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODES: [Mode; 6] =
        [Mode::Instantiated, Mode::Initialization, Mode::StepComplete, Mode::Terminated, Mode::Error, Mode::Panicked];

    fn allowed(function: Function) -> Vec<Mode> {
        MODES.into_iter().filter(|mode| check(function, *mode).is_ok()).collect()
    }

    #[test]
    fn every_row_has_six_columns() {
        for (functions, row) in TABLE {
            assert_eq!(row.len(), 2 * MODES.len() - 1, "{functions:?}");
        }
    }

    #[test]
    fn steps_are_made_between_initialisation_and_termination_only() {
        assert_eq!(allowed(Function::fmi2DoStep), [Mode::StepComplete]);
        assert_eq!(allowed(Function::fmi2CancelStep), []);
    }

    #[test]
    fn values_are_set_before_the_end_and_read_from_initialisation_on() {
        let all_but_last = &MODES[..3];
        assert_eq!(allowed(Function::fmi2SetReal), all_but_last);
        let all_but_first_and_panicked = &MODES[1..5];
        assert_eq!(allowed(Function::fmi2GetReal), all_but_first_and_panicked);
    }

    #[test]
    fn a_new_beginning_and_a_stored_state_are_always_allowed() {
        assert_eq!(allowed(Function::fmi2Reset), MODES);
        assert_eq!(allowed(Function::fmi2SetFMUstate), MODES);
    }

    #[test]
    fn a_refusal_names_the_state() {
        let message = check(Function::fmi2DoStep, Mode::Initialization).unwrap_err();
        assert!(message.contains("initialization mode") && !message.contains("reset"), "{message}");
        let message = check(Function::fmi2DoStep, Mode::Error).unwrap_err();
        assert!(message.ends_with("restore a state, or reset"), "{message}");
    }
}
