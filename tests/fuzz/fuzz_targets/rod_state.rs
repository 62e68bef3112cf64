#![no_main]

mod calls;
#[path = "../../../fmu-rod/src/lib.rs"]
mod unit;

libfuzzer_sys::fuzz_target!(|data: &[u8]| calls::state(data));
