//! The stations of a beam, where its motion comes in and its loads go out.

use scene::Scene;
use serde::{Deserialize, Serialize};

/// Positions and velocities of the stations, root to tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stations {
    /// Positions, m, per axis.
    pub position: [Vec<f64>; 2],
    /// Velocities, m/s, per axis.
    pub velocity: [Vec<f64>; 2],
}

/// Loads on the stations, root to tip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Loads {
    /// Force on each station, N per metre of depth, per axis.
    pub force: [Vec<f64>; 2],
    /// Rate at which the force falls with the station's velocity, kg/(m s).
    pub impedance: Vec<f64>,
}

impl Stations {
    /// Stations of one of a scene's beams at rest.
    pub(crate) fn at_rest(scene: &Scene, beam: &scene::Beam) -> Self {
        let rest = scene.beam_stations(beam);
        let component = |axis: usize| rest.iter().map(|p| p[axis]).collect::<Vec<_>>();
        let zero = vec![0.0; rest.len()];
        Self { position: [component(0), component(1)], velocity: [zero.clone(), zero] }
    }

    /// Number of stations.
    pub fn len(&self) -> usize {
        self.position[0].len()
    }

    /// Whether there is no station.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Become `other`, which has as many stations; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        for axis in 0..2 {
            self.position[axis].copy_from_slice(&other.position[axis]);
            self.velocity[axis].copy_from_slice(&other.velocity[axis]);
        }
    }

    /// Become where `from` gets to in `h` seconds with the velocities it has.
    pub(crate) fn go_on(&mut self, from: &Self, h: f64) {
        self.copy_from(from);
        for (position, velocity) in self.position.iter_mut().zip(&from.velocity) {
            position.iter_mut().zip(velocity).for_each(|(p, v)| *p += h * v);
        }
    }

    /// Let each of `all` become the one of `others` in the same place; unlike `clone_from` this allocates nothing.
    pub(crate) fn copy_all(all: &mut [Self], others: &[Self]) {
        all.iter_mut().zip(others).for_each(|(own, other)| own.copy_from(other));
    }

    /// Whether there are as many stations as in `other`.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let lengths = |s: &Self| [&s.position, &s.velocity].map(|axes| axes.each_ref().map(Vec::len));
        lengths(self) == lengths(other)
    }

    /// Become what lies the fraction `s` of the way from `a` to `b`, which are `h` seconds apart: velocity linear,
    /// position the cubic that has the positions and velocities of both ends.
    pub(crate) fn interpolate(&mut self, a: &Self, b: &Self, s: f64, h: f64) {
        for axis in 0..2 {
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

impl Loads {
    /// No load on `n` stations.
    pub(crate) fn none(n: usize) -> Self {
        Self { force: [vec![0.0; n], vec![0.0; n]], impedance: vec![0.0; n] }
    }

    /// Become `other`, which is for as many stations; unlike `clone_from` this allocates nothing.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        (0..2).for_each(|axis| self.force[axis].copy_from_slice(&other.force[axis]));
        self.impedance.copy_from_slice(&other.impedance);
    }

    /// Whether all are finite.
    pub(crate) fn are_finite(&self) -> bool {
        let [x, y] = &self.force;
        [x, y, &self.impedance].iter().all(|loads| loads.iter().all(|load| load.is_finite()))
    }

    /// Whether they are for as many stations as `other`.
    pub(crate) fn has_shape_of(&self, other: &Self) -> bool {
        let lengths = |l: &Self| (l.force.each_ref().map(Vec::len), l.impedance.len());
        lengths(self) == lengths(other)
    }
}
