//! FMI co-simulation unit of the elastic wing.

mod from_scene;
mod variables;

use adapter::{Announced, Carried};
use fmi_export::{Description, Log, Model, Resources, Variable, require_memory};
use scene::{Scene, WingDrive};
use wing::{Energy, Error, Loads, Membrane, RigidMotion, RootResponse, Statistics, Wing};

/// Memory of a wing with its matrix, rounded up, bytes per node of a large mesh.
const BYTES_PER_NODE: usize = 20_000;
/// Memory of a copy of the state, rounded up, bytes per node.
const STATE_BYTES_PER_NODE: usize = 300;

const BUILT: &str = "an instance has a solver";

/// The unit of a wing.
pub struct WingUnit {
    scene: Scene,
    own: scene::Wing,
    /// Name of the unit.
    name: String,
    /// Base at the end of the next step, if the master or a body moves it.
    base: Option<Base>,
    /// Response of the root, if a body carries the wing.
    announced: Option<Announced>,
    parameters: Parameters,
    /// Parameters of the wing that is built of them.
    rest: wing::Parameters,
    /// Solids that the wing touches.
    solids: Vec<scene::Body>,
    /// Loads of the next step.
    loads: Loads,
    /// None in a description.
    wing: Option<Wing>,
    energy: Energy,
    damping_power: f64,
    crossings: usize,
    /// Node farthest from the pivot at rest.
    tip: usize,
}

/// Base that the master moves.
#[derive(Clone, Copy)]
struct Base {
    position: [f64; 3],
    velocity: [f64; 3],
    /// Rows of the rotation from rest.
    rotation: [f64; 9],
    omega: [f64; 3],
}

/// Parameters that a master may set before the start.
#[derive(Clone, Copy)]
pub struct Parameters {
    /// The one outside regions; absent for veins alone.
    membrane: Option<Membrane>,
    gravity: [f64; 3],
    relaxation_time: f64,
    displaced_density: f64,
}

impl WingUnit {
    fn new(scene: Scene) -> Result<Self, String> {
        let Some(of_scene) = scene.wing_of_unit() else {
            return Err(match scene.wings.is_empty() {
                true => format!("the scene {:?} has no wing", scene.name),
                false => "the scene has several wings, but no key `this_wing` selects one of them".into(),
            });
        };
        let (own, name) = (of_scene.wing.clone(), of_scene.name.to_string());
        let (hinge, is_driven) = (scene.hinge_of(&name), matches!(own.root_motion, Some(WingDrive::Master(_))));
        let base = (hinge.is_some() || is_driven).then(|| Base {
            position: hinge.map_or(own.pivot, |hinge| scene.place_of(hinge)),
            velocity: [0.0; 3],
            rotation: std::array::from_fn(|i| {
                let axis = std::array::from_fn(|d| if d == i % 3 { 1.0 } else { 0.0 });
                hinge.map_or(axis, |hinge| hinge.at_start(axis))[i / 3]
            }),
            omega: [0.0; 3],
        });
        let announced = hinge.map(|_| Announced::new(scene.time.communication_step));
        let rest = from_scene::parameters(&scene, &own);
        let nodes = rest.mesh.nodes.len();
        require_memory(BYTES_PER_NODE * nodes)?;
        rest.check().map_err(|e| e.to_string())?;
        let distance =
            |k: &usize| -> f64 { rest.mesh.nodes[*k].iter().zip(own.pivot).map(|(x, o)| (x - o).powi(2)).sum() };
        let wing::Parameters { gravity, relaxation_time, displaced_density, .. } = rest;
        Ok(Self {
            tip: (0..nodes).max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0),
            parameters: Parameters {
                membrane: rest.membranes.first().copied(),
                gravity,
                relaxation_time,
                displaced_density,
            },
            loads: Loads { force: vec![0.0; 3 * nodes], impedance: vec![0.0; nodes], ..Loads::default() },
            energy: Energy::default(),
            damping_power: 0.0,
            crossings: 0,
            wing: None,
            solids: scene.contact_bodies(),
            name,
            base,
            announced,
            rest,
            scene,
            own,
        })
    }

    /// Return the number of nodes.
    fn nodes(&self) -> usize {
        self.rest.mesh.nodes.len()
    }

    fn wing(&self) -> &Wing {
        self.wing.as_ref().expect(BUILT)
    }

    fn wing_mut(&mut self) -> &mut Wing {
        self.wing.as_mut().expect(BUILT)
    }

    /// Rebuild the wing if its parameters changed.
    fn apply(&mut self) -> Result<(), Error> {
        let Parameters { membrane, gravity, relaxation_time, displaced_density } = self.parameters;
        let known = &self.rest;
        if known.membranes.first().copied() == membrane
            && (known.gravity, known.relaxation_time, known.displaced_density)
                == (gravity, relaxation_time, displaced_density)
        {
            return Ok(());
        }
        let mut rest = wing::Parameters { gravity, relaxation_time, displaced_density, ..known.clone() };
        rest.membranes.iter_mut().zip(membrane).for_each(|(own, membrane)| *own = membrane);
        self.set_wing(rest.clone().build()?);
        self.rest = rest;
        Ok(())
    }

    fn set_wing(&mut self, mut wing: Wing) {
        wing.loads = self.loads.clone();
        if self.announced.is_some() {
            wing.carry();
        }
        self.wing = Some(wing);
    }

    /// Place the wing at rest on its base, in the state of the base at time `t`, if the base moves.
    fn place(&mut self, t: f64) -> Result<(), Error> {
        self.move_solids([t; 2]);
        match self.base_at(t) {
            Some(base) => self.wing_mut().place(base),
            None => Ok(()),
        }
    }

    /// Move the solids that laws move, between two times, s.
    fn move_solids(&mut self, times: [f64; 2]) {
        let wing = self.wing.as_mut().expect(BUILT);
        for (i, own) in self.solids.iter().enumerate().filter(|(_, own)| own.laws().is_some()) {
            wing.move_obstacle(i, times.map(|t| own.place_at(t)));
        }
    }

    /// Return the state of the base at time `t`; `None` for a base at rest, and for a free wing.
    fn base_at(&self, t: f64) -> Option<RigidMotion> {
        let Some(Base { position, velocity, rotation, omega }) = self.base else {
            return self.own.laws().map(|laws| from_scene::pose(laws, t));
        };
        Some(RigidMotion {
            displacement: std::array::from_fn(|d| position[d] - self.own.pivot[d]),
            velocity,
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[3 * i + j])),
            angular_velocity: omega,
        })
    }

    /// Return the base that the master moves, to be set.
    fn base_mut(&mut self) -> &mut Base {
        self.mark_stale();
        self.base.as_mut().expect("there are inputs of a base")
    }

    /// Compute what several outputs read, or what a step may fail to give.
    fn copy_to_outputs(&mut self) -> Result<(), Error> {
        let wing = self.wing.as_mut().expect(BUILT);
        self.energy = wing.energy()?;
        self.crossings = wing.crossings();
        self.damping_power = if self.parameters.relaxation_time > 0.0 { wing.damping_power()? } else { 0.0 };
        Ok(())
    }
}

impl Carried for WingUnit {
    fn announced(&mut self) -> Option<&mut Announced> {
        self.announced.as_mut()
    }

    fn response(&mut self) -> &RootResponse {
        let base = self.base_at(0.0);
        let Self { announced: Some(announced), wing: Some(wing), loads, .. } = self else { return &adapter::UNKNOWN };
        announced.or_find(|step| {
            wing.base_motion = base;
            wing.loads.copy_from(loads);
            wing.root_response(step)
        })
    }
}

impl Model for WingUnit {
    const IDENTIFIER: &'static str = "fmu_wing";
    const VERSION: &'static str = env!("CARGO_PKG_VERSION");
    const RESOURCES: &'static [&'static str] = adapter::RESOURCES;
    const STATE_LAYOUT: u32 = 2;
    type State = wing::WingState;

    fn load(resources: &Resources) -> Result<Self, String> {
        Self::new(adapter::scene_of(resources)?)
    }

    fn build(&mut self) -> Result<(), String> {
        self.set_wing(self.rest.clone().build().map_err(|e| e.to_string())?);
        self.place(0.0).and_then(|()| self.copy_to_outputs()).map_err(|e| e.to_string())
    }

    fn description(&self) -> Description {
        adapter::description(
            &self.scene,
            format!("{}.{}", self.scene.name, self.name),
            "Elastic wing of veins and a membrane, implicit in time",
        )
    }

    fn variables(&self) -> Vec<Variable<Self>> {
        variables::list(self)
    }

    fn initialise(&mut self, start: f64, log: &Log) -> Result<(), String> {
        self.mark_stale();
        self.apply()
            .and_then(|()| self.place(start))
            .and_then(|()| self.copy_to_outputs())
            .map_err(|e| e.to_string())?;
        log.info(format_args!("{} nodes, start at t = {start} s", self.nodes()));
        Ok(())
    }

    fn step(&mut self, t: f64, h: f64, log: &Log) -> Result<(), String> {
        let span = || adapter::span(t, h);
        self.begin_step(h)?;
        let base = self.base_at(t + h);
        self.move_solids([t, t + h]);
        let wing = self.wing.as_mut().expect(BUILT);
        if self.announced.as_ref().is_some_and(Announced::was_saved) {
            wing.forget_trial();
        }
        wing.base_motion = base;
        wing.loads.copy_from(&self.loads);
        wing.step(h).and_then(|()| self.copy_to_outputs()).map_err(|e| format!("{e}, {}", span()))?;
        let Statistics { iterations, substeps, halvings, rescues, .. } = self.wing().statistics();
        if rescues > 0 || halvings > 0 {
            log.info(format_args!(
                "{rescues} solves needed a line search, {substeps} sub-steps after {halvings} halvings, {iterations} \
                 Newton iterations, {}",
                span()
            ));
        }
        Ok(())
    }

    fn state_bytes(&self) -> usize {
        STATE_BYTES_PER_NODE * self.nodes()
    }

    fn fault(&self) -> Option<String> {
        self.announced.as_ref().and_then(Announced::fault)
    }

    fn save(&self) -> wing::WingState {
        self.announced.iter().for_each(Announced::note_saved);
        self.wing().state().clone()
    }

    fn restore(&mut self, state: &wing::WingState) -> Result<(), String> {
        self.mark_stale();
        self.apply().map_err(|e| e.to_string())?;
        self.wing_mut().restore(state).and_then(|()| self.copy_to_outputs()).map_err(|e| e.to_string())
    }
}

adapter::export_unit!(WingUnit);
