//! Energy of the vertex between two edges, with first and second derivatives by the edges.
//!
//! An edge e has the length l and the unit tangent t = e/l; c = t_1 · t_2 is the cosine of the turning angle ψ.

use nalgebra::{SMatrix, Vector2};
use structure::{Matrix, Vector};

/// Angle below which functions of ψ use their series, rad.
const SMALL_ANGLE: f64 = 1e-2;

/// Unit tangent and length of an edge.
#[derive(Clone, Copy)]
pub struct Edge<const D: usize> {
    /// Unit tangent.
    pub t: Vector<D>,
    /// Length, m.
    pub l: f64,
    /// 1/l, 1/m.
    pub inverse_l: f64,
}

/// Value of a function of ψ, with its first and second derivative.
pub(crate) struct Jet(pub(crate) f64, pub(crate) f64, pub(crate) f64);

/// Derivatives ∂ψ/∂e of the signed angle between the projections of two edges into a plane, 1/m.
pub(crate) struct ProjectedAngle {
    pub(crate) by_before: Vector2<f64>,
    pub(crate) by_after: Vector2<f64>,
}

/// Derivatives of the energy of a vertex by the edges `before` and `after` it: gradient, N, and Hessian, N/m.
pub struct VertexDerivatives<const D: usize> {
    /// Gradient by the edge before.
    pub by_before: Vector<D>,
    /// Gradient by the edge after.
    pub by_after: Vector<D>,
    /// Hessian by the edge before.
    pub before_before: Matrix<D>,
    /// Hessian by the edge before (rows) and the edge after (columns).
    pub before_after: Matrix<D>,
    /// Hessian by the edge after.
    pub after_after: Matrix<D>,
}

/// Derivatives of the energy of a vertex by c, and of c by the two edges.
pub struct CosineSlope<const D: usize> {
    c: f64,
    /// Derivative of the energy by c, J.
    pub by_c: f64,
    by_c_twice: f64,
    /// Derivative of c by the edge before, 1/m.
    pub c_by_before: Vector<D>,
    /// Derivative of c by the edge after, 1/m.
    pub c_by_after: Vector<D>,
}

impl<const D: usize> Edge<D> {
    /// Return the edge from `start` to `end`.
    pub fn between(start: Vector<D>, end: Vector<D>) -> Self {
        let e = end - start;
        // The root and the division run in parallel.
        let square = e.norm_squared();
        let l = square.sqrt();
        let inverse_l = l * (1.0 / square);
        Self { t: e * inverse_l, l, inverse_l }
    }

    /// Return the components along x and `axis`, m.
    pub(crate) fn projection(self, axis: usize) -> Vector2<f64> {
        Vector2::new(self.t[0], self.t[axis]) * self.l
    }

    /// Return the turning angle ψ, rad: signed in the plane, its magnitude in space.
    pub(crate) fn angle(self, after: Self) -> f64 {
        if D == 2 {
            (self.t[0] * after.t[1] - self.t[1] * after.t[0]).atan2(self.t.dot(&after.t))
        } else {
            2.0 * (after.t - self.t).norm().atan2((after.t + self.t).norm())
        }
    }

    /// Return κ = 2 tan(ψ/2) = 2 sin ψ/(1 + c) in the plane from `above_fold` = 1 + c; κ' = 1 + κ²/4 = 2/(1 + c).
    #[inline(always)]
    pub(crate) fn kappa(self, after: Self, above_fold: f64) -> Jet {
        let slope = 2.0 / above_fold;
        let kappa = (self.t[0] * after.t[1] - self.t[1] * after.t[0]) * slope;
        Jet(kappa, slope, 0.5 * kappa * slope)
    }
}

impl<const D: usize> CosineSlope<D> {
    /// Return the derivatives of 2 k_b (1 − c)/(1 + c) from `above_fold` = 1 + c.
    pub fn new(before: Edge<D>, after: Edge<D>, above_fold: f64, k_b: f64) -> Self {
        let c = above_fold - 1.0;
        let inverse = 1.0 / above_fold;
        let by_c = -4.0 * k_b * inverse * inverse;
        Self {
            c,
            by_c,
            by_c_twice: -2.0 * by_c * inverse,
            c_by_before: (after.t - before.t * c) * before.inverse_l,
            c_by_after: (before.t - after.t * c) * after.inverse_l,
        }
    }

    /// Return the derivatives of ½ k_b ψ²: ∂/∂c = −k_b ψ/sin ψ, ∂²/∂c² = k_b (sin ψ − ψ cos ψ)/sin³ ψ.
    pub(crate) fn of_angle(before: Edge<D>, after: Edge<D>, above_fold: f64, k_b: f64) -> Self {
        let psi = before.angle(after);
        let (sin, cos) = psi.sin_cos();
        // The differences lose their digits at a small angle; the next terms of the series are of order ψ⁴.
        let (by_c, by_c_twice) = if psi < SMALL_ANGLE {
            let square = psi * psi;
            (1.0 + square / 6.0 + square * square * (7.0 / 360.0), 1.0 / 3.0 + square * (2.0 / 15.0))
        } else {
            (psi / sin, (sin - psi * cos) / sin.powi(3))
        };
        Self { by_c: -k_b * by_c, by_c_twice: k_b * by_c_twice, ..Self::new(before, after, above_fold, k_b) }
    }
}

impl<const D: usize> VertexDerivatives<D> {
    /// Return the derivatives of a vertex without energy.
    pub(crate) fn zeros() -> Self {
        Self {
            by_before: Vector::zeros(),
            by_after: Vector::zeros(),
            before_before: Matrix::zeros(),
            before_after: Matrix::zeros(),
            after_after: Matrix::zeros(),
        }
    }

    /// Return the derivatives of an energy of c from its `slope`.
    pub fn straight(before: Edge<D>, after: Edge<D>, slope: &CosineSlope<D>) -> Self {
        let CosineSlope { c, by_c, by_c_twice, c_by_before, c_by_after } = *slope;
        // ∂²c/∂e∂e = [c (3 t tᵀ − 1) − t_1 t_2ᵀ − t_2 t_1ᵀ] / l².
        let mixed = before.t * after.t.transpose();
        let both = mixed + mixed.transpose();
        let own = |edge: Edge<D>, slope: Vector<D>| {
            let weight = by_c * edge.inverse_l * edge.inverse_l;
            edge.t * (edge.t * (3.0 * c * weight)).transpose()
                - Matrix::from_diagonal_element(c * weight)
                - both * weight
                + slope * (slope * by_c_twice).transpose()
        };
        // ∂²c/∂e_1∂e_2 = [1 − t_2 t_2ᵀ − t_1 (t_1 − c t_2)ᵀ] / (l_1 l_2).
        let weight = by_c * before.inverse_l * after.inverse_l;
        let before_after = Matrix::from_diagonal_element(weight)
            - after.t * (after.t * weight).transpose()
            - before.t * (c_by_after * (after.l * weight)).transpose()
            + c_by_before * (c_by_after * by_c_twice).transpose();
        Self {
            by_before: c_by_before * by_c,
            by_after: c_by_after * by_c,
            before_before: own(before, c_by_before),
            before_after,
            after_after: own(after, c_by_after),
        }
    }

    /// Return the derivatives of k_b g(ψ), with the signed angle ψ in the plane.
    #[inline(always)]
    pub(crate) fn planar(before: Edge<D>, after: Edge<D>, k_b: f64, Jet(_, slope, curvature): Jet) -> Self {
        let (slope, curvature) = (k_b * slope, k_b * curvature);
        let across = |Edge { t, inverse_l, .. }: Edge<D>| [-t[1] * inverse_l, t[0] * inverse_l];
        let vector = |[x, y]: [f64; 2], by: f64| {
            let mut vector = Vector::zeros();
            (vector[0], vector[1]) = (x * by, y * by);
            vector
        };
        // With the direction θ of the edge, g is ∂θ/∂e, and `angle_hessian` has ∂²θ/∂e∂e.
        let own = |[x, y]: [f64; 2], slope: f64| {
            let (xx, xy, yy) = (x * x, x * y, y * y);
            let mixed = curvature * xy + slope * (xx - yy);
            let mut own = Matrix::zeros();
            (own[(0, 0)], own[(1, 1)]) = (curvature * xx - 2.0 * slope * xy, curvature * yy + 2.0 * slope * xy);
            (own[(0, 1)], own[(1, 0)]) = (mixed, mixed);
            own
        };
        let (g, h) = (across(before), across(after));
        Self {
            by_before: vector(g, -slope),
            by_after: vector(h, slope),
            before_before: own(g, -slope),
            before_after: vector(g, -curvature) * vector(h, 1.0).transpose(),
            after_after: own(h, slope),
        }
    }

    /// Add the energy k_b g(ψ) of an angle in the plane of x and `axis`.
    pub(crate) fn with_projected_angle(
        mut self,
        turn: &ProjectedAngle,
        axis: usize,
        k_b: f64,
        Jet(_, slope, curvature): Jet,
    ) -> Self {
        let (slope, curvature) = (k_b * slope, k_b * curvature);
        let places = [0, axis];
        let before_hessian = -angle_hessian(-turn.by_before);
        let after_hessian = angle_hessian(turn.by_after);
        for (i, &row) in places.iter().enumerate() {
            self.by_before[row] += slope * turn.by_before[i];
            self.by_after[row] += slope * turn.by_after[i];
            for (j, &column) in places.iter().enumerate() {
                let at = (row, column);
                self.before_before[at] +=
                    curvature * turn.by_before[i] * turn.by_before[j] + slope * before_hessian[(i, j)];
                self.before_after[at] += curvature * turn.by_before[i] * turn.by_after[j];
                self.after_after[at] += curvature * turn.by_after[i] * turn.by_after[j] + slope * after_hessian[(i, j)];
            }
        }
        self
    }
}

/// Return ∂θ/∂p of θ = atan2(p_y, p_x).
pub(crate) fn angle_gradient(p: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-p.y, p.x) / p.norm_squared()
}

/// Return ∂²θ/∂p∂p from the gradient: g = (−p_y, p_x)/|p|² has p/|p|² = (g_y, −g_x).
fn angle_hessian(g: Vector2<f64>) -> SMatrix<f64, 2, 2> {
    let (xx, xy) = (-2.0 * g.x * g.y, g.x * g.x - g.y * g.y);
    SMatrix::<f64, 2, 2>::new(xx, xy, xy, -xx)
}

/// Return ½ (f − rest)².
pub(crate) fn half_square(Jet(f, slope, curvature): Jet, rest: f64) -> Jet {
    let off = f - rest;
    Jet(0.5 * off * off, off * slope, slope * slope + off * curvature)
}
