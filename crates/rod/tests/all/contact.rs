//! Contact with obstacles and of a rod with itself.

use std::f64::consts::PI;

use nervure_rod::{BaseMotion, Contact, Law, Obstacle, Parameters, Pose, Rod, RootSupport, Section};

use crate::thrown::{SECTION, contact, throw};

/// A rod that lies on the ground, with its pinned root at the height h: it is lifted over (24 EI h/w)^¼ = s, and the
/// root slopes by 2 h/s.
#[test]
fn a_rod_is_lifted_off_a_plane_over_the_exact_length() {
    let (length, segments, radius, gravity) = (4.0, 160, 5e-3, 10.0);
    let contact = contact(segments, radius, 2e-4, vec![Obstacle::plane([0.0, 0.0], [0.0, 1.0])]);
    let w = SECTION.line_density * gravity;
    let Law { range, stiffness, .. } = contact.law;
    let ground = radius + range - (2.0 * w * range / stiffness).sqrt();
    let h = 0.02;
    let mut rod = Rod::<2>::new(Parameters {
        attachment: [0.0, ground + h],
        gravity: [0.0, -gravity],
        support: RootSupport::Pinned,
        contact: Some(contact),
        ..Parameters::new(length, segments, SECTION)
    })
    .unwrap();
    rod.solve_static().unwrap();
    let s = (24.0 * SECTION.bending_stiffness * h / w).powf(0.25);
    let (x, y) = (rod.positions(0), rod.positions(1));
    let slope = (y[0] - y[1]) / (x[1] - x[0]);
    let exact = 2.0 * h / s;
    assert!((slope / exact - 1.0).abs() < 0.03, "root slope {slope}, exact {exact}");
    let carried: f64 = rod.contact_forces().iter().map(|force| force[1]).sum();
    let at_root = w * length - carried;
    assert!((at_root / (w * s / 2.0) - 1.0).abs() < 0.02, "the root carries {at_root} N, exact {}", w * s / 2.0);
}

/// A cantilever whose tip rests on a ball or a cylinder, which yields by δ, gives it 3/8 w L − 3 EI δ/L³.
#[test]
fn a_propped_cantilever_gives_three_eighths_of_its_weight_to_the_prop() {
    fn carried<const D: usize>(prop: Obstacle<D>) -> [f64; 2] {
        let (length, segments, radius, stiffness) = (1.0, 40, 5e-3, 50.0);
        let mut parameters =
            Parameters::<D>::new(length, segments, Section { bending_stiffness: stiffness, ..SECTION });
        parameters.gravity[1] = -1.0;
        parameters.contact = Some(contact(segments, radius, 1e-4, vec![prop]));
        let mut rod = Rod::new(parameters).unwrap();
        rod.solve_static().unwrap();
        let force: f64 = rod.contact_forces().iter().map(|force| force[1]).sum();
        [force, 0.375 * SECTION.line_density + 3.0 * stiffness * rod.tip_displacement()[1]]
    }
    // The ball's top lies one range and half a thickness below the rod.
    let (size, [x, y]) = (0.02, [1.0, -0.035]);
    let found = [
        carried(Obstacle::block([x, y], [0.0; 2], size)),
        carried(Obstacle::block([x, y, 0.0], [0.0, 0.0, 1.0], size)),
    ];
    for [found, exact] in found {
        assert!((found / exact - 1.0).abs() < 0.01, "{found} N against {exact} N");
    }
}

/// A thin rod bends by a quarter round a drum that turns under it: T_root/T_tip = exp(μ π/2).
#[test]
fn a_rod_on_a_turning_drum_obeys_the_capstan_equation() {
    let (radius, drum, friction, pull, dt) = (2e-3, 0.1, 0.3, 1.0, 1e-3);
    let (straight, quarter) = (0.05, PI / 2.0 * (drum + radius));
    let length = 2.0 * straight + quarter;
    let segments = 120;
    let section = Section { line_density: 0.05, bending_stiffness: 1e-6, axial_stiffness: 1e4, shear_stiffness: None };
    let turned = |k: usize| {
        let along = (k as f64 + 0.5) * length / segments as f64;
        -((along - straight) / quarter).clamp(0.0, 1.0) * PI / 2.0
    };
    let law = Law { range: 5e-4, stiffness: 4e4, depth: radius, damping: 5.0, friction, film: None };
    let drum_at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        Pose { axes: [[cos, sin].into(), [-sin, cos].into()], origin: [0.0; 2].into() }
    };
    let mut rod = Rod::<2>::new(Parameters {
        attachment: [-straight, drum + radius],
        rest_angles: (0..segments).map(turned).collect(),
        damping: 0.5,
        contact: Some(Contact {
            law,
            radius: vec![radius; segments + 1],
            with_itself: false,
            obstacles: vec![Obstacle::block([0.0; 2], [0.0; 2], drum)],
        }),
        ..Parameters::new(length, segments, section)
    })
    .unwrap();
    rod.base_motion = Some(BaseMotion {
        position: [-straight, drum + radius],
        velocity: [0.0; 2],
        direction: [1.0, 0.0],
        direction_rate: [0.0; 2],
    });
    rod.loads.force = vec![0.0; 2 * (segments + 1)];
    *rod.loads.force.last_mut().unwrap() = -pull;
    let rate = -1.0;
    for k in 0..1500 {
        rod.move_obstacle(0, [drum_at(rate * dt * f64::from(k)), drum_at(rate * dt * f64::from(k + 1))]);
        rod.step(dt).unwrap();
    }
    let (found, exact) = (-rod.state().drive.force[0] / pull, (friction * PI / 2.0).exp());
    assert!((found / exact - 1.0).abs() < 0.01, "T2/T1 {found} against {exact}");
}

/// A free hairpin whose arms approach each other: they bounce, and its momentum stays.
#[test]
fn arms_of_a_rod_that_meet_bounce_without_a_net_force() {
    let (segments, radius, dt) = (40, 5e-3, 1e-3);
    // Two straight arms with a half circle of a tenth of the length between them.
    let turned = |k: usize| PI * ((k as f64 + 0.5 - 18.0) / 4.0).clamp(0.0, 1.0);
    let mut contact = contact::<2>(segments, radius, dt, Vec::new());
    contact.with_itself = true;
    let mut rod = Rod::<2>::new(Parameters {
        rest_angles: (0..segments).map(turned).collect(),
        support: RootSupport::Free,
        contact: Some(contact),
        ..Parameters::new(1.0, segments, Section { bending_stiffness: 0.01, ..SECTION })
    })
    .unwrap();
    let mut state = rod.state().clone();
    for k in 0..=segments {
        let along = (k as f64 / segments as f64 - 0.5) * 2.0;
        state.velocities[k][1] = if along.abs() > 0.1 { -0.5 * along } else { 0.0 };
    }
    rod.restore(&state).unwrap();
    let momentum = |rod: &Rod<2>| -> f64 { rod.masses().iter().zip(rod.velocities(1)).map(|(m, v)| m * v).sum() };
    let (start, mut touched, mut largest) = (momentum(&rod), 0.0_f64, 0.0_f64);
    for _ in 0..200 {
        rod.step(dt).unwrap();
        let all: f64 = rod.contact_forces().iter().map(|force| force[1]).sum();
        let each: f64 = rod.contact_forces().iter().map(|force| force[1].abs()).sum();
        (touched, largest) = (touched.max(each), largest.max(all.abs()));
        let gap = (0..18).map(|k| rod.positions(1)[segments - k] - rod.positions(1)[k]).fold(f64::INFINITY, f64::min);
        assert!(gap > radius, "the centre lines are {gap} m apart");
    }
    assert!(touched > 1.0 && largest < 1e-12 * touched, "net force {largest} N of {touched} N");
    let drift = (momentum(&rod) - start).abs();
    assert!(drift < 1e-6, "the momentum drifts by {drift} kg m/s");
}

#[test]
fn a_rod_thrown_between_obstacles_gains_no_energy_and_stays_outside() {
    let mut all = 0.0;
    for outcome in (0..3).flat_map(|seed| [throw::<2>(seed), throw::<3>(seed)]) {
        let [touched, gain, depth] = outcome.unwrap();
        assert!(gain < 0.01 && depth < 1.0, "{gain} of the energy, {depth} deep");
        all += touched;
    }
    assert!(all > 150.0, "{all} steps in contact");
}
