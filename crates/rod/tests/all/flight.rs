//! A free body that carries a rod at a driven hinge.

use method::Support;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use nervure_rod::{BaseMotion, Rod, Scheme};
use rigid::{Body, BodyParameters, FluidLoad, Flyer, Freedoms, HingeTurn, Placed};

use crate::common::unit_rod;

type Vector = Vector3<f64>;

/// Steps in a period of the mode.
const STEPS: f64 = 150.0;

const FREE: Option<Support> = Some(Support { stiffness: 0.0, damping: 0.0, rest: 0.0 });

/// A unit rod along x on a body.
struct Flight {
    flyer: Flyer,
    rod: Rod<3>,
    h: f64,
}

fn base(root: &Placed) -> BaseMotion<3> {
    let direction = root.orientation * Vector::x();
    BaseMotion {
        position: root.position.into(),
        velocity: root.velocity.into(),
        direction: direction.into(),
        direction_rate: root.omega.cross(&direction).into(),
    }
}

impl Flight {
    fn new(mass: f64, inertia: f64, arm: Vector, h: f64) -> Self {
        let mut rod = Rod::new(unit_rod::<3>(32, 1e3, Scheme::Bdf2)).unwrap();
        rod.carry();
        let body = Body::new(BodyParameters {
            mass,
            inertia: Matrix3::identity() * inertia,
            centre: Vector::zeros(),
            supports: [FREE; 6],
            gravity: Vector::zeros(),
            position: -arm,
        });
        rod.place(base(&Flyer::new(body.clone(), vec![arm]).root(0, &body.state.now, &turned((0.0, 0.0))))).unwrap();
        Self { flyer: Flyer::new(body, vec![arm]), rod, h }
    }

    /// Make the step that ends with the hinge turned about z by an angle at a rate.
    fn step(&mut self, angle: (f64, f64)) {
        let hinge = turned(angle);
        self.rod.base_motion = Some(base(&self.flyer.root(0, &self.flyer.body().reference(self.h), &hinge)));
        let response = self.rod.root_response(self.h).unwrap();
        let drive = self.rod.state().drive;
        let reaction: Freedoms = std::array::from_fn(|i| if i < 3 { -drive.force[i] } else { -drive.moment[i - 3] });
        self.flyer.step(self.h, &[response], &[reaction], &FluidLoad::default());
        self.rod.base_motion = Some(base(&self.flyer.root(0, &self.flyer.body().state.now, &hinge)));
        self.rod.step(self.h).unwrap();
    }

    fn momentum(&self) -> Vector {
        let of_rod: Vector = self.rod.state().velocities.iter().zip(self.rod.masses()).map(|(v, m)| *v * *m).sum();
        of_rod + self.flyer.body().momentum()[0]
    }
}

fn turned((angle, rate): (f64, f64)) -> HingeTurn {
    HingeTurn { turn: UnitQuaternion::from_scaled_axis(Vector::z() * angle), rate: Vector::z() * rate }
}

/// Return angle and rate of a smooth pulse from 0 to `end`.
fn pulse(t: f64, size: f64, end: f64) -> (f64, f64) {
    use std::f64::consts::PI;
    if t >= end {
        return (0.0, 0.0);
    }
    let (sin, cos) = (PI * t / end).sin_cos();
    (size * sin.powi(4), 4.0 * size * PI / end * sin.powi(3) * cos)
}

/// Of all that a step assumes of the rod, the defect alone has not reached the body yet.
#[test]
fn a_body_and_its_rod_keep_their_momentum_to_1e_10() {
    for mass in [0.01, 1.0, 100.0] {
        let h = 4e-3;
        let mut flight = Flight::new(mass, 0.02 * mass, Vector::new(0.1, 0.05, 0.0), h);
        let (mut lost, mut fastest, mut first, mut before) = (0.0_f64, 0.0_f64, Vector::zeros(), Vector::zeros());
        for step in 1..=500 {
            flight.step(pulse(f64::from(step) * h, 1.0, 1.5));
            let (now, assumed) = (flight.momentum(), flight.flyer.state().assumed);
            let defect = -flight.rod.state().drive.force - Vector::new(assumed[0], assumed[1], assumed[2]);
            if step == 1 {
                first = defect;
            } else {
                lost = lost.max((1.5 * now - 0.5 * before + h * (defect + 0.5 * first)).norm());
            }
            before = now;
            fastest = flight.rod.state().velocities.iter().map(|v| v.norm()).fold(fastest, f64::max);
        }
        assert!(lost < 1e-10 * fastest.max(2.7), "M/m = {mass}: {lost:e} kg m/s at {fastest} m/s");
    }
}

/// Return b of the first mode with bending, `b⁴ = mu omega² L⁴/EI`, of a unit rod with a mass and its inertia at one end:
/// at the root `w''' = M b⁴ w` and `w'' = −J b⁴ w'`, at the tip `w'' = w''' = 0`.
fn mode(mass: f64, inertia: f64) -> f64 {
    let determinant = |b: f64| {
        let ((sin, cos), (sinh, cosh)) = (b.sin_cos(), (b.sinh(), b.cosh()));
        // w = A cos + B sin + C cosh + D sinh by w(0) and w'(0)/b.
        let column = |w: f64, slope: f64| {
            let (by_slope, by_w) = (inertia * b.powi(3) * slope, mass * b * w);
            let [a, c, b, d] = [w + by_slope, w - by_slope, slope - by_w, slope + by_w];
            [-a * cos - b * sin + c * cosh + d * sinh, a * sin - b * cos + c * sinh + d * cosh]
        };
        let [one, other] = [column(1.0, 0.0), column(0.0, 1.0)];
        one[0] * other[1] - one[1] * other[0]
    };
    let (mut low, mut high) = (1.2, 4.9);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if determinant(low) * determinant(middle) > 0.0 { low = middle } else { high = middle }
    }
    low
}

#[test]
fn a_rod_with_a_mass_at_its_root_swings_freely_at_its_frequency() {
    let b = mode(1e-9, 1e-9);
    assert!((b - 4.730).abs() < 1e-3, "a free rod has b = {b}");
    for (mass, inertia) in [(0.1, 1e-3), (1.0, 0.02), (10.0, 5.0)] {
        let omega = mode(mass, inertia).powi(2);
        let period = std::f64::consts::TAU / omega;
        let mut flight = Flight::new(mass, inertia, Vector::zeros(), period / STEPS);
        let (mut crossings, mut last) = (Vec::new(), 0.0);
        for step in 1..=(22.0 * STEPS) as u32 {
            let t = f64::from(step) * flight.h;
            flight.step(pulse(t, 1e-4, 1.5 * period));
            let bent = flight.rod.tip_displacement()[1] - flight.rod.rigid_tip_displacement()[1];
            if t > 2.0 * period && last < 0.0 && bent >= 0.0 {
                crossings.push(t - flight.h * bent / (bent - last));
            }
            last = bent;
        }
        let count = (crossings.len() - 1) as f64;
        let found = count * std::f64::consts::TAU / (crossings[crossings.len() - 1] - crossings[0]);
        assert!((found / omega - 1.0).abs() < 5e-3, "M = {mass}: {found} rad/s against {omega}");
    }
}
