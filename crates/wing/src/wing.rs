//! The wing: parameters, state, loads and results.

use ::geometry::Crossings;

use crate::Error;
use crate::elastic::{BadShape, Elastic};
use crate::geometry::{Geometry, Vector};
use crate::loads::Loads;
use crate::newton::{Failure, Newton, Problem, Statistics};
use crate::parameters::Parameters;
use crate::pose::Pose;
use crate::section::Section;
use crate::state::State;
use crate::system::System;

/// Least mass of the membrane without the displaced fluid, by its own: the mass matrix stays positive definite.
const LEAST_MASS: f64 = 1e-3;

/// Energies, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy, without the displaced fluid.
    pub kinetic: f64,
    /// Energy of the strain of the membrane, with its tension.
    pub stretching: f64,
    /// Energy of bending of the membrane.
    pub bending: f64,
    /// Energy of the veins.
    pub veins: f64,
    /// Potential energy in gravity, 0 at rest.
    pub gravity: f64,
}

impl Energy {
    /// Return the sum of all energies.
    pub fn total(&self) -> f64 {
        self.kinetic + self.stretching + self.bending + self.veins + self.gravity
    }
}

/// Wing with its parameters, state and loads; [`Wing::step`] allocates nothing.
pub struct Wing {
    /// Loads of the next step.
    pub loads: Loads,
    /// Pose of the base at the end of the next step; `None` for a base at rest, and for a free wing.
    pub base_motion: Option<Pose>,
    pub(crate) parameters: Parameters,
    pub(crate) elastic: Elastic,
    /// Held nodes: `[nodes]`.
    pub(crate) held: Vec<bool>,
    /// Nodes at rest, m: `[nodes]`.
    pub(crate) rest: Vec<Vector>,
    /// Sum of the rows of the mass matrix with the displaced fluid, kg: `[nodes]`.
    pub(crate) masses: Vec<f64>,
    pub(crate) state: State,
    pub(crate) statistics: Statistics,
    /// Positions and velocities, component after component: `[3, nodes]`.
    positions: Vec<f64>,
    velocities: Vec<f64>,
    pub(crate) newton: Newton,
    crossings: Crossings,
    section: Option<Section>,
    pub(crate) problem: Problem,
    /// State before the step and before the sub-step.
    pub(crate) before: State,
    pub(crate) before_substep: State,
    /// Nodal forces without damping and impedance, N: `[nodes]`.
    pub(crate) force: Vec<Vector>,
    /// Positions in Newton's method, m: `[nodes]`.
    pub(crate) guess: Vec<Vector>,
    /// Accelerations a* of a stage, scratch, and blended accelerations: `[nodes]`.
    pub(crate) acceleration: Vec<Vector>,
    pub(crate) product: Vec<Vector>,
    pub(crate) blend: Vec<Vector>,
}

impl Wing {
    /// Build a wing at rest, without loads.
    ///
    /// # Errors
    /// A parameter outside its range is named with its value.
    pub fn new(parameters: Parameters) -> Result<Self, Error> {
        parameters.check()?;
        let nodes = parameters.mesh.nodes.len();
        let mut held = vec![false; nodes];
        parameters.root.nodes.iter().for_each(|&k| held[k] = true);
        if held.iter().all(|&held| held) {
            return Err(Error::value("root.nodes", "all nodes", "at most all nodes but one"));
        }
        let rest: Vec<_> = (0..nodes).map(|k| parameters.mesh.node(k)).collect();
        let mut elastic = Elastic::new(&parameters, &held)?;
        let system = System::new(&elastic, &held)?;
        let middle = rest.iter().sum::<Vector>() / nodes as f64;
        let size = rest.iter().fold(0.0_f64, |size, x| size.max((x - middle).norm()));
        let zeros = vec![Vector::zeros(); nodes];
        let state = State::at_rest(rest.clone(), Pose::rest());
        let (mut ones, mut product) = (zeros.clone(), zeros.clone());
        ones.fill(Vector::repeat(1.0));
        elastic.mass_times(&ones, &mut product);
        let masses = product.iter().map(|mass| mass.x).collect();
        for (t, face) in elastic.faces.iter_mut().enumerate() {
            let own = parameters.membrane(t).areal_density;
            face.mass -= face.area * parameters.displaced_density.min((1.0 - LEAST_MASS) * own);
        }
        let mut wing = Self {
            crossings: Crossings::new(elastic.faces.len()),
            section: Section::new(&parameters.mesh, &parameters.root.nodes),
            loads: Loads::default(),
            base_motion: None,
            newton: Newton::new(system, &elastic, &rest, size),
            problem: Problem {
                load: zeros.clone(),
                own: vec![0.0; nodes],
                mass: 0.0,
                elastic: 1.0,
                rate: 0.0,
                velocity: zeros.clone(),
            },
            masses,
            elastic,
            held,
            before: state.clone(),
            before_substep: state.clone(),
            state,
            statistics: Statistics::default(),
            positions: vec![0.0; 3 * nodes],
            velocities: vec![0.0; 3 * nodes],
            force: zeros.clone(),
            guess: rest.clone(),
            rest,
            acceleration: zeros.clone(),
            blend: zeros,
            product,
            parameters,
        };
        wing.publish();
        Ok(wing)
    }

    /// Return the parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Return the number of nodes.
    pub fn nodes(&self) -> usize {
        self.rest.len()
    }

    /// Return component `d` of the positions of the nodes, m: `[nodes]`.
    pub fn positions(&self, d: usize) -> &[f64] {
        &self.positions[d * self.rest.len()..][..self.rest.len()]
    }

    /// Return component `d` of the velocities of the nodes, m/s: `[nodes]`.
    pub fn velocities(&self, d: usize) -> &[f64] {
        &self.velocities[d * self.rest.len()..][..self.rest.len()]
    }

    /// Return the mass that belongs to each node, kg: `[nodes]`.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Return the number of unknowns of Newton's matrix and of the entries of its factor.
    pub fn size_of_system(&self) -> [usize; 2] {
        [self.newton.system.matrix.order(), self.newton.system.matrix.fill()]
    }

    /// Factorise the last matrix of Newton's method again; for measurements.
    #[doc(hidden)]
    pub fn factorise_once(&mut self) -> bool {
        self.newton.system.matrix.factorise()
    }

    /// Return the energies of the state.
    pub fn energy(&mut self) -> Result<Energy, Error> {
        Ok(self.energy_of_state()?)
    }

    /// Return them with the reason why a shape has none.
    pub(crate) fn energy_of_state(&mut self) -> Result<Energy, BadShape> {
        let Self { elastic, state, parameters, rest, masses, product, .. } = self;
        let mut energy = elastic.energy(&state.positions)?;
        elastic.mass_times(&state.velocities, product);
        energy.kinetic = 0.5 * product.iter().zip(&state.velocities).map(|(p, v)| p.dot(v)).sum::<f64>();
        let gravity = Vector::from(parameters.gravity);
        let moved = state.positions.iter().zip(&*rest).zip(&*masses);
        energy.gravity = -moved.map(|((x, rest), mass)| *mass * gravity.dot(&(x - rest))).sum::<f64>();
        Ok(energy)
    }

    /// Return momentum, kg m/s, and angular momentum about the origin of coordinates, kg m²/s.
    pub fn momentum(&mut self) -> [[f64; 3]; 2] {
        let Self { elastic, state, product, .. } = self;
        elastic.mass_times(&state.velocities, product);
        let angular: Vector = product.iter().zip(&state.positions).map(|(p, x)| x.cross(p)).sum();
        [product.iter().sum::<Vector>().into(), angular.into()]
    }

    /// Return the power lost by damping, W.
    pub fn damping_power(&mut self) -> Result<f64, Error> {
        let Self { elastic, state, product, acceleration, .. } = self;
        elastic.gradient(&state.positions, &state.velocities, product)?;
        let whole: f64 = product.iter().zip(&state.velocities).map(|(f, v)| f.dot(v)).sum();
        product.fill(Vector::zeros());
        let tau = std::mem::replace(&mut elastic.relaxation_time, 0.0);
        let undamped = elastic.gradient(&state.positions, &state.velocities, acceleration);
        elastic.relaxation_time = tau;
        undamped?;
        Ok(whole - acceleration.iter().zip(&state.velocities).map(|(f, v)| f.dot(v)).sum::<f64>())
    }

    /// Return the elastic force on each node in the shape `x` at rest, N: minus the gradient of the energy.
    pub fn elastic_forces(&mut self, x: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Error> {
        if x.len() != self.nodes() {
            return Err(Error::Length { name: "x".into(), length: x.len(), expected: self.nodes() });
        }
        let x: Vec<_> = x.iter().map(|x| Vector::from(*x)).collect();
        self.guess.fill(Vector::zeros());
        self.elastic.gradient(&x, &self.guess, &mut self.product)?;
        Ok(self.product.iter().map(|force| (-force).into()).collect())
    }

    /// Return the number of pairs of triangles that cross each other: nothing holds the parts of a wing apart.
    pub fn crossings(&mut self) -> usize {
        let (faces, x) = (&self.elastic.faces, &self.state.positions);
        self.crossings.count(|k| faces[k].nodes, |node| x[node].into())
    }

    /// Return the turn of the chord at three quarters of the span about the span, rad, from its direction on the base
    /// at rest; `None` for a wing without a line of the root or without triangles.
    pub fn twist(&self) -> Option<f64> {
        self.section.as_ref().map(|section| section.twist(&self.state.positions, &self.state.pose.matrix()))
    }

    /// Return the largest distance of the membrane from that chord, by its length, positive on the side of the normals
    /// of the triangles; `None` as the twist.
    pub fn camber(&self) -> Option<f64> {
        self.section.as_ref().map(|section| section.camber(&self.state.positions, &self.state.pose.matrix()))
    }

    /// Return the effort of the last step.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Return the state.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Continue from `state`; the same loads and steps repeat the same bits.
    ///
    /// # Errors
    /// The wing refuses a state with another number of nodes, with numbers that are not finite or with a folded shape.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        state.check(self.nodes())?;
        let support = self.elastic.support;
        self.elastic.support = state.pose.matrix();
        if let Err(shape) = self.elastic.energy(&state.positions) {
            self.elastic.support = support;
            return Err(shape.into());
        }
        self.state.copy_from(state);
        self.align_support();
        self.statistics = Statistics::default();
        self.publish();
        Ok(())
    }

    /// Place the wing with its base in the state `motion`, in its rest shape, moving as a rigid body.
    pub fn place(&mut self, motion: Pose) -> Result<(), Error> {
        motion.check()?;
        let origin = Vector::from(self.parameters.root.origin);
        let placement = motion.towards(&motion, 1.0, 1.0);
        self.state = State::at_rest(self.rest.clone(), motion);
        for (k, rest) in self.rest.iter().enumerate() {
            let [x, v, _] = placement.node(origin, rest - origin);
            (self.state.positions[k], self.state.velocities[k]) = (x, v);
            self.state.accelerations[k] =
                Vector::from(motion.angular_velocity).cross(&(placement.rate * (rest - origin)));
        }
        self.state.previous_positions.copy_from_slice(&self.state.positions);
        self.state.previous_velocities.copy_from_slice(&self.state.velocities);
        self.base_motion = Some(motion);
        self.align_support();
        self.publish();
        Ok(())
    }

    /// Set the velocities of the free nodes, m/s, before a first step.
    pub fn set_velocities(&mut self, velocities: &[[f64; 3]]) -> Result<(), Error> {
        if velocities.len() != self.nodes() {
            return Err(Error::Length { name: "velocities".into(), length: velocities.len(), expected: self.nodes() });
        }
        if let Some(k) = velocities.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
            return Err(Error::value(format!("velocities[{k}]"), velocities[k], "finite"));
        }
        for (k, v) in velocities.iter().enumerate().filter(|(k, _)| !self.held[*k]) {
            (self.state.velocities[k], self.state.previous_velocities[k]) = (Vector::from(*v), Vector::from(*v));
        }
        self.state.last_step = 0.0;
        self.publish();
        Ok(())
    }

    /// Turn the support of the elastic energy as the pose of the state says.
    pub(crate) fn align_support(&mut self) {
        self.elastic.support = self.state.pose.matrix();
        self.elastic.omega = Vector::from(self.state.pose.angular_velocity);
    }

    /// Copy positions and velocities into arrays of components.
    pub(crate) fn publish(&mut self) {
        let nodes = self.rest.len();
        for d in 0..3 {
            for k in 0..nodes {
                self.positions[d * nodes + k] = self.state.positions[k][d];
                self.velocities[d * nodes + k] = self.state.velocities[k][d];
            }
        }
    }

    /// Return the error for a failed solve.
    pub(crate) fn error(&self, failure: Failure) -> Error {
        match failure {
            Failure::NotConverged(imbalance) => Error::NotConverged {
                residual: imbalance.residual,
                tolerance: imbalance.tolerance,
                iterations: self.statistics.iterations,
            },
            Failure::BadShape(shape) => shape.into(),
            Failure::Gain([gain, exchanged]) => Error::Gain { gain, exchanged },
        }
    }
}
