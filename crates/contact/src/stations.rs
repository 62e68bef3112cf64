//! The stations of a beam or the nodes of a wing: units exchange their motion and their loads.

use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use rigid::Vector;

/// Positions and velocities of the stations, root to tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stations<const D: usize = 2> {
    /// Positions, m, per axis.
    #[serde(with = "BigArray")]
    pub position: [Vec<f64>; D],
    /// Velocities, m/s, per axis.
    #[serde(with = "BigArray")]
    pub velocity: [Vec<f64>; D],
}

/// Loads on the stations, root to tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Loads<const D: usize = 2> {
    /// Force on each station, N, in two dimensions per metre of depth, per axis.
    #[serde(with = "BigArray")]
    pub force: [Vec<f64>; D],
    /// Rate at which the force decreases with the velocity of the station, kg/s, in two dimensions per metre
    /// of depth.
    pub impedance: Vec<f64>,
}

impl<const D: usize> Stations<D> {
    /// Stations at rest at some positions, m.
    pub fn at_rest(rest: &[[f64; D]]) -> Self {
        let component = |axis: usize| rest.iter().map(|p| p[axis]).collect::<Vec<_>>();
        let zeros = |_| vec![0.0; rest.len()];
        Self { position: std::array::from_fn(component), velocity: std::array::from_fn(zeros) }
    }

    /// Return their mean position, m.
    pub fn middle(&self) -> Vector<D> {
        self.position.each_ref().map(|all| all.iter().sum::<f64>() / all.len() as f64).into()
    }

    /// Return the number of stations.
    pub fn len(&self) -> usize {
        self.position[0].len()
    }

    /// Return whether there is no station.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Copy `other`, which has as many stations; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        for axis in 0..D {
            self.position[axis].copy_from_slice(&other.position[axis]);
            self.velocity[axis].copy_from_slice(&other.velocity[axis]);
        }
    }

    /// Become the stations that `from` reaches in `h` seconds with constant velocities.
    pub fn extrapolate(&mut self, from: &Self, h: f64) {
        self.copy_from(from);
        for (position, velocity) in self.position.iter_mut().zip(&from.velocity) {
            position.iter_mut().zip(velocity).for_each(|(p, v)| *p += h * v);
        }
    }

    /// Copy each of `others` to the element of `all` with the same index; allocates nothing.
    pub fn copy_all(all: &mut [Self], others: &[Self]) {
        all.iter_mut().zip(others).for_each(|(own, other)| own.copy_from(other));
    }

    /// Return whether `other` has as many stations.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let lengths = |s: &Self| [&s.position, &s.velocity].map(|axes| axes.each_ref().map(Vec::len));
        lengths(self) == lengths(other)
    }

    /// Become the stations at the fraction `s` of the time from `a` to `b`, which are `h` seconds apart: the velocity
    /// is linear, the position is the cubic with the positions and velocities of both ends.
    pub fn interpolate(&mut self, a: &Self, b: &Self, s: f64, h: f64) {
        for axis in 0..D {
            for k in 0..self.len() {
                let (p0, p1) = (a.position[axis][k], b.position[axis][k]);
                let (v0, v1) = (a.velocity[axis][k], b.velocity[axis][k]);
                self.velocity[axis][k] = v0 + s * (v1 - v0);
                let (m0, m1) = (h * v0, h * v1);
                self.position[axis][k] =
                    p0 + s * (m0 + s * (3.0 * (p1 - p0) - 2.0 * m0 - m1 + s * (2.0 * (p0 - p1) + m0 + m1)));
            }
        }
    }
}

impl<const D: usize> Loads<D> {
    /// Loads of zero on `n` stations.
    pub fn none(n: usize) -> Self {
        Self { force: std::array::from_fn(|_| vec![0.0; n]), impedance: vec![0.0; n] }
    }

    /// Copy `other`, which is for as many stations; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        (0..D).for_each(|axis| self.force[axis].copy_from_slice(&other.force[axis]));
        self.impedance.copy_from_slice(&other.impedance);
    }

    /// Return their sum in a step between these stations, N: each force falls with the change of the velocity.
    pub fn force_in_step(&self, before: &Stations<D>, now: &Stations<D>) -> [f64; D] {
        std::array::from_fn(|axis| {
            let parts = self.force[axis].iter().zip(&self.impedance);
            let velocities = before.velocity[axis].iter().zip(&now.velocity[axis]);
            parts.zip(velocities).map(|((force, rate), (v_0, v))| force - rate * (v - v_0)).sum()
        })
    }

    /// Return the power of these forces in a step between these stations, at its end, W.
    pub fn power(&self, before: &Stations<D>, now: &Stations<D>) -> f64 {
        let power = |axis: usize| {
            let parts = self.force[axis].iter().zip(&self.impedance);
            let velocities = before.velocity[axis].iter().zip(&now.velocity[axis]);
            parts.zip(velocities).map(|((force, rate), (v_0, v))| (force - rate * (v - v_0)) * v).sum::<f64>()
        };
        (0..D).map(power).sum()
    }

    /// Return whether all are finite.
    pub fn are_finite(&self) -> bool {
        self.force.iter().chain([&self.impedance]).flatten().all(|load| load.is_finite())
    }

    /// Return whether `other` is for as many stations.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let lengths = |l: &Self| (l.force.each_ref().map(Vec::len), l.impedance.len());
        lengths(self) == lengths(other)
    }
}
