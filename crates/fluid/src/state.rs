//! Everything that the next step depends on, as data.

use std::borrow::Cow;

use line_fft::{Pack, Real};
use serde::{Deserialize, Serialize};
use serde_big_array::BigArray;

use crate::error::Error;
use crate::field::Field;
use crate::flow::Flow;
use crate::present::Present;
use crate::space::Space;

/// A state of a fluid. It fits every fluid with the same parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<const D: usize = 2>
where
    [f64; D]: Space<D>,
{
    pub(crate) present: Present<D>,
    pub(crate) fields: ByPrecision<D>,
}

/// The flow and the memory of the scheme in one of the precisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ByPrecision<const D: usize> {
    /// `f64`.
    Double(Fields<f64, D>),
    /// `f32`.
    Single(Fields<f32, D>),
}

/// The flow and the memory of the scheme.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Fields<R: Real, const D: usize> {
    /// The present flow.
    pub flow: Flow<R, D>,
    /// What the scheme remembers.
    pub memory: Memory<R, D>,
}

/// What a time scheme remembers of earlier steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Memory<R: Real, const D: usize> {
    /// Two-step backward differences.
    Sbdf2(TwoStep<R, D>),
    /// The same on two grids.
    TwoGrids(Box<TwoGridsMemory<R, D>>),
    /// Heun's method: spectrum of the velocity, m/s, `[ny/2 + 1, nx]` per component.
    Rk2(#[serde(with = "BigArray")] [Vec<Pack<R>>; D]),
}

/// Memory of the two-step scheme.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct TwoStep<R: Real, const D: usize> {
    /// Flow one step earlier.
    pub before: Flow<R, D>,
    /// Flow two steps earlier.
    pub earlier: Flow<R, D>,
    /// `w = u* + tau G` of the last step, m/s, per component.
    #[serde(with = "BigArray")]
    pub w: [Field<R>; D],
    /// `1/tau` of the last step, 1/s, so that `G = (w − u)/tau`; 0 before the first, where G is 0.
    pub inv_tau: f64,
    /// The step before the last one, s; 0 if there was none.
    pub step_before: f64,
}

/// Memory of the two-step scheme on two grids.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct TwoGridsMemory<R: Real, const D: usize> {
    /// Memory of the fine flow.
    pub fine: TwoStep<R, D>,
    /// The coarse flow.
    pub coarse: CoarseState<R, D>,
}

/// The coarse flow with its memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct CoarseState<R: Real, const D: usize> {
    /// The flow.
    pub flow: Flow<R, D>,
    /// Memory of its scheme.
    pub memory: Memory<R, D>,
    /// What the grids exchange.
    pub link: Link,
}

/// What two grids exchange, at the coarse points under the fine box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// The coarse flow before and after its last step, as coefficients: velocity, vorticity, and G.
    pub ends: [Vec<f64>; 2],
    /// Restriction of the force on the fine fluid since the last coarse step, over the density, times the time, m/s.
    pub impulse: Vec<f64>,
    /// That time, s.
    pub elapsed: f64,
    /// Force on the coarse fluid in the last step, over the density, m/s².
    pub force: Vec<f64>,
    /// Time from the fine flow to the coarse one, s.
    pub ahead: f64,
    /// Last coarse step, s, and the one before the next step; 0 before the first.
    pub length: f64,
    pub step: f64,
    /// Advection rate of the coarse flow, 1/s.
    pub advection_rate: f64,
    /// Coarse cells by which the fine box has moved along each axis.
    pub moved: Vec<i32>,
}

impl Link {
    fn lists(&self) -> [&Vec<f64>; 4] {
        let [from, to] = &self.ends;
        [from, to, &self.impulse, &self.force]
    }

    /// Copy `other`, which has the same size; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        let [from, to] = &mut self.ends;
        let own = [from, to, &mut self.impulse, &mut self.force];
        own.into_iter().zip(other.lists()).for_each(|(own, other)| own.copy_from_slice(other));
        let Self { elapsed, ahead, length, step, advection_rate, .. } = *other;
        (self.elapsed, self.ahead, self.length) = (elapsed, ahead, length);
        (self.step, self.advection_rate) = (step, advection_rate);
        self.moved.copy_from_slice(&other.moved);
    }

    /// Return whether `other` has the same size, and its times are finite.
    pub fn has_shape_of(&self, other: &Self) -> bool {
        let numbers = [other.elapsed, other.ahead, other.length, other.step, other.advection_rate];
        self.lists().iter().zip(other.lists()).all(|(own, other)| own.len() == other.len())
            && self.moved.len() == other.moved.len()
            && numbers.iter().all(|number| number.is_finite())
    }
}

/// The two precisions of a [`State`].
pub trait Stored: Real {
    /// Wrap the fields of a state.
    fn wrap<const D: usize>(fields: Fields<Self, D>) -> ByPrecision<D>;
    /// Return the fields in this precision.
    fn of<const D: usize>(fields: &ByPrecision<D>) -> Result<&Fields<Self, D>, Error>;
    /// Return the fields in this precision, to be written to.
    fn of_mut<const D: usize>(fields: &mut ByPrecision<D>) -> Result<&mut Fields<Self, D>, Error>;
}

macro_rules! stored {
    ($real:ty, $own:ident, $own_name:literal, $other:ident, $other_name:literal) => {
        impl Stored for $real {
            fn wrap<const D: usize>(fields: Fields<Self, D>) -> ByPrecision<D> {
                ByPrecision::$own(fields)
            }

            fn of<const D: usize>(fields: &ByPrecision<D>) -> Result<&Fields<Self, D>, Error> {
                match fields {
                    ByPrecision::$own(fields) => Ok(fields),
                    ByPrecision::$other(_) => Err(Error::Precision { state: $other_name, own: $own_name }),
                }
            }

            fn of_mut<const D: usize>(fields: &mut ByPrecision<D>) -> Result<&mut Fields<Self, D>, Error> {
                match fields {
                    ByPrecision::$own(fields) => Ok(fields),
                    ByPrecision::$other(_) => Err(Error::Precision { state: $other_name, own: $own_name }),
                }
            }
        }
    };
}

stored!(f64, Double, "double", Single, "single");
stored!(f32, Single, "single", Double, "double");

impl<R: Real, const D: usize> TwoStep<R, D> {
    /// Return a component of the velocity, m/s, at a time (s) before the end of the `last` step (s) of a flow, linear in it.
    pub fn velocity<'a>(&self, flow: &'a Flow<R, D>, axis: usize, before: f64, last: f64) -> Cow<'a, [f64]> {
        let now = R::field_to_f64(&flow.velocity[axis]);
        if before == 0.0 {
            return now;
        }
        let pairs = now.iter().zip(&*self.before.velocity[axis]);
        pairs.map(|(now, then)| now + before / last * (then.to_f64() - now)).collect()
    }

    /// Copy `other`, which has the same size; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        self.before.copy_from(&other.before);
        self.earlier.copy_from(&other.earlier);
        self.w.iter_mut().zip(&other.w).for_each(|(own, other)| own.copy_from_slice(other));
        (self.inv_tau, self.step_before) = (other.inv_tau, other.step_before);
    }

    /// Return whether `other` has the same size and a finite step.
    pub fn fits(&self, other: &Self) -> bool {
        self.before.has_shape_of(&other.before)
            && self.earlier.has_shape_of(&other.earlier)
            && self.w.iter().zip(&other.w).all(|(own, other)| own.len() == other.len())
            && other.inv_tau.is_finite()
            && other.step_before.is_finite()
    }
}
