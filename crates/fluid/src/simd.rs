//! The two precisions, and loops compiled for the processor at hand: AVX2 with FMA where it has them, chosen at run time
//! by pulp.
//!
//! A kernel either uses [`Arithmetic`] on a vector of numbers at a time, where a fused multiply-add is meant, or is a plain
//! loop that the compiler vectorizes. A plain loop has the same bits on every processor: Rust does not contract `a b + c`.

use std::borrow::Cow;
use std::fmt::Debug;
use std::ops::{AddAssign, Index, IndexMut};

#[cfg(target_arch = "x86_64")]
use pulp::x86::V3;
use pulp::{Scalar256b, Simd, f32x8 as Eight, f64x4 as Four};
use rustfft::FftNum;
use rustfft::num_complex::Complex;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What fields and spectra are made of: `f64` or `f32`, and nothing else.
///
/// Transforms calculate in it. All other arithmetic is on `f64`, so that no coefficient has a rounding error that is the
/// same in every step: [`Self::wide`] as a number is read and [`Self::narrow`] as it is stored do nothing to an `f64`.
pub trait Real: sealed::Sealed + FftNum + Default + PartialOrd + AddAssign + Serialize + DeserializeOwned {
    /// Numbers in a vector.
    const LANES: usize;
    /// Vectors of `f64` that as many numbers fill.
    const PARTS: usize = Self::LANES / WIDE;
    /// A spectrum is finite where its numbers are smaller: a sum over a column and the conversion to rates stay finite, and
    /// the rounding of what is near the end of the range is above it.
    const LARGEST: Self;
    /// A vector in memory.
    type Lanes: Copy
        + Default
        + Debug
        + PartialEq
        + Send
        + Sync
        + Index<usize, Output = Self>
        + IndexMut<usize>
        + AsRef<[Self]>
        + Serialize
        + DeserializeOwned;
    /// A vector in registers.
    type Vector: Copy + Debug;
    /// As many vectors as each has numbers.
    type Square: Copy + Index<usize, Output = Self::Vector> + IndexMut<usize>;

    /// Round to this precision.
    fn narrow(value: f64) -> Self;
    /// The same number.
    fn wide(self) -> f64;
    /// The same field, copied only where the precision is another.
    fn widened(field: &[Self]) -> Cow<'_, [f64]>;
    /// The numbers `part` [`WIDE`] … of a vector.
    fn part(lanes: &Self::Lanes, part: usize) -> Four;
    /// Round to those.
    fn set_part(lanes: &mut Self::Lanes, part: usize, value: Four);
    /// The same number in each lane.
    fn splat(self) -> Self::Vector;
    /// From memory.
    fn load(lanes: &Self::Lanes) -> Self::Vector;
    /// From the beginning of a slice that has enough.
    fn gather(numbers: &[Self]) -> Self::Vector;
    /// To memory.
    fn store(vector: Self::Vector) -> Self::Lanes;
    /// Vectors of zeros.
    fn zeros() -> Self::Square;
    /// Rows to columns.
    fn transposed(rows: Self::Square) -> Self::Square;
    /// Run a kernel on the processor at hand.
    fn run(kernel: impl Kernel<Real = Self>);

    /// The same complex number, rounded.
    fn complex(value: Complex<f64>) -> Complex<Self> {
        Complex::new(Self::narrow(value.re), Self::narrow(value.im))
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// Numbers in a vector of `f64`.
pub const WIDE: usize = 4;

/// Arithmetic on vectors, as the processor at hand does it best.
pub trait Arithmetic<R: Real>: Copy {
    /// a + b
    fn add(self, a: R::Vector, b: R::Vector) -> R::Vector;
    /// a − b
    fn sub(self, a: R::Vector, b: R::Vector) -> R::Vector;
    /// a b
    fn mul(self, a: R::Vector, b: R::Vector) -> R::Vector;
    /// a/b
    fn div(self, a: R::Vector, b: R::Vector) -> R::Vector;
    /// a b + c
    fn mul_add(self, a: R::Vector, b: R::Vector, c: R::Vector) -> R::Vector;
    /// c − a b
    fn mul_sub(self, a: R::Vector, b: R::Vector, c: R::Vector) -> R::Vector;
}

/// A loop to be compiled for each kind of processor.
///
/// `run` has to be `#[inline(always)]`, like all that it calls with vectors. Closures in `array::from_fn` and the like
/// are not: what is not inlined is slower by a factor of ten.
pub trait Kernel {
    /// What its vectors are made of.
    type Real: Real;
    /// Do it.
    fn run(self, arithmetic: impl Arithmetic<Self::Real>);
}

/// Run a kernel on the processor at hand.
#[inline(always)]
pub fn run<K: Kernel>(kernel: K) {
    K::Real::run(kernel);
}

#[cfg(target_arch = "x86_64")]
struct Compiled<K> {
    avx2: V3,
    kernel: K,
}

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> pulp::NullaryFnOnce for Compiled<K>
where
    V3: Arithmetic<K::Real>,
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.kernel.run(self.avx2);
    }
}

/// What is the same in both precisions but for the names: arithmetic, and what [`Real`] has of memory.
macro_rules! precision {
    ($real:ident, $vector:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $mul_add:ident, $mul_sub:ident) => {
        /// Any processor: without an instruction for it, a product is rounded before it is added.
        impl Arithmetic<$real> for Scalar256b {
            arithmetic!($vector, $add, $sub, $mul, $div);

            #[inline(always)]
            fn mul_add(self, a: $vector, b: $vector, c: $vector) -> $vector {
                self.$add(self.$mul(a, b), c)
            }

            #[inline(always)]
            fn mul_sub(self, a: $vector, b: $vector, c: $vector) -> $vector {
                self.$sub(c, self.$mul(a, b))
            }
        }

        #[cfg(target_arch = "x86_64")]
        impl Arithmetic<$real> for V3 {
            arithmetic!($vector, $add, $sub, $mul, $div);

            #[inline(always)]
            fn mul_add(self, a: $vector, b: $vector, c: $vector) -> $vector {
                self.$mul_add(a, b, c)
            }

            #[inline(always)]
            fn mul_sub(self, a: $vector, b: $vector, c: $vector) -> $vector {
                self.$mul_sub(a, b, c)
            }
        }
    };
}

macro_rules! arithmetic {
    ($vector:ident, $add:ident, $sub:ident, $mul:ident, $div:ident) => {
        #[inline(always)]
        fn add(self, a: $vector, b: $vector) -> $vector {
            self.$add(a, b)
        }

        #[inline(always)]
        fn sub(self, a: $vector, b: $vector) -> $vector {
            self.$sub(a, b)
        }

        #[inline(always)]
        fn mul(self, a: $vector, b: $vector) -> $vector {
            self.$mul(a, b)
        }

        #[inline(always)]
        fn div(self, a: $vector, b: $vector) -> $vector {
            self.$div(a, b)
        }
    };
}

/// The parts of [`Real`] that read the same in both precisions.
macro_rules! memory {
    ($lanes:literal, $vector:ident) => {
        const LANES: usize = $lanes;
        type Lanes = [Self; $lanes];
        type Vector = $vector;
        type Square = [$vector; $lanes];

        #[inline(always)]
        fn load(lanes: &Self::Lanes) -> $vector {
            pulp::cast(*lanes)
        }

        #[inline(always)]
        fn gather(numbers: &[Self]) -> $vector {
            pulp::cast(*numbers.first_chunk::<$lanes>().expect("there are enough"))
        }

        #[inline(always)]
        fn store(vector: $vector) -> Self::Lanes {
            pulp::cast(vector)
        }

        #[inline(always)]
        fn zeros() -> Self::Square {
            [Self::splat(0.0); $lanes]
        }

        #[inline(always)]
        fn run(kernel: impl Kernel<Real = Self>) {
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = V3::try_new() {
                return avx2.vectorize(Compiled { avx2, kernel });
            }
            kernel.run(Scalar256b);
        }
    };
}

precision!(f64, Four, add_f64s, sub_f64s, mul_f64s, div_f64s, mul_add_f64s, negate_mul_add_f64s);
precision!(f32, Eight, add_f32s, sub_f32s, mul_f32s, div_f32s, mul_add_f32s, negate_mul_add_f32s);

impl Real for f64 {
    memory!(4, Four);

    const LARGEST: f64 = 1e250;

    #[inline(always)]
    fn narrow(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }

    fn widened(field: &[f64]) -> Cow<'_, [f64]> {
        field.into()
    }

    #[inline(always)]
    fn part(lanes: &[f64; 4], _: usize) -> Four {
        pulp::cast(*lanes)
    }

    #[inline(always)]
    fn set_part(lanes: &mut [f64; 4], _: usize, value: Four) {
        *lanes = pulp::cast(value);
    }

    #[inline(always)]
    fn splat(self) -> Four {
        Four(self, self, self, self)
    }

    #[inline(always)]
    fn transposed([a, b, c, d]: [Four; 4]) -> [Four; 4] {
        [Four(a.0, b.0, c.0, d.0), Four(a.1, b.1, c.1, d.1), Four(a.2, b.2, c.2, d.2), Four(a.3, b.3, c.3, d.3)]
    }
}

impl Real for f32 {
    memory!(8, Eight);

    const LARGEST: f32 = 1e25;

    #[inline(always)]
    fn narrow(value: f64) -> f32 {
        value as f32
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self.into()
    }

    fn widened(field: &[f32]) -> Cow<'_, [f64]> {
        field.iter().map(|value| value.wide()).collect()
    }

    #[inline(always)]
    fn part(lanes: &[f32; 8], part: usize) -> Four {
        let part = &lanes.as_chunks::<WIDE>().0[part];
        Four(part[0].wide(), part[1].wide(), part[2].wide(), part[3].wide())
    }

    #[inline(always)]
    fn set_part(lanes: &mut [f32; 8], part: usize, value: Four) {
        let part = &mut lanes.as_chunks_mut::<WIDE>().0[part];
        *part = [value.0, value.1, value.2, value.3].map(f32::narrow);
    }

    #[inline(always)]
    fn splat(self) -> Eight {
        let a = self;
        Eight(a, a, a, a, a, a, a, a)
    }

    /// In three rounds, each of which the processor has an instruction for: pairs of numbers, of pairs, and of halves.
    #[inline(always)]
    fn transposed(rows: [Eight; 8]) -> [Eight; 8] {
        let low = |a: Eight, b: Eight| Eight(a.0, b.0, a.1, b.1, a.4, b.4, a.5, b.5);
        let high = |a: Eight, b: Eight| Eight(a.2, b.2, a.3, b.3, a.6, b.6, a.7, b.7);
        let [a, b, c, d, e, f, g, h] = rows;
        let ([a, c, e, g], [b, d, f, h]) =
            ([low(a, b), low(c, d), low(e, f), low(g, h)], [high(a, b), high(c, d), high(e, f), high(g, h)]);
        let low = |a: Eight, b: Eight| Eight(a.0, a.1, b.0, b.1, a.4, a.5, b.4, b.5);
        let high = |a: Eight, b: Eight| Eight(a.2, a.3, b.2, b.3, a.6, a.7, b.6, b.7);
        let upper = [low(a, c), high(a, c), low(b, d), high(b, d)];
        let lower = [low(e, g), high(e, g), low(f, h), high(f, h)];
        let left = |a: Eight, b: Eight| Eight(a.0, a.1, a.2, a.3, b.0, b.1, b.2, b.3);
        let right = |a: Eight, b: Eight| Eight(a.4, a.5, a.6, a.7, b.4, b.5, b.6, b.7);
        [
            left(upper[0], lower[0]),
            left(upper[1], lower[1]),
            left(upper[2], lower[2]),
            left(upper[3], lower[3]),
            right(upper[0], lower[0]),
            right(upper[1], lower[1]),
            right(upper[2], lower[2]),
            right(upper[3], lower[3]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transposes<R: Real>() {
        let mut rows = R::zeros();
        for i in 0..R::LANES {
            let numbers: Vec<_> = (0..R::LANES).map(|j| R::narrow((10 * i + j) as f64)).collect();
            rows[i] = R::gather(&numbers);
        }
        let columns = R::transposed(rows);
        for (i, j) in (0..R::LANES).flat_map(|i| (0..R::LANES).map(move |j| (i, j))) {
            assert_eq!(R::store(columns[i])[j].wide(), (10 * j + i) as f64, "row {i}, column {j}");
        }
    }

    #[test]
    fn rows_become_columns() {
        transposes::<f32>();
        transposes::<f64>();
    }
}
