//! A beam at some stations: its cells, and their places in it.
//!
//! The beam is the band around the polyline of the stations, with a flat tip; its thickness is linear in each segment.
//! At a station the tangent is the bisector of the segments beside it, and in between it turns linearly. A point
//! belongs to the place on the polyline to which the tangent is at right angles. So place, height and everything that
//! follows from them, the loads included, are continuous in the point and in the stations. At the fraction t of segment
//! k and the height n above the centre line the beam moves with the section (shear-free):
//!
//! `u_s = (1 - t) v_k + t v_{k+1} - omega n e`, `omega = (1 - t) omega_k + t omega_{k+1}`
//!
//! with e the tangent. A station turns at the rate `omega_k = (v_j - v_i)·m / |x_j - x_i|` of the line from station i
//! to j around it, with the normal m; the line is at least as long as the beam is thick. The rate over a segment alone
//! would be large for stations that move up and down in turn: their drag would be more than twice the announced
//! impedance, which is for sections that do not turn, and an explicit coupling would be unstable.

use super::frame::{Frame, Segment, StationSection};
use super::mask::BeamMask;
use super::search::{Candidate, Search};
use super::vector::{between, in_plane, lifted, normal, unit};
use crate::bodies::cells::{Cell, Cells};
use crate::bodies::measure::{Measure, Measured, Surface};
use crate::grid::Grid;
use crate::space::Space;
use contact::Stations;

/// A beam at some stations.
#[derive(Clone)]
pub struct BeamPose<const D: usize>
where
    [f64; D]: Space<D>,
{
    /// The cells in which it drags the fluid.
    pub cells: Cells<D>,
    /// Places of the cells.
    pub places: Vec<Place>,
    /// Directions of segments and sections.
    pub frame: Frame,
}

/// A place in a beam.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Number of the segment.
    pub segment: usize,
    /// Fraction along the segment.
    pub fraction: f64,
    /// Height above the centre line, m.
    pub height: f64,
    /// Unit tangent.
    pub tangent: [f64; 2],
    /// Whether it lies behind the root, where a cylinder bears the drag.
    pub is_behind_root: bool,
}

/// A place of a [`Measured`] beam.
struct BeamPoint<const D: usize> {
    /// The grid point, m.
    point: [f64; D],
    place: Place,
    /// Fraction along the segment, beyond the ends of the beam too.
    fraction: f64,
}

/// A beam that moves from the stations `before` to `stations`.
struct MovingBeam<'a, const D: usize> {
    mask: &'a BeamMask,
    frame: &'a Frame,
    stations: &'a Stations<D>,
    before: &'a Stations<D>,
}

impl Place {
    /// Return the velocity of the section if stations turn at the rates `omega` (1/s), m/s.
    fn velocity<const D: usize>(
        &self,
        sections: &[StationSection],
        omega: impl Fn(&StationSection) -> f64,
        at: &Stations<D>,
    ) -> [f64; 2] {
        let (k, t) = (self.segment, self.fraction);
        let [start, end] = [k, k + 1].map(|k| in_plane(&at.velocity).map(|v| v[k]));
        let omega = (1.0 - t) * omega(&sections[k]) + t * omega(&sections[k + 1]);
        let center = between(start, end, t);
        [0, 1].map(|axis| center[axis] - omega * self.height * self.tangent[axis])
    }
}

/// The surfaces are the upper and the lower one and the end.
impl<const D: usize> Measured<D, 3> for MovingBeam<'_, D>
where
    [f64; D]: Space<D>,
{
    type Place = BeamPoint<D>;

    #[inline(always)]
    fn measure(&self, BeamPoint { point, place, fraction }: &BeamPoint<D>) -> Measure<D, 3> {
        let (k, sections) = (place.segment, &self.frame.sections);
        let Segment { length, slope, stretch, .. } = self.frame.segments[k];
        let beyond = if k == 0 {
            -fraction * length - self.mask.anchor
        } else if k == self.frame.segments.len() - 1 {
            (fraction - 1.0) * length
        } else {
            f64::NEG_INFINITY
        };
        let [thickness, growth] = self.mask.thickness[k];
        let half = 0.5 * (thickness + (place.fraction - 0.5) * growth);
        let [above, below] = [place.height, -place.height].map(|height| (height - half) / stretch);
        let (tangent, across) = (place.tangent, normal(place.tangent));
        let [upper, lower] =
            [1.0, -1.0].map(|side| [0, 1].map(|axis| (side * across[axis] - slope * tangent[axis]) / stretch));
        let end = if k == 0 { tangent.map(|component| -component) } else { tangent };
        let surface = |distance: f64, normal: [f64; 2]| {
            let foot = [0, 1].map(|axis| point[axis] - distance * normal[axis]);
            Surface { distance, foot: lifted(foot), normal: lifted(normal) }
        };
        Measure {
            surfaces: [surface(above, upper), surface(below, lower), surface(beyond, end)],
            velocity: lifted(place.velocity(sections, |section| section.omega, self.stations)),
            velocity_before: lifted(place.velocity(sections, |section| section.omega_before, self.before)),
            spin: None,
        }
    }
}

impl<const D: usize> BeamPose<D>
where
    [f64; D]: Space<D>,
{
    /// A beam of a length and thicknesses (m) without a place yet.
    pub fn new(length: f64, thickness: &[f64]) -> Self {
        Self { cells: Cells::default(), places: Vec::new(), frame: Frame::new(length, thickness) }
    }

    /// List the cells at `stations`, to which the beam moves from `before`.
    pub fn find_cells(
        &mut self,
        mask: &BeamMask,
        search: &mut Search,
        stations: &Stations<D>,
        before: &Stations<D>,
        grid: &Grid<D>,
    ) {
        let Self { cells, places, frame } = self;
        frame.orient(&mask.thickness, stations, before);
        let frame = &*frame;
        cells.clear();
        places.clear();
        let beam = MovingBeam { mask, frame, stations, before };
        for Candidate { index, segment, fraction, height, arm, .. } in search.find(frame, mask, stations, grid) {
            let is_behind_root = mask.support.is_some() && fraction < 0.0;
            let inside = fraction.clamp(0.0, 1.0);
            let tangents = [segment, segment + 1].map(|k| frame.sections[k].tangent);
            let tangent = unit(between(tangents[0], tangents[1], inside));
            let place = Place { segment, fraction: inside, height, tangent, is_behind_root };
            let measure = beam.measure(&BeamPoint { point: grid.point(index), place, fraction });
            if cells.add(index, lifted(arm), &measure, &mask.profiles[segment], grid) {
                places.push(place);
            }
        }
    }

    /// Return the cells, each with the velocity of its section (m/s) unless the cylinder bears its drag.
    pub fn cells_and_velocities<'a>(
        &'a self,
        stations: &'a Stations<D>,
    ) -> impl Iterator<Item = (&'a Cell<D>, Option<[f64; 2]>)> {
        let velocity = |place: &Place| place.velocity(&self.frame.sections, |section| section.omega, stations);
        let cells = self.cells.iter().zip(&self.places);
        cells.map(move |(cell, place)| (cell, (!place.is_behind_root).then(|| velocity(place))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use method::Mask;

    /// A straight beam along x that tapers from 0.2 to 0.04: its surfaces are straight lines, also beyond them.
    #[test]
    fn surfaces_of_a_tapered_beam_are_straight_lines() {
        let thickness: Vec<_> = (0..=16).map(|k| 0.2 - 0.16 * f64::from(k) / 16.0).collect();
        let grid = Grid::new([[-0.5, 1.5]; 2], [64; 2]);
        let sharp = Mask::Sharp { c_eta: 1.0, displacement_corrected: false };
        let (mask, mut frame) =
            (BeamMask::new(&thickness, None, grid.cell_size(), &sharp, 1e-3), Frame::new(1.0, &thickness));
        let along = (0..=8).map(|k| f64::from(k) / 8.0).collect();
        let stations = Stations { position: [along, vec![0.0; 9]], velocity: [vec![0.0; 9], vec![0.0; 9]] };
        frame.orient(&mask.thickness, &stations, &stations);
        let moving = MovingBeam { mask: &mask, frame: &frame, stations: &stations, before: &stations };
        // The upper side is y = 0.1 − 0.08 x.
        let stretch = (1.0 + 0.08_f64 * 0.08).sqrt();
        for (segment, fraction, height) in [(0, 0.3, 0.07), (3, 0.5, -0.09), (7, 0.9, 0.05)] {
            let x = (segment as f64 + fraction) / 8.0;
            let place = Place { segment, fraction, height, tangent: [1.0, 0.0], is_behind_root: false };
            let found = moving.measure(&BeamPoint { point: [x, height], place, fraction });
            for (side, surface) in [1.0, -1.0].into_iter().zip(found.surfaces) {
                let distance = (side * height - (0.1 - 0.08 * x)) / stretch;
                let normal = [0.08 / stretch, side / stretch];
                let foot = [x - distance * normal[0], height - distance * normal[1]];
                assert!((surface.distance - distance).abs() < 1e-14, "{surface:?}: distance {distance}");
                assert!((side * foot[1] - (0.1 - 0.08 * foot[0])).abs() < 1e-14, "the foot is not on the side");
                for axis in 0..2 {
                    assert!((surface.normal[axis] - normal[axis]).abs() < 1e-14, "{surface:?}: normal {normal:?}");
                    assert!((surface.foot[axis] - foot[axis]).abs() < 1e-14, "{surface:?}: foot {foot:?}");
                }
            }
        }
    }
}
