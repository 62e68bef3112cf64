//! Triangle of the membrane: constant strain, law of St. Venant–Kirchhoff, and the geometry of its edges.
//!
//! With the deformation gradient F = Σ x_j ⊗ ∇λ_j of the rest plane and the strain E = ½ (FᵀF − 1),
//!
//! ```text
//! U = A (½ E : C : E + T tr E),     S = C : E + T,     ∂U/∂x_j = A F S ∇λ_j,
//! C : E = E h/(1 − ν²) [(1 − ν) E + ν tr E]     (plane stress).
//! ```

use nalgebra::{Matrix3, Vector2};

use crate::geometry::Vector;
use crate::parameters::Membrane;

/// Triangle at rest.
pub(crate) struct Face {
    pub(crate) nodes: [usize; 3],
    /// Area, m².
    pub(crate) area: f64,
    /// Mass, kg.
    pub(crate) mass: f64,
    /// ∇λ_j in the plane of the triangle, 1/m.
    gradients: [Vector2<f64>; 3],
    /// E h/(1 − ν²), N/m.
    stiffness: f64,
    poisson_ratio: f64,
    /// Tension at rest, N/m.
    tension: f64,
}

/// Triangle in the present shape.
#[derive(Clone, Copy)]
pub(crate) struct FaceShape {
    pub(crate) normal: Vector,
    /// Edge opposite to each corner, from the next corner to the one after it, m, and one over its length, 1/m.
    pub(crate) edges: [Vector; 3],
    pub(crate) over: [f64; 3],
    /// p_i · ∇λ_j, 1/m, with p_i across edge i: the turn of each edge by each corner that moves along the normal.
    pub(crate) by_across: Matrix3<f64>,
}

/// Components p · ∇λ_j and t · ∇λ_j, 1/m, of the frame (t, p, n) of an edge; p points to the opposite corner.
pub(crate) struct EdgeFrame {
    pub(crate) along: Vector,
    pub(crate) across: Vector,
    pub(crate) by_along: [f64; 3],
    pub(crate) by_across: [f64; 3],
}

/// Signs of t_i · ∇λ_j.
const ALONG: [[f64; 3]; 3] = [[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]];

impl FaceShape {
    /// Return the shape of a triangle; `None` if it has no area.
    #[inline(always)]
    pub(crate) fn new([a, b, c]: [Vector; 3]) -> Option<Self> {
        let twice = (b - a).cross(&(c - a));
        let area = twice.norm();
        if !area.is_normal() {
            return None;
        }
        let over_area = 1.0 / area;
        let edges = [c - b, a - c, b - a];
        let [e_0, e_1, e_2] = edges;
        let (e_01, e_12, e_20) = (e_0.dot(&e_1), e_1.dot(&e_2), e_2.dot(&e_0));
        let squares = edges.map(|edge| edge.norm_squared());
        let over = squares.map(|square| 1.0 / square.sqrt());
        let [r_0, r_1, r_2] = over.map(|over| over * over_area);
        let [s_0, s_1, s_2] = squares;
        #[rustfmt::skip]
        let by_across = Matrix3::new(
            s_0 * r_0, e_01 * r_0, e_20 * r_0,
            e_01 * r_1, s_1 * r_1, e_12 * r_1,
            e_20 * r_2, e_12 * r_2, s_2 * r_2,
        );
        Some(Self { normal: twice * over_area, edges, over, by_across })
    }

    /// Return the frame of the edge opposite to corner `i`.
    pub(crate) fn edge(&self, i: usize) -> EdgeFrame {
        let over = self.over[i];
        let along = self.edges[i] * over;
        let by_along = ALONG[i].map(|sign| sign * over);
        let by_across = std::array::from_fn(|j| self.by_across[(i, j)]);
        EdgeFrame { along, across: self.normal.cross(&along), by_along, by_across }
    }
}

impl Face {
    /// Return the triangle between the nodes at `corners`.
    pub(crate) fn new(nodes: [usize; 3], corners: [Vector; 3], membrane: &Membrane) -> Self {
        let [u, v] = [corners[1] - corners[0], corners[2] - corners[0]];
        let e1 = u.normalize();
        let e2 = (v - e1 * e1.dot(&v)).normalize();
        let flat = [Vector2::zeros(), Vector2::new(u.norm(), 0.0), Vector2::new(e1.dot(&v), e2.dot(&v))];
        let area = 0.5 * flat[1].x * flat[2].y;
        let gradients = std::array::from_fn(|j| {
            let edge = flat[(j + 2) % 3] - flat[(j + 1) % 3];
            Vector2::new(-edge.y, edge.x) / (2.0 * area)
        });
        let nu = membrane.poisson_ratio;
        Self {
            nodes,
            area,
            mass: area * membrane.areal_density,
            gradients,
            stiffness: membrane.stretching_stiffness / (1.0 - nu * nu),
            poisson_ratio: nu,
            tension: membrane.tension,
        }
    }

    /// Return C : E for a strain (E_11, E_22, 2 E_12).
    #[inline(always)]
    fn law(&self, [e_11, e_22, e_12]: [f64; 3]) -> [f64; 3] {
        let (k, nu) = (self.stiffness, self.poisson_ratio);
        [k * (e_11 + nu * e_22), k * (e_22 + nu * e_11), k * 0.5 * (1.0 - nu) * e_12]
    }

    /// Return the columns of Σ y_j ⊗ ∇λ_j.
    #[inline(always)]
    fn columns(&self, y: &[Vector]) -> [Vector; 2] {
        let mut columns = [Vector::zeros(); 2];
        for (&k, gradient) in self.nodes.iter().zip(&self.gradients) {
            columns[0] += y[k] * gradient.x;
            columns[1] += y[k] * gradient.y;
        }
        columns
    }

    #[inline(always)]
    fn strain([f_1, f_2]: &[Vector; 2]) -> [f64; 3] {
        [0.5 * (f_1.norm_squared() - 1.0), 0.5 * (f_2.norm_squared() - 1.0), f_1.dot(f_2)]
    }

    /// Return the energy in the shape `x`, J.
    pub(crate) fn energy(&self, x: &[Vector]) -> f64 {
        let strain = Self::strain(&self.columns(x));
        let stress = self.law(strain);
        let work: f64 = strain.iter().zip(&stress).map(|(strain, stress)| strain * stress).sum();
        self.area * (0.5 * work + self.tension * (strain[0] + strain[1]))
    }

    /// Return the tension at rest times the area, J.
    pub(crate) fn tension_energy(&self) -> f64 {
        self.area * self.tension.abs()
    }

    /// Return F and the stress S + τ C : E', N/m, of the shape `x` that moves at `v`.
    #[inline(always)]
    pub(crate) fn stress(&self, x: &[Vector], rates: Option<(&[Vector], f64)>) -> ([Vector; 2], [f64; 3]) {
        let f = self.columns(x);
        let mut strain = Self::strain(&f);
        if let Some((v, tau)) = rates {
            let g = self.columns(v);
            strain[0] += tau * f[0].dot(&g[0]);
            strain[1] += tau * f[1].dot(&g[1]);
            strain[2] += tau * (f[0].dot(&g[1]) + f[1].dot(&g[0]));
        }
        let [s_11, s_22, s_12] = self.law(strain);
        (f, [s_11 + self.tension, s_22 + self.tension, s_12])
    }

    /// Return the first-order change of the stress in the shape `x`, N/m, by changes of the positions of the corners.
    pub(crate) fn stress_change(&self, x: &[Vector], changes: [Vector; 3], viscous: f64) -> [f64; 3] {
        let f = self.columns(x);
        let mut d = [Vector::zeros(); 2];
        for (change, gradient) in changes.iter().zip(&self.gradients) {
            d[0] += change * gradient.x;
            d[1] += change * gradient.y;
        }
        self.law([f[0].dot(&d[0]), f[1].dot(&d[1]), f[0].dot(&d[1]) + f[1].dot(&d[0])]).map(|stress| viscous * stress)
    }

    /// Return the gradient by the corners, N.
    #[inline(always)]
    pub(crate) fn gradient(&self, x: &[Vector], rates: Option<(&[Vector], f64)>) -> [Vector; 3] {
        let (f, [s_11, s_22, s_12]) = self.stress(x, rates);
        let fluxes = [f[0] * s_11 + f[1] * s_12, f[0] * s_12 + f[1] * s_22];
        self.gradients.map(|g| (fluxes[0] * g.x + fluxes[1] * g.y) * self.area)
    }

    /// Return the Hessian by the corners j ≥ k, N/m: (0,0), (1,0), (2,0), (1,1), (2,1), (2,2).
    ///
    /// `viscous` is 1 + τ dv/du. A `safe` Hessian leaves out compressive stress, and is positive semi-definite.
    #[inline(always)]
    pub(crate) fn hessian(&self, x: &[Vector], stress: [f64; 3], viscous: f64, safe: bool) -> [Matrix3<f64>; 6] {
        let f = self.columns(x);
        let [s_11, s_22, s_12] = if safe { tensile(stress) } else { stress };
        let rows = self.gradients.map(|g| [f[0] * g.x, f[1] * g.y, f[0] * g.y + f[1] * g.x]);
        let (k, nu) = (self.area * self.stiffness * viscous, self.poisson_ratio);
        let shear = 0.5 * (1.0 - nu);
        let by_law = rows.map(|[a, b, c]| [(a + b * nu) * k, (b + a * nu) * k, c * (shear * k)]);
        let mut blocks = [Matrix3::zeros(); 6];
        for (block, (j, l)) in blocks.iter_mut().zip(PAIRS) {
            let (a, b) = (&rows[j], &by_law[l]);
            let (g, h) = (&self.gradients[j], &self.gradients[l]);
            let tension = g.x * (s_11 * h.x + s_12 * h.y) + g.y * (s_12 * h.x + s_22 * h.y);
            *block = Matrix3::from_fn(|r, c| a[0][r] * b[0][c] + a[1][r] * b[1][c] + a[2][r] * b[2][c]);
            for i in 0..3 {
                block[(i, i)] += self.area * tension;
            }
        }
        blocks
    }
}

/// Pairs (j, k), j ≥ k, of the corners of a triangle.
pub(crate) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)];

/// Return the tensile part of a stress (S_11, S_22, S_12).
fn tensile([s_11, s_22, s_12]: [f64; 3]) -> [f64; 3] {
    let (mean, half) = (0.5 * (s_11 + s_22), 0.5 * (s_11 - s_22));
    let radius = half.hypot(s_12);
    if mean >= radius {
        return [s_11, s_22, s_12];
    }
    if mean <= -radius {
        return [0.0; 3];
    }
    // One principal stress is compressive; keep the other along its direction.
    let scale = 0.5 * (mean + radius) / radius;
    [(radius + half) * scale, (radius - half) * scale, s_12 * scale]
}
