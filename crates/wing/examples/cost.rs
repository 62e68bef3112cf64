//! Milliseconds of processor time of a step by the number of nodes, beside one factorisation alone: CSV on the standard
//! output.
//!
//! A cantilever film flaps in gravity: 0.2 m by 0.1 m, E 100 MPa, 1 mm, steps of 1 ms.

use std::time::{SystemTime, UNIX_EPOCH};

use nervure_wing::{Error, Membrane, Parameters, Root, WingError, rectangle};

fn main() -> Result<(), Error> {
    println!("nodes,unknowns,factor,iterations,factorisations,step_ms,factorise_ms");
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
        let factorise = (0..steps).try_fold(0.0, |sum, _| {
            Ok::<_, Error>(sum + time(|| wing.factorise_once().then_some(()).ok_or(WingError::Singular.into()))?)
        })?;
        println!(
            "{},{unknowns},{factor},{:.1},{:.1},{:.2},{:.2}",
            wing.nodes(),
            iterations as f64 / f64::from(steps),
            factorisations as f64 / f64::from(steps),
            1e3 * step / f64::from(steps),
            1e3 * factorise / f64::from(steps)
        );
    }
    Ok(())
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
