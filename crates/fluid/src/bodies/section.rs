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
