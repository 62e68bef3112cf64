//! State and scratch of a structure.

use crate::{Balance, Error, Loads, Scheme, State, Statistics, StepRule, Vector};

/// Ratio of steps, but for rounding, above which the second is longer.
const LONGER: f64 = 1.0 + 1e-9;

/// What every structure has: state, forces and the unknowns of a stage; an array has one entry per node.
pub struct Core<const D: usize, M> {
    /// Time scheme.
    pub scheme: Scheme,
    /// Longest sub-step, s; `None` for no limit.
    pub max_step: Option<f64>,
    /// Nodes at rest, m.
    pub rest: Vec<Vector<D>>,
    /// Held nodes.
    pub held: Vec<bool>,
    /// Whether a body carries the root: held nodes then accelerate by the scheme, as that body does.
    pub carried: bool,
    /// Weights, N.
    pub weights: Vec<Vector<D>>,
    /// Parts of the weights that act before the loads tell of the fluid that moves with the nodes; all, where empty.
    pub first_weights: Vec<f64>,
    /// Whether these parts alone act.
    starts: bool,
    /// State.
    pub state: State<D, M>,
    /// State before the step.
    pub before: State<D, M>,
    /// State before the sub-step.
    pub before_substep: State<D, M>,
    /// Effort of the last step.
    pub statistics: Statistics,
    /// Weights and loads without impedance, N.
    pub force: Vec<Vector<D>>,
    /// Impedance of the loads, kg/s.
    pub impedance: Vec<f64>,
    /// Normal of a surface times the root of what the impedance across it has beyond that along it, (kg/s)^½; of others
    /// empty.
    pub across: Vec<Vector<D>>,
    /// Equation of a stage.
    pub balance: Balance<D>,
    /// Positions in Newton's method, m.
    pub guess: Vec<Vector<D>>,
    /// Accelerations a* of a stage, m/s².
    pub acceleration: Vec<Vector<D>>,
    /// Accelerations that a scheme blends of both ends of a step, m/s².
    pub blend: Vec<Vector<D>>,
    /// Product of the mass matrix and `blend`, N, or other nodal forces.
    pub product: Vec<Vector<D>>,
    /// Positions and velocities, component after component: `[D, nodes]`.
    positions: Vec<f64>,
    velocities: Vec<f64>,
}

/// Return the part of the weight of a node of the mass `own`, kg, besides `moving`, kg, of the fluid that moves with it,
/// with which it starts: a node lighter than the fluid at gravity times its whole mass over that of the fluid.
pub fn first_weight(own: f64, moving: f64) -> f64 {
    if own < moving { own / moving } else { 1.0 }
}

impl<const D: usize, M: Clone> Core<D, M> {
    /// Return the structure at rest in the state `state`, with the nodes that `held` tells and the `weights`, N.
    pub fn new(
        state: State<D, M>,
        held: Vec<bool>,
        weights: Vec<Vector<D>>,
        scheme: Scheme,
        max_step: Option<f64>,
    ) -> Self {
        let rest = state.positions.clone();
        let nodes = rest.len();
        let zeros = vec![Vector::zeros(); nodes];
        let mut core = Self {
            scheme,
            max_step,
            held,
            carried: false,
            weights,
            first_weights: vec![],
            starts: false,
            before: state.clone(),
            before_substep: state.clone(),
            state,
            statistics: Statistics::default(),
            force: zeros.clone(),
            impedance: vec![0.0; nodes],
            across: vec![],
            balance: Balance::at_rest(nodes),
            guess: rest.clone(),
            rest,
            acceleration: zeros.clone(),
            blend: zeros.clone(),
            product: zeros,
            positions: vec![0.0; D * nodes],
            velocities: vec![0.0; D * nodes],
        };
        core.publish();
        core
    }

    /// Return component `d` of the positions, m: `[nodes]`.
    pub fn positions(&self, d: usize) -> &[f64] {
        &self.positions[d * self.rest.len()..][..self.rest.len()]
    }

    /// Return component `d` of the velocities, m/s: `[nodes]`.
    pub fn velocities(&self, d: usize) -> &[f64] {
        &self.velocities[d * self.rest.len()..][..self.rest.len()]
    }

    /// Copy positions and velocities of the state into arrays of components.
    pub fn publish(&mut self) {
        let nodes = self.rest.len();
        for (components, vectors) in
            [(&mut self.positions, &self.state.positions), (&mut self.velocities, &self.state.velocities)]
        {
            for (d, component) in components.chunks_exact_mut(nodes).enumerate() {
                component.iter_mut().zip(vectors).for_each(|(component, vector)| *component = vector[d]);
            }
        }
    }

    /// Continue from `state`, of the same number of nodes.
    pub fn restore(&mut self, state: &State<D, M>) {
        self.state.copy_from(state);
        self.statistics = Statistics::default();
        self.publish();
    }

    /// Check the loads and add nodal forces and weights.
    pub fn collect<F>(&mut self, loads: &Loads) -> Result<(), Error<F>> {
        let nodes = self.rest.len();
        loads.check::<D, F>(nodes)?;
        self.starts = false;
        self.force.copy_from_slice(&self.weights);
        if !loads.force.is_empty() {
            for (d, component) in loads.force.chunks_exact(nodes).enumerate() {
                self.force.iter_mut().zip(component).for_each(|(sum, force)| sum[d] += force);
            }
        }
        match loads.impedance.is_empty() {
            true => self.impedance.fill(0.0),
            false => self.impedance.copy_from_slice(&loads.impedance),
        }
        Ok(())
    }

    /// Weigh the nodes in a first step by the mass that they have without the fluid that moves with them: without an
    /// impedance the loads do not tell of its inertia yet, and all of the weight would throw what is light.
    pub fn weigh_first(&mut self) {
        let tell = self.impedance.iter().any(|&impedance| impedance > 0.0);
        self.starts = !(self.first_weights.is_empty() || self.carried || self.state.last_step > 0.0 || tell);
        if self.starts {
            for ((force, weight), part) in self.force.iter_mut().zip(&self.weights).zip(&self.first_weights) {
                *force -= weight * (1.0 - part);
            }
        }
    }

    /// Return the weight of node `k` in the present step, N.
    pub fn weight(&self, k: usize) -> Vector<D> {
        if self.starts { self.weights[k] * self.first_weights[k] } else { self.weights[k] }
    }

    /// Return the rule that replaces TR-BDF2 and BDF2 in a sub-step of `dt` (s) in which the structure may touch anything:
    /// that of BDF2, as the trapezoid gains energy in short contacts, and after a shorter sub-step that of the backward
    /// Euler method, as BDF2 gains energy there.
    pub fn rule_in_contact(&self, dt: f64) -> Option<StepRule> {
        let last_step = if dt > LONGER * self.state.last_step { 0.0 } else { self.state.last_step };
        matches!(self.scheme, Scheme::TrBdf2 | Scheme::Bdf2).then(|| StepRule::bdf2(dt, last_step))
    }

    /// Return the force of the impedance of node `k` against the velocity `v`, N.
    #[inline(always)]
    pub fn resistance(&self, k: usize, v: &Vector<D>) -> Vector<D> {
        let change = v - self.before.velocities[k];
        let across = self.across.get(k).map_or_else(Vector::zeros, |across| across * across.dot(&change));
        change * self.impedance[k] + across
    }

    /// Predict a stage over `dt`, s: positions, v*, a* and the blended accelerations without displacement.
    ///
    /// `place` returns position, velocity and acceleration of a held node from its position at rest.
    #[inline(always)]
    pub fn predict(&mut self, rule: &StepRule, dt: f64, place: impl Fn(Vector<D>) -> [Vector<D>; 3]) {
        for k in 0..self.rest.len() {
            let now = self.state.motion(k);
            let [x, v, a] = if self.held[k] {
                let [x, v, a] = place(self.rest[k]);
                let differenced = if self.carried { rule.acceleration(now, v) } else { None };
                [x, v, differenced.unwrap_or(a)]
            } else {
                let (v, a) = rule.at_no_displacement(now);
                [now.x + now.v * dt + now.a * (0.5 * dt * dt), v, a]
            };
            (self.guess[k], self.balance.velocity[k], self.acceleration[k]) = (x, v, a);
            self.blend[k] = a * rule.new_mass + now.a * rule.old_mass;
        }
    }

    /// Complete the equation of a stage: `diagonal` has the weights of lumped masses and `load` the blended accelerations
    /// times the masses.
    ///
    /// The loads lie at the fraction `load_part` between the loads of the last step and the present loads; `damping`
    /// returns the damping of a node against its velocity, kg/s.
    #[inline(always)]
    pub fn set_balance(&mut self, rule: &StepRule, load_part: f64, damping: impl Fn(usize) -> f64) {
        let &StepRule { c_v, c_a, new_mass, new_force, old_force, .. } = rule;
        for k in 0..self.rest.len() {
            let (v, c) = (self.balance.velocity[k], damping(k));
            let force = self.force[k] * load_part + self.state.loads[k] * (1.0 - load_part);
            let resistance = self.resistance(k, &v);
            let inertia = self.balance.load[k];
            self.balance.diagonal[k] += new_force * (c + self.impedance[k]) * c_v;
            self.balance.load[k] =
                (force - v * c - resistance) * new_force + self.state.net_forces[k] * old_force - inertia;
        }
        let root = (new_force * c_v).sqrt();
        self.balance.across.iter_mut().zip(&self.across).for_each(|(own, across)| *own = across * root);
        (self.balance.mass, self.balance.elastic, self.balance.rate) = (new_mass * c_a, new_force, c_v);
    }

    /// Move the state to the positions found in a stage over `dt`, s, except net forces and own memory; blend the
    /// accelerations.
    #[inline(always)]
    pub fn correct(&mut self, rule: &StepRule, dt: f64) {
        for k in 0..self.rest.len() {
            let state = &mut self.state;
            let u = self.guess[k] - state.positions[k];
            let (mut v, mut a) = (self.balance.velocity[k], self.acceleration[k]);
            if !self.held[k] {
                (v, a) = (u * rule.c_v + v, u * rule.c_a + a);
            }
            self.blend[k] = a * rule.new_mass + state.accelerations[k] * rule.old_mass;
            state.previous_positions[k] = state.positions[k];
            state.previous_velocities[k] = state.velocities[k];
            state.positions[k] = self.guess[k];
            state.velocities[k] = v;
            state.accelerations[k] = a;
        }
        self.state.last_step = dt;
    }
}
