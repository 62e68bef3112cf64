//! FFTW, loaded at run time: real transforms on one thread.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::slice::from_raw_parts_mut;

use libloading::{Library, Symbol};
use line_fft::Real;

type Allocate = unsafe extern "C" fn(usize) -> *mut c_void;
type Plan = unsafe extern "C" fn(c_int, *const c_int, *mut c_void, *mut c_void, c_uint) -> *mut c_void;
type Execute = unsafe extern "C" fn(*mut c_void);

const FFTW_MEASURE: c_uint = 0;

/// Load the library at a path, in double precision.
pub fn load(path: &Path) -> Result<Library, libloading::Error> {
    // SAFETY: FFTW's initialisation has no requirements.
    unsafe { Library::new(path) }
}

/// Load the library in single precision that lies beside the one at a path.
pub fn load_single(path: &Path) -> Result<Library, Box<dyn std::error::Error>> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let single = |name: &std::ffi::OsStr| name.to_string_lossy().starts_with("libfftw3f-");
    let mut files = std::fs::read_dir(folder)?.filter_map(Result::ok);
    let found = files.find(|file| single(&file.file_name())).ok_or("no libfftw3f beside FFTW_LIBRARY")?;
    Ok(load(&found.path())?)
}

/// Return a symbol of a library of the precision `R`.
fn symbol<'a, R: Real, T>(library: &'a Library, name: &str) -> Symbol<'a, T> {
    let prefix = if size_of::<R>() == 8 { "fftw" } else { "fftwf" };
    // SAFETY: each caller gives the type of FFTW 3's documentation.
    unsafe { library.get(format!("{prefix}_{name}")) }.unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// What the library says of itself.
pub fn version(library: &Library) -> String {
    let text: Symbol<*const c_char> = symbol::<f64, _>(library, "version");
    // SAFETY: a constant string.
    unsafe { CStr::from_ptr(*text) }.to_string_lossy().into_owned()
}

/// The transform of a field of a shape, and that of its spectrum into another field.
pub fn plan<'a, R: Real>(library: &'a Library, shape: &[usize]) -> [impl Fn() + use<'a, R>; 2] {
    let allocate: Symbol<Allocate> = symbol::<R, _>(library, "malloc");
    let plans: [Symbol<Plan>; 2] = ["plan_dft_r2c", "plan_dft_c2r"].map(|name| symbol::<R, _>(library, name));
    let points: usize = shape.iter().product();
    let modes = shape.last().map_or(0, |last| points / last * (last / 2 + 1));
    let counts: Vec<_> = shape.iter().map(|count| *count as c_int).collect();
    // SAFETY: the arrays are as large as the plans need and live as long as the program; planning overwrites them.
    let plans = unsafe {
        let [field, spectrum, back] = [points, 2 * modes, points].map(|n| allocate(size_of::<R>() * n));
        let plan = |k: usize, from, to| plans[k](counts.len() as c_int, counts.as_ptr(), from, to, FFTW_MEASURE);
        let plans = [plan(0, field, spectrum), plan(1, spectrum, back)];
        let noise: Vec<_> = crate::noise(points).into_iter().map(R::rounded).collect();
        from_raw_parts_mut(field.cast(), points).copy_from_slice(&noise);
        plans
    };
    plans.map(|plan| {
        assert!(!plan.is_null(), "FFTW has no plan for {shape:?}");
        let execute: Symbol<Execute> = symbol::<R, _>(library, "execute");
        // SAFETY: plan and arrays are alive.
        move || unsafe { execute(plan) }
    })
}
