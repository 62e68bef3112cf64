//! The list of the variables, in the order of their value references.

use std::slice::from_mut;

use fluid::{Fluid, Force, Pose};

use super::FluidUnit;
use super::flow::Flow;

type Real = fmi_export::Real<FluidUnit>;
type Variable = fmi_export::Variable<FluidUnit>;

/// Return the variables of a unit; absent parts of the scene have none.
pub fn of(unit: &FluidUnit) -> Vec<Variable> {
    let part = unit.scene.fluid.as_ref().expect("loading refuses a scene without a fluid");
    let (cylinders, bodies, beams) = (part.cylinders.len(), part.bodies.len(), unit.flow.stations().len());
    let loads = matches!(&unit.flow, Flow::Plane(fluid) if !fluid.loads().is_empty());
    let mut list = Vec::from(parameters("max(|u|/dx + |v|/dy) dt"));
    list.extend(totals());
    if cylinders > 0 || bodies > 0 || beams > 0 {
        let all = if bodies > 0 || beams > 1 { "all bodies" } else { "all cylinders and the beam" };
        let text = |axis| format!("Force of the fluid on {all} along {axis}, per metre of depth");
        list.push(output("drag", "N/m", text("x"), |fluid| fluid.force()[0]));
        list.push(output("lift", "N/m", text("y"), |fluid| fluid.force()[1]));
    }
    for k in 0..cylinders {
        let (name, body) = (format!("cylinder[{}]", k + 1), format!("cylinder {}", k + 1));
        list.extend(force(&name, &body, "its centre", move |fluid| fluid.force_on_cylinder(k)));
    }
    for k in 0..bodies {
        let (name, body) = (format!("body[{}]", k + 1), format!("body {}", k + 1));
        list.extend(force(&name, &body, "its pivot", move |fluid| fluid.force_on_body(k)));
        list.extend(motion(&name, &body, k));
        if part.bodies[k].is_driven() {
            list.extend(displacement(&name, &body, k));
        }
        if part.bodies[k].mount.is_some() {
            list.extend(velocity(&name, &body, k));
        }
    }
    for k in 0..beams {
        // One beam has the names without a number.
        let [name, beam] = if beams == 1 { ["beam".into(), "the beam".into()] } else { numbered(k) };
        list.extend(force(&name, &beam, "its root", move |fluid| fluid.force_on_beam(k)));
        list.extend(exchange(&name, k));
    }
    for (k, probe) in part.probes.iter().enumerate() {
        let (name, x, y) = (&probe.name, probe.position[0], probe.position[1]);
        let text = |what| format!("{what} at ({x}, {y})");
        list.extend([
            output(format!("probe.{name}.u"), "m/s", text("Velocity along x"), move |f| f.probe_velocity(k)[0]),
            output(format!("probe.{name}.v"), "m/s", text("Velocity along y"), move |f| f.probe_velocity(k)[1]),
            output(format!("probe.{name}.p"), "Pa", text("Static pressure"), move |f| f.probe_pressure(k)),
        ]);
    }
    for (k, stations) in unit.flow.stations().iter().enumerate() {
        let prefix = if beams == 1 { String::new() } else { format!("{}.", numbered(k)[0]) };
        let line = matches!(&unit.flow, Flow::Plane(fluid) if !fluid.shear()[k].is_empty());
        let loads = [line, loads, unit.scene.axial_pressure_strain()];
        list.extend(station_variables(&prefix, k, stations.len(), loads));
    }
    list
}

/// Return the names of beam number `k` from 0 among several, in variables and in texts.
fn numbered(k: usize) -> [String; 2] {
    [format!("beam[{}]", k + 1), format!("beam {}", k + 1)]
}

/// Return an output that is read from the fluid.
fn output(
    name: impl Into<String>,
    unit: &str,
    text: impl Into<String>,
    read: impl Fn(&mut Fluid) -> f64 + Copy + Send + Sync + 'static,
) -> Variable {
    Real::output(name, unit, text, move |m| m.read(read)).depends_on(&[])
}

/// Return time and parameters, with the formula of the CFL number.
pub fn parameters(cfl: &str) -> [Variable; 6] {
    let max_cfl = format!("Largest CFL number {cfl}");
    [
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
        Real::parameter("max_step", "s", "Largest step of the fluid's own", |m| from_mut(&mut m.parameters.max_step))
            .above(0.0),
        Real::parameter("max_cfl", "1", max_cfl, |m| from_mut(&mut m.parameters.max_cfl)).above(0.0),
    ]
}

/// Return the outputs of every scene of two dimensions.
fn totals() -> [Variable; 5] {
    let local = |name: &str, unit: &str, text: &str, read: fn(&mut Fluid) -> f64| {
        Real::local(name, unit, text, move |m: &mut FluidUnit| m.read(read))
    };
    [
        output("cfl", "1", "CFL number of the last step", |fluid| fluid.cfl()),
        output("flow_rate", "m2/s", "Flow rate through the middle of the box per metre of depth", |f| f.flow_rate()),
        local("kinetic_energy", "J/m", "Kinetic energy of the whole box per metre of depth", |f| f.kinetic_energy()),
        local("enstrophy", "m2/s2", "Half the integral of the squared vorticity over the whole box", |f| f.enstrophy()),
        local("divergence", "1", "Largest divergence times the cell size over the largest speed", Fluid::divergence),
    ]
}

/// Return drag, lift and moment of a body under a name.
fn force(
    name: &str,
    body: &str,
    point: &str,
    of: impl Fn(&Fluid) -> Force + Copy + Send + Sync + 'static,
) -> [Variable; 3] {
    let text = |axis| format!("Force of the fluid on {body} along {axis}, per metre of depth");
    let moment = format!("Moment of the fluid on {body} about {point}, positive to the left, per metre of depth");
    [
        output(format!("{name}.drag"), "N/m", text("x"), move |fluid| of(fluid).force[0]),
        output(format!("{name}.lift"), "N/m", text("y"), move |fluid| of(fluid).force[1]),
        output(format!("{name}.moment"), "N.m/m", moment, move |fluid| of(fluid).moment),
    ]
}

/// Return power, place and angle of body number `k` under a name.
fn motion(name: &str, body: &str, k: usize) -> [Variable; 4] {
    let power = format!("Power of the force and the moment of the fluid on {body}, at the end of the step");
    let position = |axis| format!("Position of the pivot of {body} along {axis}");
    let angle = format!("Angle from the x axis to that of {body}, positive to the left");
    [
        output(format!("{name}.power"), "W/m", power, move |fluid| fluid.power_on_body(k)),
        output(format!("{name}.x"), "m", position("x"), move |fluid| fluid.pose(k).position[0]),
        output(format!("{name}.y"), "m", position("y"), move |fluid| fluid.pose(k).position[1]),
        output(format!("{name}.angle"), "rad", angle, move |fluid| fluid.pose(k).angle),
    ]
}

/// Return the motion of body number `k`, which the master moves, as inputs.
fn displacement(name: &str, body: &str, k: usize) -> [Variable; 6] {
    let input = |part: &str, unit: &str, what: &str, of: fn(&mut Pose) -> &mut f64| {
        let text = format!("{what} of {body} at the end of the step");
        Real::input(format!("{name}.motion.{part}"), unit, text, move |m: &mut FluidUnit| {
            from_mut(of(m.flow.plane().displacement_mut(k)))
        })
    };
    [
        input("x", "m", "Displacement along x", |pose| &mut pose.position[0]),
        input("y", "m", "Displacement along y", |pose| &mut pose.position[1]),
        input("angle", "rad", "Angle, added to that of the scene,", |pose| &mut pose.angle),
        input("vx", "m/s", "Velocity along x", |pose| &mut pose.velocity[0]),
        input("vy", "m/s", "Velocity along y", |pose| &mut pose.velocity[1]),
        input("omega", "rad/s", "Rate of the angle", |pose| &mut pose.omega),
    ]
}

/// Return the velocities of body number `k`, which is on springs.
fn velocity(name: &str, body: &str, k: usize) -> [Variable; 3] {
    let text = |axis| format!("Velocity of the pivot of {body} along {axis}");
    [
        output(format!("{name}.vx"), "m/s", text("x"), move |fluid| fluid.pose(k).velocity[0]),
        output(format!("{name}.vy"), "m/s", text("y"), move |fluid| fluid.pose(k).velocity[1]),
        output(format!("{name}.omega"), "rad/s", format!("Rate of the angle of {body}"), move |f| f.pose(k).omega),
    ]
}

/// Return the exchange with beam number `k` in the last step, to be compared with the rod's.
fn exchange(name: &str, k: usize) -> [Variable; 4] {
    let sum = |axis| format!("Sum of what the fluid exerted on the stations along {axis}: no unsteady term");
    let power = "Power of what the fluid exerted on the stations, at the end of the step";
    let work = "Its work since the start: the sum of power times step";
    [
        output(format!("{name}.load_x"), "N/m", sum("x"), move |fluid| fluid.exchange()[k].force[0]),
        output(format!("{name}.load_y"), "N/m", sum("y"), move |fluid| fluid.exchange()[k].force[1]),
        output(format!("{name}.power"), "W/m", power, move |fluid| fluid.exchange()[k].power),
        output(format!("{name}.work"), "J/m", work, move |fluid| fluid.exchange()[k].work),
    ]
}

/// Return the variables of the `n` stations of beam number `k`: motion, pressure jump, and if present shear of a line,
/// loads and pressure around the beam.
fn station_variables(prefix: &str, k: usize, n: usize, [line, loads, pressure]: [bool; 3]) -> Vec<Variable> {
    let (position, velocity) =
        ("Position of the stations at the end of the step", "Velocity of the stations at the end of the step");
    let (jump, load) = ("Pressure above minus below the beam", "Load on the stations for the coming step");
    let impedance = "Rate at which the load falls with the station's velocity";
    let name = |name: &str| format!("{prefix}{name}");
    let mut list = vec![
        Real::input(name("x"), "m", position, move |m| &mut m.flow.stations_mut()[k].position[0]).array(n),
        Real::input(name("y"), "m", position, move |m| &mut m.flow.stations_mut()[k].position[1]).array(n),
        Real::input(name("vx"), "m/s", velocity, move |m| &mut m.flow.stations_mut()[k].velocity[0]).array(n),
        Real::input(name("vy"), "m/s", velocity, move |m| &mut m.flow.stations_mut()[k].velocity[1]).array(n),
        Real::output(name("pressure_jump"), "Pa", jump, move |m| &m.flow.plane().pressure_jump()[k])
            .array(n)
            .depends_on(&[]),
    ];
    if line {
        let text = "Shear stress on both faces of the line, towards the tip";
        let shear = Real::output(name("shear"), "Pa", text, move |m| &m.flow.plane().shear()[k]);
        list.push(shear.array(n).depends_on(&[]));
    }
    if loads {
        list.extend(
            [
                Real::output(name("force_x"), "N/m", load, move |m| &m.flow.plane().loads()[k].force[0]),
                Real::output(name("force_y"), "N/m", load, move |m| &m.flow.plane().loads()[k].force[1]),
                Real::output(name("impedance"), "kg/(m.s)", impedance, move |m| &m.flow.plane().loads()[k].impedance),
            ]
            .map(|variable| variable.array(n).depends_on(&[])),
        );
    }
    if pressure {
        let text = "Pressure around the beam, the mean of both sides, less that of the outlet";
        let pressure = Real::output(name("pressure"), "Pa", text, move |m| &m.flow.plane().pressure_around()[k]);
        list.push(pressure.array(n).depends_on(&[]));
    }
    list
}
