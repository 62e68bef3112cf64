//! A field as a picture: the mean over two cells, as in the pictures of the command (`nervure.output.flow`), of its
//! bicubic interpolation (Catmull and Rom 1974), and a table of colours. The mean takes the waves of two cells out.

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

/// The six points around a place, and their weights.
type Taps = ([usize; 6], [f64; 6]);

/// Colours of the numbers from the low to the high end of a range, as bytes of red, green, blue and opacity.
pub type Colours = [u32; 256];

/// Paint a field row by row from the top left, with the colours of `range`.
pub fn paint(field: &Periodic, view: &View, range: [f64; 2], colours: &Colours, picture: &mut Vec<u32>) {
    let [width, height] = view.pixels;
    picture.resize(width * height, 0);
    for_each_pixel(field, view, |[px, py], value| {
        picture[(height - 1 - py) * width + px] = colour_of(value, range, colours);
    });
}

/// Return the colour of a number.
pub fn colour_of(value: f64, [low, high]: [f64; 2], colours: &Colours) -> u32 {
    // A conversion saturates, and makes 0 of what is no number.
    let colour = ((value - low) * (colours.len() as f64 / (high - low))) as usize;
    colours[colour.min(colours.len() - 1)]
}

/// Visit the pixels of a view, counted from the low ends, with the mean of the field over two cells there.
pub fn for_each_pixel(field: &Periodic, view: &View, mut visit: impl FnMut([usize; 2], f64)) {
    let [columns, rows] = [0, 1].map(|axis| taps(field, view, axis));
    let ny = field.cells[1];
    let mut line = vec![0.0; ny];
    for (px, (points, weights)) in columns.iter().enumerate() {
        line.fill(0.0);
        for (&i, weight) in points.iter().zip(weights) {
            for (sum, value) in line.iter_mut().zip(&field.values[i * ny..][..ny]) {
                *sum += weight * value;
            }
        }
        for (py, (points, weights)) in rows.iter().enumerate() {
            visit([px, py], points.iter().zip(weights).map(|(&j, weight)| weight * line[j]).sum());
        }
    }
}

/// Return the weight of a point at the distance `x`, in cells: the mean of Catmull and Rom's kernel over two cells.
fn weight(x: f64) -> f64 {
    0.5 * (integral(x + 1.0) - integral(x - 1.0))
}

/// Return the integral of Catmull and Rom's kernel from 0 to `x`.
fn integral(x: f64) -> f64 {
    let d = x.abs().min(2.0);
    let part = if d < 1.0 {
        d + d.powi(3) * (0.375 * d - 5.0 / 6.0)
    } else {
        -1.0 / 6.0 + d * (2.0 + d * (-2.0 + d * (5.0 / 6.0 - d / 8.0)))
    };
    part.copysign(x)
}

/// Return the taps of each pixel along an axis.
fn taps(field: &Periodic, view: &View, axis: usize) -> Vec<Taps> {
    let ([low, high], [first, last]) = (view.ends[axis], field.ends[axis]);
    let (n, pixels) = (field.cells[axis], view.pixels[axis]);
    let taps_at = |pixel: usize| {
        let at = low + (high - low) * (pixel as f64 + 0.5) / pixels as f64;
        let place = (at - first) / (last - first) * n as f64;
        let (begin, s) = (place.floor() as i64, place - place.floor());
        let points = [-2, -1, 0, 1, 2, 3].map(|k| (begin + k).rem_euclid(n as i64) as usize);
        (points, std::array::from_fn(|i| weight(s - (i as f64 - 2.0))))
    };
    (0..pixels).map(taps_at).collect()
}
