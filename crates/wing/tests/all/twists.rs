//! Veins with torsion against beam theory.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use nalgebra::{Rotation3, Vector3};
use nervure_wing::{Membrane, Mesh, Parameters, Root, Vein, Wing, rectangle};

type Vector = Vector3<f64>;

const EI: f64 = 1.0;
const GJ: f64 = 0.6;

/// A vein with torsion through `nodes`, clamped at the first of them.
fn clamped(nodes: Vec<[f64; 3]>, [ei, gj, ea]: [f64; 3]) -> Wing {
    let chain: Vec<_> = (0..nodes.len()).collect();
    let vein = Vein { torsional_stiffness: gj, ..Vein::new("vein", &chain, 0.1, ei, ea) };
    let mesh = Mesh { nodes, ..Mesh::default() };
    alone(mesh, vec![vein]).build().expect("a vein")
}

fn alone(mesh: Mesh, veins: Vec<Vein>) -> Parameters {
    let root = Root { nodes: vec![0], ..Root::default() };
    Parameters { veins, root, membranes: vec![], ..Parameters::new(mesh, Membrane::plate(1.0, 0.0, 1.0, 1.0)) }
}

fn arc(count: usize, radius: f64, angle: f64) -> Vec<[f64; 3]> {
    let place = |k: usize| (angle * k as f64 / count as f64).sin_cos();
    (0..=count).map(place).map(|(sin, cos)| [radius * sin, radius * (1.0 - cos), 0.0]).collect()
}

/// Return the displacement of the last node under the force `p` on it.
fn displacement(wing: &mut Wing, p: [f64; 3]) -> Vector {
    let nodes = wing.nodes();
    wing.loads.force = vec![0.0; 3 * nodes];
    (0..3).for_each(|d| wing.loads.force[d * nodes + nodes - 1] = p[d]);
    let before = wing.state().positions[nodes - 1];
    wing.solve_static().expect("an equilibrium");
    wing.state().positions[nodes - 1] - before
}

#[test]
fn a_quarter_circle_bends_and_twists_as_by_castigliano_with_second_order() {
    let p = 1e-5;
    let mut errors = Vec::new();
    for count in [8, 16, 32] {
        let error = |load: [f64; 3], axis: usize, expected: f64| {
            let found = displacement(&mut clamped(arc(count, 1.0, FRAC_PI_2), [EI, GJ, 1e6]), load)[axis];
            found / (p * expected) - 1.0
        };
        let across = error([0.0, 0.0, p], 2, FRAC_PI_4 / EI + (3.0 * FRAC_PI_4 - 2.0) / GJ);
        errors.push([across, error([p, 0.0, 0.0], 0, FRAC_PI_4 / EI)]);
    }
    println!("{errors:?}");
    for (axis, pair) in [0, 1].into_iter().flat_map(|axis| errors.windows(2).map(move |pair| (axis, pair))) {
        let [coarse, fine] = [pair[0][axis], pair[1][axis]];
        assert!(fine.abs() < 1e-2 && (3.7..4.3).contains(&(coarse / fine)), "{coarse} and {fine}");
    }
}

/// Return a vein with torsion through nodes of a mesh.
fn twisting(name: &str, nodes: &[usize]) -> Vein {
    Vein { torsional_stiffness: GJ, ..Vein::new(name, nodes, 0.1, EI, 1e6) }
}

/// The arm a carries the arm b aside: w = P (a³/3 + b³/3)/EI + P a b²/GJ. The arm b is a vein of its own, or not.
#[test]
fn a_kink_passes_bending_to_torsion_with_second_order() {
    let (a, b, p) = (1.0, 0.5, 1e-5);
    let expected = p * ((a * a * a + b * b * b) / (3.0 * EI) + a * b * b / GJ);
    let mut errors = Vec::new();
    for count in [8, 16] {
        let first = (0..=count).map(|k| [a * k as f64 / count as f64, 0.0, 0.0]);
        let nodes: Vec<_> = first.chain((1..=count).map(|k| [a, b * k as f64 / count as f64, 0.0])).collect();
        let all: Vec<_> = (0..nodes.len()).collect();
        let veins = vec![twisting("branch", &all[count..]), twisting("stem", &all[..=count])];
        let mut branched = alone(Mesh { nodes: nodes.clone(), ..Mesh::default() }, veins).build().expect("veins");
        let mut kinked = clamped(nodes, [EI, GJ, 1e6]);
        let error = |wing: &mut Wing| displacement(wing, [0.0, 0.0, p])[2] / expected - 1.0;
        errors.push([&mut kinked, &mut branched].map(error));
    }
    println!("{errors:?}");
    let [[coarse, _], [kink, branch]] = errors[..] else { panic!("two meshes") };
    assert!(kink.abs() < 2e-3 && (3.7..4.3).contains(&(coarse / kink)), "{coarse} and {kink}");
    assert!((branch - kink).abs() < 1e-8, "{branch} is not {kink}");
}

/// A vein of length a + c carries at a a vein of length b at the angle φ, under forces P across at both tips. The node
/// sinks by P (2 a³/3 + (c + e) a²/2)/EI and turns by P (a² + (c + e) a)/EI and P d a/GJ, with the tip of the branch at e
/// beyond it and at d beside it.
#[test]
fn a_branch_inside_a_vein_bends_and_twists_it_as_by_beam_theory_with_second_order() {
    let (a, c, b, p) = (0.75, 0.5, 0.4, 1e-5);
    for angle in [0.5_f64, 1.1, FRAC_PI_2, 2.5] {
        let (e, d) = (b * angle.cos(), b * angle.sin());
        let sinks = p * (2.0 * a * a * a / 3.0 + (c + e) * a * a / 2.0) / EI;
        let (turns, twists) = (p * (a * a + (c + e) * a) / EI, p * d * a / GJ);
        let expected = [
            sinks + turns * c + p * c * c * c / (3.0 * EI),
            sinks + turns * e + twists * d + p * b * b * b / (3.0 * EI),
        ];
        let mut errors = Vec::new();
        for count in [4, 8, 16] {
            // Segments beyond the node have another length.
            let part = |k: usize| k as f64 / count as f64;
            let stem = (0..=count).map(|k| a * part(k)).chain((1..=count).map(|k| a + c * part(k)));
            let branch = (1..=count).map(|k| [a + e * part(k), d * part(k), 0.0]);
            let nodes: Vec<_> = stem.map(|x| [x, 0.0, 0.0]).chain(branch).collect();
            let all: Vec<_> = (0..nodes.len()).collect();
            let tips = [2 * count, 3 * count];
            let of_branch = [&[count], &all[tips[0] + 1..]].concat();
            let veins = vec![twisting("branch", &of_branch), twisting("stem", &all[..=tips[0]])];
            let mut wing = alone(Mesh { nodes, ..Mesh::default() }, veins).build().expect("veins");
            wing.loads.force = vec![0.0; 3 * all.len()];
            tips.iter().for_each(|k| wing.loads.force[2 * all.len() + k] = p);
            wing.solve_static().expect("an equilibrium");
            errors.push([0, 1].map(|i| wing.state().positions[tips[i]].z / expected[i] - 1.0));
        }
        println!("{angle}: {errors:?}");
        for (pair, i) in errors.windows(2).flat_map(|pair| [(pair, 0), (pair, 1)]) {
            let [coarse, fine] = [pair[0][i], pair[1][i]];
            assert!(fine.abs() < 2e-2 && (3.9..4.1).contains(&(coarse / fine)), "{angle}: {coarse} and {fine}");
        }
    }
}

/// Bathe & Bolourchi (1979, Int. J. Numer. Methods Eng. 14, 961), by Simo & Vu-Quoc (1986, Comput. Methods Appl. Mech.
/// Eng. 58, 79): tip (15.79, 47.23, 53.37) under 600 across an arc of 45°, which has EI = GJ.
#[test]
fn a_bend_of_45_degrees_deflects_as_published() {
    let count = 16;
    let mut wing = clamped(arc(count, 100.0, FRAC_PI_4), [1e7 / 12.0, 1e7 / 12.0, 1e7]);
    displacement(&mut wing, [0.0, 0.0, 600.0]);
    let tip = wing.state().positions[count];
    println!("{tip:?}");
    assert!((tip - Vector::new(47.23, 15.79, 53.37)).norm() < 0.5, "{tip:?}");
}

#[test]
fn a_straight_vein_bends_as_without_torsion() {
    let straight = |gj: f64| {
        let nodes = (0..=16).map(|k| [f64::from(k) / 16.0, 0.0, 0.0]).collect();
        let mut wing = clamped(nodes, [0.05, gj, 1e3]);
        displacement(&mut wing, [0.1, -0.2, 0.3])
    };
    let [with, without] = [straight(0.02), straight(0.0)];
    println!("{:.1e}", (with - without).norm());
    assert!((with - without).norm() < 1e-9 && without.norm() > 0.5, "{with:?} is not {without:?}");
}

/// A strip with a vein along its middle under a couple T at its end twists by T L/(GJ + 2 D (1 − ν) b), the rate of a
/// strip beyond the warping of its ends.
#[test]
fn a_membrane_turns_with_its_vein() {
    let (length, width, count) = (1.0, 0.1, 40);
    let film = Membrane::plate(1e6, 0.3, 1e-2, 100.0);
    let twist = |gj: f64| {
        let mesh = rectangle(length, width, count);
        let middle = (0..mesh.nodes.len()).filter(|k| mesh.nodes[*k][1].abs() < 1e-9).collect::<Vec<_>>();
        let (root, tip) = (mesh.chain("root").expect("a root").to_vec(), mesh.chain("tip").expect("a tip").to_vec());
        let vein = Vein { torsional_stiffness: gj, ..Vein::new("vein", &middle, 1e-3, 1e-6, 1.0) };
        let root = Root { nodes: root, ..Root::default() };
        let (left, right) = (tip[tip.len() - 1], tip[0]);
        let mut wing = Parameters { root, veins: vec![vein], ..Parameters::new(mesh, film) }.build().expect("a strip");
        let nodes = wing.nodes();
        wing.loads.force = vec![0.0; 3 * nodes];
        (wing.loads.force[2 * nodes + left], wing.loads.force[2 * nodes + right]) = (1e-4, -1e-4);
        wing.solve_static().expect("an equilibrium");
        (wing.positions(2)[left] - wing.positions(2)[right]) / width
    };
    let plate = 2.0 * film.bending_stiffness * (1.0 - film.poisson_ratio) * width;
    let [bare, stiff] = [twist(1e-9 * plate), twist(plate)];
    println!("{bare} {stiff} of {}", 1e-4 * width * length / plate);
    assert!((bare * plate / (1e-4 * width * length) - 1.0).abs() < 0.05, "{bare}");
    assert!((stiff / bare - 0.5).abs() < 0.02, "{stiff} is not half of {bare}");
}

/// A bent wing with curved veins, turned and moved, has the same energy and forces.
#[test]
fn energy_and_forces_turn_with_the_wing() {
    let mut wing = clamped(arc(12, 1.0, PI), [EI, GJ, 50.0]);
    displacement(&mut wing, [0.3, -0.2, 0.5]);
    let (before, state) = (wing.energy().expect("a shape").veins, wing.state().clone());
    let forces = |wing: &mut Wing| {
        let x: Vec<[f64; 3]> = wing.state().positions.iter().map(|x| (*x).into()).collect();
        wing.elastic_forces(&x).expect("a shape").into_iter().map(Vector::from).collect::<Vec<_>>()
    };
    let still = forces(&mut wing);
    for turn in [0.1, 1.5, 3.0] {
        let rotation = Rotation3::new(Vector::new(0.4, -0.7, 0.6).normalize() * turn);
        let mut moved = state.clone();
        let move_to = |x: &mut Vector| *x = rotation * *x + Vector::new(3.0, -1.0, 2.0);
        moved.positions.iter_mut().chain(&mut moved.previous_positions).for_each(move_to);
        moved.own.twists.iter_mut().for_each(|twist| twist.director = (rotation * Vector::from(twist.director)).into());
        moved.own.base.rotation = std::array::from_fn(|i| std::array::from_fn(|j| rotation[(i, j)]));
        wing.restore(&moved).expect("a state");
        let now = wing.energy().expect("a shape").veins;
        let turned = forces(&mut wing);
        let off = still.iter().zip(&turned).map(|(a, b)| (rotation * a - b).amax()).fold(0.0, f64::max);
        println!("{:.1e} {off:.1e}", now / before - 1.0);
        assert!((now / before - 1.0).abs() < 1e-12 && off < 1e-11, "{now} is not {before}; forces off by {off:.1e}");
    }
}

/// A helix that is let go keeps its energy, and a state repeats its bits.
#[test]
fn a_vein_that_swings_keeps_its_energy_and_repeats_its_bits() {
    let place = |k: i32| (0.4 * f64::from(k)).sin_cos();
    let nodes = (0..=16).map(|k| (k, place(k))).map(|(k, (sin, cos))| [sin, 1.0 - cos, 0.05 * f64::from(k)]).collect();
    let mut wing = clamped(nodes, [EI, GJ, 1e3]);
    displacement(&mut wing, [0.02, 0.01, 0.05]);
    wing.loads.force.fill(0.0);
    let before = wing.energy().expect("a shape").veins;
    let mut worst = 0.0_f64;
    for _ in 0..100 {
        let counted = allocation_counter::measure(|| wing.step(0.01).expect("a step"));
        assert_eq!(counted.count_total, 0, "a step allocates");
        worst = worst.max((wing.energy().expect("a shape").total() / before - 1.0).abs());
    }
    let saved = wing.state().clone();
    wing.step(0.01).expect("a step");
    let first = wing.state().clone();
    wing.restore(&saved).expect("a state");
    wing.step(0.01).expect("a step");
    println!("{worst:.1e}");
    assert!(worst < 0.02, "the energy changes by {worst:.1e}");
    assert_eq!(&first, wing.state());
}

#[test]
fn veins_with_torsion_that_no_frame_fits_are_refused() {
    let refused = |nodes: &[usize], veins: usize, ei: f64| {
        let mesh = rectangle(1.0, 0.5, 4);
        let vein = Vein { torsional_stiffness: GJ, ..Vein::new("vein", nodes, 0.1, ei, 1e3) };
        let film = Membrane::plate(1e6, 0.3, 1e-2, 100.0);
        Parameters { veins: vec![vein; veins], ..Parameters::new(mesh, film) }.build().err().map(|e| e.to_string())
    };
    for (error, part) in [
        (refused(&[0, 1, 2], 1, 0.0), "bending_stiffness"),
        (refused(&[0, 1, 2, 1], 1, EI), "does not cross itself"),
        (refused(&[0, 2], 1, EI), "along the edges of triangles"),
        (refused(&[0, 1, 2], 2, EI), "on no other vein with torsion"),
        (refused(&[0, 1, 2], 1, EI), ""),
    ] {
        println!("{error:?}");
        assert!(if part.is_empty() { error.is_none() } else { error.is_some_and(|e| e.contains(part)) }, "{part}");
    }
}
