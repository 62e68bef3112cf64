//! Studies of the rod: the tables and figures of the thesis, chapter 2, and what lies beyond them.
//!
//! `rod-study FOLDER [NAME …]` writes NAME.csv into FOLDER; without names all of them. Times are those of one core.

// `from_scene` knows the crate by the name of the workspace.
extern crate nervure_rod as rod;

mod accuracy;
#[path = "../../../../crates/rod/tests/common/mod.rs"]
mod common;
mod condition;
mod extreme;
#[path = "../../../../fmu-rod/src/from_scene.rs"]
mod from_scene;
mod rods;
mod runtime;
mod taper;

use std::fmt::Display;
use std::fs;
use std::path::Path;

/// Name of a CSV file, and what computes its lines.
type Study = (&'static str, fn() -> Table);

const STUDIES: [Study; 10] = [
    ("condition", condition::table),
    ("runtime", runtime::table),
    ("order_in_n", accuracy::order_in_n),
    ("order_in_dt", accuracy::order_in_dt),
    ("taper", taper::table),
    ("bending_models", accuracy::bending_models),
    ("csm", accuracy::csm),
    ("csm3_energy", accuracy::csm3_energy),
    ("extreme", extreme::table),
    ("situations", extreme::situations),
];

/// Lines of a CSV file; the first has the names of the columns.
type Table = Vec<String>;

/// A line; a text with commas is quoted.
fn row(cells: &[&dyn Display]) -> String {
    let quoted = |text: String| if text.contains(',') { format!("\"{}\"", text.replace('"', "'")) } else { text };
    cells.iter().map(|cell| quoted(cell.to_string())).collect::<Vec<_>>().join(",")
}

fn main() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, names) = arguments.split_first().ok_or("usage: rod-study FOLDER [NAME …]")?;
    if let Some(unknown) = names.iter().find(|name| STUDIES.iter().all(|(known, _)| known != name)) {
        return Err(format!("there is no study {unknown:?}; there are {:?}", STUDIES.map(|(name, _)| name)));
    }
    for (name, compute) in
        STUDIES.iter().filter(|(name, _)| names.is_empty() || names.iter().any(|wanted| wanted == name))
    {
        eprintln!("{name} …");
        let path = Path::new(folder).join(name).with_extension("csv");
        let text = compute().join("\n") + "\n";
        fs::write(&path, text).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    Ok(())
}
