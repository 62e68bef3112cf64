//! Contradictions between the keys of a scene; types and ranges were checked before.

use std::fmt::Debug;

use geometry::AXES;
use method::{Axis, Bending, Calibration, Slide, Surface, TimeScheme};

use crate::beam::{Beam, Root};
use crate::contact_checks;
use crate::coupling::{CouplingScheme, Load};
use crate::fault::{Check, Fault, Faults, list};
use crate::flyer_checks;
use crate::law::TimeLaw;
use crate::load::Weight;
use crate::places;
use crate::rod::{Material, Rod};
use crate::root::{RootLaws, RootSupport, Rotation, Z_AXIS};
use crate::scene::{BeamWithRod, Display, Scene, Time};
use crate::stepping::TimeStepping;
use crate::wing::WingMesh;

/// Most characters of the name of a scene: the file names of its units stay within the limits of file systems.
const NAME_LENGTH: usize = 100;

/// Most steps of a unit in a communication step.
const MOST_SUBSTEPS: f64 = 1e5;

/// Most communication steps in a run.
const MOST_STEPS: f64 = 1e12;

/// Add the contradictions of a scene. Those that need values along a beam are sought only where there are no
/// others.
pub(crate) fn check(scene: &Scene, faults: &mut Faults) {
    check_name_and_time(scene, faults);
    check_parts(scene, faults);
    scene.fluid.check_at("fluid", faults);
    scene.rods.check_at("rods", faults);
    for own in scene.beams_with_rods() {
        own.beam.check_at(&format!("{}beam", own.key()), faults);
        if let Some(rod) = own.rod {
            rod.check_at(&format!("{}rod", own.key()), faults);
        }
        check_beam(scene, &own, faults);
    }
    contact_checks::check(scene, faults);
    check_display(scene, faults);
    check_substeps(scene, faults);
    scene.reference.check_at("reference", faults);
    if faults.len() == 0 {
        check_reference(scene, faults);
        places::check(scene, faults);
        check_lines(scene, faults);
        check_coupling(scene, faults);
    }
}

fn check_name_and_time(scene: &Scene, faults: &mut Faults) {
    let name = &scene.name;
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    let begins = name.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_');
    faults.require(begins && name.len() <= NAME_LENGTH && name.chars().all(plain), "name", quoted(name), || {
        format!(
            "a name has 1 to {NAME_LENGTH} letters a-z, A-Z, digits, `.`, `_` and `-`, and begins with a letter, a \
             digit or `_`"
        )
    });
    let Time { end, communication_step: step } = scene.time;
    faults.require(end / step <= MOST_STEPS, "time.communication_step", shown(&step), || {
        format!("a run has at most {MOST_STEPS:e} steps: it must be >= {:.3e}", end / MOST_STEPS)
    });
}

/// Check which parts the scene has.
fn check_parts(scene: &Scene, faults: &mut Faults) {
    let (several_wings, flies) = (!scene.wings.is_empty(), scene.flyer.is_some());
    for own in scene.wings() {
        let wing = own.wing;
        let flat = scene.fluid.as_ref().is_some_and(|fluid| !fluid.is_space());
        faults.forbid(flat, &own.key, || "the fluid has two dimensions: a wing needs `fluid.box.z`".into());
        wing.check_at(&own.key, faults);
        let bare = matches!(&wing.mesh, WingMesh::Triangles { triangles, .. } if triangles.is_empty());
        let key = format!("{}.mesh.triangles.triangles", own.key);
        faults.require(!bare || scene.fluid.is_none(), &key, "an empty list", || {
            "the fluid meets the triangles of a wing".into()
        });
    }
    check_wings(scene, faults);
    if let Some(flyer) = &scene.flyer {
        flyer_checks::check(scene, flyer, faults);
    }
    let by_contact = scene.is_coupled_by_contact();
    if scene.fluid.is_none() && scene.rod.is_none() && scene.wing.is_none() && !several_wings && !flies && !by_contact {
        faults.push(match scene.rods.is_empty() {
            true => Fault::needed("fluid", "a scene needs a fluid, a rod with a beam, or both"),
            false => Fault::needed("fluid", "several rods need a fluid or a `contact` that couples them"),
        });
    }
    if scene.rod.is_some() && scene.beam.is_none() && scene.rods.is_empty() {
        faults.push(Fault::needed("beam", "a rod needs the geometry of its beam"));
    }
    let several = !scene.rods.is_empty();
    if let Some(name) = &scene.this_rod {
        let known = scene.rods.iter().any(|own| own.name == *name);
        if faults.forbid(!several, "this_rod", || "the scene has no `rods`".into()) {
            let names = list(scene.rods.iter().map(|own| &own.name), "and");
            faults.require(known, "this_rod", quoted(name), || format!("the names in `rods` are {names}"));
        }
    }
    for (key, present) in [("beam", scene.beam.is_some()), ("rod", scene.rod.is_some())] {
        faults.forbid(several && present, key, || {
            "the scene has `rods`; move it into `rods`, or remove one of the two".into()
        });
    }
    faults.require(scene.rods.len() != 1, "rods", "a list of one", || {
        "several rods are at least two: a single rod is `beam` and `rod` of the scene".into()
    });
    for (i, own) in scene.rods.iter().enumerate() {
        // Names become file names, which some systems do not distinguish by case.
        let twice = scene.rods[..i].iter().any(|other| other.name.eq_ignore_ascii_case(&own.name));
        faults.require(!twice, &format!("rods[{i}].name"), quoted(&own.name), || {
            "another rod has this name; capital and small letters count as the same".into()
        });
    }
    let has_flexible = scene.rod.is_some() || scene.wings().next().is_some() || several;
    let coupled = by_contact || (scene.fluid.is_some() && has_flexible);
    faults.forbid(scene.coupling.is_some() && !coupled, "coupling", || "the scene lacks a fluid or a rod".into());
    let load = scene.coupling.as_ref().and_then(|coupling| coupling.load);
    faults.require(!by_contact || load != Some(Load::PressureJump), "coupling.load", "pressure_jump", || {
        "contact without a fluid gives the load momentum".into()
    });
    if coupled && scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space()) {
        faults.require(load != Some(Load::PressureJump), "coupling.load", "pressure_jump", || {
            "in space it must be momentum".into()
        });
    }
}

/// Check the list of several wings.
fn check_wings(scene: &Scene, faults: &mut Faults) {
    let several = !scene.wings.is_empty();
    faults.forbid(several && scene.wing.is_some(), "wing", || {
        "the scene has `wings`; move it into `wings`, or remove one of the two".into()
    });
    faults.require(scene.wings.len() != 1, "wings", "a list of one", || {
        "several wings are at least two: a single wing is `wing` of the scene".into()
    });
    if let Some(name) = &scene.this_wing {
        let known = scene.wings.iter().any(|own| own.name == *name);
        if faults.forbid(!several, "this_wing", || "the scene has no `wings`".into()) {
            let names = list(scene.wings.iter().map(|own| &own.name), "and");
            faults.require(known, "this_wing", quoted(name), || format!("the names in `wings` are {names}"));
        }
    }
    scene.wings.check_at("wings", faults);
    let mut names: Vec<_> = scene.rods.iter().map(|own| own.name.as_str()).collect();
    for (i, own) in scene.wings.iter().enumerate() {
        let twice = names.iter().any(|other| other.eq_ignore_ascii_case(&own.name));
        faults.require(!twice, &format!("wings[{i}].name"), quoted(&own.name), || {
            "another wing or rod has this name; capital and small letters count as the same".into()
        });
        names.push(own.name.as_str());
    }
    let (key, rods) = (if several { "wings" } else { "wing" }, scene.beams().next().is_some());
    let beside = rods && (several || scene.wing.is_some());
    let alone = scene.fluid.is_none() && scene.flyer.is_none() && !scene.is_coupled_by_contact();
    faults.forbid(alone && (several || beside), key, || {
        let what = if beside { "wings beside rods" } else { "several wings" };
        format!("{what} need a fluid, a flyer or a `contact` that couples them")
    });
    let is_rigid = scene.beam.is_some() && scene.rod.is_none();
    faults.forbid(beside && is_rigid, "beam", || {
        "beside a wing a beam needs a `rod`; a rigid one is a body of `fluid.bodies`".into()
    });
}

/// Check a beam against its rod and the rest of the scene.
fn check_beam(scene: &Scene, own: &BeamWithRod, faults: &mut Faults) {
    let key = own.key();
    let dimension = scene.dimension(own.beam);
    if let Root::OnCylinder { cylinder, .. } = own.beam.root {
        let count = scene.fluid.as_ref().map_or(0, |fluid| fluid.cylinders.len());
        faults.require(cylinder < count, &format!("{key}beam.root.on_cylinder.cylinder"), cylinder, || match count {
            0 => "the scene has no cylinder".into(),
            count => format!("the largest index is {}, counted from 0", count - 1),
        });
        check_moving_cylinder(scene, own, cylinder, faults);
    }
    let is_space = scene.fluid.as_ref().is_some_and(|fluid| fluid.is_space());
    let needed = if is_space { 3 } else { 2 };
    let fits = scene.fluid.is_none() || dimension == needed;
    let first = scene.beams().next().map(|beam| scene.dimension(beam));
    let all = if scene.wings().next().is_some() { 3 } else { first.unwrap_or(dimension) };
    let is_like = !scene.is_coupled_by_contact() || dimension == all;
    faults.require(is_like, &format!("{key}beam.root"), format!("{dimension} components"), || {
        format!("what touches has as many dimensions: position and direction need {all} components")
    });
    let (own_name, other) = if is_space { ("two", "three") } else { ("three", "two") };
    faults.require(fits, &format!("{key}beam.root"), format!("{own_name}-dimensional"), || {
        format!("the fluid is {other}-dimensional: position and direction need {needed} components")
    });
    let fits = !is_space || own.beam.surface == Surface::Line;
    faults.require(fits, &format!("{key}beam.surface"), "mask", || "in space a beam is a line".into());
    let Some(rod) = own.rod else { return };
    let fits = rod.gravity.is_empty() || rod.gravity.len() == dimension;
    faults.require(fits, &format!("{key}rod.gravity"), shown(&rod.gravity), || {
        format!("it must have {dimension} components like the root of the beam")
    });
    let tapered = own.beam.thickness.varies() || rod.material.varies();
    let fits = !tapered || rod.calibration == Calibration::SecondOrder;
    faults.require(fits, &format!("{key}rod.calibration"), "thesis", || {
        "a rod that varies along its span needs second_order".into()
    });
    if let (2, Some(laws)) = (dimension, rod.laws()) {
        check_planar_motion(laws, &format!("{key}rod.root_motion.laws"), faults);
    }
    let (length, longest) = (rod.clamp_compliance_length, own.beam.length);
    faults.require(length <= longest, &format!("{key}rod.clamp_compliance_length"), length, || {
        format!("it must be at most the length of the beam, {longest}")
    });
    check_support(rod, own.beam, dimension, &format!("{key}rod"), faults);
    check_slide(rod, own.beam, dimension, &format!("{key}rod"), faults);
}

/// Check that a cylinder that moves leaves no root behind.
fn check_moving_cylinder(scene: &Scene, own: &BeamWithRod, cylinder: usize, faults: &mut Faults) {
    let motion = scene.fluid.as_ref().and_then(|fluid| fluid.cylinders.get(cylinder)?.motion.as_ref());
    let moves = motion.is_some_and(|motion| [&motion.x, &motion.y].into_iter().any(|law| law.largest() > 0.0));
    let stays = own.rod.is_none_or(|rod| rod.root_motion.is_none());
    let key = own.key();
    faults.forbid(moves && stays, &format!("{key}beam.root.on_cylinder"), || {
        let help = match own.rod {
            Some(_) => format!("give `{key}rod.root_motion.laws` the same `x` and `y`"),
            None => "a rigid beam stays; make both bodies of `fluid.bodies` with one motion".into(),
        };
        format!("`fluid.cylinders[{cylinder}].motion` would leave the root behind: {help}")
    });
}

/// Check the guide of a root; `key` is the path of the rod.
fn check_slide(rod: &Rod, beam: &Beam, dimension: usize, key: &str, faults: &mut Faults) {
    let Some(Slide { along, .. }) = rod.slide else { return };
    let at = |name: &str| format!("{key}.{name}");
    let no_z = dimension == 2 && along == Axis::Z;
    faults.forbid(no_z, &at("slide.along"), || "a beam in two dimensions has no z".into());
    let free = matches!(rod.root, RootSupport::Free { .. });
    faults.forbid(free, &at("slide"), || "a free root has no guide".into());
    let on_cylinder = matches!(beam.root, Root::OnCylinder { .. });
    faults.forbid(on_cylinder, &at("slide"), || "the beam is attached to a cylinder".into());
    if let Some(laws) = rod.laws() {
        let (law, name) = (laws.along()[along as usize], AXES[along as usize]);
        faults.forbid(*law != TimeLaw::default(), &at(&format!("root_motion.laws.{name}")), || {
            format!("the root moves freely along {name}: `{key}.slide`")
        });
    }
    for (name, plain) in
        [("bending", rod.bending == Bending::Invariant), ("calibration", rod.calibration == Calibration::SecondOrder)]
    {
        faults.forbid(!plain, &at("slide"), || format!("a slide needs the default of `{key}.{name}`"));
    }
}

fn check_planar_motion(laws: &RootLaws, key: &str, faults: &mut Faults) {
    faults.forbid(laws.z != TimeLaw::default(), &format!("{key}.z"), || "a beam in two dimensions has no z".into());
    for (i, Rotation { axis, .. }) in laws.rotations.iter().enumerate() {
        faults.require(*axis == Z_AXIS, &format!("{key}.rotations[{i}].axis"), shown(axis), || {
            format!("a beam in two dimensions turns about {Z_AXIS:?}")
        });
    }
}

/// Check a support other than a clamp; `key` is the path of the rod.
fn check_support(rod: &Rod, beam: &Beam, dimension: usize, key: &str, faults: &mut Faults) {
    let at = |name: &str| format!("{key}.{name}");
    let (name, has_clamp) = match &rod.root {
        RootSupport::Clamped => return,
        RootSupport::Pinned => {
            let turns = rod.laws().is_some_and(|laws| !laws.rotations.is_empty());
            faults.forbid(turns, &at("root_motion.laws.rotations"), || "a pinned root has no direction".into());
            ("pinned", false)
        }
        RootSupport::TorsionSpring { damping, rest_angle, .. } => {
            for (name, value) in [("damping", damping), ("rest_angle", rest_angle)] {
                let fits = dimension == 2 || *value == 0.0;
                faults.require(fits, &at(&format!("root.torsion_spring.{name}")), value, || {
                    "in three dimensions it must be 0: the rod has no material frame".into()
                });
            }
            ("torsion_spring", true)
        }
        RootSupport::Free { force_z, .. } => {
            let has_z = dimension == 2 && *force_z != TimeLaw::default();
            faults.forbid(has_z, &at("root.free.force_z"), || "a beam in two dimensions has no z".into());
            let on_cylinder = matches!(beam.root, Root::OnCylinder { .. });
            faults.require(!on_cylinder, &at("root"), "free", || "the beam is attached to a cylinder".into());
            faults.forbid(rod.root_motion.is_some(), &at("root_motion"), || {
                format!("a free root has no prescribed motion; `{key}.root.free` holds the towing forces")
            });
            ("free", false)
        }
    };
    faults.require(rod.bending == Bending::Invariant, &at("bending"), "projected", || {
        format!("a root that is {name} needs invariant")
    });
    faults.require(rod.calibration == Calibration::SecondOrder, &at("calibration"), "thesis", || {
        format!("a root that is {name} needs second_order")
    });
    let length = rod.clamp_compliance_length;
    faults.require(has_clamp || length == 0.0, &at("clamp_compliance_length"), length, || {
        format!("a root that is {name} has no clamp: it must be 0")
    });
}

/// Check that no unit needs more steps in a communication step than a run could ever finish.
fn check_substeps(scene: &Scene, faults: &mut Faults) {
    let step = scene.time.communication_step;
    let reachable = |faults: &mut Faults, key: &str, longest: f64| {
        faults.require(step / longest <= MOST_SUBSTEPS, key, shown(&longest), || {
            let least = step / MOST_SUBSTEPS;
            format!("a communication step of {step} s has at most {MOST_SUBSTEPS} steps: it must be >= {least:.3e}")
        });
    };
    for own in scene.beams_with_rods() {
        if let Some(longest) = own.rod.and_then(|rod| rod.max_step) {
            reachable(faults, &format!("{}rod.max_step", own.key()), longest);
        }
    }
    for (key, longest) in scene.wings().filter_map(|own| Some((own.key, own.wing.max_step?))) {
        reachable(faults, &format!("{key}.max_step"), longest);
    }
    let Some(fluid) = &scene.fluid else { return };
    let TimeStepping { max_step, max_cfl, scheme } = fluid.time_stepping;
    reachable(faults, "fluid.time_stepping.max_step", max_step);
    let cfl = fluid.advection_rate() * step;
    let (fits, largest) = (cfl / max_cfl <= MOST_SUBSTEPS, scheme.largest_cfl());
    if 1.001 * cfl / MOST_SUBSTEPS > largest {
        let longest = 0.999 * step / cfl * MOST_SUBSTEPS * largest;
        faults.require(fits, "time.communication_step", shown(&step), || {
            format!(
                "the flow has the CFL number {cfl:.3e} in it, more than {MOST_SUBSTEPS} steps of {largest}, the \
                 largest of the scheme: it must be <= {longest:.3e}"
            )
        });
        return;
    }
    faults.require(fits, "fluid.time_stepping.max_cfl", shown(&max_cfl), || {
        let least = 1.001 * cfl / MOST_SUBSTEPS; // still enough after rounding to three digits
        format!(
            "the flow has the CFL number {cfl:.3e} in a communication step, which has at most {MOST_SUBSTEPS} steps: \
             it must be >= {least:.3e}"
        )
    });
}

/// Check that the words for a length and a time of 1 are no other units, in which the numbers would be read.
fn check_display(scene: &Scene, faults: &mut Faults) {
    let Some(Display { length, time }) = &scene.display else { return };
    for (key, word, si, units) in [
        ("display.length", length, "1 m", ["nm", "um", "µm", "mm", "cm", "dm", "km"].as_slice()),
        ("display.time", time, "1 s", &["ns", "us", "µs", "ms", "min", "h"]),
    ] {
        faults.require(!units.contains(&word.as_str()), key, format!("\"{word}\""), || {
            format!(
                "it is the word for {si} in a scene of other scales, such as a chord; leave out `display` for SI units"
            )
        });
    }
}

/// Check that published values are of quantities that a run evaluates, in their units.
fn check_reference(scene: &Scene, faults: &mut Faults) {
    let Some(reference) = &scene.reference else { return };
    let published = reference.quantities.iter().map(|(name, own)| ("quantities", name, &own.unit));
    let ranges = reference.spread.iter().flat_map(|spread| &spread.quantities);
    for (key, name, unit) in published.chain(ranges.map(|(name, own)| ("spread.quantities", name, &own.unit))) {
        let key = format!("reference.{key}.{name}");
        let known: &[&str] = match name.as_str() {
            // Of several rods the name stands in front.
            tip if ["tip_ux", "tip_uy", "tip_uz"].iter().any(|end| tip.ends_with(end)) => &["m"],
            "drag" | "lift" => &["N/m", "N"],
            body if body.starts_with("body_") => continue,
            _ => {
                faults
                    .push(Fault::superfluous(&key, "a run evaluates `tip_ux`, `tip_uy`, `tip_uz`, `drag` and `lift`"));
                continue;
            }
        };
        faults.require(known.contains(&unit.as_str()), &format!("{key}.unit"), quoted(unit), || {
            format!("a run evaluates {name} in {}: convert the values", known[0])
        });
    }
}

/// Check that lines suit the scheme and the load.
fn check_lines(scene: &Scene, faults: &mut Faults) {
    let explicit = scene.fluid.as_ref().is_some_and(|fluid| fluid.time_stepping.scheme == TimeScheme::Rk2);
    for own in scene.beams_with_rods() {
        let (line, key) = (own.beam.surface == Surface::Line, own.key());
        for (fits, needed) in [
            (!explicit, "a line needs the scheme sbdf2"),
            (!scene.axial_pressure_strain(), "`coupling.axial_pressure_strain` needs a mask: a line has no thickness"),
        ] {
            faults.require(!line || fits, &format!("{key}beam.surface"), "line", || needed.into());
        }
    }
}

/// Check that load and scheme suit the rods and each other.
fn check_coupling(scene: &Scene, faults: &mut Faults) {
    let Some((load, _)) = scene.chosen_load() else { return };
    if let (Load::Momentum, Some(Weight { name, own, displaced, free, line: false })) = (load, scene.lightest()) {
        let ratio = own / displaced;
        faults.require(own >= displaced, "coupling.load", "momentum", || {
            format!(
                "the rod{name} weighs {ratio:.4} of the fluid it displaces, less than 1; remove the key or use \
                 pressure_jump"
            )
        });
        faults.require(own != displaced || !free, "coupling.load", "momentum", || {
            format!(
                "the free rod{name} weighs {ratio:.4} of the fluid it displaces, which leaves it no mass; remove the \
                 key or use pressure_jump"
            )
        });
    }
    if scene.axial_pressure_strain() {
        let mut rods = scene.beams_with_rods().filter_map(|own| own.rod);
        let plane_strain = rods.all(|rod| matches!(rod.material, Material::PlaneStrain { .. }));
        let inflow = scene.fluid.as_ref().is_some_and(|fluid| fluid.inflow.is_some());
        for (there, needed) in [
            (load == Load::Momentum, "the load momentum"),
            (plane_strain, "a material in plane_strain, which has a Poisson's ratio"),
            (inflow, "an inflow, at whose outlet the pressure is 0"),
        ] {
            faults.require(there, "coupling.axial_pressure_strain", true, || format!("it needs {needed}"));
        }
    }
    let scheme = scene.coupling.as_ref().and_then(|coupling| coupling.scheme);
    let iterated = matches!(scheme, Some(CouplingScheme::Iterated { .. }));
    faults.require(!iterated || load == Load::PressureJump, "coupling.scheme", "iterated", || {
        "the load momentum needs an explicit scheme: with its impedance it is already implicit".into()
    });
}

fn quoted(text: &str) -> String {
    shown(&text)
}

fn shown(value: &impl Debug) -> String {
    format!("{value:?}")
}
