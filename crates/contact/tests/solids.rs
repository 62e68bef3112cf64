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
        assert!(velocity.norm() < 1e-5 && omega.norm() < 1e-4, "{velocity} {omega}");
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
        assert!(all > 5.0 * cases as f64, "{kinds:?}: {all} steps in contact");
    }
}

/// Return how deep points of the one lie in the other, m.
fn overlap([one, two]: [&Obstacle<3>; 2], poses: [&Pose<3>; 2]) -> f64 {
    let count = 9;
    let share = |k: usize| 0.5 * (2.0 * k as f64 / (count - 1) as f64 - 1.0) * 1.6;
    let points =
        (0..count * count * count).map(|k| V::from([k, k / count, k / count / count].map(|k| share(k % count))));
    let inside = points.filter(|point| one.nearest_at(&Pose::at([0.0; 3]), *point).distance <= 0.0);
    inside.map(|point| -two.nearest_at(poses[1], poses[0].place(point)).distance).fold(0.0, f64::max)
}

/// Four solids fall into a bin and onto each other.
#[test]
fn piles_come_to_rest_without_overlap() {
    for case in 0..6 {
        let kinds = if case < 4 { &[0, 1][..] } else { &[0, 2] };
        let mut random = Random(88_172_645_463_325_252_u64.wrapping_mul(2 * case + 1));
        (0..8).for_each(|_| _ = random.next());
        let law = BodyLaw { range: 0.04, damping: 40.0, friction: 0.3, dt: 2e-3, ..LAW };
        let bodies = (0..4).map(|k| {
            let place = [0.1 * f64::from(k % 2), 0.05 * f64::from(k), 0.8 + 1.4 * f64::from(k)];
            let rates =
                std::array::from_fn(|i| if i < 2 { random.between(-0.3, 0.3) } else { random.between(-1.0, 1.0) });
            Free { solid: shape(kinds, &mut random).0, mass: MASS, inertia: 0.1, place, rates }
        });
        let walls = [([0.0; 3], [0.0, 0.0, 1.0])].into_iter().chain((0..4).map(|k| {
            let (axis, side) = (k / 2, if k % 2 == 0 { 1.0 } else { -1.0 });
            let along = |size: f64| std::array::from_fn(|d| if d == axis { size } else { 0.0 });
            (along(-0.9 * side), along(side))
        }));
        let mut world =
            World::new(bodies.collect(), walls.map(|(at, normal)| Obstacle::plane(at, normal)).collect(), &law);
        world.gravity = V::new(0.0, 0.0, -GRAVITY);
        let energy = |world: &World<3>| {
            let height: f64 = world.bodies.iter().map(|(body, history)| body.place[2] + history.now.position[2]).sum();
            let stored: f64 = world.contacts.touching().iter().map(|(_, _, energy)| energy).sum();
            world.energy() + MASS * GRAVITY * height + stored
        };
        let start = energy(&world);
        for step in 0..2000 {
            world.step().unwrap_or_else(|pair| panic!("{case}, {step}: {pair:?}"));
            if step % 40 == 0 {
                assert!(energy(&world) < start * (1.0 + 1e-3), "{case}, {step}: {} J of {start}", energy(&world));
                let parts = world.contacts.parts();
                for (j, two) in parts.iter().enumerate().take(4) {
                    for one in &parts[..j] {
                        let (solids, poses) = ([&one.solid, &two.solid], [&one.motion.poses[0], &two.motion.poses[0]]);
                        let turned = [1, 0].map(|k| (solids[k], poses[k]));
                        let deep =
                            overlap(solids, poses).max(overlap(turned.map(|own| own.0), turned.map(|own| own.1)));
                        assert!(deep < 0.5 * law.range, "{case}, {step}: {deep} m deep");
                    }
                }
            }
        }
        assert!(world.energy() < 2e-3 * start, "{case}: {} J at the end", world.energy());
    }
}

/// A cylinder stands on a wall, on a cuboid and on another cylinder, and friction stops its spin.
#[test]
fn a_cylinder_stands_and_stops_to_spin() {
    let cylinder = Solid::Cylinder { axis: 2, radius: 0.15, half_length: 0.1 };
    let below = [
        Obstacle::plane([0.0, 0.0, 0.1], [0.0, 0.0, 1.0]),
        at(&Solid::Cuboid([0.4, 0.3, 0.1]), [0.0; 3], [0.0; 3]),
        at(&Solid::Cylinder { axis: 2, radius: 0.3, half_length: 0.1 }, [0.0; 3], [0.0; 3]),
        at(&Solid::Capsule { axis: 0, radius: 0.1, half_length: 0.5 }, [0.0; 3], [0.0; 3]),
    ];
    for (k, below) in below.into_iter().enumerate() {
        let spin = if k < 3 { 3.0 } else { 0.0 };
        let mut world =
            drop(&cylinder, [0.0, 0.0, 0.25], [0.0; 3], [0.0, 0.0, 0.0, 0.0, 0.0, spin], vec![below], &SETTLING);
        let mut wobble = 0.0_f64;
        for step in 0..3000 {
            world.step().expect("they stay apart");
            if step > 2000 {
                wobble = wobble.max(state(&world, 0).3.norm());
            }
        }
        let (place, angle, ..) = state(&world, 0);
        let gap = 0.05 + place[2];
        assert!(wobble < 1e-5 && angle.xy().norm() < 1e-5, "{k}: it turns with {wobble} rad/s at {angle}");
        assert!(gap > 0.0 && gap < SETTLING.range, "{k}: {gap} m");
        assert!(k == 3 || angle.z > 0.05, "{k}: it has turned by {angle}");
    }
}

/// A tilted one falls flat, whatever side comes first.
#[test]
fn a_tilted_cylinder_falls_flat() {
    let cylinder = Solid::Cylinder { axis: 2, radius: 0.15, half_length: 0.1 };
    for (k, turn) in [[0.2, 0.0, 0.0], [-0.1, 0.15, 0.0], [0.0, -0.3, 0.7]].into_iter().enumerate() {
        let wall = Obstacle::plane([0.0; 3], [0.0, 0.0, 1.0]);
        let law = BodyLaw { damping: 200.0, ..SETTLING };
        let mut world = drop(&cylinder, [0.0, 0.0, 0.2], turn, [0.0; 6], vec![wall], &law);
        (0..6000).for_each(|_| world.step().expect("they stay apart"));
        let (_, angle, velocity, omega) = state(&world, 0);
        assert!(angle.xy().norm() < 1e-5 && velocity.norm() < 1e-5 && omega.norm() < 1e-4, "{k}: {angle} {velocity}");
    }
}

/// It rolls on its side as fast as a solid whose speeds change by friction alone: without bumps.
#[test]
fn a_cylinder_rolls_on_its_side_without_bumps() {
    let cylinder = Solid::Cylinder { axis: 1, radius: 0.15, half_length: 0.2 };
    let wall = Obstacle::plane([0.0; 3], [0.0, 0.0, 1.0]);
    // So high that the weight is carried.
    let law = BodyLaw { damping: 200.0, ..SETTLING };
    let rates = [0.6, 0.0, 0.0, 0.0, 4.0, 0.0];
    let mut world = drop(&cylinder, [0.0, 0.0, 0.165], [0.0; 3], rates, vec![wall], &law);
    (0..500).for_each(|_| world.step().expect("they stay apart"));
    let (mut least, mut most, mut low, mut high) = (f64::INFINITY, 0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..3000 {
        world.step().expect("they stay apart");
        let (place, _, velocity, _) = state(&world, 0);
        (least, most) = (least.min(velocity[0]), most.max(velocity[0]));
        (low, high) = (low.min(place[2]), high.max(place[2]));
    }
    assert!(least > 0.59 && most < 0.61, "it rolls with {least} to {most} m/s");
    assert!(high - low < 1e-3 * law.range, "it rises from {low} to {high} m");
}

/// Bodies that meet and rub, with all of a world turned, mirrored, or in another order.
#[test]
fn turned_mirrored_and_reordered_worlds_move_alike() {
    let law = BodyLaw { range: 0.04, friction: 0.4, damping: 5.0, ..LAW };
    let shapes = [
        Solid::Cuboid([0.3, 0.2, 0.15]),
        Solid::Cuboid([0.2, 0.25, 0.1]),
        Solid::Capsule { axis: 0, radius: 0.1, half_length: 0.25 },
        Solid::Cylinder { axis: 1, radius: 0.15, half_length: 0.2 },
    ];
    let places = [[0.0, 0.0, 0.0], [0.25, 0.1, 0.35], [-0.25, -0.15, 0.35], [0.1, -0.05, -0.4]];
    let rates =
        [[0.0; 6], [-0.5, 0.1, -1.5, 0.4, 0.0, 0.3], [0.3, 0.2, -1.2, 0.0, 0.5, -0.3], [0.0, 0.1, 1.5, 0.6, 0.2, 0.0]];
    // A quarter of a turn about z, and a mirror across x.
    let turn = |[x, y, z]: [f64; 3]| [-y, x, z];
    let mirror = |[x, y, z]: [f64; 3]| [-x, y, z];
    let spin = |[x, y, z]: [f64; 3]| [x, -y, -z];
    let swapped = |solid: &Solid| match *solid {
        Solid::Cuboid([a, b, c]) => Solid::Cuboid([b, a, c]),
        Solid::Capsule { axis, radius, half_length } => Solid::Capsule { axis: [1, 0, 2][axis], radius, half_length },
        Solid::Cylinder { axis, radius, half_length } => Solid::Cylinder { axis: [1, 0, 2][axis], radius, half_length },
        _ => unreachable!(),
    };
    type Map<'a> = &'a dyn Fn([f64; 3]) -> [f64; 3];
    let run = |order: [usize; 4], shape: &dyn Fn(&Solid) -> Solid, place: Map, about: Map| {
        let body = |k: usize| {
            let [v, w] = [0, 3].map(|first| std::array::from_fn(|d| rates[k][first + d]));
            let (v, w) = (place(v), about(w));
            free(&shape(&shapes[k]), place(places[k]), std::array::from_fn(|i| if i < 3 { v[i] } else { w[i - 3] }))
        };
        let mut world = World::new(order.map(body).into(), vec![], &law);
        let mut touched = 0;
        for _ in 0..300 {
            world.step().expect("they stay apart");
            touched += usize::from(!world.contacts.touching().is_empty());
        }
        let momentum: V = (0..4).map(|k| MASS * state(&world, k).2).sum();
        let at = |k: usize| state(&world, order.iter().position(|own| *own == k).expect("it is there"));
        (std::array::from_fn::<_, 4, _>(|k| [at(k).2, at(k).3]), momentum, touched)
    };
    let same = |solid: &Solid| *solid;
    let (plain, momentum, touched) = run([0, 1, 2, 3], &same, &|v| v, &|v| v);
    let begun: V = rates.iter().map(|own| MASS * V::new(own[0], own[1], own[2])).sum();
    assert!(touched > 30 && (momentum - begun).norm() < 1e-12, "{touched} steps in contact, {momentum} from {begun}");
    assert!(plain[0][0].norm() > 0.1 && plain[0][1].norm() > 0.1, "{plain:?}");
    let others = [
        (run([3, 1, 0, 2], &same, &|v| v, &|v| v).0, &(|v| v) as Map, &(|v| v) as Map),
        (run([0, 1, 2, 3], &swapped, &turn, &turn).0, &turn, &turn),
        (run([0, 1, 2, 3], &same, &mirror, &spin).0, &mirror, &spin),
    ];
    for (i, (found, place, about)) in others.into_iter().enumerate() {
        for (own, other) in plain.iter().zip(found) {
            let off =
                (V::from(place(own[0].into())) - other[0]).norm() + (V::from(about(own[1].into())) - other[1]).norm();
            assert!(off < 1e-5, "{i}: {off} between {own:?} and {other:?}");
        }
    }
}

#[test]
fn first_and_later_meetings_of_solids_allocate_nothing() {
    let table = at(&Solid::Cuboid([0.5, 0.4, 0.2]), [0.0; 3], [0.0; 3]);
    let bodies = vec![
        free(&Solid::Cuboid([0.2, 0.15, 0.1]), [0.0, 0.0, 0.33], [0.0, 0.0, -1.0, 0.3, 0.2, 0.1]),
        free(
            &Solid::Cylinder { axis: 0, radius: 0.1, half_length: 0.1 },
            [0.0, 0.0, 0.57],
            [0.0, 0.0, -1.0, 0.0, 0.0, 0.0],
        ),
    ];
    let mut world = World::new(bodies, vec![table], &BodyLaw { friction: 0.2, ..LAW });
    let mut touched = 0;
    for _ in 0..50 {
        world.step().expect("they stay apart");
        let counted = allocation_counter::measure(|| {
            touched += usize::from(world.contacts.solve(1000.0, LAW.dt).expect("they stay apart").is_some());
        });
        assert_eq!(counted.count_total, 0);
    }
    assert!(touched > 10, "{touched} steps in contact");
}

#[test]
fn solids_without_ends_touch_neither_walls_nor_each_other() {
    let endless = at(&Solid::Cylinder { axis: 0, radius: 0.1, half_length: f64::INFINITY }, [0.0; 3], [0.0; 3]);
    let wall = Obstacle::plane([0.0; 3], [0.0, 0.0, 1.0]);
    assert!(!endless.can_touch(&wall) && !wall.can_touch(&endless) && !endless.can_touch(&endless));
    for solid in [
        Solid::Sphere(0.1),
        Solid::Cuboid([0.1; 3]),
        Solid::Capsule { axis: 0, radius: 0.1, half_length: 0.1 },
        Solid::Cylinder { axis: 0, radius: 0.1, half_length: 0.1 },
    ] {
        let own = at(&solid, [0.0; 3], [0.0; 3]);
        assert!([&endless, &wall, &own].iter().all(|other| own.can_touch(other) && other.can_touch(&own)), "{solid:?}");
    }
}
