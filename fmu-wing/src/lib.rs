//! FMI co-simulation unit of the elastic wing.

mod from_scene;
mod variables;

use fmi_export::{Description, Log, Model, Resources, Variable, require_memory};
use scene::Scene;
use wing::{Energy, Error, Loads, Membrane, Statistics, Wing};

/// Memory of a wing with its matrix, rounded up, bytes per node of a large mesh.
const BYTES_PER_NODE: usize = 20_000;
/// Memory of a copy of the state, rounded up, bytes per node.
const STATE_BYTES_PER_NODE: usize = 300;

/// The unit of a wing.
pub struct WingUnit {
    scene: Scene,
    own: scene::Wing,
    parameters: Parameters,
    wing: Wing,
    energy: Energy,
    damping_power: f64,
    crossings: usize,
    /// Node farthest from the pivot at rest.
    tip: usize,
}

/// Parameters that a master may set before the start.
#[derive(Clone, Copy)]
pub struct Parameters {
    /// The one outside regions; absent for veins alone.
    membrane: Option<Membrane>,
    gravity: [f64; 3],
    relaxation_time: f64,
    displaced_density: f64,
}

impl WingUnit {
    fn new(scene: Scene, own: scene::Wing) -> Result<Self, Error> {
        let parameters = from_scene::parameters(&own, scene.fluid.as_ref())?;
        let nodes = parameters.mesh.nodes.len();
        let distance =
            |k: &usize| -> f64 { parameters.mesh.nodes[*k].iter().zip(own.pivot).map(|(x, o)| (x - o).powi(2)).sum() };
        let tip = (0..nodes).max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
        let membrane = parameters.membranes.first().copied();
        let wing::Parameters { gravity, relaxation_time, displaced_density, .. } = parameters;
        let mut wing = parameters.build()?;
        wing.loads = Loads { force: vec![0.0; 3 * nodes], impedance: vec![0.0; nodes], ..Loads::default() };
        let mut unit = Self {
            parameters: Parameters { membrane, gravity, relaxation_time, displaced_density },
            energy: Energy::default(),
            damping_power: 0.0,
            crossings: 0,
            tip,
            scene,
            own,
            wing,
        };
        unit.place(0.0)?;
        unit.copy_to_outputs()?;
        Ok(unit)
    }

    /// Rebuild the wing if its parameters changed.
    fn apply(&mut self) -> Result<(), Error> {
        let Parameters { membrane, gravity, relaxation_time, displaced_density } = self.parameters;
        let mut parameters = self.wing.parameters().clone();
        if parameters.membranes.first().copied() == membrane
            && (parameters.gravity, parameters.relaxation_time, parameters.displaced_density)
                == (gravity, relaxation_time, displaced_density)
        {
            return Ok(());
        }
        parameters.membranes.iter_mut().zip(membrane).for_each(|(own, membrane)| *own = membrane);
        (parameters.gravity, parameters.relaxation_time) = (gravity, relaxation_time);
        parameters.displaced_density = displaced_density;
        let mut rebuilt = parameters.build()?;
        rebuilt.loads = std::mem::take(&mut self.wing.loads);
        rebuilt.base_motion = self.wing.base_motion;
        self.wing = rebuilt;
        Ok(())
    }

    /// Place the wing at rest on its base, in the state of the base at time `t`, if the base moves.
    fn place(&mut self, t: f64) -> Result<(), Error> {
        match &self.own.root_motion {
            Some(laws) => self.wing.place(from_scene::pose(laws, t)),
            None => Ok(()),
        }
    }

    /// Compute what several outputs read, or what a step may fail to give.
    fn copy_to_outputs(&mut self) -> Result<(), Error> {
        self.energy = self.wing.energy()?;
        self.crossings = self.wing.crossings();
        self.damping_power = if self.parameters.relaxation_time > 0.0 { self.wing.damping_power()? } else { 0.0 };
        Ok(())
    }
}

impl Model for WingUnit {
    const IDENTIFIER: &'static str = "fmu_wing";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = &["scene.json"];
    type State = wing::WingState;

    fn load(resources: &Resources) -> Result<Self, String> {
        let scene = Scene::from_json(resources.text("scene.json")?).map_err(|e| e.to_string())?;
        let Some(own) = scene.wing.clone() else { return Err(format!("the scene {:?} has no wing", scene.name)) };
        let nodes = from_scene::parameters(&own, None).map_err(|e| e.to_string())?.mesh.nodes.len();
        require_memory(BYTES_PER_NODE * nodes)?;
        Self::new(scene, own).map_err(|e| e.to_string())
    }

    fn description(&self) -> Description {
        Description {
            model_name: format!("{}.wing", self.scene.name),
            text: "Elastic wing of veins and a membrane, implicit in time".into(),
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
        self.apply()
            .and_then(|()| self.place(start))
            .and_then(|()| self.copy_to_outputs())
            .map_err(|e| e.to_string())?;
        log.info(format_args!("{} nodes, start at t = {start} s", self.wing.nodes()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String> {
        let span = || format!("in the step from t = {t} s to {} s", t + h);
        self.wing.base_motion = self.own.root_motion.as_ref().map(|laws| from_scene::pose(laws, t + h));
        self.wing.step(h).and_then(|()| self.copy_to_outputs()).map_err(|e| format!("{e}, {}", span()))?;
        let Statistics { iterations, substeps, halvings, rescues, .. } = self.wing.statistics();
        if rescues > 0 || halvings > 0 {
            log.info(format_args!(
                "{rescues} solves needed a line search, {substeps} sub-steps after {halvings} halvings, {iterations} \
                 Newton iterations, {}",
                span()
            ));
        }
        Ok(())
    }

    fn state_bytes(&self) -> usize {
        STATE_BYTES_PER_NODE * self.wing.nodes()
    }

    fn save(&self) -> wing::WingState {
        self.wing.state().clone()
    }

    fn restore(&mut self, state: &wing::WingState) -> Result<(), String> {
        self.apply().map_err(|e| e.to_string())?;
        self.wing.restore(state).and_then(|()| self.copy_to_outputs()).map_err(|e| e.to_string())
    }
}

fmi_export::export_fmu!(WingUnit);
fmi_export::export_text!(fmu_scene_check = scene::check_text);
fmi_export::export_text!(fmu_scene_facts = |text, _| scene::facts_text(text));
fmi_export::export_text!(fmu_scene_monitor = scene::monitor_text);
