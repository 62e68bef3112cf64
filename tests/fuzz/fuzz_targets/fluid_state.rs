#![no_main]

use fmu_fluid as _;

mod calls;

/// Folder of the unit's scene in `target/fuzz`.
const KIND: &str = "fluid";

libfuzzer_sys::fuzz_target!(|data: &[u8]| calls::state(data));
