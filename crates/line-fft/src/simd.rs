//! The two precisions, and loops compiled for the processor at hand: AVX-512, or AVX2 with FMA, chosen at run time by
//! pulp. With AVX-512 a vector is as wide, so the bits are the same, but there are twice as many registers.
//!
//! A kernel either uses [`Arithmetic`] on vectors, where a fused multiply-add is meant, or is a plain loop that the
//! compiler vectorizes. A plain loop has the same bits on every processor: Rust does not contract `a b + c`.

use std::borrow::Cow;
use std::fmt::Debug;
use std::ops::{AddAssign, Index, IndexMut};
use std::sync::Arc;

#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};
use pulp::{Scalar256b, Simd, f32x8 as Eight, f64x4 as Four};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftNum, FftPlanner};
use serde::Serialize;
use serde::de::DeserializeOwned;

#[cfg(target_arch = "x86_64")]
use crate::transpose;

/// The numbers of fields and spectra: `f64` or `f32`.
///
/// Transforms calculate in it. All other arithmetic should be on `f64`, so that no coefficient has a rounding error
/// that is the same in every step: [`Self::to_f64`] on reading and [`Self::rounded`] on storing leave an `f64` as it
/// is.
pub trait Real: sealed::Sealed + FftNum + Default + PartialOrd + AddAssign + Serialize + DeserializeOwned {
    /// Numbers in a vector.
    const LANES: usize;
    /// Vectors of `f64` that hold the numbers of a vector.
    const PARTS: usize = Self::LANES / F64_LANES;
    /// Numbers below this can be summed over a line and scaled without overflow.
    const OVERFLOW_GUARD: Self;
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
    /// A vector for each lane.
    type Square: Copy + Index<usize, Output = Self::Vector> + IndexMut<usize>;

    /// Round to this precision. (`from_f64` is a name of `num_traits`.)
    fn rounded(value: f64) -> Self;
    /// Return the number in double precision.
    fn to_f64(self) -> f64;
    /// Return a field in double precision, copied only if it has another.
    fn field_to_f64(field: &[Self]) -> Cow<'_, [f64]>;
    /// Return the numbers `F64_LANES part …` of a vector.
    fn part(lanes: &Self::Lanes, part: usize) -> Four;
    /// Round `value` to the numbers `F64_LANES part …` of a vector.
    fn set_part(lanes: &mut Self::Lanes, part: usize, value: Four);
    /// Return a vector with the number in each lane.
    fn splat(self) -> Self::Vector;
    /// Load a vector from memory.
    fn load(lanes: &Self::Lanes) -> Self::Vector;
    /// Load a vector from the first numbers of a slice.
    fn gather(numbers: &[Self]) -> Self::Vector;
    /// Store a vector.
    fn store(vector: Self::Vector) -> Self::Lanes;
    /// Return vectors of zeros.
    fn zeros() -> Self::Square;
    /// Run a kernel on the processor at hand.
    fn run(kernel: impl Kernel<Real = Self>);
    /// Plan the transform of a line of any length; of this crate alone, for all its sizes take long to compile.
    fn any_length(n: usize) -> Arc<dyn Fft<Self>>;

    /// Round a complex number.
    fn complex(value: Complex<f64>) -> Complex<Self> {
        Complex::new(Self::rounded(value.re), Self::rounded(value.im))
    }
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// Numbers in a vector of `f64`.
pub const F64_LANES: usize = 4;

/// Load numbers into a vector of `f64`.
#[inline(always)]
pub fn to_f64s<R: Real>(&[a, b, c, d]: &[R; F64_LANES]) -> Four {
    Four(a.to_f64(), b.to_f64(), c.to_f64(), d.to_f64())
}

/// Round a vector of `f64`.
#[inline(always)]
pub fn from_f64s<R: Real>(Four(a, b, c, d): Four) -> [R; F64_LANES] {
    [R::rounded(a), R::rounded(b), R::rounded(c), R::rounded(d)]
}

/// Arithmetic on vectors with the instructions of the processor at hand.
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
    /// Swap rows and columns.
    fn transposed(self, rows: R::Square) -> R::Square;
}

/// A loop compiled for each kind of processor.
///
/// `run` and every function that it calls with vectors must be `#[inline(always)]`: a call is slower by a factor of
/// ten. Closures in `array::from_fn` and the like are not inlined.
pub trait Kernel {
    /// The numbers of its vectors.
    type Real: Real;
    /// Run the loop.
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

/// [`Arithmetic`] of a precision: the names of the instructions differ.
macro_rules! precision {
    ($real:ident, $vector:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $mul_add:ident, $mul_sub:ident,
     $transposed:ident) => {
        /// Any processor: there is no fused multiply-add, so a product is rounded before it is added.
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

            #[inline(always)]
            fn transposed(self, rows: <$real as Real>::Square) -> <$real as Real>::Square {
                let mut columns = rows;
                for (i, column) in columns.iter_mut().enumerate() {
                    let mut lanes = <$real>::store(*column);
                    for (lane, row) in lanes.iter_mut().zip(rows) {
                        *lane = <$real>::store(row)[i];
                    }
                    *column = <$real>::load(&lanes);
                }
                columns
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

            #[inline(always)]
            fn transposed(self, rows: <$real as Real>::Square) -> <$real as Real>::Square {
                transpose::$transposed(self, rows)
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

/// The parts of [`Real`] that are the same text in both precisions.
macro_rules! memory {
    ($lanes:literal, $vector:ident) => {
        const LANES: usize = $lanes;
        type Lanes = [Self; $lanes];
        type Vector = $vector;
        type Square = [$vector; $lanes];

        fn any_length(n: usize) -> Arc<dyn Fft<Self>> {
            FftPlanner::new().plan_fft_forward(n)
        }

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
            if let Some(avx512) = V4::try_new() {
                return avx512.vectorize(Compiled { avx2: *avx512, kernel });
            }
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = V3::try_new() {
                return avx2.vectorize(Compiled { avx2, kernel });
            }
            kernel.run(Scalar256b);
        }
    };
}

precision!(f64, Four, add_f64s, sub_f64s, mul_f64s, div_f64s, mul_add_f64s, negate_mul_add_f64s, transposed_f64);
precision!(f32, Eight, add_f32s, sub_f32s, mul_f32s, div_f32s, mul_add_f32s, negate_mul_add_f32s, transposed_f32);

impl Real for f64 {
    memory!(4, Four);

    const OVERFLOW_GUARD: f64 = 1e250;

    #[inline(always)]
    fn rounded(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }

    fn field_to_f64(field: &[f64]) -> Cow<'_, [f64]> {
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
}

impl Real for f32 {
    memory!(8, Eight);

    const OVERFLOW_GUARD: f32 = 1e25;

    #[inline(always)]
    fn rounded(value: f64) -> f32 {
        value as f32
    }

    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.into()
    }

    fn field_to_f64(field: &[f32]) -> Cow<'_, [f64]> {
        field.iter().map(|value| value.to_f64()).collect()
    }

    #[inline(always)]
    fn part(lanes: &[f32; 8], part: usize) -> Four {
        to_f64s(&lanes.as_chunks().0[part])
    }

    #[inline(always)]
    fn set_part(lanes: &mut [f32; 8], part: usize, value: Four) {
        lanes.as_chunks_mut().0[part] = from_f64s(value);
    }

    #[inline(always)]
    fn splat(self) -> Eight {
        let a = self;
        Eight(a, a, a, a, a, a, a, a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Transpose<R: Real>(R::Square);

    impl<R: Real> Kernel for Transpose<R> {
        type Real = R;

        #[inline(always)]
        fn run(self, on: impl Arithmetic<R>) {
            let columns = on.transposed(self.0);
            for (i, j) in (0..R::LANES).flat_map(|i| (0..R::LANES).map(move |j| (i, j))) {
                assert_eq!(R::store(columns[i])[j].to_f64(), (10 * j + i) as f64, "row {i}, column {j}");
            }
        }
    }

    fn transposes<R: Real>()
    where
        Scalar256b: Arithmetic<R>,
    {
        let mut rows = R::zeros();
        for i in 0..R::LANES {
            let numbers: Vec<_> = (0..R::LANES).map(|j| R::rounded((10 * i + j) as f64)).collect();
            rows[i] = R::gather(&numbers);
        }
        run(Transpose::<R>(rows));
        Transpose::<R>(rows).run(Scalar256b);
    }

    #[test]
    fn rows_become_columns_on_every_processor() {
        transposes::<f32>();
        transposes::<f64>();
    }
}
