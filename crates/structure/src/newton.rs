//! What the Newton solvers of structures share: the equation of a stage, its residual and the effort.
//!
//! With velocities eliminated, a stage and an equilibrium are the equation of the displacement u = x − x_0
//!
//! ```text
//! r(u) = b − w M u − d u − s F(x_0 + u, c_v u + v*) = 0.
//! ```

use crate::{Error, Vector};

/// Tolerance of the last update, relative to the size of the structure.
pub const RELATIVE_UPDATE: f64 = 1e-13;
/// Rounding error of a position, relative to the largest coordinate.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Largest change of an edge, relative to its length, after which a residual counts as rounding.
///
/// The next update would be of the order of its square.
const SETTLED_UPDATE: f64 = 1e-4;

/// Terms of r that do not change in the iteration; the entries of held nodes are unused, except velocities.
#[derive(Clone, Debug)]
pub struct Balance<const D: usize> {
    /// b, N: `[nodes]`.
    pub load: Vec<Vector<D>>,
    /// d, N/m: `[nodes]`; with lumped masses it contains w M.
    pub diagonal: Vec<f64>,
    /// Vectors c of a surface, (N/m)^½: `[nodes]`, of others empty; d has the part c cᵀ beside `diagonal`.
    pub across: Vec<Vector<D>>,
    /// w, 1/s².
    pub mass: f64,
    /// s.
    pub elastic: f64,
    /// c_v, 1/s.
    pub rate: f64,
    /// v*, m/s: `[nodes]`; the velocity itself at a held node.
    pub velocity: Vec<Vector<D>>,
}

/// Effort of the last step or of the last search for equilibrium.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Newton iterations, including failed attempts.
    pub iterations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Sub-steps.
    pub substeps: usize,
    /// Halvings of sub-steps that failed or gained energy.
    pub halvings: usize,
    /// Solves that needed a line search.
    pub rescues: usize,
    /// Largest number of negative pivots in a Newton matrix of a rod; above 0 the step is too long.
    pub negative_pivots: usize,
}

/// Largest components of r and of the forces that it balances, over the nodes; N.
#[derive(Clone, Copy, Default)]
pub struct Residual {
    largest: f64,
    outer: f64,
    /// The comparisons skip NaN, a sum does not.
    sum: f64,
}

/// Residual of a shape.
#[derive(Clone, Copy, Debug)]
pub struct Imbalance {
    /// Largest component of r, N.
    pub residual: f64,
    /// Tolerance, N.
    pub tolerance: f64,
    /// Bound of the rounding error, N.
    pub rounding: f64,
}

impl<const D: usize> Balance<D> {
    /// Return the equation of an equilibrium of `nodes` nodes without loads.
    pub fn at_rest(nodes: usize) -> Self {
        let zeros = vec![Vector::zeros(); nodes];
        let (load, diagonal) = (zeros.clone(), vec![0.0; nodes]);
        Self { load, diagonal, across: vec![], mass: 0.0, elastic: 1.0, rate: 0.0, velocity: zeros }
    }

    /// Return d times the displacement of node `k`, N.
    #[inline(always)]
    pub fn d_times(&self, k: usize, u: &Vector<D>) -> Vector<D> {
        let across = self.across.get(k).map_or_else(Vector::zeros, |across| across * across.dot(u));
        u * self.diagonal[k] + across
    }
}

impl Residual {
    /// Add a node with its residual, the force against its elastic force, and its load.
    #[inline(always)]
    pub fn add<const D: usize>(&mut self, residual: Vector<D>, outer: Vector<D>, load: Vector<D>) {
        self.largest = larger(self.largest, residual);
        self.outer = larger(larger(self.outer, outer), load);
        self.sum += residual.sum();
    }

    /// Return the imbalance with a tolerance `relative` to the largest force, in a structure of the largest coordinate
    /// `extent`, m, and the largest `stiffness`, N/m.
    pub fn imbalance(self, relative: f64, extent: f64, stiffness: f64) -> Imbalance {
        let residual = if self.sum.is_nan() { f64::INFINITY } else { self.largest };
        Imbalance { residual, tolerance: relative * self.outer, rounding: ROUNDING * extent * stiffness }
    }
}

/// Return the largest of a number and the magnitudes of a vector; skip NaN. Each comparison is one instruction.
#[inline(always)]
fn larger<const D: usize>(largest: f64, vector: Vector<D>) -> f64 {
    vector.iter().fold(largest, |largest, component| if component.abs() > largest { component.abs() } else { largest })
}

impl Imbalance {
    /// Return whether the tolerance is met; `allowed` is the share of the last update that changes no edge by more
    /// than its own length.
    pub fn is_met(&self, allowed: f64) -> bool {
        let rounding = if allowed * SETTLED_UPDATE >= 1.0 { self.rounding } else { 0.0 };
        self.residual <= self.tolerance + rounding
    }

    /// Return the error of an iteration that ends here.
    pub fn error<F>(self, statistics: &Statistics) -> Error<F> {
        let Self { residual, tolerance, rounding } = self;
        Error::NotConverged { residual, tolerance, rounding, iterations: statistics.iterations }
    }
}
