//! Rigid surfaces in space: exact drag in slow flow, turns and moments, and the same plate moved from outside.

use std::f64::consts::PI;

use nervure_fluid::{Error, Extent, Flexible, Law, Mask, Motion, Pose, Precision, Shape, Solid, Triangulation, Turn};

type Body = nervure_fluid::Body<3>;
type Fluid = nervure_fluid::Fluid<3>;
type Parameters = nervure_fluid::Parameters<3>;

fn made(parameters: &Parameters) -> Fluid {
    Fluid::new(parameters).unwrap_or_else(|e| panic!("{e}"))
}

fn run(fluid: &mut Fluid, steps: usize, h: f64) {
    for _ in 0..steps {
        let t = fluid.time();
        fluid.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
    }
}

/// A disk across y.
fn disk(radius: f64) -> Triangulation {
    let (nodes, triangles) = scene::Shape::Disk { radius }.surface().expect("it is a surface");
    Triangulation(nodes, triangles)
}

/// A plate across y, with lengths along x and z.
fn plate(length: f64, width: f64) -> Triangulation {
    let (nodes, triangles) = scene::Shape::Plate { length, width: Some(width) }.surface().expect("it is a surface");
    Triangulation(nodes, triangles)
}

fn still(shape: impl Shape<3> + 'static, turn: Turn) -> Body {
    Body { turn, ..Body::still("the body", shape, [0.01, 0.02, -0.015]) }
}

fn about_z(angle: f64) -> Turn {
    Turn { axis: [0.0, 0.0, 1.0], angle }
}

fn stream(speed: [f64; 3], nu: f64, cells: usize) -> Parameters {
    let mut parameters = Parameters::new([[-0.5, 0.5]; 3], [cells; 3], 2.0, nu, 2e-3);
    (parameters.initial_velocity, parameters.mean_flow) = (speed, Some(speed.map(Law::constant)));
    parameters
}

/// A disk of radius a drags with 16 mu a U across a slow stream and with 32/3 mu a U along it (Happel & Brenner, Low
/// Reynolds Number Hydrodynamics, 5-8); in a cubic lattice of period L a body whose drag is that of a sphere of radius
/// b drags 1/(1 − 2.837 b/L + 4.19 (b/L)³) times as much (Hasimoto 1959). Errors are of first order.
#[test]
fn a_disk_has_its_drag_in_a_slow_stream() {
    let radius = 0.16;
    for (angle, alone) in [(0.5 * PI, 16.0), (0.0, 32.0 / 3.0)] {
        let b = alone * radius / (6.0 * PI);
        let expected = 2.0 * 1e-4 * alone * radius / (1.0 - 2.837 * b + 4.19 * b.powi(3));
        let [coarse, fine] = [32, 64].map(|cells| {
            let mut parameters = stream([1e-4, 0.0, 0.0], 1.0, cells);
            (parameters.bodies, parameters.mask) = (vec![still(disk(radius), about_z(angle))], Mask::log_linear(1e-8));
            let mut fluid = made(&parameters);
            run(&mut fluid, 60, 2e-3);
            let force = fluid.force_on_body(0).force;
            assert!(force[1].abs().max(force[2].abs()) < 0.003 * force[0], "{force:?}");
            force[0] / expected - 1.0
        });
        println!("{angle:.2}: {coarse:+.4}, {fine:+.4}, limit {:+.4}", 2.0 * fine - coarse);
        assert!(fine.abs() < 0.05 && (2.0 * fine - coarse).abs() < 0.04, "{angle}: {coarse}, {fine}");
    }
}

/// Forces and moments turn with the body and the stream, and a moment about another pivot has the arm of the force.
#[test]
fn forces_and_moments_turn_with_the_plate_and_the_stream() {
    let force = |speed: [f64; 3], pivot: [f64; 3], turned: bool| {
        let mut parameters = stream(speed, 1e-2, 24);
        // The axes x, y and z go to y, z and x.
        let third = || Law::constant(2.0 * PI / 3.0);
        let motion = turned.then(|| Motion::laws([0.0; 3].map(Law::constant), [1.0; 3].into(), third()));
        let (sin, cos) = (-0.5_f64).sin_cos();
        let at = [cos * pivot[0], sin * pivot[0], pivot[2]];
        let at = if turned { [at[2], at[0], at[1]] } else { at };
        parameters.bodies = vec![Body { position: at, pivot, motion, ..still(plate(0.4, 0.5), about_z(-0.5)) }];
        let mut fluid = made(&parameters);
        run(&mut fluid, 12, 2e-3);
        fluid.force_on_body(0)
    };
    let (one, edge) = (force([0.8, 0.0, 0.3], [0.0; 3], false), [-0.2, 0.0, 0.1]);
    assert!(one.force[1] > 0.1 * one.force[0] && one.moment[2] < 0.0, "lift and a nose that rises: {one:?}");
    let turned = force([0.3, 0.8, 0.0], [0.0; 3], true);
    let about_edge = force([0.8, 0.0, 0.3], edge, false);
    let (sin, cos) = (-0.5_f64).sin_cos();
    let arm = [-cos * edge[0], -sin * edge[0], -edge[2]];
    for axis in 0..3 {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let size = one.force[0].abs();
        assert!((turned.force[next] - one.force[axis]).abs() < 1e-9 * size, "{axis}: {turned:?} against {one:?}");
        assert!((turned.moment[next] - one.moment[axis]).abs() < 1e-9 * size, "{axis}: {turned:?} against {one:?}");
        assert!((about_edge.force[axis] - one.force[axis]).abs() < 1e-9 * size, "{axis}: {about_edge:?}");
        let expected = one.moment[axis] + arm[next] * one.force[last] - arm[last] * one.force[next];
        assert!((about_edge.moment[axis] - expected).abs() < 1e-9 * size, "{axis}: {about_edge:?} against {expected}");
    }
}

const OMEGA: f64 = 6.0;

/// The plate that moves by laws.
fn flapping() -> Body {
    let sine = |a: f64| Law::new(move |t: f64| (a * (OMEGA * t).sin(), a * OMEGA * (OMEGA * t).cos()));
    let displacement = [Law::constant(0.0), sine(0.1), Law::constant(0.0)];
    let motion = Motion::laws(displacement, [0.0, 0.0, 2.0].into(), sine(0.6));
    Body { position: [0.0; 3], motion: Some(motion), ..still(plate(0.4, 0.5), about_z(0.0)) }
}

/// In a motion that heaves, turns and advances, force and moment of a wing's nodes are those of the rigid plate.
#[test]
fn a_flexible_surface_in_rigid_motion_has_the_force_of_the_rigid_plate() {
    let (h, pivot) = (2e-3, [0.0; 3]);
    let Triangulation(nodes, triangles) = plate(0.4, 0.5);
    let mut by_laws = stream([0.5, 0.0, 0.0], 1e-2, 24);
    let mut by_nodes = by_laws.clone();
    let sine = |a: f64| Law::new(move |t: f64| (a * (OMEGA * t).sin(), a * OMEGA * (OMEGA * t).cos()));
    let displacement = [Law::new(|t: f64| (-t, -1.0)), sine(0.1), Law::constant(0.0)];
    let motion = Some(Motion::laws(displacement, [0.0, 0.0, 2.0].into(), sine(0.6)));
    by_laws.bodies = vec![Body { position: pivot, motion, ..still(plate(0.4, 0.5), about_z(0.0)) }];
    let extent = Extent::Surface(triangles);
    by_nodes.flexible = vec![Flexible { name: "the wing".into(), nodes: nodes.clone(), extent, pivot: Some(pivot) }];
    let (mut by_laws, mut by_nodes) = (made(&by_laws), made(&by_nodes));
    let [mut off, mut size] = [[0.0; 2]; 2];
    for step in 0..60 {
        let t = h * f64::from(step + 1);
        let (sin, cos) = (OMEGA * t).sin_cos();
        let ((s, c), omega, place) = ((0.6 * sin).sin_cos(), 0.6 * OMEGA * cos, [-t, 0.1 * sin, 0.0]);
        let stations = &mut by_nodes.stations_mut()[0];
        for (k, [x, y, z]) in nodes.iter().enumerate() {
            let arm = [c * x - s * y, s * x + c * y, *z];
            let velocity = [-1.0 - omega * arm[1], 0.1 * OMEGA * cos + omega * arm[0], 0.0];
            for axis in 0..3 {
                stations.position[axis][k] = place[axis] + arm[axis];
                stations.velocity[axis][k] = velocity[axis];
            }
        }
        [&mut by_laws, &mut by_nodes].into_iter().for_each(|fluid| run(fluid, 1, h));
        let (rigid, wing) = (by_laws.force_on_body(0), by_nodes.force_on_flexible(0));
        // A body has moments about its moving pivot.
        let moment = rigid.moment[2] + place[0] * rigid.force[1] - place[1] * rigid.force[0];
        if step > 5 {
            for (k, (a, b)) in [(rigid.force[1], wing.force[1]), (moment, wing.moment[2])].into_iter().enumerate() {
                (off[k], size[k]) = (off[k] + (a - b).powi(2), size[k] + a * a);
            }
        }
    }
    let found: [f64; 2] = std::array::from_fn(|k| (off[k] / size[k]).sqrt());
    assert!(found[0] < 0.01 && found[1] < 0.01, "force and moment are {found:?} off");
}

/// A plate that moves by laws takes the force of the same plate that the master moves.
#[test]
fn a_plate_that_laws_move_is_that_which_the_master_moves() {
    let mut by_laws = stream([0.5, 0.0, 0.0], 1e-2, 24);
    let mut by_master = by_laws.clone();
    by_laws.bodies = vec![flapping()];
    by_master.bodies = vec![Body { motion: Some(Motion::Master), ..flapping() }];
    let (mut by_laws, mut by_master) = (made(&by_laws), made(&by_master));
    for step in 0..20 {
        let (sin, cos) = (OMEGA * 2e-3 * f64::from(step + 1)).sin_cos();
        *by_master.displacement_mut(0) = Pose {
            position: [0.0, 0.1 * sin, 0.0].into(),
            angle: [0.0, 0.0, 0.6 * sin].into(),
            velocity: [0.0, 0.1 * OMEGA * cos, 0.0].into(),
            omega: [0.0, 0.0, 0.6 * OMEGA * cos].into(),
        };
        [&mut by_laws, &mut by_master].into_iter().for_each(|fluid| run(fluid, 1, 2e-3));
        let [found, expected] = [&by_laws, &by_master].map(|fluid| fluid.force_on_body(0));
        // The first step differs: what the master moves is at rest at t = 0.
        let off = (found.force - expected.force).norm() + (found.moment - expected.moment).norm();
        assert!(step == 0 || off < 1e-9 * expected.force.norm().max(1e-2), "{step}: {found:?} against {expected:?}");
    }
    let (force, pose) = (by_laws.force_on_body(0), by_laws.pose(0));
    let (found, expected) = (by_laws.power_on_body(0), force.force.dot(&pose.velocity) + force.moment.dot(&pose.omega));
    assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} against {expected}");
}

/// Threads, saved states and cells of a solid beside it change no bit, and a step allocates nothing.
#[test]
fn threads_and_states_of_a_moving_plate_change_no_bit() {
    for precision in [Precision::Double, Precision::Single] {
        let parameters = |threads: usize| {
            let mut parameters = stream([0.5, 0.0, 0.0], 1e-2, 24);
            let ball = Body { position: [0.3, 0.2, 0.0], ..still(Solid::Sphere(0.1), about_z(0.0)) };
            parameters.bodies = vec![flapping(), ball, still(disk(0.2), about_z(1.0))];
            (parameters.precision, parameters.threads) = (precision, threads);
            parameters
        };
        let result = |fluid: &Fluid| ([0, 1, 2].map(|k| fluid.force_on_body(k)), fluid.velocity(1).into_owned());
        let (mut one, mut two) = (made(&parameters(1)), made(&parameters(2)));
        [&mut one, &mut two].into_iter().for_each(|fluid| run(fluid, 5, 2e-3));
        let state = one.state();
        [&mut one, &mut two].into_iter().for_each(|fluid| run(fluid, 5, 2e-3));
        let first = result(&one);
        assert!(first == result(&two), "threads");
        one.restore(&state).unwrap_or_else(|e| panic!("{e}"));
        run(&mut one, 5, 2e-3);
        assert!(first == result(&one), "state");
        assert!(first.0.iter().all(|force| force.force[1] != 0.0 && force.moment[2] != 0.0), "{:?}", first.0);
        let counted = allocation_counter::measure(|| run(&mut one, 3, 2e-3));
        assert_eq!(counted.count_total, 0, "{counted:?}");
    }
}

#[test]
fn a_surface_without_triangles_or_with_too_many_markers_is_refused() {
    for shape in
        [Triangulation(vec![[0.0; 3]], vec![]), Triangulation(vec![[0.0; 3]; 3], vec![[0, 1, 3]]), plate(1e5, 1.0)]
    {
        let mut parameters = stream([0.0; 3], 1.0, 16);
        parameters.bodies = vec![still(shape, about_z(0.0))];
        let refused = Fluid::new(&parameters).err().expect("it is refused");
        assert!(
            matches!(refused, Error::Parameter { name, .. } if name.starts_with("extent of a thin body")),
            "{refused}"
        );
    }
}
