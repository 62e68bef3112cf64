//! `cargo fmu package`: builds a crate that uses `nervure-fmi-export` and packs it as an FMU.
//!
//! The library that is built for this system describes itself; nothing of the model is run.

mod options;
mod package;

use std::process::ExitCode;

use options::{Options, USAGE};

fn main() -> ExitCode {
    // As `cargo fmu …` it is called with `fmu` in front.
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments = arguments.strip_prefix(&["fmu".to_string()]).unwrap_or(&arguments);
    if arguments.iter().any(|argument| argument == "--help" || argument == "-h") {
        println!("{USAGE}");
        return ExitCode::SUCCESS;
    }
    match Options::parse(arguments).and_then(|options| package::package(&options)) {
        Ok(path) => {
            println!("{}", path.display());
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
