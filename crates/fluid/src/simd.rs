//! The two precisions, and loops compiled for the processor at hand: AVX-512, or AVX2 with FMA, where it has them, chosen
//! at run time by pulp. With AVX-512 a vector is as wide, so the bits are the same, but there are twice as many.
//!
//! A kernel either uses [`Arithmetic`] on a vector of numbers at a time, where a fused multiply-add is meant, or is a plain
//! loop that the compiler vectorizes. A plain loop has the same bits on every processor: Rust does not contract `a b + c`.

use std::borrow::Cow;
use std::fmt::Debug;
use std::ops::{AddAssign, Index, IndexMut};

#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};
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

/// The same numbers as a vector of `f64`.
#[inline(always)]
pub fn wide<R: Real>(&[a, b, c, d]: &[R; WIDE]) -> Four {
    Four(a.wide(), b.wide(), c.wide(), d.wide())
}

/// Round a vector of `f64`.
#[inline(always)]
pub fn narrow<R: Real>(Four(a, b, c, d): Four) -> [R; WIDE] {
    [R::narrow(a), R::narrow(b), R::narrow(c), R::narrow(d)]
}

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
    /// Rows to columns.
    fn transposed(self, rows: R::Square) -> R::Square;
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
    ($real:ident, $vector:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $mul_add:ident, $mul_sub:ident,
     $transposed:ident) => {
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
                avx::$transposed(self, rows)
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

/// Transposes by the instructions that are made for them: of single numbers the compiler makes many more.
#[cfg(target_arch = "x86_64")]
mod avx {
    use std::arch::x86_64::{__m256, __m256d};

    use pulp::cast;

    use super::{Eight, Four, V3};

    /// Pairs of rows, then halves.
    #[inline(always)]
    pub fn transposed_f64(V3 { avx, .. }: V3, [a, b, c, d]: [Four; 4]) -> [Four; 4] {
        let (a, b, c, d): (__m256d, __m256d, __m256d, __m256d) = (cast(a), cast(b), cast(c), cast(d));
        let (even_ab, odd_ab) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
        let (even_cd, odd_cd) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
        [
            cast(avx._mm256_permute2f128_pd::<0x20>(even_ab, even_cd)),
            cast(avx._mm256_permute2f128_pd::<0x20>(odd_ab, odd_cd)),
            cast(avx._mm256_permute2f128_pd::<0x31>(even_ab, even_cd)),
            cast(avx._mm256_permute2f128_pd::<0x31>(odd_ab, odd_cd)),
        ]
    }

    /// Columns 0 and 4, 1 and 5, … of four rows.
    #[inline(always)]
    fn four_rows(V3 { avx, .. }: V3, a: Eight, b: Eight, c: Eight, d: Eight) -> [__m256; 4] {
        let (a, b, c, d): (__m256, __m256, __m256, __m256) = (cast(a), cast(b), cast(c), cast(d));
        let (low_ab, high_ab) = (avx._mm256_unpacklo_ps(a, b), avx._mm256_unpackhi_ps(a, b));
        let (low_cd, high_cd) = (avx._mm256_unpacklo_ps(c, d), avx._mm256_unpackhi_ps(c, d));
        [
            avx._mm256_shuffle_ps::<0x44>(low_ab, low_cd),
            avx._mm256_shuffle_ps::<0xee>(low_ab, low_cd),
            avx._mm256_shuffle_ps::<0x44>(high_ab, high_cd),
            avx._mm256_shuffle_ps::<0xee>(high_ab, high_cd),
        ]
    }

    /// Pairs of rows, pairs of pairs, then halves.
    #[inline(always)]
    pub fn transposed_f32(v3: V3, [a, b, c, d, e, f, g, h]: [Eight; 8]) -> [Eight; 8] {
        let (upper, lower, avx) = (four_rows(v3, a, b, c, d), four_rows(v3, e, f, g, h), v3.avx);
        [
            cast(avx._mm256_permute2f128_ps::<0x20>(upper[0], lower[0])),
            cast(avx._mm256_permute2f128_ps::<0x20>(upper[1], lower[1])),
            cast(avx._mm256_permute2f128_ps::<0x20>(upper[2], lower[2])),
            cast(avx._mm256_permute2f128_ps::<0x20>(upper[3], lower[3])),
            cast(avx._mm256_permute2f128_ps::<0x31>(upper[0], lower[0])),
            cast(avx._mm256_permute2f128_ps::<0x31>(upper[1], lower[1])),
            cast(avx._mm256_permute2f128_ps::<0x31>(upper[2], lower[2])),
            cast(avx._mm256_permute2f128_ps::<0x31>(upper[3], lower[3])),
        ]
    }
}

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
        wide(&lanes.as_chunks().0[part])
    }

    #[inline(always)]
    fn set_part(lanes: &mut [f32; 8], part: usize, value: Four) {
        lanes.as_chunks_mut().0[part] = narrow(value);
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
                assert_eq!(R::store(columns[i])[j].wide(), (10 * j + i) as f64, "row {i}, column {j}");
            }
        }
    }

    fn transposes<R: Real>()
    where
        Scalar256b: Arithmetic<R>,
    {
        let mut rows = R::zeros();
        for i in 0..R::LANES {
            let numbers: Vec<_> = (0..R::LANES).map(|j| R::narrow((10 * i + j) as f64)).collect();
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
