//! Motion in vacuo and under loads.

use std::f64::consts::TAU;

use nervure_rod::{BaseMotion, Error, Parameters, Rod, RodError, Scheme, Section};

use crate::common::{GENERALISED_ALPHA, SCHEMES, total_energy, turek_hron_bar, unit_rod};

/// Roots of 1 + cos b cosh b = 0; the natural frequencies of a cantilever are b² sqrt(EI/µ)/L².
const CANTILEVER: [f64; 3] = [1.875104068711961, 4.694091132974175, 7.854757438237613];

/// Bend a rod along x into `amplitude` times a mode of the Euler–Bernoulli cantilever, at rest.
fn bend_into_mode(rod: &mut Rod<2>, b: f64, amplitude: f64) {
    let mut state = rod.state().clone();
    let length = rod.parameters().length;
    let sigma = (b.sinh() - b.sin()) / (b.cosh() + b.cos());
    for x in &mut state.positions {
        let z = b * x[0] / length;
        x[1] += 0.5 * amplitude * (z.cosh() - z.cos() - sigma * (z.sinh() - z.sin()));
    }
    state.previous_positions.clone_from(&state.positions);
    rod.restore(&state).unwrap();
}

/// Return the frequency of y of the tip, between the first and the last interpolated crossing of its mean.
fn frequency(dt: f64, y: &[f64]) -> f64 {
    let mean = 0.5 * (y.iter().copied().fold(f64::MIN, f64::max) + y.iter().copied().fold(f64::MAX, f64::min));
    let crossings: Vec<f64> = y
        .windows(2)
        .enumerate()
        .filter(|(_, w)| w[0] < mean && w[1] >= mean)
        .map(|(k, w)| dt * (k as f64 + (mean - w[0]) / (w[1] - w[0])))
        .collect();
    (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0])
}

/// Return the vertical displacements of the tip in `steps` steps of `dt`.
fn tip_history(rod: &mut Rod<2>, dt: f64, steps: usize) -> Vec<[f64; 2]> {
    (0..steps)
        .map(|_| {
            rod.step(dt).unwrap();
            rod.tip_displacement()
        })
        .collect()
}

#[test]
fn first_three_frequencies_of_small_vibrations_are_those_of_the_cantilever_within_0_1_percent() {
    for b in CANTILEVER {
        let exact = b * b / TAU;
        let mut rod = Rod::new(unit_rod::<2>(128, 1e4, Scheme::Trapezoid)).unwrap();
        bend_into_mode(&mut rod, b, 1e-5);
        let dt = 1.0 / (exact * 400.0);
        let y: Vec<f64> = tip_history(&mut rod, dt, 4 * 400).iter().map(|tip| tip[1]).collect();
        let found = frequency(dt, &y);
        assert!((found / exact - 1.0).abs() < 1e-3, "{found} Hz against {exact} Hz");
    }
}

/// CSM3 of Turek & Hron (2006): from rest under 2 m/s². The second mode is undamped and beats with the first mode. Mean
/// and amplitude, (max ± min)/2 of a period, are therefore averages over ten periods.
#[test]
fn csm3_agrees_with_the_published_bar_within_a_percent() {
    let published = [-14.305, 14.305, -63.607, 65.160, 1.0995];
    let (dt, periods, steps) = (1e-3, 10, 910);
    for scheme in SCHEMES {
        let mut rod = Rod::new(Parameters { scheme, ..turek_hron_bar(1.4e6, 2.0, 42) }).unwrap();
        let tips = tip_history(&mut rod, dt, periods * steps);
        let average = |d: usize, sign: f64| {
            let of_period = |tips: &[[f64; 2]]| {
                let values = || tips.iter().map(|tip| 1e3 * tip[d]);
                0.5 * (values().fold(f64::MIN, f64::max) + sign * values().fold(f64::MAX, f64::min))
            };
            tips.chunks(steps).map(of_period).sum::<f64>() / periods as f64
        };
        let y: Vec<f64> = tips.iter().map(|tip| tip[1]).collect();
        let found = [average(0, 1.0), average(0, -1.0), average(1, 1.0), average(1, -1.0), frequency(dt, &y)];
        for (found, published) in found.into_iter().zip(published) {
            assert!((found / published - 1.0).abs() < 0.01, "{scheme:?}: {found} against {published}");
        }
    }
}

/// The bar of CSM3 in 32 segments.
fn csm3(scheme: Scheme) -> Rod<2> {
    Rod::new(Parameters { scheme, ..turek_hron_bar(1.4e6, 2.0, 32) }).unwrap()
}

/// Return the change of the energy in 60 s, relative to the energy in gravity, and the halvings; stop at a gain of
/// 0.34.
fn energy_drift(mut rod: Rod<2>, dt: f64) -> (f64, usize) {
    let (mut scale, mut drift, mut halvings) = (0.0_f64, 0.0, 0);
    for _ in 0..(60.0 / dt).round() as usize {
        rod.step(dt).unwrap();
        halvings += rod.statistics().halvings;
        scale = scale.max(rod.energy().unwrap().gravity.abs());
        drift = total_energy(&rod) / scale;
        if drift >= 0.34 {
            break;
        }
    }
    (drift, halvings)
}

#[test]
fn default_scheme_loses_less_than_a_percent_of_energy_in_a_minute_of_csm3() {
    let (drift, _) = energy_drift(csm3(Scheme::default()), 1e-2);
    assert!(-1e-2 < drift && drift <= 0.0, "{drift}");
}

/// The trapezoidal rule of the thesis gains a third of the energy at twice that step, and more later. A driven root
/// that stays in place shows the gain, because the guard ignores a rod with a drive, whose work is unknown.
#[test]
fn trapezoid_gains_a_third_of_energy_in_a_minute_of_csm3() {
    let mut unguarded = csm3(Scheme::Trapezoid);
    let &Parameters { attachment: position, direction, .. } = unguarded.parameters();
    unguarded.base_motion = Some(BaseMotion { position, velocity: [0.0; 2], direction, direction_rate: [0.0; 2] });
    let (drift, halvings) = energy_drift(unguarded, 2e-2);
    assert!(drift >= 0.34 && halvings == 0, "{drift}, {halvings} halvings");
    let (default, _) = energy_drift(csm3(Scheme::default()), 2e-2);
    assert!(-1e-2 < default && default <= 0.0, "default scheme: {default}");
}

#[test]
fn trapezoid_holds_its_energy_in_a_minute_of_csm3_with_the_energy_guard() {
    let (resolved, halvings) = energy_drift(csm3(Scheme::Trapezoid), 1e-2);
    assert!(resolved.abs() < 1e-5 && halvings == 0, "{resolved}, {halvings} halvings");
    let (coarse, halvings) = energy_drift(csm3(Scheme::Trapezoid), 2e-2);
    assert!(coarse.abs() < 1e-2 && halvings > 0, "{coarse}, {halvings} halvings");
}

/// A tip force A sin²(πt/2) on a rod with four soft segments, up to t = 1.
fn tip_after_ramp(scheme: Scheme, steps: usize, unequal: bool) -> [f64; 2] {
    let mut rod = Rod::new(unit_rod::<2>(4, 100.0, scheme)).unwrap();
    rod.loads.force = vec![0.0; 2 * 5];
    let mut time = 0.0;
    for step in 0..steps {
        let dt = if unequal { 1.0 + 0.4 * (-1.0_f64).powi(step as i32) } else { 1.0 } / steps as f64;
        time += dt;
        rod.loads.force[9] = 5.0 * (0.25 * TAU * time).sin().powi(2);
        rod.step(dt).unwrap();
    }
    rod.tip_displacement()
}

fn assert_second_order(scheme: Scheme, unequal: bool) {
    let exact = tip_after_ramp(Scheme::Trapezoid, 51200, false);
    let errors = [400, 800, 1600].map(|steps| {
        let tip = tip_after_ramp(scheme, steps, unequal);
        (tip[0] - exact[0]).hypot(tip[1] - exact[1])
    });
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.15, "{scheme:?}: order {order}, errors {errors:?}");
    }
}

#[test]
fn trapezoid_is_second_order() {
    assert_second_order(Scheme::Trapezoid, false);
}

#[test]
fn generalised_alpha_is_second_order() {
    assert_second_order(GENERALISED_ALPHA, false);
}

#[test]
fn tr_bdf2_is_second_order() {
    assert_second_order(Scheme::TrBdf2, false);
}

#[test]
fn bdf2_is_second_order() {
    assert_second_order(Scheme::Bdf2, false);
}

#[test]
fn bdf2_is_second_order_with_unequal_steps() {
    assert_second_order(Scheme::Bdf2, true);
}

#[test]
fn trapezoid_conserves_the_energy_of_small_motion() {
    let mut rod = Rod::new(unit_rod::<2>(32, 1e4, Scheme::Trapezoid)).unwrap();
    bend_into_mode(&mut rod, CANTILEVER[0], 1e-4);
    let start = total_energy(&rod);
    for step in 0..2000 {
        rod.step(5e-3).unwrap();
        let energy = total_energy(&rod);
        assert!((energy / start - 1.0).abs() < 1e-5, "step {step}: {energy} J after {start} J");
    }
}

/// Bar of CSM3 in units of its length, with segments of 1e9 N/m and a step of 1e-2, where the trapezoid fails.
#[test]
fn dissipative_schemes_never_gain_energy_on_a_stiff_rod() {
    let segments = 32;
    for scheme in [GENERALISED_ALPHA, Scheme::TrBdf2, Scheme::Bdf2] {
        let section = Section {
            line_density: 0.0571428571,
            bending_stiffness: 0.0259151,
            axial_stiffness: 1e9 / segments as f64,
            shear_stiffness: None,
        };
        let gravity = [0.0, -0.7];
        let mut rod = Rod::new(Parameters { section, gravity, ..unit_rod::<2>(segments, 1.0, scheme) }).unwrap();
        let mut largest = f64::MIN;
        let mut statistics = rod.statistics();
        for _ in 0..3000 {
            rod.step(1e-2).unwrap();
            largest = largest.max(total_energy(&rod));
            statistics.iterations = statistics.iterations.max(rod.statistics().iterations);
            statistics.substeps = statistics.substeps.max(rod.statistics().substeps);
        }
        assert!(largest <= 1e-12, "{scheme:?}: {largest} J above a start at 0 J");
    }
}

/// Return the largest rise of the energy less the work of the loads, relative to the largest kinetic or elastic energy.
///
/// The reference is the lowest value since the closure changed the loads, with the trapezoid the first value. The count
/// starts with the third step after the change.
fn largest_rise<const D: usize>(
    rod: &mut Rod<D>,
    dt: f64,
    steps: usize,
    mut drive: impl FnMut(&mut Rod<D>, usize) -> bool,
) -> Result<f64, Error> {
    let (mut since, mut lowest, mut largest, mut rise) = (0, f64::MAX, 0.0_f64, 0.0_f64);
    for step in 0..steps {
        if drive(rod, step) {
            (since, lowest, largest) = (0, f64::MAX, 0.0);
        }
        let before = rod.state().clone();
        if let Err(error) = rod.step(dt) {
            assert_eq!(rod.state(), &before);
            return Err(error);
        }
        since += 1;
        let energy = rod.energy().unwrap();
        let nodes = rod.parameters().segments + 1;
        let forces = rod.loads.force.chunks(nodes).enumerate();
        let work: f64 = forces.flat_map(|(d, force)| rod.positions(d).iter().zip(force)).map(|(x, f)| x * f).sum();
        let total = total_energy(rod) - work;
        largest = largest.max(energy.kinetic).max(energy.stretching + energy.bending);
        if since > 2 {
            let conserving = rod.parameters().scheme == Scheme::Trapezoid;
            lowest = if conserving && since > 3 { lowest } else { lowest.min(total) };
            rise = rise.max((total - lowest) / largest);
        }
    }
    Ok(rise)
}

/// Return the beam of the thesis, section 2.4.1, in units of its length, without weight.
fn calm_rod(scheme: Scheme) -> Rod<3> {
    let section =
        Section { line_density: 0.0571, bending_stiffness: 0.0259, axial_stiffness: 95.18, shear_stiffness: None };
    let mut rod = Rod::new(Parameters { section, ..unit_rod(64, 1.0, scheme) }).unwrap();
    rod.loads.force = vec![0.0; 3 * 65];
    rod
}

/// A load pushes the tip through the root and ends, in steps that do not resolve axial waves. Without a guard, the
/// energy rose by 77 % with rho_inf = 0.8 and doubled with the trapezoid.
#[test]
fn guarded_schemes_do_not_gain_energy_where_the_rod_folds_back() {
    let generalised_alpha = [0.5, 0.8, 0.95, 1.0].map(|rho_inf| Scheme::GeneralisedAlpha { rho_inf });
    for scheme in generalised_alpha.into_iter().chain([Scheme::Trapezoid]) {
        let mut rod = calm_rod(scheme);
        let mut substeps = 0;
        let result = largest_rise(&mut rod, 2e-2, 400, |rod, step| {
            substeps = substeps.max(rod.statistics().substeps);
            let tip = if step < 200 { [-1.0, 0.3, 0.1] } else { [0.0; 3] };
            (0..3).for_each(|d| rod.loads.force[65 * d + 64] = tip[d]);
            step == 0 || step == 200
        });
        match result {
            Ok(rise) => assert!(rise <= 0.01 && substeps > 1, "{scheme:?}: a rise of {rise}, {substeps} sub-steps"),
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains("gains energy") && message.contains("tr_bdf2"), "{scheme:?}: {message}");
            }
        }
    }
}

/// A blow that the smallest sub-step does not resolve.
#[test]
fn step_that_would_gain_energy_ends_with_an_error_and_the_state_as_it_was() {
    let mut rod = calm_rod(Scheme::GeneralisedAlpha { rho_inf: 0.9 });
    (rod.loads.force[64], rod.loads.force[2 * 65 - 1]) = (-1e4, 100.0);
    let error = largest_rise(&mut rod, 0.1, 100, |_, _| false).unwrap_err();
    let Error::Structure(RodError::EnergyGain { scheme, .. }) = error else { panic!("{error}") };
    assert_eq!(scheme, Scheme::GeneralisedAlpha { rho_inf: 0.9 });
}

/// A state with a reference energy below its energy.
#[test]
fn trapezoid_that_has_gained_energy_ends_with_an_error_that_gives_it() {
    let mut rod = csm3(Scheme::Trapezoid);
    (0..30).for_each(|_| rod.step(6.4e-3).unwrap());
    let mut state = rod.state().clone();
    state.own.reference_energy -= 0.02 * state.own.largest_energy;
    rod.restore(&state).unwrap();
    let message = rod.step(6.4e-3).unwrap_err().to_string();
    assert_eq!(rod.state(), &state);
    let reference = format!("from {:.6e} J to ", state.own.reference_energy);
    for part in ["trapezoid gains energy", &reference, "in sub-steps of 1.000e-4 s", "tr_bdf2", "smaller step"] {
        assert!(message.contains(part), "no {part:?} in {message:?}");
    }
}

/// The guard subtracts the energy lost by damping from the reference.
#[test]
fn reference_of_the_trapezoid_follows_the_damping() {
    let damping = 0.4;
    let mut rod = Rod::new(Parameters { damping, ..unit_rod::<2>(32, 1e4, Scheme::Trapezoid) }).unwrap();
    bend_into_mode(&mut rod, CANTILEVER[0], 1e-3);
    let start = total_energy(&rod);
    for step in 0..1000 {
        rod.step(5e-3).unwrap();
        let (energy, reference) = (total_energy(&rod), rod.state().own.reference_energy);
        assert!(step == 0 || (energy - reference).abs() < 1e-5 * start, "step {step}: {energy} against {reference}");
    }
    assert!(total_energy(&rod) < 0.2 * start, "{} J after {start} J", total_energy(&rod));
}

/// Thirty periods of CSM3 at a sixtieth of a period.
#[test]
fn free_swing_with_little_dissipation_is_not_stopped() {
    let generalised_alpha = [0.0, 0.5, 0.8, 0.95].map(|rho_inf| Scheme::GeneralisedAlpha { rho_inf });
    for scheme in generalised_alpha.into_iter().chain([Scheme::Trapezoid]) {
        let mut rod = csm3(scheme);
        let mut substeps = 0;
        let rise = largest_rise(&mut rod, 1.5e-2, 1800, |rod, _| {
            substeps = substeps.max(rod.statistics().substeps);
            false
        });
        assert!(rise.unwrap() < 1e-3 && substeps == 1, "{scheme:?}: {substeps} sub-steps");
    }
}

/// A blow of 10 kN on the tip in one long step turns the bar over into equilibrium.
#[test]
fn blow_within_one_long_step_ends_in_equilibrium() {
    let mut rod = Rod::new(turek_hron_bar(5.6e6, 2.0, 42)).unwrap();
    rod.loads.force = vec![0.0; 2 * 43];
    rod.loads.force[42] = -1e4;
    rod.loads.force[85] = 100.0;
    (0..100).for_each(|_| rod.step(0.1).unwrap());
    let moved = rod.tip_displacement();
    rod.solve_static().unwrap();
    let settled = rod.tip_displacement();
    let distance = (moved[0] - settled[0]).hypot(moved[1] - settled[1]);
    assert!(distance < 1e-5 && settled[0] < -0.5, "{moved:?} after steps, {settled:?} in equilibrium");
}

/// Return iterations and sub-steps of the worst step, and the largest energy, of a level rod that falls in steps of 0.1
/// s.
fn fall_in_long_steps(segments: usize, k_e: f64, bending_stiffness: f64) -> (usize, usize, f64) {
    let section = Section {
        line_density: 0.0571,
        bending_stiffness,
        axial_stiffness: k_e / segments as f64,
        shear_stiffness: None,
    };
    let gravity = [0.0, -0.7];
    let rod = Parameters { section, gravity, ..unit_rod::<2>(segments, 1.0, Scheme::TrBdf2) };
    let mut rod = Rod::new(rod).unwrap();
    let (mut iterations, mut substeps, mut largest) = (0, 0, f64::MIN);
    for _ in 0..50 {
        rod.step(0.1).unwrap();
        iterations = iterations.max(rod.statistics().iterations);
        substeps = substeps.max(rod.statistics().substeps);
        largest = largest.max(total_energy(&rod));
    }
    (iterations, substeps, largest)
}

/// Return a chain whose segments whip around within a step.
#[test]
fn step_too_long_is_taken_in_substeps() {
    let (_, substeps, largest) = fall_in_long_steps(32, 1e9, 1e-5);
    assert!(substeps > 1, "{substeps} sub-steps");
    assert!(largest <= 1e-12, "{largest} J above a start at 0 J");
}

/// Free fall, Newton's first guess, stretches the first of many segments sevenfold in the first step.
#[test]
fn long_steps_of_a_fine_rod_are_easy() {
    for (k_e, bending_stiffness) in [(1e3, 1e-4), (1e5, 1e2), (1e9, 1e3)] {
        let (iterations, substeps, largest) = fall_in_long_steps(2048, k_e, bending_stiffness);
        let case = format!("k_e {k_e}, EI {bending_stiffness}");
        assert!(iterations <= 12 && substeps == 1, "{case}: {iterations} iterations, {substeps} sub-steps");
        assert!(largest <= 1e-12, "{case}: {largest} J above a start at 0 J");
    }
}

/// Bar of FSI3 in a gusty load that swings its tip by 4 cm.
#[test]
fn newton_takes_two_iterations_a_solve_at_the_step_of_fsi3() {
    let (dt, nodes) = (2e-4, 43);
    for scheme in SCHEMES {
        let mut rod = Rod::new(Parameters { scheme, ..turek_hron_bar(5.6e6, 0.0, nodes - 1) }).unwrap();
        rod.loads.force = vec![0.0; 2 * nodes];
        let mut largest = 0.0_f64;
        for step in 1..=10_000 {
            for (k, force) in rod.loads.force[nodes..].iter_mut().enumerate() {
                let swing = 150.0 * (34.0 * dt * f64::from(step)).sin();
                let gust = 200.0 * (1.7 * f64::from(step) * k as f64).sin();
                *force = (swing + gust) * 0.35 / (nodes - 1) as f64;
            }
            rod.step(dt).unwrap();
            let statistics = rod.statistics();
            let solves = if scheme == Scheme::TrBdf2 { 2 } else { 1 };
            let within =
                statistics.iterations <= 2 * solves && statistics.substeps == 1 && statistics.negative_pivots == 0;
            assert!(within, "{scheme:?}, step {step}: {statistics:?}");
            largest = largest.max(rod.tip_displacement()[1].abs());
        }
        assert!(largest > 0.03, "{scheme:?}: the tip only reached {largest} m");
    }
}

/// A rod without mass under a load −M dv/dt, with the differences of BDF2, moves like a rod of the mass M.
#[test]
fn added_mass_through_the_impedance_is_mass() {
    let dt = 2e-2;
    let weight = |nodes: usize| {
        let mut force = vec![0.0; 2 * nodes];
        force[nodes..].fill(-1.0 / nodes as f64);
        force
    };
    let heavy = unit_rod::<2>(16, 1e3, Scheme::Bdf2);
    let mut light = Rod::new(Parameters { displaced: 1.0, ..heavy.clone() }).unwrap();
    let mut heavy = Rod::new(heavy).unwrap();
    heavy.loads.force = weight(17);
    light.loads.impedance = vec![0.0; 17];
    for step in 0..200 {
        let (new, old) = if step == 0 { (1.0, 0.0) } else { (1.5, 0.5) };
        let state = light.state().clone();
        light.loads.force = weight(17);
        for k in 0..17 {
            let mass = if k == 16 { 0.5 / 16.0 } else { 1.0 / 16.0 };
            light.loads.impedance[k] = new * mass / dt;
            for d in 0..2 {
                let old_difference = old * (state.velocities[k][d] - state.previous_velocities[k][d]) / dt;
                light.loads.force[d * 17 + k] += mass * old_difference;
            }
        }
        heavy.step(dt).unwrap();
        light.step(dt).unwrap();
        for d in 0..2 {
            let (found, expected) = (light.tip_displacement()[d], heavy.tip_displacement()[d]);
            assert!((found - expected).abs() < 1e-11, "step {step}: {found} against {expected}");
        }
    }
    assert!(heavy.tip_displacement()[1].abs() > 0.01, "it hardly moved: {:?}", heavy.tip_displacement());
}

/// Without damping, physical or numerical, the final energy is the work of the loads, up to the rectangle rule.
#[test]
fn energy_is_the_work_of_the_loads() {
    let imbalance = |dt: f64| {
        let mut rod = Rod::new(unit_rod::<2>(16, 1e3, Scheme::Trapezoid)).unwrap();
        rod.loads.force = vec![0.0; 2 * 17];
        rod.loads.impedance = vec![0.5; 17];
        let steps = (2.0 / dt).round() as usize;
        for step in 1..=steps {
            let t = step as f64 * dt;
            rod.loads.force[33] = 0.1 * (1.0 - (3.0 * t).cos());
            rod.loads.force[25] = -0.3 * t * t * (-t).exp();
            rod.step(dt).unwrap();
        }
        let energy = rod.energy().unwrap();
        let own = energy.kinetic + energy.stretching + energy.bending;
        (rod.state().exchange.work - own) / own
    };
    let found = [2e-3, 1e-3, 5e-4].map(imbalance);
    assert!(found[2].abs() < 2e-3, "{found:?} of the energy");
    let ratio = found[0] / found[1];
    assert!((1.8..2.2).contains(&ratio), "{found:?}: not of first order");
}

#[test]
fn rod_without_mass_works_in_every_scheme() {
    for scheme in SCHEMES {
        let parameters = unit_rod::<2>(16, 1e3, scheme);
        let mut settled = Rod::new(parameters.clone()).unwrap();
        let mut rod = Rod::new(Parameters { displaced: 1.0, ..parameters }).unwrap();
        let mut force = vec![0.0; 2 * 17];
        force[33] = 0.5;
        settled.loads.force.clone_from(&force);
        settled.solve_static().unwrap();
        rod.loads.force = force;
        rod.loads.impedance = vec![0.1; 17];
        // D (v − v_ref) only slows the motion, which ends in the balance of forces.
        for _ in 0..20000 {
            rod.step(1e-2).unwrap();
        }
        let (found, expected) = (rod.tip_displacement()[1], settled.tip_displacement()[1]);
        assert!((found / expected - 1.0).abs() < 1e-3, "{scheme:?}: {found} against {expected}");
    }
}

#[test]
fn restored_state_continues_bit_by_bit() {
    for (scheme, jump) in SCHEMES.into_iter().flat_map(|scheme| [(scheme, 300.0), (scheme, 0.0)]) {
        let mut rod = Rod::new(Parameters { scheme, ..turek_hron_bar(5.6e6, 2.0, 42) }).unwrap();
        rod.loads.pressure_jump = vec![jump; 43];
        for _ in 0..20 {
            rod.step(1e-3).unwrap();
        }
        let written = serde_json::to_value(rod.state()).unwrap();
        for dt in [1e-3, 5e-4, 1e-3] {
            rod.step(dt).unwrap();
        }
        let mut other = Rod::new(rod.parameters().clone()).unwrap();
        other.loads = rod.loads.clone();
        other.restore(&serde_json::from_value(written).unwrap()).unwrap();
        for dt in [1e-3, 5e-4, 1e-3] {
            other.step(dt).unwrap();
        }
        let (found, expected) = (other.tip_displacement(), rod.tip_displacement());
        assert!(other.state() == rod.state(), "{scheme:?}: {found:?} against {expected:?}");
    }
}

#[test]
fn largest_step_divides_the_step_evenly() {
    let parameters = turek_hron_bar(5.6e6, 2.0, 8);
    let mut whole = Rod::new(Parameters { max_step: Some(2.5e-4), ..parameters.clone() }).unwrap();
    let mut parts = Rod::new(parameters).unwrap();
    for _ in 0..5 {
        whole.step(1e-3 * (1.0 + 1e-15)).unwrap();
        assert_eq!(whole.statistics().substeps, 4);
        (0..4).for_each(|_| parts.step(2.5e-4).unwrap());
    }
    let (found, expected) = (whole.tip_displacement()[1], parts.tip_displacement()[1]);
    assert!((found / expected - 1.0).abs() < 1e-9, "{found} against {expected}");
}

/// Damping c per length damps all modes alike: the amplitude falls as exp(−c t/2µ).
#[test]
fn damping_takes_its_share() {
    let damping = 0.4;
    let mut rod = Rod::new(Parameters { damping, ..unit_rod::<2>(32, 1e4, Scheme::Trapezoid) }).unwrap();
    bend_into_mode(&mut rod, CANTILEVER[0], 1e-4);
    let start = total_energy(&rod);
    // A whole number of half periods, where kinetic energy and damping power vanish.
    let omega = (CANTILEVER[0].powi(4) - 0.25 * damping * damping).sqrt();
    let (periods, steps) = (3.0, 3000);
    let end = periods * TAU / omega;
    (0..steps).for_each(|_| rod.step(end / steps as f64).unwrap());
    let (found, expected) = (total_energy(&rod) / start, (-damping * end).exp());
    assert!((found / expected - 1.0).abs() < 5e-3, "{found} against {expected}");
}
