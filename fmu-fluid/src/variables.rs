//! The list of the variables, in the order of their value references.

use std::slice::from_mut;

use fluid::{Fluid, Force};

use super::FluidUnit;

type Real = fmi2::Real<FluidUnit>;
type Variable = fmi2::Variable<FluidUnit>;

/// The variables of a unit; the parts that its scene has not are left out.
pub fn of(unit: &FluidUnit) -> Vec<Variable> {
    let part = unit.scene.fluid.as_ref().expect("loading refuses a scene without a fluid");
    let (cylinders, bodies, beam) = (part.cylinders.len(), part.bodies.len(), unit.scene.beam.is_some());
    let mut list = parameters_and_totals();
    if cylinders > 0 || bodies > 0 || beam {
        let all = if bodies > 0 { "all bodies" } else { "all cylinders and the beam" };
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
    }
    if beam {
        list.extend(force("beam", "the beam", "its root", |fluid| fluid.force_on_beam().unwrap_or_default()));
        list.extend(exchange());
    }
    for (k, probe) in part.probes.iter().enumerate() {
        let (name, [x, y]) = (&probe.name, probe.position);
        let text = |what| format!("{what} at ({x}, {y})");
        list.extend([
            output(format!("probe.{name}.u"), "m/s", text("Velocity along x"), move |f| f.probe_velocity(k)[0]),
            output(format!("probe.{name}.v"), "m/s", text("Velocity along y"), move |f| f.probe_velocity(k)[1]),
            output(format!("probe.{name}.p"), "Pa", text("Static pressure"), move |f| f.probe_pressure(k)),
        ]);
    }
    if let Some(stations) = unit.fluid.stations() {
        list.extend(station_variables(
            stations.len(),
            unit.fluid.loads().is_some(),
            unit.scene.strain_per_pressure().is_some(),
        ));
    }
    list
}

/// A number that is read off the fluid when it is asked for.
fn output(
    name: impl Into<String>,
    unit: &str,
    text: impl Into<String>,
    read: impl Fn(&mut Fluid) -> f64 + Copy + Send + Sync + 'static,
) -> Variable {
    Real::output(name, unit, text, move |m| m.ask(read)).depends_on(&[])
}

/// What every scene has.
fn parameters_and_totals() -> Vec<Variable> {
    let local = |name: &str, unit: &str, text: &str, read: fn(&mut Fluid) -> f64| {
        Real::local(name, unit, text, move |m: &mut FluidUnit| m.ask(read))
    };
    vec![
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
        Real::parameter("max_cfl", "1", "Largest CFL number max(|u|/dx + |v|/dy) dt", |m| {
            from_mut(&mut m.parameters.max_cfl)
        })
        .above(0.0),
        output("cfl", "1", "CFL number of the last step", |fluid| fluid.cfl()),
        output("flow_rate", "m2/s", "Flow rate through the middle of the box per metre of depth", |f| f.flow_rate()),
        local("kinetic_energy", "J/m", "Kinetic energy of the whole box per metre of depth", |f| f.kinetic_energy()),
        local("enstrophy", "m2/s2", "Half the integral of the squared vorticity over the whole box", |f| f.enstrophy()),
        local("divergence", "1", "Largest divergence times the cell size over the largest speed", Fluid::divergence),
    ]
}

/// Drag, lift and moment of a body under a name.
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

/// Power of the force on body number `k` under a name, and where the body is.
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

/// What the fluid did to the beam in the last step, to be compared with what the rod took.
fn exchange() -> [Variable; 4] {
    let sum = |axis| format!("Sum of what the fluid exerted on the stations along {axis}: no unsteady term");
    let power = "Power of what the fluid exerted on the stations, at the end of the step";
    let work = "Its work since the start: the sum of power times step";
    [
        output("beam.load_x", "N/m", sum("x"), |fluid| fluid.exchange().unwrap_or_default().force[0]),
        output("beam.load_y", "N/m", sum("y"), |fluid| fluid.exchange().unwrap_or_default().force[1]),
        output("beam.power", "W/m", power, |fluid| fluid.exchange().unwrap_or_default().power),
        output("beam.work", "J/m", work, |fluid| fluid.exchange().unwrap_or_default().work),
    ]
}

/// Motion of `n` stations in, pressure jump and, where the scene has them, loads and pressure around the beam out.
fn station_variables(n: usize, loads: bool, pressure: bool) -> Vec<Variable> {
    let (position, velocity) =
        ("Position of the stations at the end of the step", "Velocity of the stations at the end of the step");
    let (jump, load) = ("Pressure above minus below the beam", "Load on the stations for the coming step");
    let impedance = "Rate at which the load falls with the station's velocity";
    let mut list = vec![
        Real::input("x", "m", position, |m| &mut m.stations().position[0]).array(n),
        Real::input("y", "m", position, |m| &mut m.stations().position[1]).array(n),
        Real::input("vx", "m/s", velocity, |m| &mut m.stations().velocity[0]).array(n),
        Real::input("vy", "m/s", velocity, |m| &mut m.stations().velocity[1]).array(n),
        Real::output("pressure_jump", "Pa", jump, |m| m.fluid.pressure_jump().unwrap_or_default())
            .array(n)
            .depends_on(&[]),
    ];
    if loads {
        list.extend(
            [
                Real::output("force_x", "N/m", load, |m| &m.loads().force[0]),
                Real::output("force_y", "N/m", load, |m| &m.loads().force[1]),
                Real::output("impedance", "kg/(m.s)", impedance, |m| &m.loads().impedance),
            ]
            .map(|variable| variable.array(n).depends_on(&[])),
        );
    }
    if pressure {
        let text = "Pressure around the beam, the mean of both sides, less that of the outlet";
        let pressure = Real::output("pressure", "Pa", text, |m| m.fluid.pressure_around().unwrap_or_default());
        list.push(pressure.array(n).depends_on(&[]));
    }
    list
}
