//! FMU of m x'' + c x' + k x = F. The force is constant over a step, and the step is the exact solution.

use std::slice::{from_mut, from_ref};

use nervure_fmi_export::{Description, Log, Model, Resources};

type Real = nervure_fmi_export::Real<Oscillator>;
type Variable = nervure_fmi_export::Variable<Oscillator>;

/// Mass on a spring and a damper.
struct Oscillator {
    /// Mass, kg
    m: f64,
    /// Damping, N.s/m
    c: f64,
    /// Stiffness, N/m
    k: f64,
    /// Force, N
    f: f64,
    /// Position, m
    x: f64,
    /// Velocity, m/s
    v: f64,
    /// Initial position, m
    x0: f64,
}

impl Model for Oscillator {
    const IDENTIFIER: &'static str = "damped_oscillator";
    const VERSION: &'static str = "1.0";
    type State = [f64; 2];

    fn load(_resources: &Resources) -> Result<Self, String> {
        Ok(Oscillator { m: 1.0, c: 0.5, k: 10.0, f: 0.0, x: 0.0, v: 0.0, x0: 1.0 })
    }

    fn description(&self) -> Description {
        Description {
            model_name: "DampedOscillator".into(),
            text: "A mass on a spring and a damper, pushed by a force".into(),
            stop: 10.0,
            ..Description::default()
        }
    }

    fn variables(&self) -> Vec<Variable> {
        vec![
            Real::time(),
            Real::parameter("m", "kg", "Mass", |o| from_mut(&mut o.m)).above(0.0),
            Real::parameter("c", "N.s/m", "Damping", |o| from_mut(&mut o.c)).at_least(0.0),
            Real::parameter("k", "N/m", "Stiffness", |o| from_mut(&mut o.k)).above(0.0),
            Real::parameter("x0", "m", "Initial position", |o| from_mut(&mut o.x0)),
            Real::input("f", "N", "Force, held over a step", |o| from_mut(&mut o.f)),
            Real::output("x", "m", "Position", |o| from_ref(&o.x)).depends_on(&[]),
            Real::output("v", "m/s", "Velocity", |o| from_ref(&o.v)).depends_on(&[]),
        ]
    }

    fn initialise(&mut self, _start: f64, _log: &Log) -> Result<(), String> {
        (self.x, self.v) = (self.x0, 0.0);
        Ok(())
    }

    /// With y = x - F/k, a = c/(2m) and w² = k/m - a²: y(h) = e^(-ah) [(cos wh + a sin(wh)/w) y + sin(wh)/w v],
    /// and hyperbolic functions where w² < 0.
    fn step(&mut self, _t: f64, h: f64, _log: &Log) -> Result<(), String> {
        let a = self.c / (2.0 * self.m);
        let w2 = self.k / self.m - a * a;
        let w = w2.abs().sqrt();
        let (cos, sin_by_w) = match w {
            0.0 => (1.0, h),
            _ if w2 > 0.0 => ((w * h).cos(), (w * h).sin() / w),
            _ => ((w * h).cosh(), (w * h).sinh() / w),
        };
        let rest = self.f / self.k;
        let y = self.x - rest;
        let decay = (-a * h).exp();
        self.x = rest + decay * ((cos + a * sin_by_w) * y + sin_by_w * self.v);
        self.v = decay * (-self.k / self.m * sin_by_w * y + (cos - a * sin_by_w) * self.v);
        Ok(())
    }

    fn save(&self) -> Self::State {
        [self.x, self.v]
    }

    fn restore(&mut self, state: &Self::State) -> Result<(), String> {
        [self.x, self.v] = *state;
        Ok(())
    }
}

nervure_fmi_export::export_fmu!(Oscillator);
