//! Tapered rods, against the exact tapered cantilever.

use nervure_rod::{Parameters, Rod, Scheme, Section, Taper};

use crate::common::unit_rod;
use crate::modes::{RitzBeam, frequencies, gauss};

/// Thickness at the tip of a vein, relative to the root.
const TIP: f64 = 0.2;

/// Return the thickness relative to the root.
fn thickness(s: f64) -> f64 {
    1.0 - (1.0 - TIP) * s
}

/// Return a plate of length 1 and linear thickness, with EI = 1, mass 1 and GA_s = 50 at the root.
fn plate(segments: usize, shear: bool) -> Parameters<2> {
    let along =
        |value: &dyn Fn(f64) -> f64| (0..=2 * segments).map(|i| value(i as f64 / (2 * segments) as f64)).collect();
    let rod = unit_rod(segments, 1e4, Scheme::TrBdf2);
    Parameters {
        section: Section { shear_stiffness: shear.then_some(50.0), ..rod.section },
        taper: Taper {
            line_density: along(&thickness),
            displaced: Vec::new(),
            bending_stiffness: along(&|s| thickness(s).powi(3)),
            axial_stiffness: along(&thickness),
            shear_stiffness: along(&thickness),
        },
        ..rod
    }
}

/// Return the integral of `f` from root to tip.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    gauss().into_iter().map(|(s, weight)| weight * f(s)).sum()
}

/// Assert that errors with 32, 64 and 128 segments have the order 2 and end below `most`.
#[track_caller]
fn assert_second_order(errors: [f64; 3], most: f64) {
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).abs().log2();
        assert!((1.9..2.4).contains(&order), "order {order}, errors {errors:?}");
    }
    assert!(errors[2].abs() < most, "errors {errors:?}");
}

/// Euler–Bernoulli and Timoshenko beams with their exact deflections, by quadrature.
#[test]
fn deflection_under_tip_and_uniform_load_is_that_of_the_tapered_cantilever() {
    let load = 1e-5;
    for shear in [false, true] {
        for uniform in [false, true] {
            // Moment and shear force beyond s; the deflection of the tip is the work of a unit load there.
            let moment = |s: f64| if uniform { 0.5 * (1.0 - s).powi(2) } else { 1.0 - s };
            let force = |s: f64| if uniform { 1.0 - s } else { 1.0 };
            let bent = integral(|s| moment(s) * (1.0 - s) / thickness(s).powi(3));
            let sheared = if shear { integral(|s| force(s) / (50.0 * thickness(s))) } else { 0.0 };
            let exact = load * (bent + sheared);
            let errors = [32, 64, 128].map(|segments| {
                let mut rod = Rod::new(plate(segments, shear)).unwrap();
                rod.loads.force = vec![0.0; 2 * (segments + 1)];
                let across = &mut rod.loads.force[segments + 1..];
                if uniform {
                    across.fill(load / segments as f64);
                    across[segments] *= 0.5;
                } else {
                    across[segments] = load;
                }
                rod.solve_static().unwrap();
                rod.tip_displacement()[1] / exact - 1.0
            });
            println!("shear {shear}, uniform {uniform}: {errors:?}");
            assert_second_order(errors, 1e-3);
        }
    }
}

#[test]
fn first_three_frequencies_are_those_of_the_tapered_cantilever() {
    let exact = RitzBeam { bending: &|s| thickness(s).powi(3), mass: &thickness, held: 2, spring: 0.0 }.frequencies();
    let found = [32, 64, 128].map(|segments| frequencies(&mut Rod::new(plate(segments, false)).unwrap()));
    for mode in 0..3 {
        let errors = [0, 1, 2].map(|grid: usize| found[grid][mode] / exact[mode] - 1.0);
        println!("mode {mode}, {}: {errors:?}", exact[mode]);
        assert_second_order(errors, 1e-3);
    }
}

/// The Ritz method itself, on the uniform cantilever: b² with 1 + cos b cosh b = 0.
#[test]
fn ritz_method_of_the_tests_has_the_frequencies_of_the_uniform_cantilever() {
    let found = RitzBeam { bending: &|_| 1.0, mass: &|_| 1.0, held: 2, spring: 0.0 }.frequencies();
    for (found, b) in found.iter().zip([1.875_104_068_711_961_f64, 4.694_091_132_974_175, 7.854_757_438_237_613]) {
        assert!((found / b.powi(2) - 1.0).abs() < 1e-8, "{found} against {}", b.powi(2));
    }
}

/// A hanging rod stretches under its weight: each mass stretches all segments above it.
#[test]
fn hanging_rod_is_stretched_like_the_tapered_bar() {
    let weight = |s: f64| (1.0 - s) * 0.5 * (thickness(s) + TIP);
    let gravity = 1e-2;
    let exact = gravity * integral(|s| weight(s) / (1e4 * thickness(s)));
    let errors = [32, 64, 128].map(|segments| {
        let mut rod = Rod::new(Parameters { gravity: [gravity, 0.0], ..plate(segments, false) }).unwrap();
        rod.solve_static().unwrap();
        rod.tip_displacement()[0] / exact - 1.0
    });
    assert_second_order(errors, 1e-3);
    let rod = Rod::new(plate(7, false)).unwrap();
    let (mass, centre) = rod
        .masses()
        .iter()
        .enumerate()
        .fold((0.0, 0.0), |(mass, centre), (k, m)| (mass + m, centre + m * k as f64 / 7.0));
    assert!((mass - 0.6).abs() < 1e-14, "mass {mass}");
    assert!((centre - integral(|s| s * thickness(s))).abs() < 1e-14, "centre {centre}");
}
