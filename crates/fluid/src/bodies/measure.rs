//! The contract of bodies: what a body is at a place.

/// A body that can be measured.
///
/// Everything that its drag on the fluid depends on follows from `measure`: the drag profile from the distance, the
/// wall target from the surfaces, and the velocity to which the fluid is drawn. `N` is the number of surfaces that may
/// be near a point.
pub trait Measured<const N: usize> {
    /// A point near the body, with what is known of its place in the body.
    type Place;

    /// Measure the body at a place.
    fn measure(&self, place: &Self::Place) -> Measure<N>;
}

/// A body at a point.
#[derive(Clone, Copy, Debug)]
pub struct Measure<const N: usize> {
    /// Surfaces of the body.
    pub surfaces: [Surface; N],
    /// Velocity of the body at the point, m/s.
    pub velocity: [f64; 2],
    /// The same at the beginning of the step, m/s.
    pub velocity_before: [f64; 2],
    /// Growth of the velocity along a surface with the distance from it, 1/s.
    pub spin: f64,
}

/// A surface, measured from a point.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Signed distance, m, positive in the fluid.
    pub distance: f64,
    /// Nearest point of the surface, m.
    pub foot: [f64; 2],
    /// Unit normal into the fluid.
    pub normal: [f64; 2],
}

impl<const N: usize> Measure<N> {
    /// Return the signed distance from the body, m, positive in the fluid.
    #[inline(always)]
    pub fn distance(&self) -> f64 {
        self.surfaces.iter().map(|surface| surface.distance).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The walls of a channel.
pub struct Walls {
    /// y of the lower and the upper wall, m.
    pub y: [f64; 2],
    /// Height of the periodic domain, m.
    pub period: f64,
}

impl Measured<1> for Walls {
    type Place = [f64; 2];

    fn measure(&self, &[x, y]: &[f64; 2]) -> Measure<1> {
        let [low, high] = self.y;
        let delta = y - 0.5 * (low + high);
        let from_middle = delta - self.period * (delta / self.period).round();
        let distance = 0.5 * (high - low) - from_middle.abs();
        let normal = [0.0, -1_f64.copysign(from_middle)];
        let foot = [x, y - distance * normal[1]];
        let still = [0.0; 2];
        let surfaces = [Surface { distance, foot, normal }];
        Measure { surfaces, velocity: still, velocity_before: still, spin: 0.0 }
    }
}
