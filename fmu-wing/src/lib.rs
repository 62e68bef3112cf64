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

const BUILT: &str = "an instance has a solver";

/// The unit of a wing.
pub struct WingUnit {
    scene: Scene,
    own: scene::Wing,
    parameters: Parameters,
    /// Parameters of the wing that is built of them.
    rest: wing::Parameters,
    /// Loads of the next step.
    loads: Loads,
    /// None in a description.
    wing: Option<Wing>,
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
    fn new(scene: Scene, own: scene::Wing) -> Result<Self, String> {
        let rest = from_scene::parameters(&own, scene.fluid.as_ref());
        let nodes = rest.mesh.nodes.len();
        require_memory(BYTES_PER_NODE * nodes)?;
        rest.check().map_err(|e| e.to_string())?;
        let distance =
            |k: &usize| -> f64 { rest.mesh.nodes[*k].iter().zip(own.pivot).map(|(x, o)| (x - o).powi(2)).sum() };
        let wing::Parameters { gravity, relaxation_time, displaced_density, .. } = rest;
        Ok(Self {
            tip: (0..nodes).max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0),
            parameters: Parameters {
                membrane: rest.membranes.first().copied(),
                gravity,
                relaxation_time,
                displaced_density,
            },
            loads: Loads { force: vec![0.0; 3 * nodes], impedance: vec![0.0; nodes], ..Loads::default() },
            energy: Energy::default(),
            damping_power: 0.0,
            crossings: 0,
            wing: None,
            rest,
            scene,
            own,
        })
    }

    /// Return the number of nodes.
    fn nodes(&self) -> usize {
        self.rest.mesh.nodes.len()
    }

    fn wing(&self) -> &Wing {
        self.wing.as_ref().expect(BUILT)
    }

    fn wing_mut(&mut self) -> &mut Wing {
        self.wing.as_mut().expect(BUILT)
    }

    /// Rebuild the wing if its parameters changed.
    fn apply(&mut self) -> Result<(), Error> {
        let Parameters { membrane, gravity, relaxation_time, displaced_density } = self.parameters;
        let known = &self.rest;
        if known.membranes.first().copied() == membrane
            && (known.gravity, known.relaxation_time, known.displaced_density)
                == (gravity, relaxation_time, displaced_density)
        {
            return Ok(());
        }
        let mut rest = wing::Parameters { gravity, relaxation_time, displaced_density, ..known.clone() };
        rest.membranes.iter_mut().zip(membrane).for_each(|(own, membrane)| *own = membrane);
        self.set_wing(rest.clone().build()?);
        self.rest = rest;
        Ok(())
    }

    fn set_wing(&mut self, mut wing: Wing) {
        wing.loads = self.loads.clone();
        self.wing = Some(wing);
    }

    /// Place the wing at rest on its base, in the state of the base at time `t`, if the base moves.
    fn place(&mut self, t: f64) -> Result<(), Error> {
        match &self.own.root_motion {
            Some(laws) => self.wing.as_mut().expect(BUILT).place(from_scene::pose(laws, t)),
            None => Ok(()),
        }
    }

    /// Compute what several outputs read, or what a step may fail to give.
    fn copy_to_outputs(&mut self) -> Result<(), Error> {
        let wing = self.wing.as_mut().expect(BUILT);
        self.energy = wing.energy()?;
        self.crossings = wing.crossings();
        self.damping_power = if self.parameters.relaxation_time > 0.0 { wing.damping_power()? } else { 0.0 };
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
        Self::new(scene, own)
    }

    fn build(&mut self) -> Result<(), String> {
        self.set_wing(self.rest.clone().build().map_err(|e| e.to_string())?);
        self.place(0.0).and_then(|()| self.copy_to_outputs()).map_err(|e| e.to_string())
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
        log.info(format_args!("{} nodes, start at t = {start} s", self.nodes()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String> {
        let span = || format!("in the step from t = {t} s to {} s", t + h);
        let wing = self.wing.as_mut().expect(BUILT);
        wing.base_motion = self.own.root_motion.as_ref().map(|laws| from_scene::pose(laws, t + h));
        wing.loads.copy_from(&self.loads);
        wing.step(h).and_then(|()| self.copy_to_outputs()).map_err(|e| format!("{e}, {}", span()))?;
        let Statistics { iterations, substeps, halvings, rescues, .. } = self.wing().statistics();
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
        STATE_BYTES_PER_NODE * self.nodes()
    }

    fn save(&self) -> wing::WingState {
        self.wing().state().clone()
    }

    fn restore(&mut self, state: &wing::WingState) -> Result<(), String> {
        self.apply().map_err(|e| e.to_string())?;
        self.wing_mut().restore(state).and_then(|()| self.copy_to_outputs()).map_err(|e| e.to_string())
    }
}

fmi_export::export_fmu!(WingUnit);
fmi_export::export_text!(fmu_scene_check = scene::check_text);
fmi_export::export_text!(fmu_scene_facts = |text, _| scene::facts_text(text));
fmi_export::export_text!(fmu_scene_monitor = scene::monitor_text);
