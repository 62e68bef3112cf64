//! What closed shapes have in common.

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<const D: usize> {
    /// Signed distance, m, positive outside. Outside corners it is the distance to the lines or planes of the sides, so
    /// that surfaces of equal distance keep the corner.
    pub distance: f64,
    /// That point, or the point on the line or plane of the side, m.
    pub surface: [f64; D],
    /// Unit normal outwards.
    pub normal: [f64; D],
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

/// A closed shape in its own axes.
pub trait Region<const D: usize> {
    /// Return the nearest point of the surface.
    fn nearest(&self, point: [f64; D]) -> Nearest<D>;

    /// Return the extent from the origin in the direction of a unit vector, m.
    fn extent(&self, direction: [f64; D]) -> f64;

    /// Return the diameter of the largest ball inside, m.
    fn thickness(&self) -> f64;

    /// Return points by which two shapes of one kind and size are the same: corners, or points of a round outline.
    fn corners(&self) -> Vec<[f64; D]>;
}
