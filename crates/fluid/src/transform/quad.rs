//! Four complex numbers, one of each of four lines, and arithmetic with them.

use pulp::f64x4 as Four;
use rustfft::num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::simd::{Arithmetic, LANES, splat};

/// One complex number of each of four lines; fills a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub struct Quad {
    /// Real parts.
    pub re: [f64; LANES],
    /// Imaginary parts.
    pub im: [f64; LANES],
}

/// Four complex numbers in registers.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Complex4 {
    /// Real parts.
    pub re: Four,
    /// Imaginary parts.
    pub im: Four,
}

impl Complex4 {
    /// 0
    pub const ZERO: Self = Self { re: Four(0.0, 0.0, 0.0, 0.0), im: Four(0.0, 0.0, 0.0, 0.0) };

    /// From memory.
    #[inline(always)]
    pub fn load(quad: &Quad) -> Self {
        Self { re: pulp::cast(quad.re), im: pulp::cast(quad.im) }
    }

    /// To memory.
    #[inline(always)]
    pub fn quad(self) -> Quad {
        Quad { re: pulp::cast(self.re), im: pulp::cast(self.im) }
    }

    /// Real and imaginary parts exchanged.
    #[inline(always)]
    pub fn exchanged(self) -> Self {
        Self { re: self.im, im: self.re }
    }

    /// The sum.
    #[inline(always)]
    pub fn add(self, on: impl Arithmetic, b: Self) -> Self {
        Self { re: on.add_f64s(self.re, b.re), im: on.add_f64s(self.im, b.im) }
    }

    /// The difference.
    #[inline(always)]
    pub fn sub(self, on: impl Arithmetic, b: Self) -> Self {
        Self { re: on.sub_f64s(self.re, b.re), im: on.sub_f64s(self.im, b.im) }
    }

    /// `self + i b`.
    #[inline(always)]
    pub fn add_i(self, on: impl Arithmetic, b: Self) -> Self {
        Self { re: on.sub_f64s(self.re, b.im), im: on.add_f64s(self.im, b.re) }
    }

    /// `self − i b`.
    #[inline(always)]
    pub fn sub_i(self, on: impl Arithmetic, b: Self) -> Self {
        Self { re: on.add_f64s(self.re, b.im), im: on.sub_f64s(self.im, b.re) }
    }

    /// The product with the same number in each lane.
    #[inline(always)]
    pub fn times(self, on: impl Arithmetic, w: Complex64) -> Self {
        let (re, im) = (splat(w.re), splat(w.im));
        Self {
            re: on.mul_sub(self.im, im, on.mul_f64s(self.re, re)),
            im: on.mul_add(self.im, re, on.mul_f64s(self.re, im)),
        }
    }

    /// The product with a real number by lane.
    #[inline(always)]
    pub fn scaled(self, on: impl Arithmetic, factor: Four) -> Self {
        Self { re: on.mul_f64s(factor, self.re), im: on.mul_f64s(factor, self.im) }
    }

    /// The product with i.
    #[inline(always)]
    pub fn times_i(self, on: impl Arithmetic) -> Self {
        Self { re: on.sub_f64s(splat(0.0), self.im), im: self.re }
    }

    /// `self − factor b`, factor by lane.
    #[inline(always)]
    pub fn mul_sub(self, on: impl Arithmetic, factor: Four, b: Self) -> Self {
        Self { re: on.mul_sub(factor, b.re, self.re), im: on.mul_sub(factor, b.im, self.im) }
    }

    /// `self + factor b`, factor by lane.
    #[inline(always)]
    pub fn mul_add(self, on: impl Arithmetic, factor: Four, b: Self) -> Self {
        Self { re: on.mul_add(factor, b.re, self.re), im: on.mul_add(factor, b.im, self.im) }
    }
}
