//! Markers: their places, and the grid points around them with the weights of the kernel.

use std::ops::Range;

use super::kernel::{self, HALF_WIDTH};
use crate::grid::Grid;

/// Grid points in the kernel along an axis.
const WIDTH: i64 = 4;

/// Markers with their grid points.
pub struct Markers<const D: usize> {
    own: Vec<Marker<D>>,
    /// Weights along each axis, marker by marker.
    along: Vec<f64>,
    /// Grid points of all markers, the weight of each, and the weight over C, s.
    points: Vec<usize>,
    weights: Vec<f64>,
    weighed: Vec<f64>,
}

/// A marker.
#[derive(Clone)]
pub struct Marker<const D: usize> {
    /// Position, m, and velocity, m/s.
    pub position: [f64; D],
    pub velocity: [f64; D],
    /// Length or area that it stands for, m or m².
    pub measure: f64,
    /// Drag rate of the line or surface, m/s.
    kappa: f64,
    /// First grid point along each axis, and the weights from there on.
    spans: [(usize, Range<usize>); D],
    /// Its grid points.
    points: Range<usize>,
}

impl<const D: usize> Default for Markers<D> {
    fn default() -> Self {
        Self { own: vec![], along: vec![], points: vec![], weights: vec![], weighed: vec![] }
    }
}

impl<const D: usize> Markers<D> {
    /// Add a marker that stands for a length or area (m or m²), with the drag rate of the line or surface (m/s).
    pub fn add(&mut self, measure: f64, kappa: f64) {
        let spans = std::array::from_fn(|_| (0, 0..0));
        let (position, velocity) = ([0.0; D], [0.0; D]);
        self.own.push(Marker { position, velocity, measure, kappa, spans, points: 0..0 });
    }

    /// Return the number of markers.
    pub fn len(&self) -> usize {
        self.own.len()
    }

    /// Return a marker.
    pub fn get(&self, k: usize) -> &Marker<D> {
        &self.own[k]
    }

    /// Return a marker, to be moved before [`Self::find_cells`].
    pub fn get_mut(&mut self, k: usize) -> &mut Marker<D> {
        &mut self.own[k]
    }

    /// Return the velocities, m/s.
    pub fn velocities(&self) -> impl Iterator<Item = [f64; D]> {
        self.own.iter().map(|marker| marker.velocity)
    }

    /// Find the grid points around the markers at their present places.
    pub fn find_cells(&mut self, grid: &Grid<D>) {
        let Self { own, along, points, weights, .. } = self;
        along.clear();
        points.clear();
        weights.clear();
        for marker in own {
            for axis in 0..D {
                let place = (marker.position[axis] - grid.coordinate(axis, 0)) / grid.spacing[axis];
                let (first, begin) = ((place - HALF_WIDTH).ceil() as i64, along.len());
                along.extend((first..first + WIDTH).map(|i| kernel::value(i as f64 - place)));
                marker.spans[axis] = (grid.wrap(axis, first), begin..along.len());
            }
            let begin = points.len();
            multiply(grid, &marker.spans, along, 0, (0, 1.0), &mut |point, weight| {
                points.push(point);
                weights.push(weight);
            });
            marker.points = begin..points.len();
        }
    }

    /// Return the grid points around all markers.
    pub fn points(&self) -> &[usize] {
        &self.points
    }

    /// Set the inverse of C (s), given at a grid point.
    pub fn weigh(&mut self, inverse: impl Fn(usize) -> f64) {
        let Self { points, weights, weighed, .. } = self;
        weighed.clear();
        weighed.extend(points.iter().zip(weights).map(|(point, weight)| *weight * inverse(*point)));
    }

    /// Write a field of vectors, given at a grid point, as interpolated at the markers, `[D][markers]`.
    pub fn interpolate(&self, field: impl Fn(usize) -> [f64; D], values: &mut [Vec<f64>; D]) {
        for (k, marker) in self.own.iter().enumerate() {
            let mut sum = [0.0; D];
            for (point, weight) in self.points[marker.points.clone()].iter().zip(&self.weights[marker.points.clone()]) {
                sum.iter_mut().zip(field(*point)).for_each(|(sum, field)| *sum += weight * field);
            }
            values.iter_mut().zip(sum).for_each(|(values, sum)| values[k] = sum);
        }
    }

    /// Call `add` with each grid point and the number of each marker there times its weight over C.
    pub fn spread(&self, numbers: &[f64], mut add: impl FnMut(usize, f64)) {
        for (marker, number) in self.own.iter().zip(numbers) {
            let pairs = self.points[marker.points.clone()].iter().zip(&self.weighed[marker.points.clone()]);
            pairs.for_each(|(point, weighed)| add(*point, number * weighed));
        }
    }

    /// Return the first grid point of a marker along each axis.
    pub fn first_point(&self, k: usize) -> [usize; D] {
        self.own[k].spans.each_ref().map(|(first, _)| *first)
    }

    /// Return the inverse of the drag rate of a marker times what it stands for: s/m² in two dimensions.
    pub fn inverse_drag(&self, k: usize) -> f64 {
        let Marker { measure, kappa, .. } = self.own[k];
        1.0 / (kappa * measure)
    }

    /// Return `Σ w_j w_k/C` over the grid points that two markers share, s; none if they share no point.
    pub fn shared(&self, j: usize, k: usize, grid: &Grid<D>) -> Option<f64> {
        let [one, other] = [j, k].map(|marker| &self.own[marker]);
        let mut overlap: [(Range<usize>, usize); D] = std::array::from_fn(|_| (0..0, 0));
        for (axis, overlap) in overlap.iter_mut().enumerate() {
            let ((a, span_a), (b, span_b)) = (&one.spans[axis], &other.spans[axis]);
            let offset = grid.offset(axis, *a, *b);
            let range = offset.max(0)..(offset + span_b.len() as i64).min(span_a.len() as i64);
            if range.is_empty() {
                return None;
            }
            let from = (span_b.start as i64 + range.start - offset) as usize;
            *overlap = (range.start as usize..range.end as usize, from);
        }
        Some(self.sum_of_products(one, &overlap, 0, 0, 1.0))
    }

    /// Sum up over `axis` and the later ones; `row` counts the points of the earlier axes, `weight` is the product of
    /// the other marker's weights along them.
    fn sum_of_products(
        &self,
        one: &Marker<D>,
        overlap: &[(Range<usize>, usize); D],
        axis: usize,
        row: usize,
        weight: f64,
    ) -> f64 {
        let (range, from) = &overlap[axis];
        let others = &self.along[*from..*from + range.len()];
        let row = row * one.spans[axis].1.len();
        let pairs = range.clone().zip(others);
        if axis + 1 == D {
            let begin = one.points.start + row;
            return weight * pairs.map(|(i, other)| self.weighed[begin + i] * other).sum::<f64>();
        }
        pairs.map(|(i, other)| self.sum_of_products(one, overlap, axis + 1, row + i, weight * other)).sum()
    }
}

/// Call `add` with each grid point of the spans of a marker and the product of its weights. `axis` is the first axis
/// left; `before` is the number of the point along the earlier axes, and the product of its weights.
fn multiply<const D: usize>(
    grid: &Grid<D>,
    spans: &[(usize, Range<usize>); D],
    along: &[f64],
    axis: usize,
    before: (usize, f64),
    add: &mut impl FnMut(usize, f64),
) {
    let (first, weights) = &spans[axis];
    let mut place = *first;
    for weight in &along[weights.clone()] {
        let next = (before.0 * grid.cells[axis] + place, before.1 * weight);
        if axis + 1 == D {
            add(next.0, next.1)
        } else {
            multiply(grid, spans, along, axis + 1, next, add)
        }
        place = if place + 1 == grid.cells[axis] { 0 } else { place + 1 };
    }
}
