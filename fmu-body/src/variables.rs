//! List of the variables, in the order of their value references.

use std::slice::from_mut;

use adapter::along_axes;
use rigid::Placed;

use crate::unit::{BodyUnit, Carrying};

type Real = fmi_export::Real<BodyUnit>;
type Variable = fmi_export::Variable<BodyUnit>;

/// Return the variables of a unit, without the variables of absent parts.
pub fn list(unit: &BodyUnit) -> Vec<Variable> {
    let mut list = vec![
        Real::time(),
        Real::parameter("mass", "kg", "Mass without what the body carries", |m| from_mut(&mut m.mass)).above(0.0),
    ];
    list.extend(along_axes(3, |d, axis| {
        Real::parameter(format!("gravity.{axis}"), "m/s2", "Gravity", move |m| from_mut(&mut m.gravity[d]))
    }));
    list.push(Real::input("step", "s", "Length of the coming step", |m| from_mut(&mut m.step)).above(0.0));
    if unit.fluid.is_some() {
        list.extend(of_fluid());
    }
    for (k, own) in unit.hinges.iter().enumerate() {
        list.extend(hinge_inputs(k, own));
    }
    list.extend(motion().into_iter().map(|output| output.depends_on(&[])));
    for (k, own) in unit.hinges.iter().enumerate() {
        let text = "if the body keeps its accelerations in the coming step";
        list.extend(root(&format!("{}.reference.", own.name), text, own, move |m| m.reference(k)));
        let at_the_end = |output: Variable| output.depends_on(&[]);
        list.extend(
            root(&format!("{}.root.", own.name), "at the end of the step", own, move |m| m.root(k))
                .into_iter()
                .map(at_the_end),
        );
    }
    list
}

/// Return what the fluid announces.
fn of_fluid() -> Vec<Variable> {
    let mut list = Vec::new();
    list.extend(along_axes(3, |d, axis| {
        let text = "Force of the fluid on the body if it keeps its velocities";
        Real::input(format!("load.force_{axis}"), "N", text, move |m| {
            m.fluid.as_mut().map_or(&mut [], |fluid| from_mut(&mut fluid.force[d]))
        })
    }));
    list.extend(along_axes(3, |d, axis| {
        let text = "Moment of that force about the pivot";
        Real::input(format!("load.moment_{axis}"), "N.m", text, move |m| {
            m.fluid.as_mut().map_or(&mut [], |fluid| from_mut(&mut fluid.moment[d]))
        })
    }));
    let text = "Rows of the rate at which they fall with the velocities of the body";
    let impedance = Real::input("load.impedance", "1", text, |m| {
        m.fluid.as_mut().map_or(&mut [], |fluid| fluid.impedance.as_flattened_mut())
    });
    list.push(impedance.array(36));
    list
}

/// Return the angles of a hinge that the master moves, and what it carries announces.
fn hinge_inputs(k: usize, own: &Carrying) -> Vec<Variable> {
    let (name, mut list) = (&own.name, Vec::new());
    if own.is_driven() {
        for (i, angle) in ["stroke", "deviation", "pitch"].into_iter().enumerate() {
            let text = "Angle of the hinge at the end of the step";
            list.push(Real::input(format!("{name}.{angle}"), "rad", text, move |m| {
                from_mut(&mut m.hinges[k].angles[i])
            }));
            list.push(Real::input(format!("{name}.{angle}_rate"), "rad/s", "Rate of that angle", move |m| {
                from_mut(&mut m.hinges[k].rates[i])
            }));
        }
    }
    let text = "Force, N, and moment, N m, on the body in the coming step";
    list.push(
        Real::input(format!("{name}.root.reaction"), "1", text, move |m| &mut m.hinges[k].response.reaction).array(6),
    );
    let text = "Rows of the rate at which they fall with the root's velocities";
    list.push(
        Real::input(format!("{name}.root.impedance"), "1", text, move |m| {
            m.hinges[k].response.impedance.as_flattened_mut()
        })
        .array(36),
    );
    list.extend(along_axes(3, |d, axis| {
        let text = "Force of the body on the root in the last step";
        Real::input(format!("{name}.root.force_{axis}"), "N", text, move |m| from_mut(&mut m.hinges[k].force[d]))
    }));
    list.extend(along_axes(3, |d, axis| {
        let text = "Moment of the body about the root in the last step";
        Real::input(format!("{name}.root.moment_{axis}"), "N.m", text, move |m| from_mut(&mut m.hinges[k].moment[d]))
    }));
    list
}

/// Return place and motion of the body, its momentum and its energies.
fn motion() -> Vec<Variable> {
    let of = |name: String, unit: &str, text: &str, d: usize, read: fn(&BodyUnit) -> [f64; 3]| {
        Real::computed(name, unit, text, move |m: &mut BodyUnit| read(m)[d])
    };
    let mut list = Vec::new();
    list.extend(along_axes(3, |d, axis| {
        of(axis.into(), "m", "Position of the pivot", d, |m| m.body().state.now.position.into())
    }));
    list.extend(along_axes(3, |d, axis| {
        of(format!("v{axis}"), "m/s", "Velocity of the pivot", d, |m| m.body().state.now.velocity.into())
    }));
    list.extend(along_axes(3, |d, axis| {
        of(format!("angle_{axis}"), "rad", "Component of the rotation vector from rest", d, |m| m.angle)
    }));
    list.extend(along_axes(3, |d, axis| {
        of(format!("omega_{axis}"), "rad/s", "Angular velocity", d, |m| m.body().state.now.omega.into())
    }));
    list.extend(along_axes(3, |d, axis| {
        of(format!("momentum.{axis}"), "kg.m/s", "Momentum of the body", d, |m| m.body().momentum()[0].into())
    }));
    list.extend(along_axes(3, |d, axis| {
        let text = "Angular momentum of the body about the origin";
        of(format!("angular_momentum.{axis}"), "kg.m2/s", text, d, |m| m.body().momentum()[1].into())
    }));
    list.extend([
        Real::computed("energy.kinetic", "J", "Kinetic energy", |m| m.body().energy()[0]),
        Real::computed("energy.gravity", "J", "Potential energy in gravity, 0 at rest", |m| m.body().energy()[1]),
    ]);
    list
}

/// Return place and motion of a root, with names and units of the inputs of what the hinge carries.
fn root(
    prefix: &str,
    when: &str,
    own: &Carrying,
    read: impl Fn(&BodyUnit) -> Placed + Copy + Send + Sync + 'static,
) -> Vec<Variable> {
    let output = |name: String, unit: &str, what: &str, of: fn(&Placed) -> [f64; 3], d: usize| {
        let name = format!("{prefix}{name}");
        Real::computed(name, unit, format!("{what} of the root {when}"), move |m| of(&read(m))[d])
    };
    let mut list = Vec::new();
    list.extend(along_axes(3, |d, axis| output(axis.into(), "m", "Position", |at| at.position.into(), d)));
    list.extend(along_axes(3, |d, axis| output(format!("v{axis}"), "m/s", "Velocity", |at| at.velocity.into(), d)));
    if let Some(direction) = own.direction {
        let along = move |m: &BodyUnit| (read(m), read(m).orientation * direction);
        list.extend(along_axes(3, |d, axis| {
            let (name, text) = (format!("{prefix}direction.{axis}"), format!("Direction of the rod {when}"));
            Real::computed(name, "1", text, move |m: &mut BodyUnit| along(m).1[d])
        }));
        list.extend(along_axes(3, |d, axis| {
            let (name, text) = (format!("{prefix}direction_rate.{axis}"), format!("Rate of the direction {when}"));
            Real::computed(name, "1/s", text, move |m: &mut BodyUnit| {
                let (at, direction) = along(m);
                at.omega.cross(&direction)[d]
            })
        }));
        return list;
    }
    let text = format!("Turn of the root {when}");
    let rotation = Real::output(format!("{prefix}rotation"), "1", text, move |m: &mut BodyUnit| {
        let turn = read(m).orientation.to_rotation_matrix();
        m.rotation = std::array::from_fn(|i| turn[(i / 3, i % 3)]);
        &m.rotation[..]
    });
    list.push(rotation.array(9));
    list.extend(along_axes(3, |d, axis| {
        output(format!("omega_{axis}"), "rad/s", "Angular velocity", |at| at.omega.into(), d)
    }));
    list
}
