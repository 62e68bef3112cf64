//! Accuracy: deflection, orders of convergence, bending models, energy.

use std::f64::consts::{FRAC_PI_4, PI};
use std::path::Path;
use std::time::Instant;

use rod::{Parameters, Rod};
use scene::{Bending, Calibration, Material, RodScheme, Scene};

use crate::Table;
use crate::rods::{SCHEMES, csm3, elastica, thesis_beam, total_energy, unwatched};

fn calibrations() -> [(&'static str, Calibration); 3] {
    [
        ("second order", Calibration::SecondOrder),
        ("thesis k_e=1e3", Calibration::Thesis { k_e: 1e3 }),
        ("thesis k_e=1e6", Calibration::Thesis { k_e: 1e6 }),
    ]
}

fn settled<const D: usize>(parameters: Parameters<D>) -> Rod<D> {
    let mut rod = Rod::new(parameters).expect("these parameters are good");
    rod.solve_static().expect("a beam under its weight has an equilibrium");
    rod
}

/// Shape of the beam of section 2.4.1 under its weight against the exact inextensible elastica (thesis figure 2.7).
pub fn deflection() -> Table {
    let mut table = Table::new("model,n,x,y");
    let exact = elastica(1.0, 0.0571 * 0.7, 0.0259, f64::INFINITY, 100);
    exact.iter().for_each(|[x, y]| table.push(&[&"elastica", &0, x, y]));
    for (name, calibration) in calibrations() {
        for n in [8, 32, 128] {
            let rod = settled(Parameters { calibration, ..thesis_beam::<2>(n) });
            rod.positions(0).iter().zip(rod.positions(1)).for_each(|(x, y)| table.push(&[&name, &n, x, y]));
        }
    }
    table
}

/// Error of the tip against the exact elastica of the same EA, relative to the deflection; with the thesis' calibration and
/// for an EA of 1e7 N against the inextensible one.
pub fn order_in_n() -> Table {
    let mut table = Table::new("calibration,plane,gravity,tip_angle,n,error");
    let [second_order, others @ ..] = calibrations().map(|(name, calibration)| (name, calibration, None));
    let inextensible = ("second order, inextensible", Calibration::SecondOrder, Some(1e7));
    for (name, calibration, stiff) in [second_order, inextensible].into_iter().chain(others) {
        for (plane, angle) in [("xz", 0.0_f64), ("diagonal", FRAC_PI_4)] {
            for gravity in [0.7, 2.0, 8.0] {
                for n in (3..10).map(|k| 1 << k) {
                    let weight = [0.0, -gravity * angle.sin(), -gravity * angle.cos()];
                    let mut parameters = Parameters { calibration, gravity: weight, ..thesis_beam::<3>(n) };
                    let section = &mut parameters.section;
                    // A constant k_e has no EA of its own: its limit of many segments does not stretch.
                    let axial = match (calibration, stiff) {
                        (Calibration::SecondOrder, None) => section.axial_stiffness,
                        _ => f64::INFINITY,
                    };
                    section.axial_stiffness = stiff.unwrap_or(section.axial_stiffness);
                    let exact = elastica(1.0, gravity * section.line_density, section.bending_stiffness, axial, 1)[1];
                    let rod = settled(parameters);
                    let [x, y, z] = rod.tip_displacement();
                    let error =
                        (x + 1.0 - exact[0]).hypot(y - exact[1] * angle.sin()).hypot(z - exact[1] * angle.cos())
                            / exact[1].abs();
                    let last = |d: usize| rod.positions(d)[n] - rod.positions(d)[n - 1];
                    let turned = last(1).hypot(last(2)).atan2(last(0)).to_degrees();
                    table.push(&[&name, &plane, &gravity, &format!("{turned:.1}"), &n, &error]);
                }
            }
        }
    }
    table
}

/// A tip force 5 sin²(πt/2) N on a soft rod of four segments (mu = EI = L = 1, EA = 100) until t = 1, and the beam of CSM3
/// in 16 segments bending freely from rest until t = 1 s: error of the tip and run time for each scheme and step.
pub fn order_in_dt() -> Table {
    let mut table = Table::new("case,scheme,dt,error,seconds,iterations");
    let pushed = |scheme: RodScheme| {
        let mut parameters = thesis_beam::<2>(4);
        parameters.section.line_density = 1.0;
        parameters.section.bending_stiffness = 1.0;
        parameters.section.axial_stiffness = 100.0;
        Parameters { gravity: [0.0; 2], scheme, ..parameters }
    };
    let free = |scheme: RodScheme| csm3(16, scheme);
    let run = |parameters: Parameters<2>, steps: usize, force: f64| {
        let nodes = parameters.segments + 1;
        let mut rod = Rod::new(parameters).expect("these parameters are good");
        rod.loads.force = vec![0.0; 2 * nodes];
        let dt = 1.0 / steps as f64;
        let start = Instant::now();
        let mut iterations = 0;
        for step in 1..=steps {
            rod.loads.force[2 * nodes - 1] = force * (0.5 * PI * step as f64 * dt).sin().powi(2);
            rod.step(dt).ok()?;
            iterations += rod.statistics().iterations;
        }
        Some((rod.tip_displacement(), start.elapsed().as_secs_f64(), iterations))
    };
    for (case, parameters, force) in
        [("soft rod, pushed", &pushed as &dyn Fn(RodScheme) -> Parameters<2>, 5.0), ("CSM3, free", &free, 0.0)]
    {
        let (exact, ..) = run(parameters(RodScheme::Trapezoid), 409_600, force).expect("small steps");
        for (name, scheme) in SCHEMES {
            for steps in (0..9).map(|k| 50 << k) {
                // The fastest of three: others use the machine as well.
                let runs = (0..3).filter_map(|_| run(parameters(scheme), steps, force));
                let Some((tip, seconds, iterations)) = runs.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
                let error = (tip[0] - exact[0]).hypot(tip[1] - exact[1]) / exact[0].hypot(exact[1]);
                table.push(&[&case, &name, &(1.0 / steps as f64), &error, &seconds, &iterations]);
            }
        }
    }
    table
}

/// Tip deflection in the plane and in the diagonal plane by both bending models, n = 128.
pub fn bending_models() -> Table {
    let mut table = Table::new("gravity,tip_angle,invariant_diagonal,projected_plane,projected_diagonal");
    for gravity in [0.7, 1.5, 3.0, 6.0] {
        let bent = |bending, angle: f64| {
            let gravity = [0.0, -gravity * angle.sin(), -gravity * angle.cos()];
            let rod = settled(Parameters { gravity, bending, ..thesis_beam::<3>(128) });
            let [_, y, z] = rod.tip_displacement();
            let last = |d: usize| rod.positions(d)[128] - rod.positions(d)[127];
            (y.hypot(z), last(1).hypot(last(2)).atan2(last(0)).to_degrees())
        };
        let (exact, angle) = bent(Bending::Invariant, 0.0);
        let off = |bending, angle| format!("{:.2e}", bent(bending, angle).0 / exact - 1.0);
        table.push(&[
            &gravity,
            &format!("{angle:.1}"),
            &off(Bending::Invariant, FRAC_PI_4),
            &off(Bending::Projected, 0.0),
            &off(Bending::Projected, FRAC_PI_4),
        ]);
    }
    table
}

/// CSM1 at rest and CSM3 over ten periods of 0.91 s, (max ± min)/2 of each averaged, as the scenes are shipped and without
/// shear and set-back: tip, m, and frequency, Hz, from the first to the last crossing of the mean.
pub fn csm() -> Table {
    let mut table = Table::new("scene,rod,quantity,value");
    for (rod_is, stiff) in [("as shipped", false), ("without shear and set-back", true)] {
        let built = |name: &str| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../scenes").join(name);
            let mut scene = Scene::from_file(&path).expect("a shipped scene");
            let rod = scene.rod.as_mut().expect("a scene with a rod");
            if stiff && let Material::PlaneStrain { shear_factor, .. } = &mut rod.material {
                (*shear_factor, rod.clamp_setback) = (None, 0.0);
            }
            Rod::<2>::from_scene(&scene).expect("a shipped scene")
        };
        let mut rod = built("csm1.json");
        rod.solve_static().expect("a beam under its weight has an equilibrium");
        let at_rest = rod.tip_displacement();
        table.push(&[&"csm1", &rod_is, &"tip_ux.mean", &at_rest[0]]);
        table.push(&[&"csm1", &rod_is, &"tip_uy.mean", &at_rest[1]]);

        let (dt, periods, steps) = (1e-3, 10, 910);
        let mut rod = built("csm3.json");
        let tips: Vec<[f64; 2]> = (0..periods * steps)
            .map(|_| {
                rod.step(dt).expect("an easy step");
                rod.tip_displacement()
            })
            .collect();
        for (d, name) in ["tip_ux", "tip_uy"].into_iter().enumerate() {
            let extremes = |of_period: &[[f64; 2]]| {
                let values = || of_period.iter().map(|tip| tip[d]);
                (values().fold(f64::MIN, f64::max), values().fold(f64::MAX, f64::min))
            };
            for (what, sign) in [("mean", 1.0), ("amplitude", -1.0)] {
                let half = |(high, low): (f64, f64)| 0.5 * (high + sign * low);
                let average = tips.chunks(steps).map(|part| half(extremes(part))).sum::<f64>() / periods as f64;
                table.push(&[&"csm3", &rod_is, &format!("{name}.{what}"), &average]);
            }
            let (high, low) = extremes(&tips);
            table.push(&[&"csm3", &rod_is, &format!("{name}.highest"), &high]);
            let mean = 0.5 * (high + low);
            let crossings: Vec<f64> = tips
                .windows(2)
                .enumerate()
                .filter(|(_, pair)| pair[0][d] < mean && pair[1][d] >= mean)
                .map(|(k, pair)| dt * (k as f64 + (mean - pair[0][d]) / (pair[1][d] - pair[0][d])))
                .collect();
            let frequency = (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0]);
            table.push(&[&"csm3", &rod_is, &format!("{name}.frequency_hz"), &frequency]);
        }
    }
    table
}

/// Total energy in 60 s of CSM3 from rest, relative to the largest energy in gravity, every 0.2 s, with the highest until
/// then and the sub-steps that were halved; the trapezoid also unwatched.
pub fn csm3_energy() -> Table {
    let mut table = Table::new("scheme,n,dt,time,energy,highest,halvings");
    let watched = SCHEMES.map(|(name, scheme)| (name, scheme, true));
    for (name, scheme, watch) in [("trapezoid, unwatched", RodScheme::Trapezoid, false)].into_iter().chain(watched) {
        for (n, dt) in [(32, 0.02), (32, 0.01), (128, 0.01), (128, 0.005)] {
            let rod = Rod::new(csm3(n, scheme)).expect("these parameters are good");
            let mut rod = if watch { rod } else { unwatched(rod) };
            let every = (0.2 / dt) as usize;
            let mut scale = 0.0_f64;
            let (mut energies, mut highest, mut halvings) = (Vec::new(), 0.0_f64, 0);
            for step in 1..=(60.0 / dt) as usize {
                if rod.step(dt).is_err() {
                    break;
                }
                highest = highest.max(total_energy(&rod));
                halvings += rod.statistics().halvings;
                scale = scale.max(rod.energy().map_or(0.0, |energy| energy.gravity.abs()));
                // A gain of as much as there is says enough.
                let gained = total_energy(&rod) > scale;
                if gained || step % every == 0 {
                    energies.push((step as f64 * dt, total_energy(&rod), highest, halvings));
                }
                if gained {
                    break;
                }
            }
            for (time, energy, highest, halvings) in energies {
                let relative = |energy: f64| format!("{:.3e}", energy / scale);
                table.push(&[&name, &n, &dt, &format!("{time:.1}"), &relative(energy), &relative(highest), &halvings]);
            }
        }
    }
    table
}
