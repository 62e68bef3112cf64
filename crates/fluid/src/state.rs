//! Everything that the next step depends on, as data.

use serde::{Deserialize, Serialize};

use crate::bodies::{Loads, Stations};
use crate::field::Field;
use crate::force::{BodyForce, Exchange};
use crate::precision::ByPrecision;
use line_fft::Pack;
use line_fft::Real;

/// A state of a fluid, to go back to. It fits every fluid of the same scene. It is of the precision of its fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State(pub(crate) ByPrecision<StateIn<f64>, StateIn<f32>>);

/// A state in one precision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct StateIn<R: Real> {
    pub present: Present<R>,
    pub memory: Memory<R>,
}

/// What there is at the present time, whatever the time scheme.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Present<R: Real> {
    /// Time, s.
    pub time: f64,
    /// The last step, s; 0 before the first.
    pub step: f64,
    /// The flow.
    pub flow: Flow<R>,
    /// Largest `|u|/dx + |v|/dy`, 1/s.
    pub advection_rate: f64,
    /// The cylinders and the other rigid bodies, then the beams.
    pub bodies: Vec<BodyForce>,
    /// The beams.
    pub beams: Beams,
}

/// What a time scheme remembers of earlier steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Memory<R: Real> {
    /// Two-step backward differences.
    Sbdf2(TwoStep<R>),
    /// Heun's method: spectrum of the velocity, m/s, `[ny/2 + 1, nx]` per component.
    Rk2([Vec<Pack<R>>; 2]),
}

/// What the two-step scheme remembers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct TwoStep<R: Real> {
    /// The flow one step earlier.
    pub before: Flow<R>,
    /// `w = u* + tau G` of the last step, m/s, `[nx, ny]` per component.
    pub w: [Field<R>; 2],
    /// `1/tau` of the last step, 1/s, so that `G = (w − u)/tau`; 0 before the first, where G is 0.
    pub per_tau: f64,
}

/// Fields of one time, `[nx, ny]` each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Flow<R: Real> {
    /// Velocity, m/s, per component.
    pub velocity: [Field<R>; 2],
    /// Vorticity, 1/s.
    pub vorticity: Field<R>,
}

/// The beams as the fluid last saw them; every list is empty without one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beams {
    /// Where they are.
    pub stations: Vec<Stations>,
    /// Loads for the coming step; empty where the scene uses the pressure jump.
    pub loads: Vec<Loads>,
    /// What the fluid did to them.
    pub exchange: Vec<Exchange>,
}

impl<R: Real> StateIn<R> {
    /// The first part that a state `own` of the same scene would have otherwise: in another size, or, of the numbers
    /// that are not fields, not finite. `memory_fits`: it is of the scheme and size of that scene.
    pub fn misfit(&self, own: &Present<R>, memory_fits: bool) -> Option<&'static str> {
        let present = &self.present;
        let numbers = [present.time, present.step, present.advection_rate];
        [
            ("the time or a step", numbers.iter().all(|number| number.is_finite())),
            ("a field", present.flow.lengths() == own.flow.lengths() && memory_fits),
            ("the list of bodies", present.bodies.len() == own.bodies.len()),
            ("the list of beams", present.beams.have_shape_of(&own.beams)),
        ]
        .into_iter()
        .find_map(|(part, fits)| (!fits).then_some(part))
    }
}

impl<R: Real> Present<R> {
    /// Become `other`, which is of the same scene; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        (self.time, self.step, self.advection_rate) = (other.time, other.step, other.advection_rate);
        self.flow.copy_from(&other.flow);
        self.bodies.copy_from_slice(&other.bodies);
        Stations::copy_all(&mut self.beams.stations, &other.beams.stations);
        self.beams.loads.iter_mut().zip(&other.beams.loads).for_each(|(own, other)| own.copy_from(other));
        self.beams.exchange.copy_from_slice(&other.beams.exchange);
    }
}

impl<R: Real> TwoStep<R> {
    /// Become `other`, which is as large; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.before.copy_from(&other.before);
        (0..2).for_each(|axis| self.w[axis].copy_from_slice(&other.w[axis]));
        self.per_tau = other.per_tau;
    }

    /// Whether it is as large as `other`.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let lengths = |w: &[Field<R>; 2]| w.each_ref().map(|w| w.len());
        self.before.lengths() == other.before.lengths() && lengths(&self.w) == lengths(&other.w)
    }
}

impl<R: Real> Flow<R> {
    /// A uniform flow (m/s) at `n` points.
    pub fn uniform(velocity: [f64; 2], n: usize) -> Self {
        Self { velocity: velocity.map(|u| Field::uniform(R::rounded(u), n)), vorticity: Field::uniform(R::zero(), n) }
    }

    /// Become `other`, which is as large; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        (0..2).for_each(|axis| self.velocity[axis].copy_from_slice(&other.velocity[axis]));
        self.vorticity.copy_from_slice(&other.vorticity);
    }

    fn lengths(&self) -> [usize; 3] {
        [&self.velocity[0], &self.velocity[1], &self.vorticity].map(|field| field.len())
    }
}

impl Beams {
    fn have_shape_of(&self, other: &Self) -> bool {
        let lengths = |beams: &Self| [beams.stations.len(), beams.loads.len(), beams.exchange.len()];
        lengths(self) == lengths(other)
            && self.stations.iter().zip(&other.stations).all(|(a, b)| a.has_shape_of(b))
            && self.loads.iter().zip(&other.loads).all(|(a, b)| a.has_shape_of(b))
    }
}
