//! Building, describing and packing.

use std::env::consts;
use std::ffi::{CString, c_char, c_int};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::options::Options;

/// Built library.
struct Built {
    path: PathBuf,
    /// Output folder of cargo.
    target_folder: PathBuf,
}

/// Build and pack an FMU; return its path.
pub fn package(options: &Options) -> Result<PathBuf, String> {
    let own = build(&options.build, None)?;
    let description = describe(&own.path, options)?;
    let identifier = attribute(&description, "modelIdentifier")?;
    let host = platform(&format!("{}-{}", consts::ARCH, consts::OS), options.fmi)?;
    let mut libraries = vec![(host, own.path)];
    for target in &options.targets {
        let name = platform(target, options.fmi)?;
        if name == libraries[0].0 {
            continue; // the library for this system is there already
        }
        if libraries.iter().any(|(known, _)| *known == name) {
            return Err(format!("the target {target} and another target share the folder binaries/{name}"));
        }
        libraries.push((name, build(&options.build, Some(target))?.path));
    }

    let output = options.output.clone().unwrap_or_else(|| own.target_folder.join(format!("fmu/{identifier}.fmu")));
    let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let fails = |error: std::io::Error| format!("{} cannot be written: {error}", output.display());
    fs::create_dir_all(folder).map_err(fails)?;
    let mut archive = Archive(ZipWriter::new(File::create(&output).map_err(fails)?));
    archive.add("modelDescription.xml", description.as_bytes())?;
    for (name, path) in &libraries {
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        archive.add(&format!("binaries/{name}/{identifier}.{ending}"), &read(path)?)?;
    }
    if let Some(resources) = &options.resources {
        archive.add_folder("resources", resources)?;
    }
    archive.0.finish().map_err(|error| fails(error.into()))?;
    Ok(output)
}

/// Build the dynamic library of the crate, for a target or for this system.
fn build(options: &[String], target: Option<&String>) -> Result<Built, String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(["build", "--message-format=json-render-diagnostics"]).args(options).stderr(Stdio::inherit());
    if let Some(target) = target {
        command.args(["--target", target]);
    }
    let answer = command.output().map_err(|error| format!("cargo cannot be run: {error}"))?;
    if !answer.status.success() {
        return Err("the library cannot be built; the messages of cargo above say why".into());
    }
    let mut found = Vec::new();
    for line in answer.stdout.split(|byte| *byte == b'\n') {
        let Ok(message) = serde_json::from_slice::<Value>(line) else { continue };
        let is_library =
            message["target"]["crate_types"].as_array().is_some_and(|kinds| kinds.contains(&"cdylib".into()));
        if message["reason"] == "compiler-artifact" && is_library {
            let files = message["filenames"].as_array().into_iter().flatten().filter_map(Value::as_str);
            let ending = |file: &&str| [".so", ".dll", ".dylib"].iter().any(|ending| file.ends_with(ending));
            found.extend(files.filter(ending).map(PathBuf::from));
        }
    }
    match &found[..] {
        [path] => {
            // target/[TRIPLE/]PROFILE/[examples/]library
            let mut folders = path.ancestors().skip(1).filter(|folder| !folder.ends_with("examples"));
            let target_folder = folders.nth(1).unwrap_or(Path::new("target")).to_owned();
            Ok(Built { path: path.clone(), target_folder })
        }
        [] => Err("the crate has no library of crate-type \"cdylib\"".into()),
        several => {
            let names: Vec<_> = several.iter().map(|path| path.display().to_string()).collect();
            Err(format!("the build has several libraries; choose one with -p or --example: {}", names.join(", ")))
        }
    }
}

/// Type of `fmu_model_description` and `fmu_model_description_3`.
type Describe = unsafe extern "C" fn(*const c_char, *mut c_char, usize, *mut usize) -> c_int;

/// Return the `modelDescription.xml` of the library for the resources, or its error message.
fn describe(library: &Path, options: &Options) -> Result<String, String> {
    let symbol = if options.fmi == 3 { "fmu_model_description_3" } else { "fmu_model_description" };
    let text = |path: &PathBuf| {
        let path = fs::canonicalize(path).map_err(|error| format!("{}: {error}", path.display()))?;
        CString::new(path.to_string_lossy().as_bytes()).map_err(|error| format!("{}: {error}", path.display()))
    };
    let resources = options.resources.as_ref().map(text).transpose()?;
    let pointer = resources.as_ref().map_or(std::ptr::null(), |path| path.as_ptr());
    let unusable = |error| format!("{} is not a library of nervure-fmi-export: {error}", library.display());
    // SAFETY: the user's own library may run code when it is loaded; `export_fmu!` gives the symbol this type.
    unsafe {
        let loaded = libloading::Library::new(library).map_err(unusable)?;
        let function: libloading::Symbol<Describe> = loaded.get(symbol).map_err(unusable)?;
        let (mut needed, mut buffer) = (0, Vec::<u8>::new());
        loop {
            let refused = function(pointer, buffer.as_mut_ptr().cast(), buffer.len(), &mut needed) != 0;
            if needed > buffer.len() {
                buffer.resize(needed, 0);
                continue;
            }
            buffer.truncate(needed.saturating_sub(1)); // without the final NUL
            let answer = String::from_utf8_lossy(&buffer).into_owned();
            return if refused { Err(answer) } else { Ok(answer) };
        }
    }
}

/// Return the value of an attribute without escapes.
fn attribute<'a>(xml: &'a str, name: &str) -> Result<&'a str, String> {
    let value = xml.split_once(&format!(" {name}=\"")).and_then(|(_, rest)| rest.split_once('"'));
    value.map(|(value, _)| value).ok_or_else(|| format!("the model description has no {name}"))
}

/// Return the folder below `binaries` for a target, in a version of FMI.
fn platform(target: &str, fmi: u8) -> Result<String, String> {
    let processor = target.split('-').next().unwrap_or_default();
    let system = ["linux", "windows", "darwin", "macos"].into_iter().find(|name| target.contains(name));
    let (short, bits) = match processor {
        "x86_64" => ("x86_64", "64"),
        "i586" | "i686" | "x86" => ("x86", "32"),
        "aarch64" => ("aarch64", "64"),
        _ => return Err(format!("FMI defines no name for the processor of the target {target}")),
    };
    let system = match system {
        Some("macos") => "darwin",
        Some(name) => name,
        None => return Err(format!("FMI defines no name for the system of the target {target}")),
    };
    // FMI 2.0 names ARM on macOS only, where a library may hold both architectures; elsewhere it uses the name of FMI
    // 3.0.
    Ok(match (fmi, short, system) {
        (2, "x86_64" | "x86", "windows") => format!("win{bits}"),
        (2, "x86_64" | "x86", _) | (2, _, "darwin") => format!("{system}{bits}"),
        _ => format!("{short}-{system}"),
    })
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|error| format!("{} cannot be read: {error}", path.display()))
}

/// FMU archive under construction; equal files give equal bytes.
struct Archive(ZipWriter<File>);

impl Archive {
    fn add(&mut self, name: &str, content: &[u8]) -> Result<(), String> {
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        let about = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(mode);
        let written = self.0.start_file(name, about).map_err(std::io::Error::from);
        written.and_then(|()| self.0.write_all(content)).map_err(|error| format!("{name} cannot be packed: {error}"))
    }

    fn add_folder(&mut self, name: &str, folder: &Path) -> Result<(), String> {
        let unreadable = |error| format!("{} cannot be read: {error}", folder.display());
        let entries = fs::read_dir(folder).map_err(unreadable)?;
        let mut paths: Vec<_> =
            entries.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>().map_err(unreadable)?;
        paths.sort();
        for path in paths {
            let file = path.file_name().unwrap_or_default().to_string_lossy();
            let inner = format!("{name}/{file}");
            match path.is_dir() {
                true => self.add_folder(&inner, &path)?,
                false => self.add(&inner, &read(&path)?)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn platforms_have_the_names_of_their_version() {
        for (target, two, three) in [
            ("x86_64-unknown-linux-gnu", "linux64", "x86_64-linux"),
            ("i686-unknown-linux-gnu", "linux32", "x86-linux"),
            ("x86_64-pc-windows-gnu", "win64", "x86_64-windows"),
            ("x86_64-apple-darwin", "darwin64", "x86_64-darwin"),
            ("aarch64-apple-darwin", "darwin64", "aarch64-darwin"),
            ("aarch64-unknown-linux-gnu", "aarch64-linux", "aarch64-linux"),
            ("aarch64-macos", "darwin64", "aarch64-darwin"),
        ] {
            assert_eq!([platform(target, 2).unwrap(), platform(target, 3).unwrap()], [two, three], "{target}");
        }
        for target in ["wasm32-unknown-unknown", "riscv64gc-unknown-linux-gnu", "x86_64-unknown-freebsd"] {
            let message = platform(target, 3).unwrap_err();
            assert!(message.contains(target), "{message}");
        }
    }

    #[test]
    fn an_attribute_is_read_off() {
        assert_eq!(attribute("<a b=\"1\" modelIdentifier=\"hinge\"/>", "modelIdentifier"), Ok("hinge"));
        assert!(attribute("<a/>", "modelIdentifier").is_err());
    }
}
