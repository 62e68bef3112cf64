//! What a unit announces to a body that carries it.

use std::cell::Cell;
use std::fmt::Display;
use std::slice::from_mut;

use fmi_export::{Model, Real, Variable};
use rigid::RootResponse;

/// A response that could not be found.
pub const UNKNOWN: RootResponse = RootResponse { reaction: [f64::NAN; 6], impedance: [[f64::NAN; 6]; 6] };

/// Relative difference of a step from the announced one that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Response of the root in the coming step.
#[derive(Clone)]
pub struct Announced {
    /// Length of the coming step, s.
    step: f64,
    /// None if inputs or state have changed since it was found.
    found: Option<RootResponse>,
    /// Why the last one could not be found.
    fault: Option<String>,
    /// Whether the state was saved since then.
    is_saved: Cell<bool>,
}

impl Announced {
    /// Return a response that is still to be found, for a step of so many seconds.
    pub fn new(step: f64) -> Self {
        Self { step, found: None, fault: None, is_saved: Cell::new(false) }
    }

    /// Note that the state is saved: what comes next must be the same after a restore, which forgets the response.
    pub fn note_saved(&self) {
        self.is_saved.set(true);
    }

    /// Return whether the state was saved since the response was found, once.
    pub fn was_saved(&self) -> bool {
        self.is_saved.take()
    }

    /// Return why there is no response, if the last search failed.
    pub fn fault(&self) -> Option<String> {
        self.fault.clone()
    }

    /// Return the response, [`UNKNOWN`] where `find` fails, which gets the length of the step.
    pub fn or_find<E: Display>(&mut self, find: impl FnOnce(f64) -> Result<RootResponse, E>) -> &RootResponse {
        let step = self.step;
        if self.was_saved() {
            self.found = None;
        }
        let Self { found, fault, .. } = self;
        found.get_or_insert_with(|| {
            let sought = find(step);
            *fault = sought.as_ref().err().map(ToString::to_string);
            sought.unwrap_or(UNKNOWN)
        })
    }
}

/// A unit that a body may carry.
pub trait Carried: Model {
    /// Return what it announces, if a body carries it.
    fn announced(&mut self) -> Option<&mut Announced>;

    /// Return the response of the root in the coming step.
    fn response(&mut self) -> &RootResponse;

    /// Find the response anew where it is read again.
    fn mark_stale(&mut self) {
        if let Some(announced) = self.announced() {
            announced.found = None;
        }
    }

    /// Begin a step of `h` seconds; refuse one that was not announced.
    fn begin_step(&mut self, h: f64) -> Result<(), String> {
        match self.announced() {
            Some(Announced { step, .. }) if (h - *step).abs() > ROUNDING * h => {
                Err(format!("the step of {h:e} s must be the announced `root.step`, {step:e} s"))
            }
            _ => {
                self.mark_stale();
                Ok(())
            }
        }
    }
}

/// Return the variables of what a unit announces.
pub fn response<M: Carried>() -> [Variable<M>; 3] {
    [
        Real::input("root.step", "s", "Length of the coming step", |m: &mut M| {
            m.mark_stale();
            m.announced().map_or(&mut [], |announced| from_mut(&mut announced.step))
        })
        .above(0.0),
        Real::output("root.reaction", "1", "Force, N, and moment, N m, on the body in the coming step", |m: &mut M| {
            &m.response().reaction
        })
        .array(6),
        Real::output(
            "root.impedance",
            "1",
            "Rows of the rate at which they fall with the root's velocities",
            |m: &mut M| m.response().impedance.as_flattened(),
        )
        .array(36),
    ]
}
