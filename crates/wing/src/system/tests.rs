//! Newton's matrix against differences of the forces.

use nalgebra::Rotation3;
use structure::Balance;

use super::System;
use crate::elastic::Elastic;
use crate::frames::Frames;
use crate::geometry::{Geometry, Vector};
use crate::{Membrane, Parameters, Root, Support, Vein, rectangle};

/// Return a wing with all kinds of springs, in a shape bent, stretched and sheared by some percent.
fn wing(support: Support) -> (Parameters, Vec<bool>, Vec<Vector>) {
    let mesh = rectangle(1.0, 0.8, 4);
    let root = Root { nodes: mesh.chain("root").expect("a root").to_vec(), support, origin: [0.0; 3] };
    let vein = Vein::new("vein", mesh.chain("right").expect("a side"), 0.1, 0.02, 50.0);
    let membrane = Membrane { tension: 3.0, ..Membrane::plate(1e4, 0.3, 1e-2, 100.0) };
    let mut held = vec![false; mesh.nodes.len()];
    root.nodes.iter().for_each(|&k| held[k] = true);
    let shape = (0..mesh.nodes.len()).map(|k| {
        let [x, y, _]: [f64; 3] = mesh.nodes[k];
        let bend = if held[k] { 0.0 } else { 0.2 * x * x + 0.1 * x * (5.0 * y).sin() };
        Vector::new(x + 0.03 * x * y, y + 0.02 * x * (3.0 * x).sin(), bend)
    });
    let shape = shape.collect();
    (Parameters { root, veins: vec![vein], ..Parameters::new(mesh, membrane) }, held, shape)
}

#[test]
fn the_tangent_is_the_derivative_of_the_forces() {
    for support in [Support::Clamped, Support::Pinned, Support::TorsionSpring { stiffness: 0.3 }] {
        let (parameters, held, x) = wing(support);
        let mut elastic = Elastic::new(&parameters, &held).expect("springs");
        let mut system = System::new(&elastic, &held, &x).expect("a matrix");
        let still = vec![Vector::zeros(); x.len()];
        let balance = Balance::at_rest(x.len());
        elastic.set_stresses(&x);
        system.assemble(&mut elastic, &x, &still, &balance, false).expect("a good shape");
        assert!(system.matrix.factorise(), "a positive definite matrix");
        // The matrix has unknowns beside the nodes, so compare its inverse: K⁻¹ (K p) = p.
        let direction: Vec<_> = (0..x.len())
            .map(|k| if held[k] { Vector::zeros() } else { Vector::from_fn(|d, _| ((7 * k + 3 * d) as f64).sin()) })
            .collect();
        let mut forces = |sign: f64| {
            let moved: Vec<_> = x.iter().zip(&direction).map(|(x, p)| x + p * (sign * 1e-6)).collect();
            let mut gradient = still.clone();
            elastic.gradient(&moved, &still, &mut gradient).expect("a good shape");
            gradient
        };
        let (ahead, behind) = (forces(1.0), forces(-1.0));
        let product: Vec<_> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / 2e-6).collect();
        system.solve(&product, &[]);
        let worst = (0..x.len()).map(|k| (system.update_of(k) - direction[k]).amax()).fold(0.0, f64::max);
        assert!(worst < 1e-6, "{support:?}: off by {worst:.1e} of 1");
    }
}

#[test]
fn the_forces_are_the_derivative_of_the_energy() {
    for support in [Support::Clamped, Support::Pinned] {
        let (parameters, held, x) = wing(support);
        let mut elastic = Elastic::new(&parameters, &held).expect("springs");
        let still = vec![Vector::zeros(); x.len()];
        let mut gradient = still.clone();
        elastic.gradient(&x, &still, &mut gradient).expect("a good shape");
        let largest = gradient.iter().map(|g| g.amax()).fold(0.0, f64::max);
        for k in 0..x.len() {
            for d in 0..3 {
                let mut energy = |step: f64| {
                    let mut moved = x.clone();
                    moved[k][d] += step;
                    let energy = elastic.energy(&moved).expect("a good shape");
                    energy.stretching + energy.bending + energy.veins
                };
                let slope = (energy(1e-6) - energy(-1e-6)) / 2e-6;
                assert!((slope - gradient[k][d]).abs() < 1e-7 * largest, "node {k}: {slope} and {}", gradient[k][d]);
            }
        }
    }
}

/// Springs of a wing with a kinked vein at its rim and a branch inside, both with torsion, in a shape with twist; its
/// forces and torques after a share of a motion of nodes and directors.
struct Twisted {
    elastic: Elastic,
    system: System,
    x: Vec<Vector>,
    motion: (Vec<Vector>, Vec<f64>),
}

impl Twisted {
    fn new() -> Self {
        let (mut parameters, held, x) = wing(Support::Clamped);
        let mesh = &parameters.mesh;
        let [rim, tip] = ["right", "tip"].map(|name| mesh.chain(name).expect("a side"));
        let stem: Vec<_> = rim.iter().chain(&tip[1..]).copied().collect();
        let start = rim[2];
        let beside = mesh.triangles.iter().filter(|corners| corners.contains(&start)).flatten();
        let branch = [start, *beside.into_iter().find(|k| !stem.contains(k) && !held[**k]).expect("a neighbour")];
        let vein =
            |name: &str, nodes: &[usize]| Vein { torsional_stiffness: 0.03, ..Vein::new(name, nodes, 0.1, 0.02, 50.0) };
        parameters.veins = vec![vein("branch", &branch), vein("stem", &stem)];
        let mut elastic = Elastic::new(&parameters, &held).expect("springs");
        let system = System::new(&elastic, &held, &x).expect("a matrix");
        let nodes =
            |k: usize| if held[k] { Vector::zeros() } else { Vector::from_fn(|d, _| ((7 * k + 3 * d) as f64).sin()) };
        let turn = |k: usize| if elastic.twists.strands[k].rigid { 0.0 } else { ((5 * k + 1) as f64).cos() };
        let motion = ((0..x.len()).map(nodes).collect(), (0..elastic.twists.strands.len()).map(turn).collect());
        elastic.twists.carry(&x, &elastic.support);
        elastic.twists.turn(0.1, |k| ((3 * k) as f64).sin());
        elastic.twists.mark();
        Self { elastic, system, x, motion }
    }

    fn moved(&mut self, share: f64) -> Vec<Vector> {
        let Self { elastic, motion, x, .. } = self;
        elastic.twists.back_to_mark();
        elastic.twists.turn(share, |k| motion.1[k]);
        elastic.forget_shape();
        x.iter().zip(&motion.0).map(|(x, p)| x + p * share).collect()
    }

    fn forces(&mut self, share: f64) -> (Vec<Vector>, Vec<f64>) {
        let (x, still) = (self.moved(share), vec![Vector::zeros(); self.x.len()]);
        let mut gradient = still.clone();
        self.elastic.gradient(&x, &still, &mut gradient).expect("a good shape");
        (gradient, self.elastic.twists.torques.clone())
    }

    fn energy(&mut self, share: f64) -> f64 {
        let x = self.moved(share);
        let energy = self.elastic.energy(&x).expect("a good shape");
        energy.stretching + energy.bending + energy.veins
    }
}

#[test]
fn forces_and_torques_of_directors_are_the_derivative_of_the_energy() {
    let mut twisted = Twisted::new();
    let slope = (twisted.energy(1e-6) - twisted.energy(-1e-6)) / 2e-6;
    let (forces, torques) = twisted.forces(0.0);
    let (nodes, turns) = &twisted.motion;
    let along: f64 = forces.iter().zip(nodes).map(|(f, p)| f.dot(p)).sum();
    let expected = along + torques.iter().zip(turns).map(|(t, p)| t * p).sum::<f64>();
    assert!((slope / expected - 1.0).abs() < 1e-7, "{slope} is not {expected}");
}

/// The matrix is the derivative of forces and torques where the directors are in equilibrium.
#[test]
fn the_tangent_with_directors_is_the_derivative_of_forces_and_torques() {
    let mut twisted = Twisted::new();
    let nodes = twisted.x.len();
    let (still, balance) = (vec![Vector::zeros(); nodes], Balance::at_rest(nodes));
    // Newton's method for the directors alone.
    let mut alone = System::new(&twisted.elastic, &vec![true; nodes], &twisted.x).expect("a matrix");
    for _ in 0..8 {
        let (_, torques) = twisted.forces(0.0);
        let Twisted { elastic, x, .. } = &mut twisted;
        alone.assemble(elastic, x, &still, &balance, false).expect("a good shape");
        assert!(alone.matrix.factorise(), "a positive definite matrix");
        let free = |k: usize, torque: f64| if elastic.twists.strands[k].rigid { 0.0 } else { -torque };
        let torques: Vec<_> = torques.iter().enumerate().map(|(k, torque)| free(k, *torque)).collect();
        alone.solve(&still, &torques);
        elastic.twists.turn(1.0, |k| alone.turn_of(k));
        elastic.twists.mark();
    }
    let torques = twisted.forces(0.0).1;
    assert!(torques.iter().zip(&twisted.motion.1).all(|(torque, turn)| *turn == 0.0 || torque.abs() < 1e-12));
    let (ahead, behind) = (twisted.forces(1e-6), twisted.forces(-1e-6));
    let x = twisted.moved(0.0);
    let Twisted { elastic, system, motion, .. } = &mut twisted;
    elastic.set_stresses(&x);
    system.assemble(elastic, &x, &still, &balance, false).expect("a good shape");
    assert!(system.matrix.factorise(), "a positive definite matrix");
    let forces: Vec<_> = ahead.0.iter().zip(&behind.0).map(|(a, b)| (a - b) / 2e-6).collect();
    let torques: Vec<_> = ahead.1.iter().zip(&behind.1).map(|(a, b)| (a - b) / 2e-6).collect();
    system.solve(&forces, &torques);
    let worst = (0..nodes).map(|k| (system.update_of(k) - motion.0[k]).amax()).fold(0.0, f64::max);
    let turns = motion.1.iter().enumerate().map(|(k, turn)| (system.turn_of(k) - turn).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-6 && turns < 1e-6, "off by {worst:.1e} and {turns:.1e} of 1");
}

#[test]
fn the_factors_of_a_shape_serve_the_shape_that_has_turned() {
    let (parameters, held, x) = wing(Support::Clamped);
    let mut elastic = Elastic::new(&parameters, &held).expect("springs");
    let mut system = System::new(&elastic, &held, &x).expect("a matrix");
    let rest: Vec<_> = (0..x.len()).map(|k| parameters.mesh.node(k)).collect();
    let mut frames = Frames::new(&rest, &elastic.faces);
    let still = vec![Vector::zeros(); x.len()];
    elastic.set_stresses(&x);
    system.assemble(&mut elastic, &x, &still, &Balance::at_rest(x.len()), false).expect("a good shape");
    assert!(system.matrix.factorise(), "a positive definite matrix");
    frames.set(&elastic.faces, &x);
    let force: Vec<_> = (0..x.len()).map(|k| Vector::from_fn(|d, _| ((7 * k + 3 * d) as f64).sin())).collect();
    let solved = |system: &mut System, force: &[Vector]| -> Vec<Vector> {
        system.solve(force, &[]);
        (0..x.len()).map(|k| system.update_of(k)).collect()
    };
    let update = solved(&mut system, &force);
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.1);
    let turned = |vectors: &[Vector]| -> Vec<Vector> { vectors.iter().map(|vector| turn * vector).collect() };
    frames.turn(&elastic.faces, &turned(&x), &mut system.rotations);
    let update_turned = solved(&mut system, &turned(&force));
    let largest = update.iter().map(|u| u.amax()).fold(0.0, f64::max);
    let off = turned(&update).iter().zip(&update_turned).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max);
    assert!(off < 1e-9 * largest, "off by {off:.1e} of {largest:.1e}");
}
