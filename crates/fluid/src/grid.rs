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

    /// Return the point below a coordinate (m) along an axis, and the distance from it in spacings.
    #[inline(always)] // as `interpolation`
    fn split(&self, axis: usize, coordinate: f64) -> (i64, f64) {
        floor((coordinate - self.origin[axis]) / self.spacing[axis])
    }
}

impl Grid {
    /// Call `visit(index, x, y)` for the points inside a rectangle, with the coordinates of the periodic image that
    /// lies in it. A rectangle larger than the domain is cut to one period.
    pub fn for_each_in(&self, rectangle: [[f64; 2]; 2], mut visit: impl FnMut(usize, f64, f64)) {
        let [columns, rows] = [0, 1].map(|axis| {
            let [first, last] = rectangle[axis].map(|end| (end - self.origin[axis]) / self.spacing[axis]);
            let (first, last) = (first.ceil() as i64, last.floor() as i64);
            first..last.saturating_add(1).min(first.saturating_add(self.cells[axis] as i64))
        });
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
        let [columns, rows] = [0, 1].map(|axis| {
            let (low, s) = self.split(axis, point[axis]);
            let weights = [
                -s * (s - 1.0) * (s - 2.0) / 6.0,
                (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
                -(s + 1.0) * s * (s - 2.0) / 2.0,
                (s + 1.0) * s * (s - 1.0) / 6.0,
            ];
            let place = |k: usize| wrap(low.saturating_add(k as i64 - 1), self.cells[axis]);
            std::array::from_fn::<_, 4, _>(|k| (place(k), weights[k]))
        });
        std::array::from_fn(|k| {
            let ((i, a), (j, b)) = (columns[k / 4], rows[k % 4]);
            (i * self.cells[1] + j, a * b)
        })
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
