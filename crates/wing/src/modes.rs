//! Natural frequencies about the present shape, by subspace iteration (Bathe & Wilson 1972, Int. J. Numer. Methods
//! Eng. 6, 213).

use nalgebra::{DMatrix, SymmetricEigen};
use structure::Balance;

use crate::geometry::Vector;
use crate::{Error, Wing, WingError};

/// Maximum number of iterations.
const ITERATIONS: usize = 200;
/// Tolerance of the squared frequencies.
const TOLERANCE: f64 = 1e-10;

impl Wing {
    /// Return the lowest `count` circular frequencies, rad/s, of small free oscillations about the present shape.
    ///
    /// # Errors
    /// The stiffness of a free wing, or of a buckled shape, is singular.
    pub fn frequencies(&mut self, count: usize) -> Result<Vec<f64>, Error> {
        let nodes = self.nodes();
        let free = self.newton.system.positions;
        let size = (count + 8).min(free);
        let Self { newton, elastic, core, .. } = self;
        let (x, product) = (&core.state.positions, &mut core.product);
        let balance = Balance::at_rest(nodes);
        newton.forget();
        elastic.set_stresses(x);
        newton.system.assemble(elastic, x, &balance.velocity, &balance, false)?;
        if !newton.system.matrix.factorise() {
            return Err(WingError::Singular.into());
        }
        // Numbers without a pattern start the iteration.
        let mut vectors: Vec<Vec<Vector>> = (0..size)
            .map(|j| {
                let entry = |k: usize, d: usize| (((3 * k + d + 1) * (j + 1)) as f64 * 12.9898).sin();
                (0..nodes).map(|k| Vector::from_fn(|d, _| if core.held[k] { 0.0 } else { entry(k, d) })).collect()
            })
            .collect();
        let mut last = vec![0.0; count];
        for _ in 0..ITERATIONS {
            // K y = M x, then the projections of K and M on the vectors y.
            let images: Vec<Vec<Vector>> = vectors
                .iter_mut()
                .map(|vector| {
                    elastic.mass_times(vector, product);
                    let image = product.clone();
                    newton.system.solve(product, &[]);
                    (0..nodes).for_each(|k| vector[k] = newton.system.update_of(k));
                    image
                })
                .collect();
            let dot = |a: &[Vector], b: &[Vector]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(b)).sum() };
            let stiffness = DMatrix::from_fn(size, size, |i, j| dot(&vectors[i], &images[j]));
            let weighted: Vec<Vec<Vector>> = vectors
                .iter()
                .map(|vector| {
                    elastic.mass_times(vector, product);
                    product.clone()
                })
                .collect();
            let mass = DMatrix::from_fn(size, size, |i, j| dot(&vectors[i], &weighted[j]));
            let symmetric = |m: DMatrix<f64>| (&m + m.transpose()) * 0.5;
            let lower = symmetric(mass).cholesky().ok_or(WingError::Singular)?.l();
            let inverse = lower.try_inverse().ok_or(WingError::Singular)?;
            let reduced = symmetric(&inverse * symmetric(stiffness) * inverse.transpose());
            let SymmetricEigen { eigenvalues, eigenvectors } = reduced.symmetric_eigen();
            let mut order: Vec<_> = (0..size).collect();
            order.sort_by(|&i, &j| eigenvalues[i].total_cmp(&eigenvalues[j]));
            let mixing = inverse.transpose() * eigenvectors;
            vectors = order
                .iter()
                .map(|&column| {
                    let mut vector = vec![Vector::zeros(); nodes];
                    for (j, other) in vectors.iter().enumerate() {
                        let weight = mixing[(j, column)];
                        vector.iter_mut().zip(other).for_each(|(sum, other)| *sum += other * weight);
                    }
                    vector
                })
                .collect();
            let now: Vec<f64> = order.iter().take(count).map(|&i| eigenvalues[i]).collect();
            if now.iter().zip(&last).all(|(now, last)| (now - last).abs() <= TOLERANCE * now.abs()) {
                return Ok(now.into_iter().map(|square| square.max(0.0).sqrt()).collect());
            }
            last = now;
        }
        Err(WingError::Singular.into())
    }
}
