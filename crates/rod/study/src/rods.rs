//! Rods and the exact solution that several studies use.

use rod::{Parameters, Rod, Root};
use scene::{Bending, Calibration, Material, RodScheme, Section};

/// Schemes by name.
pub const SCHEMES: [(&str, RodScheme); 5] = [
    ("trapezoid", RodScheme::Trapezoid),
    ("generalised-alpha 0.5", RodScheme::GeneralisedAlpha { rho_inf: 0.5 }),
    ("generalised-alpha 0.8", RodScheme::GeneralisedAlpha { rho_inf: 0.8 }),
    ("TR-BDF2", RodScheme::TrBdf2),
    ("BDF2", RodScheme::Bdf2),
];

/// The beam of the thesis, section 2.4.1, in units of its length: mu = 0.0571, EI = 0.0259, g = 0.7 along the last axis,
/// with the EA of the bar of thickness 2/35.
pub fn thesis_beam<const D: usize>(segments: usize) -> Parameters<D> {
    let mut direction = [0.0; D];
    direction[0] = 1.0;
    let mut gravity = [0.0; D];
    gravity[D - 1] = -0.7;
    let bending_stiffness = 0.0259;
    Parameters {
        root: [0.0; D],
        direction,
        length: 1.0,
        segments,
        rest_angles: Vec::new(),
        section: Section {
            line_density: 0.0571,
            bending_stiffness,
            axial_stiffness: 12.0 * bending_stiffness * 17.5 * 17.5,
            shear_stiffness: None,
        },
        displaced: 0.0,
        gravity,
        damping: 0.0,
        bending: Bending::Invariant,
        calibration: Calibration::SecondOrder,
        clamp_setback: 0.0,
        scheme: RodScheme::default(),
        max_step: None,
    }
}

/// The bar of CSM3 (Turek & Hron 2006).
pub fn csm3(segments: usize, scheme: RodScheme) -> Parameters<2> {
    Parameters {
        length: 0.35,
        section: Material::PlaneStrain {
            density: 1000.0,
            youngs_modulus: 1.4e6,
            poisson_ratio: 0.4,
            shear_factor: None,
        }
        .section(0.02),
        gravity: [0.0, -2.0],
        scheme,
        ..thesis_beam(segments)
    }
}

/// The same rod with nothing watched: its root is driven, but to where it is.
pub fn unwatched(mut rod: Rod<2>) -> Rod<2> {
    let &Parameters { root: position, direction, .. } = rod.parameters();
    rod.root = Some(Root { position, velocity: [0.0; 2], direction, direction_rate: [0.0; 2] });
    rod
}

/// Shape (x, y) of the exact elastica, clamped along x, under `weight` per length at rest along −y, at `points` + 1 equal
/// distances from the root: θ'' = (1 + ε) w (L − s) cos θ / EI, ε = −w (L − s) sin θ / EA, θ(0) = 0, θ'(L) = 0.
///
/// Classical Runge–Kutta rule with 8000 steps and bisection for θ'(0): halving the steps moves the tip by less than 1e-12.
pub fn elastica(length: f64, weight: f64, bending: f64, axial: f64, points: usize) -> Vec<[f64; 2]> {
    const STEPS: usize = 8000;
    let ds = length / STEPS as f64;
    // y = (θ, θ', x, y).
    let slope = |s: f64, y: [f64; 4]| {
        let beyond = weight * (length - s);
        let stretch = 1.0 - beyond * y[0].sin() / axial;
        [y[1], stretch * beyond * y[0].cos() / bending, stretch * y[0].cos(), stretch * y[0].sin()]
    };
    let march = |curvature: f64, mut visit: Box<dyn FnMut(usize, [f64; 4]) + '_>| {
        let mut y = [0.0, curvature, 0.0, 0.0];
        visit(0, y);
        for step in 0..STEPS {
            let s = step as f64 * ds;
            let along = |k: [f64; 4], part: f64| std::array::from_fn(|i| y[i] + part * ds * k[i]);
            let k1 = slope(s, y);
            let k2 = slope(s + 0.5 * ds, along(k1, 0.5));
            let k3 = slope(s + 0.5 * ds, along(k2, 0.5));
            let k4 = slope(s + ds, along(k3, 1.0));
            y = std::array::from_fn(|i| y[i] + ds / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            visit(step + 1, y);
        }
        y
    };
    let (mut low, mut high) = (-weight * length * length / bending, 0.0);
    while high - low > 1e-15 * low.abs() && 0.5 * (low + high) > low && 0.5 * (low + high) < high {
        let middle = 0.5 * (low + high);
        if march(middle, Box::new(|_, _| ()))[1] > 0.0 { high = middle } else { low = middle }
    }
    let mut shape = Vec::with_capacity(points + 1);
    march(
        0.5 * (low + high),
        Box::new(|step, y| {
            if step % (STEPS / points) == 0 {
                shape.push([y[2], y[3]]);
            }
        }),
    );
    shape
}

/// Kinetic, elastic and gravity energy together, J.
pub fn total_energy<const D: usize>(rod: &Rod<D>) -> f64 {
    rod.energy().map_or(f64::NAN, |e| e.kinetic + e.stretching + e.bending + e.gravity)
}
