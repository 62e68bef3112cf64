//! Accuracy: orders of convergence, bending models, energy.

use std::f64::consts::{FRAC_PI_4, PI};
use std::path::Path;
use std::time::Instant;

use nervure_rod::{BaseMotion, Bending, Calibration, Parameters, Rod, Scheme, Section};
use scene::{Material, Scene};

use crate::common::{elastica, total_energy, unit_rod};
use crate::from_scene;
use crate::rods::{SCHEMES, build, csm3, settled, thesis_beam, tip_angle};
use crate::{Table, row};

const CALIBRATIONS: [(&str, Calibration); 3] = [
    ("second order", Calibration::SecondOrder),
    ("thesis k_e=1e3", Calibration::Thesis { k_e: 1e3 }),
    ("thesis k_e=1e6", Calibration::Thesis { k_e: 1e6 }),
];

/// Error of the tip against the exact elastica of the same EA, relative to the deflection; with the thesis' calibration and
/// for an EA of 1e7 N against the inextensible one.
pub fn order_in_n() -> Table {
    let mut table = vec!["calibration,plane,gravity,tip_angle,n,error".to_string()];
    let inextensible = ("second order, inextensible", Calibration::SecondOrder);
    for (name, calibration) in [CALIBRATIONS[0], inextensible, CALIBRATIONS[1], CALIBRATIONS[2]] {
        for (plane, angle) in [("xz", 0.0_f64), ("diagonal", FRAC_PI_4)] {
            for (g, n) in [0.7, 2.0, 8.0].into_iter().flat_map(|g| (3..10).map(move |k| (g, 1 << k))) {
                let mut beam = Parameters { calibration, gravity: tilted(g, angle), ..thesis_beam(n) };
                let Section { line_density, bending_stiffness, ref mut axial_stiffness, .. } = beam.section;
                // A constant k_e has no EA of its own: its limit of many segments does not stretch.
                let axial = if name == "second order" { *axial_stiffness } else { f64::INFINITY };
                if name == inextensible.0 {
                    *axial_stiffness = 1e7;
                }
                let exact = elastica(1.0, g * line_density, bending_stiffness, axial, 1)[1];
                let rod = settled(build(beam));
                let [x, y, z] = rod.tip_displacement();
                let [y, z] = [y - exact[1] * angle.sin(), z - exact[1] * angle.cos()];
                let error = (x + 1.0 - exact[0]).hypot(y).hypot(z) / exact[1].abs();
                table.push(row(&[&name, &plane, &g, &format!("{:.1}", tip_angle(&rod)), &n, &error]));
            }
        }
    }
    table
}

/// Gravity at `angle` from the plane of x and z.
fn tilted(gravity: f64, angle: f64) -> [f64; 3] {
    [0.0, -gravity * angle.sin(), -gravity * angle.cos()]
}

/// A tip force 5 sin²(πt/2) N on a soft rod of four segments (mu = EI = L = 1, EA = 100) until t = 1, and the beam of CSM3
/// in 16 segments bending freely from rest until t = 1 s: error of the tip and run time for each scheme and step.
pub fn order_in_dt() -> Table {
    let mut table = vec!["case,scheme,dt,error,seconds,iterations".to_string()];
    let pushed = unit_rod(4, 100.0, Scheme::default());
    let run = |parameters: &Parameters<2>, scheme: Scheme, steps: usize, force: f64| {
        let mut rod = build(Parameters { scheme, ..parameters.clone() });
        let last = 2 * parameters.segments + 1;
        rod.loads.force = vec![0.0; last + 1];
        let dt = 1.0 / steps as f64;
        let start = Instant::now();
        let mut iterations = 0;
        for step in 1..=steps {
            rod.loads.force[last] = force * (0.5 * PI * step as f64 * dt).sin().powi(2);
            rod.step(dt).ok()?;
            iterations += rod.statistics().iterations;
        }
        Some((rod.tip_displacement(), start.elapsed().as_secs_f64(), iterations))
    };
    for (case, parameters, force) in
        [("soft rod, pushed", pushed, 5.0), ("CSM3, free", csm3(16, Scheme::default()), 0.0)]
    {
        let (exact, ..) = run(&parameters, Scheme::Trapezoid, 409_600, force).expect("small steps");
        for (name, scheme) in SCHEMES {
            for steps in (0..9).map(|k| 50 << k) {
                // The fastest of three: others use the machine as well.
                let runs = (0..3).filter_map(|_| run(&parameters, scheme, steps, force));
                let Some((tip, seconds, iterations)) = runs.min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
                let error = (tip[0] - exact[0]).hypot(tip[1] - exact[1]) / exact[0].hypot(exact[1]);
                table.push(row(&[&case, &name, &(1.0 / steps as f64), &error, &seconds, &iterations]));
            }
        }
    }
    table
}

/// Tip deflection in the plane and in the diagonal plane by both bending models, n = 128.
pub fn bending_models() -> Table {
    let mut table = vec!["gravity,tip_angle,invariant_diagonal,projected_plane,projected_diagonal".to_string()];
    for gravity in [0.7, 1.5, 3.0, 6.0] {
        let bent = |bending, angle| {
            let rod = settled(build(Parameters { gravity: tilted(gravity, angle), bending, ..thesis_beam(128) }));
            let [_, y, z] = rod.tip_displacement();
            (y.hypot(z), tip_angle(&rod))
        };
        let (exact, angle) = bent(Bending::Invariant, 0.0);
        let off = |bending, angle| format!("{:.2e}", bent(bending, angle).0 / exact - 1.0);
        let [invariant, projected] = [Bending::Invariant, Bending::Projected].map(|bending| off(bending, FRAC_PI_4));
        let plane = off(Bending::Projected, 0.0);
        table.push(row(&[&gravity, &format!("{angle:.1}"), &invariant, &plane, &projected]));
    }
    table
}

/// CSM1 at rest and CSM3 over ten periods of 0.91 s, (max ± min)/2 of each averaged, as the scenes are shipped and without
/// shear and set-back: tip, m, and frequency, Hz, from the first to the last crossing of the mean.
pub fn csm() -> Table {
    let mut table = vec!["scene,rod,quantity,value".to_string()];
    for (rod_is, stiff) in [("as shipped", false), ("without shear and set-back", true)] {
        let built = |name: &str| {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../scenes").join(name);
            let mut scene = Scene::from_file(&path).expect("a shipped scene");
            let rod = scene.rod.as_mut().expect("a scene with a rod");
            if stiff && let Material::PlaneStrain { shear_factor, .. } = &mut rod.material {
                (*shear_factor, rod.clamp_compliance_length) = (None, 0.0);
            }
            let (beam, rod) = (scene.beam.as_ref().expect("a beam"), scene.rod.as_ref().expect("a rod"));
            let mut own = Rod::<2>::new(from_scene::parameters(&scene, beam, rod)).expect("a shipped scene");
            own.loads = from_scene::loads(&scene, 2, beam.segments + 1);
            own
        };
        let at_rest = settled(built("csm1.json")).tip_displacement();
        let (dt, periods, steps) = (1e-3, 10, 910);
        let mut rod = built("csm3.json");
        let mut next = || rod.step(dt).map(|()| rod.tip_displacement()).expect("an easy step");
        let tips: Vec<[f64; 2]> = (0..periods * steps).map(|_| next()).collect();
        for (name, value) in ["tip_ux.mean", "tip_uy.mean"].iter().zip(at_rest) {
            table.push(row(&[&"csm1", &rod_is, name, &value]));
        }
        for (d, name) in ["tip_ux", "tip_uy"].into_iter().enumerate() {
            let mut push =
                |what: &str, value: f64| table.push(row(&[&"csm3", &rod_is, &format!("{name}.{what}"), &value]));
            let values: Vec<f64> = tips.iter().map(|tip| tip[d]).collect();
            let highest = |part: &[f64]| part.iter().copied().fold(f64::MIN, f64::max);
            let lowest = |part: &[f64]| part.iter().copied().fold(f64::MAX, f64::min);
            let half = |part: &[f64], sign: f64| 0.5 * (highest(part) + sign * lowest(part));
            let average = |sign| values.chunks(steps).map(|part| half(part, sign)).sum::<f64>() / periods as f64;
            push("mean", average(1.0));
            push("amplitude", average(-1.0));
            push("highest", highest(&values));
            let mean = half(&values, 1.0);
            let pairs = values.windows(2).enumerate().filter(|(_, pair)| pair[0] < mean && pair[1] >= mean);
            let crossings = pairs.map(|(k, pair)| dt * (k as f64 + (mean - pair[0]) / (pair[1] - pair[0])));
            let crossings: Vec<f64> = crossings.collect();
            push("frequency_hz", (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0]));
        }
    }
    table
}

/// Total energy in 60 s of CSM3 from rest, relative to the largest energy in gravity, every 0.2 s, with the highest until
/// then and the sub-steps that were halved; the trapezoid also unwatched.
pub fn csm3_energy() -> Table {
    let mut table = vec!["scheme,n,dt,time,energy,highest,halvings".to_string()];
    let unwatched = [("trapezoid, unwatched", Scheme::Trapezoid)];
    for (name, scheme) in unwatched.into_iter().chain(SCHEMES) {
        for (n, dt) in [(32, 0.02), (32, 0.01), (128, 0.01), (128, 0.005)] {
            let mut rod = build(csm3(n, scheme));
            if name == unwatched[0].0 {
                // Its root is driven, but to where it is.
                let &Parameters { attachment: position, direction, .. } = rod.parameters();
                rod.base_motion =
                    Some(BaseMotion { position, velocity: [0.0; 2], direction, direction_rate: [0.0; 2] });
            }
            let (mut scale, mut highest, mut halvings, mut energies) = (0.0_f64, 0.0_f64, 0, Vec::new());
            for step in 1..=(60.0 / dt) as usize {
                if rod.step(dt).is_err() {
                    break;
                }
                let energy = total_energy(&rod);
                highest = highest.max(energy);
                halvings += rod.statistics().halvings;
                scale = scale.max(rod.energy().map_or(0.0, |energy| energy.gravity.abs()));
                let gained = energy > scale;
                if gained || step % (0.2 / dt) as usize == 0 {
                    energies.push((format!("{:.1}", step as f64 * dt), [energy, highest], halvings));
                }
                if gained {
                    break; // A gain of as much as there is says enough.
                }
            }
            for (time, both, halvings) in energies {
                let [energy, highest] = both.map(|energy| format!("{:.3e}", energy / scale));
                table.push(row(&[&name, &n, &dt, &time, &energy, &highest, &halvings]));
            }
        }
    }
    table
}
