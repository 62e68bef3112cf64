//! What is measured of exact solutions and invariants: the tests hold it to limits, `bench` writes it down.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use nervure_fluid::Fluid;
use rustfft::num_complex::Complex64;
use scene::{Filter, Mask, TimeScheme, WallCorrection};

use crate::common::{fluid_of, run, scene, spectrum, unlimited_fluid_of};

pub const CYLINDER_IN_CHANNEL: &str = r#"
    "kinematic_viscosity": 1e-3,
    "box": { "x": [-0.4, 1.2], "y": [-0.1, 0.5], "cells": [96, 36] },
    "channel": { "y": [0.0, 0.41] },
    "inflow": { "x": [-0.4, 0.0], "profile": "parabolic", "c_eta": 1e-3,
                "mean_velocity": { "cosine_ramp": { "value": 1.0, "duration": 0.1 } } },
    "cylinders": [{ "center": [0.2, 0.2], "radius": 0.05 }]"#;

pub const BEAM: &str = r#", "beam": { "root": { "on_cylinder": { "cylinder": 0 } }, "length": 0.35, "thickness": 0.05,
    "segments": 12 }"#;

/// Largest error of the Taylor–Green vortex in a mean flow on 16 x 24 points at t = 1 s with `steps` steps, whose
/// lengths over their mean are by turns those of `pattern`. The mean flow makes advection more than a gradient.
pub fn taylor_green_error(scheme: TimeScheme, steps: usize, pattern: &[f64]) -> f64 {
    let (nu, mean) = (0.05, [0.4, -0.3]);
    let vortex = |x: f64, y: f64| [x.sin() * y.cos(), -x.cos() * y.sin()];
    let text =
        format!(r#""kinematic_viscosity": {nu}, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [16, 24] }}"#);
    let mut scene = scene(&text, "");
    scene.fluid.as_mut().expect("it has one").time_stepping.scheme = scheme;
    let mut fluid = fluid_of(&scene);
    fluid.set_velocity(|[x, y]| [0, 1].map(|axis| mean[axis] + vortex(x, y)[axis]));
    pattern.iter().cycle().take(steps).for_each(|length| run(&mut fluid, 1, length / steps as f64));
    let decay = (-2.0 * nu * fluid.time()).exp();
    let grid = *fluid.grid();
    let mut largest = 0.0_f64;
    for axis in 0..2 {
        for (c, value) in fluid.velocity(axis).iter().enumerate() {
            let (x, y) = (
                grid.coordinate(0, c / grid.cells[1]) - mean[0] * fluid.time(),
                grid.coordinate(1, c % grid.cells[1]) - mean[1] * fluid.time(),
            );
            let exact = mean[axis] + decay * vortex(x, y)[axis];
            largest = largest.max((value - exact).abs());
        }
    }
    largest
}

/// Stokes (1851): a cylinder of radius a that oscillates in a still fluid carries the displaced mass times the real
/// part of `1 + 4 K_1(z)/(z K_0(z))`, `z = a √(i omega/nu)`, as added mass.
///
/// In a square lattice with the share phi of the area and no mean pressure gradient each cylinder stands in the field
/// of the others' dipoles: the tangential velocity at its surface falls by 1/(1 + phi), the 1 becomes (1 − phi)/(1 +
/// phi) and the Stokes layer's part, which goes with the square of that velocity, is divided by (1 + phi)².
///
/// Found and expected added mass over the displaced mass, in a box of twice `half_box` metres.
pub fn added_mass(half_box: f64, cells: usize) -> [f64; 2] {
    let (radius, amplitude, frequency, nu) = (0.1_f64, 0.002, 5.0, 4e-3);
    let omega = TAU * frequency;
    // Large z: K_1/K_0 = 1 + 1/(2 z) − 1/(8 z²) + 1/(8 z³) − …
    let per_z = Complex64::from_polar((nu / omega).sqrt() / radius, -0.25 * PI);
    let ratio = 1.0 + per_z * (0.5 + per_z * (-0.125 + per_z * 0.125));
    let layer = (4.0 * per_z * ratio).re;
    let text = format!(
        r#""kinematic_viscosity": {nu},
        "box": {{ "x": [-{half_box}, {half_box}], "y": [-{half_box}, {half_box}], "cells": [{cells}, {cells}] }},
        "cylinders": [{{ "center": [0.0, 0.0], "radius": {radius}, "motion":
            {{ "x": {{ "sine": {{ "amplitude": {amplitude}, "frequency": {frequency} }} }} }} }}]"#
    );
    let mut scene = scene(&text, "");
    scene.fluid.as_mut().expect("it has one").mask = Mask::LogLinear {
        c_eta: 1e-5,
        decay_length_cells: 0.25,
        core_depth: None,
        wall_correction: WallCorrection::Curvature,
    };
    let mut fluid = fluid_of(&scene);
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
    [coefficient, expected]
}

/// Memory that a fluid with a beam takes at most, in arrays of the grid's size, on 320 x 120 points.
pub fn arrays() -> f64 {
    let mut scene = scene(CYLINDER_IN_CHANNEL, BEAM);
    scene.fluid.as_mut().expect("it has one").r#box.cells = vec![320, 120];
    let counted = allocation_counter::measure(|| {
        let mut fluid = fluid_of(&scene);
        run(&mut fluid, 2, 1e-3);
        fluid.pressure_jump();
    });
    counted.bytes_max as f64 / (8.0 * 320.0 * 120.0)
}

/// A flow from noise at every grid point, with waves up to the highest that the filter leaves.
pub fn noise(filter: Filter) -> Fluid {
    let text = r#""kinematic_viscosity": 1e-30, "box": { "x": [0, 6], "y": [0, 4], "cells": [48, 30] }"#;
    let mut scene = scene(text, "");
    scene.fluid.as_mut().expect("it has one").filter = filter;
    let mut fluid = unlimited_fluid_of(&scene);
    let mut seed = 1_u32;
    let seed = std::cell::RefCell::new(&mut seed);
    fluid.set_velocity(|[_, _]| {
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
pub fn made_by_advection(mut fluid: Fluid) -> [f64; 2] {
    let fields = |fluid: &Fluid| [fluid.velocity(0), fluid.velocity(1), fluid.vorticity(0)].map(Cow::into_owned);
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

/// The smooth filter on a flow from noise with waves up to two thirds of the highest.
pub fn resolved_noise() -> Fluid {
    let (resolved, mut fluid) = (noise(Filter::TwoThirds), noise(Filter::Smooth));
    let grid = *resolved.grid();
    fluid.set_velocity(|[x, y]| {
        let index = (x / grid.spacing[0]).round() as usize * grid.cells[1] + (y / grid.spacing[1]).round() as usize;
        [resolved.velocity(0)[index], resolved.velocity(1)[index]]
    });
    fluid
}

/// Two waves whose sum is too short for the grid: what they put into the wave that the sum looks like, over what they
/// put into the wave of their difference.
pub fn aliased(filter: Filter, waves: [[i32; 2]; 2]) -> f64 {
    let n = 24;
    let text =
        format!(r#""kinematic_viscosity": 1e-30, "box": {{ "x": [0, {TAU}], "y": [0, {TAU}], "cells": [{n}, {n}] }}"#);
    let mut scene = scene(&text, "");
    scene.fluid.as_mut().expect("it has one").filter = filter;
    let mut fluid = fluid_of(&scene);
    fluid.set_velocity(|[x, y]| {
        waves.into_iter().fold([0.0, 0.0], |[u, v], [p, q]| {
            let slope = (f64::from(p) * x + f64::from(q) * y).sin();
            [u - f64::from(q) * slope, v + f64::from(p) * slope]
        })
    });
    run(&mut fluid, 1, 1e-3);
    let omega = spectrum(&fluid.vorticity(0), [n, n]);
    let at = |wave: [i32; 2]| {
        let [i, j] = wave.map(|k| k.rem_euclid(n as i32) as usize);
        omega[i * n + j].norm()
    };
    let [a, b] = waves;
    at([a[0] + b[0], a[1] + b[1]]) / at([a[0] - b[0], a[1] - b[1]])
}

/// Plane Poiseuille flow between walls at 0 and 1 moved by `offset` cells, driven by its mean: where the parabola that
/// the middle of the channel shows has its zeros (in cells from the walls), and the flux over that of the parabola
/// between the true walls, less 1.
fn poiseuille(cells: usize, offset: f64, mask: Mask) -> ([f64; 2], f64) {
    let dx = 1.5 / cells as f64;
    let (length, low, high) = (8.0 * dx, offset * dx, 1.0 + offset * dx);
    let text = format!(
        r#""kinematic_viscosity": 1.0, "box": {{ "x": [0, {length}], "y": [-0.25, 1.25], "cells": [8, {cells}] }},
        "channel": {{ "y": [{low}, {high}] }}, "initial_velocity": [1, 0], "mean_flow": {{ "x": {{ "constant": 1 }} }}"#
    );
    let mut scene = scene(&text, "");
    let part = scene.fluid.as_mut().expect("it has one");
    (part.mask, part.time_stepping.max_cfl) = (mask, 1e9);
    let mut fluid = fluid_of(&scene);
    run(&mut fluid, 1500, 1e-3);
    let (grid, velocity) = (*fluid.grid(), fluid.velocity(0));
    let u = &velocity[..cells];
    // Least squares in powers of the distance z from the middle, eight cells and more from the walls.
    let middle = 0.5 * (low + high);
    let (mut moments, mut sums) = ([0.0; 5], [0.0; 3]);
    for (j, u) in u.iter().enumerate() {
        let z = grid.coordinate(1, j) - middle;
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
    let flux = u.iter().sum::<f64>() * grid.spacing[1];
    ([(walls[0] + 0.5) / dx, (walls[1] - 0.5) / dx], flux / (-2.0 * a / 12.0) - 1.0)
}

/// Where the walls of the penalized channel are at several offsets of the grid: least and most, cells, outwards
/// positive.
pub fn walls(decay_length_cells: f64) -> [f64; 2] {
    let mask =
        Mask::LogLinear { c_eta: 1e-7, decay_length_cells, core_depth: None, wall_correction: WallCorrection::None };
    let offsets = [0.0, 0.13, 0.25, 0.37, 0.5, 0.71, 0.9];
    let walls = offsets.map(|offset| poiseuille(96, offset, mask).0).map(|[low, high]| [-low, high]);
    let (least, most) = walls.iter().flatten().fold((f64::MAX, f64::MIN), |(a, b), w| (w.min(a), w.max(b)));
    [least, most]
}

/// Largest relative error of the flux through the penalized channel over several offsets of the grid.
pub fn flux_error(cells: usize) -> f64 {
    let mask = Mask::LogLinear {
        c_eta: 1e-7,
        decay_length_cells: 0.4,
        core_depth: None,
        wall_correction: WallCorrection::None,
    };
    let errors = [0.0, 0.25, 0.5, 0.75].map(|offset| poiseuille(cells, offset, mask).1);
    errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()))
}
