//! The cantilever whose thickness falls in a straight line to a fifth at the tip: errors and condition number by n.
//!
//! L = EI = mu = 1 and EA = 1e4 at the root. The condition number is that of K + 4 m/dt² with dt = 1e-3, in the 1-norm, and
//! beside it that of the same rod without taper.

use faer::{Mat, Side};
use nervure_rod::{Parameters, Scheme, Taper};

use crate::common::unit_rod;
use crate::condition::norm_1;
use crate::rods::{build, entry};
use crate::{Table, row};

/// Thickness at the tip by that at the root.
const TIP: f64 = 0.2;
/// Circular frequencies by the Ritz method (`tests/all/taper.rs` finds them anew).
const FREQUENCIES: [f64; 3] = [4.292_494_539, 15.742_700_171, 36.884_553_264];
const LOAD: f64 = 1e-5;
const DT: f64 = 1e-3;

pub fn table() -> Table {
    let mut table = vec!["n,deflection,first,second,third,tapered,even".to_string()];
    // ∫ (1 − s)²/h³ ds with h = 1 − (1 − b) s, b being that of the tip.
    let exact = LOAD * (2.0 * TIP - 0.5 * TIP * TIP - TIP.ln() - 1.5) / (1.0 - TIP).powi(3);
    for n in [8, 16, 32, 64, 128, 256] {
        let mut rod = build(plate(n));
        rod.loads.force = vec![0.0; 2 * (n + 1)];
        rod.loads.force[2 * n + 1] = LOAD;
        rod.solve_static().expect("a small load");
        let deflection = rod.tip_displacement()[1] / exact - 1.0;
        let found = frequencies(n);
        let errors: [f64; 3] = std::array::from_fn(|mode| found[mode] / FREQUENCIES[mode] - 1.0);
        let [tapered, even] = [plate(n), unit_rod(n, 1e4, Scheme::TrBdf2)].map(condition);
        table.push(row(&[&n, &deflection, &errors[0], &errors[1], &errors[2], &tapered, &even]));
    }
    table
}

fn plate(n: usize) -> Parameters<2> {
    let along = |power: i32| {
        let thickness = |i: usize| 1.0 - (1.0 - TIP) * i as f64 / (2 * n) as f64;
        (0..=2 * n).map(|i| thickness(i).powi(power)).collect()
    };
    let taper =
        Taper { line_density: along(1), bending_stiffness: along(3), axial_stiffness: along(1), ..Taper::default() };
    Parameters { taper, ..unit_rod(n, 1e4, Scheme::TrBdf2) }
}

/// Of vibrations across the rod, which is straight along x.
fn frequencies(n: usize) -> Vec<f64> {
    let mut rod = build(plate(n));
    let (stiffness, masses) = (rod.stiffness().expect("no fold"), rod.masses());
    let reduced =
        Mat::from_fn(n, n, |i, j| entry(&stiffness, 2 * i + 1, 2 * j + 1) / (masses[i + 1] * masses[j + 1]).sqrt());
    let squares = reduced.self_adjoint_eigenvalues(Side::Lower).expect("a symmetric matrix");
    squares.into_iter().map(f64::sqrt).collect()
}

fn condition(parameters: Parameters<2>) -> f64 {
    let mut rod = build(parameters);
    let (stiffness, masses) = (rod.stiffness().expect("no fold"), rod.masses());
    let order = stiffness.order();
    let matrix = Mat::from_fn(order, order, |i, j| {
        entry(&stiffness, i, j) + if i == j { 4.0 * masses[i / 2 + 1] / (DT * DT) } else { 0.0 }
    });
    norm_1(&matrix) * norm_1(&crate::condition::inverse(&matrix))
}
