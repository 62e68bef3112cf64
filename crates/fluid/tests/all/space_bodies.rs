//! Bodies in three dimensions: the agreement with two dimensions, exact forces in Stokes layers, and symmetries.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use nervure_fluid::{
    Extent, Filter, Flexible, Fluid, Law, Motion, Mount, Outline, Precision, Shape, Solid, Support, Turn, Zone,
};
use rustfft::num_complex::Complex64;
use scene::{Scene, WingMesh};

type Body = nervure_fluid::Body<3>;
type Parameters = nervure_fluid::Parameters<3>;

const LINE: Extent = Extent::Line { free: [true; 2] };

fn sine(amplitude: f64, frequency: f64) -> Law {
    let omega = TAU * frequency;
    Law::new(move |t| (amplitude * (omega * t).sin(), amplitude * omega * (omega * t).cos()))
}

fn made(parameters: &Parameters) -> Fluid<3> {
    Fluid::<3>::new(parameters).unwrap_or_else(|e| panic!("{e}"))
}

fn still(shape: impl Shape<3> + 'static, position: [f64; 3]) -> Body {
    Body::still("the body", shape, position)
}

/// A cylinder along z in a channel with inflow and sponge, which turns about a line beside its axis while it moves, has
/// the flow, the force and the moment of a circle in two dimensions.
#[test]
fn a_long_cylinder_is_a_circle_in_two_dimensions() {
    let (domain, cells, depth) = ([[-0.4, 1.2], [-0.1, 0.5]], [64, 24], 0.2);
    let zone = |x: [f64; 2], parabolic: bool, c_eta: f64| {
        Some(Zone { x, parabolic, mean_velocity: Law::constant(1.0), c_eta })
    };
    let mut flat = nervure_fluid::Parameters::new(domain, cells, 3.0, 2e-3, 0.01);
    let mut deep = Parameters::new([domain[0], domain[1], [0.0, depth]], [64, 24, 8], 3.0, 2e-3, 0.01);
    flat.walls[1] = Some([0.0, 0.41]);
    deep.walls[1] = flat.walls[1];
    (flat.inflow, flat.sponge) = (zone([-0.4, -0.2], true, 1e-3), zone([0.9, 1.2], false, 0.2));
    (deep.inflow, deep.sponge) = (flat.inflow.clone(), flat.sponge.clone());
    (flat.initial_velocity, deep.initial_velocity) = ([1.0, 0.0], [1.0, 0.0, 0.0]);
    let (x, y, angle) = (sine(0.02, 2.0), sine(0.03, 1.0), sine(0.5, 1.5));
    flat.bodies = vec![nervure_fluid::Body {
        pivot: [0.03, -0.02],
        turn: 0.3,
        motion: Some(Motion::laws([x.clone(), y.clone()], 1.0, angle.clone())),
        // Of a circle two dimensions keep the whole square around it.
        ..nervure_fluid::Body::still("the cylinder", Outline::Ellipse([0.08, 0.08]), [0.2, 0.2])
    }];
    let round = Solid::Cylinder { axis: 2, radius: 0.08, half_length: f64::INFINITY };
    deep.bodies = vec![Body {
        pivot: [0.03, -0.02, 0.0],
        turn: Turn { axis: [0.0, 0.0, 2.0], angle: 0.3 },
        motion: Some(Motion::laws([x, y, Law::constant(0.0)], [0.0, 0.0, 5.0].into(), angle)),
        ..still(round, [0.2, 0.2, 0.07])
    }];
    // The smooth filter cuts more waves off in space.
    (flat.filter, deep.filter) = (Filter::TwoThirds, Filter::TwoThirds);
    let mut flat = Fluid::new(&flat).unwrap_or_else(|e| panic!("{e}"));
    let mut deep = made(&deep);
    for step in 0..12 {
        let t = flat.time();
        flat.advance(t, 0.01).and_then(|()| deep.advance(t, 0.01)).unwrap_or_else(|e| panic!("{step}: {e}"));
    }
    let (one, other) = (flat.force_on_body(0), deep.force_on_body(0));
    let scale = depth * one.force[0].abs();
    assert!(scale > 1e-3 && one.moment.abs() > 1e-3, "{one:?}");
    for axis in 0..2 {
        let difference = other.force[axis] - depth * one.force[axis];
        assert!(difference.abs() < 1e-9 * scale, "force {axis}: {} beside {one:?}", other.force[axis]);
    }
    let difference = other.moment[2] - depth * one.moment;
    assert!(difference.abs() < 1e-9 * scale, "moment: {other:?} beside {one:?}");
    assert!((deep.power_on_body(0) - depth * flat.power_on_body(0)).abs() < 1e-9 * scale);
    let (u, v) = (flat.velocity(1), deep.velocity(1));
    let largest = (0..v.len()).map(|c| (v[c] - u[c / 8]).abs()).fold(0.0, f64::max);
    assert!(largest < 1e-9, "{largest} m/s");
}

/// A cylinder along z on springs and dampers, held beside its axis in a stream, moves and turns as a circle on springs in
/// the plane; also with the box, the stream and the springs turned so that it lies along another axis.
#[test]
fn a_long_cylinder_on_springs_is_a_circle_on_springs() {
    let (cells, depth, h) = (32, 0.25, 0.01);
    let [stiff, soft, twist] = [[40.0, 0.5], [10.0, 0.2], [0.3, 0.004]].map(|[stiffness, damping]| {
        let rest = 0.02;
        move |depth: f64| Some(Support { stiffness: depth * stiffness, damping: depth * damping, rest })
    });
    let mut flat = nervure_fluid::Parameters::new([[0.0, 1.0]; 2], [cells; 2], 3.0, 2e-3, h);
    (flat.initial_velocity, flat.filter) = ([0.6, 0.2], Filter::TwoThirds);
    let supports = [stiff(1.0), soft(1.0), twist(1.0), None, None, None];
    let mount = Mount { mass: 0.15, inertia: 2e-3, supports, gravity: [0.3, -0.2] };
    flat.bodies = vec![nervure_fluid::Body {
        pivot: [0.03, -0.02],
        motion: Some(Motion::Mount(mount)),
        ..nervure_fluid::Body::still("the cylinder", Outline::Ellipse([0.1, 0.1]), [0.45, 0.5])
    }];
    for turn in 0..3 {
        let mut fresh = Fluid::new(&flat).unwrap_or_else(|e| panic!("{e}"));
        // x, y and z of the plane go to the axes turn, turn + 1 and turn + 2.
        let place = |own: [f64; 3]| {
            let mut all = [0.0; 3];
            (0..3).for_each(|axis| all[(axis + turn) % 3] = own[axis]);
            all
        };
        let (mut ends, mut points) = ([[0.0, 1.0]; 3], [cells; 3]);
        (ends[(turn + 2) % 3], points[(turn + 2) % 3]) = ([0.0, depth], 8);
        let mut deep = Parameters::new(ends, points, 3.0, 2e-3, h);
        (deep.initial_velocity, deep.filter) = (place([0.6, 0.2, 0.0]), Filter::TwoThirds);
        let mut supports = [None; 6];
        for (axis, own) in [stiff(depth), soft(depth), None].into_iter().enumerate() {
            supports[(axis + turn) % 3] = own;
        }
        supports[3 + (turn + 2) % 3] = twist(depth);
        let inertia = Matrix3::from_diagonal(&place([1.0, 1.0, depth * 2e-3]).into());
        let mount = Mount { mass: depth * 0.15, inertia, supports, gravity: place([0.3, -0.2, 0.0]) };
        let along = (turn + 2) % 3;
        deep.bodies = vec![Body {
            pivot: place([0.03, -0.02, 0.0]),
            motion: Some(Motion::Mount(mount)),
            ..still(Solid::Cylinder { axis: along, radius: 0.1, half_length: f64::INFINITY }, place([0.45, 0.5, 0.1]))
        }];
        let mut deep = made(&deep);
        for step in 0..60 {
            let t = h * f64::from(step);
            fresh.advance(t, h).and_then(|()| deep.advance(t, h)).unwrap_or_else(|e| panic!("{turn}, {step}: {e}"));
        }
        let (one, other) = (fresh.pose(0), deep.pose(0));
        let found: Vec<f64> = (0..2).map(|axis| other.position[(axis + turn) % 3]).collect();
        assert!((one.position[1] - 0.5).abs() > 1e-3 && one.angle.abs() > 1e-3, "it moves: {one:?}");
        for (axis, found) in found.iter().enumerate() {
            assert!((found - one.position[axis]).abs() < 1e-9, "{turn}: {other:?} beside {one:?}");
        }
        assert!((other.angle[along] - one.angle).abs() < 1e-8, "{turn}: {other:?} beside {one:?}");
        assert!((other.omega[along] - one.omega).abs() < 1e-7, "{turn}: {other:?} beside {one:?}");
    }
}

/// Length of the periodic box around a sphere of the diameter 1, m.
const BOX: f64 = 3.2;

/// Return the mass that the sphere displaces in a fluid of the density 1, and the one that it takes along, half of the
/// former by `(1 + 2q)/(1 − q)` for the images of the sphere, which fills the share q of the box.
fn masses() -> (f64, f64) {
    let (displaced, share) = (PI / 6.0, PI / 6.0 / BOX.powi(3));
    (displaced, 0.5 * displaced * (1.0 + 2.0 * share) / (1.0 - share))
}

/// The sphere on a support along y in fluid of the viscosity `nu`, at rest.
fn sphere(mass: f64, support: Support, gravity: f64, nu: f64) -> Fluid<3> {
    let mut parameters = Parameters::new([[-0.5 * BOX, 0.5 * BOX]; 3], [32; 3], 1.0, nu, 0.04);
    parameters.mean_flow = Some([0, 1, 2].map(|_| Law::constant(0.0)));
    let supports = [None, Some(support), None, None, None, None];
    let mount = Mount { mass, inertia: Matrix3::identity(), supports, gravity: [0.0, -gravity, 0.0] };
    let body = still(Solid::Sphere(0.5), [0.01, 0.02, 0.03]);
    parameters.bodies = vec![Body { motion: Some(Motion::Mount(mount)), ..body }];
    made(&parameters)
}

/// Period and damping of a sphere on a spring in still fluid are those of Stokes (1851): at the complex rate s the force
/// is `−(m s + 6 pi mu R (1 + R √(s/nu))) v` with the mass m that it takes along.
#[test]
fn a_sphere_on_a_spring_has_period_and_damping_of_stokes() {
    let ((displaced, added), nu, h) = (masses(), 0.04, 0.04);
    let mass = 2.0 * displaced;
    let stiffness = (TAU / 4.0_f64).powi(2) * (mass + added);
    let mut rate = Complex64::new(0.0, TAU / 4.0);
    for _ in 0..100 {
        let drag = 3.0 * PI * nu * (1.0 + 0.5 * (rate / nu).sqrt());
        rate = Complex64::i() * (stiffness / (mass + added + drag / rate)).sqrt();
    }
    let (period, expected) = (TAU / rate.im, -rate.re / rate.im);
    let mut fluid = sphere(mass, Support { stiffness, damping: 0.0, rest: -0.05 }, 0.0, nu);
    let (mut crossings, mut extremes, mut last) = (Vec::new(), Vec::new(), (0.05, 0.0));
    while crossings.len() < 4 {
        let t = fluid.time();
        fluid.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
        let pose = fluid.pose(0);
        let now = (pose.position[1] + 0.03, pose.velocity[1]);
        if last.0 * now.0 < 0.0 {
            crossings.push(fluid.time() - h * now.0 / (now.0 - last.0));
        }
        if last.1 * now.1 < 0.0 {
            extremes.push(now.0.abs());
        }
        last = now;
    }
    let found = crossings[3] - crossings[1];
    let damping = (extremes[0] / extremes[2]).ln() / TAU;
    println!("period {found:.4} by {period:.4}, damping {damping:.4} by {expected:.4}");
    assert!((found / period - 1.0).abs() < 0.02, "period {found} by {period}");
    assert!((damping / expected - 1.0).abs() < 0.1, "damping {damping} by {expected}");
}

/// A sphere that gravity sets in motion gains speed by the equation of Basset (1888),
/// `(M + m) v' = (M − B) g − 6 pi mu R (v + R/√(pi nu) ∫ v'(s)/√(t − s) ds)`, with the displaced mass B and the mass m
/// that it takes along; a light one rises.
#[test]
fn a_sphere_falls_and_rises_as_by_basset() {
    let ((displaced, added), nu, h, steps) = (masses(), 0.05, 0.04, 30);
    for ratio in [2.0, 0.5] {
        let (weight, drag, mass) = ((ratio - 1.0) * displaced * 0.1, 3.0 * PI * nu, ratio * displaced);
        let (fine, mut rates, mut expected) = (0.1 * h, Vec::new(), 0.0);
        for n in 0..10 * steps {
            // The history of a constant rate in the interval k before this one.
            let kernel = |k: usize| (fine / (PI * nu)).sqrt() * (((k + 1) as f64).sqrt() - (k as f64).sqrt());
            let history: f64 = rates.iter().enumerate().map(|(j, rate)| rate * kernel(n - j)).sum();
            let rate = (weight - drag * (expected + history)) / (mass + added + drag * (kernel(0) + fine));
            rates.push(rate);
            expected += fine * rate;
        }
        let mut fluid = sphere(mass, Support { stiffness: 0.0, damping: 0.0, rest: 0.0 }, 0.1, nu);
        for _ in 0..steps {
            let t = fluid.time();
            fluid.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
        }
        let found = -fluid.pose(0).velocity[1];
        println!("mass ratio {ratio}: {found:.5} m/s by {expected:.5}");
        assert!((found / expected - 1.0).abs() < 0.06, "mass ratio {ratio}: {found} by {expected}");
    }
}

/// A body that the master moves takes the force of one that a law moves in the same way, turned by a rotation vector.
#[test]
fn the_master_moves_a_body_as_a_law_does() {
    let axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
    let laws = Motion::laws([0.05, 0.02, -0.03].map(|a| sine(a, 1.0)), axis.into(), sine(0.5, 1.0));
    let fluids = [laws, Motion::Master].map(|motion| {
        let mut parameters = Parameters::new([[-0.5, 0.5]; 3], [24; 3], 2.0, 0.01, 0.01);
        let turn = Turn { axis: [1.0, 2.0, -1.0], angle: 0.4 };
        let body = still(Solid::Cuboid([0.2, 0.1, 0.15]), [0.05, -0.02, 0.03]);
        parameters.bodies = vec![Body { turn, motion: Some(motion), pivot: [0.05, 0.0, 0.02], ..body }];
        made(&parameters)
    });
    let [mut by_law, mut by_master] = fluids;
    for step in 0..12 {
        let (t, h) = (0.01 * f64::from(step), 0.01);
        by_law.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
        let pose = by_law.pose(0);
        let displacement = by_master.displacement_mut(0);
        *displacement = pose;
        displacement.position -= Vector3::new(0.05, -0.02, 0.03);
        by_master.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
        let [one, other] = [&by_law, &by_master].map(|fluid| fluid.force_on_body(0));
        let off = (one.force - other.force).norm() + (one.moment - other.moment).norm();
        // Before the first step the master has not said how it moves.
        assert!(step == 0 || off < 1e-9 * one.force.norm(), "{step}: {one:?} beside {other:?}");
    }
}

/// In a fluid that weighs nothing a body that was led on a parabola while it turned keeps to it from its release, and one
/// released at the start has the velocity of its laws.
#[test]
fn a_body_released_in_space_goes_on_falling_and_turning() {
    let h = 0.01;
    for release in [0.0, 0.1] {
        let polynomial = |v: f64, a: f64| Law::new(move |t| (v * t + 0.5 * a * t * t, v + a * t));
        let fall = [polynomial(0.2, 0.0), polynomial(0.0, -1.0), polynomial(-0.1, 0.5)];
        let Motion::Laws(laws) = Motion::laws(fall, [0.0, 0.0, 1.0].into(), polynomial(2.0, 0.0)) else {
            unreachable!()
        };
        let supports = [Some(Support { stiffness: 0.0, damping: 0.0, rest: 0.0 }); 6];
        let mount = Mount { mass: 1e8, inertia: Matrix3::identity() * 1e6, supports, gravity: [0.0, -1.0, 0.5] };
        let mut parameters = Parameters::new([[-0.5, 0.5]; 3], [16; 3], 1.0, 0.01, h);
        let body = still(Solid::Ellipsoid([0.2, 0.1, 0.15]), [0.02, 0.01, -0.03]);
        parameters.bodies = vec![Body { motion: Some(Motion::Released { laws, release, mount }), ..body }];
        let mut fluid = made(&parameters);
        for _ in 0..20 {
            fluid.advance(fluid.time(), h).unwrap_or_else(|e| panic!("{e}"));
        }
        let (t, pose) = (fluid.time(), fluid.pose(0));
        let way = Vector3::new(0.02 + 0.2 * t, 0.01 - 0.5 * t * t, -0.03 - 0.1 * t + 0.25 * t * t);
        let off = [(pose.position - way).norm(), (pose.angle - Vector3::new(0.0, 0.0, 2.0 * t)).norm()];
        println!("released at {release} s: off by {off:?}");
        // The first step is one of Euler's.
        let most = if release > 0.0 { 1e-7 } else { 0.8 * h * h * 1.25_f64.sqrt() };
        assert!(off[0] < most && off[1] < 1e-7, "released at {release} s: off by {off:?}");
    }
}

/// An ellipsoid that moves and turns obliquely beside a driven sheet and a driven line, between walls, feels the same
/// with its axes in turn along others, of another length and with other cells.
#[test]
fn axes_are_treated_alike_by_bodies() {
    let runs = [0, 1, 2].map(|turn| {
        let place = |own: [f64; 3]| {
            let mut all = [0.0; 3];
            (0..3).for_each(|axis| all[(axis + turn) % 3] = own[axis]);
            all
        };
        let half = place([0.6, 0.5, 0.7]);
        let cells = place([24.0, 18.0, 20.0]).map(|cells| cells as usize);
        let mut parameters = Parameters::new(half.map(|half| [-half, half]), cells, 2.0, 0.01, 0.01);
        parameters.initial_velocity = place([0.5, 0.2, -0.3]);
        parameters.walls[(2 + turn) % 3] = Some([-0.6, 0.65]);
        let mut displacement = [0.05, 0.0, 0.02].map(|amplitude| sine(amplitude, 1.0));
        displacement.rotate_right(turn);
        parameters.bodies = vec![Body {
            pivot: place([0.05, 0.1, -0.03]),
            turn: Turn { axis: place([1.0, 2.0, -1.0]), angle: 0.4 },
            motion: Some(Motion::laws(displacement, place([2.0, -1.0, 1.0]).into(), sine(0.8, 1.0))),
            ..still(Solid::Ellipsoid(place([0.3, 0.2, 0.15])), place([0.05, -0.02, 0.03]))
        }];
        let mesh = WingMesh::Rectangular { length: 0.5, width: 0.4, along: 5 }.build();
        let sheet = mesh.nodes.iter().map(|[x, y, _]| place([0.8 * x - 0.5, 0.6 * x + y - 0.3, 0.4 * y + 0.4]));
        let line = (0..10).map(|k| f64::from(k) / 20.0).map(|s| place([0.2 + 0.3 * s, s - 0.4, 0.5 * s - 0.4]));
        let lists = [(sheet.collect(), Extent::Surface(mesh.triangles)), (line.collect(), LINE)];
        parameters.flexible =
            lists.map(|(nodes, extent)| Flexible { name: "own".into(), nodes, extent, pivot: None }).into();
        let mut fluid = made(&parameters);
        let back = |all: [f64; 3]| [0, 1, 2].map(|axis| all[(axis + turn) % 3]);
        for _ in 0..10 {
            for stations in fluid.stations_mut() {
                for k in 0..stations.len() {
                    let [x, y, z] = back(stations.position.each_ref().map(|along| along[k]));
                    let velocity = place([0.3 - y, 0.8 * x - 0.4 * z, 0.2 + 0.5 * y]);
                    for (axis, velocity) in velocity.into_iter().enumerate() {
                        stations.position[axis][k] += 0.005 * velocity;
                        stations.velocity[axis][k] = velocity;
                    }
                }
            }
            let t = fluid.time();
            fluid.advance(t, 0.005).unwrap_or_else(|e| panic!("{e}"));
        }
        let mut all = vec![fluid.power_on_body(0), fluid.kinetic_energy(), fluid.enstrophy()];
        let forces = [fluid.force_on_body(0), fluid.force_on_flexible(0), fluid.force_on_flexible(1)];
        all.extend(forces.iter().flat_map(|own| [back(own.force.into()), back(own.moment.into())].concat()));
        for (loads, exchange) in fluid.loads().iter().zip(fluid.exchange()) {
            all.extend([exchange.power, exchange.work]);
            let at = |k: usize| back(loads.force.each_ref().map(|along| along[k]));
            all.extend((0..loads.impedance.len()).flat_map(at).chain(loads.impedance.iter().copied()));
        }
        all
    });
    for turn in [1, 2] {
        for (k, (found, expected)) in runs[turn].iter().zip(&runs[0]).enumerate() {
            assert!((found - expected).abs() < 1e-10, "turned {turn} times, number {k} is {found}, not {expected}");
        }
    }
}

/// The scene tells of probes in a turned body by its own geometry: there the fluid stands still.
#[test]
fn the_scene_tells_of_probes_where_a_turned_body_stops_the_fluid() {
    let places: Vec<_> = (0..216).map(|k| [k / 36, k / 6 % 6, k % 6].map(|i| 0.16 * i as f64 - 0.41)).collect();
    let names = places.iter().enumerate();
    let probes = names.map(|(k, place)| format!(r#"{{ "name": "p{k}", "position": {place:?} }}"#)).collect::<Vec<_>>();
    let scene = Scene::from_json(&format!(
        r#"{{ "name": "turned", "time": {{ "end": 1.0, "communication_step": 0.002 }}, "fluid": {{ "density": 1.0,
        "kinematic_viscosity": 0.01, "initial_velocity": [1.0, 0.5, 0.7],
        "box": {{ "x": [-0.6, 0.6], "y": [-0.6, 0.6], "z": [-0.6, 0.6], "cells": [48, 40, 36] }},
        "bodies": [
            {{ "shape": {{ "cuboid": {{ "lengths": [0.7, 0.2, 0.4] }} }}, "position": [0.1, -0.05, 0.15],
            "pivot": [0.15, 0.05, -0.1], "turn": {{ "axis": [1, 2, -1], "angle": 0.9 }},
            "motion": {{ "angle": {{ "constant": 0.5 }}, "axis": [2, -1, 1] }} }}],
        "probes": [{}], "mask": {{ "cosine": {{ "c_eta": 1e-7, "half_width": 0.5 }} }},
        "time_stepping": {{ "max_step": 0.01, "max_cfl": 0.4 }} }} }}"#,
        probes.join(", ")
    ))
    .unwrap_or_else(|e| panic!("{e}"));
    let keys: Vec<_> = scene.facts().warnings.into_iter().map(|warning| warning.key).collect();
    let parameters = Parameters::try_from(&scene).unwrap_or_else(|e| panic!("{e}"));
    let mut fluid = made(&parameters);
    for _ in 0..20 {
        let t = fluid.time();
        fluid.advance(t, 0.002).unwrap_or_else(|e| panic!("{e}"));
    }
    let mut told = 0;
    for (k, place) in places.iter().enumerate() {
        let speed = fluid.probe_velocity(k).iter().fold(0.0_f64, |speed, part| speed.hypot(*part));
        let is_told = keys.contains(&format!("fluid.probes[{k}].position"));
        assert_eq!(speed < 0.1, is_told, "told: {is_told}, but the fluid goes at {speed} m/s at {place:?}");
        told += usize::from(is_told);
    }
    // A probe for each 0.16³ m³.
    assert!((10..17).contains(&told), "{told} probes lie in 0.7 m x 0.2 m x 0.4 m");
}

/// Stokes (1851; Landau & Lifshitz, Fluid mechanics, § 24 and its problems): a sphere of radius R that oscillates along a
/// line or about a diameter, with the depth of penetration δ = √(2 nu/omega), q = R/δ:
/// `F = −6 π rho nu R (1 + q) u − (3 π R² rho δ + ⅔ π R³ rho) u'`, and the moment
/// `−(8/3) π rho nu R³ Re[(3 + 6q + 6q² + 2q³ − 2i q² (1 + q))/(1 + 2q + 2q²) Omega]`.
#[test]
fn an_oscillating_sphere_feels_the_forces_of_stokes() {
    let (radius, nu, frequency, density) = (0.14, 3e-2, 4.0, 1.3);
    let omega = TAU * frequency;
    let depth = (2.0 * nu / omega).sqrt();
    let q = radius / depth;
    let motion = |along: bool| {
        let x = sine(if along { 1e-3 } else { 0.0 }, frequency);
        let angle = sine(if along { 0.0 } else { 1e-2 }, frequency);
        Motion::laws([x, Law::constant(0.0), Law::constant(0.0)], [0.0, 1.0, 1.0].into(), angle)
    };
    let found = |along: bool| {
        let mut parameters = Parameters::new([[-0.5, 0.5]; 3], [40; 3], density, nu, 5e-3);
        parameters.bodies =
            vec![Body { motion: Some(motion(along)), ..still(Solid::Sphere(radius), [0.01, 0.0, 0.0]) }];
        let (mut fluid, h, period) = (made(&parameters), 5e-3, 50);
        // The drag belongs to the end of a step, the momentum of the displaced fluid changes in it.
        let volume = 4.0 / 3.0 * PI * radius.powi(3);
        let (amplitude, displaced) =
            if along { (1e-3, density * volume) } else { (1e-2, 0.4 * density * volume * radius * radius) };
        // In phase with the displacement and with the velocity.
        let mut phases = [-displaced * amplitude * omega * omega, 0.0];
        for step in 0..2 * period {
            let t = fluid.time();
            fluid.advance(t, h).unwrap_or_else(|e| panic!("{e}"));
            let force = fluid.force_on_body(0);
            let value = if along { force.force[0] } else { force.moment[2] * 2_f64.sqrt() };
            let [before, after] = [omega * t, omega * (t + h)];
            let drag = value - displaced * amplitude * omega * (after.cos() - before.cos()) / h;
            if step >= period {
                phases[0] += 2.0 / f64::from(period) * drag * after.sin();
                phases[1] += 2.0 / f64::from(period) * drag * after.cos();
            }
        }
        phases
    };
    let [inertia, friction] = found(true);
    let mass = density * (3.0 * PI * radius.powi(2) * depth + 2.0 / 3.0 * PI * radius.powi(3));
    let drag = 6.0 * PI * density * nu * radius * (1.0 + q);
    // The layer has two cells. Bare walls, without the correction, have inertias of 0.90 and 0.82.
    let [inertia, friction] = [inertia / (1e-3 * omega * omega * mass), -friction / (1e-3 * omega * drag)];
    assert!((inertia - 1.0).abs() < 0.03 && (friction - 1.0).abs() < 0.08, "{inertia}, {friction}");

    let [inertia, friction] = found(false);
    let common = 8.0 / 3.0 * PI * density * nu * radius.powi(3) / (1.0 + 2.0 * q + 2.0 * q * q) * 1e-2 * omega;
    let friction = -friction / (common * (3.0 + 6.0 * q + 6.0 * q * q + 2.0 * q.powi(3)));
    let inertia = inertia / (common * 2.0 * q * q * (1.0 + q));
    assert!((inertia - 1.0).abs() < 0.05 && (friction - 1.0).abs() < 0.08, "{inertia}, {friction}");
}

#[test]
fn forces_and_states_of_moving_bodies_have_the_same_bits() {
    let mut one = Parameters::new([[-0.5, 0.5]; 3], [48; 3], 2.0, 0.01, 0.01);
    one.precision = Precision::Single;
    one.initial_velocity = [1.0, 0.0, 0.0];
    let motion = Motion::laws([0.05, 0.02, 0.0].map(|a| sine(a, 1.0)), [1.0; 3].into(), sine(0.5, 1.0));
    one.bodies = vec![
        still(Solid::Sphere(0.15), [-0.2, 0.0, 0.0]),
        Body { motion: Some(motion), ..still(Solid::Cuboid([0.1, 0.08, 0.2]), [0.2, 0.1, 0.0]) },
    ];
    let mut two = one.clone();
    two.threads = 2;
    let mut fluids = [made(&one), made(&two)];
    let run = |fluid: &mut Fluid<3>, steps: usize| {
        (0..steps).for_each(|_| fluid.advance(fluid.time(), 0.004).unwrap_or_else(|e| panic!("{e}")));
    };
    fluids.iter_mut().for_each(|fluid| run(fluid, 3));
    let state = fluids[0].state();
    assert!(state == fluids[1].state(), "two threads have other bits");
    run(&mut fluids[0], 2);
    fluids[1].restore(&state).unwrap_or_else(|e| panic!("{e}"));
    run(&mut fluids[1], 2);
    assert!(fluids[0].state() == fluids[1].state(), "a step back has other bits");
    let mut other = made(&one);
    other.restore(&state).unwrap_or_else(|e| panic!("{e}"));
    run(&mut other, 2);
    assert!(fluids[0].state() == other.state(), "a state in another fluid has other bits");
}
