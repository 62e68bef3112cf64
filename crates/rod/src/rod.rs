//! The rod: parameters, state, loads and results.

use structure::{Core, Loads, Statistics, Structure, Vector, first_weight};

use crate::Error;
use crate::base_motion::{BaseMotion, BaseState};
use crate::contact::Contacts;
use crate::elastic::Elastic;
use crate::hinge::Hinge;
use crate::memory::{RodMemory, RodState};
use crate::model::RootSupport;
use crate::newton::{Newton, kept};
use crate::parameters::Parameters;
use ::contact::Pose;

/// Energies, J (per metre of depth in two dimensions).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Kinetic energy of the rod without displaced fluid.
    pub kinetic: f64,
    /// Energy of extension.
    pub stretching: f64,
    /// Energy of bending and shear.
    pub bending: f64,
    /// Energy of contact.
    pub contact: f64,
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
    pub(crate) core: Core<D, RodMemory<D>>,
    pub(crate) elastic: Elastic<D>,
    /// Length of rod that belongs to each node, m: `[n + 1]`.
    pub(crate) tributary: Vec<f64>,
    /// Mass of each node, kg: `[n + 1]`.
    pub(crate) masses: Vec<f64>,
    /// Masses on which gravity acts.
    weights: Vec<f64>,
    pub(crate) newton: Newton<D>,
    /// Torsion spring at the root, in the plane.
    pub(crate) hinge: Option<Hinge>,
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
        let is_held = parameters.support != RootSupport::Free;
        let contact = parameters.contact.clone();
        let contact = contact.map(|own| Contacts::new(own, &rest, parameters.segment_length(), is_held));
        let hinge = parameters.hinge();
        let pressure = vec![0.0; if parameters.strain_per_pressure > 0.0 { segments + 1 } else { 0 }];
        let own = RodMemory::at_rest(direction, pressure, hinge.map(|hinge| hinge.at_rest(0.0)));
        let (first, slide) = (parameters.first_node(), parameters.slide.map(|slide| slide.axis));
        let shear = parameters.section.shear_stiffness.is_some();
        let weights = parameters.weights();
        let gravity = Vector::from(parameters.gravity);
        let masses = parameters.masses();
        let mut core = Core::new(
            RodState::at_rest(rest, own),
            (0..=segments).map(|k| k < first).collect(),
            weights.iter().map(|weight| gravity * *weight).collect(),
            parameters.scheme,
            parameters.max_step,
        );
        let parts = masses.iter().zip(&weights).map(|(own, whole)| first_weight(*own, whole - own));
        core.first_weights = parts.collect();
        let mut rod = Self {
            loads: Loads::default(),
            base_motion: None,
            towing: [0.0; D],
            core,
            elastic: parameters.elastic(direction),
            tributary: parameters.tributary(),
            masses,
            weights,
            newton: Newton::new(segments, length, attachment.amax() + length, shear, first, slide)
                .with_contact(contact),
            hinge,
            parameters,
        };
        rod.elastic.energy(&rod.core.rest)?;
        rod.newton.contact.as_mut().map_or(Ok(()), |contact| contact.check_depth(&rod.core.rest))?;
        rod.settle_hinge()?;
        Ok(rod)
    }

    /// Return the parameters of the rod.
    pub fn parameters(&self) -> &Parameters<D> {
        &self.parameters
    }

    /// Return component `d` of the positions of the nodes, m: `[n + 1]`.
    pub fn positions(&self, d: usize) -> &[f64] {
        self.core.positions(d)
    }

    /// Return component `d` of the velocities of the nodes, m/s: `[n + 1]`.
    pub fn velocities(&self, d: usize) -> &[f64] {
        self.core.velocities(d)
    }

    /// Return component `d` of the acceleration of node `k`, m/s².
    pub fn acceleration(&self, d: usize, k: usize) -> f64 {
        self.core.state.accelerations[k][d]
    }

    /// Return the displacement of the tip from its position at rest, m.
    pub fn tip_displacement(&self) -> [f64; D] {
        let tip = self.parameters.segments;
        (self.core.state.positions[tip] - self.core.rest[tip]).into()
    }

    /// Return the displacement of the tip of a rigid rod with the same root, m.
    pub fn rigid_tip_displacement(&self) -> [f64; D] {
        let tip = self.parameters.segments;
        let (at_rest, direction) = (Vector::from(self.parameters.direction).normalize(), self.core.state.own.direction);
        let arm = self.core.rest[tip] - self.core.rest[0];
        let mut turned = direction * arm.dot(&at_rest);
        if D == 2 {
            // The tip of a curved rod, which only the plane has, also lies to the left of the root's direction.
            let left = at_rest[0] * arm[1] - at_rest[1] * arm[0];
            (turned[0], turned[1]) = (turned[0] - left * direction[1], turned[1] + left * direction[0]);
        }
        (self.core.state.positions[0] + turned - self.core.rest[tip]).into()
    }

    /// Return the mass of each node less the mass of the fluid it displaces, kg: `[n + 1]`.
    pub fn masses(&self) -> &[f64] {
        &self.masses
    }

    /// Return the power lost by the damping of the rod and of a torsion spring at the root, W.
    pub fn damping_power(&self) -> f64 {
        let squares = self.core.state.velocities.iter().zip(&self.tributary).map(|(v, l)| l * v.norm_squared());
        let of_rod = self.parameters.damping * squares.sum::<f64>();
        match (self.hinge, self.core.state.own.hinge) {
            (Some(hinge), Some(state)) => of_rod + hinge.damping * state.v.powi(2),
            _ => of_rod,
        }
    }

    /// Return the angle of a torsion spring at the root, rad, and its rate, rad/s; in the plane only.
    pub fn hinge(&self) -> Option<[f64; 2]> {
        self.core.state.own.hinge.map(|hinge| [hinge.x, hinge.v])
    }

    /// Bring a torsion spring at the root to rest in the present shape.
    fn settle_hinge(&mut self) -> Result<(), Error> {
        let Some(hinge) = self.hinge else { return Ok(()) };
        let moment = self.elastic.spring_moment(&self.core.state.positions, &mut self.newton.moments)?;
        self.core.state.own.hinge = Some(hinge.at_rest(moment));
        self.align();
        Ok(())
    }

    /// Bring the rod to rest in the shape `positions`, with its root in the state `base`.
    pub(crate) fn place_at_rest(&mut self, base: BaseState<D>, positions: Vec<Vector<D>>) -> Result<(), Error> {
        let RodMemory { pressure, hinge, .. } = self.core.state.own.clone();
        self.core.state = RodState::at_rest(positions, RodMemory::at_rest(base.direction, pressure, hinge));
        base.copy_to(&mut self.core.state);
        self.settle_hinge()?;
        self.core.publish();
        Ok(())
    }

    /// Return the energies of the state.
    pub fn energy(&self) -> Result<Energy, Error> {
        let elastic = self.elastic.energy(&self.core.state.positions)?;
        let gravity = Vector::from(self.parameters.gravity);
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for k in 0..self.core.rest.len() {
            let m = self.masses[k];
            kinetic += 0.5 * m * self.core.state.velocities[k].norm_squared();
            potential -= self.weights[k] * gravity.dot(&(self.core.state.positions[k] - self.core.rest[0]));
        }
        let contact = self.newton.contact.as_ref().map_or(0.0, |contact| contact.energy(&self.core.state.positions));
        Ok(Energy { kinetic, contact, stretching: elastic.stretching, bending: elastic.bending, gravity: potential })
    }

    /// Prescribe the places of obstacle `i` at the begin and the end of the next step; it then stays.
    pub fn move_obstacle(&mut self, i: usize, places: [Pose<D>; 2]) {
        if let Some(place) = self.newton.contact.as_mut().and_then(|contact| contact.obstacles.motion_mut(i)) {
            *place = places;
        }
    }

    /// Return the forces of contact on the nodes, N: `[n + 1]`; empty without contact.
    pub fn contact_forces(&self) -> &[Vector<D>] {
        &self.newton.touch
    }

    /// Return the effort of the last step.
    pub fn statistics(&self) -> Statistics {
        self.core.statistics
    }

    /// Return the state.
    pub fn state(&self) -> &RodState<D> {
        &self.core.state
    }

    /// Continue from `state`; the same loads and steps repeat the same bits.
    ///
    /// # Errors
    /// The rod refuses a state with another number of nodes, with numbers that are not finite, with a root away from
    /// its place at rest (unless it is free, driven or on a slide), without the angle of a torsion spring, or with a
    /// singular shape.
    pub fn restore(&mut self, state: &RodState<D>) -> Result<(), Error> {
        state.check(self.core.rest.len())?;
        state.own.check()?;
        let (direction, still) = (Vector::from(self.parameters.direction).normalize(), Vector::zeros());
        let held =
            |vector: Vector<D>| self.parameters.slide.map_or(vector, |slide| kept(vector, slide.axis, Vector::zeros()));
        for (name, found, expected, allowed) in [
            ("positions[0]", held(state.positions[0]), held(self.core.rest[0]), "the position of the root at rest"),
            ("velocities[0]", held(state.velocities[0]), still, "0 at a root at rest"),
            ("direction", state.own.direction, direction, "the direction at rest"),
            ("direction_rate", state.own.direction_rate, still, "0 at a root at rest"),
        ] {
            if self.base_motion.is_none() && self.parameters.support != RootSupport::Free && found != expected {
                return Err(Error::value(format!("state.{name}"), found.as_slice(), allowed));
            }
        }
        if state.own.hinge.is_some() != self.hinge.is_some() {
            let allowed = "present with a torsion spring at the root in the plane, and absent otherwise";
            return Err(Error::value("state.hinge", format!("{:?}", state.own.hinge), allowed));
        }
        Error::check_length("state.pressure", state.own.pressure.len(), self.core.state.own.pressure.len())?;
        self.elastic.direction = state.own.direction;
        let shape = self.elastic.energy(&state.positions);
        if shape.is_ok() {
            self.core.restore(state);
        }
        self.align();
        shape?;
        Ok(())
    }

    /// Let all nodes move with the root as a rigid body.
    fn move_rigidly(&mut self, base: &BaseState<D>) {
        let omega = structure::cross(&base.direction, &base.direction_rate);
        let state = &mut self.core.state;
        for k in 0..state.positions.len() {
            let arm = state.positions[k] - base.position;
            let arm = |i: usize| if i % 3 < D { arm[i % 3] } else { 0.0 };
            let swing = Vector::from_fn(|i, _| omega[(i + 1) % 3] * arm(i + 2) - omega[(i + 2) % 3] * arm(i + 1));
            (state.velocities[k], state.previous_velocities[k]) = (base.velocity + swing, base.velocity + swing);
        }
        self.core.publish();
    }

    /// Place the rod in its rest shape with its root in the state `motion`, as before a first step.
    ///
    /// The motion of the root stays prescribed, and the rod moves with it as a rigid body, at a pinned root without its
    /// turn.
    pub fn place(&mut self, motion: BaseMotion<D>) -> Result<(), Error> {
        let base = motion.normalised()?;
        let shape = self.parameters.rest_shape(base.position, base.direction);
        let elastic = self.parameters.elastic(base.direction);
        elastic.energy(&shape)?;
        self.elastic = elastic;
        self.core.state.own.pressure.fill(0.0);
        self.place_at_rest(base, shape)?;
        self.base_motion = Some(motion);
        let is_turned = self.parameters.support != RootSupport::Pinned;
        self.move_rigidly(&if is_turned { base } else { BaseState { direction_rate: Vector::zeros(), ..base } });
        Ok(())
    }
}
