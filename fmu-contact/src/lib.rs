//! FMI co-simulation unit of the contact between rods and wings, where no fluid couples them.

mod variables;

use adapter::{Dimensions, either, of_both};
use contact::{ContactCoupling, CouplingState, FlexibleBody, FlexibleContact, Law, Skin};
use fmi_export::{Description, Log, Model, Resources, Variable, require_memory};
use scene::{Contact, Scene};

/// Memory of a station with its variables, rounded up, bytes.
const BYTES_PER_STATION: usize = 20_000;
/// Memory of a station in a state, rounded up, bytes.
const STATE_BYTES_PER_STATION: usize = 150;

/// Contact of the rods and wings of a scene.
struct ContactUnit {
    scene: Scene,
    coupling: Coupling,
    /// Sum of the rods' stations and the wings' nodes.
    stations: usize,
    /// Number of fast meetings of which it has warned.
    warned_meetings: usize,
}

/// Contact in the plane or in space.
type Coupling = Dimensions<ContactCoupling<2>, ContactCoupling<3>>;

/// Return the contact of the rods and wings of a scene at rest; fails if there is no memory for it.
fn coupling<const D: usize>(scene: &Scene, own: &Contact) -> Result<ContactCoupling<D>, String>
where
    [f64; D]: rigid::Kinematics<D>,
{
    let point = |place: &[f64; 3]| std::array::from_fn(|d| place[d]);
    let rods = scene.beams().map(|beam| (scene.beam_stations(beam), None));
    let wings = scene.wings().map(|own| (scene.wing_nodes(&own), Some(own.wing.mesh.build().triangles)));
    let shapes: Vec<(Vec<[f64; D]>, _)> =
        rods.chain(wings).map(|(nodes, triangles)| (nodes.iter().map(point).collect(), triangles)).collect();
    let skins: Vec<Option<Skin>> = own.skins(scene, D);
    let bodies: Vec<_> = shapes
        .iter()
        .zip(&skins)
        .map(|((nodes, triangles), skin)| FlexibleBody { nodes, triangles: triangles.as_deref(), skin: skin.as_ref() })
        .collect();
    let law = Law {
        range: own.range_between(scene),
        stiffness: own.stiffness.unwrap_or(f64::INFINITY),
        depth: f64::INFINITY,
        damping: own.damping,
        friction: own.friction,
        film: None,
    };
    require_memory(FlexibleContact::bytes(&bodies, 0))?;
    Ok(ContactCoupling::new(&bodies, &law, scene.time.communication_step))
}

/// Return the contact of a scene; an error where something else couples its rods and wings.
fn of_scene(scene: &Scene) -> Result<Coupling, String> {
    let own = scene.contact.as_ref().filter(|_| scene.is_coupled_by_contact());
    let own = own.ok_or_else(|| format!("the scene {:?} has no rods or wings that contact couples", scene.name))?;
    let is_plane = scene.beams().next().is_some_and(|beam| scene.dimension(beam) == 2);
    Ok(if is_plane { Coupling::Plane(coupling(scene, own)?) } else { Coupling::Space(coupling(scene, own)?) })
}

impl Model for ContactUnit {
    const IDENTIFIER: &'static str = "fmu_contact";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = adapter::RESOURCES;
    type State = Dimensions<CouplingState<2>, CouplingState<3>>;

    fn load(resources: &Resources) -> Result<Self, String> {
        let scene = adapter::scene_of(resources)?;
        let nodes = scene.wings().map(|own| own.wing.mesh.build().nodes.len());
        let stations = scene.beams().map(|beam| beam.segments + 1).chain(nodes).sum();
        require_memory(BYTES_PER_STATION * stations)?;
        Ok(Self { coupling: of_scene(&scene)?, scene, stations, warned_meetings: 0 })
    }

    fn description(&self) -> Description {
        adapter::description(
            &self.scene,
            format!("{}.contact", self.scene.name),
            "Contact between rods and wings, by a force and an impedance at each station",
        )
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        variables::of(self)
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        either!(&mut self.coupling, own => own.start()).map_err(|e| e.to_string())?;
        log.info(format_args!("{} stations, start at t = {start} s", self.stations));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String> {
        let span = |e| format!("{e}, {}", adapter::span(t, h));
        either!(&mut self.coupling, own => own.advance(h)).map_err(span)?;
        let fast = either!(&self.coupling, own => own.fast());
        fast.iter().skip(self.warned_meetings).for_each(|own| log.warn(self.scene.warning_of(own, t + h)));
        self.warned_meetings = fast.len();
        Ok(())
    }

    fn state_bytes(&self) -> usize {
        STATE_BYTES_PER_STATION * self.stations
    }

    fn save(&self) -> Self::State {
        of_both!(&self.coupling, own => own.state().clone())
    }

    fn restore(&mut self, state: &Self::State) -> Result<(), String> {
        adapter::restore!(&mut self.coupling, state, own => own)
    }
}

adapter::export_unit!(ContactUnit);
