//! The list of the variables of a fluid of three dimensions, in the order of their value references.

use fluid::space::{Fluid, Force};

use super::FluidUnit;
use super::variables::parameters;

type Real = fmi_export::Real<FluidUnit>;
type Variable = fmi_export::Variable<FluidUnit>;

/// Names of the force along x, y and z.
const FORCES: [&str; 3] = ["drag", "lift", "side"];
const AXES: [&str; 3] = ["x", "y", "z"];

/// Return the variables of a unit; absent parts of the scene have none.
pub fn variables(unit: &FluidUnit) -> Vec<Variable> {
    let part = unit.scene.fluid.as_ref().expect("loading refuses a scene without a fluid");
    let mut list = Vec::from(parameters("max(|u|/dx + |v|/dy + |w|/dz) dt"));
    list.extend(totals());
    let thin = unit.flow.nodes().len();
    if part.bodies.len() + thin > 0 {
        for (axis, name) in FORCES.into_iter().enumerate() {
            let text = format!("Force of the fluid on all bodies along {}", AXES[axis]);
            list.push(output(name, "N", text, move |fluid| fluid.force()[axis]));
        }
    }
    for k in 0..part.bodies.len() {
        list.extend(body(k));
    }
    let thin: Vec<_> = (0..thin).map(|k| ThinNames::of(unit, k)).collect();
    for (k, names) in thin.iter().enumerate() {
        list.extend(names.exchange(k));
    }
    for (k, probe) in part.probes.iter().enumerate() {
        let (name, place) = (&probe.name, &probe.position);
        for (axis, component) in ["u", "v", "w"].into_iter().enumerate() {
            let text = format!("Velocity along {} at {place:?}", AXES[axis]);
            list.push(output(format!("probe.{name}.{component}"), "m/s", text, move |f| f.probe_velocity(k)[axis]));
        }
        let text = format!("Static pressure at {place:?}");
        list.push(output(format!("probe.{name}.p"), "Pa", text, move |fluid| fluid.probe_pressure(k)));
    }
    for (k, (names, nodes)) in thin.iter().zip(unit.flow.nodes()).enumerate() {
        list.extend(names.nodes(k, nodes.len()));
    }
    list
}

/// Names of a thin body.
struct ThinNames {
    /// In outputs, e.g. `beam[2]`.
    name: String,
    /// In texts, e.g. `beam 2`.
    text: String,
    /// In front of the variables of its nodes.
    prefix: String,
    /// The nodes and the point of the moments in texts.
    nodes: &'static str,
    centre: &'static str,
}

impl ThinNames {
    /// Names of thin body number `k`: one beam has the names without a number.
    fn of(unit: &FluidUnit, k: usize) -> Self {
        let beams = unit.scene.beams().count();
        let number = k + 1;
        let (name, text, prefix, nodes, centre) = if k >= beams {
            ("wing".into(), "the wing".into(), "wing.".into(), "nodes", "the pivot of the wing")
        } else if beams == 1 {
            ("beam".into(), "the beam".into(), String::new(), "stations", "its root")
        } else {
            (format!("beam[{number}]"), format!("beam {number}"), format!("beam[{number}]."), "stations", "its root")
        };
        Self { name, text, prefix, nodes, centre }
    }

    /// Return force, moment, power and work in the last step.
    fn exchange(&self, k: usize) -> Vec<Variable> {
        let Self { name, text, nodes, centre, .. } = self;
        let mut list = Vec::new();
        for (axis, along) in AXES.into_iter().enumerate() {
            let text = format!("Force of the fluid on {text} along {along}");
            let force = move |fluid: &mut Fluid| fluid.force_on_thin(k).force[axis];
            list.push(output(format!("{name}.{}", FORCES[axis]), "N", text, force));
        }
        for (axis, about) in AXES.into_iter().enumerate() {
            let text = format!("Moment of the fluid on {text} about an axis along {about} through {centre}");
            let moment = move |fluid: &mut Fluid| fluid.force_on_thin(k).moment[axis];
            list.push(output(format!("{name}.moment_{about}"), "N.m", text, moment));
        }
        for (axis, along) in AXES.into_iter().enumerate() {
            let text = format!("Sum of what the fluid exerted on the {nodes} along {along}: no unsteady term");
            list.push(output(format!("{name}.load_{along}"), "N", text, move |fluid| fluid.exchange()[k].force[axis]));
        }
        let power = format!("Power of what the fluid exerted on the {nodes}, at the end of the step");
        let work = "Its work since the start: the sum of power times step";
        list.push(output(format!("{name}.power"), "W", power, move |fluid| fluid.exchange()[k].power));
        list.push(output(format!("{name}.work"), "J", work, move |fluid| fluid.exchange()[k].work));
        list
    }

    /// Return motion and loads of the `n` nodes.
    fn nodes(&self, k: usize, n: usize) -> Vec<Variable> {
        let Self { prefix, nodes, .. } = self;
        let mut list = Vec::new();
        for (axis, along) in AXES.into_iter().enumerate() {
            let text = format!("Position of the {nodes} at the end of the step");
            list.push(Real::input(format!("{prefix}{along}"), "m", text, move |m| {
                &mut m.flow.nodes_mut()[k].position[axis]
            }));
        }
        for (axis, along) in AXES.into_iter().enumerate() {
            let text = format!("Velocity of the {nodes} at the end of the step");
            list.push(Real::input(format!("{prefix}v{along}"), "m/s", text, move |m| {
                &mut m.flow.nodes_mut()[k].velocity[axis]
            }));
        }
        for (axis, along) in AXES.into_iter().enumerate() {
            let text = format!("Load on the {nodes} for the coming step");
            let load = Real::output(format!("{prefix}force_{along}"), "N", text, move |m| {
                &m.flow.space().loads()[k].force[axis]
            });
            list.push(load.depends_on(&[]));
        }
        let text = "Rate at which the load falls with the node's velocity";
        let impedance =
            Real::output(format!("{prefix}impedance"), "kg/s", text, move |m| &m.flow.space().loads()[k].impedance);
        list.push(impedance.depends_on(&[]));
        list.into_iter().map(|variable| variable.array(n)).collect()
    }
}

/// Return an output that is read from the fluid.
fn output(
    name: impl Into<String>,
    unit: &str,
    text: impl Into<String>,
    read: impl Fn(&mut Fluid) -> f64 + Copy + Send + Sync + 'static,
) -> Variable {
    Real::output(name, unit, text, move |m| m.read_space(read)).depends_on(&[])
}

/// Return the outputs of every scene.
fn totals() -> [Variable; 5] {
    let local = |name: &str, unit: &str, text: &str, read: fn(&mut Fluid) -> f64| {
        Real::local(name, unit, text, move |m: &mut FluidUnit| m.read_space(read))
    };
    [
        output("cfl", "1", "CFL number of the last step", |fluid| fluid.cfl()),
        output("flow_rate", "m3/s", "Flow rate through the middle of the box", |fluid| fluid.flow_rate()),
        local("kinetic_energy", "J", "Kinetic energy of the whole box", |fluid| fluid.kinetic_energy()),
        local("enstrophy", "m3/s2", "Half the integral of the squared vorticity over the whole box", |f| f.enstrophy()),
        local("divergence", "1", "Largest divergence times the cell size over the largest speed", Fluid::divergence),
    ]
}

/// Return force, moment, power, place and angle of body number `k`.
fn body(k: usize) -> Vec<Variable> {
    let (name, body) = (format!("body[{}]", k + 1), format!("body {}", k + 1));
    let mut list = Vec::new();
    let mut force = |name: String, unit: &str, text: String, of: fn(Force) -> [f64; 3], axis: usize| {
        list.push(output(name, unit, text, move |fluid| of(fluid.force_on_body(k))[axis]));
    };
    for (axis, along) in AXES.into_iter().enumerate() {
        let text = format!("Force of the fluid on {body} along {along}");
        force(format!("{name}.{}", FORCES[axis]), "N", text, |force| force.force, axis);
    }
    for (axis, about) in AXES.into_iter().enumerate() {
        let text = format!("Moment of the fluid on {body} about an axis along {about} through its pivot");
        force(format!("{name}.moment_{about}"), "N.m", text, |force| force.moment, axis);
    }
    let power = format!("Power of the force and the moment of the fluid on {body}, at the end of the step");
    list.push(output(format!("{name}.power"), "W", power, move |fluid| fluid.power_on_body(k)));
    for (axis, along) in AXES.into_iter().enumerate() {
        let text = format!("Position of the pivot of {body} along {along}");
        list.push(output(format!("{name}.{along}"), "m", text, move |fluid| fluid.pose(k).position[axis]));
    }
    let angle = format!("Angle of the motion of {body} about its axis");
    list.push(output(format!("{name}.angle"), "rad", angle, move |fluid| fluid.pose(k).angle));
    list
}
