//! Rod with shear, against the beam of Timoshenko.

use nalgebra::{DMatrix, DVector, Matrix4, RowVector4};
use nervure_rod::{Parameters, Rod, Scheme, Section};

use crate::common::unit_rod;

/// GA_s of a rod with length and bending stiffness 1: shear is a twentieth of the deflection of the tip.
const SHEAR: f64 = 60.0;

fn sheared(segments: usize) -> Parameters<2> {
    let rod = unit_rod::<2>(segments, 1e6, Scheme::Trapezoid);
    Parameters { section: Section { shear_stiffness: Some(SHEAR), ..rod.section }, ..rod }
}

/// A small force P deflects the tip by P L³/(3 EI) + P L/GA_s, and a clamp compliance length d adds P L² d/EI.
#[test]
fn tip_deflection_is_timoshenkos() {
    let (force, setback) = (1e-4, 0.01);
    let exact = force * (1.0 / 3.0 + 1.0 / SHEAR + setback);
    let errors = [20, 40].map(|segments| {
        let mut rod = Rod::new(Parameters { clamp_compliance_length: setback, ..sheared(segments) }).unwrap();
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

/// The first three natural frequencies agree with the cantilever of Timoshenko without rotary inertia, to second order.
#[test]
fn natural_frequencies_are_timoshenkos() {
    let [coarse, fine] = [30, 60].map(|segments| modes(segments).0);
    for (mode, exact) in exact_frequencies::<3>().into_iter().enumerate() {
        let errors = [coarse[mode] / exact - 1.0, fine[mode] / exact - 1.0];
        assert!(errors[1].abs() < 3e-3, "mode {mode}, omega {exact}: {errors:?}");
        let ratio = errors[0] / errors[1];
        assert!((3.7..4.3).contains(&ratio), "mode {mode} is not of second order: {errors:?}");
    }
}

/// The rod vibrates at these frequencies in time, too. Rotary inertia would lower the third frequency by some per cent.
#[test]
fn sheared_rod_vibrates_without_rotary_inertia() {
    const SEGMENTS: usize = 60;
    let exact = exact_frequencies::<3>();
    let (_, shapes) = modes(SEGMENTS);
    for (mode, exact) in exact.into_iter().enumerate() {
        let mut rod = Rod::new(sheared(SEGMENTS)).unwrap();
        let mut state = rod.state().clone();
        for (k, v) in state.velocities.iter_mut().enumerate().skip(1) {
            v[1] = 1e-4 * shapes[mode][k - 1];
        }
        rod.restore(&state).unwrap();
        // Four periods in steps with an error of the trapezoid of 1e-4.
        let period = std::f64::consts::TAU / exact;
        let (steps, dt) = (4 * 180, period / 180.0);
        let (mut last, mut crossings) = (0.0, Vec::new());
        for step in 1..=steps + 90 {
            rod.step(dt).unwrap();
            let now: f64 = rod.positions(1)[1..].iter().zip(&shapes[mode]).map(|(y, shape)| y * shape).sum();
            if last * now < 0.0 {
                crossings.push(dt * (step as f64 - now / (now - last)));
            }
            last = now;
        }
        let half_periods = (crossings.len() - 1) as f64;
        let found = std::f64::consts::PI * half_periods / (crossings.last().unwrap() - crossings[0]);
        let error = found / exact - 1.0;
        assert!(error.abs() < 4e-3, "mode {mode}: omega {found} against {exact}, {error:+.2e}");
    }
}

/// Return the lowest zeros of `determinant`.
fn exact_frequencies<const N: usize>() -> [f64; N] {
    let (mut low, mut found) = (0.5, 0);
    let mut exact = [0.0; N];
    let (mut omega, mut sign) = (low, determinant(low) > 0.0);
    while found < N {
        omega += 0.5;
        if (determinant(omega) > 0.0) != sign {
            let (mut below, mut above) = (low, omega);
            for _ in 0..60 {
                let middle = 0.5 * (below + above);
                if (determinant(middle) > 0.0) == sign { below = middle } else { above = middle }
            }
            exact[found] = below;
            sign = !sign;
            found += 1;
        }
        low = omega;
    }
    exact
}

/// Return the angular frequencies of small transverse vibrations, the lowest first, and the shapes of the nodes from 1
/// on.
fn modes(segments: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut rod = Rod::new(sheared(segments)).unwrap();
    let banded = rod.stiffness().unwrap();
    let full = DMatrix::from_fn(banded.order(), banded.order(), |i, j| {
        let (row, column) = (i.max(j), i.min(j));
        banded.column(column).get(row - column).copied().unwrap_or(0.0)
    });
    // The three unknowns of a node are moment, x and y.
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
    let eigen = scaled.symmetric_eigen();
    let mut order: Vec<_> = (0..segments).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let shape = |i: usize| eigen.eigenvectors.column(i).component_mul(&scale).as_slice().to_vec();
    (order.iter().map(|&i| eigen.eigenvalues[i].sqrt()).collect(), order.iter().map(|&i| shape(i)).collect())
}

/// Zero at the natural frequencies: of w = A cosh ax + B sinh ax + C cos bx + D sin bx with EI w'''' + (ω² EI/GA_s) w''
/// = ω² w the conditions w = φ = 0 at the clamp and M = Q = 0 at the tip, where M = EI (w'' + ω² w/GA_s), Q = −M' and φ
/// = w' − Q/GA_s.
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
