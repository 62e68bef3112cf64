//! What a wing adds to a step in time: its stages, the check of the energy and the reaction of the base.

use structure::{Core, Mounted, Reaction, RootResponse, Span, StepRule, Structure};

use crate::energy::{Energy, EnergyBefore};
use crate::geometry::Vector;
use crate::{Error, Memory, RigidMotion, Wing, WingError};

/// Energy that a wing may gain in a sub-step beyond the work of its loads, by the energy that it exchanges. At long
/// steps Newton's method may find another solution, as of wrinkles, and each one may add energy.
const MOST_GAIN: f64 = 0.01;
/// Motion in a step, by the extent of the wing, below which energies are rounding.
const QUIET: f64 = 1e-10;
/// Change of an energy that is rounding, by the work of loads and tension over the largest coordinate: the rounding
/// of a coordinate, in a sum over some hundred edges that are each a tenth of the wing long.
const ROUNDING: f64 = 1e-13;
/// Maximum number of iterations for the first accelerations; the mass matrix needs about twenty.
const MASS_ITERATIONS: usize = 200;
/// Tolerance of the first accelerations.
const MASS_TOLERANCE: f64 = 1e-13;

impl Structure<3> for Wing {
    type Own = Memory;
    type Failure = WingError;
    type Base = RigidMotion;

    /// Six stopped a film of 100 Pa before it folded.
    const HALVINGS: u32 = 12;
    const LOAD_GROWTH: u32 = 1;

    fn core(&self) -> &Core<3, Memory> {
        &self.core
    }

    fn core_mut(&mut self) -> &mut Core<3, Memory> {
        &mut self.core
    }

    fn next_base(&self) -> Result<RigidMotion, Error> {
        let base = self.base_motion.unwrap_or(self.core.state.own.base.stopped());
        base.check()?;
        Ok(base)
    }

    fn collect_loads(&mut self) -> Result<(), Error> {
        self.core.collect(&self.loads)
    }

    fn load(&self, k: usize) -> Vector {
        self.core.force[k] - self.core.weight(k)
    }

    fn prepare(&mut self, base: &RigidMotion, duration: f64) -> Result<(), Error> {
        if !self.trial.begin(duration, &self.loads) {
            self.newton.forget();
        }
        self.slide(duration);
        self.energy_before = None;
        if self.has_no_drive(base) {
            let energy = self.energy()?;
            let Core { rest, state, force, .. } = &self.core;
            let extent = rest.iter().map(|x| (x - rest[0]).norm()).fold(0.0, f64::max);
            let motion = 0.5 * self.masses.iter().sum::<f64>() * (QUIET * extent / duration).powi(2);
            let farthest = state.positions.iter().map(Vector::amax).fold(extent, f64::max);
            let forces = force.iter().map(Vector::norm).sum::<f64>() + self.elastic.tension_energy() / extent;
            let stored = (energy.stretching + energy.bending + energy.veins).abs();
            let rounding = motion + ROUNDING * (forces * farthest + stored);
            self.energy_before = Some(EnergyBefore { energy, rounding });
        }
        Ok(())
    }

    /// Set accelerations and net forces before the first step: M a = F on the free nodes, by conjugate gradients.
    fn start(&mut self) -> Result<(), Error> {
        if self.parameters.displaced_density > 0.0 {
            // The fluid that moves with the wing tells of its inertia in the loads, which are not known yet.
            return Ok(());
        }
        let Self { elastic, core, masses, newton, .. } = self;
        newton.touch_at_rest(elastic, &core.state.positions)?;
        let Core { state, force, balance, guess, product, held, .. } = core;
        let (residual, direction) = (&mut balance.load, guess);
        elastic.gradient(&state.positions, &state.velocities, product)?;
        for k in 0..held.len() {
            state.net_forces[k] = force[k] - product[k];
        }
        if let Some(contact) = &newton.contact {
            state.net_forces.iter_mut().zip(&contact.forces).for_each(|(net, force)| *net += force);
        }
        elastic.mass_times(&state.accelerations, product);
        let mut square = 0.0;
        for k in 0..held.len() {
            residual[k] = if held[k] { Vector::zeros() } else { state.net_forces[k] - product[k] };
            direction[k] = residual[k] / masses[k];
            square += residual[k].dot(&direction[k]);
        }
        let first = square;
        for _ in 0..MASS_ITERATIONS {
            if square <= MASS_TOLERANCE * MASS_TOLERANCE * first {
                break;
            }
            elastic.mass_times(direction, product);
            let length = square / direction.iter().zip(&*product).map(|(d, p)| d.dot(p)).sum::<f64>();
            let mut next = 0.0;
            for k in (0..held.len()).filter(|&k| !held[k]) {
                state.accelerations[k] += direction[k] * length;
                residual[k] -= product[k] * length;
                next += residual[k].norm_squared() / masses[k];
            }
            for k in (0..held.len()).filter(|&k| !held[k]) {
                direction[k] = residual[k] / masses[k] + direction[k] * (next / square);
            }
            square = next;
        }
        Ok(())
    }

    /// Where the wing may touch anything, BDF2 replaces TR-BDF2.
    fn rule(&mut self, dt: f64) -> Result<Option<StepRule>, Error> {
        let Self { core, elastic, newton, .. } = self;
        let Some(contact) = &mut newton.contact else { return Ok(None) };
        contact.detect_nearby(&elastic.faces, &core.state.positions, &core.state.velocities, dt)?;
        Ok(core.rule_in_contact(dt).filter(|_| contact.is_near))
    }

    fn stage(&mut self, rule: &StepRule, load_part: f64, span: &Span<RigidMotion>) -> Result<(), Error> {
        if self.trial.serves && self.newton.contact.as_ref().is_some_and(|contact| contact.is_near) {
            self.forget();
        }
        let Self { core, elastic, newton, trial, .. } = self;
        let placement = core.before.own.base.towards(span.base, span.to, span.duration);
        let origin = Vector::from(self.parameters.root.origin);
        core.predict(rule, span.dt, |rest| placement.node(origin, rest - origin));
        core.balance.diagonal.fill(0.0);
        elastic.mass_times(&core.blend, &mut core.balance.load);
        core.set_balance(rule, load_part, |_| 0.0);
        let base = placement.motion();
        elastic.twists.predict(&core.state.own.twists, rule, span.dt, core.state.last_step);
        if trial.serves && elastic.twists.strands.is_empty() {
            trial.guess(&base, origin, core);
        }
        elastic.forget_shape();
        (elastic.support, elastic.omega) = (base.matrix(), Vector::from(base.angular_velocity));
        if let Some(contact) = &mut newton.contact {
            contact.begin(&elastic.faces, &core.state.positions, &core.guess, span.dt, [span.from, span.to])?;
        }
        let origin = &core.state.positions;
        let solved = newton.solve(elastic, &core.balance, origin, &mut core.guess, &mut core.statistics);
        if solved.is_err() && trial.serves {
            self.forget();
            self.align();
            return self.stage(rule, load_part, span);
        }
        solved?;
        newton.contact.as_ref().map_or(Ok(()), |contact| contact.check(&elastic.faces, &core.guess, origin))?;
        elastic.twists.correct(rule, &mut core.state.own.twists);
        core.correct(rule, span.dt);
        if rule.old_force != 0.0 {
            elastic.mass_times(&core.blend, &mut core.product);
            for (net, blended) in core.state.net_forces.iter_mut().zip(&core.product) {
                *net = (blended - *net * rule.old_force) / rule.new_force;
            }
        }
        core.state.own.base = base;
        Ok(())
    }

    /// Compare the energy after a sub-step with the energy before it plus the work of the loads.
    fn guard(&mut self, _: &Span<RigidMotion>) -> Result<(), Error> {
        let Some(EnergyBefore { energy: before, rounding }) = self.energy_before else { return Ok(()) };
        let now = self.energy()?;
        if self.newton.contact.as_ref().is_some_and(|contact| contact.is_near) {
            // BDF2 takes some steps over an impulse, and the energy dips meanwhile.
            self.energy_before = Some(EnergyBefore { energy: now, rounding });
            return Ok(());
        }
        let elastic = |energy: &Energy| energy.stretching + energy.bending + energy.veins;
        let [elastic, gravity] = [elastic(&now) - elastic(&before), now.gravity - before.gravity];
        let [work, work_magnitude] = self.work_of_loads();
        let gain = now.kinetic - before.kinetic + elastic + gravity - work;
        let exchanged = now.kinetic + before.kinetic + elastic.abs() + gravity.abs() + work_magnitude;
        if exchanged > rounding && gain > MOST_GAIN * exchanged {
            return Err(WingError::Gain { gain, exchanged }.into());
        }
        self.energy_before = Some(EnergyBefore { energy: now, rounding });
        Ok(())
    }

    fn complete(&mut self, base: &RigidMotion) -> Result<Option<Reaction<3>>, Error> {
        self.core.state.own.base = *base;
        self.align();
        self.newton.contact.iter_mut().for_each(|contact| contact.detection.obstacles.stay());
        if self.parameters.root.nodes.is_empty() {
            return Ok(None);
        }
        let Self { core, elastic, newton, .. } = self;
        elastic.mass_times(&core.state.accelerations, &mut core.guess);
        let (x, v) = (&core.state.positions, &core.state.velocities);
        elastic.gradient(x, v, &mut core.product)?;
        let centre = Vector::from(self.parameters.root.origin) + Vector::from(base.displacement);
        let omega = Vector::from(base.angular_velocity);
        // The support turns the edges that it holds by the couple that the nodes alone do not balance.
        let couple: Vector = x.iter().zip(&core.product).map(|(x, elastic)| elastic.cross(&(x - centre))).sum();
        let (mut force, mut moment, mut power) = (Vector::zeros(), couple, couple.dot(&omega));
        for k in (0..x.len()).filter(|&k| core.held[k]) {
            let mut reaction = core.guess[k] + core.product[k] - core.force[k] + core.resistance(k, &v[k]);
            if let Some(contact) = &newton.contact {
                reaction -= contact.forces[k];
            }
            force += reaction;
            moment += (x[k] - centre).cross(&reaction);
            power += reaction.dot(&v[k]);
        }
        Ok(Some((force, moment.into(), power)))
    }

    /// Turn the support of the elastic energy as the state says.
    fn align(&mut self) {
        let Self { core, elastic, .. } = self;
        let base = &core.state.own.base;
        (elastic.support, elastic.omega) = (base.matrix(), Vector::from(base.angular_velocity));
        elastic.twists.set(&core.state.own.twists, &core.state.positions);
        elastic.forget_shape();
    }

    fn forget(&mut self) {
        self.newton.forget();
        self.trial.forget();
    }

    fn find_elastic_forces(&mut self) -> Result<(), Error> {
        let Self { core, elastic, newton, .. } = self;
        newton.touch_at_rest(elastic, &core.state.positions)?;
        elastic.omega = Vector::zeros();
        elastic.twists.keep();
        elastic.gradient(&core.state.positions, &core.balance.velocity, &mut core.product)?;
        if let Some(contact) = &newton.contact {
            core.product.iter_mut().zip(&contact.forces).for_each(|(product, force)| *product -= force);
        }
        Ok(())
    }

    fn solve(&mut self, origin: &[Vector]) -> Result<(), Error> {
        let Self { core, elastic, newton, .. } = self;
        newton.contact.as_mut().map_or(Ok(()), |contact| contact.begin_static(&elastic.faces, origin))?;
        elastic.twists.keep();
        let solved = newton.solve(elastic, &core.balance, origin, &mut core.guess, &mut core.statistics);
        if solved.is_err() {
            elastic.twists.back_to_kept();
            elastic.forget_shape();
        }
        solved
    }
}

impl Mounted for Wing {
    fn centre(&self) -> Vector {
        Vector::from(self.parameters.root.origin) + Vector::from(self.core.state.own.base.displacement)
    }

    fn factorise(&mut self) -> Result<(), Error> {
        let Self { core, elastic, newton, .. } = self;
        newton.factorise_at(elastic, &core.balance, &core.state.positions, &core.state.velocities)
    }

    fn multiply_mass(&mut self) {
        let Self { core, elastic, .. } = self;
        elastic.mass_times(&core.guess, &mut core.product);
        core.product.iter_mut().for_each(|product| *product *= core.balance.mass);
    }

    fn keep_trial(&mut self) {
        self.trial.keep(&self.core, &self.loads);
    }

    fn displace(&mut self) {
        let Self { core, newton, .. } = self;
        newton.system.solve(&core.product, &[]);
        core.product.iter_mut().enumerate().for_each(|(k, product)| *product = newton.system.update_of(k));
    }
}

impl Wing {
    /// Let a body carry the root: a step in time by differences then treats the wing and the body alike.
    pub fn carry(&mut self) {
        self.core.carried = true;
    }

    /// Return what the root bears in a step of `duration`, s, under the present loads to the present `base_motion`; the
    /// wing stays as it is ([`structure::root_response`]). The next step starts from this trial, so its last digits differ
    /// from those of a step without one, by less than the tolerance of Newton's method.
    ///
    /// # Errors
    /// As [`Wing::step`].
    pub fn root_response(&mut self, duration: f64) -> Result<RootResponse, Error> {
        self.forget();
        structure::root_response(self, duration)
    }

    /// Let the next step start from the state alone.
    pub fn forget_trial(&mut self) {
        self.forget();
    }

    /// Advance by `duration`, s, under the present loads ([`structure::step`]), with up to twelve halvings.
    ///
    /// # Errors
    /// A step may fail to converge or fold the wing. After an error the state is the state before the step.
    pub fn step(&mut self, duration: f64) -> Result<(), Error> {
        structure::step(self, duration)
    }

    /// Let the fluid slide along the wing in a step of `duration`, s: the impedance acts across, and along it the layer,
    /// which the mass of the membrane leaves out, keeps its inertia.
    fn slide(&mut self, duration: f64) {
        let Self { core, layer, .. } = self;
        let Core { state, across, impedance, .. } = core;
        layer.find_normals(|k| state.positions[k].into());
        for (k, (across, impedance)) in across.iter_mut().zip(impedance).enumerate() {
            let (normal, along) = layer.rate(k, *impedance, duration);
            let normal = Vector::from(normal);
            *across = normal * ((*impedance - along).sqrt() / normal.norm().max(f64::MIN_POSITIVE));
            *impedance = along;
        }
    }

    /// Return whether the root is absent, or at rest in a step to the pose `base`.
    ///
    /// The work of a root that moves is known to first order only, too coarse for a check.
    fn has_no_drive(&self, base: &RigidMotion) -> bool {
        let before = &self.core.before.own.base;
        let still = |base: &RigidMotion| *base == base.stopped();
        let held = (base.displacement, base.rotation) == (before.displacement, before.rotation)
            && still(base)
            && still(before);
        let still = self.newton.contact.as_ref().is_none_or(|contact| contact.detection.obstacles.are_still());
        still && (held || self.parameters.root.nodes.is_empty())
    }

    /// Return the most work of the loads in the last sub-step, and the sum of its magnitudes over the nodes, J.
    ///
    /// At each node the load changes on the way: the more of the works of the loads before and after counts.
    fn work_of_loads(&self) -> [f64; 2] {
        let core = &self.core;
        let ends = [&core.before_substep, &core.state];
        let (mut most, mut sum) = (0.0, 0.0);
        for k in 0..core.rest.len() {
            let moved = ends[1].positions[k] - ends[0].positions[k];
            let [first, last] = ends
                .map(|state| (state.loads[k] - core.weight(k) - core.resistance(k, &state.velocities[k])).dot(&moved));
            most += first.max(last);
            sum += first.abs().max(last.abs());
        }
        [most, sum]
    }
}
