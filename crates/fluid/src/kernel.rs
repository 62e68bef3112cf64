//! Loops over the grid, compiled for the processor at hand.

use multiversion::multiversion;

/// Coefficients of the two-step backward differences with a step that may change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// `∂u/∂t ≈ c_0 u^{n+1} − c_1 u^n − c_2 u^{n−1}`, 1/s.
    pub c: [f64; 3],
    /// Extrapolation to the new time: `e_1 N^n + e_2 N^{n−1}`.
    pub e: [f64; 2],
    /// 1/c_0, s.
    pub tau: f64,
}

impl Differences {
    /// A step `dt` after one of `before` seconds; `before` = 0: the first step, by backward Euler.
    pub fn new(dt: f64, before: f64) -> Self {
        if before == 0.0 {
            return Self { c: [1.0 / dt, 1.0 / dt, 0.0], e: [1.0, 0.0], tau: dt };
        }
        let r = dt / before;
        let c_0 = (1.0 + 2.0 * r) / ((1.0 + r) * dt);
        let c = [c_0, (1.0 + r) / dt, -r * r / ((1.0 + r) * dt)];
        Self { c, e: [1.0 + r, -r], tau: 1.0 / c_0 }
    }
}

/// One component of u* + tau G on a block of points; its histories move on by one step.
///
/// `(omega, other, sign)` make this component of `omega × u` as `sign · omega · other`.
#[multiversion(targets("x86_64+avx2+fma"))]
#[expect(clippy::too_many_arguments, reason = "separate slices are known not to overlap")]
pub fn solve_component(
    &Differences { c, e, tau }: &Differences,
    rate: &[f64],
    u: &[f64],
    (omega, other, sign): (&[f64], &[f64], f64),
    g: &[f64],
    u_before: &mut [f64],
    n_before: &mut [f64],
    w: &mut [f64],
) {
    let len = w.len();
    let (rate, u, omega, other, g) = (&rate[..len], &u[..len], &omega[..len], &other[..len], &g[..len]);
    let (u_before, n_before) = (&mut u_before[..len], &mut n_before[..len]);
    for i in 0..len {
        let n = sign * omega[i] * other[i];
        let r = c[1] * u[i] + c[2] * u_before[i] - e[0] * n - e[1] * n_before[i] - g[i];
        w[i] = r / (c[0] + rate[i]) + tau * g[i];
        u_before[i] = u[i];
        n_before[i] = n;
    }
}

/// `result = factor (a − b)`.
#[multiversion(targets("x86_64+avx2+fma"))]
pub fn difference(factor: f64, a: &[f64], b: &[f64], result: &mut [f64]) {
    for ((result, a), b) in result.iter_mut().zip(a).zip(b) {
        *result = factor * (a - b);
    }
}

/// Largest `|u|/dx + |v|/dy`, 1/s.
#[multiversion(targets("x86_64+avx2+fma"))]
pub fn advection_rate(per_dx: f64, per_dy: f64, u: &[f64], v: &[f64]) -> f64 {
    const LANES: usize = 8;
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let mut largest = [0.0; LANES];
    let ((u, u_rest), (v, v_rest)) = (u.as_chunks::<LANES>(), v.as_chunks::<LANES>());
    for (u, v) in u.iter().zip(v) {
        for lane in 0..LANES {
            largest[lane] = larger(u[lane].abs() * per_dx + v[lane].abs() * per_dy, largest[lane]);
        }
    }
    let rest = u_rest.iter().zip(v_rest).map(|(u, v)| u.abs() * per_dx + v.abs() * per_dy);
    largest.into_iter().chain(rest).fold(0.0, larger)
}
