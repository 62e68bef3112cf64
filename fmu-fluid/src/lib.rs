//! The fluid as an FMI 2.0 co-simulation unit: the list of its variables and its step.

use std::path::Path;
use std::slice::{from_mut, from_ref};

use fluid::{Exchange, Fluid, Force, Stations};
use fmi2::{Description, Log, Model};
use scene::{Mask, Scene};
use serde::{Deserialize, Serialize};

type Real = fmi2::Real<FluidUnit>;
type Variable = fmi2::Variable<FluidUnit>;

/// The fluid of a scene.
struct FluidUnit {
    scene: Scene,
    parameters: Parameters,
    fluid: Fluid,
    force: [f64; 2],
    /// Forces on the cylinders and on the beam.
    forces: Vec<Force>,
    /// What the fluid did to the beam.
    exchange: Exchange,
    cfl: f64,
    flow_rate: f64,
    /// What is made only when it is asked for.
    asked: f64,
}

/// What a master may change before the start without another scene file.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Parameters {
    density: f64,
    kinematic_viscosity: f64,
    c_eta: f64,
    max_step: f64,
    max_cfl: f64,
}

#[derive(Clone, Serialize, Deserialize)]
struct State {
    parameters: Parameters,
    stations: Option<Stations>,
    fluid: fluid::State,
}

impl Parameters {
    fn of(fluid: &scene::Fluid) -> Self {
        Self {
            density: fluid.density,
            kinematic_viscosity: fluid.kinematic_viscosity,
            c_eta: fluid.mask.c_eta(),
            max_step: fluid.time_stepping.max_step,
            max_cfl: fluid.time_stepping.max_cfl,
        }
    }

    fn apply(&self, fluid: &mut scene::Fluid) {
        fluid.density = self.density;
        fluid.kinematic_viscosity = self.kinematic_viscosity;
        let (Mask::Sharp { c_eta, .. } | Mask::Cosine { c_eta, .. } | Mask::LogLinear { c_eta, .. }) = &mut fluid.mask;
        *c_eta = self.c_eta;
        fluid.time_stepping.max_step = self.max_step;
        fluid.time_stepping.max_cfl = self.max_cfl;
    }
}

impl FluidUnit {
    fn stations(&mut self) -> &mut Stations {
        self.fluid.stations_mut().expect("a scene without a beam has no variable of its stations")
    }

    fn loads(&self) -> &fluid::Loads {
        self.fluid.loads().expect("a scene without the momentum load has no variable of it")
    }

    /// Make the solver anew if a parameter is not the one that it was made with.
    fn set_parameters(&mut self, parameters: Parameters) -> Result<(), String> {
        self.parameters = parameters;
        let part = self.scene.fluid.as_mut().expect("loading refuses a scene without a fluid");
        let own = Parameters::of(part);
        if own == parameters {
            return Ok(());
        }
        parameters.apply(part);
        let renewed = self.scene.check().map_err(|e| e.to_string());
        match renewed.and_then(|()| Fluid::new(&self.scene).map_err(|e| e.to_string())) {
            Ok(fluid) => self.fluid = fluid,
            Err(message) => {
                own.apply(self.scene.fluid.as_mut().expect("it was there"));
                return Err(message);
            }
        }
        Ok(())
    }

    fn publish(&mut self) {
        self.force = self.fluid.force();
        let cylinders = self.scene.fluid.as_ref().map_or(0, |fluid| fluid.cylinders.len());
        self.forces.clear();
        self.forces.extend((0..cylinders).map(|cylinder| self.fluid.force_on_cylinder(cylinder)));
        self.forces.extend(self.fluid.force_on_beam());
        self.exchange = self.fluid.exchange().unwrap_or_default();
        self.cfl = self.fluid.cfl();
        self.flow_rate = self.fluid.flow_rate();
    }

    /// A value that is made when it is asked for.
    fn ask(&mut self, make: impl FnOnce(&mut Fluid) -> f64) -> &[f64] {
        self.asked = make(&mut self.fluid);
        from_ref(&self.asked)
    }

    /// What the fluid did to the beam in the last step, to be compared with what the rod took.
    fn exchange_variables() -> [Variable; 4] {
        let sum = |axis| format!("Sum of what the fluid exerted on the stations along {axis}: no unsteady term");
        let power = "Power of what the fluid exerted on the stations, at the end of the step";
        let work = "Its work since the start: the sum of power times step";
        [
            Real::output("beam.load_x", "N/m", sum("x"), |m| from_ref(&m.exchange.force[0])),
            Real::output("beam.load_y", "N/m", sum("y"), |m| from_ref(&m.exchange.force[1])),
            Real::output("beam.power", "W/m", power, |m| from_ref(&m.exchange.power)),
            Real::output("beam.work", "J/m", work, |m| from_ref(&m.exchange.work)),
        ]
        .map(|variable| variable.depends_on(&[]))
    }

    /// Drag, lift and moment of body `number` (the cylinders, then the beam) under a name.
    fn force_variables(number: usize, name: &str, body: &str, point: &str) -> [Variable; 3] {
        let text = |axis| format!("Force of the fluid on {body} along {axis}, per metre of depth");
        let moment = format!("Moment of the fluid on {body} about {point}, positive to the left, per metre of depth");
        [
            Real::output(format!("{name}.drag"), "N/m", text("x"), move |m| from_ref(&m.forces[number].force[0])),
            Real::output(format!("{name}.lift"), "N/m", text("y"), move |m| from_ref(&m.forces[number].force[1])),
            Real::output(format!("{name}.moment"), "N.m/m", moment, move |m| from_ref(&m.forces[number].moment)),
        ]
        .map(|variable| variable.depends_on(&[]))
    }
}

impl Model for FluidUnit {
    const IDENTIFIER: &'static str = "fmu_fluid";
    type State = State;

    fn load(resources: Option<&Path>) -> Result<Self, String> {
        let resources = resources.ok_or("the fluid needs its resources folder with scene.json in it")?;
        let scene = Scene::from_file(&resources.join("scene.json")).map_err(|e| e.to_string())?;
        let fluid = Fluid::new(&scene).map_err(|e| e.to_string())?;
        let part = scene.fluid.as_ref().expect("Fluid::new refuses a scene without a fluid");
        let parameters = Parameters::of(part);
        let mut unit = Self {
            parameters,
            scene,
            fluid,
            force: [0.0; 2],
            forces: Vec::new(),
            exchange: Exchange::default(),
            cfl: 0.0,
            flow_rate: 0.0,
            asked: 0.0,
        };
        unit.publish();
        Ok(unit)
    }

    fn description(&self) -> Description {
        Description {
            model_name: format!("{}.fluid", self.scene.name),
            text: "Incompressible flow by a Fourier pseudo-spectral method with volume penalization".into(),
            start: 0.0,
            stop: self.scene.time.end,
            step: self.scene.time.communication_step,
            tolerance: 1e-6,
        }
    }

    fn variables(&self) -> Vec<Variable> {
        let mut list = vec![
            Real::time(),
            Real::parameter("density", "kg/m3", "Density", |m| from_mut(&mut m.parameters.density)).above(0.0),
            Real::parameter("kinematic_viscosity", "m2/s", "Kinematic viscosity", |m| {
                from_mut(&mut m.parameters.kinematic_viscosity)
            })
            .above(0.0),
            Real::parameter("c_eta", "s", "Relaxation time of the fluid inside solids", |m| {
                from_mut(&mut m.parameters.c_eta)
            })
            .above(0.0),
            Real::parameter("max_step", "s", "Largest step of the fluid's own", |m| {
                from_mut(&mut m.parameters.max_step)
            })
            .above(0.0),
            Real::parameter("max_cfl", "1", "Largest CFL number max(|u|/dx + |v|/dy) dt", |m| {
                from_mut(&mut m.parameters.max_cfl)
            })
            .above(0.0),
            Real::output("cfl", "1", "CFL number of the last step", |m| from_ref(&m.cfl)).depends_on(&[]),
            Real::output("flow_rate", "m2/s", "Flow rate through the middle of the box per metre of depth", |m| {
                from_ref(&m.flow_rate)
            })
            .depends_on(&[]),
            Real::local("kinetic_energy", "J/m", "Kinetic energy of the whole box per metre of depth", |m| {
                m.ask(|fluid| fluid.kinetic_energy())
            }),
            Real::local("enstrophy", "m2/s2", "Half the integral of the squared vorticity over the whole box", |m| {
                m.ask(|fluid| fluid.enstrophy())
            }),
            Real::local("divergence", "1", "Largest divergence times the cell size over the largest speed", |m| {
                m.ask(Fluid::divergence)
            }),
        ];
        let part = self.scene.fluid.as_ref().expect("loading refuses a scene without a fluid");
        if !part.cylinders.is_empty() || self.scene.beam.is_some() {
            let text =
                |axis| format!("Force of the fluid on all cylinders and the beam along {axis}, per metre of depth");
            list.push(Real::output("drag", "N/m", text("x"), |m| from_ref(&m.force[0])).depends_on(&[]));
            list.push(Real::output("lift", "N/m", text("y"), |m| from_ref(&m.force[1])).depends_on(&[]));
        }
        for number in 0..part.cylinders.len() {
            let name = format!("cylinder[{}]", number + 1);
            list.extend(Self::force_variables(number, &name, &format!("cylinder {}", number + 1), "its centre"));
        }
        if self.scene.beam.is_some() {
            list.extend(Self::force_variables(part.cylinders.len(), "beam", "the beam", "its root"));
            list.extend(Self::exchange_variables());
        }
        for (k, probe) in part.probes.iter().enumerate() {
            let name = format!("probe.{}", probe.name);
            let [x, y] = probe.position;
            let text = |what| format!("{what} at ({x}, {y})");
            list.extend(
                [
                    Real::output(format!("{name}.u"), "m/s", text("Velocity along x"), move |m| {
                        m.ask(|fluid| fluid.probe_velocity(k)[0])
                    }),
                    Real::output(format!("{name}.v"), "m/s", text("Velocity along y"), move |m| {
                        m.ask(|fluid| fluid.probe_velocity(k)[1])
                    }),
                    Real::output(format!("{name}.p"), "Pa", text("Static pressure"), move |m| {
                        m.ask(|fluid| fluid.probe_pressure(k))
                    }),
                ]
                .map(|variable| variable.depends_on(&[])),
            );
        }
        if let Some(stations) = self.fluid.stations() {
            let n = stations.len();
            list.extend([
                Real::input("x", "m", "Position of the stations at the end of the step", |m| {
                    &mut m.stations().position[0]
                })
                .array(n),
                Real::input("y", "m", "Position of the stations at the end of the step", |m| {
                    &mut m.stations().position[1]
                })
                .array(n),
                Real::input("vx", "m/s", "Velocity of the stations at the end of the step", |m| {
                    &mut m.stations().velocity[0]
                })
                .array(n),
                Real::input("vy", "m/s", "Velocity of the stations at the end of the step", |m| {
                    &mut m.stations().velocity[1]
                })
                .array(n),
                Real::output("pressure_jump", "Pa", "Pressure above minus below the beam", |m| {
                    m.fluid.pressure_jump().unwrap_or_default()
                })
                .array(n)
                .depends_on(&[]),
            ]);
            if self.fluid.loads().is_some() {
                list.extend([
                    Real::output("force_x", "N/m", "Load on the stations for the coming step", |m| &m.loads().force[0])
                        .array(n)
                        .depends_on(&[]),
                    Real::output("force_y", "N/m", "Load on the stations for the coming step", |m| &m.loads().force[1])
                        .array(n)
                        .depends_on(&[]),
                    Real::output(
                        "impedance",
                        "kg/(m.s)",
                        "Rate at which the load falls with the station's velocity",
                        |m| &m.loads().impedance,
                    )
                    .array(n)
                    .depends_on(&[]),
                ]);
            }
        }
        list
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.set_parameters(self.parameters)?;
        self.publish();
        let (grid, stations) = (self.fluid.grid(), self.fluid.stations().map_or(0, Stations::len));
        log.info(format_args!("{} x {} cells, {stations} stations, start at t = {start} s", grid.nx, grid.ny));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, _log: &Log) -> Result<(), String> {
        self.fluid.advance(t, h).map_err(|e| e.to_string())?;
        self.publish();
        Ok(())
    }

    fn save(&self) -> State {
        State {
            parameters: self.parameters,
            stations: self.fluid.stations().cloned(),
            fluid: self.fluid.state().clone(),
        }
    }

    fn restore(&mut self, state: &State) -> Result<(), String> {
        self.set_parameters(state.parameters)?;
        self.fluid.restore(&state.fluid).map_err(|e| e.to_string())?;
        if let Some(stations) = self.fluid.stations_mut() {
            match &state.stations {
                Some(known) if known.has_shape_of(stations) => stations.copy_from(known),
                _ => return Err("its stations are not as many as those of this beam".into()),
            }
        }
        self.publish();
        Ok(())
    }

    /// `vorticity`, `u`, `v` and `p`, in SI units, x the slow axis.
    fn field(&mut self, name: &str) -> Option<([usize; 2], Vec<f64>)> {
        let values = match name {
            "vorticity" => self.fluid.vorticity().to_vec(),
            "u" => self.fluid.velocity(0).to_vec(),
            "v" => self.fluid.velocity(1).to_vec(),
            "p" => self.fluid.pressure(),
            _ => return None,
        };
        let grid = self.fluid.grid();
        Some(([grid.nx, grid.ny], values))
    }
}

fmi2::export_fmu!(FluidUnit);
