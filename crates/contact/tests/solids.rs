//! Cuboids, capsules and cylinders that meet in space, in two-step backward differences.

#[path = "common/flying.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod flying;

use flying::{Free, LAW, Random, World, throw};
use geometry::space::Solid;
use nalgebra::{Rotation3, SVector, Vector3};
use nervure_contact::{BodyLaw, Obstacle, Pose};

type V = SVector<f64, 3>;

const GRAVITY: f64 = 9.81;
const MASS: f64 = 2.0;

fn at(solid: &Solid, place: [f64; 3], turn: [f64; 3]) -> Obstacle<3> {
    let turn = Rotation3::from_scaled_axis(Vector3::from(turn));
    let axes = std::array::from_fn(|d| turn.matrix().column(d).into_owned());
    Obstacle::of_solid(solid, Pose { axes, origin: place.into() }).expect("no ellipsoid")
}

fn free(solid: &Solid, place: [f64; 3], rates: [f64; 6]) -> Free<3> {
    Free { solid: at(solid, [0.0; 3], [0.0; 3]), mass: MASS, inertia: 0.05, place, rates }
}

/// Return a world of one turned body above still solids, with gravity.
fn drop(
    body: &Solid,
    place: [f64; 3],
    turn: [f64; 3],
    rates: [f64; 6],
    still: Vec<Obstacle<3>>,
    law: &BodyLaw,
) -> World<3> {
    let mut world = World::new(vec![free(body, place, rates)], still, law);
    world.gravity = V::new(0.0, 0.0, -GRAVITY);
    world.turn(0, turn);
    world
}

fn state(world: &World<3>, k: usize) -> (V, V, V, V) {
    let now = &world.bodies[k].1.now;
    (now.position, now.angle, now.velocity, now.omega)
}

const SETTLING: BodyLaw = BodyLaw { range: 0.02, stiffness: 2e4, damping: 60.0, friction: 0.3, ..LAW };

/// Flat on a face, four edges below are as far as it and four ends of upright edges r farther, each with f = k (h − g)²/2h.
#[test]
fn a_cuboid_that_falls_on_a_cuboid_rests_with_its_weight() {
    for (turn, place) in [([0.0; 3], [0.05, 0.02, 0.5]), ([0.3, -0.2, 0.4], [-0.05, 0.03, 0.6])] {
        let table = at(&Solid::Cuboid([0.5, 0.4, 0.2]), [0.0; 3], [0.0; 3]);
        let mut world = drop(&Solid::Cuboid([0.2, 0.15, 0.1]), place, turn, [0.0; 6], vec![table], &SETTLING);
        (0..4000).for_each(|_| world.step().expect("they stay apart"));
        let (rested, angle, velocity, omega) = state(&world, 0);
        let gap = place[2] + rested[2] - 0.3;
        assert!(velocity.norm() < 1e-7 && omega.norm() < 1e-7, "{velocity} {omega}");
        assert!(angle.xy().norm() < 1e-5, "it lies at {angle}");
        let (h, r) = (SETTLING.range, 0.1 * 0.5 * SETTLING.range);
        // The stiffness of a contact of ten steps is smaller than the one that is asked for.
        let least = 1.0 / (1.0 / MASS + (0.2_f64.powi(2) + 0.15_f64.powi(2) + 0.1_f64.powi(2)) / 0.05);
        let k = SETTLING.stiffness.min(nervure_contact::largest_stiffness(least, SETTLING.dt));
        let force = |gap: f64| 0.5 * k * (h - gap).powi(2) / h;
        let sum = 4.0 * (force(gap) + force(gap + r));
        assert!((sum / (MASS * GRAVITY) - 1.0).abs() < 2e-3, "{sum} N at a gap of {gap}");
        (0..1000).for_each(|_| world.step().expect("they stay apart"));
        let moved = (state(&world, 0).0 - rested).norm();
        assert!(moved < 1e-7, "it creeps by {moved} m a second");
    }
}

/// No corner of one lies over the other.
#[test]
fn planks_that_cross_rest_on_each_other() {
    for slant in [0.0, 0.5] {
        let lower = at(&Solid::Cuboid([0.6, 0.08, 0.05]), [0.0; 3], [0.0, 0.0, slant]);
        let upper = Solid::Cuboid([0.08, 0.6, 0.05]);
        let mut world = drop(&upper, [0.02, 0.01, 0.125], [0.02, 0.03, 0.0], [0.0; 6], vec![lower], &SETTLING);
        (0..4000).for_each(|_| world.step().expect("they stay apart"));
        let (rested, angle, velocity, omega) = state(&world, 0);
        let gap = 0.125 + rested[2] - 0.1;
        assert!(velocity.norm() < 1e-6 && omega.norm() < 1e-6, "{velocity} {omega}");
        assert!(gap > 0.0 && gap < SETTLING.range && angle.xy().norm() < 1e-2, "{gap} m, {angle}");
    }
}

/// Edges at 45° to the gap are rounded by half the range, and reach as far as (√2 − 1) of it less.
#[test]
fn crossed_edges_know_their_gap() {
    let (half, range) = (0.2, 0.05);
    let law = BodyLaw { range, ..LAW };
    for (slant, gap, way) in [(0.0, 0.01, 0.0), (0.6, 0.02, 0.0), (-0.9, 0.0, 0.03), (0.3, 0.025, -0.05)] {
        let cube = Solid::Cuboid([half; 3]);
        let lower = at(&cube, [0.0; 3], [std::f64::consts::FRAC_PI_4, 0.0, 0.0]);
        let height = 2.0 * half * 2.0_f64.sqrt() + gap;
        let mut world = World::new(vec![free(&cube, [way, way, height], [0.0; 6])], vec![lower], &law);
        let across = Rotation3::from_scaled_axis(Vector3::z() * slant)
            * Rotation3::from_scaled_axis(Vector3::y() * std::f64::consts::FRAC_PI_4);
        world.turn(0, across.scaled_axis().into());
        world.step().expect("they stay apart");
        let found = world.contacts.touching()[0].1;
        let expected = gap + 0.5 * range * (2.0_f64.sqrt() - 1.0);
        // What makes the point unique adds a little off the middle of an edge.
        assert!(found > expected - 1e-12 && found < expected + 2e-3 * range, "{found}, not {expected}");
    }
}

fn shape(kinds: &[usize], random: &mut Random) -> (Obstacle<3>, f64) {
    let [a, b, c] = std::array::from_fn(|_| random.between(0.18, 0.4));
    let axis = random.between(0.0, 3.0) as usize;
    let solid = match kinds[random.between(0.0, kinds.len() as f64) as usize] {
        0 => Solid::Cuboid([a, b, c]),
        1 => Solid::Capsule { axis, radius: 0.7 * a, half_length: b },
        _ => Solid::Cylinder { axis, radius: a, half_length: b },
    };
    (at(&solid, [0.0; 3], [0.0; 3]), a * a + b * b)
}

#[test]
fn random_solids_stay_apart_and_gain_no_energy() {
    for (kinds, cases) in [(&[0][..], 120), (&[0, 1], 120), (&[2], 40), (&[0, 1, 2], 80)] {
        let mut all = 0.0;
        for case in 0..cases {
            let pillar = at(&Solid::Cuboid([0.3, 0.2, 0.9]), [0.0; 3], [0.2, 0.1, 0.5]);
            let [touched, gain, depth] = throw::<3>(case, |random| shape(kinds, random), pillar).unwrap();
            assert!(gain < 1e-12 && depth < 1.0, "{kinds:?}, {case}: {gain} of the energy, {depth} deep");
            all += touched;
        }
        eprintln!("{kinds:?}: {all} steps in contact");
        assert!(all > 5.0 * cases as f64, "{kinds:?}: {all} steps in contact");
    }
}
