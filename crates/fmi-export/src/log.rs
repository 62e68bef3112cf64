//! Messages to the master's logger.

use std::cell::Cell;
use std::ffi::{CStr, CString};
use std::fmt::Display;

use crate::sys::{
    fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status, fmi3InstanceEnvironment, fmi3LogMessageCallback,
    fmi3Status,
};
use crate::version::Version;

/// Log categories with their descriptions, as the model description lists them.
pub(crate) fn categories(version: Version) -> [(&'static CStr, &'static str); 4] {
    let [errors, warnings, events] = match version {
        Version::Fmi2 => [
            "Why a call was refused or failed, always reported",
            "What looks wrong but does not stop the simulation, always reported",
            "What the model tells about its progress, reported when logging is on",
        ],
        Version::Fmi3 => [
            "Why a call was refused or failed",
            "What looks wrong but does not stop the simulation",
            "What the model tells about its progress",
        ],
    };
    [(ERROR, errors), (WARNING, warnings), (EVENT, events), (ALL, "All of these")]
}

const ERROR: &CStr = c"logStatusError";
const WARNING: &CStr = c"logStatusWarning";
const EVENT: &CStr = c"logEvents";
const ALL: &CStr = c"logAll";

/// The way to the master's logger. In FMI 2.0 errors and warnings always pass, and information only when the master
/// turned it on; in FMI 3.0 that goes for all of them.
pub struct Log {
    logger: Logger,
    /// Whether errors, warnings and information pass.
    passing: Cell<[bool; 3]>,
}

enum Logger {
    Nobody,
    Fmi2 { call: fmi2CallbackLogger, environment: fmi2ComponentEnvironment, instance_name: CString },
    Fmi3 { call: fmi3LogMessageCallback, environment: fmi3InstanceEnvironment },
}

impl Log {
    /// # Safety
    /// `call`, if present, must be an FMI 2.0 logger that accepts `environment` for as long as the log lives.
    pub(crate) unsafe fn fmi2(
        call: fmi2CallbackLogger,
        environment: fmi2ComponentEnvironment,
        instance_name: CString,
        info: bool,
    ) -> Self {
        let logger = Logger::Fmi2 { call, environment, instance_name };
        Log { logger, passing: Cell::new([true, true, info]) }
    }

    /// # Safety
    /// `call`, if present, must be an FMI 3.0 logger that accepts `environment` for as long as the log lives.
    pub(crate) unsafe fn fmi3(call: fmi3LogMessageCallback, environment: fmi3InstanceEnvironment, on: bool) -> Self {
        Log { logger: Logger::Fmi3 { call, environment }, passing: Cell::new([on; 3]) }
    }

    /// A log that nobody reads, to call a model without a master.
    pub fn silent() -> Self {
        Log { logger: Logger::Nobody, passing: Cell::new([false; 3]) }
    }

    /// Tells progress. The message is formatted only if the master listens: pass `format_args!(...)`.
    pub fn info(&self, message: impl Display) {
        self.send(2, fmi2Status::fmi2OK, EVENT, message);
    }

    /// Tells what looks wrong but does not stop the simulation.
    pub fn warn(&self, message: impl Display) {
        self.send(1, fmi2Status::fmi2Warning, WARNING, message);
    }

    /// Tells why a call fails. A model returns its errors instead, and the glue reports them.
    pub(crate) fn error(&self, message: impl Display) {
        self.send(0, fmi2Status::fmi2Error, ERROR, message);
    }

    /// Turns categories on or off. None means all; an unknown one is an error.
    pub(crate) fn set_debug_logging(&self, on: bool, chosen: &[&CStr]) -> Result<(), String> {
        let known = |category: &&CStr| categories(Version::Fmi3).iter().any(|(name, _)| name == category);
        if let Some(unknown) = chosen.iter().find(|category| !known(category)) {
            return Err(format!("log category {unknown:?} does not exist"));
        }
        let meant = |category| chosen.is_empty() || chosen.contains(&category) || chosen.contains(&ALL);
        let selected = [ERROR, WARNING, EVENT].map(meant);
        self.passing.set(match self.logger {
            Logger::Fmi3 { .. } => selected.map(|selected| on && selected),
            _ => [true, true, on && selected[2]],
        });
        Ok(())
    }

    fn send(&self, kind: usize, status: fmi2Status, category: &CStr, message: impl Display) {
        if !self.passing.get()[kind] {
            return;
        }
        match &self.logger {
            Logger::Fmi2 { call: Some(call), environment, instance_name } => {
                let message = escape(&message.to_string());
                // SAFETY: `fmi2` was promised a logger that accepts this environment. The strings live through the
                // call, and the message, its format string, has no conversion that would ask for further arguments.
                unsafe { call(*environment, instance_name.as_ptr(), status, category.as_ptr(), message.as_ptr()) }
            }
            Logger::Fmi3 { call: Some(call), environment } => {
                let message = without_nul(&message.to_string());
                // SAFETY: `fmi3` was promised a logger that accepts this environment. The strings live through the
                // call. The numbers of the statuses are those of FMI 2.0.
                unsafe { call(*environment, fmi3Status(status.0), category.as_ptr(), message.as_ptr()) }
            }
            _ => {}
        }
    }
}

/// The message for C, where NUL would end it.
fn without_nul(message: &str) -> CString {
    CString::new(message.replace('\0', "\u{fffd}")).expect("NUL was replaced")
}

/// The message as a format string: `%` and `#` have a meaning to loggers of FMI 2.0 and are doubled.
fn escape(message: &str) -> CString {
    without_nul(&message.replace('%', "%%").replace('#', "##"))
}

#[cfg(test)]
mod tests {
    use std::ptr::null_mut;

    use super::*;

    #[test]
    fn percent_and_hash_are_doubled_and_nul_is_replaced() {
        assert_eq!(escape("100 % of #1\0").to_str(), Ok("100 %% of ##1\u{fffd}"));
    }

    #[test]
    fn what_passes_is_what_was_turned_on_and_in_fmi_2_always_errors_and_warnings() {
        // SAFETY: there is no logger.
        let logs =
            unsafe { [Log::fmi2(None, null_mut(), CString::default(), false), Log::fmi3(None, null_mut(), false)] };
        for (on, categories, in_fmi2, in_fmi3) in [
            (true, &[][..], [true; 3], [true; 3]),
            (true, &[WARNING][..], [true, true, false], [false, true, false]),
            (true, &[WARNING, ALL][..], [true; 3], [true; 3]),
            (false, &[EVENT][..], [true, true, false], [false; 3]),
        ] {
            for (log, expected) in logs.iter().zip([in_fmi2, in_fmi3]) {
                log.set_debug_logging(on, categories).unwrap();
                assert_eq!(log.passing.get(), expected, "{on} {categories:?}");
            }
        }
    }

    #[test]
    fn an_unknown_category_is_named() {
        let message = Log::silent().set_debug_logging(true, &[c"logNothing"]).unwrap_err();
        assert!(message.contains("logNothing"), "{message}");
    }
}
