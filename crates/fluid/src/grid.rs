//! The periodic grid.

use scene::FluidBox;

/// A periodic grid of `[nx, ny]` points, y contiguous; point (i, j) is at `origin + (i dx, j dy)`.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Number of points along x.
    pub nx: usize,
    /// Number of points along y.
    pub ny: usize,
    /// Spacing along x, m.
    pub dx: f64,
    /// Spacing along y, m.
    pub dy: f64,
    /// Length of the box along x, m.
    pub length: f64,
    /// Length of the box along y, m.
    pub height: f64,
    origin: [f64; 2],
}

impl Grid {
    /// Grid of a scene's box.
    pub fn new(domain: &FluidBox) -> Self {
        let [nx, ny] = domain.cells;
        let (length, height) = (domain.x[1] - domain.x[0], domain.y[1] - domain.y[0]);
        let origin = [domain.x[0], domain.y[0]];
        Self { nx, ny, dx: length / nx as f64, dy: height / ny as f64, length, height, origin }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.nx * self.ny
    }

    /// Whether there is no point; there always is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Area of a cell, m².
    pub fn cell_area(&self) -> f64 {
        self.dx * self.dy
    }

    /// The coarser of the two spacings, m: the cell size that masks are measured in.
    pub fn cell_size(&self) -> f64 {
        self.dx.max(self.dy)
    }

    /// x of column `i`, m.
    pub fn x(&self, i: usize) -> f64 {
        self.origin[0] + i as f64 * self.dx
    }

    /// y of row `j`, m.
    pub fn y(&self, j: usize) -> f64 {
        self.origin[1] + j as f64 * self.dy
    }

    /// Position of the point with an index, m.
    pub fn point(&self, index: usize) -> [f64; 2] {
        [self.x(index / self.ny), self.y(index % self.ny)]
    }

    /// Visit the points of the periodic grid inside a rectangle: `visit(index, x, y)` with the coordinates of the image
    /// that lies in the rectangle. A rectangle larger than the box is cut to one period.
    pub fn for_each_in(&self, x: [f64; 2], y: [f64; 2], mut visit: impl FnMut(usize, f64, f64)) {
        let range = |[low, high]: [f64; 2], origin: f64, step: f64, count: usize| {
            let first = ((low - origin) / step).ceil() as i64;
            let last = ((high - origin) / step).floor() as i64;
            first..last.saturating_add(1).min(first.saturating_add(count as i64))
        };
        let (columns, rows) = (range(x, self.origin[0], self.dx, self.nx), range(y, self.origin[1], self.dy, self.ny));
        for i in columns {
            let row = wrap(i, self.nx) * self.ny;
            for j in rows.clone() {
                let index = row + wrap(j, self.ny);
                visit(index, self.origin[0] + i as f64 * self.dx, self.origin[1] + j as f64 * self.dy);
            }
        }
    }

    /// Bilinear interpolation at a point (m): the indices of the four points around it and their weights.
    #[inline(always)] // A call would hand the pairs over in memory, which takes as long as finding them.
    pub fn interpolation(&self, [x, y]: [f64; 2]) -> [(usize, f64); 4] {
        let split = |p: f64, origin: f64, step: f64, count: usize| {
            let (low, rest) = floor((p - origin) / step);
            (wrap(low, count), wrap(low.saturating_add(1), count), rest)
        };
        let (i0, i1, s) = split(x, self.origin[0], self.dx, self.nx);
        let (j0, j1, t) = split(y, self.origin[1], self.dy, self.ny);
        [
            (i0 * self.ny + j0, (1.0 - s) * (1.0 - t)),
            (i0 * self.ny + j1, (1.0 - s) * t),
            (i1 * self.ny + j0, s * (1.0 - t)),
            (i1 * self.ny + j1, s * t),
        ]
    }

    /// Cubic (Lagrange) interpolation along both axes at a point (m): the indices of the sixteen points around it and
    /// their weights.
    pub fn cubic_interpolation(&self, [x, y]: [f64; 2]) -> [(usize, f64); 16] {
        let along = |p: f64, origin: f64, step: f64, count: usize| {
            let (low, s) = floor((p - origin) / step);
            let weights = [
                -s * (s - 1.0) * (s - 2.0) / 6.0,
                (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
                -(s + 1.0) * s * (s - 2.0) / 2.0,
                (s + 1.0) * s * (s - 1.0) / 6.0,
            ];
            let point = |k: usize| wrap(low.saturating_add(k as i64 - 1), count);
            std::array::from_fn::<_, 4, _>(|k| (point(k), weights[k]))
        };
        let (columns, rows) = (along(x, self.origin[0], self.dx, self.nx), along(y, self.origin[1], self.dy, self.ny));
        std::array::from_fn(|k| {
            let ((i, a), (j, b)) = (columns[k / 4], rows[k % 4]);
            (i * self.ny + j, a * b)
        })
    }

    /// Distance along x between two points of the periodic box, m.
    pub fn periodic_x(&self, delta: f64) -> f64 {
        delta - self.length * (delta / self.length).round()
    }

    /// Distance along y between two points of the periodic box, m.
    pub fn periodic_y(&self, delta: f64) -> f64 {
        delta - self.height * (delta / self.height).round()
    }
}

/// The integer at or below `q`, and how far `q` is beyond it. `f64::floor` is a call where only SSE2 is taken for granted.
fn floor(q: f64) -> (i64, f64) {
    let near = q as i64;
    let low = if near as f64 > q { near.saturating_sub(1) } else { near };
    (low, q - low as f64)
}

/// `index` modulo `count`; a division only outside of 0 … count - 1.
fn wrap(index: i64, count: usize) -> usize {
    if (0..count as i64).contains(&index) { index as usize } else { index.rem_euclid(count as i64) as usize }
}
