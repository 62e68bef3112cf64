//! Rods and exact solutions that several tests and the study share.
#![allow(dead_code, reason = "each of them uses its own part")]

use nalgebra::{DMatrix, DVector};
use nervure_rod::{Parameters, Rod, Taper};
use scene::{Bending, Calibration, Material, RodScheme, Section};

pub const GENERALISED_ALPHA: RodScheme = RodScheme::GeneralisedAlpha { rho_inf: 0.5 };
pub const SCHEMES: [RodScheme; 4] = [RodScheme::Trapezoid, GENERALISED_ALPHA, RodScheme::TrBdf2, RodScheme::Bdf2];

/// The bar of Turek & Hron (2006): 0.35 m x 0.02 m, density 1000 kg/m³, Poisson's ratio 0.4.
pub fn turek_hron_bar(youngs_modulus: f64, gravity: f64, segments: usize) -> Parameters<2> {
    Parameters {
        root: [0.25, 0.2],
        direction: [1.0, 0.0],
        length: 0.35,
        segments,
        rest_angles: Vec::new(),
        section: Material::PlaneStrain { density: 1000.0, youngs_modulus, poisson_ratio: 0.4, shear_factor: None }
            .section(&0.02.into(), 0.0),
        displaced: 0.0,
        taper: Taper::default(),
        gravity: [0.0, -gravity],
        damping: 0.0,
        bending: Bending::Invariant,
        calibration: Calibration::SecondOrder,
        clamp_setback: 0.0,
        scheme: RodScheme::Bdf2,
        max_step: None,
    }
}

/// A soft rod of length, mass and bending stiffness 1 along x, whose axial waves are slow enough to be resolved.
pub fn unit_rod<const D: usize>(segments: usize, axial_stiffness: f64, scheme: RodScheme) -> Parameters<D> {
    Parameters {
        root: [0.0; D],
        direction: std::array::from_fn(|d| f64::from(d == 0)),
        length: 1.0,
        segments,
        rest_angles: Vec::new(),
        section: Section { line_density: 1.0, bending_stiffness: 1.0, axial_stiffness, shear_stiffness: None },
        displaced: 0.0,
        taper: Taper::default(),
        gravity: [0.0; D],
        damping: 0.0,
        bending: Bending::Invariant,
        calibration: Calibration::SecondOrder,
        clamp_setback: 0.0,
        scheme,
        max_step: None,
    }
}

/// Kinetic, elastic and gravity energy together, J.
pub fn total_energy<const D: usize>(rod: &Rod<D>) -> f64 {
    let energy = rod.energy().unwrap();
    energy.kinetic + energy.stretching + energy.bending + energy.gravity
}

/// Shape (x, y) of the exact elastica, clamped along x, under `weight` per length at rest along −y, at `points` + 1 equal
/// distances from the root:
///
/// θ'' = (1 + ε) w (L − s) cos θ / EI, ε = −w (L − s) sin θ / EA, θ(0) = 0, θ'(L) = 0.
///
/// An infinite EA is the inextensible elastica. Classical Runge–Kutta rule with 8000 steps and bisection for θ'(0): halving
/// the steps moves the tip by less than 1e-12.
pub fn elastica(length: f64, weight: f64, bending: f64, axial: f64, points: usize) -> Vec<[f64; 2]> {
    const STEPS: usize = 8000;
    let ds = length / STEPS as f64;
    // y = (θ, θ', x, y).
    let slope = |s: f64, y: [f64; 4]| {
        let beyond = weight * (length - s);
        let stretch = 1.0 - beyond * y[0].sin() / axial;
        [y[1], stretch * beyond * y[0].cos() / bending, stretch * y[0].cos(), stretch * y[0].sin()]
    };
    let march = |curvature: f64| {
        let mut states = vec![[0.0, curvature, 0.0, 0.0]];
        for step in 0..STEPS {
            let (s, y) = (step as f64 * ds, states[step]);
            let along = |k: [f64; 4], part: f64| std::array::from_fn(|i| y[i] + part * ds * k[i]);
            let k1 = slope(s, y);
            let k2 = slope(s + 0.5 * ds, along(k1, 0.5));
            let k3 = slope(s + 0.5 * ds, along(k2, 0.5));
            let k4 = slope(s + ds, along(k3, 1.0));
            states.push(std::array::from_fn(|i| y[i] + ds / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])));
        }
        states
    };
    let (mut low, mut high) = (-weight * length * length / bending, 0.0);
    let mut middle = 0.5 * (low + high);
    while high - low > 1e-15 * low.abs() && low < middle && middle < high {
        if march(middle)[STEPS][1] > 0.0 {
            high = middle
        } else {
            low = middle
        }
        middle = 0.5 * (low + high);
    }
    march(middle).iter().step_by(STEPS / points).map(|y| [y[2], y[3]]).collect()
}

/// Displacement of its tip.
pub fn elastica_tip(length: f64, weight: f64, bending: f64, axial: f64) -> [f64; 2] {
    let [x, y] = elastica(length, weight, bending, axial, 1)[1];
    [x - length, y]
}

/// A beam whose vibrations the Ritz method finds: of length 1, in units of its own.
pub struct RitzBeam<'a> {
    /// EI at the place s.
    pub bending: &'a dyn Fn(f64) -> f64,
    /// Mass per length at the place s.
    pub mass: &'a dyn Fn(f64) -> f64,
    /// 0 for a free root, 1 for one that only turns, 2 for a clamped one.
    pub held: usize,
    /// Stiffness of a torsion spring at the root.
    pub spring: f64,
}

impl RitzBeam<'_> {
    /// Circular frequencies of the first modes, those of a rigid beam included: 18 Legendre polynomials times s^held, and Gauss's
    /// rule; rounding leaves errors of 1e-9.
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

    /// Values, first and second derivatives of the basis at `s`.
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
        for k in 0..terms {
            let (p, dp, ddp) = (legendre[0][k], 2.0 * legendre[1][k], 4.0 * legendre[2][k]);
            basis[0].push(factor * p);
            basis[1].push(factor * dp + by_s * p);
            basis[2].push(factor * ddp + 2.0 * by_s * dp + by_s_twice * p);
        }
        basis
    }
}

/// Gauss's rule with 10 points on each of 20 parts of 0 … 1: places and weights.
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

/// Circular frequencies of small vibrations across a straight rod along x, from the lowest.
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
