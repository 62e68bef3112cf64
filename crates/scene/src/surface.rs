//! The fluid that moves with a beam: inside its mask, or in the layer of a line.

use method::Surface;

use crate::beam::Beam;
use crate::fluid::Fluid;
use crate::rod::Rod;
use crate::scene::Scene;

/// Thickness of the plate that a line in the plane stands for, cells. `fluid` derives it from the kernel of its
/// markers.
pub const LINE_THICKNESS_CELLS: f64 = 2_286_280_459.0 / 1_556_755_200.0;

/// Thickness of the plate that a surface in space stands for, cells.
pub const SURFACE_THICKNESS_CELLS: f64 = 1487.0 / 1134.0;

/// Cross-section of the rod that a line stands for in space, cells². `fluid` derives it from the kernel of its markers.
pub const ROD_SECTION_CELLS: f64 = (315.0 / 151.0) * (315.0 / 151.0);

/// Radius of the rod that drags like a line in space in slow flow, cells. `fluid` derives it from that kernel, too.
pub const ROD_RADIUS_CELLS: f64 = 0.873_538_9;

impl Scene {
    /// Return the mass of the fluid that moves with a beam, per length and, in the plane, metre of depth, at a place
    /// from 0 at the root to 1 at the tip: of the fluid inside the mask, or in the layer that a line stands for. In
    /// space a rod that is thinner than its line has a layer as if its cells were as small. A rod on a line that is
    /// lighter than this layer has as little as itself.
    pub(crate) fn displaced<'a>(&self, fluid: &'a Fluid, beam: &'a Beam, rod: &'a Rod) -> impl Fn(f64) -> f64 + 'a {
        let cell = fluid.spacing().into_iter().fold(0.0, f64::max);
        move |s| {
            let thickness = beam.thickness.at(s);
            let layer = match beam.surface {
                Surface::Line if fluid.is_space() => {
                    ROD_SECTION_CELLS * cell.min(0.5 * thickness / ROD_RADIUS_CELLS).powi(2)
                }
                Surface::Line => LINE_THICKNESS_CELLS * cell,
                Surface::Mask => return fluid.density * thickness,
            };
            (fluid.density * layer).min(rod.material.section(&beam.thickness, s).line_density)
        }
    }
}
