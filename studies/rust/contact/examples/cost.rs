//! What contact of a rod and of a wing with itself costs: a hairpin and a book that close, with contact and without.
//!
//! `cost FOLDER` writes cost.csv into FOLDER.

#[path = "../../../../crates/rod/tests/all/thrown.rs"]
#[allow(dead_code, reason = "its tests use the rest")]
mod rods;
#[path = "../../../../crates/wing/tests/all/thrown.rs"]
#[allow(dead_code, reason = "its tests use the rest")]
mod wings;

use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

use nervure_rod::{Parameters, Rod, RootSupport, Scheme, Section};

/// Steps of a motion, s, and their number: both close in about half of them.
const STEP: f64 = 1e-3;
const STEPS: usize = 200;

/// Runs of which the fastest counts.
const RUNS: usize = 5;

/// Steps in which nothing touches before the first that does, and those that do: their number and their time, s.
type Phases = [(u32, f64); 2];

fn main() -> Result<(), String> {
    let folder = std::env::args().nth(1).ok_or("usage: cost FOLDER")?;
    let path = Path::new(&folder).join("cost.csv");
    let written = std::fs::write(&path, table().join("\n") + "\n");
    written.map_err(|error| format!("cannot write {}: {error}", path.display()))
}

/// Return the lines of a table: milliseconds of a step without contact, with it before anything touches, and with it while
/// something does.
fn table() -> Vec<String> {
    let mut lines = vec!["part,nodes,without,apart,touching".to_string()];
    for (name, nodes, run) in [("rod", 41, rod as fn(bool) -> Phases), ("wing", 0, wing)] {
        let fastest = |key: bool| {
            let mut best = run(key);
            for _ in 1..RUNS {
                best.iter_mut().zip(run(key)).for_each(|(best, own)| best.1 = best.1.min(own.1));
            }
            best
        };
        let [with, without] = [true, false].map(fastest);
        let step = |(count, seconds): (u32, f64)| 1e3 * seconds / f64::from(count.max(1));
        let nodes = if nodes == 0 { book(true).nodes() } else { nodes };
        let [none, apart, touching] = [without[0], with[0], with[1]].map(step);
        lines.push(format!("{name},{nodes},{none:.4},{apart:.4},{touching:.4}"));
    }
    lines
}

/// Take the steps, and return the times of those before the first that `touches`, and of those that do. Without contact a
/// motion ends where with it something touches: by a step that fails, or `last`.
fn time<T>(part: &mut T, step: impl Fn(&mut T) -> bool, touches: impl Fn(&mut T) -> bool, last: usize) -> Phases {
    let mut phases = Phases::default();
    for _ in 0..last {
        let clock = Instant::now();
        let done = step(part);
        let seconds = clock.elapsed().as_secs_f64();
        if !done {
            break;
        }
        let now = touches(part);
        if now || phases[1].0 == 0 {
            let phase = &mut phases[usize::from(now)];
            *phase = (phase.0 + 1, phase.1 + seconds);
        }
    }
    phases
}

/// A free hairpin whose arms close.
fn hairpin(key: bool) -> Rod<2> {
    let (segments, radius) = (40, 5e-3);
    let turned = |k: usize| PI * ((k as f64 + 0.5 - 18.0) / 4.0).clamp(0.0, 1.0);
    let mut contact = rods::contact::<2>(segments, radius, STEP, Vec::new());
    contact.with_itself = true;
    let mut rod = Rod::<2>::new(Parameters {
        rest_angles: (0..segments).map(turned).collect(),
        support: RootSupport::Free,
        contact: key.then_some(contact),
        scheme: Scheme::Bdf2,
        ..Parameters::new(1.0, segments, Section { bending_stiffness: 0.01, ..rods::SECTION })
    })
    .expect("a rod");
    let mut state = rod.state().clone();
    for k in 0..=segments {
        let along = (k as f64 / segments as f64 - 0.5) * 2.0;
        state.velocities[k][1] = if along.abs() > 0.1 { -0.3 * along } else { 0.0 };
    }
    rod.restore(&state).expect("its state");
    rod
}

fn rod(key: bool) -> Phases {
    let apart = if key { STEPS } else { rod(true)[0].0 as usize };
    let touches = |rod: &mut Rod<2>| rod.energy().expect("an energy").contact > 0.0;
    time(&mut hairpin(key), |rod| rod.step(STEP).is_ok(), touches, apart)
}

/// A free wing whose halves close like a book.
fn book(key: bool) -> nervure_wing::Wing {
    let mut own = wings::parameters(wings::contact(vec![]), 0.0);
    own.contact = key.then(|| nervure_wing::Contact { with_itself: true, ..wings::contact(vec![]) });
    own.scheme = nervure_wing::Scheme::Bdf2;
    let mut wing = wings::book(own, 8).build().expect("a wing");
    let turning: Vec<_> = wing.positions(0).iter().map(|x| [0.0, 0.0, 20.0 * (x - 0.1).abs()]).collect();
    wing.set_velocities(&turning).expect("velocities");
    wing
}

fn wing(key: bool) -> Phases {
    let apart = if key { STEPS } else { wing(true)[0].0 as usize };
    let touches = |wing: &mut nervure_wing::Wing| wing.energy().expect("an energy").contact > 0.0;
    time(&mut book(key), |wing| wing.step(STEP).is_ok(), touches, apart)
}
