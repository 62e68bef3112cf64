//! Writes or checks `crates/fmi-export/src/sys.rs`, the C types of FMI 2.0 and 3.0 as Rust types.
//!
//! `fmi-bindgen HEADER_DIR SYS_RS` writes the file, `fmi-bindgen --check HEADER_DIR SYS_RS` compares it and
//! fails if it differs. libclang is found through the environment variable `LIBCLANG_PATH`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The C library headers that the FMI headers include, with what is used from them: a libclang installed on its own
/// comes without them.
const C_HEADERS: [(&str, &str); 4] = [
    ("stddef.h", "typedef __SIZE_TYPE__ size_t;\n"),
    ("stdlib.h", "#include <stddef.h>\n"),
    ("stdbool.h", "#define bool _Bool\n#define true 1\n#define false 0\n"),
    (
        "stdint.h",
        "typedef __INT8_TYPE__ int8_t;\ntypedef __UINT8_TYPE__ uint8_t;\n\
         typedef __INT16_TYPE__ int16_t;\ntypedef __UINT16_TYPE__ uint16_t;\n\
         typedef __INT32_TYPE__ int32_t;\ntypedef __UINT32_TYPE__ uint32_t;\n\
         typedef __INT64_TYPE__ int64_t;\ntypedef __UINT64_TYPE__ uint64_t;\n",
    ),
];

const PREAMBLE: &str =
    "The C types of FMI 2.0 and 3.0, generated from the official headers by `crates/fmi-export/bindgen`: do not edit.";

/// C's `bool` as a byte: a master's invalid value must not become an invalid Rust `bool`.
const BOOLEANS: [&str; 2] = ["fmi3Boolean", "fmi3Clock"];

fn generate(header_dir: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let shims = std::env::temp_dir().join(format!("fmi-bindgen-{}", std::process::id()));
    std::fs::create_dir_all(&shims)?;
    for (name, text) in C_HEADERS {
        std::fs::write(shims.join(name), text)?;
    }
    let headers = ["fmi2FunctionTypes.h", "fmi3FunctionTypes.h"].map(|name| header_dir.join(name));
    let bindings = bindgen::Builder::default()
        .headers(headers.iter().map(|path| path.to_string_lossy()))
        .clang_args(["-nostdinc", "-isystem", &shims.to_string_lossy()])
        .allowlist_type("fmi[23].*")
        .blocklist_type(BOOLEANS.join("|"))
        // A newtype accepts every integer: a master's invalid number must not become an invalid Rust enum.
        .default_enum_style(bindgen::EnumVariation::NewType { is_bitfield: false, is_global: false })
        .generate_comments(false)
        .layout_tests(false)
        .rust_target(bindgen::RustTarget::stable(89, 0).expect("Rust 1.89 is known to bindgen"))
        .formatter(bindgen::Formatter::Prettyplease)
        .disable_header_comment()
        .raw_line(format!("//! {PREAMBLE}"))
        .raw_line("#![allow(missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals)]")
        .raw_line("")
        .raw_line(BOOLEANS.map(|name| format!("pub type {name} = u8;")).join("\n"))
        .generate();
    std::fs::remove_dir_all(&shims)?;
    Ok(bindings?.to_string())
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    let (flags, paths): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|argument| argument == "--check");
    let [header_dir, sys_rs] = &paths[..] else {
        return Err("usage: fmi-bindgen [--check] HEADER_DIR SYS_RS".into());
    };
    let (header_dir, sys_rs) = (PathBuf::from(header_dir), PathBuf::from(sys_rs));
    let generated = generate(&header_dir)?;
    if flags.is_empty() {
        std::fs::write(&sys_rs, generated)?;
    } else if std::fs::read_to_string(&sys_rs)? != generated {
        return Err(format!("{} differs from what the headers generate", sys_rs.display()).into());
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("fmi-bindgen: {error}");
            ExitCode::FAILURE
        }
    }
}
