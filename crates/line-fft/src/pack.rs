//! Complex numbers, one in each lane of a vector, and arithmetic with them.

use rustfft::num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::simd::{Arithmetic, Real};

/// One complex number of each of four lines, or of eight in single precision; fills a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
#[repr(align(64))]
pub struct Pack<R: Real> {
    /// Real parts.
    pub re: R::Lanes,
    /// Imaginary parts.
    pub im: R::Lanes,
}

/// The complex numbers of a [`Pack`] in registers.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Complexes<R: Real> {
    /// Real parts.
    pub re: R::Vector,
    /// Imaginary parts.
    pub im: R::Vector,
}

impl<R: Real> Complexes<R> {
    /// Return zeros.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { re: R::zero().splat(), im: R::zero().splat() }
    }

    /// Load a pack.
    #[inline(always)]
    pub fn load(pack: &Pack<R>) -> Self {
        Self { re: R::load(&pack.re), im: R::load(&pack.im) }
    }

    /// Store to a pack.
    #[inline(always)]
    pub fn pack(self) -> Pack<R> {
        Pack { re: R::store(self.re), im: R::store(self.im) }
    }

    /// Swap real and imaginary parts.
    #[inline(always)]
    pub fn exchanged(self) -> Self {
        Self { re: self.im, im: self.re }
    }

    /// Return `self + b`.
    #[inline(always)]
    pub fn add(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.add(self.re, b.re), im: on.add(self.im, b.im) }
    }

    /// Return `self − b`.
    #[inline(always)]
    pub fn sub(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.sub(self.re, b.re), im: on.sub(self.im, b.im) }
    }

    /// Return `self + i b`.
    #[inline(always)]
    pub fn add_i(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.sub(self.re, b.im), im: on.add(self.im, b.re) }
    }

    /// Return `self − i b`.
    #[inline(always)]
    pub fn sub_i(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.add(self.re, b.im), im: on.sub(self.im, b.re) }
    }

    /// Return `self w`, the same `w` in each lane.
    #[inline(always)]
    pub fn times(self, on: impl Arithmetic<R>, w: Complex<R>) -> Self {
        let (re, im) = (w.re.splat(), w.im.splat());
        Self { re: on.mul_sub(self.im, im, on.mul(self.re, re)), im: on.mul_add(self.im, re, on.mul(self.re, im)) }
    }

    /// Return `factor self`, a real factor for each lane.
    #[inline(always)]
    pub fn scaled(self, on: impl Arithmetic<R>, factor: R::Vector) -> Self {
        Self { re: on.mul(factor, self.re), im: on.mul(factor, self.im) }
    }

    /// Return `i self`.
    #[inline(always)]
    pub fn times_i(self, on: impl Arithmetic<R>) -> Self {
        Self { re: on.sub(R::zero().splat(), self.im), im: self.re }
    }

    /// Return `self − factor b`, a factor for each lane.
    #[inline(always)]
    pub fn mul_sub(self, on: impl Arithmetic<R>, factor: R::Vector, b: Self) -> Self {
        Self { re: on.mul_sub(factor, b.re, self.re), im: on.mul_sub(factor, b.im, self.im) }
    }

    /// Return `self + factor b`, a factor for each lane.
    #[inline(always)]
    pub fn mul_add(self, on: impl Arithmetic<R>, factor: R::Vector, b: Self) -> Self {
        Self { re: on.mul_add(factor, b.re, self.re), im: on.mul_add(factor, b.im, self.im) }
    }
}

/// Parts of a pack as vectors of `f64`, for arithmetic in double precision.
impl<R: Real> Pack<R> {
    /// Return the numbers of a part.
    #[inline(always)]
    pub fn part(&self, part: usize) -> Complexes<f64> {
        Complexes { re: R::part(&self.re, part), im: R::part(&self.im, part) }
    }

    /// Round `value` to the numbers of a part.
    #[inline(always)]
    pub fn set_part(&mut self, part: usize, value: Complexes<f64>) {
        R::set_part(&mut self.re, part, value.re);
        R::set_part(&mut self.im, part, value.im);
    }
}
