//! The clamp in prescribed motion.

use crate::Error;
use crate::elastic::Vector;

/// Where the clamp is, at the end of the next step, and how it moves then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root<const D: usize> {
    /// Position of node 0, m.
    pub position: [f64; D],
    /// Its velocity, m/s.
    pub velocity: [f64; D],
    /// Direction of the rod at the clamp; any length but 0.
    pub direction: [f64; D],
    /// Rate of the direction, 1/s, in units of the direction's length.
    pub direction_rate: [f64; D],
}

/// The same with a direction of length 1 and its rate across it.
#[derive(Clone, Copy)]
pub(crate) struct Clamp<const D: usize> {
    pub(crate) position: Vector<D>,
    pub(crate) velocity: Vector<D>,
    pub(crate) direction: Vector<D>,
    pub(crate) direction_rate: Vector<D>,
}

impl<const D: usize> Root<D> {
    /// Refuses numbers that are not finite and a direction without length.
    pub(crate) fn clamp(&self) -> Result<Clamp<D>, Error> {
        for (name, vector) in [
            ("position", self.position),
            ("velocity", self.velocity),
            ("direction", self.direction),
            ("direction_rate", self.direction_rate),
        ] {
            if vector.iter().any(|c| !c.is_finite()) {
                return Err(Error::value(format!("root.{name}"), &vector[..], "finite"));
            }
        }
        let direction = Vector::from(self.direction);
        if !direction.norm().is_normal() {
            return Err(Error::value(
                "root.direction",
                format!("{:?}", self.direction),
                "a vector of any length but 0",
            ));
        }
        let (direction, direction_rate) = unit(direction, self.direction_rate.into());
        Ok(Clamp { position: self.position.into(), velocity: self.velocity.into(), direction, direction_rate })
    }
}

impl<const D: usize> Clamp<D> {
    /// At the fraction `s` of the way to `end`, which is `duration` seconds later: the cubic that has the positions and
    /// rates of both ends.
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

/// a × b, in two dimensions with only the last component.
pub(crate) fn cross<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> [f64; 3] {
    let component = |i: usize, j: usize| if i < D && j < D { a[i] * b[j] - a[j] * b[i] } else { 0.0 };
    [component(1, 2), component(2, 0), component(0, 1)]
}

/// `vector` with length 1 and the rate that this has.
fn unit<const D: usize>(vector: Vector<D>, rate: Vector<D>) -> (Vector<D>, Vector<D>) {
    let norm = vector.norm();
    let direction = vector / norm;
    (direction, (rate - direction * direction.dot(&rate)) / norm)
}

/// Value and rate of the cubic between two values with their rates.
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
