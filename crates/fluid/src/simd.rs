//! Loops compiled for the processor at hand: AVX2 with FMA where it has them, chosen at run time by pulp.
//!
//! A kernel either uses [`Arithmetic`] on four numbers at a time, where a fused multiply-add is meant, or is a plain loop
//! that the compiler vectorizes. A plain loop has the same bits on every processor: Rust does not contract `a b + c`.

#[cfg(target_arch = "x86_64")]
use pulp::x86::V3;
use pulp::{Scalar256b, Simd, f64x4 as Four};

/// Numbers in a vector.
pub const LANES: usize = 4;

/// Arithmetic on four numbers, as the processor at hand does it best.
pub trait Arithmetic: Simd<f64s = Four> {
    /// a b + c
    fn mul_add(self, a: Four, b: Four, c: Four) -> Four;
    /// c − a b
    fn mul_sub(self, a: Four, b: Four, c: Four) -> Four;
}

/// Any processor: without an instruction for it, a product is rounded before it is added.
impl Arithmetic for Scalar256b {
    #[inline(always)]
    fn mul_add(self, a: Four, b: Four, c: Four) -> Four {
        self.add_f64s(self.mul_f64s(a, b), c)
    }

    #[inline(always)]
    fn mul_sub(self, a: Four, b: Four, c: Four) -> Four {
        self.sub_f64s(c, self.mul_f64s(a, b))
    }
}

#[cfg(target_arch = "x86_64")]
impl Arithmetic for V3 {
    #[inline(always)]
    fn mul_add(self, a: Four, b: Four, c: Four) -> Four {
        self.mul_add_f64s(a, b, c)
    }

    #[inline(always)]
    fn mul_sub(self, a: Four, b: Four, c: Four) -> Four {
        self.negate_mul_add_f64s(a, b, c)
    }
}

/// A loop to be compiled for each kind of processor.
///
/// `run` has to be `#[inline(always)]`, like all that it calls with vectors. Closures in `array::from_fn` and the like
/// are not: what is not inlined is slower by a factor of ten.
pub trait Kernel {
    /// Do it.
    fn run(self, arithmetic: impl Arithmetic);
}

/// Run a kernel on the processor at hand.
pub fn run(kernel: impl Kernel) {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = V3::try_new() {
        return avx2.vectorize(Compiled { avx2, kernel });
    }
    kernel.run(Scalar256b);
}

#[cfg(target_arch = "x86_64")]
struct Compiled<K> {
    avx2: V3,
    kernel: K,
}

#[cfg(target_arch = "x86_64")]
impl<K: Kernel> pulp::NullaryFnOnce for Compiled<K> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.kernel.run(self.avx2);
    }
}

/// The same number in each lane.
#[inline(always)]
pub fn splat(a: f64) -> Four {
    Four(a, a, a, a)
}
