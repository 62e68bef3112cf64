//! A free body against exact motions, invariants and orders.

use std::f64::consts::TAU;

use method::Support;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use nervure_rigid::{Body, BodyParameters, Drag, Mass, Placed};

const FREE: Option<Support> = Some(Support { stiffness: 0.0, damping: 0.0, rest: 0.0 });
const NO_FLUID: Mass<3> = Mass { mass: 0.0, inertia: [[0.0; 3]; 3], arm: Vector3::new(0.0, 0.0, 0.0) };

fn parameters() -> BodyParameters {
    BodyParameters {
        mass: 2.0,
        inertia: Matrix3::from_diagonal(&Vector3::new(0.5, 0.9, 1.2)),
        centre: Vector3::new(0.1, -0.2, 0.3),
        supports: [FREE; 6],
        gravity: Vector3::zeros(),
        position: Vector3::new(1.0, 2.0, 3.0),
    }
}

fn placed(body: &Body, velocity: Vector3<f64>, omega: Vector3<f64>) -> Placed {
    Placed { velocity, omega, ..body.state.now }
}

fn run(body: &mut Body, h: f64, steps: usize) {
    for _ in 0..steps {
        body.step(h, &Drag::default(), &NO_FLUID, &[0.0; 6]);
    }
}

#[test]
fn a_tumbling_body_keeps_momentum_to_rounding_and_its_energy() {
    let mut body = Body::new(parameters());
    body.place(placed(&body, Vector3::new(0.3, -0.1, 0.2), Vector3::new(0.4, 2.0, 0.7)));
    let ([momentum, angular], [energy, _]) = (body.momentum(), body.energy());
    run(&mut body, 2e-3, 5000);
    let ([after, after_angular], [now, _]) = (body.momentum(), body.energy());
    let off = [(after - momentum).norm() / momentum.norm(), (now - energy).abs() / energy];
    assert!(off[0] < 1e-11, "momentum off by {:e}", off[0]);
    assert!((after_angular - angular).norm() < 1e-10 * angular.norm(), "{after_angular:?} against {angular:?}");
    assert!(off[1] < 1e-6, "energy off by {:e}", off[1]);
}

/// Spin a symmetric top with a tilted axis in steady precession about the vertical, and return how far its axis is from
/// the exact one after so many turns, rad.
fn top(turns: usize, steps: usize) -> f64 {
    let (spin, tilt, length, g, mass) = (200.0, 0.4_f64, 0.3, 9.81, 2.0);
    let own = Vector3::new(0.02, 0.02, 0.03);
    let about_pivot = own.x + mass * length * length;
    // about_pivot cos(tilt) Ω² − I_3 spin Ω + m g l = 0, the slow root; spin is that about the axis in all.
    let (a, b, c) = (about_pivot * tilt.cos(), own.z * spin, mass * g * length);
    let precession = 2.0 * c / (b + (b * b - 4.0 * a * c).sqrt());
    let mut body = Body::new(BodyParameters {
        mass,
        inertia: Matrix3::from_diagonal(&own),
        centre: Vector3::new(0.0, 0.0, length),
        supports: [None, None, None, FREE, FREE, FREE],
        gravity: Vector3::new(0.0, 0.0, -g),
        position: Vector3::zeros(),
    });
    let axis = |t: f64| {
        let (sin, cos) = (precession * t).sin_cos();
        Vector3::new(tilt.sin() * cos, tilt.sin() * sin, tilt.cos())
    };
    // The part of omega along the axis is `spin`, that across is that of the precession.
    let vertical = Vector3::new(0.0, 0.0, precession);
    let omega = vertical + axis(0.0) * (spin - precession * tilt.cos());
    let orientation = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt);
    body.place(Placed { orientation, omega, ..body.state.now });
    let h = TAU / spin / steps as f64;
    run(&mut body, h, turns * steps);
    (body.state.now.orientation * Vector3::z()).angle(&axis(h * (turns * steps) as f64))
}

#[test]
fn a_spinning_top_precesses_for_a_hundred_turns_to_a_millionth() {
    let off = top(100, 400);
    assert!(off < 1e-6, "its axis is off by {off:e} rad");
}

#[test]
fn a_body_under_a_force_follows_to_second_order() {
    let end = |steps: usize| {
        let mut body = Body::new(BodyParameters { gravity: Vector3::new(0.0, 0.0, -9.81), ..parameters() });
        body.place(placed(&body, Vector3::new(0.3, -0.1, 0.2), Vector3::new(0.4, 2.0, 0.7)));
        let h = 1.0 / steps as f64;
        for _ in 0..steps {
            let mut load = Drag::<3>::default();
            // A damper at the pivot and one about it.
            let rates = body.reference(h).rates();
            for (i, rate) in rates.into_iter().enumerate() {
                load.impedance[i][i] = 0.8;
                if i < 3 { load.force.force[i] = -0.8 * rate } else { load.force.moment[i - 3] = -0.8 * rate }
            }
            body.step(h, &load, &NO_FLUID, &[0.0; 6]);
        }
        (body.state.now.position, body.state.now.orientation)
    };
    let [coarse, fine, finest] = [100, 200, 1600].map(end);
    let off = |end: (Vector3<f64>, UnitQuaternion<f64>)| (end.0 - finest.0).norm() + end.1.angle_to(&finest.1);
    let order = (off(coarse) / off(fine)).log2();
    assert!(off(coarse) < 2e-3 && order > 1.8, "off by {:e}, order {order}", off(coarse));
}

#[test]
fn a_body_on_springs_swings_at_its_frequencies() {
    let spring = |stiffness: f64| Some(Support { stiffness, damping: 0.0, rest: 0.0 });
    let supports = [spring(8.0), None, None, None, None, spring(4.8)];
    let mut body = Body::new(BodyParameters { centre: Vector3::zeros(), supports, ..parameters() });
    let start = Placed {
        position: body.state.now.position + Vector3::new(0.1, 0.0, 0.0),
        orientation: UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.1),
        ..body.state.now
    };
    body.place(start);
    // Both have the frequency 2 rad/s; half a period later they are on the other side.
    run(&mut body, TAU / 4.0 / 1000.0, 1000);
    let now = body.state.now.displacement(&Vector3::new(1.0, 2.0, 3.0));
    assert!((now.position.x + 0.1).abs() < 2e-5, "{} m against -0.1", now.position.x);
    assert!((now.angle.z + 0.1).abs() < 2e-5, "{} rad against -0.1", now.angle.z);
}
