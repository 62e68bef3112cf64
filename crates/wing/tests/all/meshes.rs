//! Generated meshes.

use nervure_wing::{Error, Membrane, Mesh, Parameters, Root, Vein, WingError, ellipse, insect_wing, rectangle};

const FILM: Membrane = Membrane {
    areal_density: 0.05,
    stretching_stiffness: 5e3,
    bending_stiffness: 1e-6,
    poisson_ratio: 0.3,
    tension: 0.0,
};

fn area(mesh: &Mesh) -> f64 {
    let areas = mesh.triangles.iter().map(|&[a, b, c]| {
        let [[x0, y0, _], [x1, y1, _], [x2, y2, _]] = [a, b, c].map(|k| mesh.nodes[k]);
        0.5 * ((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0))
    });
    let signs: Vec<f64> = areas.collect();
    assert!(signs.iter().all(|area| area * signs[0] > 0.0), "all triangles turn in the same sense");
    signs.iter().sum::<f64>().abs()
}

#[test]
fn meshes_fill_their_outlines_and_make_wings() {
    let (rectangle, ellipse) = (rectangle(0.3, 0.2, 12), ellipse(0.3, 0.2, 24));
    assert!((area(&rectangle) - 0.06).abs() < 1e-12);
    assert!((area(&ellipse) / (0.06 * std::f64::consts::FRAC_PI_4) - 1.0).abs() < 5e-3);
    for mesh in [rectangle, ellipse, insect_wing(0.1, 0.04, 12)] {
        Parameters::new(mesh, FILM).build().expect("a wing");
    }
}

#[test]
fn an_insect_wing_hangs_from_its_root_by_five_straight_veins() {
    let mesh = insect_wing(0.1, 0.04, 12);
    let chain = |name: &str| mesh.chain(name).expect("a chain").to_vec();
    let veins =
        ["costa", "radius", "media", "cubitus", "anal"].map(|name| Vein::new(name, &chain(name), 1e-4, 5e-6, 100.0));
    let root = Root { nodes: chain("root"), ..Root::default() };
    let parameters =
        Parameters { veins: veins.to_vec(), root, gravity: [0.0, 0.0, -0.01], ..Parameters::new(mesh, FILM) };
    let sag = |parameters: Parameters| {
        let mut wing = parameters.build().expect("a wing");
        wing.solve_static().expect("an equilibrium");
        -wing.positions(2).iter().fold(0.0, |lowest: f64, z| lowest.min(*z))
    };
    let bare = Parameters { veins: Vec::new(), ..parameters.clone() };
    let (with, without) = (sag(parameters), sag(bare));
    println!("{with} {without}");
    assert!(with > 1e-7 && without > 3.0 * with);
}

#[test]
fn what_makes_no_wing_is_refused_by_name() {
    let refusal = |change: fn(&mut Parameters)| {
        let mut parameters = Parameters::new(rectangle(0.2, 0.1, 4), FILM);
        change(&mut parameters);
        parameters.build().err().expect("a refusal").to_string()
    };
    let turned = refusal(|p| p.mesh.triangles[0].swap(0, 1));
    assert!(turned.contains("same sense of rotation"), "{turned}");
    let bent = refusal(|p| p.veins = vec![Vein::new("bent", &[0, 1, 6], 1.0, 1.0, 1.0)]);
    assert!(bent.starts_with("veins.bent.nodes"), "{bent}");
    let flat = refusal(|p| p.mesh.nodes[1] = p.mesh.nodes[0]);
    assert!(flat.starts_with("mesh.triangles["), "{flat}");
    let loose = refusal(|p| p.mesh.nodes.push([1.0; 3]));
    assert!(loose.contains("no triangle and no vein"), "{loose}");
    let light = refusal(|p| p.membranes[0].areal_density = 0.0);
    assert!(light.starts_with("membranes[0].areal_density is 0.0"), "{light}");
}

#[test]
fn loads_that_are_no_numbers_leave_the_state_as_it_was() {
    let mut wing = Parameters::new(rectangle(0.2, 0.1, 4), FILM).build().expect("a wing");
    wing.loads.force = vec![0.0; 3 * wing.nodes()];
    wing.step(1e-3).expect("a step");
    let before = wing.state().clone();
    for value in [f64::NAN, f64::INFINITY, 1e200] {
        wing.loads.force[2] = value;
        let error = wing.step(1e-3).expect_err("no such force");
        assert!(
            matches!(
                error,
                Error::Value { .. } | Error::NotConverged { .. } | Error::Structure(WingError::Fold { .. })
            ),
            "{error}"
        );
        assert_eq!(*wing.state(), before);
    }
    wing.loads.force[2] = 0.0;
    wing.step(1e-3).expect("a step");
}
