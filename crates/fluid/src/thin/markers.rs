//! Markers: their places, and the grid points around them with the weights of the kernel.

use std::ops::Range;

use nalgebra::SMatrix;

use super::slip::Slip;
use crate::grid::Grid;
use crate::kernel::Kernel;
use crate::space::Vector;

/// Least square of the distance of neighbours in a direction along a body, by that in all, with which a matrix of them has
/// an inverse.
const LEAST_SQUARE: f64 = 1e-9;

/// Markers with their grid points.
pub struct Markers<const D: usize> {
    own: Vec<Marker<D>>,
    /// Neighbours of all markers, marker by marker.
    neighbours: Vec<usize>,
    /// Weights along each axis, marker by marker.
    along: Vec<f64>,
    /// Weights of the grid points of all markers, marker by marker, and the weights over C, s.
    weights: Vec<f64>,
    weighed: Vec<f64>,
    /// Grid points of all markers, each once, and the place there of each point of each marker.
    points: Vec<usize>,
    places: Vec<u32>,
    /// 1 + the place in `points`, at each point of the grid; 0 at the others.
    numbers: Vec<u32>,
    /// The inverse of C (s) at each of `points`, and at all of them if it is the same.
    inverse: Vec<f64>,
    uniform: Option<f64>,
    /// It where no mask is, s.
    without_mask: f64,
    /// What is interpolated or spread, at each of `points`.
    at_points: Vec<Vector<D>>,
}

/// A marker.
#[derive(Clone)]
pub struct Marker<const D: usize> {
    /// Position, m, and velocity, m/s.
    pub position: Vector<D>,
    pub velocity: Vector<D>,
    /// Length or area that it stands for, m or m².
    pub measure: f64,
    /// Penalization rate of the line or surface, m/s.
    kappa: f64,
    /// Volume of the layer that moves with it, m³, or m² in the plane.
    pub layer: f64,
    /// Projection of a vector on the line or surface along which it slips, 0 where it does not slip.
    pub along: SMatrix<f64, D, D>,
    /// Its slip.
    pub slip: Slip,
    /// Its neighbours on a flexible surface, in `neighbours`.
    beside: Range<usize>,
    /// First grid point along each axis, and the weights from there on.
    spans: [(usize, Range<usize>); D],
    /// Its grid points in `weights` and `places`.
    points: Range<usize>,
}

impl<const D: usize> Default for Markers<D> {
    fn default() -> Self {
        Self {
            own: vec![],
            neighbours: vec![],
            along: vec![],
            weights: vec![],
            weighed: vec![],
            points: vec![],
            places: vec![],
            numbers: vec![],
            inverse: vec![],
            uniform: None,
            without_mask: 0.0,
            at_points: vec![],
        }
    }
}

impl<const D: usize> Markers<D> {
    /// Add a marker that stands for a length or area (m or m²) with a layer, m² or m³, that follows it within a time (s).
    /// `neighbours` are those on the same flexible surface.
    pub fn add(
        &mut self,
        measure: f64,
        layer: f64,
        c_eta: f64,
        slip: Slip,
        neighbours: impl IntoIterator<Item = usize>,
    ) {
        let (zero, along, spans) = (Vector::zeros(), SMatrix::zeros(), std::array::from_fn(|_| (0, 0..0)));
        let kappa = layer / (measure * c_eta);
        let (position, velocity, begin) = (zero, zero, self.neighbours.len());
        self.neighbours.extend(neighbours);
        let beside = begin..self.neighbours.len();
        self.own.push(Marker { position, velocity, measure, layer, kappa, along, slip, beside, spans, points: 0..0 });
    }

    /// Return the acceleration across the body (m/s²) that fluid has beside the body's own because it slides along a marker
    /// with a velocity, m/s: `2 ∂U + ∂T u_s` across, with the derivatives along `u_s`. Gradients are those of least squares
    /// over the neighbours.
    pub fn sliding(&self, k: usize, slip: &Vector<D>) -> Vector<D> {
        let own = &self.own[k];
        let others = || {
            let neighbours = self.neighbours[own.beside.clone()].iter().map(|j| &self.own[*j]);
            neighbours.map(|other| (other, own.along * (other.position - own.position)))
        };
        let mut squares: SMatrix<f64, D, D> = others().map(|(_, way)| way * way.transpose()).sum();
        let size = squares.trace();
        if size <= 0.0 {
            return Vector::zeros();
        }
        squares += (SMatrix::identity() * (1.0 + LEAST_SQUARE) - own.along) * size;
        let ahead = inverse(squares) * slip;
        let changes = others().map(|(other, way)| {
            ((other.velocity - own.velocity) * 2.0 + (other.along - own.along) * slip) * way.dot(&ahead)
        });
        let sum: Vector<D> = changes.sum();
        sum - own.along * sum
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

    /// Find the grid points around the markers at their present places.
    pub fn find_cells(&mut self, grid: &Grid<D>) {
        let Self { own, along, weights, points, places, numbers, .. } = self;
        let kernel = Kernel::of(D);
        numbers.resize(grid.len(), 0);
        points.drain(..).for_each(|point| numbers[point] = 0);
        along.clear();
        weights.clear();
        places.clear();
        for marker in own {
            for axis in 0..D {
                let (low, share) = grid.split(axis, marker.position[axis]);
                let begin = along.len();
                kernel.add_weights(share, along);
                marker.spans[axis] = (grid.wrap(axis, low.saturating_sub(kernel.reach as i64 - 1)), begin..along.len());
            }
            let begin = weights.len();
            multiply(grid, &marker.spans, along, 0, (0, 1.0), &mut |point, weight| {
                if numbers[point] == 0 {
                    points.push(point);
                    numbers[point] = points.len() as u32;
                }
                places.push(numbers[point] - 1);
                weights.push(weight);
            });
            marker.points = begin..weights.len();
        }
    }

    /// Return the grid points around all markers, each once.
    pub fn points(&self) -> &[usize] {
        &self.points
    }

    /// Return whether a layer can slide along a marker: it is on a flexible surface, and no mask is at its grid points nor at
    /// those of its neighbours.
    pub fn glides(&self, k: usize) -> bool {
        let free = |marker: &Marker<D>| {
            let mut inverse = self.places[marker.points.clone()].iter().map(|place| self.inverse[*place as usize]);
            inverse.all(|own| own == self.without_mask)
        };
        let own = &self.own[k];
        let beside = &self.neighbours[own.beside.clone()];
        !beside.is_empty()
            && (self.uniform.is_some() || free(own) && beside.iter().all(|other| free(&self.own[*other])))
    }

    /// Set the inverse of C (s), given at a grid point.
    pub fn weigh(&mut self, inverse: impl Fn(usize) -> f64) {
        self.inverse.clear();
        self.inverse.extend(self.points.iter().map(|point| inverse(*point)));
        self.uniform = self.inverse.first().copied().filter(|first| self.inverse.iter().all(|own| own == first));
        self.without_mask = self.inverse.iter().copied().fold(0.0, f64::max);
        self.weighed.clear();
        let pairs = self.places.iter().zip(&self.weights);
        self.weighed.extend(pairs.map(|(place, weight)| weight * self.inverse[*place as usize]));
    }

    /// Write the mean velocity (m/s) of the flow, given at a grid point, past each marker, and let the markers slip by it.
    pub fn pass(&mut self, flow: impl Fn(usize) -> [f64; D], passing: &mut [Vector<D>]) {
        let Self { own, weights, points, places, at_points, .. } = self;
        at_points.clear();
        at_points.extend(points.iter().map(|point| Vector::from(flow(*point))));
        for (marker, passing) in own.iter_mut().zip(passing) {
            let (mut mean, mut square) = (Vector::zeros(), 0.0);
            for (place, weight) in places[marker.points.clone()].iter().zip(&weights[marker.points.clone()]) {
                let velocity = at_points[*place as usize] - marker.velocity;
                mean += velocity * *weight;
                square += velocity.dot(&velocity) * weight;
            }
            *passing = mean;
            marker.slip.pass((mean - marker.along * mean).norm(), square.max(0.0).sqrt());
        }
    }

    /// Call `add` with each grid point and the sum over the markers there of vectors times their weights over C.
    pub fn spread(&mut self, vectors: &[Vector<D>], mut add: impl FnMut(usize, &Vector<D>)) {
        let Self { own, weighed, points, places, at_points, .. } = self;
        at_points.clear();
        at_points.resize(points.len(), Vector::zeros());
        for (marker, vector) in own.iter().zip(vectors) {
            for (place, weight) in places[marker.points.clone()].iter().zip(&weighed[marker.points.clone()]) {
                at_points[*place as usize] += vector * *weight;
            }
        }
        points.iter().zip(at_points).for_each(|(point, sum)| add(*point, sum));
    }

    /// Return each grid point with the sum of the last vectors that were spread, times their weights.
    pub fn spread_sums(&self) -> impl Iterator<Item = (usize, Vector<D>)> {
        let sums = self.at_points.iter().zip(&self.inverse).map(|(sum, inverse)| sum / *inverse);
        self.points.iter().copied().zip(sums)
    }

    /// Return the first grid point of a marker along each axis.
    pub fn first_point(&self, k: usize) -> [usize; D] {
        self.own[k].spans.each_ref().map(|(first, _)| *first)
    }

    /// Return the inverse of the penalization rate of a marker times what it stands for, for each axis: s/m² in two
    /// dimensions.
    pub fn inverse_drag(&self, k: usize) -> SMatrix<f64, D, D> {
        let Marker { measure, kappa, along, slip, .. } = &self.own[k];
        let [slip, across] = slip.resistances();
        (SMatrix::from_diagonal_element(1.0 / kappa + across) + along * (slip - across)) / *measure
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
        Some(match self.uniform {
            Some(inverse) => {
                let spans = one.spans.iter().zip(&overlap);
                spans.fold(inverse, |product, ((_, span), (range, from))| {
                    let own = &self.along[span.start + range.start..span.start + range.end];
                    let pairs = own.iter().zip(&self.along[*from..]);
                    product * pairs.map(|(own, other)| own * other).sum::<f64>()
                })
            }
            None => self.sum_of_products(one, &overlap, 0, 0, 1.0),
        })
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

/// Return the inverse of a symmetric, positive definite block.
pub fn inverse<const D: usize>(mut block: SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    for p in 0..D {
        let inverse = 1.0 / block[(p, p)];
        block[(p, p)] = 1.0;
        (0..D).for_each(|column| block[(p, column)] *= inverse);
        for row in (0..D).filter(|row| *row != p) {
            let share = block[(row, p)];
            block[(row, p)] = 0.0;
            (0..D).for_each(|column| block[(row, column)] -= share * block[(p, column)]);
        }
    }
    block
}
