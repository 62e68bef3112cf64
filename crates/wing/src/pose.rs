//! Pose and motion of the base that holds the root.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::geometry::Vector;

/// Tolerance of a rotation matrix, for rounding.
const ORTHOGONAL: f64 = 1e-6;

/// Pose and motion of the base at the end of the next step: a node at X at rest moves to o + d + R (X − o).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Displacement d of the origin o, m.
    pub displacement: [f64; 3],
    /// Velocity of the origin, m/s.
    pub velocity: [f64; 3],
    /// Rows of the rotation R from rest.
    pub rotation: [[f64; 3]; 3],
    /// Angular velocity, rad/s.
    pub angular_velocity: [f64; 3],
}

/// Pose with the rates of all its numbers.
#[derive(Clone, Copy)]
pub(crate) struct Placement {
    pub(crate) displacement: Vector,
    pub(crate) velocity: Vector,
    pub(crate) acceleration: Vector,
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) rate: Matrix3<f64>,
    pub(crate) second_rate: Matrix3<f64>,
}

impl Pose {
    /// Return the pose at rest.
    pub fn rest() -> Self {
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { displacement: [0.0; 3], velocity: [0.0; 3], rotation, angular_velocity: [0.0; 3] }
    }

    /// Refuse numbers that are not finite and a matrix that is not a rotation.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let vectors = [self.displacement, self.velocity, self.angular_velocity];
        if vectors.iter().chain(&self.rotation).flatten().any(|number| !number.is_finite()) {
            return Err(Error::value("pose", self, "finite"));
        }
        let rotation = self.matrix();
        let off = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        match off <= ORTHOGONAL && rotation.determinant() > 0.0 {
            true => Ok(()),
            false => Err(Error::value("pose.rotation", self.rotation, "a rotation matrix")),
        }
    }

    /// Return R.
    pub(crate) fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.rotation[i][j])
    }

    /// Return the pose at the fraction `s` of the way to `end`, `duration` seconds later, by the cubic through both.
    pub(crate) fn towards(&self, end: &Self, s: f64, duration: f64) -> Placement {
        let ends = [self, end].map(|pose| {
            let rotation = pose.matrix();
            let rate = Vector::from(pose.angular_velocity).cross_matrix() * rotation;
            (Vector::from(pose.displacement), Vector::from(pose.velocity), rotation, rate)
        });
        let [(d_0, v_0, r_0, w_0), (d_1, v_1, r_1, w_1)] = ends;
        let [displacement, velocity, acceleration] = hermite((d_0, v_0), (d_1, v_1), s, duration);
        let [rotation, rate, second_rate] = hermite((r_0, w_0), (r_1, w_1), s, duration);
        Placement { displacement, velocity, acceleration, rotation, rate, second_rate }
    }
}

impl Placement {
    /// Return position, velocity and acceleration of a node at `arm` from the `origin` at rest.
    pub(crate) fn node(&self, origin: Vector, arm: Vector) -> [Vector; 3] {
        [
            origin + self.displacement + self.rotation * arm,
            self.velocity + self.rate * arm,
            self.acceleration + self.second_rate * arm,
        ]
    }
}

/// Return value, rate and second rate of the cubic that has these values and rates at its ends.
fn hermite<const C: usize>(
    (p_0, v_0): (nalgebra::SMatrix<f64, 3, C>, nalgebra::SMatrix<f64, 3, C>),
    (p_1, v_1): (nalgebra::SMatrix<f64, 3, C>, nalgebra::SMatrix<f64, 3, C>),
    s: f64,
    duration: f64,
) -> [nalgebra::SMatrix<f64, 3, C>; 3] {
    let (m_0, m_1) = (v_0 * duration, v_1 * duration);
    let (square, cube) = ((p_1 - p_0) * 3.0 - m_0 * 2.0 - m_1, (p_0 - p_1) * 2.0 + m_0 + m_1);
    // At the end the pose is exact.
    let value = if s == 1.0 { p_1 } else { p_0 + (m_0 + (square + cube * s) * s) * s };
    let rate = (m_0 + (square * 2.0 + cube * (3.0 * s)) * s) / duration;
    [value, if s == 1.0 { v_1 } else { rate }, (square * 2.0 + cube * (6.0 * s)) / (duration * duration)]
}
