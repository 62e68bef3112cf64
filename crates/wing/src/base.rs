//! Motion of the base that holds the root.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use structure::cubic;

use crate::Error;
use crate::geometry::Vector;
use crate::twist::Twist;

/// Tolerance of a rotation matrix, for rounding.
const ORTHOGONAL: f64 = 1e-6;

/// State of a wing between two steps.
pub type WingState = structure::State<3, Memory>;

/// Memory of a wing alone.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Pose of the base.
    pub base: RigidMotion,
    /// Directors of the segments of veins with torsion, vein after vein.
    pub twists: Vec<Twist>,
}

impl Clone for Memory {
    fn clone(&self) -> Self {
        Self { base: self.base, twists: self.twists.clone() }
    }

    /// Copy without allocation.
    fn clone_from(&mut self, other: &Self) {
        self.base = other.base;
        self.twists.clone_from(&other.twists);
    }
}

/// Pose and motion of the base at the end of the next step: a node at X at rest moves to o + d + R (X − o).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidMotion {
    /// Displacement d of the origin o, m.
    pub displacement: [f64; 3],
    /// Velocity of the origin, m/s.
    pub velocity: [f64; 3],
    /// Rows of the rotation R from rest.
    pub rotation: [[f64; 3]; 3],
    /// Angular velocity, rad/s.
    pub angular_velocity: [f64; 3],
}

/// Displacement and rotation of the base, each with its first and second rate.
pub(crate) struct Placement {
    displacement: [Vector; 3],
    pub(crate) rotation: [Matrix3<f64>; 3],
}

impl RigidMotion {
    /// Return the pose at rest.
    pub fn rest() -> Self {
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Self { displacement: [0.0; 3], velocity: [0.0; 3], rotation, angular_velocity: [0.0; 3] }
    }

    /// Return the pose without its motion.
    pub(crate) fn stopped(self) -> Self {
        Self { velocity: [0.0; 3], angular_velocity: [0.0; 3], ..self }
    }

    /// Return R.
    pub(crate) fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.rotation[i][j])
    }

    /// Return the pose at the fraction `s` of the way to `end`, `duration` seconds later, by the cubic through both.
    pub(crate) fn towards(&self, end: &Self, s: f64, duration: f64) -> Placement {
        let ends = [self, end].map(|pose| (Vector::from(pose.displacement), Vector::from(pose.velocity)));
        let turns = [self, end].map(|pose| {
            let rotation = pose.matrix();
            (rotation, Vector::from(pose.angular_velocity).cross_matrix() * rotation)
        });
        let displacement = cubic(ends[0], ends[1], s, duration);
        Placement { displacement, rotation: cubic(turns[0], turns[1], s, duration) }
    }

    /// Refuse numbers that are not finite and a matrix that is not a rotation.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let vectors = [self.displacement, self.velocity, self.angular_velocity];
        if vectors.iter().chain(&self.rotation).flatten().any(|number| !number.is_finite()) {
            return Err(Error::value("pose", format!("{self:?}"), "finite"));
        }
        let rotation = self.matrix();
        let off = (rotation.transpose() * rotation - Matrix3::identity()).amax();
        match off <= ORTHOGONAL && rotation.determinant() > 0.0 {
            true => Ok(()),
            false => Err(Error::value("pose.rotation", format!("{:?}", self.rotation), "a rotation matrix")),
        }
    }
}

impl Placement {
    /// Return position, velocity and acceleration of a node at `arm` from the `origin` at rest.
    pub(crate) fn node(&self, origin: Vector, arm: Vector) -> [Vector; 3] {
        let [d, v, a] = self.displacement;
        let [turned, rate, second_rate] = self.rotation.map(|rotation| rotation * arm);
        [origin + d + turned, v + rate, a + second_rate]
    }

    /// Return the pose with its motion.
    pub(crate) fn motion(&self) -> RigidMotion {
        let ([displacement, velocity, _], [rotation, rate, _]) = (self.displacement, self.rotation);
        let spin = rate * rotation.transpose();
        let twice = [spin[(2, 1)] - spin[(1, 2)], spin[(0, 2)] - spin[(2, 0)], spin[(1, 0)] - spin[(0, 1)]];
        RigidMotion {
            displacement: displacement.into(),
            velocity: velocity.into(),
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)])),
            angular_velocity: twice.map(|component| component * 0.5),
        }
    }
}
