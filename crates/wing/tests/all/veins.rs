//! Veins against the rod and against exact solutions.

use nervure_wing::{Mesh, Parameters, Root, Scheme, Support, Vein, Wing};
use rod::{Rod, Section};

fn chain(vein: Vein, count: usize, length: f64, root: Root) -> Wing {
    let nodes = (0..=count).map(|k| [length * k as f64 / count as f64, 0.0, 0.0]).collect();
    let parameters = Parameters {
        mesh: Mesh { nodes, ..Mesh::default() },
        membranes: Vec::new(),
        regions: Vec::new(),
        veins: vec![vein],
        root,
        gravity: [0.0, 0.0, -9.81],
        relaxation_time: 0.0,
        displaced_density: 0.0,
        contact: None,
        scheme: Scheme::default(),
        max_step: None,
    };
    parameters.build().expect("a chain")
}

#[test]
fn a_vein_alone_is_the_rod_at_a_large_deflection() {
    let (count, section) =
        (16, Section { line_density: 0.1, bending_stiffness: 0.05, axial_stiffness: 1e3, shear_stiffness: None });
    let nodes: Vec<_> = (0..=count).collect();
    let vein = Vein::new("vein", &nodes, section.line_density, section.bending_stiffness, section.axial_stiffness);
    let mut wing = chain(vein, count, 1.0, Root { nodes: vec![0], ..Root::default() });
    wing.solve_static().expect("an equilibrium");
    let mut rod =
        Rod::<3>::new(rod::Parameters { gravity: [0.0, 0.0, -9.81], ..rod::Parameters::new(1.0, count, section) })
            .expect("a rod");
    rod.solve_static().expect("an equilibrium");
    assert!(rod.tip_displacement()[2] < -0.5);
    for k in 0..=count {
        for d in 0..3 {
            let (own, other) = (wing.positions(d)[k], rod.positions(d)[k]);
            assert!((own - other).abs() < 1e-9, "node {k}: {own} and {other}");
        }
    }
}

/// A cantilever whose diameter falls to the half weighs ∫ μ d² ds, gives way by ∫ ds/(EA d²) along itself and by
/// ∫ s² ds/(EI d⁴) across, s being the distance from the load at the tip.
#[test]
fn a_tapered_vein_weighs_stretches_and_bends_by_the_powers_of_its_diameter() {
    let (count, length, force) = (100, 2.0, 1e-3);
    let diameter: Vec<_> = (0..=count).map(|k| 1.0 - 0.5 * k as f64 / count as f64).collect();
    let nodes: Vec<_> = (0..=count).collect();
    let vein = Vein { diameter, ..Vein::new("vein", &nodes, 0.1, 5.0, 30.0) };
    let integral = |term: &dyn Fn(f64, f64) -> f64| {
        let parts = (0..1000).map(|i| (f64::from(i) + 0.5) / 1000.0);
        parts.map(|s| term(length * s, 0.5 + 0.5 * s) * length / 1000.0).sum::<f64>()
    };
    let tip = |axis: usize| {
        let mut wing = chain(vein.clone(), count, length, Root { nodes: vec![0], ..Root::default() });
        // The loads carry the weight and leave the force.
        let mass = wing.masses().to_vec();
        wing.loads.force = vec![0.0; 3 * (count + 1)];
        (0..=count).for_each(|k| wing.loads.force[2 * (count + 1) + k] = 9.81 * mass[k]);
        wing.loads.force[axis * (count + 1) + count] += force;
        wing.solve_static().expect("an equilibrium");
        wing.positions(axis)[count] - if axis == 0 { length } else { 0.0 }
    };
    let wing = chain(vein.clone(), count, length, Root { nodes: vec![0], ..Root::default() });
    for (name, found, expected) in [
        ("mass", wing.masses().iter().sum(), integral(&|_, d| 0.1 * d.powi(2))),
        ("elongation", tip(0), integral(&|_, d| force / (30.0 * d.powi(2)))),
        ("deflection", tip(1), integral(&|s, d| force * s * s / (5.0 * d.powi(4)))),
    ] {
        println!("{name}: {found} by {expected}");
        assert!((found / expected - 1.0).abs() < 2e-4, "{name}: {found} is not {expected}");
    }
}

#[test]
fn a_hanging_chain_is_a_catenary() {
    // A chain of length 1 between supports 0.8 apart: sag and span give the parameter a, 2 a sinh(0.4/a) = 1.
    let (count, mut a) = (80, 0.5_f64);
    for _ in 0..50 {
        let (f, slope) = (2.0 * a * (0.4 / a).sinh() - 1.0, 2.0 * (0.4 / a).sinh() - 0.8 / a * (0.4 / a).cosh());
        a -= f / slope;
    }
    let sag = a * ((0.4 / a).cosh() - 1.0);
    let nodes: Vec<_> = (0..=count).collect();
    let root = Root { nodes: vec![0, count], support: Support::Pinned, ..Root::default() };
    let vein = Vein::new("chain", &nodes, 0.1, 0.0, 1e5);
    // At rest the chain lies in a V between its supports.
    let nodes = (0..=count).map(|k| {
        let s = k as f64 / count as f64;
        [0.8 * s, 0.0, -0.3 * (1.0 - (2.0 * s - 1.0).abs())]
    });
    let mesh = Mesh { nodes: nodes.collect(), ..Mesh::default() };
    let parameters = Parameters {
        mesh,
        membranes: Vec::new(),
        regions: Vec::new(),
        veins: vec![vein],
        root,
        gravity: [0.0, 0.0, -9.81],
        relaxation_time: 0.0,
        displaced_density: 0.0,
        contact: None,
        scheme: Scheme::default(),
        max_step: None,
    };
    let mut wing = parameters.build().expect("a chain");
    wing.solve_static().expect("an equilibrium");
    let deepest = wing.positions(2).iter().fold(0.0_f64, |deepest, z| deepest.max(-z));
    println!("{deepest} {sag}");
    assert!((deepest / sag - 1.0).abs() < 1e-3);
}
