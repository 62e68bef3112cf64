//! The rod: parameters, state, loads and results.

use crate::Error;
use crate::base_motion::BaseMotion;
use crate::elastic::{BadShape, Elastic, FOLD};
use crate::hinge::Hinge;
use crate::loads::Loads;
use crate::model::RootSupport;
use crate::newton::{Balance, Failure, Imbalance, Newton, Statistics, kept};
use crate::parameters::Parameters;
use crate::state::State;
use crate::vector::Vector;

/// Energies, J (per metre of depth in two dimensions).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Kinetic energy of the rod without displaced fluid.
    pub kinetic: f64,
    /// Energy of extension.
    pub stretching: f64,
    /// Energy of bending and shear.
    pub bending: f64,
    /// Potential energy in gravity, 0 at the height of the root at rest.
    pub gravity: f64,
}

/// Rod with its parameters, state and loads; [`Rod::step`] allocates nothing.
pub struct Rod<const D: usize> {
    /// Loads of the next step.
    pub loads: Loads,
    /// Motion of the root at the end of the next step; `None` for a root at rest.
    pub base_motion: Option<BaseMotion<D>>,
    /// Towing force on a free root at the end of the next step, N; other roots ignore it.
    pub towing: [f64; D],
    pub(crate) parameters: Parameters<D>,
    pub(crate) elastic: Elastic<D>,
    /// Nodes at rest, m: `[n + 1]`.
    pub(crate) rest: Vec<Vector<D>>,
    /// Length of rod that belongs to each node, m: `[n + 1]`.
    pub(crate) tributary: Vec<f64>,
    /// Mass of each node, kg: `[n + 1]`.
    pub(crate) masses: Vec<f64>,
    /// Masses on which gravity acts.
    pub(crate) weights: Vec<f64>,
    pub(crate) state: State<D>,
    pub(crate) statistics: Statistics,
    /// Positions and velocities, component after component: `[D, n + 1]`.
    positions: Vec<f64>,
    velocities: Vec<f64>,
    pub(crate) newton: Newton<D>,
    /// Torsion spring at the root, in the plane.
    pub(crate) hinge: Option<Hinge>,
    pub(crate) balance: Balance<D>,
    /// State before the step.
    pub(crate) before: State<D>,
    /// State before the sub-step (TR-BDF2).
    pub(crate) before_substep: State<D>,
    /// Nodal forces without damping and impedance, N: `[n + 1]`.
    pub(crate) force: Vec<Vector<D>>,
    /// Positions in Newton's method, m: `[n + 1]`.
    pub(crate) guess: Vec<Vector<D>>,
}

impl<const D: usize> Rod<D> {
    /// Build a rod at rest, without loads.
    ///
    /// # Errors
    /// A parameter outside its range is named with its value.
    pub fn new(parameters: Parameters<D>) -> Result<Self, Error> {
        const { assert!(D == 2 || D == 3, "a rod lives in 2 or 3 dimensions") };
        parameters.check()?;
        let &Parameters { length, segments, .. } = &parameters;
        let attachment = Vector::from(parameters.attachment);
        let direction = Vector::from(parameters.direction).normalize();
        let rest = parameters.rest_shape(attachment, direction);
        let nodes = segments + 1;
        let hinge = parameters.hinge();
        let mut at_rest = State::at_rest(rest.clone(), direction, hinge.map(|hinge| hinge.at_rest(0.0)));
        at_rest.pressure = vec![0.0; if parameters.strain_per_pressure > 0.0 { nodes } else { 0 }];
        let (first, slide) = (parameters.first_node(), parameters.slide.map(|slide| slide.axis));
        let shear = parameters.section.shear_stiffness.is_some();
        let mut rod = Self {
            loads: Loads::default(),
            base_motion: None,
            towing: [0.0; D],
            elastic: parameters.elastic(direction),
            tributary: parameters.tributary(),
            masses: parameters.masses(),
            weights: parameters.weights(),
            state: at_rest.clone(),
            before: at_rest.clone(),
            before_substep: at_rest,
            statistics: Statistics::default(),
            positions: vec![0.0; D * nodes],
            velocities: vec![0.0; D * nodes],
            newton: Newton::new(segments, length, attachment.amax() + length, shear, first, slide),
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

    /// Return the parameters of the rod.
    pub fn parameters(&self) -> &Parameters<D> {
        &self.parameters
    }

    /// Return component `d` of the positions of the nodes, m: `[n + 1]`.
    pub fn positions(&self, d: usize) -> &[f64] {
        &self.positions[d * self.rest.len()..][..self.rest.len()]
    }

    /// Return component `d` of the velocities of the nodes, m/s: `[n + 1]`.
    pub fn velocities(&self, d: usize) -> &[f64] {
        &self.velocities[d * self.rest.len()..][..self.rest.len()]
    }

    /// Return component `d` of the acceleration of node `k`, m/s².
    pub fn acceleration(&self, d: usize, k: usize) -> f64 {
        self.state.accelerations[k][d]
    }

    /// Return the displacement of the tip from its position at rest, m.
    pub fn tip_displacement(&self) -> [f64; D] {
        let tip = self.parameters.segments;
        (self.state.positions[tip] - self.rest[tip]).into()
    }

    /// Return the displacement of the tip of a rigid rod with the same root, m.
    pub fn rigid_tip_displacement(&self) -> [f64; D] {
        let tip = self.parameters.segments;
        let (at_rest, direction) = (Vector::from(self.parameters.direction).normalize(), self.state.direction);
        let arm = self.rest[tip] - self.rest[0];
        let mut turned = direction * arm.dot(&at_rest);
        if D == 2 {
            // The tip of a curved rod, which only the plane has, also lies to the left of the root's direction.
            let left = at_rest[0] * arm[1] - at_rest[1] * arm[0];
            (turned[0], turned[1]) = (turned[0] - left * direction[1], turned[1] + left * direction[0]);
        }
        (self.state.positions[0] + turned - self.rest[tip]).into()
    }

    /// Return the mass of each node less the mass of the fluid it displaces, kg: `[n + 1]`.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Return the power lost by the damping of the rod and of a torsion spring at the root, W.
    pub fn damping_power(&self) -> f64 {
        let squares = self.state.velocities.iter().zip(&self.tributary).map(|(v, l)| l * v.norm_squared());
        let of_rod = self.parameters.damping * squares.sum::<f64>();
        match (self.hinge, self.state.hinge) {
            (Some(hinge), Some(state)) => of_rod + hinge.damping * state.rate.powi(2),
            _ => of_rod,
        }
    }

    /// Return the angle of a torsion spring at the root, rad, and its rate, rad/s; in the plane only.
    pub fn hinge(&self) -> Option<[f64; 2]> {
        self.state.hinge.map(|hinge| [hinge.angle, hinge.rate])
    }

    /// Bring a torsion spring at the root to rest in the present shape.
    pub(crate) fn settle_hinge(&mut self) -> Result<(), Error> {
        let Some(hinge) = self.hinge else { return Ok(()) };
        let Self { elastic, state, newton, .. } = self;
        let moment = elastic.spring_moment(&state.positions, &mut newton.moments);
        self.state.hinge = Some(hinge.at_rest(moment.map_err(|shape| self.error(shape.into()))?));
        self.align_elastic();
        Ok(())
    }

    /// Copy direction, pressure and the angle of a damped spring from the state to the elastic energy.
    ///
    /// An undamped spring has no state of its own: it is in series with half a segment.
    pub(crate) fn align_elastic(&mut self) {
        self.elastic.direction = self.state.direction;
        self.elastic.set_pressure(self.parameters.strain_per_pressure, &self.state.pressure);
        if let (Some(hinge), Some(state)) = (self.hinge.filter(Hinge::is_damped), self.state.hinge) {
            self.elastic.set_spring(hinge.half_segment, state.angle, hinge.energy(state.angle));
        }
    }

    /// Return the energies of the state.
    pub fn energy(&self) -> Result<Energy, Error> {
        let elastic = self.elastic.energy(&self.state.positions).map_err(|shape| self.error(shape.into()))?;
        let gravity = Vector::from(self.parameters.gravity);
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for k in 0..self.rest.len() {
            let m = self.masses[k];
            kinetic += 0.5 * m * self.state.velocities[k].norm_squared();
            potential -= self.weights[k] * gravity.dot(&(self.state.positions[k] - self.rest[0]));
        }
        Ok(Energy { kinetic, stretching: elastic.stretching, bending: elastic.bending, gravity: potential })
    }

    /// Return the effort of the last step.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Return the state.
    pub fn state(&self) -> &State<D> {
        &self.state
    }

    /// Continue from `state`; the same loads and steps repeat the same bits.
    ///
    /// # Errors
    /// The rod refuses a state with another number of nodes, with numbers that are not finite, with a root away from
    /// its place at rest (unless it is free, driven or on a slide), without the angle of a torsion spring, or with a
    /// singular shape.
    pub fn restore(&mut self, state: &State<D>) -> Result<(), Error> {
        state.check(self.rest.len())?;
        let (direction, still) = (Vector::from(self.parameters.direction).normalize(), Vector::zeros());
        let held =
            |vector: Vector<D>| self.parameters.slide.map_or(vector, |slide| kept(vector, slide.axis, Vector::zeros()));
        for (name, found, expected, allowed) in [
            ("positions[0]", held(state.positions[0]), held(self.rest[0]), "the position of the root at rest"),
            ("velocities[0]", held(state.velocities[0]), still, "0 at a root at rest"),
            ("direction", state.direction, direction, "the direction at rest"),
            ("direction_rate", state.direction_rate, still, "0 at a root at rest"),
        ] {
            if self.base_motion.is_none() && self.parameters.support != RootSupport::Free && found != expected {
                return Err(Error::value(format!("state.{name}"), found.as_slice(), allowed));
            }
        }
        if state.hinge.is_some() != self.hinge.is_some() {
            let allowed = "present with a torsion spring at the root in the plane, and absent otherwise";
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
        self.align_elastic();
        self.statistics = Statistics::default();
        self.publish();
        Ok(())
    }

    /// Place the rod with its root in the state `motion`, at rest in its rest shape, as before a first step.
    ///
    /// The motion of the root stays prescribed.
    pub fn place(&mut self, motion: BaseMotion<D>) -> Result<(), Error> {
        let base = motion.normalised()?;
        let shape = self.parameters.rest_shape(base.position, base.direction);
        let elastic = self.parameters.elastic(base.direction);
        elastic.energy(&shape).map_err(|shape| self.error(shape.into()))?;
        self.elastic = elastic;
        let pressure = vec![0.0; self.state.pressure.len()];
        self.state = State { pressure, ..State::at_rest(shape, base.direction, self.state.hinge) };
        self.state.set_base(&base);
        self.settle_hinge()?;
        self.base_motion = Some(motion);
        self.publish();
        Ok(())
    }

    /// Copy positions and velocities into arrays of components.
    pub(crate) fn publish(&mut self) {
        let nodes = self.rest.len();
        for d in 0..D {
            for k in 0..nodes {
                self.positions[d * nodes + k] = self.state.positions[k][d];
                self.velocities[d * nodes + k] = self.state.velocities[k][d];
            }
        }
    }

    /// Return the error for a failed solve.
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

/// Rods of both dimensions. Builds with little optimization share generic functions of the crate that has them, so that
/// tests and units do not translate all of a rod again.
#[cfg(debug_assertions)]
#[used]
static TRANSLATED: (Translated<2>, Translated<3>) = (translated(), translated());

#[cfg(debug_assertions)]
type Translated<const D: usize> = (
    fn(Parameters<D>) -> Result<Rod<D>, Error>,
    fn(&mut Rod<D>, f64) -> Result<(), Error>,
    fn(&mut Rod<D>) -> Result<(), Error>,
    fn(&mut Rod<D>, BaseMotion<D>) -> Result<(), Error>,
    fn(&mut Rod<D>, &State<D>) -> Result<(), Error>,
    fn(&Rod<D>) -> Result<Energy, Error>,
);

#[cfg(debug_assertions)]
const fn translated<const D: usize>() -> Translated<D> {
    (Rod::new, Rod::step, Rod::solve_static, Rod::place, Rod::restore, Rod::energy)
}
