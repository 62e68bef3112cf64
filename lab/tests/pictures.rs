//! A picture is the mean of a field over two cells along both axes; in space of the largest values along lines of
//! sight.

use std::array::from_fn;
use std::f64::consts::PI;

use lab::paint::{Colours, Periodic, View, paint};
use lab::project::{Camera, Volume, project};

const CELLS: [usize; 2] = [24, 16];

/// Colours that are their own numbers.
fn numbers() -> Colours {
    from_fn(|i| i as u32)
}

/// Return the picture of a field between −1 and 1, a pixel at each point, row by row from the lowest.
fn picture(value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let [nx, ny] = CELLS;
    let values: Vec<f64> = (0..nx * ny).map(|i| value(i / ny, i % ny)).collect();
    let field = Periodic { values: &values, cells: CELLS, ends: [[0.0, nx as f64], [0.0, ny as f64]] };
    let view = View { ends: CELLS.map(|n| [-0.5, n as f64 - 0.5]), pixels: CELLS };
    let mut found = vec![];
    paint(&field, &view, [-1.0, 1.0], &numbers(), &mut found);
    let shown = |colour: u32| (f64::from(colour) + 0.5) / 128.0 - 1.0;
    found.chunks(nx).rev().flatten().map(|&colour| shown(colour)).collect()
}

#[test]
fn waves_of_two_cells_are_not_seen() {
    let checked = |sum: usize| if sum.is_multiple_of(2) { 0.9 } else { -0.9 };
    for found in [picture(|i, _| checked(i)), picture(|_, j| checked(j)), picture(|i, j| checked(i + j))] {
        assert!(found.iter().all(|value| value.abs() < 0.01), "{found:?}");
    }
}

#[test]
fn long_waves_have_the_amplitude_of_their_mean() {
    let wave = |i: usize| (2.0 * PI * i as f64 / 12.0).cos();
    let mean = (2.0 * PI / 12.0).sin() / (2.0 * PI / 12.0);
    let found = picture(|i, _| 0.9 * wave(i));
    for (place, value) in found.iter().enumerate() {
        let expected = 0.9 * mean * wave(place % CELLS[0]);
        assert!((value - expected).abs() < 0.015, "{value} at {place}, {expected} expected");
    }
}

/// Cells of three sizes along the axes of space, and the low ends.
const VOLUME: ([usize; 3], [f64; 3], [f64; 3]) = ([30, 24, 36], [0.1, 0.12, 0.09], [-1.0, -2.0, 0.5]);

/// Return the picture of a field of space between −1 and 1 in a square about a point, row by row from the lowest.
fn seen(value: impl Fn([f64; 3]) -> f64, camera: &Camera, centre: [f64; 3], half: f64, pixels: usize) -> Vec<f64> {
    let (cells, spacing, low) = VOLUME;
    let point = |i: usize| {
        let at = [i / (cells[1] * cells[2]), i / cells[2] % cells[1], i % cells[2]];
        from_fn(|d| low[d] + spacing[d] * at[d] as f64)
    };
    let values: Vec<f64> = (0..cells.iter().product()).map(|i| value(point(i))).collect();
    let ends = from_fn(|d| [low[d], low[d] + spacing[d] * cells[d] as f64]);
    let middle = [camera.right, camera.up].map(|axis| axis.iter().zip(centre).map(|(a, x)| a * x).sum::<f64>());
    let view = View { ends: middle.map(|at| [at - half, at + half]), pixels: [pixels; 2] };
    let mut found = vec![];
    project(&Volume { values: &values, cells, ends }, camera, &view, [-1.0, 1.0], &numbers(), &mut found);
    let shown = |colour: u32| (f64::from(colour) + 0.5) / 128.0 - 1.0;
    found.chunks(pixels).rev().flatten().map(|&colour| shown(colour)).collect()
}

/// Cameras that look mainly along each axis, from both of its ends.
fn cameras() -> impl Iterator<Item = Camera> {
    [(0.3, 0.2), (1.4, -0.3), (0.5, 1.2), (-2.9, 0.4), (-1.2, 0.1), (2.0, -1.3)]
        .map(|(a, b)| Camera::new(a, b))
        .into_iter()
}

#[test]
fn the_directions_of_a_camera_are_right_handed_unit_vectors() {
    for Camera { right, up, toward } in cameras() {
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (a, b, expected) in
            [(right, right, 1.0), (up, up, 1.0), (right, up, 0.0), (right, toward, 0.0), (up, toward, 0.0)]
        {
            assert!((dot(a, b) - expected).abs() < 1e-14);
        }
        let cross: [f64; 3] = from_fn(|d| right[(d + 1) % 3] * up[(d + 2) % 3] - right[(d + 2) % 3] * up[(d + 1) % 3]);
        assert!(cross.iter().zip(toward).all(|(a, b)| (a - b).abs() < 1e-14));
        assert!(up[1] > 0.0, "y is upward");
    }
}

/// A ball, whose value falls with the square of the distance from its centre, has in the picture that of the distance
/// of the line of sight: from each side in the same place.
#[test]
fn a_ball_is_seen_where_it_is_from_all_sides() {
    let (centre, radius) = ([0.6, -0.5, 2.0], 1.0);
    let value = |square: f64| 0.9 - square / (radius * radius);
    let ball = |x: [f64; 3]| value(x.iter().zip(centre).map(|(x, c)| (x - c).powi(2)).sum()).max(0.0);
    let (half, pixels) = (0.5, 20);
    for camera in cameras() {
        for (i, found) in seen(ball, &camera, centre, half, pixels).iter().enumerate() {
            let [s, t] = [i % pixels, i / pixels].map(|k| half * ((2 * k + 1) as f64 / pixels as f64 - 1.0));
            let expected = value(s * s + t * t);
            assert!((found - expected).abs() < 0.03, "{found} at {s:.2}, {t:.2}, {expected} expected: {camera:?}");
        }
    }
}

#[test]
fn the_largest_value_hides_what_is_behind_and_before_it() {
    let blob = |x: [f64; 3], at: [f64; 3], top: f64| {
        top * (-x.iter().zip(at).map(|(x, c)| (x - c).powi(2)).sum::<f64>() / 0.25).exp()
    };
    for camera in cameras() {
        let (centre, reach) = ([0.5, -0.5, 2.1], 0.8);
        let [before, behind] = [reach, -reach].map(|way| from_fn(|d| centre[d] + way * camera.toward[d]));
        for tops in [[0.8, 0.4], [0.4, 0.8]] {
            let both = |x| blob(x, before, tops[0]).max(blob(x, behind, tops[1]));
            let found = seen(both, &camera, centre, 0.05, 1)[0];
            assert!((found - 0.8).abs() < 0.08, "{found}: {camera:?}");
        }
        let far = from_fn(|d| centre[d] + 4.0 * camera.right[d]);
        assert!(seen(|_| 0.9, &camera, far, 0.05, 1)[0].abs() < 0.01, "outside the field");
    }
}
