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
    if !part.bodies.is_empty() {
        for (axis, name) in FORCES.into_iter().enumerate() {
            let text = format!("Force of the fluid on all bodies along {}", AXES[axis]);
            list.push(output(name, "N", text, move |fluid| fluid.force()[axis]));
        }
    }
    for k in 0..part.bodies.len() {
        list.extend(body(k));
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
    list
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
