//! Place and motion of a rigid body.

use serde::{Deserialize, Serialize};

use crate::parameters::{Body, Motion};

/// Place and motion of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position of the pivot, m.
    pub position: [f64; 2],
    /// Angle from the x axis of the domain to that of the body, rad.
    pub angle: f64,
    /// Velocity of the pivot, m/s.
    pub velocity: [f64; 2],
    /// Rate at which it turns, rad/s.
    pub omega: f64,
}

impl Pose {
    /// Return place and motion of a body at a time (s); one without a law is as given.
    pub fn of(body: &Body, t: f64) -> Self {
        let mut pose = Self { position: body.position, angle: body.angle, ..Self::default() };
        if let Some(Motion::Laws { displacement, angle }) = &body.motion {
            for (axis, law) in displacement.iter().enumerate() {
                let (displacement, rate) = law.value_and_rate(t);
                pose.position[axis] += displacement;
                pose.velocity[axis] = rate;
            }
            let (angle, rate) = angle.value_and_rate(t);
            pose.angle += angle;
            pose.omega = rate;
        }
        pose
    }

    /// Become the pose at the fraction `s` of the time from `a` to `b`, which are `h` seconds apart: the velocity is
    /// linear, the position is the cubic with the positions and velocities of both ends.
    pub(crate) fn interpolated(a: &Self, b: &Self, s: f64, h: f64) -> Self {
        let linear = |a: f64, b: f64| a + s * (b - a);
        let cubic = |p0: f64, p1: f64, v0: f64, v1: f64| {
            let (m0, m1) = (h * v0, h * v1);
            p0 + s * (m0 + s * (3.0 * (p1 - p0) - 2.0 * m0 - m1 + s * (2.0 * (p0 - p1) + m0 + m1)))
        };
        Self {
            position: [0, 1].map(|axis| cubic(a.position[axis], b.position[axis], a.velocity[axis], b.velocity[axis])),
            angle: cubic(a.angle, b.angle, a.omega, b.omega),
            velocity: [0, 1].map(|axis| linear(a.velocity[axis], b.velocity[axis])),
            omega: linear(a.omega, b.omega),
        }
    }

    /// Return x, y and angle.
    pub(crate) fn places(&self) -> [f64; 3] {
        [self.position[0], self.position[1], self.angle]
    }

    /// Return the rates of x, y and angle.
    pub(crate) fn rates(&self) -> [f64; 3] {
        [self.velocity[0], self.velocity[1], self.omega]
    }

    /// A pose from [`Self::places`] and [`Self::rates`].
    pub(crate) fn new([x, y, angle]: [f64; 3], [u, v, omega]: [f64; 3]) -> Self {
        Self { position: [x, y], angle, velocity: [u, v], omega }
    }
}
