//! FMI co-simulation unit of a free rigid body that carries wings and rods at driven hinges.

mod unit;
mod variables;

use fmi_export::{Description, Log, Model, Resources, Variable};
use scene::Scene;

use unit::{BodyUnit, UnitState};

impl Model for BodyUnit {
    const IDENTIFIER: &'static str = "fmu_body";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = &["scene.json"];
    type State = UnitState;

    fn load(resources: &Resources) -> Result<Self, String> {
        Self::new(Scene::from_json(resources.text("scene.json")?).map_err(|e| e.to_string())?)
    }

    fn build(&mut self) -> Result<(), String> {
        BodyUnit::build(self);
        Ok(())
    }

    fn description(&self) -> Description {
        Description {
            model_name: format!("{}.body", self.scene.name),
            text: "Free rigid body with driven hinges, implicit with what it carries".into(),
            author: "The nervure developers".into(),
            copyright: "Copyright (c) 2026 The nervure developers".into(),
            license: env!("CARGO_PKG_LICENSE").into(),
            stop: self.scene.time.end,
            step: self.scene.time.communication_step,
            ..Description::default()
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        variables::list(self)
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.start(start);
        log.info(format_args!("{} hinges, start at t = {start} s", self.hinges.len()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, _: &Log) -> Result<(), String> {
        self.advance(t, h).map_err(|e| format!("{e}, in the step from t = {t} s to {} s", t + h))
    }

    fn save(&self) -> UnitState {
        BodyUnit::save(self)
    }

    fn restore(&mut self, state: &UnitState) -> Result<(), String> {
        BodyUnit::restore(self, state)
    }
}

fmi_export::export_fmu!(BodyUnit);
fmi_export::export_text!(fmu_scene_check = scene::check_text);
fmi_export::export_text!(fmu_scene_facts = |text, _| scene::facts_text(text));
fmi_export::export_text!(fmu_scene_monitor = scene::monitor_text);
