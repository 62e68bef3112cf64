//! Rods and exact solutions that several tests share.
#![allow(dead_code, reason = "each test file uses its own part")]

use nervure_rod::{Parameters, Rod};
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
            .section(0.02),
        displaced: 0.0,
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
    let mut direction = [0.0; D];
    direction[0] = 1.0;
    Parameters {
        root: [0.0; D],
        direction,
        length: 1.0,
        segments,
        rest_angles: Vec::new(),
        section: Section { line_density: 1.0, bending_stiffness: 1.0, axial_stiffness, shear_stiffness: None },
        displaced: 0.0,
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

/// Tip displacement (along the clamped direction, along the load) of the exact elastica, clamped horizontally, under
/// the weight `w` per length at rest:
///
/// θ'' = (1 + ε) w (L − s) cos θ / EI, ε = −w (L − s) sin θ / EA, θ(0) = 0, θ'(L) = 0,
///
/// by the classical Runge-Kutta rule and bisection for θ'(0). An infinite EA is the inextensible elastica.
pub fn elastica_tip(length: f64, weight: f64, bending: f64, axial: f64) -> [f64; 2] {
    const STEPS: usize = 4000;
    let ds = length / STEPS as f64;
    // y = (θ, θ', x, y).
    let slope = |s: f64, y: [f64; 4]| {
        let beyond = weight * (length - s);
        let stretch = 1.0 - beyond * y[0].sin() / axial;
        [y[1], stretch * beyond * y[0].cos() / bending, stretch * y[0].cos(), stretch * y[0].sin()]
    };
    let end = |curvature: f64| {
        let mut y = [0.0, curvature, 0.0, 0.0];
        for step in 0..STEPS {
            let s = step as f64 * ds;
            let along = |k: [f64; 4], part: f64| std::array::from_fn(|i| y[i] + part * ds * k[i]);
            let k1 = slope(s, y);
            let k2 = slope(s + 0.5 * ds, along(k1, 0.5));
            let k3 = slope(s + 0.5 * ds, along(k2, 0.5));
            let k4 = slope(s + ds, along(k3, 1.0));
            y = std::array::from_fn(|i| y[i] + ds / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        y
    };
    // The linear beam bends more than the elastica.
    let (mut low, mut high) = (-0.5 * weight * length * length / bending, 0.0);
    while high - low > 1e-14 * (1.0 + high.abs().max(low.abs())) {
        let middle = 0.5 * (low + high);
        if end(middle)[1] > 0.0 { high = middle } else { low = middle }
    }
    let [_, _, x, y] = end(0.5 * (low + high));
    [x - length, y]
}
