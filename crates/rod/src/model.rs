//! Choices that define the model of a rod: section, bending energy, calibration and support.

pub use method::{Bending, Calibration, Section};

/// Profiles of section and displaced fluid along the rod, relative to the root.
///
/// An array alternates between nodes and midpoints of segments, `[2 n + 1]`; an empty array is a uniform profile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Taper {
    /// Mass per length.
    pub line_density: Vec<f64>,
    /// Mass per length of the displaced fluid.
    pub displaced: Vec<f64>,
    /// Bending stiffness.
    pub bending_stiffness: Vec<f64>,
    /// Axial stiffness.
    pub axial_stiffness: Vec<f64>,
    /// Shear stiffness.
    pub shear_stiffness: Vec<f64>,
}

impl Taper {
    /// Return a ratio of a profile at one of its places.
    pub(crate) fn at(profile: &[f64], i: usize) -> f64 {
        profile.get(i).copied().unwrap_or(1.0)
    }
}

/// Support of the root. Each one but the clamp needs invariant bending and the second-order calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum RootSupport {
    /// The root neither moves nor turns, except by prescribed motion.
    #[default]
    Clamped,
    /// The root turns without resistance.
    Pinned,
    /// The root turns by an angle θ against the moment `stiffness (θ − rest_angle) + damping θ'`.
    TorsionSpring {
        /// Stiffness, N m/rad.
        stiffness: f64,
        /// Damping, N m s/rad; 0 in space, where θ has no axis.
        damping: f64,
        /// Angle of the relaxed spring, rad, positive to the left; 0 in space.
        rest_angle: f64,
    },
    /// The root moves and turns; [`Rod::towing`](crate::Rod::towing) acts on it.
    Free,
}

/// Guide along which the root moves freely; in all else the support holds it or the prescribed motion moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slide {
    /// Axis of the guide: 0 is x.
    pub axis: usize,
    /// Mass that moves with the root, kg, besides the mass of the rod.
    pub mass: f64,
}
