//! The rod: state and stepping.

use std::f64::consts::PI;

use scene::{Load, RodScheme, Scene};

use crate::banded::Banded;
use crate::elastic::{BadShape, Elastic, FOLD, Vector};
use crate::error::{Error, LARGEST_GAIN};
use crate::hinge::Hinge;
use crate::newton::{Balance, Failure, Imbalance, Newton, Problem, Statistics};
use crate::parameters::{Hold, Loads, Parameters, Taper};
use crate::root::{Clamp, Root, cross};
use crate::scheme::{LastStage, StepRule, TRAPEZOID_PART};
use crate::state::{Drive, Exchange, State};

/// A step that fails is halved at most this many times.
const HALVINGS: u32 = 6;
/// Most steps of `max_step` that one call may ask for, each of which may be halved six times.
const MAX_STEPS: f64 = 1e4;
/// A strain, and turning angle per node, whose energy is nothing but rounding.
const NO_STRAIN: f64 = 1e-10;

/// Energies, J (per metre of depth in two dimensions).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Of the rod's own mass.
    pub kinetic: f64,
    /// Of the segments' extension.
    pub stretching: f64,
    /// Of the turning angles, shear included.
    pub bending: f64,
    /// Of the rod's own mass in gravity, 0 at the height of the root at rest.
    pub gravity: f64,
}

/// The rod with its state, loads and scratch; [`Rod::step`] allocates nothing.
pub struct Rod<const D: usize> {
    /// Loads of the next step.
    pub loads: Loads,
    /// Where the next step takes the clamp; `None`: it is still, in its place at rest.
    pub root: Option<Root<D>>,
    /// Force that tows a free root, N, at the end of the next step; on no other root has it an effect.
    pub towing: [f64; D],
    pub(crate) parameters: Parameters<D>,
    pub(crate) elastic: Elastic<D>,
    rest: Vec<Vector<D>>,
    /// Length that belongs to each node, m: `[n + 1]`.
    pub(crate) tributary: Vec<f64>,
    /// Mass of each node, kg: `[n + 1]`.
    masses: Vec<f64>,
    pub(crate) state: State<D>,
    statistics: Statistics,
    /// Positions and velocities component after component: `[D, n + 1]`.
    positions: Vec<f64>,
    velocities: Vec<f64>,
    pub(crate) newton: Newton<D>,
    /// The torsion spring at the root in the plane.
    pub(crate) hinge: Option<Hinge>,
    pub(crate) balance: Balance<D>,
    /// State before the step.
    pub(crate) before: State<D>,
    /// State before the sub-step (TR-BDF2).
    before_substep: State<D>,
    /// What the last step, if it was taken in one piece, left for sensitivities.
    pub(crate) last: Option<LastStage<D>>,
    /// Nodal forces without damping and impedance, N: `[n + 1]`.
    force: Vec<Vector<D>>,
    /// Positions that Newton's method works on, m: `[n + 1]`.
    guess: Vec<Vector<D>>,
}

impl<const D: usize> Rod<D> {
    /// A rod at rest without loads.
    pub fn new(parameters: Parameters<D>) -> Result<Self, Error> {
        const { assert!(D == 2 || D == 3, "a rod lives in 2 or 3 dimensions") };
        parameters.check()?;
        let &Parameters { length, segments, .. } = &parameters;
        let root = Vector::from(parameters.root);
        let direction = Vector::from(parameters.direction).normalize();
        let rest = parameters.rest_shape(root, direction);
        let nodes = segments + 1;
        let hinge = parameters.hinge();
        let mut at_rest = State::at_rest(rest.clone(), direction, hinge.map(|hinge| hinge.at_rest(0.0)));
        at_rest.pressure = vec![0.0; if parameters.strain_per_pressure > 0.0 { nodes } else { 0 }];
        let first = usize::from(parameters.hold != Hold::Free);
        let shear = parameters.section.shear_stiffness.is_some();
        let mut rod = Self {
            loads: Loads::default(),
            root: None,
            towing: [0.0; D],
            elastic: parameters.elastic(direction),
            tributary: parameters.tributary(),
            masses: parameters.masses(),
            state: at_rest.clone(),
            before: at_rest.clone(),
            before_substep: at_rest,
            last: None,
            statistics: Statistics::default(),
            positions: vec![0.0; D * nodes],
            velocities: vec![0.0; D * nodes],
            newton: Newton::new(segments, length, root.amax() + length, shear, first),
            hinge,
            balance: Balance { weight: vec![0.0; nodes], load: vec![Vector::zeros(); nodes], elastic_weight: 1.0 },
            force: vec![Vector::zeros(); nodes],
            guess: rest.clone(),
            rest,
            parameters,
        };
        rod.elastic.energy(&rod.rest).map_err(|shape| rod.error(shape.into()))?;
        rod.settle_hinge()?;
        rod.publish();
        Ok(rod)
    }

    /// The rod of a scene with the loads that the scene has: nodal forces and (in two dimensions) the pressure jump where
    /// there is no fluid, nodal forces and impedance under the momentum load, the pressure jump under that load. Where
    /// the root moves in time is up to the caller: see [`Rod::place`] and [`Rod::root`].
    pub fn from_scene(scene: &Scene) -> Result<Self, Error> {
        let (Some(beam), Some(rod)) = (&scene.beam, &scene.rod) else {
            return Err(Error::NoRod { scene: scene.name.clone(), dimension: D });
        };
        if scene.dimension(beam) != D {
            return Err(Error::NoRod { scene: scene.name.clone(), dimension: D });
        }
        let (root, direction) = scene.beam_root(beam);
        let mut built = Self::new(Parameters {
            root: std::array::from_fn(|d| root[d]),
            direction: std::array::from_fn(|d| direction[d]),
            length: beam.length,
            segments: beam.segments,
            rest_angles: beam.rest_angles.clone(),
            section: rod.material.section(&beam.thickness, 0.0),
            displaced: scene.displaced_line_density(),
            strain_per_pressure: scene.strain_per_pressure().unwrap_or(0.0),
            taper: Taper::of(beam, &rod.material),
            gravity: std::array::from_fn(|d| rod.gravity.get(d).copied().unwrap_or(0.0)),
            damping: rod.damping,
            bending: rod.bending,
            calibration: rod.calibration,
            hold: match rod.root {
                scene::RootSupport::Clamped => Hold::Clamped,
                scene::RootSupport::Pinned => Hold::Pinned,
                scene::RootSupport::TorsionSpring { stiffness, damping, rest_angle } => {
                    Hold::TorsionSpring { stiffness, damping, rest_angle }
                }
                scene::RootSupport::Free { .. } => Hold::Free,
            },
            clamp_compliance_length: rod.clamp_compliance_length,
            scheme: rod.scheme,
            max_step: rod.max_step,
        })?;
        let nodes = beam.segments + 1;
        let zeros = |count: usize| vec![0.0; count];
        built.loads = match scene.load() {
            None => {
                let pressure_jump = zeros(if D == 2 { nodes } else { 0 });
                Loads { force: zeros(D * nodes), pressure_jump, ..Loads::default() }
            }
            Some(Load::Momentum) => {
                let pressure = zeros(built.state.pressure.len());
                Loads { force: zeros(D * nodes), impedance: zeros(nodes), pressure, ..Loads::default() }
            }
            Some(Load::PressureJump) => Loads { pressure_jump: zeros(nodes), ..Loads::default() },
        };
        Ok(built)
    }

    /// What the rod was made of.
    pub fn parameters(&self) -> &Parameters<D> {
        &self.parameters
    }

    /// Component `d` of the nodes' positions, m: `[n + 1]`.
    pub fn positions(&self, d: usize) -> &[f64] {
        &self.positions[d * self.rest.len()..][..self.rest.len()]
    }

    /// Component `d` of the nodes' velocities, m/s: `[n + 1]`.
    pub fn velocities(&self, d: usize) -> &[f64] {
        &self.velocities[d * self.rest.len()..][..self.rest.len()]
    }

    /// Component `d` of the acceleration of node `k`, m/s².
    pub fn acceleration(&self, d: usize, k: usize) -> f64 {
        self.state.accelerations[k][d]
    }

    /// Displacement of the tip from its rest position, m.
    pub fn tip_displacement(&self) -> [f64; D] {
        let tip = self.parameters.segments;
        (self.state.positions[tip] - self.rest[tip]).into()
    }

    /// Displacement that the tip would have on a rigid rod, m.
    pub fn rigid_tip_displacement(&self) -> [f64; D] {
        let tip = self.parameters.segments;
        let (at_rest, direction) = (Vector::from(self.parameters.direction).normalize(), self.state.direction);
        let arm = self.rest[tip] - self.rest[0];
        let mut turned = direction * arm.dot(&at_rest);
        if D == 2 {
            // A curved rest shape, which only the plane has, is off to the left as well.
            let left = at_rest[0] * arm[1] - at_rest[1] * arm[0];
            (turned[0], turned[1]) = (turned[0] - left * direction[1], turned[1] + left * direction[0]);
        }
        (self.state.positions[0] + turned - self.rest[tip]).into()
    }

    /// Mass of each node less that of the fluid it displaces, kg: `[n + 1]`.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Power that the damping takes, W, that of a torsion spring at the root included.
    pub fn damping_power(&self) -> f64 {
        let squares = self.state.velocities.iter().zip(&self.tributary).map(|(v, l)| l * v.norm_squared());
        let of_rod = self.parameters.damping * squares.sum::<f64>();
        match (self.hinge, self.state.hinge) {
            (Some(hinge), Some(state)) => of_rod + hinge.damping * state.rate.powi(2),
            _ => of_rod,
        }
    }

    /// Angle by which a torsion spring at the root is turned, rad, and its rate, rad/s; in the plane only.
    pub fn hinge(&self) -> Option<[f64; 2]> {
        self.state.hinge.map(|hinge| [hinge.angle, hinge.rate])
    }

    /// Bring a torsion spring at the root to rest in the present shape.
    fn settle_hinge(&mut self) -> Result<(), Error> {
        let Some(hinge) = self.hinge else { return Ok(()) };
        let Self { elastic, state, newton, .. } = self;
        let moment = elastic.spring_moment(&state.positions, &mut newton.moments);
        self.state.hinge = Some(hinge.at_rest(moment.map_err(|shape| self.error(shape.into()))?));
        self.align();
        Ok(())
    }

    /// Let the elastic energy see clamp, pressure and spring as they are; without damping the spring is always in series with half
    /// a segment.
    fn align(&mut self) {
        self.elastic.direction = self.state.direction;
        self.elastic.set_pressure(self.parameters.strain_per_pressure, &self.state.pressure);
        if let (Some(hinge), Some(state)) = (self.hinge.filter(Hinge::is_damped), self.state.hinge) {
            self.elastic.set_spring(hinge.beside, state.angle, hinge.energy(state.angle));
        }
    }

    /// Energies of the state.
    pub fn energy(&self) -> Result<Energy, Error> {
        let elastic = self.elastic.energy(&self.state.positions).map_err(|shape| self.error(shape.into()))?;
        let gravity = Vector::from(self.parameters.gravity);
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for k in 0..self.rest.len() {
            let m = self.mass(k);
            kinetic += 0.5 * m * self.state.velocities[k].norm_squared();
            potential -= m * gravity.dot(&(self.state.positions[k] - self.rest[0]));
        }
        Ok(Energy { kinetic, stretching: elastic.stretching, bending: elastic.bending, gravity: potential })
    }

    /// What the last step took.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// All that the rod remembers.
    pub fn state(&self) -> &State<D> {
        &self.state
    }

    /// Continue from `state`; with the same loads and steps the continuation repeats bit by bit.
    ///
    /// Refuses a state of another number of nodes, with numbers that are not finite, with a clamp that is not where it
    /// is at rest (unless it is free, or [`Rod::root`] moves it), without the angle of a torsion spring, or of a shape
    /// without energy.
    pub fn restore(&mut self, state: &State<D>) -> Result<(), Error> {
        state.check(self.rest.len())?;
        let (direction, still) = (Vector::from(self.parameters.direction).normalize(), Vector::zeros());
        for (name, found, expected, allowed) in [
            ("positions[0]", state.positions[0], self.rest[0], "the root's position"),
            ("velocities[0]", state.velocities[0], still, "0 at the clamp"),
            ("direction", state.direction, direction, "the direction at the clamp"),
            ("direction_rate", state.direction_rate, still, "0 at the clamp"),
        ] {
            if self.root.is_none() && self.parameters.hold != Hold::Free && found != expected {
                return Err(Error::value(format!("state.{name}"), found.as_slice(), allowed));
            }
        }
        if state.hinge.is_some() != self.hinge.is_some() {
            let allowed = "there where a torsion spring holds the root in the plane, and nowhere else";
            return Err(Error::value("state.hinge", format!("{:?}", state.hinge), allowed));
        }
        if state.pressure.len() != self.state.pressure.len() {
            let (length, expected) = (state.pressure.len(), self.state.pressure.len());
            return Err(Error::Length { name: "state.pressure".into(), length, expected });
        }
        let own = std::mem::replace(&mut self.elastic.direction, state.direction);
        if let Err(shape) = self.elastic.energy(&state.positions) {
            self.elastic.direction = own;
            return Err(self.error(shape.into()));
        }
        self.state.copy_from(state);
        self.align();
        self.statistics = Statistics::default();
        self.last = None;
        self.publish();
        Ok(())
    }

    /// Put the rod at rest, in its rest shape, to where `root` is, as before a first step; `root` stays prescribed.
    pub fn place(&mut self, root: Root<D>) -> Result<(), Error> {
        let clamp = root.clamp()?;
        let shape = self.parameters.rest_shape(clamp.position, clamp.direction);
        let elastic = self.parameters.elastic(clamp.direction);
        elastic.energy(&shape).map_err(|shape| self.error(shape.into()))?;
        self.elastic = elastic;
        let pressure = vec![0.0; self.state.pressure.len()];
        self.state = State { pressure, ..State::at_rest(shape, clamp.direction, self.state.hinge) };
        self.state.set_clamp(&clamp);
        self.settle_hinge()?;
        self.last = None;
        self.root = Some(root);
        self.publish();
        Ok(())
    }

    /// Advance by `duration`, s, under the present loads.
    ///
    /// Takes equal sub-steps no longer than `max_step`, and halves those that fail up to six times. The loads are
    /// those at the end of the step; forces with an impedance refer to the velocity at its beginning. On an error the
    /// state is as before.
    pub fn step(&mut self, duration: f64) -> Result<(), Error> {
        if !(duration.is_finite() && duration > 0.0) {
            return Err(Error::value("duration", duration, "a finite number of seconds above 0"));
        }
        // A duration that rounding has made a little too long takes no extra step.
        let steps = self.parameters.max_step.map_or(1.0, |longest| (duration / longest - 1e-9).ceil().max(1.0));
        if steps > MAX_STEPS {
            return Err(Error::value("duration", duration, "no more than 10000 times max_step"));
        }
        self.collect_loads()?;
        let clamp = self.next_clamp()?;
        self.before.copy_from(&self.state);
        self.statistics = Statistics::default();
        self.last = None;
        self.follow_pressure(-(-duration / self.parameters.axial_period()).exp_m1());
        if self.state.last_step == 0.0 {
            self.start()?;
        }
        let whole = 1 << HALVINGS;
        let total = steps as u64 * whole;
        let mut size = whole;
        let mut remaining = total;
        while remaining > 0 {
            let span = Span {
                from: (total - remaining) as f64 / total as f64,
                to: (total - remaining + size) as f64 / total as f64,
                dt: duration * (size as f64 / total as f64),
                duration,
                largest_gain: LARGEST_GAIN * 2.0 / f64::from(2 + size.ilog2()),
                clamp: clamp.as_ref(),
            };
            match self.substep(span) {
                Ok(()) => {
                    remaining -= size;
                    if size < whole && remaining.is_multiple_of(2 * size) {
                        size *= 2;
                    }
                }
                Err(_) if size > 1 => {
                    self.statistics.halvings += 1;
                    size /= 2;
                }
                Err(failure) => {
                    self.state.copy_from(&self.before);
                    self.align();
                    self.last = None;
                    return Err(self.error(failure));
                }
            }
        }
        if self.statistics.substeps > 1 {
            self.last = None;
        }
        self.sum_up_loads(duration);
        if clamp.is_some() {
            self.sum_up_drive(duration)?;
        } else if self.parameters.hold == Hold::Free {
            let force = Vector::from(self.towing);
            let power = force.dot(&self.state.velocities[0]);
            let work = self.state.drive.work + power * duration;
            self.state.drive = Drive { force, moment: [0.0; 3], power, work };
        }
        self.publish();
        Ok(())
    }

    /// Take the pressure that strains the rod so large a `part` of the way to that around it.
    ///
    /// Without a lag a change of the pressure would push the tip at once, and that the pressure there: with short segments and
    /// an exchange once in a step the two drive each other. Below the first axial mode the strain is that of equilibrium anyway.
    fn follow_pressure(&mut self, part: f64) {
        let Self { state: State { pressure, .. }, loads, elastic, parameters, .. } = self;
        if pressure.is_empty() {
            return;
        }
        for (k, own) in pressure.iter_mut().enumerate() {
            *own += part * (loads.pressure.get(k).copied().unwrap_or(0.0) - *own);
        }
        elastic.set_pressure(parameters.strain_per_pressure, pressure);
    }

    /// What the loads did in the step of `duration` seconds that has just been made.
    fn sum_up_loads(&mut self, duration: f64) {
        let nodes = self.rest.len();
        let Loads { force, pressure_jump, impedance, .. } = &self.loads;
        let (mut sum, mut power) = (Vector::zeros(), 0.0);
        for (k, v) in self.state.velocities.iter().enumerate() {
            let mut load = Vector::<D>::from_fn(|d, _| force.get(d * nodes + k).copied().unwrap_or(0.0));
            if let Some(jump) = pressure_jump.get(k) {
                load += pressure_area(&self.before.positions, k) * *jump;
            }
            if let Some(impedance) = impedance.get(k) {
                load -= (v - self.before.velocities[k]) * *impedance;
            }
            sum += load;
            power += load.dot(v);
        }
        let work = self.state.exchange.work + power * duration;
        self.state.exchange = Exchange { force: sum, power, work };
    }

    /// What the clamp did to the rod in the step of `duration` seconds that has just been made.
    ///
    /// Node 0 belongs to the rod: the drive accelerates its mass, and what the loads do there goes through the drive.
    fn sum_up_drive(&mut self, duration: f64) -> Result<(), Error> {
        let reaction = self.elastic.clamp_reaction(&self.state.positions, &mut self.newton.moments);
        let (mut force, moment) = reaction.map_err(|shape| self.error(shape.into()))?;
        let State { velocities, accelerations, direction, direction_rate, .. } = &self.state;
        let v = velocities[0];
        force += accelerations[0] * self.mass(0) + v * (self.parameters.damping * self.tributary[0]) - self.force[0];
        if let Some(impedance) = self.loads.impedance.first() {
            force += (v - self.before.velocities[0]) * *impedance;
        }
        let turning = cross(direction, direction_rate).into_iter().zip(moment).map(|(omega, m)| omega * m);
        let power = force.dot(&v) + turning.sum::<f64>();
        let work = self.state.drive.work + power * duration;
        self.state.drive = Drive { force, moment, power, work };
        Ok(())
    }

    /// Where the next step takes the clamp; `None` where it is still.
    fn next_clamp(&self) -> Result<Option<Clamp<D>>, Error> {
        let Some(root) = &self.root else { return Ok(None) };
        let clamp = root.clamp()?;
        if clamp.direction.dot(&self.state.direction) <= 0.0 {
            return Err(Error::value(
                "root.direction",
                &root.direction[..],
                "less than a right angle from the direction at the beginning of the step",
            ));
        }
        Ok(Some(clamp))
    }

    /// Move to equilibrium under the present loads, at rest, as before a first step; impedance plays no part.
    ///
    /// Where that is too far for Newton's method the loads grow in parts, halved up to six times, from those that the
    /// present shape balances. A pressure jump keeps the direction that it has in the present shape. On an error the
    /// state is as before. A free rod is refused: nothing holds it.
    pub fn solve_static(&mut self) -> Result<(), Error> {
        if self.parameters.hold == Hold::Free {
            return Err(Error::value(
                "hold",
                "Free".to_string(),
                "another for an equilibrium: nothing holds a free rod",
            ));
        }
        self.collect_loads()?;
        self.statistics = Statistics::default();
        self.balance.weight.fill(0.0);
        self.balance.elastic_weight = 1.0;
        if self.hinge.is_some() {
            // Damping plays no part: spring and half a segment in series.
            self.elastic = self.parameters.elastic(self.state.direction);
        }
        let pressure = self.state.pressure.clone();
        self.follow_pressure(1.0);
        let mut missing = self.force.clone();
        let balanced = self.elastic.gradient(&self.state.positions, &mut self.newton.moments, |k, gradient| {
            missing[k] -= gradient;
        });
        balanced.map_err(|shape| self.error(shape.into()))?;
        let mut settled = self.state.positions.clone();
        let whole = 1_u32 << HALVINGS;
        let (mut done, mut size) = (0, whole);
        while done < whole {
            let Self { newton, elastic, balance, force, guess, statistics, .. } = self;
            let left = f64::from(whole - done - size) / f64::from(whole);
            for ((load, force), missing) in balance.load.iter_mut().zip(&*force).zip(&missing) {
                *load = force - missing * left;
            }
            guess.copy_from_slice(&settled);
            let problem = Problem { elastic, balance, origin: &settled };
            match newton.solve(problem, guess, statistics) {
                Ok(()) => {
                    settled.copy_from_slice(guess);
                    statistics.substeps += 1;
                    done += size;
                    size = (2 * size).min(whole - done);
                }
                Err(_) if size > 1 => size = (size / 2).max(1),
                Err(failure) => {
                    self.state.pressure = pressure;
                    self.align();
                    return Err(self.error(failure));
                }
            }
        }
        let clamp = self.state.clamp();
        let pressure = std::mem::take(&mut self.state.pressure);
        self.state = State { pressure, ..State::at_rest(settled, clamp.direction, self.state.hinge) };
        self.state.set_clamp(&clamp);
        self.settle_hinge()?;
        self.last = None;
        self.publish();
        Ok(())
    }

    /// One step by the time scheme; on failure the state is as before.
    fn substep(&mut self, span: Span<D>) -> Result<(), Failure> {
        let last_step = self.state.last_step;
        match self.parameters.scheme {
            RodScheme::Trapezoid => self.stage_with_energy_guard(StepRule::trapezoid(span.dt), span)?,
            RodScheme::GeneralisedAlpha { rho_inf } => {
                self.stage_with_energy_guard(StepRule::generalised_alpha(rho_inf, span.dt), span)?;
            }
            RodScheme::Bdf2 => self.stage(StepRule::bdf2(span.dt, last_step), 1.0, span)?,
            RodScheme::TrBdf2 => {
                self.before_substep.copy_from(&self.state);
                let (first, second) = span.split(TRAPEZOID_PART);
                self.stage(StepRule::trapezoid(first.dt), TRAPEZOID_PART, first)?;
                let second_stage = self.stage(StepRule::bdf2(second.dt, first.dt), 1.0, second);
                if second_stage.is_err() {
                    self.state.copy_from(&self.before_substep);
                    self.align();
                    return second_stage;
                }
            }
        }
        self.state.loads.copy_from_slice(&self.force);
        self.statistics.substeps += 1;
        Ok(())
    }

    /// A whole sub-step by a `rule` that does not bound the energy outside linear problems: fails where the energy less the
    /// work of the loads rises while only constant forces work on the rod. On failure the state is as before.
    ///
    /// The first sub-step under new loads blends two levels of them: the second is the first to compare with.
    fn stage_with_energy_guard(&mut self, rule: StepRule, span: Span<D>) -> Result<(), Failure> {
        let constant = span.clamp.is_none()
            && self.state.last_step > 0.0
            && self.force[self.elastic.first..] == self.state.loads[self.elastic.first..]
            && self.state.pressure.is_empty()
            && self.loads.impedance.iter().all(|&impedance| impedance == 0.0);
        if !constant {
            self.stage(rule, 1.0, span)?;
            self.state.largest_energy = 0.0;
            return Ok(());
        }
        self.before_substep.copy_from(&self.state);
        self.stage(rule, 1.0, span)?;
        let guarded = self.energy_guard(span);
        if guarded.is_err() {
            self.state.copy_from(&self.before_substep);
            self.align();
        }
        guarded
    }

    /// Fail where the energy less the work of the loads is above its reference, or bring that up to date.
    ///
    /// The trapezoid gives back what its oscillating energy has lost: its reference is the first energy, of which only the
    /// damping takes. That of generalised-α, which dissipates, is the lowest.
    fn energy_guard(&mut self, span: Span<D>) -> Result<(), Failure> {
        let shape = self.elastic.energy(&self.state.positions)?;
        let elastic = shape.stretching + shape.bending;
        let (mut kinetic, mut work, mut mean_squares) = (0.0, 0.0, 0.0);
        for (k, force) in self.force.iter().enumerate().skip(self.elastic.first) {
            let (v, v_before) = (self.state.velocities[k], self.before_substep.velocities[k]);
            kinetic += 0.5 * self.mass(k) * v.norm_squared();
            work += force.dot(&(self.state.positions[k] - self.rest[0]));
            mean_squares += 0.25 * self.tributary[k] * (v + v_before).norm_squared();
        }
        let energy = kinetic + elastic - work;
        let mut damped = self.parameters.damping * mean_squares * span.dt;
        if let (Some(hinge), Some(now), Some(before)) = (self.hinge, self.state.hinge, self.before_substep.hinge) {
            damped += hinge.damping * (0.5 * (now.rate + before.rate)).powi(2) * span.dt;
        }
        let Elastic { axial, bending, segment_length, .. } = &self.elastic;
        let segments = self.parameters.segments as f64;
        let noise = 0.5 * segments * (axial[0] * segment_length.powi(2) + bending[1]) * NO_STRAIN.powi(2);
        let conserving = self.parameters.scheme == RodScheme::Trapezoid;
        let State { reference_energy, largest_energy, .. } = &mut self.state;
        let reference = if *largest_energy == 0.0 {
            energy
        } else if conserving {
            *reference_energy - damped
        } else {
            *reference_energy
        };
        let largest = largest_energy.max(kinetic).max(elastic).max(noise);
        if energy > reference + span.largest_gain * largest {
            return Err(Failure::Gain { reference, energy, largest, dt: span.dt });
        }
        *reference_energy = if conserving { reference } else { reference.min(energy) };
        *largest_energy = largest;
        Ok(())
    }

    /// One solve: from the state over `span.dt` by `rule`, under the loads that have gone `load_part` of the way from
    /// those of the last step to the present ones. On failure the state is as before.
    fn stage(&mut self, rule: StepRule, load_part: f64, span: Span<D>) -> Result<(), Failure> {
        let dt = span.dt;
        let StepRule { new_mass, old_mass, new_force, old_force, .. } = rule;
        self.balance.elastic_weight = new_force;
        for k in self.elastic.first..self.rest.len() {
            let (v_star, a_star) = rule.at_no_displacement(&self.state, k);
            let m = self.mass(k);
            let c = self.parameters.damping * self.tributary[k];
            let d = self.loads.impedance.get(k).copied().unwrap_or(0.0);
            let (v, a) = (self.state.velocities[k], self.state.accelerations[k]);
            let v_ref = self.before.velocities[k];
            let force = self.force[k] * load_part + self.state.loads[k] * (1.0 - load_part);

            self.balance.weight[k] = new_mass * m * rule.c_a + new_force * (c + d) * rule.c_v;
            self.balance.load[k] = (force - v_star * c - (v_star - v_ref) * d) * new_force
                + self.state.net_forces[k] * old_force
                - (a_star * new_mass + a * old_mass) * m;
            self.guess[k] = self.state.positions[k] + v * dt + a * (0.5 * dt * dt);
        }
        let clamp = span.clamp.map(|end| self.before.clamp().towards(end, span.to, span.duration));
        if let Some(clamp) = &clamp {
            self.guess[0] = clamp.position;
            self.elastic.direction = clamp.direction;
        } else if self.elastic.first == 1 {
            self.guess[0] = self.state.positions[0];
        } else {
            // Nothing keeps a free rod where its coordinates are small.
            self.newton.extent = self.guess[0].amax() + self.parameters.length;
        }
        let spring = self.hinge.zip(self.state.hinge).map(|(hinge, state)| hinge.stage(&rule, &state));
        if let Some(spring) = spring.filter(|_| self.hinge.as_ref().is_some_and(Hinge::is_damped)) {
            let (stiffness, rest) = spring.for_rod();
            self.elastic.set_spring(stiffness, rest, 0.0);
        }
        let Self { newton, elastic, balance, state, guess, statistics, .. } = self;
        let problem = Problem { elastic, balance, origin: &state.positions };
        if let Err(failure) = newton.solve(problem, guess, statistics) {
            self.align();
            return Err(failure);
        }
        if let (Some(spring), Some(hinge)) = (spring, self.state.hinge) {
            let moment = self.elastic.spring_moment(&self.guess, &mut self.newton.moments);
            let angle = spring.angle(match moment {
                Ok(moment) => moment,
                Err(shape) => {
                    self.align();
                    return Err(shape.into());
                }
            });
            // A jump from one side to the other has passed the fold, where the moment of the spring changes its sign.
            if (angle - hinge.angle).abs() > PI {
                self.align();
                return Err(BadShape::Fold { node: 0 }.into());
            }
            if let Some(hinge) = &mut self.state.hinge {
                hinge.advance(&rule, angle);
            }
        }

        let per_new_force = 1.0 / new_force;
        for k in self.elastic.first..self.rest.len() {
            let m = self.mass(k);
            let (v_star, a_star) = rule.at_no_displacement(&self.state, k);
            let state = &mut self.state;
            let u = self.guess[k] - state.positions[k];
            let a = u * rule.c_a + a_star;
            let blended = (a * new_mass + state.accelerations[k] * old_mass) * m;
            state.previous_positions[k] = state.positions[k];
            state.previous_velocities[k] = state.velocities[k];
            state.positions[k] = self.guess[k];
            state.velocities[k] = u * rule.c_v + v_star;
            state.accelerations[k] = a;
            state.net_forces[k] = (blended - state.net_forces[k] * old_force) * per_new_force;
        }
        let old_direction = self.state.direction;
        if let Some(clamp) = &clamp {
            self.state.move_clamp(clamp, dt);
        }
        self.align();
        self.last = Some(LastStage { rule, previous_direction: old_direction });
        self.state.last_step = dt;
        Ok(())
    }

    /// Accelerations and net forces at the beginning of the first step; 0 for nodes without mass, which only follow.
    fn start(&mut self) -> Result<(), Error> {
        let Self { elastic, newton, state, force, tributary, masses, parameters, .. } = self;
        let State { positions, velocities, net_forces, accelerations, loads, .. } = state;
        let result = elastic.gradient(positions, &mut newton.moments, |k, gradient| {
            let m = masses[k];
            if m > 0.0 {
                net_forces[k] = force[k] - gradient - velocities[k] * (parameters.damping * tributary[k]);
                accelerations[k] = net_forces[k] / m;
            }
        });
        loads.copy_from_slice(force);
        result.map_err(|shape| self.error(shape.into()))
    }

    /// Check the loads and sum up what they and gravity do in the present shape.
    fn collect_loads(&mut self) -> Result<(), Error> {
        let nodes = self.rest.len();
        self.loads.check::<D>(nodes)?;
        let gravity = Vector::from(self.parameters.gravity);
        for k in 0..nodes {
            self.force[k] = gravity * self.mass(k);
        }
        if !self.loads.force.is_empty() {
            for (d, component) in self.loads.force.chunks_exact(nodes).enumerate() {
                self.force.iter_mut().zip(component).for_each(|(sum, force)| sum[d] += force);
            }
        }
        for (k, jump) in self.loads.pressure_jump.iter().enumerate() {
            self.force[k] += pressure_area(&self.state.positions, k) * *jump;
        }
        if self.parameters.hold == Hold::Free {
            let towing = Vector::from(self.towing);
            if towing.iter().any(|component| !component.is_finite()) {
                return Err(Error::value("towing", &self.towing[..], "finite"));
            }
            self.force[0] += towing;
        }
        Ok(())
    }

    /// Mass of node `k`, kg.
    pub(crate) fn mass(&self, k: usize) -> f64 {
        self.masses[k]
    }

    /// Refresh the component-wise outputs.
    fn publish(&mut self) {
        let nodes = self.rest.len();
        for d in 0..D {
            for k in 0..nodes {
                self.positions[d * nodes + k] = self.state.positions[k][d];
                self.velocities[d * nodes + k] = self.state.velocities[k][d];
            }
        }
    }

    /// ∂²U/∂x∂x of the present shape, N/m: the stiffness of the free nodes, x and y (and z) of the first one first. With shear the
    /// bending moment at the beginning of each segment stands before its node, in the mixed form of [`crate`]'s Newton matrix.
    pub fn stiffness(&mut self) -> Result<Banded, Error> {
        let nodes = self.rest.len();
        let balance = Balance { weight: vec![0.0; nodes], load: vec![Vector::zeros(); nodes], elastic_weight: 1.0 };
        let Self { newton, elastic, state, .. } = self;
        let problem = Problem { elastic, balance: &balance, origin: &state.positions };
        newton.assemble(problem, &state.positions).map_err(|shape| self.error(shape.into()))?;
        Ok(self.newton.matrix.clone())
    }

    pub(crate) fn error(&self, failure: Failure) -> Error {
        match failure {
            Failure::NotConverged(Imbalance { residual, tolerance, rounding }) => {
                Error::NotConverged { residual, tolerance, rounding, iterations: self.statistics.iterations }
            }
            Failure::Gain { reference, energy, largest, dt } => {
                Error::EnergyGain { scheme: self.parameters.scheme, reference, energy, largest, dt }
            }
            Failure::BadShape(BadShape::Fold { node }) => {
                Error::FoldBack { node, limit: FOLD * self.elastic.segment_length.powi(2) }
            }
            Failure::BadShape(BadShape::Projection { node, axis }) => {
                Error::Projection { node, axis: ['x', 'y', 'z'][axis] }
            }
        }
    }
}

/// A part of a step.
#[derive(Clone, Copy)]
struct Span<'a, const D: usize> {
    /// Where it begins, as a fraction of the step.
    from: f64,
    /// Where it ends.
    to: f64,
    /// Its length, s.
    dt: f64,
    /// Length of the whole step, s.
    duration: f64,
    /// As [`LARGEST_GAIN`], for this part: a quarter in a step that is not halved, so that shorter ones have room left.
    largest_gain: f64,
    /// Where the whole step takes the clamp; `None`: it is still.
    clamp: Option<&'a Clamp<D>>,
}

impl<const D: usize> Span<'_, D> {
    /// The first `part` and the rest.
    fn split(self, part: f64) -> (Self, Self) {
        let middle = self.from + part * (self.to - self.from);
        (Self { to: middle, dt: part * self.dt, ..self }, Self { from: middle, dt: (1.0 - part) * self.dt, ..self })
    }
}

/// Force on node `k` of the shape `x` per unit of pressure jump, m², in two dimensions: half of either edge belongs to
/// the node; turned to the right it is minus the normal times the length.
pub(crate) fn pressure_area<const D: usize>(x: &[Vector<D>], k: usize) -> Vector<D> {
    let own = (x[(k + 1).min(x.len() - 1)] - x[k.saturating_sub(1)]) * 0.5;
    let mut area = Vector::zeros();
    (area[0], area[1]) = (own[1], -own[0]);
    area
}
