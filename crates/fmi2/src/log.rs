//! Messages to the master's logger.

use std::cell::Cell;
use std::ffi::{CStr, CString};
use std::fmt::Display;
use std::ptr;

use crate::sys::{fmi2CallbackLogger, fmi2ComponentEnvironment, fmi2Status};

/// Log categories with their descriptions, as the model description lists them.
pub(crate) const CATEGORIES: [(&CStr, &str); 4] = [
    (ERROR, "Why a call was refused or failed, always reported"),
    (WARNING, "What looks wrong but does not stop the simulation, always reported"),
    (EVENT, "What the model tells about its progress, reported when logging is on"),
    (ALL, "All of these"),
];
const ERROR: &CStr = c"logStatusError";
const WARNING: &CStr = c"logStatusWarning";
const EVENT: &CStr = c"logEvents";
const ALL: &CStr = c"logAll";

/// The way to the master's logger. Errors and warnings always pass, information only when the master turned it on.
pub struct Log {
    logger: fmi2CallbackLogger,
    environment: fmi2ComponentEnvironment,
    instance_name: CString,
    info: Cell<bool>,
}

impl Log {
    /// # Safety
    /// `logger`, if present, must be an FMI 2.0 logger that accepts `environment` for as long as the log lives.
    pub(crate) unsafe fn new(
        logger: fmi2CallbackLogger,
        environment: fmi2ComponentEnvironment,
        instance_name: CString,
        info: bool,
    ) -> Self {
        Log { logger, environment, instance_name, info: Cell::new(info) }
    }

    /// A log that nobody reads, to call a model without a master.
    pub fn silent() -> Self {
        Log { logger: None, environment: ptr::null_mut(), instance_name: CString::default(), info: Cell::new(false) }
    }

    /// Tells progress. The message is formatted only if the master listens: pass `format_args!(...)`.
    pub fn info(&self, message: impl Display) {
        if self.info.get() {
            self.send(fmi2Status::fmi2OK, EVENT, message);
        }
    }

    /// Tells what looks wrong but does not stop the simulation.
    pub fn warn(&self, message: impl Display) {
        self.send(fmi2Status::fmi2Warning, WARNING, message);
    }

    /// Tells why a call fails. A model returns its errors instead, and the glue reports them.
    pub(crate) fn error(&self, message: impl Display) {
        self.send(fmi2Status::fmi2Error, ERROR, message);
    }

    /// Turns information on or off. No categories means all; an unknown one is an error.
    pub(crate) fn set_debug_logging(&self, on: bool, categories: &[&CStr]) -> Result<(), String> {
        let known = |category: &&CStr| CATEGORIES.iter().any(|(name, _)| name == category);
        if let Some(unknown) = categories.iter().find(|category| !known(category)) {
            return Err(format!("log category {unknown:?} does not exist"));
        }
        let selected = categories.is_empty() || categories.contains(&EVENT) || categories.contains(&ALL);
        self.info.set(on && selected);
        Ok(())
    }

    fn send(&self, status: fmi2Status, category: &CStr, message: impl Display) {
        let Some(logger) = self.logger else { return };
        let message = escape(&message.to_string());
        // SAFETY: `new` was promised a logger that accepts this environment. The strings live through the call, and
        // the message, its format string, has no conversion that would ask for further arguments.
        unsafe {
            logger(self.environment, self.instance_name.as_ptr(), status, category.as_ptr(), message.as_ptr());
        }
    }
}

/// The message as a format string: `%` and `#` have a meaning to loggers and are doubled, NUL would end it.
fn escape(message: &str) -> CString {
    let escaped = message.replace('%', "%%").replace('#', "##").replace('\0', "\u{fffd}");
    CString::new(escaped).expect("NUL was replaced")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_and_hash_are_doubled_and_nul_is_replaced() {
        assert_eq!(escape("100 % of #1\0").to_str(), Ok("100 %% of ##1\u{fffd}"));
    }

    #[test]
    fn information_needs_its_category() {
        let log = Log::silent();
        log.set_debug_logging(true, &[]).unwrap();
        assert!(log.info.get());
        log.set_debug_logging(true, &[WARNING]).unwrap();
        assert!(!log.info.get());
        log.set_debug_logging(true, &[WARNING, ALL]).unwrap();
        assert!(log.info.get());
        log.set_debug_logging(false, &[EVENT]).unwrap();
        assert!(!log.info.get());
    }

    #[test]
    fn an_unknown_category_is_named() {
        let message = Log::silent().set_debug_logging(true, &[c"logNothing"]).unwrap_err();
        assert!(message.contains("logNothing"), "{message}");
    }
}
