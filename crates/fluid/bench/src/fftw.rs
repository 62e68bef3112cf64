//! FFTW, loaded at run time: real two-dimensional transforms in double precision on one thread.

use std::ffi::{c_int, c_uint, c_void};
use std::slice::from_raw_parts_mut;

use libloading::{Library, Symbol};

const FFTW_MEASURE: c_uint = 0;

type PlanForward = unsafe extern "C" fn(c_int, c_int, *mut f64, *mut [f64; 2], c_uint) -> *mut c_void;
type PlanInverse = unsafe extern "C" fn(c_int, c_int, *mut [f64; 2], *mut f64, c_uint) -> *mut c_void;

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
        unsafe { self.0.get(name.as_bytes()) }.unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// What the library says of itself.
    pub fn version(&self) -> String {
        let text: Symbol<*const std::ffi::c_char> = self.symbol("fftw_version");
        // SAFETY: a constant string.
        unsafe { std::ffi::CStr::from_ptr(*text) }.to_string_lossy().into_owned()
    }

    /// Plan transforms of `[nx, ny]` fields.
    pub fn plan(&self, nx: usize, ny: usize) -> Transforms<'_> {
        let allocate: Symbol<unsafe extern "C" fn(usize) -> *mut c_void> = self.symbol("fftw_malloc");
        let plan_forward: Symbol<PlanForward> = self.symbol("fftw_plan_dft_r2c_2d");
        let plan_inverse: Symbol<PlanInverse> = self.symbol("fftw_plan_dft_c2r_2d");
        let (points, modes, (n0, n1)) = (nx * ny, nx * (ny / 2 + 1), (nx as c_int, ny as c_int));
        // SAFETY: the arrays are as large as the plans need and planned for; planning with MEASURE overwrites them.
        unsafe {
            let [field, back] = [(); 2].map(|()| allocate(8 * points).cast::<f64>());
            let spectrum = allocate(16 * modes).cast::<[f64; 2]>();
            let forward = plan_forward(n0, n1, field, spectrum, FFTW_MEASURE);
            let inverse = plan_inverse(n0, n1, spectrum, back, FFTW_MEASURE);
            assert!(!forward.is_null() && !inverse.is_null(), "FFTW has no plan for {nx} x {ny}");
            from_raw_parts_mut(field, points).copy_from_slice(&crate::noise(points));
            Transforms { execute: self.symbol("fftw_execute"), forward, inverse }
        }
    }
}

/// A forward and an inverse transform with the arrays they work on; they live as long as the program.
pub struct Transforms<'a> {
    execute: Symbol<'a, unsafe extern "C" fn(*mut c_void)>,
    forward: *mut c_void,
    inverse: *mut c_void,
}

impl Transforms<'_> {
    /// Spectrum of the field.
    pub fn forward(&self) {
        // SAFETY: plan and arrays are alive.
        unsafe { (self.execute)(self.forward) }
    }

    /// Field of the spectrum, to another array than that which `forward` reads.
    pub fn inverse(&self) {
        // SAFETY: plan and arrays are alive.
        unsafe { (self.execute)(self.inverse) }
    }
}
