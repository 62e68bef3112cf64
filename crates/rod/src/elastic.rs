//! Elastic energy of the rod with its exact gradient and Hessian, found by the edges e_j = x_j − x_{j−1}.
//!
//! With l = |e|, t = e/l and c = t_1 · t_2 the cosine of the turning angle ψ between neighbouring edges,
//!
//! ```text
//! U = Σ ½ k_e (l_j − l0)²  +  Σ ½ k_b κ_j²,      κ = 2 tan(ψ/2) = 2 |e_1 × e_2| / (|e_1| |e_2| + e_1 · e_2),
//! κ² = 4 (1 − c)/(1 + c).
//! ```
//!
//! κ is the discrete curvature of Bergou et al. (2008, *Discrete elastic rods*, ACM Trans. Graph. 27, 63): the energy
//! does not depend on the frame, in two as in three dimensions. With a straight rest shape it is a function of c
//! alone. At the clamp the clamp's direction takes the place of t_1, and the stiffness is 2 EI/l0 because only half
//! a segment belongs to that vertex; this and half a mass at the tip make the rod second order in l0. Folding back,
//! ψ → π, is an infinite barrier.
//!
//! In the plane κ has the sign of ψ, and sin ψ and c give it and its derivatives by ψ with one division; a rest shape that
//! is curved there has U = Σ ½ k_b (κ(ψ_j) − κ(ψ0_j))².
//!
//! With shear the bending energy is that of [`Shear`], a function of all κ.
//!
//! The projected model of the thesis (eqs. 2.1, 2.3, 2.4) is U = Σ ½ k_b (θ_j − θ_{j−1} − ψ0_j)², the same for φ in three
//! dimensions, with θ and φ the angles of the edges' projections into the planes xy and xz. Where the rod passes the
//! vertical, an angle jumps by π; a vertex that turns by more than a right angle in a projection is therefore refused.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{SMatrix, SVector, Vector2};

use crate::root::cross;
use crate::shear::Shear;

/// A point, velocity or force.
pub(crate) type Vector<const D: usize> = SVector<f64, D>;
/// Second derivatives by two points.
pub(crate) type Matrix<const D: usize> = SMatrix<f64, D, D>;

/// A vertex counts as folded where |e_1||e_2| + e_1·e_2 is below this part of l0²; a projection as vanished where its
/// squared length is.
pub(crate) const FOLD: f64 = 1e-12;
/// Below this angle, rad, functions of it are taken by their series.
const SMALL_ANGLE: f64 = 1e-2;

/// Springs of the rod.
pub(crate) struct Elastic<const D: usize> {
    /// Length of a segment at rest, l0, m.
    pub(crate) segment_length: f64,
    /// Length of each segment without tension, m: l0, but for what the pressure around the rod takes: `[n]`.
    pub(crate) slack: Vec<f64>,
    /// k_e of each segment, N/m: `[n]`.
    pub(crate) axial: Vec<f64>,
    /// k_b at the beginning of each segment, N m, the first that of the joint at the root: `[n]`.
    pub(crate) bending: Vec<f64>,
    /// How the root turns.
    pub(crate) joint: Joint,
    /// First node that moves by itself: 1, or 0 where the root is free.
    pub(crate) first: usize,
    /// Unit tangent at the clamp.
    pub(crate) direction: Vector<D>,
    /// What k_b goes with.
    pub(crate) angles: Angles,
    /// In series with k_b, in the plane and with invariant angles; `None`: stiff against shear.
    pub(crate) shear: Option<Shear>,
}

/// How the root turns against the direction of the clamp.
#[derive(Clone, Copy)]
pub(crate) enum Joint {
    /// Like a vertex between two segments.
    Clamped,
    /// Without resistance.
    Loose,
    /// By U = ½ k_b (ψ − rest)² + stored of the true angle ψ; at rest at 0 in space.
    Spring { rest: f64, stored: f64 },
}

/// What bending energy depends on.
pub(crate) enum Angles {
    /// κ of the true turning angle, 0 at rest.
    Straight,
    /// κ of the signed turning angle in the plane, at rest these: `[n]`.
    Curved(Vec<f64>),
    /// Turning angles of the projections, at rest these, rad: `[n]`.
    Projected(Vec<f64>),
}

/// Derivatives of the energy by the positions of a node, k, and those after it; 0 for nodes that do not exist.
pub(crate) struct NodeDerivatives<const D: usize> {
    /// ∂U/∂x_k, N.
    pub(crate) gradient: Vector<D>,
    /// ∂²U/∂x_k∂x_k, N/m.
    pub(crate) own: Matrix<D>,
    /// ∂²U/∂x_{k+1}∂x_k, N/m.
    pub(crate) next: Matrix<D>,
    /// ∂²U/∂x_{k+2}∂x_k, N/m.
    pub(crate) next_but_one: Matrix<D>,
    /// ∂κ/∂x_k, 1/m, of the vertices k − 1, k and k + 1; with shear only, where the second derivatives are those with the
    /// moments held.
    pub(crate) turns: [Vector<D>; 3],
}

/// Elastic energies, J (per metre of depth in two dimensions).
pub(crate) struct ElasticEnergy {
    pub(crate) stretching: f64,
    /// Shear included.
    pub(crate) bending: f64,
}

/// A shape that has no bending energy.
#[derive(Clone, Copy, Debug)]
pub(crate) enum BadShape {
    /// The rod folds back on itself at this node.
    Fold { node: usize },
    /// The projection into the plane of x and this axis vanishes, or turns by more than a right angle, at this node.
    Projection { node: usize, axis: usize },
}

/// An edge by its unit tangent, length, m, and one over that.
#[derive(Clone, Copy)]
struct Edge<const D: usize> {
    t: Vector<D>,
    l: f64,
    inverse_l: f64,
}

/// Derivatives of the energy of the vertex between two edges, `before` and `after`.
struct VertexDerivatives<const D: usize> {
    by_before: Vector<D>,
    by_after: Vector<D>,
    before_before: Matrix<D>,
    before_after: Matrix<D>,
    after_after: Matrix<D>,
}

/// The energy 2 k_b (1 − c)/(1 + c) of a vertex by c, and c by the two edges.
struct CosineSlope<const D: usize> {
    c: f64,
    by_c: f64,
    by_c_twice: f64,
    c_by_before: Vector<D>,
    c_by_after: Vector<D>,
}

/// ∂ψ/∂e, 1/m, of the signed turning angle between the projections of two edges into a plane.
struct Turn {
    by_before: Vector2<f64>,
    by_after: Vector2<f64>,
}

/// A function of a turning angle with its first two derivatives.
struct Jet(f64, f64, f64);

impl Angles {
    /// Of a rest shape that turns by `psi`, rad, at the beginning of each segment: `[n]`.
    pub(crate) fn curved(psi: Vec<f64>) -> Self {
        Self::Curved(psi.into_iter().map(|psi| 2.0 * (0.5 * psi).tan()).collect())
    }
}

impl<const D: usize> Elastic<D> {
    /// Energy of the shape `x`, `[n + 1]`.
    pub(crate) fn energy(&self, x: &[Vector<D>]) -> Result<ElasticEnergy, BadShape> {
        let mut energy = ElasticEnergy { stretching: 0.0, bending: 0.0 };
        let (mut before, mut sheared) = (self.clamped_edge(), 0.0);
        for (node, (ends, (k_e, k_b))) in x.windows(2).zip(self.axial.iter().zip(&self.bending)).enumerate() {
            let after = Edge::between(ends[0], ends[1]);
            energy.stretching += 0.5 * k_e * (after.l - self.slack[node]).powi(2);
            if let Some(shear) = &self.shear {
                energy.bending += shear.energy(node, self.turn(node, before, after)?.0, &mut sheared);
                if let (0, Joint::Spring { stored, .. }) = (node, self.joint) {
                    energy.bending += stored;
                }
                before = after;
                continue;
            }
            if let (0, Joint::Loose | Joint::Spring { .. }) = (node, self.joint) {
                energy.bending += self.joint_energy(before, after)?;
                before = after;
                continue;
            }
            energy.bending += match &self.angles {
                Angles::Straight => {
                    k_b * (after.t - before.t).norm_squared() / self.cosine_above_fold(node, before, after)?
                }
                Angles::Curved(rest) => {
                    let above_fold = self.cosine_above_fold(node, before, after)?;
                    k_b * half_square(before.kappa(after, above_fold), rest[node]).0
                }
                Angles::Projected(rest) => {
                    let mut sum = 0.0;
                    for axis in 1..D {
                        let (psi, _) = self.projected_turn(node, before, after, axis)?;
                        sum += k_b * half_square(Jet(psi, 1.0, 0.0), rest[node]).0;
                    }
                    sum
                }
            };
            before = after;
        }
        Ok(energy)
    }

    /// ∂U/∂x_k of the shape `x`, `[n + 1]`, for the free nodes k = first … n, given to `emit` in this order. `moments`, `[n]` with
    /// shear and empty without, become those of the shape.
    pub(crate) fn gradient(
        &self,
        x: &[Vector<D>],
        moments: &mut [f64],
        mut emit: impl FnMut(usize, Vector<D>),
    ) -> Result<(), BadShape> {
        self.find_moments(x, moments)?;
        let mut before = self.clamped_edge();
        // ∂U/∂e of the edge before and of the one before that: U goes by e_k = x_k − x_{k−1} and e_{k+1}.
        let (mut by_before, mut by_earlier) = (Vector::zeros(), Vector::zeros());
        // Two rounds more, without a vertex, give the last two nodes.
        for node in 0..=x.len() {
            let mut new_by_before = Vector::zeros();
            if let Some([start, end]) = x[node..].first_chunk() {
                let after = Edge::between(*start, *end);
                let vertex = self.vertex_gradient(node, before, after, self.bending[node], moments.get(node))?;
                by_before += vertex.0;
                new_by_before = after.t * (self.axial[node] * (after.l - self.slack[node])) + vertex.1;
                before = after;
            }
            if node > self.first {
                emit(node - 1, by_earlier - by_before);
            }
            (by_earlier, by_before) = (by_before, new_by_before);
        }
        Ok(())
    }

    /// Gradient and Hessian for the shape `x`, `[n + 1]`, for the free nodes k = first … n, given to `emit` in this order; `moments`
    /// as in [`Elastic::gradient`].
    pub(crate) fn derivatives(
        &self,
        x: &[Vector<D>],
        moments: &mut [f64],
        mut emit: impl FnMut(usize, &NodeDerivatives<D>),
    ) -> Result<(), BadShape> {
        self.find_moments(x, moments)?;
        let mut before = self.clamped_edge();
        // By the edges: gradient and own block of the edge before, and of the one before that with its coupling to it.
        let (mut gradient, mut block) = (Vector::zeros(), Matrix::zeros());
        let (mut earlier_gradient, mut earlier_block, mut earlier_coupling) =
            (Vector::zeros(), Matrix::zeros(), Matrix::zeros());
        // ∂κ by the edges before and after it, of the last three vertices.
        let mut turns = [(Vector::zeros(), Vector::zeros()); 3];
        // Two rounds more, without a vertex, give the last two nodes.
        for node in 0..=x.len() {
            let (mut new_gradient, mut new_block, mut coupling) = (Vector::zeros(), Matrix::zeros(), Matrix::zeros());
            turns = [turns[1], turns[2], (Vector::zeros(), Vector::zeros())];
            if let Some([start, end]) = x[node..].first_chunk() {
                let after @ Edge { t, l, inverse_l } = Edge::between(*start, *end);
                let (l0, k_e, k_b) = (self.slack[node], self.axial[node], self.bending[node]);
                let vertex = self.vertex(node, before, after, k_b, moments.get(node))?;
                if self.shear.is_some() {
                    turns[2] = self.turn_gradient(node, before, after)?;
                }
                gradient += vertex.by_before;
                block += vertex.before_before;
                coupling = vertex.before_after;
                new_gradient = t * (k_e * (l - l0)) + vertex.by_after;
                let stretched = k_e * l0 * inverse_l;
                let turned = k_e - stretched;
                new_block =
                    t * (t * stretched).transpose() + Matrix::from_diagonal_element(turned) + vertex.after_after;
                before = after;
            }
            if node > self.first {
                emit(
                    node - 1,
                    &NodeDerivatives {
                        gradient: earlier_gradient - gradient,
                        own: earlier_block + block - earlier_coupling - earlier_coupling.transpose(),
                        next: (earlier_coupling - block + coupling).transpose(),
                        next_but_one: -coupling.transpose(),
                        turns: [turns[0].1, turns[1].0 - turns[1].1, -turns[2].0],
                    },
                );
            }
            (earlier_gradient, earlier_block) = (gradient, block);
            earlier_coupling = if node > 0 { coupling } else { Matrix::zeros() };
            (gradient, block) = (new_gradient, new_block);
        }
        Ok(())
    }

    /// Let the segments shrink by `strain` (1/Pa) times the pressure at their ends, Pa: `[n + 1]`, or empty where there is
    /// none.
    pub(crate) fn set_pressure(&mut self, strain: f64, pressure: &[f64]) {
        for (slack, ends) in self.slack.iter_mut().zip(pressure.windows(2)) {
            *slack = self.segment_length * (1.0 - strain * 0.5 * (ends[0] + ends[1]));
        }
    }

    /// What the clamp holds the shape `x`, `[n + 1]`, with: ∂U/∂x_0, N, and the moment e × ∂U/∂e, N m, e being the edge
    /// along the clamp's direction; `moments` as in [`Elastic::gradient`].
    pub(crate) fn clamp_reaction(
        &self,
        x: &[Vector<D>],
        moments: &mut [f64],
    ) -> Result<(Vector<D>, [f64; 3]), BadShape> {
        self.find_moments(x, moments)?;
        let (clamped, first, second) = (self.clamped_edge(), Edge::between(x[0], x[1]), Edge::between(x[1], x[2]));
        let (by_clamped, by_first) = self.vertex_gradient(0, clamped, first, self.bending[0], moments.first())?;
        let (by_first_again, _) = self.vertex_gradient(1, first, second, self.bending[1], moments.get(1))?;
        let tension = first.t * (self.axial[0] * (first.l - self.slack[0]));
        Ok((-(tension + by_first + by_first_again), cross(&(clamped.t * clamped.l), &by_clamped)))
    }

    /// Derivatives of the energy of the vertex at `node` by the edges before and after it.
    #[inline(always)]
    fn vertex_gradient(
        &self,
        node: usize,
        before: Edge<D>,
        after: Edge<D>,
        k_b: f64,
        moment: Option<&f64>,
    ) -> Result<(Vector<D>, Vector<D>), BadShape> {
        let own = node > 0 || matches!(self.joint, Joint::Clamped);
        if D == 3 && own && matches!(self.angles, Angles::Straight) {
            let slope = CosineSlope::new(before, after, self.cosine_above_fold(node, before, after)?, k_b);
            return Ok((slope.c_by_before * slope.by_c, slope.c_by_after * slope.by_c));
        }
        let vertex = self.vertex(node, before, after, k_b, moment)?;
        Ok((vertex.by_before, vertex.by_after))
    }

    /// The same with second derivatives; with the moment of the vertex those of its product with κ.
    #[inline(always)]
    fn vertex(
        &self,
        node: usize,
        before: Edge<D>,
        after: Edge<D>,
        k_b: f64,
        moment: Option<&f64>,
    ) -> Result<VertexDerivatives<D>, BadShape> {
        if let Some(&moment) = moment {
            return Ok(VertexDerivatives::planar(before, after, moment, self.turn(node, before, after)?));
        }
        match self.joint {
            Joint::Loose if node == 0 => return Ok(VertexDerivatives::zeros()),
            Joint::Spring { rest, .. } if node == 0 => return self.spring_vertex(before, after, k_b, rest),
            _ => (),
        }
        let rest = match &self.angles {
            Angles::Straight if D == 2 => 0.0,
            Angles::Straight => {
                let above_fold = self.cosine_above_fold(node, before, after)?;
                return Ok(VertexDerivatives::straight(
                    before,
                    after,
                    &CosineSlope::new(before, after, above_fold, k_b),
                ));
            }
            Angles::Curved(rest) => rest[node],
            Angles::Projected(rest) => return self.projected_vertex(node, before, after, k_b, rest[node]),
        };
        let above_fold = self.cosine_above_fold(node, before, after)?;
        Ok(VertexDerivatives::planar(before, after, k_b, half_square(before.kappa(after, above_fold), rest)))
    }

    /// The same of a spring at the root.
    fn spring_vertex(
        &self,
        before: Edge<D>,
        after: Edge<D>,
        k_b: f64,
        rest: f64,
    ) -> Result<VertexDerivatives<D>, BadShape> {
        let above_fold = self.cosine_above_fold(0, before, after)?;
        if D == 2 {
            let turn = Jet(before.angle(after), 1.0, 0.0);
            return Ok(VertexDerivatives::planar(before, after, k_b, half_square(turn, rest)));
        }
        Ok(VertexDerivatives::straight(before, after, &CosineSlope::of_angle(before, after, above_fold, k_b)))
    }

    /// Energy of the joint at the root without shear.
    fn joint_energy(&self, before: Edge<D>, after: Edge<D>) -> Result<f64, BadShape> {
        let Joint::Spring { rest, stored } = self.joint else { return Ok(0.0) };
        self.cosine_above_fold(0, before, after)?;
        Ok(0.5 * self.bending[0] * (before.angle(after) - rest).powi(2) + stored)
    }

    /// Moment of a spring at the root in the shape `x`, N m, positive to the left; `moments` as in [`Elastic::gradient`].
    pub(crate) fn spring_moment(&self, x: &[Vector<D>], moments: &mut [f64]) -> Result<f64, BadShape> {
        self.find_moments(x, moments)?;
        let turn = |elastic: &Self| elastic.turn(0, elastic.clamped_edge(), Edge::between(x[0], x[1]));
        moments.first().map_or_else(|| Ok(self.bending[0] * turn(self)?.0), |moment| Ok(*moment))
    }

    /// The spring at the root by its stiffness, N m, angle at rest, rad, and what it stores besides, J.
    pub(crate) fn set_spring(&mut self, stiffness: f64, rest: f64, stored: f64) {
        (self.bending[0], self.joint) = (stiffness, Joint::Spring { rest, stored });
        if let Some(shear) = &mut self.shear {
            shear.set_root(stiffness);
        }
    }

    /// The same in the projected model.
    fn projected_vertex(
        &self,
        node: usize,
        before: Edge<D>,
        after: Edge<D>,
        k_b: f64,
        rest: f64,
    ) -> Result<VertexDerivatives<D>, BadShape> {
        let mut vertex = VertexDerivatives::zeros();
        for axis in 1..D {
            let (psi, turn) = self.projected_turn(node, before, after, axis)?;
            vertex = vertex.with_turn(&turn, axis, k_b, half_square(Jet(psi, 1.0, 0.0), rest));
        }
        Ok(vertex)
    }

    /// κ less what it is at rest, in the plane with invariant angles.
    fn turn(&self, node: usize, before: Edge<D>, after: Edge<D>) -> Result<Jet, BadShape> {
        match self.joint {
            Joint::Loose if node == 0 => return Ok(Jet(0.0, 0.0, 0.0)),
            Joint::Spring { rest, .. } if node == 0 => {
                self.cosine_above_fold(0, before, after)?;
                return Ok(Jet(before.angle(after) - rest, 1.0, 0.0));
            }
            _ => (),
        }
        let Jet(kappa, slope, curvature) = before.kappa(after, self.cosine_above_fold(node, before, after)?);
        let rest = if let Angles::Curved(rest) = &self.angles { rest[node] } else { 0.0 };
        Ok(Jet(kappa - rest, slope, curvature))
    }

    /// ∂κ/∂e of the edges before and after a vertex, 1/m.
    fn turn_gradient(&self, node: usize, before: Edge<D>, after: Edge<D>) -> Result<(Vector<D>, Vector<D>), BadShape> {
        let Jet(_, slope, _) = self.turn(node, before, after)?;
        let unit = VertexDerivatives::planar(before, after, 1.0, Jet(0.0, slope, 0.0));
        Ok((unit.by_before, unit.by_after))
    }

    /// With shear, the moments of the shape `x`.
    fn find_moments(&self, x: &[Vector<D>], moments: &mut [f64]) -> Result<(), BadShape> {
        let Some(shear) = &self.shear else { return Ok(()) };
        let mut before = self.clamped_edge();
        for (node, (ends, moment)) in x.windows(2).zip(&mut *moments).enumerate() {
            let after = Edge::between(ends[0], ends[1]);
            *moment = self.turn(node, before, after)?.0;
            before = after;
        }
        shear.solve(moments);
        Ok(())
    }

    /// What stands before the first edge.
    fn clamped_edge(&self) -> Edge<D> {
        Edge { t: self.direction, l: self.segment_length, inverse_l: 1.0 / self.segment_length }
    }

    /// 1 + c between two edges, or the error that they fold back (or have no length).
    fn cosine_above_fold(&self, node: usize, before: Edge<D>, after: Edge<D>) -> Result<f64, BadShape> {
        let above_fold = 0.5 * (before.t + after.t).norm_squared();
        // Not a number where an edge has no length: that is refused as well.
        if before.l * after.l * above_fold > FOLD * self.segment_length.powi(2) {
            Ok(above_fold)
        } else {
            Err(BadShape::Fold { node })
        }
    }

    /// Turning angle of the projections into the plane of x and `axis`, rad, or the error that they are singular.
    fn projected_turn(
        &self,
        node: usize,
        before: Edge<D>,
        after: Edge<D>,
        axis: usize,
    ) -> Result<(f64, Turn), BadShape> {
        let (p, q) = (before.projection(axis), after.projection(axis));
        let psi = p.perp(&q).atan2(p.dot(&q));
        let long = |p: Vector2<f64>| p.norm_squared() > FOLD * self.segment_length.powi(2);
        if long(p) && long(q) && psi.abs() < FRAC_PI_2 {
            Ok((psi, Turn { by_before: -angle_gradient(p), by_after: angle_gradient(q) }))
        } else {
            Err(BadShape::Projection { node, axis })
        }
    }
}

impl<const D: usize> Edge<D> {
    fn between(start: Vector<D>, end: Vector<D>) -> Self {
        let e = end - start;
        // Root and division do not wait for one another.
        let square = e.norm_squared();
        let l = square.sqrt();
        let inverse_l = l * (1.0 / square);
        Self { t: e * inverse_l, l, inverse_l }
    }

    /// Components along x and `axis`, m.
    fn projection(self, axis: usize) -> Vector2<f64> {
        Vector2::new(self.t[0], self.t[axis]) * self.l
    }

    /// Turning angle ψ, rad: signed in the plane, the magnitude in space.
    fn angle(self, after: Self) -> f64 {
        if D == 2 {
            (self.t[0] * after.t[1] - self.t[1] * after.t[0]).atan2(self.t.dot(&after.t))
        } else {
            2.0 * (after.t - self.t).norm().atan2((after.t + self.t).norm())
        }
    }

    /// κ = 2 tan(ψ/2) = 2 sin ψ/(1 + c) in the plane, by ψ, from 1 + c: κ' = 1 + κ²/4 = 2/(1 + c).
    #[inline(always)]
    fn kappa(self, after: Self, above_fold: f64) -> Jet {
        let slope = 2.0 / above_fold;
        let kappa = (self.t[0] * after.t[1] - self.t[1] * after.t[0]) * slope;
        Jet(kappa, slope, 0.5 * kappa * slope)
    }
}

impl<const D: usize> CosineSlope<D> {
    fn new(before: Edge<D>, after: Edge<D>, above_fold: f64, k_b: f64) -> Self {
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
}

impl<const D: usize> CosineSlope<D> {
    /// Of ½ k_b ψ²: ∂/∂c = −k_b ψ/sin ψ, ∂²/∂c² = k_b (sin ψ − ψ cos ψ)/sin³ ψ.
    fn of_angle(before: Edge<D>, after: Edge<D>, above_fold: f64, k_b: f64) -> Self {
        let psi = before.angle(after);
        let (sin, cos) = psi.sin_cos();
        // Series where the differences would lose their digits; the next terms are of order ψ⁴.
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
    fn zeros() -> Self {
        Self {
            by_before: Vector::zeros(),
            by_after: Vector::zeros(),
            before_before: Matrix::zeros(),
            before_after: Matrix::zeros(),
            after_after: Matrix::zeros(),
        }
    }

    /// Of 2 k_b (1 − c)/(1 + c), by the derivatives of c by the two edges.
    fn straight(before: Edge<D>, after: Edge<D>, slope: &CosineSlope<D>) -> Self {
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

    /// Of k_b g(ψ) with ψ the signed turning angle in the plane.
    #[inline(always)]
    fn planar(before: Edge<D>, after: Edge<D>, k_b: f64, Jet(_, slope, curvature): Jet) -> Self {
        let (slope, curvature) = (k_b * slope, k_b * curvature);
        let across = |Edge { t, inverse_l, .. }: Edge<D>| [-t[1] * inverse_l, t[0] * inverse_l];
        let vector = |[x, y]: [f64; 2], by: f64| {
            let mut vector = Vector::zeros();
            (vector[0], vector[1]) = (x * by, y * by);
            vector
        };
        // g is ∂θ/∂e of the edge's direction θ, and ∂²θ/∂e∂e is as in `angle_hessian`.
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

    /// With the energy k_b g(ψ) of a turn in the plane of x and `axis` added.
    fn with_turn(mut self, turn: &Turn, axis: usize, k_b: f64, Jet(_, slope, curvature): Jet) -> Self {
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

/// ∂θ/∂p of θ = atan2(p_y, p_x).
fn angle_gradient(p: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-p.y, p.x) / p.norm_squared()
}

/// ∂²θ/∂p∂p from the gradient: g = (−p_y, p_x)/|p|² has p/|p|² = (g_y, −g_x).
fn angle_hessian(g: Vector2<f64>) -> SMatrix<f64, 2, 2> {
    let (xx, xy) = (-2.0 * g.x * g.y, g.x * g.x - g.y * g.y);
    SMatrix::<f64, 2, 2>::new(xx, xy, xy, -xx)
}

/// ½ (f − rest)².
fn half_square(Jet(f, slope, curvature): Jet, rest: f64) -> Jet {
    let off = f - rest;
    Jet(0.5 * off * off, off * slope, slope * slope + off * curvature)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    const SEGMENTS: usize = 6;

    fn springs<const D: usize>() -> Elastic<D> {
        let mut direction = Vector::zeros();
        direction[0] = 1.0;
        Elastic {
            segment_length: 0.25,
            slack: (0..SEGMENTS).map(|j| 0.25 - 0.001 * j as f64).collect(),
            axial: (0..SEGMENTS).map(|j| 40.0 + j as f64).collect(),
            bending: bending(),
            joint: Joint::Clamped,
            first: 1,
            direction,
            angles: Angles::Straight,
            shear: None,
        }
    }

    /// Tapered, with the clamp's spring.
    fn bending() -> Vec<f64> {
        (0..SEGMENTS).map(|v| if v == 0 { 6.0 } else { 3.1 - 0.1 * v as f64 }).collect()
    }

    fn shear() -> Shear {
        Shear::new(0.25, &bending(), |j| 7.0 - 0.5 * j as f64)
    }

    /// Every kind of angles that there is in `D` dimensions, curved ones in the plane.
    fn springs_of_all_kinds<const D: usize>() -> Vec<Elastic<D>> {
        let rest: Vec<f64> = (0..SEGMENTS).map(|k| if D == 2 { 0.1 + 0.05 * k as f64 } else { 0.0 }).collect();
        let with = |angles| Elastic { angles, ..springs() };
        let mut kinds = vec![with(Angles::Straight), with(Angles::Projected(rest.clone()))];
        if D == 2 {
            kinds.push(Elastic { shear: Some(shear()), ..springs() });
            kinds.push(Elastic { shear: Some(shear()), ..with(Angles::curved(rest.clone())) });
            kinds.push(with(Angles::curved(rest)));
        }
        let spring = Joint::Spring { rest: if D == 2 { 0.3 } else { 0.0 }, stored: 0.0 };
        for (joint, first) in [(Joint::Loose, 1), (Joint::Loose, 0), (spring, 1)] {
            let mut bending = bending();
            if matches!(joint, Joint::Loose) {
                bending[0] = 0.0;
            }
            if D == 2 {
                let shear = Some(Shear::new(0.25, &bending, |j| 7.0 - 0.5 * j as f64));
                kinds.push(Elastic { joint, first, bending: bending.clone(), shear, ..springs() });
            }
            kinds.push(Elastic { joint, first, bending, ..springs() });
        }
        kinds
    }

    /// A shape with turning angles of up to about a radian and edges 20 % longer or shorter than at rest.
    fn bent<const D: usize>(seed: f64) -> Vec<Vector<D>> {
        let mut shape = vec![Vector::zeros()];
        for k in 0..SEGMENTS {
            let noise = |d: usize| (seed + 12.9898 * (1 + k) as f64 + 78.233 * (1 + d) as f64).sin();
            let edge = Vector::from_fn(|d, _| 0.25 * f64::from(d == 0) + 0.15 * noise(d));
            shape.push(shape[k] + edge);
        }
        shape
    }

    fn total<const D: usize>(springs: &Elastic<D>, shape: &[Vector<D>]) -> f64 {
        let energy = springs.energy(shape).unwrap();
        energy.stretching + energy.bending
    }

    fn moved<const D: usize>(shape: &[Vector<D>], node: usize, d: usize, by: f64) -> Vec<Vector<D>> {
        let mut moved = shape.to_vec();
        moved[node][d] += by;
        moved
    }

    /// Room for the moments.
    fn moments<const D: usize>(springs: &Elastic<D>) -> Vec<f64> {
        vec![0.0; if springs.shear.is_some() { SEGMENTS } else { 0 }]
    }

    fn gradients<const D: usize>(springs: &Elastic<D>, shape: &[Vector<D>]) -> Vec<Vector<D>> {
        let mut gradients = vec![Vector::zeros(); springs.first];
        springs
            .gradient(shape, &mut moments(springs), |node, gradient| {
                assert_eq!(node, gradients.len());
                gradients.push(gradient);
            })
            .unwrap();
        gradients
    }

    fn gradient_is_that_of_the_energy<const D: usize>() {
        let step = 1e-5;
        for (springs, seed) in springs_of_all_kinds::<D>().iter().flat_map(|s| (0..5).map(move |seed| (s, seed))) {
            let shape = bent(seed as f64);
            let gradients = gradients(springs, &shape);
            for (node, exact) in gradients.iter().enumerate().skip(springs.first) {
                for (d, exact) in exact.iter().enumerate() {
                    let difference = (total(springs, &moved(&shape, node, d, step))
                        - total(springs, &moved(&shape, node, d, -step)))
                        / (2.0 * step);
                    let error = (difference - exact).abs();
                    assert!(error < 1e-6 * (1.0 + exact.abs()), "node {node}, {d}: {exact} against {difference}");
                }
            }
        }
    }

    fn hessian_is_that_of_the_gradient<const D: usize>() {
        let step = 1e-5;
        for (springs, seed) in springs_of_all_kinds::<D>().iter().flat_map(|s| (0..5).map(move |seed| (s, seed))) {
            let shape = bent(seed as f64);
            let expected = gradients(springs, &shape);
            let slopes: Vec<_> = (0..D * (SEGMENTS + 1 - springs.first))
                .map(|i| {
                    let (node, d) = (springs.first + i / D, i % D);
                    let [above, below] = [step, -step].map(|by| gradients(springs, &moved(&shape, node, d, by)));
                    above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * step)).collect::<Vec<_>>()
                })
                .collect();
            // What the moments, held in the second derivatives, add: Bᵀ A⁻¹ B.
            let mut by_moments = [Vector::<D>::zeros(); SEGMENTS + 1];
            let mut turns = vec![[Vector::<D>::zeros(); SEGMENTS]; SEGMENTS + 1];
            if springs.shear.is_some() {
                springs
                    .derivatives(&shape, &mut moments(springs), |node, by| {
                        for (i, turn) in
                            by.turns.iter().enumerate().filter(|&(i, _)| (1..=SEGMENTS).contains(&(node + i)))
                        {
                            turns[node][node + i - 1] = *turn;
                        }
                    })
                    .unwrap();
            }
            let mut nodes = springs.first;
            springs
                .derivatives(&shape, &mut moments(springs), |node, by| {
                    assert_eq!(node, nodes);
                    nodes += 1;
                    assert!((by.gradient - expected[node]).amax() < 1e-12 * (1.0 + by.gradient.amax()));
                    for d in 0..D {
                        if let Some(shear) = &springs.shear {
                            let mut moved = turns[node].map(|turn| turn[d]);
                            shear.solve(&mut moved);
                            for (other, turns) in by_moments.iter_mut().zip(&turns) {
                                *other = turns.iter().zip(moved).map(|(turn, moment)| turn * moment).sum();
                            }
                        }
                        let slope = &slopes[(node - springs.first) * D + d];
                        for (other, slope) in slope.iter().enumerate().skip(node) {
                            let exact = match other - node {
                                0 => by.own.column(d).into_owned(),
                                1 => by.next.column(d).into_owned(),
                                2 => by.next_but_one.column(d).into_owned(),
                                _ => Vector::zeros(),
                            } + by_moments[other];
                            let error = (slope - exact).amax();
                            assert!(
                                error < 1e-5 * (1.0 + exact.amax()),
                                "nodes {other}, {node}, {d}: {exact} against {slope}"
                            );
                        }
                    }
                })
                .unwrap();
            assert_eq!(nodes, SEGMENTS + 1);
        }
    }

    #[test]
    fn gradient_is_that_of_the_energy_in_2d() {
        gradient_is_that_of_the_energy::<2>();
    }

    #[test]
    fn gradient_is_that_of_the_energy_in_3d() {
        gradient_is_that_of_the_energy::<3>();
    }

    #[test]
    fn hessian_is_that_of_the_gradient_in_2d() {
        hessian_is_that_of_the_gradient::<2>();
    }

    #[test]
    fn hessian_is_that_of_the_gradient_in_3d() {
        hessian_is_that_of_the_gradient::<3>();
    }

    #[test]
    fn energy_does_not_depend_on_the_frame() {
        let springs = springs::<3>();
        for seed in 0..20 {
            let shape = bent::<3>(f64::from(seed));
            let angles = [1.0, 2.0, 3.0].map(|k| 3.0 * (k * f64::from(seed) + k).sin());
            let rotation = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
            let shift = Vector3::new(0.3, -0.7, 0.5);
            let turned = Elastic { direction: rotation * springs.direction, ..self::springs() };
            let moved: Vec<_> = shape.iter().map(|x| rotation * x + shift).collect();
            let (before, after) = (total(&springs, &shape), total(&turned, &moved));
            assert!((before - after).abs() < 1e-12 * before, "seed {seed}: {before} against {after}");
        }
    }

    #[test]
    fn bending_energy_is_half_the_squared_curvature() {
        let springs = springs::<2>();
        let angle: f64 = 0.8;
        let bend = Vector::from([angle.cos(), angle.sin()]) * 0.25;
        let straight = Vector::from([0.25, 0.0]);
        let kappa = 2.0 * (0.5 * angle).tan();
        for (first, second, expected) in
            [(straight, straight + bend, 0.5 * 3.0 * kappa.powi(2)), (bend, bend * 2.0, 0.5 * 6.0 * kappa.powi(2))]
        {
            let found = springs.energy(&[Vector::zeros(), first, second]).unwrap().bending;
            assert!((found - expected).abs() < 1e-12 * expected, "{found} against {expected}");
        }
    }

    /// With no rest angles the signed angle in the plane gives what its cosine gives.
    #[test]
    fn curved_model_of_a_straight_rod_is_the_straight_model() {
        let [straight, curved] =
            [Angles::Straight, Angles::Curved(vec![0.0; SEGMENTS])].map(|angles| Elastic { angles, ..springs::<2>() });
        for seed in 0..5 {
            let shape = bent(f64::from(seed));
            let (energy, of_curved) = (total(&straight, &shape), total(&curved, &shape));
            assert!((energy - of_curved).abs() < 1e-13 * energy, "{energy} against {of_curved}");
            let mut expected = Vec::new();
            straight
                .derivatives(&shape, &mut [], |_, by| expected.push((by.gradient, by.own, by.next, by.next_but_one)))
                .unwrap();
            curved
                .derivatives(&shape, &mut [], |node, by| {
                    let (gradient, own, next, next_but_one) = expected[node - 1];
                    let errors = [
                        (by.gradient - gradient).amax(),
                        (by.own - own).amax(),
                        (by.next - next).amax(),
                        (by.next_but_one - next_but_one).amax(),
                    ];
                    assert!(errors.iter().all(|&error| error < 1e-9), "seed {seed}, node {node}: {errors:?}");
                })
                .unwrap();
        }
    }

    /// Straight up in the plane xy, the projection into xz vanishes.
    #[test]
    fn projected_model_refuses_the_vertical() {
        let springs = Elastic { angles: Angles::Projected(vec![0.0; 3]), ..springs::<3>() };
        let along = |angles: [f64; 3]| {
            let mut x = vec![Vector::<3>::zeros()];
            for (k, angle) in angles.into_iter().enumerate() {
                x.push(x[k] + Vector::from([angle.cos(), angle.sin(), 0.0]) * 0.25);
            }
            x
        };
        springs.energy(&along([0.5, 1.0, 1.5])).map(|_| ()).unwrap();
        for last in [FRAC_PI_2, 1.7] {
            let shape = along([0.5, 1.0, last]);
            let found = springs.energy(&shape).map(|_| ()).unwrap_err();
            assert!(matches!(found, BadShape::Projection { node: 2, axis: 2 }), "{last}: {found:?}");
            let found = springs.derivatives(&shape, &mut [], |_, _| ()).unwrap_err();
            assert!(matches!(found, BadShape::Projection { node: 2, axis: 2 }), "{last}: {found:?}");
        }
    }

    #[test]
    fn folding_back_is_refused() {
        let springs = springs::<2>();
        let points = |x: [f64; 3]| x.map(|x| Vector::from([x, 0.0]));
        for (shape, node) in [([0.0, 0.25, 0.0], 1), ([0.0, -0.25, -0.5], 0), ([0.0, 0.25, 0.25], 1)] {
            let found = springs.energy(&points(shape)).map(|_| ()).unwrap_err();
            assert!(matches!(found, BadShape::Fold { node: n } if n == node), "energy of {shape:?}: {found:?}");
            let found = springs.derivatives(&points(shape), &mut [], |_, _| ()).unwrap_err();
            assert!(matches!(found, BadShape::Fold { node: n } if n == node), "derivatives of {shape:?}: {found:?}");
        }
    }
}
