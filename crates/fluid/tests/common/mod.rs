//! Helpers of the tests of the fluid.

use line_fft::Real;
use nervure_fluid::{Fluid, Parameters};
use rustfft::num_complex::Complex64;
use scene::Scene;

/// A scene from the parts of its fluid and the other parts.
#[allow(dead_code, reason = "not every test needs it")]
pub fn scene(fluid: &str, rest: &str) -> Scene {
    let text = format!(
        r#"{{ "name": "test", "time": {{ "end": 1.0, "communication_step": 0.01 }}, "fluid": {{
            "density": 1000.0, "time_stepping": {{ "max_step": 1.0, "max_cfl": 0.4 }},
            "mask": {{ "cosine": {{ "c_eta": 1e-4, "half_width": 1.0 }} }}, {fluid} }} {rest} }}"#
    );
    Scene::from_json(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// Make the fluid of a scene.
#[allow(dead_code, reason = "not every test needs it")]
pub fn fluid_of(scene: &Scene) -> Fluid {
    let fluid = Parameters::<2>::try_from(scene).and_then(|parameters| Fluid::new(&parameters));
    fluid.unwrap_or_else(|e| panic!("{e}"))
}

/// Make the fluid of a scene with steps of any CFL number, which a scene may not have.
#[allow(dead_code, reason = "not every test needs it")]
pub fn unlimited_fluid_of(scene: &Scene) -> Fluid {
    let unlimited = |parameters| Parameters { max_cfl: 1e9, ..parameters };
    let fluid = Parameters::<2>::try_from(scene).map(unlimited).and_then(|parameters| Fluid::new(&parameters));
    fluid.unwrap_or_else(|e| panic!("{e}"))
}

/// Make some steps of `h` seconds.
#[allow(dead_code, reason = "not every test needs it")]
pub fn run(fluid: &mut Fluid, steps: usize, h: f64) {
    for step in 0..steps {
        let t = fluid.time();
        fluid.advance(t, h).unwrap_or_else(|e| panic!("step {step}: {e}"));
    }
}

/// Spectrum of a field `[nx, ny]`, unnormalised, by whole complex transforms: mode (i, j) at `i ny + j`.
#[allow(dead_code, reason = "not every test needs it")]
pub fn spectrum(field: &[f64], [nx, ny]: [usize; 2]) -> Vec<Complex64> {
    let transposed = |from: &[Complex64], rows: usize, columns: usize| -> Vec<Complex64> {
        (0..rows * columns).map(|c| from[c % rows * columns + c / rows]).collect()
    };
    let mut modes: Vec<_> = field.iter().map(|value| Complex64::from(*value)).collect();
    f64::any_length(ny).process(&mut modes);
    let mut modes = transposed(&modes, nx, ny);
    f64::any_length(nx).process(&mut modes);
    transposed(&modes, ny, nx)
}
