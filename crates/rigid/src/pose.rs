//! Place and motion of a rigid body.

use serde::{Deserialize, Serialize};

use crate::kinematics::{Freedoms, Kinematics, Spin, Vector, join, split};

/// Place and motion of a body, or its displacement from its place at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose<const D: usize = 2>
where
    [f64; D]: Kinematics<D>,
{
    /// Position of the pivot, m.
    pub position: Vector<D>,
    /// In the plane the angle from the x axis of the domain to that of the body, in space the rotation vector from the
    /// orientation at rest, rad.
    pub angle: Spin<D>,
    /// Velocity of the pivot, m/s.
    pub velocity: Vector<D>,
    /// Angular velocity, rad/s.
    pub omega: Spin<D>,
}

impl<const D: usize> Default for Pose<D>
where
    [f64; D]: Kinematics<D>,
{
    fn default() -> Self {
        Self::new(&[0.0; 6], &[0.0; 6])
    }
}

impl<const D: usize> Pose<D>
where
    [f64; D]: Kinematics<D>,
{
    /// Become the pose at the fraction `s` of the time from `a` to `b`, which are `h` seconds apart: the velocity is
    /// linear, the position is the cubic with the positions and velocities of both ends.
    pub fn interpolated(a: &Self, b: &Self, s: f64, h: f64) -> Self {
        let (p0, p1, v0, v1) = (a.places(), b.places(), a.rates(), b.rates());
        let [slope0, slope1] = [a, b].map(Self::rates_of_places);
        let place = |i: usize| {
            let (m0, m1) = (h * slope0[i], h * slope1[i]);
            p0[i] + s * (m0 + s * (3.0 * (p1[i] - p0[i]) - 2.0 * m0 - m1 + s * (2.0 * (p0[i] - p1[i]) + m0 + m1)))
        };
        Self::new(&std::array::from_fn(place), &std::array::from_fn(|i| v0[i] + s * (v1[i] - v0[i])))
    }

    /// Return the position and the angle.
    pub fn places(&self) -> Freedoms {
        join(&self.position, self.angle)
    }

    /// Return the velocity and the angular velocity.
    pub fn rates(&self) -> Freedoms {
        join(&self.velocity, self.omega)
    }

    /// Return the rates of [`Self::places`].
    pub fn rates_of_places(&self) -> Freedoms {
        join(&self.velocity, <[f64; D]>::angle_rate(self.angle, self.omega))
    }

    /// A pose from [`Self::places`] and [`Self::rates`].
    pub fn new(places: &Freedoms, rates: &Freedoms) -> Self {
        let ((position, angle), (velocity, omega)) = (split(places), split(rates));
        Self { position, angle, velocity, omega }
    }
}
