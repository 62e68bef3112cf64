//! What a rod adds to a step in time: its stages, the guard of the energy and the reaction of the root.

use std::f64::consts::PI;

use structure::{Core, Mounted, Reaction, RootResponse, Scheme, Span, StepRule, Structure, Vector, cross};

use crate::base_motion::BaseState;
use crate::error::LARGEST_GAIN;
use crate::hinge::{Hinge, advanced};
use crate::memory::RodMemory;
use crate::model::RootSupport;
use crate::newton::{Newton, Problem, kept, with_touch};
use crate::{Error, Loads, Rod, RodError};

/// Strain, and turning angle per node, whose energy is rounding noise.
const NO_STRAIN: f64 = 1e-10;

impl<const D: usize> Structure<D> for Rod<D> {
    type Own = RodMemory<D>;
    type Failure = RodError;
    /// `None` for a root at rest.
    type Base = Option<BaseState<D>>;

    const HALVINGS: u32 = 6;
    const LOAD_GROWTH: u32 = 2;

    fn core(&self) -> &Core<D, RodMemory<D>> {
        &self.core
    }

    fn core_mut(&mut self) -> &mut Core<D, RodMemory<D>> {
        &mut self.core
    }

    fn next_base(&self) -> Result<Option<BaseState<D>>, Error> {
        let Some(motion) = &self.base_motion else { return Ok(None) };
        let base = motion.normalised()?;
        if base.direction.dot(&self.core.state.own.direction) <= 0.0 {
            return Err(Error::value(
                "base_motion.direction",
                &motion.direction[..],
                "less than a right angle from the direction at the beginning of the step",
            ));
        }
        Ok(Some(base))
    }

    fn collect_loads(&mut self) -> Result<(), Error> {
        let Self { core, loads, .. } = self;
        core.collect(loads)?;
        for (k, jump) in loads.pressure_jump.iter().enumerate() {
            core.force[k] += pressure_area(&core.state.positions, k) * *jump;
        }
        if self.parameters.support == RootSupport::Free {
            structure::finite("towing", &self.towing)?;
            core.force[0] += Vector::from(self.towing);
        }
        Ok(())
    }

    fn load(&self, k: usize) -> Vector<D> {
        let Loads { force, pressure_jump, .. } = &self.loads;
        let nodes = self.core.rest.len();
        let load = Vector::from_fn(|d, _| force.get(d * nodes + k).copied().unwrap_or(0.0));
        pressure_jump.get(k).map_or(load, |jump| load + pressure_area(&self.core.before.positions, k) * *jump)
    }

    fn prepare(&mut self, _: &Option<BaseState<D>>, duration: f64) -> Result<(), Error> {
        self.follow_pressure(-(-duration / self.parameters.axial_period()).exp_m1());
        Ok(())
    }

    /// Set accelerations and net forces before the first step; nodes without mass keep 0.
    fn start(&mut self) -> Result<(), Error> {
        let Self { core, elastic, newton, tributary, masses, parameters, .. } = self;
        let state = &mut core.state;
        newton.touch_at_rest(&state.positions)?;
        let Newton { moments, touch, .. } = newton;
        elastic.gradient(&state.positions, moments, |k, gradient| {
            let m = masses[k];
            if m > 0.0 {
                let damping = state.velocities[k] * (parameters.damping * tributary[k]);
                state.net_forces[k] = with_touch(core.force[k] - gradient - damping, touch, k, 1.0);
                state.accelerations[k] = state.net_forces[k] / m;
            }
        })?;
        if let Some(slide) = parameters.slide {
            for held in [&mut state.net_forces[0], &mut state.accelerations[0]] {
                *held = kept(Vector::zeros(), slide.axis, *held);
            }
        }
        Ok(())
    }

    /// Where the rod may touch anything, BDF2 replaces TR-BDF2.
    fn rule(&mut self, dt: f64) -> Result<Option<StepRule>, Error> {
        let Self { core, newton, .. } = self;
        let Some((rule, contact)) = core.rule_in_contact(dt).zip(newton.contact.as_mut()) else { return Ok(None) };
        let touches = contact.may_touch(&core.state.positions, &core.state.velocities, dt)?;
        Ok(touches.then_some(rule))
    }

    fn stage(&mut self, rule: &StepRule, load_part: f64, span: &Span<Option<BaseState<D>>>) -> Result<(), Error> {
        let dt = span.dt;
        let Self { core, elastic, newton, parameters, masses, tributary, .. } = self;
        let now = BaseState::of(&core.state);
        let base = span.base.map(|end| BaseState::of(&core.before).towards(&end, span.to, span.duration));
        let root =
            base.map_or([now.position, now.velocity, core.state.accelerations[0]], |base| base.of_node(&now, dt));
        core.predict(rule, dt, |_| root);
        if let Some(slide) = parameters.slide {
            core.guess[0] = kept(root[0], slide.axis, core.guess[0]);
        }
        if let Some(base) = &base {
            elastic.direction = base.direction;
        }
        for (k, m) in masses.iter().enumerate() {
            core.balance.diagonal[k] = rule.new_mass * m * rule.c_a;
            core.balance.load[k] = core.blend[k] * *m;
        }
        core.set_balance(rule, load_part, |k| parameters.damping * tributary[k]);
        if elastic.first == 0 {
            // The coordinates of a free rod may grow without limit.
            newton.extent = core.guess[0].amax() + parameters.length;
        }
        let spring = self.hinge.zip(core.state.own.hinge).map(|(hinge, now)| hinge.stage(rule, now));
        if let Some(spring) = spring.filter(|_| self.hinge.as_ref().is_some_and(Hinge::is_damped)) {
            let (stiffness, rest) = spring.in_series();
            elastic.set_spring(stiffness, rest, 0.0);
        }
        let problem = Problem { elastic, balance: &core.balance, origin: &core.state.positions };
        if let Some(contact) = &mut newton.contact {
            contact.begin(problem.origin, &core.guess, dt, [span.from, span.to])?;
        }
        newton.solve(problem, &mut core.guess, &mut core.statistics)?;
        newton.contact.as_ref().map_or(Ok(()), |contact| contact.check(&core.guess, problem.origin))?;
        if let (Some(spring), Some(hinge)) = (spring, &mut core.state.own.hinge) {
            let angle = spring.angle(elastic.spring_moment(&core.guess, &mut newton.moments)?);
            // A jump of more than π has passed the fold, where the moment of the spring changes its sign.
            if (angle - hinge.x).abs() > PI {
                return Err(elastic.fold(0).into());
            }
            *hinge = advanced(*hinge, rule, angle);
        }
        core.correct(rule, dt);
        let per_new_force = 1.0 / rule.new_force;
        for (k, net) in core.state.net_forces.iter_mut().enumerate().skip(elastic.first) {
            *net = (core.blend[k] * masses[k] - *net * rule.old_force) * per_new_force;
        }
        if let Some(slide) = parameters.slide {
            let still = BaseState::of(&core.before);
            let [x, v, a] = base.unwrap_or(still).of_node(&now, dt);
            let state = &mut core.state;
            for (free, held) in
                [(&mut state.positions[0], x), (&mut state.velocities[0], v), (&mut state.accelerations[0], a)]
            {
                *free = kept(held, slide.axis, *free);
            }
        }
        if let Some(base) = base {
            (core.state.own.direction, core.state.own.direction_rate) = (base.direction, base.direction_rate);
        }
        self.align();
        Ok(())
    }

    /// Refuse an energy less the work of constant loads above its reference; otherwise update the reference.
    ///
    /// The trapezoid and generalised-α bound the energy of linear problems only. The first sub-step after a change of
    /// the loads blends old and new loads, so the comparison starts with the second. The energy of the trapezoid
    /// oscillates about a constant, so its reference is the first energy less the energy lost by damping.
    /// Generalised-α dissipates, so its reference is the lowest energy.
    fn guard(&mut self, span: &Span<Option<BaseState<D>>>) -> Result<(), Error> {
        let Self { core, elastic, newton, .. } = self;
        let (scheme, before) = (core.scheme, &core.before_substep);
        if matches!(scheme, Scheme::TrBdf2 | Scheme::Bdf2) {
            return Ok(());
        }
        let constant = span.base.is_none()
            && before.last_step > 0.0
            && core.force[elastic.first..] == before.loads[elastic.first..]
            && before.own.pressure.is_empty()
            && newton.contact.as_ref().is_none_or(|contact| contact.obstacles.are_still())
            && core.impedance.iter().all(|&impedance| impedance == 0.0);
        if !constant {
            core.state.own.largest_energy = 0.0;
            return Ok(());
        }
        let shape = elastic.energy(&core.state.positions)?;
        let touching = newton.contact.as_ref().map_or(0.0, |contact| contact.energy(&core.state.positions));
        let stored = shape.stretching + shape.bending + touching;
        let (mut kinetic, mut work, mut mean_squares) = (0.0, 0.0, 0.0);
        for (k, force) in core.force.iter().enumerate().skip(elastic.first) {
            let (v, v_before) = (core.state.velocities[k], before.velocities[k]);
            kinetic += 0.5 * self.masses[k] * v.norm_squared();
            work += force.dot(&(core.state.positions[k] - core.rest[0]));
            mean_squares += 0.25 * self.tributary[k] * (v + v_before).norm_squared();
        }
        let energy = kinetic + stored - work;
        let mut damped = self.parameters.damping * mean_squares * span.dt;
        if let (Some(hinge), Some(now), Some(before)) = (self.hinge, core.state.own.hinge, before.own.hinge) {
            damped += hinge.damping * (0.5 * (now.v + before.v)).powi(2) * span.dt;
        }
        let stiffness = elastic.axial[0] * elastic.segment_length.powi(2) + elastic.bending[1];
        let noise = 0.5 * self.parameters.segments as f64 * stiffness * NO_STRAIN.powi(2);
        let conserving = scheme == Scheme::Trapezoid;
        let RodMemory { reference_energy, largest_energy, .. } = &mut core.state.own;
        let reference = if *largest_energy == 0.0 {
            energy
        } else if conserving {
            *reference_energy - damped
        } else {
            *reference_energy
        };
        let largest = largest_energy.max(kinetic).max(stored).max(noise);
        // A quarter of the limit in a step without halvings leaves room for shorter parts.
        let limit = LARGEST_GAIN * 2.0 / f64::from(2 + Self::HALVINGS - span.halvings);
        if energy > reference + limit * largest {
            return Err(RodError::EnergyGain { scheme, reference, energy, largest, dt: span.dt }.into());
        }
        *reference_energy = if conserving { reference } else { reference.min(energy) };
        *largest_energy = largest;
        Ok(())
    }

    /// Return the reaction of the root; node 0 belongs to the rod, so it accelerates its mass and balances its loads.
    fn complete(&mut self, base: &Option<BaseState<D>>) -> Result<Option<Reaction<D>>, Error> {
        let Self { core, elastic, newton, parameters, .. } = self;
        newton.contact.iter_mut().for_each(|contact| contact.obstacles.stay());
        let state = &core.state;
        let v = state.velocities[0];
        if base.is_none() {
            let towing = Vector::from(self.towing);
            return Ok((parameters.support == RootSupport::Free).then(|| (towing, [0.0; 3], towing.dot(&v))));
        }
        let (mut force, moment) = elastic.support_reaction(&state.positions, &mut newton.moments)?;
        force += state.accelerations[0] * self.masses[0] + v * (parameters.damping * self.tributary[0]) - core.force[0];
        force += core.resistance(0, &v);
        newton.touch.first().inspect(|touch| force -= **touch);
        if let Some(slide) = parameters.slide {
            force[slide.axis] = 0.0;
        }
        let omega = cross(&state.own.direction, &state.own.direction_rate);
        let turning = omega.into_iter().zip(moment).map(|(omega, m)| omega * m);
        let power = force.dot(&v) + turning.sum::<f64>();
        Ok(Some((force, moment, power)))
    }

    /// Copy direction, pressure and the angle of a damped spring from the state to the elastic energy.
    ///
    /// An undamped spring has no state of its own: it is in series with half a segment.
    fn align(&mut self) {
        let own = &self.core.state.own;
        self.elastic.direction = own.direction;
        self.elastic.set_pressure(self.parameters.strain_per_pressure, &own.pressure);
        if let (Some(hinge), Some(now)) = (self.hinge.filter(Hinge::is_damped), own.hinge) {
            self.elastic.set_spring(hinge.half_segment, now.x, hinge.energy(now.x));
        }
    }

    fn find_elastic_forces(&mut self) -> Result<(), Error> {
        let Self { core, elastic, newton, .. } = self;
        newton.touch_at_rest(&core.state.positions)?;
        let Newton { moments, touch, .. } = newton;
        let forces = &mut core.product;
        elastic.gradient(&core.state.positions, moments, |k, gradient| {
            forces[k] = with_touch(gradient, touch, k, -1.0);
        })?;
        Ok(())
    }

    fn solve(&mut self, origin: &[Vector<D>]) -> Result<(), Error> {
        let Self { core, elastic, newton, .. } = self;
        if let Some(contact) = &mut newton.contact {
            contact.begin_static(origin)?;
        }
        newton.solve(Problem { elastic, balance: &core.balance, origin }, &mut core.guess, &mut core.statistics)?;
        newton.contact.as_ref().map_or(Ok(()), |contact| Ok(contact.check(&core.guess, origin)?))
    }
}

impl Mounted for Rod<3> {
    fn centre(&self) -> Vector<3> {
        self.core.state.positions[0]
    }

    fn factorise(&mut self) -> Result<(), Error> {
        let Self { core, elastic, newton, .. } = self;
        let positions = &core.state.positions;
        newton.factorise_at(Problem { elastic, balance: &core.balance, origin: positions }, positions)
    }

    fn multiply_mass(&mut self) {
        self.core.product.fill(Vector::zeros());
    }

    fn displace(&mut self) {
        self.newton.displace(&mut self.core.product);
    }
}

impl Rod<3> {
    /// Let a body carry the root: a step in time by differences then treats the rod and the body alike.
    pub fn carry(&mut self) {
        self.core.carried = true;
    }

    /// Return what the root bears in a step of `duration`, s, under the present loads to the present `base_motion`; the
    /// rod stays as it is ([`structure::root_response`]).
    ///
    /// # Errors
    /// As [`Rod::step`].
    pub fn root_response(&mut self, duration: f64) -> Result<RootResponse, Error> {
        structure::root_response(self, duration)
    }
}

impl<const D: usize> Rod<D> {
    /// Advance by `duration`, s, under the present loads ([`structure::step`]), with up to six halvings.
    ///
    /// # Errors
    /// A step may fail to converge, gain energy or fold the rod. After an error the state is the state before the step.
    pub fn step(&mut self, duration: f64) -> Result<(), Error> {
        structure::step(self, duration)
    }

    /// Relax the pressure that strains the rod by the fraction `part` towards the pressure around the rod.
    ///
    /// Without this lag a change of the pressure would move the tip at once, and the moving tip would change the
    /// pressure: coupling once per step is unstable with short segments. Below the first axial mode the strain is in
    /// equilibrium.
    pub(crate) fn follow_pressure(&mut self, part: f64) {
        let Self { core, loads, elastic, parameters, .. } = self;
        let pressure = &mut core.state.own.pressure;
        if pressure.is_empty() {
            return;
        }
        for (k, own) in pressure.iter_mut().enumerate() {
            *own += part * (loads.pressure.get(k).copied().unwrap_or(0.0) - *own);
        }
        elastic.set_pressure(parameters.strain_per_pressure, pressure);
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
