//! The fluid as an FMI co-simulation unit.

mod flow;
mod parameters;
mod space;
mod variables;

use std::slice::from_ref;

use fluid::{Fluid, Pose, Stations};
use fmi_export::{Description, Log, Model, Resources, Variable};
use scene::Scene;
use serde::{Deserialize, Serialize};

use flow::{Flow, FlowState};
use parameters::Parameters;

/// The fluid of a scene.
struct FluidUnit {
    scene: Scene,
    parameters: Parameters,
    flow: Flow,
    /// The last scalar that was read.
    scalar: f64,
}

#[derive(Clone, Serialize, Deserialize)]
struct State {
    parameters: Parameters,
    stations: Vec<Stations>,
    nodes: Vec<Stations<3>>,
    displacements: Vec<Pose>,
    flow: FlowState,
}

impl FluidUnit {
    /// Make the solver again if a parameter has changed.
    fn set_parameters(&mut self, parameters: Parameters) -> Result<(), String> {
        self.parameters = parameters;
        let part = self.scene.fluid.as_mut().expect("loading refuses a scene without a fluid");
        let own = Parameters::of(part);
        if own == parameters {
            return Ok(());
        }
        parameters.apply(part);
        let checked = self.scene.check().map_err(|e| e.to_string());
        match checked.and_then(|()| Flow::new(&self.scene)) {
            Ok(mut flow) => {
                flow.stations_mut().iter_mut().zip(self.flow.stations()).for_each(|(own, set)| own.copy_from(set));
                flow.nodes_mut().iter_mut().zip(self.flow.nodes()).for_each(|(own, set)| own.copy_from(set));
                flow.displacements_mut().copy_from_slice(self.flow.displacements());
                self.flow = flow;
            }
            Err(message) => {
                own.apply(self.scene.fluid.as_mut().expect("it was there"));
                return Err(message);
            }
        }
        Ok(())
    }

    /// Read a scalar of a fluid of two dimensions.
    fn read(&mut self, read: impl FnOnce(&mut Fluid) -> f64) -> &[f64] {
        self.scalar = read(self.flow.plane());
        from_ref(&self.scalar)
    }

    /// Read a scalar of a fluid of three dimensions.
    fn read_space(&mut self, read: impl FnOnce(&mut fluid::space::Fluid) -> f64) -> &[f64] {
        self.scalar = read(self.flow.space());
        from_ref(&self.scalar)
    }
}

impl Model for FluidUnit {
    const IDENTIFIER: &'static str = "fmu_fluid";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = &["scene.json"];
    const STATE_LAYOUT: u32 = 5;
    type State = State;

    fn load(resources: &Resources) -> Result<Self, String> {
        let scene = Scene::from_json(resources.text("scene.json")?).map_err(|e| e.to_string())?;
        let flow = Flow::new(&scene)?;
        let part = scene.fluid.as_ref().expect("a flow is refused without a fluid");
        let parameters = Parameters::of(part);
        Ok(Self { parameters, scene, flow, scalar: 0.0 })
    }

    fn description(&self) -> Description {
        Description {
            model_name: format!("{}.fluid", self.scene.name),
            text: "Incompressible flow by a Fourier pseudo-spectral method with volume penalization".into(),
            author: "The nervure developers".into(),
            copyright: "Copyright (c) 2026 The nervure developers".into(),
            license: env!("CARGO_PKG_LICENSE").into(),
            stop: self.scene.time.end,
            step: self.scene.time.communication_step,
            ..Description::default()
        }
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        match &self.flow {
            Flow::Plane(_) => variables::of(self),
            Flow::Space(_) => space::variables(self),
        }
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.set_parameters(self.parameters)?;
        self.flow.start_at(start);
        let stations = self.flow.stations().iter().map(Stations::len).sum::<usize>()
            + self.flow.nodes().iter().map(Stations::len).sum::<usize>();
        log.info(format_args!("{} cells, {stations} stations, start at t = {start} s", self.flow.cells()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, _log: &Log) -> Result<(), String> {
        self.flow.advance(t, h).map_err(|e| e.to_string())
    }

    fn state_bytes(&self) -> usize {
        self.flow.state_bytes()
    }

    fn save(&self) -> State {
        State {
            parameters: self.parameters,
            stations: self.flow.stations().to_vec(),
            nodes: self.flow.nodes().to_vec(),
            displacements: self.flow.displacements().to_vec(),
            flow: self.flow.state(),
        }
    }

    fn restore(&mut self, state: &State) -> Result<(), String> {
        self.set_parameters(state.parameters)?;
        self.flow.restore(&state.flow)?;
        copy_stations(self.flow.stations_mut(), &state.stations)?;
        copy_stations(self.flow.nodes_mut(), &state.nodes)?;
        let (own, known) = (self.flow.displacements_mut(), &state.displacements);
        if own.len() != known.len() {
            return Err("its bodies are not as many as those of this fluid".into());
        }
        own.copy_from_slice(known);
        Ok(())
    }

    /// Return `vorticity`, `u`, `v` or `p`, in SI units, x the slow axis; in three dimensions also `w` and
    /// `vorticity_x`, `vorticity_y`, and the component along z as `vorticity`.
    fn field(&mut self, name: &str) -> Option<(Vec<usize>, Vec<f64>)> {
        self.flow.field(name)
    }
}

/// Copy the stations of a state.
fn copy_stations<const D: usize>(own: &mut [Stations<D>], known: &[Stations<D>]) -> Result<(), String> {
    if own.len() != known.len() || own.iter().zip(known).any(|(own, known)| !known.has_shape_of(own)) {
        return Err("its stations are not as many as those of this beam".into());
    }
    own.iter_mut().zip(known).for_each(|(own, known)| own.copy_from(known));
    Ok(())
}

fmi_export::export_fmu!(FluidUnit);
fmi_export::export_text!(fmu_scene_check = scene::check_text);
fmi_export::export_text!(fmu_scene_facts = |text, _| scene::facts_text(text));
fmi_export::export_text!(fmu_scene_monitor = scene::monitor_text);
