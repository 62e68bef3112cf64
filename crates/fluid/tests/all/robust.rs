//! No run fails silently: some cells of the table of stability.

use nervure_fluid::{Error, Grid};

use crate::cases::{Case, LOG_LINEAR, Outcome, channel, hard_scenes, outcome};
use crate::common::fluid_of;

const CASE: Case = Case { scheme: "sbdf2", mask: LOG_LINEAR, c_eta: 1e-5, cfl: 0.4, reynolds: 100.0 };

#[test]
fn flows_start_by_a_jump_at_any_stiffness_and_reynolds_number() {
    for (c_eta, reynolds) in [(1e-2, 1e4), (1e-5, 1.0), (1e-8, 1.0), (1e-8, 1e4)] {
        match outcome(channel(Case { c_eta, reynolds, ..CASE }), 30) {
            Outcome::Ok { fastest } => assert!(fastest > 1.0, "C_eta {c_eta} s, Re {reynolds}: only {fastest} m/s"),
            Outcome::Wild { fastest } => panic!("C_eta {c_eta} s, Re {reynolds}: {fastest} m/s"),
            Outcome::NotFinite => panic!("C_eta {c_eta} s, Re {reynolds}: a silent NaN"),
            Outcome::Error { message, .. } => panic!("C_eta {c_eta} s, Re {reynolds}: {message}"),
        }
    }
}

#[test]
fn hard_scenes_go_through() {
    for (name, scene) in hard_scenes(CASE).unwrap_or_else(|e| panic!("{e}")) {
        match outcome(Ok(scene), 110) {
            Outcome::Ok { .. } => {}
            Outcome::Wild { fastest } => panic!("{name}: {fastest} m/s"),
            Outcome::NotFinite => panic!("{name}: a silent NaN"),
            Outcome::Error { message, .. } => panic!("{name}: {message}"),
        }
    }
}

#[test]
fn what_cannot_go_on_says_why() {
    let stiff = Case { scheme: "rk2", mask: ("sharp", ""), c_eta: 1e-8, ..CASE };
    let mut fast = channel(Case { reynolds: 1e6, ..CASE }).unwrap_or_else(|e| panic!("{e}"));
    // A scene may not have this.
    fast.fluid.as_mut().expect("it has one").time_stepping.max_cfl = 1e9;
    fast.fluid.as_mut().expect("it has one").time_stepping.max_step = 1.0;
    fast.time.communication_step = 0.1;
    for (scene, named) in [(channel(stiff), "C_eta = 9.999e-9 s"), (Ok(fast), "the flow diverged at t =")] {
        match outcome(scene, 1000) {
            Outcome::Error { time: Some(_), message } => {
                assert!(message.contains(named) && message.contains("t = "), "{message}");
            }
            other => panic!("{named}: {other:?}"),
        }
    }
}

/// Heun's method went wild at Re 1e4 and a CFL number of 1 without a word.
#[test]
fn unstable_cfl_numbers_are_refused_and_the_largest_allowed_goes_through() {
    for (scheme, mask, largest) in [("sbdf2", LOG_LINEAR, 0.4), ("rk2", ("sharp", ""), 0.6)] {
        let case = Case { scheme, mask, c_eta: 1e-2, cfl: 1.0, reynolds: 1e4 };
        let error = channel(case).expect_err("a CFL number of 1 is unstable");
        let named = ["fluid.time_stepping.max_cfl", "1", scheme, &largest.to_string()];
        assert!(named.iter().all(|part| error.contains(part)), "{error}");
        let ended = outcome(channel(Case { cfl: largest, ..case }), 100);
        assert!(matches!(ended, Outcome::Ok { .. }), "{scheme}: {ended:?}");
    }
}

/// At the beginning of the communication step the fluid is at rest and would let every step be of 0.01 s.
#[test]
fn steps_are_divided_anew_where_the_flow_becomes_too_fast_within_a_communication_step() {
    let mut scene = channel(CASE).unwrap_or_else(|e| panic!("{e}"));
    scene.time.communication_step = 0.1;
    let mut fluid = fluid_of(&scene);
    fluid.advance(0.0, 0.1).unwrap_or_else(|e| panic!("{e}"));
    assert!(fluid.cfl() < 1.1 * CASE.cfl, "CFL number {}", fluid.cfl());
    assert_eq!(fluid.time(), 0.1);
}

#[test]
fn a_state_of_another_grid_or_scheme_is_refused_and_changes_nothing() {
    let make = |case: Case, cells: usize| {
        let mut scene = channel(case).unwrap_or_else(|e| panic!("{e}"));
        scene.fluid.as_mut().expect("it has one").r#box.cells[0] = cells;
        fluid_of(&scene)
    };
    let mut fluid = make(CASE, 32);
    let before = fluid.state();
    for other in [make(CASE, 36), make(Case { scheme: "rk2", ..CASE }, 32)] {
        let result = fluid.restore(&other.state());
        assert!(matches!(result, Err(Error::State("a field"))), "{result:?}");
        assert_eq!(fluid.state(), before);
    }
}

#[test]
fn far_beyond_all_integers_the_periodic_grid_still_has_indices() {
    let grid = Grid::new([[-0.752, 2.2], [-0.0902, 0.5002]], [200, 40]);
    for p in [1e300, -1e300] {
        let mut around: Vec<usize> = grid.interpolation([p, p]).into_iter().map(|(index, _)| index).collect();
        around.extend(grid.cubic_interpolation([p, p]).map(|(index, _)| index));
        grid.for_each_in([[p, p]; 2], |index, _| around.push(index));
        assert!(around.iter().all(|index| *index < grid.cells[0] * grid.cells[1]), "{p}: {around:?}");
    }
}
