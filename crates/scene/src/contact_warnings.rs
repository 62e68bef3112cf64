//! Rods and bodies that start in contact, whose energy throws them.

use geometry::vector::{between, dot, minus};

use ::contact::{BodyContacts, FastMeeting, HELD, Kinematics, Obstacle, Part, PartMotion, Party};

use crate::body::Body;
use crate::places::{rounded, three_digits};
use crate::root::{RootMotion, RootSupport};
use crate::scene::{BeamWithRod, Scene, WingOfScene};
use crate::warning::Warning;

/// Most points at which the gap is looked at.
const MOST_POINTS: f64 = 1e4;

/// Return the warning about a rod that contact throws farther than its range at the start.
pub(crate) fn of_rod(scene: &Scene, own: &BeamWithRod) -> Option<Warning> {
    let (contact, rod) = (scene.contact.as_ref()?, own.rod?);
    let (law, mut stations) = (contact.law(scene, own), scene.beam_stations(own.beam));
    if let Some(RootMotion::Laws(laws)) = &rod.root_motion {
        stations = stations.iter().copied().map(laws.motion(stations[0], 0.0)).collect();
    }
    let (last, length) = ((stations.len() - 1) as f64, own.beam.length);
    // The points of contact of the rod.
    let count = last * (length / last / (law.depth + law.range)).min(MOST_POINTS / last).ceil();
    let shares: Vec<_> = (0..=count as usize).map(|i| i as f64 / count).collect();
    let half = |share: f64| 0.5 * own.beam.thickness.at(share);
    let place = |share: &f64| {
        let station = ((share * last) as usize).min(stations.len() - 2);
        between(stations[station], stations[station + 1], share * last - station as f64)
    };
    let places: Vec<_> = shares.iter().map(place).collect();
    let part = |share: f64| if share == 0.0 || share == 1.0 { 0.5 * length / count } else { length / count };
    let at_places = |name: String, distance: &dyn Fn([f64; 3]) -> f64| {
        (name, places.iter().map(|place| distance(*place)).collect::<Vec<_>>())
    };
    let endless = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
    let bodies = scene.contact_bodies_with_keys().map(|(key, body)| {
        let shape = body.shape_at(0.0, &endless);
        at_places(format!("`{key}`"), &|place| shape.distance(place))
    });
    let walls = scene
        .contact_walls()
        .into_iter()
        .map(|(point, normal)| at_places("a wall of the channel".into(), &|place| dot(minus(place, point), normal)));
    let (near, is_held) = (half(0.0) + law.range, !matches!(rod.root, RootSupport::Free { .. }));
    let (mut energy, mut closest) = (0.0, (f64::INFINITY, String::new()));
    for (name, distances) in bodies.chain(walls) {
        let free = if is_held && distances[0] < near { HELD * near } else { 0.0 };
        for (share, distance) in shares.iter().zip(distances).filter(|(share, _)| *share * length >= free) {
            let gap = distance - half(*share);
            energy += part(*share) * law.penalty(gap).potential;
            if gap < closest.0 {
                closest = (gap, name.clone());
            }
        }
    }
    let mass_at = |share: &f64| part(*share) * rod.material.section(&own.beam.thickness, *share).line_density;
    let mass: f64 = shares.iter().map(mass_at).sum();
    let (weight, speed) =
        (mass * rod.gravity.iter().fold(0.0_f64, |g, part| g.hypot(*part)), (2.0 * energy / mass).sqrt());
    // A rod that rests on something has a third of that or less.
    let is_thrown = energy > weight * law.range && speed * scene.time.end > law.range;
    (is_thrown && energy.is_finite()).then(|| {
        let name = own.name.map_or(String::new(), |name| format!(" `{name}`"));
        let (unit, other) = (if scene.dimension(own.beam) == 2 { "J/m" } else { "J" }, closest.1);
        let [gap, range, energy, speed] = [closest.0, law.range, energy, speed].map(three_digits);
        let text = format!(
            "the rod{name} starts in contact with {other}: its gap is {gap} m and `contact.range` {range} m, \
             and {energy} {unit} throw it with up to {speed} m/s"
        );
        Warning { key: "contact.range".into(), time: None, text }
    })
}

/// Return the warning about a flyer whose solid no fluid knows, beside something that moves.
pub(crate) fn of_flyer(scene: &Scene) -> Option<Warning> {
    scene.flyer.as_ref().filter(|_| scene.contact.is_some())?.solid.as_ref()?;
    let mounted = scene.fluid.iter().flat_map(|fluid| fluid.obstacles()).filter(|own| own.body.mount.is_some());
    let rods = scene.beams_with_rods().map(|own| own.name.unwrap_or("rod").to_string());
    let units = rods.chain(scene.wings().map(|own| own.name.to_string()));
    let bare = units.filter(|name| scene.hinge_of(name).is_none());
    let other = mounted.map(|own| own.key).chain(bare).next()?;
    let text = format!("`flyer.solid` passes through `{other}`, which only a `flyer.shape` in the fluid touches");
    Some(Warning { key: "flyer.solid".into(), time: None, text })
}

impl Scene {
    /// Return the warning about two that met faster than contact surely stops in a step to time `t`, s.
    pub fn warning_of(&self, FastMeeting { parties, speed, limit }: &FastMeeting, t: f64) -> String {
        let name = |party: Party| match party {
            Party::Body(k) => self.fluid.as_ref()?.obstacles().nth(k).map(|own| own.name),
            Party::Flexible(k) => {
                let rod = |own: BeamWithRod| own.name.map_or("the rod".into(), |name| format!("the rod {name}"));
                let wing =
                    |own: WingOfScene| own.number.map_or("the wing".into(), |_| format!("the wing {}", own.name));
                self.beams_with_rods().map(rod).chain(self.wings().map(wing)).nth(k)
            }
        };
        let [one, other] = parties.map(|party| name(party).unwrap_or_default());
        let [speed, limit] = [*speed, *limit].map(three_digits);
        let at = rounded(t);
        format!(
            "{one} and {other} meet with {speed} m/s at t = {at} s, but contact is sure to stop {limit} m/s: it needs a \
             longer `contact.range` or a shorter `time.communication_step`"
        )
    }
}

/// Return the warnings about bodies on a mount that contact throws at the start, or cannot part.
pub(crate) fn of_bodies(scene: &Scene) -> Vec<Warning> {
    if scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space()) {
        let endless = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
        thrown::<3>(scene, |body| Obstacle::of_solid(&body.shape.solid(&endless)?, body.place_at(0.0)))
    } else {
        thrown::<2>(scene, |body| Obstacle::of_outline(&body.shape.outline()?, body.place_at(0.0)))
    }
}

fn thrown<const D: usize>(scene: &Scene, obstacle: impl Fn(&Body) -> Option<Obstacle<D>>) -> Vec<Warning>
where
    [f64; D]: Kinematics<D>,
{
    let Some((contact, fluid)) = scene.contact.as_ref().zip(scene.fluid.as_ref()) else { return vec![] };
    let law = contact.law_of_bodies(scene);
    let on_mount = fluid.obstacles().filter(|own| own.body.mount.is_some()).map(|own| (own.key, own.body));
    let bodies: Vec<_> = on_mount.chain(scene.contact_bodies_with_keys()).collect();
    let moving = bodies.iter().filter_map(|(key, body)| {
        let solid = obstacle(body)?;
        let motion = PartMotion { free: [body.mount.is_some(); 6], ..PartMotion::still(solid.pose) };
        let inertia = body.mount.as_ref().map(|mount| [mount.mass, f64::INFINITY]);
        Some((format!("`{key}`"), body.mount.as_ref(), Part { solid, inertia, pivot: [0.0; D].into(), motion }))
    });
    let walls = scene.contact_walls().into_iter().map(|(point, normal)| {
        let [point, normal] = [point, normal].map(|vector| std::array::from_fn(|d| vector[d]));
        let solid = Obstacle::plane(point, normal);
        let motion = PartMotion::still(solid.pose);
        ("a wall of the channel".to_string(), None, Part { solid, inertia: None, pivot: [0.0; D].into(), motion })
    });
    let all: Vec<_> = moving.chain(walls).collect();
    let Ok(contacts) = BodyContacts::new(all.iter().map(|(.., part)| part.clone()).collect(), &law) else {
        return vec![];
    };
    let of_pair = |(parts, gap, energy): ([usize; 2], f64, f64)| {
        let [(name, mount, _), (other, its, _)] = parts.map(|k| &all[k]);
        let mounts = [mount, its].into_iter().flatten();
        let mass = mounts.clone().map(|mount| mount.mass).fold(f64::INFINITY, f64::min);
        let heaviest = mounts.map(|own| own.mass * own.gravity.iter().fold(0.0_f64, |g, part| g.hypot(*part)));
        let (weight, speed) = (heaviest.fold(0.0, f64::max), (2.0 * energy / mass).sqrt());
        let [depth, gap, range, energy_text, speed_text] = [-gap, gap, law.range, energy, speed].map(three_digits);
        let text = if energy == f64::INFINITY {
            format!("the body {name} starts in contact with {other}, {depth} m deep: the first step is refused")
        } else if energy > weight * law.range && speed * scene.time.end > law.range {
            let unit = if D == 2 { "J/m" } else { "J" };
            format!(
                "the body {name} starts in contact with {other}: its gap is {gap} m and `contact.range` {range} m, and \
                 {energy_text} {unit} throw it with up to {speed_text} m/s"
            )
        } else {
            return None;
        };
        Some(Warning { key: "contact.range".into(), time: None, text })
    };
    contacts.touching().into_iter().filter_map(of_pair).collect()
}
