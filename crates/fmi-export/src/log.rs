//! Messages to the logger of the master.

use std::cell::Cell;
use std::ffi::{CStr, CString};
use std::fmt::Display;

use crate::sys::{
    fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status, fmi3InstanceEnvironment, fmi3LogMessageCallback,
    fmi3Status,
};
use crate::version::Version;

/// Return the log categories with their descriptions.
pub(crate) fn categories(version: Version) -> [(&'static CStr, &'static str); 4] {
    let [errors, warnings, events] = match version {
        Version::Fmi2 => [
            "Reasons of refused and failed calls, always reported",
            "Problems that do not stop the simulation, always reported",
            "Progress of the model, reported when logging is on",
        ],
        Version::Fmi3 => {
            ["Reasons of refused and failed calls", "Problems that do not stop the simulation", "Progress of the model"]
        }
    };
    [(ERROR, errors), (WARNING, warnings), (EVENT, events), (ALL, "All categories")]
}

const ERROR: &CStr = c"logStatusError";
const WARNING: &CStr = c"logStatusWarning";
const EVENT: &CStr = c"logEvents";
const ALL: &CStr = c"logAll";

/// Connection to the logger of the master.
///
/// In FMI 2.0 errors and warnings always pass, and information passes if the master turned it on. In FMI 3.0 the master
/// turns each category on or off.
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

    /// Return a log without a reader, for a model without a master.
    pub fn silent() -> Self {
        Log { logger: Logger::Nobody, passing: Cell::new([false; 3]) }
    }

    /// Report progress. The message is formatted only if the master reads it, so pass `format_args!(...)`.
    pub fn info(&self, message: impl Display) {
        self.send(2, fmi2Status::fmi2OK, EVENT, message);
    }

    /// Report a problem that does not stop the simulation.
    pub fn warn(&self, message: impl Display) {
        self.send(1, fmi2Status::fmi2Warning, WARNING, message);
    }

    /// Report the reason of a failed call. A model returns its errors, and the export reports them.
    pub(crate) fn error(&self, message: impl Display) {
        self.send(0, fmi2Status::fmi2Error, ERROR, message);
    }

    /// Turn categories on or off, all for an empty list; refuse an unknown category.
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
                // SAFETY: the caller of `fmi2` guarantees a logger that accepts this environment. The strings live
                // through the call. The message is the format string, and without conversions it reads no further
                // arguments.
                unsafe { call(*environment, instance_name.as_ptr(), status, category.as_ptr(), message.as_ptr()) }
            }
            Logger::Fmi3 { call: Some(call), environment } => {
                let message = without_nul(&message.to_string());
                // SAFETY: the caller of `fmi3` guarantees a logger that accepts this environment. The strings live
                // through the call. FMI 2.0 and 3.0 number the statuses alike.
                unsafe { call(*environment, fmi3Status(status.0), category.as_ptr(), message.as_ptr()) }
            }
            _ => {}
        }
    }
}

/// Return the message for C, without NUL.
fn without_nul(message: &str) -> CString {
    CString::new(message.replace('\0', "\u{fffd}")).expect("NUL was replaced")
}

/// Return the message as a format string, with `%` and `#` doubled, which have a meaning to loggers of FMI 2.0.
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
