//! As many complex numbers as a vector has lanes, one of each of as many lines, and arithmetic with them.

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

/// As many complex numbers in registers.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Complexes<R: Real> {
    /// Real parts.
    pub re: R::Vector,
    /// Imaginary parts.
    pub im: R::Vector,
}

impl<R: Real> Complexes<R> {
    /// 0
    #[inline(always)]
    pub fn zero() -> Self {
        Self { re: R::zero().splat(), im: R::zero().splat() }
    }

    /// From memory.
    #[inline(always)]
    pub fn load(pack: &Pack<R>) -> Self {
        Self { re: R::load(&pack.re), im: R::load(&pack.im) }
    }

    /// To memory.
    #[inline(always)]
    pub fn pack(self) -> Pack<R> {
        Pack { re: R::store(self.re), im: R::store(self.im) }
    }

    /// Real and imaginary parts exchanged.
    #[inline(always)]
    pub fn exchanged(self) -> Self {
        Self { re: self.im, im: self.re }
    }

    /// The sum.
    #[inline(always)]
    pub fn add(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.add(self.re, b.re), im: on.add(self.im, b.im) }
    }

    /// The difference.
    #[inline(always)]
    pub fn sub(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.sub(self.re, b.re), im: on.sub(self.im, b.im) }
    }

    /// `self + i b`.
    #[inline(always)]
    pub fn add_i(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.sub(self.re, b.im), im: on.add(self.im, b.re) }
    }

    /// `self − i b`.
    #[inline(always)]
    pub fn sub_i(self, on: impl Arithmetic<R>, b: Self) -> Self {
        Self { re: on.add(self.re, b.im), im: on.sub(self.im, b.re) }
    }

    /// The product with the same number in each lane.
    #[inline(always)]
    pub fn times(self, on: impl Arithmetic<R>, w: Complex<R>) -> Self {
        let (re, im) = (w.re.splat(), w.im.splat());
        Self { re: on.mul_sub(self.im, im, on.mul(self.re, re)), im: on.mul_add(self.im, re, on.mul(self.re, im)) }
    }

    /// The product with a real number by lane.
    #[inline(always)]
    pub fn scaled(self, on: impl Arithmetic<R>, factor: R::Vector) -> Self {
        Self { re: on.mul(factor, self.re), im: on.mul(factor, self.im) }
    }

    /// The product with i.
    #[inline(always)]
    pub fn times_i(self, on: impl Arithmetic<R>) -> Self {
        Self { re: on.sub(R::zero().splat(), self.im), im: self.re }
    }

    /// `self − factor b`, factor by lane.
    #[inline(always)]
    pub fn mul_sub(self, on: impl Arithmetic<R>, factor: R::Vector, b: Self) -> Self {
        Self { re: on.mul_sub(factor, b.re, self.re), im: on.mul_sub(factor, b.im, self.im) }
    }

    /// `self + factor b`, factor by lane.
    #[inline(always)]
    pub fn mul_add(self, on: impl Arithmetic<R>, factor: R::Vector, b: Self) -> Self {
        Self { re: on.mul_add(factor, b.re, self.re), im: on.mul_add(factor, b.im, self.im) }
    }
}

/// Numbers of a pack that fill a vector of `f64`, for arithmetic in double precision whatever that of the pack.
impl<R: Real> Pack<R> {
    /// The numbers of a part.
    #[inline(always)]
    pub fn part(&self, part: usize) -> Complexes<f64> {
        Complexes { re: R::part(&self.re, part), im: R::part(&self.im, part) }
    }

    /// Round to those of a part.
    #[inline(always)]
    pub fn set_part(&mut self, part: usize, value: Complexes<f64>) {
        R::set_part(&mut self.re, part, value.re);
        R::set_part(&mut self.im, part, value.im);
    }
}
