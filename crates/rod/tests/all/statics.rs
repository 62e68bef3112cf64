//! Equilibrium shapes.

use std::f64::consts::{FRAC_PI_4, PI};

use nervure_rod::{Bending, Calibration, Loads, Parameters, Rod, Scheme, Section};

use crate::common::{elastica_tip, turek_hron_bar, unit_rod};

/// Return the bar of CSM1: 2 m/s² on 0.35 m.
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

/// On a line the fluid that moves with the rod is a part of the rod's mass, and nothing carries its weight.
#[test]
fn the_displaced_mass_weighs_on_a_line() {
    let sunk = |displaced: f64, displaced_weighs: bool| {
        let mut rod = Rod::new(Parameters { displaced, displaced_weighs, ..csm1(16) }).unwrap();
        rod.solve_static().unwrap();
        (rod.tip_displacement()[1], rod.energy().unwrap().gravity)
    };
    let own = sunk(0.0, false);
    assert_eq!(sunk(20.0, true), own);
    let (floating, _) = sunk(20.0, false);
    assert!(own.0 < -0.06 && floating.abs() < 1e-12, "{own:?} beside {floating}");
}

/// Fluid that no load accounts for carries the rod by its weight: one that weighs as much lets it float, more lifts it.
#[test]
fn the_weight_of_the_fluid_carries_a_rod() {
    let tip = |buoyant: f64| {
        let buoyant = vec![buoyant; 33];
        let mut rod = Rod::new(Parameters { buoyant, ..csm1(16) }).unwrap();
        rod.solve_static().unwrap();
        rod.tip_displacement()[1]
    };
    let own = csm1(2).section.line_density;
    assert!(tip(0.0) < -0.06 && tip(own).abs() < 1e-12 && (tip(2.0 * own) + tip(0.0)).abs() < 1e-9);
}

/// In the diagonal plane of space, up to tip angles of 70°.
#[test]
fn diagonal_deflection_of_a_fine_rod_is_within_1e_4_of_the_elastica() {
    let Parameters { length, section, .. } = csm1(2);
    let diagonal = 0.5_f64.sqrt();
    for (gravity, angle) in [(2.0, 14.0), (5.0, 30.0), (30.0, 70.0)] {
        let weight = gravity * section.line_density;
        let exact = elastica_tip(length, weight, section.bending_stiffness, section.axial_stiffness);
        let errors = [64, 128].map(|segments| {
            let gravity = [0.0, -gravity * diagonal, -gravity * diagonal];
            let parameters = unit_rod::<3>(segments, 1.0, Scheme::Bdf2);
            let mut rod = Rod::new(Parameters { length, section, gravity, ..parameters }).unwrap();
            rod.solve_static().unwrap();
            let [x, y, z] = rod.tip_displacement();
            let last = |d: usize| rod.positions(d)[segments] - rod.positions(d)[segments - 1];
            let turned = last(1).hypot(last(2)).atan2(last(0)).to_degrees();
            assert!(turned > angle, "the tip only turned by {turned}° under {gravity:?}");
            (x - exact[0]).hypot(y - exact[1] * diagonal).hypot(z - exact[1] * diagonal) / exact[1].abs()
        });
        let order = (errors[0] / errors[1]).log2();
        assert!(errors[1] < 1e-4, "{gravity} m/s²: errors {errors:?}");
        assert!((order - 2.0).abs() < 0.1, "{gravity} m/s²: order {order}, errors {errors:?}");
    }
}

/// With an EA of 1e7 N and an EI of 0.0259 N m², rounding of the axial forces must not end Newton's method early.
#[test]
fn inextensible_elastica_is_met_with_second_order() {
    let (gravity, bending_stiffness) = (2.0, 0.0259);
    let exact = elastica_tip(1.0, 0.0571 * gravity, bending_stiffness, f64::INFINITY);
    let errors = [64, 128, 256, 512].map(|segments| {
        let section = Section { line_density: 0.0571, bending_stiffness, axial_stiffness: 1e7, shear_stiffness: None };
        let rod = unit_rod::<2>(segments, 1.0, Scheme::TrBdf2);
        let mut rod = Rod::new(Parameters { section, gravity: [0.0, -gravity], ..rod }).unwrap();
        rod.solve_static().unwrap();
        let [x, y] = rod.tip_displacement();
        (x - exact[0]).hypot(y - exact[1]) / exact[1].abs()
    });
    for (coarse, fine) in errors.iter().zip(&errors[1..]) {
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.05, "order {order}, errors {errors:?}");
    }
    assert!(errors[1] < 1e-4, "errors {errors:?}");
}

/// CSM1 of Turek & Hron (2006): (−7.1877, −66.1023) mm. Without shear and the curved root the deflection differs by
/// 0.75 %; a clamp compliance length of 0.64 mm replaces both.
#[test]
fn csm1_is_met_within_a_percent_and_with_the_clamp_set_back_within_0_15() {
    let published = [-7.1877e-3_f64, -66.1023e-3];
    let tip = |clamp_compliance_length| {
        let mut rod = Rod::new(Parameters { clamp_compliance_length, ..csm1(128) }).unwrap();
        rod.solve_static().unwrap();
        rod.tip_displacement()
    };
    let plain = tip(0.0);
    let error = (plain[0] - published[0]).hypot(plain[1] - published[1]) / published[0].hypot(published[1]);
    assert!(error < 0.01, "{plain:?} against {published:?}: {error}");
    let set_back = tip(0.64e-3);
    for (found, published) in set_back.into_iter().zip(published) {
        assert!((found / published - 1.0).abs() < 0.0015, "set back: {found} m against {published} m");
    }
}

/// The calibration of the thesis, section 2.4.1, is of first order: the error of the deflection is 10 % with 32
/// segments.
///
/// The thesis reports 0.01 %: there the error of a constant k_e, an EA that falls with n, cancels the error of the
/// mass.
#[test]
fn calibration_of_the_thesis_is_of_first_order() {
    let exact = elastica_tip(1.0, 0.0571 * 0.7, 0.0259, f64::INFINITY)[1];
    let errors = [32, 64, 128].map(|segments| {
        let section =
            Section { line_density: 0.0571, bending_stiffness: 0.0259, axial_stiffness: 1.0, shear_stiffness: None };
        let mut rod = Rod::new(Parameters {
            section,
            gravity: [0.0, -0.7],
            calibration: Calibration::Thesis { k_e: 1e6 },
            ..unit_rod::<2>(segments, 1.0, Scheme::Trapezoid)
        })
        .unwrap();
        rod.solve_static().unwrap();
        rod.tip_displacement()[1] / exact - 1.0
    });
    assert!((errors[0] - 0.10).abs() < 0.01, "errors {errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 1.0).abs() < 0.1, "order {order}, errors {errors:?}");
    }
}

/// Both models agree in a plane of the frame. In the diagonal plane the projected model depends on the frame: the error
/// is 2.5 % at a tip angle of 14° and 12 % at 53°.
#[test]
fn projected_bending_is_right_in_the_plane_and_wrong_in_the_diagonal() {
    let Parameters { length, section, .. } = csm1(2);
    let deflection = |bending, gravity: f64, angle: f64| {
        let gravity = [0.0, -gravity * angle.cos(), -gravity * angle.sin()];
        let parameters = unit_rod::<3>(128, 1.0, Scheme::Bdf2);
        let mut rod = Rod::new(Parameters { length, section, gravity, bending, ..parameters }).unwrap();
        rod.solve_static().unwrap();
        let [_, y, z] = rod.tip_displacement();
        y.hypot(z)
    };
    for (gravity, expected) in [(2.0, 0.025), (14.0, 0.12)] {
        let exact = deflection(Bending::Invariant, gravity, 0.0);
        let planar = deflection(Bending::Projected, gravity, 0.0) / exact - 1.0;
        let diagonal = deflection(Bending::Projected, gravity, FRAC_PI_4) / exact - 1.0;
        assert!(planar.abs() < 1e-4, "{gravity} m/s²: {planar} off in the plane");
        assert!((diagonal.abs() - expected).abs() < 0.2 * expected, "{gravity} m/s²: {diagonal} off in the diagonal");
    }
}

/// A rod curved to half a circle is at rest, and a pressure on its inside opens it.
#[test]
fn curved_rest_shape_is_in_equilibrium() {
    let segments = 64;
    let angle = |k: usize| PI * (k as f64 + 0.5) / segments as f64;
    let curved =
        Parameters { rest_angles: (0..segments).map(angle).collect(), ..unit_rod::<2>(segments, 1e4, Scheme::TrBdf2) };
    let mut rod = Rod::new(curved).unwrap();
    let diameter = 2.0 / PI;
    let tip = [rod.positions(0)[segments], rod.positions(1)[segments]];
    assert!(tip[0].abs() < 1e-12 && (tip[1] - diameter).abs() < 1e-3 * diameter, "{tip:?}, diameter {diameter}");
    for _ in 0..20 {
        rod.step(1e-2).unwrap();
    }
    let moved = rod.tip_displacement();
    assert!(moved[0].hypot(moved[1]) < 1e-12, "it moved by {moved:?} without a load");
    // The curvature changes by M/EI, M = p/2 · chord². To first order the tip of a thin ring moves by the integral
    // ∫ (M/EI) (position of the tip − x) ds, turned by a right angle.
    let jump = -1e-3;
    rod.loads.pressure_jump = vec![jump; segments + 1];
    rod.solve_static().unwrap();
    let moved = rod.tip_displacement();
    let radius = 1.0 / PI;
    let exact = {
        let steps = 20_000;
        (0..steps).fold([0.0; 2], |[u, v], step| {
            let theta = PI * (f64::from(step) + 0.5) / f64::from(steps);
            let (dx, dy) = (-radius * theta.sin(), radius * (1.0 + theta.cos()));
            let moment = 0.5 * jump * (dx * dx + dy * dy);
            let turn = -moment * radius * PI / f64::from(steps);
            [u - turn * dy, v + turn * dx]
        })
    };
    for (found, exact) in moved.into_iter().zip(exact) {
        assert!(
            (found / exact.abs()).abs() > 0.9 && (found.abs() / exact.abs() - 1.0).abs() < 5e-3,
            "{moved:?}, {exact}"
        );
    }
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
            ..unit_rod::<3>(segments, 1.0, Scheme::Bdf2)
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
    let mut rod = Rod::new(unit_rod::<2>(64, 1e4, Scheme::Bdf2)).unwrap();
    rod.loads.pressure_jump = vec![jump; 65];
    rod.solve_static().unwrap();
    let (found, exact) = (rod.tip_displacement()[1], -jump / 8.0);
    assert!((found - exact).abs() < 1e-3 * exact.abs(), "{found} against {exact}");
}

/// In each shape the moment of a uniform pressure about the root is p/2 times the chord squared. The spring 2 EI/l0 of
/// the clamp balances it.
#[test]
fn pressure_load_follows_the_shape() {
    let (jump, segments) = (5.0, 64);
    let mut rod = Rod::new(unit_rod::<2>(segments, 1e5, Scheme::Bdf2)).unwrap();
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

/// Bar of FSI1, as dense as the fluid it displaces, with the loads of a fluid.
fn strained_bar(youngs_modulus: f64, strain_per_pressure: f64) -> Rod<2> {
    let bar = turek_hron_bar(youngs_modulus, 0.0, 42);
    let mut rod = Rod::new(Parameters { displaced: 20.0, strain_per_pressure, ..bar }).unwrap();
    let [force, impedance, pressure] = [86, 43, 43].map(|count| vec![0.0; count]);
    rod.loads = Loads { force, impedance, pressure, ..Loads::default() };
    rod
}

/// Bar of FSI1 under pressure from all sides, by Hooke's law in plane strain with σ_x = σ_y = −p in every section. The
/// pressure falls along the bar, and a bent bar shrinks along its axis.
#[test]
fn pressure_all_round_shrinks_the_bar_by_hookes_law() {
    let (young, nu) = (2.1e3, 0.4);
    let bar = || strained_bar(young, (1.0 + nu) * (1.0 - 2.0 * nu) / young);
    let strain = |p: f64| ((1.0 - nu * nu) * -p - nu * (1.0 + nu) * -p) / young;
    let pressure: Vec<_> = (0..43).map(|k| 50.0 - 20.0 * f64::from(k) / 42.0).collect();
    let expected = 0.35 * strain(40.0);
    assert!(expected < -1e-3, "{expected} m is too little to be seen");

    let mut rod = bar();
    rod.loads.pressure.clone_from(&pressure);
    rod.solve_static().unwrap();
    let [x, y] = rod.tip_displacement();
    assert!((x / expected - 1.0).abs() < 1e-9 && y.abs() < 1e-12, "({x}, {y}) m against {expected} m");

    // A motion in time ends in the same shape, and a state contains it.
    let mut moving = bar();
    moving.loads.pressure.clone_from(&pressure);
    moving.loads.impedance.fill(5.0);
    (0..100).for_each(|_| moving.step(0.5).unwrap());
    let mut other = bar();
    other.loads = moving.loads.clone();
    other.restore(moving.state()).unwrap();
    for (name, rod) in [("moving", &mut moving), ("restored", &mut other)] {
        rod.step(0.5).unwrap();
        let [x, _] = rod.tip_displacement();
        assert!((x / expected - 1.0).abs() < 1e-6, "{name}: {x} m against {expected} m");
    }
    assert_eq!(moving.state(), other.state());

    // The chords of a bent bar, without the change of the tension by bending, 0.2 %.
    moving.loads.force[2 * 43 - 1] = -3e-3;
    moving.solve_static().unwrap();
    let lengths = (1..43).map(|k| {
        let [dx, dy] = [0, 1].map(|d| moving.positions(d)[k] - moving.positions(d)[k - 1]);
        dx.hypot(dy)
    });
    let (length, bent) = (lengths.sum::<f64>(), moving.tip_displacement()[1]);
    assert!(bent < -0.02, "the tip is only {bent} m aside");
    assert!(((length - 0.35) / expected - 1.0).abs() < 2e-3, "{length} m against {} m", 0.35 + expected);
}

#[test]
fn pressure_of_the_wrong_number_and_a_state_without_it_are_refused() {
    let mut rod = strained_bar(1.4e6, 2e-7);
    let other = strained_bar(1.4e6, 0.0);
    assert!(other.state().own.pressure.is_empty());
    let error = rod.restore(other.state()).unwrap_err().to_string();
    assert!(error.contains("state.pressure has 0 entries") && error.contains("43 are needed"), "{error}");
    rod.loads.pressure.push(1.0);
    let error = rod.step(1e-3).unwrap_err().to_string();
    assert!(error.contains("loads.pressure has 44 entries"), "{error}");
}

/// The pressure is followed with the period of the first axial mode, 4 L √(μ/EA).
#[test]
fn pressure_strains_the_bar_with_the_lag_of_its_first_axial_mode() {
    for (young, length_of_step) in [(1.4e6_f64, 0.3), (5.6e6, 1.0), (5.6e6, 3.0)] {
        let axial = young / (1.0 - 0.4 * 0.4) * 0.02;
        let period = 4.0 * 0.35 * (20.0 / axial).sqrt();
        let mut bar = strained_bar(young, 1e-8);
        bar.loads.pressure.fill(7.0);
        let mut expected = 0.0;
        for _ in 0..3 {
            bar.step(length_of_step * period).unwrap();
            expected += (7.0 - expected) * (1.0 - (-length_of_step).exp());
            let found = bar.state().own.pressure[20];
            assert!((found - expected).abs() < 1e-9, "{young}: {found} against {expected}");
        }
    }
}
