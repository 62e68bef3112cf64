//! Exact solutions and invariants.

use std::f64::consts::{PI, TAU};

use nervure_fluid::{Fluid, Loads, Stations};
use rustfft::num_complex::Complex64;
use scene::{Filter, Mask, TimeScheme, WallCorrection};

use crate::common::{fluid_of, run, scene, spectrum, unlimited_fluid_of};
use crate::measures::{
    BEAM, CYLINDER_IN_CHANNEL, added_mass, aliased, arrays, flux_error, made_by_advection, noise, resolved_noise,
    taylor_green_error, walls,
};

const FREE_BEAM: &str = r#", "beam": { "root": { "at": { "position": [0.4, 0.2], "direction": [1, 0] } },
    "length": 0.35, "thickness": 0.05, "segments": 12 }"#;

#[test]
fn the_taylor_green_vortex_decays_with_second_order_in_time() {
    for (scheme, limit) in [(TimeScheme::Sbdf2, 1.5e-5), (TimeScheme::Rk2, 5e-6)] {
        let [coarse, fine] = [80, 160].map(|steps| taylor_green_error(scheme, steps, &[1.0]));
        let order = (coarse / fine).log2();
        assert!(fine < limit, "{scheme:?}: error {fine} with 160 steps");
        assert!((order - 2.0).abs() < 0.1, "{scheme:?}: order {order}: errors {coarse} and {fine}");
    }
}

/// In a pattern of two steps the errors of a wrong extrapolation would cancel.
#[test]
fn the_order_in_time_holds_with_unequal_steps() {
    for (scheme, limit) in [(TimeScheme::Sbdf2, 3e-5), (TimeScheme::Rk2, 1e-5)] {
        let [coarse, fine] = [81, 162].map(|steps| taylor_green_error(scheme, steps, &[0.5, 0.5, 2.0]));
        let order = (coarse / fine).log2();
        assert!(fine < limit, "{scheme:?}: error {fine} with 162 steps");
        assert!((order - 2.0).abs() < 0.1, "{scheme:?}: order {order}: errors {coarse} and {fine}");
    }
}

/// Largest growth in a step, over all waves that the smooth filter leaves, of advection without viscosity at a CFL
/// number.
fn growth(scheme: TimeScheme, cfl: f64) -> f64 {
    let waves = (1..=1000).map(|k| f64::from(k) / 1000.0);
    let grown = waves.map(|k| {
        let z = Complex64::new(0.0, PI * k * cfl);
        let factor = match scheme {
            TimeScheme::Rk2 => (1.0 + z + 0.5 * z * z).norm(),
            // 3/2 w₁ = 2 w₀ − 1/2 w₋₁ + z (5/2 w₀ − 2 w₋₁ + 1/2 w₋₂), over the last hundred of three hundred steps
            TimeScheme::Sbdf2 => {
                let by = [(2.0 + 2.5 * z) / 1.5, (-0.5 - 2.0 * z) / 1.5, 0.5 * z / 1.5];
                let mut wave = [Complex64::new(1.0, 0.0), Complex64::new(0.3, 0.2), Complex64::new(-0.4, 0.1)];
                let size = |wave: &[Complex64; 3]| wave.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
                let mut sizes = [0.0; 2];
                for step in 0..=300 {
                    (sizes, wave) = match step {
                        200 => ([size(&wave), sizes[1]], wave),
                        300 => ([sizes[0], size(&wave)], wave),
                        _ => (sizes, wave),
                    };
                    wave = [by[0] * wave[0] + by[1] * wave[1] + by[2] * wave[2], wave[0], wave[1]];
                }
                (sizes[1] / sizes[0]).powf(0.01)
            }
        };
        factor * (-36.0 * k.powi(36)).exp()
    });
    grown.fold(0.0, f64::max)
}

#[test]
fn the_largest_cfl_numbers_of_both_schemes_have_the_same_growth() {
    for scheme in [TimeScheme::Sbdf2, TimeScheme::Rk2] {
        let growth = growth(scheme, scheme.largest_cfl());
        assert!((1.5..1.6).contains(&growth), "{scheme:?}: {growth} in a step");
    }
}

/// Through two times alone, the extrapolation lets the shortest of them grow by a seventh in each step of 0.25.
#[test]
fn no_wave_in_a_stream_without_viscosity_and_bodies_grows_at_the_largest_cfl_numbers() {
    for cfl in [0.25, TimeScheme::Sbdf2.largest_cfl()] {
        waves_in_a_stream_decay(cfl);
    }
}

fn waves_in_a_stream_decay(cfl: f64) {
    let (cells, steps) = (32, 400);
    let text = format!(
        r#""kinematic_viscosity": 1e-12, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [{cells}, 8] }}"#
    );
    let mut fluid = fluid_of(&scene(&text, ""));
    let waves = |x: f64| (1..cells / 2).map(|k| 1e-6 * (f64::from(k) * (x + f64::from(k * k))).sin()).sum::<f64>();
    fluid.set_velocity(|[x, _]| [1.0, waves(x)]);
    let size = |fluid: &Fluid| fluid.velocity(1).iter().map(|v| v * v).sum::<f64>().sqrt();
    let first = size(&fluid);
    run(&mut fluid, steps, cfl * TAU / f64::from(cells));
    let last = size(&fluid);
    assert!(last < first, "CFL number {cfl}: waves of {first:.3e} m/s became {last:.3e} m/s in {steps} steps");
}

#[test]
fn a_scene_without_bodies_has_no_force_and_no_beam() {
    let text = r#""kinematic_viscosity": 1e-3, "box": { "x": [0, 1], "y": [0, 1], "cells": [8, 8] },
        "initial_velocity": [0.3, -0.2]"#;
    let mut fluid = fluid_of(&scene(text, ""));
    run(&mut fluid, 3, 0.01);
    assert_eq!(fluid.force(), [0.0; 2]);
    assert!(fluid.loads().is_empty() && fluid.stations().is_empty() && fluid.pressure_jump().is_empty());
    for (axis, expected) in [0.3, -0.2].into_iter().enumerate() {
        let worst = fluid.velocity(axis).iter().map(|u| (u - expected).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-15, "a uniform flow changed by {worst} m/s");
    }
}

#[test]
fn the_velocity_is_divergence_free_around_bodies() {
    let mut fluid = fluid_of(&scene(CYLINDER_IN_CHANNEL, BEAM));
    run(&mut fluid, 60, 2e-3);
    let grid = *fluid.grid();
    let [u_hat, v_hat] = [0, 1].map(|axis| spectrum(&fluid.velocity(axis), [grid.cells[0], grid.cells[1]]));
    let (mut divergence, mut gradient) = (0.0_f64, 0.0_f64);
    for j in 0..=grid.cells[1] / 2 {
        for i in 0..grid.cells[0] {
            let signed = if 2 * i > grid.cells[0] { i as f64 - grid.cells[0] as f64 } else { i as f64 };
            let (kx, ky) = (TAU / grid.size[0] * signed, TAU / grid.size[1] * j as f64);
            let [u, v] = [&u_hat, &v_hat].map(|modes| modes[i * grid.cells[1] + j]);
            divergence = divergence.max((u * kx + v * ky).norm());
            gradient = gradient.max((u * ky).norm());
        }
    }
    assert!(divergence < 1e-13 * gradient, "divergence {divergence} beside gradients of {gradient}");
}

#[test]
fn the_inflow_zone_sets_the_flow_rate() {
    let mut fluid = fluid_of(&scene(CYLINDER_IN_CHANNEL, ""));
    run(&mut fluid, 200, 2e-3);
    let (rate, nominal) = (fluid.flow_rate(), 0.41);
    assert!((rate / nominal - 1.0).abs() < 5e-3, "{rate} m²/s against {nominal}");
}

/// The pressure gradient of plane Poiseuille flow, from a channel with its own drive: dp/dx = −12 rho nu U / H².
#[test]
fn poiseuille_flow_has_its_pressure_drop() {
    let text = r#""kinematic_viscosity": 0.02, "box": { "x": [-0.4, 1.6], "y": [-0.1, 0.5], "cells": [64, 96] },
        "channel": { "y": [0.0, 0.41] },
        "inflow": { "x": [-0.4, 0.0], "profile": "parabolic", "mean_velocity": { "constant": 1.0 }, "c_eta": 1e-3 }"#;
    let mut fluid = fluid_of(&scene(text, ""));
    run(&mut fluid, 1500, 1e-3);
    let (grid, pressure) = (*fluid.grid(), fluid.pressure());
    let at = |x: f64| -> f64 { grid.interpolation([x, 0.205]).iter().map(|&(c, w)| w * pressure[c]).sum() };
    let (drop, exact) = ((at(1.0) - at(0.5)) / 0.5, -12.0 * 1000.0 * 0.02 / 0.41_f64.powi(2));
    assert!((drop / exact - 1.0).abs() < 0.01, "dp/dx = {drop} Pa/m against {exact}");
}

#[test]
fn an_oscillating_cylinder_feels_its_added_mass() {
    for (half_box, cells) in [(1.0, 256), (0.7, 180)] {
        let [found, expected] = added_mass(half_box, cells);
        assert!(
            (found / expected - 1.0).abs() < 0.01,
            "box of {} m: added mass {found} against {expected} displaced masses",
            2.0 * half_box
        );
    }
}

#[test]
fn a_restored_state_continues_bit_by_bit() {
    for scheme in [TimeScheme::Sbdf2, TimeScheme::Rk2] {
        restored_state_continues(scheme);
    }
}

fn restored_state_continues(scheme: TimeScheme) {
    let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
    scene.fluid.as_mut().expect("it has one").time_stepping.scheme = scheme;
    let mut fluid = fluid_of(&scene);
    let shake = |fluid: &mut Fluid, step: usize| {
        let phase = step as f64;
        let stations = &mut fluid.stations_mut()[0];
        for k in 1..stations.len() {
            stations.velocity[1][k] = 0.01 * k as f64 * phase.sin();
            stations.position[1][k] += 2e-3 * stations.velocity[1][k];
        }
    };
    for step in 0..10 {
        shake(&mut fluid, step);
        run(&mut fluid, 1, 2e-3);
    }
    let saved = fluid.state();
    let mut other = fluid_of(&scene);
    other.restore(&saved).unwrap_or_else(|e| panic!("{e}"));
    for fluid in [&mut fluid, &mut other] {
        for step in 10..20 {
            shake(fluid, step);
            run(fluid, 1, if step < 15 { 2e-3 } else { 1e-3 });
        }
    }
    assert!(fluid.state() == other.state(), "{scheme:?}: the states differ after ten steps");
    assert_eq!(fluid.pressure_jump(), other.pressure_jump());
    assert_eq!(fluid.pressure(), other.pressure());
}

/// The load that is announced is the one that the fluid then exerts, less the impedance times the change of velocity.
#[test]
fn announced_loads_are_exerted() {
    let masks = [
        Mask::Sharp { c_eta: 1e-4, displacement_corrected: true },
        Mask::Cosine { c_eta: 1e-4, half_width: 1.0, displacement_corrected: true },
        Mask::LogLinear {
            c_eta: 1e-5,
            decay_length_cells: 0.25,
            core_depth: None,
            wall_correction: WallCorrection::Curvature,
        },
    ];
    for mask in masks {
        let mut scene = scene(CYLINDER_IN_CHANNEL, FREE_BEAM);
        let parts = (scene.fluid.as_mut(), scene.beam.as_mut());
        let (fluid, beam) = (parts.0.expect("it has one"), parts.1.expect("it has one"));
        (fluid.mask, beam.thickness) = (mask, 0.08.into());
        let mut fluid = fluid_of(&scene);
        run(&mut fluid, 50, 2e-3);
        let sum = |values: &[f64]| values.iter().sum::<f64>();
        let impedance = sum(&fluid.loads()[0].impedance);
        let mut still = fluid_of(&scene);
        still.restore(&fluid.state()).unwrap_or_else(|e| panic!("{e}"));
        run(&mut still, 1, 2e-3);
        let changes = [3e-3, -2e-3];
        let stations = &mut fluid.stations_mut()[0];
        (0..2).for_each(|axis| stations.velocity[axis].fill(changes[axis]));
        run(&mut fluid, 1, 2e-3);
        let displaced = 1000.0 * 0.08 * 0.35;
        for (axis, change) in changes.into_iter().enumerate() {
            // The unsteady term of the reported force is the displaced mass times the change of velocity.
            let exerted = fluid.force()[axis] - still.force()[axis] - displaced * change / 2e-3;
            let announced = -impedance * change;
            // A wall target follows the body along and across the surface by different factors, of which the impedance
            // has that for motion across the beam.
            let limit = if axis == 0 && matches!(mask, Mask::LogLinear { .. }) { 0.1 } else { 1e-9 };
            assert!(
                (exerted / announced - 1.0).abs() < limit,
                "{mask:?}, axis {axis}: {exerted} N/m against {announced}"
            );
        }
    }
}

/// Where the stations go on with their velocities, what was announced to them is what is exerted: their sum is the drag
/// on the beam, and their power that of the drag on the cells, rotation of the section included.
#[test]
fn announced_station_loads_have_the_force_and_the_power_of_the_drag() {
    for mask in [
        Mask::Cosine { c_eta: 1e-4, half_width: 1.0, displacement_corrected: true },
        Mask::LogLinear {
            c_eta: 1e-5,
            decay_length_cells: 0.25,
            core_depth: None,
            wall_correction: WallCorrection::Curvature,
        },
    ] {
        let mut scene = scene(CYLINDER_IN_CHANNEL, FREE_BEAM);
        let parts = (scene.fluid.as_mut(), scene.beam.as_mut());
        let (part, beam) = (parts.0.expect("it has one"), parts.1.expect("it has one"));
        (part.mask, beam.thickness) = (mask, 0.08.into());
        let mut fluid = fluid_of(&scene);
        let stations = &mut fluid.stations_mut()[0];
        for k in 0..stations.len() {
            let s = k as f64 / stations.len() as f64;
            (stations.velocity[0][k], stations.velocity[1][k]) = (0.1 - 0.05 * s, 0.3 * s * s);
        }
        let h = 2e-3;
        let go_on = |fluid: &mut Fluid| {
            let Stations { position, velocity } = &mut fluid.stations_mut()[0];
            let way = velocity.iter().flatten().map(|v| h * v);
            position.iter_mut().flatten().zip(way).for_each(|(p, way)| *p += way);
            run(fluid, 1, h);
        };
        (0..20).for_each(|_| go_on(&mut fluid));
        let velocity = fluid.stations()[0].velocity.clone();
        let Loads { force, .. } = fluid.loads()[0].clone();
        let work = fluid.exchange()[0].work;
        go_on(&mut fluid);
        let exchange = fluid.exchange()[0];
        let sums = force.each_ref().map(|component| component.iter().sum::<f64>());
        let product = |axis: usize| force[axis].iter().zip(&velocity[axis]).map(|(f, v)| f * v).sum::<f64>();
        let power = product(0) + product(1);
        for axis in 0..2 {
            let far = (exchange.force[axis] - sums[axis]).abs() / (sums[0].abs() + sums[1].abs());
            assert!(far < 1e-9, "{mask:?}: {:?} N/m, announced {sums:?}", exchange.force);
        }
        let far = (exchange.power / power - 1.0).abs();
        assert!(far < 1e-9, "{mask:?}: {} W/m on the cells, {power} on the stations", exchange.power);
        let done = exchange.work - work;
        assert!((done - h * power).abs() < 1e-9 * power.abs(), "{mask:?}: work {done} J/m");
    }
}

#[test]
fn a_step_allocates_nothing() {
    for scheme in [TimeScheme::Sbdf2, TimeScheme::Rk2] {
        step_allocates_nothing(scheme);
    }
}

fn step_allocates_nothing(scheme: TimeScheme) {
    let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
    scene.fluid.as_mut().expect("it has one").time_stepping.scheme = scheme;
    let mut fluid = fluid_of(&scene);
    let swing = |fluid: &mut Fluid, step: usize| {
        let stations = &mut fluid.stations_mut()[0];
        for k in 1..stations.len() {
            stations.position[1][k] = 0.2 + 0.002 * k as f64 * (0.3 * step as f64).sin();
        }
        run(fluid, 1, 2e-3);
    };
    // One swing lets every list grow to what it needs.
    (0..21).for_each(|step| swing(&mut fluid, step));
    let counted = allocation_counter::measure(|| (21..42).for_each(|step| swing(&mut fluid, step)));
    assert_eq!(counted.count_total, 0, "{scheme:?}: {counted:?}");
}

#[test]
fn a_fluid_takes_less_than_25_fields() {
    let fields = arrays();
    assert!(fields < 25.0, "{fields} arrays of the grid's size");
}

#[test]
fn threads_change_no_bit() {
    let [one, two, many] = [1, 2, 5].map(|threads| {
        let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
        let fluid = scene.fluid.as_mut().expect("it has one");
        // Large enough for five threads; blocks of columns that overlap, rows that do not come out even.
        (fluid.r#box.cells, fluid.threads) = (vec![999, 201], threads);
        let mut fluid = fluid_of(&scene);
        run(&mut fluid, 8, 2e-4);
        fluid
    });
    assert!(one.state() == two.state(), "two threads give other bits than one");
    assert!(one.state() == many.state(), "five threads give other bits than one");
}

#[test]
fn bad_steps_and_stations_are_refused_and_change_nothing() {
    let mut fluid = fluid_of(&scene(CYLINDER_IN_CHANNEL, BEAM));
    run(&mut fluid, 2, 2e-3);
    let before = fluid.state();
    for h in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let error = fluid.advance(4e-3, h).expect_err("such a step is no step").to_string();
        assert!(error.contains("above 0"), "{error}");
    }
    fluid.stations_mut()[0].position[1][3] = f64::NAN;
    let error = fluid.advance(4e-3, 1e-3).expect_err("NaN is nowhere").to_string();
    assert!(error.contains("station 4"), "{error}");
    assert!(fluid.state() == before, "a refused step changed the state");
}

#[test]
fn divergence_is_an_error_with_the_time() {
    let text =
        r#""kinematic_viscosity": 1e-6, "box": { "x": [0, 1], "y": [0, 1], "cells": [16, 16] }, "filter": "none""#;
    let mut fluid = unlimited_fluid_of(&scene(text, ""));
    fluid.set_velocity(|[x, y]| [10.0 * (TAU * y).sin() + (3.0 * TAU * x).cos(), 7.0 * (2.0 * TAU * x).cos()]);
    let error = (0..10_000).find_map(|step| fluid.advance(0.5 * step as f64, 0.5).err());
    let error = error.expect("CFL numbers of a hundred cannot be stable").to_string();
    assert!(error.contains("diverged at t ="), "{error}");
}

/// `u · (omega × u)` is 0 at every point, so aliasing does not touch the energy; the enstrophy needs the products
/// unaliased. The smooth filter damps the highest waves and with them both, but leaves a resolved flow alone.
#[test]
fn advection_conserves_energy_and_enstrophy() {
    let [energy, enstrophy] = made_by_advection(noise(Filter::TwoThirds));
    assert!(energy.abs() < 1e-13 && enstrophy.abs() < 1e-13, "two_thirds: {energy}, {enstrophy}");
    let [energy, enstrophy] = made_by_advection(noise(Filter::None));
    assert!(energy.abs() < 1e-13 && enstrophy.abs() > 1e-4, "none: {energy}, {enstrophy}");
    let [energy, enstrophy] = made_by_advection(noise(Filter::Smooth));
    assert!(energy < -1e-2 && enstrophy < -1e-2, "smooth: {energy}, {enstrophy}");
    let [energy, enstrophy] = made_by_advection(resolved_noise());
    // The filter takes 36 (2/3)³⁶ of the highest of these waves.
    let taken = 36.0 * (2.0_f64 / 3.0).powi(36);
    assert!(energy.abs() < 2.0 * taken && enstrophy.abs() < 2.0 * taken, "smooth, resolved: {energy}, {enstrophy}");
}

#[test]
fn the_two_thirds_rule_leaves_products_unaliased() {
    // 7 + 6 looks like 11, 9 + 8 like 7 on 24 points; the ellipse of two thirds ends below 8.
    let (kept, cut) = ([[7, 1], [6, 2]], [[9, 1], [8, 3]]);
    let found = [Filter::TwoThirds, Filter::Smooth, Filter::None].map(|filter| aliased(filter, kept));
    assert!(found[0] < 1e-11 && found[1] < 0.02 * found[2] && found[2] > 0.1, "{found:?}");
    let found = [Filter::Smooth, Filter::None].map(|filter| aliased(filter, cut));
    assert!(found[1] > 0.1 && found[0] > 0.9 * found[1], "{found:?}");
}

/// With an e-fold of a quarter of a cell or more the wall keeps its place; below, the grid no longer resolves the
/// profile.
#[test]
fn the_wall_is_where_it_should_be_at_any_offset_of_the_grid() {
    for (decay_length_cells, limit) in [(0.2, 0.06), (0.25, 0.03), (0.3, 0.02)] {
        let [least, most] = walls(decay_length_cells);
        assert!(least > -limit && most < limit, "e-fold {decay_length_cells}: walls {least} to {most} cells off");
    }
}

#[test]
fn the_flux_through_a_channel_converges_with_second_order() {
    let [coarse, fine] = [64, 128].map(flux_error);
    assert!((coarse / fine).log2() > 1.9 && fine < 1e-3, "{coarse} and {fine}");
}
