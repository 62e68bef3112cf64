//! The search for the grid points near a beam.

use super::frame::{Frame, Segment};
use super::mask::BeamMask;
use crate::grid::Grid;
use contact::Stations;

/// A grid point that the mask may reach, with its place on the polyline of the stations.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Index of the grid point.
    pub index: usize,
    /// Number of the segment.
    pub segment: usize,
    /// Fraction along the segment; it may lie beyond the ends of the beam.
    pub fraction: f64,
    /// Height above the centre line, m.
    pub height: f64,
    /// Squared distance from the place on the polyline, m².
    distance_squared: f64,
    /// Position from the root, m.
    pub arm: [f64; 2],
}

/// Room for a search.
pub struct Search {
    /// For each grid point, 1 + its number among the candidates; 0 if it is none.
    slot: Vec<u32>,
    candidates: Vec<Candidate>,
}

impl Search {
    /// Room for a search on a grid.
    pub fn new<const D: usize>(grid: &Grid<D>) -> Self {
        Self { slot: vec![0; grid.len()], candidates: Vec::new() }
    }

    /// Return the grid points that the mask may reach, each with its nearest place.
    pub fn find<const D: usize>(
        &mut self,
        frame: &Frame,
        mask: &BeamMask,
        stations: &Stations<D>,
        grid: &Grid<D>,
    ) -> impl Iterator<Item = Candidate> {
        /// Share of a segment by which the end of a segment may seem to lie beyond its neighbour.
        const ROUNDING: f64 = 1e-9;
        let last = frame.segments.len() - 1;
        let root = [stations.position[0][0], stations.position[1][0]];
        let Self { slot, candidates } = self;
        for (k, &Segment { along: [ex, ey], length, .. }) in frame.segments.iter().enumerate() {
            let [thickness, growth] = mask.thickness[k];
            let reach = 0.5 * (thickness + 0.5 * growth.abs()) + mask.profiles[k].reach();
            let [x0, y0] = [stations.position[0][k], stations.position[1][k]];
            // The tangents at both ends, along the segment and to the left.
            let [(c0, s0), (c1, s1)] = [k, k + 1].map(|k| {
                let [tx, ty] = frame.sections[k].tangent;
                (tx * ex + ty * ey, ex * ty - ey * tx)
            });
            // Extent of the rectangle of the segment beyond its stations, with the leaning sections at both ends.
            let wedge = |c: f64, s: f64| if c > s.abs() { reach * s.abs() / c } else { reach };
            let before = if k == 0 { reach + mask.anchor } else { wedge(c0, s0) };
            let beyond = if k == last { reach } else { wedge(c1, s1) };
            // The smallest upright rectangle around it.
            let end = length + beyond;
            let around = |start: f64, along: f64, across: f64| {
                let (a, b) = (start - before * along, start + end * along);
                let margin = reach * across.abs();
                [a.min(b) - margin, a.max(b) + margin]
            };
            let ends = [around(x0, ex, ey), around(y0, ey, ex)];
            grid.for_each_in(std::array::from_fn(|axis| ends[axis.min(1)]), |index, point| {
                let (x, y) = (point[0], point[1]);
                let (rx, ry) = (x - x0, y - y0);
                let ahead = rx * ex + ry * ey;
                let side = ex * ry - ey * rx;
                if ahead < -before || ahead > end || side.abs() > reach {
                    return;
                }
                // (r − t l e)·((1 − t) T_k + t T_{k+1}) = 0; beyond the ends of the beam the tangent is constant.
                let start = ahead * c0 + side * s0;
                let stop = (ahead - length) * c1 + side * s1;
                let fraction = if (k == 0 && start < 0.0) || (k == last && stop > 0.0) {
                    ahead / length
                } else if start < -ROUNDING * length || stop > ROUNDING * length {
                    return;
                } else {
                    let (bend, rate) = (length * (c1 - c0), ahead * (c1 - c0) + side * (s1 - s0) - length * c0);
                    (2.0 * start / ((rate * rate + 4.0 * bend * start).sqrt() - rate)).clamp(0.0, 1.0)
                };
                if fraction.is_nan() {
                    return;
                }
                let off = ahead - fraction * length;
                let (height, arm) = (side.hypot(off).copysign(side), [x - root[0], y - root[1]]);
                let past = (fraction - fraction.clamp(0.0, 1.0)) * length;
                let distance_squared = height * height + past * past;
                let candidate = Candidate { index, segment: k, fraction, height, distance_squared, arm };
                match slot[index] {
                    0 => {
                        candidates.push(candidate);
                        slot[index] = candidates.len() as u32;
                    }
                    number => {
                        let known = &mut candidates[number as usize - 1];
                        if distance_squared < known.distance_squared {
                            *known = candidate;
                        }
                    }
                }
            });
        }
        candidates.drain(..).inspect(|candidate| slot[candidate.index] = 0)
    }
}
