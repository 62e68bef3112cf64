//! The elastic rod as an FMI co-simulation unit: the list of its variables and its step.

use std::slice::{from_mut, from_ref};

use fmi_export::{Description, Log, Model, Resources, require_memory};
use rod::{Energy, Error, Hold, Loads, Rod, Root, Statistics, Taper};
use scene::{RootMotion, Scene, Section};
use serde::{Deserialize, Serialize};

type Real = fmi_export::Real<RodUnit>;
type Integer = fmi_export::Integer<RodUnit>;
type Text = fmi_export::Text<RodUnit>;
type Variable = fmi_export::Variable<RodUnit>;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Memory of a rod with its scratch by station, and of a copy of its state, bytes: measured in space, and rounded up.
const BYTES_PER_STATION: usize = 4000;
const STATE_BYTES_PER_STATION: usize = 250;

/// The rod of a scene.
struct RodUnit {
    /// With this rod alone.
    scene: Scene,
    /// Whether it is one of several, whose name is in that of its scene.
    several: bool,
    parameters: Parameters,
    body: Body,
    /// Where the master wants the root at the end of the next step.
    root: RootInputs,
    /// Name of the load that the rod takes from a fluid, and why; empty without a fluid.
    load: [String; 2],
    energy: Energy,
    /// What is made only when it is asked for.
    asked: f64,
    counted: i32,
}

/// The root as inputs of a master that drives it.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
struct RootInputs {
    position: [f64; 3],
    velocity: [f64; 3],
    /// Angle of the direction from the x axis and its rate, in the plane.
    angle: f64,
    omega: f64,
    /// Direction and its rate, in space.
    direction: [f64; 3],
    direction_rate: [f64; 3],
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
    clamp_compliance_length: f64,
    gravity: [f64; 3],
}

#[derive(Clone, Serialize, Deserialize)]
struct State {
    parameters: Parameters,
    loads: Loads,
    root: RootInputs,
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

    fn statistics(&self) -> Statistics {
        either!(self, rod => rod.statistics())
    }
}

impl Parameters {
    fn of<const D: usize>(rod: &Rod<D>) -> Self {
        let own = rod.parameters();
        Self {
            section: own.section,
            displaced_line_density: own.displaced,
            damping: own.damping,
            clamp_compliance_length: own.clamp_compliance_length,
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
            clamp_compliance_length: self.clamp_compliance_length,
            gravity: std::array::from_fn(|axis| self.gravity[axis]),
            ..rod.parameters().clone()
        })?;
        renewed.loads.clone_from(&rod.loads);
        renewed.root = rod.root;
        *rod = renewed;
        Ok(())
    }
}

/// The first `D` components of position, velocity, direction and its rate.
fn root_of<const D: usize>(root: [[f64; 3]; 4]) -> Root<D> {
    let [position, velocity, direction, direction_rate] = root.map(|vector| std::array::from_fn(|d| vector[d]));
    Root { position, velocity, direction, direction_rate }
}

impl RodUnit {
    /// Bring up to date what more than one variable shows.
    fn publish(&mut self) -> Result<(), Error> {
        self.energy = either!(&self.body, rod => rod.energy()?);
        Ok(())
    }

    /// A value that is made when it is asked for.
    fn ask(&mut self, make: impl FnOnce(&Body) -> f64) -> &[f64] {
        self.asked = make(&self.body);
        from_ref(&self.asked)
    }

    /// A count of the last step.
    fn count(&mut self, of: impl FnOnce(Statistics) -> usize) -> &[i32] {
        self.counted = i32::try_from(of(self.body.statistics())).unwrap_or(i32::MAX);
        from_ref(&self.counted)
    }

    /// Number of space dimensions.
    fn dimension(&self) -> usize {
        either!(&self.body, rod => rod.tip_displacement().len())
    }

    /// A variable for each axis, made from its number and name.
    fn along_axes(&self, make: impl Fn(usize, &str) -> Variable) -> impl Iterator<Item = Variable> {
        AXES[..self.dimension()].iter().enumerate().map(move |(d, axis)| make(d, axis))
    }

    /// `unit` in space, `planar` in the plane, where everything is per metre of depth.
    fn per<'a>(&self, unit: &'a str, planar: &'a str) -> &'a str {
        if self.dimension() == 2 { planar } else { unit }
    }

    /// What a master may change before the start.
    fn parameters(&self) -> Vec<Variable> {
        let (loads, section) = either!(&self.body, rod => (&rod.loads, rod.parameters().section));
        let tapered = either!(&self.body, rod => rod.parameters().taper != Taper::default());
        let text = |text: &str| if tapered { format!("{text}, at the root") } else { text.to_string() };
        let mut list = vec![
            Real::parameter("line_density", self.per("kg/m", "kg/m2"), text("Mass of the section per length"), |m| {
                from_mut(&mut m.parameters.section.line_density)
            })
            .above(0.0),
            Real::parameter("bending_stiffness", self.per("N.m2", "N.m"), text("Bending stiffness EI"), |m| {
                from_mut(&mut m.parameters.section.bending_stiffness)
            })
            .above(0.0),
            Real::parameter("axial_stiffness", self.per("N", "N/m"), text("Axial stiffness EA"), |m| {
                from_mut(&mut m.parameters.section.axial_stiffness)
            })
            .above(0.0),
            Real::parameter(
                "damping",
                self.per("kg/(m.s)", "kg/(m2.s)"),
                "Damping force per length and velocity",
                |m| from_mut(&mut m.parameters.damping),
            )
            .at_least(0.0),
            Real::parameter("clamp_compliance_length", "m", "Length by which the clamp lies behind the root", |m| {
                from_mut(&mut m.parameters.clamp_compliance_length)
            })
            .at_least(0.0),
        ];
        if !loads.impedance.is_empty() {
            list.push(
                Real::parameter(
                    "displaced_line_density",
                    "kg/m2",
                    text("Mass of the displaced fluid per length"),
                    |m| from_mut(&mut m.parameters.displaced_line_density),
                )
                .at_least(0.0),
            );
        }
        if section.shear_stiffness.is_some() {
            list.push(
                Real::parameter("shear_stiffness", "N/m", text("Shear stiffness GA_s"), |m| {
                    m.parameters.section.shear_stiffness.as_mut_slice()
                })
                .above(0.0),
            );
        }
        list.extend(self.along_axes(|d, axis| {
            Real::parameter(format!("gravity.{axis}"), "m/s2", "Gravity", move |m| {
                from_mut(&mut m.parameters.gravity[d])
            })
        }));
        list
    }

    /// The loads on the stations, as far as the scene has them.
    fn load_inputs(&self) -> Vec<Variable> {
        let (loads, nodes) = either!(&self.body, rod => (&rod.loads, rod.positions(0).len()));
        let mut list = Vec::new();
        if !loads.force.is_empty() {
            let text = "Load on the stations at the end of the step";
            list.extend(self.along_axes(|d, axis| {
                Real::input(format!("force_{axis}"), self.per("N", "N/m"), text, move |m| m.body.force(d)).array(nodes)
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
        list.push(
            Real::input("pressure", "Pa", "Pressure around the beam", |m| &mut m.body.loads().pressure)
                .array(loads.pressure.len()),
        );
        list
    }

    /// The inputs of a master that drives the root.
    fn root_inputs(&self) -> Vec<Variable> {
        let mut list = Vec::new();
        list.extend(self.along_axes(|d, axis| {
            let text = "Position of the root at the end of the step";
            Real::input(format!("root.{axis}"), "m", text, move |m| from_mut(&mut m.root.position[d]))
        }));
        list.extend(self.along_axes(|d, axis| {
            let text = "Velocity of the root at the end of the step";
            Real::input(format!("root.v{axis}"), "m/s", text, move |m| from_mut(&mut m.root.velocity[d]))
        }));
        if self.hold() == Hold::Pinned {
            return list;
        }
        if self.dimension() == 2 {
            list.push(Real::input("root.angle", "rad", "Direction of the beam at the root, from the x axis", |m| {
                from_mut(&mut m.root.angle)
            }));
            list.push(Real::input("root.omega", "rad/s", "Rate of the direction at the root", |m| {
                from_mut(&mut m.root.omega)
            }));
            return list;
        }
        list.extend(self.along_axes(|d, axis| {
            let text = "Direction of the beam at the root, of any length";
            Real::input(format!("root.direction.{axis}"), "1", text, move |m| from_mut(&mut m.root.direction[d]))
        }));
        list.extend(self.along_axes(|d, axis| {
            let text = "Rate of the direction at the root";
            Real::input(format!("root.direction_rate.{axis}"), "1/s", text, move |m| {
                from_mut(&mut m.root.direction_rate[d])
            })
        }));
        list
    }

    /// Stations, tip, and what the loads did.
    fn station_outputs(&self) -> Vec<Variable> {
        let nodes = self.body.positions(0).len();
        let mut list = Vec::new();
        list.extend(self.along_axes(|d, axis| {
            Real::output(axis, "m", "Position of the stations", move |m| m.body.positions(d)).array(nodes)
        }));
        list.extend(self.along_axes(|d, axis| {
            let text = "Velocity of the stations";
            Real::output(format!("v{axis}"), "m/s", text, move |m| m.body.velocities(d)).array(nodes)
        }));
        list.extend(self.along_axes(|d, axis| {
            Real::output(format!("tip.u{axis}"), "m", "Displacement of the tip", move |m| {
                m.ask(|body| either!(body, rod => rod.tip_displacement()[d]))
            })
        }));
        list.extend(self.along_axes(|d, axis| {
            Real::output(format!("tip.v{axis}"), "m/s", "Velocity of the tip", move |m| {
                &m.body.velocities(d)[nodes - 1..]
            })
        }));
        list.extend(self.along_axes(|d, axis| {
            let text = format!("Sum along {axis} of the loads that the stations took at the end of the step");
            Real::output(
                format!("load.{axis}"),
                self.per("N", "N/m"),
                text,
                move |m| either!(&m.body, rod => from_ref(&rod.state().exchange.force[d])),
            )
        }));
        let power = "Power of the loads at the end of the step";
        let work = "Work of the loads since the start: the sum of power times step";
        list.extend([
            Real::output(
                "load.power",
                self.per("W", "W/m"),
                power,
                |m| either!(&m.body, rod => from_ref(&rod.state().exchange.power)),
            ),
            Real::output(
                "load.work",
                self.per("J", "J/m"),
                work,
                |m| either!(&m.body, rod => from_ref(&rod.state().exchange.work)),
            ),
        ]);
        list
    }

    /// How the root is held.
    fn hold(&self) -> Hold {
        either!(&self.body, rod => rod.parameters().hold)
    }

    /// What a torsion spring at the root does in the plane.
    fn hinge_outputs(&self) -> Vec<Variable> {
        let spring = matches!(self.hold(), Hold::TorsionSpring { .. }) && self.dimension() == 2;
        let of_hinge = |name: &str, unit: &str, text: &str, i: usize| {
            Real::output(name, unit, text, move |m| {
                m.ask(|body| either!(body, rod => rod.hinge().unwrap_or_default()[i]))
            })
        };
        if !spring {
            return Vec::new();
        }
        vec![
            of_hinge("hinge.angle", "rad", "Angle by which the torsion spring is turned, positive to the left", 0),
            of_hinge("hinge.omega", "rad/s", "Its rate", 1),
        ]
    }

    /// What a driven root puts in, or the force that tows a free one.
    fn drive_outputs(&self) -> Vec<Variable> {
        let mut list = Vec::new();
        let (free, turns) =
            (self.hold() == Hold::Free, matches!(self.hold(), Hold::Clamped | Hold::TorsionSpring { .. }));
        if turns {
            list.extend(self.along_axes(|d, axis| {
                let text = "Displacement that the tip would have on a rigid rod";
                Real::output(format!("rigid_tip.u{axis}"), "m", text, move |m| {
                    m.ask(|body| either!(body, rod => rod.rigid_tip_displacement()[d]))
                })
            }));
        }
        list.extend(self.along_axes(|d, axis| {
            let text = format!("Force along {axis} with which the root is {}", if free { "towed" } else { "driven" });
            Real::output(
                format!("root.force_{axis}"),
                self.per("N", "N/m"),
                text,
                move |m| either!(&m.body, rod => from_ref(&rod.state().drive.force[d])),
            )
        }));
        let moment = |name: &str, unit: &str, d: usize| {
            Real::output(
                name,
                unit,
                "Moment about the root with which it is driven",
                move |m| either!(&m.body, rod => from_ref(&rod.state().drive.moment[d])),
            )
        };
        if turns && self.dimension() == 2 {
            list.push(moment("root.moment", "N.m/m", 2));
        } else if turns {
            list.extend(self.along_axes(|d, axis| moment(&format!("root.moment_{axis}"), "N.m", d)));
        }
        let (power, work) = if turns { ("Power of both", "Their work") } else { ("Its power", "Its work") };
        let power = format!("{power} at the end of the step");
        let work = format!("{work} since the start: the sum of power times step");
        list.extend([
            Real::output(
                "root.power",
                self.per("W", "W/m"),
                power,
                |m| either!(&m.body, rod => from_ref(&rod.state().drive.power)),
            ),
            Real::output(
                "root.work",
                self.per("J", "J/m"),
                work,
                |m| either!(&m.body, rod => from_ref(&rod.state().drive.work)),
            ),
            Real::output(
                "damping.power",
                self.per("W", "W/m"),
                "Power that the damping takes at the end of the step",
                |m| m.ask(|body| either!(body, rod => rod.damping_power())),
            ),
        ]);
        list
    }

    /// Energies, and what the last step took.
    fn energy_and_newton_outputs(&self) -> [Variable; 7] {
        let unit = self.per("J", "J/m");
        [
            Real::output("energy.elastic", unit, "Energy of extension and bending", |m| {
                let Energy { stretching, bending, .. } = m.energy;
                m.ask(|_| stretching + bending)
            }),
            Real::output("energy.kinetic", unit, "Kinetic energy of the rod's own mass", |m| {
                from_ref(&m.energy.kinetic)
            }),
            Real::output("energy.gravity", unit, "Energy in gravity, 0 at the root at rest", |m| {
                from_ref(&m.energy.gravity)
            }),
            Integer::output("newton.iterations", "Newton iterations of the last step", |m| m.count(|s| s.iterations)),
            Integer::output("newton.substeps", "Sub-steps of the last step", |m| m.count(|s| s.substeps)),
            Integer::output("newton.rescues", "Solves of the last step that needed shift and line search", |m| {
                m.count(|s| s.rescues)
            }),
            Integer::output("newton.negative_pivots", "Negative pivots in the last step", |m| {
                m.count(|s| s.negative_pivots)
            }),
        ]
    }

    /// Where the root is at time `t`: position, velocity, direction and its rate; `None` where it is still.
    fn root_at(&self, t: f64) -> Option<[[f64; 3]; 4]> {
        let motion = self.scene.rod.as_ref()?.root_motion.as_ref()?;
        Some(match motion {
            RootMotion::Laws(laws) => {
                let (rest, direction) = self.scene.beam_root(self.scene.beam.as_ref()?);
                let (displacement, velocity) = laws.displacement(t);
                let (direction, rate) = laws.direction(t, direction);
                [std::array::from_fn(|d| rest[d] + displacement[d]), velocity, direction, rate]
            }
            RootMotion::Master => {
                let RootInputs { position, velocity, angle, omega, direction, direction_rate } = self.root;
                match self.body {
                    Body::Planar(_) => {
                        let (sin, cos) = angle.sin_cos();
                        [position, velocity, [cos, sin, 0.0], [-omega * sin, omega * cos, 0.0]]
                    }
                    Body::Spatial(_) => [position, velocity, direction, direction_rate],
                }
            }
        })
    }

    /// Put the rod, at rest, to where its root is at time `t`, if it moves at all.
    fn place(&mut self, t: f64) -> Result<(), Error> {
        match self.root_at(t) {
            Some(root) => either!(&mut self.body, rod => rod.place(root_of(root))),
            None => Ok(()),
        }
    }
}

impl Model for RodUnit {
    const IDENTIFIER: &'static str = "fmu_rod";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = &["scene.json"];
    type State = State;

    fn load(resources: &Resources) -> Result<Self, String> {
        let whole = Scene::from_json(resources.text("scene.json")?).map_err(|e| e.to_string())?;
        let load = whole.chosen_load().map(|(load, reason)| [load.name().to_string(), reason]).unwrap_or_default();
        let scene =
            whole.of_unit().ok_or("the scene has several rods, but no key `this_rod` that says which this one is")?;
        let stations = scene.beam.as_ref().map_or(0, |beam| beam.segments + 1);
        require_memory(BYTES_PER_STATION * stations)?;
        let dimension = scene.beam.as_ref().map_or(2, |beam| scene.dimension(beam));
        let body = Body::new(&scene, dimension).map_err(|e| e.to_string())?;
        let energy = either!(&body, rod => rod.energy()).map_err(|e| e.to_string())?;
        let (position, direction) = scene.beam.as_ref().map_or_else(Default::default, |beam| scene.beam_root(beam));
        let still = [0.0; 3];
        let angle = direction[1].atan2(direction[0]);
        let mut unit = Self {
            parameters: either!(&body, rod => Parameters::of(rod)),
            load,
            several: !whole.rods.is_empty(),
            scene,
            body,
            root: RootInputs { position, velocity: still, angle, omega: 0.0, direction, direction_rate: still },
            energy,
            asked: 0.0,
            counted: 0,
        };
        unit.place(0.0).map_err(|e| e.to_string())?;
        Ok(unit)
    }

    fn description(&self) -> Description {
        let root = match self.hold() {
            Hold::Clamped => "clamped at its root",
            Hold::Pinned => "pinned at its root",
            Hold::TorsionSpring { .. } => "on a torsion spring at its root",
            Hold::Free => "free at its root",
        };
        Description {
            model_name: if self.several { self.scene.name.clone() } else { format!("{}.rod", self.scene.name) },
            text: format!("Elastic mass-spring rod, {root}, implicit in time"),
            author: "The nervure developers".into(),
            copyright: "Copyright (c) 2026 The nervure developers".into(),
            license: env!("CARGO_PKG_LICENSE").into(),
            stop: self.scene.time.end,
            step: self.scene.time.communication_step,
            ..Description::default()
        }
    }

    fn variables(&self) -> Vec<Variable> {
        let rod = self.scene.rod.as_ref().expect("loading refuses a scene without a rod");
        let mut list = vec![Real::time()];
        list.extend(self.parameters());
        list.extend(self.load_inputs());
        if rod.root_motion == Some(RootMotion::Master) {
            list.extend(self.root_inputs());
        }
        // Every output is that of the end of a step.
        let at_the_end = |output: Variable| output.depends_on(&[]);
        list.extend(self.station_outputs().into_iter().map(at_the_end));
        list.extend(self.hinge_outputs().into_iter().map(at_the_end));
        if rod.root_motion.is_some() || matches!(rod.root, scene::RootSupport::Free { .. }) {
            list.extend(self.drive_outputs().into_iter().map(at_the_end));
        }
        if self.scene.load().is_some() {
            list.extend([
                Text::local("load.name", "Load that the rod takes from the fluid", |m| from_ref(&m.load[0])).constant(),
                Text::local("load.reason", "Why it is that one", |m| from_ref(&m.load[1])).constant(),
            ]);
        }
        list.extend(self.energy_and_newton_outputs().map(at_the_end));
        list
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        either!(&mut self.body, rod => self.parameters.apply(rod)).map_err(|e| e.to_string())?;
        self.place(start).and_then(|()| self.publish()).map_err(|e| e.to_string())?;
        log.info(format_args!("{} stations, start at t = {start} s", self.body.positions(0).len()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String> {
        if let Some(root) = self.root_at(t + h) {
            either!(&mut self.body, rod => rod.root = Some(root_of(root)));
        }
        let towing = self.scene.rod.as_ref().and_then(|rod| rod.root.towing_force(t + h));
        if let Some(towing) = towing {
            either!(&mut self.body, rod => rod.towing = std::array::from_fn(|d| towing[d]));
        }
        let span = || format!("in the step from t = {t} s to {} s", t + h);
        self.body.step(h).and_then(|()| self.publish()).map_err(|e| format!("{e}, {}", span()))?;
        let Statistics { iterations, substeps, halvings, rescues, negative_pivots } = self.body.statistics();
        if rescues > 0 || negative_pivots > 0 || halvings > 0 {
            log.info(format_args!(
                "{rescues} solves needed shift and line search, {substeps} sub-steps after {halvings} halvings, {iterations} \
                 Newton iterations, {negative_pivots} negative pivots, {}",
                span()
            ));
        }
        Ok(())
    }

    fn state_bytes(&self) -> usize {
        STATE_BYTES_PER_STATION * self.body.positions(0).len()
    }

    fn save(&self) -> State {
        State {
            parameters: self.parameters,
            loads: either!(&self.body, rod => rod.loads.clone()),
            root: self.root,
            rod: match &self.body {
                Body::Planar(rod) => BodyState::Planar(rod.state().clone()),
                Body::Spatial(rod) => BodyState::Spatial(rod.state().clone()),
            },
        }
    }

    fn restore(&mut self, state: &State) -> Result<(), String> {
        self.parameters = state.parameters;
        self.root = state.root;
        either!(&mut self.body, rod => state.parameters.apply(rod)).map_err(|e| e.to_string())?;
        let loads = self.body.loads();
        for (name, own, known) in [
            ("force", &mut loads.force, &state.loads.force),
            ("impedance", &mut loads.impedance, &state.loads.impedance),
            ("pressure_jump", &mut loads.pressure_jump, &state.loads.pressure_jump),
            ("pressure", &mut loads.pressure, &state.loads.pressure),
        ] {
            if own.len() != known.len() {
                return Err(format!("loads.{name} has {} elements, but this rod has {}", known.len(), own.len()));
            }
            own.copy_from_slice(known);
        }
        let result = match (&mut self.body, &state.rod) {
            (Body::Planar(rod), BodyState::Planar(state)) => rod.restore(state),
            (Body::Spatial(rod), BodyState::Spatial(state)) => rod.restore(state),
            _ => return Err("the rod of the state has another number of space dimensions than this one".into()),
        };
        result.and_then(|()| self.publish()).map_err(|e| e.to_string())
    }
}

fmi_export::export_fmu!(RodUnit);
