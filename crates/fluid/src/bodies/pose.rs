//! Place and motion that the laws of a body give.

use rigid::Pose;

use crate::parameters::{Body, Laws};
use crate::space::{Kinematics, Space, Vector};

/// Return place and motion of a body at a time (s); one without a law is at rest.
pub fn pose_at<const D: usize>(body: &Body<D>, t: f64) -> Pose<D>
where
    [f64; D]: Space<D>,
{
    displaced(body, &body.laws().map(|laws| displacement_at(laws, t)).unwrap_or_default())
}

/// Return place and motion of a body for those relative to its place at rest.
pub fn displaced<const D: usize>(body: &Body<D>, by: &Pose<D>) -> Pose<D>
where
    [f64; D]: Space<D>,
{
    let angle = <[f64; D]>::angle_at_rest(&body.turn) + by.angle;
    Pose { position: Vector::from(body.position) + by.position, angle, ..*by }
}

/// Return displacement and motion that laws give at a time (s).
pub fn displacement_at<const D: usize>(laws: &Laws<D>, t: f64) -> Pose<D>
where
    [f64; D]: Space<D>,
{
    let mut pose = Pose::default();
    for (axis, law) in laws.displacement.iter().enumerate() {
        (pose.position[axis], pose.velocity[axis]) = law.value_and_rate(t);
    }
    for (about, angle) in &laws.rotations {
        let (angle, rate) = angle.value_and_rate(t);
        (pose.angle, pose.omega) = <[f64; D]>::turned((pose.angle, pose.omega), *about * angle, *about * rate);
    }
    pose
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use geometry::space::Solid;
    use nalgebra::Rotation3;

    use super::*;
    use crate::law::Law;
    use crate::parameters::{Body, Motion};
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
            let pose = pose_at(&body, t);
            let own = Rotation3::new(pose.angle) * Vector::from([0.2, -0.5, 0.3]);
            assert!((own - turned(t)).norm() < 1e-14, "{own} against {} at {t}", turned(t));
            let rate = (turned(t + 1e-5) - turned(t - 1e-5)) / 2e-5;
            let expected = pose.omega.cross(&own);
            assert!((rate - expected).norm() < 1e-8, "{expected} against {rate} at {t}");
        }
    }
}
