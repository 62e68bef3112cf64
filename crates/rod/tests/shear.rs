//! The rod with shear against Timoshenko's beam.

mod common;

use common::unit_rod;
use nalgebra::{DMatrix, DVector, Matrix4, RowVector4};
use nervure_rod::{Parameters, Rod};
use scene::{RodScheme, Section};

/// GA_s of a rod with length and bending stiffness 1 whose shear counts: a twentieth of the tip's deflection.
const SHEAR: f64 = 60.0;

fn sheared(segments: usize) -> Parameters<2> {
    let rod = unit_rod::<2>(segments, 1e6, RodScheme::Trapezoid);
    Parameters { section: Section { shear_stiffness: Some(SHEAR), ..rod.section }, ..rod }
}

/// A small force P at the tip bends it by P L³/(3 EI) + P L/GA_s, a set-back clamp by P L² d/EI more.
#[test]
fn tip_deflection_is_timoshenkos() {
    let (force, setback) = (1e-4, 0.01);
    let exact = force * (1.0 / 3.0 + 1.0 / SHEAR + setback);
    let errors = [20, 40].map(|segments| {
        let mut rod = Rod::new(Parameters { clamp_setback: setback, ..sheared(segments) }).unwrap();
        rod.loads.force = vec![0.0; 2 * (segments + 1)];
        *rod.loads.force.last_mut().unwrap() = force;
        rod.solve_static().unwrap();
        let energy = rod.energy().unwrap();
        let stored = energy.bending + energy.stretching;
        let work = 0.5 * force * rod.tip_displacement()[1];
        assert!((stored - work).abs() < 1e-6 * work, "{segments}: energy {stored} J, work {work} J");
        (rod.tip_displacement()[1] - exact) / exact
    });
    assert!(errors[1].abs() < 5e-4, "{errors:?}");
    let ratio = errors[0] / errors[1];
    assert!((3.8..4.2).contains(&ratio), "not of second order: {errors:?}");
}

/// The first three natural frequencies are those of Timoshenko's cantilever without rotary inertia, to second order.
#[test]
fn natural_frequencies_are_timoshenkos() {
    let [coarse, fine] = [30, 60].map(frequencies);
    let (mut low, mut found) = (0.5, 0);
    let (mut omega, mut sign) = (low, determinant(low) > 0.0);
    while found < 3 {
        omega += 0.5;
        if (determinant(omega) > 0.0) != sign {
            let (mut below, mut above) = (low, omega);
            for _ in 0..60 {
                let middle = 0.5 * (below + above);
                if (determinant(middle) > 0.0) == sign { below = middle } else { above = middle }
            }
            let errors = [coarse[found] / below - 1.0, fine[found] / below - 1.0];
            assert!(errors[1].abs() < 3e-3, "mode {found}, omega {below}: {errors:?}");
            let ratio = errors[0] / errors[1];
            assert!((3.7..4.3).contains(&ratio), "mode {found} is not of second order: {errors:?}");
            sign = !sign;
            found += 1;
        }
        low = omega;
    }
}

/// Angular frequencies of small transverse vibrations about rest, the lowest first.
fn frequencies(segments: usize) -> Vec<f64> {
    let mut rod = Rod::new(sheared(segments)).unwrap();
    let banded = rod.stiffness().unwrap();
    let full = DMatrix::from_fn(banded.order(), banded.order(), |i, j| {
        let (row, column) = (i.max(j), i.min(j));
        banded.column(column).get(row - column).copied().unwrap_or(0.0)
    });
    // Moments come first of the three unknowns of a node; y is the last.
    let moments: Vec<_> = (0..segments).map(|k| 3 * k).collect();
    let y: Vec<_> = (0..segments).map(|k| 3 * k + 2).collect();
    let pick = |rows: &[usize], columns: &[usize]| full.select_rows(rows).select_columns(columns);
    let coupling = pick(&moments, &y);
    let condensed = pick(&y, &y) - coupling.transpose() * pick(&moments, &moments).lu().solve(&coupling).unwrap();
    let scale = DVector::from_fn(segments, |k, _| {
        let share = if k + 1 == segments { 0.5 } else { 1.0 };
        (segments as f64 / share).sqrt()
    });
    let scaled = DMatrix::from_diagonal(&scale) * condensed * DMatrix::from_diagonal(&scale);
    let mut omega: Vec<_> = scaled.symmetric_eigenvalues().iter().map(|square| square.sqrt()).collect();
    omega.sort_by(f64::total_cmp);
    omega
}

/// Zero at the natural frequencies: of w = A cosh ax + B sinh ax + C cos bx + D sin bx with EI w'''' + (ω² EI/GA_s) w'' = ω² w the conditions
/// w = φ = 0 at the clamp and M = Q = 0 at the tip, where M = EI (w'' + ω² w/GA_s), Q = −M' and φ = w' − Q/GA_s.
fn determinant(omega: f64) -> f64 {
    let square = omega * omega;
    let half = 0.5 * square / SHEAR;
    let root = (half * half + square).sqrt();
    let (a, b) = ((root - half).sqrt(), (root + half).sqrt());
    // w, w', w'' and w''' of the four functions at x.
    let derivatives = |x: f64| {
        let (sinh, cosh, (sin, cos)) = ((a * x).sinh(), (a * x).cosh(), (b * x).sin_cos());
        [
            RowVector4::new(cosh, sinh, cos, sin),
            RowVector4::new(a * sinh, a * cosh, -b * sin, b * cos),
            RowVector4::new(a * a * cosh, a * a * sinh, -b * b * cos, -b * b * sin),
            RowVector4::new(a.powi(3) * sinh, a.powi(3) * cosh, b.powi(3) * sin, -b.powi(3) * cos),
        ]
    };
    let ([w, slope, _, third], [tip, tip_slope, tip_second, tip_third]) = (derivatives(0.0), derivatives(1.0));
    let turning = slope + (third + slope * (square / SHEAR)) / SHEAR;
    let moment = tip_second + tip * (square / SHEAR);
    let shear = tip_third + tip_slope * (square / SHEAR);
    Matrix4::from_rows(&[w, turning, moment, shear]).determinant()
}
