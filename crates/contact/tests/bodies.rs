//! Rigid bodies without a fluid, in two-step backward differences.

#[path = "common/flying.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod flying;

use std::f64::consts::PI;

use nervure_contact::{BodyFilm, BodyLaw, Obstacle};
use rigid::{Freedoms, SpringDynamics};

use flying::{Free, LAW, World, ball, floor, fly};

/// Return the speed after a fall of a ball of 2 kg at 1 m/s on a floor.
fn rebound<const D: usize>(law: &BodyLaw) -> f64
where
    [f64; D]: SpringDynamics<D>,
{
    let mut place = [0.0; D];
    // So thick that what keeps it from half its thickness adds nothing.
    place[D - 1] = 10.0 + 3.0 * law.range.max(law.film.map_or(0.0, |film| film.range));
    let mut world = World::new(vec![ball(10.0, place, -1.0)], vec![floor()], law);
    for _ in 0..100_000 {
        world.step().unwrap();
        let now = &world.bodies[0].1.now;
        if now.velocity[D - 1] > 0.0 && now.position[D - 1] > 0.0 {
            return now.velocity[D - 1];
        }
    }
    0.0
}

#[test]
fn a_ball_on_spring_and_damper_loses_the_exact_share_of_its_speed() {
    for zeta in [0.0, 0.05, 0.3] {
        let stiffness = 2e4_f64;
        let damping = 2.0 * zeta * (2.0 * stiffness).sqrt();
        let dt = PI * (2.0 / stiffness).sqrt() / 1000.0;
        let law = BodyLaw { range: 1e-5, stiffness, damping, dt, ..LAW };
        let exact = (-PI * zeta / (1.0_f64 - zeta * zeta).sqrt()).exp();
        let found = [rebound::<2>(&law), rebound::<3>(&law)];
        for found in found {
            assert!((found - exact).abs() < 1e-3, "damping ratio {zeta}: {found} against {exact}");
        }
    }
}

#[test]
fn a_contact_of_ten_steps_keeps_the_speed_within_some_per_cent() {
    for k in 0..50 {
        let found = rebound::<2>(&BodyLaw { range: 0.01 + 2e-5 * f64::from(k), ..LAW });
        assert!(found <= 1.0 + 1e-9 && found > 0.95, "{k}: {found}");
    }
}

/// e = 1 − 2 ln(h_0/h_min)/St with p = 1, and by the same impulse ∫ (h^(−3/2) − h_0^(−3/2)) dh in the plane.
#[test]
fn a_ball_keeps_the_exact_speed_through_a_film() {
    let (range, least, radius) = (0.1_f64, 1e-3_f64, 10.0_f64);
    for (loss, steps) in [0.1, 0.3, 0.6].into_iter().flat_map(|loss| [2.0, 20.0].map(|steps| (loss, steps))) {
        let viscosity = |impulse: f64| 0.5 * loss * 2.0 / impulse;
        let space = 6.0 * PI * radius * radius * (range / least).ln();
        let plane = 3.0 * 2.0_f64.sqrt() * PI * radius.powf(1.5) * (3.0 / least.sqrt() - 3.0 / range.sqrt());
        let law = |impulse: f64| {
            let film = Some(BodyFilm { viscosity: viscosity(impulse), range, least });
            BodyLaw { range: 1e-8, stiffness: 1e12, film, dt: range / steps, ..LAW }
        };
        let found = [rebound::<2>(&law(plane)), rebound::<3>(&law(space))];
        for found in found {
            assert!((found - 1.0 + loss).abs() < 0.015, "{found} in {steps} steps against {}", 1.0 - loss);
        }
    }
}

#[test]
fn random_bodies_stay_apart_and_gain_no_energy() {
    let mut all = 0.0;
    for outcome in (0..20).flat_map(|case| [fly::<2>(case), fly::<3>(case)]) {
        let [touched, gain, depth] = outcome.unwrap();
        assert!(gain < 1e-12 && depth < 1.0, "{gain} of the energy, {depth} deep");
        all += touched;
    }
    assert!(all > 200.0, "{all} steps in contact");
}

/// The place in the list decides nothing: two that rub, balls or capsules, of unlike size.
#[test]
fn bodies_that_rub_move_the_same_in_any_order() {
    let rub = |order: [usize; 2], half: [f64; 2]| {
        let law = BodyLaw { range: 0.05, friction: 0.5, ..LAW };
        let body = |k: usize| {
            let (own, side) = (ball([0.2, 0.3][k], [0.02, 0.01, [0.26, -0.29][k]], [-0.5, 0.5][k]), [0.4, -0.2][k]);
            let rates = [side, 0.3 * side, own.rates[2], 0.0, 0.0, 0.0];
            let along = if k == 0 { [half[0], 0.0, 0.0] } else { [0.0, half[1], 0.0] };
            Free { rates, solid: Obstacle::block([0.0; 3], along, [0.2, 0.3][k]), ..own }
        };
        let mut world = World::<3>::new(order.map(body).into(), vec![], &law);
        (0..40).for_each(|_| world.step().expect("they stay apart"));
        [0, 1].map(|k| world.bodies[k].1.now.rates())
    };
    for half in [[0.0, 0.0], [0.1, 0.1]] {
        let ordered = |own: [Freedoms; 2], order: [usize; 2]| order.map(|k| own[k]);
        let [one, other] = [rub([0, 1], half), ordered(rub([1, 0], half), [1, 0])];
        let off = one.iter().flatten().zip(other.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-7 && one[1][4].abs() > 0.1, "{off} in {one:?}");
    }
}

/// A ball hands its speed to one of the same mass beyond the edge of a periodic box.
#[test]
fn balls_touch_across_the_edge_of_a_periodic_box() {
    let law = BodyLaw { range: 0.02, ..LAW };
    let mut world = World::<2>::new(vec![ball(0.05, [0.0, 0.9], 1.0), ball(0.05, [0.0, -0.9], 0.0)], vec![], &law);
    world.contacts = world.contacts.with_periods([f64::INFINITY, 2.0]);
    (0..300).for_each(|_| world.step().expect("they stay apart"));
    let [first, second] = [0, 1].map(|k| world.bodies[k].1.now.velocity[1]);
    assert!(first.abs() < 0.05 && (second - 1.0).abs() < 0.05, "{first} and {second} m/s");
}
