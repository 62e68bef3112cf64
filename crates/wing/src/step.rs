//! Steps in time: loads, sub-steps and stages.

use rod::{Drive, Exchange, Scheme, StepRule, TRAPEZOID_PART};

use crate::geometry::Vector;
use crate::newton::{Failure, Statistics};
use crate::{Energy, Error, Pose, Wing};

/// Maximum number of halvings of a failed sub-step. Six stopped a film of 100 Pa before it folded.
pub(crate) const HALVINGS: u32 = 12;
/// Energy that a wing may gain in a sub-step beyond the work of its loads, by the energy that it exchanges. At long
/// steps Newton's method may find another solution, as of wrinkles, and each one may add energy.
const MOST_GAIN: f64 = 0.01;
/// Motion in a step, by the extent of the wing, below which energies are rounding.
const QUIET: f64 = 1e-10;
/// Maximum number of sub-steps of `max_step` in a step.
const MAX_STEPS: f64 = 1e4;
/// Maximum number of iterations for the first accelerations; the mass matrix needs about twenty.
const MASS_ITERATIONS: usize = 200;
/// Tolerance of the first accelerations.
const MASS_TOLERANCE: f64 = 1e-13;

/// Part of a step.
#[derive(Clone, Copy)]
struct Span {
    /// Begin and end, as fractions of the step.
    from: f64,
    to: f64,
    /// Length, s.
    dt: f64,
    /// Length of the whole step, s.
    duration: f64,
    /// Pose of the base at the end of the whole step.
    base: Pose,
}

impl Span {
    /// Return the first `part` and the rest.
    fn split(self, part: f64) -> (Self, Self) {
        let middle = self.from + part * (self.to - self.from);
        (Self { to: middle, dt: part * self.dt, ..self }, Self { from: middle, dt: (1.0 - part) * self.dt, ..self })
    }
}

impl Wing {
    /// Advance by `duration`, s, under the present loads.
    ///
    /// The wing takes equal sub-steps no longer than `max_step` and halves a failed sub-step up to twelve times. The
    /// loads are the loads at the end of the step. Forces with an impedance refer to the velocity at the beginning of
    /// the step.
    ///
    /// # Errors
    /// A step may fail to converge or fold the wing. After an error the state is the state before the step.
    pub fn step(&mut self, duration: f64) -> Result<(), Error> {
        if !(duration.is_finite() && duration > 0.0) {
            return Err(Error::value("duration", duration, "a finite number of seconds above 0"));
        }
        // A duration that exceeds a multiple of `max_step` by rounding needs no extra sub-step.
        let steps = self.parameters.max_step.map_or(1.0, |longest| (duration / longest - 1e-9).ceil().max(1.0));
        if steps > MAX_STEPS {
            return Err(Error::value("duration", duration, "at most 10000 times max_step"));
        }
        let base =
            self.base_motion.unwrap_or(Pose { velocity: [0.0; 3], angular_velocity: [0.0; 3], ..self.state.pose });
        base.check()?;
        self.collect_loads()?;
        self.before.copy_from(&self.state);
        self.statistics = Statistics::default();
        self.newton.forget();
        if self.state.last_step == 0.0 {
            self.start()?;
        }
        let mut energy = if self.has_no_drive(&base) { Some(self.energy_of_state()?) } else { None };
        let extent = self.rest.iter().map(|x| (x - self.rest[0]).norm()).fold(0.0, f64::max);
        let quiet = 0.5 * self.masses.iter().sum::<f64>() * (QUIET * extent / duration).powi(2);
        let whole = 1_u64 << HALVINGS;
        let total = steps as u64 * whole;
        let (mut size, mut remaining) = (whole, total);
        while remaining > 0 {
            let span = Span {
                from: (total - remaining) as f64 / total as f64,
                to: (total - remaining + size) as f64 / total as f64,
                dt: duration * (size as f64 / total as f64),
                duration,
                base,
            };
            match self.substep(span).and_then(|()| self.check_gain(&mut energy, quiet)) {
                Ok(()) => {
                    self.statistics.substeps += 1;
                    remaining -= size;
                    if size < whole && remaining.is_multiple_of(2 * size) {
                        size *= 2;
                        self.newton.forget();
                    }
                }
                Err(_) if size > 1 => {
                    self.statistics.halvings += 1;
                    size /= 2;
                    self.newton.forget();
                }
                Err(failure) => {
                    self.state.copy_from(&self.before);
                    self.align_support();
                    return Err(self.error(failure));
                }
            }
        }
        self.state.pose = base;
        self.align_support();
        self.sum_up(duration)?;
        self.publish();
        Ok(())
    }

    /// Return whether the root is absent, or at rest in a step to the pose `base`.
    ///
    /// The work of a root that moves is known to first order only, too coarse for a check.
    fn has_no_drive(&self, base: &Pose) -> bool {
        let pose = &self.before.pose;
        let still = |pose: &Pose| [pose.velocity, pose.angular_velocity].as_flattened().iter().all(|c| *c == 0.0);
        let held =
            (base.displacement, base.rotation) == (pose.displacement, pose.rotation) && still(base) && still(pose);
        held || self.parameters.root.nodes.is_empty()
    }

    /// Compare the energy after a sub-step with `energy` before it plus the work of the loads. `energy`
    /// is absent where a drive does work. A gain above the rounding of `quiet` joules takes the sub-step back.
    fn check_gain(&mut self, energy: &mut Option<Energy>, quiet: f64) -> Result<(), Failure> {
        let Some(before) = energy else { return Ok(()) };
        let now = self.energy_of_state()?;
        let elastic = |energy: &Energy| energy.stretching + energy.bending + energy.veins;
        let [elastic, gravity] = [elastic(&now) - elastic(before), now.gravity - before.gravity];
        let [work, worked] = self.work_of_loads();
        let gain = now.kinetic - before.kinetic + elastic + gravity - work;
        let exchanged = now.kinetic + before.kinetic + elastic.abs() + gravity.abs() + worked;
        if exchanged > quiet && gain > MOST_GAIN * exchanged {
            self.state.copy_from(&self.before_substep);
            self.align_support();
            return Err(Failure::Gain([gain, exchanged]));
        }
        *before = now;
        Ok(())
    }

    /// Return the most work of the loads in the last sub-step, and the sum of its magnitudes over the nodes, J.
    ///
    /// At each node the load changes on the way: the more of the works of the loads before and after counts.
    fn work_of_loads(&self) -> [f64; 2] {
        let gravity = Vector::from(self.parameters.gravity);
        let (old, new) = (&self.before_substep, &self.state);
        let (mut most, mut sum) = (0.0, 0.0);
        for k in 0..self.rest.len() {
            let moved = new.positions[k] - old.positions[k];
            let [first, last] = [old, new].map(|state| {
                (state.loads[k] - gravity * self.masses[k] - self.resistance(k, &state.velocities[k])).dot(&moved)
            });
            most += first.max(last);
            sum += first.abs().max(last.abs());
        }
        [most, sum]
    }

    /// Record force, power and work of the loads and of the base in the step of `duration` seconds just made.
    fn sum_up(&mut self, duration: f64) -> Result<(), Error> {
        let gravity = Vector::from(self.parameters.gravity);
        let (mut force, mut power) = (Vector::zeros(), 0.0);
        for (k, v) in self.state.velocities.iter().enumerate() {
            let load = self.force[k] - gravity * self.masses[k] - self.resistance(k, v);
            force += load;
            power += load.dot(v);
        }
        let work = self.state.exchange.work + power * duration;
        self.state.exchange = Exchange { force, power, work };
        if self.parameters.root.nodes.is_empty() {
            return Ok(());
        }
        self.elastic.mass_times(&self.state.accelerations, &mut self.guess);
        let (x, v) = (&self.state.positions, &self.state.velocities);
        self.elastic.gradient(x, v, &mut self.product)?;
        let centre = Vector::from(self.parameters.root.origin) + Vector::from(self.state.pose.displacement);
        let omega = Vector::from(self.state.pose.angular_velocity);
        // The support turns the edges that it holds by the couple that the nodes alone do not balance.
        let couple: Vector = x.iter().zip(&self.product).map(|(x, elastic)| elastic.cross(&(x - centre))).sum();
        let (mut force, mut moment, mut power) = (Vector::zeros(), couple, couple.dot(&omega));
        for k in (0..self.rest.len()).filter(|&k| self.held[k]) {
            let reaction = self.guess[k] + self.product[k] - self.force[k] + self.resistance(k, &v[k]);
            force += reaction;
            moment += (x[k] - centre).cross(&reaction);
            power += reaction.dot(&v[k]);
        }
        let work = self.state.drive.work + power * duration;
        self.state.drive = Drive { force, moment: moment.into(), power, work };
        Ok(())
    }

    /// Return the force of the impedance of node `k` against the velocity `v`, N.
    fn resistance(&self, k: usize, v: &Vector) -> Vector {
        let impedance = self.loads.impedance.get(k).copied().unwrap_or(0.0);
        (v - self.before.velocities[k]) * impedance
    }

    /// Make a sub-step by the time scheme; a failure leaves the state unchanged.
    fn substep(&mut self, span: Span) -> Result<(), Failure> {
        let last_step = self.state.last_step;
        self.before_substep.copy_from(&self.state);
        match self.parameters.scheme {
            Scheme::Trapezoid => self.stage(StepRule::trapezoid(span.dt), 1.0, span)?,
            Scheme::GeneralisedAlpha { rho_inf } => {
                self.stage(StepRule::generalised_alpha(rho_inf, span.dt), 1.0, span)?;
            }
            Scheme::Bdf2 => self.stage(StepRule::bdf2(span.dt, last_step), 1.0, span)?,
            Scheme::TrBdf2 => {
                let (first, second) = span.split(TRAPEZOID_PART);
                self.stage(StepRule::trapezoid(first.dt), TRAPEZOID_PART, first)?;
                let second_stage = self.stage(StepRule::bdf2(second.dt, first.dt), 1.0, second);
                if second_stage.is_err() {
                    self.state.copy_from(&self.before_substep);
                    self.align_support();
                    return second_stage;
                }
            }
        }
        self.state.loads.copy_from_slice(&self.force);
        Ok(())
    }

    /// Solve for one stage over `span.dt` by `rule`; a failure leaves the state unchanged.
    ///
    /// The loads lie at the fraction `load_part` between the loads of the last step and the present loads.
    fn stage(&mut self, rule: StepRule, load_part: f64, span: Span) -> Result<(), Failure> {
        let dt = span.dt;
        let StepRule { c_v, c_a, new_mass, old_mass, new_force, old_force, .. } = rule;
        let placement = self.before.pose.towards(&span.base, span.to, span.duration);
        let origin = Vector::from(self.parameters.root.origin);
        for k in 0..self.rest.len() {
            let state = &self.state;
            let (v, a) = (state.velocities[k], state.accelerations[k]);
            let (guess, v_star, a_star) = if self.held[k] {
                let [x, v, a] = placement.node(origin, self.rest[k] - origin);
                (x, v, a)
            } else {
                let (v_star, a_star) = rule.at_no_displacement(state.motion(k));
                (state.positions[k] + v * dt + a * (0.5 * dt * dt), v_star, a_star)
            };
            self.guess[k] = guess;
            self.problem.velocity[k] = v_star;
            self.acceleration[k] = a_star;
            self.blend[k] = a_star * new_mass + a * old_mass;
        }
        self.elastic.mass_times(&self.blend, &mut self.product);
        for k in 0..self.rest.len() {
            let d = self.loads.impedance.get(k).copied().unwrap_or(0.0);
            let force = self.force[k] * load_part + self.state.loads[k] * (1.0 - load_part);
            let resistance = self.resistance(k, &self.problem.velocity[k]);
            self.problem.own[k] = new_force * d * c_v;
            self.problem.load[k] =
                (force - resistance) * new_force + self.state.net_forces[k] * old_force - self.product[k];
        }
        (self.problem.mass, self.problem.elastic, self.problem.rate) = (new_mass * c_a, new_force, c_v);
        self.elastic.support = placement.rotation;
        self.elastic.omega = vee(&(placement.rate * placement.rotation.transpose()));
        let Self { newton, elastic, problem, state, guess, statistics, .. } = self;
        if let Err(failure) = newton.solve(elastic, problem, &state.positions, guess, statistics) {
            self.align_support();
            return Err(failure);
        }

        for k in 0..self.rest.len() {
            let state = &mut self.state;
            let u = self.guess[k] - state.positions[k];
            let (mut v, mut a) = (self.problem.velocity[k], self.acceleration[k]);
            if !self.held[k] {
                (v, a) = (u * c_v + v, u * c_a + a);
            }
            self.blend[k] = a * new_mass + state.accelerations[k] * old_mass;
            state.previous_positions[k] = state.positions[k];
            state.previous_velocities[k] = state.velocities[k];
            state.positions[k] = self.guess[k];
            state.velocities[k] = v;
            state.accelerations[k] = a;
        }
        if old_force != 0.0 {
            self.elastic.mass_times(&self.blend, &mut self.product);
            for (net, blended) in self.state.net_forces.iter_mut().zip(&self.product) {
                *net = (blended - *net * old_force) / new_force;
            }
        }
        self.state.pose = Pose {
            displacement: placement.displacement.into(),
            velocity: placement.velocity.into(),
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| placement.rotation[(i, j)])),
            angular_velocity: self.elastic.omega.into(),
        };
        self.state.last_step = dt;
        Ok(())
    }

    /// Set accelerations and net forces before the first step: M a = F on the free nodes, by conjugate gradients.
    fn start(&mut self) -> Result<(), Error> {
        if self.parameters.displaced_density > 0.0 {
            // The fluid that moves with the wing tells of its inertia in the loads, which are not known yet.
            self.state.loads.copy_from_slice(&self.force);
            return Ok(());
        }
        let Self { elastic, state, force, problem, guess, product, held, masses, .. } = self;
        let (residual, direction) = (&mut problem.load, guess);
        elastic.gradient(&state.positions, &state.velocities, product)?;
        for k in 0..held.len() {
            state.net_forces[k] = force[k] - product[k];
        }
        state.loads.copy_from_slice(force);
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

    /// Check the loads and add them to gravity.
    pub(crate) fn collect_loads(&mut self) -> Result<(), Error> {
        let nodes = self.rest.len();
        self.loads.check(nodes)?;
        let gravity = Vector::from(self.parameters.gravity);
        for k in 0..nodes {
            self.force[k] = gravity * self.masses[k];
        }
        if !self.loads.force.is_empty() {
            for (d, component) in self.loads.force.chunks_exact(nodes).enumerate() {
                self.force.iter_mut().zip(component).for_each(|(sum, force)| sum[d] += force);
            }
        }
        Ok(())
    }
}

/// Return the angular velocity of a rate of rotation.
fn vee(rate: &nalgebra::Matrix3<f64>) -> Vector {
    Vector::new(rate[(2, 1)] - rate[(1, 2)], rate[(0, 2)] - rate[(2, 0)], rate[(1, 0)] - rate[(0, 1)]) * 0.5
}
