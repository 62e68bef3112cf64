//! Facts of a scene that programs need beside its text, so that its rules stand in this crate alone.
//!
//! The dimensionless numbers are
//!
//! ```text
//! Re = U L / nu,   k = pi f L / U,   M = mu / (rho L),   K = EI / (rho U² L³)
//! ```
//!
//! with U the velocity that drives the flow, of a body that falls that at a drag coefficient of 1, L the length of the
//! first cylinder, body, beam or wing (`scales.rs`; in M and K always that of the beam or the wing), f the frequency of
//! the drive, and mu and EI mass per area and bending stiffness of the first beam at its root, per metre of depth, or
//! the mean of a wing and the stiffness of its membrane. A stream is what a flow keeps or oscillates about: a gust that
//! ends is none.
//!
//! The added mass is that of a thin plate across the flow, pi/4 rho L² (Theodorsen 1935). The layer at the front of a
//! body is that of the stagnation flow with the strain rate of potential flow: 4 U/D at a cylinder, 2 U/L at a plate.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use geometry::vector::{self, minus};
use mesh::Mesh;
use method::{Support, Surface};
use serde::Serialize;

use crate::body::Body;
use crate::fluid::{Fluid, InflowProfile};
use crate::flyer::HingeLaws;
use crate::lag_warnings;
use crate::law::TimeLaw;
use crate::law_warnings;
use crate::layers::layers;
use crate::mount::Freedom;
use crate::scales::{Scales, fastest, reach_from_axis, scales, sides_of_wing};
use crate::scene::{BeamWithRod, Scene};
use crate::warning::Warning;
use crate::warnings::warnings;
use crate::wing::Wing;

/// Relative part by which a step may exceed a limit without being divided.
const ROUNDING: f64 = 1e-9;

/// Largest velocity beside a cylinder by that of the stream: 2 in potential flow.
const SPEED_UP: f64 = 2.0;

/// Facts of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Facts {
    /// The beams, in the order in which the fluid counts them.
    pub beams: Vec<BeamFacts>,
    /// Laws of the flow by the path of their key.
    pub laws: BTreeMap<&'static str, LawFacts>,
    /// Dimensionless numbers; absent without a fluid.
    pub dimensionless: Option<Dimensionless>,
    /// Scales of the coefficients of bodies, by the name of their force.
    pub scales: BTreeMap<String, Scales>,
    /// Velocity of the stream, m/s; absent in still fluid.
    pub stream: Option<[f64; 3]>,
    /// Name of what the fine box follows, or `master`; absent for a box that stays, and without one.
    pub followed: Option<String>,
    /// Mesh of the wing; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wing: Option<WingFacts>,
    /// Number of steps that the fluid is expected to make in a communication step.
    pub fluid_steps: u64,
    /// What may be a mistake.
    pub warnings: Vec<Warning>,
}

/// Facts of a beam at its stations, from root to tip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BeamFacts {
    /// Thickness, m: `[segments + 1]`.
    pub thickness: Vec<f64>,
    /// Mass per length, kg/m (per metre of depth in two dimensions): `[segments + 1]`; absent without a rod.
    pub line_density: Option<Vec<f64>>,
    /// Bending stiffness, N m² (per metre of depth in two dimensions): `[segments + 1]`; absent without a rod.
    pub bending_stiffness: Option<Vec<f64>>,
    /// Whether the fluid meets the beam as a line.
    pub line: bool,
}

/// Mesh of a wing at rest; nodes are counted from 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WingFacts {
    /// Positions of the nodes, m.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of the triangles.
    pub triangles: Vec<[usize; 3]>,
    /// Nodes of each vein from base to tip.
    pub veins: Vec<Vec<usize>>,
    /// Held nodes.
    pub root: Vec<usize>,
    /// Material of each triangle: 0, or the number of a region from 1; absent without regions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<usize>,
}

/// Facts of a law of time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LawFacts {
    /// Time from which the law stays constant, s, and its value then; absent where it never is.
    pub settles: Option<(f64, f64)>,
}

/// Dimensionless numbers of a scene with a fluid; numbers that the scene lacks are absent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dimensionless {
    /// U, m/s; absent where nothing drives the flow.
    pub velocity: Option<f64>,
    /// The part of the scene that has this velocity.
    pub velocity_of: Option<String>,
    /// L, m; absent without a body.
    pub length: Option<f64>,
    /// Name of the body that has this length.
    pub length_of: Option<String>,
    /// Re.
    pub reynolds: Option<f64>,
    /// k, of a sine that drives a body or the flow.
    pub reduced_frequency: Option<f64>,
    /// M.
    pub mass_ratio: Option<f64>,
    /// Least ratio of the mass of a rod to that of the fluid it displaces.
    pub density_ratio: Option<f64>,
    /// Added mass of a plate by the mass of the beam.
    pub added_mass_ratio: Option<f64>,
    /// K.
    pub stiffness: Option<f64>,
    /// CFL number of the longest step with the velocity beside a cylinder.
    pub cfl: Option<f64>,
    /// Resolution of the bodies by the name of their force, in the order of the fluid.
    pub bodies: Vec<(String, Resolution)>,
    /// Bodies on springs by the name of their force.
    pub mounts: Vec<(String, MountFacts)>,
}

/// Numbers of a body on springs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MountFacts {
    /// Mass by that of the displaced fluid, m*; absent for a line.
    pub mass_ratio: Option<f64>,
    /// The directions in which it moves, by the keys of their supports.
    pub supports: Vec<(&'static str, SupportFacts)>,
}

/// Numbers of a spring and a damper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SupportFacts {
    /// Natural frequency f_n without a fluid, Hz.
    pub natural_frequency: f64,
    /// Damping by the critical damping without a fluid; absent without a spring.
    pub damping_ratio: Option<f64>,
    /// Reduced velocity U/(f_n L), with the length of the body; absent without a spring or a drive.
    pub reduced_velocity: Option<f64>,
}

/// Resolution of a body by the grid; cells are counted in the coarser direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Resolution {
    /// Diameter of a cylinder, length of a beam or another body, m.
    pub length: f64,
    /// Cells in the diameter or the thickness.
    pub thickness_cells: f64,
    /// Cells along what the fluid meets as a line: in the length of a beam, in mean chord and span of a wing.
    pub along: Vec<(&'static str, f64)>,
    /// Cells in the boundary layer at the front; absent in still fluid and for a beam in a wake.
    pub layer_cells: Option<f64>,
}

/// A velocity that drives the flow.
struct Drive {
    /// Speed of what stays, m/s; of a motion the largest.
    speed: f64,
    /// Largest speed, m/s.
    largest: f64,
    /// Velocity of what stays, m/s; of a motion zero.
    velocity: [f64; 3],
    name: String,
    frequency: Option<f64>,
    /// Name of the force of what a hinge moves.
    carried: Option<String>,
}

impl Scene {
    /// Return the facts of the scene.
    pub fn facts(&self) -> Facts {
        let beams: Vec<_> = self.beams_with_rods().map(|beam| beam_facts(self, &beam)).collect();
        let streams = self.fluid.as_ref().map(streams).unwrap_or_default();
        let stream = streams.iter().find(|drive| drive.speed > 0.0).map(|drive| drive.velocity);
        let scales = scales(self, stream);
        let dimensionless = self.fluid.as_ref().map(|fluid| dimensionless(self, fluid, &beams, &streams, &scales));
        let fluid_steps = match (&self.fluid, &dimensionless) {
            (Some(fluid), Some(numbers)) => fluid_steps(self, fluid, numbers.cfl),
            _ => 1,
        };
        let mut warnings = warnings(self, dimensionless.as_ref().and_then(|numbers| numbers.reynolds));
        warnings.extend(law_warnings::of(self));
        let velocity = dimensionless.as_ref().and_then(|numbers| numbers.velocity);
        warnings.extend(self.fluid.iter().flat_map(|fluid| layers(self, fluid, &scales, velocity)));
        warnings.extend(self.fluid.iter().filter_map(|fluid| lag_warnings::of_step(self, fluid)));
        if let (Some(fluid), Some(Dimensionless { length: Some(length), velocity, .. })) = (&self.fluid, &dimensionless)
        {
            let passages = [Some(*length), self.thin_layer(fluid)].map(|way| Some(way? / (*velocity)?));
            warnings.extend(law_warnings::of_drag(fluid, self.time.communication_step, passages));
        }
        let wing = self.wing.as_ref().map(wing_facts);
        let fine = self.fluid.as_ref().and_then(|fluid| fluid.fine_box.as_ref());
        Facts {
            beams,
            laws: laws(self),
            dimensionless,
            scales: scales.into_iter().collect(),
            stream,
            followed: fine.filter(|fine| fine.follows()).and_then(|fine| fine.follow.clone()),
            wing,
            fluid_steps,
            warnings,
        }
    }
}

fn beam_facts(scene: &Scene, BeamWithRod { beam, rod, .. }: &BeamWithRod) -> BeamFacts {
    let places = || (0..=beam.segments).map(|i| i as f64 / beam.segments as f64);
    let sections = rod.map(|rod| places().map(|s| rod.material.section(&beam.thickness, s)).collect::<Vec<_>>());
    BeamFacts {
        thickness: places().map(|s| beam.thickness.at(s)).collect(),
        line_density: sections.as_ref().map(|all| all.iter().map(|section| section.line_density).collect()),
        bending_stiffness: sections.as_ref().map(|all| all.iter().map(|section| section.bending_stiffness).collect()),
        line: scene.fluid.is_some() && beam.surface == Surface::Line,
    }
}

fn wing_facts(wing: &Wing) -> WingFacts {
    let mesh = wing.mesh.build();
    let materials = wing.materials(&mesh);
    let Mesh { nodes, triangles, chains } = mesh;
    let chain = |name: &String| chains.iter().find(|own| own.name == *name).map(|own| own.nodes.clone());
    WingFacts {
        veins: wing.veins.iter().filter_map(|vein| chain(&vein.chain)).collect(),
        root: wing.root.as_ref().and_then(chain).unwrap_or_default(),
        nodes,
        triangles,
        materials,
    }
}

fn laws(scene: &Scene) -> BTreeMap<&'static str, LawFacts> {
    let mut laws: BTreeMap<_, &TimeLaw> = BTreeMap::new();
    if let Some(fluid) = &scene.fluid {
        laws.extend(fluid.inflow.iter().map(|inflow| ("fluid.inflow.mean_velocity", &inflow.mean_velocity)));
        laws.extend(fluid.mean_flow.iter().map(|flow| ("fluid.mean_flow.x", &flow.x)));
        laws.extend(fluid.mean_flow.iter().map(|flow| ("fluid.mean_flow.y", &flow.y)));
        let deep = fluid.mean_flow.iter().filter(|_| fluid.is_space());
        laws.extend(deep.map(|flow| ("fluid.mean_flow.z", &flow.z)));
    }
    laws.into_iter().map(|(key, law)| (key, LawFacts { settles: law.settles() })).collect()
}

/// Return the thicknesses of bodies, beams and wings in the order of the fluid, m.
fn thicknesses(scene: &Scene, fluid: &Fluid, beams: &[BeamFacts]) -> Vec<f64> {
    let bodies = fluid.obstacles().map(|own| own.body.shape.size()[1]);
    let thinnest = |facts: &BeamFacts| facts.thickness.iter().copied().fold(f64::INFINITY, f64::min);
    bodies.chain(beams.iter().map(thinnest)).chain(scene.wings().map(|_| 0.0)).collect()
}

/// Return the lengths, m, along beams and wings that the fluid meets as lines, each with its name, in the order of the
/// fluid.
fn along(scene: &Scene, fluid: &Fluid, stream: Option<[f64; 3]>) -> Vec<Vec<(&'static str, f64)>> {
    let bodies = fluid.obstacles().map(|_| Vec::new());
    let beams = scene.beams_with_rods().map(|BeamWithRod { beam, .. }| match beam.surface {
        Surface::Line => vec![("length", beam.length)],
        _ => Vec::new(),
    });
    let wings = scene.wings().map(|own| {
        let [mean_chord, span] = sides_of_wing(own.wing, stream);
        vec![("mean chord", mean_chord), ("span", span)]
    });
    bodies.chain(beams).chain(wings).collect()
}

/// Return the number of steps of the fluid in a communication step with the CFL number `cfl` of its longest step.
fn fluid_steps(scene: &Scene, fluid: &Fluid, cfl: Option<f64>) -> u64 {
    let at_least_one = |ratio: f64| (ratio - ROUNDING).ceil().max(1.0);
    let (step, longest) = (scene.time.communication_step, fluid.time_stepping.max_step);
    (at_least_one(step / longest) * at_least_one(cfl.unwrap_or(0.0) / scene.largest_cfl(fluid))) as u64
}

fn dimensionless(
    scene: &Scene,
    fluid: &Fluid,
    beams: &[BeamFacts],
    streams: &[Drive],
    scales: &[(String, Scales)],
) -> Dimensionless {
    let (rho, nu) = (fluid.density, fluid.kinematic_viscosity);
    let motions = motions(scene, fluid);
    let steady = streams.iter().chain(&motions).find(|drive| drive.speed > 0.0).map(|drive| (drive.speed, drive));
    // A flow that only goes to and fro has its largest speed.
    let swinging = || streams.iter().find(|drive| drive.largest > 0.0).map(|drive| (drive.largest, drive));
    let drive = steady.or_else(swinging);
    // The speed at a hinge is that of what it carries.
    let carried = drive.and_then(|(_, drive)| scales.iter().find(|(name, _)| drive.carried.as_ref() == Some(name)));
    let (length_of, first_scales) = carried.or(scales.first()).map(|(name, own)| (name.clone(), own)).unzip();
    let drive = drive.map(|(speed, drive)| (speed, drive.name.clone()));
    let chosen = first_scales.and_then(|own| Some((own.speed?, "reference".to_string())));
    let (velocity, velocity_of) = chosen.or(drive).unzip();
    let frequency = motions.iter().chain(streams).find_map(|drive| drive.frequency);
    let largest = |drives: &[Drive]| drives.iter().map(|drive| drive.largest).fold(0.0, f64::max);
    let peak = fluid.inflow.as_ref().map_or(1.0, |inflow| inflow.profile.peak());
    let fastest = peak * f64::hypot(largest(streams), largest(&motions));

    let spacing = fluid.spacing();
    let (coarsest, finest) =
        (spacing.iter().copied().fold(0.0, f64::max), spacing.iter().copied().fold(f64::INFINITY, f64::min));
    let step = scene.time.communication_step.min(fluid.time_stepping.max_step);
    let length = first_scales.map(|own| own.length);
    let stream = streams.iter().find(|drive| drive.speed > 0.0).map(|drive| drive.velocity);
    let sizes = thicknesses(scene, fluid, beams).into_iter().zip(along(scene, fluid, stream));
    let strains: Vec<_> = fluid.obstacles().map(|own| own.body.shape.strain_factor()).collect();
    let bodies =
        scales.iter().zip(sizes).enumerate().map(|(i, ((name, Scales { length, .. }), (thickness, along)))| {
            let factor = strains.get(i).copied().unwrap_or(if i > 0 { 0.0 } else { 2.0 });
            let strain = factor * fastest / length;
            let resolution = Resolution {
                length: *length,
                thickness_cells: thickness / coarsest,
                along: along.into_iter().map(|(name, length)| (name, length / coarsest)).collect(),
                layer_cells: (strain > 0.0).then(|| (nu / strain).sqrt() / coarsest),
            };
            (name.clone(), resolution)
        });

    let first = scene.beams_with_rods().next().zip(beams.first()).and_then(|(own, facts)| {
        Some((own.beam.length, facts.line_density.as_ref()?[0] / rho, facts.bending_stiffness.as_ref()?[0]))
    });
    // These numbers of a beam are of a metre of depth.
    let first = first.filter(|_| !fluid.is_space()).or_else(|| {
        let own = scene.wings().next()?;
        let (wing, name) = (own.wing, own.force_name());
        let length = scales.iter().find(|(other, _)| *other == name)?.1.length;
        let membrane = wing.membrane.filter(|membrane| membrane.bending_stiffness > 0.0);
        Some((length, mean_density(wing) / rho, membrane.map_or(f64::NAN, |membrane| membrane.bending_stiffness)))
    });
    let section = |thickness: f64| if fluid.is_space() { PI / 4.0 * thickness * thickness } else { thickness };
    let ratios = beams.iter().filter_map(|facts| {
        let masses = facts.line_density.as_ref()?.iter().zip(&facts.thickness);
        Some(masses.map(|(mass, thickness)| mass / rho / section(*thickness)).fold(f64::INFINITY, f64::min))
    });
    let number = |value: Option<f64>| value.filter(|value| value.is_finite());
    Dimensionless {
        velocity,
        velocity_of,
        length,
        length_of,
        reynolds: number(velocity.zip(length).map(|(u, l)| u * l / nu)),
        reduced_frequency: number(velocity.zip(length).zip(frequency).map(|((u, l), f)| PI * f * l / u)),
        mass_ratio: number(first.map(|(span, mass, _)| mass / span)),
        density_ratio: number(ratios.reduce(f64::min)),
        added_mass_ratio: number(first.map(|(span, mass, _)| PI / 4.0 * span / mass)),
        stiffness: number(
            first.zip(velocity).map(|((span, _, stiffness), u)| stiffness / (rho * (u * u) * span.powi(3))),
        ),
        cfl: number((fastest > 0.0).then(|| SPEED_UP * fastest * step / finest)),
        bodies: bodies.collect(),
        mounts: (1..)
            .zip(&fluid.bodies)
            .filter_map(|(i, body)| Some((format!("body_{i}"), mount(fluid, body, velocity)?)))
            .collect(),
    }
}

/// Return the numbers of a body if it is on springs, in a flow of a velocity.
fn mount(fluid: &Fluid, body: &Body, velocity: Option<f64>) -> Option<MountFacts> {
    let mount = body.mount.as_ref()?;
    let ([length, _], ends) = (body.shape.size(), fluid.r#box.ends().collect::<Vec<_>>());
    let number = |value: f64| Some(value).filter(|value| value.is_finite());
    let supports =
        body.freedoms(fluid.is_space()).into_iter().filter_map(|Freedom { name, inertia, support, .. }| {
            let Support { stiffness, damping, .. } = support?;
            let omega = (stiffness / inertia).sqrt();
            let natural_frequency = omega / (2.0 * PI);
            Some((
                name,
                SupportFacts {
                    natural_frequency,
                    damping_ratio: number(0.5 * damping / (omega * inertia)),
                    reduced_velocity: velocity.and_then(|u| number(u / (natural_frequency * length))),
                },
            ))
        });
    let mass_ratio = number(mount.mass / body.displaced_by(fluid.density, &ends).0);
    Some(MountFacts { mass_ratio, supports: supports.collect() })
}

/// Return the length of a vector. In the plane it has the bits of `hypot`.
fn speed([x, y, z]: [f64; 3]) -> f64 {
    f64::hypot(f64::hypot(x, y), z)
}

/// Return the mass of a wing by its area, kg/m².
fn mean_density(wing: &Wing) -> f64 {
    let mesh = wing.mesh.build();
    let materials = wing.materials(&mesh);
    let areas = mesh.triangles.iter().map(|corners| mesh::triangle_area(&corners.map(|node| mesh.nodes[node])));
    let of_region = |i: usize| wing.regions.get(i.checked_sub(1)?).map(|region| region.membrane);
    let (mut mass, mut area) = (0.0, 0.0);
    for (t, own) in areas.enumerate() {
        let membrane = materials.get(t).and_then(|i| of_region(*i)).or(wing.membrane);
        (mass, area) = (mass + own * membrane.map_or(0.0, |membrane| membrane.areal_density), area + own);
    }
    for vein in &wing.veins {
        let nodes = mesh.chain(&vein.chain).unwrap_or_default();
        let length: f64 =
            nodes.windows(2).map(|pair| vector::norm(minus(mesh.nodes[pair[1]], mesh.nodes[pair[0]]))).sum();
        let tip = vein.tip_diameter;
        mass += vein.line_density * length * (1.0 + tip + tip * tip) / 3.0;
    }
    mass / area
}

/// Return the velocities of the flow that the scene asks for.
fn streams(fluid: &Fluid) -> Vec<Drive> {
    let mut streams = Vec::new();
    let mut add = |laws: [Option<&TimeLaw>; 3], name: &str| {
        let velocity = laws.map(|law| law.map_or(0.0, TimeLaw::kept));
        streams.push(Drive {
            speed: speed(velocity),
            largest: speed(laws.map(|law| law.map_or(0.0, TimeLaw::largest))),
            velocity,
            name: name.into(),
            frequency: laws.into_iter().flatten().find_map(TimeLaw::frequency),
            carried: None,
        });
    };
    if let Some(inflow) = &fluid.inflow {
        add([Some(&inflow.mean_velocity), None, None], "inflow");
    }
    if let Some(flow) = &fluid.mean_flow {
        add(flow.laws().map(|(_, law)| Some(law)), "mean flow");
    }
    if let Some(sponge) = &fluid.sponge {
        add([Some(&sponge.mean_velocity), None, None], "sponge");
    }
    let initial: [f64; 3] = std::array::from_fn(|axis| fluid.initial_velocity.get(axis).copied().unwrap_or(0.0));
    let laws = initial.map(TimeLaw::Constant);
    add(std::array::from_fn(|axis| Some(&laws[axis])), "initial velocity");
    streams
}

/// Return the largest speeds of the bodies that are driven: of a pivot, of the farthest point of a body that only
/// turns, of a body that falls with a drag coefficient of 1, of the tip of a beam or a wing as if it were rigid, beside
/// a body that carries it at a hinge.
fn motions(scene: &Scene, fluid: &Fluid) -> Vec<Drive> {
    let first_frequency = |laws: &[&TimeLaw]| laws.iter().find_map(|law| law.frequency());
    let ends: Vec<_> = fluid.r#box.ends().collect();
    let mut motions = Vec::new();
    let motion =
        |speed, name, frequency| Drive { speed, largest: speed, velocity: [0.0; 3], name, frequency, carried: None };
    let mut add = |speed: f64, name: String, frequency| motions.push(motion(speed, name, frequency));
    for own in fluid.obstacles() {
        let Some(motion) = own.body.laws() else { continue };
        let speed = speed(motion.along().map(|law| law.largest_rate()));
        let farthest = |axis| match fluid.is_space() {
            true => reach_from_axis(&own.body, axis, &ends),
            false => own.body.shape.reach([own.body.pivot[0], own.body.pivot[1]]),
        };
        let turning = || norm(motion.turns().map(|(axis, angle)| angle.largest_rate() * farthest(axis)));
        add(
            if speed > 0.0 { speed } else { turning() },
            format!("motion of {}", own.name),
            first_frequency(&motion.all().collect::<Vec<_>>()),
        );
    }
    for (i, body) in fluid.bodies.iter().enumerate() {
        let area = if fluid.is_space() { body.shape.sides(&ends).1 } else { body.shape.size()[0] };
        let weight = self::speed(body.free_weight(fluid.density, &ends));
        add((2.0 * weight / (fluid.density * area)).sqrt(), format!("fall of body {}", i + 1), None);
    }
    for own in scene.beams_with_rods() {
        let Some(laws) = own.laws() else { continue };
        let all: Vec<_> = laws.all().collect();
        let rates =
            all.iter().enumerate().map(|(i, law)| law.largest_rate() * if i < 3 { 1.0 } else { own.beam.length });
        add(norm(rates), "drive of the root".into(), first_frequency(&all));
    }
    let farthest = |wing: &Wing| {
        let arms = wing.mesh.build().nodes.into_iter().map(|node| minus(node, wing.pivot));
        arms.max_by(|a, b| vector::norm(*a).total_cmp(&vector::norm(*b))).unwrap_or_default()
    };
    for (wing, laws) in scene.wings().filter_map(|own| Some((own.wing, own.wing.laws()?))) {
        let arm = farthest(wing);
        let velocity = |t: f64| {
            let (shift, turn) = (laws.displacement(t).1, laws.direction(t, arm).1);
            std::array::from_fn(|d| shift[d] + turn[d])
        };
        let all: Vec<_> = laws.all().collect();
        let speed = vector::norm(fastest(velocity, scene.time.end));
        add(speed, "drive of the root".into(), first_frequency(&all));
    }
    for hinge in scene.flyer.iter().flat_map(|flyer| &flyer.hinges) {
        let Some(HingeLaws { stroke, deviation, pitch }) = hinge.laws() else { continue };
        let wing = || {
            let own = scene.wings().find(|own| own.name == hinge.carries)?;
            Some((own.force_name(), farthest(own.wing)))
        };
        let rod = || {
            let own = scene.beams_with_rods().find(|own| own.name.unwrap_or("rod") == hinge.carries)?;
            Some((own.force_name(), scene.beam_root(own.beam).1.map(|part| part * own.beam.length)))
        };
        let Some((carried, arm)) = wing().or_else(rod) else { continue };
        let speed = vector::norm(fastest(|t| hinge.vector_at(t, arm).1, scene.time.end));
        let frequency = first_frequency(&[stroke, deviation, pitch]);
        let name = format!("hinge of {}", hinge.carries);
        motions.push(Drive { carried: Some(carried), ..motion(speed, name, frequency) });
    }
    motions
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|value| value * value).sum::<f64>().sqrt()
}

impl InflowProfile {
    /// Return the largest velocity of the profile by its mean.
    fn peak(self) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::Parabolic => 1.5,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The layer has the thickness `√(nu/strain)`, with the strain 4 U/D at a circle and 2 U/L at a plate.
    #[test]
    fn the_layer_is_that_of_the_stagnation_flow() {
        let text = r#"{ "name": "plates", "time": { "end": 1, "communication_step": 0.01 }, "fluid": {
            "density": 1, "kinematic_viscosity": 0.01, "box": { "x": [-8, 8], "y": [-4, 4], "cells": [160, 160] },
            "initial_velocity": [0.5, 0], "cylinders": [{ "center": [-4, 0], "radius": 0.5 }],
            "bodies": [{ "shape": { "circle": { "radius": 1 } }, "position": [0, 0] },
                { "shape": { "rectangle": { "length": 2, "thickness": 0.1 } }, "position": [4, 0] }],
            "mask": { "log_linear": { "c_eta": 1e-4 } }, "time_stepping": { "max_step": 0.01, "max_cfl": 0.4 } } }"#;
        let scene = Scene::from_json(text).unwrap_or_else(|e| panic!("{e}"));
        let numbers = scene.facts().dimensionless.expect("it has a fluid");
        for ((name, found), strain) in numbers.bodies.iter().zip([4.0 * 0.5 / 1.0, 4.0 * 0.5 / 2.0, 2.0 * 0.5 / 2.0]) {
            // The coarser cells are those along x, of 0.1 m.
            let expected = (0.01_f64 / strain).sqrt() / 0.1;
            let layer = found.layer_cells.expect("there is a stream");
            assert!((layer / expected - 1.0).abs() < 1e-12, "{name}: {layer} cells, not {expected}");
        }
    }
}
