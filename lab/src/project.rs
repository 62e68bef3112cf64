//! A field of space as a picture: its largest value along each line of sight, by the shear-warp method (Lacroute and
//! Levoy 1994, doi:10.1145/192161.192283).
//!
//! The lines of sight through the grid's slices across one axis are sheared to lines along this axis: each slice is
//! shifted by bilinear interpolation, and the largest value is kept. This image is refined as a field of a plane is
//! ([`crate::paint`]) and warped to the picture.

use std::array::from_fn;

use crate::paint::{Colours, Periodic, View, colour_of, for_each_pixel};

/// Points of the refined image for each one of the sheared image, along both axes.
const FINER: usize = 4;
/// Points without a value around the sheared image: the refinement reads three.
const MARGIN: i64 = 3;

/// Directions of a picture of space, unit vectors: of a parallel projection.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Camera {
    /// To the right of the picture.
    pub right: [f64; 3],
    /// To its top.
    pub up: [f64; 3],
    /// To the viewer.
    pub toward: [f64; 3],
}

impl Camera {
    /// A viewer turned about the y axis, which is vertical, from the z axis to the x axis, and raised above the
    /// horizon, rad.
    pub fn new(turned: f64, raised: f64) -> Self {
        let ([s, c], [se, ce]) = ([turned.sin(), turned.cos()], [raised.sin(), raised.cos()]);
        Self { right: [c, 0.0, -s], up: [-se * s, ce, -se * c], toward: [ce * s, se, ce * c] }
    }
}

/// A field of space, of which the first point lies at the low ends.
#[derive(Clone, Copy, Debug)]
pub struct Volume<'a> {
    /// Values, `[nx, ny, nz]`.
    pub values: &'a [f64],
    /// Points along each axis.
    pub cells: [usize; 3],
    /// Ends along each axis, m.
    pub ends: [[f64; 2]; 3],
}

/// The largest values along lines of sight, at the points where these meet the first slice, and beyond its edges.
struct Sheared {
    /// Axis across the slices, and the axes of a slice.
    axes: [usize; 3],
    /// Number of the first point along the axes of a slice.
    first: [i64; 2],
    /// Points along them.
    points: [usize; 2],
    values: Vec<f64>,
}

/// Paint the largest values of a field that is nowhere negative, row by row from the top left, with the colours of
/// `range`; outside the field the value is 0. The ends of the view are along the axes of the picture, from the origin.
pub fn project(
    field: &Volume,
    camera: &Camera,
    view: &View,
    range: [f64; 2],
    colours: &Colours,
    picture: &mut Vec<u32>,
) {
    let spacing: [f64; 3] = from_fn(|d| (field.ends[d][1] - field.ends[d][0]) / field.cells[d] as f64);
    let steps: [f64; 3] = from_fn(|d| camera.toward[d] / spacing[d]);
    let sheared = shear(field, &steps);
    let Sheared { axes: [depth, b, c], first, points, .. } = sheared;
    let fine = refined(&sheared);
    let fine_points = points.map(|n| FINER * n);
    // The point of the refined image, along one of its axes, that a point of the picture meets: an affine function.
    let met = |at: [f64; 2], of: usize| {
        let place = |d: usize| at[0] * camera.right[d] + at[1] * camera.up[d];
        let axis = [b, c][of];
        let slices = (field.ends[depth][0] - place(depth)) / spacing[depth];
        let point = (place(axis) - field.ends[axis][0]) / spacing[axis] + slices * steps[axis] / steps[depth];
        (point - first[of] as f64) * FINER as f64 + 0.5 * (FINER - 1) as f64
    };
    let ([width, height], [[left, right], [bottom, top]]) = (view.pixels, view.ends);
    let pixel = [(right - left) / width as f64, (top - bottom) / height as f64];
    let per_pixel = [0, 1].map(|of| met([pixel[0], 0.0], of) - met([0.0, 0.0], of));
    picture.clear();
    for row in 0..height {
        let begin = [left + 0.5 * pixel[0], top - (row as f64 + 0.5) * pixel[1]];
        let begin = [0, 1].map(|of| met(begin, of));
        picture.extend((0..width).map(|column| {
            let at: [f64; 2] = from_fn(|of| begin[of] + column as f64 * per_pixel[of]);
            colour_of(bilinear(&fine, fine_points, at), range, colours)
        }));
    }
}

/// Shear a field to the largest values along lines with such components in cells.
fn shear(field: &Volume, steps: &[f64; 3]) -> Sheared {
    let depth = (0..3).max_by(|&a, &b| steps[a].abs().total_cmp(&steps[b].abs())).unwrap_or(0);
    let [b, c] = [[1, 2], [0, 2], [0, 1]][depth];
    let n = field.cells;
    let strides = [n[1] * n[2], n[2], 1];
    // Cells by which a line moves from slice to slice.
    let moves = [b, c].map(|axis| steps[axis] / steps[depth]);
    let reach = moves.map(|per_slice| -per_slice * (n[depth] - 1) as f64);
    let first = reach.map(|reach| reach.min(0.0).floor() as i64 - MARGIN);
    let last: [i64; 2] =
        from_fn(|of| ([b, c].map(|axis| n[axis] as i64)[of]) + reach[of].max(0.0).ceil() as i64 + MARGIN);
    let points: [usize; 2] = from_fn(|of| (last[of] - first[of]) as usize);
    let mut values = vec![0.0_f64; points[0] * points[1]];
    for k in 0..n[depth] {
        let place = moves.map(|per_slice| k as f64 * per_slice);
        let whole: [i64; 2] = from_fn(|of| place[of].floor() as i64 + first[of]);
        let [s, t]: [f64; 2] = from_fn(|of| place[of] - place[of].floor());
        // A point i of the image lies between the points i + whole and i + whole + 1 of the slice.
        let begin = whole.map(|whole| (-whole) as usize);
        for i in 0..n[b] - 1 {
            let row = k * strides[depth] + i * strides[b];
            let to = &mut values[(begin[0] + i) * points[1] + begin[1]..][..n[c] - 1];
            for (j, largest) in to.iter_mut().enumerate() {
                let at = |di: usize, dj: usize| field.values[row + di * strides[b] + (j + dj) * strides[c]];
                let value =
                    (1.0 - s) * ((1.0 - t) * at(0, 0) + t * at(0, 1)) + s * ((1.0 - t) * at(1, 0) + t * at(1, 1));
                *largest = largest.max(value);
            }
        }
    }
    Sheared { axes: [depth, b, c], first, points, values }
}

/// Refine an image.
fn refined(image: &Sheared) -> Vec<f64> {
    let ends = image.points.map(|n| [0.0, n as f64]);
    let field = Periodic { values: &image.values, cells: image.points, ends };
    // The points of a pixel lie around its own.
    let view = View { ends: image.points.map(|n| [-0.5, n as f64 - 0.5]), pixels: image.points.map(|n| FINER * n) };
    let mut fine = Vec::with_capacity(view.pixels[0] * view.pixels[1]);
    for_each_pixel(&field, &view, |_, value| fine.push(value));
    fine
}

/// Return the bilinear interpolation of values `[n, m]` at a place in cells, 0 outside.
fn bilinear(values: &[f64], [n, m]: [usize; 2], [x, y]: [f64; 2]) -> f64 {
    if !(x >= 0.0 && y >= 0.0 && x < (n - 1) as f64 && y < (m - 1) as f64) {
        return 0.0;
    }
    let (i, j) = (x as usize, y as usize);
    let (s, t) = (x - i as f64, y - j as f64);
    let at = &values[i * m + j..];
    (1.0 - s) * ((1.0 - t) * at[0] + t * at[1]) + s * ((1.0 - t) * at[m] + t * at[m + 1])
}
