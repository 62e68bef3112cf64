//! The wing: parameters, state, loads and results.

use ::contact::Pose;
use ::geometry::Crossings;
use mesh::Layer;
use structure::{Core, Loads, Statistics, Structure, first_weight};

use crate::Error;
use crate::base::{Memory, RigidMotion, WingState};
use crate::contact::Contacts;
use crate::elastic::Elastic;
use crate::energy::{Energy, EnergyBefore};
use crate::geometry::{Geometry, Vector};
use crate::newton::Newton;
use crate::parameters::Parameters;
use crate::section::Section;
use crate::system::System;
use crate::trial::Trial;

/// Least mass of the membrane without the displaced fluid, by its own: the mass matrix stays positive definite.
const LEAST_MASS: f64 = 1e-3;

/// Wing with its parameters, state and loads; [`Wing::step`] allocates nothing.
pub struct Wing {
    /// Loads of the next step.
    pub loads: Loads,
    /// Pose of the base at the end of the next step; `None` for a base at rest, and for a free wing.
    pub base_motion: Option<RigidMotion>,
    pub(crate) parameters: Parameters,
    pub(crate) core: Core<3, Memory>,
    pub(crate) elastic: Elastic,
    /// Sum of the rows of the mass matrix with the displaced fluid, kg: `[nodes]`.
    pub(crate) masses: Vec<f64>,
    pub(crate) layer: Layer,
    pub(crate) newton: Newton,
    pub(crate) trial: Trial,
    crossings: Crossings,
    section: Option<Section>,
    /// Energy before a sub-step; `None` where a drive does work.
    pub(crate) energy_before: Option<EnergyBefore>,
}

impl Parameters {
    /// Return the wing of these parameters; see [`Wing::new`].
    pub fn build(self) -> Result<Wing, Error> {
        Wing::new(self)
    }
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
        let system = System::new(&elastic, &held, &rest)?;
        let middle = rest.iter().sum::<Vector>() / nodes as f64;
        let size = rest.iter().fold(0.0_f64, |size, x| size.max((x - middle).norm()));
        let (ones, mut product) = (vec![Vector::repeat(1.0); nodes], vec![Vector::zeros(); nodes]);
        elastic.mass_times(&ones, &mut product);
        let masses: Vec<_> = product.iter().map(|mass| mass.x).collect();
        let faces = elastic.faces.iter().map(|face| (face.nodes, face.area * parameters.displaced_density));
        let layer = Layer::new(nodes, faces);
        for (t, face) in elastic.faces.iter_mut().enumerate() {
            let own = parameters.membrane(t).areal_density;
            face.mass -= face.area * parameters.displaced_density.min((1.0 - LEAST_MASS) * own);
        }
        let gravity = Vector::from(parameters.gravity);
        let contact = parameters.contact.as_ref().map(|own| Contacts::new(own, &parameters));
        let newton = Newton::new(system, &elastic, &rest, size, contact);
        let mut core = Core::new(
            WingState::at_rest(rest, Memory { base: RigidMotion::rest(), twists: elastic.twists.at_rest() }),
            held,
            masses.iter().map(|mass| gravity * *mass).collect(),
            parameters.scheme,
            parameters.max_step,
        );
        if parameters.displaced_density > 0.0 {
            elastic.mass_times(&ones, &mut product);
            let mut moving = vec![0.0; nodes];
            for face in &elastic.faces {
                face.nodes.iter().for_each(|&k| moving[k] += face.area * parameters.displaced_density / 3.0);
            }
            core.first_weights =
                product.iter().zip(&moving).map(|(own, &moving)| first_weight(own.x, moving)).collect();
        }
        (core.across, core.balance.across) = (vec![Vector::zeros(); nodes], vec![Vector::zeros(); nodes]);
        Ok(Self {
            loads: Loads::default(),
            base_motion: None,
            crossings: Crossings::new(elastic.faces.len()),
            section: Section::new(&parameters.mesh, &parameters.root.nodes),
            newton,
            trial: Trial::none(&core),
            energy_before: None,
            core,
            masses,
            layer,
            elastic,
            parameters,
        })
    }

    /// Return the parameters.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Return the number of nodes.
    pub fn nodes(&self) -> usize {
        self.core.rest.len()
    }

    /// Return component `d` of the positions of the nodes, m: `[nodes]`.
    pub fn positions(&self, d: usize) -> &[f64] {
        self.core.positions(d)
    }

    /// Return component `d` of the velocities of the nodes, m/s: `[nodes]`.
    pub fn velocities(&self, d: usize) -> &[f64] {
        self.core.velocities(d)
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

    /// Return first entries of the columns, rows and values of the lower triangle of Newton's last matrix, in the order of
    /// its factor; for measurements.
    #[doc(hidden)]
    pub fn matrix(&self) -> (&[usize], &[usize], &[f64]) {
        self.newton.system.matrix.lower()
    }

    /// Return the energies of the state.
    pub fn energy(&mut self) -> Result<Energy, Error> {
        let Self { elastic, core, parameters, masses, newton, .. } = self;
        let Core { state, rest, product, .. } = core;
        let mut energy = elastic.energy(&state.positions)?;
        if let Some(contact) = &mut newton.contact {
            energy.contact = contact.energy(&elastic.faces, &state.positions)?;
        }
        elastic.mass_times(&state.velocities, product);
        energy.kinetic = 0.5 * product.iter().zip(&state.velocities).map(|(p, v)| p.dot(v)).sum::<f64>();
        let gravity = Vector::from(parameters.gravity);
        let moved = state.positions.iter().zip(&*rest).zip(&*masses);
        energy.gravity = -moved.map(|((x, rest), mass)| *mass * gravity.dot(&(x - rest))).sum::<f64>();
        Ok(energy)
    }

    /// Return momentum, kg m/s, and angular momentum about the origin of coordinates, kg m²/s.
    pub fn momentum(&mut self) -> [[f64; 3]; 2] {
        let Self { elastic, core, .. } = self;
        let Core { state, product, .. } = core;
        elastic.mass_times(&state.velocities, product);
        let angular: Vector = product.iter().zip(&state.positions).map(|(p, x)| x.cross(p)).sum();
        [product.iter().sum::<Vector>().into(), angular.into()]
    }

    /// Return the power lost by damping, W.
    pub fn damping_power(&mut self) -> Result<f64, Error> {
        let Self { elastic, core, .. } = self;
        let Core { state, product, acceleration, .. } = core;
        elastic.gradient(&state.positions, &state.velocities, product)?;
        let whole: f64 = product.iter().zip(&state.velocities).map(|(f, v)| f.dot(v)).sum();
        product.fill(Vector::zeros());
        let tau = std::mem::replace(&mut elastic.relaxation_time, 0.0);
        let undamped = elastic.gradient(&state.positions, &state.velocities, acceleration);
        elastic.relaxation_time = tau;
        undamped?;
        Ok(whole - acceleration.iter().zip(&state.velocities).map(|(f, v)| f.dot(v)).sum::<f64>())
    }

    /// Return the elastic force on each node in the shape `x` at rest, N: minus the gradient of the energy. Veins
    /// with torsion keep their twist.
    pub fn elastic_forces(&mut self, x: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Error> {
        Error::check_length("x", x.len(), self.nodes())?;
        let x: Vec<_> = x.iter().map(|x| Vector::from(*x)).collect();
        let still = vec![Vector::zeros(); x.len()];
        let found = self.elastic.gradient(&x, &still, &mut self.core.product);
        self.align();
        found?;
        Ok(self.core.product.iter().map(|force| (-force).into()).collect())
    }

    /// Prescribe the places of obstacle `i` at the begin and the end of the next step; it then stays.
    pub fn move_obstacle(&mut self, i: usize, places: [Pose<3>; 2]) {
        if let Some(place) = self.newton.contact.as_mut().and_then(|contact| contact.detection.obstacles.motion_mut(i))
        {
            *place = places;
        }
    }

    /// Return the forces of contact on the nodes, N: `[nodes]`; empty without contact.
    pub fn contact_forces(&self) -> &[Vector] {
        self.newton.contact.as_ref().map_or(&[], |contact| &contact.forces)
    }

    /// Return the number of pairs of triangles that cross each other: without contact nothing holds the parts apart.
    pub fn crossings(&mut self) -> usize {
        let (faces, x) = (&self.elastic.faces, &self.core.state.positions);
        self.crossings.count(|k| faces[k].nodes, |node| x[node].into())
    }

    /// Return the turn of the chord at three quarters of the span about the span, rad, from its direction on the base
    /// at rest; `None` for a wing without a line of the root or without triangles.
    pub fn twist(&self) -> Option<f64> {
        self.section
            .as_ref()
            .map(|section| section.twist(&self.core.state.positions, &self.core.state.own.base.matrix()))
    }

    /// Return the largest distance of the membrane from that chord, by its length, positive on the side of the normals
    /// of the triangles; `None` as the twist.
    pub fn camber(&self) -> Option<f64> {
        self.section
            .as_ref()
            .map(|section| section.camber(&self.core.state.positions, &self.core.state.own.base.matrix()))
    }

    /// Return the effort of the last step.
    pub fn statistics(&self) -> Statistics {
        self.core.statistics
    }

    /// Return the state.
    pub fn state(&self) -> &WingState {
        &self.core.state
    }

    /// Continue from `state`; the same loads and steps repeat the same bits.
    ///
    /// # Errors
    /// The wing refuses a state with another number of nodes, with numbers that are not finite or with a folded shape.
    pub fn restore(&mut self, state: &WingState) -> Result<(), Error> {
        state.check(self.nodes())?;
        state.own.base.check()?;
        self.elastic.twists.check(&state.own.twists, &state.positions)?;
        self.forget();
        self.elastic.support = state.own.base.matrix();
        self.elastic.twists.set(&state.own.twists, &state.positions);
        self.elastic.forget_shape();
        let shape = self.elastic.energy(&state.positions);
        if shape.is_ok() {
            self.core.restore(state);
        }
        self.align();
        shape?;
        Ok(())
    }

    /// Place the wing with its base in the state `motion`, in its rest shape, moving as a rigid body.
    pub fn place(&mut self, motion: RigidMotion) -> Result<(), Error> {
        motion.check()?;
        let origin = Vector::from(self.parameters.root.origin);
        let placement = motion.towards(&motion, 1.0, 1.0);
        let (rotation, omega) = (motion.matrix(), Vector::from(motion.angular_velocity));
        let twists = self.elastic.twists.placed(&self.core.rest, &rotation, &omega);
        let mut state = WingState::at_rest(self.core.rest.clone(), Memory { base: motion, twists });
        for (k, rest) in self.core.rest.iter().enumerate() {
            let [x, v, _] = placement.node(origin, rest - origin);
            (state.positions[k], state.velocities[k]) = (x, v);
            (state.previous_positions[k], state.previous_velocities[k]) = (x, v);
            state.accelerations[k] =
                Vector::from(motion.angular_velocity).cross(&(placement.rotation[1] * (rest - origin)));
        }
        self.forget();
        self.core.state = state;
        self.base_motion = Some(motion);
        self.align();
        self.core.publish();
        Ok(())
    }

    /// Set the velocities of the free nodes, m/s, before a first step.
    pub fn set_velocities(&mut self, velocities: &[[f64; 3]]) -> Result<(), Error> {
        Error::check_length("velocities", velocities.len(), self.nodes())?;
        for (k, v) in velocities.iter().enumerate() {
            structure::finite(&format!("velocities[{k}]"), v)?;
        }
        self.forget();
        let Core { state, held, .. } = &mut self.core;
        for (k, v) in velocities.iter().enumerate().filter(|(k, _)| !held[*k]) {
            (state.velocities[k], state.previous_velocities[k]) = (Vector::from(*v), Vector::from(*v));
        }
        state.last_step = 0.0;
        self.core.publish();
        Ok(())
    }
}
