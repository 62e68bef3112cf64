//! Run time against the number of segments (thesis table 2.3, figure 2.6), in space.
//!
//! All solvers get the same matrix, that of the first Newton iteration of a step of the thesis' beam; the rest of an
//! iteration (derivatives, assembly, check of the residual) is the library's own.

use std::hint::black_box;
use std::time::Instant;

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::LltError;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::{Mat, Side};
use rod::{Banded, Rod};

use crate::Table;
use crate::matrices::{DT, newton_matrix, to_sparse};
use crate::rods::thesis_beam;

pub fn table() -> Table {
    let mut table =
        Table::new("n,iterations_per_step,iteration_3d,iteration_2d,banded,sparse,dense,thesis_sparse,thesis_dense");
    let thesis = [
        (8, 32.514, 30.042),
        (16, 37.006, 36.388),
        (32, 46.888, 50.297),
        (64, 81.209, 104.936),
        (128, 216.240, 359.969),
        (256, 1142.829, 2014.8),
        (512, 3511.771, 10166.194),
        (1024, 16337.062, 53284.245),
    ];
    for n in (3..14).map(|k| 1 << k) {
        let (spatial, iterations) = iteration_time::<3>(n);
        let (planar, _) = iteration_time::<2>(n);
        let matrix = newton_matrix(n);
        let (sparse_thesis, dense_thesis) = thesis
            .iter()
            .find(|row| row.0 == n)
            .map_or_else(Default::default, |row| (row.1.to_string(), row.2.to_string()));
        let dense = if n <= 1024 { dense_time(&matrix).to_string() } else { String::new() };
        table.push(&[
            &n,
            &iterations,
            &spatial,
            &planar,
            &banded_time(&matrix),
            &sparse_time(&matrix),
            &dense,
            &sparse_thesis,
            &dense_thesis,
        ]);
    }
    table
}

/// Seconds of a step by its iterations, and the mean number of these: the beam falls from rest.
fn iteration_time<const D: usize>(n: usize) -> (f64, f64) {
    let mut rod = Rod::new(thesis_beam::<D>(n)).expect("these parameters are good");
    let steps = (163_840 / n).clamp(100, 2000);
    let mut iterations = 0;
    let times = (0..steps)
        .map(|_| {
            let start = Instant::now();
            rod.step(DT).expect("an easy step");
            iterations += rod.statistics().iterations;
            start.elapsed().as_secs_f64() / rod.statistics().iterations as f64
        })
        .collect();
    (undisturbed(times), iterations as f64 / steps as f64)
}

fn banded_time(matrix: &Banded) -> f64 {
    repeat(matrix.order(), || {
        let mut factors = matrix.clone();
        let mut b = vec![1.0; matrix.order()];
        let start = Instant::now();
        factors.factorise().expect("a positive definite matrix");
        factors.solve(&mut b);
        let seconds = start.elapsed().as_secs_f64();
        black_box(b);
        seconds
    })
}

/// faer's sparse Cholesky: the numeric part, the symbolic one being done once.
fn sparse_time(matrix: &Banded) -> f64 {
    let sparse = to_sparse(matrix);
    let symbolic = SymbolicLlt::try_new(sparse.symbolic(), Side::Lower).expect("enough memory");
    repeat(matrix.order(), || {
        let mut b = Mat::from_fn(matrix.order(), 1, |_, _| 1.0);
        let start = Instant::now();
        let factors: Result<_, LltError> = Llt::try_new_with_symbolic(symbolic.clone(), sparse.as_ref(), Side::Lower);
        factors.expect("a positive definite matrix").solve_in_place(&mut b);
        let seconds = start.elapsed().as_secs_f64();
        black_box(b);
        seconds
    })
}

fn dense_time(matrix: &Banded) -> f64 {
    let sparse = to_sparse(matrix);
    let mut dense = sparse.to_dense();
    for j in 0..dense.ncols() {
        for i in 0..j {
            dense[(i, j)] = dense[(j, i)];
        }
    }
    repeat(matrix.order() * matrix.order(), || {
        let mut b = Mat::from_fn(matrix.order(), 1, |_, _| 1.0);
        let start = Instant::now();
        dense.llt(Side::Lower).expect("a positive definite matrix").solve_in_place(&mut b);
        let seconds = start.elapsed().as_secs_f64();
        black_box(b);
        seconds
    })
}

/// As many runs as `size` leaves time for.
fn repeat(size: usize, mut run: impl FnMut() -> f64) -> f64 {
    undisturbed((0..(1_000_000 / size).clamp(3, 300)).map(|_| run()).collect())
}

/// The lower decile: what a machine that others use as well takes when it is left alone.
fn undisturbed(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 10]
}
