//! The fluid as an FMI co-simulation unit.

mod flow;
mod parameters;
mod variables;

use adapter::{either, of_both};
use fmi_export::{Description, Log, Model, Resources, Variable};
use scene::Scene;

use flow::{Flow, FlowState};
use parameters::Parameters;

/// The fluid of a scene.
struct FluidUnit {
    scene: Scene,
    parameters: Parameters,
    flow: Flow,
    /// Whether it has warned of loads that do not hold.
    has_warned: bool,
    /// Number of fast meetings of which it has warned.
    warned_meetings: usize,
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
        checked.and_then(|()| either!(&mut self.flow, flow => flow.change(&self.scene))).inspect_err(|_| {
            own.apply(self.scene.fluid.as_mut().expect("it was there"));
        })
    }
}

impl Model for FluidUnit {
    const IDENTIFIER: &'static str = "fmu_fluid";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = adapter::RESOURCES;
    const STATE_LAYOUT: u32 = 11;
    type State = FlowState;

    fn load(resources: &Resources) -> Result<Self, String> {
        let mut scene = adapter::scene_of(resources)?;
        // The variables are those of this load: no parameter chooses another.
        if let load @ Some(_) = scene.load() {
            scene.coupling.get_or_insert_default().load = load;
        }
        let flow = flow::of_scene(&scene)?;
        let part = scene.fluid.as_ref().expect("a flow is refused without a fluid");
        let parameters = Parameters::of(part);
        Ok(Self { parameters, scene, flow, has_warned: false, warned_meetings: 0 })
    }

    fn build(&mut self) -> Result<(), String> {
        either!(&mut self.flow, flow => flow.build())
    }

    fn description(&self) -> Description {
        adapter::description(
            &self.scene,
            format!("{}.fluid", self.scene.name),
            "Incompressible flow by a Fourier pseudo-spectral method with volume penalization",
        )
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        variables::of(self)
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.set_parameters(self.parameters)?;
        either!(&mut self.flow, flow => flow.start_at(start)).map_err(|e| e.to_string())?;
        let cells =
            either!(&self.flow, flow => flow.cells()).iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
        log.info(format_args!(
            "{cells} cells, {} stations, start at t = {start} s",
            either!(&self.flow, flow => flow.nodes())
        ));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String> {
        if !self.has_warned && either!(&self.flow, flow => flow.outlives_loads(h)) {
            self.has_warned = true;
            log.warn(format_args!(
                "the communication step of {h:.3e} s at t = {t:.6e} s is longer than the output `longest_step`: the loads \
                 `force_x`, `force_y` with their `impedance` hold for one step of the fluid, `pressure_jump` for any"
            ));
        }
        either!(&mut self.flow, flow => flow.advance(t, h)).map_err(|e| e.to_string())?;
        let fast = either!(&self.flow, flow => flow.solver().fast_meetings());
        fast.iter().skip(self.warned_meetings).for_each(|own| log.warn(self.scene.warning_of(own, t + h)));
        self.warned_meetings = fast.len();
        Ok(())
    }

    fn state_bytes(&self) -> usize {
        either!(&self.flow, flow => flow.solver().state_bytes())
    }

    fn save(&self) -> FlowState {
        of_both!(&self.flow, flow => flow.solver().state())
    }

    fn restore(&mut self, state: &FlowState) -> Result<(), String> {
        self.set_parameters(self.parameters)?;
        adapter::restore!(&mut self.flow, state, flow => flow.solver_mut())
    }

    /// Return `vorticity`, `u`, `v` or `p`, in SI units, x the slow axis; in three dimensions also `w` and
    /// `vorticity_x`, `vorticity_y`, and the component along z as `vorticity`. With `fine.` in front they are those in the
    /// fine box.
    fn field(&mut self, name: &str) -> Option<(Vec<usize>, Vec<f64>)> {
        either!(&mut self.flow, flow => flow.field(name))
    }
}

adapter::export_unit!(FluidUnit);
