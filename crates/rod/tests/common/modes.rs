//! Vibrations of a rod from its masses and springs, and of a beam by the Ritz method.
#![allow(dead_code, reason = "each test uses its own part")]

use nalgebra::{DMatrix, DVector};
use nervure_rod::Rod;

/// Dimensionless beam of length 1 for the Ritz method.
pub struct RitzBeam<'a> {
    /// EI at s.
    pub bending: &'a dyn Fn(f64) -> f64,
    /// Mass per length at s.
    pub mass: &'a dyn Fn(f64) -> f64,
    /// 0 for a free root, 1 for a pinned root, 2 for a clamped root.
    pub held: usize,
    /// Stiffness of a torsion spring at the root.
    pub spring: f64,
}

impl RitzBeam<'_> {
    /// Return the circular frequencies of the first modes, rigid modes included.
    ///
    /// The basis is 18 Legendre polynomials times s^held, integrated by Gauss's rule; rounding errors are 1e-9.
    pub fn frequencies(&self) -> Vec<f64> {
        const TERMS: usize = 18;
        let (mut stiffness, mut inertia) = (DMatrix::zeros(TERMS, TERMS), DMatrix::zeros(TERMS, TERMS));
        let add = |matrix: &mut DMatrix<f64>, weight: f64, values: &[f64]| {
            let values = DVector::from_column_slice(values);
            *matrix += &values * values.transpose() * weight;
        };
        for (s, weight) in gauss() {
            let [values, _, second] = self.basis(s, TERMS);
            add(&mut inertia, weight * (self.mass)(s), &values);
            add(&mut stiffness, weight * (self.bending)(s), &second);
        }
        let [_, slopes, _] = self.basis(0.0, TERMS);
        add(&mut stiffness, self.spring, &slopes);
        generalised_frequencies(&stiffness, &inertia)
    }

    /// Return values, first and second derivatives of the basis at `s`.
    fn basis(&self, s: f64, terms: usize) -> [Vec<f64>; 3] {
        let x = 2.0 * s - 1.0;
        let mut legendre = [vec![1.0, x], vec![0.0, 1.0], vec![0.0, 0.0]];
        for k in 1..terms - 1 {
            let n = k as f64;
            let value = ((2.0 * n + 1.0) * x * legendre[0][k] - n * legendre[0][k - 1]) / (n + 1.0);
            let slope = legendre[1][k - 1] + (2.0 * n + 1.0) * legendre[0][k];
            let second = legendre[2][k - 1] + (2.0 * n + 1.0) * legendre[1][k];
            legendre.iter_mut().zip([value, slope, second]).for_each(|(list, next)| list.push(next));
        }
        let [factor, by_s, by_s_twice] = [[1.0, 0.0, 0.0], [s, 1.0, 0.0], [s * s, 2.0 * s, 2.0]][self.held];
        let mut basis = [vec![], vec![], vec![]];
        let [values, slopes, seconds] = legendre;
        for (p, (dp, ddp)) in values.into_iter().zip(slopes.into_iter().zip(seconds)).take(terms) {
            let (dp, ddp) = (2.0 * dp, 4.0 * ddp);
            basis[0].push(factor * p);
            basis[1].push(factor * dp + by_s * p);
            basis[2].push(factor * ddp + 2.0 * by_s * dp + by_s_twice * p);
        }
        basis
    }
}

/// Return points and weights of Gauss's rule with 10 points on each of 20 parts of 0 … 1.
pub fn gauss() -> Vec<(f64, f64)> {
    // The eigenvalues of Jacobi's matrix are the points (Golub & Welsch 1969).
    let beside = |k: usize| k as f64 / (4.0 * (k * k) as f64 - 1.0).sqrt();
    let jacobi = DMatrix::from_fn(10, 10, |i, j| if i.abs_diff(j) == 1 { beside(i.max(j)) } else { 0.0 });
    let eigen = jacobi.symmetric_eigen();
    let points: Vec<_> = (0..10).map(|i| (eigen.eigenvalues[i], eigen.eigenvectors[(0, i)].powi(2))).collect();
    let of_part = |part| {
        let place = move |&(x, weight): &(f64, f64)| ((f64::from(part) + 0.5 * (x + 1.0)) / 20.0, weight / 20.0);
        points.iter().map(place)
    };
    (0..20).flat_map(of_part).collect()
}

/// Return the circular frequencies of small transverse vibrations of a straight rod along x, the lowest first.
pub fn frequencies(rod: &mut Rod<2>) -> Vec<f64> {
    let stiffness = rod.stiffness().unwrap();
    let free = stiffness.order() / 2;
    let across = |i: usize, j: usize| {
        let (i, j) = (2 * i.max(j) + 1, 2 * i.min(j) + 1);
        stiffness.column(j).get(i - j).copied().unwrap_or(0.0)
    };
    let masses = rod.masses();
    let inertia = DVector::from_column_slice(&masses[masses.len() - free..]);
    generalised_frequencies(&DMatrix::from_fn(free, free, across), &DMatrix::from_diagonal(&inertia))
}

fn generalised_frequencies(stiffness: &DMatrix<f64>, inertia: &DMatrix<f64>) -> Vec<f64> {
    let root = inertia.clone().cholesky().expect("a positive mass").l();
    let half = root.solve_lower_triangular(stiffness).expect("regular");
    let reduced = root.solve_lower_triangular(&half.transpose()).expect("regular");
    let mut squares: Vec<f64> =
        ((&reduced + reduced.transpose()) * 0.5).symmetric_eigenvalues().iter().copied().collect();
    squares.sort_by(f64::total_cmp);
    squares.into_iter().map(|square| square.max(0.0).sqrt()).collect()
}
