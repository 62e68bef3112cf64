//! Parameters of the fluid of a scene.
//!
//! This stands here behind the feature `scene`, and not in the FMU: tests, benchmarks and the FMU share it, and nothing
//! can depend on the FMU's library. Without the feature the crate knows no scene files.

use scene::{BodyDrive, Ends, InflowProfile, Load, Root, Scene, TimeLaw};

use crate::error::Error;
use crate::parameters::{
    Beam, Body, Cylinder, Filter, Law, Mask, Motion, Mount, Parameters, Precision, Shape, Support, Surface, TimeScheme,
    WallCorrection, Zone,
};
use crate::space;

impl TryFrom<&Scene> for Parameters {
    type Error = Error;

    /// Fails for a scene without a fluid of two dimensions.
    fn try_from(scene: &Scene) -> Result<Self, Error> {
        let fluid = scene.fluid.as_ref().ok_or_else(|| Error::NoFluid(scene.name.clone()))?;
        if fluid.is_space() {
            return Err(Error::Dimension { scene: scene.name.clone(), dimensions: 3 });
        }
        Ok(Self {
            domain: [fluid.r#box.x, fluid.r#box.y],
            cells: components(&fluid.r#box.cells),
            density: fluid.density,
            kinematic_viscosity: fluid.kinematic_viscosity,
            initial_velocity: components(&fluid.initial_velocity),
            disturbance: fluid.disturbance,
            mean_flow: fluid.mean_flow.as_ref().map(|mean| [law(&mean.x), law(&mean.y)]),
            channel: fluid.channel.as_ref().map(|channel| channel.y),
            inflow: fluid.inflow.as_ref().map(inflow),
            sponge: fluid.sponge.as_ref().map(sponge),
            cylinders: fluid.cylinders.iter().map(cylinder).collect(),
            bodies: fluid.bodies.iter().map(body).collect(),
            beams: scene.beams().map(|of| beam(scene, of)).collect(),
            mask: mask(&fluid.mask),
            probes: fluid.probes.iter().map(|probe| components(&probe.position)).collect(),
            filter: filter(fluid.filter),
            precision: precision(fluid.precision),
            threads: fluid.threads,
            scheme: match fluid.time_stepping.scheme {
                scene::TimeScheme::Sbdf2 => TimeScheme::Sbdf2,
                scene::TimeScheme::Rk2 => TimeScheme::Rk2,
            },
            max_step: fluid.time_stepping.max_step,
            max_cfl: fluid.time_stepping.max_cfl,
            communication_step: scene.time.communication_step,
            loads: scene.load().is_none_or(|load| load == Load::Momentum),
            pressure_around: scene.axial_pressure_strain(),
        })
    }
}

/// Return the first components; those that a list lacks are 0.
fn components<T: Copy + Default, const D: usize>(list: &[T]) -> [T; D] {
    std::array::from_fn(|axis| list.get(axis).copied().unwrap_or_default())
}

fn inflow(inflow: &scene::Inflow) -> Zone {
    zone(inflow.x, inflow.profile, &inflow.mean_velocity, inflow.c_eta)
}

fn sponge(sponge: &scene::Sponge) -> Zone {
    zone(sponge.x, sponge.profile, &sponge.mean_velocity, sponge.c_eta)
}

fn zone(x: [f64; 2], profile: InflowProfile, mean_velocity: &TimeLaw, c_eta: f64) -> Zone {
    Zone { x, parabolic: profile == InflowProfile::Parabolic, mean_velocity: law(mean_velocity), c_eta }
}

fn filter(filter: scene::Filter) -> Filter {
    match filter {
        scene::Filter::Smooth => Filter::Smooth,
        scene::Filter::TwoThirds => Filter::TwoThirds,
        scene::Filter::None => Filter::None,
    }
}

fn precision(precision: scene::Precision) -> Precision {
    match precision {
        scene::Precision::Double => Precision::Double,
        scene::Precision::Single => Precision::Single,
    }
}

impl TryFrom<&Scene> for space::Parameters {
    type Error = Error;

    /// Fails for a scene without a fluid of three dimensions.
    fn try_from(scene: &Scene) -> Result<Self, Error> {
        let fluid = scene.fluid.as_ref().ok_or_else(|| Error::NoFluid(scene.name.clone()))?;
        let (of, channel) = (&fluid.r#box, fluid.channel.as_ref());
        let z = of.z.ok_or_else(|| Error::Dimension { scene: scene.name.clone(), dimensions: 2 })?;
        Ok(Self {
            domain: [of.x, of.y, z],
            cells: components(&of.cells),
            density: fluid.density,
            kinematic_viscosity: fluid.kinematic_viscosity,
            initial_velocity: components(&fluid.initial_velocity),
            mean_flow: fluid.mean_flow.as_ref().map(|mean| [law(&mean.x), law(&mean.y), law(&mean.z)]),
            walls: channel.map_or([None; 3], |channel| [channel.x, Some(channel.y), channel.z]),
            inflow: fluid.inflow.as_ref().map(inflow),
            sponge: fluid.sponge.as_ref().map(sponge),
            bodies: fluid.bodies.iter().map(body_in_space).collect(),
            flexible: flexible(scene),
            mask: mask(&fluid.mask),
            probes: fluid.probes.iter().map(|probe| components(&probe.position)).collect(),
            filter: filter(fluid.filter),
            precision: precision(fluid.precision),
            threads: fluid.threads,
            max_step: fluid.time_stepping.max_step,
            max_cfl: fluid.time_stepping.max_cfl,
            communication_step: scene.time.communication_step,
        })
    }
}

/// Return the thin bodies of a scene in space: its beams in their order, then its wing.
fn flexible(scene: &Scene) -> Vec<space::Flexible> {
    let beams = scene.beams_with_rods().map(|own| space::Flexible {
        name: own.number.map_or("the beam".into(), |number| format!("beam {number}")),
        nodes: scene.beam_stations(own.beam),
        extent: space::Extent::Line,
        pivot: None,
    });
    let wing = scene.wing.iter().map(|wing| {
        let mesh = wing.mesh.build();
        let extent = space::Extent::Surface(mesh.triangles);
        space::Flexible { name: "the wing".into(), nodes: mesh.nodes, extent, pivot: Some(wing.pivot) }
    });
    beams.chain(wing).collect()
}

fn body_in_space(body: &scene::Body) -> space::Body {
    const Z: [f64; 3] = [0.0, 0.0, 1.0];
    let half = |lengths: &[f64; 3]| lengths.map(|length| 0.5 * length);
    let motion = |motion: &scene::BodyMotion| space::Motion {
        displacement: [&motion.x, &motion.y, &motion.z].map(law),
        axis: motion.axis.unwrap_or(Z),
        angle: law(&motion.angle),
    };
    space::Body {
        shape: match &body.shape {
            scene::Shape::Sphere { radius } => space::Shape::Sphere(*radius),
            scene::Shape::Ellipsoid { lengths } => space::Shape::Ellipsoid(half(lengths)),
            scene::Shape::Cuboid { lengths } => space::Shape::Cuboid(half(lengths)),
            scene::Shape::CircularCylinder { axis, radius, length } => space::Shape::Cylinder {
                axis: *axis as usize,
                radius: *radius,
                half_length: length.map_or(f64::INFINITY, |length| 0.5 * length),
            },
            shape => match shape.surface() {
                Some((nodes, triangles)) => space::Shape::Surface(nodes, triangles),
                None => unreachable!("checked: a shape of three dimensions"),
            },
        },
        position: components(&body.position),
        pivot: components(&body.pivot),
        turn: body
            .turn
            .as_ref()
            .map_or(space::Turn { axis: Z, angle: 0.0 }, |turn| space::Turn { axis: turn.axis, angle: turn.angle }),
        motion: body.laws().map(motion),
    }
}

fn law(law: &TimeLaw) -> Law {
    let law = law.clone();
    Law::new(move |t| law.value_and_rate(t))
}

fn cylinder(cylinder: &scene::Cylinder) -> Cylinder {
    let motion = |motion: &scene::Motion| [law(&motion.x), law(&motion.y)];
    Cylinder { center: cylinder.center, radius: cylinder.radius, motion: cylinder.motion.as_ref().map(motion) }
}

fn body(body: &scene::Body) -> Body {
    let motion = |drive: &BodyDrive| match drive {
        BodyDrive::Master(_) => Motion::Master,
        BodyDrive::Laws(laws) => Motion::Laws { displacement: [law(&laws.x), law(&laws.y)], angle: law(&laws.angle) },
    };
    let support = |scene::Support { stiffness, damping, rest }| Support { stiffness, damping, rest };
    let mount = |mount: &scene::Mount| Mount {
        mass: mount.mass,
        inertia: mount.inertia.unwrap_or_default(),
        supports: mount.supports().map(|own| own.map(support)),
    };
    Body {
        shape: shape(&body.shape),
        position: components(&body.position),
        pivot: components(&body.pivot),
        angle: body.angle,
        motion: body.motion.as_ref().map(motion).or(body.mount.as_ref().map(mount).map(Motion::Mount)),
    }
}

fn shape(shape: &scene::Shape) -> Shape {
    match shape {
        scene::Shape::Circle { radius } => Shape::Circle(*radius),
        scene::Shape::Ellipse { length, thickness } => Shape::Ellipse([0.5 * length, 0.5 * thickness]),
        scene::Shape::Rectangle { length, thickness, ends: Ends::Square } => {
            Shape::Rectangle([0.5 * length, 0.5 * thickness])
        }
        scene::Shape::Rectangle { length, thickness, ends: Ends::Round } => {
            Shape::Capsule([0.5 * (length - thickness), 0.5 * thickness])
        }
        scene::Shape::Polygon { corners } => Shape::Polygon(corners.clone()),
        scene::Shape::Plate { length, .. } => Shape::Line(vec![[-0.5 * length, 0.0], [0.5 * length, 0.0]]),
        scene::Shape::Polyline { points } => Shape::Line(points.clone()),
        scene::Shape::Disk { .. }
        | scene::Shape::Triangulation { .. }
        | scene::Shape::Sphere { .. }
        | scene::Shape::Ellipsoid { .. }
        | scene::Shape::Cuboid { .. }
        | scene::Shape::CircularCylinder { .. } => unreachable!("checked: a shape of two dimensions"),
    }
}

fn beam(scene: &Scene, beam: &scene::Beam) -> Beam {
    Beam {
        stations: scene.beam_stations(beam).into_iter().map(|[x, y, _]| [x, y]).collect(),
        length: beam.length,
        thickness: beam.places().map(|s| beam.thickness.at(s)).collect(),
        support_cylinder: match beam.root {
            Root::OnCylinder { cylinder, .. } => Some(cylinder),
            Root::At { .. } => None,
        },
        surface: match beam.surface {
            scene::Surface::Line => Surface::Line,
            scene::Surface::Mask => Surface::Mask,
        },
    }
}

fn mask(mask: &scene::Mask) -> Mask {
    match *mask {
        scene::Mask::Sharp { c_eta, displacement_corrected } => Mask::Sharp { c_eta, displacement_corrected },
        scene::Mask::Cosine { c_eta, half_width, displacement_corrected } => {
            Mask::Cosine { c_eta, half_width, displacement_corrected }
        }
        scene::Mask::LogLinear { c_eta, decay_length_cells, core_depth, wall_correction } => Mask::LogLinear {
            c_eta,
            decay_length_cells,
            core_depth,
            wall_correction: match wall_correction {
                scene::WallCorrection::None => WallCorrection::None,
                scene::WallCorrection::Shear => WallCorrection::Shear,
                scene::WallCorrection::Curvature => WallCorrection::Curvature,
            },
        },
    }
}
