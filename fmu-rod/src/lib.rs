//! The elastic rod as an FMI 2.0 co-simulation unit: the list of its variables and its step.

use std::path::Path;
use std::slice::{from_mut, from_ref};

use fmi2::{Description, Log, Model, Span};
use rod::{Drive, Error, Exchange, Loads, Rod, Root, Sensitivity, Statistics};
use scene::{RootMotion, Scene, Section};
use serde::{Deserialize, Serialize};

type Real = fmi2::Real<RodUnit>;
type Integer = fmi2::Integer<RodUnit>;
type Text = fmi2::Text<RodUnit>;
type Variable = fmi2::Variable<RodUnit>;

const AXES: [&str; 3] = ["x", "y", "z"];

/// The rod of a scene.
struct RodUnit {
    scene: Scene,
    parameters: Parameters,
    body: Body,
    /// Where the master wants the root at the end of the next step.
    root: RootInputs,
    /// Name of the load that the rod takes from a fluid, and why; empty without a fluid.
    load: [String; 2],
    tip_displacement: [f64; 3],
    tip_velocity: [f64; 3],
    /// What the loads did: force, power and work.
    exchange: Exchange<3>,
    /// What a driven root did, the displacement that the tip would have on a rigid rod, and what the damping takes.
    drive: Drive<3>,
    rigid_tip: [f64; 3],
    damping_power: f64,
    elastic_energy: f64,
    kinetic_energy: f64,
    gravity_energy: f64,
    /// Newton iterations, sub-steps, rescued solves and negative pivots of the last step.
    newton: [i32; 4],
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
    clamp_setback: f64,
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

    fn sensitivity(&mut self, change: &Loads) -> Result<Sensitivity, Error> {
        either!(self, rod => rod.sensitivity(change))
    }

    fn statistics(&self) -> Statistics {
        either!(self, rod => rod.statistics())
    }
}

/// What an output array holds.
#[derive(Clone, Copy)]
enum Quantity {
    Position,
    Velocity,
}

/// Quantity and axis of an output along the rod or of its tip, and the node of its first element.
fn station_output(name: &str, nodes: usize) -> Option<(Quantity, usize, usize)> {
    let (name, first) = match name.strip_prefix("tip.") {
        Some(name) => (name.strip_prefix('u').unwrap_or(name), nodes - 1),
        None => (name, 0),
    };
    let (quantity, axis) = match name.strip_prefix('v') {
        Some(axis) => (Quantity::Velocity, axis),
        None => (Quantity::Position, name),
    };
    AXES.iter().position(|known| *known == axis).map(|axis| (quantity, axis, first))
}

impl Parameters {
    fn of<const D: usize>(rod: &Rod<D>) -> Self {
        let own = rod.parameters();
        Self {
            section: own.section,
            displaced_line_density: own.displaced,
            damping: own.damping,
            clamp_setback: own.clamp_setback,
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
            clamp_setback: self.clamp_setback,
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
    /// What the master reads after a step.
    fn publish(&mut self) -> Result<(), Error> {
        either!(&self.body, rod => {
            let tip = rod.positions(0).len() - 1;
            for (axis, displacement) in rod.tip_displacement().into_iter().enumerate() {
                self.tip_displacement[axis] = displacement;
                self.tip_velocity[axis] = rod.velocities(axis)[tip];
            }
            let Exchange { force, power, work } = rod.state().exchange;
            self.exchange = Exchange { power, work, ..Exchange::none() };
            force.iter().enumerate().for_each(|(axis, force)| self.exchange.force[axis] = *force);
            if rod.root.is_some() {
                let Drive { force, moment, power, work } = rod.state().drive;
                self.drive = Drive { moment, power, work, ..Drive::none() };
                force.iter().enumerate().for_each(|(axis, force)| self.drive.force[axis] = *force);
                let rigid_tip = rod.rigid_tip_displacement();
                self.rigid_tip[..rigid_tip.len()].copy_from_slice(&rigid_tip);
                self.damping_power = rod.damping_power();
            }
            let energy = rod.energy()?;
            self.elastic_energy = energy.stretching + energy.bending;
            self.kinetic_energy = energy.kinetic;
            self.gravity_energy = energy.gravity;
            let Statistics { iterations, substeps, rescues, negative_pivots, .. } = rod.statistics();
            self.newton = [iterations, substeps, rescues, negative_pivots]
                .map(|count| i32::try_from(count).unwrap_or(i32::MAX));
        });
        Ok(())
    }

    /// The inputs of a master that drives the root.
    fn root_inputs(&self) -> Vec<Variable> {
        type Place = fn(&mut RodUnit) -> &mut [f64];
        let position: [Place; 3] = [
            |m| from_mut(&mut m.root.position[0]),
            |m| from_mut(&mut m.root.position[1]),
            |m| from_mut(&mut m.root.position[2]),
        ];
        let velocity: [Place; 3] = [
            |m| from_mut(&mut m.root.velocity[0]),
            |m| from_mut(&mut m.root.velocity[1]),
            |m| from_mut(&mut m.root.velocity[2]),
        ];
        let direction: [Place; 3] = [
            |m| from_mut(&mut m.root.direction[0]),
            |m| from_mut(&mut m.root.direction[1]),
            |m| from_mut(&mut m.root.direction[2]),
        ];
        let direction_rate: [Place; 3] = [
            |m| from_mut(&mut m.root.direction_rate[0]),
            |m| from_mut(&mut m.root.direction_rate[1]),
            |m| from_mut(&mut m.root.direction_rate[2]),
        ];
        let planar = matches!(self.body, Body::Planar(_));
        let along = |name: &str, unit: &str, text: &str, places: [Place; 3]| {
            let axes = AXES.iter().zip(places).take(if planar { 2 } else { 3 });
            axes.map(|(axis, place)| Real::input(format!("{name}{axis}"), unit, text, place)).collect::<Vec<_>>()
        };
        let mut list = along("root.", "m", "Position of the root at the end of the step", position);
        list.extend(along("root.v", "m/s", "Velocity of the root at the end of the step", velocity));
        if planar {
            list.push(Real::input("root.angle", "rad", "Direction of the beam at the root, from the x axis", |m| {
                from_mut(&mut m.root.angle)
            }));
            list.push(Real::input("root.omega", "rad/s", "Rate of the direction at the root", |m| {
                from_mut(&mut m.root.omega)
            }));
        } else {
            list.extend(along("root.direction.", "1", "Direction of the beam at the root, of any length", direction));
            list.extend(along("root.direction_rate.", "1/s", "Rate of the direction at the root", direction_rate));
        }
        list
    }

    /// What a driven root puts in.
    fn drive_outputs(&self) -> Vec<Variable> {
        let planar = matches!(self.body, Body::Planar(_));
        let per = |unit: &str, planar_unit: &str| if planar { planar_unit.to_string() } else { unit.to_string() };
        let axes = || AXES.iter().take(if planar { 2 } else { 3 }).enumerate();
        let rigid_tip: [fn(&mut Self) -> &[f64]; 3] =
            [|m| from_ref(&m.rigid_tip[0]), |m| from_ref(&m.rigid_tip[1]), |m| from_ref(&m.rigid_tip[2])];
        let force: [fn(&mut Self) -> &[f64]; 3] =
            [|m| from_ref(&m.drive.force[0]), |m| from_ref(&m.drive.force[1]), |m| from_ref(&m.drive.force[2])];
        let moment: [fn(&mut Self) -> &[f64]; 3] =
            [|m| from_ref(&m.drive.moment[0]), |m| from_ref(&m.drive.moment[1]), |m| from_ref(&m.drive.moment[2])];
        let mut list = Vec::new();
        list.extend(axes().map(|(d, axis)| {
            let text = "Displacement that the tip would have on a rigid rod";
            Real::output(format!("rigid_tip.u{axis}"), "m", text, rigid_tip[d])
        }));
        list.extend(axes().map(|(d, axis)| {
            let text = format!("Force along {axis} with which the root is driven");
            Real::output(format!("root.force_{axis}"), &per("N", "N/m"), text, force[d])
        }));
        let text = "Moment about the root with which it is driven";
        if planar {
            list.push(Real::output("root.moment", "N.m/m", text, moment[2]));
        } else {
            list.extend(axes().map(|(d, axis)| Real::output(format!("root.moment_{axis}"), "N.m", text, moment[d])));
        }
        list.extend([
            Real::output("root.power", &per("W", "W/m"), "Power of both at the end of the step", |m| {
                from_ref(&m.drive.power)
            }),
            Real::output(
                "root.work",
                &per("J", "J/m"),
                "Their work since the start: the sum of power times step",
                |m| from_ref(&m.drive.work),
            ),
            Real::output(
                "damping.power",
                &per("W", "W/m"),
                "Power that the damping takes at the end of the step",
                |m| from_ref(&m.damping_power),
            ),
        ]);
        list.into_iter().map(|output| output.depends_on(&[])).collect()
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
    const DIRECTIONAL_DERIVATIVE: bool = true;
    const OUTPUT_DERIVATIVE: bool = true;
    type State = State;

    fn load(resources: Option<&Path>) -> Result<Self, String> {
        let resources = resources.ok_or("the rod needs its resources folder with scene.json in it")?;
        let scene = Scene::from_file(&resources.join("scene.json")).map_err(|e| e.to_string())?;
        let dimension = scene.beam.as_ref().map_or(2, |beam| scene.dimension(beam));
        let body = Body::new(&scene, dimension).map_err(|e| e.to_string())?;
        let (position, direction) = scene.beam.as_ref().map_or_else(Default::default, |beam| scene.beam_root(beam));
        let still = [0.0; 3];
        let angle = direction[1].atan2(direction[0]);
        let mut unit = Self {
            parameters: either!(&body, rod => Parameters::of(rod)),
            load: scene.chosen_load().map(|(load, reason)| [load.name().to_string(), reason]).unwrap_or_default(),
            scene,
            body,
            root: RootInputs { position, velocity: still, angle, omega: 0.0, direction, direction_rate: still },
            tip_displacement: [0.0; 3],
            tip_velocity: [0.0; 3],
            exchange: Exchange::none(),
            drive: Drive::none(),
            rigid_tip: [0.0; 3],
            damping_power: 0.0,
            elastic_energy: 0.0,
            kinetic_energy: 0.0,
            gravity_energy: 0.0,
            newton: [0; 4],
        };
        unit.place(0.0).map_err(|e| e.to_string())?;
        Ok(unit)
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
            Real::parameter("clamp_setback", "m", "Length by which the clamp lies behind the root", |m| {
                from_mut(&mut m.parameters.clamp_setback)
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
        if either!(&self.body, rod => rod.parameters().section.shear_stiffness.is_some()) {
            list.push(
                Real::parameter("shear_stiffness", "N/m", "Shear stiffness GA_s", |m| {
                    m.parameters.section.shear_stiffness.as_mut_slice()
                })
                .above(0.0),
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
        if matches!(self.scene.rod.as_ref().and_then(|rod| rod.root_motion.as_ref()), Some(RootMotion::Master)) {
            list.extend(self.root_inputs());
        }
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
        let load: [fn(&mut Self) -> &[f64]; 3] = [
            |m| from_ref(&m.exchange.force[0]),
            |m| from_ref(&m.exchange.force[1]),
            |m| from_ref(&m.exchange.force[2]),
        ];
        list.extend(axes().map(|(d, axis)| {
            let text = format!("Sum along {axis} of the loads that the stations took at the end of the step");
            Real::output(format!("load.{axis}"), &per("N", "N/m"), text, load[d]).depends_on(&[])
        }));
        let power = "Power of the loads at the end of the step";
        let work = "Work of the loads since the start: the sum of power times step";
        list.extend([
            Real::output("load.power", &per("W", "W/m"), power, |m| from_ref(&m.exchange.power)).depends_on(&[]),
            Real::output("load.work", &per("J", "J/m"), work, |m| from_ref(&m.exchange.work)).depends_on(&[]),
        ]);
        if self.scene.rod.as_ref().is_some_and(|rod| rod.root_motion.is_some()) {
            list.extend(self.drive_outputs());
        }
        if self.scene.load().is_some() {
            list.extend([
                Text::local("load.name", "Load that the rod takes from the fluid", |m| from_ref(&m.load[0])).constant(),
                Text::local("load.reason", "Why it is that one", |m| from_ref(&m.load[1])).constant(),
            ]);
        }
        list.extend([
            Real::output("energy.elastic", &per("J", "J/m"), "Energy of extension and bending", |m| {
                from_ref(&m.elastic_energy)
            })
            .depends_on(&[]),
            Real::output("energy.kinetic", &per("J", "J/m"), "Kinetic energy of the rod's own mass", |m| {
                from_ref(&m.kinetic_energy)
            })
            .depends_on(&[]),
            Real::output("energy.gravity", &per("J", "J/m"), "Energy in gravity, 0 at the root at rest", |m| {
                from_ref(&m.gravity_energy)
            })
            .depends_on(&[]),
            Integer::output("newton.iterations", "Newton iterations of the last step", |m| from_ref(&m.newton[0]))
                .depends_on(&[]),
            Integer::output("newton.substeps", "Sub-steps of the last step", |m| from_ref(&m.newton[1]))
                .depends_on(&[]),
            Integer::output("newton.rescues", "Solves of the last step that needed shift and line search", |m| {
                from_ref(&m.newton[2])
            })
            .depends_on(&[]),
            Integer::output("newton.negative_pivots", "Negative pivots in the last step", |m| from_ref(&m.newton[3]))
                .depends_on(&[]),
        ]);
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

    /// Of the stations and the tip with respect to the loads: what the end of the last step would have been under other
    /// loads.
    fn directional_derivative(
        &mut self,
        unknown: &[Span],
        known: &[Span],
        seed: &[f64],
        derivative: &mut [f64],
    ) -> Result<(), String> {
        let nodes = self.body.positions(0).len();
        let mut change = self.body.loads().clone();
        let Loads { force, pressure_jump, impedance } = &mut change;
        [&mut *force, &mut *pressure_jump, &mut *impedance].into_iter().for_each(|array| array.fill(0.0));
        let mut rest = seed;
        for Span { name, elements } in known {
            let piece = rest.split_off(..elements.len()).expect("one seed per reference");
            let axis = name.strip_prefix("force_").and_then(|axis| AXES.iter().position(|known| *known == axis));
            let array = match (*name, axis) {
                (_, Some(axis)) => &mut force[axis * nodes..],
                ("pressure_jump", _) => &mut pressure_jump[..],
                ("impedance", _) => &mut impedance[..],
                _ => return Err(format!("no derivative by {name} is provided, only by the loads on the stations")),
            };
            array[elements.clone()].iter_mut().zip(piece).for_each(|(sum, seed)| *sum += seed);
        }
        let sensitivity = self.body.sensitivity(&change).map_err(|e| e.to_string())?;
        let mut rest = derivative;
        for Span { name, elements } in unknown {
            let piece = rest.split_off_mut(..elements.len()).expect("one value per reference");
            let (quantity, axis, first) = station_output(name, nodes)
                .ok_or_else(|| format!("no directional derivative of {name} is provided, only of stations and tip"))?;
            let array = match quantity {
                Quantity::Position => &sensitivity.positions,
                Quantity::Velocity => &sensitivity.velocities,
            };
            piece.copy_from_slice(&array[axis * nodes + first..][elements.clone()]);
        }
        Ok(())
    }

    fn output_derivative(&mut self, outputs: &Span, derivative: &mut [f64]) -> Result<(), String> {
        let nodes = self.body.positions(0).len();
        let (quantity, axis, first) = station_output(outputs.name, nodes)
            .ok_or_else(|| format!("no derivative of {} is provided, only of stations and tip", outputs.name))?;
        for (value, element) in derivative.iter_mut().zip(outputs.elements.clone()) {
            let k = first + element;
            *value = match quantity {
                Quantity::Position => self.body.velocities(axis)[k],
                Quantity::Velocity => either!(&self.body, rod => rod.acceleration(axis, k)),
            };
        }
        Ok(())
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

fmi2::export_fmu!(RodUnit);
