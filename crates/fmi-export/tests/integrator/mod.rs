//! A model with one variable of each kind and type, and its C functions.
#![allow(dead_code, reason = "each test uses a part")]

use std::slice::{from_mut, from_ref};

use nervure_fmi_export::{Description, Log, Model, Resources, Variable};
use serde::{Deserialize, Serialize};

/// Inputs of this value make a step fail or panic.
pub const FAILING: f64 = 13.0;
pub const PANICKING: f64 = 666.0;

/// A parameter with this value does not fit.
pub const UNFIT: f64 = 99.0;

/// A state with this integral is refused.
pub const FOREIGN: f64 = 4711.0;

/// dy/dt = gain u + bias, with one variable of each kind and type around it.
pub struct Integrator {
    gain: f64,
    bias: f64,
    u: [f64; 3],
    y: [f64; 3],
    order: i32,
    length: i32,
    hold: bool,
    held: bool,
    label: String,
    echo: String,
    mode: i32,
}

/// Integrals, whether they were held, and the echo.
#[derive(Clone, Serialize, Deserialize)]
pub struct Memory([f64; 3], bool, String);

impl Model for Integrator {
    const IDENTIFIER: &'static str = "integrator";
    const VERSION: &'static str = "1.0";
    type State = Memory;

    fn load(resources: &Resources) -> Result<Self, String> {
        if let Some(folder) = resources.folder().filter(|folder| !folder.is_dir()) {
            return Err(format!("resources {} is not a folder, 100 %", folder.display()));
        }
        Ok(Integrator {
            gain: 1.0,
            bias: 0.0,
            u: [0.0; 3],
            y: [0.0; 3],
            order: 1,
            length: 3,
            hold: false,
            held: false,
            label: "début".into(),
            echo: String::new(),
            mode: 1,
        })
    }

    fn description(&self) -> Description {
        Description { model_name: "Integrator".into(), text: "Three integrators".into(), ..Description::default() }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        type Real = nervure_fmi_export::Real<Integrator>;
        type Integer = nervure_fmi_export::Integer<Integrator>;
        type Boolean = nervure_fmi_export::Boolean<Integrator>;
        type Text = nervure_fmi_export::Text<Integrator>;
        vec![
            Real::time(),
            Real::parameter("gain", "1", "Gain", |m| from_mut(&mut m.gain)).above(0.0),
            Real::parameter("bias", "1/s", "Bias", |m| from_mut(&mut m.bias)).at_least(-1.0).at_most(1.0).tunable(),
            Real::input("u", "1/s", "Rate", |m| &mut m.u).array(3),
            Real::output("y", "1", "Integral", |m| &m.y).array(3).depends_on(&[]),
            Integer::parameter("order", "Order", |m| from_mut(&mut m.order)).at_least(1),
            Integer::local("length", "Length", |m| from_ref(&m.length)).constant(),
            Boolean::input("hold", "Hold the integral", |m| from_mut(&mut m.hold)),
            Boolean::output("held", "It was held", |m| from_ref(&m.held)),
            Text::parameter("label", "Label", |m| from_mut(&mut m.label)),
            Text::output("echo", "Label, once initialised", |m| from_ref(&m.echo)),
            Integer::parameter("mode", "Mode", |m| from_mut(&mut m.mode)).enumeration("Mode", &["off", "on"]),
            Real::computed("total", "1", "Sum of the integrals", |m| m.y.iter().sum()),
        ]
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        if self.gain == UNFIT {
            return Err(format!("gain = {UNFIT} does not fit"));
        }
        self.echo = format!("{} at {start}", self.label);
        log.info(format_args!("initialised {}", self.label));
        Ok(())
    }

    fn step(&mut self, _t: f64, h: f64, _log: &Log) -> Result<(), String> {
        if self.u[0] == FAILING {
            return Err(format!("u[1] = {FAILING} must not be {FAILING}"));
        }
        for (i, (y, u)) in self.y.iter_mut().zip(self.u).enumerate() {
            *y += if self.hold { 0.0 } else { h * (self.gain * u + self.bias) };
            assert!(u != PANICKING, "u[{}] = {PANICKING}", i + 1);
        }
        self.held = self.hold;
        Ok(())
    }

    fn save(&self) -> Memory {
        Memory(self.y, self.held, self.echo.clone())
    }

    fn restore(&mut self, state: &Memory) -> Result<(), String> {
        Memory(self.y, self.held, self.echo) = state.clone();
        if self.y[0] == FOREIGN {
            return Err(format!("y[1] = {FOREIGN} is foreign"));
        }
        Ok(())
    }
}

nervure_fmi_export::export_fmu!(Integrator);

pub const TIME: u32 = 0;
pub const GAIN: u32 = 1;
pub const BIAS: u32 = 2;
pub const U: [u32; 3] = [3, 4, 5];
pub const Y: [u32; 3] = [6, 7, 8];
pub const ORDER: u32 = 9;
pub const LENGTH: u32 = 10;
pub const HOLD: u32 = 11;
pub const HELD: u32 = 12;
pub const LABEL: u32 = 13;
pub const ECHO: u32 = 14;
pub const MODE: u32 = 15;
pub const TOTAL: u32 = 16;
