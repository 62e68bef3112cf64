//! Prescribed motion of the root.

use std::f64::consts::{PI, TAU};

use nervure_rod::{BaseMotion, Error, Parameters, Rod, RootSupport, Scheme, Section};
use scene::{RootLaws, Rotation, TimeLaw};

use crate::common::{SCHEMES, total_energy, turek_hron_bar, unit_rod};

/// Return the motion of the root of a rod along x at the origin.
fn root_at<const D: usize>(laws: &RootLaws, t: f64) -> BaseMotion<D> {
    let ((position, velocity), (direction, rate)) = (laws.displacement(t), laws.direction(t, [1.0, 0.0, 0.0]));
    let [position, velocity, direction, direction_rate] =
        [position, velocity, direction, rate].map(|vector| std::array::from_fn(|d| vector[d]));
    BaseMotion { position, velocity, direction, direction_rate }
}

/// Return the amplitude of sin(omega t) in samples `dt` apart, over whole periods from `start`.
fn amplitude(samples: &[f64], omega: f64, start: f64, dt: f64) -> f64 {
    let weighted = samples.iter().enumerate().map(|(k, y)| y * (omega * (start + dt * (k + 1) as f64)).sin());
    2.0 * weighted.sum::<f64>() / samples.len() as f64
}

/// Return the transverse amplitude of the tip of a unit rod, relative to a base motion along y or about z.
///
/// The frequency is b⁴ = mu omega² L⁴ / EI.
fn transfer(b: f64, pitch: bool) -> f64 {
    const AMPLITUDE: f64 = 1e-4;
    let omega = b * b;
    let (period, steps_per_period) = (TAU / omega, 200);
    let dt = period / f64::from(steps_per_period);
    let law =
        TimeLaw::Sine { mean: 0.0, amplitude: AMPLITUDE, frequency: 1.0 / period, phase: 0.0, ramp: 20.0 * period };
    let laws = if pitch {
        RootLaws { rotations: vec![Rotation { angle: law, axis: [0.0, 0.0, 1.0] }], ..RootLaws::default() }
    } else {
        RootLaws { y: law, ..RootLaws::default() }
    };
    let mut rod = Rod::new(unit_rod::<2>(64, 1e4, Scheme::TrBdf2)).unwrap();
    let (ramp, measured) = (30 * steps_per_period, 20 * steps_per_period);
    let mut samples = Vec::new();
    for step in 1..=ramp + measured {
        rod.base_motion = Some(root_at(&laws, dt * f64::from(step)));
        rod.step(dt).unwrap();
        if step > ramp {
            samples.push(rod.tip_displacement()[1]);
        }
    }
    amplitude(&samples, omega, dt * f64::from(ramp), dt) / AMPLITUDE
}

/// w(L)/w0 = (cos b + cosh b)/(1 + cos b cosh b), and for a rotation w(L)/(theta0 L) = (sin b + sinh b)/(b (1 + cos b
/// cosh b)), of the Euler–Bernoulli cantilever with a moving base; it resonates at b = 1.875 and 4.694.
#[test]
fn base_excitation_has_the_transfer_function_of_the_cantilever() {
    for b in [1.2_f64, 2.6, 3.4, 4.0] {
        let denominator = 1.0 + b.cos() * b.cosh();
        for (pitch, exact) in
            [(false, (b.cos() + b.cosh()) / denominator), (true, (b.sin() + b.sinh()) / (b * denominator))]
        {
            let found = transfer(b, pitch);
            assert!((found / exact - 1.0).abs() < 5e-3, "b = {b}, pitch {pitch}: {found} against {exact}");
        }
    }
}

/// The gain of energy is the work of the drive less the loss by damping. A soft rod of moderate extension heaves and
/// pitches widely over its second period, in the plane and in space.
#[test]
fn power_at_the_root_becomes_energy_or_goes_into_damping() {
    fn missing<const D: usize>(scheme: Scheme, steps: u32, shear_stiffness: Option<f64>) -> f64 {
        let law = |amplitude, phase| TimeLaw::Sine { mean: 0.0, amplitude, frequency: 0.4, phase, ramp: 2.5 };
        let axis = if D == 2 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 1.0] };
        let rotations = vec![Rotation { angle: law(0.9, 0.5), axis }];
        let laws = RootLaws { x: law(0.2, 1.0), y: law(0.4, 0.0), rotations, ..RootLaws::default() };
        let mut gravity = [0.0; D];
        gravity[1] = -1.0;
        let rod = unit_rod::<D>(16, 200.0, scheme);
        let section = Section { shear_stiffness, ..rod.section };
        let mut rod = Rod::new(Parameters { damping: 2.0, gravity, section, ..rod }).unwrap();
        rod.place(root_at(&laws, 0.0)).unwrap();
        let dt = 2.5 / f64::from(steps);
        let (mut energy, mut work, mut damped, mut exchanged) = (0.0, 0.0, 0.0, 0.0);
        for step in 1..=2 * steps {
            rod.base_motion = Some(root_at(&laws, dt * f64::from(step)));
            rod.step(dt).unwrap();
            if step == steps {
                (energy, work, damped, exchanged) = (total_energy(&rod), rod.state().drive.work, 0.0, 0.0);
            }
            damped += rod.damping_power() * dt;
            exchanged += rod.state().drive.power.abs() * dt;
        }
        let gained = total_energy(&rod) - energy;
        (rod.state().drive.work - work - gained - damped) / exchanged
    }
    for scheme in SCHEMES {
        for (space, [coarse, fine]) in [
            ("plane", [400, 800].map(|steps| missing::<2>(scheme, steps, None))),
            ("plane, with shear", [400, 800].map(|steps| missing::<2>(scheme, steps, Some(60.0)))),
            ("space", [400, 800].map(|steps| missing::<3>(scheme, steps, None))),
        ] {
            println!("{scheme:?}, {space}: {coarse:.2e} and with half the step {fine:.2e} of the work exchanged");
            assert!(fine.abs() < 1e-2 && fine.abs() < 0.6 * coarse.abs(), "{scheme:?}, {space}: {coarse}, {fine}");
        }
    }
}

/// On a nearly rigid rod, the force accelerates the centre of mass and the moment the inertia about the root.
#[test]
fn drive_of_a_stiff_rod_is_that_of_a_rigid_one() {
    let (frequency, amplitude) = (1.0, 0.8);
    let law = TimeLaw::Sine { mean: 0.0, amplitude, frequency, phase: 0.0, ramp: 1.0 };
    let laws = RootLaws { rotations: vec![Rotation { angle: law, axis: [0.0, 0.0, 1.0] }], ..RootLaws::default() };
    let mut stiff = unit_rod::<2>(32, 1e7, Scheme::Bdf2);
    stiff.section.bending_stiffness = 1e6;
    let mut rod = Rod::new(stiff).unwrap();
    let dt = 2e-4;
    for step in 1..=10_000 {
        let t = dt * f64::from(step);
        rod.base_motion = Some(root_at(&laws, t));
        rod.step(dt).unwrap();
        let (angle, _) = laws.rotations[0].angle.value_and_rate(t);
        let rate = |t: f64| laws.rotations[0].angle.value_and_rate(t).1;
        let (omega, alpha) = (rate(t), (rate(t + 1e-6) - rate(t - 1e-6)) / 2e-6);
        if step % 500 != 0 {
            continue;
        }
        let (sin, cos) = angle.sin_cos();
        let force = [-alpha * sin - omega * omega * cos, alpha * cos - omega * omega * sin].map(|a| 0.5 * a);
        let drive = rod.state().drive;
        let largest = amplitude * (TAU * frequency).powi(2);
        for (found, exact) in drive.force.iter().zip(force) {
            assert!((found - exact).abs() < 2e-3 * largest, "force at t = {t}: {found} against {exact}");
        }
        let moment = drive.moment[2];
        assert!((moment - alpha / 3.0).abs() < 2e-3 * largest, "moment at t = {t}: {moment} against {}", alpha / 3.0);
        let [x, y] = rod.rigid_tip_displacement();
        assert!((x - (cos - 1.0)).abs() < 1e-12 && (y - sin).abs() < 1e-12, "rigid tip at t = {t}: {x}, {y}");
    }
}

/// A constant acceleration of the root acts like a weight. The trapezoid is exact on the parabola.
#[test]
fn accelerated_root_is_gravity() {
    let (acceleration, dt) = (2.0, 1e-3);
    let mut weighed = Rod::new(Parameters { scheme: Scheme::Trapezoid, ..turek_hron_bar(1.4e6, 2.0, 32) }).unwrap();
    let mut moved = Rod::new(Parameters { gravity: [0.0; 2], ..weighed.parameters().clone() }).unwrap();
    for step in 1..=500 {
        let t = dt * f64::from(step);
        let height = 0.5 * acceleration * t * t;
        moved.base_motion = Some(BaseMotion {
            position: [0.25, 0.2 + height],
            velocity: [0.0, acceleration * t],
            direction: [1.0, 0.0],
            direction_rate: [0.0; 2],
        });
        weighed.step(dt).unwrap();
        moved.step(dt).unwrap();
        let (found, expected) = (moved.tip_displacement(), weighed.tip_displacement());
        for d in 0..2 {
            let found = found[d] - if d == 1 { height } else { 0.0 };
            assert!((found - expected[d]).abs() < 1e-9, "step {step}, {d}: {found} against {}", expected[d]);
        }
    }
    assert!(weighed.tip_displacement()[1] < -0.1, "hardly moved: {:?}", weighed.tip_displacement());
}

/// Flapping about an oblique axis in space equals flapping in the plane at right angles to it.
#[test]
fn flapping_is_the_same_in_the_plane_and_in_space() {
    let sine = |amplitude| TimeLaw::Sine { mean: 0.0, amplitude, frequency: 0.25, phase: 0.0, ramp: 1.0 };
    let about = |axis| RootLaws { rotations: vec![Rotation { angle: sine(0.6), axis }], ..RootLaws::default() };
    let plane = RootLaws { y: sine(0.2), ..about([0.0, 0.0, 1.0]) };
    let tilt = 0.7_f64;
    let space =
        RootLaws { y: sine(0.2 * tilt.cos()), z: sine(0.2 * tilt.sin()), ..about([0.0, -tilt.sin(), tilt.cos()]) };
    for scheme in SCHEMES {
        let mut planar = Rod::new(unit_rod::<2>(16, 1e3, scheme)).unwrap();
        let mut spatial = Rod::new(unit_rod::<3>(16, 1e3, scheme)).unwrap();
        let dt = 0.02;
        for step in 1..=150 {
            let t = dt * f64::from(step);
            planar.base_motion = Some(root_at(&plane, t));
            spatial.base_motion = Some(root_at(&space, t));
            planar.step(dt).unwrap();
            spatial.step(dt).unwrap();
            let ([x, y], found) = (planar.tip_displacement(), spatial.tip_displacement());
            for (found, expected) in found.into_iter().zip([x, y * tilt.cos(), y * tilt.sin()]) {
                assert!((found - expected).abs() < 1e-7, "{scheme:?}, t = {t}: {found} against {expected}");
            }
        }
        assert!(planar.tip_displacement()[1].abs() > 0.1, "{scheme:?} ended at {:?}", planar.tip_displacement());
    }
}

/// A sub-step inside a step finds the root on the cubic between the ends.
#[test]
fn substeps_follow_the_root_within_the_step() {
    let laws = RootLaws {
        y: TimeLaw::Sine { mean: 0.0, amplitude: 0.2, frequency: 0.8, phase: 0.0, ramp: 0.5 },
        rotations: vec![Rotation {
            angle: TimeLaw::Sine { mean: 0.0, amplitude: 0.6, frequency: 0.8, phase: 0.0, ramp: 0.5 },
            axis: [0.0, 0.0, 1.0],
        }],
        ..RootLaws::default()
    };
    let (dt, parts) = (0.02, 8);
    let fine = unit_rod::<2>(16, 1e3, Scheme::TrBdf2);
    let mut coarse = Rod::new(Parameters { max_step: Some(dt / f64::from(parts)), ..fine.clone() }).unwrap();
    let mut fine = Rod::new(fine).unwrap();
    for step in 1..=100 {
        coarse.base_motion = Some(root_at(&laws, dt * f64::from(step)));
        coarse.step(dt).unwrap();
        assert_eq!(coarse.statistics().substeps, parts as usize);
        for part in 1..=parts {
            fine.base_motion = Some(root_at(&laws, dt * (f64::from(step - 1) + f64::from(part) / f64::from(parts))));
            fine.step(dt / f64::from(parts)).unwrap();
        }
    }
    for d in 0..2 {
        let (found, expected) = (coarse.tip_displacement()[d], fine.tip_displacement()[d]);
        assert!((found - expected).abs() < 1e-5, "{found} against {expected}");
    }
}

/// A placed rod lies along its new direction and stays there.
#[test]
fn placed_rod_is_at_rest_where_it_was_put() {
    let mut rod = Rod::new(unit_rod::<3>(8, 1e3, Scheme::TrBdf2)).unwrap();
    let root = BaseMotion {
        position: [1.0, 2.0, 3.0],
        velocity: [0.0; 3],
        direction: [0.0, 3.0, 4.0],
        direction_rate: [0.0; 3],
    };
    rod.place(root).unwrap();
    for _ in 0..10 {
        rod.step(0.1).unwrap();
    }
    let tip: [f64; 3] = std::array::from_fn(|d| rod.positions(d)[8]);
    for (found, expected) in tip.into_iter().zip([1.0, 2.6, 3.8]) {
        assert!((found - expected).abs() < 1e-12, "{tip:?}");
    }
}

#[test]
fn restored_state_of_a_moving_rod_continues_bit_by_bit() {
    let laws = RootLaws {
        rotations: vec![Rotation {
            angle: TimeLaw::Sine { mean: 0.1, amplitude: 0.6, frequency: 0.8, phase: PI, ramp: 0.0 },
            axis: [0.0, 0.0, 1.0],
        }],
        ..RootLaws::default()
    };
    for scheme in SCHEMES {
        let parameters = unit_rod::<2>(16, 1e3, scheme);
        let step = |rod: &mut Rod<2>, step: u32| {
            rod.base_motion = Some(root_at(&laws, 0.01 * f64::from(step)));
            rod.step(0.01).unwrap();
        };
        let mut rod = Rod::new(parameters.clone()).unwrap();
        (1..20).for_each(|k| step(&mut rod, k));
        let state = rod.state().clone();
        let mut other = Rod::new(parameters).unwrap();
        assert!(other.restore(&state).is_err(), "a still rod took a moved clamp");
        other.base_motion = rod.base_motion;
        other.restore(&state).unwrap();
        (20..30).for_each(|k| [&mut rod, &mut other].into_iter().for_each(|rod| step(rod, k)));
        let (found, expected) = (other.tip_displacement(), rod.tip_displacement());
        assert!(other.state() == rod.state(), "{scheme:?}: {found:?} against {expected:?}");
    }
}

#[test]
fn bad_roots_are_named_and_change_nothing() {
    let mut rod = Rod::new(unit_rod::<2>(8, 1e3, Scheme::TrBdf2)).unwrap();
    let good = BaseMotion { position: [0.0; 2], velocity: [0.0; 2], direction: [1.0, 0.0], direction_rate: [0.0; 2] };
    let before = rod.state().clone();
    for (root, part) in [
        (BaseMotion { position: [f64::NAN, 0.0], ..good }, "base_motion.position is [NaN, 0.000e0]"),
        (BaseMotion { velocity: [0.0, f64::INFINITY], ..good }, "base_motion.velocity is [0.000e0, inf]"),
        (
            BaseMotion { direction: [0.0; 2], ..good },
            "base_motion.direction is [0.000e0, 0.000e0], but it must be a vector of any length",
        ),
        (
            BaseMotion { direction: [-0.1, 1.0], ..good },
            "base_motion.direction is [-1.000e-1, 1.000e0], but it must be less than a right",
        ),
    ] {
        rod.base_motion = Some(root);
        let message = rod.step(0.1).map_err(|error: Error| error.to_string()).unwrap_err();
        assert!(message.contains(part), "no {part:?} in {message:?}");
        assert_eq!(rod.state(), &before);
    }
}

/// The root is at rest within the step, so that nothing but the motion at its end is too large.
#[test]
fn a_motion_without_a_finite_power_is_refused_and_changes_nothing() {
    let still = BaseMotion { position: [0.0; 2], velocity: [0.0; 2], direction: [1.0, 0.0], direction_rate: [0.0; 2] };
    for scheme in SCHEMES {
        let mut rod = Rod::new(unit_rod::<2>(8, 1e3, scheme)).unwrap();
        let before = rod.state().clone();
        for root in [
            BaseMotion { velocity: [1.7e308, 0.0], ..still },
            BaseMotion { velocity: [0.0, -1e200], ..still },
            BaseMotion { direction: [0.6, 0.8], direction_rate: [-0.8e308, 0.6e308], ..still },
        ] {
            rod.base_motion = Some(root);
            assert!(rod.step(0.1).is_err(), "{scheme:?}, {root:?}: {:?}", rod.state().drive);
            assert_eq!(rod.state(), &before);
        }
    }
}

/// The prescribed motion of node 0 hides its impedance from all other nodes: only the drive feels it.
#[test]
fn drive_overcomes_the_impedance_of_the_root() {
    let root = |velocity| BaseMotion { position: [0.0; 2], velocity, direction: [1.0, 0.0], direction_rate: [0.0; 2] };
    let force = |impedance: f64| {
        let mut rod = Rod::new(unit_rod::<2>(8, 1e3, Scheme::Bdf2)).unwrap();
        rod.loads.impedance = vec![0.0; 9];
        rod.loads.impedance[0] = impedance;
        [[0.02, 0.01], [0.05, -0.03]].map(|velocity| {
            rod.base_motion = Some(root(velocity));
            rod.step(0.01).unwrap();
            rod.state().drive.force
        })
    };
    for (step, change) in [[0.02, 0.01], [0.03, -0.04]].into_iter().enumerate() {
        for (axis, change) in change.into_iter().enumerate() {
            let found = force(3.0)[step][axis] - force(0.0)[step][axis];
            assert!((found - 3.0 * change).abs() < 1e-9, "step {step}, axis {axis}: {found}");
        }
    }
}

#[test]
fn rigid_tip_of_a_curved_rod_turns_with_its_root() {
    let curved = Parameters { rest_angles: vec![0.0, 0.3, 0.7, 1.2], ..unit_rod::<2>(4, 1e3, Scheme::Bdf2) };
    let mut rod = Rod::new(curved).unwrap();
    let rest: [f64; 2] = std::array::from_fn(|d| rod.positions(d)[4]);
    assert!(rest[1] > 0.3, "{rest:?}");
    for angle in [0.4_f64, -1.1, 2.5] {
        let (sin, cos) = angle.sin_cos();
        let (position, direction) = ([0.2, -0.1], [3.0 * cos, 3.0 * sin]);
        rod.place(BaseMotion { position, velocity: [0.0; 2], direction, direction_rate: [0.0; 2] }).unwrap();
        let turned = [cos * rest[0] - sin * rest[1], sin * rest[0] + cos * rest[1]];
        for axis in 0..2 {
            let expected = position[axis] + turned[axis] - rest[axis];
            let found = rod.rigid_tip_displacement()[axis];
            assert!((found - expected).abs() < 1e-12, "{angle}, axis {axis}: {found} against {expected}");
        }
    }
}

/// A rod whose root moves uniformly from the start falls like one whose root stands, whatever holds it.
#[test]
fn a_root_in_uniform_motion_changes_nothing() {
    const VELOCITY: [f64; 2] = [0.7, -0.4];
    for support in [RootSupport::Clamped, RootSupport::Pinned] {
        let tip = |speed: f64| {
            let velocity = VELOCITY.map(|v| speed * v);
            let at = |t: f64| BaseMotion {
                position: velocity.map(|v| v * t),
                velocity,
                direction: [1.0, 0.0],
                direction_rate: [0.0; 2],
            };
            let own = unit_rod::<2>(8, 1e4, Scheme::Bdf2);
            let mut rod = Rod::new(Parameters { gravity: [0.3, -1.0], support, ..own }).unwrap();
            rod.place(at(0.0)).unwrap();
            for step in 1..=100 {
                rod.base_motion = Some(at(0.01 * f64::from(step)));
                rod.step(0.01).unwrap();
            }
            let moved = rod.tip_displacement();
            [0, 1].map(|d| moved[d] - velocity[d])
        };
        let [still, moving] = [tip(0.0), tip(1.0)];
        let off = (0..2).map(|d| (still[d] - moving[d]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9 && still[1].abs() > 0.01, "{off}: {moving:?} against {still:?}");
    }
}
