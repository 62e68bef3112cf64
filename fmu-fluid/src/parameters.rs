//! Parameters that a master may change before the start.

use scene::Mask;

/// Parameters of the fluid, in SI units.
#[derive(Clone, Copy, PartialEq)]
pub struct Parameters {
    pub density: f64,
    pub kinematic_viscosity: f64,
    pub c_eta: f64,
    pub max_step: f64,
    pub max_cfl: f64,
}

impl Parameters {
    /// Return the parameters of a scene.
    pub fn of(fluid: &scene::Fluid) -> Self {
        Self {
            density: fluid.density,
            kinematic_viscosity: fluid.kinematic_viscosity,
            c_eta: fluid.mask.c_eta(),
            max_step: fluid.time_stepping.max_step,
            max_cfl: fluid.time_stepping.max_cfl,
        }
    }

    /// Write the parameters to a scene.
    pub fn apply(&self, fluid: &mut scene::Fluid) {
        fluid.density = self.density;
        fluid.kinematic_viscosity = self.kinematic_viscosity;
        let (Mask::Sharp { c_eta, .. } | Mask::Cosine { c_eta, .. } | Mask::LogLinear { c_eta, .. }) = &mut fluid.mask;
        *c_eta = self.c_eta;
        fluid.time_stepping.max_step = self.max_step;
        fluid.time_stepping.max_cfl = self.max_cfl;
    }
}
