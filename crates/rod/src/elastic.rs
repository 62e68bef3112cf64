//! Elastic energy of the rod with its exact gradient and Hessian, in terms of the edges e_j = x_j − x_{j−1}.
//!
//! With l = |e|, t = e/l and c = t_1 · t_2 the cosine of the turning angle ψ between neighbouring edges,
//!
//! ```text
//! U = Σ ½ (EA/l0) (l_j − l0)²  +  Σ ½ (EI/l0) κ_j²,      κ = 2 tan(ψ/2) = 2 |e_1 × e_2| / (|e_1| |e_2| + e_1 · e_2),
//! κ² = 4 (1 − c)/(1 + c).
//! ```
//!
//! κ is the discrete curvature of Bergou et al. (2008, *Discrete elastic rods*, ACM Trans. Graph. 27, 63): the energy
//! does not depend on the frame, in two as in three dimensions. With a straight rest shape it is a function of c
//! alone. At the clamp the fixed direction d0 takes the place of t_1, and the stiffness is 2 EI/l0 because only half
//! a segment belongs to that vertex; this and half a mass at the tip make the rod second order in l0. Folding back,
//! ψ → π, is an infinite barrier.

use nalgebra::{SMatrix, SVector};

/// A point, velocity or force.
pub(crate) type Vector<const D: usize> = SVector<f64, D>;
/// Second derivatives by two points.
pub(crate) type Matrix<const D: usize> = SMatrix<f64, D, D>;

/// A vertex counts as folded where |e_1||e_2| + e_1·e_2 is below this part of l0².
pub(crate) const FOLD: f64 = 1e-12;

/// Springs of the rod.
pub(crate) struct Elastic<const D: usize> {
    /// Length of a segment at rest, l0, m.
    pub(crate) segment_length: f64,
    /// EA/l0, N/m.
    pub(crate) axial: f64,
    /// EI/l0, N m.
    pub(crate) bending: f64,
    /// Unit tangent at the clamp, d0.
    pub(crate) direction: Vector<D>,
}

/// Derivatives of the energy by the edges; entry `j` belongs to the edge from node `j` to node `j + 1`.
pub(crate) struct EdgeDerivatives<const D: usize> {
    /// ∂U/∂e_j, N: `[n]`.
    pub(crate) gradient: Vec<Vector<D>>,
    /// ∂²U/∂e_j∂e_j, N/m: `[n]`.
    pub(crate) diagonal: Vec<Matrix<D>>,
    /// ∂²U/∂e_j∂e_{j+1}, N/m: `[n]`, the last one zero.
    pub(crate) coupling: Vec<Matrix<D>>,
}

/// Elastic energies, J (per metre of depth in two dimensions).
pub(crate) struct ElasticEnergy {
    pub(crate) stretching: f64,
    pub(crate) bending: f64,
}

/// The rod folds back on itself at this node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FoldBack {
    pub(crate) node: usize,
}

impl<const D: usize> EdgeDerivatives<D> {
    /// Zeros for `segments` edges.
    pub(crate) fn zeros(segments: usize) -> Self {
        Self {
            gradient: vec![Vector::zeros(); segments],
            diagonal: vec![Matrix::zeros(); segments],
            coupling: vec![Matrix::zeros(); segments],
        }
    }
}

impl<const D: usize> Elastic<D> {
    /// Energy of the shape `x`, `[n + 1]`.
    pub(crate) fn energy(&self, x: &[Vector<D>]) -> Result<ElasticEnergy, FoldBack> {
        let mut energy = ElasticEnergy { stretching: 0.0, bending: 0.0 };
        let (mut before, mut length_before, mut stiffness) = (self.direction, self.segment_length, 2.0 * self.bending);
        for (node, ends) in x.windows(2).enumerate() {
            let e = ends[1] - ends[0];
            let l = e.norm();
            let t = e / l;
            let cosine_above_fold = self.cosine_above_fold(node, (before, length_before), (t, l))?;
            energy.stretching += 0.5 * self.axial * (l - self.segment_length).powi(2);
            energy.bending += stiffness * (t - before).norm_squared() / cosine_above_fold;
            (before, length_before, stiffness) = (t, l, self.bending);
        }
        Ok(energy)
    }

    /// Gradient and Hessian by the edges for the shape `x`, `[n + 1]`.
    pub(crate) fn derivatives(&self, x: &[Vector<D>], by_edge: &mut EdgeDerivatives<D>) -> Result<(), FoldBack> {
        let l0 = self.segment_length;
        let (mut before, mut length_before, mut stiffness) = (self.direction, l0, 2.0 * self.bending);
        for (node, ends) in x.windows(2).enumerate() {
            let e = ends[1] - ends[0];
            let l = e.norm();
            let t = e / l;
            let across = Matrix::identity() - t * t.transpose();

            by_edge.gradient[node] = t * (self.axial * (l - l0));
            by_edge.diagonal[node] = (t * t.transpose() + across * (1.0 - l0 / l)) * self.axial;
            by_edge.coupling[node].fill(0.0);

            // Energy of the vertex 2 B (1 − c)/(1 + c), its derivatives by c, and those of c by the two edges.
            let above_fold = self.cosine_above_fold(node, (before, length_before), (t, l))?;
            let by_c = -4.0 * stiffness / above_fold.powi(2);
            let by_c_twice = 8.0 * stiffness / above_fold.powi(3);
            let c = above_fold - 1.0;
            let c_by_before = (t - before * c) / length_before;
            let c_by_e = (before - t * c) / l;
            let own = |tangent: Vector<D>, length: f64, slope: Vector<D>| {
                let mixed = slope * tangent.transpose();
                (mixed + mixed.transpose()) / -length
                    - (Matrix::identity() - tangent * tangent.transpose()) * (c / (length * length))
            };
            by_edge.gradient[node] += c_by_e * by_c;
            by_edge.diagonal[node] += own(t, l, c_by_e) * by_c + c_by_e * c_by_e.transpose() * by_c_twice;
            if node > 0 {
                let mixed = (across - before * c_by_e.transpose() * l) / (length_before * l);
                by_edge.gradient[node - 1] += c_by_before * by_c;
                by_edge.diagonal[node - 1] +=
                    own(before, length_before, c_by_before) * by_c + c_by_before * c_by_before.transpose() * by_c_twice;
                by_edge.coupling[node - 1] = mixed * by_c + c_by_before * c_by_e.transpose() * by_c_twice;
            }
            (before, length_before, stiffness) = (t, l, self.bending);
        }
        Ok(())
    }

    /// 1 + c between two edges given by tangent and length, or the error that they fold back (or have no length).
    fn cosine_above_fold(
        &self,
        node: usize,
        (before, length_before): (Vector<D>, f64),
        (t, l): (Vector<D>, f64),
    ) -> Result<f64, FoldBack> {
        let above_fold = 0.5 * (before + t).norm_squared();
        // Not a number where an edge has no length: that is refused as well.
        if length_before * l * above_fold > FOLD * self.segment_length.powi(2) {
            Ok(above_fold)
        } else {
            Err(FoldBack { node })
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    const SEGMENTS: usize = 6;

    fn springs<const D: usize>() -> Elastic<D> {
        let mut direction = Vector::zeros();
        direction[0] = 1.0;
        Elastic { segment_length: 0.25, axial: 40.0, bending: 3.0, direction }
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

    /// Move everything from node `edge + 1` on, which changes one edge only.
    fn with_edge_moved<const D: usize>(shape: &[Vector<D>], edge: usize, d: usize, by: f64) -> Vec<Vector<D>> {
        let mut moved = shape.to_vec();
        moved[edge + 1..].iter_mut().for_each(|x| x[d] += by);
        moved
    }

    fn gradient_is_that_of_the_energy<const D: usize>() {
        let (springs, step) = (springs::<D>(), 1e-5);
        for seed in 0..5 {
            let shape = bent(seed as f64);
            let mut by_edge = EdgeDerivatives::zeros(SEGMENTS);
            springs.derivatives(&shape, &mut by_edge).unwrap();
            for edge in 0..SEGMENTS {
                for d in 0..D {
                    let difference = (total(&springs, &with_edge_moved(&shape, edge, d, step))
                        - total(&springs, &with_edge_moved(&shape, edge, d, -step)))
                        / (2.0 * step);
                    let exact = by_edge.gradient[edge][d];
                    let error = (difference - exact).abs();
                    assert!(error < 1e-7 * (1.0 + exact.abs()), "edge {edge}, {d}: {exact} against {difference}");
                }
            }
        }
    }

    fn hessian_is_that_of_the_gradient<const D: usize>() {
        let (springs, step) = (springs::<D>(), 1e-5);
        for seed in 0..5 {
            let shape = bent(seed as f64);
            let [mut by_edge, mut above, mut below] = [(); 3].map(|()| EdgeDerivatives::zeros(SEGMENTS));
            springs.derivatives(&shape, &mut by_edge).unwrap();
            for edge in 0..SEGMENTS {
                for d in 0..D {
                    springs.derivatives(&with_edge_moved(&shape, edge, d, step), &mut above).unwrap();
                    springs.derivatives(&with_edge_moved(&shape, edge, d, -step), &mut below).unwrap();
                    for other in 0..SEGMENTS {
                        let difference = (above.gradient[other] - below.gradient[other]) / (2.0 * step);
                        let exact = match other.abs_diff(edge) {
                            0 => by_edge.diagonal[edge].column(d).into_owned(),
                            1 if other < edge => by_edge.coupling[other].column(d).into_owned(),
                            1 => by_edge.coupling[edge].row(d).transpose(),
                            _ => Vector::zeros(),
                        };
                        let error = (difference - exact).amax();
                        assert!(
                            error < 1e-7 * (1.0 + exact.amax()),
                            "edges {other}, {edge}, {d}: {exact} against {difference}"
                        );
                    }
                }
            }
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
            let turned = Elastic { direction: rotation * springs.direction, ..springs };
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

    #[test]
    fn folding_back_is_refused() {
        let springs = springs::<2>();
        let points = |x: [f64; 3]| x.map(|x| Vector::from([x, 0.0]));
        let mut by_edge = EdgeDerivatives::zeros(2);
        for (shape, node) in [([0.0, 0.25, 0.0], 1), ([0.0, -0.25, -0.5], 0), ([0.0, 0.25, 0.25], 1)] {
            let found = springs.energy(&points(shape)).map(|_| ()).unwrap_err().node;
            assert_eq!(found, node, "energy of {shape:?}");
            let found = springs.derivatives(&points(shape), &mut by_edge).unwrap_err().node;
            assert_eq!(found, node, "derivatives of {shape:?}");
        }
    }
}
