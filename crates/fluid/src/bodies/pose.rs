//! Place and motion that the laws of a body give.

use rigid::Pose;

use crate::parameters::{Body, Motion};
use crate::space::{Kinematics, Space};

/// Return place and motion of a body at a time (s); one without a law is at rest.
pub fn pose_at<const D: usize>(body: &Body<D>, t: f64) -> Pose<D>
where
    [f64; D]: Space<D>,
{
    let angle = <[f64; D]>::angle_at_rest(&body.turn);
    let mut pose = Pose { position: body.position.into(), angle, ..Pose::default() };
    if let Some(Motion::Laws { displacement, axis: about, angle }) = &body.motion {
        for (axis, law) in displacement.iter().enumerate() {
            let (displacement, rate) = law.value_and_rate(t);
            pose.position[axis] += displacement;
            pose.velocity[axis] = rate;
        }
        let (angle, rate) = angle.value_and_rate(t);
        pose.angle += *about * angle;
        pose.omega = *about * rate;
    }
    pose
}
