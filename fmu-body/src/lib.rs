//! FMI co-simulation unit of a free rigid body that carries wings and rods at driven hinges.

mod touch;
mod unit;
mod variables;

use fmi_export::{Description, Log, Model, Resources, Variable};

use unit::{BodyUnit, UnitState};

impl Model for BodyUnit {
    const IDENTIFIER: &'static str = "fmu_body";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = adapter::RESOURCES;
    type State = UnitState;

    fn load(resources: &Resources) -> Result<Self, String> {
        Self::new(adapter::scene_of(resources)?)
    }

    fn build(&mut self) -> Result<(), String> {
        BodyUnit::build(self)
    }

    fn description(&self) -> Description {
        adapter::description(
            &self.scene,
            format!("{}.body", self.scene.name),
            "Free rigid body with driven hinges, implicit with what it carries",
        )
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        variables::list(self)
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.start(start)?;
        log.info(format_args!("{} hinges, start at t = {start} s", self.hinges.len()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, _: &Log) -> Result<(), String> {
        self.advance(t, h).map_err(|e| format!("{e}, {}", adapter::span(t, h)))
    }

    fn save(&self) -> UnitState {
        BodyUnit::save(self)
    }

    fn restore(&mut self, state: &UnitState) -> Result<(), String> {
        BodyUnit::restore(self, state)
    }
}

adapter::export_unit!(BodyUnit);
