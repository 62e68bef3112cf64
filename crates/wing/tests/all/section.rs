//! Twist and camber of the section at three quarters of the span.

use std::f64::consts::FRAC_PI_3;

use nervure_wing::{Membrane, Mesh, Parameters, RigidMotion, Root, Wing, ellipse, insect_wing, rectangle};

const FILM: Membrane = Membrane {
    areal_density: 0.05,
    stretching_stiffness: 5e3,
    bending_stiffness: 1e-6,
    poisson_ratio: 0.3,
    tension: 0.0,
};
const SPAN: f64 = 0.3;

fn held(mesh: Mesh) -> Wing {
    let root = Root { nodes: mesh.chain("root").unwrap_or_default().to_vec(), ..Root::default() };
    Parameters { root, ..Parameters::new(mesh, FILM) }.build().expect("a wing")
}

/// Give each node the place that `shape` says, on a base turned by 60° about the y axis.
fn bent(wing: &mut Wing, shape: impl Fn([f64; 3]) -> [f64; 3]) {
    let (sin, cos) = FRAC_PI_3.sin_cos();
    let mut state = wing.state().clone();
    state.own.base =
        RigidMotion { rotation: [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]], ..RigidMotion::rest() };
    for (place, rest) in state.positions.iter_mut().zip(&wing.parameters().mesh.nodes) {
        let [x, y, z] = shape(*rest);
        *place = [cos * x + sin * z, y, cos * z - sin * x].into();
    }
    wing.restore(&state).expect("a shape");
}

#[test]
fn a_mesh_that_is_twisted_by_an_angle_has_this_twist() {
    let angle = 0.4_f64;
    for (name, mesh) in [
        ("rectangle", rectangle(SPAN, 0.2, 8)),
        ("ellipse", ellipse(SPAN, 0.2, 8)),
        ("insect", insect_wing(SPAN, 0.1, 8)),
    ] {
        let mut wing = held(mesh);
        let rest = [wing.twist(), wing.camber()].map(|found| found.expect("a section"));
        assert!(rest.iter().all(|found| found.abs() < 1e-12), "{name} at rest: {rest:?}");
        // Sections beyond half the span turn about the axis y = −0.02 by one angle, sections at the root do not.
        bent(&mut wing, |[x, y, z]| {
            let (sin, cos) = (angle * (2.0 * x / SPAN).min(1.0)).sin_cos();
            [x, (y + 0.02) * cos - z * sin - 0.02, (y + 0.02) * sin + z * cos]
        });
        let [twist, camber] = [wing.twist(), wing.camber()].map(|found| found.expect("a section"));
        println!("{name}: twist {twist} for {angle}, camber {camber} for 0");
        assert!((twist - angle).abs() < 1e-12 && camber.abs() < 1e-12);
    }
}

#[test]
fn a_wing_that_is_bent_to_a_parabola_has_its_height_as_camber() {
    for sign in [1.0, -1.0] {
        let mut wing = held(rectangle(SPAN, 0.2, 8));
        bent(&mut wing, |[x, y, _]| [x, y, sign * 0.02 * (1.0 - (y / 0.1).powi(2))]);
        let [twist, camber] = [wing.twist(), wing.camber()].map(|found| found.expect("a section"));
        println!("twist {twist} for 0, camber {camber} for {}", sign * 0.1);
        assert!(twist.abs() < 1e-12 && (camber - sign * 0.1).abs() < 1e-12);
    }
}

#[test]
fn a_free_wing_has_no_section() {
    let wing = Parameters::new(rectangle(SPAN, 0.2, 4), FILM).build().expect("a wing");
    assert_eq!([wing.twist(), wing.camber()], [None; 2]);
}
