//! Rods and exact solutions for several tests and the study.
#![allow(dead_code, reason = "each of them uses its own part")]

use nervure_rod::{Parameters, Rod, Scheme, Section};

pub const GENERALISED_ALPHA: Scheme = Scheme::GeneralisedAlpha { rho_inf: 0.5 };
pub const SCHEMES: [Scheme; 4] = [Scheme::Trapezoid, GENERALISED_ALPHA, Scheme::TrBdf2, Scheme::Bdf2];

/// Return the bar of Turek & Hron (2006): 0.35 m x 0.02 m, density 1000 kg/m³, Poisson's ratio 0.4, in plane strain.
pub fn turek_hron_bar(youngs_modulus: f64, gravity: f64, segments: usize) -> Parameters<2> {
    let (thickness, poisson_ratio): (f64, f64) = (0.02, 0.4);
    let modulus = youngs_modulus / (1.0 - poisson_ratio * poisson_ratio);
    let section = Section {
        line_density: 1000.0 * thickness,
        bending_stiffness: modulus * thickness.powi(3) / 12.0,
        axial_stiffness: modulus * thickness,
        shear_stiffness: None,
    };
    let bar = Parameters::new(0.35, segments, section);
    Parameters { attachment: [0.25, 0.2], gravity: [0.0, -gravity], scheme: Scheme::Bdf2, ..bar }
}

/// Return a soft rod of length, mass and bending stiffness 1 along x, whose axial waves the step resolves.
pub fn unit_rod<const D: usize>(segments: usize, axial_stiffness: f64, scheme: Scheme) -> Parameters<D> {
    let section = Section { line_density: 1.0, bending_stiffness: 1.0, axial_stiffness, shear_stiffness: None };
    Parameters { scheme, ..Parameters::new(1.0, segments, section) }
}

/// Return the sum of kinetic, elastic and gravity energy, J.
pub fn total_energy<const D: usize>(rod: &Rod<D>) -> f64 {
    let energy = rod.energy().unwrap();
    energy.kinetic + energy.stretching + energy.bending + energy.gravity
}

/// Return the shape (x, y) of the exact elastica, clamped along x, under `weight` per length along −y.
///
/// The shape has `points` + 1 equidistant points and satisfies
///
/// θ'' = (1 + ε) w (L − s) cos θ / EI, ε = −w (L − s) sin θ / EA, θ(0) = 0, θ'(L) = 0.
///
/// An infinite EA is the inextensible elastica. The solution uses the classical Runge–Kutta rule with 8000 steps and
/// bisection for θ'(0); half the step moves the tip by less than 1e-12.
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

/// Return the displacement of the tip of the elastica.
pub fn elastica_tip(length: f64, weight: f64, bending: f64, axial: f64) -> [f64; 2] {
    let [x, y] = elastica(length, weight, bending, axial, 1)[1];
    [x - length, y]
}
