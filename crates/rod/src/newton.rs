//! Newton's method for a stage or for equilibrium.
//!
//! With lumped masses the equation of [`Balance`] is the minimum of an incremental potential of u = x − x_0,
//!
//! ```text
//! Π(u) = Σ_k (½ d_k |u_k|² − b_k · u_k) + s U(x_0 + u),      d u − b + s ∇U = 0,
//! ```
//!
//! whose Hessian couples each node to two nodes on either side. Plain Newton comes first. If it does not converge, a
//! shift of the diagonal makes all pivots positive, and Armijo's rule on Π limits the length of the update (Nocedal &
//! Wright 2006, *Numerical Optimization*, 2nd ed., sections 3.1 and 3.4).

use structure::{Balance, Imbalance, RELATIVE_UPDATE, Residual, Statistics, Vector};

use crate::banded::{Banded, Singular};
use crate::contact::Contacts;
use crate::elastic::Elastic;
use crate::{BadShape, Error};

/// Maximum number of plain iterations: 1 … 4 are usual, about ten occur in a long step of a very stiff rod.
const PLAIN_ITERATIONS: usize = 15;
/// Maximum number of guarded iterations, each of which lowers Π; beyond it smaller steps cost less.
const GUARDED_ITERATIONS: usize = 100;
/// Tolerance of the residual, relative to the largest force in the rod.
const RELATIVE_RESIDUAL: f64 = 1e-10;
/// Share of the predicted decrease of Π in Armijo's rule.
const ARMIJO: f64 = 1e-4;
/// Rounding of Π, relative to its terms.
const POTENTIAL_ROUNDING: f64 = 1e-14;
/// First shift, relative to the largest diagonal entry.
const SMALLEST_SHIFT: f64 = 1e-8;
/// Largest shift, relative to the largest diagonal entry: above Gershgorin's bound of a row.
const LARGEST_SHIFT: f64 = 1e2;
/// Maximum number of halvings in the line search.
const BACKTRACKS: usize = 40;

/// Problem: minimise Π over u = x − origin, with node 0 held unless it is free.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a, const D: usize> {
    pub(crate) elastic: &'a Elastic<D>,
    pub(crate) balance: &'a Balance<D>,
    /// x_0, m: `[n + 1]`.
    pub(crate) origin: &'a [Vector<D>],
}

/// Kind of update.
#[derive(Clone, Copy)]
enum Update {
    /// Full update.
    Plain,
    /// Update with a shifted diagonal and a line search.
    Guarded,
}

/// Solver with its scratch.
pub(crate) struct Newton<const D: usize> {
    /// ∇∇Π by the positions, node after node; with shear the moment of the vertex before a node precedes its position.
    pub(crate) matrix: Banded,
    /// Bending moments with shear, N m: `[n]`; empty without shear.
    pub(crate) moments: Vec<f64>,
    /// Right-hand side with a 0 for each moment, then the solution: `[n (D + 1)]`; empty without shear.
    mixed: Vec<f64>,
    /// Largest diagonal entry of the last matrix, N/m.
    stiffness: f64,
    /// −∇Π of the free nodes, N: `[n D]`.
    descent: Vec<f64>,
    /// Update of the free nodes, m: `[n D]`.
    update: Vec<f64>,
    /// First guess, then the positions before a line search, m: `[n + 1]`.
    before: Vec<Vector<D>>,
    /// Length of the rod, m.
    length: f64,
    /// Largest expected coordinate, m.
    pub(crate) extent: f64,
    /// First node that moves freely: 1, or 0 with a free or sliding root.
    first: usize,
    /// Contact; `None` without.
    pub(crate) contact: Option<Contacts<D>>,
    /// Forces of the contact, N: `[n + 1]`; empty without.
    pub(crate) touch: Vec<Vector<D>>,
    /// Only component in which node 0 moves freely, with a sliding root.
    slide: Option<usize>,
}

impl<const D: usize> Newton<D> {
    /// Return the solver of a rod of `segments` and `length` (m), with coordinates up to `extent` (m).
    ///
    /// The nodes from `first` on move freely; `shear` adds a moment per segment to the unknowns.
    pub(crate) fn new(
        segments: usize,
        length: f64,
        extent: f64,
        shear: bool,
        first: usize,
        slide: Option<usize>,
    ) -> Self {
        let (order, half_bandwidth) = if shear { (D + 1, 3 * D + 1) } else { (D, 3 * D - 1) };
        let (moments, nodes) = (if shear { segments } else { 0 }, segments + 1 - first);
        Self {
            matrix: Banded::zeros(nodes * order, half_bandwidth),
            moments: vec![0.0; moments],
            mixed: vec![0.0; if shear { nodes * order } else { 0 }],
            stiffness: 0.0,
            descent: vec![0.0; nodes * D],
            update: vec![0.0; nodes * D],
            before: vec![Vector::zeros(); segments + 1],
            length,
            extent,
            first,
            contact: None,
            touch: Vec::new(),
            slide,
        }
    }

    /// Add a contact.
    pub(crate) fn with_contact(self, contact: Option<Contacts<D>>) -> Self {
        let touch = if contact.is_some() { vec![Vector::zeros(); self.before.len()] } else { Vec::new() };
        Self { contact, touch, ..self }
    }

    /// Move `x` from its first guess to the minimum of Π; a failure leaves `x` undefined.
    pub(crate) fn solve(
        &mut self,
        problem: Problem<D>,
        x: &mut [Vector<D>],
        statistics: &mut Statistics,
    ) -> Result<(), Error> {
        self.before.copy_from_slice(x);
        let Err(plain) = self.iterate(problem, x, statistics, Update::Plain) else { return Ok(()) };
        statistics.rescues += 1;
        x.copy_from_slice(&self.before);
        // After a long step the guess bends sharply beside the clamp; the origin may then be nearer.
        let of_guess = self.potential(problem, x).map_or(f64::INFINITY, |(of_x, _)| of_x);
        x[self.first..].copy_from_slice(&problem.origin[self.first..]);
        if let Some(axis) = self.slide {
            x[0] = kept(self.before[0], axis, x[0]);
        }
        if of_guess <= self.potential(problem, x).map_or(f64::INFINITY, |(of_x, _)| of_x) {
            x.copy_from_slice(&self.before);
        }
        // The line search stops in front of the bad shape that the plain method met.
        self.iterate(problem, x, statistics, Update::Guarded).map_err(|guarded| match plain {
            Error::Structure(_) => plain,
            _ => guarded,
        })
    }

    /// Factorise ∇∇Π at `x`.
    pub(crate) fn factorise_at(&mut self, problem: Problem<D>, x: &[Vector<D>]) -> Result<(), Error> {
        self.assemble(problem, x)?;
        match self.factorise() {
            Ok(_) => Ok(()),
            Err(Singular) => Err(self.failure(problem, x, &Statistics::default())),
        }
    }

    /// Replace the forces on the free nodes, N, by the displacements under them, m, after [`Self::factorise_at`].
    pub(crate) fn displace(&mut self, forces: &mut [Vector<D>]) {
        let free = &mut forces[self.first..];
        for (update, force) in self.update.chunks_exact_mut(D).zip(&*free) {
            update.copy_from_slice(force.as_slice());
        }
        self.solve_factorised();
        for (update, force) in self.update.chunks_exact(D).zip(free) {
            force.copy_from_slice(update);
        }
    }

    fn iterate(
        &mut self,
        problem: Problem<D>,
        x: &mut [Vector<D>],
        statistics: &mut Statistics,
        kind: Update,
    ) -> Result<(), Error> {
        let limit = match kind {
            Update::Plain => PLAIN_ITERATIONS,
            Update::Guarded => GUARDED_ITERATIONS,
        };
        let (mut shift, mut allowed) = (0.0, 0.0);
        for iteration in 0.. {
            // The first guess always gets one update, or the tolerance would hide a small load.
            if iteration > 0 {
                let imbalance = self.find_descent(problem, x)?;
                if imbalance.is_met(allowed) {
                    break;
                }
                if iteration == limit {
                    return Err(imbalance.error(statistics));
                }
            }
            statistics.iterations += 1;
            statistics.factorisations += 1;
            self.assemble(problem, x)?;
            match (self.factorise(), kind) {
                (Ok(0), _) => shift = 0.0,
                (Ok(negative_pivots), Update::Plain) => {
                    statistics.negative_pivots = statistics.negative_pivots.max(negative_pivots);
                }
                (Err(Singular), Update::Plain) => return Err(self.failure(problem, x, statistics)),
                (_, Update::Guarded) => {
                    let Some(found) = self.factorise_shifted(problem, x, 0.1 * shift) else {
                        return Err(self.failure(problem, x, statistics));
                    };
                    shift = found;
                }
            }
            self.update.copy_from_slice(&self.descent);
            self.solve_factorised();
            // Share of the update that changes no edge by more than its own length.
            allowed = problem.elastic.segment_length / self.edge_change();
            let taken = match kind {
                Update::Plain if allowed > 1.0 => {
                    self.add_update(x, 1.0);
                    true
                }
                Update::Plain => false,
                Update::Guarded => self.search(problem, x, allowed.min(1.0)),
            };
            if !taken {
                return Err(self.failure(problem, x, statistics));
            }
            // A shift shortens updates, so a short update proves nothing.
            let update = self.update.iter().fold(0.0_f64, |largest, entry| entry.abs().max(largest));
            if shift == 0.0 && update <= RELATIVE_UPDATE * self.length {
                break;
            }
        }
        Ok(())
    }

    /// Return the failure at `x`.
    fn failure(&mut self, problem: Problem<D>, x: &[Vector<D>], statistics: &Statistics) -> Error {
        self.find_descent(problem, x).map_or_else(Error::from, |imbalance| imbalance.error(statistics))
    }

    /// Write −∇Π at `x` to `descent` and return the residual.
    fn find_descent(&mut self, problem: Problem<D>, x: &[Vector<D>]) -> Result<Imbalance, BadShape> {
        self.find_touch(problem, x);
        let Self { descent, moments, first, touch, slide, .. } = self;
        let mut residual = Residual::default();
        problem.elastic.gradient(x, moments, |k, gradient| {
            let of_node = problem.outer(k, x);
            let mut descent_of_node =
                with_touch(of_node, touch, k, problem.balance.elastic) - gradient * problem.balance.elastic;
            if let (0, Some(axis)) = (k, *slide) {
                descent_of_node = kept(Vector::zeros(), axis, descent_of_node);
            }
            residual.add(descent_of_node, of_node, problem.balance.load[k]);
            descent[(k - *first) * D..][..D].copy_from_slice(descent_of_node.as_slice());
        })?;
        Ok(residual.imbalance(RELATIVE_RESIDUAL, self.extent, self.stiffness))
    }

    /// Write ∇∇Π at `x` to `matrix` and −∇Π to `descent`.
    pub(crate) fn assemble(&mut self, problem: Problem<D>, x: &[Vector<D>]) -> Result<(), BadShape> {
        self.find_touch(problem, x);
        let Self { matrix, moments, descent, stiffness, touch, first: first_node, .. } = self;
        let first_node = *first_node;
        let Problem { elastic, balance, .. } = problem;
        let s = balance.elastic;
        // Unknowns of a node; with shear the first is a moment.
        let first = usize::from(elastic.shear.is_some());
        let block = first + D;
        let sheared = elastic.shear.as_ref().map_or(0.0, |shear| s * shear.stiffest);
        *stiffness = 0.0;
        elastic.derivatives(x, moments, |k, by| {
            let sum = with_touch(problem.outer(k, x), touch, k, s) - by.gradient * s;
            let place = k - first_node;
            descent[place * D..][..D].copy_from_slice(sum.as_slice());
            if let Some(shear) = &elastic.shear {
                let column = matrix.column_mut(place * block);
                column.fill(0.0);
                // No vertex precedes a free root: its unknown is 0 and couples to nothing.
                let [own, next] = if k > 0 { shear.column(k - 1) } else { [shear.column(0)[0], 0.0] };
                column[0] = -own / s;
                column[1..=D].copy_from_slice(by.turns[0].as_slice());
                if k + 1 < x.len() {
                    column[block] = -next / s;
                }
            }
            for j in 0..D {
                let (own, others) = matrix.column_mut(place * block + first + j).split_at_mut(D - j);
                for (i, entry) in own.iter_mut().enumerate() {
                    *entry = s * by.own[(j + i, j)];
                }
                own[0] += balance.diagonal[k];
                *stiffness =
                    stiffness.max(own[0].abs() + sheared * by.turns.iter().map(|turn| turn[j] * turn[j]).sum::<f64>());
                if first == 1 {
                    (others[0], others[block]) = (by.turns[1][j], by.turns[2][j]);
                }
                for i in 0..D {
                    others[first + i] = s * by.next[(i, j)];
                    others[first + block + i] = s * by.next_but_one[(i, j)];
                }
            }
        })?;
        if let Some(contact) = &self.contact {
            let (matrix, stiffness) = (&mut self.matrix, &mut self.stiffness);
            contact.hessian(x, problem.origin, |k, [own, mixed, next]| {
                for (node, block_of_node) in
                    [(k, own), (k + 1, next)].into_iter().filter(|(node, _)| *node >= first_node)
                {
                    for j in 0..D {
                        let column = matrix.column_mut((node - first_node) * block + first + j);
                        (j..D).for_each(|i| column[i - j] += s * block_of_node[(i, j)]);
                        *stiffness = stiffness.max(column[0].abs());
                        if node == k {
                            (0..D).for_each(|i| column[D - j + first + i] += s * mixed[(i, j)]);
                        }
                    }
                }
            });
        }
        if let Some(axis) = self.slide {
            self.hold_root(axis, first);
        }
        Ok(())
    }

    /// Find the forces of the contact in the shape `x` at rest.
    pub(crate) fn touch_at_rest(&mut self, x: &[Vector<D>]) -> Result<(), Error> {
        let Some(contact) = &mut self.contact else { return Ok(()) };
        contact.begin_static(x)?;
        contact.find_forces(x, x, &mut self.touch);
        Ok(())
    }

    /// Find the forces of the contact at `x`.
    fn find_touch(&mut self, problem: Problem<D>, x: &[Vector<D>]) {
        if let Some(contact) = &self.contact {
            contact.find_forces(x, problem.origin, &mut self.touch);
        }
    }

    /// Return Π and its expected rounding error, J; `None` if the shape `x` has no energy.
    fn potential(&self, problem: Problem<D>, x: &[Vector<D>]) -> Option<(f64, f64)> {
        let (potential, rounding) = problem.potential(x)?;
        let Some(contact) = &self.contact else { return Some((potential, rounding)) };
        let touching = problem.balance.elastic * contact.potential(x, problem.origin);
        Some((potential + touching, rounding + POTENTIAL_ROUNDING * touching.abs()))
    }

    /// Uncouple the components of node 0 except `axis`, which get the update 0; `first` is their first column.
    fn hold_root(&mut self, axis: usize, first: usize) {
        for j in 0..D {
            let column = self.matrix.column_mut(first + j);
            if j == axis {
                column[1..D - j].fill(0.0);
            } else {
                column.fill(0.0);
                column[0] = self.stiffness;
                self.descent[j] = 0.0;
            }
        }
    }

    /// Factorise `matrix` and return the number of negative eigenvalues of ∇∇Π.
    ///
    /// Each unknown moment adds a negative eigenvalue to the mixed matrix.
    fn factorise(&mut self) -> Result<usize, Singular> {
        self.matrix.factorise().map(|negative| negative.saturating_sub(self.mixed.len() / (D + 1)))
    }

    /// Replace the right-hand side in `update` by the solution of the factorised matrix.
    fn solve_factorised(&mut self) {
        let Self { matrix, mixed, update, .. } = self;
        if mixed.is_empty() {
            return matrix.solve(update);
        }
        for (mixed, update) in mixed.chunks_exact_mut(D + 1).zip(update.chunks_exact(D)) {
            mixed[0] = 0.0;
            mixed[1..].copy_from_slice(update);
        }
        matrix.solve(mixed);
        for (mixed, update) in mixed.chunks_exact(D + 1).zip(update.chunks_exact_mut(D)) {
            update.copy_from_slice(&mixed[1..]);
        }
    }

    /// Add `value` to the diagonal of ∇∇Π.
    fn shift(&mut self, value: f64) {
        let block = D + usize::from(!self.moments.is_empty());
        for column in 0..self.matrix.order() {
            if column % block >= block - D {
                self.matrix.column_mut(column)[0] += value;
            }
        }
    }

    /// Raise the diagonal, beginning with `shift`, until all pivots are positive; return the shift, N/m.
    fn factorise_shifted(&mut self, problem: Problem<D>, x: &[Vector<D>], shift: f64) -> Option<f64> {
        let mut factor = 1.0;
        loop {
            self.assemble(problem, x).ok()?;
            let stiffness = self.stiffness;
            let tried = shift.max(SMALLEST_SHIFT * stiffness) * factor;
            // A matrix of NaN has the stiffness 0.
            if tried > LARGEST_SHIFT * stiffness || !stiffness.is_finite() || stiffness == 0.0 {
                return None;
            }
            self.shift(tried);
            if let Ok(0) = self.factorise() {
                return Some(tried);
            }
            factor *= 10.0;
        }
    }

    /// Add the largest of `part`, `part`/2, `part`/4 … of the update that lowers Π enough; return false if none does.
    fn search(&mut self, problem: Problem<D>, x: &mut [Vector<D>], mut part: f64) -> bool {
        let slope: f64 = -self.descent.iter().zip(&self.update).map(|(r, u)| r * u).sum::<f64>();
        let Some((start, rounding)) = self.potential(problem, x) else { return false };
        self.before.copy_from_slice(x);
        for _ in 0..BACKTRACKS {
            self.add_update(x, part);
            if let Some((potential, _)) = self.potential(problem, x)
                && potential <= start + ARMIJO * part * slope + rounding
            {
                return true;
            }
            x.copy_from_slice(&self.before);
            part *= 0.5;
        }
        false
    }

    /// Add `part` of the update to `x`.
    fn add_update(&self, x: &mut [Vector<D>], part: f64) {
        for (x, update) in x[self.first..].iter_mut().zip(self.update.chunks_exact(D)) {
            *x += Vector::from_column_slice(update) * part;
        }
    }

    /// Return the largest change of an edge in the update, m.
    fn edge_change(&self) -> f64 {
        let (nodes, _) = self.update.as_chunks::<D>();
        let beside_root = if self.first == 1 { Vector::from(nodes[0]).norm_squared() } else { 0.0 };
        let square = nodes.windows(2).fold(beside_root, |largest, ends| {
            largest.max((Vector::from(ends[1]) - Vector::from(ends[0])).norm_squared())
        });
        square.sqrt()
    }
}

/// Return the force on node `k` with `part` of the contact; without contact it is the same.
#[inline(always)]
pub(crate) fn with_touch<const D: usize>(force: Vector<D>, touch: &[Vector<D>], k: usize, part: f64) -> Vector<D> {
    touch.get(k).map_or(force, |touch| force + touch * part)
}

/// Return `vector` with the component `axis` of `free`.
pub(crate) fn kept<const D: usize>(mut vector: Vector<D>, axis: usize, free: Vector<D>) -> Vector<D> {
    vector[axis] = free[axis];
    vector
}

impl<const D: usize> Problem<'_, D> {
    /// Return the force against the elastic force on node `k` of the shape `x`, N.
    #[inline(always)]
    fn outer(&self, k: usize, x: &[Vector<D>]) -> Vector<D> {
        self.balance.load[k] - (x[k] - self.origin[k]) * self.balance.diagonal[k]
    }

    /// Return Π without contact and its expected rounding error, J; `None` if the shape `x` has no energy.
    fn potential(&self, x: &[Vector<D>]) -> Option<(f64, f64)> {
        let Balance { diagonal, load, elastic, .. } = self.balance;
        let energy = self.elastic.energy(x).ok()?;
        let (mut potential, mut size) = (elastic * (energy.stretching + energy.bending), 0.0);
        for (k, (x, origin)) in x.iter().zip(self.origin).enumerate().skip(self.elastic.first) {
            let u = x - origin;
            let inertia = 0.5 * diagonal[k] * u.norm_squared();
            let work = load[k].dot(&u);
            potential += inertia - work;
            size += inertia + work.abs();
        }
        Some((potential, POTENTIAL_ROUNDING * (size + potential.abs())))
    }
}
