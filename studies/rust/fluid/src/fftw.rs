//! FFTW, loaded at run time: real two-dimensional transforms in double precision on one thread.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::slice::from_raw_parts_mut;

use libloading::{Library, Symbol};

type Allocate = unsafe extern "C" fn(usize) -> *mut f64;
type Plan = unsafe extern "C" fn(c_int, c_int, *mut f64, *mut f64, c_uint) -> *mut c_void;
type Execute = unsafe extern "C" fn(*mut c_void);

const FFTW_MEASURE: c_uint = 0;

fn symbol<'a, T>(library: &'a Library, name: &str) -> Symbol<'a, T> {
    // SAFETY: each caller gives the type of FFTW 3's documentation.
    unsafe { library.get(name) }.unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// What the library says of itself.
pub fn version(library: &Library) -> String {
    let text: Symbol<*const c_char> = symbol(library, "fftw_version");
    // SAFETY: a constant string.
    unsafe { CStr::from_ptr(*text) }.to_string_lossy().into_owned()
}

/// The transform of a field `[nx, ny]`, and that of its spectrum into another field.
pub fn plan(library: &Library, [nx, ny]: [usize; 2]) -> [impl Fn(); 2] {
    let allocate: Symbol<Allocate> = symbol(library, "fftw_malloc");
    let plans: [Symbol<Plan>; 2] = ["fftw_plan_dft_r2c_2d", "fftw_plan_dft_c2r_2d"].map(|name| symbol(library, name));
    let (points, modes) = (nx * ny, nx * (ny / 2 + 1));
    // SAFETY: the arrays are as large as the plans need and live as long as the program; planning overwrites them.
    let plans = unsafe {
        let [field, spectrum, back] = [points, 2 * modes, points].map(|n| allocate(8 * n));
        let plan = |k: usize, from, to| plans[k](nx as c_int, ny as c_int, from, to, FFTW_MEASURE);
        let plans = [plan(0, field, spectrum), plan(1, spectrum, back)];
        from_raw_parts_mut(field, points).copy_from_slice(&crate::noise(points));
        plans
    };
    plans.map(|plan| {
        assert!(!plan.is_null(), "FFTW has no plan for {nx} x {ny}");
        let execute: Symbol<Execute> = symbol(library, "fftw_execute");
        // SAFETY: plan and arrays are alive.
        move || unsafe { execute(plan) }
    })
}
