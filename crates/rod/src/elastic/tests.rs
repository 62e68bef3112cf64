//! Tests of the elastic energy against differences, frames and closed forms.

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
    for (joint, first) in [(Joint::Loose, 1), (Joint::Loose, 0), (spring, 1), (spring, 0), (Joint::Clamped, 0)] {
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
                    for (i, turn) in by.turns.iter().enumerate().filter(|&(i, _)| (1..=SEGMENTS).contains(&(node + i)))
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
        assert!(matches!(found, BadShape::Projection { node: 2, axis: 'z' }), "{last}: {found:?}");
        let found = springs.derivatives(&shape, &mut [], |_, _| ()).unwrap_err();
        assert!(matches!(found, BadShape::Projection { node: 2, axis: 'z' }), "{last}: {found:?}");
    }
}

#[test]
fn folding_back_is_refused() {
    let springs = springs::<2>();
    let points = |x: [f64; 3]| x.map(|x| Vector::from([x, 0.0]));
    for (shape, node) in [([0.0, 0.25, 0.0], 1), ([0.0, -0.25, -0.5], 0), ([0.0, 0.25, 0.25], 1)] {
        let found = springs.energy(&points(shape)).map(|_| ()).unwrap_err();
        assert!(matches!(found, BadShape::FoldBack { node: n, .. } if n == node), "energy of {shape:?}: {found:?}");
        let found = springs.derivatives(&points(shape), &mut [], |_, _| ()).unwrap_err();
        assert!(
            matches!(found, BadShape::FoldBack { node: n, .. } if n == node),
            "derivatives of {shape:?}: {found:?}"
        );
    }
}
