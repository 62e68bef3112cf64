//! Which function may be called when: the calling sequence of a co-simulation slave (FMI 2.0.4, section 4.2.4).

use std::fmt;

use serde::{Deserialize, Serialize};

/// Where an instance is in its life.
///
/// The standard's states "step in progress", "step canceled" and "step failed" belong to steps that run
/// asynchronously or are discarded, "fatal" to instances that take others with them. None of these occurs here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Mode {
    Instantiated,
    Initialization,
    StepComplete,
    Terminated,
    /// The model returned an error and is as it was before the call.
    Error,
    /// The model panicked and may be in pieces: only a new beginning or a stored state helps.
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

/// The functions that act on an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    SetDebugLogging,
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    GetReal,
    GetInteger,
    GetBoolean,
    GetString,
    SetReal,
    SetInteger,
    SetBoolean,
    SetString,
    GetFMUstate,
    SetFMUstate,
    FreeFMUstate,
    SerializedFMUstateSize,
    SerializeFMUstate,
    DeSerializeFMUstate,
    GetDirectionalDerivative,
    SetRealInputDerivatives,
    GetRealOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
    GetRealStatus,
    GetIntegerStatus,
    GetBooleanStatus,
    GetStringStatus,
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "fmi2{self:?}")
    }
}

/// One column per [`Mode`], in its order; `x` is allowed.
#[rustfmt::skip]
const TABLE: [(&[Function], &str); 12] = {
    use Function::*;
    [
        //                                                         Instantiated
        //                                                         | Initialization
        //                                                         | | StepComplete
        //                                                         | | | Terminated
        //                                                         | | | | Error
        //                                                         | | | | | Panicked
        (&[SetDebugLogging, Reset, SetFMUstate, FreeFMUstate],    "x x x x x x"),
        (&[SerializedFMUstateSize, SerializeFMUstate,
           DeSerializeFMUstate],                                  "x x x x x x"),
        (&[GetFMUstate],                                          "x x x x x -"),
        (&[SetupExperiment, EnterInitializationMode],             "x - - - - -"),
        (&[ExitInitializationMode],                               "- x - - - -"),
        (&[Terminate, DoStep],                                    "- - x - - -"),
        (&[CancelStep],                                           "- - - - - -"),
        (&[GetReal, GetInteger, GetBoolean, GetString],           "- x x x x -"),
        (&[SetReal, SetInteger, SetBoolean, SetString,
           SetRealInputDerivatives],                              "x x x - - -"),
        (&[GetDirectionalDerivative],                             "- x x x x -"),
        (&[GetRealOutputDerivatives],                             "- - x x x -"),
        (&[GetStatus, GetRealStatus, GetIntegerStatus,
           GetBooleanStatus, GetStringStatus],                    "- - x x x x"),
    ]
};

/// Refuses a call that the state does not allow.
pub(crate) fn check(function: Function, mode: Mode) -> Result<(), String> {
    let (_, row) = TABLE.iter().find(|(functions, _)| functions.contains(&function)).expect("every function has a row");
    if row.as_bytes()[2 * mode as usize] == b'x' {
        return Ok(());
    }
    Err(format!("not allowed in the state \"{mode}\""))
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
    fn every_function_has_one_row_and_every_row_six_columns() {
        let mut functions: Vec<_> = TABLE.iter().flat_map(|(functions, _)| functions.iter().copied()).collect();
        functions.sort_by_key(|function| *function as usize);
        let numbers: Vec<_> = functions.iter().map(|function| *function as usize).collect();
        assert_eq!(numbers, (0..=Function::GetStringStatus as usize).collect::<Vec<_>>());
        for (functions, row) in TABLE {
            assert_eq!(row.len(), 2 * MODES.len() - 1, "{functions:?}");
        }
    }

    #[test]
    fn steps_are_made_between_initialisation_and_termination_only() {
        assert_eq!(allowed(Function::DoStep), [Mode::StepComplete]);
        assert_eq!(allowed(Function::CancelStep), []);
    }

    #[test]
    fn values_are_set_before_the_end_and_read_from_initialisation_on() {
        let all_but_last = &MODES[..3];
        assert_eq!(allowed(Function::SetReal), all_but_last);
        let all_but_first_and_panicked = &MODES[1..5];
        assert_eq!(allowed(Function::GetReal), all_but_first_and_panicked);
    }

    #[test]
    fn a_new_beginning_and_a_stored_state_are_always_allowed() {
        assert_eq!(allowed(Function::Reset), MODES);
        assert_eq!(allowed(Function::SetFMUstate), MODES);
    }

    #[test]
    fn a_refusal_names_the_state() {
        let message = check(Function::DoStep, Mode::Initialization).unwrap_err();
        assert!(message.contains("initialization mode"), "{message}");
    }

    #[test]
    fn the_readme_shows_this_table() {
        let readme = include_str!("../README.md");
        for (functions, row) in TABLE {
            let functions: Vec<_> = functions.iter().map(|function| format!("{function:?}")).collect();
            let line = format!("| {} | {} |", functions.join(", "), row.replace(' ', " | ").replace('-', " "));
            assert!(readme.contains(&line), "README.md lacks\n{line}");
        }
    }
}
