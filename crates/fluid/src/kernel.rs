//! Loops over the grid, compiled for the processor at hand.

use std::ops::Range;

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

/// What one component of the local solve reads at each point.
#[derive(Clone)]
pub struct Component<'a> {
    /// This component of the velocity.
    pub u: &'a [f64],
    /// The same one step earlier.
    pub u_before: &'a [f64],
    /// `w = u + tau G` of the last step.
    pub w: &'a [f64],
    /// `1/tau` of the last step.
    pub per_tau: f64,
    /// Vorticity.
    pub omega: &'a [f64],
    /// The same one step earlier.
    pub omega_before: &'a [f64],
    /// The other component of the velocity: this one of `omega × u` is `sign · omega · other`.
    pub other: &'a [f64],
    /// The same one step earlier.
    pub other_before: &'a [f64],
    /// −1 for x, 1 for y.
    pub sign: f64,
}

impl<'a> Component<'a> {
    /// The same for some of the points.
    pub fn points(&self, points: Range<usize>) -> Self {
        let part = |field: &'a [f64]| &field[points.clone()];
        Self {
            u: part(self.u),
            u_before: part(self.u_before),
            w: part(self.w),
            omega: part(self.omega),
            omega_before: part(self.omega_before),
            other: part(self.other),
            other_before: part(self.other_before),
            ..*self
        }
    }

    /// At point `i`: the right-hand side without the bodies, `c_1 u^n + c_2 u^{n−1} − e_1 N^n − e_2 N^{n−1} − G^n`, and
    /// G^n.
    #[inline(always)]
    pub fn right_side(&self, &Differences { c, e, .. }: &Differences, i: usize) -> (f64, f64) {
        let n = self.sign * self.omega[i] * self.other[i];
        let n_before = self.sign * self.omega_before[i] * self.other_before[i];
        let g = self.per_tau * (self.w[i] - self.u[i]);
        (c[1] * self.u[i] + c[2] * self.u_before[i] - e[0] * n - e[1] * n_before - g, g)
    }
}

/// u* + tau G without the velocities of the bodies, at points with the total drag rate `rate`.
#[multiversion(targets("x86_64+avx2+fma"))]
pub fn solve(component: &Component, scheme: &Differences, rate: &[f64], w: &mut [f64]) {
    let component = component.points(0..w.len());
    for (i, (w, rate)) in w.iter_mut().zip(rate).enumerate() {
        let (r, g) = component.right_side(scheme, i);
        *w = r / (scheme.c[0] + rate) + scheme.tau * g;
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
