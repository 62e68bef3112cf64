//! FFTW, loaded at run time: real two-dimensional transforms in double precision on one thread.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::slice::from_raw_parts_mut;

use libloading::{Library, Symbol};

const FFTW_MEASURE: c_uint = 0;

type Plan<From, To> = unsafe extern "C" fn(c_int, c_int, *mut From, *mut To, c_uint) -> *mut c_void;

/// The library.
pub struct Fftw(Library);

impl Fftw {
    /// Load the library at a path.
    pub fn load(path: &str) -> Result<Self, libloading::Error> {
        // SAFETY: FFTW's initialisation has no requirements.
        unsafe { Library::new(path) }.map(Self)
    }

    fn symbol<T>(&self, name: &str) -> Symbol<'_, T> {
        // SAFETY: each caller gives the type of FFTW 3's documentation.
        unsafe { self.0.get(name) }.unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// What the library says of itself.
    pub fn version(&self) -> String {
        let text: Symbol<*const c_char> = self.symbol("fftw_version");
        // SAFETY: a constant string.
        unsafe { CStr::from_ptr(*text) }.to_string_lossy().into_owned()
    }

    /// The transform of a field `[nx, ny]`, and that of its spectrum into another field.
    pub fn plan(&self, [nx, ny]: [usize; 2]) -> [impl Fn(); 2] {
        let allocate: Symbol<unsafe extern "C" fn(usize) -> *mut c_void> = self.symbol("fftw_malloc");
        let forward: Symbol<Plan<f64, [f64; 2]>> = self.symbol("fftw_plan_dft_r2c_2d");
        let inverse: Symbol<Plan<[f64; 2], f64>> = self.symbol("fftw_plan_dft_c2r_2d");
        let (points, modes, n0, n1) = (nx * ny, nx * (ny / 2 + 1), nx as c_int, ny as c_int);
        // SAFETY: the arrays are as large as the plans need and live as long as the program; planning overwrites them.
        let plans = unsafe {
            let [field, back] = [(); 2].map(|()| allocate(8 * points).cast());
            let spectrum = allocate(16 * modes).cast();
            let plans = [forward(n0, n1, field, spectrum, FFTW_MEASURE), inverse(n0, n1, spectrum, back, FFTW_MEASURE)];
            from_raw_parts_mut(field, points).copy_from_slice(&crate::noise(points));
            plans
        };
        plans.map(|plan| {
            assert!(!plan.is_null(), "FFTW has no plan for {nx} x {ny}");
            let execute: Symbol<unsafe extern "C" fn(*mut c_void)> = self.symbol("fftw_execute");
            // SAFETY: plan and arrays are alive.
            move || unsafe { execute(plan) }
        })
    }
}
