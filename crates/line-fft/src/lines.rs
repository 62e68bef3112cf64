//! Discrete Fourier transforms of several lines at once, one in each lane of a vector.
//!
//! All lanes do the same, so no factor of a length needs shuffles, and 13 is as good as 4. Decimation in time
//! (Cooley & Tukey 1965): transforms of the last factor from strided input, then a pass for each other factor in place.

#![allow(clippy::needless_range_loop, reason = "what runs over lanes or a butterfly is unrolled, by index")]

use std::array::from_fn;
use std::f64::consts::TAU;
use std::sync::Arc;

use rustfft::{
    Fft,
    num_complex::{Complex, Complex64},
};

use crate::pack::{Complexes, Pack};
use crate::simd::{Arithmetic, Kernel, Real, run};

/// Lines longer than this are transformed in parts: a part and its input stay in the first cache.
const FIRST_CACHE_LENGTH: usize = 384;

/// Transforms of one length.
pub enum Lines<R: Real> {
    /// A length without prime factors above 13.
    Smooth(Smooth<R>),
    /// Any length, one line after the other.
    Any(Arc<dyn Fft<R>>),
}

/// Plan for a length with small factors.
pub struct Smooth<R> {
    /// First factor, and its [`roots`].
    leaf: (usize, Vec<Complex<R>>),
    /// Place in the input where each transform of the first factor begins.
    starts: Vec<usize>,
    passes: Vec<Pass<R>>,
}

/// Combine transforms of length `m` to transforms of length `factor m`.
struct Pass<R> {
    factor: usize,
    m: usize,
    roots: Vec<Complex<R>>,
    /// `exp(−2πi r k/(factor m))` for r = 1 … factor − 1, then k.
    twiddles: Vec<Complex<R>>,
}

fn root(numerator: usize, n: usize) -> Complex64 {
    Complex64::from_polar(1.0, -TAU * (numerator % n) as f64 / n as f64)
}

/// `exp(−2πi j k/p)` for j = 1 … p/2, then k.
fn roots<R: Real>(p: usize) -> Vec<Complex<R>> {
    (1..=p / 2).flat_map(|k| (1..=p / 2).map(move |j| R::complex(root(j * k, p)))).collect()
}

impl<R: Real> Lines<R> {
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
            return Self::Any(R::any_length(n));
        }
        let mut m = factors[0];
        let mut starts = vec![0];
        for (level, factor) in factors.iter().enumerate().skip(1).rev() {
            // The remainders of the outermost factor are the slowest in the output and one apart in the input.
            let apart: usize = factors[level + 1..].iter().product();
            starts = starts.iter().flat_map(|start| (0..*factor).map(move |r| start + r * apart)).collect();
        }
        let passes = factors[1..].iter().map(|&factor| {
            let twiddles = (0..m).flat_map(|k| (1..factor).map(move |r| R::complex(root(r * k, factor * m)))).collect();
            let pass = Pass { factor, m, roots: roots(factor), twiddles };
            m *= factor;
            pass
        });
        let passes = passes.collect();
        Self::Smooth(Smooth { leaf: (factors[0], roots(factors[0])), starts, passes })
    }

    /// Return the gain of each mode in a round trip (inverse, then forward) over the length.
    ///
    /// Rounded roots of unity do not have the absolute value 1. The excess is the same in every round trip, so it adds
    /// up.
    pub fn gains(&self) -> Vec<f64> {
        match self {
            Self::Smooth(smooth) => smooth.gains(),
            Self::Any(fft) => vec![1.0; fft.len()],
        }
    }

    /// Return the number of complex values in the scratch space of [`Self::forward`].
    pub fn scratch_len(&self) -> usize {
        match self {
            Self::Smooth(_) => 0,
            Self::Any(fft) => fft.len() + fft.get_inplace_scratch_len(),
        }
    }

    /// Write `to[k] = Σ_j from[j] exp(−2πi j k/n)`.
    ///
    /// With `EXCHANGE` real and imaginary parts of the input are swapped: the output is the inverse transform, also
    /// with its parts swapped.
    pub fn forward<const EXCHANGE: bool>(&self, from: &[Pack<R>], to: &mut [Pack<R>], scratch: &mut [Complex<R>]) {
        match self {
            Self::Smooth(smooth) => smooth.forward::<EXCHANGE>(from, to),
            Self::Any(fft) => {
                let (line, scratch) = scratch.split_at_mut(fft.len());
                for lane in 0..R::LANES {
                    for (value, pack) in line.iter_mut().zip(from) {
                        let (re, im) = (pack.re[lane], pack.im[lane]);
                        *value = if EXCHANGE { Complex::new(im, re) } else { Complex::new(re, im) };
                    }
                    fft.process_with_scratch(line, &mut scratch[..fft.get_inplace_scratch_len()]);
                    for (value, pack) in line.iter().zip(&mut *to) {
                        (pack.re[lane], pack.im[lane]) = (value.re, value.im);
                    }
                }
            }
        }
    }
}

impl<R: Real> Smooth<R> {
    fn forward<const EXCHANGE: bool>(&self, from: &[Pack<R>], to: &mut [Pack<R>]) {
        let (inner, outer) = match self.passes.split_last() {
            Some((last, inner)) if to.len() > FIRST_CACHE_LENGTH => (inner, Some(last)),
            _ => (&self.passes[..], None),
        };
        let part = outer.map_or(to.len(), |pass| pass.m);
        let (leaf, roots) = &self.leaf;
        for (to, starts) in to.chunks_exact_mut(part).zip(self.starts.chunks_exact(part / leaf)) {
            match leaf {
                2 => run(Leaves::<R, 2, EXCHANGE> { from, to, starts, roots }),
                3 => run(Leaves::<R, 3, EXCHANGE> { from, to, starts, roots }),
                4 => run(Leaves::<R, 4, EXCHANGE> { from, to, starts, roots }),
                5 => run(Leaves::<R, 5, EXCHANGE> { from, to, starts, roots }),
                7 => run(Leaves::<R, 7, EXCHANGE> { from, to, starts, roots }),
                11 => run(Leaves::<R, 11, EXCHANGE> { from, to, starts, roots }),
                _ => run(Leaves::<R, 13, EXCHANGE> { from, to, starts, roots }),
            }
            inner.iter().for_each(|pass| pass.apply(to));
        }
        outer.into_iter().for_each(|pass| pass.apply(to));
    }
}

impl<R: Real> Smooth<R> {
    /// Return [`Lines::gains`], to first order in the rounding.
    ///
    /// The weight of an input in an output is a product with one factor for each pass. So the mean over the inputs of
    /// the squared weight, less 1, is a sum over the passes; so is the mean over the outputs. A mode is an output of
    /// the forward transform and an input of the inverse one: its gain is half of both sums.
    fn gains(&self) -> Vec<f64> {
        /// Gains nearer to 1 have no effect in any number of steps. In double precision all are nearer.
        const NO_EFFECT: f64 = 1e-12;
        let (leaf, roots) = &self.leaf;
        let first = Pass {
            factor: *leaf,
            m: 1,
            roots: roots.clone(),
            twiddles: vec![Complex::new(R::one(), R::zero()); leaf - 1],
        };
        let mut n = leaf * self.passes.iter().map(|pass| pass.factor).product::<usize>();
        let mut gains = vec![1.0; n];
        for pass in self.passes.iter().rev().chain([&first]) {
            let (factor, m) = (pass.factor, pass.m);
            let [mut of_input, mut of_output] = [vec![0.0; factor], vec![0.0; factor * m]];
            for (k, r, q) in (0..m).flat_map(|k| (0..factor * factor).map(move |n| (k, n / factor, n % factor))) {
                let excess = pass.square(q, r, k) - 1.0;
                of_input[q] += 0.5 * excess / (factor * m) as f64;
                of_output[r * m + k] += 0.5 * excess / factor as f64;
            }
            // Distance of two inputs of one transform of this pass: the product of the factors of the later passes.
            let apart = gains.len() / n;
            for (mode, gain) in gains.iter_mut().enumerate() {
                *gain += of_input[mode / apart % factor] + of_output[mode % (factor * m)];
            }
            n = m;
        }
        gains.into_iter().map(|gain: f64| if (gain - 1.0).abs() < NO_EFFECT { 1.0 } else { gain }).collect()
    }
}

impl<R: Real> Pass<R> {
    /// Return the squared weight of part q in the output `r m + k`.
    fn square(&self, q: usize, r: usize, k: usize) -> f64 {
        let square = |of: Complex<R>| of.re.to_f64().powi(2) + of.im.to_f64().powi(2);
        let p = self.factor;
        let twiddle = if q == 0 { 1.0 } else { square(self.twiddles[k * (p - 1) + q - 1]) };
        // The weights of 2 and 4 are exact.
        let root = match (q.min(p - q), r.min(p - r)) {
            (0, _) | (_, 0) => 1.0,
            _ if p == 2 || p == 4 => 1.0,
            (q, r) => square(self.roots[(r - 1) * (p / 2) + q - 1]),
        };
        twiddle * root
    }

    fn apply(&self, lines: &mut [Pack<R>]) {
        let pass = self;
        match pass.factor {
            2 => run(Combine::<R, 2> { pass, lines }),
            3 => run(Combine::<R, 3> { pass, lines }),
            4 => run(Combine::<R, 4> { pass, lines }),
            5 => run(Combine::<R, 5> { pass, lines }),
            7 => run(Combine::<R, 7> { pass, lines }),
            11 => run(Combine::<R, 11> { pass, lines }),
            _ => run(Combine::<R, 13> { pass, lines }),
        }
    }
}

/// Transform lines of length `P` from strided input.
struct Leaves<'a, R: Real, const P: usize, const EXCHANGE: bool> {
    from: &'a [Pack<R>],
    to: &'a mut [Pack<R>],
    starts: &'a [usize],
    roots: &'a [Complex<R>],
}

impl<R: Real, const P: usize, const EXCHANGE: bool> Kernel for Leaves<'_, R, P, EXCHANGE> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let roots = self.roots;
        let stride = self.from.len() / P;
        let from: [&[Pack<R>]; P] = from_fn(|j| &self.from[j * stride..][..stride]);
        for (to, &start) in self.to.as_chunks_mut::<P>().0.iter_mut().zip(self.starts) {
            let mut x = [Complexes::zero(); P];
            for j in 0..P {
                let value = Complexes::load(&from[j][start]);
                x[j] = if EXCHANGE { value.exchanged() } else { value };
            }
            butterfly(on, x, roots, |k, value| to[k] = value.pack());
        }
    }
}

/// [`Pass::apply`] for the factor `P`.
struct Combine<'a, R: Real, const P: usize> {
    pass: &'a Pass<R>,
    lines: &'a mut [Pack<R>],
}

impl<R: Real, const P: usize> Kernel for Combine<'_, R, P> {
    type Real = R;

    #[inline(always)]
    fn run(self, on: impl Arithmetic<R>) {
        let Pass { m, ref roots, ref twiddles, .. } = *self.pass;
        for line in self.lines.chunks_exact_mut(P * m) {
            let mut rest = line;
            let mut parts: [&mut [Pack<R>]; P] = from_fn(|_| {
                let (part, others) = std::mem::take(&mut rest).split_at_mut(m);
                rest = others;
                part
            });
            for (k, twiddles) in twiddles.chunks_exact(P - 1).enumerate().take(m) {
                let mut x = [Complexes::load(&parts[0][k]); P];
                for r in 1..P {
                    x[r] = Complexes::load(&parts[r][k]).times(on, twiddles[r - 1]);
                }
                butterfly(on, x, roots, |r, value| parts[r][k] = value.pack());
            }
        }
    }
}

/// Transform `P` values, P = 2, 4 or odd, and call `store(k, value)` with each result.
#[inline(always)]
fn butterfly<R: Real, const P: usize>(
    on: impl Arithmetic<R>,
    mut x: [Complexes<R>; P],
    roots: &[Complex<R>],
    mut store: impl FnMut(usize, Complexes<R>),
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
            let mut even = x[0].mul_add(on, roots[0].re.splat(), x[1]);
            let mut odd = x[P - 1].scaled(on, roots[0].im.splat());
            for j in 2..half + 1 {
                even = even.mul_add(on, roots[j - 1].re.splat(), x[j]);
                odd = odd.mul_add(on, roots[j - 1].im.splat(), x[P - j]);
            }
            store(k, even.add_i(on, odd));
            store(P - k, even.sub_i(on, odd));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn every_processor_gives<R: Real>(rounding: f64)
    where
        pulp::Scalar256b: Arithmetic<R>,
    {
        let mut from = vec![Pack::<R>::default(); 35];
        for (k, pack) in from.iter_mut().enumerate() {
            for lane in 0..R::LANES {
                let phase = (R::LANES * k + lane) as f64;
                (pack.re[lane], pack.im[lane]) = (R::rounded(0.5 * phase.sin()), R::rounded(0.5 * phase.cos()));
            }
        }
        let (roots, starts) = (roots(5), (0..7).collect::<Vec<_>>());
        let mut to = [vec![Pack::default(); 35], vec![Pack::default(); 35]];
        let [any, this] = &mut to;
        Leaves::<R, 5, false> { from: &from, to: any, starts: &starts, roots: &roots }.run(pulp::Scalar256b);
        run(Leaves::<R, 5, false> { from: &from, to: this, starts: &starts, roots: &roots });
        for (any, this) in any.iter().zip(this) {
            for lane in 0..R::LANES {
                let off = [any.re[lane] - this.re[lane], any.im[lane] - this.im[lane]].map(R::to_f64);
                assert!(off.iter().all(|off| off.abs() < rounding), "lane {lane}: {off:?}");
            }
        }
    }

    #[test]
    fn every_processor_gives_the_same() {
        every_processor_gives::<f64>(1e-15);
        every_processor_gives::<f32>(5e-7);
    }
}
