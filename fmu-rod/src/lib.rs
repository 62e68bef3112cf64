//! The elastic rod as an FMI 2.0 co-simulation unit: the list of its variables and its step.

use std::path::Path;
use std::slice::{from_mut, from_ref};

use fmi2::{Description, Log, Model};
use rod::{Error, Loads, Rod};
use scene::{Scene, Section};
use serde::{Deserialize, Serialize};

type Real = fmi2::Real<RodUnit>;
type Integer = fmi2::Integer<RodUnit>;
type Variable = fmi2::Variable<RodUnit>;

const AXES: [&str; 3] = ["x", "y", "z"];

/// The rod of a scene.
struct RodUnit {
    scene: Scene,
    parameters: Parameters,
    body: Body,
    tip_displacement: [f64; 3],
    tip_velocity: [f64; 3],
    elastic_energy: f64,
    kinetic_energy: f64,
    /// Newton iterations, sub-steps and negative pivots of the last step.
    newton: [i32; 3],
}

/// A rod in the plane or in space; neither carries what the other needs.
enum Body {
    Planar(Rod<2>),
    Spatial(Rod<3>),
}

/// The same expression for a rod of either kind.
macro_rules! either {
    ($body:expr, $rod:ident => $value:expr) => {
        match $body {
            Body::Planar($rod) => $value,
            Body::Spatial($rod) => $value,
        }
    };
}

/// What a master may change before the start without another scene file.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Parameters {
    section: Section,
    displaced_line_density: f64,
    damping: f64,
    gravity: [f64; 3],
}

#[derive(Clone, Serialize, Deserialize)]
struct State {
    parameters: Parameters,
    loads: Loads,
    rod: BodyState,
}

#[derive(Clone, Serialize, Deserialize)]
enum BodyState {
    Planar(rod::State<2>),
    Spatial(rod::State<3>),
}

impl Body {
    fn new(scene: &Scene, dimension: usize) -> Result<Self, Error> {
        Ok(match dimension {
            2 => Self::Planar(Rod::from_scene(scene)?),
            _ => Self::Spatial(Rod::from_scene(scene)?),
        })
    }

    fn loads(&mut self) -> &mut Loads {
        either!(self, rod => &mut rod.loads)
    }

    fn positions(&self, axis: usize) -> &[f64] {
        either!(self, rod => rod.positions(axis))
    }

    fn velocities(&self, axis: usize) -> &[f64] {
        either!(self, rod => rod.velocities(axis))
    }

    /// Component `axis` of the nodal forces.
    fn force(&mut self, axis: usize) -> &mut [f64] {
        let nodes = self.positions(0).len();
        &mut self.loads().force[axis * nodes..(axis + 1) * nodes]
    }

    fn step(&mut self, h: f64) -> Result<(), Error> {
        either!(self, rod => rod.step(h))
    }
}

impl Parameters {
    fn of<const D: usize>(rod: &Rod<D>) -> Self {
        let own = rod.parameters();
        Self {
            section: own.section,
            displaced_line_density: own.displaced,
            damping: own.damping,
            gravity: std::array::from_fn(|axis| own.gravity.get(axis).copied().unwrap_or(0.0)),
        }
    }

    /// The rod anew with these parameters, if they are not its own already.
    fn apply<const D: usize>(&self, rod: &mut Rod<D>) -> Result<(), Error> {
        if Self::of(rod) == *self {
            return Ok(());
        }
        let mut renewed = Rod::new(rod::Parameters {
            section: self.section,
            displaced: self.displaced_line_density,
            damping: self.damping,
            gravity: std::array::from_fn(|axis| self.gravity[axis]),
            ..rod.parameters().clone()
        })?;
        renewed.loads.clone_from(&rod.loads);
        *rod = renewed;
        Ok(())
    }
}

impl RodUnit {
    /// What the master reads after a step.
    fn publish(&mut self) -> Result<(), Error> {
        either!(&self.body, rod => {
            let tip = rod.positions(0).len() - 1;
            for (axis, displacement) in rod.tip_displacement().into_iter().enumerate() {
                self.tip_displacement[axis] = displacement;
                self.tip_velocity[axis] = rod.velocities(axis)[tip];
            }
            let energy = rod.energy()?;
            self.elastic_energy = energy.stretching + energy.bending;
            self.kinetic_energy = energy.kinetic;
            let statistics = rod.statistics();
            let count = |count: usize| i32::try_from(count).unwrap_or(i32::MAX);
            self.newton =
                [count(statistics.iterations), count(statistics.substeps), count(statistics.negative_pivots)];
        });
        Ok(())
    }
}

impl Model for RodUnit {
    const IDENTIFIER: &'static str = "fmu_rod";
    type State = State;

    fn load(resources: Option<&Path>) -> Result<Self, String> {
        let resources = resources.ok_or("the rod needs its resources folder with scene.json in it")?;
        let scene = Scene::from_file(&resources.join("scene.json")).map_err(|e| e.to_string())?;
        let dimension = scene.beam.as_ref().map_or(2, |beam| scene.dimension(beam));
        let body = Body::new(&scene, dimension).map_err(|e| e.to_string())?;
        Ok(Self {
            parameters: either!(&body, rod => Parameters::of(rod)),
            scene,
            body,
            tip_displacement: [0.0; 3],
            tip_velocity: [0.0; 3],
            elastic_energy: 0.0,
            kinetic_energy: 0.0,
            newton: [0; 3],
        })
    }

    fn description(&self) -> Description {
        Description {
            model_name: format!("{}.rod", self.scene.name),
            text: "Elastic mass-spring rod, clamped at its root, implicit in time".into(),
            start: 0.0,
            stop: self.scene.time.end,
            step: self.scene.time.communication_step,
            tolerance: 1e-6,
        }
    }

    fn variables(&self) -> Vec<Variable> {
        let (axes, loads, nodes) =
            either!(&self.body, rod => (rod.tip_displacement().len(), &rod.loads, rod.positions(0).len()));
        // In the plane everything is per metre of depth.
        let per = |unit: &str, planar: &str| if axes == 2 { planar.to_string() } else { unit.to_string() };
        let mut list = vec![
            Real::time(),
            Real::parameter("line_density", &per("kg/m", "kg/m2"), "Mass of the section per length", |m| {
                from_mut(&mut m.parameters.section.line_density)
            })
            .above(0.0),
            Real::parameter("bending_stiffness", &per("N.m2", "N.m"), "Bending stiffness EI", |m| {
                from_mut(&mut m.parameters.section.bending_stiffness)
            })
            .above(0.0),
            Real::parameter("axial_stiffness", &per("N", "N/m"), "Axial stiffness EA", |m| {
                from_mut(&mut m.parameters.section.axial_stiffness)
            })
            .above(0.0),
            Real::parameter("damping", &per("kg/(m.s)", "kg/(m2.s)"), "Damping force per length and velocity", |m| {
                from_mut(&mut m.parameters.damping)
            })
            .at_least(0.0),
        ];
        if !loads.impedance.is_empty() {
            list.push(
                Real::parameter("displaced_line_density", "kg/m2", "Mass of the displaced fluid per length", |m| {
                    from_mut(&mut m.parameters.displaced_line_density)
                })
                .at_least(0.0),
            );
        }
        let gravity: [fn(&mut Self) -> &mut [f64]; 3] = [
            |m| from_mut(&mut m.parameters.gravity[0]),
            |m| from_mut(&mut m.parameters.gravity[1]),
            |m| from_mut(&mut m.parameters.gravity[2]),
        ];
        let position: [fn(&mut Self) -> &[f64]; 3] =
            [|m| m.body.positions(0), |m| m.body.positions(1), |m| m.body.positions(2)];
        let velocity: [fn(&mut Self) -> &[f64]; 3] =
            [|m| m.body.velocities(0), |m| m.body.velocities(1), |m| m.body.velocities(2)];
        let tip_displacement: [fn(&mut Self) -> &[f64]; 3] = [
            |m| from_ref(&m.tip_displacement[0]),
            |m| from_ref(&m.tip_displacement[1]),
            |m| from_ref(&m.tip_displacement[2]),
        ];
        let tip_velocity: [fn(&mut Self) -> &[f64]; 3] =
            [|m| from_ref(&m.tip_velocity[0]), |m| from_ref(&m.tip_velocity[1]), |m| from_ref(&m.tip_velocity[2])];
        let force: [fn(&mut Self) -> &mut [f64]; 3] = [|m| m.body.force(0), |m| m.body.force(1), |m| m.body.force(2)];
        let axes = || AXES.iter().take(axes).enumerate();
        list.extend(axes().map(|(d, axis)| Real::parameter(format!("gravity.{axis}"), "m/s2", "Gravity", gravity[d])));
        if !loads.force.is_empty() {
            list.extend(axes().map(|(d, axis)| {
                Real::input(
                    format!("force_{axis}"),
                    &per("N", "N/m"),
                    "Load on the stations at the end of the step",
                    force[d],
                )
                .array(nodes)
            }));
        }
        list.push(
            Real::input("impedance", "kg/(m.s)", "Rate at which the load falls with the station's velocity", |m| {
                &mut m.body.loads().impedance
            })
            .at_least(0.0)
            .array(loads.impedance.len()),
        );
        list.push(
            Real::input("pressure_jump", "Pa", "Pressure above minus below the beam", |m| {
                &mut m.body.loads().pressure_jump
            })
            .array(loads.pressure_jump.len()),
        );
        list.extend(axes().map(|(d, axis)| {
            Real::output(*axis, "m", "Position of the stations", position[d]).array(nodes).depends_on(&[])
        }));
        list.extend(axes().map(|(d, axis)| {
            Real::output(format!("v{axis}"), "m/s", "Velocity of the stations", velocity[d])
                .array(nodes)
                .depends_on(&[])
        }));
        list.extend(axes().map(|(d, axis)| {
            Real::output(format!("tip.u{axis}"), "m", "Displacement of the tip", tip_displacement[d]).depends_on(&[])
        }));
        list.extend(axes().map(|(d, axis)| {
            Real::output(format!("tip.v{axis}"), "m/s", "Velocity of the tip", tip_velocity[d]).depends_on(&[])
        }));
        list.extend([
            Real::output("energy.elastic", &per("J", "J/m"), "Energy of extension and bending", |m| {
                from_ref(&m.elastic_energy)
            })
            .depends_on(&[]),
            Real::output("energy.kinetic", &per("J", "J/m"), "Kinetic energy of the rod's own mass", |m| {
                from_ref(&m.kinetic_energy)
            })
            .depends_on(&[]),
            Integer::output("newton.iterations", "Newton iterations of the last step", |m| from_ref(&m.newton[0]))
                .depends_on(&[]),
            Integer::output("newton.substeps", "Sub-steps of the last step", |m| from_ref(&m.newton[1]))
                .depends_on(&[]),
            Integer::output("newton.negative_pivots", "Negative pivots in the last step", |m| from_ref(&m.newton[2]))
                .depends_on(&[]),
        ]);
        list
    }

    fn initialise(&mut self, _start: f64, _log: &Log) -> Result<(), String> {
        either!(&mut self.body, rod => self.parameters.apply(rod)).map_err(|e| e.to_string())?;
        self.publish().map_err(|e| e.to_string())
    }

    fn step(&mut self, _t: f64, h: f64, _log: &Log) -> Result<(), String> {
        self.body.step(h).and_then(|()| self.publish()).map_err(|e| e.to_string())
    }

    fn save(&self) -> State {
        State {
            parameters: self.parameters,
            loads: either!(&self.body, rod => rod.loads.clone()),
            rod: match &self.body {
                Body::Planar(rod) => BodyState::Planar(rod.state().clone()),
                Body::Spatial(rod) => BodyState::Spatial(rod.state().clone()),
            },
        }
    }

    fn restore(&mut self, state: &State) {
        self.parameters = state.parameters;
        let result = either!(&mut self.body, rod => state.parameters.apply(rod)).and_then(|()| {
            self.body.loads().clone_from(&state.loads);
            match (&mut self.body, &state.rod) {
                (Body::Planar(rod), BodyState::Planar(state)) => rod.restore(state),
                (Body::Spatial(rod), BodyState::Spatial(state)) => rod.restore(state),
                _ => unreachable!("a state of this scene has its dimension"),
            }
        });
        result.and_then(|()| self.publish()).expect("a saved state was once a valid one");
    }
}

fmi2::export_fmu!(RodUnit);
