//! The list of the variables, in the order of their value references.
//!
//! Quantities of the plane are per metre of depth. A moment is about z there; in space it has a component about each
//! axis.

use std::slice::from_mut;

use adapter::{AXES, FlexibleNames, per_depth};
use fluid::{Fluid, Force, Kinematics, Pose, Spin, Stations};
use scene::{Followed, Load, Surface};

use super::FluidUnit;
use super::flow::{Counted, Flow, FlowIn};

type Real = fmi_export::Real<FluidUnit>;
type Variable = fmi_export::Variable<FluidUnit>;

/// Names of the force along each axis.
const FORCES: [&str; 3] = ["drag", "lift", "side"];
/// Names of the velocity along each axis.
const VELOCITIES: [&str; 3] = ["u", "v", "w"];

/// Return the variables of a unit; absent parts of the scene have none.
pub fn of(unit: &FluidUnit) -> Vec<Variable> {
    match &unit.flow {
        Flow::Plane(flow) => List::of(unit, flow),
        Flow::Space(flow) => List::of(unit, flow),
    }
}

/// The list for D dimensions.
struct List<const D: usize>(Vec<Variable>);

/// Return inputs and solver of a unit, whose list is that of its dimensions.
fn flow<const D: usize>(unit: &mut FluidUnit) -> &mut FlowIn<D>
where
    [f64; D]: Counted<D>,
{
    <[f64; D]>::of(&mut unit.flow)
}

/// Return the solver of a unit.
fn fluid<const D: usize>(unit: &mut FluidUnit) -> &mut Fluid<D>
where
    [f64; D]: Counted<D>,
{
    flow(unit).solver_mut()
}

impl<const D: usize> List<D>
where
    [f64; D]: Counted<D>,
{
    fn of(unit: &FluidUnit, FlowIn { stations, .. }: &FlowIn<D>) -> Vec<Variable> {
        let part = unit.scene.fluid.as_ref().expect("loading refuses a scene without a fluid");
        let (cylinders, bodies) = (part.cylinders.len(), part.bodies.len());
        let names: Vec<_> = (0..stations.len()).map(|k| FlexibleNames::of(&unit.scene, k)).collect();
        let mut list = Self(Vec::new());
        list.parameters();
        list.totals();
        if cylinders + bodies + names.len() > 0 {
            let all = if D == 3 || bodies > 0 || names.len() > 1 { "all bodies" } else { "all cylinders and the beam" };
            list.force("", all, |fluid, axis| fluid.force()[axis]);
        }
        for (k, of) in part.cylinders.iter().enumerate() {
            let (name, body) = (format!("cylinder[{}].", k + 1), format!("cylinder {}", k + 1));
            list.force_and_moment(&name, &body, "its centre", move |fluid| fluid.force_on_body(k));
            if of.motion.is_some() {
                list.position(&name, &format!("the centre of {body}"), k);
            }
        }
        for (k, of) in part.bodies.iter().enumerate() {
            let (name, body, k) = (format!("body[{}].", k + 1), format!("body {}", k + 1), cylinders + k);
            list.force_and_moment(&name, &body, "its pivot", move |fluid| fluid.force_on_body(k));
            let has_axis = of.motion.is_none() || of.laws().is_some_and(|laws| laws.rotations.is_empty());
            list.motion(&name, &body, k, has_axis && of.mount.is_none());
            if of.is_driven() {
                list.displacement(&name, &body, k);
            }
            if unit.scene.flyer.as_ref().is_some_and(|flyer| flyer.shape == Some(k - cylinders)) {
                list.load(&name, &body, k);
            }
            if of.mount.is_some() {
                list.velocity(&name, &body, k);
            }
        }
        for (k, names) in names.iter().enumerate() {
            list.exchange(names, k);
        }
        if unit.scene.followed() == Some(Followed::Master) {
            for (axis, along) in AXES.into_iter().enumerate().take(D) {
                let text = format!("Displacement along {along} at the end of the step that the fine box follows");
                list.0.push(Real::input(format!("fine_box.motion.{along}"), "m", text, move |m: &mut FluidUnit| {
                    from_mut(&mut flow::<D>(m).box_displacement[axis])
                }));
            }
        }
        if part.gust.is_some() {
            // An inflow blows along x alone.
            let axes = if part.mean_flow.is_some() { D } else { 1 };
            for (axis, along) in AXES.into_iter().enumerate().take(axes) {
                let text = format!("Velocity along {along} that is added to the stream at the end of the step");
                list.0.push(Real::input(format!("gust.{along}"), "m/s", text, move |m: &mut FluidUnit| {
                    from_mut(&mut flow::<D>(m).gust[axis])
                }));
            }
        }
        if unit.scene.followed().is_some() {
            let text = |along: &str| format!("Lower end of the fine box along {along}");
            list.along("fine_box.", "m", text, |fluid, axis| fluid.grid_of_bodies().low()[axis]);
        }
        for (k, probe) in part.probes.iter().enumerate() {
            list.probe(&probe.name, &probe.position, k);
        }
        for (k, names) in names.iter().enumerate() {
            let is_line = D == 2 && unit.scene.beams().nth(k).is_some_and(|beam| beam.surface == Surface::Line);
            let loads = unit.scene.load().is_none_or(|load| load == Load::Momentum);
            let is_surface = D == 3 && unit.scene.beams().nth(k).is_none();
            let parts = Parts { is_line, is_surface, loads, pressure: unit.scene.axial_pressure_strain() };
            list.stations(names, k, stations[k].len(), &parts);
        }
        list.0
    }

    /// Add an output that is read from the fluid.
    fn output(
        &mut self,
        name: impl Into<String>,
        unit: &'static str,
        text: impl Into<String>,
        read: impl Fn(&mut Fluid<D>) -> f64 + Copy + Send + Sync + 'static,
    ) {
        self.0.push(Real::computed(name, per_depth(D, unit), text, move |m| read(fluid(m))).depends_on(&[]));
    }

    /// Add an output along each axis, whose name ends with it.
    fn along(
        &mut self,
        name: &str,
        unit: &'static str,
        text: impl Fn(&str) -> String,
        read: impl Fn(&mut Fluid<D>, usize) -> f64 + Copy + Send + Sync + 'static,
    ) {
        for (axis, along) in AXES.into_iter().enumerate().take(D) {
            self.output(format!("{name}{along}"), unit, text(along), move |fluid| read(fluid, axis));
        }
    }

    /// Add an output about the axis across the plane, or in space one about each axis, whose name ends with it.
    fn about(
        &mut self,
        name: &str,
        unit: &'static str,
        text: impl Fn(Option<&str>) -> String,
        read: impl Fn(&mut Fluid<D>) -> Spin<D> + Copy + Send + Sync + 'static,
    ) {
        let component = move |fluid: &mut Fluid<D>, about| <[f64; D]>::components(read(fluid))[about];
        if D == 2 {
            return self.output(name, unit, text(None), move |fluid| component(fluid, 0));
        }
        self.along(&format!("{name}_"), unit, |about| text(Some(about)), component);
    }

    /// Add time and parameters.
    fn parameters(&mut self) {
        let rate: Vec<_> = (0..D).map(|axis| format!("|{}|/d{}", VELOCITIES[axis], AXES[axis])).collect();
        let max_cfl = format!("Largest CFL number max({}) dt", rate.join(" + "));
        self.0.extend([
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
            Real::parameter("max_step", "s", "Largest step of the fluid's own", |m| {
                from_mut(&mut m.parameters.max_step)
            })
            .above(0.0),
            Real::parameter("max_cfl", "1", max_cfl, |m| from_mut(&mut m.parameters.max_cfl)).above(0.0),
        ]);
    }

    /// Add the outputs of every scene.
    fn totals(&mut self) {
        let depth = if D == 2 { " per metre of depth" } else { "" };
        self.output("cfl", "1", "CFL number of the last step", |fluid| fluid.cfl());
        let flow_rate = format!("Flow rate through the middle of the box{depth}");
        self.output("flow_rate", "m3/s", flow_rate, |fluid| fluid.flow_rate());
        let mut local = |name: &str, unit: &'static str, text: String, read: fn(&mut Fluid<D>) -> f64| {
            self.0.push(Real::computed(name, per_depth(D, unit), text, move |m| read(fluid(m))).local());
        };
        local("kinetic_energy", "J", format!("Kinetic energy of the whole box{depth}"), |f| f.kinetic_energy());
        let enstrophy = "Half the integral of the squared vorticity over the whole box";
        local("enstrophy", "m3/s2", enstrophy.into(), |f| f.enstrophy());
        let divergence = "Largest divergence times the cell size over the largest speed";
        local("divergence", "1", divergence.into(), Fluid::divergence);
        let longest = "Longest step from here; where loads are announced also of a communication step";
        local("longest_step", "s", longest.into(), |f| f.longest_step());
    }

    /// Add the force on something along each axis.
    fn force(
        &mut self,
        name: &str,
        body: &str,
        force: impl Fn(&Fluid<D>, usize) -> f64 + Copy + Send + Sync + 'static,
    ) {
        let depth = if D == 2 { ", per metre of depth" } else { "" };
        for (axis, along) in AXES.into_iter().enumerate().take(D) {
            let text = format!("Force of the fluid on {body} along {along}{depth}");
            self.output(format!("{name}{}", FORCES[axis]), "N", text, move |fluid| force(fluid, axis));
        }
    }

    /// Add force and moment on a body about a point.
    fn force_and_moment(
        &mut self,
        name: &str,
        body: &str,
        point: &str,
        of: impl Fn(&Fluid<D>) -> Force<D> + Copy + Send + Sync + 'static,
    ) {
        self.force(name, body, move |fluid, axis| of(fluid).force[axis]);
        let text = |about: Option<&str>| match about {
            None => format!("Moment of the fluid on {body} about {point}, positive to the left, per metre of depth"),
            Some(about) => format!("Moment of the fluid on {body} about an axis along {about} through {point}"),
        };
        self.about(&format!("{name}moment"), "N.m", text, move |fluid| of(fluid).moment);
    }

    /// Add the position of `point`, that of rigid body number `k`.
    fn position(&mut self, name: &str, point: &str, k: usize) {
        let text = |along: &str| format!("Position of {point} along {along}");
        self.along(name, "m", text, move |fluid, axis| fluid.pose(k).position[axis]);
    }

    /// Add power, place and angle of rigid body number `k`.
    fn motion(&mut self, name: &str, body: &str, k: usize, has_axis: bool) {
        let power = format!("Power of the force and the moment of the fluid on {body}, at the end of the step");
        self.output(format!("{name}power"), "W", power, move |fluid| fluid.power_on_body(k));
        self.position(name, &format!("the pivot of {body}"), k);
        let name = format!("{name}angle");
        if D == 3 && has_axis {
            let text = format!("Angle of the motion of {body} about its axis");
            return self.output(name, "rad", text, move |fluid| fluid.angle_of_law(k));
        }
        let text = |about: Option<&str>| match about {
            None => format!("Angle from the x axis to that of {body}, positive to the left"),
            Some(about) => format!("Component along {about} of the rotation vector of {body} from rest"),
        };
        self.about(&name, "rad", text, move |fluid| fluid.pose(k).angle);
    }

    /// Add the load of the next step on rigid body number `k`, which a free body moves.
    fn load(&mut self, name: &str, body: &str, k: usize) {
        let text = |along: &str| {
            format!("Force of the fluid on {body} along {along} in the next step, if it keeps its velocities")
        };
        self.along(&format!("{name}load.force_"), "N", text, move |fluid, axis| {
            fluid.load_on_body(k).map_or(0.0, |load| load.force.force[axis])
        });
        let text =
            |about: &str| format!("Moment of that force about an axis along {about} through the pivot of {body}");
        self.along(&format!("{name}load.moment_"), "N.m", text, move |fluid, axis| {
            fluid.load_on_body(k).map_or(0.0, |load| <[f64; D]>::components(load.force.moment)[axis])
        });
        let text = "Rows of the rate at which they fall with the velocities of the body";
        let impedance = Real::output(format!("{name}load.impedance"), "1", text, move |m: &mut FluidUnit| {
            fluid::<D>(m).load_on_body(k).map_or(&[][..], |load| load.impedance.as_flattened())
        });
        self.0.push(impedance.array(36));
    }

    /// Add the motion of rigid body number `k`, which the master moves, as inputs.
    fn displacement(&mut self, name: &str, body: &str, k: usize) {
        let mut input = |part: String, unit: &str, what: String, of: Select<D>, axis: usize| {
            let text = format!("{what} of {body} at the end of the step");
            self.0.push(Real::input(format!("{name}motion.{part}"), unit, text, move |m: &mut FluidUnit| {
                from_mut(of(&mut flow::<D>(m).displacements[k], axis))
            }));
        };
        for (axis, along) in AXES.into_iter().enumerate().take(D) {
            input(
                along.into(),
                "m",
                format!("Displacement along {along}"),
                |pose, axis| &mut pose.position[axis],
                axis,
            );
        }
        let angle: Select<D> = |pose, about| <[f64; D]>::component_mut(&mut pose.angle, about);
        if D == 2 {
            input("angle".into(), "rad", "Angle, added to that of the scene,".into(), angle, 0);
        } else {
            for (axis, about) in AXES.into_iter().enumerate() {
                let what = format!("Component along {about} of the rotation vector from rest");
                input(format!("angle_{about}"), "rad", what, angle, axis);
            }
        }
        for (axis, along) in AXES.into_iter().enumerate().take(D) {
            input(
                format!("v{along}"),
                "m/s",
                format!("Velocity along {along}"),
                |pose, axis| &mut pose.velocity[axis],
                axis,
            );
        }
        let omega: Select<D> = |pose, about| <[f64; D]>::component_mut(&mut pose.omega, about);
        if D == 2 {
            input("omega".into(), "rad/s", "Rate of the angle".into(), omega, 0);
        } else {
            for (axis, about) in AXES.into_iter().enumerate() {
                let what = format!("Angular velocity about {about}");
                input(format!("omega_{about}"), "rad/s", what, omega, axis);
            }
        }
    }

    /// Add the velocities of rigid body number `k`, which is on springs.
    fn velocity(&mut self, name: &str, body: &str, k: usize) {
        let text = |along: &str| format!("Velocity of the pivot of {body} along {along}");
        self.along(&format!("{name}v"), "m/s", text, move |fluid, axis| fluid.pose(k).velocity[axis]);
        let text = |about: Option<&str>| match about {
            None => format!("Rate of the angle of {body}"),
            Some(about) => format!("Angular velocity of {body} about {about}"),
        };
        self.about(&format!("{name}omega"), "rad/s", text, move |fluid| fluid.pose(k).omega);
    }

    /// Add force, moment, power and work of flexible body number `k` in the last step, to be compared with the rod's.
    fn exchange(&mut self, FlexibleNames { name, text, stations, centre, .. }: &FlexibleNames, k: usize) {
        let name = format!("{name}.");
        self.force_and_moment(&name, text, centre, move |fluid| fluid.force_on_flexible(k));
        let text =
            |along: &str| format!("Sum of what the fluid exerted on the {stations} along {along}: no unsteady term");
        self.along(&format!("{name}load_"), "N", text, move |fluid, axis| fluid.exchange()[k].force[axis]);
        let power = format!("Power of what the fluid exerted on the {stations}, at the end of the step");
        self.output(format!("{name}power"), "W", power, move |fluid| fluid.exchange()[k].power);
        let work = "Its work since the start: the sum of power times step";
        self.output(format!("{name}work"), "J", work, move |fluid| fluid.exchange()[k].work);
    }

    /// Add velocity and pressure at probe number `k`.
    fn probe(&mut self, name: &str, position: &[f64], k: usize) {
        let place = if D == 2 { format!("({}, {})", position[0], position[1]) } else { format!("{position:?}") };
        for (axis, along) in AXES.into_iter().enumerate().take(D) {
            let text = format!("Velocity along {along} at {place}");
            let velocity = move |fluid: &mut Fluid<D>| fluid.probe_velocity(k)[axis];
            self.output(format!("probe.{name}.{}", VELOCITIES[axis]), "m/s", text, velocity);
        }
        let text = format!("Static pressure at {place}");
        self.output(format!("probe.{name}.p"), "Pa", text, move |fluid| fluid.probe_pressure(k));
    }

    /// Add the variables of the `n` stations of flexible body number `k`: motion, stresses, loads.
    fn stations(&mut self, FlexibleNames { prefix, stations, .. }: &FlexibleNames, k: usize, n: usize, parts: &Parts) {
        let mut input = |name: &str, unit: &str, what: &str, of: fn(&mut Stations<D>) -> &mut [Vec<f64>; D]| {
            for (axis, along) in AXES.into_iter().enumerate().take(D) {
                let text = format!("{what} of the {stations} at the end of the step");
                let variable = Real::input(format!("{prefix}{name}{along}"), unit, text, move |m| {
                    &mut of(&mut flow::<D>(m).stations[k])[axis]
                });
                self.0.push(variable.array(n));
            }
        };
        input("", "m", "Position", |stations| &mut stations.position);
        input("v", "m/s", "Velocity", |stations| &mut stations.velocity);
        if D == 2 || parts.is_surface {
            let text = if D == 2 {
                "Pressure above minus below the beam"
            } else {
                "Pressure where the normals of the triangles point minus that behind"
            };
            self.array(format!("{prefix}pressure_jump"), "Pa", text, n, move |fluid| &fluid.pressure_jump()[k]);
        }
        if parts.is_line {
            let text = "Shear stress on both faces of the line, towards the tip";
            self.array(format!("{prefix}shear"), "Pa", text, n, move |fluid| &fluid.shear()[k][0]);
        }
        if parts.is_surface {
            for (axis, along) in AXES.into_iter().enumerate().take(D) {
                let name = format!("{prefix}shear_{along}");
                self.array(name, "Pa", "Shear stress on both faces", n, move |fluid| &fluid.shear()[k][axis]);
            }
        }
        if parts.loads {
            for (axis, along) in AXES.into_iter().enumerate().take(D) {
                let text = format!("Load on the {stations} for the coming step");
                let name = format!("{prefix}force_{along}");
                self.array(name, "N", text, n, move |fluid| &fluid.loads()[k].force[axis]);
            }
            let of = if D == 2 { "station" } else { "node" };
            let text = format!("Rate at which the load falls with the {of}'s velocity");
            self.array(format!("{prefix}impedance"), "kg/s", text, n, move |fluid| &fluid.loads()[k].impedance);
        }
        if parts.pressure {
            let text = "Pressure around the beam, the mean of both sides, less that of the outlet";
            self.array(format!("{prefix}pressure"), "Pa", text, n, move |fluid| &fluid.pressure_around()[k]);
        }
    }

    /// Add an output of `n` numbers.
    fn array(
        &mut self,
        name: String,
        unit: &'static str,
        text: impl Into<String>,
        n: usize,
        of: impl Fn(&mut Fluid<D>) -> &Vec<f64> + Send + Sync + 'static,
    ) {
        let variable = Real::output(name, per_depth(D, unit), text, move |m| of(fluid(m)));
        self.0.push(variable.array(n).depends_on(&[]));
    }
}

/// Which variables the stations of a flexible body have beside their motion.
struct Parts {
    is_line: bool,
    is_surface: bool,
    loads: bool,
    pressure: bool,
}

/// Selects a component of a pose by the number of its axis.
type Select<const D: usize> = fn(&mut Pose<D>, usize) -> &mut f64;
