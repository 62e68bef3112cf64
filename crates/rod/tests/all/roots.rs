//! Pinned and free roots and torsion springs, against exact solutions and invariants.

use std::f64::consts::{PI, TAU};

use nervure_rod::{BaseMotion, Bending, Calibration, Parameters, Rod, RootSupport, Scheme, Section, Slide, Taper};

use crate::common::{SCHEMES, total_energy, unit_rod};
use crate::modes::{RitzBeam, frequencies};

fn spring(stiffness: f64) -> RootSupport {
    RootSupport::TorsionSpring { stiffness, damping: 0.0, rest_angle: 0.0 }
}

/// Return b of the frequency b² sqrt(EI/µ)/L², by bisection around `guess`.
fn characteristic(equation: impl Fn(f64) -> f64, guess: f64) -> f64 {
    let (mut low, mut high) = (guess - 0.05, guess + 0.05);
    assert!(equation(low) * equation(high) < 0.0, "no root around {guess}");
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if equation(low) * equation(middle) <= 0.0 { high = middle } else { low = middle }
    }
    low
}

/// κ (1 + cos b cosh b) = b (sin b cosh b − cos b sinh b), κ = k L/EI; without spring tan b = tanh b.
fn hinged(kappa: f64) -> impl Fn(f64) -> f64 {
    move |b: f64| kappa * (1.0 / b.cosh() + b.cos()) - b * (b.sin() - b.cos() * b.tanh())
}

#[test]
fn frequencies_are_those_of_the_characteristic_equations() {
    let free = |b: f64| 1.0 / b.cosh() - b.cos();
    let modes = |equation: &dyn Fn(f64) -> f64, guesses: [f64; 3]| guesses.map(|guess| characteristic(equation, guess));
    for (support, rigid, exact) in [
        (RootSupport::Pinned, 1, modes(&hinged(0.0), [3.93, 7.07, 10.21])),
        (spring(1.0), 0, modes(&hinged(1.0), [1.25, 4.03, 7.13])),
        (spring(50.0), 0, modes(&hinged(50.0), [1.84, 4.60, 7.70])),
        (RootSupport::Free, 2, modes(&free, [4.73, 7.85, 11.0])),
    ] {
        let errors = [32, 64, 128].map(|segments| {
            let mut rod = Rod::new(Parameters { support, ..unit_rod(segments, 1e4, Scheme::TrBdf2) }).unwrap();
            let found = frequencies(&mut rod);
            assert!(found[..rigid].iter().all(|&omega| omega < 1e-3 * found[rigid]), "{support:?}: {:?}", &found[..4]);
            [0, 1, 2].map(|mode| found[rigid + mode] / exact[mode].powi(2) - 1.0)
        });
        println!("{support:?}: {errors:?}");
        for mode in 0..3 {
            let orders = [0, 1].map(|grid| (errors[grid][mode] / errors[grid + 1][mode]).log2());
            assert!(
                orders.iter().all(|order| (order - 2.0).abs() < 0.1),
                "{support:?}, mode {mode}: orders {orders:?}"
            );
            assert!(errors[2][mode].abs() < 1e-3, "{support:?}, mode {mode}: {errors:?}");
        }
    }
}

/// Taper and spring together, against the Ritz method.
#[test]
fn tapered_rod_on_a_spring_has_the_frequencies_of_the_ritz_method() {
    let thickness = |s: f64| 1.0 - 0.8 * s;
    let bending = |s: f64| thickness(s).powi(3);
    for (support, held, spring) in [(RootSupport::Free, 0, 0.0), (RootSupport::Pinned, 1, 0.0), (spring(3.0), 1, 3.0)] {
        let exact = RitzBeam { bending: &bending, mass: &thickness, held, spring }.frequencies();
        let rigid = if spring > 0.0 { 0 } else { 2 - held };
        let errors = [64, 128].map(|segments: usize| {
            let along = |value: &dyn Fn(f64) -> f64| {
                (0..=2 * segments).map(|i| value(i as f64 / (2 * segments) as f64)).collect()
            };
            let taper =
                Taper { line_density: along(&thickness), bending_stiffness: along(&bending), ..Taper::default() };
            let mut rod = Rod::new(Parameters { support, taper, ..unit_rod(segments, 1e4, Scheme::TrBdf2) }).unwrap();
            let found = frequencies(&mut rod);
            [0, 1, 2].map(|mode| found[rigid + mode] / exact[rigid + mode] - 1.0)
        });
        println!("{support:?}: {errors:?}");
        for mode in 0..3 {
            let order = (errors[0][mode] / errors[1][mode]).log2();
            assert!((order - 2.0).abs() < 0.1 && errors[1][mode].abs() < 1.2e-3, "{support:?}, {mode}: {errors:?}");
        }
    }
}

/// Return the period of a rigid rod of length 1 that swings by `amplitude` about a pin: 4 K(sin(a/2)) sqrt(2 L/(3 g)).
///
/// K follows from the arithmetic-geometric mean.
fn pendulum_period(amplitude: f64, gravity: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..6 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    TAU / a * (2.0 / (3.0 * gravity)).sqrt()
}

/// Return the times at which `values`, `dt` apart, pass 0.
fn crossings(values: &[f64], dt: f64) -> Vec<f64> {
    let pairs = values.windows(2).enumerate().filter(|(_, pair)| pair[0] * pair[1] < 0.0);
    pairs.map(|(i, pair)| dt * (i as f64 + pair[0] / (pair[0] - pair[1]))).collect()
}

/// A stiff rod pinned at 45° to gravity: in two dimensions, and in space in two planes, one of them oblique.
#[test]
fn pinned_stiff_rod_is_a_compound_pendulum() {
    fn period<const D: usize>(gravity: [f64; D], across: [f64; D], steps: usize) -> f64 {
        let dt = 1.0 / steps as f64;
        let stiff = Section { line_density: 1.0, bending_stiffness: 1e4, axial_stiffness: 1e7, shear_stiffness: None };
        let parameters = Parameters {
            section: stiff,
            support: RootSupport::Pinned,
            gravity,
            ..unit_rod::<D>(32, 1.0, Scheme::TrBdf2)
        };
        let mut rod = Rod::new(parameters).unwrap();
        let swing: Vec<f64> = (0..4 * steps)
            .map(|_| {
                rod.step(dt).unwrap();
                let tip = rod.tip_displacement();
                tip.iter().zip(&across).map(|(u, a)| u * a).sum::<f64>() + across[0]
            })
            .collect();
        let passed = crossings(&swing, dt);
        2.0 * (passed[2] - passed[0]) / 2.0
    }
    // Gravity of 9.81 at 45° to the rod at rest, and the direction across it.
    let (g, half) = (9.81, std::f64::consts::FRAC_1_SQRT_2);
    let exact = pendulum_period(PI / 4.0, g);
    // n segments have the moment of inertia (1 + 1/(2 n²))/3.
    let discrete = (1.0 + 0.5 / 32.0_f64.powi(2)).sqrt();
    for steps in [500, 1000] {
        let planar = period([g * half, -g * half], [half, half], steps);
        let spatial = period([g * half, -g * half * 0.6, -g * half * 0.8], [half, half * 0.6, half * 0.8], steps);
        println!("{steps}: {planar}, {spatial}, exact {exact}");
        assert!(
            (planar / exact / discrete - 1.0).abs() < 4.0 / (steps as f64).powi(2) + 1e-5,
            "{planar} against {exact}"
        );
        assert!((spatial / planar - 1.0).abs() < 1e-8, "{spatial} against {planar}");
    }
}

/// A stiff rod on a spring with damping, released away from the spring's rest: θ'' + 2 ζ ω θ' + ω² (θ − θ0) = 0.
#[test]
fn stiff_rod_on_a_damped_spring_is_the_exact_oscillator() {
    let (stiffness, rest_angle) = (2.0, 1.2);
    let stiff = Section { line_density: 1.0, bending_stiffness: 1e5, axial_stiffness: 1e7, shear_stiffness: None };
    for shear in [None, Some(1e7)] {
        for damping in [0.0, 0.2, 3.0] {
            let support = RootSupport::TorsionSpring { stiffness, damping, rest_angle };
            for scheme in SCHEMES {
                let section = Section { shear_stiffness: shear, ..stiff };
                let mut rod = Rod::new(Parameters { section, support, ..unit_rod::<2>(64, 1.0, scheme) }).unwrap();
                let inertia = (1.0 + 0.5 / 64.0_f64.powi(2)) / 3.0;
                let (decay, square) = (0.5 * damping / inertia, stiffness / inertia);
                let mut worst: f64 = 0.0;
                let dt = 1e-3;
                for step in 1..=2000 {
                    rod.step(dt).unwrap();
                    let t = dt * f64::from(step);
                    let root = (square - decay * decay).abs().sqrt();
                    let (c, s) = if square > decay * decay {
                        ((root * t).cos(), (root * t).sin() / root)
                    } else {
                        ((root * t).cosh(), (root * t).sinh() / root)
                    };
                    let exact = rest_angle * (1.0 - (-decay * t).exp() * (c + decay * s));
                    let tip = rod.state().positions[64];
                    worst = worst.max((tip[1].atan2(tip[0]) - exact).abs());
                    let [angle, _] = rod.hinge().unwrap();
                    assert!((angle - tip[1].atan2(tip[0])).abs() < 1e-4, "{angle} against {tip}");
                }
                println!("damping {damping}, shear {shear:?}, {scheme:?}: {worst:.2e}");
                // BDF2 begins with backward Euler.
                let most = if scheme == Scheme::Bdf2 { 4e-3 } else { 2e-4 };
                assert!(worst < most, "damping {damping}, shear {shear:?}, {scheme:?}: {worst}");
            }
        }
    }
}

/// The loss of energy is the work of the damping of the spring.
#[test]
fn damping_of_the_spring_takes_the_energy() {
    let support = RootSupport::TorsionSpring { stiffness: 2.0, damping: 0.1, rest_angle: 0.9 };
    let lost = |steps: u32| {
        let mut rod = Rod::new(Parameters { support, ..unit_rod::<2>(16, 1e3, Scheme::Trapezoid) }).unwrap();
        let (before, dt) = (total_energy(&rod), 2.0 / f64::from(steps));
        let mut taken = 0.0;
        for _ in 0..steps {
            let power = rod.damping_power();
            rod.step(dt).unwrap();
            taken += 0.5 * dt * (power + rod.damping_power());
        }
        println!("{steps}: {before} J, {} J lost, {taken} J taken", before - total_energy(&rod));
        ((before - total_energy(&rod)) / taken - 1.0).abs()
    };
    let errors = [1000, 2000].map(lost);
    assert!(errors[1] < 5e-3 && errors[0] / errors[1] > 3.5, "{errors:?}");
}

/// The spring is isotropic in space: the motion in an oblique plane equals the motion in two dimensions.
#[test]
fn spring_in_space_is_that_of_the_plane() {
    let gravity = 9.0;
    let mut planar = Rod::new(Parameters {
        support: spring(1.5),
        gravity: [0.0, -gravity],
        ..unit_rod::<2>(12, 1e3, Scheme::TrBdf2)
    })
    .unwrap();
    let oblique = [0.0, -gravity * 0.6, -gravity * 0.8];
    let mut spatial =
        Rod::new(Parameters { support: spring(1.5), gravity: oblique, ..unit_rod::<3>(12, 1e3, Scheme::TrBdf2) })
            .unwrap();
    for _ in 0..300 {
        planar.step(5e-3).unwrap();
        spatial.step(5e-3).unwrap();
        let ([x, y], found) = (planar.tip_displacement(), spatial.tip_displacement());
        for (found, expected) in found.iter().zip([x, 0.6 * y, 0.8 * y]) {
            assert!((found - expected).abs() < 1e-7, "{found} against {expected}");
        }
        assert!((total_energy(&planar) - total_energy(&spatial)).abs() < 1e-7);
    }
}

/// Return momentum, centre of mass times mass, and angular momentum about the origin.
fn invariants(rod: &Rod<2>) -> ([f64; 2], [f64; 2], f64) {
    let (mut momentum, mut centre, mut angular) = ([0.0; 2], [0.0; 2], 0.0);
    let state = rod.state();
    for ((m, x), v) in rod.masses().iter().zip(&state.positions).zip(&state.velocities) {
        for d in 0..2 {
            momentum[d] += m * v[d];
            centre[d] += m * x[d];
        }
        angular += m * (x[0] * v[1] - x[1] * v[0]);
    }
    (momentum, centre, angular)
}

/// A free rod, bent and spun by a load that ends, conserves its momenta; its centre of mass falls like a point.
#[test]
fn free_rod_keeps_its_momenta_and_falls_as_a_point_does() {
    let drift = |steps: usize, gravity: [f64; 2], shear: Option<f64>| {
        let rod = unit_rod::<2>(16, 1e3, Scheme::TrBdf2);
        let section = Section { shear_stiffness: shear, ..rod.section };
        let mut rod = Rod::new(Parameters { section, support: RootSupport::Free, gravity, ..rod }).unwrap();
        let (dt, nodes) = (1.0 / steps as f64, 17);
        rod.loads.force = vec![0.0; 2 * nodes];
        for k in 0..nodes {
            rod.loads.force[nodes + k] = (0.3 * k as f64).sin();
        }
        for _ in 0..steps / 2 {
            rod.step(dt).unwrap();
        }
        rod.loads.force.fill(0.0);
        // The scheme blends the last load with the unloaded state over one step.
        rod.step(dt).unwrap();
        let (momentum, centre, angular) = invariants(&rod);
        for step in 1..=steps {
            rod.step(dt).unwrap();
            let t = dt * step as f64;
            let (now, place, _) = invariants(&rod);
            for d in 0..2 {
                let expected = momentum[d] + gravity[d] * t;
                assert!((now[d] - expected).abs() < 1e-8, "momentum {} against {expected}", now[d]);
                let expected = centre[d] + momentum[d] * t + 0.5 * gravity[d] * t * t;
                assert!((place[d] - expected).abs() < 1e-8, "centre {} against {expected}", place[d]);
            }
        }
        (invariants(&rod).2 / angular - 1.0).abs()
    };
    drift(200, [0.3, -9.81], None);
    for shear in [None, Some(40.0)] {
        let drifts = [200, 1600].map(|steps| drift(steps, [0.0; 2], shear));
        println!("angular momentum: {drifts:?}");
        assert!(drifts[0] < 1e-4 && drifts[1] < 5e-6, "{drifts:?}");
    }
}

/// A constant force along the rod tows it with the acceleration F/m, and the drive does the work F x.
#[test]
fn towed_rod_has_the_acceleration_of_the_force() {
    let mut rod = Rod::new(Parameters { support: RootSupport::Free, ..unit_rod::<3>(8, 1e5, Scheme::TrBdf2) }).unwrap();
    rod.towing = [-2.0, 0.0, 0.0];
    for _ in 0..1000 {
        rod.step(1e-3).unwrap();
    }
    let mean: f64 = rod.masses().iter().zip(&rod.state().velocities).map(|(m, v)| m * v[0]).sum();
    assert!((mean + 2.0).abs() < 1e-8, "{mean}");
    let drive = rod.state().drive;
    assert_eq!(drive.force[0], -2.0);
    assert!(
        (drive.work - total_energy(&rod)).abs() < 0.01 * drive.work,
        "{} against {}",
        drive.work,
        total_energy(&rod)
    );
}

/// A pinned root follows its prescribed motion, and the reaction moves the masses.
#[test]
fn moving_root_takes_a_pinned_rod_along() {
    for support in [RootSupport::Pinned, spring(0.5)] {
        let mut rod = Rod::new(Parameters { support, ..unit_rod::<2>(16, 1e3, Scheme::TrBdf2) }).unwrap();
        let at = |t: f64| {
            let y = 0.3 * (1.0 - t.cos());
            BaseMotion {
                position: [0.0, y],
                velocity: [0.0, 0.3 * t.sin()],
                direction: [1.0, 0.0],
                direction_rate: [0.0; 2],
            }
        };
        rod.place(at(0.0)).unwrap();
        let (dt, mut impulse) = (2e-3, 0.0);
        for step in 1..=1000 {
            let force = rod.state().drive.force[1];
            rod.base_motion = Some(at(dt * f64::from(step)));
            rod.step(dt).unwrap();
            impulse += 0.5 * dt * (force + rod.state().drive.force[1]);
        }
        let momentum: f64 = rod.masses().iter().zip(&rod.state().velocities).map(|(m, v)| m * v[1]).sum();
        println!(
            "{support:?}: impulse {impulse}, momentum {momentum}, work {}, energy {}",
            rod.state().drive.work,
            total_energy(&rod)
        );
        assert!((rod.positions(1)[0] - 0.3 * (1.0 - 2.0_f64.cos())).abs() < 1e-12);
        assert!((impulse / momentum - 1.0).abs() < 2e-3, "{support:?}: {impulse} against {momentum}");
        let moment = rod.state().drive.moment[2];
        assert_eq!(moment == 0.0, support == RootSupport::Pinned, "moment {moment}");
    }
}

#[test]
fn state_of_a_damped_spring_is_put_back() {
    let support = RootSupport::TorsionSpring { stiffness: 2.0, damping: 0.3, rest_angle: 0.5 };
    let mut rod = Rod::new(Parameters { support, ..unit_rod::<2>(8, 1e3, Scheme::Bdf2) }).unwrap();
    (0..20).for_each(|_| rod.step(1e-2).unwrap());
    let state = rod.state().clone();
    (0..20).for_each(|_| rod.step(1e-2).unwrap());
    let expected = rod.state().clone();
    rod.restore(&state).unwrap();
    (0..20).for_each(|_| rod.step(1e-2).unwrap());
    assert_eq!(*rod.state(), expected);
    let mut other =
        Rod::new(Parameters { support: RootSupport::Pinned, ..unit_rod::<2>(8, 1e3, Scheme::Bdf2) }).unwrap();
    let refused = other.restore(&state).unwrap_err().to_string();
    assert!(refused.contains("state.hinge"), "{refused}");
}

#[test]
fn roots_that_cannot_be_are_refused_by_name() {
    let rod = || unit_rod::<3>(8, 1e3, Scheme::TrBdf2);
    let damped = RootSupport::TorsionSpring { stiffness: 1.0, damping: 0.1, rest_angle: 0.0 };
    let turned = RootSupport::TorsionSpring { stiffness: 1.0, damping: 0.0, rest_angle: 0.1 };
    for (support, name) in
        [(damped, "support.damping"), (turned, "support.rest_angle"), (spring(0.0), "support.stiffness")]
    {
        let refused = Rod::new(Parameters { support, ..rod() }).map(|_| ()).unwrap_err().to_string();
        assert!(refused.contains(name), "{refused}");
    }
    let projected = Parameters { support: RootSupport::Pinned, bending: Bending::Projected, ..rod() };
    let refused = Rod::new(projected).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("support is Pinned"), "{refused}");
    let mut free = Rod::new(Parameters { support: RootSupport::Free, ..rod() }).unwrap();
    assert!(free.solve_static().unwrap_err().to_string().contains("Free"));
}

/// Across its axis the rod turns, so that no other velocity than the root's gives the power.
#[test]
fn towing_force_does_its_work_at_the_root() {
    for force in [[0.0, 2.0], [-1.0, -0.5]] {
        let mut rod =
            Rod::new(Parameters { support: RootSupport::Free, ..unit_rod::<2>(8, 1e4, Scheme::TrBdf2) }).unwrap();
        rod.towing = force;
        for _ in 0..400 {
            rod.step(1e-3).unwrap();
            let (drive, v) = (rod.state().drive, rod.state().velocities[0]);
            assert!((drive.power - force[0] * v[0] - force[1] * v[1]).abs() < 1e-12, "{drive:?}");
        }
        let (work, energy) = (rod.state().drive.work, total_energy(&rod));
        let tip = rod.state().velocities[8];
        assert!((work - energy).abs() < 0.02 * energy, "{work} against {energy}, tip {tip}");
    }
}

/// Return a root that slides along x, with this mass.
fn along_x(mass: f64) -> Option<Slide> {
    Some(Slide { axis: 0, mass })
}

/// A root driven across its slide and turned gives the rod no momentum along the slide, in every scheme; the work of
/// the drive is the energy of the rod.
#[test]
fn driven_root_gives_no_momentum_along_its_slide() {
    let heave = |t: f64| {
        let (angle, rate) = (0.4 * (1.0 - t.cos()), 0.4 * t.sin());
        BaseMotion {
            position: [0.0, 0.3 * (1.0 - t.cos())],
            velocity: [0.0, 0.3 * t.sin()],
            direction: [angle.cos(), angle.sin()],
            direction_rate: [-rate * angle.sin(), rate * angle.cos()],
        }
    };
    for support in [RootSupport::Clamped, RootSupport::Pinned, spring(0.5)] {
        for (shear, scheme) in SCHEMES.into_iter().flat_map(|scheme| [(None, scheme), (Some(40.0), scheme)]) {
            let rod = unit_rod::<2>(16, 1e3, scheme);
            let section = Section { shear_stiffness: shear, ..rod.section };
            let mut rod = Rod::new(Parameters { section, support, slide: along_x(0.2), ..rod }).unwrap();
            rod.place(heave(0.0)).unwrap();
            let centre = invariants(&rod).1[0];
            let (dt, mut farthest, mut work) = (2e-3, 0.0_f64, 0.0);
            for step in 1..=1000 {
                let before = rod.state().drive.power;
                rod.base_motion = Some(heave(dt * f64::from(step)));
                rod.step(dt).unwrap();
                work += 0.5 * dt * (before + rod.state().drive.power);
                let (momentum, place, _) = invariants(&rod);
                assert!(momentum[0].abs() < 1e-8, "{support:?}, {scheme:?}: momentum {}", momentum[0]);
                assert!((place[0] - centre).abs() < 1e-8, "{support:?}, {scheme:?}: {} from {centre}", place[0]);
                assert_eq!(rod.state().positions[0][1], heave(dt * f64::from(step)).position[1]);
                farthest = farthest.max(rod.state().positions[0][0].abs());
            }
            let energy = total_energy(&rod);
            println!("{support:?}, {shear:?}, {scheme:?}: root moves {farthest}, work {work}, energy {energy}");
            assert!(farthest > 5e-3, "{support:?}: the root does not slide: {farthest}");
            assert!((work / energy - 1.0).abs() < 0.01, "{support:?}, {scheme:?}: work {work}, energy {energy}");
        }
    }
}

/// Along its slide a rod falls as a point does, with the mass of the slide; the trapezoid keeps energy and momentum of
/// a rod that a load has bent.
#[test]
fn sliding_rod_falls_as_a_point_does_and_keeps_its_energy() {
    for shear in [None, Some(40.0)] {
        let parameters = |gravity| {
            let rod = unit_rod::<2>(16, 1e3, Scheme::Trapezoid);
            Parameters {
                section: Section { shear_stiffness: shear, ..rod.section },
                slide: along_x(0.7),
                gravity,
                ..rod
            }
        };
        let mut rod = Rod::new(parameters([9.81, 0.0])).unwrap();
        for step in 1..=200 {
            rod.step(5e-3).unwrap();
            let t = 5e-3 * f64::from(step);
            for (x, rest) in rod.positions(0).iter().zip(0..) {
                let exact = f64::from(rest) / 16.0 + 0.5 * 9.81 * t * t;
                assert!((x - exact).abs() < 1e-9, "{x} against {exact}");
            }
        }
        let mut rod = Rod::new(parameters([0.0; 2])).unwrap();
        rod.loads.force = vec![0.0; 2 * 17];
        (rod.loads.force[16], rod.loads.force[33]) = (0.5, 1.0);
        for _ in 0..500 {
            rod.step(1e-3).unwrap();
        }
        rod.loads.force.fill(0.0);
        rod.step(1e-3).unwrap();
        let (energy, momentum) = (total_energy(&rod), invariants(&rod).0[0]);
        assert!(momentum > 0.2, "{momentum}");
        for _ in 0..2000 {
            rod.step(1e-3).unwrap();
            assert!((total_energy(&rod) / energy - 1.0).abs() < 1e-3, "{} J of {energy}", total_energy(&rod));
            assert!((invariants(&rod).0[0] - momentum).abs() < 1e-9, "momentum {}", invariants(&rod).0[0]);
        }
    }
}

/// A stiff rod that hangs from a pin on a cart: ω² = (M + m) m g c / ((M + m) I − m² c²) with c = L/2, I about the pin.
#[test]
fn pinned_rod_on_a_slide_is_a_pendulum_on_a_cart() {
    let g = 9.81;
    let stiff = Section { line_density: 1.0, bending_stiffness: 1e3, axial_stiffness: 1e6, shear_stiffness: None };
    for (cart, scheme) in [(0.5, Scheme::TrBdf2), (2.0, Scheme::Bdf2), (1e6, Scheme::TrBdf2)] {
        let (support, slide) = (RootSupport::Pinned, along_x(cart));
        let rod = unit_rod::<2>(16, 1.0, scheme);
        let (gravity, direction) = ([0.0, -g], [0.0, -1.0]);
        let mut rod = Rod::new(Parameters { section: stiff, support, slide, gravity, direction, ..rod }).unwrap();
        // After a short push the pendulum swings beside a uniform motion.
        rod.loads.force = vec![0.0; 2 * 17];
        rod.loads.force[16] = 0.05;
        let dt = 1e-3;
        for _ in 0..50 {
            rod.step(dt).unwrap();
        }
        rod.loads.force.fill(0.0);
        let lean: Vec<f64> = (0..6000)
            .map(|_| {
                rod.step(dt).unwrap();
                rod.positions(0)[16] - rod.positions(0)[0]
            })
            .collect();
        let passed = crossings(&lean, dt);
        let period = 2.0 * (passed[passed.len() - 1] - passed[0]) / (passed.len() - 1) as f64;
        // n segments have the moment of inertia (1 + 1/(2 n²))/3.
        let (c, inertia) = (0.5, (1.0 + 0.5 / 256.0) / 3.0);
        let square = (cart + 1.0) * g * c / ((cart + 1.0) * inertia - c * c);
        let exact = TAU / square.sqrt();
        println!("cart {cart}: {period} against {exact}");
        assert!((period / exact - 1.0).abs() < 5e-4, "cart {cart}: {period} against {exact}");
    }
}

#[test]
fn slide_is_refused_where_it_has_no_meaning() {
    let rod = || Parameters { slide: along_x(0.0), ..unit_rod::<2>(8, 1e3, Scheme::TrBdf2) };
    for (parameters, word) in [
        (Parameters { support: RootSupport::Free, ..rod() }, "slide"),
        (Parameters { slide: Some(Slide { axis: 2, mass: 0.0 }), ..rod() }, "slide"),
        (Parameters { slide: along_x(-1.0), ..rod() }, "slide.mass"),
        (Parameters { calibration: Calibration::Thesis { k_e: 1.0 }, ..rod() }, "slide"),
        (Parameters { bending: Bending::Projected, ..rod() }, "slide"),
    ] {
        let error = Rod::new(parameters).err().unwrap().to_string();
        assert!(error.contains(word), "{error}");
    }
    let error = Rod::new(rod()).unwrap().solve_static().unwrap_err().to_string();
    assert!(error.contains("no equilibrium"), "{error}");
}
