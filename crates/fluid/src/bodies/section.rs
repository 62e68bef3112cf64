//! What an outline is measured by.

/// The nearest point of an outline.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// Signed distance, m, positive outside. Outside corners it is the distance to the lines of the sides, so that
    /// lines of equal distance keep the corner.
    pub distance: f64,
    /// That point, or the point on the line of the side, m.
    pub surface: [f64; 2],
    /// Unit normal outwards.
    pub normal: [f64; 2],
}

/// Area and its moments.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Area, m².
    pub area: f64,
    /// Centroid, m.
    pub centroid: [f64; 2],
    /// Polar second moment of area about the centroid, m⁴.
    pub polar: f64,
}

impl Section {
    /// Return the section of a layer of a thickness (m) along a line.
    pub fn of_layer(points: &[[f64; 2]], thickness: f64) -> Self {
        let sides = || {
            points.windows(2).map(|side| {
                let middle = [0, 1].map(|axis| 0.5 * (side[0][axis] + side[1][axis]));
                (middle, (side[1][0] - side[0][0]).hypot(side[1][1] - side[0][1]))
            })
        };
        let length: f64 = sides().map(|(_, length)| length).sum();
        let centroid = [0, 1].map(|axis| sides().map(|(middle, part)| middle[axis] * part).sum::<f64>() / length);
        let polar = |(middle, part): ([f64; 2], f64)| {
            let arm = [0, 1].map(|axis| middle[axis] - centroid[axis]);
            part * (arm[0] * arm[0] + arm[1] * arm[1] + part * part / 12.0)
        };
        Self { area: thickness * length, centroid, polar: thickness * sides().map(polar).sum::<f64>() }
    }
}
