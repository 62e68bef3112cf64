//! Plates and membranes against exact solutions.

use nervure_wing::{Membrane, Mesh, Parameters, Root, Support, Wing, rectangle};

fn plate(nu: f64) -> Membrane {
    Membrane::plate(1e9, nu, 1e-3, 1000.0)
}

fn root(mesh: &Mesh) -> Root {
    Root { nodes: mesh.chain("root").expect("the chain").to_vec(), ..Root::default() }
}

fn cantilever(along: usize, nu: f64) -> Wing {
    let mesh = rectangle(1.0, 1.0, along);
    Parameters { root: root(&mesh), ..Parameters::new(mesh, plate(nu)) }.build().expect("a plate")
}

/// Frequencies of a square plate clamped at one side, ω L² √(ρ h/D), ν = 0.3: upper bounds by 36 products of beam
/// functions (Leissa 1973, J. Sound Vib. 31, 257).
const LEISSA: [f64; 6] = [3.4917, 8.5246, 21.429, 27.331, 31.111, 54.443];

#[test]
fn six_frequencies_of_a_cantilever_plate_are_within_one_percent_at_twenty_elements_a_side() {
    let scaled = |along: usize| -> Vec<f64> {
        let material = plate(0.3);
        let scale = (material.areal_density / material.bending_stiffness).sqrt();
        cantilever(along, 0.3).frequencies(6).expect("frequencies").iter().map(|omega| omega * scale).collect()
    };
    let [coarse, fine, finest] = [10, 20, 40].map(scaled);
    for (mode, bound) in LEISSA.iter().enumerate() {
        let limit = finest[mode] + (finest[mode] - fine[mode]) / 3.0;
        let order = ((coarse[mode] - limit) / (fine[mode] - limit)).log2();
        println!("mode {mode}: {} (limit {limit}, Leissa {bound}), order {order:.2}", fine[mode]);
        assert!((fine[mode] / limit - 1.0).abs() < 0.01);
        assert!((1.7..2.4).contains(&order));
        assert!(limit < *bound && limit > 0.992 * bound, "his bounds are up to 0.7 % too high");
    }
}

#[test]
fn a_strip_bends_like_a_beam_with_second_order() {
    // With ν = 0 a plate under a uniform load bends like a beam, w = q L⁴/(8 D).
    let error = |along: usize| {
        let mut wing = cantilever(along, 0.0);
        let nodes = wing.nodes();
        let (q, d) = (1e-6, plate(0.0).bending_stiffness);
        let mut force = vec![0.0; 3 * nodes];
        for k in 0..nodes {
            force[2 * nodes + k] = q * wing.masses()[k];
        }
        wing.loads.force = force;
        wing.solve_static().expect("an equilibrium");
        let mesh = &wing.parameters().mesh;
        let tip = mesh.chain("tip").expect("the tip");
        tip.iter().map(|&k| (wing.positions(2)[k] * 8.0 * d / q - 1.0).abs()).fold(0.0, f64::max)
    };
    let errors = [5, 10, 20].map(error);
    println!("{errors:?}");
    assert!(errors[2] < 0.01);
    assert!(errors[0] / errors[1] > 3.3 && errors[1] / errors[2] > 3.3, "{errors:?}");
}

#[test]
fn a_square_membrane_has_the_frequencies_of_its_tension() {
    let relative = |along: usize| {
        let mesh = rectangle(1.0, 1.0, along);
        let nodes = ["root", "tip", "left", "right"].iter().flat_map(|name| mesh.chain(name).expect("a side").to_vec());
        let root = Root { nodes: nodes.collect(), support: Support::Pinned, ..Root::default() };
        let membrane = Membrane { bending_stiffness: 0.0, tension: 10.0, ..plate(0.3) };
        let mut wing = Parameters { root, ..Parameters::new(mesh, membrane) }.build().expect("a membrane");
        let frequencies = wing.frequencies(4).expect("frequencies");
        let speed = (membrane.tension / membrane.areal_density).sqrt() * std::f64::consts::PI;
        let exact = [2.0, 5.0, 5.0, 8.0_f64].map(|square| speed * square.sqrt());
        std::array::from_fn::<_, 4, _>(|i| frequencies[i] / exact[i] - 1.0)
    };
    let (coarse, fine) = (relative(10), relative(20));
    println!("{coarse:?} {fine:?}");
    for (coarse, fine) in coarse.iter().zip(fine) {
        assert!(fine.abs() < 0.01 && (3.5..4.5).contains(&(coarse / fine)));
    }
}

#[test]
fn a_uniform_strain_leaves_inner_nodes_in_balance_on_a_distorted_mesh() {
    let mut mesh = rectangle(1.0, 1.0, 6);
    let inner = |[x, y, _]: [f64; 3]| x > 1e-9 && x < 1.0 - 1e-9 && y.abs() < 0.5 - 1e-9;
    let inside: Vec<_> = (0..mesh.nodes.len()).filter(|&k| inner(mesh.nodes[k])).collect();
    for &k in &inside {
        mesh.nodes[k][0] += 0.03 * (17.0 * k as f64).sin();
        mesh.nodes[k][1] += 0.03 * (29.0 * k as f64).sin();
    }
    let stretched: Vec<_> = mesh.nodes.iter().map(|[x, y, _]| [1.02 * x + 0.01 * y, 0.99 * y, 0.03 * x]).collect();
    let mut wing = Parameters::new(mesh, plate(0.3)).build().expect("a plate");
    let forces = wing.elastic_forces(&stretched).expect("forces");
    let largest = forces.iter().flatten().fold(0.0_f64, |largest, force| largest.max(force.abs()));
    for k in inside {
        assert!(forces[k].iter().all(|force| force.abs() < 1e-11 * largest), "node {k}: {:?}", forces[k]);
    }
}

#[test]
fn a_large_rotation_strains_nothing() {
    let mesh = rectangle(1.0, 0.6, 5);
    let nodes = mesh.nodes.clone();
    let mut wing = Parameters::new(mesh, plate(0.3)).build().expect("a plate");
    let (sin, cos) = 2.5_f64.sin_cos();
    // About z, then about x.
    let turn = |[x, y, _]: &[f64; 3]| {
        let (x, y) = (cos * x - sin * y, sin * x + cos * y);
        [x + 3.0, cos * y, sin * y - 1.0]
    };
    let turned: Vec<_> = nodes.iter().map(turn).collect();
    let forces = wing.elastic_forces(&turned).expect("forces");
    let stiffness = plate(0.3).stretching_stiffness;
    assert!(forces.iter().flatten().all(|force| force.abs() < 1e-12 * stiffness), "{forces:?}");
}

#[test]
fn a_hanging_strip_of_cloth_is_a_catenary() {
    // Length 1 between pins 0.8 apart; at rest an arc, whose sag is 4 % less. 0.8 = 2 R sin θ, 1 = 2 R θ.
    let root_of = |f: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (0.5, 2.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *if f(middle) < 0.0 { &mut low } else { &mut high } = middle;
        }
        low
    };
    let theta = root_of(&|x| 0.8 - x.sin() / x);
    let u = root_of(&|x| 0.8 * x.sinh() / x - 1.0);
    let sag = 0.4 / u * (u.cosh() - 1.0);
    let mut mesh = rectangle(1.0, 0.1, 40);
    let middle = mesh.nodes.iter().position(|&[x, y, _]| (x - 0.5).abs() < 1e-9 && y.abs() < 0.06).expect("a node");
    let radius = 0.5 / theta;
    for [x, _, z] in &mut mesh.nodes {
        let angle = (*x - 0.5) / radius;
        (*x, *z) = (0.4 + radius * angle.sin(), radius * (theta.cos() - angle.cos()));
    }
    let nodes = ["root", "tip"].iter().flat_map(|name| mesh.chain(name).expect("a side").to_vec()).collect();
    let cloth = Membrane { areal_density: 0.1, stretching_stiffness: 1e4, bending_stiffness: 1e-6, ..plate(0.0) };
    let root = Root { nodes, support: Support::Pinned, ..Root::default() };
    let gravity = [0.0, 0.0, -9.81];
    let mut wing = Parameters { root, gravity, ..Parameters::new(mesh, cloth) }.build().expect("a cloth");
    wing.solve_static().expect("an equilibrium");
    let own = -wing.positions(2)[middle];
    println!("sag {own} and {sag}");
    assert!((own / sag - 1.0).abs() < 1e-3);
}
