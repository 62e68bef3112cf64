//! What one core can do, measured: the bandwidth of streams through arrays of a size, and arithmetic. These are the two
//! roofs of a roofline (Williams, Waterman & Patterson 2009, *Comm. ACM* 52(4), 65).
//!
//! Both are compiled for AVX2 with FMA, as the kernels of the fluid are.

use std::hint::black_box;
use std::time::{Duration, Instant};

/// How long each is measured: longer than what else runs on the machine is busy without a pause.
const TIME: Duration = Duration::from_millis(1500);
/// Bytes that are streamed between two looks at the clock, at least: a tenth of a millisecond. A clock of processor
/// time may stand still for some microseconds.
const STREAMED: usize = 40_000_000;
/// Vectors of multiply-adds that do not wait for each other: more than a core has under way.
const CHAINS: usize = 12;
/// Multiply-adds of each between two looks at the clock.
const LINKS: usize = 100_000;
/// Bytes of a vector.
const VECTOR: usize = 32;

/// A clock, s.
pub type Clock<'a> = &'a dyn Fn() -> f64;

/// Shortest time of a run, s.
pub fn shortest(clock: Clock, mut run: impl FnMut()) -> f64 {
    run();
    let (begin, mut shortest) = (Instant::now(), f64::INFINITY);
    while begin.elapsed() < TIME {
        let start = clock();
        run();
        shortest = shortest.min(clock() - start);
    }
    shortest
}

/// Bandwidth of the triad `a = b + s c` through three arrays of so many bytes together, bytes/s.
///
/// Counted are the two arrays that are read, the one that is written, and that one again: a line comes into the cache
/// before it is written to.
pub fn bandwidth(bytes: usize, clock: Clock) -> f64 {
    let n = bytes / (3 * size_of::<f64>());
    let [mut a, b, c] = [0.0, 1.0, 2.0].map(|value| vec![value; n]);
    let passes = STREAMED.div_ceil(bytes);
    let seconds = shortest(clock, || {
        for _ in 0..passes {
            compiled::triad(black_box(&mut a), &b, &c, 0.5);
        }
    });
    (4 * size_of::<f64>() * n * passes) as f64 / seconds
}

/// A precision with its fused multiply-add.
pub trait Fused {
    /// Operations a second of multiply-adds that wait for nothing, two for each.
    fn peak(clock: Clock) -> f64;
}

macro_rules! fused {
    ($number:ty, $multiply_add:ident) => {
        impl Fused for $number {
            fn peak(clock: Clock) -> f64 {
                let mut sums = [[1.0; VECTOR / size_of::<$number>()]; CHAINS];
                let seconds = shortest(clock, || compiled::$multiply_add(black_box(&mut sums), 0.5));
                (2 * LINKS * sums.as_flattened().len()) as f64 / seconds
            }
        }
    };
}
fused!(f64, multiply_add_double);
fused!(f32, multiply_add_single);

/// Loops for the processor at hand, which has to have what the fluid's kernels are compiled for.
mod compiled {
    use super::{CHAINS, LINKS, VECTOR};

    macro_rules! compiled {
        ($name:ident, ($($argument:ident: $kind:ty),*), $body:block) => {
            pub fn $name($($argument: $kind),*) {
                #[cfg_attr(target_arch = "x86_64", target_feature(enable = "avx2,fma"))]
                fn compiled($($argument: $kind),*) $body
                #[cfg(target_arch = "x86_64")]
                assert!(is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"), "no AVX2 with FMA");
                #[allow(unused_unsafe, reason = "without features it is safe")]
                // SAFETY: the processor has the features.
                unsafe { compiled($($argument),*) }
            }
        };
    }

    compiled!(triad, (a: &mut [f64], b: &[f64], c: &[f64], s: f64), {
        for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
            *a = b + s * c;
        }
    });

    macro_rules! multiply_add {
        ($name:ident, $number:ty) => {
            compiled!($name, (sums: &mut [[$number; VECTOR / size_of::<$number>()]; CHAINS], factor: $number), {
                let mut own = *sums;
                for _ in 0..LINKS {
                    for sum in own.as_flattened_mut() {
                        *sum = sum.mul_add(factor, 1.0);
                    }
                }
                *sums = own;
            });
        };
    }
    multiply_add!(multiply_add_double, f64);
    multiply_add!(multiply_add_single, f32);
}
