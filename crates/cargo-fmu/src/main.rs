//! `cargo fmu package`: build a crate that uses `nervure-fmi-export` and pack it as an FMU.
//!
//! The library for this system writes its own model description; no step of the model runs.

mod options;
mod package;

use std::process::ExitCode;

use options::{Options, USAGE};

fn main() -> ExitCode {
    // `cargo fmu …` passes `fmu` as the first argument.
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
