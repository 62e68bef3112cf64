//! Exact solutions and invariants.

mod common;

use std::f64::consts::{PI, TAU};

use common::{run, scene};
use fluid::fft::{Complex64, Fft2};
use fluid::{Fluid, Loads};
use scene::{Filter, Mask, TimeScheme, WallTarget};

const CYLINDER_IN_CHANNEL: &str = r#"
    "kinematic_viscosity": 1e-3,
    "box": { "x": [-0.4, 1.2], "y": [-0.1, 0.5], "cells": [96, 36] },
    "channel": { "y": [0.0, 0.41] },
    "inflow": { "x": [-0.4, 0.0], "profile": "parabolic", "c_eta": 1e-3,
                "mean_velocity": { "cosine_ramp": { "value": 1.0, "duration": 0.1 } } },
    "cylinders": [{ "center": [0.2, 0.2], "radius": 0.05 }]"#;

const FREE_BEAM: &str = r#", "beam": { "root": { "at": { "position": [0.4, 0.2], "direction": [1, 0] } },
    "length": 0.35, "thickness": 0.05, "segments": 12 }"#;

const BEAM: &str = r#", "beam": { "root": { "on_cylinder": { "cylinder": 0 } }, "length": 0.35, "thickness": 0.05,
    "segments": 12 }"#;

/// Largest error of the Taylor–Green vortex in a mean flow on 16 x 24 points at t = 1 s with `steps` steps. The mean
/// flow makes advection more than a gradient.
fn taylor_green_error(scheme: TimeScheme, steps: usize) -> f64 {
    let (nu, mean) = (0.05, [0.4, -0.3]);
    let vortex = |x: f64, y: f64| [x.sin() * y.cos(), -x.cos() * y.sin()];
    let text =
        format!(r#""kinematic_viscosity": {nu}, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [16, 24] }}"#);
    let mut scene = common::scene(&text, "");
    scene.fluid.as_mut().expect("it has one").time_stepping.scheme = scheme;
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    fluid.set_velocity(|x, y| [0, 1].map(|axis| mean[axis] + vortex(x, y)[axis]));
    run(&mut fluid, steps, 1.0 / steps as f64);
    let decay = (-2.0 * nu * fluid.time()).exp();
    let grid = *fluid.grid();
    let mut largest = 0.0_f64;
    for axis in 0..2 {
        for (c, value) in fluid.velocity(axis).iter().enumerate() {
            let (x, y) = (grid.x(c / grid.ny) - mean[0] * fluid.time(), grid.y(c % grid.ny) - mean[1] * fluid.time());
            let exact = mean[axis] + decay * vortex(x, y)[axis];
            largest = largest.max((value - exact).abs());
        }
    }
    largest
}

#[test]
fn the_taylor_green_vortex_decays_with_second_order_in_time() {
    for (scheme, limit) in [(TimeScheme::Sbdf2, 1.5e-5), (TimeScheme::Rk2, 5e-6)] {
        let [coarse, fine] = [80, 160].map(|steps| taylor_green_error(scheme, steps));
        let order = (coarse / fine).log2();
        println!("{scheme:?}: {coarse:.3e} with 80 steps, {fine:.3e} with 160");
        assert!(fine < limit, "{scheme:?}: error {fine} with 160 steps");
        assert!((order - 2.0).abs() < 0.1, "{scheme:?}: order {order}: errors {coarse} and {fine}");
    }
}

#[test]
fn a_scene_without_bodies_has_no_force_and_no_beam() {
    let text = r#""kinematic_viscosity": 1e-3, "box": { "x": [0, 1], "y": [0, 1], "cells": [8, 8] },
        "initial_velocity": [0.3, -0.2]"#;
    let mut fluid = Fluid::new(&scene(text, "")).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 3, 0.01);
    assert_eq!(fluid.force(), [0.0; 2]);
    assert!(fluid.loads().is_none() && fluid.stations().is_none() && fluid.pressure_jump().is_none());
    for (axis, expected) in [0.3, -0.2].into_iter().enumerate() {
        let worst = fluid.velocity(axis).iter().map(|u| (u - expected).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-15, "a uniform flow changed by {worst} m/s");
    }
}

#[test]
fn the_velocity_is_divergence_free_around_bodies() {
    let mut fluid = Fluid::new(&scene(CYLINDER_IN_CHANNEL, BEAM)).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 60, 2e-3);
    let grid = *fluid.grid();
    let fft = Fft2::new(grid.nx, grid.ny, grid.ny / 2 + 1);
    let (mut spectra, mut scratch) = ([fft.spectrum(), fft.spectrum()], fft.scratch());
    for (axis, spectrum) in spectra.iter_mut().enumerate() {
        fft.forward(fluid.velocity(axis), spectrum, &mut scratch);
    }
    let (mut divergence, mut gradient) = (0.0_f64, 0.0_f64);
    for j in 0..=grid.ny / 2 {
        for i in 0..grid.nx {
            let signed = if 2 * i > grid.nx { i as f64 - grid.nx as f64 } else { i as f64 };
            let (kx, ky) = (TAU / grid.length * signed, TAU / grid.height * j as f64);
            let [u, v] = [0, 1].map(|axis| fft.mode(&spectra[axis], i, j));
            divergence = divergence.max((u * kx + v * ky).norm());
            gradient = gradient.max((u * ky).norm());
        }
    }
    assert!(divergence < 1e-13 * gradient, "divergence {divergence} beside gradients of {gradient}");
}

#[test]
fn the_inflow_zone_sets_the_flow_rate() {
    let mut fluid = Fluid::new(&scene(CYLINDER_IN_CHANNEL, "")).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 200, 2e-3);
    let (rate, nominal) = (fluid.flow_rate(), 0.41);
    assert!((rate / nominal - 1.0).abs() < 5e-3, "{rate} m²/s against {nominal}");
}

/// The pressure gradient of plane Poiseuille flow, from a channel with its own drive: dp/dx = −12 rho nu U / H².
#[test]
fn poiseuille_flow_has_its_pressure_drop() {
    let text = r#""kinematic_viscosity": 0.02, "box": { "x": [-0.4, 1.6], "y": [-0.1, 0.5], "cells": [64, 96] },
        "channel": { "y": [0.0, 0.41] },
        "inflow": { "x": [-0.4, 0.0], "profile": "parabolic", "mean_velocity": { "steady": 1.0 }, "c_eta": 1e-3 }"#;
    let mut fluid = Fluid::new(&scene(text, "")).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 1500, 1e-3);
    let (grid, pressure) = (*fluid.grid(), fluid.pressure());
    let at = |x: f64| -> f64 { grid.interpolation([x, 0.205]).iter().map(|&(c, w)| w * pressure[c]).sum() };
    let (drop, exact) = ((at(1.0) - at(0.5)) / 0.5, -12.0 * 1000.0 * 0.02 / 0.41_f64.powi(2));
    assert!((drop / exact - 1.0).abs() < 0.01, "dp/dx = {drop} Pa/m against {exact}");
}

/// Stokes (1851): a cylinder of radius a that oscillates in a still fluid carries the displaced mass times the real part
/// of `1 + 4 K_1(z)/(z K_0(z))`, `z = a √(i omega/nu)`, as added mass.
///
/// In a square lattice with the share phi of the area and no mean pressure gradient each cylinder stands in the field of
/// the others' dipoles: the tangential velocity at its surface falls by 1/(1 + phi), the 1 becomes (1 − phi)/(1 + phi)
/// and the Stokes layer's part, which goes with the square of that velocity, is divided by (1 + phi)².
#[test]
fn an_oscillating_cylinder_feels_its_added_mass() {
    let (radius, amplitude, frequency, nu) = (0.1_f64, 0.002, 5.0, 4e-3);
    let omega = TAU * frequency;
    // Large z: K_1/K_0 = 1 + 1/(2 z) − 1/(8 z²) + 1/(8 z³) − …
    let per_z = Complex64::from_polar((nu / omega).sqrt() / radius, -0.25 * PI);
    let ratio = 1.0 + per_z * (0.5 + per_z * (-0.125 + per_z * 0.125));
    let layer = (4.0 * per_z * ratio).re;
    for (half_box, cells) in [(1.0, 256), (0.7, 180)] {
        let text = format!(
            r#""kinematic_viscosity": {nu},
            "box": {{ "x": [-{half_box}, {half_box}], "y": [-{half_box}, {half_box}], "cells": [{cells}, {cells}] }},
            "cylinders": [{{ "center": [0.0, 0.0], "radius": {radius}, "motion":
                {{ "x": {{ "sine": {{ "amplitude": {amplitude}, "frequency": {frequency} }} }} }} }}]"#
        );
        let mut scene = scene(&text, "");
        scene.fluid.as_mut().expect("it has one").mask =
            Mask::LogLinear { c_eta: 1e-5, e_fold: 0.25, target: WallTarget::Curvature };
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        let (h, per_period) = (1e-3, 200);
        run(&mut fluid, 2 * per_period, h);
        // The part of the force in phase with the displacement: F = −m_a x'' = m_a omega² x.
        let mut in_phase = 0.0;
        for _ in 0..per_period {
            run(&mut fluid, 1, h);
            in_phase += 2.0 / per_period as f64 * fluid.force()[0] * (omega * (fluid.time() - 0.5 * h)).sin();
        }
        let coefficient = in_phase / (amplitude * omega * omega) / (1000.0 * PI * radius * radius);
        let phi = PI * radius * radius / (4.0 * half_box * half_box);
        let expected = (1.0 - phi) / (1.0 + phi) + layer / (1.0 + phi).powi(2);
        println!("box of {:.1} m: added mass {coefficient:.4} against {expected:.4} displaced masses", 2.0 * half_box);
        assert!(
            (coefficient / expected - 1.0).abs() < 0.01,
            "box of {} m: added mass {coefficient} against {expected} displaced masses",
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
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    let shake = |fluid: &mut Fluid, step: usize| {
        let phase = step as f64;
        let stations = fluid.stations_mut().expect("the scene has a beam");
        for k in 1..stations.len() {
            stations.velocity[1][k] = 0.01 * k as f64 * phase.sin();
            stations.position[1][k] += 2e-3 * stations.velocity[1][k];
        }
    };
    for step in 0..10 {
        shake(&mut fluid, step);
        run(&mut fluid, 1, 2e-3);
    }
    let saved = fluid.state().clone();
    let mut other = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
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
        Mask::LogLinear { c_eta: 1e-5, e_fold: 0.25, target: WallTarget::Curvature },
    ];
    for mask in masks {
        let mut scene = scene(CYLINDER_IN_CHANNEL, FREE_BEAM);
        let parts = (scene.fluid.as_mut(), scene.beam.as_mut());
        let (fluid, beam) = (parts.0.expect("it has one"), parts.1.expect("it has one"));
        (fluid.mask, beam.thickness) = (mask, 0.08);
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        run(&mut fluid, 50, 2e-3);
        let sum = |values: &[f64]| values.iter().sum::<f64>();
        let impedance = sum(&fluid.loads().expect("the scene has a beam").impedance);
        let mut still = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        still.restore(&fluid.state().clone()).unwrap_or_else(|e| panic!("{e}"));
        run(&mut still, 1, 2e-3);
        let changes = [3e-3, -2e-3];
        let stations = fluid.stations_mut().expect("the scene has a beam");
        (0..2).for_each(|axis| stations.velocity[axis].fill(changes[axis]));
        run(&mut fluid, 1, 2e-3);
        let displaced = 1000.0 * 0.08 * 0.35;
        for (axis, change) in changes.into_iter().enumerate() {
            // The unsteady term of the reported force is the displaced mass times the change of velocity.
            let exerted = fluid.force()[axis] - still.force()[axis] - displaced * change / 2e-3;
            let announced = -impedance * change;
            // A wall target follows the body along and across the surface by different factors, of which the impedance has
            // that for motion across the beam.
            let limit = if axis == 0 && matches!(mask, Mask::LogLinear { .. }) { 0.1 } else { 1e-9 };
            assert!(
                (exerted / announced - 1.0).abs() < limit,
                "{mask:?}, axis {axis}: {exerted} N/m against {announced}"
            );
        }
    }
}

/// Where the stations keep position and velocity, what was announced to them is what is exerted: their sum is the force on
/// the beam less the unsteady term, and their power that of the drag on the cells, rotation of the section included.
#[test]
fn announced_station_loads_have_the_force_and_the_power_of_the_drag() {
    for mask in [
        Mask::Cosine { c_eta: 1e-4, half_width: 1.0, displacement_corrected: true },
        Mask::LogLinear { c_eta: 1e-5, e_fold: 0.25, target: WallTarget::Curvature },
    ] {
        let mut scene = scene(CYLINDER_IN_CHANNEL, FREE_BEAM);
        let parts = (scene.fluid.as_mut(), scene.beam.as_mut());
        let (part, beam) = (parts.0.expect("it has one"), parts.1.expect("it has one"));
        (part.mask, beam.thickness) = (mask, 0.08);
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        let stations = fluid.stations_mut().expect("the scene has a beam");
        for k in 0..stations.len() {
            let s = k as f64 / stations.len() as f64;
            (stations.velocity[0][k], stations.velocity[1][k]) = (0.1 - 0.05 * s, 0.3 * s * s);
        }
        run(&mut fluid, 20, 2e-3);
        let velocity = fluid.stations().expect("the scene has a beam").velocity.clone();
        let Loads { force, .. } = fluid.loads().expect("the scene has the momentum load").clone();
        let work = fluid.exchange().expect("the scene has a beam").work;
        run(&mut fluid, 1, 2e-3);
        let exchange = fluid.exchange().expect("the scene has a beam");
        let sums = force.each_ref().map(|component| component.iter().sum::<f64>());
        let product = |axis: usize| force[axis].iter().zip(&velocity[axis]).map(|(f, v)| f * v).sum::<f64>();
        let power = product(0) + product(1);
        let total = fluid.force_on_beam().expect("the scene has a beam").force;
        for axis in 0..2 {
            let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * (sums[0].abs() + sums[1].abs());
            assert!(close(exchange.force[axis], sums[axis]), "{mask:?}: {:?} N/m, announced {sums:?}", exchange.force);
            assert!(close(total[axis], sums[axis]), "{mask:?}: force {total:?} N/m against {sums:?}");
        }
        let far = (exchange.power / power - 1.0).abs();
        assert!(far < 1e-9, "{mask:?}: {} W/m on the cells, {power} on the stations", exchange.power);
        let done = exchange.work - work;
        assert!((done - 2e-3 * power).abs() < 1e-9 * power.abs(), "{mask:?}: work {done} J/m");
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
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    let swing = |fluid: &mut Fluid, step: usize| {
        let stations = fluid.stations_mut().expect("the scene has a beam");
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
    let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
    scene.fluid.as_mut().expect("it has one").domain.cells = [320, 120];
    let counted = allocation_counter::measure(|| {
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        run(&mut fluid, 2, 1e-3);
        fluid.pressure_jump();
    });
    let fields = counted.bytes_max as f64 / (8.0 * 320.0 * 120.0);
    println!("{fields:.1} arrays of the grid's size at most");
    assert!(fields < 25.0, "{fields} arrays of the grid's size");
}

#[test]
fn threads_change_no_bit() {
    let [one, two, many] = [1, 2, 5].map(|threads| {
        let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
        let fluid = scene.fluid.as_mut().expect("it has one");
        // Blocks of columns that overlap, rows that do not come out even.
        (fluid.domain.cells, fluid.threads) = ([99, 39], threads);
        let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
        run(&mut fluid, 20, 2e-3);
        fluid
    });
    assert!(one.state() == two.state(), "two threads give other bits than one");
    assert!(one.state() == many.state(), "five threads give other bits than one");
}

#[test]
fn bad_steps_and_stations_are_refused_and_change_nothing() {
    let mut fluid = Fluid::new(&scene(CYLINDER_IN_CHANNEL, BEAM)).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 2, 2e-3);
    let before = fluid.state().clone();
    for h in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let error = fluid.advance(4e-3, h).expect_err("such a step is no step").to_string();
        assert!(error.contains("above 0"), "{error}");
    }
    fluid.stations_mut().expect("the scene has a beam").position[1][3] = f64::NAN;
    let error = fluid.advance(4e-3, 1e-3).expect_err("NaN is nowhere").to_string();
    assert!(error.contains("station 4"), "{error}");
    assert!(fluid.state() == &before, "a refused step changed the state");
}

#[test]
fn divergence_is_an_error_with_the_time() {
    let text =
        r#""kinematic_viscosity": 1e-6, "box": { "x": [0, 1], "y": [0, 1], "cells": [16, 16] }, "filter": "none""#;
    let mut scene = scene(text, "");
    scene.fluid.as_mut().expect("it has one").time_stepping.max_cfl = 1e9;
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    fluid.set_velocity(|x, y| [10.0 * (TAU * y).sin() + (3.0 * TAU * x).cos(), 7.0 * (2.0 * TAU * x).cos()]);
    let error = (0..10_000).find_map(|step| fluid.advance(0.5 * step as f64, 0.5).err());
    let error = error.expect("CFL numbers of a hundred cannot be stable").to_string();
    assert!(error.contains("diverged at t ="), "{error}");
}

/// A flow from noise at every grid point, with waves up to the highest that the filter leaves.
fn noise(filter: Filter) -> Fluid {
    let text = r#""kinematic_viscosity": 1e-30, "box": { "x": [0, 6], "y": [0, 4], "cells": [48, 30] }"#;
    let mut scene = scene(text, "");
    let part = scene.fluid.as_mut().expect("it has one");
    (part.filter, part.time_stepping.max_cfl) = (filter, 1e9);
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    let mut seed = 1_u32;
    let seed = std::cell::RefCell::new(&mut seed);
    fluid.set_velocity(|_, _| {
        [0, 1].map(|_| {
            let mut seed = seed.borrow_mut();
            **seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(**seed) / f64::from(u32::MAX) - 0.5
        })
    });
    fluid
}

/// Energy and enstrophy that a step makes, over what it exchanges between points.
///
/// The first step is backward Euler, `u_1 = F P (u_0 − dt N)` without viscosity and bodies: `⟨u_0, u_1 − u_0⟩` is the
/// energy that advection makes, and the same with omega the enstrophy.
fn made_by_advection(mut fluid: Fluid) -> [f64; 2] {
    let fields = |fluid: &Fluid| [fluid.velocity(0), fluid.velocity(1), fluid.vorticity()].map(<[f64]>::to_vec);
    let before = fields(&fluid);
    run(&mut fluid, 1, 0.1);
    let after = fields(&fluid);
    let sum = |k: usize, term: fn(f64) -> f64| -> f64 {
        before[k].iter().zip(&after[k]).map(|(a, b)| term(a * (b - a))).sum()
    };
    let part = |term: fn(f64) -> f64| [sum(0, term) + sum(1, term), sum(2, term)];
    let (net, exchanged) = (part(|x| x), part(f64::abs));
    [net[0] / exchanged[0], net[1] / exchanged[1]]
}

/// `u · (omega × u)` is 0 at every point, so aliasing does not touch the energy; the enstrophy needs the products
/// unaliased. The smooth filter damps the highest waves and with them both, but leaves a resolved flow alone.
#[test]
fn advection_conserves_energy_and_enstrophy() {
    let [energy, enstrophy] = made_by_advection(noise(Filter::TwoThirds));
    println!("two_thirds: energy {energy:.1e}, enstrophy {enstrophy:.1e} of what is exchanged");
    assert!(energy.abs() < 1e-13 && enstrophy.abs() < 1e-13, "two_thirds: {energy}, {enstrophy}");
    let [energy, enstrophy] = made_by_advection(noise(Filter::None));
    println!("none: energy {energy:.1e}, enstrophy {enstrophy:.1e}");
    assert!(energy.abs() < 1e-13 && enstrophy.abs() > 1e-4, "none: {energy}, {enstrophy}");
    let [energy, enstrophy] = made_by_advection(noise(Filter::Smooth));
    println!("smooth, waves up to the highest: energy {energy:.1e}, enstrophy {enstrophy:.1e}");
    assert!(energy < -1e-2 && enstrophy < -1e-2, "smooth: {energy}, {enstrophy}");
    let (resolved, mut fluid) = (noise(Filter::TwoThirds), noise(Filter::Smooth));
    let grid = *resolved.grid();
    fluid.set_velocity(|x, y| {
        let index = (x / grid.dx).round() as usize * grid.ny + (y / grid.dy).round() as usize;
        [resolved.velocity(0)[index], resolved.velocity(1)[index]]
    });
    let [energy, enstrophy] = made_by_advection(fluid);
    println!("smooth, waves up to two thirds: energy {energy:.1e}, enstrophy {enstrophy:.1e}");
    // The filter takes 36 (2/3)³⁶ of the highest of these waves.
    let taken = 36.0 * (2.0_f64 / 3.0).powi(36);
    assert!(energy.abs() < 2.0 * taken && enstrophy.abs() < 2.0 * taken, "smooth, resolved: {energy}, {enstrophy}");
}

/// Two waves whose sum is too short for the grid: what they put into the wave that the sum looks like, over what they
/// put into the wave of their difference.
fn aliased(filter: Filter, waves: [[i32; 2]; 2]) -> f64 {
    let n = 24;
    let text =
        format!(r#""kinematic_viscosity": 1e-30, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [{n}, {n}] }}"#);
    let mut scene = scene(&text, "");
    scene.fluid.as_mut().expect("it has one").filter = filter;
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    fluid.set_velocity(|x, y| {
        waves.into_iter().fold([0.0, 0.0], |[u, v], [p, q]| {
            let slope = (f64::from(p) * x + f64::from(q) * y).sin();
            [u - f64::from(q) * slope, v + f64::from(p) * slope]
        })
    });
    run(&mut fluid, 1, 1e-3);
    let fft = Fft2::new(n, n, n / 2 + 1);
    let mut spectrum = fft.spectrum();
    fft.forward(fluid.vorticity(), &mut spectrum, &mut fft.scratch());
    let at = |[p, q]: [i32; 2]| {
        let (p, q) = if q < 0 { (-p, -q) } else { (p, q) };
        fft.mode(&spectrum, p.rem_euclid(n as i32) as usize, q as usize).norm()
    };
    let [a, b] = waves;
    at([a[0] + b[0], a[1] + b[1]]) / at([a[0] - b[0], a[1] - b[1]])
}

#[test]
fn the_two_thirds_rule_leaves_products_unaliased() {
    // 7 + 6 looks like 11, 9 + 8 like 7 on 24 points; the ellipse of two thirds ends below 8.
    let (kept, cut) = ([[7, 1], [6, 2]], [[9, 1], [8, 3]]);
    let found = [Filter::TwoThirds, Filter::Smooth, Filter::None].map(|filter| aliased(filter, kept));
    println!("7 + 6 on 24 points: two_thirds {:.1e}, smooth {:.1e}, none {:.1e}", found[0], found[1], found[2]);
    assert!(found[0] < 1e-11 && found[1] < 0.02 * found[2] && found[2] > 0.1, "{found:?}");
    let found = [Filter::Smooth, Filter::None].map(|filter| aliased(filter, cut));
    println!("9 + 8 on 24 points: smooth {:.1e}, none {:.1e}", found[0], found[1]);
    assert!(found[1] > 0.1 && found[0] > 0.9 * found[1], "{found:?}");
}

/// Plane Poiseuille flow between walls at 0 and 1 moved by `offset` cells, driven by its mean: where the parabola that
/// the middle of the channel shows has its zeros (in cells from the walls), and the flux over that of the parabola
/// between the true walls, less 1.
fn poiseuille(cells: usize, offset: f64, mask: Mask) -> ([f64; 2], f64) {
    let dx = 1.5 / cells as f64;
    let (length, low, high) = (8.0 * dx, offset * dx, 1.0 + offset * dx);
    let text = format!(
        r#""kinematic_viscosity": 1.0, "box": {{ "x": [0, {length}], "y": [-0.25, 1.25], "cells": [8, {cells}] }},
        "channel": {{ "y": [{low}, {high}] }}, "initial_velocity": [1, 0], "mean_flow": {{ "x": {{ "steady": 1 }} }}"#
    );
    let mut scene = scene(&text, "");
    let part = scene.fluid.as_mut().expect("it has one");
    (part.mask, part.time_stepping.max_cfl) = (mask, 1e9);
    let mut fluid = Fluid::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluid, 1500, 1e-3);
    let (grid, u) = (*fluid.grid(), &fluid.velocity(0)[..cells]);
    // Least squares in powers of the distance z from the middle, eight cells and more from the walls.
    let middle = 0.5 * (low + high);
    let (mut moments, mut sums) = ([0.0; 5], [0.0; 3]);
    for (j, u) in u.iter().enumerate() {
        let z = grid.y(j) - middle;
        if z.abs() < 0.5 - 8.0 * dx {
            (0..5).for_each(|p| moments[p] += z.powi(p as i32));
            (0..3).for_each(|p| sums[p] += u * z.powi(p as i32));
        }
    }
    let determinant = |m: [[f64; 3]; 3]| {
        let minor = |i: usize, j: usize| m[1][i] * m[2][j] - m[1][j] * m[2][i];
        m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1)
    };
    let matrix = [0, 1, 2].map(|p| [moments[p], moments[p + 1], moments[p + 2]]);
    let coefficients = [0, 1, 2].map(|column| {
        let mut replaced = matrix;
        (0..3).for_each(|row| replaced[row][column] = sums[row]);
        determinant(replaced) / determinant(matrix)
    });
    let [c, b, a] = coefficients;
    let root = (b * b - 4.0 * a * c).sqrt();
    let walls = [(-b + root) / (2.0 * a), (-b - root) / (2.0 * a)];
    let flux = u.iter().sum::<f64>() * grid.dy;
    ([(walls[0] + 0.5) / dx, (walls[1] - 0.5) / dx], flux / (-2.0 * a / 12.0) - 1.0)
}

/// With an e-fold of a quarter of a cell or more the wall keeps its place; below, the grid no longer resolves the profile.
#[test]
fn the_wall_is_where_it_should_be_at_any_offset_of_the_grid() {
    for (e_fold, limit) in [(0.2, 0.06), (0.25, 0.03), (0.3, 0.02)] {
        let mask = Mask::LogLinear { c_eta: 1e-7, e_fold, target: WallTarget::None };
        let offsets = [0.0, 0.13, 0.25, 0.37, 0.5, 0.71, 0.9];
        // Outwards is positive.
        let walls = offsets.map(|offset| poiseuille(96, offset, mask).0).map(|[low, high]| [-low, high]);
        let (least, most) = walls.iter().flatten().fold((f64::MAX, f64::MIN), |(a, b), w| (w.min(a), w.max(b)));
        println!("{mask:?}: walls {least:.4} to {most:.4} cells off");
        assert!(least > -limit && most < limit, "{mask:?}: walls {least} to {most} cells off");
    }
}

#[test]
fn the_flux_through_a_channel_converges_with_second_order() {
    let mask = Mask::LogLinear { c_eta: 1e-7, e_fold: 0.4, target: WallTarget::None };
    let worst = |cells: usize| {
        let errors = [0.0, 0.25, 0.5, 0.75].map(|offset| poiseuille(cells, offset, mask).1);
        errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()))
    };
    let [coarse, fine] = [64, 128].map(worst);
    println!("flux off by {coarse:.3e} with 64 cells, {fine:.3e} with 128");
    assert!((coarse / fine).log2() > 1.9 && fine < 1e-3, "{coarse} and {fine}");
}
