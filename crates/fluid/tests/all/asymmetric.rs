//! Properties that hold without any symmetry: unequal cells, skew lines and surfaces that move and turn in oblique
//! streams, zones with a profile, markers in masks, starts at any time.

use std::f64::consts::TAU;
use std::sync::Arc;

use nervure_fluid::{
    Body, Extent, Flexible, Fluid, Force, Kinematics, Law, Motion, Outline, Parameters, Polyline, Shape, Solid,
    Solvable, Triangulation, Turn, Zone,
};
use scene::WingMesh;

fn made<const D: usize>(parameters: &Parameters<D>) -> Fluid<D>
where
    [f64; D]: Solvable<D>,
{
    Fluid::new(parameters).unwrap_or_else(|e| panic!("{e}"))
}

/// A box of unequal cells with a stream oblique to its axes, around flexible bodies.
fn beside<const D: usize>(flexible: Vec<Flexible<D>>) -> Parameters<D>
where
    [f64; D]: Solvable<D>,
{
    let ends = [[-0.6, 1.0], [-0.5, 0.7], [-0.4, 0.6]];
    let cells = [40, 36, 20];
    let first = |all: [f64; 3]| std::array::from_fn(|axis| all[axis]);
    let mut parameters =
        Parameters::new(std::array::from_fn(|axis| ends[axis]), std::array::from_fn(|axis| cells[axis]), 3.0, 0.02, H);
    parameters.initial_velocity = first([0.8, 0.3, -0.4]);
    parameters.flexible = flexible;
    parameters
}

/// Communication step, s.
const H: f64 = 2e-3;

fn flexible<const D: usize>(nodes: Vec<[f64; D]>, extent: Extent) -> Flexible<D> {
    Flexible { name: "the body".into(), nodes, extent, pivot: None }
}

/// A skew line of 21 nodes.
fn line<const D: usize>(from: [f64; D], to: [f64; D]) -> Flexible<D> {
    let at = |k: usize| std::array::from_fn(|axis| from[axis] + (to[axis] - from[axis]) * k as f64 / 20.0);
    flexible((0..=20).map(at).collect(), Extent::Line { free: [true; 2] })
}

/// A skew sheet, 0.8 m x 0.4 m.
fn sheet() -> Flexible<3> {
    let mesh = WingMesh::Rectangular { length: 0.8, width: 0.4, along: 6 }.build();
    let place = |[x, y, _]: &[f64; 3]| [0.9 * x - 0.3, 0.6 * y + 0.3 * x, 0.75 * y - 0.3 * x + 0.1];
    flexible(mesh.nodes.iter().map(place).collect(), Extent::Surface(mesh.triangles))
}

/// Make a step in which all nodes move with an affine motion that swings in time.
fn swing<const D: usize>(fluid: &mut Fluid<D>, rest: &[Vec<[f64; D]>])
where
    [f64; D]: Solvable<D>,
{
    let t = fluid.time();
    for (stations, rest) in fluid.stations_mut().iter_mut().zip(rest) {
        for (k, x) in rest.iter().enumerate() {
            let [a, b] = [x[0], x[1]];
            let c = x.get(2).copied().unwrap_or(0.0);
            let way = [0.3 - 1.5 * b + 0.4 * c, -0.2 + 1.5 * a - 0.3 * c, 0.1 + 0.5 * a + 0.7 * b];
            for axis in 0..D {
                stations.position[axis][k] = x[axis] + way[axis] * (4.0 * (t + H)).sin() / 4.0;
                stations.velocity[axis][k] = way[axis] * (4.0 * (t + H)).cos();
            }
        }
    }
    fluid.advance(t, H).unwrap_or_else(|e| panic!("{e}"));
}

fn swung<const D: usize>(parameters: &Parameters<D>, steps: usize) -> Fluid<D>
where
    [f64; D]: Solvable<D>,
{
    let rest: Vec<_> = parameters.flexible.iter().map(|body| body.nodes.clone()).collect();
    let mut fluid = made(parameters);
    (0..steps).for_each(|_| swing(&mut fluid, &rest));
    fluid
}

/// Return a moment about each axis.
fn moment<const D: usize>(force: &Force<D>) -> [f64; 3]
where
    [f64; D]: Solvable<D>,
{
    let about = <[f64; D]>::components(force.moment);
    if D == 2 { [0.0, 0.0, about[0]] } else { about }
}

fn cross<const D: usize>(a: [f64; D], b: [f64; D]) -> [f64; 3] {
    let part = |v: [f64; D], axis: usize| v.get(axis).copied().unwrap_or(0.0);
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| part(a, i) * part(b, j) - part(a, j) * part(b, i))
}

/// The largest difference of numbers by the largest number.
fn off(found: impl IntoIterator<Item = f64>, expected: impl IntoIterator<Item = f64>) -> f64 {
    let pairs = found.into_iter().zip(expected);
    let (most, scale) =
        pairs.fold((0.0_f64, 0.0_f64), |(most, scale), (a, b)| (most.max((a - b).abs()), scale.max(b.abs())));
    most / scale
}

/// Check a body with one whose nodes are numbered from the other end: forces, power and loads are the same. Moments,
/// which are taken about the first node, differ by that of the force; of the rate of the displaced momentum in the
/// middle of the step.
fn check_from_the_other_end<const D: usize>(body: Flexible<D>)
where
    [f64; D]: Solvable<D>,
{
    let last = body.nodes.len() - 1;
    let mut other = body.clone();
    other.nodes.reverse();
    if let Extent::Surface(triangles) = &mut other.extent {
        triangles.iter_mut().flatten().for_each(|node| *node = last - *node);
    }
    let parameters = [beside(vec![body]), beside(vec![other])];
    let before = swung(&parameters[0], 7).stations()[0].clone();
    let [one, other] = parameters.each_ref().map(|parameters| swung(parameters, 8));
    let reversed = |list: &[f64]| list.iter().rev().copied().collect::<Vec<_>>();
    let (own, its) = (&one.loads()[0], &other.loads()[0]);
    for axis in 0..D {
        let off = off(reversed(&its.force[axis]), own.force[axis].iter().copied());
        assert!(off < 1e-8, "loads along {axis} are off by {off}");
    }
    let off_impedance = off(reversed(&its.impedance), own.impedance.iter().copied());
    assert!(off_impedance < 1e-8, "impedances are off by {off_impedance}");
    let (drag, work) = (one.exchange()[0], other.exchange()[0]);
    let (force, its_force) = (one.force_on_flexible(0), other.force_on_flexible(0));
    assert!(off(its_force.force.iter().copied(), force.force.iter().copied()) < 1e-8, "{its_force:?}, not {force:?}");
    assert!(off([work.power, work.work], [drag.power, drag.work]) < 1e-8, "{work:?} is not {drag:?}");
    let arm = |stations: &nervure_fluid::Stations<D>| stations.position.each_ref().map(|along| along[last] - along[0]);
    let (end, begin) = (arm(&one.stations()[0]), arm(&before));
    let middle: [f64; D] = std::array::from_fn(|axis| 0.5 * (end[axis] + begin[axis]));
    let unsteady: [f64; D] = std::array::from_fn(|axis| force.force[axis] - drag.force[axis]);
    let expected: Vec<_> = cross(end, drag.force).iter().zip(cross(middle, unsteady)).map(|(a, b)| a + b).collect();
    let found = moment(&force).into_iter().zip(moment(&its_force)).map(|(own, its)| own - its);
    let scale = cross(middle, unsteady).iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    for (found, expected) in found.zip(expected) {
        assert!((found - expected).abs() < 1e-2 * scale, "the moments differ by {found}, not {expected}");
    }
}

#[test]
fn a_body_whose_nodes_are_numbered_from_the_other_end_is_the_same_body() {
    check_from_the_other_end(line([-0.3, -0.2], [0.2, 0.1]));
    check_from_the_other_end(line([-0.3, -0.2, 0.1], [0.2, 0.1, 0.3]));
    check_from_the_other_end(sheet());
}

/// Jump and shear of a straight line, which moves, turns and stretches along itself, add up to its force across and
/// along, with that of the fluid that it accelerates.
#[test]
fn stresses_on_a_straight_line_add_up_to_its_force() {
    let mut fluid = swung(&beside(vec![line([-0.3, -0.2], [0.2, 0.1])]), 8);
    let stations = &fluid.stations()[0];
    let along = stations.position.each_ref().map(|x| x[20] - x[0]);
    let length = along[0].hypot(along[1]);
    let [x, y] = along.map(|part| part / length);
    let Force { force, .. } = fluid.force_on_flexible(0);
    let step = 0.5_f64.hypot(0.3) / 20.0;
    let sum = |stress: &[f64]| stress.windows(2).map(|ends| 0.5 * (ends[0] + ends[1]) * step).sum::<f64>();
    let found = [sum(&fluid.pressure_jump()[0].clone()), sum(&fluid.shear()[0][0])];
    let expected = [force[0] * y - force[1] * x, force[0] * x + force[1] * y];
    for (what, found, expected) in [("jump", found[0], expected[0]), ("shear", found[1], expected[1])] {
        assert!((found - expected).abs() < 1e-9 * force.norm(), "the {what} adds up to {found}, not {expected}");
    }
}

/// Check that the sum of the loads on stations that then keep their velocities is the drag of the next step, in an
/// inflow with a parabola and in a still body, also where that step is the first of half the length.
fn check_announced<const D: usize>(mut parameters: Parameters<D>)
where
    [f64; D]: Solvable<D>,
{
    parameters.max_step = 1.0;
    let (longest, _) = check_steps(&parameters);
    parameters.max_cfl *= 0.999 * H / longest;
    let (_, end) = check_steps(&parameters);
    assert!((end - 5.5 * H).abs() < 1e-9, "the last step alone is half as long: {end} s");
}

/// Check the same of six steps, and return the longest that could be the last, and the end, s.
fn check_steps<const D: usize>(parameters: &Parameters<D>) -> (f64, f64)
where
    [f64; D]: Solvable<D>,
{
    let mut fluid = made(parameters);
    let velocity = |k: usize, axis: usize| 0.3 * (1.3 * k as f64 + 2.0 * axis as f64).sin();
    let (mut announced, mut longest) = (Vec::new(), H);
    for _ in 0..6 {
        announced = fluid.loads().to_vec();
        let h = H / (H / fluid.longest_step()).ceil();
        longest = fluid.longest_step();
        for stations in fluid.stations_mut() {
            for (axis, along) in stations.velocity.iter_mut().enumerate() {
                along.iter_mut().enumerate().for_each(|(k, own)| *own = velocity(k, axis));
            }
            for (position, velocity) in stations.position.iter_mut().zip(&stations.velocity) {
                position.iter_mut().zip(velocity).for_each(|(x, v)| *x += h * v);
            }
        }
        let t = fluid.time();
        fluid.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
    }
    for (announced, found) in announced.iter().zip(fluid.exchange()) {
        let sums = announced.force.each_ref().map(|along| along.iter().sum::<f64>());
        assert!(announced.impedance.iter().all(|impedance| *impedance > 0.0), "{:?}", announced.impedance);
        let off = off(sums, found.force);
        assert!(off < 1e-9, "{sums:?} N is announced, but {:?} N comes", found.force);
    }
    (longest, fluid.time())
}

/// Put a zone with a parabola between walls in front of the bodies.
fn with_inflow<const D: usize>(mut parameters: Parameters<D>, body: Body<D>) -> Parameters<D>
where
    [f64; D]: Solvable<D>,
{
    parameters.walls[1] = Some([-0.45, 0.6]);
    let mean_velocity = Law::new(|t| (1.0 + 20.0 * t, 20.0));
    parameters.inflow = Some(Zone { x: [-0.6, -0.1], parabolic: true, mean_velocity, c_eta: 1e-3 });
    parameters.bodies = vec![body];
    parameters
}

#[test]
fn announced_loads_come_true_in_zones_with_a_profile_and_in_masks() {
    let disk = Body::still("the disk", Outline::Circle(0.15), [0.2, 0.1]);
    check_announced(with_inflow(beside(vec![line([-0.3, -0.3], [0.2, 0.1])]), disk));
    let ball = Body::still("the ball", Solid::Sphere(0.15), [0.2, 0.1, 0.1]);
    check_announced(with_inflow(beside(vec![line([-0.3, -0.3, 0.3], [0.2, 0.1, 0.1]), sheet()]), ball));
}

/// A law with its time shifted by `by` seconds.
fn law(by: f64, size: f64, frequency: f64) -> Law {
    Law::new(move |t| {
        let (sin, cos) = (TAU * frequency * (t + by) + 0.3).sin_cos();
        (size * sin, size * TAU * frequency * cos)
    })
}

/// Check that a flow that starts at 0.37 s is that of all laws 0.37 s earlier, from the first step on. `bodies` makes
/// bodies whose laws are shifted by a time.
fn check_start<const D: usize>(parameters: &Parameters<D>, bodies: impl Fn(f64) -> Vec<Body<D>>)
where
    [f64; D]: Solvable<D>,
{
    let mut fluids = [0.37, 0.0].map(|by| {
        let mut own = parameters.clone();
        let mean_velocity = law(by, 1.0, 2.0);
        own.inflow = Some(Zone { x: [-0.6, -0.4], parabolic: false, mean_velocity, c_eta: 1e-3 });
        own.bodies = bodies(by);
        made(&own)
    });
    fluids[1].start_at(0.37);
    let numbers = |fluid: &Fluid<D>| {
        let mut all = vec![fluid.kinetic_energy()];
        for body in 0..parameters.bodies.len() {
            let (pose, force) = (fluid.pose(body), fluid.force_on_body(body));
            all.extend(pose.position.iter().chain(&pose.velocity).chain(&force.force).copied());
            all.extend(moment(&force));
        }
        all
    };
    for step in 0..4 {
        let [expected, found] = fluids.each_ref().map(numbers);
        for (found, expected) in found.iter().zip(&expected) {
            let close = (found - expected).abs() < 1e-9 * expected.abs().max(1.0);
            assert!(close, "after {step} steps {found} in place of {expected}");
        }
        for fluid in &mut fluids {
            let t = fluid.time();
            fluid.advance(t, H).unwrap_or_else(|e| panic!("{e}"));
        }
    }
}

#[test]
fn a_start_at_another_time_is_that_of_earlier_laws() {
    let in_plane = |by| {
        let moving = |shape: Arc<dyn Shape<2>>, position| Body {
            pivot: [0.03, -0.02],
            motion: Some(Motion::laws([law(by, 0.05, 1.0), law(by, 0.1, 0.5)], 1.0, law(by, 0.8, 0.7))),
            ..Body { shape, ..Body::still("", Outline::Circle(1.0), position) }
        };
        let plate = Polyline(vec![[-0.2, 0.0], [0.2, 0.0]]);
        vec![moving(Arc::new(Outline::Ellipse([0.2, 0.1])), [0.3, 0.2]), moving(Arc::new(plate), [0.5, -0.2])]
    };
    check_start(&Parameters { bodies: in_plane(0.0), ..beside(vec![]) }, in_plane);
    let in_space = |by| {
        let moving = |shape: Arc<dyn Shape<3>>, position| Body {
            pivot: [0.03, -0.02, 0.05],
            turn: Turn { axis: [1.0, 2.0, -1.0], angle: 0.4 },
            motion: Some(Motion::laws(
                [law(by, 0.05, 1.0), law(by, 0.1, 0.5), law(by, 0.04, 0.8)],
                [2.0, -1.0, 1.0].into(),
                law(by, 0.8, 0.7),
            )),
            ..Body { shape, ..Body::still("", Solid::Sphere(1.0), position) }
        };
        let mesh = WingMesh::Rectangular { length: 0.4, width: 0.3, along: 3 }.build();
        let cylinder = Solid::Cylinder { axis: 1, radius: 0.12, half_length: 0.3 };
        let plate = Triangulation(mesh.nodes, mesh.triangles);
        vec![moving(Arc::new(cylinder), [0.3, 0.2, 0.1]), moving(Arc::new(plate), [0.5, -0.2, 0.0])]
    };
    check_start(&Parameters { bodies: in_space(0.0), ..beside(vec![]) }, in_space);
}
