//! Contact of the bodies on a mount with each other, with other bodies, and with walls.

use ::contact::{BodyContacts, BodyError, Obstacle, Part, PartMotion, Pose};

use super::pose::pose_at;
use super::rigid::Rigid;
use crate::bodies::DisplacementHistory;
use crate::error::Error;
use crate::parameters::{Body, Contact, Parameters};
use crate::space::{Freedoms, Kinematics, Space, Vector};

/// Contact of the bodies in a fluid: its parts are the rigid bodies, other obstacles, and walls.
pub struct Contacts<const D: usize>
where
    [f64; D]: Space<D>,
{
    solver: BodyContacts<D>,
    /// Obstacles that the fluid does not see.
    obstacles: Vec<Body<D>>,
    rigid: usize,
}

/// Equations of a body that is held.
const HELD: [Freedoms; 6] = {
    let (mut identity, mut i) = ([[0.0; 6]; 6], 0);
    while i < 6 {
        identity[i][i] = 1.0;
        i += 1;
    }
    identity
};

impl<const D: usize> Contacts<D>
where
    [f64; D]: Space<D>,
{
    /// Return the contact of the bodies on a mount; none without such a body.
    ///
    /// # Errors
    /// [`BodyError::Touch`] for bodies that cannot touch.
    pub fn new(parameters: &Parameters<D>) -> Result<Option<Self>, Error> {
        let Some(Contact { law, obstacles, walls, periods, carrier, .. }) = &parameters.contact else {
            return Ok(None);
        };
        if !parameters.bodies.iter().any(|body| body.mount().is_some()) {
            return Ok(None);
        }
        let (bodies, size) = (&parameters.bodies, parameters.grid().size);
        let mut parts = Vec::new();
        for body in bodies.iter().chain(obstacles) {
            let name = || BodyError::Touch([body.name.clone(), "anything".into()]);
            let solid = body.shape.obstacle().ok_or_else(name)?;
            let mut motion = PartMotion::still(place(body, &pose_at(body, 0.0)));
            let inertia = if let Some(mount) = body.mount() {
                motion.free = mount.free();
                let displaced = parameters.density * body.shape.moments(&size).volume;
                let [mass, moment] = mount.least_inertia();
                // A light body is as slow as the fluid that it displaces.
                Some([mass.max(displaced), moment])
            } else {
                None
            };
            parts.push(Part { solid, inertia, pivot: body.pivot.into(), motion });
        }
        for (axis, ends) in walls.iter().enumerate().filter_map(|(axis, ends)| Some((axis, (*ends)?))) {
            let along = |size: f64| std::array::from_fn(|d| if d == axis { size } else { 0.0 });
            for (end, side) in ends.into_iter().zip([1.0, -1.0]) {
                let solid = Obstacle::plane(along(end), along(side));
                let motion = PartMotion::still(solid.pose);
                parts.push(Part { solid, inertia: None, pivot: Vector::zeros(), motion });
            }
        }
        let names = bodies.iter().chain(obstacles).map(|own| &own.name);
        let solver = BodyContacts::new(parts, law).map_err(|pair| BodyError::Touch(BodyError::names(pair, names)))?;
        // A body that another unit moves feels only what is announced.
        let is_announced = |k: &usize| carrier.is_some() && bodies.get(*k).is_some_and(|body| body.announces);
        let solver = solver.without(|pair| pair.iter().any(is_announced)).with_periods(*periods);
        Ok(Some(Self { solver, obstacles: obstacles.clone(), rigid: bodies.len() }))
    }

    /// Return the changes of the velocities by the contact in a step between two times (s) with the first coefficient
    /// `c_0` of the differences, by rigid body; none where nothing touches.
    ///
    /// # Errors
    /// [`BodyError::Deep`].
    pub fn solve(
        &mut self,
        c_0: f64,
        times: [f64; 2],
        rigid: &[Rigid<D>],
        histories: &[DisplacementHistory<D>],
    ) -> Result<Option<&[Freedoms]>, Error> {
        let Self { solver, obstacles, rigid: count } = self;
        let mut histories = histories.iter();
        for (k, own) in rigid.iter().enumerate() {
            let motion = solver.motion_mut(k);
            let body = own.body();
            let before = match histories.as_slice().first().filter(|_| own.is_carried()) {
                Some(known) => {
                    histories.next();
                    own.pose_of(&known.now)
                }
                None => pose_at(body, times[0]),
            };
            let (mut now, mut matrix) = (own.pose, HELD);
            if let Some(found) = &own.spring_motion {
                (now, matrix) = (own.pose_of(&found.displacement), found.matrix);
            }
            let poses = [before, now].map(|pose| place(body, &pose));
            let free = own.mount().map(|mount| mount.free()).unwrap_or_default();
            *motion = PartMotion { poses, rates: now.rates(), matrix, free };
        }
        for (k, body) in obstacles.iter().enumerate() {
            let poses = times.map(|t| pose_at(body, t));
            let motion = solver.motion_mut(*count + k);
            *motion = PartMotion { poses: poses.map(|pose| place(body, &pose)), rates: poses[1].rates(), ..*motion };
        }
        solver.solve(c_0, times[1] - times[0]).map_err(|pair| {
            let names = rigid.iter().map(|own| &own.body().name).chain(obstacles.iter().map(|own| &own.name));
            BodyError::Deep { time: times[1], bodies: BodyError::names(pair, names) }.into()
        })
    }
}

/// Return the place of the shape of a body.
pub fn place<const D: usize>(body: &Body<D>, pose: &super::Pose<D>) -> Pose<D>
where
    [f64; D]: Space<D>,
{
    let orientation = <[f64; D]>::orientation(&body.turn, pose.angle);
    let unit = |axis: usize| Vector::from_fn(|d, _| f64::from(u8::from(d == axis)));
    let axes = std::array::from_fn(|axis| <[f64; D]>::turn(&orientation, unit(axis)));
    Pose { axes, origin: pose.position - <[f64; D]>::turn(&orientation, body.pivot.into()) }
}
