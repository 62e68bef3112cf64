//! One Newton iteration, and the solve in it against faer's sparse Cholesky on the same matrix, on one core.

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::{Mat, Side};
use rod::Rod;

#[path = "../src/matrices.rs"]
mod matrices;
#[path = "../src/rods.rs"]
#[allow(dead_code, reason = "the benchmark uses a part of it")]
mod rods;

use matrices::{newton_matrix, to_sparse};
use rods::thesis_beam;

/// A step of 1e-3 s of BDF2 that takes one iteration: everything that an iteration does, and what a step adds to it.
fn iteration<const D: usize>(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group(format!("iteration in {D}D"));
    for n in [64, 256, 1024, 4096, 8192] {
        let parameters = rod::Parameters { scheme: scene::RodScheme::Bdf2, ..thesis_beam::<D>(n) };
        let mut rod = Rod::new(parameters).expect("these parameters are good");
        rod.step(1e-3).expect("an easy step");
        let start = rod.state().clone();
        group.bench_function(BenchmarkId::from_parameter(n), |bencher| {
            bencher.iter(|| {
                rod.step(1e-3).expect("an easy step");
                if rod.statistics().iterations != 1 {
                    rod.restore(&start).expect("a state of this rod");
                }
            });
        });
    }
    group.finish();
}

fn solve(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("factorise and solve in 3D");
    for n in [64, 1024, 8192] {
        let matrix = newton_matrix(n);
        let order = matrix.order();
        group.bench_function(BenchmarkId::new("banded", n), |bencher| {
            let fresh = || (matrix.clone(), vec![1.0; order]);
            bencher.iter_batched_ref(
                fresh,
                |(factors, b)| {
                    factors.factorise().expect("a positive definite matrix");
                    factors.solve(b);
                },
                BatchSize::LargeInput,
            );
        });
        let sparse = to_sparse(&matrix);
        let symbolic = SymbolicLlt::try_new(sparse.symbolic(), Side::Lower).expect("enough memory");
        group.bench_function(BenchmarkId::new("faer sparse Cholesky", n), |bencher| {
            let fresh = || (symbolic.clone(), Mat::from_fn(order, 1, |_, _| 1.0));
            bencher.iter_batched_ref(
                fresh,
                |(symbolic, b)| {
                    let factors = Llt::try_new_with_symbolic(symbolic.clone(), sparse.as_ref(), Side::Lower);
                    factors.expect("a positive definite matrix").solve_in_place(b.as_mut());
                },
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, iteration::<2>, iteration::<3>, solve);
criterion_main!(benches);
