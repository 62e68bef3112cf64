//! A fluid and its rods or wings with one exchange in a step: these step first, then the fluid, as the class
//! `Explicit` of `python/nervure/coupling/schemes.py` steps the units.

use fluid::{Error, Fluid, Parameters, Solvable};
use fpenv::Fast;
use rod::Loads;
use scene::{CouplingScheme, Load, Scene};

/// Magnitude that no force may reach, N, in the plane per metre of depth: the limit of the Python tool.
const LARGEST: f64 = 1e12;
/// Parts of a step for which loads have to hold before it has fewer exchanges, as `LONGER` of the Python tool.
const LONGER: f64 = 1.1;
/// Part of a step that is rounding.
const ROUNDING: f64 = 1e-9;

/// A rod or a wing with its part of the scene.
pub trait Flexible<const D: usize>: Sized {
    /// Return those of a scene, with their roots in the places of time 0.
    ///
    /// # Errors
    /// A scene whose parts this program cannot run.
    fn all(scene: &Scene) -> Result<Vec<Self>, String>;

    /// Return the loads of the next step.
    fn loads_mut(&mut self) -> &mut Loads;

    /// Step from `t` to `t + h` (s) with these loads.
    ///
    /// # Errors
    /// A solver that fails, with its reason.
    fn step(&mut self, t: f64, h: f64) -> Result<(), String>;

    /// Return component `axis` of the positions of the stations, m.
    fn positions(&self, axis: usize) -> &[f64];

    /// Return component `axis` of their velocities, m/s.
    fn velocities(&self, axis: usize) -> &[f64];

    /// Continue from the state of another one.
    ///
    /// # Errors
    /// A state that does not fit.
    fn continue_from(&mut self, other: &Self) -> Result<(), String>;

    /// Append to a sample the displacement of the tip, m, and what else is measured.
    fn sample(&self, to: &mut Vec<f64>);
}

/// A fluid with the rods or wings in it.
pub struct Coupled<const D: usize, F>
where
    [f64; D]: Solvable<D>,
{
    scene: Scene,
    fluid: Fluid<D>,
    pub(crate) flexible: Vec<F>,
    /// Time before the first of `steps`, s.
    start: f64,
    /// Steps made since `start`.
    steps: u32,
    /// Length of the last exchange, s; 0 before the first.
    last: f64,
}

impl<const D: usize, F: Flexible<D>> Coupled<D, F>
where
    [f64; D]: Solvable<D>,
    Parameters<D>: for<'a> TryFrom<&'a Scene, Error = Error>,
{
    /// The fluid of a scene file with what is in it, at t = 0.
    ///
    /// # Errors
    /// A scene with faults, or one that this program cannot run.
    pub fn new(text: &str) -> Result<Self, String> {
        Self::of(Scene::from_json(text).map_err(|e| e.to_string())?)
    }

    /// The same of a scene.
    pub(crate) fn of(mut scene: Scene) -> Result<Self, String> {
        let scheme = scene.coupling.as_ref().and_then(|coupling| coupling.scheme);
        if scheme.is_some_and(|scheme| scheme != CouplingScheme::Explicit) {
            return Err("`coupling.scheme` must be `explicit` here: one exchange in a step, the rods first".into());
        }
        if scene.load() == Some(Load::PressureJump) && scheme.is_none() {
            return Err(
                "a rod that weighs less than the fluid it displaces needs iterations, which are not made here".into()
            );
        }
        if let Some(fluid) = &mut scene.fluid {
            fluid.threads = 1;
        }
        let parameters = Parameters::<D>::try_from(&scene).map_err(|e| e.to_string())?;
        let fluid = Fluid::new(&parameters).map_err(|e| e.to_string())?;
        let flexible = F::all(&scene)?;
        Ok(Self { scene, fluid, flexible, start: 0.0, steps: 0, last: 0.0 })
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
        if next.flexible.len() != self.flexible.len() {
            return Err("the scene has another number of rods or wings".into());
        }
        for (new, old) in next.flexible.iter_mut().zip(&self.flexible) {
            new.continue_from(old)?;
        }
        next.start = time;
        *self = next;
        Ok(())
    }

    /// Return the scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Return the fluid.
    pub fn fluid(&mut self) -> &mut Fluid<D> {
        &mut self.fluid
    }

    /// Return the present time, s.
    pub fn time(&self) -> f64 {
        self.start + f64::from(self.steps) * self.scene.time.communication_step
    }

    /// Return the number of rods or wings.
    pub fn flexible(&self) -> usize {
        self.flexible.len()
    }

    /// Return component `axis` of the positions of the stations of a rod or a wing, m.
    pub fn positions(&self, number: usize, axis: usize) -> &[f64] {
        self.flexible[number].positions(axis)
    }

    /// Make one step of the size of the scene, with an exchange in each step of the fluid.
    ///
    /// # Errors
    /// A solver that fails, with its reason.
    pub fn step(&mut self) -> Result<(), String> {
        let _fast = Fast::enter();
        let (t, h) = (self.time(), self.scene.time.communication_step);
        // As `python/nervure/coupling`: the announced loads hold for a step as long as the last one, or that divided.
        let whole = |number: f64| (number - ROUNDING).ceil().max(1.0);
        let parts = |own: &Self, h: f64| if own.fluid.announces() { whole(h / own.fluid.longest_step()) } else { 1.0 };
        if self.last == 0.0 || 2.0 * parts(self, LONGER * h) <= h / self.last * (1.0 + ROUNDING) {
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
        let force = self.fluid.force();
        // A number that is none is not below either.
        if force.iter().all(|force| force.abs() < LARGEST) {
            return Ok(());
        }
        let force = force.map(|force| format!("{force:.3e}")).join(", ");
        let unit = if D == 2 { "N/m" } else { "N" };
        Err(format!("the force of the flow is {force} {unit} at t = {:.3} s", self.time()))
    }

    /// Step what is flexible from `t` to `t + h` (s) with the present loads, then the fluid.
    fn exchange(&mut self, t: f64, h: f64) -> Result<(), String> {
        for (i, own) in self.flexible.iter_mut().enumerate() {
            take_loads(&mut self.fluid, i, own.loads_mut());
            own.step(t, h).map_err(|e| format!("{e}, in the step from t = {t} s"))?;
        }
        for (stations, own) in self.fluid.stations_mut().iter_mut().zip(&self.flexible) {
            for axis in 0..D {
                stations.position[axis].copy_from_slice(own.positions(axis));
                stations.velocity[axis].copy_from_slice(own.velocities(axis));
            }
        }
        self.fluid.advance(t, h).map_err(|e| e.to_string())
    }

    /// Return the time, the force of the fluid along each axis, what each rod or wing appends, and the position of
    /// each body, in SI units.
    pub fn sample(&self) -> Vec<f64> {
        let mut sample = vec![self.time()];
        sample.extend(self.fluid.force());
        self.flexible.iter().for_each(|own| own.sample(&mut sample));
        let part = self.scene.fluid.as_ref();
        let bodies = part.map_or(0..0, |part| part.cylinders.len()..part.cylinders.len() + part.bodies.len());
        sample.extend(bodies.flat_map(|body| <[f64; D]>::from(self.fluid.pose(body).position)));
        sample
    }
}

/// Copy the loads of the fluid on flexible body number `i` to those of its solver; absent loads stay absent.
fn take_loads<const D: usize>(fluid: &mut Fluid<D>, i: usize, loads: &mut Loads)
where
    [f64; D]: Solvable<D>,
{
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
