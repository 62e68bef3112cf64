//! Run time against the number of segments (thesis table 2.3, figure 2.6), in space; an iteration in the plane beside it.
//!
//! All solvers get the same matrix, that of the first Newton iteration of a step of the thesis' beam; the rest of an
//! iteration (derivatives, assembly, check of the residual) is the library's own. Times are medians.

use std::hint::black_box;
use std::time::Instant;

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use nervure_rod::{Banded, Parameters};

use crate::rods::{build, entry, thesis_beam};
use crate::{Table, row};

/// Step, s.
const DT: f64 = 1e-3;

/// Seconds that the thesis prints for n = 8 … 1024.
const SPARSE: [f64; 8] = [32.514, 37.006, 46.888, 81.209, 216.240, 1142.829, 3511.771, 16337.062];
const DENSE: [f64; 8] = [30.042, 36.388, 50.297, 104.936, 359.969, 2014.8, 10166.194, 53284.245];

pub fn table() -> Table {
    let mut table = vec![
        "n,iterations_per_step,iteration_3d,iteration_2d,banded,sparse,dense,thesis_sparse,thesis_dense".to_string(),
    ];
    for k in 0..11 {
        let n = 8 << k;
        let ((spatial, iterations), (planar, _)) = (iteration_time::<3>(n), iteration_time::<2>(n));
        let [banded, sparse, dense] = solver_times(&newton_matrix(n));
        let [sparse_then, dense_then] =
            [SPARSE, DENSE].map(|times| times.get(k).map_or_else(String::new, f64::to_string));
        table.push(row(&[&n, &iterations, &spatial, &planar, &banded, &sparse, &dense, &sparse_then, &dense_then]));
    }
    table
}

/// Seconds of a step by its iterations, and the mean number of these: the beam falls from rest.
fn iteration_time<const D: usize>(n: usize) -> (f64, f64) {
    let mut rod = build(thesis_beam::<D>(n));
    let steps = (163_840 / n).clamp(100, 2000);
    let mut iterations = 0;
    let times = (0..steps).map(|_| {
        let start = Instant::now();
        rod.step(DT).expect("an easy step");
        iterations += rod.statistics().iterations;
        start.elapsed().as_secs_f64() / rod.statistics().iterations as f64
    });
    (median(times.collect()), iterations as f64 / steps as f64)
}

/// K + 4 m/dt² of the thesis' beam in space, bending in the diagonal plane, so that no entry of the band vanishes.
fn newton_matrix(n: usize) -> Banded {
    let mut rod = build(Parameters { gravity: [0.0, -0.5, -0.5], ..thesis_beam::<3>(n) });
    (0..5).for_each(|_| rod.step(DT).expect("an easy step"));
    let mut matrix = rod.stiffness().expect("a shape that steps have reached");
    let inertia = 4.0 * 0.0571 / n as f64 / (DT * DT);
    (0..matrix.order()).for_each(|j| matrix.column_mut(j)[0] += inertia);
    matrix
}

/// Factorise and solve: banded, by faer's sparse Cholesky, whose symbolic part is done once, and up to n = 1024 its dense one.
fn solver_times(matrix: &Banded) -> [String; 3] {
    let (order, good) = (matrix.order(), "a positive definite matrix");
    let copies = || (matrix.clone(), vec![1.0; order]);
    let banded = time(order, copies, |(factors, b)| {
        factors.factorise().expect(good);
        factors.solve(b);
    });
    let below = |j| j..order.min(j + matrix.half_bandwidth() + 1);
    let lower = (0..order).flat_map(|j| below(j).map(move |i| Triplet::new(i, j, entry(matrix, i, j))));
    let entries: Vec<_> = lower.filter(|entry| entry.val != 0.0).collect();
    let faers = SparseColMat::<usize, f64>::try_new_from_triplets(order, order, &entries).expect("entries inside");
    let symbolic = SymbolicLlt::try_new(faers.symbolic(), Side::Lower).expect("enough memory");
    let ones = || Mat::from_fn(order, 1, |_, _| 1.0);
    let sparse = time(order, ones, |b| {
        let factors = Llt::try_new_with_symbolic(symbolic.clone(), faers.as_ref(), Side::Lower);
        factors.expect(good).solve_in_place(b);
    });
    if order > 3 * 1024 {
        return [banded.to_string(), sparse.to_string(), String::new()];
    }
    let full = Mat::from_fn(order, order, |i, j| entry(matrix, i, j));
    let dense = time(order * order, ones, |b| full.llt(Side::Lower).expect(good).solve_in_place(b));
    [banded, sparse, dense].map(|seconds| seconds.to_string())
}

/// Of as many runs as `size` leaves time for, each on a fresh input.
fn time<T>(size: usize, fresh: impl Fn() -> T, run: impl Fn(&mut T)) -> f64 {
    let times = (0..(1_000_000 / size).clamp(3, 300)).map(|_| {
        let mut input = fresh();
        let start = Instant::now();
        run(black_box(&mut input));
        let seconds = start.elapsed().as_secs_f64();
        black_box(input);
        seconds
    });
    median(times.collect())
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
