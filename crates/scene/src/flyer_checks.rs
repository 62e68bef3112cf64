//! Where a flyer has what it carries, and what is wrong with it.

use geometry::vector::{minus, norm};

use crate::body::BodyDrive;
use crate::fault::{Check, Fault, Faults, list};
use crate::flyer::{Flyer, FlyerHinge};
use crate::mount::{OF_A_BODY, is_positive};
use crate::root::RootSupport;
use crate::scene::Scene;

impl Scene {
    /// Return the hinge that carries a unit.
    pub fn hinge_of(&self, unit: &str) -> Option<&FlyerHinge> {
        self.flyer.as_ref()?.hinges.iter().find(|hinge| hinge.carries == unit)
    }

    /// Return the numbers of the beams, then the wings, that the flyer carries.
    pub fn carried_by_flyer(&self) -> Vec<usize> {
        let rods = self.beams_with_rods().map(|own| own.name.unwrap_or("rod"));
        let names = rods.chain(self.wings().map(|own| own.name)).enumerate();
        names.filter(|(_, name)| self.hinge_of(name).is_some()).map(|(k, _)| k).collect()
    }

    /// Return the mass of the fluid that the body `k` of the fluid displaces, kg, its moments of inertia about the pivot,
    /// kg m², as a matrix, and its centroid from the pivot, m, in the axes of the box at the start.
    pub fn displaced_by_body(&self, k: usize) -> Option<(f64, [[f64; 3]; 3], [f64; 3])> {
        let fluid = self.fluid.as_ref()?;
        let (body, ends) = (fluid.bodies.get(k)?, fluid.r#box.ends().collect::<Vec<_>>());
        let (mass, about) = body.displaced_by(fluid.density, &ends);
        let (axes, pivot) = (body.axes_at_rest(), |e: usize| body.pivot.get(e).copied().unwrap_or(0.0));
        let own = |e: usize, f: usize| if e == f { about[e] } else { -mass * pivot(e) * pivot(f) };
        let turned =
            |i: usize, j: usize| -> f64 { (0..9).map(|n| own(n / 3, n % 3) * axes[n / 3][i] * axes[n % 3][j]).sum() };
        let arm = std::array::from_fn(|i| -(0..3).map(|e| pivot(e) * axes[e][i]).sum::<f64>());
        Some((mass, std::array::from_fn(|i| std::array::from_fn(|j| turned(i, j))), arm))
    }

    /// Return the place of a hinge at the start, m.
    pub fn place_of(&self, hinge: &FlyerHinge) -> [f64; 3] {
        let origin = self.flyer.as_ref().map_or([0.0; 3], |flyer| flyer.position);
        std::array::from_fn(|d| origin[d] + hinge.position[d])
    }
}

/// Check the body of a scene with a flyer against its other parts.
pub(crate) fn check(scene: &Scene, flyer: &Flyer, faults: &mut Faults) {
    if let Some(fluid) = &scene.fluid {
        faults.forbid(!fluid.is_space(), "flyer", || "the fluid has two dimensions: it needs `fluid.box.z`".into());
    }
    let (inertia, products) = (flyer.inertia, flyer.products_of_inertia);
    let ([x, y, z], [yz, zx, xy], of_all) = (inertia.about(), products, "flyer.products_of_inertia");
    let own_positive = [x, y, z].iter().all(|about| *about > 0.0) && (x * y * z).is_normal();
    let is_positive = is_positive([[x, xy, zx], [xy, y, yz], [zx, yz, z]]);
    let exists = inertia.is_of_a_body([0.0; 3]);
    faults.require(own_positive, "flyer.inertia", inertia, || {
        "each axis has a moment of inertia > 0, and their product is from 1e-300 to 1e300".into()
    });
    faults.require(!own_positive || exists, "flyer.inertia", inertia, || format!("each {OF_A_BODY}"));
    faults.require(!own_positive || is_positive, of_all, format!("{products:?}"), || {
        format!("with `flyer.inertia`, {inertia}, each axis, also an oblique one, has a moment of inertia > 0")
    });
    let is_possible = !(own_positive && exists && is_positive) || inertia.is_of_a_body(products);
    faults.require(is_possible, of_all, format!("{products:?}"), || {
        format!("with `flyer.inertia`, {inertia}, each principal {OF_A_BODY}")
    });
    if let Some(shape) = flyer.shape {
        let bodies = scene.fluid.as_ref().map_or(&[][..], |fluid| &fluid.bodies);
        let is_driven = |k: usize| bodies.get(k).is_some_and(|body| matches!(body.motion, Some(BodyDrive::Master(_))));
        faults.require(is_driven(shape), "flyer.shape", shape, || {
            "it is the number, from 0, of a body of `fluid.bodies` with `\"motion\": \"master\"`".into()
        });
        if let Some(body) = bodies.get(shape) {
            let fits = body.position[..] == flyer.position;
            let is_solid = scene
                .fluid
                .as_ref()
                .is_some_and(|fluid| body.shape.solid(&fluid.r#box.ends().collect::<Vec<_>>()).is_some());
            faults.require(is_solid, "flyer.shape", shape, || {
                "its shape is a surface, and the body needs a sphere, an ellipsoid, a cuboid, a circular_cylinder or a \
                 capsule"
                    .into()
            });
            faults.require(fits, "flyer.position", format!("{:?}", flyer.position), || {
                format!("the pivot of its shape, `fluid.bodies[{shape}].position`, is {:?}", body.position)
            });
        }
    }
    if let Some(solid) = &flyer.solid {
        let key = "flyer.solid";
        solid.check_at(key, faults);
        solid.check_dimension(key, true, faults);
        faults.forbid(flyer.shape.is_some(), key, || "the body has its shape in the fluid, `flyer.shape`".into());
        let free = solid.mount.is_some() || solid.motion.is_some() || solid.reference.is_some();
        faults.forbid(free, key, || "the flyer moves it, without `motion`, `mount` and `reference`".into());
        faults.forbid(scene.contact.is_none(), key, || "it is for the key `contact`, which the scene lacks".into());
        let place = format!("{:?}", solid.position);
        faults.require(solid.position[..] == flyer.position, &format!("{key}.position"), place, || {
            format!("the flyer is at {:?}", flyer.position)
        });
    }
    let mut units: Vec<String> = scene.wings().map(|own| own.name.to_string()).collect();
    units.extend(scene.beams_with_rods().map(|own| own.name.unwrap_or("rod").to_string()));
    for (i, hinge) in flyer.hinges.iter().enumerate() {
        let key = format!("flyer.hinges[{i}]");
        hinge.check_at(&key, faults);
        let (key, shown) = (format!("{key}.carries"), format!("{:?}", hinge.carries));
        faults.require(units.contains(&hinge.carries), &key, &shown, || match units.is_empty() {
            true => "the scene has no wing and no rod".into(),
            false => format!("the units of the scene are {}", list(&units, "and")),
        });
        let twice = flyer.hinges[..i].iter().any(|other| other.carries == hinge.carries);
        faults.require(!twice, &key, &shown, || "another hinge carries it".into());
    }
    let carried = |name: &str| scene.hinge_of(name).is_some();
    for own in scene.wings().filter(|own| carried(own.name)) {
        let (wing, key) = (own.wing, &own.key);
        if wing.root.is_none() {
            faults.push(Fault::needed(&format!("{key}.root"), "a hinge carries the wing at its root"));
        }
        let moved = wing.root_motion.is_some();
        faults.forbid(moved, &format!("{key}.root_motion"), || "a hinge of the flyer moves the root".into());
        check_scheme(key, wing.scheme, wing.max_step, faults);
    }
    for own in scene.beams_with_rods().filter(|own| carried(own.name.unwrap_or("rod"))) {
        let Some(rod) = own.rod else { continue };
        let key = format!("{}rod", own.key());
        let moved = rod.root_motion.is_some();
        faults.forbid(moved, &format!("{key}.root_motion"), || "a hinge of the flyer moves the root".into());
        let is_clamped = matches!(rod.root, RootSupport::Clamped);
        faults.require(is_clamped && rod.slide.is_none(), &format!("{key}.root"), "another support", || {
            "a hinge carries a rod that is clamped to it".into()
        });
        let flat = scene.dimension(own.beam) == 2;
        faults.forbid(flat, &format!("{}beam.root", own.key()), || {
            "a flyer has three dimensions: position and direction need three components".into()
        });
        let hinge = scene.hinge_of(own.name.unwrap_or("rod")).expect("it is carried");
        let (place, root) = (scene.place_of(hinge), scene.beam_root(own.beam).0);
        let off = norm(minus(place, root));
        faults.require(off <= 1e-9 * own.beam.length, &format!("{}beam.root", own.key()), format!("{root:?}"), || {
            format!("its hinge is at {place:?}")
        });
        let index = scene.flyer.iter().flat_map(|flyer| &flyer.hinges).position(|other| other == hinge).unwrap_or(0);
        faults.forbid(hinge.turn.is_some(), &format!("flyer.hinges[{index}].turn"), || {
            "a rod has the axes of the body; its beam has a direction".into()
        });
        check_scheme(&key, rod.scheme, rod.max_step, faults);
    }
}

/// Check that a part steps as the body that carries it, once in a communication step.
fn check_scheme(key: &str, scheme: method::Scheme, max_step: Option<f64>, faults: &mut Faults) {
    let differences = scheme == method::Scheme::Bdf2;
    let shown = serde_json::to_string(&scheme).unwrap_or_default();
    faults.require(differences, &format!("{key}.scheme"), shown, || {
        "what a flyer carries steps as its body: it must be bdf2".into()
    });
    faults.forbid(max_step.is_some(), &format!("{key}.max_step"), || {
        "what a flyer carries steps as its body, once in a communication step".into()
    });
}
