#![no_main]

use fmu_wing as _;

mod calls;

/// Folder of the unit's scene in `target/fuzz`.
const KIND: &str = "wing";

libfuzzer_sys::fuzz_target!(|data: &[u8]| calls::state(data));
