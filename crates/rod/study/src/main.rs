//! Studies of the rod: the tables and figures of the thesis, chapter 2, and what lies beyond them.
//!
//! `rod-study FOLDER [NAME …]` writes NAME.csv into FOLDER; without names all of them. Times are those of one core.

mod accuracy;
mod condition;
mod extreme;
mod matrices;
mod rods;
mod runtime;

use std::fmt::Display;
use std::fs;
use std::path::Path;
use std::process::exit;

/// Name of a CSV file, and what computes its first line and rows.
type Study = (&'static str, fn() -> Table);

const STUDIES: [Study; 10] = [
    ("condition", condition::table),
    ("runtime", runtime::table),
    ("deflection", accuracy::deflection),
    ("order_in_n", accuracy::order_in_n),
    ("order_in_dt", accuracy::order_in_dt),
    ("bending_models", accuracy::bending_models),
    ("csm", accuracy::csm),
    ("csm3_energy", accuracy::csm3_energy),
    ("extreme", extreme::table),
    ("situations", extreme::situations),
];

/// Rows under a header.
pub struct Table {
    header: &'static str,
    rows: Vec<String>,
}

impl Table {
    fn new(header: &'static str) -> Self {
        Self { header, rows: Vec::new() }
    }

    /// Add a row; a text with commas is quoted.
    fn push(&mut self, cells: &[&dyn Display]) {
        let quoted = |cell: &&dyn Display| {
            let text = cell.to_string();
            if text.contains(',') { format!("\"{}\"", text.replace('"', "'")) } else { text }
        };
        self.rows.push(cells.iter().map(quoted).collect::<Vec<_>>().join(","));
    }

    fn write(&self, path: &Path) {
        let text = format!("{}\n{}\n", self.header, self.rows.join("\n"));
        fs::write(path, text).unwrap_or_else(|error| fail(&format!("cannot write {}: {error}", path.display())));
    }
}

fn fail(message: &str) -> ! {
    eprintln!("{message}");
    exit(2)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some((folder, names)) = arguments.split_first() else { fail("usage: rod-study FOLDER [NAME …]") };
    if let Some(unknown) = names.iter().find(|name| STUDIES.iter().all(|(known, _)| known != name)) {
        fail(&format!("there is no study {unknown:?}; there are {:?}", STUDIES.map(|(name, _)| name)));
    }
    for (name, compute) in STUDIES {
        if names.is_empty() || names.iter().any(|wanted| wanted == name) {
            eprintln!("{name} …");
            compute().write(&Path::new(folder).join(name).with_extension("csv"));
        }
    }
}
