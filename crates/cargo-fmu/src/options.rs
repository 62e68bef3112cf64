//! Options of the command line.

use std::path::PathBuf;

/// Text of `--help`.
pub const USAGE: &str = "\
Build a crate that uses nervure-fmi-export and pack it as an FMU.

Usage: cargo fmu package [--fmi 2|3] [--resources FOLDER] [--output FILE] [--target TRIPLE]... [OPTIONS OF CARGO BUILD]

  --fmi 2|3            version of FMI (2)
  --resources FOLDER   folder to pack as `resources`
  --output FILE        path of the FMU (target/fmu/IDENTIFIER.fmu)
  --target TRIPLE      add a library for this target to the library for this system

All other options go to `cargo build`: -p, --example, --features, --manifest-path, --locked, ...
The profile is `release` unless --profile names another.";

/// Crate to build and FMU to write.
#[derive(Debug, PartialEq)]
pub struct Options {
    /// Version of FMI: 2 or 3.
    pub fmi: u8,
    /// Folder of the resources.
    pub resources: Option<PathBuf>,
    /// File to write.
    pub output: Option<PathBuf>,
    /// Targets in addition to this system.
    pub targets: Vec<String>,
    /// Options for `cargo build`.
    pub build: Vec<String>,
}

impl Options {
    /// Parse the arguments after `cargo fmu`.
    pub fn parse(arguments: &[String]) -> Result<Self, String> {
        let [command, arguments @ ..] = arguments else {
            return Err(format!("missing command\n\n{USAGE}"));
        };
        if command != "package" {
            return Err(format!("unknown command {command:?}; the only command is \"package\"\n\n{USAGE}"));
        }
        let mut options = Options { fmi: 2, resources: None, output: None, targets: vec![], build: vec![] };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            let (name, given) = match argument.split_once('=') {
                Some((name, value)) => (name, Some(value.to_string())),
                None => (argument.as_str(), None),
            };
            if !["--fmi", "--resources", "--output", "--target"].contains(&name) {
                options.build.push(argument.clone());
                continue;
            }
            let value = given.or_else(|| rest.next().cloned()).ok_or_else(|| format!("{name} needs a value"))?;
            match name {
                "--fmi" => {
                    let versions = [("2", 2), ("3", 3)];
                    let known = versions.iter().find(|(text, _)| *text == value);
                    options.fmi = known.ok_or_else(|| format!("--fmi is {value:?}, but must be 2 or 3"))?.1;
                }
                "--resources" => options.resources = Some(value.into()),
                "--output" => options.output = Some(value.into()),
                _ => options.targets.push(value),
            }
        }
        let has_profile = options.build.iter().any(|o| o == "--release" || o == "-r" || o.starts_with("--profile"));
        if !has_profile {
            options.build.push("--release".into());
        }
        Ok(options)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(line: &str) -> Result<Options, String> {
        Options::parse(&line.split_whitespace().map(str::to_string).collect::<Vec<_>>())
    }

    #[test]
    fn what_is_not_ours_goes_to_cargo() {
        let found = parse("package --fmi 3 -p hinge --resources=data --target a --locked --target=b --output x.fmu");
        let expected = Options {
            fmi: 3,
            resources: Some("data".into()),
            output: Some("x.fmu".into()),
            targets: vec!["a".into(), "b".into()],
            build: ["-p", "hinge", "--locked", "--release"].map(str::to_string).into(),
        };
        assert_eq!(found, Ok(expected));
        assert_eq!(parse("package --profile dev").unwrap().build, ["--profile", "dev"]);
    }

    #[test]
    fn a_wrong_line_is_refused_with_what_is_wrong() {
        for (line, part) in [
            ("", "missing command"),
            ("pack", "\"pack\"; the only command is \"package\""),
            ("package --fmi 1", "\"1\", but must be 2 or 3"),
            ("package --target", "--target needs a value"),
        ] {
            let message = parse(line).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
    }
}
