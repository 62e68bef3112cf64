//! Discrete Fourier transforms of four lines at once, one line in each lane of a vector.
//!
//! All lanes do the same, so no factor of a length needs shuffles, and 13 gets on as well as 4. Decimation in time
//! (Cooley & Tukey 1965): transforms of the last factor from strided input, then a pass for each other factor in place.

#![allow(clippy::needless_range_loop, reason = "what runs over lanes or a butterfly is unrolled, by index")]

use std::array::from_fn;
use std::f64::consts::TAU;
use std::sync::Arc;

use rustfft::{Fft, FftPlanner, num_complex::Complex64};

use super::quad::{Complex4, Quad};
use crate::simd::{Arithmetic, Kernel, LANES, run, splat};

/// A line longer than this is transformed in parts, so that a part with its input stays in the first cache.
const LONG: usize = 384;

/// Transforms of one length.
pub enum Lines {
    /// Of a length with no prime factor above 13.
    Smooth(Smooth),
    /// Of any length, one line after the other.
    Any(Arc<dyn Fft<f64>>),
}

/// Plan for a length with small factors.
pub struct Smooth {
    /// The factor transformed first, and its [`roots`].
    leaf: (usize, Vec<Complex64>),
    /// Where in the input each of those transforms begins.
    starts: Vec<usize>,
    passes: Vec<Pass>,
}

/// From transforms of length `m` to those of length `factor m`.
struct Pass {
    factor: usize,
    m: usize,
    roots: Vec<Complex64>,
    /// `exp(−2πi r k/(factor m))` for r = 1 … factor − 1, then k.
    twiddles: Vec<Complex64>,
}

fn root(numerator: usize, n: usize) -> Complex64 {
    Complex64::from_polar(1.0, -TAU * (numerator % n) as f64 / n as f64)
}

/// `exp(−2πi j k/p)` for j = 1 … p/2, then k.
fn roots(p: usize) -> Vec<Complex64> {
    (1..=p / 2).flat_map(|k| (1..=p / 2).map(move |j| root(j * k, p))).collect()
}

impl Lines {
    /// Plan transforms of length `n`.
    pub fn new(n: usize) -> Self {
        let mut factors = Vec::new();
        let mut rest = n;
        for factor in [13, 11, 7, 5, 4, 3, 2] {
            while rest.is_multiple_of(factor) {
                factors.push(factor);
                rest /= factor;
            }
        }
        if rest > 1 || n == 1 {
            return Self::Any(FftPlanner::new().plan_fft_forward(n));
        }
        let mut m = factors[0];
        let mut starts = vec![0];
        for (level, factor) in factors.iter().enumerate().skip(1).rev() {
            // Of the outermost factor, its remainders are the slowest in the output and one apart in the input.
            let apart: usize = factors[level + 1..].iter().product();
            starts = starts.iter().flat_map(|start| (0..*factor).map(move |r| start + r * apart)).collect();
        }
        let passes = factors[1..].iter().map(|&factor| {
            let twiddles = (0..m).flat_map(|k| (1..factor).map(move |r| root(r * k, factor * m))).collect();
            let pass = Pass { factor, m, roots: roots(factor), twiddles };
            m *= factor;
            pass
        });
        let passes = passes.collect();
        Self::Smooth(Smooth { leaf: (factors[0], roots(factors[0])), starts, passes })
    }

    /// Number of complex values that [`Self::forward`] needs for itself.
    pub fn scratch_len(&self) -> usize {
        match self {
            Self::Smooth(_) => 0,
            Self::Any(fft) => fft.len() + fft.get_inplace_scratch_len(),
        }
    }

    /// `to[k] = Σ_j from[j] exp(−2πi j k/n)`.
    ///
    /// With `EXCHANGE` the input is taken with real and imaginary parts exchanged. The output is then that of the
    /// inverse transform, with the parts exchanged.
    pub fn forward<const EXCHANGE: bool>(&self, from: &[Quad], to: &mut [Quad], scratch: &mut [Complex64]) {
        match self {
            Self::Smooth(smooth) => smooth.forward::<EXCHANGE>(from, to),
            Self::Any(fft) => {
                let (line, scratch) = scratch.split_at_mut(fft.len());
                for lane in 0..LANES {
                    for (value, quad) in line.iter_mut().zip(from) {
                        let (re, im) = (quad.re[lane], quad.im[lane]);
                        *value = if EXCHANGE { Complex64::new(im, re) } else { Complex64::new(re, im) };
                    }
                    fft.process_with_scratch(line, &mut scratch[..fft.get_inplace_scratch_len()]);
                    for (value, quad) in line.iter().zip(&mut *to) {
                        (quad.re[lane], quad.im[lane]) = (value.re, value.im);
                    }
                }
            }
        }
    }
}

impl Smooth {
    fn forward<const EXCHANGE: bool>(&self, from: &[Quad], to: &mut [Quad]) {
        let (inner, outer) = match self.passes.split_last() {
            Some((last, inner)) if to.len() > LONG => (inner, Some(last)),
            _ => (&self.passes[..], None),
        };
        let part = outer.map_or(to.len(), |pass| pass.m);
        let (leaf, roots) = &self.leaf;
        for (to, starts) in to.chunks_exact_mut(part).zip(self.starts.chunks_exact(part / leaf)) {
            match leaf {
                2 => run(Leaves::<2, EXCHANGE> { from, to, starts, roots }),
                3 => run(Leaves::<3, EXCHANGE> { from, to, starts, roots }),
                4 => run(Leaves::<4, EXCHANGE> { from, to, starts, roots }),
                5 => run(Leaves::<5, EXCHANGE> { from, to, starts, roots }),
                7 => run(Leaves::<7, EXCHANGE> { from, to, starts, roots }),
                11 => run(Leaves::<11, EXCHANGE> { from, to, starts, roots }),
                _ => run(Leaves::<13, EXCHANGE> { from, to, starts, roots }),
            }
            inner.iter().for_each(|pass| pass.apply(to));
        }
        outer.into_iter().for_each(|pass| pass.apply(to));
    }
}

impl Pass {
    fn apply(&self, lines: &mut [Quad]) {
        let pass = self;
        match pass.factor {
            2 => run(Combine::<2> { pass, lines }),
            3 => run(Combine::<3> { pass, lines }),
            4 => run(Combine::<4> { pass, lines }),
            5 => run(Combine::<5> { pass, lines }),
            7 => run(Combine::<7> { pass, lines }),
            11 => run(Combine::<11> { pass, lines }),
            _ => run(Combine::<13> { pass, lines }),
        }
    }
}

/// Transforms of length `P` from strided input.
struct Leaves<'a, const P: usize, const EXCHANGE: bool> {
    from: &'a [Quad],
    to: &'a mut [Quad],
    starts: &'a [usize],
    roots: &'a [Complex64],
}

impl<const P: usize, const EXCHANGE: bool> Kernel for Leaves<'_, P, EXCHANGE> {
    #[inline(always)]
    fn run(self, on: impl Arithmetic) {
        let roots = self.roots;
        let stride = self.from.len() / P;
        let from: [&[Quad]; P] = from_fn(|j| &self.from[j * stride..][..stride]);
        for (to, &start) in self.to.as_chunks_mut::<P>().0.iter_mut().zip(self.starts) {
            let mut x = [Complex4::ZERO; P];
            for j in 0..P {
                let value = Complex4::load(&from[j][start]);
                x[j] = if EXCHANGE { value.exchanged() } else { value };
            }
            butterfly(on, x, roots, |k, value| to[k] = value.quad());
        }
    }
}

/// [`Pass::apply`] for the factor `P`.
struct Combine<'a, const P: usize> {
    pass: &'a Pass,
    lines: &'a mut [Quad],
}

impl<const P: usize> Kernel for Combine<'_, P> {
    #[inline(always)]
    fn run(self, on: impl Arithmetic) {
        let Pass { m, ref roots, ref twiddles, .. } = *self.pass;
        for line in self.lines.chunks_exact_mut(P * m) {
            let mut rest = line;
            let mut parts: [&mut [Quad]; P] = from_fn(|_| {
                let (part, others) = std::mem::take(&mut rest).split_at_mut(m);
                rest = others;
                part
            });
            for (k, twiddles) in twiddles.chunks_exact(P - 1).enumerate().take(m) {
                let mut x = [Complex4::load(&parts[0][k]); P];
                for r in 1..P {
                    x[r] = Complex4::load(&parts[r][k]).times(on, twiddles[r - 1]);
                }
                butterfly(on, x, roots, |r, value| parts[r][k] = value.quad());
            }
        }
    }
}

/// The transform of length `P`, which is 2, 4 or odd; `store(k, value)` puts the values away.
#[inline(always)]
fn butterfly<const P: usize>(
    on: impl Arithmetic,
    mut x: [Complex4; P],
    roots: &[Complex64],
    mut store: impl FnMut(usize, Complex4),
) {
    if P == 2 {
        store(0, x[0].add(on, x[1]));
        store(1, x[0].sub(on, x[1]));
    } else if P == 4 {
        let (even, odd) = (x[0].add(on, x[2]), x[1].add(on, x[3]));
        let (even_difference, odd_difference) = (x[0].sub(on, x[2]), x[1].sub(on, x[3]));
        store(0, even.add(on, odd));
        store(1, even_difference.sub_i(on, odd_difference));
        store(2, even.sub(on, odd));
        store(3, even_difference.add_i(on, odd_difference));
    } else {
        // x_j and x_{P−j} have conjugate roots: y_k, y_{P−k} = x_0 + Σ cos (x_j + x_{P−j}) ± i Σ sin (x_j − x_{P−j}).
        // (Ranges that include their end would not be unrolled.)
        let half = P / 2;
        let mut sum = x[0];
        for j in 1..half + 1 {
            (x[j], x[P - j]) = (x[j].add(on, x[P - j]), x[j].sub(on, x[P - j]));
            sum = sum.add(on, x[j]);
        }
        store(0, sum);
        for k in 1..half + 1 {
            let roots = &roots[(k - 1) * half..][..half];
            let mut even = x[0].mul_add(on, splat(roots[0].re), x[1]);
            let mut odd = x[P - 1].scaled(on, splat(roots[0].im));
            for j in 2..half + 1 {
                even = even.mul_add(on, splat(roots[j - 1].re), x[j]);
                odd = odd.mul_add(on, splat(roots[j - 1].im), x[P - j]);
            }
            store(k, even.add_i(on, odd));
            store(P - k, even.sub_i(on, odd));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<Quad> {
        let number = |c: usize| (c as f64 * 0.618_033_988_749_894_9).fract() - 0.5;
        let quad = |k: usize| Quad {
            re: from_fn(|lane| number(8 * k + lane)),
            im: from_fn(|lane| number(8 * k + LANES + lane)),
        };
        (0..n).map(quad).collect()
    }

    #[test]
    fn a_transform_is_the_sum_that_defines_it() {
        // Each factor as the first and in a pass, parts of a long line, and a prime that is none of the factors.
        for n in [2, 3, 4, 5, 7, 11, 13, 8, 9, 25, 49, 121, 169, 60, 450, 650, 17, 74] {
            let (lines, from) = (Lines::new(n), noise(n));
            let mut to = [vec![Quad::default(); n], vec![Quad::default(); n]];
            let mut scratch = vec![Complex64::default(); lines.scratch_len()];
            lines.forward::<false>(&from, &mut to[0], &mut scratch);
            lines.forward::<true>(&from, &mut to[1], &mut scratch);
            for (k, lane) in (0..n).flat_map(|k| (0..LANES).map(move |lane| (k, lane))) {
                let mut sums = [Complex64::default(); 2];
                for (j, quad) in from.iter().enumerate() {
                    sums[0] += Complex64::new(quad.re[lane], quad.im[lane]) * root(j * k, n);
                    sums[1] += Complex64::new(quad.im[lane], quad.re[lane]) * root(j * k, n);
                }
                for (sum, to) in sums.iter().zip(&to) {
                    let error = (Complex64::new(to[k].re[lane], to[k].im[lane]) - sum).norm();
                    assert!(error < 1e-15 * n as f64, "length {n}, {k} of lane {lane}: off by {error}");
                }
            }
        }
    }

    #[test]
    fn every_processor_gives_the_same() {
        let (from, roots) = (noise(35), roots(5));
        let starts: Vec<_> = (0..7).collect();
        let mut to = [vec![Quad::default(); 35], vec![Quad::default(); 35]];
        let [any, this] = &mut to;
        Leaves::<5, false> { from: &from, to: any, starts: &starts, roots: &roots }.run(pulp::Scalar256b);
        run(Leaves::<5, false> { from: &from, to: this, starts: &starts, roots: &roots });
        for (any, this) in any.iter().zip(this) {
            for lane in 0..LANES {
                let error = (any.re[lane] - this.re[lane]).hypot(any.im[lane] - this.im[lane]);
                assert!(error < 1e-15, "lane {lane}: {error}");
            }
        }
    }
}
