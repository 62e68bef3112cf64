//! The flow in space, and everything that the next step depends on.

use line_fft::Real;
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::field::Field;
use crate::step::Differences;

/// Velocity and vorticity at one time, `[nx, ny, nz]` per component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Flow<R: Real> {
    /// Velocity, m/s.
    pub velocity: [Field<R>; 3],
    /// Vorticity, 1/s.
    pub vorticity: [Field<R>; 3],
}

/// A time with its flow and the memory of the two-step scheme.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Memory<R: Real> {
    /// Present flow.
    pub flow: Flow<R>,
    /// Flow one step earlier.
    pub before: Flow<R>,
    /// `w = u* + tau G` of the last step, m/s.
    pub w: [Field<R>; 3],
    /// `1/tau` of the last step, 1/s, so that `G = (w − u)/tau`; 0 before the first, where G is 0.
    pub inv_tau: f64,
}

/// The memory in one of the precisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ByPrecision {
    /// `f64`.
    Double(Memory<f64>),
    /// `f32`.
    Single(Memory<f32>),
}

/// The two precisions.
pub trait Stored: Real {
    /// Wrap a memory.
    fn wrap(memory: Memory<Self>) -> ByPrecision;
    /// Return the memory of this precision.
    fn of(memory: &ByPrecision) -> Result<&Memory<Self>, Error>;
    /// Return the memory of this precision, to be written to.
    fn of_mut(memory: &mut ByPrecision) -> Result<&mut Memory<Self>, Error>;
}

macro_rules! stored {
    ($real:ty, $own:ident, $own_name:literal, $other_name:literal) => {
        impl Stored for $real {
            fn wrap(memory: Memory<Self>) -> ByPrecision {
                ByPrecision::$own(memory)
            }

            fn of(memory: &ByPrecision) -> Result<&Memory<Self>, Error> {
                match memory {
                    ByPrecision::$own(memory) => Ok(memory),
                    _ => Err(Error::Precision { state: $other_name, own: $own_name }),
                }
            }

            fn of_mut(memory: &mut ByPrecision) -> Result<&mut Memory<Self>, Error> {
                match memory {
                    ByPrecision::$own(memory) => Ok(memory),
                    _ => Err(Error::Precision { state: $other_name, own: $own_name }),
                }
            }
        }
    };
}

stored!(f64, Double, "double", "single");
stored!(f32, Single, "single", "double");

impl<R: Real> Flow<R> {
    /// A uniform flow (m/s) at `n` points.
    pub fn uniform(velocity: [f64; 3], n: usize) -> Self {
        let field = |value| Field::uniform(R::rounded(value), n);
        Self { velocity: velocity.map(field), vorticity: [0.0; 3].map(field) }
    }

    /// Return the velocity at a grid point, m/s.
    #[inline(always)]
    pub fn velocity_at(&self, point: usize) -> [f64; 3] {
        self.velocity.each_ref().map(|u| u[point].to_f64())
    }

    fn fields(&self) -> impl Iterator<Item = &Field<R>> {
        self.velocity.iter().chain(&self.vorticity)
    }
}

impl<R: Real> Memory<R> {
    /// A uniform flow (m/s) at `n` points without an earlier step.
    pub fn uniform(velocity: [f64; 3], n: usize) -> Self {
        Self {
            flow: Flow::uniform(velocity, n),
            before: Flow::uniform([0.0; 3], n),
            w: [(); 3].map(|()| Field::uniform(R::zero(), n)),
            inv_tau: 0.0,
        }
    }

    /// Return u* (m/s) of a step in work with the solution `w_next` of the local solve, at a grid point.
    pub fn u_star(&self, scheme: &Differences, w_next: &[Field<R>; 3], point: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let [u, w, w_next] = [&self.flow.velocity, &self.w, w_next].map(|fields| fields[axis][point].to_f64());
            w_next - scheme.tau * (self.inv_tau * (w - u))
        })
    }

    fn fields(&self) -> impl Iterator<Item = &Field<R>> {
        self.flow.fields().chain(self.before.fields()).chain(&self.w)
    }

    /// Return whether `other` has the same size and a finite step.
    pub fn fits(&self, other: &Self) -> bool {
        self.inv_tau.is_finite() && self.fields().zip(other.fields()).all(|(own, other)| own.len() == other.len())
    }

    /// Copy `other`, which has the same size; unlike `clone_from` this allocates nothing.
    pub fn copy_from(&mut self, other: &Self) {
        let Self { flow, before, w, .. } = self;
        let flows = [flow, before].into_iter().flat_map(|flow| flow.velocity.iter_mut().chain(&mut flow.vorticity));
        flows.chain(w).zip(other.fields()).for_each(|(own, other)| own.copy_from_slice(other));
        self.inv_tau = other.inv_tau;
    }
}
