//! Milliseconds of processor time of a step by the number of nodes, beside one factorisation alone, by this crate and by
//! faer in its own order: CSV on the standard output. Each matrix goes to the folder that is named, if one is: one entry
//! (row, column, value) of its lower triangle in a line.
//!
//! A cantilever film flaps in gravity: 0.2 m by 0.1 m, E 100 MPa, 1 mm, steps of 1 ms.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{SymmetricOrdering, factorize_symbolic_cholesky};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};
use nervure_wing::{Error, Membrane, Parameters, Root, Wing, WingError, rectangle};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let folder = std::env::args_os().nth(1).map(PathBuf::from);
    println!("nodes,unknowns,factor,iterations,factorisations,step_ms,factorise_ms,faer_ms");
    for along in [10, 20, 43, 60, 100, 200] {
        let mesh = rectangle(0.2, 0.1, along);
        let root = Root { nodes: mesh.chain("root").unwrap_or_default().to_vec(), ..Root::default() };
        let film = Membrane::plate(1e8, 0.3, 1e-3, 1000.0);
        let gravity = [0.0, 0.0, -9.81];
        let mut wing = Parameters { root, gravity, ..Parameters::new(mesh, film) }.build()?;
        let steps = if along < 50 { 100 } else { 5 };
        let (mut step, mut iterations, mut factorisations) = (0.0, 0, 0);
        for _ in 0..steps {
            step += time(|| wing.step(1e-3))?;
            iterations += wing.statistics().iterations;
            factorisations += wing.statistics().factorisations;
        }
        let [unknowns, factor] = wing.size_of_system();
        // Together: a single factorisation of a small matrix is shorter than the clock's steps.
        let factorise = time(|| {
            let all = (0..steps).all(|_| wing.factorise_once());
            all.then_some(()).ok_or_else(|| WingError::Singular.into())
        })?;
        let faer = faer(&wing, steps)?;
        if let Some(folder) = &folder {
            write(&wing, &folder.join(format!("{}.txt", wing.nodes())))?;
        }
        println!(
            "{},{unknowns},{factor},{:.1},{:.1},{:.2},{:.2},{:.2}",
            wing.nodes(),
            iterations as f64 / f64::from(steps),
            factorisations as f64 / f64::from(steps),
            1e3 * step / f64::from(steps),
            1e3 * factorise / f64::from(steps),
            1e3 * faer / f64::from(steps)
        );
    }
    Ok(())
}

/// Return the time of some factorisations of the last matrix by faer, s.
fn faer(wing: &Wing, times: u32) -> Result<f64, Failure> {
    let (columns, rows, values) = wing.matrix();
    let order = columns.len() - 1;
    let pattern = SymbolicSparseColMatRef::new_checked(order, order, columns, None, rows);
    let symbolic = factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, Default::default())
        .map_err(|error| format!("{error:?}"))?;
    let matrix = SparseColMatRef::new(pattern, values);
    let mut room = MemBuffer::new(symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()));
    let mut factors = vec![0.0; symbolic.len_val()];
    let stack = MemStack::new(&mut room);
    let start = seconds();
    for _ in 0..times {
        let (regularization, parameters) = Default::default();
        symbolic
            .factorize_numeric_llt(&mut factors, matrix, Side::Lower, regularization, Par::Seq, stack, parameters)
            .map_err(|error| format!("{error:?}"))?;
    }
    Ok(seconds() - start)
}

/// Write the entries of the last matrix.
fn write(wing: &Wing, path: &Path) -> std::io::Result<()> {
    let (columns, rows, values) = wing.matrix();
    let lines = columns
        .windows(2)
        .enumerate()
        .flat_map(|(column, ends)| (ends[0]..ends[1]).map(move |k| format!("{} {column} {:e}\n", rows[k], values[k])));
    std::fs::write(path, lines.collect::<String>())
}

fn time(run: impl FnOnce() -> Result<(), Error>) -> Result<f64, Error> {
    let start = seconds();
    run()?;
    Ok(seconds() - start)
}

/// Return the processor time of this thread, or the time of the day where Linux is not.
fn seconds() -> f64 {
    let own = std::fs::read_to_string("/proc/thread-self/schedstat");
    let nanoseconds = own.ok().and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64());
    nanoseconds.map_or_else(now, |time| 1e-9 * time)
}
