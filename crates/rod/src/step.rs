//! Steps in time: loads, sub-steps, stages and the guard of the energy.

use std::f64::consts::PI;

use crate::Error;
use crate::base_motion::BaseState;
use crate::elastic::{BadShape, Elastic};
use crate::error::LARGEST_GAIN;
use crate::hinge::{Hinge, advance};
use crate::loads::Loads;
use crate::model::{RootSupport, Scheme};
use crate::newton::{Failure, Problem, Statistics, kept};
use crate::rod::Rod;
use crate::scheme::{StepRule, TRAPEZOID_PART};
use crate::state::{Drive, Exchange, State};
use crate::vector::{Vector, cross};

/// Maximum number of halvings of a failed sub-step.
pub(crate) const HALVINGS: u32 = 6;
/// Maximum number of sub-steps of `max_step` in a step.
const MAX_STEPS: f64 = 1e4;
/// Strain, and turning angle per node, whose energy is rounding noise.
const NO_STRAIN: f64 = 1e-10;

/// Part of a step.
#[derive(Clone, Copy)]
struct Span<'a, const D: usize> {
    /// Begin, as a fraction of the step.
    from: f64,
    /// End, as a fraction of the step.
    to: f64,
    /// Length, s.
    dt: f64,
    /// Length of the whole step, s.
    duration: f64,
    /// [`LARGEST_GAIN`] of this part: a quarter in a step without halvings, which leaves room for shorter parts.
    largest_gain: f64,
    /// Root at the end of the whole step; `None` for a root at rest.
    base: Option<&'a BaseState<D>>,
}

impl<const D: usize> Span<'_, D> {
    /// Return the first `part` and the rest.
    fn split(self, part: f64) -> (Self, Self) {
        let middle = self.from + part * (self.to - self.from);
        (Self { to: middle, dt: part * self.dt, ..self }, Self { from: middle, dt: (1.0 - part) * self.dt, ..self })
    }
}

impl<const D: usize> Rod<D> {
    /// Advance by `duration`, s, under the present loads.
    ///
    /// The rod takes equal sub-steps no longer than `max_step` and halves a failed sub-step up to six times. The loads
    /// are the loads at the end of the step. Forces with an impedance refer to the velocity at the beginning of the
    /// step.
    ///
    /// # Errors
    /// A step may fail to converge, gain energy or fold the rod. After an error the state is the state before the step.
    pub fn step(&mut self, duration: f64) -> Result<(), Error> {
        if !(duration.is_finite() && duration > 0.0) {
            return Err(Error::value("duration", duration, "a finite number of seconds above 0"));
        }
        // A duration that exceeds a multiple of `max_step` by rounding needs no extra sub-step.
        let steps = self.parameters.max_step.map_or(1.0, |longest| (duration / longest - 1e-9).ceil().max(1.0));
        if steps > MAX_STEPS {
            return Err(Error::value("duration", duration, "at most 10000 times max_step"));
        }
        self.collect_loads()?;
        let base = self.next_base()?;
        self.before.copy_from(&self.state);
        self.statistics = Statistics::default();
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
                base: base.as_ref(),
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
                    self.align_elastic();
                    return Err(self.error(failure));
                }
            }
        }
        self.sum_up_loads(duration);
        if base.is_some() {
            self.sum_up_drive(duration)?;
        } else if self.parameters.support == RootSupport::Free {
            let force = Vector::from(self.towing);
            let power = force.dot(&self.state.velocities[0]);
            let work = self.state.drive.work + power * duration;
            self.state.drive = Drive { force, moment: [0.0; 3], power, work };
        }
        if let Err(error) = self.state.check_exchange() {
            self.state.copy_from(&self.before);
            self.align_elastic();
            return Err(error);
        }
        self.publish();
        Ok(())
    }

    /// Relax the pressure that strains the rod by the fraction `part` towards the pressure around the rod.
    ///
    /// Without this lag a change of the pressure would move the tip at once, and the moving tip would change the
    /// pressure: coupling once per step is unstable with short segments. Below the first axial mode the strain is in
    /// equilibrium.
    pub(crate) fn follow_pressure(&mut self, part: f64) {
        let Self { state: State { pressure, .. }, loads, elastic, parameters, .. } = self;
        if pressure.is_empty() {
            return;
        }
        for (k, own) in pressure.iter_mut().enumerate() {
            *own += part * (loads.pressure.get(k).copied().unwrap_or(0.0) - *own);
        }
        elastic.set_pressure(parameters.strain_per_pressure, pressure);
    }

    /// Record force, power and work of the loads in the step of `duration` seconds just made.
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

    /// Record force, moment, power and work of the drive in the step of `duration` seconds just made.
    ///
    /// Node 0 belongs to the rod, so the drive accelerates its mass and balances the loads on it.
    fn sum_up_drive(&mut self, duration: f64) -> Result<(), Error> {
        let reaction = self.elastic.support_reaction(&self.state.positions, &mut self.newton.moments);
        let (mut force, moment) = reaction.map_err(|shape| self.error(shape.into()))?;
        let State { velocities, accelerations, direction, direction_rate, .. } = &self.state;
        let v = velocities[0];
        force += accelerations[0] * self.masses[0] + v * (self.parameters.damping * self.tributary[0]) - self.force[0];
        if let Some(impedance) = self.loads.impedance.first() {
            force += (v - self.before.velocities[0]) * *impedance;
        }
        if let Some(slide) = self.parameters.slide {
            force[slide.axis] = 0.0;
        }
        let turning = cross(direction, direction_rate).into_iter().zip(moment).map(|(omega, m)| omega * m);
        let power = force.dot(&v) + turning.sum::<f64>();
        let work = self.state.drive.work + power * duration;
        self.state.drive = Drive { force, moment, power, work };
        Ok(())
    }

    /// Return the root at the end of the next step; `None` for a root at rest.
    fn next_base(&self) -> Result<Option<BaseState<D>>, Error> {
        let Some(motion) = &self.base_motion else { return Ok(None) };
        let base = motion.normalised()?;
        if base.direction.dot(&self.state.direction) <= 0.0 {
            return Err(Error::value(
                "base_motion.direction",
                &motion.direction[..],
                "less than a right angle from the direction at the beginning of the step",
            ));
        }
        Ok(Some(base))
    }

    /// Make a sub-step by the time scheme; a failure leaves the state unchanged.
    fn substep(&mut self, span: Span<D>) -> Result<(), Failure> {
        let last_step = self.state.last_step;
        match self.parameters.scheme {
            Scheme::Trapezoid => self.stage_with_energy_guard(StepRule::trapezoid(span.dt), span)?,
            Scheme::GeneralisedAlpha { rho_inf } => {
                self.stage_with_energy_guard(StepRule::generalised_alpha(rho_inf, span.dt), span)?;
            }
            Scheme::Bdf2 => self.stage(StepRule::bdf2(span.dt, last_step), 1.0, span)?,
            Scheme::TrBdf2 => {
                self.before_substep.copy_from(&self.state);
                let (first, second) = span.split(TRAPEZOID_PART);
                self.stage(StepRule::trapezoid(first.dt), TRAPEZOID_PART, first)?;
                let second_stage = self.stage(StepRule::bdf2(second.dt, first.dt), 1.0, second);
                if second_stage.is_err() {
                    self.state.copy_from(&self.before_substep);
                    self.align_elastic();
                    return second_stage;
                }
            }
        }
        self.state.loads.copy_from_slice(&self.force);
        self.statistics.substeps += 1;
        Ok(())
    }

    /// Make a sub-step by a `rule` that bounds the energy of linear problems only; a failure leaves the state
    /// unchanged.
    ///
    /// The sub-step fails if the energy less the work of the loads rises under constant forces. The first sub-step
    /// after a change of the loads blends old and new loads, so the comparison starts with the second.
    fn stage_with_energy_guard(&mut self, rule: StepRule, span: Span<D>) -> Result<(), Failure> {
        let constant = span.base.is_none()
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
            self.align_elastic();
        }
        guarded
    }

    /// Refuse an energy less the work of the loads above its reference; otherwise update the reference.
    ///
    /// The energy of the trapezoid oscillates about a constant, so its reference is the first energy less the energy
    /// lost by damping. Generalised-α dissipates, so its reference is the lowest energy.
    fn energy_guard(&mut self, span: Span<D>) -> Result<(), Failure> {
        let shape = self.elastic.energy(&self.state.positions)?;
        let elastic = shape.stretching + shape.bending;
        let (mut kinetic, mut work, mut mean_squares) = (0.0, 0.0, 0.0);
        for (k, force) in self.force.iter().enumerate().skip(self.elastic.first) {
            let (v, v_before) = (self.state.velocities[k], self.before_substep.velocities[k]);
            kinetic += 0.5 * self.masses[k] * v.norm_squared();
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
        let conserving = self.parameters.scheme == Scheme::Trapezoid;
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

    /// Solve for one stage over `span.dt` by `rule`; a failure leaves the state unchanged.
    ///
    /// The loads lie at the fraction `load_part` between the loads of the last step and the present loads.
    fn stage(&mut self, rule: StepRule, load_part: f64, span: Span<D>) -> Result<(), Failure> {
        let dt = span.dt;
        let StepRule { new_mass, old_mass, new_force, old_force, .. } = rule;
        self.balance.elastic_weight = new_force;
        for k in self.elastic.first..self.rest.len() {
            let (v_star, a_star) = rule.at_no_displacement(self.state.motion(k));
            let m = self.masses[k];
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
        let base = span.base.map(|end| self.before.base().towards(end, span.to, span.duration));
        let free = self.guess[0];
        if let Some(base) = &base {
            self.guess[0] = base.position;
            self.elastic.direction = base.direction;
        } else if self.parameters.support != RootSupport::Free {
            self.guess[0] = self.state.positions[0];
        }
        if let Some(slide) = self.parameters.slide {
            self.guess[0] = kept(self.guess[0], slide.axis, free);
        }
        if self.elastic.first == 0 {
            // The coordinates of a free rod may grow without limit.
            self.newton.extent = self.guess[0].amax() + self.parameters.length;
        }
        let spring = self.hinge.zip(self.state.hinge).map(|(hinge, state)| hinge.stage(&rule, &state));
        if let Some(spring) = spring.filter(|_| self.hinge.as_ref().is_some_and(Hinge::is_damped)) {
            let (stiffness, rest) = spring.in_series();
            self.elastic.set_spring(stiffness, rest, 0.0);
        }
        let Self { newton, elastic, balance, state, guess, statistics, .. } = self;
        let problem = Problem { elastic, balance, origin: &state.positions };
        if let Err(failure) = newton.solve(problem, guess, statistics) {
            self.align_elastic();
            return Err(failure);
        }
        if let (Some(spring), Some(hinge)) = (spring, self.state.hinge) {
            let moment = self.elastic.spring_moment(&self.guess, &mut self.newton.moments);
            let angle = spring.angle(match moment {
                Ok(moment) => moment,
                Err(shape) => {
                    self.align_elastic();
                    return Err(shape.into());
                }
            });
            // A jump of more than π has passed the fold, where the moment of the spring changes its sign.
            if (angle - hinge.angle).abs() > PI {
                self.align_elastic();
                return Err(BadShape::Fold { node: 0 }.into());
            }
            if let Some(hinge) = &mut self.state.hinge {
                advance(hinge, &rule, angle);
            }
        }

        let root = self.state.motion(0);
        let per_new_force = 1.0 / new_force;
        for k in self.elastic.first..self.rest.len() {
            let m = self.masses[k];
            let (v_star, a_star) = rule.at_no_displacement(self.state.motion(k));
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
        if let Some(slide) = self.parameters.slide {
            let still = self.before.base();
            self.state.move_slide(&root, base.as_ref().unwrap_or(&still), dt, slide.axis);
        } else if let Some(base) = &base {
            self.state.move_base(base, dt);
        }
        self.align_elastic();
        self.state.last_step = dt;
        Ok(())
    }

    /// Set accelerations and net forces before the first step; nodes without mass keep 0.
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
        if let Some(slide) = parameters.slide {
            for held in [&mut net_forces[0], &mut accelerations[0]] {
                *held = kept(Vector::zeros(), slide.axis, *held);
            }
        }
        loads.copy_from_slice(force);
        result.map_err(|shape| self.error(shape.into()))
    }

    /// Check the loads and add them to gravity, in the present shape.
    pub(crate) fn collect_loads(&mut self) -> Result<(), Error> {
        let nodes = self.rest.len();
        self.loads.check::<D>(nodes)?;
        let gravity = Vector::from(self.parameters.gravity);
        for k in 0..nodes {
            self.force[k] = gravity * self.weights[k];
        }
        if !self.loads.force.is_empty() {
            for (d, component) in self.loads.force.chunks_exact(nodes).enumerate() {
                self.force.iter_mut().zip(component).for_each(|(sum, force)| sum[d] += force);
            }
        }
        for (k, jump) in self.loads.pressure_jump.iter().enumerate() {
            self.force[k] += pressure_area(&self.state.positions, k) * *jump;
        }
        if self.parameters.support == RootSupport::Free {
            let towing = Vector::from(self.towing);
            if towing.iter().any(|component| !component.is_finite()) {
                return Err(Error::value("towing", &self.towing[..], "finite"));
            }
            self.force[0] += towing;
        }
        Ok(())
    }
}

/// Return the force on node `k` of the shape `x` per pressure jump in the plane, m².
///
/// Half of each edge belongs to the node. The edge turned to the right is minus the normal times the length.
fn pressure_area<const D: usize>(x: &[Vector<D>], k: usize) -> Vector<D> {
    let own = (x[(k + 1).min(x.len() - 1)] - x[k.saturating_sub(1)]) * 0.5;
    let mut area = Vector::zeros();
    (area[0], area[1]) = (own[1], -own[0]);
    area
}
