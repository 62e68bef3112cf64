//! The rod: parameters, loads, stepping.

use scene::{Coupling, Load, RodScheme, Scene, Section};
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::elastic::{Elastic, FOLD, Vector};
use crate::newton::{Balance, Failure, Newton, Statistics};
use crate::scheme::StepRule;
use crate::state::State;

/// A step that fails is halved at most this many times.
const HALVINGS: u32 = 6;

/// What a rod is made of and where it is clamped; straight at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters<const D: usize> {
    /// Position of the root, m.
    pub root: [f64; D],
    /// Direction from root to tip at rest; any length but 0.
    pub direction: [f64; D],
    /// Length, m.
    pub length: f64,
    /// Number of segments n, at least 2; there are n + 1 nodes.
    pub segments: usize,
    /// Mass and stiffness of the section (per metre of depth in two dimensions).
    pub section: Section,
    /// Mass per length of the displaced fluid, kg/m, that the loads account for. The rod itself carries the
    /// difference `section.line_density - displaced`, which may be 0 but not negative; gravity acts on it.
    pub displaced: f64,
    /// Gravity, m/s².
    pub gravity: [f64; D],
    /// Damping force per length and velocity, kg/(m s).
    pub damping: f64,
    /// Time scheme.
    pub scheme: RodScheme,
    /// Largest step taken inside [`Rod::step`], s; `None`: the whole step.
    pub max_step: Option<f64>,
}

/// Loads on the nodes, root to tip, held over a step; an empty array is a load that does not exist. The components of
/// `force` are `force.chunks_exact_mut(n + 1)`.
///
/// What is given for the clamped node 0 has no effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Nodal forces, N, component after component: `[D, n + 1]`.
    pub force: Vec<f64>,
    /// Jump of the pressure across the rod, p_top − p_bottom, Pa: `[n + 1]`; in two dimensions only. Top is the side of
    /// the left-hand normal n when walking from root to tip, and the load per length is −\[p\] n. It follows the
    /// rod's shape at the beginning of the step, so its direction is a step late.
    pub pressure_jump: Vec<f64>,
    /// Impedance D of the nodal forces, kg/s, at least 0: `[n + 1]`. A node moving at v gets the force
    /// f − D (v − v_ref), v_ref being its velocity at the beginning of the step, where f was found. With D = 0 a load
    /// from a fluid as heavy as the rod makes the coupling unstable.
    pub impedance: Vec<f64>,
}

/// Energies, J (per metre of depth in two dimensions).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Of the rod's own mass.
    pub kinetic: f64,
    /// Of the segments' extension.
    pub stretching: f64,
    /// Of the turning angles.
    pub bending: f64,
    /// Of the rod's own mass in gravity, 0 at the height of the root.
    pub gravity: f64,
}

/// The rod with its state, loads and scratch; [`Rod::step`] allocates nothing.
pub struct Rod<const D: usize> {
    /// Loads of the next step.
    pub loads: Loads,
    parameters: Parameters<D>,
    elastic: Elastic<D>,
    rest: Vec<Vector<D>>,
    /// Length that belongs to each node, m: `[n + 1]`.
    tributary: Vec<f64>,
    state: State<D>,
    statistics: Statistics,
    /// Positions and velocities component after component: `[D, n + 1]`.
    positions: Vec<f64>,
    velocities: Vec<f64>,
    newton: Newton<D>,
    balance: Balance<D>,
    /// State before the step.
    before: State<D>,
    /// Nodal forces without damping and impedance, N: `[n + 1]`.
    force: Vec<Vector<D>>,
    /// Positions that Newton's method works on, m: `[n + 1]`.
    guess: Vec<Vector<D>>,
}

impl<const D: usize> Rod<D> {
    /// A rod at rest, straight, without loads.
    pub fn new(parameters: Parameters<D>) -> Result<Self, Error> {
        const { assert!(D == 2 || D == 3, "a rod lives in 2 or 3 dimensions") };
        parameters.check()?;
        let &Parameters { length, segments, section, .. } = &parameters;
        let root = Vector::from(parameters.root);
        let direction = Vector::from(parameters.direction).normalize();
        let segment_length = length / segments as f64;
        let rest: Vec<_> = (0..=segments).map(|k| root + direction * (length * k as f64 / segments as f64)).collect();
        let nodes = segments + 1;
        let mut tributary = vec![segment_length; nodes];
        tributary[0] *= 0.5;
        tributary[segments] *= 0.5;
        let mut rod = Self {
            loads: Loads::default(),
            elastic: Elastic {
                segment_length,
                axial: section.axial_stiffness / segment_length,
                bending: section.bending_stiffness / segment_length,
                direction,
            },
            state: State::at_rest(rest.clone()),
            before: State::at_rest(rest.clone()),
            statistics: Statistics::default(),
            positions: vec![0.0; D * nodes],
            velocities: vec![0.0; D * nodes],
            newton: Newton::new(segments, length, root.amax() + length),
            balance: Balance { weight: vec![0.0; nodes], load: vec![Vector::zeros(); nodes], elastic_weight: 1.0 },
            force: vec![Vector::zeros(); nodes],
            guess: rest.clone(),
            rest,
            tributary,
            parameters,
        };
        rod.publish();
        Ok(rod)
    }

    /// The rod of a scene with the loads that the scene has: nodal forces where there is no fluid, nodal forces and
    /// impedance under the momentum load, the pressure jump under that load.
    pub fn from_scene(scene: &Scene) -> Result<Self, Error> {
        let (Some(beam), Some(rod)) = (&scene.beam, &scene.rod) else {
            return Err(Error::NoRod { scene: scene.name.clone(), dimension: D });
        };
        if scene.dimension(beam) != D {
            return Err(Error::NoRod { scene: scene.name.clone(), dimension: D });
        }
        let stations = scene.beam_stations(beam);
        let (root, tip) = (stations[0], stations[beam.segments]);
        let mut built = Self::new(Parameters {
            root: std::array::from_fn(|d| root[d]),
            direction: std::array::from_fn(|d| tip[d] - root[d]),
            length: beam.length,
            segments: beam.segments,
            section: rod.material.section(beam.thickness),
            displaced: scene.displaced_line_density(),
            gravity: std::array::from_fn(|d| rod.gravity.get(d).copied().unwrap_or(0.0)),
            damping: rod.damping,
            scheme: rod.scheme,
            max_step: rod.max_step,
        })?;
        let nodes = beam.segments + 1;
        let zeros = |count: usize| vec![0.0; count];
        built.loads = match scene.coupling {
            None => Loads { force: zeros(D * nodes), ..Loads::default() },
            Some(Coupling { load: Load::Momentum, .. }) => {
                Loads { force: zeros(D * nodes), impedance: zeros(nodes), ..Loads::default() }
            }
            Some(Coupling { load: Load::PressureJump, .. }) => {
                Loads { pressure_jump: zeros(nodes), ..Loads::default() }
            }
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

    /// Displacement of the tip from its rest position, m.
    pub fn tip_displacement(&self) -> [f64; D] {
        let tip = self.parameters.segments;
        (self.state.positions[tip] - self.rest[tip]).into()
    }

    /// Energies of the state.
    pub fn energy(&self) -> Result<Energy, Error> {
        let elastic = self.elastic.energy(&self.state.positions).map_err(|fold| self.error(Failure::FoldBack(fold)))?;
        let gravity = Vector::from(self.parameters.gravity);
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for k in 1..self.rest.len() {
            let m = self.mass(k);
            kinetic += 0.5 * m * self.state.velocities[k].norm_squared();
            potential -= m * gravity.dot(&(self.state.positions[k] - self.state.positions[0]));
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
    /// Refuses a state of another number of nodes, with numbers that are not finite, with a root that is not the
    /// rod's, or that folds back.
    pub fn restore(&mut self, state: &State<D>) -> Result<(), Error> {
        state.check(self.rest.len())?;
        let (position, velocity) = (state.positions[0], state.velocities[0]);
        if position != self.rest[0] {
            return Err(Error::value(
                "state.positions[0]",
                format!("{:?}", position.as_slice()),
                "the root's position",
            ));
        }
        if velocity != Vector::<D>::zeros() {
            return Err(Error::value("state.velocities[0]", format!("{:?}", velocity.as_slice()), "0 at the clamp"));
        }
        self.elastic.energy(&state.positions).map_err(|fold| self.error(Failure::FoldBack(fold)))?;
        self.state.copy_from(state);
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
        self.collect_loads()?;
        self.before.copy_from(&self.state);
        self.statistics = Statistics::default();
        if self.state.last_step == 0.0 {
            self.start()?;
        }
        // A duration that rounding has made a little too long takes no extra step.
        let steps = self.parameters.max_step.map_or(1.0, |longest| (duration / longest - 1e-9).ceil().max(1.0)) as u64;
        let whole = 1 << HALVINGS;
        let total = steps.saturating_mul(whole);
        let mut size = whole;
        let mut remaining = total;
        while remaining > 0 {
            match self.substep(duration * (size as f64 / total as f64)) {
                Ok(()) => {
                    remaining -= size;
                    if size < whole && remaining.is_multiple_of(2 * size) {
                        size *= 2;
                    }
                }
                Err(_) if size > 1 => size /= 2,
                Err(failure) => {
                    self.state.copy_from(&self.before);
                    return Err(self.error(failure));
                }
            }
        }
        self.publish();
        Ok(())
    }

    /// Move to equilibrium under the present loads, at rest, as before a first step; impedance plays no part.
    ///
    /// A pressure jump keeps the direction that it has in the present shape. On an error the state is as before.
    pub fn solve_static(&mut self) -> Result<(), Error> {
        self.collect_loads()?;
        self.statistics = Statistics::default();
        self.balance.weight.fill(0.0);
        self.balance.load.copy_from_slice(&self.force);
        self.balance.elastic_weight = 1.0;
        self.guess.copy_from_slice(&self.state.positions);
        let Self { newton, elastic, balance, state, guess, statistics, .. } = self;
        newton.solve(elastic, balance, &state.positions, guess, statistics).map_err(|failure| self.error(failure))?;
        self.state = State::at_rest(self.guess.clone());
        self.publish();
        Ok(())
    }

    /// One step of `dt` by the time scheme; on failure the state is as before.
    fn substep(&mut self, dt: f64) -> Result<(), Failure> {
        let rule = StepRule::new(self.parameters.scheme, dt, self.state.last_step);
        let (new_mass, old_mass, new_force, old_force) =
            (1.0 - rule.alpha_m, rule.alpha_m, 1.0 - rule.alpha_f, rule.alpha_f);
        self.balance.elastic_weight = new_force;
        for k in 1..self.rest.len() {
            let (v_star, a_star) = rule.at_no_displacement(&self.state, k);
            let m = self.mass(k);
            let c = self.parameters.damping * self.tributary[k];
            let d = self.loads.impedance.get(k).copied().unwrap_or(0.0);
            let (v, a) = (self.state.velocities[k], self.state.accelerations[k]);
            let v_ref = self.before.velocities[k];

            self.balance.weight[k] = new_mass * m * rule.c_a + new_force * (c + d) * rule.c_v;
            self.balance.load[k] = (self.force[k] - v_star * c - (v_star - v_ref) * d) * new_force
                + self.state.net_forces[k] * old_force
                - (a_star * new_mass + a * old_mass) * m;
            self.guess[k] = self.state.positions[k] + v * dt + a * (0.5 * dt * dt);
        }
        let Self { newton, elastic, balance, state, guess, statistics, .. } = self;
        newton.solve(elastic, balance, &state.positions, guess, statistics)?;

        for k in 1..self.rest.len() {
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
            state.net_forces[k] = (blended - state.net_forces[k] * old_force) / new_force;
        }
        self.state.last_step = dt;
        self.statistics.substeps += 1;
        Ok(())
    }

    /// Accelerations and net forces at the beginning of the first step; 0 for nodes without mass, which only follow.
    fn start(&mut self) -> Result<(), Error> {
        let Self { newton, elastic, state, .. } = self;
        let by_edge = &mut newton.by_edge;
        elastic.derivatives(&state.positions, by_edge).map_err(|fold| self.error(Failure::FoldBack(fold)))?;
        for k in 1..self.rest.len() {
            let m = self.mass(k);
            if m > 0.0 {
                let beyond = self.newton.by_edge.gradient.get(k).copied().unwrap_or_else(Vector::zeros);
                let elastic_force = beyond - self.newton.by_edge.gradient[k - 1];
                let c = self.parameters.damping * self.tributary[k];
                let net = self.force[k] + elastic_force - self.state.velocities[k] * c;
                self.state.net_forces[k] = net;
                self.state.accelerations[k] = net / m;
            }
        }
        Ok(())
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
            // Half of either edge belongs to the node; turned to the left it is the normal times the length.
            let x = &self.state.positions;
            let own = (x[(k + 1).min(nodes - 1)] - x[k.saturating_sub(1)]) * 0.5;
            self.force[k][0] += jump * own[1];
            self.force[k][1] -= jump * own[0];
        }
        Ok(())
    }

    /// Mass of node `k`, kg.
    fn mass(&self, k: usize) -> f64 {
        (self.parameters.section.line_density - self.parameters.displaced) * self.tributary[k]
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

    fn error(&self, failure: Failure) -> Error {
        match failure {
            Failure::NotConverged { residual, tolerance } => {
                Error::NotConverged { residual, tolerance, iterations: self.statistics.iterations }
            }
            Failure::FoldBack(fold) => {
                Error::FoldBack { node: fold.node, limit: FOLD * self.elastic.segment_length.powi(2) }
            }
        }
    }
}

impl<const D: usize> Parameters<D> {
    fn check(&self) -> Result<(), Error> {
        let Section { line_density, bending_stiffness, axial_stiffness } = self.section;
        for (name, vector) in [("root", self.root), ("direction", self.direction), ("gravity", self.gravity)] {
            if vector.iter().any(|c| !c.is_finite()) {
                return Err(Error::value(name, format!("{vector:?}"), "finite"));
            }
        }
        let direction = Vector::from(self.direction).norm();
        if !(direction.is_normal()) {
            return Err(Error::value("direction", format!("{:?}", self.direction), "a vector of any length but 0"));
        }
        for (name, value) in [
            ("length", self.length),
            ("section.line_density", line_density),
            ("section.bending_stiffness", bending_stiffness),
            ("section.axial_stiffness", axial_stiffness),
        ]
        .into_iter()
        .chain(self.max_step.map(|longest| ("max_step", longest)))
        {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::value(name, value, "a finite number above 0"));
            }
        }
        for (name, value) in [("displaced", self.displaced), ("damping", self.damping)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::value(name, value, "a finite number of at least 0"));
            }
        }
        if self.displaced > line_density {
            return Err(Error::NegativeMass { line_density, displaced: self.displaced });
        }
        if self.segments < 2 {
            return Err(Error::value("segments", self.segments, "at least 2"));
        }
        match self.scheme {
            RodScheme::GeneralisedAlpha { rho_inf } if !(0.0..=1.0).contains(&rho_inf) => {
                Err(Error::value("scheme.generalised_alpha.rho_inf", rho_inf, "between 0 and 1"))
            }
            _ => Ok(()),
        }
    }
}

impl Loads {
    /// Each array is empty or has its number of entries, all finite; the impedance is not negative.
    fn check<const D: usize>(&self, nodes: usize) -> Result<(), Error> {
        for (name, array, expected) in [
            ("force", &self.force, D * nodes),
            ("pressure_jump", &self.pressure_jump, if D == 2 { nodes } else { 0 }),
            ("impedance", &self.impedance, nodes),
        ] {
            if !array.is_empty() && array.len() != expected {
                return Err(Error::Length { name: format!("loads.{name}"), length: array.len(), expected });
            }
            if let Some(k) = array.iter().position(|value| !value.is_finite()) {
                return Err(Error::value(format!("loads.{name}[{k}]"), array[k], "finite"));
            }
        }
        match self.impedance.iter().position(|&d| d < 0.0) {
            Some(k) => Err(Error::value(format!("loads.impedance[{k}]"), self.impedance[k], "at least 0 kg/s")),
            None => Ok(()),
        }
    }
}
