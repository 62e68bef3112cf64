//! Transfer between the grids: cubic splines through the values at the coarse points, and their adjoint.
//!
//! Interpolation I is a sum of cubic B-splines whose coefficients come from the values at the coarse points by a symmetric
//! filter. Restriction S is the adjoint of the sum, over the number of fine cells in a coarse one: it keeps sums exactly,
//! and smooths. Both are products over the axes.
//!
//! The fine points are periodic: a box that moves by a coarse cell leaves them in place, and the cells that it leaves
//! behind become those that it newly covers. At the seam, where its ends meet, a fine point is half at each of them: it has
//! the mean of both values and gives a half to each, so that no end is another one in a mirror.

use std::array::from_fn;
use std::ops::Range;

use line_fft::{Arithmetic, Kernel, run};

use crate::grid::Grid;
use crate::kernel::cubic;
use crate::parameters::FineBox;

/// Coefficients beyond each end of the fine box that its points need: one before and two after.
const MARGIN: usize = 3;

/// Points on each side of a coefficient from which it is found.
const REACH: usize = 5;

/// The coarse cells under the fine box, and the transfer on them.
pub struct Transfer<const D: usize> {
    ratio: usize,
    /// Coarse cells across the fine box.
    cells: [usize; D],
    /// Coarse point at the lower end of the fine box along each axis, before it has moved.
    home: [usize; D],
    /// Place among the fine points of the first coarse cell of the box along each axis, in coarse cells.
    turned: [usize; D],
    /// Coarse points along each axis, in the first period, from [`REACH`] points before the first coefficient on.
    places: [Vec<usize>; D],
    /// Point of each of them on the patch, the periodic box of coarse cells under the fine box.
    on_patch: Vec<u32>,
    /// Coarse points along each axis.
    coarse: [usize; D],
    /// Weights of four coefficients at each of the fine points of a coarse cell.
    weights: Vec<[f64; 4]>,
    /// Filter from values to coefficients, from its middle on.
    filter: [f64; REACH + 1],
}

/// Room for the coefficients of a plane and of a row, and for the fine values of a plane.
#[derive(Clone, Default)]
pub struct Rows {
    plane: Vec<f64>,
    row: Vec<f64>,
    values: Vec<f64>,
}

/// Room for values on the way to coefficients.
#[derive(Default)]
pub struct FilterRoom([Vec<f64>; 2]);

impl<const D: usize> Transfer<D> {
    /// The transfer between a coarse grid and a fine box in it.
    pub fn new(coarse: &Grid<D>, fine: &FineBox<D>) -> Self {
        let mut own = Self {
            ratio: fine.ratio,
            cells: fine.cells,
            home: fine.first,
            turned: [0; D],
            places: from_fn(|axis| vec![0; fine.cells[axis] + MARGIN + 2 * REACH]),
            coarse: coarse.cells,
            weights: (0..fine.ratio).map(|p| cubic(p as f64 / fine.ratio as f64)).collect(),
            filter: low_pass(),
            on_patch: vec![0],
        };
        own.place(&[0; D]);
        for (places, cells) in own.places.iter().zip(own.cells) {
            let along = |i: usize| ((i + cells - 1 - REACH) % cells) as u32;
            let next =
                own.on_patch.iter().flat_map(|before| (0..places.len()).map(move |i| before * cells as u32 + along(i)));
            own.on_patch = next.collect();
        }
        own
    }

    /// Put the fine box to where it is after moves by so many coarse cells along each axis.
    pub fn place(&mut self, moved: &[i32]) {
        for (axis, moved) in moved.iter().map(|moved| i64::from(*moved)).enumerate() {
            self.turned[axis] = moved.rem_euclid(self.cells[axis] as i64) as usize;
            let first = self.home[axis] as i64 + moved - (1 + REACH) as i64;
            let place = |i: usize| (first + i as i64).rem_euclid(self.coarse[axis] as i64) as usize;
            self.places[axis].iter_mut().enumerate().for_each(|(i, own)| *own = place(i));
        }
    }

    /// Move the coefficients of a field with the box by a coarse cell along an axis, forwards or backwards. Those of the
    /// cells that it newly covers are 0; those that it leaves are lost, or with `keeps` added to the nearest ones.
    pub fn shift(&self, coefficients: &mut [f64], axis: usize, forwards: bool, keeps: bool) {
        let extent = self.extent();
        let inner: usize = extent[axis + 1..].iter().product();
        let length = extent[axis] * inner;
        for block in coefficients.chunks_exact_mut(length) {
            // The first or last layer, the one that takes its place, and the one that becomes free.
            let [lost, next, free] =
                if forwards { [0, inner, length - inner] } else { [length - inner, length - 2 * inner, 0] };
            (0..inner).filter(|_| keeps).for_each(|k| block[next + k] += block[lost + k]);
            if forwards {
                block.copy_within(inner.., 0);
            } else {
                block.copy_within(..length - inner, inner);
            }
            block[free..free + inner].fill(0.0);
        }
    }

    /// Return the coarse cell of the box, counted along an axis from its lower end, that holds a fine point.
    fn cell(&self, axis: usize, point: usize) -> usize {
        let (place, turned) = (point / self.ratio, self.turned[axis]);
        if place >= turned { place - turned } else { place + self.cells[axis] - turned }
    }

    /// Return the fine points along an axis in a coarse cell of the box.
    #[inline(always)]
    pub fn points_in(&self, axis: usize, cell: usize) -> Range<usize> {
        let place = cell + self.turned[axis];
        let first = if place < self.cells[axis] { place } else { place - self.cells[axis] } * self.ratio;
        first..first + self.ratio
    }

    /// Return the number of coefficients along each axis.
    fn extent(&self) -> [usize; D] {
        self.cells.map(|cells| cells + MARGIN)
    }

    /// Return the number of coefficients of a field.
    pub fn len(&self) -> usize {
        self.extent().iter().product()
    }

    /// Return the number of coefficients of a plane across x.
    pub fn plane_len(&self) -> usize {
        self.extent()[1..].iter().product()
    }

    /// Return the number of coefficients of a row.
    pub fn row_len(&self) -> usize {
        self.extent()[D - 1]
    }

    /// Return the number of fine planes across x.
    pub fn planes(&self) -> usize {
        self.cells[0] * self.ratio
    }

    /// Return the number of fine points of a row.
    pub fn row_points(&self) -> usize {
        self.cells[D - 1] * self.ratio
    }

    /// Return the number of fine rows of a plane across x.
    fn rows_of_plane(&self) -> usize {
        if D == 2 { 1 } else { self.cells[1] * self.ratio }
    }

    /// Return the number of coarse cells across the fine box along each axis.
    pub fn cells(&self) -> &[usize; D] {
        &self.cells
    }

    /// Return room for rows.
    pub fn rows(&self) -> Rows {
        let last = D - 1;
        Rows {
            plane: vec![0.0; self.plane_len()],
            row: vec![0.0; self.extent()[last]],
            values: vec![0.0; self.rows_of_plane() * self.row_points()],
        }
    }

    /// Write the coefficients of a field that is given at a coarse point and its place on the patch.
    pub fn write_coefficients(
        &self,
        at: impl Fn(usize, usize) -> f64,
        FilterRoom([from, to]): &mut FilterRoom,
        coefficients: &mut [f64],
    ) {
        let mut sizes: [usize; D] = self.places.each_ref().map(Vec::len);
        from.clear();
        let mut on_patch = self.on_patch.iter();
        let mut next = || on_patch.next().map_or(0, |place| *place as usize);
        self.for_each_place(0, 0, &mut |index| from.push(at(index, next())));
        for axis in 0..D {
            let inner: usize = sizes[axis + 1..].iter().product();
            let (length, left) = (sizes[axis], sizes[axis] - 2 * REACH);
            let outer: usize = sizes[..axis].iter().product();
            to.clear();
            to.resize(outer * left * inner, 0.0);
            for (from, to) in from.chunks_exact(length * inner).zip(to.chunks_exact_mut(left * inner)) {
                for (i, to) in to.chunks_exact_mut(inner).enumerate() {
                    let line = |k: usize| &from[k * inner..][..inner];
                    to.iter_mut().zip(line(i + REACH)).for_each(|(to, at)| *to = self.filter[0] * at);
                    for (k, weight) in self.filter.iter().enumerate().skip(1) {
                        let pairs = line(i + REACH - k).iter().zip(line(i + REACH + k));
                        to.iter_mut().zip(pairs).for_each(|(to, (a, b))| *to += weight * (a + b));
                    }
                }
            }
            sizes[axis] = left;
            std::mem::swap(from, to);
        }
        coefficients.copy_from_slice(from);
    }

    /// Write the adjoint of [`Self::write_coefficients`]: call `add` with each coarse point, its place on the patch, and
    /// what it receives.
    pub fn add_to_points(
        &self,
        sums: &[f64],
        FilterRoom([from, to]): &mut FilterRoom,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        let mut sizes = self.extent();
        from.clear();
        from.extend_from_slice(sums);
        for axis in 0..D {
            let inner: usize = sizes[axis + 1..].iter().product();
            let (length, more) = (sizes[axis], sizes[axis] + 2 * REACH);
            let outer: usize = sizes[..axis].iter().product();
            to.clear();
            to.resize(outer * more * inner, 0.0);
            for (from, to) in from.chunks_exact(length * inner).zip(to.chunks_exact_mut(more * inner)) {
                for (i, from) in from.chunks_exact(inner).enumerate() {
                    for offset in 0..=2 * REACH {
                        let weight = self.filter[offset.abs_diff(REACH)];
                        let to = &mut to[(i + offset) * inner..][..inner];
                        to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
                    }
                }
            }
            sizes[axis] = more;
            std::mem::swap(from, to);
        }
        let mut values = from.iter().zip(&self.on_patch);
        self.for_each_place(0, 0, &mut |point| {
            if let Some((value, place)) = values.next() {
                add(point, *place as usize, *value);
            }
        });
    }

    /// Visit the coarse points of `places` from `axis` on; `index` is that of the axes before.
    fn for_each_place(&self, axis: usize, index: usize, visit: &mut impl FnMut(usize)) {
        for place in &self.places[axis] {
            let index = index * self.coarse[axis] + place;
            if axis + 1 == D { visit(index) } else { self.for_each_place(axis + 1, index, visit) }
        }
    }

    /// Return the number of points of a plane of the patch across x.
    pub fn points_of_patch_plane(&self) -> usize {
        self.cells[1..].iter().product()
    }

    /// Return how many coarse points along an axis a point lies behind the lower end of the box.
    fn points_behind(&self, axis: usize, point: usize) -> usize {
        let first = self.places[axis][1 + REACH];
        if point >= first { point - first } else { point + self.coarse[axis] - first }
    }

    /// Return the fine point at the place of a coarse one, if it is between the ends of the fine box.
    pub fn in_box(&self, point: usize) -> Option<usize> {
        let (mut rest, mut own, mut stride) = (point, 0, 1);
        for axis in (0..D).rev() {
            let from_first = self.points_behind(axis, rest % self.coarse[axis]);
            if !(1..self.cells[axis]).contains(&from_first) {
                return None;
            }
            own += self.points_in(axis, from_first).start * stride;
            stride *= self.cells[axis] * self.ratio;
            rest /= self.coarse[axis];
        }
        Some(own)
    }

    /// Call `visit` with some coarse points, each with the fine one at its place if it is between the ends of the fine box.
    pub fn for_each_of(&self, points: Range<usize>, mut visit: impl FnMut(usize, Option<usize>)) {
        let (length, second) = (self.coarse[D - 1], self.places[D - 1][2 + REACH]);
        for row in points.start / length..points.end.div_ceil(length) {
            let start = row * length;
            let own = self.in_box(start + second).map(|own| own - self.points_in(D - 1, 1).start);
            for point in start.max(points.start)..(start + length).min(points.end) {
                let from_first = self.points_behind(D - 1, point - start);
                let inside = own.filter(|_| (1..self.cells[D - 1]).contains(&from_first));
                visit(point, inside.map(|own| own + self.points_in(D - 1, from_first).start));
            }
        }
    }

    /// Return the interpolated values of a fine plane across x.
    pub fn interpolate<'a>(&self, coefficients: &[f64], plane: usize, rows: &'a mut Rows) -> &'a [f64] {
        run(Interpolation { transfer: self, coefficients, plane, rows: &mut *rows });
        &rows.values
    }

    /// Write the fine values of a row with such coefficients.
    #[inline(always)]
    fn expand(&self, coefficients: &[f64], values: &mut [f64]) {
        let turned = self.turned[D - 1];
        let (behind, ahead) = values.split_at_mut(turned * self.ratio);
        self.expand_cells(coefficients, ahead);
        self.expand_cells(&coefficients[self.cells[D - 1] - turned..], behind);
        let seam = &mut values[turned * self.ratio];
        *seam *= 0.5;
        let (last, weights) = self.half_of_end(D - 1);
        coefficients[last..].iter().zip(weights).for_each(|(c, w)| *seam += w * c);
    }

    /// Write the fine values of some neighbouring coarse cells.
    #[inline(always)]
    fn expand_cells(&self, coefficients: &[f64], values: &mut [f64]) {
        match self.ratio {
            2 => expand::<2>(&self.weights, coefficients, values),
            4 => expand::<4>(&self.weights, coefficients, values),
            _ => {
                for (values, c) in values.chunks_exact_mut(self.ratio).zip(coefficients.windows(4)) {
                    for (value, w) in values.iter_mut().zip(&self.weights) {
                        *value = w[0] * c[0] + w[1] * c[1] + w[2] * c[2] + w[3] * c[3];
                    }
                }
            }
        }
    }

    /// Return the first coefficient of a fine point along an axis, and the weights from there on: one or both of its ends.
    #[inline(always)]
    fn weights_at(&self, axis: usize, point: usize) -> impl Iterator<Item = (usize, [f64; 4])> {
        let (cell, weights) = (self.cell(axis, point), self.weights[point % self.ratio]);
        let is_seam = point == self.turned[axis] * self.ratio;
        let own = if is_seam { weights.map(|weight| 0.5 * weight) } else { weights };
        [Some((cell, own)), is_seam.then(|| self.half_of_end(axis))].into_iter().flatten()
    }

    /// Return the same of the upper end of the box, halved.
    #[inline(always)]
    fn half_of_end(&self, axis: usize) -> (usize, [f64; 4]) {
        let [a, b, c, _] = self.weights[0];
        (self.cells[axis] - 1, [0.0, a, b, c].map(|weight| 0.5 * weight))
    }

    /// Return the coarse cells along the last axis that lie between rims of a width in cells.
    #[inline(always)]
    pub fn between_rims(&self, rim: f64) -> Range<usize> {
        let rim = rim.ceil() as usize;
        rim..self.cells[D - 1] - rim
    }

    /// Add the restriction of a row of a fine plane along the axes after x to the sums of that plane. In some coarse cells
    /// the values are nothing.
    pub fn restrict_row(
        &self,
        row: usize,
        values: &[f64],
        nothing: Range<usize>,
        of_row: &mut [f64],
        of_plane: &mut [f64],
    ) {
        let last = self.extent()[D - 1];
        let gather = |sums: &mut [f64]| run(Gathering { transfer: self, values, nothing: nothing.clone(), sums });
        if D == 2 {
            return gather(of_plane);
        }
        of_row.fill(0.0);
        gather(of_row);
        for (first, weights) in self.weights_at(1, row) {
            for (of_plane, weight) in of_plane[first * last..].chunks_exact_mut(last).zip(weights) {
                of_plane.iter_mut().zip(&*of_row).for_each(|(sum, own)| *sum += weight * own);
            }
        }
    }

    #[inline(always)]
    fn gather(&self, values: &[f64], nothing: Range<usize>, coefficients: &mut [f64]) {
        for cells in [0..nothing.start, nothing.end..self.cells[D - 1]] {
            for cell in cells {
                let values = &values[self.points_in(D - 1, cell)];
                let mut sums = [0.0; 4];
                for (value, w) in values.iter().zip(&self.weights) {
                    for k in 0..4 {
                        sums[k] += w[k] * value;
                    }
                }
                for k in 0..4 {
                    coefficients[cell + k] += sums[k];
                }
            }
        }
        let seam = values[self.turned[D - 1] * self.ratio];
        let (last, of_end) = self.half_of_end(D - 1);
        for k in 0..4 {
            coefficients[k] -= 0.5 * self.weights[0][k] * seam;
            coefficients[last + k] += of_end[k] * seam;
        }
    }

    /// Add the restriction of all planes, whose own sums are `of_planes`, to `sums`.
    pub fn restrict_planes<'a>(&self, of_planes: impl Iterator<Item = &'a [f64]>, factor: f64, sums: &mut [f64]) {
        let (length, factor) = (self.plane_len(), factor / self.fine_cells());
        for (plane, of_plane) in of_planes.enumerate() {
            for (first, weights) in self.weights_at(0, plane) {
                for (sums, weight) in sums[first * length..].chunks_exact_mut(length).zip(weights) {
                    sums.iter_mut().zip(of_plane).for_each(|(sum, own)| *sum += factor * weight * own);
                }
            }
        }
    }

    /// Add the restriction of `value` at one fine point, which is not at the seam.
    pub fn restrict_point(&self, index: usize, value: [f64; D], sums: &mut [f64]) {
        let (extent, field, mut rest) = (self.extent(), self.len(), index);
        let mut along = [(0, [0.0; 4]); D];
        for axis in (0..D).rev() {
            let points = self.cells[axis] * self.ratio;
            along[axis] = (self.cell(axis, rest % points), self.weights[rest % self.ratio]);
            rest /= points;
        }
        let scale = 1.0 / self.fine_cells();
        for corner in 0..4_usize.pow(D as u32) {
            let (mut place, mut weight, mut rest) = (0, scale, corner);
            for axis in 0..D {
                place = place * extent[axis] + along[axis].0 + rest % 4;
                weight *= along[axis].1[rest % 4];
                rest /= 4;
            }
            (0..D).for_each(|axis| sums[axis * field + place] += weight * value[axis]);
        }
    }

    /// Return the number of fine cells in a coarse one.
    fn fine_cells(&self) -> f64 {
        (self.ratio as f64).powi(D as i32)
    }

    /// Return the distance of a fine point along an axis from the nearest end of the fine box, coarse cells.
    pub fn distance_from_end(&self, axis: usize, point: usize) -> f64 {
        let from_low = self.cell(axis, point) * self.ratio + point % self.ratio;
        from_low.min(self.cells[axis] * self.ratio - from_low) as f64 / self.ratio as f64
    }
}

/// Restriction of a row along it.
struct Gathering<'a, const D: usize> {
    transfer: &'a Transfer<D>,
    values: &'a [f64],
    nothing: Range<usize>,
    sums: &'a mut [f64],
}

impl<const D: usize> Kernel for Gathering<'_, D> {
    type Real = f64;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<f64>) {
        self.transfer.gather(self.values, self.nothing, self.sums);
    }
}

/// See [`Transfer::interpolate`].
struct Interpolation<'a, const D: usize> {
    transfer: &'a Transfer<D>,
    coefficients: &'a [f64],
    plane: usize,
    rows: &'a mut Rows,
}

impl<const D: usize> Kernel for Interpolation<'_, D> {
    type Real = f64;

    #[inline(always)]
    fn run(self, _: impl Arithmetic<f64>) {
        let Self { transfer, coefficients, plane, rows: Rows { plane: of_plane, row: of_row, values } } = self;
        combine(coefficients, transfer.weights_at(0, plane), of_plane);
        if D == 2 {
            return transfer.expand(of_plane, values);
        }
        for (row, values) in values.chunks_exact_mut(transfer.row_points()).enumerate() {
            combine(of_plane, transfer.weights_at(1, row), of_row);
            transfer.expand(of_row, values);
        }
    }
}

/// Write the fine values of some coarse cells with so many each.
#[inline(always)]
fn expand<const RATIO: usize>(weights: &[[f64; 4]], coefficients: &[f64], values: &mut [f64]) {
    let mut columns = [[0.0; RATIO]; 4];
    for (k, column) in columns.iter_mut().enumerate() {
        column.iter_mut().zip(weights).for_each(|(column, weights)| *column = weights[k]);
    }
    for (values, c) in values.as_chunks_mut::<RATIO>().0.iter_mut().zip(coefficients.windows(4)) {
        for p in 0..RATIO {
            values[p] = columns[0][p] * c[0] + columns[1][p] * c[1] + columns[2][p] * c[2] + columns[3][p] * c[3];
        }
    }
}

/// Write the sum of neighbouring planes or rows, four from each first one on, with weights.
#[inline(always)]
fn combine(coefficients: &[f64], terms: impl Iterator<Item = (usize, [f64; 4])>, sum: &mut [f64]) {
    let length = sum.len();
    for (term, (first, weights)) in terms.enumerate() {
        let of = |k: usize| &coefficients[(first + k) * length..][..length];
        let (a, b, c, d) = (of(0), of(1), of(2), of(3));
        let value = |i: usize| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i] + weights[3] * d[i];
        if term == 0 {
            sum.iter_mut().enumerate().for_each(|(i, sum)| *sum = value(i));
        } else {
            sum.iter_mut().enumerate().for_each(|(i, sum)| *sum += value(i));
        }
    }
}

/// Return the filter from values to coefficients, from its middle on. With y = sin²(k h/2) of a wave along an axis, the
/// B-splines leave 1 − ⅔ y of it at the points. The filter is the inverse of that to the fifth order in y, and leaves
/// nothing of the highest wave, y = 1.
fn low_pass() -> [f64; REACH + 1] {
    let (mut filter, mut power, mut share, mut rest) = ([0.0; REACH + 1], [0.0; REACH + 1], 1.0, 0.0);
    power[0] = 1.0;
    for order in 0..=REACH {
        let factor = if order == REACH { -rest } else { share };
        (0..=REACH).for_each(|k| filter[k] += factor * power[k]);
        (rest, share) = (rest + share, share * 2.0 / 3.0);
        // Times y: half of each wave less a quarter of its neighbours.
        let at = |k: usize| if k <= REACH { power[k] } else { 0.0 };
        power = from_fn(|k| 0.5 * at(k) - 0.25 * (at(k.abs_diff(1)) + at(k + 1)));
    }
    filter
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Return repeatable numbers from −1 to 1.
    fn numbers(count: usize) -> Vec<f64> {
        (0..count).map(|i| (12.9898 * (i + 1) as f64).sin()).collect()
    }

    fn between<const D: usize>() -> (Grid<D>, Grid<D>, Transfer<D>) {
        let coarse = Grid::new([[0.0, 2.0]; D], std::array::from_fn(|axis| 20 + 2 * axis));
        let fine = FineBox { first: [4; D], cells: std::array::from_fn(|axis| 10 + axis), ratio: 3, follows: None };
        (coarse, fine.grid(&coarse), Transfer::new(&coarse, &fine))
    }

    fn interpolated<const D: usize>(transfer: &Transfer<D>, field: &[f64]) -> Vec<f64> {
        let (mut coefficients, mut all, mut rows) = (vec![0.0; transfer.len()], vec![], transfer.rows());
        transfer.write_coefficients(|point, _| field[point], &mut FilterRoom::default(), &mut coefficients);
        for plane in 0..transfer.planes() {
            all.extend_from_slice(transfer.interpolate(&coefficients, plane, &mut rows));
        }
        all
    }

    fn restricted<const D: usize>(transfer: &Transfer<D>, points: usize, field: &[f64]) -> Vec<f64> {
        let (mut sums, mut all) = (vec![0.0; transfer.len()], vec![0.0; points]);
        let row = transfer.cells[D - 1] * transfer.ratio;
        let of_planes = field.chunks_exact(field.len() / transfer.planes()).map(|plane| {
            let (mut of_plane, mut of_row) = (vec![0.0; transfer.plane_len()], vec![0.0; transfer.plane_len()]);
            let rows = plane.chunks_exact(row).enumerate();
            let last = transfer.extent()[D - 1];
            rows.for_each(|(k, row)| transfer.restrict_row(k, row, 0..0, &mut of_row[..last], &mut of_plane));
            of_plane
        });
        let of_planes: Vec<_> = of_planes.collect();
        transfer.restrict_planes(of_planes.iter().map(|of| &of[..]), 1.0, &mut sums);
        transfer.add_to_points(&sums, &mut FilterRoom::default(), |point, _, part| all[point] += part);
        all
    }

    fn restriction_is_the_adjoint_of_interpolation<const D: usize>() {
        let (coarse, fine, transfer) = between::<D>();
        let (a, b) = (numbers(coarse.len()), numbers(fine.len()));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let on_fine = dot(&interpolated(&transfer, &a), &b) / 3_f64.powi(D as i32);
        let on_coarse = dot(&a, &restricted(&transfer, coarse.len(), &b));
        assert!((on_fine - on_coarse).abs() < 1e-12 * b.len() as f64, "{on_fine} on fine cells, {on_coarse} on coarse");
    }

    #[test]
    fn restriction_is_the_adjoint_of_interpolation_in_the_plane_and_in_space() {
        restriction_is_the_adjoint_of_interpolation::<2>();
        restriction_is_the_adjoint_of_interpolation::<3>();
    }

    fn coarse_cells_receive_the_momentum_of_fine_ones<const D: usize>() {
        let (coarse, fine, transfer) = between::<D>();
        let field = numbers(fine.len());
        let received = restricted(&transfer, coarse.len(), &field).iter().sum::<f64>() * coarse.cell_volume();
        let given = field.iter().sum::<f64>() * fine.cell_volume();
        assert!((received - given).abs() < 1e-14 * fine.len() as f64, "{received} of {given}");
        let mut sums = vec![0.0; D * transfer.len()];
        transfer.restrict_point(fine.len() / 2 + 7, [1.5; D], &mut sums);
        let received = sums.iter().sum::<f64>() * coarse.cell_volume();
        let given = 1.5 * D as f64 * fine.cell_volume();
        assert!((received / given - 1.0).abs() < 1e-14, "{received} of {given}, from a point");
    }

    #[test]
    fn coarse_cells_receive_all_momentum_of_fine_ones() {
        coarse_cells_receive_the_momentum_of_fine_ones::<2>();
        coarse_cells_receive_the_momentum_of_fine_ones::<3>();
    }

    /// Interpolate and restrict on a box that has moved as on one that was made there, over an end of the domain.
    fn a_moved_box_is_one_made_there<const D: usize>() {
        let (coarse, _, mut moved) = between::<D>();
        let way: [i32; D] = std::array::from_fn(|axis| [-7, 13, 1][axis]);
        let first = std::array::from_fn(|axis| coarse.wrap(axis, 4 + i64::from(way[axis])));
        let made = Transfer::new(&coarse, &FineBox { first, cells: moved.cells, ratio: moved.ratio, follows: None });
        moved.place(&way);
        let field = numbers(coarse.len());
        let [on_moved, on_made] = [&moved, &made].map(|transfer| interpolated(transfer, &field));
        let points = moved.cells.map(|cells| cells * moved.ratio);
        let turned = (0..on_made.len()).map(|point| {
            let (mut rest, mut own, mut stride) = (point, 0, 1);
            for axis in (0..D).rev() {
                let along = rest % points[axis];
                own += (moved.points_in(axis, along / moved.ratio).start + along % moved.ratio) * stride;
                stride *= points[axis];
                rest /= points[axis];
            }
            own
        });
        let turned = turned.collect::<Vec<_>>();
        assert!(turned.iter().zip(&on_made).all(|(place, expected)| on_moved[*place] == *expected));
        let mut values = vec![0.0; turned.len()];
        let given = numbers(turned.len());
        turned.iter().zip(&given).for_each(|(place, given)| values[*place] = *given);
        let [found, expected] =
            [(&moved, &values), (&made, &given)].map(|(of, values)| restricted(of, coarse.len(), values));
        let largest = found.iter().zip(&expected).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        assert!(largest < 1e-13, "{largest}");
        moved.for_each_of(0..coarse.len(), |_, own| assert!(own.is_none_or(|own| on_moved[own].is_finite())));
        // Coefficients move with the box, and keep their sum.
        let (mut list, before) = (numbers(moved.len()), numbers(moved.len()).iter().sum::<f64>());
        for (axis, forwards) in [(0, true), (D - 1, false)] {
            moved.shift(&mut list, axis, forwards, true);
        }
        let after = list.iter().sum::<f64>();
        assert!((after - before).abs() < 1e-12, "{after} of {before}");
    }

    #[test]
    fn a_moved_box_is_one_made_there_in_the_plane_and_in_space() {
        a_moved_box_is_one_made_there::<2>();
        a_moved_box_is_one_made_there::<3>();
    }

    #[test]
    fn interpolation_has_the_fourth_order_and_knows_nothing_of_the_highest_wave() {
        let error = |cells: usize| {
            let coarse = Grid::new([[0.0, 1.0]; 2], [cells; 2]);
            let fine = FineBox { first: [3; 2], cells: [12; 2], ratio: 4, follows: None };
            let (own, transfer) = (fine.grid(&coarse), Transfer::new(&coarse, &fine));
            let wave = |[x, y]: [f64; 2]| (6.0 * x + 0.3).sin() * (5.0 * y).cos();
            let field: Vec<_> = (0..coarse.len()).map(|point| wave(coarse.point(point))).collect();
            let found = interpolated(&transfer, &field).into_iter().enumerate();
            let inside = found.filter(|(point, _)| own.point(*point).iter().all(|x| (0.25..0.5).contains(x)));
            inside.map(|(point, value)| (value - wave(own.point(point))).abs()).fold(0.0, f64::max)
        };
        let errors = [24, 48].map(error);
        assert!(errors[0] / errors[1] > 14.0, "{errors:?}");
        let (coarse, _, transfer) = between::<2>();
        let highest: Vec<_> = (0..coarse.len()).map(|point| [1.0, -1.0][point % 2]).collect();
        let most = interpolated(&transfer, &highest).iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        assert!(most < 1e-13, "{most}");
    }
}
