//! The periodic grid.

use std::ops::Range;

use crate::space::Space;

/// A periodic grid, the last axis contiguous in memory.
#[derive(Clone, Copy, Debug)]
pub struct Grid<const D: usize = 2> {
    /// Number of points along each axis.
    pub cells: [usize; D],
    /// Spacing along each axis, m.
    pub spacing: [f64; D],
    /// Size of the domain along each axis, m.
    pub size: [f64; D],
    /// Position of the first point, m.
    origin: [f64; D],
}

impl<const D: usize> Grid<D> {
    /// Grid of a domain, whose ends (m) are given for each axis.
    pub fn new(domain: [[f64; 2]; D], cells: [usize; D]) -> Self {
        let size = domain.map(|[low, high]| high - low);
        let spacing = std::array::from_fn(|axis| size[axis] / cells[axis] as f64);
        Self { cells, spacing, size, origin: domain.map(|[low, _]| low) }
    }

    /// Return the number of points.
    pub fn len(&self) -> usize {
        self.cells.iter().product()
    }

    /// Return whether there is no point; there always is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Return the volume of a cell, m² in two dimensions.
    pub fn cell_volume(&self) -> f64 {
        self.spacing.iter().product()
    }

    /// Return the coarsest spacing, m: the cell size of masks.
    pub fn cell_size(&self) -> f64 {
        self.spacing.into_iter().fold(0.0, f64::max)
    }

    /// Return the coordinate of point `i` along an axis, m.
    pub fn coordinate(&self, axis: usize, i: usize) -> f64 {
        self.origin[axis] + i as f64 * self.spacing[axis]
    }

    /// Return the coordinate of the middle point along an axis, m.
    pub fn middle(&self, axis: usize) -> f64 {
        self.coordinate(axis, self.cells[axis] / 2)
    }

    /// Return the position of the point with an index, m.
    pub fn point(&self, mut index: usize) -> [f64; D] {
        let mut point = self.origin;
        for axis in (0..D).rev() {
            point[axis] = self.coordinate(axis, index % self.cells[axis]);
            index /= self.cells[axis];
        }
        point
    }

    /// Return the grid moved by a way, m.
    pub fn moved(&self, way: &[f64; D]) -> Self {
        Self { origin: std::array::from_fn(|axis| self.origin[axis] + way[axis]), ..*self }
    }

    /// Return the grid moved by whole periods so that a point lies in the period from `low` (m) on.
    pub fn image(&self, index: usize, low: &[f64; D]) -> Self {
        let point = self.point(index);
        let periods = |axis: usize| ((low[axis] - point[axis]) / self.size[axis] - 1e-9).ceil() * self.size[axis];
        self.moved(&std::array::from_fn(periods))
    }

    /// Return the coordinates of the first point, m.
    pub fn low(&self) -> [f64; D] {
        self.origin
    }

    /// Return the shortest distance (m) along an axis that is periodically the same as `delta`.
    pub fn periodic(&self, axis: usize, delta: f64) -> f64 {
        delta - self.size[axis] * (delta / self.size[axis]).round()
    }

    /// Return the points along an axis between two coordinates (m), at most one period.
    fn between(&self, axis: usize, ends: [f64; 2]) -> Range<i64> {
        let [first, last] = ends.map(|end| (end - self.origin[axis]) / self.spacing[axis]);
        let (first, last) = (first.ceil() as i64, last.floor() as i64);
        first..last.saturating_add(1).min(first.saturating_add(self.cells[axis] as i64))
    }

    /// Return the four points along an axis around a coordinate (m) and their weights in a cubic (Lagrange)
    /// interpolation.
    fn cubic(&self, axis: usize, coordinate: f64) -> [(usize, f64); 4] {
        let (low, s) = self.split(axis, coordinate);
        let weights = [
            -s * (s - 1.0) * (s - 2.0) / 6.0,
            (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
            -(s + 1.0) * s * (s - 2.0) / 2.0,
            (s + 1.0) * s * (s - 1.0) / 6.0,
        ];
        let place = |k: usize| wrap(low.saturating_add(k as i64 - 1), self.cells[axis]);
        std::array::from_fn(|k| (place(k), weights[k]))
    }

    /// Call `visit(index, point)` for the points inside a box, with the coordinates (m) of the periodic image that lies
    /// in it. A box larger than the domain is cut to one period.
    pub fn for_each_in(&self, ends: [[f64; 2]; D], mut visit: impl FnMut(usize, [f64; D])) {
        let ranges = std::array::from_fn(|axis| self.between(axis, ends[axis]));
        self.visit(&ranges, 0, 0, [0.0; D], &mut visit);
    }

    /// Visit the points of all `ranges` from `axis` on; `index` and `point` are those of the axes before.
    fn visit(
        &self,
        ranges: &[Range<i64>; D],
        axis: usize,
        index: usize,
        mut point: [f64; D],
        visit: &mut impl FnMut(usize, [f64; D]),
    ) {
        let (first, cells) = (index * self.cells[axis], self.cells[axis]);
        let coordinate = |i: i64| self.origin[axis] + i as f64 * self.spacing[axis];
        if axis + 1 == D {
            for i in ranges[axis].clone() {
                point[axis] = coordinate(i);
                visit(first + wrap(i, cells), point);
            }
        } else {
            for i in ranges[axis].clone() {
                point[axis] = coordinate(i);
                self.visit(ranges, axis + 1, first + wrap(i, cells), point, visit);
            }
        }
    }

    /// Return the points around a point (m), four along each axis, and their weights in a cubic (Lagrange)
    /// interpolation.
    pub fn cubic_interpolation(&self, point: [f64; D]) -> impl Iterator<Item = (usize, f64)> + use<D> {
        let (along, cells): ([_; D], _) = (std::array::from_fn(|axis| self.cubic(axis, point[axis])), self.cells);
        (0..4_usize.pow(D as u32)).map(move |corner| {
            let (mut index, mut product) = (0, 1.0);
            for axis in 0..D {
                let (i, weight) = along[axis][corner >> (2 * (D - 1 - axis)) & 3];
                (index, product) = (index * cells[axis] + i, if axis == 0 { weight } else { product * weight });
            }
            (index, product)
        })
    }

    /// Return the number of a point along an axis in the first period.
    pub fn wrap(&self, axis: usize, index: i64) -> usize {
        wrap(index, self.cells[axis])
    }

    /// Return the least number of points along an axis from `from` to `to` or a periodic image of it.
    pub fn offset(&self, axis: usize, from: usize, to: usize) -> i64 {
        let (count, offset) = (self.cells[axis] as i64, to as i64 - from as i64);
        // All pairs of markers ask for it, so it does not divide.
        if 2 * offset >= count {
            offset - count
        } else if 2 * offset < -count {
            offset + count
        } else {
            offset
        }
    }

    /// Return the point below a coordinate (m) along an axis, and the distance from it in spacings.
    #[inline(always)] // as `interpolation`
    pub fn split(&self, axis: usize, coordinate: f64) -> (i64, f64) {
        floor((coordinate - self.origin[axis]) / self.spacing[axis])
    }
}

impl<const D: usize> Grid<D>
where
    [f64; D]: Space<D>,
{
    /// Return the points around a point (m), two along each axis, and their weights in a linear interpolation.
    #[inline(always)] // A call would pass the pairs in memory, which takes as long as finding them.
    pub fn interpolation(&self, point: [f64; D]) -> <[f64; D] as Space<D>>::Corners {
        let mut along = [[(0, 0.0); 2]; D];
        for (axis, along) in along.iter_mut().enumerate() {
            let ((low, share), cells) = (self.split(axis, point[axis]), self.cells[axis]);
            *along = [(wrap(low, cells), 1.0 - share), (wrap(low.saturating_add(1), cells), share)];
        }
        <[f64; D]>::corners(along, &self.cells)
    }
}

/// Return the integer at or below `q`, and the rest. `f64::floor` is a call if only SSE2 is taken for granted.
fn floor(q: f64) -> (i64, f64) {
    let near = q as i64;
    let low = if near as f64 > q { near.saturating_sub(1) } else { near };
    (low, q - low as f64)
}

/// Return `index` modulo `count`; it divides only outside 0 … count − 1.
fn wrap(index: i64, count: usize) -> usize {
    if (0..count as i64).contains(&index) { index as usize } else { index.rem_euclid(count as i64) as usize }
}
