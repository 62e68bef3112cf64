//! A picture is the mean of a field over two cells along both axes.

use std::array::from_fn;
use std::f64::consts::PI;

use lab::paint::{Colours, Periodic, View, paint};

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
