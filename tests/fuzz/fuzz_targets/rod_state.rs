#![no_main]

use fmu_rod as _;

mod calls;

/// Folder of the unit's scene in `target/fuzz`.
const KIND: &str = "rod";

libfuzzer_sys::fuzz_target!(|data: &[u8]| calls::state(data));
