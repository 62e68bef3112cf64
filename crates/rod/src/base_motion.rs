//! Prescribed motion of the root.

use structure::{Vector, cubic};

use crate::{Error, RodState};

/// Pose and motion of a driven root at the end of the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseMotion<const D: usize> {
    /// Position of node 0, m.
    pub position: [f64; D],
    /// Velocity of node 0, m/s.
    pub velocity: [f64; D],
    /// Direction of the rod at the root, of any length but 0.
    pub direction: [f64; D],
    /// Rate of the direction, 1/s, in units of the direction's length.
    pub direction_rate: [f64; D],
}

/// Position and unit tangent at the root with their rates.
#[derive(Clone, Copy)]
pub struct BaseState<const D: usize> {
    pub(crate) position: Vector<D>,
    pub(crate) velocity: Vector<D>,
    pub(crate) direction: Vector<D>,
    /// Rate of the unit tangent, at right angles to it.
    pub(crate) direction_rate: Vector<D>,
}

impl<const D: usize> BaseMotion<D> {
    /// Return the motion with a unit tangent; refuse numbers that are not finite and a direction of no length.
    pub(crate) fn normalised(&self) -> Result<BaseState<D>, Error> {
        structure::finite("base_motion.position", &self.position)?;
        structure::finite("base_motion.velocity", &self.velocity)?;
        structure::finite("base_motion.direction", &self.direction)?;
        structure::finite("base_motion.direction_rate", &self.direction_rate)?;
        let direction = Vector::from(self.direction);
        if !direction.norm().is_normal() {
            let allowed = "a vector of any length but 0";
            return Err(Error::value("base_motion.direction", &self.direction[..], allowed));
        }
        let (direction, direction_rate) = unit(direction, self.direction_rate.into());
        Ok(BaseState { position: self.position.into(), velocity: self.velocity.into(), direction, direction_rate })
    }
}

impl<const D: usize> BaseState<D> {
    /// Return the root of a rod in `state`.
    pub(crate) fn of(state: &RodState<D>) -> Self {
        let (position, velocity) = (state.positions[0], state.velocities[0]);
        Self { position, velocity, direction: state.own.direction, direction_rate: state.own.direction_rate }
    }

    /// Give the root of a rod in `state` this state.
    pub(crate) fn copy_to(&self, state: &mut RodState<D>) {
        (state.positions[0], state.velocities[0]) = (self.position, self.velocity);
        (state.own.direction, state.own.direction_rate) = (self.direction, self.direction_rate);
    }

    /// Interpolate at the fraction `s` of the way to `end`, `duration` seconds later, by the cubic through both ends.
    pub(crate) fn towards(&self, end: &Self, s: f64, duration: f64) -> Self {
        if s == 1.0 {
            return *end;
        }
        let [position, velocity, _] = cubic((self.position, self.velocity), (end.position, end.velocity), s, duration);
        let ends = [self, end].map(|base| (base.direction, base.direction_rate));
        let [direction, rate, _] = cubic(ends[0], ends[1], s, duration);
        let (direction, direction_rate) = unit(direction, rate);
        Self { position, velocity, direction, direction_rate }
    }

    /// Return position, velocity and acceleration of node 0 at the end of the cubic over `dt`, s, from `before`.
    pub(crate) fn of_node(&self, before: &Self, dt: f64) -> [Vector<D>; 3] {
        let (x, v) = (self.position, self.velocity);
        [x, v, (before.position - x) * (6.0 / (dt * dt)) + (before.velocity * 2.0 + v * 4.0) / dt]
    }
}

/// Return the unit vector along `vector`, and its rate.
fn unit<const D: usize>(vector: Vector<D>, rate: Vector<D>) -> (Vector<D>, Vector<D>) {
    let norm = vector.norm();
    let direction = vector / norm;
    (direction, (rate - direction * direction.dot(&rate)) / norm)
}
