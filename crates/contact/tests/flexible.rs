//! Contact of lines and surfaces that others move, by the loads that it announces.

use nervure_contact::{
    BodyLaw, ContactCoupling, FlexibleBody, FlexibleContact, Law, Loads, MountedBody, Obstacle, Party, Pose, Skin,
    Stations, largest_stiffness,
};

const STEP: f64 = 5e-3;
const RADIUS: f64 = 0.005;
const LAW: Law =
    Law { range: 0.1, stiffness: f64::INFINITY, depth: f64::INFINITY, damping: 0.0, friction: 0.3, film: None };

/// A straight line that moves as a whole.
#[derive(Clone)]
struct Line {
    length: f64,
    mass: f64,
    at: [f64; 2],
    velocity: [f64; 2],
    /// Force on it beside contact, N.
    outer: [f64; 2],
    is_held: bool,
}

impl Line {
    fn upper(mass: f64, height: f64, velocity: [f64; 2]) -> Self {
        Self { length: 0.8, mass, at: [0.0, height], velocity, outer: [0.0; 2], is_held: false }
    }

    /// A line below it that reaches farther on both sides.
    fn lower(mass: f64) -> Self {
        Self { length: 2.4, ..Self::upper(mass, 0.0, [0.0; 2]) }
    }

    fn nodes(&self) -> Vec<[f64; 2]> {
        (-4..=4).map(|k| [self.at[0] + 0.125 * f64::from(k) * self.length, self.at[1]]).collect()
    }

    fn energy(&self) -> f64 {
        0.5 * self.mass * self.velocity.iter().map(|v| v * v).sum::<f64>()
    }
}

/// Two lines that nothing couples but contact.
struct Pair {
    lines: [Line; 2],
    contact: ContactCoupling<2>,
}

impl Pair {
    fn new(lines: [Line; 2], law: &Law) -> Self {
        let nodes = lines.each_ref().map(Line::nodes);
        let skins = lines.each_ref().map(|line| Skin {
            radius: vec![RADIUS; 9],
            largest_stiffness: largest_stiffness(line.mass / line.length, STEP),
            mass: line.mass / line.length,
        });
        let bodies = [0, 1].map(|k| FlexibleBody { nodes: &nodes[k], triangles: None, skin: Some(&skins[k]) });
        let mut pair = Self { contact: ContactCoupling::new(&bodies, law, STEP), lines };
        pair.give();
        pair.contact.start().expect("places are finite");
        pair
    }

    fn give(&mut self) {
        for (stations, line) in self.contact.target.iter_mut().zip(&self.lines) {
            *stations = Stations::at_rest(&line.nodes());
            (0..2).for_each(|d| stations.velocity[d].fill(line.velocity[d]));
        }
    }

    fn step(&mut self) -> [[f64; 2]; 2] {
        self.exchange(STEP)
    }

    /// Make a step of `h` seconds, and return the impulse on each line, N s.
    fn exchange(&mut self, h: f64) -> [[f64; 2]; 2] {
        let mut impulses = [[0.0; 2]; 2];
        for (k, line) in self.lines.iter_mut().enumerate().filter(|(_, line)| !line.is_held) {
            let Loads { force, impedance } = &self.contact.loads()[k];
            let rate: f64 = impedance.iter().sum();
            for d in 0..2 {
                let load: f64 = force[d].iter().sum();
                let change = (load + line.outer[d]) / (line.mass / h + rate);
                line.velocity[d] += change;
                line.at[d] += h * line.velocity[d];
                impulses[k][d] = h * (load - rate * change);
            }
        }
        self.give();
        self.contact.advance(h).expect("places are finite");
        impulses
    }

    fn energy(&self) -> f64 {
        self.lines.iter().map(Line::energy).sum::<f64>() + self.contact.energy()
    }
}

/// Height (m) of a line of this mass (kg) above one of the same mass per metre at which contact carries a load, N.
fn height_under(load: f64, mass: f64) -> f64 {
    let stiffness = 0.5 * largest_stiffness(mass / 0.8, STEP);
    2.0 * RADIUS + LAW.range - (2.0 * LAW.range * load / 0.8 / stiffness).sqrt()
}

/// A line that lies on a held one under a load N slides against μ N, and stops.
#[test]
fn a_line_that_slides_on_another_one_slows_by_friction_alone_and_stops() {
    let (mass, load) = (1.6, 8.0);
    let mut upper = Line::upper(mass, height_under(load, mass), [0.5, 0.0]);
    upper.outer[1] = -load;
    let lower = Line { is_held: true, ..Line::lower(3.0 * mass) };
    let mut pair = Pair::new([upper, lower], &LAW);
    let deceleration = LAW.friction * load / mass;
    let (mut before, mut slow, mut worst) = (0.5, 0, 0.0_f64);
    for k in 1..=100 {
        pair.step();
        let ([v, w], t) = (pair.lines[0].velocity, f64::from(k) * STEP);
        assert!(v <= before + 1e-5 && v > -1e-5, "{v} m/s after {before} m/s");
        assert!(w.abs() < 5e-2, "it rises with {w} m/s");
        let exact = 0.5 - deceleration * t;
        if exact > 0.05 {
            worst = worst.max((v - exact).abs());
            slow += 1;
        }
        before = v;
    }
    assert!(worst < 4e-3, "{worst} m/s off");
    assert!(slow > 50 && before < 1e-3, "it still slides with {before} m/s");
}

/// Under a load along the surface below μ N a line creeps; above it, it slides as fast as by friction alone.
#[test]
fn a_line_sticks_below_the_limit_of_friction() {
    let (mass, load) = (1.6, 8.0);
    for (along, slides) in [(0.5 * LAW.friction * load, false), (1.5 * LAW.friction * load, true)] {
        let mut upper = Line::upper(mass, height_under(load, mass), [0.0; 2]);
        upper.outer = [along, -load];
        let lower = Line { is_held: true, ..Line::lower(3.0 * mass) };
        let mut pair = Pair::new([upper, lower], &LAW);
        (0..200).for_each(|_| {
            pair.step();
        });
        let v = pair.lines[0].velocity[0];
        let free = (along - if slides { LAW.friction * load } else { 0.0 }) / mass * 200.0 * STEP;
        let expected = if slides { (0.97 * free)..(1.03 * free) } else { 0.0..(0.03 * free) };
        assert!(expected.contains(&v), "{v} m/s, but {free} m/s by the loads");
    }
}

/// Momentum passes from one to the other: what a step leaves over the next one makes up for.
#[test]
fn lines_of_any_masses_exchange_momentum_and_gain_no_energy() {
    // With steps of two lengths, of which none is the announced one, the energy is exact to the order of the scheme only.
    for (second, off) in [(STEP, 1e-9), (0.6 * STEP, 1e-3)] {
        for (ratio, friction) in [0.03, 0.3, 1.0, 7.0, 50.0].into_iter().flat_map(|ratio| [(ratio, 0.0), (ratio, 0.5)])
        {
            let lines = [Line::upper(1.6, 0.2, [0.3, -1.0]), Line::lower(1.6 * ratio)];
            let mut pair = Pair::new(lines, &Law { friction, ..LAW });
            let (start, mut sum, mut given) = (pair.lines[0].energy(), [0.0; 2], 0.0_f64);
            let case = format!("ratio {ratio}, friction {friction}, steps of {STEP} and {second} s");
            for h in [STEP, second].repeat(100) {
                let [one, other] = pair.exchange(h);
                (0..2).for_each(|d| sum[d] += one[d] + other[d]);
                given += one[1].abs();
                let energy = pair.energy();
                assert!(energy < start * (1.0 + off), "{case}: {energy} J of {start} J");
            }
            let [upper, lower] = &pair.lines;
            assert!(upper.velocity[1] > lower.velocity[1] && given > 0.05, "{case}: they do not bounce");
            assert!(sum.iter().all(|off| off.abs() < 1e-13 * given), "{case}: {sum:?} N s of {given} N s");
            // Friction slows the slip; only what is owed of the last step may turn it around, by a trace.
            let slip = upper.velocity[0] - lower.velocity[0];
            let expected = if friction > 0.0 { -1e-4..0.29 } else { 0.295..0.305 };
            assert!(expected.contains(&slip), "{case}: a slip of {slip} m/s");
        }
    }
}

/// The range stops lines that meet up to the speed of the limit, beyond which each pair is noted once.
#[test]
fn lines_that_meet_faster_than_the_range_stops_are_noted_once() {
    for (mass, speed, is_fast) in [(1.6, 3.1, false), (1.6, 4.6, true), (30.0, 3.1, false), (30.0, 4.6, true)] {
        let lines = [Line::upper(1.6, 0.25, [0.0, -speed]), Line::lower(3.0 * mass)];
        let mut pair = Pair::new(lines, &Law { friction: 0.0, ..LAW });
        let mut least = f64::INFINITY;
        for _ in 0..60 {
            pair.step();
            least = least.min(pair.lines[0].at[1] - pair.lines[1].at[1] - 2.0 * RADIUS);
        }
        assert!((least < 0.0) == is_fast, "{speed} m/s: a gap of {least} m");
        let limit = LAW.range * std::f64::consts::PI / (10.0 * STEP * 3.0_f64.sqrt());
        match pair.contact.fast() {
            [one] if is_fast => {
                assert_eq!(one.parties, [Party::Flexible(0), Party::Flexible(1)]);
                assert!((one.speed - speed).abs() < 1e-12 && (one.limit - limit).abs() < 1e-12, "{one:?}");
            }
            found => assert!(found.is_empty() && !is_fast, "{speed} m/s: {found:?}"),
        }
    }
}

/// A light and a heavy disk on a mount under a line that slides over them.
#[test]
fn friction_takes_a_body_on_a_mount_along_and_never_past_the_line() {
    let nodes = Line::upper(1.6, 0.34, [0.0; 2]).nodes();
    let skin = Skin { radius: vec![RADIUS; 9], largest_stiffness: largest_stiffness(2.0, STEP), mass: 2.0 };
    let mut stations = [Stations::at_rest(&nodes)];
    stations[0].velocity[0].fill(1.0);
    let place = Pose { axes: [[1.0, 0.0].into(), [0.0, 1.0].into()], origin: [0.0; 2].into() };
    for mass in [1e-3, 0.1, 10.0] {
        let moment = 0.5 * mass * 0.09;
        let [(force, about), (without, _)] = [10.0, 0.0].map(|friction| {
            let body = MountedBody::new(0, Obstacle::block([0.0; 2], [0.0; 2], 0.3), [mass, moment]);
            let flexible = [FlexibleBody { nodes: &nodes, triangles: None, skin: Some(&skin) }];
            let law = Law { friction, ..LAW };
            let contact = FlexibleContact::new(&flexible, vec![body], &law, [f64::INFINITY; 2]);
            let mut contact = contact.expect("the line touches the disk");
            contact.find(&stations, |_| Some((place, rigid::Pose::default())), STEP);
            let (_, push) = contact.pushes().next().expect("one body");
            let [own, line] = [push.load.force.force[0], contact.loads()[0].force[0].iter().sum()];
            assert!((own + line).abs() < 1e-12 * own, "{own} N on the disk, {line} N on the line");
            (own, push.load.force.moment)
        });
        // Speed of the surface under the line after the step.
        let surface = STEP * ((force - without) / mass - 0.3 * about / moment);
        assert!(surface > 0.05 && surface < 1.0, "mass {mass} kg: the surface moves with {surface} m/s");
    }
}

/// A state in the middle of a bounce leads to the same bits, and one of other lines is refused.
#[test]
fn a_bounce_goes_on_from_its_state_to_the_bit() {
    let lines = || [Line::upper(1.6, 0.12, [0.3, -1.0]), Line::lower(3.0)];
    let mut pair = Pair::new(lines(), &LAW);
    (0..6).for_each(|_| {
        pair.step();
    });
    assert!(pair.contact.loads()[0].impedance.iter().any(|rate| *rate > 0.0), "they do not touch");
    let state = pair.contact.state().clone();
    let mut again = Pair { lines: pair.lines.clone(), ..Pair::new(lines(), &LAW) };
    again.contact.restore(&state).expect("it is a state of these lines");
    for _ in 0..20 {
        assert_eq!(pair.step(), again.step());
    }
    assert_eq!(pair.contact.state(), again.contact.state());
    let (state, before) = (pair.contact.state().clone(), pair.contact.state().clone());
    let other = FlexibleBody { nodes: &[[0.0; 2]; 3], triangles: None, skin: None };
    assert!(ContactCoupling::new(&[other; 2], &LAW, STEP).restore(&state).is_err());
    pair.contact.target[1].position[0][4] = f64::NAN;
    let error = pair.contact.advance(STEP).expect_err("it is no number").to_string();
    assert!(error.contains("station 5 of 2") && *pair.contact.state() == before, "{error}");
}

/// A line that falls too fast on one of two blocks that meet too fast with many corners.
#[test]
fn first_and_fast_meetings_in_many_points_allocate_nothing() {
    let nodes = Line::upper(1.6, 0.33, [0.0; 2]).nodes();
    let skin = Skin { radius: vec![RADIUS; 9], largest_stiffness: largest_stiffness(2.0, STEP), mass: 2.0 };
    let mut stations = [Stations::at_rest(&nodes)];
    stations[0].velocity[1].fill(-50.0);
    let law = BodyLaw { range: 0.1, stiffness: 1e9, damping: 0.0, friction: 0.3, film: None, dt: STEP };
    let body = |number| MountedBody {
        law: Some(law),
        ..MountedBody::new(number, Obstacle::block([0.0; 2], [0.3, 0.3], 0.0), [1.0, 0.1])
    };
    let line = [FlexibleBody { nodes: &nodes, triangles: None, skin: Some(&skin) }];
    let at = |number: usize| {
        let place = [0.0, [0.0, -0.62][number]];
        let pose = rigid::Pose { velocity: [0.0, [0.0, 50.0][number]].into(), ..rigid::Pose::default() };
        Some((Pose::at(place), rigid::Pose { position: place.into(), ..pose }))
    };
    let [blocks, with_line] = [[Party::Body(0), Party::Body(1)], [Party::Flexible(0), Party::Body(0)]];
    for (lines, expected) in [(0, vec![blocks]), (1, vec![with_line, blocks])] {
        let contact = FlexibleContact::new(&line[..lines], vec![body(0), body(1)], &LAW, [f64::INFINITY; 2]);
        let mut contact = contact.expect("two may touch");
        let counted = allocation_counter::measure(|| contact.find(&stations[..lines], at, STEP));
        assert_eq!(contact.fast().iter().map(|met| met.parties).collect::<Vec<_>>(), expected);
        assert_eq!(counted.count_total, 0, "{lines} lines");
    }
}

/// Sheets of few large triangles have thousands of points each.
#[test]
fn the_memory_of_coarse_and_fine_bodies_is_known_beforehand() {
    for (side, radius, bodies) in [(1, 1e-3, 3), (1, 0.05, 2), (40, 0.02, 2)] {
        let at = |k: usize| [(k % (side + 1)) as f64 / side as f64, (k / (side + 1)) as f64 / side as f64, 0.0];
        let nodes: Vec<_> = (0..(side + 1) * (side + 1)).map(at).collect();
        let corner = |k: usize| k % side + k / side * (side + 1);
        let halves = |k| [[k, k + 1, k + side + 2], [k, k + side + 2, k + side + 1]];
        let triangles: Vec<_> = (0..side * side).map(corner).flat_map(halves).collect();
        let skin = Skin { radius: vec![radius; nodes.len()], largest_stiffness: 1e3, mass: 1.0 };
        let sheet = FlexibleBody { nodes: &nodes, triangles: Some(&triangles), skin: Some(&skin) };
        let sheets = vec![sheet; bodies];
        let counted = allocation_counter::measure(|| {
            drop(FlexibleContact::new(&sheets, vec![], &LAW, [f64::INFINITY; 3]));
        });
        let (said, most) = (FlexibleContact::bytes(&sheets, 0) as f64, counted.bytes_max as f64);
        assert!(said >= most && said <= 4.0 * most, "{side} along a side, {radius} m: {said} for {most} bytes");
    }
}

/// A refused step leaves the contact as it was, and a state with works that are no numbers is refused.
#[test]
fn what_is_too_large_for_numbers_is_refused() {
    let lines = || [Line::upper(1.6, 0.02, [0.0; 2]), Line::lower(1.6)];
    let mut pair = Pair::new(lines(), &LAW);
    pair.step();
    let before = (pair.contact.state().clone(), pair.contact.loads().to_vec());
    for velocity in [1e160, 1e300] {
        pair.give();
        pair.contact.target[0].velocity[1].fill(-velocity);
        let refused = (0..3).find_map(|_| pair.contact.advance(STEP).err());
        assert!(refused.is_some_and(|why| why.to_string().contains("so large")), "{velocity} m/s");
        assert!(pair.contact.exchange().iter().all(|own| own.power.is_finite() && own.work.is_finite()));
        pair.contact.restore(&before.0).unwrap();
        assert_eq!(pair.contact.loads(), &before.1[..]);
    }
    pair.give();
    let counted = allocation_counter::measure(|| assert!(pair.contact.advance(f64::MAX).is_err()));
    assert_eq!((pair.contact.state(), pair.contact.loads()), (&before.0, &before.1[..]));
    assert_eq!(counted.count_total, 0);
}
