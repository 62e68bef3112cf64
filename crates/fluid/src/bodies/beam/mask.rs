//! What does not move of a beam: its thickness and its drag.

use method::Mask;

use crate::wall::DragProfile;

/// Thickness and drag of a beam.
pub struct BeamMask {
    /// Thickness at the middle of each segment, and the thickness at its end less the one at its beginning, m.
    pub thickness: Vec<[f64; 2]>,
    /// Drag of each segment.
    pub profiles: Vec<DragProfile>,
    /// Length of the mask behind the root, inside the cylinder that the beam is clamped to, m.
    pub anchor: f64,
    /// The rigid body that the beam is clamped to.
    pub support: Option<usize>,
}

impl BeamMask {
    /// Calibrate the drag of a beam with thicknesses `at` its stations and the middles of its segments, on cells of a size,
    /// m.
    pub fn new(at: &[f64], support: Option<usize>, cell: f64, mask: &Mask, nu: f64) -> Self {
        // Between the stations the thickness is taken to be linear.
        let ends = at.iter().step_by(2).zip(at.iter().step_by(2).skip(1));
        let thickness: Vec<_> = ends.map(|(start, end)| [0.5 * (start + end), end - start]).collect();
        let mut profiles = Vec::<DragProfile>::with_capacity(thickness.len());
        for k in 0..thickness.len() {
            // Segments of equal thickness share a profile: the calibration of a wall is slow.
            let known = if k > 0 && thickness[k][0] == thickness[k - 1][0] { profiles.last().copied() } else { None };
            profiles.push(known.unwrap_or_else(|| DragProfile::of_body(thickness[k][0], true, mask, nu, cell)));
        }
        let anchor = if support.is_some() { 0.5 * at[0] } else { 0.0 };
        Self { thickness, profiles, anchor, support }
    }
}
