//! Place and motion of a rigid body.

use serde::{Deserialize, Serialize};

use crate::parameters::{Body, Motion};
use crate::space::{Freedoms, Space, Spin, Vector, join, split};

/// Place and motion of a body, or its displacement from its place at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose<const D: usize = 2>
where
    [f64; D]: Space<D>,
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
    [f64; D]: Space<D>,
{
    fn default() -> Self {
        Self::new(&[0.0; 6], &[0.0; 6])
    }
}

impl<const D: usize> Pose<D>
where
    [f64; D]: Space<D>,
{
    /// Return place and motion of a body at a time (s); one without a law is at rest.
    pub fn of(body: &Body<D>, t: f64) -> Self {
        let angle = <[f64; D]>::angle_at_rest(&body.turn);
        let mut pose = Self { position: body.position.into(), angle, ..Self::default() };
        if let Some(Motion::Laws { displacement, rotations }) = &body.motion {
            for (axis, law) in displacement.iter().enumerate() {
                let (displacement, rate) = law.value_and_rate(t);
                pose.position[axis] += displacement;
                pose.velocity[axis] = rate;
            }
            for (about, angle) in rotations {
                let (angle, rate) = angle.value_and_rate(t);
                (pose.angle, pose.omega) = <[f64; D]>::turned((pose.angle, pose.omega), *about * angle, *about * rate);
            }
        }
        pose
    }

    /// Become the pose at the fraction `s` of the time from `a` to `b`, which are `h` seconds apart: the velocity is
    /// linear, the position is the cubic with the positions and velocities of both ends.
    pub(crate) fn interpolated(a: &Self, b: &Self, s: f64, h: f64) -> Self {
        let (p0, p1, v0, v1) = (a.places(), b.places(), a.rates(), b.rates());
        let [slope0, slope1] = [a, b].map(Self::rates_of_places);
        let place = |i: usize| {
            let (m0, m1) = (h * slope0[i], h * slope1[i]);
            p0[i] + s * (m0 + s * (3.0 * (p1[i] - p0[i]) - 2.0 * m0 - m1 + s * (2.0 * (p0[i] - p1[i]) + m0 + m1)))
        };
        Self::new(&std::array::from_fn(place), &std::array::from_fn(|i| v0[i] + s * (v1[i] - v0[i])))
    }

    /// Return the position and the angle.
    pub(crate) fn places(&self) -> Freedoms {
        join(&self.position, self.angle)
    }

    /// Return the velocity and the angular velocity.
    pub(crate) fn rates(&self) -> Freedoms {
        join(&self.velocity, self.omega)
    }

    /// Return the rates of [`Self::places`].
    pub(crate) fn rates_of_places(&self) -> Freedoms {
        join(&self.velocity, <[f64; D]>::angle_rate(self.angle, self.omega))
    }

    /// A pose from [`Self::places`] and [`Self::rates`].
    pub(crate) fn new(places: &Freedoms, rates: &Freedoms) -> Self {
        let ((position, angle), (velocity, omega)) = (split(places), split(rates));
        Self { position, angle, velocity, omega }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use geometry::space::Solid;
    use nalgebra::Rotation3;

    use super::*;
    use crate::parameters::{Body, Law};
    use crate::space::Turn;

    #[test]
    fn the_angular_velocity_is_the_rate_of_the_rotations_in_their_order() {
        let law = |a: f64, w: f64| Law::new(move |t| (a * (w * t).sin(), a * w * (w * t).cos()));
        let axes = [[0.0, 0.0, 1.0], [2.0, -1.0, 2.0], [0.0, 1.0, 0.0]].map(Vector::from);
        let angles = [law(0.9, TAU), law(0.7, 4.0), law(0.3, 9.0)];
        let motion = Motion::of_rotations([0.0; 3].map(Law::constant), axes.into_iter().zip(angles.clone()));
        let turn = Turn { axis: [1.0, 0.0, 1.0], angle: 0.4 };
        let body = Body { turn, motion: Some(motion), ..Body::still("", Solid::Ellipsoid([0.3, 0.1, 0.2]), [0.0; 3]) };
        for t in [0.0, 0.13, 0.6] {
            let turned = |t: f64| {
                axes.iter().zip(&angles).fold(Vector::from([0.2, -0.5, 0.3]), |point, (axis, angle)| {
                    Rotation3::new(axis.normalize() * angle.value_and_rate(t).0) * point
                })
            };
            let pose = Pose::of(&body, t);
            let own = Rotation3::new(pose.angle) * Vector::from([0.2, -0.5, 0.3]);
            assert!((own - turned(t)).norm() < 1e-14, "{own} against {} at {t}", turned(t));
            let rate = (turned(t + 1e-5) - turned(t - 1e-5)) / 2e-5;
            let expected = pose.omega.cross(&own);
            assert!((rate - expected).norm() < 1e-8, "{expected} against {rate} at {t}");
        }
    }
}
