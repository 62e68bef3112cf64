//! Parameters of the fluid of a scene.
//!
//! This stands here behind the feature `scene`, and not in the FMU: tests, benchmarks and the FMU share it, and nothing
//! can depend on the FMU's library. Without the feature the crate knows no scene files.

use std::sync::Arc;

use nalgebra::Matrix3;
use scene::{BodyDrive, InflowProfile, Load, Root, Scene, TimeLaw};

use crate::error::Error;
use crate::gust::Gust;
use crate::law::Law;
use crate::parameters::{
    Body, Carrier, Contact, Extent, FineBox, Flexible, Followed, MiddleBox, Motion, Mount, Parameters, Zone,
};
use crate::shapes::{Polyline, Shape, Triangulation};
use crate::space::{Kinematics, Space, Spin, Turn, Vector};

impl TryFrom<&Scene> for Parameters<2> {
    type Error = Error;

    /// Fails for a scene without a fluid of two dimensions.
    fn try_from(scene: &Scene) -> Result<Self, Error> {
        let fluid = of_dimension(scene, 2)?;
        let make = |of: &[scene::Body], name| bodies(of, name, shape, |body| body.angle, |_| 1.0).collect::<Vec<_>>();
        let cylinders: Vec<_> = fluid.cylinders.iter().map(scene::Body::from).collect();
        Ok(Self {
            bodies: [make(&cylinders, "cylinder"), make(&fluid.bodies, "body")].concat(),
            contact: contact(scene, fluid, |of| make(of, "obstacle")),
            flexible: beams(scene),
            ..common(scene, fluid, [fluid.r#box.x, fluid.r#box.y])
        })
    }
}

impl TryFrom<&Scene> for Parameters<3> {
    type Error = Error;

    /// Fails for a scene without a fluid of three dimensions.
    fn try_from(scene: &Scene) -> Result<Self, Error> {
        const Z: [f64; 3] = [0.0, 0.0, 1.0];
        let fluid = of_dimension(scene, 3)?;
        let turn = |body: &scene::Body| {
            body.turn.as_ref().map_or(Turn { axis: Z, angle: 0.0 }, |turn| Turn { axis: turn.axis, angle: turn.angle })
        };
        let shape = scene.flyer.as_ref().and_then(|flyer| flyer.shape);
        let own = bodies(&fluid.bodies, "body", solid, turn, Vector::from).enumerate();
        Ok(Self {
            contact: contact(scene, fluid, |of| bodies(of, "obstacle", solid, turn, Vector::from).collect()),
            bodies: own.map(|(k, body)| Body { announces: shape == Some(k), ..body }).collect(),
            flexible: rods_and_wings(scene),
            ..common(scene, fluid, [fluid.r#box.x, fluid.r#box.y, fluid.r#box.z.unwrap_or_default()])
        })
    }
}

/// Return the fluid of a scene that has so many dimensions.
fn of_dimension(scene: &Scene, dimensions: usize) -> Result<&scene::Fluid, Error> {
    let fluid = scene.fluid.as_ref().ok_or_else(|| Error::NoFluid(scene.name.clone()))?;
    let own = if fluid.is_space() { 3 } else { 2 };
    if own == dimensions { Ok(fluid) } else { Err(Error::Dimension { scene: scene.name.clone(), dimensions: own }) }
}

/// Return the parameters that depend on no shape, without bodies.
fn common<const D: usize>(scene: &Scene, fluid: &scene::Fluid, domain: [[f64; 2]; D]) -> Parameters<D>
where
    [f64; D]: Space<D>,
{
    let step = scene.time.communication_step;
    let (walls, time) = (fluid.walls(), &fluid.time_stepping);
    let mean_flow = fluid.mean_flow.as_ref().map(|mean| [&mean.x, &mean.y, &mean.z]);
    let gust = fluid.gust.map(|_| Gust::default());
    let blown = |law: Law, axis| gust.as_ref().map_or(law.clone(), |gust| gust.added_to(law, axis));
    let zone = |zone: scene::Zone| Zone {
        x: zone.x,
        parabolic: zone.profile == InflowProfile::Parabolic,
        mean_velocity: blown(law(zone.mean_velocity), 0),
        c_eta: zone.c_eta,
    };
    let [inflow, sponge] = fluid.zones().map(|own| own.map(zone));
    let place = |places: Vec<[usize; 2]>| [0, 1].map(|k| std::array::from_fn(|axis| places[axis][k]));
    Parameters {
        fine_box: fluid.fine_box.as_ref().map(|fine| {
            let [first, cells] = place(fine.places(&fluid.r#box));
            let follows = scene.followed().map(|part| match part {
                scene::Followed::Cylinder(k) => Followed::Rigid(k),
                scene::Followed::Body(k) => Followed::Rigid(fluid.cylinders.len() + k),
                scene::Followed::Beam(k) => Followed::Flexible(k),
                scene::Followed::Wing => Followed::Flexible(scene.beams().count()),
                scene::Followed::Master => Followed::Master,
            });
            FineBox { first, cells, ratio: fine.ratio, follows }
        }),
        middle_box: fluid.middle_box.as_ref().map(|middle| {
            let [first, cells] = place(middle.places(&fluid.r#box));
            MiddleBox { first, cells, ratio: middle.ratio }
        }),
        initial_velocity: components(&fluid.initial_velocity),
        disturbance: fluid.disturbance,
        mean_flow: mean_flow.map(|mean| std::array::from_fn(|axis| blown(law(mean[axis]), axis))),
        walls: std::array::from_fn(|axis| walls[axis]),
        inflow,
        sponge,
        gust: gust.clone(),
        mask: fluid.mask,
        probes: fluid.probes.iter().map(|probe| components(&probe.position)).collect(),
        filter: fluid.filter,
        precision: fluid.precision,
        threads: fluid.threads,
        scheme: time.scheme,
        max_step: time.max_step,
        max_cfl: scene.largest_cfl(fluid),
        loads: scene.load().is_none_or(|load| load == Load::Momentum),
        pressure_around: scene.axial_pressure_strain(),
        ..Parameters::new(domain, components(&fluid.r#box.cells), fluid.density, fluid.kinematic_viscosity, step)
    }
}

/// Return the first components; those that a list lacks are 0.
fn components<T: Copy + Default, const D: usize>(list: &[T]) -> [T; D] {
    std::array::from_fn(|axis| list.get(axis).copied().unwrap_or_default())
}

/// Return the flexible bodies of a scene in space: its beams in their order, then its wings.
fn rods_and_wings(scene: &Scene) -> Vec<Flexible<3>> {
    let beams = scene.beams_with_rods().map(|own| Flexible {
        name: own.number.map_or("the beam".into(), |number| format!("beam {number}")),
        nodes: scene.beam_stations(own.beam),
        extent: Extent::Rod(own.beam.places().step_by(2).map(|s| own.beam.thickness.at(s)).collect()),
        pivot: None,
    });
    let wings = scene.wings().map(|own| {
        let extent = Extent::Surface(own.wing.mesh.build().triangles);
        let pivot = scene.hinge_of(own.name).map_or(own.wing.pivot, |hinge| scene.place_of(hinge));
        let name = own.number.map_or("the wing".into(), |number| format!("wing {number}"));
        Flexible { name, nodes: scene.wing_nodes(&own), extent, pivot: Some(pivot) }
    });
    beams.chain(wings).collect()
}

/// Return the beams of a scene in the plane.
fn beams(scene: &Scene) -> Vec<Flexible<2>> {
    let beam = |own: scene::BeamWithRod| {
        let beam = own.beam;
        let support = if let Root::OnCylinder { cylinder, .. } = beam.root { Some(cylinder) } else { None };
        Flexible {
            name: own.number.map_or("the beam".into(), |number| format!("beam {number}")),
            nodes: scene.beam_stations(beam).into_iter().map(|[x, y, _]| [x, y]).collect(),
            extent: match beam.surface {
                scene::Surface::Line => Extent::Line { free: [support.is_none(), true] },
                scene::Surface::Mask => {
                    let thickness = beam.places().map(|s| beam.thickness.at(s)).collect();
                    Extent::Band { length: beam.length, thickness, support }
                }
            },
            pivot: None,
        }
    };
    scene.beams_with_rods().map(beam).collect()
}

fn law(law: &TimeLaw) -> Law {
    let law = law.clone();
    Law::new(move |t| law.value_and_rate(t))
}

/// Return the contact of the bodies of a scene, with the obstacles that `make` makes.
fn contact<const D: usize>(
    scene: &Scene,
    fluid: &scene::Fluid,
    make: impl FnOnce(&[scene::Body]) -> Vec<Body<D>>,
) -> Option<Contact<D>>
where
    [f64; D]: Space<D>,
{
    let own = scene.contact.as_ref()?;
    let law = own.law_of_bodies(scene);
    let walls = fluid.walls();
    let size: Vec<_> = fluid.r#box.ends().map(|[low, high]| high - low).collect();
    Some(Contact {
        law,
        obstacles: make(&own.obstacles),
        walls: std::array::from_fn(|axis| walls[axis]),
        periods: std::array::from_fn(|axis| if walls[axis].is_none() { size[axis] } else { f64::INFINITY }),
        flexible_stiffness: own.stiffness.unwrap_or(f64::INFINITY),
        skins: own.skins(scene, D),
        carrier: scene
            .flyer
            .as_ref()
            .filter(|flyer| flyer.shape.is_some())
            .map(|flyer| Carrier { inertia: least_inertia(flyer), carries: scene.carried_by_flyer() }),
    })
}

/// Return the mass of a flyer, kg, and its least moment of inertia, kg m², infinite where it cannot turn.
fn least_inertia(flyer: &scene::Flyer) -> [f64; 2] {
    use scene::FreedomName::{AngleX, AngleY, AngleZ};
    let ([x, y, z], [yz, zx, xy]) = (flyer.inertia.about(), flyer.products_of_inertia);
    let about = Matrix3::new(x, xy, zx, xy, y, yz, zx, yz, z).symmetric_eigenvalues().min();
    let turns = [AngleX, AngleY, AngleZ].iter().any(|about| !flyer.held.contains(about));
    [flyer.mass, if turns { about } else { f64::INFINITY }]
}

/// Return bodies of a scene, with their shapes, turns at rest and axes of their motions, each with a name and its number.
fn bodies<'a, const D: usize>(
    all: &'a [scene::Body],
    name: &'a str,
    shape: impl Fn(&scene::Shape) -> Arc<dyn Shape<D>> + 'a,
    turn: impl Fn(&scene::Body) -> <[f64; D] as Kinematics<D>>::Turn + 'a,
    axis: impl Fn([f64; 3]) -> Spin<D> + 'a,
) -> impl Iterator<Item = Body<D>> + 'a
where
    [f64; D]: Space<D>,
{
    all.iter().enumerate().map(move |(k, body)| {
        let driven = |drive: &BodyDrive| match drive {
            BodyDrive::Master(_) => Motion::Master,
            BodyDrive::Laws(laws) => {
                let displacement = std::array::from_fn(|axis| law(laws.along()[axis]));
                Motion::of_rotations(displacement, laws.turns().map(|(about, angle)| (axis(about), law(angle))))
            }
        };
        let motion = match (body.motion.as_ref().map(driven), &body.mount) {
            (Some(Motion::Laws(laws)), Some(own)) => {
                Some(Motion::Released { laws, release: body.release().unwrap_or_default(), mount: mount(own) })
            }
            (None, Some(own)) => Some(Motion::Mount(mount(own))),
            (motion, _) => motion,
        };
        Body {
            name: format!("{name} {}", k + 1),
            shape: shape(&body.shape),
            position: components(&body.position),
            pivot: components(&body.pivot),
            turn: turn(body),
            motion,
            announces: false,
        }
    })
}

/// Return springs and dampers.
fn mount<const D: usize>(mount: &scene::Mount) -> Mount<D>
where
    [f64; D]: Space<D>,
{
    let mut supports = mount.supports(D == 3).map(|(_, support)| support);
    Mount {
        mass: mount.mass,
        inertia: <[f64; D]>::inertia(mount.inertias()),
        supports: std::array::from_fn(|_| supports.next().flatten()),
        gravity: components(&mount.gravity),
    }
}

fn shape(shape: &scene::Shape) -> Arc<dyn Shape<2>> {
    match (shape.outline(), shape.line()) {
        (Some(outline), _) => Arc::new(outline),
        (_, Some(points)) => Arc::new(Polyline(points)),
        _ => unreachable!("checked: a shape of two dimensions"),
    }
}

fn solid(shape: &scene::Shape) -> Arc<dyn Shape<3>> {
    // A cylinder through the box has no ends here.
    match (shape.solid(&[[0.0, f64::INFINITY]]), shape.surface()) {
        (Some(solid), _) => Arc::new(solid),
        (_, Some((nodes, triangles))) => Arc::new(Triangulation(nodes, triangles)),
        _ => unreachable!("checked: a shape of three dimensions"),
    }
}
