//! Directions of the segments and sections of a beam, and how the sections turn.

use super::vector::{bisector, difference, direction, dot, normal};
use contact::Stations;

/// Directions of a beam at some stations.
#[derive(Clone)]
pub struct Frame {
    /// Segments.
    pub segments: Vec<Segment>,
    /// Sections at the stations, `[segments + 1]`.
    pub sections: Vec<StationSection>,
}

/// Direction and length of a segment.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Unit vector along it.
    pub along: [f64; 2],
    /// Length, m.
    pub length: f64,
    /// Slope of the upper surface against the centre line.
    pub slope: f64,
    /// Length of that surface over the length of the segment.
    pub stretch: f64,
}

/// The section at a station.
#[derive(Clone, Copy, Debug)]
pub struct StationSection {
    /// Unit tangent.
    pub tangent: [f64; 2],
    /// Stations that determine how the section turns, the unit normal of the line between them, and its length, m.
    pub ends: [usize; 2],
    pub across: [f64; 2],
    pub span: f64,
    /// Rates at which it turns at the end and at the beginning of the step, 1/s.
    pub omega: f64,
    pub omega_before: f64,
}

impl Frame {
    /// A frame of a beam of a length and thicknesses (m) without directions yet.
    pub fn new(length: f64, thickness: &[f64]) -> Self {
        let segments = thickness.len() / 2;
        let segment = Segment { along: [1.0, 0.0], length: 1.0, slope: 0.0, stretch: 1.0 };
        let section = |k: usize| {
            let half = (0.5 * thickness[2 * k] * segments as f64 / length).ceil() as usize;
            let span = (2 * half).clamp(2, segments);
            let from = k.saturating_sub(span / 2).min(segments - span);
            StationSection {
                tangent: [1.0, 0.0],
                ends: [from, from + span],
                across: [0.0, 1.0],
                span: 1.0,
                omega: 0.0,
                omega_before: 0.0,
            }
        };
        Self { segments: vec![segment; segments], sections: (0..=segments).map(section).collect() }
    }

    /// Turn to `stations`, with the velocities there and at the stations `before`.
    pub fn orient<const D: usize>(&mut self, thickness: &[[f64; 2]], stations: &Stations<D>, before: &Stations<D>) {
        for (k, (segment, [_, growth])) in self.segments.iter_mut().zip(thickness).enumerate() {
            let (along, length) = direction(difference(&stations.position, [k, k + 1]));
            let slope = 0.5 * growth / length;
            *segment = Segment { along, length, slope, stretch: (1.0 + slope * slope).sqrt() };
        }
        for (k, section) in self.sections.iter_mut().enumerate() {
            section.tangent = bisector(k, self.segments.len() - 1, |k| self.segments[k].along);
            let (line, span) = direction(difference(&stations.position, section.ends));
            (section.span, section.across) = (span, normal(line));
            [section.omega, section.omega_before] = [stations, before]
                .map(|stations| dot(difference(&stations.velocity, section.ends), section.across) / section.span);
        }
    }
}
