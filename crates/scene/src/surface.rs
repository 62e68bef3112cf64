//! The fluid that moves with a beam: inside its mask, or in the layer of a line.

use method::{LINE_THICKNESS_CELLS, ROD_RADIUS_CELLS, ROD_SECTION_CELLS, SURFACE_THICKNESS_CELLS, Surface};

use crate::beam::Beam;
use crate::fluid::Fluid;
use crate::rod::Rod;
use crate::scene::Scene;
use crate::shape::Shape;

impl Scene {
    /// Return the mass of the fluid that moves with a beam, per length and, in the plane, metre of depth, at a place
    /// from 0 at the root to 1 at the tip: of the fluid inside the mask, or in the layer that a line stands for. In
    /// space a rod that is thinner than its line has a layer as if its cells were as small. A rod on a line that is
    /// lighter than this layer has as little as itself.
    pub(crate) fn displaced<'a>(&self, fluid: &'a Fluid, beam: &'a Beam, rod: &'a Rod) -> impl Fn(f64) -> f64 + 'a {
        let cell = fluid.largest_cell();
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

    /// Return the thickness of the layer for which thin bodies stand, m; none without one, and of rods in space, whose layer
    /// is as thick as they are.
    pub(crate) fn thin_layer(&self, fluid: &Fluid) -> Option<f64> {
        let mut lines = self.beams_with_rods().map(|own| own.beam.surface);
        let is_line = !fluid.is_space() && lines.any(|surface| surface == Surface::Line);
        let has_markers = |shape: &Shape| shape.line().is_some() || shape.surface().is_some();
        let is_thin =
            is_line || self.wings().next().is_some() || fluid.obstacles().any(|own| has_markers(&own.body.shape));
        let cells = if fluid.is_space() { SURFACE_THICKNESS_CELLS } else { LINE_THICKNESS_CELLS };
        is_thin.then_some(cells * fluid.largest_cell())
    }
}
