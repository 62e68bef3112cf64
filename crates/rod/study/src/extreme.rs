//! Stiff and extreme cases: each ends in an energy error or in an error with its cause.

use std::time::Instant;

use rod::{Error, Parameters, Rod};
use scene::Section;

use crate::Table;
use crate::rods::{SCHEMES, thesis_beam, total_energy};

/// Steps of a cell.
const STEPS: usize = 50;
/// Steps without a load until no formula holds a loaded level any more.
const LEVELS: usize = 3;
/// Gain of energy that a dissipative scheme must not exceed.
const LARGEST_GAIN: f64 = 0.01;

/// What became of a run.
struct Outcome {
    result: String,
    /// Largest energy above that of the start, by the largest energy that moved.
    gain: f64,
    loss: f64,
    seconds: f64,
    iterations: usize,
    substeps: usize,
}

/// The beam released from rest in its weight, for every k_e of a segment (N/m), EI (N m²), step (s) and n.
pub fn table() -> Table {
    let mut table = Table::new("n,k_e,EI,dt,result,gain,loss,worst_step_seconds,iterations,substeps");
    for n in [8, 32, 128, 512, 2048] {
        eprintln!("  n = {n}");
        for k_e in (3..=9).map(|k| 10_f64.powi(k)) {
            for bending_stiffness in (-6..=3).map(|k| 10_f64.powi(k)) {
                for dt in (-5..=-1).map(|k| 10_f64.powi(k)) {
                    let axial_stiffness = k_e / n as f64;
                    let section = Section { line_density: 0.0571, bending_stiffness, axial_stiffness, shear_stiffness: None };
                    let rod = Rod::new(Parameters { section, ..thesis_beam::<2>(n) });
                    let outcome = run(rod.expect("these parameters are good"), dt, STEPS, |_, _| ());
                    push(&mut table, &[&n, &k_e, &bending_stiffness, &dt], &outcome);
                }
            }
        }
    }
    table
}

fn push(table: &mut Table, cell: &[&dyn std::fmt::Display], outcome: &Outcome) {
    let Outcome { result, gain, loss, seconds, iterations, substeps } = outcome;
    let numbers = [format!("{gain:.1e}"), format!("{loss:.1e}"), format!("{seconds:.4}")];
    let mut cells: Vec<&dyn std::fmt::Display> = cell.to_vec();
    cells.push(result);
    cells.extend(numbers.iter().map(|number| number as &dyn std::fmt::Display));
    cells.push(iterations);
    cells.push(substeps);
    table.push(&cells);
}

/// `steps` steps of `dt` after `drive` has set the loads of each; energies count while there are none.
fn run<const D: usize>(mut rod: Rod<D>, dt: f64, steps: usize, mut drive: impl FnMut(&mut Rod<D>, usize)) -> Outcome {
    let mut outcome = Outcome { result: String::new(), gain: 0.0, loss: 0.0, seconds: 0.0, iterations: 0, substeps: 0 };
    let (mut start, mut low, mut high, mut scale) = (total_energy(&rod), 0.0_f64, 0.0_f64, f64::MIN_POSITIVE);
    let mut unloaded = LEVELS;
    for step in 0..steps {
        drive(&mut rod, step);
        let loaded = rod.loads.force.iter().any(|&force| force != 0.0);
        unloaded = if loaded { 0 } else { unloaded + 1 };
        let clock = Instant::now();
        let result = rod.step(dt);
        outcome.seconds = outcome.seconds.max(clock.elapsed().as_secs_f64());
        outcome.iterations = outcome.iterations.max(rod.statistics().iterations);
        outcome.substeps = outcome.substeps.max(rod.statistics().substeps);
        if let Err(error) = result {
            outcome.result = format!("{} in step {}: {error}", cause(&error), step + 1);
            return outcome;
        }
        let Ok(energy) = rod.energy() else {
            outcome.result = "no energy".into();
            return outcome;
        };
        let total = total_energy(&rod);
        scale = scale.max(energy.gravity.abs()).max(energy.kinetic).max(energy.stretching + energy.bending);
        if unloaded < LEVELS {
            start = total;
        } else {
            (low, high) = (low.min(total - start), high.max(total - start));
        }
        if !total.is_finite() {
            outcome.result = "an energy that is no number".into();
            return outcome;
        }
    }
    (outcome.gain, outcome.loss) = (high / scale, -low / scale);
    outcome.result = if outcome.gain > LARGEST_GAIN { "gain of energy".into() } else { "ok".into() };
    outcome
}

fn cause(error: &Error) -> &'static str {
    match error {
        Error::NotConverged { .. } => "not converged",
        Error::FoldBack { .. } => "folds back",
        Error::EnergyGain { .. } => "stopped for a gain of energy",
        _ => "refused",
    }
}

/// Named situations with every scheme, in space where they leave the plane.
pub fn situations() -> Table {
    let mut table = Table::new("situation,scheme,result,gain,loss,worst_step_seconds,iterations,substeps");
    for (name, scheme) in SCHEMES {
        let beam = || Parameters { scheme, ..thesis_beam::<3>(64) };
        let calm = || Parameters { gravity: [0.0; 3], ..beam() };
        let with_ratio = |ratio: f64| {
            let mut parameters = beam();
            // k_e/EI of a segment, in 1/(m³).
            parameters.section.axial_stiffness = ratio * parameters.section.bending_stiffness / 64.0;
            parameters
        };
        let tip = |rod: &mut Rod<3>, force: [f64; 3]| {
            rod.loads.force = vec![0.0; 3 * 65];
            (0..3).for_each(|d| rod.loads.force[d * 65 + 64] = force[d]);
        };
        let build = |parameters| Rod::new(parameters).expect("these parameters are good");
        let pushed = |force: [f64; 3], until: usize| {
            move |rod: &mut Rod<3>, step: usize| tip(rod, if step < until { force } else { [0.0; 3] })
        };
        let mut upright = beam();
        upright.direction = [0.0, 0.0, 1.0];
        upright.gravity = [0.0, 0.001, -40.0];
        let mut soft = beam();
        soft.section.bending_stiffness = 1e-4;
        for (situation, outcome) in [
            ("swings past vertical: EI 1e-4, falls from level", run(build(soft.clone()), 5e-3, 600, |_, _| ())),
            ("buckles: upright in 20 times the critical weight", run(build(upright), 5e-3, 600, |_, _| ())),
            ("compressed along its axis by 10 EI/L², 1e-6 aside, released", {
                run(build(calm()), 5e-3, 600, pushed([-0.259, 1e-6, 0.0], 200))
            }),
            ("folded back: tip pushed to behind the root, released", {
                run(build(calm()), 2e-2, 400, pushed([-1.0, 0.3, 0.1], 200))
            }),
            ("snap: tip force of 100 EI/L² for 0.1 s, released", {
                run(build(calm()), 5e-3, 400, pushed([0.0, 2.59, 0.0], 20))
            }),
            ("blow: 1e4 N at the tip for one step of 0.1 s, released", {
                run(build(calm()), 0.1, 100, pushed([-1e4, 100.0, 0.0], 1))
            }),
            ("k_e/EI = 1e12, dt 1e-2", run(build(with_ratio(1e12)), 1e-2, 300, |_, _| ())),
            ("k_e/EI = 1e12, dt 1e-4", run(build(with_ratio(1e12)), 1e-4, 300, |_, _| ())),
            ("n = 2048, k_e/EI = 1e12, dt 1e-2", {
                let mut parameters = with_ratio(1e12);
                parameters.section.axial_stiffness *= 64.0 / 2048.0;
                parameters.segments = 2048;
                run(build(parameters), 1e-2, 50, |_, _| ())
            }),
        ] {
            push(&mut table, &[&situation, &name], &outcome);
        }
    }
    table
}
