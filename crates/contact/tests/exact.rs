//! A ball of mass 1 that bounces with the speed 1 against a wall at x = 0.

use std::f64::consts::PI;

use nervure_contact::{Before, Film, FilmPower, Law, largest_stiffness};

/// Advance place and speed by a step: the trapezoid for the penalty, the mean force of the step for damper and film.
fn step(law: &Law, [x, v]: [f64; 2], dt: f64) -> [f64; 2] {
    let (before, held) = (Some(Before { gap: x, dt }), law.penalty(x).force);
    let mut end = x + v * dt;
    for _ in 0..60 {
        // 2 (x_1 − x − v Δt)/Δt² = f: the penalty counts by the mean of both ends.
        let (all, own) = (law.response(end, before), law.penalty(end));
        let force = all.force + 0.5 * (held - own.force);
        let miss = 2.0 * (end - x - v * dt) / (dt * dt) - force;
        let update = miss / (2.0 / (dt * dt) + all.stiffness - 0.5 * own.stiffness);
        end -= update;
        if update.abs() < 1e-16 {
            break;
        }
    }
    [end, 2.0 * (end - x) / dt - v]
}

#[test]
fn a_ball_on_spring_and_damper_loses_the_exact_share_of_its_speed() {
    let stiffness = 1e4_f64;
    for zeta in [0.0, 0.05, 0.3] {
        // The range, in which the stiffness grows, is a thousandth of the overlap.
        let damping = 2.0 * zeta * stiffness.sqrt();
        let law = Law { range: 1e-5, stiffness, depth: f64::INFINITY, damping, friction: 0.0, film: None };
        let (mut ball, dt) = ([2e-5, -1.0], PI / stiffness.sqrt() / 400.0);
        while ball[0] < 1.5e-5 || ball[1] < 0.0 {
            ball = step(&law, ball, dt);
        }
        let exact = (-PI * zeta / (1.0 - zeta * zeta).sqrt()).exp();
        assert!((ball[1] - exact).abs() < 3e-3, "damping ratio {zeta}: {} against {exact}", ball[1]);
    }
}

#[test]
fn a_ball_rests_where_its_weight_balances_the_spring() {
    let law = Law { range: 1e-3, stiffness: 500.0, depth: f64::INFINITY, damping: 5.0, friction: 0.0, film: None };
    let (weight, mut ball) = (9.81, [0.0, 0.0]);
    for _ in 0..100_000 {
        let [x, v] = step(&law, ball, 1e-4);
        ball = [x - 0.5e-8 * weight, v - 1e-4 * weight];
    }
    let exact = 0.5e-3 - weight / 500.0;
    assert!((ball[0] / exact - 1.0).abs() < 1e-3, "{} against {exact}", ball[0]);
}

/// e = 1 − 2 ln(h_0/h_min)/St with an elastic bounce: the film is an impulse, exact in steps of any length.
#[test]
fn a_ball_keeps_the_exact_speed_through_a_film_in_few_steps() {
    let (range, least) = (0.1, 1e-3);
    for (stokes, steps) in [15.0, 27.0, 58.0, 152.0].into_iter().flat_map(|st| [1.0, 2.0, 5.0, 20.0].map(|n| (st, n))) {
        let film = Some(Film { coefficient: 1.0 / stokes, power: FilmPower::One, range, least });
        // The ball enters the spring by a thousandth of h_min.
        let law = Law { range: 1e-8, stiffness: 1e12, depth: f64::INFINITY, damping: 0.0, friction: 0.0, film };
        let (mut ball, mut taken) = ([range, -1.0_f64], 0);
        while ball[1] < 0.0 || ball[0] < range {
            let free = if ball[1] < 0.0 { 0.9 * ball[0] / -ball[1] } else { ball[0] / ball[1] };
            ball = step(&law, ball, free.clamp(2e-8, range / steps));
            taken += 1;
            assert!(taken < 20_000, "the ball stays at {ball:?}");
        }
        let exact = 1.0 - 2.0 * (range / least).ln() / stokes;
        assert!((ball[1] - exact).abs() < 2e-3, "St {stokes}, {steps} steps: {} against {exact}", ball[1]);
    }
}

/// The proposed stiffness keeps a contact of a mass longer than ten steps.
#[test]
fn the_largest_stiffness_is_ten_steps_of_half_a_period() {
    let (mass, dt) = (3.0, 1e-3);
    let half = PI * (mass / largest_stiffness(mass, dt)).sqrt();
    assert!((half / dt - 10.0).abs() < 1e-12, "{half} s in steps of {dt} s");
}
