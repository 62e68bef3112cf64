//! Stiff and extreme cases: each ends in an energy error or in an error with its cause.

use std::time::Instant;

use nervure_rod::{Energy, Error, Parameters, Rod, RodError, Section};

use crate::common::total_energy;
use crate::rods::{SCHEMES, build, thesis_beam};
use crate::{Table, row};

/// Steps without a load until no formula holds a loaded level any more.
const LEVELS: usize = 3;
/// Gain of energy that a dissipative scheme must not exceed.
const LARGEST_GAIN: f64 = 0.01;

/// The beam released from rest in its weight, for every k_e of a segment (N/m), EI (N m²), step (s) and n.
pub fn table() -> Table {
    let mut table = vec!["n,k_e,EI,dt,result,gain,loss,worst_step_seconds,iterations,substeps".to_string()];
    for n in [8, 32, 128, 512, 2048] {
        eprintln!("  n = {n}");
        for cell in 0..350 {
            let [k_e, bending_stiffness, dt] = [cell / 50 + 3, cell / 5 % 10 - 6, cell % 5 - 5].map(|k| 10_f64.powi(k));
            let mut beam = thesis_beam::<2>(n);
            beam.section = Section { bending_stiffness, axial_stiffness: k_e / n as f64, ..beam.section };
            let [result, gain, loss, seconds, iterations, substeps] = &run(build(beam), dt, 50, [0.0; 2], 0);
            table.push(row(&[&n, &k_e, &bending_stiffness, &dt, result, gain, loss, seconds, iterations, substeps]));
        }
    }
    table
}

/// `steps` steps, the first `until` with the force `push` on the tip; energies count while there is none.
///
/// What became of it; the largest gain of energy and the largest loss, by the largest energy that moved; of a single step
/// the most seconds, iterations and sub-steps.
fn run<const D: usize>(mut rod: Rod<D>, dt: f64, steps: usize, push: [f64; D], until: usize) -> [String; 6] {
    let nodes = rod.parameters().segments + 1;
    let (mut start, mut low, mut high, mut scale) = (total_energy(&rod), 0.0_f64, 0.0_f64, f64::MIN_POSITIVE);
    let (mut seconds, mut iterations, mut substeps, mut failure) = (0.0_f64, 0, 0, None);
    for step in 0..steps {
        if until > 0 {
            let force = if step < until { push } else { [0.0; D] };
            rod.loads.force = vec![0.0; D * nodes];
            (0..D).for_each(|d| rod.loads.force[(d + 1) * nodes - 1] = force[d]);
        }
        let clock = Instant::now();
        let result = rod.step(dt);
        seconds = seconds.max(clock.elapsed().as_secs_f64());
        iterations = iterations.max(rod.statistics().iterations);
        substeps = substeps.max(rod.statistics().substeps);
        let result = result.and_then(|()| rod.energy());
        let Ok(Energy { kinetic, stretching, bending, gravity, .. }) = result else {
            failure = result.err().map(|error| format!("{} in step {}: {error}", cause(&error), step + 1));
            break;
        };
        scale = scale.max(gravity.abs()).max(kinetic).max(stretching + bending);
        let total = total_energy(&rod);
        if !total.is_finite() {
            failure = Some("an energy that is no number".into());
            break;
        }
        if until > 0 && step + 1 < until + LEVELS {
            start = total;
        }
        (low, high) = (low.min(total - start), high.max(total - start));
    }
    let (gain, loss) = if failure.is_some() { (0.0, 0.0) } else { (high / scale, -low / scale) };
    let result = failure.unwrap_or_else(|| if gain > LARGEST_GAIN { "gain of energy".into() } else { "ok".into() });
    let [gain, loss] = [gain, loss].map(|energy| format!("{energy:.1e}"));
    [result, gain, loss, format!("{seconds:.4}"), iterations.to_string(), substeps.to_string()]
}

fn cause(error: &Error) -> &'static str {
    match error {
        Error::NotConverged { .. } => "not converged",
        Error::Structure(RodError::Shape(_)) => "folds back",
        Error::Structure(RodError::EnergyGain { .. }) => "stopped for a gain of energy",
        _ => "refused",
    }
}

/// Named situations with every scheme, in space where they leave the plane.
pub fn situations() -> Table {
    let mut table = vec!["situation,scheme,result,gain,loss,worst_step_seconds,iterations,substeps".to_string()];
    let beam = thesis_beam::<3>(64);
    let with = |section| Parameters { section, ..beam.clone() };
    let soft = with(Section { bending_stiffness: 1e-4, ..beam.section });
    let upright = Parameters { direction: [0.0, 0.0, 1.0], gravity: [0.0, 0.001, -40.0], ..beam.clone() };
    let calm = Parameters { gravity: [0.0; 3], ..beam.clone() };
    // k_e/EI of a segment is 1e12/m³.
    let axial_stiffness = 1e12 * beam.section.bending_stiffness / 64.0;
    let stiff = with(Section { axial_stiffness, ..beam.section });
    let axial_stiffness = axial_stiffness * (64.0 / 2048.0);
    let long = Parameters { segments: 2048, ..with(Section { axial_stiffness, ..beam.section }) };
    let none = [0.0; 3];
    let situations = [
        ("swings past vertical: EI 1e-4, falls from level", &soft, 5e-3, 600, none, 0),
        ("buckles: upright in 20 times the critical weight", &upright, 5e-3, 600, none, 0),
        ("compressed along its axis by 10 EI/L², 1e-6 aside, released", &calm, 5e-3, 600, [-0.259, 1e-6, 0.0], 200),
        ("folded back: tip pushed to behind the root, released", &calm, 2e-2, 400, [-1.0, 0.3, 0.1], 200),
        ("snap: tip force of 100 EI/L² for 0.1 s, released", &calm, 5e-3, 400, [0.0, 2.59, 0.0], 20),
        ("blow: 1e4 N at the tip for one step of 0.1 s, released", &calm, 0.1, 100, [-1e4, 100.0, 0.0], 1),
        ("k_e/EI = 1e12, dt 1e-2", &stiff, 1e-2, 300, none, 0),
        ("k_e/EI = 1e12, dt 1e-4", &stiff, 1e-4, 300, none, 0),
        ("n = 2048, k_e/EI = 1e12, dt 1e-2", &long, 1e-2, 50, none, 0),
    ];
    for (name, scheme) in SCHEMES {
        for (situation, parameters, dt, steps, push, until) in situations {
            let rod = build(Parameters { scheme, ..parameters.clone() });
            let [result, gain, loss, seconds, iterations, substeps] = &run(rod, dt, steps, push, until);
            table.push(row(&[&situation, &name, result, gain, loss, seconds, iterations, substeps]));
        }
    }
    table
}
