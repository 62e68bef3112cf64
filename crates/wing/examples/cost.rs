//! Milliseconds of a step by the number of nodes, beside one factorisation alone: CSV on the standard
//! output.
//!
//! A cantilever film flaps in gravity: 0.2 m by 0.1 m, E 100 MPa, 1 mm, steps of 1 ms.

use std::time::Instant;

use nervure_wing::{Error, Membrane, Parameters, Root, rectangle};

fn main() -> Result<(), Error> {
    println!("nodes,unknowns,factor,iterations,factorisations,step_ms,factorise_ms");
    for along in [10, 20, 43, 60, 100, 200] {
        let mesh = rectangle(0.2, 0.1, along);
        let root = Root { nodes: mesh.chain("root").unwrap_or_default().to_vec(), ..Root::default() };
        let film = Membrane::plate(1e8, 0.3, 1e-3, 1000.0);
        let gravity = [0.0, 0.0, -9.81];
        let mut wing = Parameters { root, gravity, ..Parameters::new(mesh, film) }.build()?;
        let steps = if along < 100 { 20 } else { 5 };
        let (mut times, mut iterations, mut factorisations) = (Vec::new(), 0, 0);
        for _ in 0..steps {
            let start = Instant::now();
            wing.step(1e-3)?;
            times.push(start.elapsed().as_secs_f64());
            iterations += wing.statistics().iterations;
            factorisations += wing.statistics().factorisations;
        }
        let [unknowns, factor] = wing.size_of_system();
        let factorise = (0..3).map(|_| time(|| wing.factorise_once())).fold(f64::INFINITY, f64::min);
        times.sort_by(f64::total_cmp);
        println!(
            "{},{unknowns},{factor},{:.1},{:.1},{:.2},{:.2}",
            wing.nodes(),
            iterations as f64 / f64::from(steps),
            factorisations as f64 / f64::from(steps),
            1e3 * times[times.len() / 2],
            1e3 * factorise
        );
    }
    Ok(())
}

fn time<T>(run: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}
