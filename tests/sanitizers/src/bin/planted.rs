//! The same calls on a unit with a bug in its step: `planted none|use_after_free|out_of_bounds|leak`.

use std::hint::black_box;
use std::slice::{from_mut, from_ref};

use nervure_fmi_export::{Description, Log, Model, Resources, Variable};

#[path = "../calls.rs"]
mod calls;

struct Planted {
    u: f64,
    y: f64,
    bug: String,
}

impl Model for Planted {
    const IDENTIFIER: &'static str = "planted";
    const VERSION: &'static str = "1.0";
    const RESOURCES: &'static [&'static str] = &["scene.json"];
    type State = f64;

    fn load(resources: &Resources) -> Result<Self, String> {
        Ok(Planted { u: 0.0, y: 0.0, bug: resources.text("scene.json")?.to_owned() })
    }

    fn description(&self) -> Description {
        let (model_name, text) = ("Planted".into(), "A unit with a bug".into());
        Description { model_name, text, ..Description::default() }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        type Real = nervure_fmi_export::Real<Planted>;
        vec![
            Real::input("u", "1", "Input", |m| from_mut(&mut m.u)),
            Real::output("y", "1", "Output", |m| from_ref(&m.y)).depends_on(&[]),
        ]
    }

    fn initialise(&mut self, _start: f64, _log: &Log) -> Result<(), String> {
        Ok(())
    }

    fn step(&mut self, _t: f64, _h: f64, _log: &Log) -> Result<(), String> {
        let values = black_box(vec![self.u; 8]);
        let first = values.as_ptr();
        match self.bug.as_str() {
            "use_after_free" => {
                drop(values);
                // SAFETY: none, this is the bug.
                self.y = unsafe { black_box(first).read() };
            }
            // SAFETY: none, this is the bug.
            "out_of_bounds" => self.y = unsafe { black_box(first).add(8).read() },
            "leak" => {
                std::mem::forget(values);
                self.y = self.u;
            }
            _ => self.y = values[0],
        }
        Ok(())
    }

    fn save(&self) -> Self::State {
        self.y
    }

    fn restore(&mut self, state: &Self::State) -> Result<(), String> {
        self.y = *state;
        Ok(())
    }
}

nervure_fmi_export::export_fmu!(Planted);

fn main() {
    let bug = std::env::args().nth(1).expect("usage: planted BUG");
    calls::run(bug.as_bytes());
}
