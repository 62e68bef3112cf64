//! A field as a picture: bicubic interpolation (Catmull and Rom 1974) and a table of colours.

/// Part of the plane and size of its picture.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Ends along each axis, m.
    pub ends: [[f64; 2]; 2],
    /// Pixels along each axis.
    pub pixels: [usize; 2],
}

/// Ends of a periodic field along each axis, m, and its points, of which the first lies at the low end.
#[derive(Clone, Copy, Debug)]
pub struct Periodic<'a> {
    /// Values, `[nx, ny]`.
    pub values: &'a [f64],
    /// Points along each axis.
    pub cells: [usize; 2],
    /// Ends along each axis, m.
    pub ends: [[f64; 2]; 2],
}

/// The four points around a place, and their weights.
type Taps = ([usize; 4], [f64; 4]);

/// Colours of the numbers from the low to the high end of a range, as bytes of red, green, blue and opacity.
pub type Colours = [u32; 256];

/// Paint a field row by row from the top left, with the colours of `range`.
pub fn paint(field: &Periodic, view: &View, range: [f64; 2], colours: &Colours, picture: &mut Vec<u32>) {
    let [width, height] = view.pixels;
    let [columns, rows] = [0, 1].map(|axis| taps(field, view, axis));
    let ny = field.cells[1];
    let scale = colours.len() as f64 / (range[1] - range[0]);
    let mut line = vec![0.0; ny];
    picture.resize(width * height, 0);
    for (px, (points, weights)) in columns.iter().enumerate() {
        let [a, b, c, d] = points.map(|i| &field.values[i * ny..][..ny]);
        for (j, value) in line.iter_mut().enumerate() {
            *value = weights[0] * a[j] + weights[1] * b[j] + weights[2] * c[j] + weights[3] * d[j];
        }
        for (py, (points, weights)) in rows.iter().enumerate() {
            let value: f64 = points.iter().zip(weights).map(|(&j, weight)| weight * line[j]).sum();
            // A conversion saturates, and makes 0 of what is no number.
            let colour = ((value - range[0]) * scale) as usize;
            picture[(height - 1 - py) * width + px] = colours[colour.min(colours.len() - 1)];
        }
    }
}

/// Return the taps of each pixel along an axis.
fn taps(field: &Periodic, view: &View, axis: usize) -> Vec<Taps> {
    let ([low, high], [first, last]) = (view.ends[axis], field.ends[axis]);
    let (n, pixels) = (field.cells[axis], view.pixels[axis]);
    let taps_at = |pixel: usize| {
        let at = low + (high - low) * (pixel as f64 + 0.5) / pixels as f64;
        let place = (at - first) / (last - first) * n as f64;
        let (begin, s) = (place.floor() as i64, place - place.floor());
        let points = [-1, 0, 1, 2].map(|k| (begin + k).rem_euclid(n as i64) as usize);
        (
            points,
            [
                0.5 * s * (-1.0 + s * (2.0 - s)),
                1.0 + 0.5 * s * s * (3.0 * s - 5.0),
                0.5 * s * (1.0 + s * (4.0 - 3.0 * s)),
                0.5 * s * s * (s - 1.0),
            ],
        )
    };
    (0..pixels).map(taps_at).collect()
}
