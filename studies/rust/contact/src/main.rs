//! Random contacts of rods, wings and bodies with walls, solids, each other and themselves.
//!
//! `contact-study FOLDER` writes random.csv into FOLDER, with a row for each kind.

#[path = "../../../../crates/contact/tests/common/flying.rs"]
#[allow(dead_code, reason = "its tests use the rest")]
mod flying;
#[path = "../../../../crates/rod/tests/all/thrown.rs"]
mod rods;
#[path = "../../../../crates/wing/tests/all/thrown.rs"]
#[allow(dead_code, reason = "its tests use the rest")]
mod wings;

use std::fs;
use std::path::Path;
use std::time::Instant;

/// Steps in contact, largest gain of energy and largest depth of a case, or why it ended.
type Outcome = Result<[f64; 3], String>;

/// Kinds with their numbers of cases.
const KINDS: [(&str, u64, fn(u64) -> Outcome); 5] = [
    ("rods in the plane", 175, rods::throw::<2>),
    ("rods in space", 175, rods::throw::<3>),
    ("wings", 300, wings::throw),
    ("bodies in the plane", 175, flying::fly::<2>),
    ("bodies in space", 175, flying::fly::<3>),
];

fn main() -> Result<(), String> {
    let folder = std::env::args().nth(1).ok_or("usage: contact-study FOLDER")?;
    let mut table = vec!["kind,cases,touching,steps,gain,depth,failed,seconds".to_string()];
    for (kind, cases, throw) in KINDS {
        let clock = Instant::now();
        let [mut touching, mut failed, mut steps, mut gain, mut depth] = [0.0, 0.0, 0.0, 0.0_f64, 0.0_f64];
        for outcome in (0..cases).map(throw) {
            match outcome {
                Ok([touched, gained, deepest]) => {
                    touching += f64::from(u8::from(touched > 0.0));
                    (steps, gain, depth) = (steps + touched, gain.max(gained), depth.max(deepest));
                }
                Err(error) => {
                    eprintln!("{kind}: {error}");
                    failed += 1.0;
                }
            }
        }
        let seconds = clock.elapsed().as_secs_f64();
        table.push(format!("{kind},{cases},{touching},{steps},{gain:.3e},{depth:.3},{failed},{seconds:.1}"));
    }
    let path = Path::new(&folder).join("random.csv");
    fs::write(&path, table.join("\n") + "\n").map_err(|error| format!("cannot write {}: {error}", path.display()))
}
