//! Prescribed motion of the root.

use crate::Error;
use crate::vector::Vector;

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
pub(crate) struct BaseState<const D: usize> {
    pub(crate) position: Vector<D>,
    pub(crate) velocity: Vector<D>,
    pub(crate) direction: Vector<D>,
    /// Rate of the unit tangent, at right angles to it.
    pub(crate) direction_rate: Vector<D>,
}

impl<const D: usize> BaseMotion<D> {
    /// Return the motion with a unit tangent; refuse numbers that are not finite and a direction of no length.
    pub(crate) fn normalised(&self) -> Result<BaseState<D>, Error> {
        for (name, vector) in [
            ("position", self.position),
            ("velocity", self.velocity),
            ("direction", self.direction),
            ("direction_rate", self.direction_rate),
        ] {
            if vector.iter().any(|c| !c.is_finite()) {
                return Err(Error::value(format!("base_motion.{name}"), &vector[..], "finite"));
            }
        }
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
    /// Interpolate at the fraction `s` of the way to `end`, `duration` seconds later, by the cubic through both ends.
    pub(crate) fn towards(&self, end: &Self, s: f64, duration: f64) -> Self {
        if s == 1.0 {
            return *end;
        }
        let (position, velocity) = hermite((self.position, self.velocity), (end.position, end.velocity), s, duration);
        let (direction, rate) =
            hermite((self.direction, self.direction_rate), (end.direction, end.direction_rate), s, duration);
        let (direction, direction_rate) = unit(direction, rate);
        Self { position, velocity, direction, direction_rate }
    }
}

/// Return the unit vector along `vector`, and its rate.
fn unit<const D: usize>(vector: Vector<D>, rate: Vector<D>) -> (Vector<D>, Vector<D>) {
    let norm = vector.norm();
    let direction = vector / norm;
    (direction, (rate - direction * direction.dot(&rate)) / norm)
}

/// Return value and rate of the cubic that has these values and rates at its ends.
fn hermite<const D: usize>(
    (p0, v0): (Vector<D>, Vector<D>),
    (p1, v1): (Vector<D>, Vector<D>),
    s: f64,
    duration: f64,
) -> (Vector<D>, Vector<D>) {
    let (m0, m1) = (v0 * duration, v1 * duration);
    let (square, cube) = ((p1 - p0) * 3.0 - m0 * 2.0 - m1, (p0 - p1) * 2.0 + m0 + m1);
    (p0 + (m0 + (square + cube * s) * s) * s, (m0 + (square * 2.0 + cube * (3.0 * s)) * s) / duration)
}
