//! Newton's method for a stage or for equilibrium.
//!
//! The equation is the one of [`Balance`], with the elastic and viscous forces F. One factorisation serves as long as each iteration shrinks r enough;
//! it turns with the nodes (`frames`). If that fails, the matrix is made positive definite and a line search limits
//! the update: it looks for a point where r has lost its component along the update.

use structure::{Balance, Imbalance, RELATIVE_UPDATE, Residual, Statistics};

use crate::contact::Contacts;
use crate::elastic::Elastic;
use crate::frames::Frames;
use crate::geometry::Vector;
use crate::system::System;
use crate::{Error, WingError};

/// Maximum number of iterations, of which 2 … 10 are usual; beyond it smaller steps cost less.
const ITERATIONS: usize = 100;
/// Largest ratio of two residuals with the same factors; beyond it a new factorisation costs less.
const SLOW: f64 = 0.2;
/// Tolerance of the residual, relative to the largest force on a node.
const RELATIVE_RESIDUAL: f64 = 1e-9;
/// Share of the component of r along the update that a line search leaves.
const REMAINDER: f64 = 0.9;
/// Maximum number of halvings in the line search.
const BACKTRACKS: usize = 30;

/// Imbalance of a matrix without factors or of an update without a shape.
const UNSOLVED: Imbalance = Imbalance { residual: f64::INFINITY, tolerance: 0.0, rounding: 0.0 };

/// Solver with its scratch.
pub(crate) struct Newton {
    pub(crate) system: System,
    /// r, N: `[nodes]`, and of the directors, N m: `[strands]`.
    residual: Vec<Vector>,
    torques: Vec<f64>,
    /// u, m, and M u: `[nodes]`.
    moved: Vec<Vector>,
    inertia: Vec<Vector>,
    /// v, m/s: `[nodes]`.
    velocity: Vec<Vector>,
    /// Positions, m, and velocities, m/s, before a line search: `[nodes]`.
    before: Vec<Vector>,
    velocity_before: Vec<Vector>,
    /// Whether `system` holds factors.
    factorised: bool,
    /// Whether these are of a shape nearby, for which no iteration has used them.
    near: bool,
    /// Largest diagonal entry of the last matrix, N/m.
    stiffness: f64,
    /// Size of the wing, m.
    size: f64,
    /// Ends of the edges whose length limits an update.
    edges: Vec<[usize; 2]>,
    frames: Frames,
    /// Contact; `None` without.
    pub(crate) contact: Option<Contacts>,
}

impl Newton {
    pub(crate) fn new(
        system: System,
        elastic: &Elastic,
        rest: &[Vector],
        size: f64,
        contact: Option<Contacts>,
    ) -> Self {
        let zeros = || vec![Vector::zeros(); rest.len()];
        let of_faces = elastic.faces.iter().flat_map(|face| (0..3).map(|i| [face.nodes[i], face.nodes[(i + 1) % 3]]));
        let mut edges: Vec<_> = of_faces.chain(elastic.segments.iter().map(|segment| segment.nodes)).collect();
        edges.iter_mut().for_each(|ends| ends.sort_unstable());
        edges.sort_unstable();
        edges.dedup();
        Self {
            system,
            residual: zeros(),
            torques: vec![0.0; elastic.twists.strands.len()],
            moved: zeros(),
            inertia: zeros(),
            velocity: zeros(),
            before: zeros(),
            velocity_before: zeros(),
            factorised: false,
            near: false,
            stiffness: 0.0,
            size,
            edges,
            frames: Frames::new(rest, &elastic.faces),
            contact,
        }
    }

    /// Forget the factors: results must not depend on earlier steps.
    pub(crate) fn forget(&mut self) {
        (self.factorised, self.near) = (false, false);
    }

    /// Factorise the matrix of the shape `x` that moves at `v`, which the last solve for `balance` has found.
    pub(crate) fn factorise_at(
        &mut self,
        elastic: &mut Elastic,
        balance: &Balance<3>,
        x: &[Vector],
        v: &[Vector],
    ) -> Result<(), Error> {
        self.extrapolate_stresses(elastic, balance);
        self.system.assemble(elastic, x, v, balance, false)?;
        self.add_contact(elastic, balance, x, x, false);
        self.stiffness = self.system.stiffness();
        self.factorised = self.system.matrix.factorise() || self.system.factorise_shifted();
        self.near = self.factorised;
        self.frames.set(&elastic.faces, x);
        match self.factorised {
            true => Ok(()),
            false => Err(UNSOLVED.error(&Statistics::default())),
        }
    }

    /// Move `x` from its first guess to the solution near `origin`; a failure leaves `x` undefined.
    pub(crate) fn solve(
        &mut self,
        elastic: &mut Elastic,
        balance: &Balance<3>,
        origin: &[Vector],
        x: &mut [Vector],
        statistics: &mut Statistics,
    ) -> Result<(), Error> {
        elastic.set_angles(origin)?;
        let mut imbalance = match self.find_residual(elastic, balance, origin, x) {
            // The guess knows nothing of what is in the way.
            Err(WingError::Contact(contact::ContactError::Deep { .. })) => {
                let free = x.iter_mut().zip(origin).zip(&self.system.unknowns).filter(|(_, first)| first.is_some());
                free.for_each(|((x, origin), _)| *x = *origin);
                self.find_residual(elastic, balance, origin, x)?
            }
            found => found?,
        };
        let mut stale = !self.factorised;
        if stale {
            elastic.set_stresses(origin);
        }
        // Factors that do not turn keep the momentum of a free wing in each iteration.
        let rooted = self.system.positions < 3 * origin.len();
        if !stale && rooted {
            self.frames.turn(&elastic.faces, x, &mut self.system.rotations);
        }
        let mut guarded = false;
        for _ in 0..ITERATIONS {
            statistics.iterations += 1;
            if stale {
                guarded |= !self.factorise(elastic, balance, origin, x, statistics)?;
                statistics.factorisations += 1;
            }
            self.system.solve(&self.residual, &self.torques);
            // Share of the update that changes no edge by more than its own length and turns no director by 1 rad.
            let allowed = 1.0 / self.edge_change(x);
            let before = imbalance.residual;
            let whole;
            (imbalance, whole) = self.search(elastic, balance, origin, x, allowed.min(1.0), statistics)?;
            guarded |= !whole;
            let update = self.system.update[..self.system.positions].iter().fold(0.0_f64, |l, c| c.abs().max(l));
            if imbalance.is_met(allowed) || whole && update <= RELATIVE_UPDATE * self.size {
                statistics.rescues += usize::from(guarded);
                return Ok(elastic.check_angles()?);
            }
            // A first soft update to a shape nearby leaves stiff forces as large as those before; the second removes them.
            let is_first_nearby = std::mem::take(&mut self.near);
            stale = imbalance.residual > SLOW * before && !is_first_nearby;
            if stale {
                self.extrapolate_stresses(elastic, balance);
            }
        }
        Err(imbalance.error(statistics))
    }

    /// Set the stresses of the next matrix, by the last update of the shape before it.
    fn extrapolate_stresses(&self, elastic: &mut Elastic, balance: &Balance<3>) {
        let viscous = 1.0 + elastic.relaxation_time * balance.rate;
        elastic.extrapolate_stresses(&self.before, &self.velocity_before, viscous, |k| self.system.update_of(k));
    }

    /// Assemble and factorise the matrix in the shape `x`; return whether it is the tangent.
    fn factorise(
        &mut self,
        elastic: &mut Elastic,
        balance: &Balance<3>,
        origin: &[Vector],
        x: &[Vector],
        statistics: &Statistics,
    ) -> Result<bool, Error> {
        // Compression, of a guess or before a wing buckles, makes a tangent without a minimum.
        for safe in [false, true] {
            self.system.assemble(elastic, x, &self.velocity, balance, safe)?;
            self.add_contact(elastic, balance, origin, x, safe);
            self.stiffness = self.system.stiffness();
            self.factorised = if safe { self.system.factorise_shifted() } else { self.system.matrix.factorise() };
            if self.factorised {
                self.frames.set(&elastic.faces, x);
                return Ok(!safe);
            }
        }
        Err(UNSOLVED.error(statistics))
    }

    /// Find the forces of contact in the shape `x` at rest.
    pub(crate) fn touch_at_rest(&mut self, elastic: &Elastic, x: &[Vector]) -> Result<(), WingError> {
        let Some(contact) = &mut self.contact else { return Ok(()) };
        contact.begin_static(&elastic.faces, x)?;
        contact.find_forces(elastic, x, x)
    }

    /// Add what contact in the shape `x` of a stage from `origin` adds to the matrix.
    fn add_contact(&mut self, elastic: &Elastic, balance: &Balance<3>, origin: &[Vector], x: &[Vector], safe: bool) {
        let Self { system, contact: Some(contact), .. } = self else { return };
        contact.hessian(&elastic.faces, x, origin, safe, |spot, hessian| {
            system.add_to_triangle(spot.triangle, spot.shares, hessian * balance.elastic);
        });
    }

    /// Write r in the shape `x` to `residual`.
    fn find_residual(
        &mut self,
        elastic: &mut Elastic,
        balance: &Balance<3>,
        origin: &[Vector],
        x: &[Vector],
    ) -> Result<Imbalance, WingError> {
        let Self { system, residual, torques, moved, inertia, velocity, contact, .. } = self;
        if let Some(contact) = contact {
            contact.find_forces(elastic, x, origin)?;
        }
        for (k, first) in system.unknowns.iter().enumerate() {
            moved[k] = if first.is_some() { x[k] - origin[k] } else { Vector::zeros() };
            velocity[k] = moved[k] * balance.rate + balance.velocity[k];
        }
        elastic.twists.set_spins(balance.rate);
        elastic.mass_times(moved, inertia);
        elastic.gradient(x, velocity, residual)?;
        let mut measure = Residual::default();
        for (k, r) in residual.iter_mut().enumerate() {
            if system.unknowns[k].is_none() {
                continue;
            }
            let mut of_node = balance.load[k] - inertia[k] * balance.mass - balance.d_times(k, &moved[k]);
            if let Some(contact) = contact {
                of_node += contact.forces[k] * balance.elastic;
            }
            *r = of_node - *r * balance.elastic;
            measure.add(*r, of_node, balance.load[k]);
        }
        for (k, (torque, strand)) in torques.iter_mut().zip(&elastic.twists.strands).enumerate() {
            *torque = if strand.rigid { 0.0 } else { -elastic.twists.torques[k] * balance.elastic };
            measure.add(Vector::repeat(*torque / strand.length), Vector::zeros(), Vector::zeros());
        }
        let extent = x.iter().fold(self.size, |largest, x| largest.max(x.amax()));
        Ok(measure.imbalance(RELATIVE_RESIDUAL, extent, self.stiffness))
    }

    /// Return the largest change of an edge by the update, relative to its length, or turn of a director, rad.
    fn edge_change(&self, x: &[Vector]) -> f64 {
        let (mut largest, mut sum) = (0.0_f64, 0.0);
        for &[a, b] in &self.edges {
            let change = (self.system.update_of(b) - self.system.update_of(a)).norm_squared();
            let length = (x[b] - x[a]).norm_squared();
            largest = largest.max(change / length);
            sum += change;
        }
        for k in 0..self.torques.len() {
            let turn = self.system.turn_of(k).powi(2);
            (largest, sum) = (largest.max(turn), sum + turn);
        }
        // `max` skips NaN, a sum does not.
        if sum.is_nan() { f64::INFINITY } else { largest.sqrt() }
    }

    /// Add the share of the update, at most `share`, after which r has lost enough of its component along the update.
    fn search(
        &mut self,
        elastic: &mut Elastic,
        balance: &Balance<3>,
        origin: &[Vector],
        x: &mut [Vector],
        mut share: f64,
        statistics: &Statistics,
    ) -> Result<(Imbalance, bool), Error> {
        self.before.copy_from_slice(x);
        self.velocity_before.copy_from_slice(&self.velocity);
        let along = |newton: &Self| -> f64 {
            let turns = newton.torques.iter().enumerate().map(|(k, torque)| torque * newton.system.turn_of(k));
            let moves = newton.residual.iter().enumerate().map(|(k, r)| r.dot(&newton.system.update_of(k)));
            moves.chain(turns).sum()
        };
        elastic.twists.mark();
        let first = along(self);
        let mut last = UNSOLVED.error(statistics);
        for _ in 0..BACKTRACKS {
            for (k, x) in x.iter_mut().enumerate() {
                *x = self.before[k] + self.system.update_of(k) * share;
            }
            elastic.twists.back_to_mark();
            elastic.twists.turn(share, |k| self.system.turn_of(k));
            elastic.forget_shape();
            match self.find_residual(elastic, balance, origin, x) {
                // A component that stays positive means that the minimum lies further on.
                Ok(imbalance) if along(self) >= -REMAINDER * first => return Ok((imbalance, share == 1.0)),
                Ok(imbalance) => last = imbalance.error(statistics),
                Err(shape) => last = shape.into(),
            }
            share *= 0.5;
        }
        Err(last)
    }
}
