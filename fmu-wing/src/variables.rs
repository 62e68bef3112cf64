//! List of the variables, in the order of their value references.

use std::slice::{from_mut, from_ref};

use adapter::{Carried, along_axes};
use wing::Membrane;

use crate::WingUnit;

type Real = fmi_export::Real<WingUnit>;
type Integer = fmi_export::Integer<WingUnit>;
type Variable = fmi_export::Variable<WingUnit>;

/// Return the variables of a unit, without the variables of absent parts.
pub fn list(unit: &WingUnit) -> Vec<Variable> {
    let mut list = vec![Real::time()];
    list.extend(parameters(unit));
    list.extend(inputs(unit));
    if unit.base.is_some() {
        list.extend(base_inputs());
    }
    // Outputs belong to the end of a step.
    list.extend(outputs(unit).into_iter().map(|output| output.depends_on(&[])));
    if unit.announced.is_some() {
        list.extend(adapter::response());
    }
    list
}

fn parameters(unit: &WingUnit) -> Vec<Variable> {
    let of_membrane = |name: &str, of: &str, text: &str, select: fn(&mut Membrane) -> &mut f64| {
        Real::parameter(format!("membrane.{name}"), of, text, move |m| match &mut m.parameters.membrane {
            Some(membrane) => from_mut(select(membrane)),
            None => &mut [],
        })
    };
    let mut list = Vec::new();
    if unit.parameters.membrane.is_some() {
        list.extend([
            of_membrane("areal_density", "kg/m2", "Mass of the membrane per area", |m| &mut m.areal_density).above(0.0),
            of_membrane("stretching_stiffness", "N/m", "Stiffness E h in the plane", |m| &mut m.stretching_stiffness)
                .above(0.0),
            of_membrane("bending_stiffness", "N.m", "Bending stiffness", |m| &mut m.bending_stiffness).at_least(0.0),
            of_membrane("tension", "N/m", "Tension at rest", |m| &mut m.tension).at_least(0.0),
        ]);
    }
    let text = "Relaxation time of strain and curvature";
    list.push(
        Real::parameter("relaxation_time", "s", text, |m| from_mut(&mut m.parameters.relaxation_time)).at_least(0.0),
    );
    if unit.scene.fluid.is_some() {
        let text = "Mass of the fluid per area whose inertia the loads account for";
        let displaced =
            Real::parameter("displaced_density", "kg/m2", text, |m| from_mut(&mut m.parameters.displaced_density));
        list.push(displaced.at_least(0.0));
    }
    list.extend(along_axes(3, |d, axis| {
        Real::parameter(format!("gravity.{axis}"), "m/s2", "Gravity", move |m| from_mut(&mut m.parameters.gravity[d]))
    }));
    list
}

/// Return the loads on the nodes.
fn inputs(unit: &WingUnit) -> Vec<Variable> {
    let nodes = unit.nodes();
    let mut list: Vec<_> = along_axes(3, |d, axis| {
        let text = "Load on the nodes at the end of the step";
        Real::input(format!("force_{axis}"), "N", text, move |m| {
            m.mark_stale();
            &mut m.loads.force[d * nodes..(d + 1) * nodes]
        })
        .array(nodes)
    })
    .collect();
    let text = "Decrease of the load per velocity of the node";
    let impedance = Real::input("impedance", "kg/s", text, |m| {
        m.mark_stale();
        &mut m.loads.impedance
    });
    list.push(impedance.at_least(0.0).array(nodes));
    list
}

/// Return the motion of the base as inputs of a master that moves it.
fn base_inputs() -> Vec<Variable> {
    let mut list = Vec::new();
    list.extend(along_axes(3, |d, axis| {
        let text = "Position of the pivot at the end of the step";
        Real::input(format!("root.{axis}"), "m", text, move |m| from_mut(&mut m.base_mut().position[d]))
    }));
    list.extend(along_axes(3, |d, axis| {
        let text = "Velocity of the pivot at the end of the step";
        Real::input(format!("root.v{axis}"), "m/s", text, move |m| from_mut(&mut m.base_mut().velocity[d]))
    }));
    let text = "Rows of the matrix that turns the base from rest";
    list.push(Real::input("root.rotation", "1", text, |m| &mut m.base_mut().rotation).array(9));
    list.extend(along_axes(3, |d, axis| {
        let text = "Angular velocity of the base at the end of the step";
        Real::input(format!("root.omega_{axis}"), "rad/s", text, move |m| from_mut(&mut m.base_mut().omega[d]))
    }));
    list
}

/// Return the motion of the nodes, the exchange with loads and base, the energies and the effort of the last step.
fn outputs(unit: &WingUnit) -> Vec<Variable> {
    let nodes = unit.nodes();
    let output = |name: &str, of: &str, text: &str, read: fn(&WingUnit) -> f64| {
        Real::computed(name, of, text, move |m: &mut WingUnit| read(m))
    };
    let mut list = Vec::new();
    list.extend(along_axes(3, |d, axis| {
        Real::output(axis, "m", "Position of the nodes", move |m| m.wing().positions(d)).array(nodes)
    }));
    list.extend(along_axes(3, |d, axis| {
        let text = "Velocity of the nodes";
        Real::output(format!("v{axis}"), "m/s", text, move |m| m.wing().velocities(d)).array(nodes)
    }));
    list.extend(along_axes(3, |d, axis| {
        let text = "Displacement of the node farthest from the pivot";
        Real::computed(format!("tip.u{axis}"), "m", text, move |m| {
            m.wing().positions(d)[m.tip] - m.rest.mesh.nodes[m.tip][d]
        })
    }));
    list.extend(along_axes(3, |d, axis| {
        let text = "Velocity of the node farthest from the pivot";
        Real::computed(format!("tip.v{axis}"), "m/s", text, move |m| m.wing().velocities(d)[m.tip])
    }));
    if unit.own.root_motion.is_some() || unit.base.is_some() {
        list.extend(along_axes(3, |d, axis| {
            let text = "Displacement of that node on a rigid wing";
            Real::computed(format!("rigid_tip.u{axis}"), "m", text, move |m| {
                let (base, node) = (&m.wing().state().own.base, m.rest.mesh.nodes[m.tip]);
                let arm: [f64; 3] = std::array::from_fn(|e| node[e] - m.own.pivot[e]);
                base.displacement[d] + (0..3).map(|e| base.rotation[d][e] * arm[e]).sum::<f64>() - arm[d]
            })
        }));
    }
    list.extend(along_axes(3, |d, axis| {
        let text = "Sum of the loads on the nodes at the end of the step";
        Real::computed(format!("load.{axis}"), "N", text, move |m| m.wing().state().exchange.force[d])
    }));
    list.push(output("load.power", "W", "Power of the loads at the end of the step", |m| {
        m.wing().state().exchange.power
    }));
    list.push(output("load.work", "J", "Work of the loads since the start: the sum of power times step", |m| {
        m.wing().state().exchange.work
    }));
    if unit.own.root.is_some() {
        list.extend(along_axes(3, |d, axis| {
            let text = "Force of the base on the root";
            Real::computed(format!("root.force_{axis}"), "N", text, move |m| m.wing().state().drive.force[d])
        }));
        list.extend(along_axes(3, |d, axis| {
            let (name, text) = (format!("root.moment_{axis}"), "Moment of the base about the pivot");
            Real::computed(name, "N.m", text, move |m| m.wing().state().drive.moment[d])
        }));
        list.push(output("root.power", "W", "Power of the base at the end of the step", |m| {
            m.wing().state().drive.power
        }));
        list.push(output("root.work", "J", "Work of the base since the start: the sum of power times step", |m| {
            m.wing().state().drive.work
        }));
    }
    if unit.rest.have_section() {
        let text =
            "Turn of the chord at three quarters of the span about the span, from its direction on the base at rest";
        list.push(output("section.twist", "rad", text, |m| m.wing().twist().unwrap_or_default()));
        let text =
            "Largest distance of the membrane from that chord, by its length, positive along the triangles' normal";
        list.push(output("section.camber", "1", text, |m| m.wing().camber().unwrap_or_default()));
    }
    if unit.scene.contact.is_some() {
        list.push(Real::output("energy.contact", "J", "Energy of contact", |m| from_ref(&m.energy.contact)));
    }
    list.push(output("damping.power", "W", "Power lost by damping at the end of the step", |m| m.damping_power));
    list.extend([
        output("energy.elastic", "J", "Energy of membrane and veins", |m| {
            m.energy.stretching + m.energy.bending + m.energy.veins
        }),
        Real::output("energy.kinetic", "J", "Kinetic energy", |m| from_ref(&m.energy.kinetic)),
        Real::output("energy.gravity", "J", "Potential energy in gravity, 0 at rest", |m| from_ref(&m.energy.gravity)),
        Integer::count("newton.iterations", "Newton iterations of the last step", |m| m.wing().statistics().iterations),
        Integer::count("newton.substeps", "Sub-steps of the last step", |m| m.wing().statistics().substeps),
        Integer::count("newton.rescues", "Solves of the last step that needed a line search", |m| {
            m.wing().statistics().rescues
        }),
        Integer::count("newton.factorisations", "Factorisations of the last step", |m| {
            m.wing().statistics().factorisations
        }),
        Integer::count("crossings", "Pairs of triangles that cross each other", |m| m.crossings),
    ]);
    list
}
