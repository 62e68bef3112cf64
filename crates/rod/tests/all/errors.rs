//! Each bad input is refused with its name and value.

use nervure_rod::{Bending, Calibration, Error, Loads, Parameters, Rod, RodState, Scheme, Section};

use crate::common::{turek_hron_bar, unit_rod};

fn bar() -> Parameters<2> {
    turek_hron_bar(5.6e6, 2.0, 4)
}

fn assert_names(error: &Error, parts: &[&str]) {
    let message = error.to_string();
    for part in parts {
        assert!(message.contains(part), "no {part:?} in {message:?}");
    }
}

#[test]
fn bad_parameters_are_named() {
    let section = bar().section;
    for (parameters, parts) in [
        (Parameters { segments: 1, ..bar() }, ["segments is 1", "at least 2"]),
        (Parameters { length: 0.0, ..bar() }, ["length is 0", "above 0"]),
        (Parameters { length: f64::NAN, ..bar() }, ["length is NaN", "finite"]),
        (Parameters { attachment: [f64::INFINITY, 0.0], ..bar() }, ["attachment is [inf, 0.000e0]", "finite"]),
        (Parameters { direction: [0.0, 0.0], ..bar() }, ["direction is [0.000e0, 0.000e0]", "but 0"]),
        (Parameters { gravity: [0.0, f64::NAN], ..bar() }, ["gravity is [0.000e0, NaN]", "finite"]),
        (Parameters { damping: -1.0, ..bar() }, ["damping is -1", "at least 0"]),
        (Parameters { displaced: -1.0, ..bar() }, ["displaced is -1", "at least 0"]),
        (Parameters { strain_per_pressure: -1e-7, ..bar() }, ["strain_per_pressure is -1.000e-7", "at least 0"]),
        (Parameters { displaced: 21.0, ..bar() }, ["weighs 20 kg/m and displaces 21 kg/m", "-1 kg/m"]),
        (Parameters { segments: 0, ..bar() }, ["segments is 0", "at least 2"]),
        (
            Parameters { clamp_compliance_length: -1e-3, ..bar() },
            ["clamp_compliance_length is -1.000e-3", "at least 0"],
        ),
        (Parameters { calibration: Calibration::Thesis { k_e: 0.0 }, ..bar() }, ["k_e is 0", "above 0"]),
        (Parameters { rest_angles: vec![0.1; 3], ..bar() }, ["rest_angles has 3 entries", "4 are needed"]),
        (
            Parameters { rest_angles: vec![0.0, 0.0, 3.2, 0.0], ..bar() },
            ["rest_angles[2] is 3.2", "less than π from the angle of the segment before"],
        ),
        (Parameters { rest_angles: vec![0.0, f64::NAN, 0.0, 0.0], ..bar() }, ["rest_angles[1] is NaN", "finite"]),
        (Parameters { max_step: Some(0.0), ..bar() }, ["max_step is 0", "above 0"]),
        (
            Parameters { section: Section { line_density: 0.0, ..section }, ..bar() },
            ["section.line_density is 0", "above 0"],
        ),
        (
            Parameters { section: Section { bending_stiffness: -2.0, ..section }, ..bar() },
            ["section.bending_stiffness is -2", "above 0"],
        ),
        (
            Parameters { section: Section { axial_stiffness: f64::NAN, ..section }, ..bar() },
            ["section.axial_stiffness is NaN", "above 0"],
        ),
        (
            Parameters { scheme: Scheme::GeneralisedAlpha { rho_inf: 1.5 }, ..bar() },
            ["rho_inf is 1.5", "between 0 and 1"],
        ),
    ] {
        match Rod::new(parameters) {
            Ok(_) => panic!("accepted where {parts:?} was expected"),
            Err(error) => assert_names(&error, &parts),
        }
    }
}

#[test]
fn curved_rest_shape_in_space_is_refused() {
    let curved = Parameters { rest_angles: vec![0.1; 4], ..unit_rod::<3>(4, 1.0, Scheme::TrBdf2) };
    let Err(error) = Rod::new(curved) else { panic!("accepted") };
    assert_names(&error, &["rest_angles is given for 4 segments", "material frame"]);
}

/// The rod starts upright or a load bends it upright; beyond the vertical the angle of the thesis about the other axis
/// jumps.
#[test]
fn projected_bending_stops_at_its_singularity() {
    let projected = Parameters { bending: Bending::Projected, ..unit_rod::<3>(16, 1e3, Scheme::TrBdf2) };
    let Err(error) = Rod::new(Parameters { direction: [0.0, 1.0, 0.0], ..projected.clone() }) else {
        panic!("an upright rod was accepted")
    };
    let parts = ["in the plane xz is singular", "invariant bending"];
    assert_names(&error, &parts);

    let mut rod = Rod::new(projected).unwrap();
    rod.loads.force = vec![0.0; 3 * 17];
    rod.loads.force[2 * 17 - 1] = 20.0;
    let mut before = rod.state().clone();
    let error = loop {
        match rod.step(1e-2) {
            Ok(()) => before = rod.state().clone(),
            Err(error) => break error,
        }
    };
    assert_names(&error, &parts);
    assert_eq!(rod.state(), &before);
}

#[test]
fn bad_loads_are_named_and_change_nothing() {
    let mut rod = Rod::new(bar()).unwrap();
    let before = rod.state().clone();
    let with = |at: usize, value: f64, count: usize| {
        let mut array = vec![0.0; count];
        array[at] = value;
        array
    };
    for (loads, parts) in [
        (Loads { force: vec![0.0; 9], ..Loads::default() }, ["loads.force has 9 entries", "10 are needed"]),
        (Loads { impedance: vec![0.0; 6], ..Loads::default() }, ["loads.impedance has 6", "5 are needed"]),
        (Loads { pressure_jump: vec![0.0; 1], ..Loads::default() }, ["loads.pressure_jump has 1", "5 are"]),
        (Loads { force: with(7, f64::NAN, 10), ..Loads::default() }, ["loads.force[7] is NaN", "finite"]),
        (Loads { impedance: with(2, -3.0, 5), ..Loads::default() }, ["loads.impedance[2] is -3", "at least 0"]),
        (Loads { pressure_jump: with(4, f64::INFINITY, 5), ..Loads::default() }, ["[4] is inf", "finite"]),
    ] {
        rod.loads = loads;
        assert_names(&rod.step(1e-3).unwrap_err(), &parts);
        assert_names(&rod.solve_static().unwrap_err(), &parts);
        assert_eq!(rod.state(), &before);
    }
    let mut rod = Rod::new(unit_rod::<3>(4, 1.0, Scheme::Bdf2)).unwrap();
    rod.loads.pressure_jump = vec![0.0; 5];
    assert_names(&rod.step(1e-3).unwrap_err(), &["loads.pressure_jump has 5 entries", "0 are needed"]);
}

#[test]
fn bad_durations_are_named() {
    let mut rod = Rod::new(bar()).unwrap();
    for duration in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        assert_names(&rod.step(duration).unwrap_err(), &[&format!("duration is {duration:.3e}"), "above 0"]);
    }
}

#[test]
fn step_too_long_for_its_parts_is_refused() {
    let mut rod = Rod::new(Parameters { max_step: Some(1e-4), ..bar() }).unwrap();
    assert_names(&rod.step(11.0).unwrap_err(), &["duration is 1.100e1", "10000 times max_step"]);
    rod.step(1e-3).unwrap();
}

#[test]
fn step_too_short_for_any_digit_ends_with_an_error_and_the_state_as_it_was() {
    let mut rod = Rod::new(bar()).unwrap();
    let before = rod.state().clone();
    for duration in [5e-324, 1e-300, 1e-200] {
        rod.step(duration).expect_err("dt squared is 0");
        assert_eq!(rod.state(), &before);
    }
    rod.step(1e-3).unwrap();
}

#[test]
fn bad_states_are_named() {
    let mut rod = Rod::new(bar()).unwrap();
    let good = rod.state().clone();
    let edit = |change: fn(&mut RodState<2>)| {
        let mut state = good.clone();
        change(&mut state);
        state
    };
    for (state, parts) in [
        (edit(|s| s.velocities.truncate(4)), ["state.velocities has 4 entries", "5 are needed"]),
        (edit(|s| s.positions[2][1] = f64::NAN), ["state.positions[2]", "finite"]),
        (
            edit(|s| s.positions[0][1] = 0.1),
            ["state.positions[0] is [2.500e-1, 1.000e-1]", "the position of the root at rest"],
        ),
        (edit(|s| s.velocities[0][1] = 0.1), ["state.velocities[0] is [0.000e0, 1.000e-1]", "0 at a root at rest"]),
        (edit(|s| s.last_step = -1.0), ["state.last_step is -1", "at least 0"]),
        (edit(|s| s.own.reference_energy = f64::INFINITY), ["state.reference_energy is inf", "finite"]),
        (edit(|s| s.own.largest_energy = -1.0), ["state.largest_energy is -1", "at least 0 J"]),
        (edit(|s| s.positions[2] = s.positions[0]), ["folds back at node 1", "must be above"]),
    ] {
        assert_names(&rod.restore(&state).unwrap_err(), &parts);
        assert_eq!(rod.state(), &good);
    }
}

#[test]
fn hopeless_step_ends_with_an_error_and_the_state_as_it_was() {
    let mut rod = Rod::new(bar()).unwrap();
    rod.step(1e-3).unwrap();
    let before = rod.state().clone();
    rod.loads.force = vec![1e300; 10];
    assert_names(&rod.step(1e-3).unwrap_err(), &["residual of", "N, above", "iterations"]);
    assert_eq!(rod.state(), &before);
    rod.loads.force.fill(0.0);
    rod.step(1e-3).unwrap();
}
