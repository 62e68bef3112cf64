//! Condition numbers of the full Jacobian of the trapezoidal step (thesis tables 2.1 and 2.2, figure 2.5).
//!
//! J = [[1, −dt/2], [dt/2 K, m]] over positions and velocities of the n − 1 free points, the rod straight, L = EI = mu = 1,
//! h = L/n, in the 1-norm. Beside it the matrix that is really factorised, K + 4 m/dt², with the velocities eliminated.

use faer::Mat;
use faer::linalg::solvers::DenseSolveCore;
use nervure_rod::{Calibration, Parameters, Section};

use crate::rods::{build, entry, thesis_beam};
use crate::{Table, row};

pub fn table() -> Table {
    let mut table = vec!["n,order,k_e,dt,full,eliminated".to_string()];
    for (k_e, dt) in [(5e4, 1e-3), (1e5, 1e-3), (2e5, 1e-3), (1e5, 1e-2)] {
        for n in [32, 64, 128, 256, 512] {
            let [full, eliminated] = conditions(n, k_e, dt).map(|number| format!("{number:.6e}"));
            table.push(row(&[&n, &(6 * (n - 1)), &k_e, &dt, &full, &eliminated]));
        }
    }
    table
}

/// Of the full Jacobian and of the one without velocities.
fn conditions(n: usize, k_e: f64, dt: f64) -> [f64; 2] {
    let h = 1.0 / n as f64;
    let stiffness = build(Parameters {
        length: h * (n - 1) as f64,
        section: Section { line_density: 1.0, bending_stiffness: 1.0, axial_stiffness: 1.0, shear_stiffness: None },
        calibration: Calibration::Thesis { k_e },
        ..thesis_beam::<3>(n - 1)
    })
    .stiffness()
    .expect("a straight rod has no fold");
    let order = stiffness.order();
    let k = |i, j| entry(&stiffness, i, j);
    let full = Mat::from_fn(2 * order, 2 * order, |i, j| match (i < order, j < order) {
        (true, true) => f64::from(i == j),
        (true, false) => -0.5 * dt * f64::from(i == j - order),
        (false, true) => 0.5 * dt * k(i - order, j),
        (false, false) => h * f64::from(i == j),
    });
    let eliminated = Mat::from_fn(order, order, |i, j| k(i, j) + 4.0 * h / (dt * dt) * f64::from(i == j));
    [full, eliminated].map(|matrix| norm_1(&matrix) * norm_1(&inverse(&matrix)))
}

pub fn inverse(matrix: &Mat<f64>) -> Mat<f64> {
    matrix.partial_piv_lu().inverse()
}

/// Largest sum of a column's magnitudes.
pub fn norm_1(matrix: &Mat<f64>) -> f64 {
    (0..matrix.ncols()).map(|j| matrix.col(j).norm_l1()).fold(0.0, f64::max)
}
