//! List of the variables, in the order of their value references.

use std::slice::{from_mut, from_ref};

use adapter::{AXES, Carried, either};
use rod::{RootSupport, Statistics, Taper};
use scene::RootMotion;

use crate::body::Body;
use crate::unit::RodUnit;

type Real = fmi_export::Real<RodUnit>;
type Integer = fmi_export::Integer<RodUnit>;
type Text = fmi_export::Text<RodUnit>;
type Variable = fmi_export::Variable<RodUnit>;

/// Return the variables of a unit, without the variables of absent parts.
pub fn list(unit: &RodUnit) -> Vec<Variable> {
    let mut list = vec![Real::time()];
    list.extend(parameters(unit));
    list.extend(load_inputs(unit));
    if unit.rod.root_motion == Some(RootMotion::Master) {
        list.extend(base_inputs(unit));
    }
    // Outputs belong to the end of a step.
    let at_the_end = |output: Variable| output.depends_on(&[]);
    list.extend(station_outputs(unit).into_iter().map(at_the_end));
    list.extend(hinge_outputs(unit).into_iter().map(at_the_end));
    list.extend(slide_outputs(unit).into_iter().map(at_the_end));
    if unit.rod.root_motion.is_some() || matches!(unit.rod.root, scene::RootSupport::Free { .. }) {
        list.extend(drive_outputs(unit).into_iter().map(at_the_end));
    }
    if unit.scene.load().is_some() {
        list.extend([
            Text::local("load.name", "Load that the rod receives from the fluid", |m| from_ref(&m.load[0])).constant(),
            Text::local("load.reason", "Reason for the choice of the load", |m| from_ref(&m.load[1])).constant(),
        ]);
    }
    list.extend(energy_and_newton_outputs(unit).map(at_the_end));
    if unit.announced.is_some() {
        list.extend(adapter::response());
    }
    if unit.scene.contact.is_some() {
        let text = "Energy of contact";
        let energy = Real::output("energy.contact", per(unit, "J", "J/m"), text, |m| from_ref(&m.energy.contact));
        list.push(at_the_end(energy));
    }
    list
}

/// Return a variable for each axis of a unit.
fn along_axes(unit: &RodUnit, make: impl Fn(usize, &str) -> Variable) -> impl Iterator<Item = Variable> {
    adapter::along_axes(unit.plan.count(), make)
}

/// Return `spatial` in space and `planar` in the plane, where quantities are per metre of depth.
fn per<'a>(unit: &RodUnit, spatial: &'a str, planar: &'a str) -> &'a str {
    if unit.plan.count() == 2 { planar } else { spatial }
}

/// Return an output read from a body.
fn output(
    name: impl Into<String>,
    unit: &str,
    text: impl Into<String>,
    read: impl Fn(&Body) -> f64 + Send + Sync + 'static,
) -> Variable {
    Real::computed(name, unit, text, move |m: &mut RodUnit| read(m.body()))
}

fn parameters(unit: &RodUnit) -> Vec<Variable> {
    let per = |spatial, planar| per(unit, spatial, planar);
    let tapered = either!(&unit.plan, parameters => parameters.taper != Taper::default());
    let text = |text: &str| if tapered { format!("{text}, at the root") } else { text.to_string() };
    let mut list = vec![
        Real::parameter("line_density", per("kg/m", "kg/m2"), text("Mass of the section per length"), |m| {
            from_mut(&mut m.parameters.section.line_density)
        })
        .above(0.0),
        Real::parameter("bending_stiffness", per("N.m2", "N.m"), text("Bending stiffness EI"), |m| {
            from_mut(&mut m.parameters.section.bending_stiffness)
        })
        .above(0.0),
        Real::parameter("axial_stiffness", per("N", "N/m"), text("Axial stiffness EA"), |m| {
            from_mut(&mut m.parameters.section.axial_stiffness)
        })
        .above(0.0),
        Real::parameter("damping", per("kg/(m.s)", "kg/(m2.s)"), "Damping force per length and velocity", |m| {
            from_mut(&mut m.parameters.damping)
        })
        .at_least(0.0),
        Real::parameter(
            "clamp_compliance_length",
            "m",
            "Length of rod whose bending compliance is added to the clamp",
            |m| from_mut(&mut m.parameters.clamp_compliance_length),
        )
        .at_least(0.0),
    ];
    if !unit.loads.impedance.is_empty() {
        list.push(
            Real::parameter(
                "displaced_line_density",
                per("kg/m", "kg/m2"),
                text("Mass of the displaced fluid per length"),
                |m| from_mut(&mut m.parameters.displaced_line_density),
            )
            .at_least(0.0),
        );
    }
    if unit.parameters.section.shear_stiffness.is_some() {
        list.push(
            Real::parameter("shear_stiffness", "N/m", text("Shear stiffness GA_s"), |m| {
                m.parameters.section.shear_stiffness.as_mut_slice()
            })
            .above(0.0),
        );
    }
    list.extend(along_axes(unit, |d, axis| {
        Real::parameter(format!("gravity.{axis}"), "m/s2", "Gravity", move |m| from_mut(&mut m.parameters.gravity[d]))
    }));
    list
}

/// Return the loads on the stations.
fn load_inputs(unit: &RodUnit) -> Vec<Variable> {
    let (loads, stations) = (&unit.loads, unit.stations());
    let mut list = Vec::new();
    if !loads.force.is_empty() {
        let text = "Load on the stations at the end of the step";
        list.extend(along_axes(unit, |d, axis| {
            let (name, unit) = (format!("force_{axis}"), per(unit, "N", "N/m"));
            Real::input(name, unit, text, move |m| m.force_mut(d)).array(stations)
        }));
    }
    list.push(
        Real::input(
            "impedance",
            per(unit, "kg/s", "kg/(m.s)"),
            "Decrease of the load per velocity of the station",
            |m| {
                m.mark_stale();
                &mut m.loads.impedance
            },
        )
        .at_least(0.0)
        .array(loads.impedance.len()),
    );
    list.push(
        Real::input("pressure_jump", "Pa", "Pressure above minus below the beam", |m| &mut m.loads.pressure_jump)
            .array(loads.pressure_jump.len()),
    );
    list.push(
        Real::input("pressure", "Pa", "Pressure around the beam", |m| &mut m.loads.pressure)
            .array(loads.pressure.len()),
    );
    list
}

/// Return the motion of the root as inputs of a master that drives it.
fn base_inputs(unit: &RodUnit) -> Vec<Variable> {
    let mut list = Vec::new();
    let driven = |make: &dyn Fn(usize, &str) -> Variable| {
        let axes = AXES[..unit.plan.count()].iter().enumerate();
        axes.filter(|(d, _)| slide_axis(unit) != Some(*d)).map(|(d, axis)| make(d, axis)).collect::<Vec<_>>()
    };
    list.extend(driven(&|d, axis| {
        let text = "Position of the root at the end of the step";
        Real::input(format!("root.{axis}"), "m", text, move |m| from_mut(&mut m.base_mut().position[d]))
    }));
    list.extend(driven(&|d, axis| {
        let text = "Velocity of the root at the end of the step";
        Real::input(format!("root.v{axis}"), "m/s", text, move |m| from_mut(&mut m.base_mut().velocity[d]))
    }));
    if unit.support() == RootSupport::Pinned {
        return list;
    }
    if unit.plan.count() == 2 {
        let text = "Angle of the beam at the root, from the x axis";
        list.push(Real::input("root.angle", "rad", text, |m| from_mut(&mut m.base.angle)));
        let text = "Rate of the angle at the root";
        list.push(Real::input("root.omega", "rad/s", text, |m| from_mut(&mut m.base.omega)));
        return list;
    }
    list.extend(along_axes(unit, |d, axis| {
        let text = "Direction of the beam at the root, of any length";
        Real::input(format!("root.direction.{axis}"), "1", text, move |m| from_mut(&mut m.base_mut().direction[d]))
    }));
    list.extend(along_axes(unit, |d, axis| {
        let (name, text) = (format!("root.direction_rate.{axis}"), "Rate of the direction at the root");
        Real::input(name, "1/s", text, move |m| from_mut(&mut m.base_mut().direction_rate[d]))
    }));
    list
}

/// Return the motion of the stations and of the tip, and force, power and work of the loads.
fn station_outputs(unit: &RodUnit) -> Vec<Variable> {
    let stations = unit.stations();
    let mut list = Vec::new();
    list.extend(along_axes(unit, |d, axis| {
        Real::output(axis, "m", "Position of the stations", move |m| either!(m.body(), rod => rod.positions(d)))
            .array(stations)
    }));
    list.extend(along_axes(unit, |d, axis| {
        let text = "Velocity of the stations";
        Real::output(format!("v{axis}"), "m/s", text, move |m| either!(m.body(), rod => rod.velocities(d)))
            .array(stations)
    }));
    list.extend(along_axes(unit, |d, axis| {
        output(
            format!("tip.u{axis}"),
            "m",
            "Displacement of the tip",
            move |body| either!(body, rod => rod.tip_displacement()[d]),
        )
    }));
    list.extend(along_axes(unit, |d, axis| {
        let text = "Velocity of the tip";
        output(format!("tip.v{axis}"), "m/s", text, move |body| either!(body, rod => rod.velocities(d)[stations - 1]))
    }));
    list.extend(along_axes(unit, |d, axis| {
        let text = format!("Sum of the loads on the stations along {axis} at the end of the step");
        output(
            format!("load.{axis}"),
            per(unit, "N", "N/m"),
            text,
            move |body| either!(body, rod => rod.state().exchange.force[d]),
        )
    }));
    let work = "Work of the loads since the start: the sum of power times step";
    list.extend([
        output(
            "load.power",
            per(unit, "W", "W/m"),
            "Power of the loads at the end of the step",
            |body| either!(body, rod => rod.state().exchange.power),
        ),
        output("load.work", per(unit, "J", "J/m"), work, |body| either!(body, rod => rod.state().exchange.work)),
    ]);
    list
}

/// Return angle and rate of a torsion spring at the root, in the plane.
fn hinge_outputs(unit: &RodUnit) -> Vec<Variable> {
    let spring = matches!(unit.support(), RootSupport::TorsionSpring { .. }) && unit.plan.count() == 2;
    if !spring {
        return Vec::new();
    }
    let of_hinge = |name: &str, unit: &str, text: &str, i: usize| {
        output(name, unit, text, move |body| either!(body, rod => rod.hinge().unwrap_or_default()[i]))
    };
    vec![
        of_hinge("hinge.angle", "rad", "Angle of the torsion spring, positive to the left", 0),
        of_hinge("hinge.omega", "rad/s", "Rate of the angle of the torsion spring", 1),
    ]
}

/// Return displacement and velocity of the root along its slide.
fn slide_outputs(unit: &RodUnit) -> Vec<Variable> {
    let Some(axis) = slide_axis(unit) else { return Vec::new() };
    let name = AXES[axis];
    vec![
        output(
            format!("root.u{name}"),
            "m",
            format!("Displacement of the root along {name}, on its slide"),
            move |body| either!(body, rod => rod.state().positions[0][axis] - rod.parameters().attachment[axis]),
        ),
        output(
            format!("root.v{name}"),
            "m/s",
            format!("Velocity of the root along {name}, on its slide"),
            move |body| either!(body, rod => rod.velocities(axis)[0]),
        ),
    ]
}

/// Return the axis along which the root slides.
fn slide_axis(unit: &RodUnit) -> Option<usize> {
    either!(&unit.plan, parameters => parameters.slide.map(|slide| slide.axis))
}

/// Return force, moment, power and work of a drive or of a towing force.
fn drive_outputs(unit: &RodUnit) -> Vec<Variable> {
    let mut list = Vec::new();
    let free = unit.support() == RootSupport::Free;
    let turns = matches!(unit.support(), RootSupport::Clamped | RootSupport::TorsionSpring { .. });
    if turns {
        list.extend(along_axes(unit, |d, axis| {
            output(
                format!("rigid_tip.u{axis}"),
                "m",
                "Displacement of the tip of a rigid rod",
                move |body| either!(body, rod => rod.rigid_tip_displacement()[d]),
            )
        }));
    }
    list.extend(along_axes(unit, |d, axis| {
        let text = format!("{} force on the root along {axis}", if free { "Towing" } else { "Driving" });
        output(
            format!("root.force_{axis}"),
            per(unit, "N", "N/m"),
            text,
            move |body| either!(body, rod => rod.state().drive.force[d]),
        )
    }));
    let moment = |name: &str, unit: &str, d: usize| {
        let text = "Driving moment about the root";
        output(name, unit, text, move |body| either!(body, rod => rod.state().drive.moment[d]))
    };
    if turns && unit.plan.count() == 2 {
        list.push(moment("root.moment", "N.m/m", 2));
    } else if turns {
        list.extend(along_axes(unit, |d, axis| moment(&format!("root.moment_{axis}"), "N.m", d)));
    }
    let of = match (free, turns) {
        (true, _) => "the towing force",
        (_, true) => "the driving force and moment",
        _ => "the driving force",
    };
    let (power, work) = (format!("Power of {of} at the end of the step"), format!("Work of {of} since the start"));
    list.extend([
        output("root.power", per(unit, "W", "W/m"), power, |body| either!(body, rod => rod.state().drive.power)),
        output(
            "root.work",
            per(unit, "J", "J/m"),
            format!("{work}: the sum of power times step"),
            |body| either!(body, rod => rod.state().drive.work),
        ),
        output(
            "damping.power",
            per(unit, "W", "W/m"),
            "Power lost by damping at the end of the step",
            |body| either!(body, rod => rod.damping_power()),
        ),
    ]);
    list
}

/// Return the energies and the effort of the last step.
fn energy_and_newton_outputs(unit: &RodUnit) -> [Variable; 7] {
    let unit = per(unit, "J", "J/m");
    let count = |name: &str, text: &str, of: fn(Statistics) -> usize| {
        Integer::count(name, text, move |m| of(either!(m.body(), rod => rod.statistics())))
    };
    [
        Real::computed("energy.elastic", unit, "Energy of extension, bending and shear", |m| {
            m.energy.stretching + m.energy.bending
        }),
        Real::output("energy.kinetic", unit, "Kinetic energy of the rod without displaced fluid", |m| {
            from_ref(&m.energy.kinetic)
        }),
        Real::output("energy.gravity", unit, "Potential energy in gravity, 0 at the root at rest", |m| {
            from_ref(&m.energy.gravity)
        }),
        count("newton.iterations", "Newton iterations of the last step", |s| s.iterations),
        count("newton.substeps", "Sub-steps of the last step", |s| s.substeps),
        count("newton.rescues", "Solves of the last step that needed shift and line search", |s| s.rescues),
        count("newton.negative_pivots", "Largest number of negative pivots in the last step", |s| s.negative_pivots),
    ]
}
