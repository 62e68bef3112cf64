//! The fluid as an FMI co-simulation unit.

mod parameters;
mod variables;

use std::slice::from_ref;

use fluid::{Fluid, Pose, Stations};
use fmi_export::{Description, Log, Model, Resources, Variable, require_memory};
use scene::Scene;
use serde::{Deserialize, Serialize};

use parameters::Parameters;

/// The fluid of a scene.
struct FluidUnit {
    scene: Scene,
    parameters: Parameters,
    fluid: Fluid,
    /// The last scalar that was read.
    scalar: f64,
}

#[derive(Clone, Serialize, Deserialize)]
struct State {
    parameters: Parameters,
    stations: Vec<Stations>,
    displacements: Vec<Pose>,
    fluid: fluid::State,
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
        match checked.and_then(|()| new_fluid(&self.scene)) {
            Ok(mut fluid) => {
                fluid.stations_mut().iter_mut().zip(self.fluid.stations()).for_each(|(own, set)| own.copy_from(set));
                fluid.displacements_mut().copy_from_slice(self.fluid.displacements());
                self.fluid = fluid;
            }
            Err(message) => {
                own.apply(self.scene.fluid.as_mut().expect("it was there"));
                return Err(message);
            }
        }
        Ok(())
    }

    /// Read a scalar of the fluid.
    fn read(&mut self, read: impl FnOnce(&mut Fluid) -> f64) -> &[f64] {
        self.scalar = read(&mut self.fluid);
        from_ref(&self.scalar)
    }
}

/// Make the fluid of a scene; fails if there is no memory for it.
fn new_fluid(scene: &Scene) -> Result<Fluid, String> {
    let parameters = fluid::Parameters::try_from(scene).map_err(|e| e.to_string())?;
    require_memory(Fluid::bytes(&parameters))?;
    Fluid::new(&parameters).map_err(|e| e.to_string())
}

impl Model for FluidUnit {
    const IDENTIFIER: &'static str = "fmu_fluid";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = &["scene.json"];
    const STATE_LAYOUT: u32 = 3;
    type State = State;

    fn load(resources: &Resources) -> Result<Self, String> {
        let scene = Scene::from_json(resources.text("scene.json")?).map_err(|e| e.to_string())?;
        let fluid = new_fluid(&scene)?;
        let part = scene.fluid.as_ref().expect("new_fluid refuses a scene without a fluid");
        let parameters = Parameters::of(part);
        Ok(Self { parameters, scene, fluid, scalar: 0.0 })
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
        variables::of(self)
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.set_parameters(self.parameters)?;
        if start != self.fluid.time() {
            self.fluid.start_at(start);
        }
        let (grid, stations) = (self.fluid.grid(), self.fluid.stations().iter().map(Stations::len).sum::<usize>());
        log.info(format_args!(
            "{} x {} cells, {stations} stations, start at t = {start} s",
            grid.cells[0], grid.cells[1]
        ));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, _log: &Log) -> Result<(), String> {
        self.fluid.advance(t, h).map_err(|e| e.to_string())
    }

    fn state_bytes(&self) -> usize {
        self.fluid.state_bytes()
    }

    fn save(&self) -> State {
        State {
            parameters: self.parameters,
            stations: self.fluid.stations().to_vec(),
            displacements: self.fluid.displacements().to_vec(),
            fluid: self.fluid.state(),
        }
    }

    fn restore(&mut self, state: &State) -> Result<(), String> {
        self.set_parameters(state.parameters)?;
        self.fluid.restore(&state.fluid).map_err(|e| e.to_string())?;
        let (own, known) = (self.fluid.stations_mut(), &state.stations);
        if own.len() != known.len() || own.iter().zip(known).any(|(own, known)| !known.has_shape_of(own)) {
            return Err("its stations are not as many as those of this beam".into());
        }
        own.iter_mut().zip(known).for_each(|(own, known)| own.copy_from(known));
        let (own, known) = (self.fluid.displacements_mut(), &state.displacements);
        if own.len() != known.len() {
            return Err("its bodies are not as many as those of this fluid".into());
        }
        own.copy_from_slice(known);
        Ok(())
    }

    /// Return `vorticity`, `u`, `v` or `p`, in SI units, x the slow axis.
    fn field(&mut self, name: &str) -> Option<([usize; 2], Vec<f64>)> {
        let values = match name {
            "vorticity" => self.fluid.vorticity().into_owned(),
            "u" => self.fluid.velocity(0).into_owned(),
            "v" => self.fluid.velocity(1).into_owned(),
            "p" => self.fluid.pressure(),
            _ => return None,
        };
        Some((self.fluid.grid().cells, values))
    }
}

fmi_export::export_fmu!(FluidUnit);
fmi_export::export_text!(fmu_scene_check = scene::check_text);
fmi_export::export_text!(fmu_scene_facts = |text, _| scene::facts_text(text));
