//! A fluid and its rods with one exchange in a step: the rods step first, then the fluid, as the class `Explicit` of
//! `python/nervure/coupling/schemes.py` steps the units.

use fluid::{Fluid, Parameters};
use fpenv::Fast;
use rod::{BaseMotion, Loads, Rod};
use scene::{Beam, CouplingScheme, Load, RootMotion, Scene};

use crate::from_scene;

/// Magnitude that no force may reach, N per metre of depth: the limit of the Python tool.
const LARGEST: f64 = 1e12;

/// A fluid with the rods in it.
pub struct Coupled {
    scene: Scene,
    fluid: Fluid,
    rods: Vec<RodInFlow>,
    /// Time before the first of `steps`, s.
    start: f64,
    /// Steps made since `start`.
    steps: u32,
    /// Length of the last exchange, s; 0 before the first.
    last: f64,
    pull: Option<Pull>,
}

/// A rod with its part of the scene.
struct RodInFlow {
    rod: Rod<2>,
    beam: Beam,
    model: scene::Rod,
    scene: Scene,
}

/// A spring from a station of a rod to a point of the plane.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Number of the rod, from 0.
    pub rod: usize,
    /// Number of the station, from 0 at the root.
    pub station: usize,
    /// The other end of the spring, m.
    pub to: [f64; 2],
    /// Stiffness, N/m per metre of depth.
    pub stiffness: f64,
}

impl RodInFlow {
    /// The rod of a scene with a single rod, with its root in the place of time 0.
    fn new(scene: Scene) -> Result<Self, String> {
        let (Some(beam), Some(model)) = (scene.beam.clone(), scene.rod.clone()) else {
            return Err(format!("the scene {:?} has no beam with a rod", scene.name));
        };
        if scene.dimension(&beam) != 2 {
            return Err("a rod in space cannot be in this flow, which has two dimensions".into());
        }
        if matches!(model.root_motion, Some(RootMotion::Master)) {
            return Err("`rod.root_motion` is left to a master, but here only laws of time can drive a root".into());
        }
        let mut rod = Rod::new(from_scene::parameters(&scene, &beam, &model)).map_err(|e| e.to_string())?;
        rod.loads = from_scene::loads(&scene, 2, beam.segments + 1);
        let mut own = Self { rod, beam, model, scene };
        if let Some(base) = own.base_at(0.0) {
            own.rod.place(base).map_err(|e| e.to_string())?;
        }
        Ok(own)
    }

    /// Return the motion of a driven root at `t` (s).
    fn base_at(&self, t: f64) -> Option<BaseMotion<2>> {
        let Some(RootMotion::Laws(laws)) = &self.model.root_motion else { return None };
        let (rest, direction) = self.scene.beam_root(&self.beam);
        let (displacement, velocity) = laws.displacement(t);
        let (direction, rate) = laws.direction(t, direction);
        let plane = |[x, y, _]: [f64; 3]| [x, y];
        let position = std::array::from_fn(|d| rest[d] + displacement[d]);
        Some(BaseMotion {
            position,
            velocity: plane(velocity),
            direction: plane(direction),
            direction_rate: plane(rate),
        })
    }

    /// Step from `t` to `t + h` (s) with the loads that were set.
    fn step(&mut self, t: f64, h: f64) -> Result<(), String> {
        if let Some(base) = self.base_at(t + h) {
            self.rod.base_motion = Some(base);
        }
        if let Some([x, y, _]) = self.model.root.towing_force(t + h) {
            self.rod.towing = [x, y];
        }
        self.rod.step(h).map_err(|e| format!("{e}, in the step from t = {t} s"))
    }

    /// Add the force of a spring to the loads: that for a station that keeps its velocity, with the impedance by which the
    /// stretch counts that the step ends with.
    fn pull(&mut self, pull: &Pull, h: f64) {
        let n = self.beam.segments + 1;
        let station = pull.station.min(n - 1);
        let ahead = |axis| self.rod.positions(axis)[station] + h * self.rod.velocities(axis)[station];
        let stretch = [0, 1].map(|axis| pull.to[axis] - ahead(axis));
        let Loads { force, impedance, .. } = &mut self.rod.loads;
        force.resize(2 * n, 0.0);
        impedance.resize(n, 0.0);
        for (force, stretch) in force.chunks_exact_mut(n).zip(stretch) {
            force[station] += pull.stiffness * stretch;
        }
        impedance[station] += pull.stiffness * h;
    }
}

impl Coupled {
    /// The fluid and the rods of a scene file at t = 0.
    ///
    /// # Errors
    /// A scene with faults, or one that this program cannot run.
    pub fn new(text: &str) -> Result<Self, String> {
        let mut scene = Scene::from_json(text).map_err(|e| e.to_string())?;
        if scene
            .coupling
            .as_ref()
            .and_then(|coupling| coupling.scheme)
            .is_some_and(|scheme| scheme != CouplingScheme::Explicit)
        {
            return Err("`coupling.scheme` must be `explicit` here: one exchange in a step, the rods first".into());
        }
        if scene.load() == Some(Load::PressureJump) && scene.coupling.as_ref().is_none_or(|own| own.scheme.is_none()) {
            return Err(
                "a rod that weighs less than the fluid it displaces needs iterations, which are not made here".into()
            );
        }
        if let Some(fluid) = &mut scene.fluid {
            fluid.threads = 1;
        }
        let parameters = Parameters::<2>::try_from(&scene).map_err(|e| e.to_string())?;
        let fluid = Fluid::new(&parameters).map_err(|e| e.to_string())?;
        let of_rod = |name: Option<String>| Scene { this_rod: name, ..scene.clone() }.of_unit();
        let rods = if scene.rods.is_empty() {
            scene.rod.iter().filter_map(|_| of_rod(None)).map(RodInFlow::new).collect::<Result<_, _>>()?
        } else {
            let names = scene.rods.iter().map(|rod| Some(rod.name.clone()));
            names.filter_map(of_rod).map(RodInFlow::new).collect::<Result<_, _>>()?
        };
        Ok(Self { scene, fluid, rods, start: 0.0, steps: 0, last: 0.0, pull: None })
    }

    /// Continue with another scene from the present flow: with other values, or with more or fewer cylinders, after
    /// which the time scheme of the fluid starts again.
    ///
    /// # Errors
    /// A scene that cannot be run, or that the flow does not fit; then nothing changes.
    pub fn change(&mut self, text: &str) -> Result<(), String> {
        let (mut next, time) = (Self::new(text)?, self.time());
        let cylinders = |of: &Scene| of.fluid.as_ref().map(|fluid| fluid.cylinders.len());
        if cylinders(&next.scene) == cylinders(&self.scene) {
            next.fluid.restore(&self.fluid.state()).map_err(|e| e.to_string())?;
            next.last = self.last;
        } else {
            next.fluid.continue_from(&self.fluid).map_err(|e| e.to_string())?;
        }
        if next.rods.len() != self.rods.len() {
            return Err("the scene has another number of rods".into());
        }
        for (new, old) in next.rods.iter_mut().zip(&self.rods) {
            new.rod.restore(old.rod.state()).map_err(|e| e.to_string())?;
        }
        (next.start, next.pull) = (time, self.pull);
        *self = next;
        Ok(())
    }

    /// Return the scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Return the fluid.
    pub fn fluid(&mut self) -> &mut Fluid {
        &mut self.fluid
    }

    /// Return the present time, s.
    pub fn time(&self) -> f64 {
        self.start + f64::from(self.steps) * self.scene.time.communication_step
    }

    /// Return the number of rods.
    pub fn rods(&self) -> usize {
        self.rods.len()
    }

    /// Return component `axis` of the positions of the stations of a rod, m.
    pub fn positions(&self, rod: usize, axis: usize) -> &[f64] {
        self.rods[rod].rod.positions(axis)
    }

    /// Pull at a station from now on, or let go.
    pub fn set_pull(&mut self, pull: Option<Pull>) {
        self.pull = pull.filter(|pull| pull.rod < self.rods.len());
    }

    /// Make one step of the size of the scene, with an exchange in each step of the fluid.
    ///
    /// # Errors
    /// A solver that fails, with its reason.
    pub fn step(&mut self) -> Result<(), String> {
        let _fast = Fast::enter();
        let (t, h) = (self.time(), self.scene.time.communication_step);
        // As `python/nervure/coupling`: the announced loads hold for a step as long as the last one, or that divided.
        let whole = |number: f64| (number - 1e-9).ceil().max(1.0);
        let parts = |own: &Self, h: f64| if own.fluid.announces() { whole(h / own.fluid.longest_step()) } else { 1.0 };
        if self.last == 0.0 || 2.0 * parts(self, h) <= h / self.last * (1.0 + 1e-9) {
            self.last = h;
        }
        let mut left = h;
        while left > 0.0 {
            let count = whole(left / self.last * parts(self, self.last));
            self.last = left / count;
            self.exchange(t + (h - left), self.last)?;
            left = if count > 1.0 { left - self.last } else { 0.0 };
        }
        self.steps += 1;
        let [drag, lift] = self.fluid.force();
        if drag.abs().max(lift.abs()) < LARGEST {
            return Ok(());
        }
        Err(format!("the force of the flow is {drag:.3e}, {lift:.3e} N/m at t = {:.3} s", self.time()))
    }

    /// Step the rods from `t` to `t + h` (s) with the present loads, then the fluid.
    fn exchange(&mut self, t: f64, h: f64) -> Result<(), String> {
        for (i, own) in self.rods.iter_mut().enumerate() {
            take_loads(&mut self.fluid, i, &mut own.rod.loads);
            if let Some(pull) = self.pull.filter(|pull| pull.rod == i) {
                own.pull(&pull, h);
            }
            own.step(t, h)?;
        }
        for (stations, own) in self.fluid.stations_mut().iter_mut().zip(&self.rods) {
            for axis in 0..2 {
                stations.position[axis].copy_from_slice(own.rod.positions(axis));
                stations.velocity[axis].copy_from_slice(own.rod.velocities(axis));
            }
        }
        self.fluid.advance(t, h).map_err(|e| e.to_string())
    }

    /// Return time, drag and lift, the displacement of the tip of each rod, and the position of each body, in SI units.
    pub fn sample(&self) -> impl Iterator<Item = f64> {
        let tips = self.rods.iter().flat_map(|own| own.rod.tip_displacement());
        let bodies = self
            .scene
            .fluid
            .as_ref()
            .map_or(0..0, |fluid| fluid.cylinders.len()..fluid.cylinders.len() + fluid.bodies.len());
        let places = bodies.flat_map(|body| <[f64; 2]>::from(self.fluid.pose(body).position));
        [self.time()].into_iter().chain(self.fluid.force()).chain(tips).chain(places)
    }
}

/// Copy the loads of the fluid on beam number `i` to those of its rod; absent loads stay absent.
fn take_loads(fluid: &mut Fluid, i: usize, loads: &mut Loads) {
    if let Some(given) = fluid.loads().get(i) {
        let n = given.impedance.len();
        for (own, given) in loads.force.chunks_exact_mut(n).zip(&given.force) {
            own.copy_from_slice(given);
        }
        loads.impedance.copy_from_slice(&given.impedance);
    } else {
        loads.force.fill(0.0);
        loads.impedance.fill(0.0);
    }
    if !loads.pressure_jump.is_empty() {
        loads.pressure_jump.copy_from_slice(&fluid.pressure_jump()[i]);
    }
    if !loads.pressure.is_empty() {
        loads.pressure.copy_from_slice(&fluid.pressure_around()[i]);
    }
}
