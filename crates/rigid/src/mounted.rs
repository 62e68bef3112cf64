//! A step of a body on springs whose centre of mass is its pivot.

use method::Support;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

use crate::body::{Body, BodyParameters, BodyState, Placed};
use crate::force::Drag;
use crate::history::DisplacementHistory;
use crate::kinematics::{Freedoms, Kinematics, nearest};
use crate::pose::Pose;
use crate::step::{Mass, SpringMotion, SpringStep};

/// A body on springs in a step. In the plane its angle obeys the differences; in space it turns as a [`Body`] does.
pub struct MountedStep<'a, const D: usize>
where
    [f64; D]: Kinematics<D>,
{
    /// Spring and damper along each freedom; absent where the body is held.
    pub supports: &'a [Option<Support>; 6],
    /// Displacement before the step.
    pub history: &'a DisplacementHistory<D>,
    /// Coefficients of the backward differences.
    pub c: [f64; 3],
    /// Mass, kg.
    pub mass: f64,
    /// Moments of inertia about the pivot, in the axes of the domain at rest, kg m².
    pub inertia: [[f64; 3]; 3],
    /// The displaced fluid.
    pub fluid: Mass<D>,
    /// Weight less that of the fluid that carries the body, with its moment.
    pub weight: Freedoms,
    /// Velocities along the freedoms with which the drag was found.
    pub predicted: Freedoms,
}

/// Dynamics of a body on springs; the crate implements them in two and three dimensions.
pub trait SpringDynamics<const D: usize>: Kinematics<D> {
    /// See [`MountedStep::solve`].
    fn solve(step: &MountedStep<D>, drag: &Drag<D>) -> SpringMotion<D>
    where
        [f64; D]: Kinematics<D>;
}

impl<const D: usize> MountedStep<'_, D>
where
    [f64; D]: SpringDynamics<D>,
{
    /// Find the motion under `drag`.
    pub fn solve(&self, drag: &Drag<D>) -> SpringMotion<D> {
        <[f64; D]>::solve(self, drag)
    }
}

impl SpringDynamics<2> for [f64; 2] {
    fn solve(step: &MountedStep<2>, drag: &Drag<2>) -> SpringMotion<2> {
        let &MountedStep { supports, history, c, mass, inertia, fluid, weight, predicted } = step;
        let own = Mass { mass, inertia, arm: Vector2::zeros() };
        let (mass, gyroscopic) = (own.matrix(), own.gyroscopic(&predicted));
        SpringStep { supports, history, c, mass, gyroscopic, fluid, weight, predicted }.solve(drag)
    }
}

impl SpringDynamics<3> for [f64; 3] {
    fn solve(step: &MountedStep<3>, drag: &Drag<3>) -> SpringMotion<3> {
        let &MountedStep { supports, history, c, mass, inertia, ref fluid, ref weight, ref predicted } = step;
        let still = Vector3::zeros();
        let mut body = Body::new(BodyParameters {
            mass,
            inertia: inertia.into(),
            centre: still,
            supports: *supports,
            gravity: still,
            position: still,
        });
        let [now, before] = [history.now, history.before].map(|Pose { position, angle, velocity, omega }| Placed {
            position,
            orientation: UnitQuaternion::from_scaled_axis(angle),
            velocity,
            omega,
        });
        let [h, last_step] = steps(&c);
        body.state = BodyState { now, before, acceleration: history.acceleration, last_step };
        let matrix = body.step_by(&c, h, history, drag, fluid, weight);
        let mut displacement = body.state.now.displacement(&still);
        displacement.angle = nearest(displacement.angle, &history.now.angle);
        SpringMotion { matrix, ..SpringMotion::given(displacement, c, history, fluid, predicted) }
    }
}

/// Return the step and the last one (s; 0 if there was none) that have the backward differences `c`.
fn steps(&[c_0, c_1, c_2]: &[f64; 3]) -> [f64; 2] {
    if c_2 == 0.0 {
        return [1.0 / c_0, 0.0];
    }
    let ratio = (-c_1 / c_2).sqrt() - 1.0;
    let h = 1.0 / (c_0 + c_2 * ratio);
    [h, h * ratio]
}
