//! Everything that the next step depends on, as data.

use line_fft::{Pack, Real};
use serde::{Deserialize, Serialize};

use crate::bodies::{Carried, Stations};
use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::force::BodyForce;
use crate::present::{Beams, Present};

/// A state of a fluid. It fits every fluid with the same parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State(ByPrecision);

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum ByPrecision {
    Double(SolverState<f64>),
    Single(SolverState<f32>),
}

/// A state in one precision: the present time with its flow, and the memory of the scheme.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct SolverState<R: Real> {
    time: f64,
    step: f64,
    pub flow: Flow<R>,
    advection_rate: f64,
    bodies: Vec<BodyForce>,
    carried: Vec<Carried>,
    beams: Beams,
    pub memory: Memory<R>,
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

/// Memory of the two-step scheme.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct TwoStep<R: Real> {
    /// Flow one step earlier.
    pub before: Flow<R>,
    /// `w = u* + tau G` of the last step, m/s, `[nx, ny]` per component.
    pub w: [Field<R>; 2],
    /// `1/tau` of the last step, 1/s, so that `G = (w − u)/tau`; 0 before the first, where G is 0.
    pub inv_tau: f64,
}

/// The two precisions of a [`State`].
pub trait Stored: Real {
    /// Wrap a state.
    fn wrap(state: SolverState<Self>) -> State;
    /// Return the state of this precision.
    fn of(state: &State) -> Result<&SolverState<Self>, Error>;
    /// Return the state of this precision, to be written to.
    fn of_mut(state: &mut State) -> Result<&mut SolverState<Self>, Error>;
}

macro_rules! stored {
    ($real:ty, $own:ident, $own_name:literal, $other:ident, $other_name:literal) => {
        impl Stored for $real {
            fn wrap(state: SolverState<Self>) -> State {
                State(ByPrecision::$own(state))
            }

            fn of(state: &State) -> Result<&SolverState<Self>, Error> {
                match &state.0 {
                    ByPrecision::$own(state) => Ok(state),
                    ByPrecision::$other(_) => Err(Error::Precision { state: $other_name, own: $own_name }),
                }
            }

            fn of_mut(state: &mut State) -> Result<&mut SolverState<Self>, Error> {
                match &mut state.0 {
                    ByPrecision::$own(state) => Ok(state),
                    ByPrecision::$other(_) => Err(Error::Precision { state: $other_name, own: $own_name }),
                }
            }
        }
    };
}

stored!(f64, Double, "double", Single, "single");
stored!(f32, Single, "single", Double, "double");

impl<R: Real> SolverState<R> {
    /// Copy the present time, its flow and the memory of the scheme.
    pub fn new(present: &Present, flow: &Flow<R>, memory: Memory<R>) -> Self {
        let Present { time, step, advection_rate, bodies, carried, beams } = present.clone();
        Self { time, step, flow: flow.clone(), advection_rate, bodies, carried, beams, memory }
    }

    /// Overwrite all but the memory of the scheme; allocates nothing.
    pub fn save(&mut self, present: &Present, flow: &Flow<R>) {
        (self.time, self.step, self.advection_rate) = (present.time, present.step, present.advection_rate);
        self.flow.copy_from(flow);
        self.bodies.copy_from_slice(&present.bodies);
        self.carried.copy_from_slice(&present.carried);
        self.beams.copy_from(&present.beams);
    }

    /// Write all but the memory of the scheme to `present` and `flow`; allocates nothing.
    pub fn restore(&self, present: &mut Present, flow: &mut Flow<R>) {
        (present.time, present.step, present.advection_rate) = (self.time, self.step, self.advection_rate);
        flow.copy_from(&self.flow);
        present.bodies.copy_from_slice(&self.bodies);
        present.carried.copy_from_slice(&self.carried);
        present.beams.copy_from(&self.beams);
    }

    /// Return the stations, or the first part that differs in size from `own`, or is a number and not finite.
    /// `memory_fits`: the memory is of the scheme and size of this fluid.
    pub fn check(&self, own: &Present, flow: &Flow<R>, memory_fits: bool) -> Result<&[Stations], Error> {
        let numbers = [self.time, self.step, self.advection_rate];
        let parts = [
            ("the time or a step", numbers.iter().all(|number| number.is_finite())),
            ("a field", self.flow.has_shape_of(flow) && memory_fits),
            ("the list of bodies", self.bodies.len() == own.bodies.len() && self.carried.len() == own.carried.len()),
            ("the place of a body", self.carried.iter().all(Carried::is_finite)),
            ("the list of beams", self.beams.have_shape_of(&own.beams)),
        ];
        match parts.into_iter().find(|(_, fits)| !fits) {
            Some((part, _)) => Err(Error::State(part)),
            None => Ok(&self.beams.stations),
        }
    }
}

impl<R: Real> TwoStep<R> {
    /// Copy `other`, which has the same size; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.before.copy_from(&other.before);
        self.w.iter_mut().zip(&other.w).for_each(|(own, other)| own.copy_from_slice(other));
        self.inv_tau = other.inv_tau;
    }

    /// Return whether `other` has the same size.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let lengths = |w: &[Field<R>; 2]| w.each_ref().map(|w| w.len());
        self.before.has_shape_of(&other.before) && lengths(&self.w) == lengths(&other.w)
    }
}
