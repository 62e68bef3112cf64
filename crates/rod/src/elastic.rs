//! Elastic energy of the rod, with exact gradient and Hessian, from the edges e_j = x_j − x_{j−1}.
//!
//! With l = |e|, t = e/l and the cosine c = t_1 · t_2 of the turning angle ψ between neighbouring edges,
//!
//! ```text
//! U = Σ ½ k_e (l_j − l0)²  +  Σ ½ k_b κ_j²,      κ = 2 tan(ψ/2) = 2 |e_1 × e_2| / (|e_1| |e_2| + e_1 · e_2),
//! κ² = 4 (1 − c)/(1 + c).
//! ```
//!
//! κ is the discrete curvature of Bergou et al. (2008, *Discrete elastic rods*, ACM Trans. Graph. 27, 63), so the
//! energy does not depend on the frame. With a straight rest shape the energy is a function of c alone. At the clamp,
//! the direction of the clamp replaces t_1, and the stiffness is 2 EI/l0, because half a segment belongs to that
//! vertex. With this spring and half a mass at the tip the rod is of second order in l0. Folding back, ψ → π, is an
//! infinite barrier.
//!
//! In the plane κ has the sign of ψ: sin ψ and c give κ and its derivatives by ψ with one division. A curved rest shape
//! has U = Σ ½ k_b (κ(ψ_j) − κ(ψ0_j))².
//!
//! With shear the bending energy is the energy of [`Shear`], a function of all κ.
//!
//! The projected model of the thesis (eqs. 2.1, 2.3, 2.4) has U = Σ ½ k_b (θ_j − θ_{j−1} − ψ0_j)², and the same sum for
//! φ in three dimensions. θ and φ are the angles of the projections of the edges into the planes xy and xz. An angle
//! jumps by π where the rod passes the vertical, so a vertex that turns by more than a right angle in a projection is
//! refused.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector2;
use structure::{Matrix, Vector, cross};

use crate::BadShape;
use crate::shear::Shear;
use crate::vertex::{CosineSlope, Edge, Jet, ProjectedAngle, VertexDerivatives, angle_gradient, half_square};

/// Limit of |e_1||e_2| + e_1·e_2 at a fold, and of the squared length of a vanished projection, relative to l0².
const FOLD: f64 = 1e-12;

/// Springs of the rod.
pub(crate) struct Elastic<const D: usize> {
    /// Length l0 of a segment at rest, m.
    pub(crate) segment_length: f64,
    /// Length of each segment without tension, m: l0 less the strain of the pressure around the rod: `[n]`.
    pub(crate) slack: Vec<f64>,
    /// k_e of each segment, N/m: `[n]`.
    pub(crate) axial: Vec<f64>,
    /// k_b at the beginning of each segment, N m; the first belongs to the joint at the root: `[n]`.
    pub(crate) bending: Vec<f64>,
    /// Resistance of the root against turning.
    pub(crate) joint: Joint,
    /// First node that moves freely: 1, or 0 with a free or sliding root.
    pub(crate) first: usize,
    /// Unit tangent at the root.
    pub(crate) direction: Vector<D>,
    /// Angles that strain the springs k_b.
    pub(crate) angles: Angles,
    /// Shear in series with k_b, in the plane and with invariant angles; `None` is a section rigid in shear.
    pub(crate) shear: Option<Shear>,
}

/// Resistance of the root against turning from the direction of the support.
#[derive(Clone, Copy)]
pub(crate) enum Joint {
    /// The vertex resists like a vertex between two segments.
    Clamped,
    /// The root turns freely.
    Loose,
    /// The energy is ½ k_b (ψ − rest)² + stored of the true angle ψ; in space rest is 0.
    Spring { rest: f64, stored: f64 },
}

/// Angles on which the bending energy depends.
pub(crate) enum Angles {
    /// κ of the true turning angle, 0 at rest.
    Straight,
    /// κ of the signed turning angle in the plane, with values at rest: `[n]`.
    Curved(Vec<f64>),
    /// Turning angles of the projections, with values at rest, rad: `[n]`.
    Projected(Vec<f64>),
}

/// Derivatives of the energy by the positions of node k and of the nodes after it; 0 for missing nodes.
pub(crate) struct NodeDerivatives<const D: usize> {
    /// ∂U/∂x_k, N.
    pub(crate) gradient: Vector<D>,
    /// ∂²U/∂x_k∂x_k, N/m.
    pub(crate) own: Matrix<D>,
    /// ∂²U/∂x_{k+1}∂x_k, N/m.
    pub(crate) next: Matrix<D>,
    /// ∂²U/∂x_{k+2}∂x_k, N/m.
    pub(crate) next_but_one: Matrix<D>,
    /// ∂κ/∂x_k of the vertices k − 1, k and k + 1, 1/m, with shear; the second derivatives then hold the moments
    /// constant.
    pub(crate) turns: [Vector<D>; 3],
}

/// Elastic energies, J (per metre of depth in two dimensions).
pub(crate) struct ElasticEnergy {
    pub(crate) stretching: f64,
    /// Bending and shear.
    pub(crate) bending: f64,
}

impl Angles {
    /// Return the angles of a rest shape that turns by `psi`, rad, at the beginning of each segment: `[n]`.
    pub(crate) fn curved(psi: Vec<f64>) -> Self {
        Self::Curved(psi.into_iter().map(|psi| 2.0 * (0.5 * psi).tan()).collect())
    }
}

impl<const D: usize> Elastic<D> {
    /// Return the energies of the shape `x`, `[n + 1]`.
    pub(crate) fn energy(&self, x: &[Vector<D>]) -> Result<ElasticEnergy, BadShape> {
        let mut energy = ElasticEnergy { stretching: 0.0, bending: 0.0 };
        let (mut before, mut sheared) = (self.support_edge(), 0.0);
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

    /// Pass ∂U/∂x_k of the shape `x`, `[n + 1]`, to `emit` for the nodes k = first … n in order.
    ///
    /// With shear, overwrite `moments`, `[n]`, with the bending moments; without shear it is empty.
    pub(crate) fn gradient(
        &self,
        x: &[Vector<D>],
        moments: &mut [f64],
        mut emit: impl FnMut(usize, Vector<D>),
    ) -> Result<(), BadShape> {
        self.find_moments(x, moments)?;
        let mut before = self.support_edge();
        // ∂U/∂e of the edge before and of the edge before it; x_k enters through e_k = x_k − x_{k−1} and e_{k+1}.
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
            // The edge of the support does not move with node 0.
            (by_earlier, by_before) = (if node > 0 { by_before } else { Vector::zeros() }, new_by_before);
        }
        Ok(())
    }

    /// Pass gradient and Hessian of the shape `x`, `[n + 1]`, to `emit` for the nodes k = first … n in order.
    ///
    /// `moments` is as in [`Elastic::gradient`].
    pub(crate) fn derivatives(
        &self,
        x: &[Vector<D>],
        moments: &mut [f64],
        mut emit: impl FnMut(usize, &NodeDerivatives<D>),
    ) -> Result<(), BadShape> {
        self.find_moments(x, moments)?;
        let mut before = self.support_edge();
        // Gradient and diagonal block of the edge before, and of the edge before it with the coupling of both.
        let (mut gradient, mut block) = (Vector::zeros(), Matrix::zeros());
        let (mut earlier_gradient, mut earlier_block, mut earlier_coupling) =
            (Vector::zeros(), Matrix::zeros(), Matrix::zeros());
        // ∂κ of the last three vertices by the edges before and after each.
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
                    if node == 0 {
                        turns[2].0 = Vector::zeros(); // the edge of the support does not move with node 0
                    }
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
            (earlier_gradient, earlier_block, earlier_coupling) = (gradient, block, coupling);
            if node == 0 {
                (earlier_gradient, earlier_block, earlier_coupling) =
                    (Vector::zeros(), Matrix::zeros(), Matrix::zeros());
            }
            (gradient, block) = (new_gradient, new_block);
        }
        Ok(())
    }

    /// Shorten the segments by `strain` (1/Pa) times the pressure at their ends, Pa: `[n + 1]`, or empty.
    pub(crate) fn set_pressure(&mut self, strain: f64, pressure: &[f64]) {
        for (slack, ends) in self.slack.iter_mut().zip(pressure.windows(2)) {
            *slack = self.segment_length * (1.0 - strain * 0.5 * (ends[0] + ends[1]));
        }
    }

    /// Return the reaction of the support to the shape `x`, `[n + 1]`: the force ∂U/∂x_0, N, and the moment e × ∂U/∂e,
    /// N m.
    ///
    /// e is the edge along the direction of the support; `moments` is as in [`Elastic::gradient`].
    pub(crate) fn support_reaction(
        &self,
        x: &[Vector<D>],
        moments: &mut [f64],
    ) -> Result<(Vector<D>, [f64; 3]), BadShape> {
        self.find_moments(x, moments)?;
        let (support, first, second) = (self.support_edge(), Edge::between(x[0], x[1]), Edge::between(x[1], x[2]));
        let (by_support, by_first) = self.vertex_gradient(0, support, first, self.bending[0], moments.first())?;
        let (by_first_again, _) = self.vertex_gradient(1, first, second, self.bending[1], moments.get(1))?;
        let tension = first.t * (self.axial[0] * (first.l - self.slack[0]));
        Ok((-(tension + by_first + by_first_again), cross(&(support.t * support.l), &by_support)))
    }

    /// Return the derivatives of the energy of the vertex at `node` by the edges before and after it.
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

    /// Return first and second derivatives of the energy of a vertex; with its `moment`, of the product of moment and
    /// κ.
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

    /// Return the derivatives of the energy of a spring at the root.
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

    /// Return the energy of the joint at the root without shear.
    fn joint_energy(&self, before: Edge<D>, after: Edge<D>) -> Result<f64, BadShape> {
        let Joint::Spring { rest, stored } = self.joint else { return Ok(0.0) };
        self.cosine_above_fold(0, before, after)?;
        Ok(0.5 * self.bending[0] * (before.angle(after) - rest).powi(2) + stored)
    }

    /// Return the moment of a spring at the root in the shape `x`, N m, positive to the left.
    ///
    /// `moments` is as in [`Elastic::gradient`].
    pub(crate) fn spring_moment(&self, x: &[Vector<D>], moments: &mut [f64]) -> Result<f64, BadShape> {
        self.find_moments(x, moments)?;
        let turn = |elastic: &Self| elastic.turn(0, elastic.support_edge(), Edge::between(x[0], x[1]));
        moments.first().map_or_else(|| Ok(self.bending[0] * turn(self)?.0), |moment| Ok(*moment))
    }

    /// Set stiffness (N m), rest angle (rad) and further energy (J) of the spring at the root.
    pub(crate) fn set_spring(&mut self, stiffness: f64, rest: f64, stored: f64) {
        (self.bending[0], self.joint) = (stiffness, Joint::Spring { rest, stored });
        if let Some(shear) = &mut self.shear {
            shear.set_root(stiffness);
        }
    }

    /// Return the derivatives of the energy of a vertex in the projected model.
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
            vertex = vertex.with_projected_angle(&turn, axis, k_b, half_square(Jet(psi, 1.0, 0.0), rest));
        }
        Ok(vertex)
    }

    /// Return κ less its value at rest, in the plane with invariant angles.
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

    /// Return ∂κ/∂e by the edges before and after a vertex, 1/m.
    fn turn_gradient(&self, node: usize, before: Edge<D>, after: Edge<D>) -> Result<(Vector<D>, Vector<D>), BadShape> {
        let Jet(_, slope, _) = self.turn(node, before, after)?;
        let unit = VertexDerivatives::planar(before, after, 1.0, Jet(0.0, slope, 0.0));
        Ok((unit.by_before, unit.by_after))
    }

    /// With shear, overwrite `moments` with the bending moments of the shape `x`.
    fn find_moments(&self, x: &[Vector<D>], moments: &mut [f64]) -> Result<(), BadShape> {
        let Some(shear) = &self.shear else { return Ok(()) };
        let mut before = self.support_edge();
        for (node, (ends, moment)) in x.windows(2).zip(&mut *moments).enumerate() {
            let after = Edge::between(ends[0], ends[1]);
            *moment = self.turn(node, before, after)?.0;
            before = after;
        }
        shear.solve(moments);
        Ok(())
    }

    /// Return the edge along the direction of the support, in front of the first segment.
    fn support_edge(&self) -> Edge<D> {
        Edge { t: self.direction, l: self.segment_length, inverse_l: 1.0 / self.segment_length }
    }

    /// Return 1 + c between two edges; refuse edges that fold back or have no length.
    fn cosine_above_fold(&self, node: usize, before: Edge<D>, after: Edge<D>) -> Result<f64, BadShape> {
        let above_fold = 0.5 * (before.t + after.t).norm_squared();
        // An edge without length gives NaN, which the comparison refuses.
        if before.l * after.l * above_fold > FOLD * self.segment_length.powi(2) {
            Ok(above_fold)
        } else {
            Err(self.fold(node))
        }
    }

    /// Return the error of a rod that folds back at `node`.
    #[cold]
    pub(crate) fn fold(&self, node: usize) -> BadShape {
        BadShape::FoldBack { node, limit: FOLD * self.segment_length.powi(2) }
    }

    /// Return the angle between the projections into the plane of x and `axis`, rad; refuse singular projections.
    fn projected_turn(
        &self,
        node: usize,
        before: Edge<D>,
        after: Edge<D>,
        axis: usize,
    ) -> Result<(f64, ProjectedAngle), BadShape> {
        let (p, q) = (before.projection(axis), after.projection(axis));
        let psi = p.perp(&q).atan2(p.dot(&q));
        let long = |p: Vector2<f64>| p.norm_squared() > FOLD * self.segment_length.powi(2);
        if long(p) && long(q) && psi.abs() < FRAC_PI_2 {
            Ok((psi, ProjectedAngle { by_before: -angle_gradient(p), by_after: angle_gradient(q) }))
        } else {
            Err(BadShape::Projection { node, axis: ['x', 'y', 'z'][axis] })
        }
    }
}

#[cfg(test)]
mod tests;
