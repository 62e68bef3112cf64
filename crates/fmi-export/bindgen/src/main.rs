//! Writes or checks `crates/fmi-export/src/sys.rs`, the C types and functions of FMI 2.0 and 3.0 in Rust.
//!
//! `fmi-bindgen HEADER_DIR SYS_RS` writes the file, `fmi-bindgen --check HEADER_DIR SYS_RS` compares it and
//! fails if it differs. libclang is found through the environment variable `LIBCLANG_PATH`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use quote::ToTokens;
use syn::{GenericArgument, Item, ItemType, PathArguments, ReturnType, Type};

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

const PREAMBLE: &str = "\
//! The C types and functions of FMI 2.0 and 3.0, generated from the official headers by `crates/fmi-export/bindgen`: do
//! not edit.
#![allow(missing_docs, non_camel_case_types, non_snake_case, non_upper_case_globals)]

";

/// C's `bool` as a byte: a master's invalid value must not become an invalid Rust `bool`.
const BOOLEANS: [&str; 2] = ["fmi3Boolean", "fmi3Clock"];

/// Functions of FMI 2.0 for model exchange alone; FMI 3.0 wants all functions in each library.
const MODEL_EXCHANGE: &str = "fmi2(EnterEventMode|NewDiscreteStates|EnterContinuousTimeMode|CompletedIntegratorStep|\
    SetTime|SetContinuousStates|GetDerivatives|GetEventIndicators|GetContinuousStates|GetNominalsOfContinuousStates)TYPE";

/// Return the text of `sys.rs`: the types of the functions' arguments, and a macro with the functions.
fn generate(header_dir: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let (functions, types): (Vec<_>, Vec<_>) =
        syn::parse_file(&bindings(header_dir)?)?.items.into_iter().partition(|item| function(item).is_some());
    let types = prettyplease::unparse(&syn::File { shebang: None, attrs: Vec::new(), items: types });
    let functions: String = functions.iter().filter_map(function).map(|line| folded(&line)).collect();
    Ok(format!(
        "{PREAMBLE}{types}
/// Pass the functions of FMI 2.0 and 3.0 for co-simulation to the macro `with`, after what is `given`.
#[doc(hidden)]
#[macro_export]
macro_rules! __standard_functions {{
    ($with:path, $($given:tt)*) => {{
        $with! {{ $($given)*
{functions}        }}
    }};
}}
"
    ))
}

/// Return what bindgen makes of the headers.
fn bindings(header_dir: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let shims = std::env::temp_dir().join(format!("fmi-bindgen-{}", std::process::id()));
    std::fs::create_dir_all(&shims)?;
    for (name, text) in C_HEADERS {
        std::fs::write(shims.join(name), text)?;
    }
    let headers = ["fmi2FunctionTypes.h", "fmi3FunctionTypes.h"].map(|name| header_dir.join(name));
    let bindings = bindgen::Builder::default()
        .headers(headers.iter().map(|path| path.to_string_lossy()))
        .clang_args(["-nostdinc", "-isystem", &shims.to_string_lossy()])
        .allowlist_type("fmi[23].*TYPE")
        .blocklist_type(MODEL_EXCHANGE)
        .blocklist_type(BOOLEANS.join("|"))
        // A newtype accepts every integer: a master's invalid number must not become an invalid Rust enum.
        .default_enum_style(bindgen::EnumVariation::NewType { is_bitfield: false, is_global: false })
        .generate_comments(false)
        .layout_tests(false)
        .rust_target(bindgen::RustTarget::stable(89, 0).expect("Rust 1.89 is known to bindgen"))
        .formatter(bindgen::Formatter::None)
        .disable_header_comment()
        .raw_line(BOOLEANS.map(|name| format!("pub type {name} = u8;")).join("\n"))
        .generate();
    std::fs::remove_dir_all(&shims)?;
    Ok(bindings?.to_string())
}

/// Return the function whose type is `NAMETYPE = Option<unsafe extern "C" fn(…) -> …>` as `NAME(…) -> …;`.
fn function(item: &Item) -> Option<String> {
    let Item::Type(ItemType { ident, ty, .. }) = item else { return None };
    let name = ident.to_string();
    let (name, Type::Path(option)) = (name.strip_suffix("TYPE")?, &**ty) else { return None };
    let PathArguments::AngleBracketed(option) = &option.path.segments.last()?.arguments else { return None };
    let Some(GenericArgument::Type(Type::BareFn(function))) = option.args.first() else { return None };
    let arguments = function.inputs.iter().map(|input| {
        let name = input.name.as_ref().map_or("_".into(), |(name, _)| name.to_string());
        format!("{name}: {}", text(&input.ty))
    });
    let arguments = arguments.collect::<Vec<_>>().join(", ");
    let result = match &function.output {
        ReturnType::Default => "()".to_string(),
        ReturnType::Type(_, result) => text(result),
    };
    Some(format!("{name}({arguments}) -> {result};"))
}

fn text(of: &Type) -> String {
    match of {
        Type::Ptr(pointer) if pointer.mutability.is_some() => format!("*mut {}", text(&pointer.elem)),
        Type::Ptr(pointer) => format!("*const {}", text(&pointer.elem)),
        name => name.to_token_stream().to_string().replace(' ', ""),
    }
}

/// Fold a function at its commas into lines of at most 120 characters.
fn folded(function: &str) -> String {
    let (mut lines, mut line) = (String::new(), " ".repeat(11));
    for piece in function.split_inclusive(", ").flat_map(|piece| piece.split_inclusive(") ")) {
        if line.len() + piece.trim_end().len() + 1 > 120 {
            lines += &format!("{}\n", line.trim_end());
            line = " ".repeat(15);
        }
        line = format!("{line} {}", piece.trim_end());
    }
    format!("{lines}{line}\n")
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
