//! Equilibrium shapes.

mod common;

use common::{elastica_tip, turek_hron_bar, unit_rod};
use rod::{Parameters, Rod};
use scene::RodScheme;

/// The bar of CSM1: 2 m/s² on 0.35 m.
fn csm1(segments: usize) -> Parameters<2> {
    turek_hron_bar(1.4e6, 2.0, segments)
}

#[test]
fn elastica_of_the_tests_has_the_known_tip() {
    let section = csm1(2).section;
    let [x, y] = elastica_tip(0.35, 2.0 * section.line_density, section.bending_stiffness, f64::INFINITY);
    for (found, expected) in [(x, -7.1089e-3), (y, -65.6175e-3)] {
        assert!((found - expected).abs() < 6e-8, "{found} against {expected}");
    }
}

#[test]
fn static_deflection_converges_to_the_elastica_with_second_order() {
    let section = csm1(2).section;
    let exact = elastica_tip(0.35, 2.0 * section.line_density, section.bending_stiffness, section.axial_stiffness);
    let errors = [16, 32, 64, 128].map(|segments| {
        let mut rod = Rod::new(csm1(segments)).unwrap();
        rod.solve_static().unwrap();
        let tip = rod.tip_displacement();
        (tip[0] - exact[0]).hypot(tip[1] - exact[1]) / exact[1].abs()
    });
    for (coarse, fine) in errors.iter().zip(&errors[1..]) {
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.05, "order {order}, errors {errors:?}");
    }
    assert!(errors[3] < 1e-4, "errors {errors:?}");
}

#[test]
fn deflection_is_the_same_in_every_plane() {
    let mut plane = Rod::new(csm1(32)).unwrap();
    plane.solve_static().unwrap();
    let [x, y] = plane.tip_displacement();
    let Parameters { length, segments, section, .. } = csm1(32);
    for angle in [0.0_f64, 45.0, 90.0, 200.0].map(f64::to_radians) {
        let (sin, cos) = angle.sin_cos();
        let mut rod = Rod::new(Parameters {
            length,
            section,
            gravity: [0.0, -2.0 * cos, -2.0 * sin],
            ..unit_rod::<3>(segments, 1.0, RodScheme::Bdf2)
        })
        .unwrap();
        rod.solve_static().unwrap();
        let tip = rod.tip_displacement();
        for (found, expected) in tip.into_iter().zip([x, y * cos, y * sin]) {
            assert!((found - expected).abs() < 1e-11, "angle {angle}: {tip:?} against in-plane {x}, {y}");
        }
    }
}

/// Fifty times its weight: the bar hangs almost straight down.
#[test]
fn heavy_load_reaches_the_elastica() {
    let gravity = 100.0;
    let mut rod = Rod::new(turek_hron_bar(1.4e6, gravity, 128)).unwrap();
    rod.solve_static().unwrap();
    let section = csm1(2).section;
    let weight = gravity * section.line_density;
    let exact = elastica_tip(0.35, weight, section.bending_stiffness, section.axial_stiffness);
    for (found, exact) in rod.tip_displacement().into_iter().zip(exact) {
        assert!((found - exact).abs() < 1e-3 * exact.abs(), "{found} against {exact}");
    }
}

/// A small uniform jump bends the beam away from the top by p L⁴/8 EI.
#[test]
fn pressure_on_top_pushes_down() {
    let jump = 1e-3;
    let mut rod = Rod::new(unit_rod::<2>(64, 1e4, RodScheme::Bdf2)).unwrap();
    rod.loads.pressure_jump = vec![jump; 65];
    rod.solve_static().unwrap();
    let (found, exact) = (rod.tip_displacement()[1], -jump / 8.0);
    assert!((found - exact).abs() < 1e-3 * exact.abs(), "{found} against {exact}");
}

/// However it bends, the moment of a uniform pressure about the root is p/2 times the chord squared, and the clamp's
/// spring of 2 EI/l0 carries it.
#[test]
fn pressure_load_follows_the_shape() {
    let (jump, segments) = (5.0, 64);
    let mut rod = Rod::new(unit_rod::<2>(segments, 1e5, RodScheme::Bdf2)).unwrap();
    rod.loads.pressure_jump = vec![jump; segments + 1];
    let mut tip = [f64::NAN; 2];
    for _ in 0..200 {
        if tip == rod.tip_displacement() {
            break;
        }
        tip = rod.tip_displacement();
        rod.solve_static().unwrap();
    }
    let (x, y) = (rod.positions(0), rod.positions(1));
    let turned = y[1].atan2(x[1]);
    let clamp = 2.0 * segments as f64 * 2.0 * (0.5 * turned).tan() / (0.5 * turned).cos().powi(2);
    let applied = -0.5 * jump * (x[segments].powi(2) + y[segments].powi(2));
    assert!((clamp - applied).abs() < 1e-3 * applied.abs(), "{clamp} against {applied}, tip {tip:?}");
    assert!(tip[1] < -0.4, "hardly bent: {tip:?}");
}
