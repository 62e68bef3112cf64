//! Transposes of square blocks by the instructions made for them: from single numbers the compiler makes many more.

use std::arch::x86_64::{__m256, __m256d};

use pulp::x86::V3;
use pulp::{cast, f32x8 as Eight, f64x4 as Four};

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
