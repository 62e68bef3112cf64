//! How beams meet the fluid: by a mask or as a line.

use crate::beam::{Beam, Surface};
use crate::fluid::Fluid;
use crate::method::TimeScheme;
use crate::rod::Rod;
use crate::scene::Scene;

/// Thickness of the plate that a line stands for, cells. `fluid` derives it from the kernel of its markers.
pub const LINE_THICKNESS_CELLS: f64 = 1487.0 / 1134.0;

/// A beam whose thickness has fewer cells is a line by default: a mask cannot hold it. Above, the blunt tip and the
/// thickness of a bar count for more than the noise of its mask.
const MASK_CELLS: f64 = 2.0;

impl Scene {
    /// Return how a beam meets the fluid, and the reason as a clause; none without a fluid. It is never
    /// [`Surface::Auto`].
    pub fn surface(&self, beam: &Beam) -> Option<(Surface, String)> {
        let fluid = self.fluid.as_ref()?;
        if beam.surface != Surface::Auto {
            return Some((beam.surface, "the scene says so".into()));
        }
        if fluid.time_stepping.scheme == TimeScheme::Rk2 {
            return Some((Surface::Mask, "the scheme rk2 has no lines".into()));
        }
        let thinnest = beam.places().map(|s| beam.thickness.at(s)).fold(f64::INFINITY, f64::min);
        let cells = thinnest / cell_size(fluid);
        Some(if cells < MASK_CELLS {
            (Surface::Line, format!("it is {cells:.3} cells thick, and a mask needs {MASK_CELLS} or more"))
        } else {
            (Surface::Mask, format!("it is {cells:.3} cells thick, {MASK_CELLS} or more"))
        })
    }

    /// Return whether the fluid meets a beam as a line.
    pub fn is_line(&self, beam: &Beam) -> bool {
        self.surface(beam).is_some_and(|(surface, _)| surface == Surface::Line)
    }

    /// Return the mass of the fluid that moves with a beam, per length and metre of depth, kg/m², at a place from 0 at the
    /// root to 1 at the tip: of the fluid inside the mask, or in the layer that a line stands for. A rod on a line that
    /// is lighter than this layer has as little as itself.
    pub(crate) fn displaced<'a>(&self, fluid: &'a Fluid, beam: &'a Beam, rod: &'a Rod) -> impl Fn(f64) -> f64 + 'a {
        let (line, layer) = (self.is_line(beam), LINE_THICKNESS_CELLS * cell_size(fluid));
        move |s| {
            if line {
                (fluid.density * layer).min(rod.material.section(&beam.thickness, s).line_density)
            } else {
                fluid.density * beam.thickness.at(s)
            }
        }
    }
}

/// Return the coarsest spacing, m.
fn cell_size(fluid: &Fluid) -> f64 {
    fluid.r#box.spacing().into_iter().fold(0.0, f64::max)
}
