//! FMI co-simulation unit of the elastic rod.

mod body;
mod contact;
mod from_scene;
mod parameters;
mod unit;
mod variables;

use adapter::{Announced, Carried, either, of_both};
use fmi_export::{Description, Log, Model, Resources, Variable, require_memory};
use rod::{RootSupport, Statistics};

use body::BodyState;
use unit::RodUnit;

/// Memory of a rod in space with its scratch, rounded up, bytes per station.
const BYTES_PER_STATION: usize = 4000;
/// Memory of a copy of the state of a rod in space, rounded up, bytes per station.
const STATE_BYTES_PER_STATION: usize = 250;

impl Model for RodUnit {
    const IDENTIFIER: &'static str = "fmu_rod";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = adapter::RESOURCES;
    type State = BodyState;

    fn load(resources: &Resources) -> Result<Self, String> {
        let whole = adapter::scene_of(resources)?;
        let load = whole.chosen_load().map(|(load, reason)| [load.name().to_string(), reason]).unwrap_or_default();
        let scene = whole.of_unit().ok_or("the scene has several rods, but no key `this_rod` selects one of them")?;
        let (Some(beam), Some(rod)) = (scene.beam.clone(), scene.rod.clone()) else {
            return Err(format!("the scene {:?} has no beam with a rod", scene.name));
        };
        require_memory(BYTES_PER_STATION * (beam.segments + 1))?;
        let name = if whole.rods.is_empty() { format!("{}.rod", scene.name) } else { scene.name.clone() };
        let hinge = whole.hinge_of(whole.this_rod.as_deref().unwrap_or("rod"));
        Self::new(name, scene, (beam, rod), load, hinge).map_err(|e| e.to_string())
    }

    fn build(&mut self) -> Result<(), String> {
        RodUnit::build(self).map_err(|e| e.to_string())
    }

    fn description(&self) -> Description {
        let root = match self.support() {
            RootSupport::Clamped => "clamped at its root",
            RootSupport::Pinned => "pinned at its root",
            RootSupport::TorsionSpring { .. } => "on a torsion spring at its root",
            RootSupport::Free => "free at its root",
        };
        adapter::description(
            &self.scene,
            self.name.clone(),
            format!("Elastic mass-spring rod, {root}, implicit in time"),
        )
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        variables::list(self)
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.mark_stale();
        self.apply_parameters().map_err(|e| e.to_string())?;
        self.place(start).and_then(|()| self.copy_to_outputs()).map_err(|e| e.to_string())?;
        log.info(format_args!("{} stations, start at t = {start} s", self.stations()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String> {
        let span = || adapter::span(t, h);
        self.begin_step(h)?;
        RodUnit::step(self, t, h).map_err(|e| format!("{e}, {}", span()))?;
        let Statistics { iterations, substeps, halvings, rescues, negative_pivots, .. } =
            either!(self.body(), rod => rod.statistics());
        if rescues > 0 || negative_pivots > 0 || halvings > 0 {
            log.info(format_args!(
                "{rescues} solves needed shift and line search, {substeps} sub-steps after {halvings} halvings, \
                 {iterations} Newton iterations, {negative_pivots} negative pivots, {}",
                span()
            ));
        }
        Ok(())
    }

    fn state_bytes(&self) -> usize {
        STATE_BYTES_PER_STATION * self.stations()
    }

    fn fault(&self) -> Option<String> {
        self.announced.as_ref().and_then(Announced::fault)
    }

    fn save(&self) -> BodyState {
        of_both!(self.body(), rod => rod.state().clone())
    }

    fn restore(&mut self, state: &BodyState) -> Result<(), String> {
        self.mark_stale();
        self.apply_parameters().map_err(|e| e.to_string())?;
        adapter::restore!(self.body_mut(), state, rod => rod)?;
        self.copy_to_outputs().map_err(|e| e.to_string())
    }
}

adapter::export_unit!(RodUnit);
