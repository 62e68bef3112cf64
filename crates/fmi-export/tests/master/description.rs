//! Texts that a library writes, and what they say of FMI 2.0.

use std::ffi::{CStr, c_char};
use std::ptr::null_mut;

/// Return the text that a function of a library writes into a buffer of exactly its size; a message if it fails.
pub fn written(write: impl Fn(*mut c_char, usize, *mut usize) -> i32) -> Result<String, String> {
    let mut needed = 0;
    write(null_mut(), 0, &mut needed);
    let mut buffer = vec![0u8; needed];
    let code = write(buffer.as_mut_ptr().cast(), needed, &mut needed);
    let text = CStr::from_bytes_with_nul(&buffer).expect("a text ends with its only NUL");
    let text = text.to_str().expect("descriptions and messages are UTF-8").to_string();
    if code == 0 { Ok(text) } else { Err(text) }
}

/// Return the first attribute of this name.
pub fn attribute(xml: &str, name: &str) -> String {
    let (_, rest) = xml.split_once(&format!(" {name}=\"")).expect("the description has it");
    rest.split_once('"').expect("it ends").0.to_owned()
}

/// Return names and value references of the Real variables of a causality.
pub fn reals(xml: &str, causality: &str) -> Vec<(String, u32)> {
    let variables = xml.split("<ScalarVariable").skip(1);
    let chosen = variables.filter(|v| v.contains(&format!("causality=\"{causality}\"")) && v.contains("<Real"));
    chosen.map(|v| (attribute(v, "name"), attribute(v, "valueReference").parse().expect("a number"))).collect()
}

/// Return the value references of the Real variables of a causality.
pub fn references(xml: &str, causality: &str) -> Vec<u32> {
    reals(xml, causality).into_iter().map(|(_, reference)| reference).collect()
}
