//! The periodic grid.

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

    /// Return the shortest distance (m) along an axis that is periodically the same as `delta`.
    pub fn periodic(&self, axis: usize, delta: f64) -> f64 {
        delta - self.size[axis] * (delta / self.size[axis]).round()
    }

    /// Return the points along an axis between two coordinates (m), at most one period.
    fn between(&self, axis: usize, ends: [f64; 2]) -> std::ops::Range<i64> {
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

impl Grid {
    /// Call `visit(index, x, y)` for the points inside a rectangle, with the coordinates of the periodic image that
    /// lies in it. A rectangle larger than the domain is cut to one period.
    pub fn for_each_in(&self, rectangle: [[f64; 2]; 2], mut visit: impl FnMut(usize, f64, f64)) {
        let [columns, rows] = [0, 1].map(|axis| self.between(axis, rectangle[axis]));
        let [nx, ny] = self.cells;
        for i in columns {
            let row = wrap(i, nx) * ny;
            for j in rows.clone() {
                let [x, y] = [(0, i), (1, j)].map(|(axis, i)| self.origin[axis] + i as f64 * self.spacing[axis]);
                visit(row + wrap(j, ny), x, y);
            }
        }
    }

    /// Return the four points around a point (m) and their weights in a bilinear interpolation.
    #[inline(always)] // A call would pass the pairs in memory, which takes as long as finding them.
    pub fn interpolation(&self, [x, y]: [f64; 2]) -> [(usize, f64); 4] {
        let [nx, ny] = self.cells;
        let ((i, s), (j, t)) = (self.split(0, x), self.split(1, y));
        let (i0, i1) = (wrap(i, nx), wrap(i.saturating_add(1), nx));
        let (j0, j1) = (wrap(j, ny), wrap(j.saturating_add(1), ny));
        [
            (i0 * ny + j0, (1.0 - s) * (1.0 - t)),
            (i0 * ny + j1, (1.0 - s) * t),
            (i1 * ny + j0, s * (1.0 - t)),
            (i1 * ny + j1, s * t),
        ]
    }

    /// Return the sixteen points around a point (m) and their weights in a cubic (Lagrange) interpolation.
    pub fn cubic_interpolation(&self, point: [f64; 2]) -> [(usize, f64); 16] {
        let [columns, rows] = [0, 1].map(|axis| self.cubic(axis, point[axis]));
        std::array::from_fn(|k| {
            let ((i, a), (j, b)) = (columns[k / 4], rows[k % 4]);
            (i * self.cells[1] + j, a * b)
        })
    }
}

impl Grid<3> {
    /// Call `visit(index, point)` for the points inside a cuboid, with the coordinates (m) of the periodic image that
    /// lies in it. A cuboid larger than the domain is cut to one period.
    pub fn for_each_in(&self, cuboid: [[f64; 2]; 3], mut visit: impl FnMut(usize, [f64; 3])) {
        let [along_x, along_y, along_z] = [0, 1, 2].map(|axis| self.between(axis, cuboid[axis]));
        let [nx, ny, nz] = self.cells;
        let coordinate = |axis: usize, i: i64| self.origin[axis] + i as f64 * self.spacing[axis];
        for i in along_x {
            for j in along_y.clone() {
                let line = (wrap(i, nx) * ny + wrap(j, ny)) * nz;
                let (x, y) = (coordinate(0, i), coordinate(1, j));
                along_z.clone().for_each(|k| visit(line + wrap(k, nz), [x, y, coordinate(2, k)]));
            }
        }
    }

    /// Return the eight points around a point (m) and their weights in a trilinear interpolation.
    pub fn interpolation(&self, point: [f64; 3]) -> [(usize, f64); 8] {
        let along = [0, 1, 2].map(|axis| {
            let (low, share) = self.split(axis, point[axis]);
            let place = |i| wrap(i, self.cells[axis]);
            [(place(low), 1.0 - share), (place(low.saturating_add(1)), share)]
        });
        std::array::from_fn(|n| self.product([along[0][n / 4], along[1][n / 2 % 2], along[2][n % 2]]))
    }

    /// Return the 64 points around a point (m) and their weights in a cubic (Lagrange) interpolation.
    pub fn cubic_interpolation(&self, point: [f64; 3]) -> [(usize, f64); 64] {
        let along = [0, 1, 2].map(|axis| self.cubic(axis, point[axis]));
        std::array::from_fn(|n| self.product([along[0][n / 16], along[1][n / 4 % 4], along[2][n % 4]]))
    }

    fn product(&self, [(i, a), (j, b), (k, c)]: [(usize, f64); 3]) -> (usize, f64) {
        ((i * self.cells[1] + j) * self.cells[2] + k, a * b * c)
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
